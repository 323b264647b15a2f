use super::{Edit, RECORD, each_alone, each_passes, only, passes, rules};
use crate::claims::Claims;
use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsStep};
use crate::geometry::Pose;
use crate::schedule::microrobots::MicrorobotsState;
use crate::schedule::{Schedule, State, Swing};
use crate::source::Span;
use crate::verify::{Rule, Verdict, verify};
use build::*;
use std::f64::consts::TAU;
use std::sync::Arc;

mod build;
mod clearance;
mod docking;
mod garbage;
mod random;

/// Three of the four robots move, far from one another; D1 and D2 orbit at the end.
fn day() -> Day {
    Day::new(order(&[(0, 0.0, 0.0, 90.0), (1, 1000.0, 0.0, 0.0), (3, 2500.0, 500.0, 0.0)]))
        .drive(1, &[(2, 300), (1, 200), (0, 400)])
        .wait(7_000_000)
        .apply(4, 100)
        .drive(0, &[(3, 1500)])
}

/// The `nth` train of strokes.
fn swing(schedule: &mut Schedule, nth: usize) -> &mut crate::schedule::Actuation {
    schedule.actuations.iter_mut().filter(|actuation| actuation.swing.is_some()).nth(nth).expect("a train")
}

fn level(schedule: &mut Schedule, at: usize, [from, to]: [f64; 2]) {
    (schedule.actuations[at].from, schedule.actuations[at].to) = (from, to);
}

fn swings(schedule: &mut Schedule, nth: usize, period_ns: u64, levels: [f64; 2]) {
    let train = swing(schedule, nth);
    (train.from, train.to, train.swing) = (levels[0], levels[1], Some(Swing { period_ns, levels }));
}

/// Cuts an actuation in two.
fn cut(schedule: &mut Schedule, at: usize, first_ns: u64) {
    let mut second = schedule.actuations[at];
    schedule.actuations[at].duration_ns = first_ns;
    (second.start_ns, second.duration_ns) = (second.start_ns + first_ns, second.duration_ns - first_ns);
    schedule.actuations.insert(at + 1, second);
}

fn with_state(schedule: &mut Schedule, at: usize, edit: impl FnOnce(&mut usize, &mut Vec<u8>, &mut Vec<String>)) {
    let State::Microrobots(MicrorobotsState { control, arms, docked, .. }) = &mut schedule.plans[0].states[at].state
    else {
        panic!("a bed's state")
    };
    edit(control, arms, docked);
}

fn with_pose(schedule: &mut Schedule, at: usize, [x_um, heading_rad]: [f64; 2]) {
    let State::Microrobots(MicrorobotsState { poses, .. }) = &mut schedule.plans[0].states[at].state else {
        panic!("a bed's state")
    };
    let pose = poses.get_mut("D1").expect("a robot");
    (pose.x_um, pose.heading_deg) = (pose.x_um + x_um, pose.heading_deg + heading_rad.to_degrees());
}

fn figure(schedule: &mut Schedule, name: &str, value: f64) {
    schedule.plans[0].outcomes.insert(name.to_owned(), value);
}

/// Each edit of the day's schedule breaks one rule and no other.
const BROKEN: &[(&str, Rule, Edit)] = &[
    ("more than the source gives", Rule::Level, |s| level(s, 0, [200.000_001; 2])),
    ("less than nothing", Rule::Level, |s| level(s, 0, [-0.000_001; 2])),
    ("a level that rises", Rule::Level, |s| level(s, 0, [9.0, 9.000_001])),
    ("a level too short", Rule::Level, |s| {
        s.actuations[0].duration_ns -= 1;
        (s.actuations[1].start_ns, s.actuations[1].duration_ns) = (DWELL - 1, DWELL + 1);
    }),
    ("a level in two pieces", Rule::Level, |s| cut(s, 0, DWELL / 2)),
    ("a little more flex", Rule::Train, |s| swings(s, 0, PERIOD, [100.000_001, 60.0])),
    ("a little less relax", Rule::Train, |s| swings(s, 0, PERIOD, [100.0, 59.999_999])),
    ("relax before flex", Rule::Train, |s| swings(s, 0, PERIOD, [60.0, 100.0])),
    ("strokes twice as fast", Rule::Train, |s| swings(s, 0, PERIOD / 2, [100.0, 60.0])),
    ("a train in two pieces", Rule::Train, |s| cut(s, 2, 10 * PERIOD)),
    ("strokes that are none", Rule::Train, |s| {
        let train = swing(s, 4);
        (train.from, train.to, train.swing) = (100.0, 100.0, None);
    }),
    ("a train that swings and is said not to", Rule::Swing, |s| swing(s, 1).from = 99.0),
    ("a train that ends elsewhere", Rule::Swing, |s| swing(s, 1).to = 61.0),
    ("half a period", Rule::Swing, |s| swings(s, 0, PERIOD * 2 / 3 + 1, [100.0, 60.0])),
    ("an odd period", Rule::Swing, |s| swings(s, 0, 3125, [100.0, 60.0])),
    ("no period", Rule::Swing, |s| swings(s, 0, 0, [100.0, 60.0])),
    ("levels that are no numbers", Rule::Swing, |s| {
        swing(s, 0).swing = Some(Swing { period_ns: PERIOD, levels: [f64::NAN; 2] })
    }),
    ("a cycle that leaves an arm as it was", Rule::Arm, |s| level(s, 0, [60.0; 2])),
    ("a level that need not snap", Rule::Arm, |s| level(s, 1, [111.999_9; 2])),
    ("a level that need not keep", Rule::Arm, |s| level(s, 1, [128.000_1; 2])),
    ("a state of one arm less, not of the record", Rule::State, |s| {
        let pair = s.actuations.iter().position(|actuation| actuation.from == 27.5).expect("state 1");
        level(s, pair, [9.0; 2]);
    }),
    ("another start", Rule::Start, |s| with_pose(s, 0, [2e-4, 0.0])),
    ("another heading at first", Rule::Start, |s| with_pose(s, 0, [0.0, 2e-6])),
    ("another control state at first", Rule::Start, |s| with_state(s, 0, |control, _, _| *control = 1)),
    ("another pose", Rule::State, |s| with_pose(s, 2, [-2e-4, 0.0])),
    ("arms of another state", Rule::State, |s| with_state(s, 1, |_, arms, _| arms[0] = 0)),
    ("arms of another table", Rule::State, |s| with_state(s, 1, |_, arms, _| arms.truncate(3))),
    ("docked of a sudden", Rule::State, |s| with_state(s, 3, |_, _, docked| docked.push("D1".into()))),
    ("another cost", Rule::Figure, |s| s.plans[0].cost += 1e-6),
    ("another planner", Rule::Figure, |s| s.plans[0].planner = "portfolio".into()),
    ("another number of strokes", Rule::Figure, |s| figure(s, "strokes", 2501.0)),
    ("another number of legs", Rule::Figure, |s| figure(s, "switches", 4.0)),
    ("another channel", Rule::Channel, |s| s.channels[0].name = "fleet.bed2".into()),
];

#[test]
fn the_day_is_sound() {
    let (schedule, claims) = day().both();
    assert_eq!(schedule.plans[0].outcomes["strokes"], 2500.0);
    assert_eq!(schedule.plans[0].states.len(), 7);
    assert_eq!(schedule.duration_ns, 8 * DWELL + 2500 * PERIOD + 7_000_000);
    passes(&schedule, &claims);
}

#[test]
fn each_break_is_caught_by_its_rule_alone() {
    let (schedule, claims) = day().both();
    each_alone(&schedule, &claims, &[BROKEN, RECORD].concat());
}

#[test]
fn what_lies_within_the_tolerances_passes() {
    let near: &[(&str, Edit)] = &[
        ("a pose", |s| with_pose(s, 0, [-9e-5, 9e-7])),
        ("a turned heading", |s| with_pose(s, 2, [0.0, -2.0 * TAU])),
        ("the most that the source gives", |s| level(s, 3, [200.0; 2])),
        ("the least that surely snaps", |s| level(s, 1, [112.0; 2])),
        ("the most that surely keeps", |s| level(s, 1, [128.0; 2])),
        ("the source off at first", |s| level(s, 0, [0.0; 2])),
    ];
    let (schedule, claims) = day().both();
    assert_eq!(schedule.actuations[3].from, 176.0);
    each_passes(&schedule, &claims, near);
}

#[test]
fn levels_may_last_longer_and_no_time_is_lost_between_them() {
    let lasting = |linger_ns, pause_ns| {
        let mut day = day();
        for leg in day.legs.iter_mut().flatten() {
            (leg.linger_ns, leg.pause_ns) = (linger_ns, pause_ns);
        }
        day.both()
    };
    let (slow, claims) = lasting(1, 0);
    passes(&slow, &claims);
    let (idle, claims) = lasting(0, 1);
    only(Rule::Idle, &idle, &claims);
    let (mut long, claims) = day().both();
    long.duration_ns += 1;
    long.plans[0].duration_ns += 1;
    long.plans[0].states.last_mut().expect("an end").t_ns += 1;
    long.steps[3].duration_ns += 1;
    let duration_ns = long.plans[0].duration_ns as f64;
    long.plans[0].outcomes.insert("time_ns".into(), duration_ns);
    long.plans[0].cost = duration_ns / 1e9;
    only(Rule::Idle, &long, &claims);
}

/// At 0 V all arms go up, so a pause between the cycle and its strokes undoes the cycle.
#[test]
fn arms_go_up_where_nothing_is_driven() {
    let day = Day::new(order(&[(0, 0.0, 0.0, 90.0)])).apply(2, 100);
    let (mut schedule, claims) = day.both();
    let train = schedule.actuations.last_mut().expect("a train");
    train.start_ns += PERIOD;
    train.duration_ns -= PERIOD;
    assert_eq!(rules(&schedule, &claims), [Rule::Start, Rule::Idle]);
}

#[test]
fn strokes_leave_every_arm_alone() {
    let driven = |edit: fn(&mut crate::device::microrobots::MicrorobotsFacts)| {
        let mut day = day();
        edit(Arc::make_mut(&mut day.order.facts));
        let (schedule, claims) = day.both();
        rules(&schedule, &claims)
    };
    assert_eq!(driven(|facts| facts.flex_v = 108.0), []);
    assert_eq!(driven(|facts| facts.flex_v = 108.000_1), [Rule::Arm]);
    assert_eq!(driven(|facts| facts.relax_v = 52.0), []);
    assert_eq!(driven(|facts| facts.relax_v = 51.999_9), [Rule::Arm]);
    assert_eq!(driven(|facts| facts.margin_v = 7.5), []);
    assert_eq!(driven(|facts| facts.margin_v = 7.500_1), [Rule::Arm]);
}

/// At 9 V the arm of the first row, which is not on the bed, need not go up; at 0 V it does, if its release voltage is
/// at least the margin.
#[test]
fn arms_surely_go_up_without_voltage() {
    let reported = |release_v: f64, waits: usize| {
        let start = Day::new(order(&[(1, 0.0, 0.0, 90.0)]));
        let mut day = (0..waits).fold(start, |day, _| day.wait(5)).apply(0, 10);
        Arc::make_mut(&mut day.order.facts).robots[0].release_v = release_v;
        let (schedule, claims) = day.both();
        match verify(schedule, &claims) {
            Verdict::Rejected(found) => found[0].title.clone(),
            Verdict::Accepted(_) | Verdict::Inconclusive { .. } => String::new(),
        }
    };
    assert_eq!(reported(11.0, 0), "");
    assert_eq!(reported(10.999, 0), "the arm of `D1` may be up or down when strokes begin at 5 ms");
    assert_eq!(reported(2.0, 1), "");
    assert_eq!(reported(1.999, 1), "the arm of `D1` may stay down at 0 V, at 0 ms");
}

#[test]
fn arms_stand_as_in_a_control_state_of_the_claims() {
    let (schedule, mut claims) = day().both();
    Arc::make_mut(&mut order_of(&mut claims, 0).states).remove(2);
    order_of(&mut claims, 0).steps[2].action = MicrorobotsAction::Apply { state: 3, duration_ns: 100 * PERIOD };
    only(Rule::Control, &schedule, &claims);
}

#[test]
fn a_state_is_applied_as_claimed() {
    let claimed = |state, duration_ns| {
        let (schedule, mut claims) = day().both();
        order_of(&mut claims, 0).steps[2].action = MicrorobotsAction::Apply { state, duration_ns };
        rules(&schedule, &claims)
    };
    assert_eq!(claimed(4, 99 * PERIOD + 1), []);
    assert_eq!(claimed(4, 100 * PERIOD), []);
    assert_eq!(claimed(4, 99 * PERIOD), [Rule::Apply]);
    assert_eq!(claimed(4, 100 * PERIOD + 1), [Rule::Apply]);
    assert_eq!(claimed(3, 100 * PERIOD), [Rule::Apply]);
    let twice = |legs: &[(usize, u64)]| {
        let mut day = Day::new(order(&[(0, 0.0, 0.0, 90.0)]));
        day.go(&build::legs(legs));
        let action = MicrorobotsAction::Apply { state: 1, duration_ns: 40 * PERIOD };
        day.order.steps.push(MicrorobotsStep { action, span: Span::default() });
        let (schedule, claims) = day.both();
        rules(&schedule, &claims)
    };
    assert_eq!(twice(&[(1, 40)]), []);
    assert_eq!(twice(&[(1, 20), (1, 20)]), [Rule::Apply]);
    assert_eq!(twice(&[]), [Rule::Apply]);
}

/// The rules that the day breaks after an edit of the stops of its first step; the last stop is the goal.
fn with_stops(edit: impl FnOnce(&mut Vec<Pose>)) -> Vec<Rule> {
    let (schedule, mut claims) = day().both();
    let MicrorobotsAction::Drive { stops, .. } = &mut order_of(&mut claims, 0).steps[0].action else {
        panic!("a drive")
    };
    let mut poses: Vec<Pose> = stops.iter().map(|stop| stop.pose).collect();
    edit(&mut poses);
    *stops = poses.into_iter().map(stop).collect();
    rules(&schedule, &claims)
}

#[test]
fn goals_are_met_within_the_precision() {
    assert_eq!(with_stops(|stops| stops[0].x_um += 0.4999), []);
    assert_eq!(with_stops(|stops| stops[0].y_um -= 0.4999), []);
    assert_eq!(with_stops(|stops| stops[0].y_um -= 0.5001), [Rule::Goal]);
    assert_eq!(with_stops(|stops| stops[0].heading_rad += 0.009_99 + TAU), []);
    assert_eq!(with_stops(|stops| stops[0].heading_rad += 0.010_01), [Rule::Goal]);
    assert_eq!(with_stops(|stops| stops[0].heading_rad -= 0.010_01), [Rule::Goal]);
}

#[test]
fn stops_are_met_at_ends_of_legs_in_their_order() {
    let start = pose(1000.0, 0.0, 0.0);
    let first = carried(&facts().robots[1], crate::device::microrobots::Arm::Down, start, 150.0);
    let second = carried(&facts().robots[1], crate::device::microrobots::Arm::Up, first, 100.0);
    let midway = carried(&facts().robots[1], crate::device::microrobots::Arm::Up, first, 50.0);
    let via = |vias: &[Pose]| with_stops(|stops| drop(stops.splice(0..0, vias.iter().copied())));
    assert_eq!(via(&[first]), []);
    assert_eq!(via(&[first, second]), []);
    assert_eq!(via(&[start, first, first, second]), []);
    assert_eq!(via(&[second, first]), [Rule::Goal]);
    assert_eq!(via(&[midway]), [Rule::Goal]);
    let end = with_stops(|stops| stops.push(stops[0]));
    assert_eq!(end, []);
}

#[test]
fn waits_last_as_claimed_and_are_quiet() {
    let waiting = |ns| Day::new(order(&[(0, 0.0, 0.0, 90.0)])).apply(1, 10).wait(ns).apply(2, 10);
    let (schedule, claims) = waiting(40 * DWELL).both();
    passes(&schedule, &claims);
    let (other, _) = waiting(40 * DWELL + 1).both();
    only(Rule::Wait, &other, &claims);
    let mut loud = schedule.clone();
    let mut stray = loud.actuations[0];
    (stray.step, stray.start_ns) = (1, loud.steps[1].start_ns + 1);
    loud.actuations.insert(3, stray);
    only(Rule::Wait, &loud, &claims);
    for ns in [0, 1, u64::MAX / 2] {
        let (schedule, claims) = waiting(ns).both();
        passes(&schedule, &claims);
    }
}

#[test]
fn robots_stand_where_the_last_run_left_them() {
    let robots = [(0, 0.0, 0.0, 90.0), (1, 1000.0, 0.0, 0.0)];
    let first = Day::new(order(&robots)).apply(2, 300);
    let second = Day::new(order(&robots)).apply(1, 77);
    let claims = in_turn(vec![first.order, second.order]);
    let sound = schedule(&claims, &[first.legs, second.legs]);
    passes(&sound, &claims);
    let mut early = sound.clone();
    early.plans[1].states[0].state = sound.plans[0].states[0].state.clone();
    only(Rule::Start, &early, &claims);
    let mut idle = claims.clone();
    order_of(&mut idle, 1).steps.clear();
    let rests = schedule(&idle, &[vec![vec![leg(2, 300)]], vec![]]);
    passes(&rests, &idle);
    assert_eq!(rests.plans[1].states.len(), 1);
}

#[test]
fn messages_name_robots_voltages_times_and_limits() {
    let (schedule, claims) = day().both();
    let reported = |edit: Edit| {
        let mut broken = schedule.clone();
        edit(&mut broken);
        let Verdict::Rejected(found) = verify(broken, &claims) else { panic!("a broken schedule") };
        found[0].title.clone()
    };
    assert_eq!(
        reported(|s| level(s, 2, [250.0; 2])),
        "actuation 2 on `fleet.bed` swings between 100 V and 60 V, but is recorded as going from 250 V to 250 V"
    );
    assert_eq!(reported(|s| level(s, 0, [250.0; 2])), "the bed is at 250 V at 0 ms; the source gives 0 V to 200 V");
    assert_eq!(reported(|s| level(s, 0, [60.0; 2])), "the arm of `D3` may be up or down when strokes begin at 10 ms");
    let fast = reported(|s| swings(s, 0, PERIOD / 2, [100.0, 60.0]));
    assert_eq!(
        fast,
        "the bed swings between 100 V and 60 V every 0.05 ms at 10 ms; 100 V and 60 V every 0.1 ms is needed"
    );
    let far = reported(|s| with_pose(s, 0, [1.0, 0.0]));
    assert!(far.ends_with("but starts at control state 2 with `D1` at (0 um, 0 um, 90 deg), `D2` at (1000 um, 0 um, 0 deg), `D4` at (2500 um, 500 um, 0 deg)"), "{far}");
}
