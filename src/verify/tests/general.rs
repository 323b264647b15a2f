use super::dimibot::build::*;
use super::*;
use crate::claims::dimibot::{DimibotAction, DimibotMethod, DimibotObjective};
use crate::claims::{Job, Relation, Requirement, Timeline};
use crate::device::dimibot::PLANNERS;
use crate::diagnostic::{Code, Diagnostic};
use crate::schedule::dimibot::DimibotState;
use crate::schedule::{Actuation, Swing};
use crate::source::Span;

/// A program with two devices: bot fetches; bot returns while arm waves; after 7 ms bot nods.
fn day() -> Claims {
    let bot = || facts(3, 3);
    let fetch = order(
        bot(),
        vec![go(&[(2, 0), (2, 4)]), DimibotAction::Wait(10 * MS), DimibotAction::Visit(stops(&[(3, 5), (3, 4)]))],
    );
    let back = order(bot(), vec![go(&[(3, 1)])]);
    let wave = order(facts(2, 2), vec![go(&[(1, 0)]), go(&[(0, 0)])]);
    let nod = order(bot(), vec![go(&[(3, 0)])]);
    let jobs =
        vec![job("fetch", "bot", fetch), job("back", "bot", back), job("wave", "arm", wave), job("nod", "bot", nod)];
    let together = Timeline::Together(vec![Timeline::Run(1), Timeline::Run(2)]);
    let timeline = Timeline::Sequence(vec![Timeline::Run(0), together, Timeline::Wait(7 * MS), Timeline::Run(3)]);
    let mut claims = claims(jobs, timeline);
    claims.wires.insert("bot.bl0.set".into(), "DAC0".into());
    claims
}

const DAY: Pulses = &[
    &[&["bl1.set", "br2.set"], &[], &["bl0.set", "br0.set"]],
    &[&["br2.reset"]],
    &[&["bl0.set"], &["bl0.reset"]],
    &[&["br0.reset"]],
];

/// Each edit of the day's schedule breaks one rule and no other.
const BROKEN: &[(&str, Rule, Edit)] = &[
    ("a channel past the end", Rule::Reference, |s| s.actuations[0].channel = 20),
    ("a step past the end", Rule::Reference, |s| s.actuations[0].step = 99),
    ("a plan past the end", Rule::Reference, |s| s.steps[0].plan = u32::MAX),
    ("no duration", Rule::Number, |s| s.actuations[0].duration_ns = 0),
    ("the end of the clock", Rule::Number, |s| s.actuations[7].duration_ns = u64::MAX),
    ("a step past the end of the clock", Rule::Number, |s| s.steps[1].duration_ns = u64::MAX),
    ("a plan past the end of the clock", Rule::Number, |s| s.plans[1].duration_ns = u64::MAX),
    ("no number", Rule::Number, |s| s.actuations[0].to = f64::NAN),
    ("an endless voltage", Rule::Number, |s| s.actuations[0].from = f64::INFINITY),
    ("a cost that is none", Rule::Number, |s| s.plans[0].cost = f64::NAN),
    ("a negative bound", Rule::Number, |s| s.plans[0].bound = -1.0),
    ("an endless outcome", Rule::Number, |s| *s.plans[0].outcomes.get_mut("time_ns").unwrap() = f64::INFINITY),
    ("a place that is none", Rule::Number, |s| {
        let State::Dimibot(DimibotState { position_um, .. }) = &mut s.plans[0].states[1].state else {
            panic!("a state of a DiMiBot")
        };
        position_um[1] = f64::NAN;
    }),
    ("two actuations in the wrong order", Rule::Order, |s| s.actuations.swap(1, 2)),
    ("channels of one instant in the wrong order", Rule::Order, |s| s.actuations.swap(4, 5)),
    ("the same twice", Rule::Overlap, |s| s.actuations.insert(1, s.actuations[0])),
    ("a longer pulse over a second one", Rule::Overlap, |s| {
        let first = s.actuations[0];
        s.actuations.insert(1, Actuation { start_ns: first.end_ns() - 1, ..first });
    }),
    ("a channel of no device", Rule::Channel, |s| s.channels[1].name = "bot.bl3.set".into()),
    ("a channel of a wrong device", Rule::Channel, |s| s.channels[1].device = "arm".into()),
    ("a channel twice", Rule::Channel, |s| s.channels.push(s.channels[1].clone())),
    ("another wire", Rule::Wire, |s| s.channels[0].wire = Some("DAC1".into())),
    ("no wire", Rule::Wire, |s| s.channels[0].wire = None),
    ("a wire too many", Rule::Wire, |s| s.channels[1].wire = Some("DAC0".into())),
    ("after its step", Rule::Interval, |s| s.actuations[1].duration_ns += 5 * MS + 1),
    ("before its step", Rule::Interval, |s| s.actuations[2].start_ns -= 1),
    ("of another step", Rule::Interval, |s| s.actuations[0].step = 2),
    ("of another device's step", Rule::Interval, |s| s.actuations[6].channel = channel(s, "bot.bl1.reset")),
    ("of another program", Rule::Plan, |s| s.name = "night".into()),
    ("a plan less", Rule::Plan, |s| {
        s.plans.pop();
        s.steps.pop();
        s.actuations.pop();
    }),
    ("of another task", Rule::Plan, |s| s.plans[1].task = "fetch".into()),
    ("of another device", Rule::Plan, |s| s.plans[1].device = "arm".into()),
    ("a step less", Rule::Step, |s| {
        s.steps.pop();
        s.actuations.pop();
    }),
    ("a step more", Rule::Step, |s| {
        let mut step = s.steps[6].clone();
        (step.start_ns, step.duration_ns) = (step.end_ns(), 0);
        s.steps.push(step);
    }),
    ("a step of another task", Rule::Step, |s| s.steps[0].task = "back".into()),
    ("a gap between steps", Rule::Step, |s| (s.steps[1].start_ns, s.steps[1].duration_ns) = (40 * MS + 1, 10 * MS - 1)),
    ("a run that outlasts its steps", Rule::Step, |s| s.plans[0].duration_ns += 1),
    ("a run that ends before its steps", Rule::Step, |s| s.plans[0].duration_ns -= 1),
    ("a longer schedule", Rule::Timeline, |s| s.duration_ns += 1),
    ("a shorter schedule", Rule::Timeline, |s| s.duration_ns -= 1),
    ("a later run", Rule::Timeline, |s| shift(s, 3, 1)),
    ("a run after the other one instead of together", Rule::Timeline, |s| shift(s, 2, 20 * MS)),
    ("another planner", Rule::Figure, |s| s.plans[0].planner = "dijkstra".into()),
    ("another objective", Rule::Figure, |s| s.plans[0].objective = "time".into()),
    ("another unit", Rule::Figure, |s| s.plans[0].unit = "mm".into()),
    ("a lower cost", Rule::Figure, |s| {
        s.plans[0].cost *= 0.999_999;
        s.plans[0].bound = s.plans[0].cost;
    }),
    ("a bound above the cost", Rule::Figure, |s| s.plans[0].bound *= 1.000_001),
    ("a bound above the cost of no optimum", Rule::Figure, |s| {
        (s.plans[0].bound, s.plans[0].optimal) = (s.plans[0].cost * 1.000_001, false);
    }),
    ("an optimum without proof", Rule::Figure, |s| s.plans[0].bound *= 0.999_999),
    ("a shorter time", Rule::Figure, |s| *s.plans[0].outcomes.get_mut("time_ns").unwrap() -= 1e3),
    ("a switch less", Rule::Figure, |s| *s.plans[0].outcomes.get_mut("switches").unwrap() -= 1.0),
    ("less energy", Rule::Figure, |s| *s.plans[0].outcomes.get_mut("energy_j").unwrap() -= 1e-6),
    ("another distance", Rule::Figure, |s| *s.plans[0].outcomes.get_mut("distance_um").unwrap() *= 1.000_001),
    ("an outcome less", Rule::Figure, |s| s.plans[0].outcomes.retain(|name, _| name != "energy_j")),
    ("an outcome more", Rule::Figure, |s| s.plans[0].outcomes.extend([("steps".into(), 3.0)])),
    ("a state too early", Rule::State, |s| s.plans[0].states[1].t_ns -= 1),
    ("a start too late", Rule::State, |s| s.plans[0].states[0].t_ns += 1),
    ("a state less", Rule::State, |s| s.plans[0].states.truncate(4)),
    ("a state more", Rule::State, |s| {
        let last = s.plans[0].states[4].clone();
        s.plans[0].states.push(last);
    }),
    ("no states", Rule::State, |s| s.plans[0].states.clear()),
    ("another word", Rule::State, |s| {
        let State::Dimibot(DimibotState { word, .. }) = &mut s.plans[0].states[1].state else {
            panic!("a state of a DiMiBot")
        };
        *word = 1 << 40;
    }),
    ("another cell", Rule::State, |s| {
        let State::Dimibot(DimibotState { cell, .. }) = &mut s.plans[0].states[1].state else {
            panic!("a state of a DiMiBot")
        };
        cell.swap(0, 1);
    }),
    ("another place", Rule::State, |s| {
        let State::Dimibot(DimibotState { position_um, .. }) = &mut s.plans[0].states[1].state else {
            panic!("a state of a DiMiBot")
        };
        position_um[0] += 1e-6;
    }),
    ("another first word", Rule::Start, |s| {
        let State::Dimibot(DimibotState { word, .. }) = &mut s.plans[0].states[0].state else {
            panic!("a state of a DiMiBot")
        };
        *word = 1;
    }),
];

/// Edits that leave the day's schedule sound.
const NEAR_MISSES: &[(&str, Edit)] = &[
    ("a bound that is 0 and no optimum", |s| (s.plans[0].bound, s.plans[0].optimal) = (0.0, false)),
    ("an optimum that is not called so", |s| s.plans[0].optimal = false),
    ("a cost that differs by rounding", |s| s.plans[0].cost *= 1.0 + 1e-12),
    ("a bound above the cost by rounding", |s| s.plans[0].bound *= 1.0 + 1e-12),
    ("a place that differs by rounding", |s| {
        let State::Dimibot(DimibotState { position_um, .. }) = &mut s.plans[0].states[1].state else {
            panic!("a state of a DiMiBot")
        };
        position_um[0] += 1e-12;
    }),
    ("an unused channel left out at the end", |s| s.channels.truncate(19)),
    ("other words for a step", |s| s.steps[0].text = "go".into()),
];

/// Shifts a run with everything in it.
fn shift(schedule: &mut Schedule, plan: usize, by_ns: u64) {
    schedule.plans[plan].start_ns += by_ns;
    schedule.plans[plan].states.iter_mut().for_each(|state| state.t_ns += by_ns);
    let steps = &mut schedule.steps;
    let of_plan = |actuation: &&mut Actuation| steps[actuation.step as usize].plan as usize == plan;
    schedule.actuations.iter_mut().filter(of_plan).for_each(|actuation| actuation.start_ns += by_ns);
    steps.iter_mut().filter(|step| step.plan as usize == plan).for_each(|step| step.start_ns += by_ns);
    schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
}

#[test]
fn the_day_is_sound() {
    let schedule = schedule(&day(), DAY);
    assert_eq!(schedule.actuations.len(), 8);
    assert_eq!(schedule.duration_ns, 157 * MS);
    passes(&schedule, &day());
}

#[test]
fn each_break_is_caught_by_its_rule_alone() {
    each_alone(&schedule(&day(), DAY), &day(), BROKEN);
}

#[test]
fn near_misses_pass() {
    each_passes(&schedule(&day(), DAY), &day(), NEAR_MISSES);
}

#[test]
fn a_device_is_in_one_run_at_a_time() {
    let jobs = |device| -> Vec<Job> {
        ["bot", device]
            .map(|device| job("go", device, order(facts(3, 3), vec![go(&[(0, 0)]), DimibotAction::Wait(MS)])))
            .into()
    };
    let both = Timeline::Together(vec![Timeline::Run(0), Timeline::Run(1)]);
    let idle: Pulses = &[&[&[], &[]], &[&[], &[]]];
    let clash = claims(jobs("bot"), both.clone());
    only(Rule::Busy, &schedule(&clash, idle), &clash);
    let two = claims(jobs("arm"), both);
    passes(&schedule(&two, idle), &two);
    let after = claims(jobs("bot"), Timeline::Sequence(vec![Timeline::Run(0), Timeline::Run(1)]));
    passes(&schedule(&after, idle), &after);
}

fn limited(relation: Relation, outcome: &str, limit: f64) -> Claims {
    let mut claims = alone(order(facts(3, 3), vec![go(&[(3, 0)])]));
    claims.jobs[0].requirements = vec![Requirement { outcome: outcome.into(), relation, limit, span: Span::default() }];
    claims
}

#[test]
fn requirements_hold_up_to_their_limits() {
    use Relation::*;
    let cases = [
        (AtMost, "time", 0.04, true),
        (AtMost, "time", 0.039_999_9, false),
        (Less, "time", 0.04, false),
        (Less, "time", 0.040_000_1, true),
        (AtMost, "time", 0.039_999_999_99, false),
        (Less, "time", 0.040_000_000_01, true),
        (Equal, "time", 0.4 * 0.1, true),
        (Less, "switches", 2.000_000_001, true),
        (AtMost, "switches", 1.999_999_999, false),
        (Equal, "switches", 2.0, true),
        (Equal, "switches", 3.0, false),
        (AtLeast, "energy", 0.06, true),
        (AtLeast, "energy", 0.060_001, false),
        (More, "energy", 0.06, false),
        (More, "energy", 0.059_999, true),
        (AtMost, "distance", 5.13e-6, true),
        (AtMost, "distance", 5.12e-6, false),
    ];
    for (relation, outcome, limit, holds) in cases {
        let claims = limited(relation, outcome, limit);
        let schedule = schedule(&claims, &[&[&["bl0.set", "bl1.set"]]]);
        let expected = if holds { vec![] } else { vec![Rule::Requirement] };
        assert_eq!(rules(&schedule, &claims), expected, "{outcome} {relation:?} {limit}");
    }
}

#[test]
fn a_broken_requirement_tells_value_and_limit() {
    let claims = limited(Relation::AtMost, "time", 0.039_999_999);
    let schedule = schedule(&claims, &[&[&["bl0.set", "bl1.set"]]]);
    let Verdict::Rejected(violations) = verify(schedule, &claims) else { panic!("the limit is broken") };
    assert_eq!(violations[0].title, "time of 40 ms in `fetch`; at most 39.999999 ms is required");
    assert_eq!(violations[0].help.as_deref(), Some("set the limit to 40 ms; `minimize time` may lower the value"));
}

#[test]
fn the_cost_is_that_of_the_objective() {
    for objective in
        [DimibotObjective::Distance, DimibotObjective::Switches, DimibotObjective::Time, DimibotObjective::Energy]
    {
        let mut claims = day();
        order_of(&mut claims, 0).objective = objective;
        let sound = schedule(&claims, DAY);
        passes(&sound, &claims);
        let mut dear = sound.clone();
        dear.plans[0].cost *= 1.000_000_1;
        dear.plans[0].bound = dear.plans[0].cost;
        only(Rule::Figure, &dear, &claims);
    }
}

#[test]
fn every_planner_has_its_name() {
    use DimibotMethod::*;
    let methods = [StagedAstar, Dijkstra, BidirectionalDijkstra, Astar, HypercubeAstar];
    for (method, planner) in methods.into_iter().zip(PLANNERS) {
        let mut claims = day();
        order_of(&mut claims, 0).planner.method = method;
        let mut schedule = schedule(&claims, DAY);
        schedule.plans[0].planner = planner.name.into();
        passes(&schedule, &claims);
    }
}

#[test]
fn a_violation_becomes_a_diagnostic() {
    let claims = day();
    let mut schedule = schedule(&claims, DAY);
    schedule.actuations[1].from = 19.5;
    let Verdict::Rejected(found) = verify(schedule, &claims) else { panic!("the voltage is wrong") };
    let diagnostic = Diagnostic::from(found[0].clone());
    assert_eq!(diagnostic.code, Code::E0721);
    assert_eq!(diagnostic.title, "the pulse on `br2.set` goes from 19.5 V to 20 V; 20 V is needed");
    assert!(diagnostic.labels.is_empty() && diagnostic.help.is_some());
}

#[test]
fn times_that_differ_print_differently() {
    use super::rule::ms;
    let printed = [ms(0), ms(1), ms(15 * MS), ms(15 * MS + 100_000), ms(u64::MAX)];
    assert_eq!(printed, ["0 ms", "0.000001 ms", "15 ms", "15.1 ms", "18446744073709.551615 ms"]);
}

#[test]
fn modules_do_not_swing() {
    let mut broken = schedule(&day(), DAY);
    let pulse = &mut broken.actuations[0];
    pulse.swing = Some(Swing { period_ns: pulse.duration_ns, levels: [pulse.from, pulse.to] });
    only(Rule::Swing, &broken, &day());
}
