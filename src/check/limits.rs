//! Limits of one outcome that exclude each other, so that no plan is searched for.

use super::errors;
use crate::claims::{Relation, Requirement};
use crate::diagnostic::Sink;

/// Whether no two limits that a task sets on one outcome exclude each other; the first pair that does is reported.
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

/// Whether a lower and an upper limit of the same outcome leave no value that keeps both, given the slack with which
/// limits are held.
fn exclude(lower: &Requirement, upper: &Requirement) -> bool {
    let least = match lower.relation {
        Relation::AtLeast | Relation::Equal => lower.limit - lower.slack(),
        Relation::More => lower.limit + lower.slack(),
        Relation::Less | Relation::AtMost => return false,
    };
    let most = match upper.relation {
        Relation::AtMost | Relation::Equal => upper.limit + upper.slack(),
        Relation::Less => upper.limit - upper.slack(),
        Relation::AtLeast | Relation::More => return false,
    };
    let is_strict = lower.relation == Relation::More || upper.relation == Relation::Less;
    lower.outcome == upper.outcome && (least > most || (is_strict && least == most))
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
            // Within the slack: 1100 ms is not exactly 1.1 s.
            [(AtLeast, 1.1), (AtMost, 1.1 - 1e-15)],
            [(Equal, 1.1), (Equal, 1.1 + 1e-15)],
        ] {
            assert!(can(&kept), "{kept:?}");
        }
        for lost in [
            [(AtMost, 1.0), (AtLeast, 2.0)],
            [(AtLeast, 2.0), (AtMost, 1.0)],
            [(Less, 1.0), (AtLeast, 1.0)],
            [(Equal, 1.0), (Equal, 2.0)],
            [(More, 1.0), (Equal, 1.0)],
            [(More, 0.0), (AtMost, 0.0)],
        ] {
            assert!(!can(&lost), "{lost:?}");
        }
        let other = [of("time", AtMost, 1.0), of("distance", AtLeast, 2.0)];
        assert!(can_be_kept(&other, &mut Sink::default()));
    }
}
