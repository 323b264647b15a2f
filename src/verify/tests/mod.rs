//! Each rule is broken by hand in a way that only it catches, and nearly broken in a way that passes.

mod dimibot;
mod electrode_array;
mod faults;
mod fingers;
mod general;
mod holds;
mod microrobots;
mod outputs;

use super::*;
use crate::claims::{Job, Order, Timeline, fixture};
use crate::schedule::dimibot::DimibotState;
use crate::schedule::{PlanRecord, ScheduledStep, SourceRef};
use crate::source::Span;

const MS: u64 = 1_000_000;

fn claims(jobs: Vec<Job>, timeline: Timeline) -> Claims {
    fixture::claims("day", jobs, timeline)
}

/// The claims of tasks `task0`, `task1`, ... of one device, one after the other.
fn in_turn(device: &str, orders: impl IntoIterator<Item = Order>) -> Claims {
    let orders = orders.into_iter().enumerate();
    let jobs: Vec<Job> = orders.map(|(at, order)| fixture::job(&format!("task{at}"), device, order)).collect();
    let timeline = Timeline::Sequence((0..jobs.len()).map(Timeline::Run).collect());
    claims(jobs, timeline)
}

/// The rules that a schedule breaks, each once, in the order of the catalogue.
fn rules(schedule: &Schedule, claims: &Claims) -> Vec<Rule> {
    match verify(schedule.clone(), claims) {
        Verdict::Accepted(_) => Vec::new(),
        Verdict::Rejected(violations) => {
            let mut rules: Vec<Rule> = violations.into_iter().map(|violation| violation.rule).collect();
            rules.sort_unstable();
            rules.dedup();
            rules
        }
        Verdict::Inconclusive { why } => panic!("inconclusive: {why}"),
    }
}

/// Asserts that exactly one rule is broken.
#[track_caller]
fn only(rule: Rule, schedule: &Schedule, claims: &Claims) {
    assert_eq!(rules(schedule, claims), [rule]);
}

/// An edit that breaks something.
type Edit = fn(&mut Schedule);

/// Asserts that each edit of a sound schedule breaks its rule and no other.
#[track_caller]
fn each_alone(sound: &Schedule, claims: &Claims, broken: &[(&str, Rule, Edit)]) {
    let found = broken.iter().map(|(name, _, edit)| {
        let mut broken = sound.clone();
        edit(&mut broken);
        (*name, rules(&broken, claims))
    });
    let expected: Vec<_> = broken.iter().map(|(name, rule, _)| (*name, vec![*rule])).collect();
    assert_eq!(found.collect::<Vec<_>>(), expected);
}

/// Edits of a record that are caught for any kind of device.
const RECORD: &[(&str, Rule, Edit)] = &[
    ("a state too late", Rule::State, |s| s.plans[0].states[1].t_ns += 1),
    ("a state less", Rule::State, |s| drop(s.plans[0].states.pop())),
    ("a state twice", Rule::State, |s| {
        let last = s.plans[0].states.last().cloned();
        s.plans[0].states.extend(last);
    }),
    ("a state of another kind", Rule::State, |s| {
        s.plans[0].states[1].state = State::Dimibot(DimibotState { word: 0, cell: [0, 0], position_um: [0.0, 0.0] });
    }),
    ("no states", Rule::State, |s| s.plans[0].states.clear()),
];

/// Asserts that each edit of a sound schedule breaks nothing.
#[track_caller]
fn each_passes(sound: &Schedule, claims: &Claims, near: &[(&str, Edit)]) {
    for (name, edit) in near {
        let mut near = sound.clone();
        edit(&mut near);
        assert_eq!(rules(&near, claims), [], "{name}");
    }
}

/// Asserts that nothing is broken.
#[track_caller]
fn passes(schedule: &Schedule, claims: &Claims) {
    if let Verdict::Rejected(violations) = verify(schedule.clone(), claims) {
        panic!("{violations:#?}");
    }
    assert!(rules(schedule, claims).is_empty());
}

/// The reason why claims cannot be judged; `None` if they were judged.
fn why(schedule: &Schedule, claims: &Claims) -> Option<String> {
    match verify(schedule.clone(), claims) {
        Verdict::Inconclusive { why } => Some(why),
        Verdict::Accepted(_) | Verdict::Rejected(_) => None,
    }
}

/// Asserts that claims cannot be judged, for a reason that contains these words.
#[track_caller]
fn inconclusive(schedule: &Schedule, claims: &Claims, expected: &str) {
    let why = why(schedule, claims).unwrap_or_else(|| panic!("claims were judged, not {expected}"));
    assert!(why.contains(expected), "{why}, not {expected}");
}

/// Part of a reason, and an edit of an order that causes it.
type UnfitOrder<O> = (&'static str, fn(&mut O));

/// Asserts that sound claims can be judged, and that each edit of their first order makes them unfit for its reason.
#[track_caller]
fn each_unfit<O>(sound: (&Schedule, &Claims), order_of: fn(&mut Claims, usize) -> &mut O, cases: &[UnfitOrder<O>]) {
    let (schedule, claims) = sound;
    passes(schedule, claims);
    for (expected, spoil) in cases {
        let mut claims = claims.clone();
        spoil(order_of(&mut claims, 0));
        inconclusive(schedule, &claims, expected);
    }
}

/// Edits one item of a list; the index wraps around.
fn write<T>(list: &mut [T], at: usize, edit: impl FnOnce(&mut T)) {
    let len = list.len().max(1);
    list.get_mut(at % len).map(edit);
}

/// An empty schedule of some claims.
fn bare(claims: &Claims) -> Schedule {
    Schedule {
        holds: Vec::new(),
        bench: Default::default(),
        name: claims.name.clone(),
        source: SourceRef { file: "day.twz".into(), sha256: "00".into(), settings: Vec::new() },
        duration_ns: 0,
        channels: Vec::new(),
        actuations: Vec::new(),
        steps: Vec::new(),
        plans: Vec::new(),
    }
}

/// A step of a job, from one instant to another.
fn step_of(job: &Job, plan: usize, [start_ns, end_ns]: [u64; 2]) -> ScheduledStep {
    ScheduledStep {
        task: job.task.clone(),
        plan: plan as u32,
        text: "step".into(),
        file: "day.twz".into(),
        line: 1,
        column: 1,
        start_ns,
        duration_ns: end_ns - start_ns,
        reached: Vec::new(),
        operations: Vec::new(),
        span: Span::default(),
    }
}

/// The planner's record of a job, from one instant to another; not proven optimal, and without states.
fn record_of(job: &Job, planner: &str, [objective, unit]: [&str; 2], [start_ns, end_ns]: [u64; 2]) -> PlanRecord {
    PlanRecord {
        task: job.task.clone(),
        device: job.device.clone(),
        kind: job.kind(),
        planner: planner.into(),
        objective: objective.into(),
        unit: unit.into(),
        cost: 0.0,
        bound: 0.0,
        optimal: false,
        bounds: Default::default(),
        outcomes: Default::default(),
        start_ns,
        duration_ns: end_ns - start_ns,
        states: Vec::new(),
        remarks: Vec::new(),
    }
}
