//! Checks the limits of a task against the outcomes of its plan.
//!
//! Input: a job, its plan, and what the planner of its kind knows of each limit that the plan misses. Output: whether
//! all limits are kept; each missed one is reported. Promise: "no plan" is only reported where the kind has a proof,
//! and a help names only a plan or a limit that works.

use super::Plan;
use super::errors::{self, LimitTexts, LimitVerdict};
use crate::claims::{Job, Relation, Requirement};
use crate::diagnostic::Sink;
use crate::quantity::{Dimension, Quantity, Unit};
use std::collections::BTreeMap;

type Outcomes = BTreeMap<String, f64>;

/// Whether an outcome meets its requirement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kept {
    Yes,
    No,
}

/// A kind's knowledge of an upper limit, or an upper side of `==`, that its plan misses. The default knows nothing: the
/// report then says that no plan was found.
#[derive(Debug, Default)]
pub struct KnownLimit {
    /// Proven: no plan keeps all limits of the job at once.
    pub none_keeps_all: bool,
    /// Proven lower bound, in SI units, on this outcome for plans that keep the other limits. A bound that ignores the
    /// other limits is valid too.
    pub least: Option<f64>,
    /// Another plan of the same job, such as one for another objective. It is named only where it keeps all the other
    /// limits.
    pub other: Option<Plan<()>>,
    /// Advice on finding a plan where none was found and nothing is proven.
    pub advice: Option<String>,
}

/// Checks an outcome against a requirement.
pub fn keeps(requirement: &Requirement, reached: f64) -> Kept {
    if requirement.relation.holds(reached, requirement.limit, requirement.slack()) { Kept::Yes } else { Kept::No }
}

/// Whether a requirement is only an upper limit of its outcome.
pub fn is_upper(requirement: &Requirement) -> bool {
    match requirement.relation {
        Relation::Less | Relation::AtMost => true,
        Relation::Equal | Relation::AtLeast | Relation::More => false,
    }
}

/// Whether an outcome is more than a requirement allows.
fn is_missed_above(requirement: &Requirement, reached: f64) -> bool {
    match requirement.relation {
        Relation::Less | Relation::AtMost => true,
        Relation::Equal => reached > requirement.limit,
        Relation::AtLeast | Relation::More => false,
    }
}

/// Whether a plan meets all requirements of its job; missed ones are reported.
///
/// `known` is called for each upper limit, and each upper side of `==`, that is missed.
pub fn require<M>(
    job: &Job,
    plan: &Plan<M>,
    known: &mut dyn FnMut(&Requirement) -> KnownLimit,
    sink: &mut Sink,
) -> Kept {
    let mut all_kept = Kept::Yes;
    let (mut proven, mut open) = (Vec::new(), Vec::new());
    for (index, requirement) in job.requirements.iter().enumerate() {
        let Some(&reached) = plan.outcomes.get(&requirement.outcome) else { continue };
        if keeps(requirement, reached) == Kept::Yes {
            continue;
        }
        all_kept = Kept::No;
        let known = if is_missed_above(requirement, reached) { known(requirement) } else { KnownLimit::default() };
        let verdict = verdict(job, index, plan, &known);
        let dimension = dimension(job, requirement);
        let limit = requirement.limit;
        let texts = |value: Option<f64>| {
            let reached = show(reached, dimension);
            let value = value.map(|value| match requirement.relation {
                // A rounded figure would be a different limit.
                Relation::Equal => {
                    (in_full(value, dimension), in_full(value, dimension), no_more(value, limit, dimension))
                }
                Relation::Less | Relation::AtMost | Relation::AtLeast | Relation::More => {
                    (exact(value, dimension), enough(value, dimension), no_more(value, limit, dimension))
                }
            });
            let beside = value.iter().flat_map(|(value, enough, floor)| [value, enough, floor]).chain([&reached]);
            let limit = limit_text(limit, beside, dimension);
            let (value, enough, floor) = value.unwrap_or_default();
            LimitTexts { reached, limit, value, enough, floor }
        };
        let missed = errors::requirement_missed(requirement, verdict, job.requirements.len(), &texts);
        let missed = match verdict.is_proven() {
            true => {
                let unproven = LimitVerdict::NotFound;
                missed.with_weaker_form(errors::requirement_missed(
                    requirement,
                    unproven,
                    job.requirements.len(),
                    &texts,
                ))
            }
            false => missed,
        };
        let advice = known.advice.or_else(|| longer(job, index, reached)).filter(|_| verdict == LimitVerdict::NotFound);
        let missed = missed.help_if(advice);
        if verdict.is_proven() { proven.push(missed) } else { open.push(missed) }
    }
    // If one limit is proven out of reach, no plan keeps all of them: limits without a proof are not reported.
    let reported = if proven.is_empty() { open } else { proven };
    reported.into_iter().for_each(|missed| sink.push(missed));
    all_kept
}

/// Advises a wait that makes a run long enough for a lower limit on its time, if no other limit on the time forbids
/// that.
fn longer(job: &Job, index: usize, reached: f64) -> Option<String> {
    let requirement = &job.requirements[index];
    // The wait is rounded up: it may miss an exact limit, and end exactly on a strict one.
    let is_from_below = match requirement.relation {
        Relation::AtLeast => true,
        Relation::Less | Relation::AtMost | Relation::Equal | Relation::More => false,
    };
    let missing_s = requirement.limit - reached;
    let mut of_time = job.requirements.iter().filter(|other| other.outcome == requirement.outcome);
    let is_alone = of_time.all(|other| keeps(other, requirement.limit) == Kept::Yes);
    (is_from_below && requirement.outcome == "time" && missing_s > 0.0 && is_alone)
        .then(|| format!("a last step `wait {}` keeps it", enough(missing_s, Dimension::TIME)))
}

/// The strongest statement about a missed limit that is known to be true.
fn verdict<M>(job: &Job, index: usize, plan: &Plan<M>, known: &KnownLimit) -> LimitVerdict {
    let requirement = &job.requirements[index];
    let candidates =
        [Some((plan.objective, &plan.outcomes)), known.other.as_ref().map(|plan| (plan.objective, &plan.outcomes))];
    let best =
        candidates.into_iter().flatten().filter(|plan| keeps_the_others(job, index, plan.1)).min_by(|one, other| {
            let value = |outcomes: &Outcomes| outcomes.get(&requirement.outcome).copied().unwrap_or(f64::INFINITY);
            value(one.1).total_cmp(&value(other.1))
        });
    let best = best.and_then(|(objective, outcomes)| Some((objective, *outcomes.get(&requirement.outcome)?)));
    let is_beyond = |least: &f64| *least >= requirement.limit && keeps(requirement, *least) == Kept::No;
    let least = known.least.filter(is_beyond);
    match (least, best) {
        (_, Some((objective, value))) if keeps(requirement, value) == Kept::Yes && objective != plan.objective => {
            LimitVerdict::Elsewhere(objective, value)
        }
        (Some(least), Some((_, value))) if value <= least * (1.0 + requirement.tolerance()) => {
            LimitVerdict::Least(value)
        }
        (Some(least), best) => LimitVerdict::AtLeast(least, best.map(|(_, value)| value)),
        (None, _) if known.none_keeps_all => LimitVerdict::Conflict,
        (None, _) => LimitVerdict::NotFound,
    }
}

/// Whether outcomes keep all requirements of a job except one.
fn keeps_the_others(job: &Job, but: usize, outcomes: &Outcomes) -> bool {
    let mut others = job.requirements.iter().enumerate().filter(|(index, _)| *index != but);
    others.all(|(_, other)| outcomes.get(&other.outcome).is_none_or(|value| keeps(other, *value) == Kept::Yes))
}

fn dimension(job: &Job, requirement: &Requirement) -> Dimension {
    let outcomes = job.kind().vocabulary().outcomes;
    let known = outcomes.iter().find(|known| known.name == requirement.outcome);
    known.map_or(Dimension::NUMBER, |known| known.unit.dimension())
}

/// Formats an outcome in few digits, or in all of them if it is a count or a time that few would change.
pub fn show(value: f64, dimension: Dimension) -> String {
    let short = Quantity::new(value, dimension).to_string();
    let is_exact = read_back(&short).is_some_and(|read| is_same(read, value));
    if is_counted(dimension) && !is_exact { in_full(value, dimension) } else { short }
}

/// Whether figures of a dimension are counts, or times in whole nanoseconds.
fn is_counted(dimension: Dimension) -> bool {
    dimension == Dimension::NUMBER || dimension == Dimension::TIME
}

fn is_same(read: f64, value: f64) -> bool {
    (read - value).abs() <= value.abs() * SAME
}

/// Relative difference up to which a number equals the one read back from its digits.
const SAME: f64 = 4.0 * f64::EPSILON;

/// Formats all digits of a value that arithmetic leaves right, in the unit of the short form.
fn in_full(value: f64, dimension: Dimension) -> String {
    let quantity = Quantity::new(value, dimension);
    let digits = |number: f64| format!("{number:.14e}").parse().unwrap_or(number).to_string();
    match quantity.to_string().split_once(' ') {
        Some((_, unit)) => format!("{} {unit}", digits(quantity.in_unit(unit))),
        None => digits(value),
    }
}

/// Formats a limit; with all its digits if rounding would make it look like one of the figures beside it.
fn limit_text<'t>(limit: f64, beside: impl IntoIterator<Item = &'t String>, dimension: Dimension) -> String {
    let text = show(limit, dimension);
    let is_exact = read_back(&text).is_some_and(|read| is_same(read, limit));
    if !is_exact && beside.into_iter().any(|figure| *figure == text) { in_full(limit, dimension) } else { text }
}

/// Formats a count or a time as it is, another figure rounded up.
fn exact(value: f64, dimension: Dimension) -> String {
    if is_counted(dimension) { show(value, dimension) } else { enough(value, dimension) }
}

/// Formats a value in few digits, rounded up so that it keeps a limit with the printed value.
pub fn enough(value: f64, dimension: Dimension) -> String {
    let is_enough = |read: f64| value <= read || is_same(read, value);
    rounded(value, 1.0, dimension, is_enough).unwrap_or_else(|| in_full(value, dimension))
}

/// Formats a lower bound in few digits, rounded down; with all of them if few would no longer exceed an upper limit.
fn no_more(value: f64, limit: f64, dimension: Dimension) -> String {
    let is_bound = |read: f64| (read <= value || is_same(read, value)) && (read > limit || value <= limit);
    rounded(value, -1.0, dimension, is_bound).unwrap_or_else(|| in_full(value, dimension))
}

/// First of several short texts, each rounded a little farther to one side, whose value fits when it is read back.
fn rounded(value: f64, side: f64, dimension: Dimension, fits: impl Fn(f64) -> bool) -> Option<String> {
    let texts = [0.0, 1e-6, 2e-6, 5e-6, 1e-5]
        .map(|part| Quantity::new(value + side * value.abs() * part, dimension).to_string());
    texts.into_iter().find(|text| read_back(text).is_some_and(&fits))
}

/// The SI value of a quantity as it is printed.
fn read_back(text: &str) -> Option<f64> {
    let (number, unit) = text.split_once(' ').unwrap_or((text, ""));
    let unit = if unit.is_empty() { Unit::ONE } else { Unit::parse(unit).ok()? };
    unit.of(number).map(|quantity| quantity.si)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Span;

    const RELATIONS: [Relation; 5] =
        [Relation::Less, Relation::AtMost, Relation::Equal, Relation::AtLeast, Relation::More];

    fn kept(outcome: &str, limit: f64, reached: f64) -> [bool; 5] {
        RELATIONS.map(|relation| {
            let requirement = Requirement { outcome: outcome.into(), relation, limit, span: Span::default() };
            keeps(&requirement, reached) == Kept::Yes
        })
    }

    /// Equality is exact at 0, where rounding has no room.
    #[test]
    fn a_limit_takes_equality_where_its_sign_says_so() {
        for (limit, reached, expected) in [
            (0.0, 0.0, [false, true, true, true, false]),
            (0.0, 1e-30, [false, false, false, true, true]),
            (0.0, -1e-30, [true, true, false, false, false]),
            (3.0, 3.0, [false, true, true, true, false]),
            (3.0, 3.0 + 1e-12, [false, true, true, true, false]),
            (3.0, 3.0 - 1e-12, [false, true, true, true, false]),
            (3.0, 3.0 + 1e-6, [false, false, false, true, true]),
            (3.0, 3.0 - 1e-6, [true, true, false, false, false]),
        ] {
            assert_eq!(kept("distance", limit, reached), expected, "{reached} and {limit}");
        }
    }

    #[test]
    fn limits_on_times_and_counts_are_exact() {
        let [below, equal, above] =
            [[true, true, false, false, false], [false, true, true, true, false], [false, false, false, true, true]];
        for (outcome, limit, reached, expected) in [
            ("time", 10.030_000_005, 10.03, below),
            ("time", 60_000.029_999_999, 60_000.03, above),
            ("time", 60_000.03, 60_000.03, equal),
            // As `3 * 100 ms`, and as a product of times.
            ("time", 3.0 * 0.1, 0.3, equal),
            ("time", 0.015 * 7.0 + 0.1, 0.205, equal),
            ("switches", 2.000_000_001, 2.0, below),
            ("switches", 1.999_999_99, 2.0, above),
            ("steps", 0.1 * 30.0, 3.0, equal),
        ] {
            assert_eq!(kept(outcome, limit, reached), expected, "{outcome} {reached} and {limit}");
        }
    }

    #[test]
    fn times_and_counts_are_shown_as_they_are() {
        assert_eq!(show(60_000.03, Dimension::TIME), "60000.03 s");
        assert_eq!(show(1_298_479.0, Dimension::NUMBER), "1298479");
        assert_eq!(show(0.4, Dimension::TIME), "400 ms");
        assert_eq!(show(0.199_999_99, Dimension::TIME), "199.99999 ms");
        assert_eq!(show(0.029_999_999_9, Dimension::TIME), "29.9999999 ms");
    }

    #[test]
    fn a_bound_excludes_the_limit_that_it_is_shown_for() {
        assert_eq!(no_more(14.991_35, 10.0, Dimension::TIME), "14.9913 s");
        assert_eq!(no_more(60_000.03, 60_000.02, Dimension::TIME), "60000.03 s");
        assert_eq!(enough(33.038_058_551, Dimension::TIME), "33.0381 s");
        let beside = ["26.4688 um".to_owned()];
        assert_eq!(limit_text(26.468_8e-6, &beside, Dimension::LENGTH), "26.4688 um");
        assert_eq!(limit_text(26.468_801e-6, &beside, Dimension::LENGTH), "26.468801 um");
    }

    #[test]
    fn a_limit_that_is_advised_is_kept() {
        for value in [26.46885e-6, 26.468849e-6, 45e-3, 1.0, 99.99999e-6, 0.999_999_51, 3.0e-12 / 7.0] {
            for dimension in [Dimension::LENGTH, Dimension::TIME, Dimension::NUMBER] {
                let text = enough(value, dimension);
                let read = read_back(&text).unwrap();
                assert!(value <= read * (1.0 + SAME) && read <= value * 1.000_02, "{value} {text}");
                let text = no_more(value, 0.0, dimension);
                let read = read_back(&text).unwrap();
                assert!(read <= value * (1.0 + SAME) && value <= read * 1.000_02, "{value} {text}");
            }
        }
    }
}
