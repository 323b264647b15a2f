//! No readable schedule or claims make the verifier panic.

use super::*;
use crate::claims::Timeline;
use crate::claims::dimibot::{DimibotAction, DimibotObstacleBody};
use crate::device::dimibot::LatticeCell;
use crate::geometry::shape::Shape;
use crate::schedule::Actuation;
use crate::schedule::dimibot::DimibotState;
use proptest::prelude::*;

fn sound() -> (Claims, Schedule) {
    let bot = order(facts(3, 3), vec![go(&[(1, 0), (1, 1)]), DimibotAction::Wait(3 * MS), go(&[(1, 0)])]);
    let arm = order(facts(1, 2), vec![DimibotAction::Visit(stops(&[(1, 0), (0, 0)]))]);
    let timeline = Timeline::Together(vec![Timeline::Run(0), Timeline::Run(1)]);
    let claims = claims(vec![job("go", "bot", bot), job("wave", "arm", arm)], timeline);
    let schedule = schedule(&claims, &[&[&["bl0.set", "br0.set"], &[], &["br0.reset"]], &[&["bl0.set", "bl0.reset"]]]);
    (claims, schedule)
}

fn instant() -> impl Strategy<Value = u64> {
    prop_oneof![Just(0), Just(u64::MAX), Just(u64::MAX - 1), Just(1 << 40), Just(15 * MS), Just(20 * MS), any::<u64>()]
}

fn index() -> impl Strategy<Value = u32> {
    prop_oneof![4 => 0..6u32, 1 => Just(u32::MAX), 1 => any::<u32>()]
}

fn number() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(20.0), Just(f64::NAN), Just(f64::INFINITY), Just(-1e308), Just(1e308), any::<f64>()]
}

/// A field of a schedule, and the value to write there.
#[derive(Debug, Clone)]
enum Spoil {
    Index(usize, usize, u32),
    Instant(usize, usize, u64),
    Number(usize, usize, f64),
    List(usize, usize),
}

fn spoil() -> impl Strategy<Value = Spoil> {
    let place = || (0..6usize, 0..8usize);
    prop_oneof![
        (place(), index()).prop_map(|((what, at), value)| Spoil::Index(what, at, value)),
        (place(), instant()).prop_map(|((what, at), value)| Spoil::Instant(what, at, value)),
        (place(), number()).prop_map(|((what, at), value)| Spoil::Number(what, at, value)),
        place().prop_map(|(what, at)| Spoil::List(what, at)),
    ]
}

fn spoiled(schedule: &mut Schedule, spoil: &Spoil) {
    let Schedule { duration_ns, channels, actuations, steps, plans, .. } = schedule;
    match *spoil {
        Spoil::Index(what, at, value) => match what {
            0 => write(steps, at, |step| step.plan = value),
            1 | 2 => write(actuations, at, |actuation| actuation.channel = value),
            _ => write(actuations, at, |actuation| actuation.step = value),
        },
        Spoil::Instant(what, at, value) => match what {
            0 => *duration_ns = value,
            1 => write(steps, at, |step| step.start_ns = value),
            2 => write(steps, at, |step| step.duration_ns = value),
            3 => write(plans, at, |plan| plan.duration_ns = value),
            4 => write(plans, at, |plan| plan.start_ns = value),
            _ => write(actuations, at, |actuation| {
                let field = if at % 2 == 0 { &mut actuation.start_ns } else { &mut actuation.duration_ns };
                *field = value;
            }),
        },
        Spoil::Number(what, at, value) => match what {
            0 => write(plans, at, |plan| plan.cost = value),
            1 => write(plans, at, |plan| plan.bound = value),
            2 => write(plans, at, |plan| plan.outcomes.extend([("time_ns".to_owned(), value)])),
            3 => write(plans, at, |plan| {
                write(&mut plan.states, at, |timed| {
                    let State::Dimibot(DimibotState { word, cell, position_um }) = &mut timed.state else { return };
                    (*word, cell[0], position_um[1]) = (1 << 40, u32::MAX, value);
                })
            }),
            4 => write(actuations, at, |actuation| actuation.from = value),
            _ => write(actuations, at, |actuation| actuation.to = value),
        },
        Spoil::List(what, at) => match what {
            0 => drop(steps.pop()),
            1 => drop(plans.pop()),
            2 => drop(channels.pop()),
            3 => steps.extend(steps.first().cloned()),
            4 => channels.extend(channels.get(at).cloned()),
            _ => drop((at < actuations.len()).then(|| actuations.remove(at))),
        },
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn spoiled_schedules_are_judged(spoils in prop::collection::vec(spoil(), 1..8), sorts: bool) {
        let (claims, mut schedule) = sound();
        spoils.iter().for_each(|one| spoiled(&mut schedule, one));
        if sorts {
            schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
        }
        verify(schedule, &claims);
    }

    #[test]
    fn random_actuations_are_judged(
        list in prop::collection::vec((index(), instant(), instant(), number(), index()), 0..20),
    ) {
        let (claims, mut schedule) = sound();
        let actuation = |(channel, start_ns, duration_ns, from, step)| Actuation { channel, start_ns, duration_ns, from, to: from, swing: None, step };
        schedule.actuations = list.into_iter().map(actuation).collect();
        verify(schedule, &claims);
    }

    #[test]
    fn random_facts_are_judged(
        modules in (0..80u32, 0..80u32),
        numbers in prop::collection::vec(number(), 6),
        (pulse_duration_ns, rest_ns) in (instant(), instant()),
        places in prop::collection::vec((index(), index()), 3),
    ) {
        let (mut claims, schedule) = sound();
        let order = order_of(&mut claims, 0);
        (order.facts.left, order.facts.right) = modules;
        (order.facts.pulse_duration_ns, order.facts.rest_ns) = (pulse_duration_ns, rest_ns);
        (order.facts.gain, order.facts.stroke_um, order.facts.pulse_voltage_v) = (numbers[0], numbers[1], numbers[2]);
        (order.facts.pulse_current_a, order.facts.repeatability_um) = (numbers[3], numbers[4]);
        order.precision_um = Some(numbers[5]);
        order.facts.home = LatticeCell { x: places[0].0, y: places[0].1 };
        std::sync::Arc::make_mut(&mut order.obstacles).push(cells("dust", places[1], places[2]));
        verify(schedule, &claims);
    }

    #[test]
    fn random_shapes_are_judged(
        numbers in prop::collection::vec(number(), 4),
        corners in prop::collection::vec((number(), number()), 0..5),
        form in 0..4,
    ) {
        let shape = match form {
            0 => Shape::Disc { radius_um: numbers[0] },
            1 => Shape::Box { size_um: [numbers[0], numbers[1]] },
            2 => Shape::Capsule { length_um: numbers[0], radius_um: numbers[1] },
            _ => Shape::Polygon { points_um: corners.into_iter().map(|(x, y)| [x, y]).collect() },
        };
        let (mut claims, schedule) = sound();
        let mut obstacle = solid("bead", shape, numbers[2], numbers[3]);
        if let DimibotObstacleBody::Solid { pose, .. } = &mut obstacle.body {
            pose.heading_rad = numbers[0];
        }
        std::sync::Arc::make_mut(&mut order_of(&mut claims, 0).obstacles).push(obstacle);
        verify(schedule, &claims);
    }
}

#[test]
fn claims_that_no_program_has_are_inconclusive() {
    let (claims, schedule) = sound();
    passes(&schedule, &claims);
    let with = |edit: fn(&mut Claims)| {
        let mut claims = claims.clone();
        edit(&mut claims);
        claims
    };
    let twice =
        with(|claims| claims.timeline = Timeline::Sequence(vec![Timeline::Run(0), Timeline::Run(0), Timeline::Run(1)]));
    inconclusive(&schedule, &twice, "2 times");
    inconclusive(&schedule, &with(|claims| claims.timeline = Timeline::Run(0)), "runs job 1 0 times");
    inconclusive(&schedule, &with(|claims| claims.timeline = Timeline::Run(7)), "runs job 7, but they have 2 jobs");
    let deep = with(|claims| {
        for _ in 0..300 {
            claims.timeline = Timeline::Sequence(vec![claims.timeline.clone()]);
        }
    });
    inconclusive(&schedule, &deep, "deeper than 256");
    inconclusive(&schedule, &with(|claims| claims.jobs[1].device = "bot".into()), "two different sets of facts");
    inconclusive(&schedule, &with(|claims| order_of(claims, 0).facts.left = 21), "too many");
    inconclusive(&schedule, &with(|claims| order_of(claims, 0).facts.gain = f64::NAN), "out of range");
    inconclusive(&schedule, &with(|claims| order_of(claims, 0).facts.rest_ns = u64::MAX), "end of the clock");
    inconclusive(&schedule, &with(|claims| order_of(claims, 0).facts.home.x = 8), "does not have");
    let flat = with(|claims| {
        order_of(claims, 0).obstacles = vec![solid("bead", Shape::Disc { radius_um: -1.0 }, 0.0, 0.0)].into()
    });
    inconclusive(&schedule, &flat, "no shape");
}

#[test]
fn no_more_violations_are_kept_than_stated() {
    let (claims, mut schedule) = sound();
    schedule.actuations = vec![Actuation { channel: u32::MAX, ..schedule.actuations[0] }; 3 * MAX_VIOLATIONS];
    let Verdict::Rejected(found) = verify(schedule, &claims) else { panic!("no such channel") };
    assert_eq!(found.len(), MAX_VIOLATIONS);
}

#[test]
fn an_empty_program_is_sound() {
    let claims = claims(Vec::new(), Timeline::Sequence(Vec::new()));
    passes(&schedule(&claims, &[]), &claims);
}
