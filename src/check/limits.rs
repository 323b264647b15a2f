//! Limits of one figure that exclude each other: no plan is searched for then.

use super::errors;
use crate::claims::{Relation, Requirement};
use crate::diagnostic::Sink;

/// Whether a figure can keep all limits that a task sets to it; those that exclude each other are reported, the later at the earlier one.
pub fn can_be_kept(requirements: &[Requirement], sink: &mut Sink) -> bool {
    let excluded = requirements.iter().enumerate().find_map(|(nth, later)| {
        let earlier = requirements[..nth].iter().find(|earlier| exclude(earlier, later) || exclude(later, earlier));
        earlier.map(|earlier| (earlier, later))
    });
    if let Some((earlier, later)) = excluded {
        sink.push(errors::limits_exclude(&later.outcome, earlier.span, later.span));
    }
    excluded.is_none()
}

/// Whether one limit is from below and above another one of the same figure, which is from above.
fn exclude(lower: &Requirement, upper: &Requirement) -> bool {
    let is_lower = match lower.relation {
        Relation::AtLeast | Relation::More | Relation::Equal => true,
        Relation::Less | Relation::AtMost => false,
    };
    let is_upper = match upper.relation {
        Relation::AtMost | Relation::Less | Relation::Equal => true,
        Relation::AtLeast | Relation::More => false,
    };
    let is_strict = lower.relation == Relation::More || upper.relation == Relation::Less;
    lower.outcome == upper.outcome
        && is_lower
        && is_upper
        && (lower.limit > upper.limit || (is_strict && lower.limit == upper.limit))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Span;

    #[test]
    fn limits_exclude_each_other_where_nothing_is_between_them() {
        use Relation::{AtLeast, AtMost, Equal, Less, More};
        let of = |outcome: &str, relation, limit| Requirement {
            outcome: outcome.to_owned(),
            relation,
            limit,
            span: Span::default(),
        };
        let can = |limits: &[(Relation, f64)]| {
            let all: Vec<Requirement> = limits.iter().map(|(relation, limit)| of("time", *relation, *limit)).collect();
            let mut sink = Sink::default();
            let can = can_be_kept(&all, &mut sink);
            assert_eq!(can, sink.errors() == 0);
            can
        };
        for kept in [
            [(AtMost, 2.0), (AtLeast, 1.0)],
            [(AtMost, 1.0), (AtLeast, 1.0)],
            [(AtMost, 1.0), (Less, 0.5)],
            [(Equal, 1.0), (AtMost, 1.0)],
            [(More, 1.0), (Less, 1.5)],
        ] {
            assert!(can(&kept), "{kept:?}");
        }
        for lost in [
            [(AtMost, 1.0), (AtLeast, 2.0)],
            [(AtLeast, 2.0), (AtMost, 1.0)],
            [(Less, 1.0), (AtLeast, 1.0)],
            [(Equal, 1.0), (Equal, 2.0)],
            [(More, 1.0), (Equal, 1.0)],
        ] {
            assert!(!can(&lost), "{lost:?}");
        }
        let other = [of("time", AtMost, 1.0), of("distance", AtLeast, 2.0)];
        assert!(can_be_kept(&other, &mut Sink::default()));
    }
}
