//! Third round: the plan's own record, and the task's requirements on the outcome.
//!
//! Input: a run and its replay. Figures agree if they differ by no more than [`TOLERANCE`], since the planner may sum
//! in another order. Counts and times then agree exactly, because they are far from that limit.

use super::clock::JudgedRun;
use super::rule::{Findings, Rule, Violation, ms};
use super::{JudgedOperation, RecordTerms, Replay, ReplayedState, judge_of, judged_state};
use crate::claims::{Relation, Requirement};
use crate::device::{Outcome, OutcomeUnit};
use crate::quantity::{Dimension, Quantity, digits};
use crate::schedule::reached::reached;
use crate::schedule::{Reached, ScheduledOperation, TimedState};

/// Relative difference up to which two figures agree, as a fraction of the larger one.
pub(super) const TOLERANCE: f64 = 1e-9;

/// Relative rounding error of a whole number that was computed in fractions.
const WHOLE_ROUNDING: f64 = 4e-15;

pub(super) fn check(run: &JudgedRun, replay: &Replay, findings: &mut Findings) {
    names(run, findings);
    findings.count_checks(Rule::Figure, 2 + run.plan.bounds.len());
    cost(run, replay, findings);
    bound(run, findings);
    other_bounds(run, findings);
    outcomes(run, replay, findings);
    nearness(run, replay, findings);
    operations(run, replay, findings);
    if let Some(violation) = difference(run, &replay.states) {
        findings.push(violation);
    }
    requirements(run, replay, findings);
}

fn alike(one: f64, other: f64) -> bool {
    (one - other).abs() <= TOLERANCE * one.abs().max(other.abs())
}

fn figure(run: &JudgedRun, title: String) -> Violation {
    Violation::new(Rule::Figure, run.plan.start_ns, title).label(run.job.run_span, "this run")
}

fn names(run: &JudgedRun, findings: &mut Findings) {
    let terms = judge_of(&run.job.order).terms();
    let named = [
        ("planner", &run.plan.planner, terms.planner),
        ("objective", &run.plan.objective, terms.objective),
        ("unit", &run.plan.unit, terms.unit),
    ];
    findings.count_checks(Rule::Figure, named.len());
    for (what, recorded, claimed) in named.into_iter().filter(|(_, recorded, claimed)| recorded != claimed) {
        let title = format!("the plan of `{}` has the {what} `{recorded}`, but must have `{claimed}`", run.job.task);
        findings.push(figure(run, title));
    }
}

fn cost(run: &JudgedRun, replay: &Replay, findings: &mut Findings) {
    let RecordTerms { outcome, unit, scale, .. } = judge_of(&run.job.order).terms();
    let Some(outcome) = outcome else { return estimate(run, findings) };
    let replayed = replay.outcomes[outcome] * scale;
    if !alike(run.plan.cost, replayed) {
        let (recorded, replayed) = apart(run.plan.cost, replayed);
        let title =
            format!("the recorded cost of `{}` is {recorded} {unit}, but the replay gives {replayed}", run.job.task);
        findings.push(figure(run, title));
    }
}

/// An estimated cost is a fraction from 0 to 1.
fn estimate(run: &JudgedRun, findings: &mut Findings) {
    let cost = run.plan.cost;
    if !(0.0..=1.0).contains(&cost) {
        let title = format!("the recorded cost of `{}` is {}; it must be between 0 and 1", run.job.task, digits(cost));
        findings.push(figure(run, title));
    }
}

fn bound(run: &JudgedRun, findings: &mut Findings) {
    let (cost, bound) = (run.plan.cost, run.plan.bound);
    let unit = if run.plan.unit.is_empty() { String::new() } else { format!(" {}", run.plan.unit) };
    let title = if alike(cost, bound) {
        return;
    } else if bound > cost {
        let (bound, cost) = apart(bound, cost);
        format!("the lower bound of `{}` is {bound}{unit}, above its cost of {cost}{unit}", run.job.task)
    } else if run.plan.optimal {
        let (bound, cost) = apart(bound, cost);
        format!("`{}` is recorded as optimal at {cost}{unit}, but its lower bound is only {bound}{unit}", run.job.task)
    } else {
        return;
    };
    findings.push(figure(run, title));
}

/// Lower bounds on outcomes that were not minimised do not exceed these outcomes.
fn other_bounds(run: &JudgedRun, findings: &mut Findings) {
    for (name, bound) in &run.plan.bounds {
        let title = match run.plan.outcomes.get(name) {
            None => format!("the plan of `{}` has a bound on an unknown outcome `{name}`", run.job.task),
            Some(reached) if *bound > *reached && !alike(*bound, *reached) => {
                let (bound, reached) = apart(*bound, *reached);
                format!("the lower bound on {name} of `{}` is {bound}, above the {reached} of its plan", run.job.task)
            }
            Some(_) => continue,
        };
        findings.push(figure(run, title));
    }
}

/// Two different numbers as text, with all their digits if fewer would look the same.
fn apart(one: f64, other: f64) -> (String, String) {
    let (short_one, short_other) = (digits(one), digits(other));
    if short_one == short_other { (one.to_string(), other.to_string()) } else { (short_one, short_other) }
}

fn outcomes(run: &JudgedRun, replay: &Replay, findings: &mut Findings) {
    let recorded = &run.plan.outcomes;
    findings.count_checks(Rule::Figure, recorded.len().max(replay.outcomes.len()));
    let known = run.job.kind().vocabulary().outcomes;
    for outcome @ Outcome { name, unit, .. } in known {
        let replayed = replay.outcomes[name];
        let (recorded, replayed) = match recorded.get(&outcome.key()).copied() {
            Some(value) if is_recorded(value, replayed, *unit) => continue,
            Some(value) => quantities_apart(unit.to_si(value), replayed, unit.dimension()),
            None => ("unknown".to_owned(), Quantity::new(replayed, unit.dimension()).to_string()),
        };
        let title = format!("the recorded {name} of `{}` is {recorded}, but the replay gives {replayed}", run.job.task);
        findings.push(figure(run, title));
    }
    for name in recorded.keys().filter(|key| known.iter().all(|outcome| outcome.key() != **key)) {
        findings.push(figure(run, format!("the plan of `{}` has an unknown outcome `{name}`", run.job.task)));
    }
}

/// Tolerance between a recorded and a replayed number of a reached goal: in micrometres, degrees, or components of a
/// quaternion.
const REACHED_TOLERANCE: f64 = 5e-3;

/// The recorded result of a step, if there is one, equals the replayed one.
fn nearness(run: &JudgedRun, replay: &Replay, findings: &mut Findings) {
    for nth in 0..run.steps.len() {
        let step = run.step(nth);
        let end_ns = step.end_ns();
        if step.reached.is_empty() {
            continue;
        }
        findings.count_checks(Rule::Figure, step.reached.len());
        let over = replay.states.partition_point(|timed| timed.t_ns <= end_ns);
        let end = over.checked_sub(1).map(|last| &replay.states[last]);
        let due = end.map_or_else(Vec::new, |end| reached(&run.job.order, nth, &end.state));
        let differs = |(recorded, due): &(&Reached, &Reached)| !recorded.is_near(due, REACHED_TOLERANCE);
        let (has, is_due) = (step.reached.len(), due.len());
        let other = step.reached.iter().zip(&due).find(differs);
        let wrong = match other {
            Some((recorded, due)) => format!("{recorded}; the replay gives: {due}"),
            None if has != is_due => format!("{has} goals, but the replay reaches {is_due}"),
            None => continue,
        };
        let title =
            format!("the recorded result of step {} of `{}` differs from the replay: {wrong}", nth + 1, run.job.task);
        let place = run.job.step_spans().get(nth).map_or(run.job.run_span, |span| *span);
        let wrong = Violation::new(Rule::Figure, run.plan.start_ns, title);
        findings.push(wrong.label(place, "this step").step(run.steps[nth]));
    }
}

/// The recorded operations of a step, if there are any, equal the replayed ones.
fn operations(run: &JudgedRun, replay: &Replay, findings: &mut Findings) {
    for nth in 0..run.steps.len() {
        let step = run.step(nth);
        let due = replay.operations.get(&nth).map_or(&[][..], Vec::as_slice);
        findings.count_checks(Rule::Figure, step.operations.len());
        if !step.operations.is_empty() && step.operations.len() != due.len() {
            let (recorded, replayed) = (step.operations.len(), due.len());
            let place = format!("step {} of `{}`", nth + 1, run.job.task);
            let title = format!("{place} is recorded with {recorded} operations, but the replay gives {replayed}");
            findings.push(figure(run, title).step(run.steps[nth]));
            continue;
        }
        let differs = |(recorded, due): &(&ScheduledOperation, &JudgedOperation)| {
            [recorded.start_ns, recorded.arrival_ns, recorded.end_ns()] != due.times_ns || recorded.parts != due.parts
        };
        for (recorded, due) in step.operations.iter().zip(due).filter(differs) {
            let described = |parts: &[String], [start, arrival, end]: [u64; 3]| {
                format!("{} from {} to {}, arriving at {}", parts.join(" with "), ms(start), ms(end), ms(arrival))
            };
            let times_ns = [recorded.start_ns, recorded.arrival_ns, recorded.end_ns()];
            let (recorded, replayed) = (described(&recorded.parts, times_ns), described(&due.parts, due.times_ns));
            let title = format!("an operation is recorded as {recorded}, but the replay gives {replayed}");
            findings.push(figure(run, title).step(run.steps[nth]).label(due.span, "this operation"));
        }
    }
}

/// The violation at the first recorded state that differs from the replayed one.
pub(super) fn difference(run: &JudgedRun, replayed: &[ReplayedState]) -> Option<Violation> {
    let recorded = &run.plan.states;
    let differs = |(one, other): (&TimedState, &ReplayedState)| !agrees(one, other);
    let first = recorded.iter().zip(replayed).position(differs);
    let violation = match first {
        Some(0) if recorded[0].t_ns == replayed[0].t_ns => {
            let (recorded, replayed) =
                (judged_state(&recorded[0].state).shown(), judged_state(&replayed[0].state).shown());
            let title = format!(
                "the run of `{}` is recorded as starting at {recorded}, but starts at {replayed}",
                run.job.task
            );
            Violation::new(Rule::Start, run.plan.start_ns, title)
        }
        Some(at) => {
            let (one, other) = (&recorded[at], &replayed[at]);
            let title = format!(
                "state {at} of `{}` is recorded as {} from {} on, but the replay gives {} from {} on",
                run.job.task,
                judged_state(&one.state).shown(),
                ms(one.t_ns),
                judged_state(&other.state).shown(),
                ms(other.t_ns)
            );
            Violation::new(Rule::State, other.t_ns, title)
        }
        None if recorded.len() != replayed.len() => return Some(miscounted(run, replayed.len() as u64)),
        None => return None,
    };
    Some(violation.label(run.job.run_span, "this run"))
}

/// The violation of a record with too few or too many states.
pub(super) fn miscounted(run: &JudgedRun, replayed: u64) -> Violation {
    let recorded = run.plan.states.len();
    let title =
        format!("the run of `{}` has {recorded} recorded states, but the replay gives {replayed}", run.job.task);
    Violation::new(Rule::State, run.end_ns(), title).label(run.job.run_span, "this run")
}

/// Whether a recorded state equals the replayed one, up to rounding.
pub(super) fn agrees(recorded: &TimedState, replayed: &TimedState) -> bool {
    recorded.t_ns == replayed.t_ns && judged_state(&recorded.state).agrees(&replayed.state)
}

fn requirements(run: &JudgedRun, replay: &Replay, findings: &mut Findings) {
    findings.count_checks(Rule::Requirement, run.job.requirements.len());
    for requirement in &run.job.requirements {
        let outcomes = run.job.kind().vocabulary().outcomes;
        let outcome = outcomes.iter().find(|outcome| outcome.name == requirement.outcome);
        let outcome = outcome.expect("the premise knows every limited outcome");
        let value = replay.outcomes[outcome.name];
        if !holds(value, requirement, outcome.unit) {
            findings.push(broken(run, requirement, outcome, value));
        }
    }
}

/// Whether a figure in the unit of the record equals that of the replay, in SI units. Counts and nanoseconds are whole
/// numbers and are compared exactly.
fn is_recorded(recorded: f64, replayed: f64, unit: OutcomeUnit) -> bool {
    match unit {
        OutcomeUnit::Count => recorded == replayed,
        OutcomeUnit::Nanosecond => recorded == (replayed * 1e9).round(),
        OutcomeUnit::Degree | OutcomeUnit::Joule | OutcomeUnit::Micrometre => alike(unit.to_si(recorded), replayed),
    }
}

/// Whether a value meets a requirement. Counts, and times in nanoseconds, are whole numbers: a limit on them has no
/// tolerance beyond the rounding of its own arithmetic.
fn holds(value: f64, Requirement { relation, limit, .. }: &Requirement, unit: OutcomeUnit) -> bool {
    let equal = match unit {
        OutcomeUnit::Count => value == nearest_whole(*limit),
        OutcomeUnit::Nanosecond => (value * 1e9).round() == nearest_whole(*limit * 1e9),
        OutcomeUnit::Degree | OutcomeUnit::Joule | OutcomeUnit::Micrometre => alike(value, *limit),
    };
    match relation {
        Relation::Less => value < *limit && !equal,
        Relation::AtMost => value < *limit || equal,
        Relation::Equal => equal,
        Relation::AtLeast => value > *limit || equal,
        Relation::More => value > *limit && !equal,
    }
}

/// The whole number that a number equals up to rounding; otherwise the number itself.
fn nearest_whole(number: f64) -> f64 {
    if (number - number.round()).abs() <= WHOLE_ROUNDING * number.abs() { number.round() } else { number }
}

fn broken(run: &JudgedRun, requirement: &Requirement, outcome: &Outcome, value: f64) -> Violation {
    let name = outcome.name;
    let words = match requirement.relation {
        Relation::Less => "less than",
        Relation::AtMost => "at most",
        Relation::Equal => "exactly",
        Relation::AtLeast => "at least",
        Relation::More => "more than",
    };
    let (value, limit) = quantities_apart(value, requirement.limit, outcome.unit.dimension());
    let title = format!("{name} of {value} in `{}`; {words} {limit} is required", run.job.task);
    Violation::new(Rule::Requirement, run.end_ns(), title)
        .label(requirement.span, format!("this limit; the plan takes {value}"))
        .label(run.job.run_span, "in this run")
        .help(mend(run, requirement.relation, name, &value))
}

fn mend(run: &JudgedRun, relation: Relation, name: &'static str, value: &str) -> String {
    let objective = judge_of(&run.job.order).minimized_as(name);
    let limit = match relation {
        Relation::AtMost | Relation::AtLeast | Relation::Equal => format!("set the limit to {value}"),
        Relation::Less => format!("raise the limit above {value}"),
        Relation::More => format!("lower the limit below {value}"),
    };
    match (relation, objective) {
        (Relation::AtMost | Relation::Less, Some(objective)) if run.plan.objective == objective => {
            format!("{limit}; the plan is already made with `minimize {objective}`")
        }
        (Relation::AtMost | Relation::Less, Some(objective)) => {
            format!("{limit}; `minimize {objective}` may lower the value")
        }
        (Relation::AtMost | Relation::Less, None)
        | (Relation::Equal | Relation::AtLeast | Relation::More, Some(_) | None) => limit,
    }
}

/// Two quantities of one dimension, with all their digits if fewer would look the same.
fn quantities_apart(one: f64, other: f64, dimension: Dimension) -> (String, String) {
    let short = |si| Quantity::new(si, dimension).to_string();
    if short(one) != short(other) || one == other {
        return (short(one), short(other));
    }
    let unit = dimension.example_unit();
    let long = |si| match unit.as_str() {
        "" => format!("{si}"),
        unit => format!("{} {unit}", Quantity::new(si, dimension).in_unit(unit)),
    };
    (long(one), long(other))
}
