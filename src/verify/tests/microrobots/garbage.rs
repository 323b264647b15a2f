//! No readable schedule or claims make the verifier panic, and none take it long.

use super::*;
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::{MAX_ROBOTS, MicrorobotsFacts};
use crate::geometry::{Pose, Shape};
use crate::schedule::microrobots::MicrorobotsState;
use crate::verify::tests::{UnfitOrder, each_unfit, why, write};
use proptest::prelude::*;

fn sound() -> (Claims, Schedule) {
    let mut order = order(&[(0, 0.0, 2000.0, 0.0), (1, 0.0, 0.0, 0.0), (2, 842.0, 0.0, 180.0)]);
    order.obstacles = Arc::new(vec![obstacle("dust", Shape::Disc { radius_um: 5.0 }, pose(-500.0, -500.0, 0.0))]);
    let dock = Leg { docks: vec![1, 2], ..leg(0, 600) };
    let day = Day::new(order).assemble(&[1, 2], &[dock]).wait(DWELL).drive(0, &[(1, 300), (0, 100)]).apply(1, 40);
    let (schedule, claims) = day.both();
    (claims, schedule)
}

fn instant() -> impl Strategy<Value = u64> {
    prop_oneof![Just(0), Just(1), Just(u64::MAX), Just(1 << 40), Just(PERIOD), Just(DWELL), Just(1 << 62), any::<u64>()]
}

fn index() -> impl Strategy<Value = u32> {
    prop_oneof![4 => 0..8u32, 1 => Just(u32::MAX), 1 => any::<u32>()]
}

fn number() -> impl Strategy<Value = f64> {
    let picked = vec![0.0, 100.0, 60.0, 0.5, 1e6, -1.0, 1e-300, f64::NAN, f64::INFINITY, -1e308];
    prop_oneof![10 => prop::sample::select(picked), 1 => any::<f64>()]
}

/// Writes an arbitrary value to one field of a schedule.
fn spoiled(schedule: &mut Schedule, what: u8, at: usize, value: u64, small: u32, number: f64) {
    let Schedule { duration_ns, channels, actuations, steps, plans, .. } = schedule;
    match what {
        0 => *duration_ns = value,
        1 => write(steps, at, |step| step.duration_ns = value),
        2 => write(steps, at, |step| step.start_ns = value),
        3 => write(plans, at, |plan| plan.duration_ns = value),
        4 => write(actuations, at, |actuation| actuation.duration_ns = value),
        5 => write(actuations, at, |actuation| actuation.start_ns = value),
        6 => write(actuations, at, |actuation| actuation.step = small),
        7 => write(actuations, at, |actuation| (actuation.from, actuation.to) = (number, number)),
        8 => write(actuations, at, |a| a.swing = Some(Swing { period_ns: value, levels: [number, a.to] })),
        9 => write(actuations, at, |actuation| actuation.swing = None),
        10 => plans.iter_mut().for_each(|plan| plan.states.truncate(at)),
        11 => drop((at < actuations.len()).then(|| actuations.remove(at))),
        12 => write(channels, at, |channel| channel.name = format!("fleet.bed{small}")),
        _ => write(plans, 0, |plan| {
            write(&mut plan.states, at, |timed| {
                let State::Microrobots(MicrorobotsState { control, arms, docked, poses }) = &mut timed.state else {
                    return;
                };
                (*control, arms[0]) = (small as usize, small as u8);
                docked.push(format!("D{small}"));
                poses.insert(format!("D{small}"), Pose::at(number, 0.0).into());
            });
        }),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn spoiled_schedules_are_judged(
        spoils in prop::collection::vec(((0..14u8, 0..12usize), instant(), index(), number()), 1..6),
        sorts: bool,
    ) {
        let (claims, mut schedule) = sound();
        for ((what, at), value, small, number) in spoils {
            spoiled(&mut schedule, what, at, value, small, number);
        }
        if sorts {
            schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
        }
        verify(schedule, &claims);
    }
}

/// Writes a number to one field of an order.
fn distorted(order: &mut MicrorobotsOrder, what: u8, at: usize, value: f64, ns: u64) {
    let facts = Arc::make_mut(&mut order.facts);
    match what {
        0 => facts.robots[at % 4].snap_down_v = value,
        1 => facts.robots[at % 4].release_v = value,
        2 => facts.robots[at % 4].turning_radius_um = value,
        3 => facts.robots[at % 4].step_um = value,
        4 => facts.robots[at % 4].length_um = value,
        5 => facts.robots[at % 4].width_um = value,
        6 => facts.margin_v = value,
        7 => facts.max_v = value,
        8 => facts.relax_v = value,
        9 => facts.flex_v = value,
        10 => facts.clearance_um = value,
        11 => facts.orbit_clearance_um = value,
        12 => facts.docking.tolerance_um = value,
        13 => facts.fine.length_um = value,
        14 => facts.fine.cycle_um = value,
        15 => facts.period_ns = ns,
        16 => facts.dwell_ns = ns,
        17 => write(Arc::make_mut(&mut order.states).as_mut_slice(), at, |state| state.levels_v[0] = value),
        18 => Arc::make_mut(&mut order.robots)[at % 3].pose.x_um = value,
        19 => Arc::make_mut(&mut order.robots)[at % 3].pose.heading_rad = value,
        20 => Arc::make_mut(&mut order.obstacles)[0].shape = Shape::Disc { radius_um: value },
        21 => Arc::make_mut(&mut order.obstacles)[0].pose.x_um = value,
        22 => order.precision.place_um = value,
        23 => order.precision.heading_rad = value,
        24 => Arc::make_mut(&mut order.robots)[at % 3].row = ns as usize,
        25 => order.steps[3].action = MicrorobotsAction::Apply { state: at, duration_ns: ns },
        26 => order.steps[1].action = MicrorobotsAction::Wait(ns),
        _ => Arc::make_mut(&mut order.states).truncate(at % 5),
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_claims_are_judged(
        edits in prop::collection::vec((0..28u8, 0..12usize, number(), instant()), 1..4),
        follows: bool,
    ) {
        let (mut claims, mut schedule) = sound();
        let order = order_of(&mut claims, 0);
        edits.iter().for_each(|(what, at, value, ns)| distorted(order, *what, *at, *value, *ns));
        if follows {
            let MicrorobotsFacts { flex_v, relax_v, .. } = *order.facts;
            for train in schedule.actuations.iter_mut().filter(|actuation| actuation.swing.is_some()) {
                (train.from, train.to) = (flex_v, relax_v);
                train.swing = Some(Swing { period_ns: PERIOD, levels: [flex_v, relax_v] });
            }
        }
        verify(schedule, &claims);
    }
}

#[test]
fn claims_that_no_program_has_are_inconclusive() {
    let (claims, schedule) = sound();
    fn facts(order: &mut MicrorobotsOrder) -> &mut MicrorobotsFacts {
        Arc::make_mut(&mut order.facts)
    }
    let cases: &[UnfitOrder<MicrorobotsOrder>] = &[
        ("no row", |order| facts(order).robots.clear()),
        ("too many", |order| {
            let row = facts(order).robots[0].clone();
            facts(order).robots.resize(MAX_ROBOTS + 1, row);
        }),
        ("two robots with the same name", |order| facts(order).robots[1].name = "D1".into()),
        ("a voltage out of range", |order| facts(order).margin_v = f64::NAN),
        ("a voltage out of range", |order| facts(order).margin_v = -1.0),
        ("than the source gives", |order| facts(order).max_v = 99.0),
        ("zero or odd", |order| facts(order).period_ns = 0),
        ("zero or odd", |order| facts(order).period_ns = 3),
        ("dwell time of 0", |order| facts(order).dwell_ns = 0),
        ("a length out of range", |order| facts(order).clearance_um = -1.0),
        ("a length out of range", |order| facts(order).docking.tolerance_um = f64::INFINITY),
        ("a length out of range", |order| facts(order).fine.length_um = f64::NAN),
        ("never releases", |order| facts(order).robots[2].release_v = 130.0),
        ("a robot with a size out of range", |order| facts(order).robots[2].turning_radius_um = 0.0),
        ("a robot with a size out of range", |order| facts(order).robots[2].step_um = 1e7),
        ("of another table", |order| Arc::make_mut(&mut order.states)[1].arms.truncate(3)),
        ("a control state twice", |order| {
            let states = Arc::make_mut(&mut order.states);
            states[1].arms = states[2].arms.clone();
        }),
        ("without levels", |order| Arc::make_mut(&mut order.states)[1].levels_v.clear()),
        ("not finite", |order| Arc::make_mut(&mut order.states)[1].levels_v[0] = f64::NAN),
        ("with all arms up", |order| drop(Arc::make_mut(&mut order.states).remove(0))),
        ("another order than their table", |order| Arc::make_mut(&mut order.robots).swap(0, 1)),
        ("not in the table", |order| Arc::make_mut(&mut order.robots)[2].row = 4),
        ("a robot out of range", |order| Arc::make_mut(&mut order.robots)[2].pose.y_um = f64::NAN),
        ("without a shape", |order| {
            Arc::make_mut(&mut order.obstacles)[0].shape = Shape::Disc { radius_um: -1.0 };
        }),
        ("a precision", |order| order.precision.place_um = f64::NAN),
        ("apply a state", |order| order.steps[3].action = MicrorobotsAction::Apply { state: 5, duration_ns: 1 }),
        ("drive a robot that", |order| {
            order.steps[2].action = MicrorobotsAction::Drive { robot: 3, stops: vec![stop(pose(0.0, 0.0, 0.0))] };
        }),
        ("without a goal", |order| order.steps[2].action = MicrorobotsAction::Drive { robot: 2, stops: vec![] }),
        ("a goal out of range", |order| {
            order.steps[2].action = MicrorobotsAction::Drive { robot: 2, stops: vec![stop(pose(1e7, 0.0, 0.0))] };
        }),
        ("assemble no robot", |order| order.steps[0].action = MicrorobotsAction::Assemble(vec![])),
        ("a robot twice", |order| {
            let MicrorobotsAction::Assemble(docks) = &mut order.steps[0].action else { return };
            docks[1].robot = 1;
        }),
        ("assemble a robot that", |order| {
            let MicrorobotsAction::Assemble(docks) = &mut order.steps[0].action else { return };
            docks[1].robot = 3;
        }),
    ];
    each_unfit((&schedule, &claims), order_of, cases);
}

/// A run has other facts, or other robots, on the same device.
#[test]
fn a_bed_has_one_table_and_one_set_of_robots() {
    let start = || Day::new(order(&[(0, 0.0, 0.0, 0.0)])).apply(0, 10).order;
    let because = |second: MicrorobotsOrder, expected: &str| {
        let claims = in_turn(vec![start(), second]);
        let schedule = schedule(&claims, &[vec![legs(&[(0, 10)])], vec![legs(&[(0, 10)])]]);
        assert_eq!(why(&schedule, &claims).as_deref(), Some(expected));
    };
    let mut faster = start();
    Arc::make_mut(&mut faster.facts).robots[0].step_um = 0.6;
    because(faster, "the claims have two different sets of facts about the device `fleet`");
    let other = Day::new(order(&[(1, 0.0, 0.0, 0.0)])).apply(0, 10).order;
    because(other, "the claims have two different sets of parts on the device `fleet`");
}

/// As large as plans get: 500 legs, four robots, and 50 obstacles around them.
#[test]
fn a_large_schedule_is_followed() {
    let mut order =
        order(&[(0, 0.0, 0.0, 0.0), (1, 1500.0, 0.0, 90.0), (2, 0.0, 1500.0, 180.0), (3, 1500.0, 1500.0, 0.0)]);
    let ring = (0..50).map(|at| {
        let angle_rad = f64::from(at) / 50.0 * TAU;
        let (x, y) = (1e5 * angle_rad.cos(), 1e5 * angle_rad.sin());
        obstacle("dust", Shape::Box { size_um: [50.0, 20.0] }, pose(x, y, f64::from(at)))
    });
    order.obstacles = Arc::new(ring.collect());
    let all: Vec<(usize, u64)> = (0..500).map(|at| (4 - at % 2, 300)).collect();
    let (schedule, claims) = Day::new(order).drive(0, &all).both();
    passes(&schedule, &claims);
}
