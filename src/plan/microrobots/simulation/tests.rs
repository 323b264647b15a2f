use super::*;
use crate::claims::fixture::bed_order;
use crate::device::microrobots::fixture::{self, pose};
use crate::device::microrobots::{Docking as Limits, Errors, Fine, MicrorobotsFacts, Robot, Turning};
use crate::geometry::Pose;
use crate::plan::microrobots::control::StrokeSegment;
use crate::plan::microrobots::guarantee::{Containment, ContainmentCheck, estimated_containments};
use crate::plan::microrobots::strategy::bent;
use crate::plan::microrobots::{Crew, MicrorobotsStepMotion, RobotDocking};
use crate::random::SplitMix64;
use crate::source::Span;
use std::sync::Arc;

/// A speed of 200 µm/s, and the published bound on the turning error: 3.7 degrees per millimetre.
pub fn errors(replan_ms: u64) -> Errors {
    Errors {
        speed_ratio: 0.02,
        turning_rad_per_um: 3.7_f64.to_radians() / 1000.0,
        place_um: 1.0,
        heading_rad: 0.5_f64.to_radians(),
        replan_ns: replan_ms * 1_000_000,
    }
}

pub fn robot(name: &str, turning: Turning) -> Robot {
    Robot { snap_down_v: 120.0, release_v: 40.0, turning, length_um: 260.0, ..fixture::robot(name, 165.0, 0.01) }
}

/// A bed with `count` robots of one kind; state j lowers the first j.
pub fn order(count: usize, turning: Turning, errors: Errors, poses: &[Pose]) -> MicrorobotsOrder {
    let usual = fixture::facts((0..count).map(|index| robot(&format!("D{}", index + 1), turning)).collect());
    let facts = MicrorobotsFacts {
        dwell_ns: 2_000_000,
        clearance_um: 20.0,
        orbit_clearance_um: 30.0,
        docking: Limits { tolerance_um: 5.0, ..usual.docking },
        fine: Fine { length_um: 250.0, cycle_um: 10.0 },
        errors: Some(errors),
        ..usual
    };
    let states = fixture::string_states(count, 1.0, |_| vec![9.0, 120.0]);
    bed_order(facts, states, poses.iter().copied().enumerate())
}

/// The pose from which a share `share` of turning leads a robot to a goal.
pub fn before(robot: &Robot, goal: Pose, share: f64, way_um: f64) -> Pose {
    let turn_per_um = share * robot.turning.sign() / robot.turning_radius_um;
    let back = Pose { heading_rad: goal.heading_rad + std::f64::consts::PI, ..goal };
    let there = bent(back, -turn_per_um, way_um);
    Pose { heading_rad: crate::device::microrobots::wrapped_rad(there.heading_rad - std::f64::consts::PI), ..there }
}

/// One robot, the last, that docks head on with the first, which stands docked at the origin heading for +x.
pub fn single(start: Pose, turning: Turning, errors: Errors) -> (MicrorobotsOrder, MicrorobotsMotion) {
    let order = order(2, turning, errors, &[start, pose(0.0, 0.0, 0.0)]);
    let goal = pose(260.0, 0.0, 180.0);
    let approach = before(order.robot(0), goal, 0.5, 250.0);
    let stage = AssemblyStage::Single { robot: 0, states: [1, 0], approach, goal };
    let steps = vec![MicrorobotsStepMotion::Legs {
        legs: Vec::new(),
        docks: vec![RobotDocking { robot: 0, leg: 0 }],
        stages: vec![stage],
    }];
    let motion =
        MicrorobotsMotion { start: Crew { poses: vec![start, pose(0.0, 0.0, 0.0)], docked: vec![false, true] }, steps };
    (order, motion)
}

#[test]
fn shares_are_as_wilson_says() {
    // Newcombe, Statistics in Medicine 17 (1998), Table I, method 3: 81 of 263 and 15 of 148, 0 of 20, 1 of 29.
    for (successes, trials, low, high) in
        [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)]
    {
        let [below, above] = wilson(successes, trials);
        assert!((below - low).abs() < 5e-5 && (above - high).abs() < 5e-5, "{successes}/{trials}: {below} {above}");
    }
    assert_eq!(wilson(0, 0), [0.0, 1.0]);
}

#[test]
fn the_spread_is_of_ranks() {
    let spread = Spread::of((1..=100).rev().map(f64::from).collect());
    assert_eq!((spread.mean, spread.p95, spread.max), (50.5, 95.0, 100.0));
    assert_eq!(Spread::of(Vec::new()), Spread::default());
}

#[test]
fn without_errors_everything_fits() {
    let none =
        Errors { speed_ratio: 0.0, turning_rad_per_um: 0.0, place_um: 0.0, heading_rad: 0.0, replan_ns: 100_000_000 };
    for turning in [Turning::Clockwise, Turning::Counterclockwise] {
        let (order, motion) = single(pose(1500.0, 900.0, 30.0), turning, none);
        let report = simulate(&order, &motion, 8, 1, 2).expect("the errors are known");
        assert_eq!(report.successes, 8, "{report:?}");
        assert!(report.dockings[0].across_um.max < 0.2 && report.dockings[0].incidence_rad.max < 0.02, "{report:?}");
    }
}

/// Every stroke of the bed moves every robot that has not docked, by its own arm.
#[test]
fn robots_that_are_not_driven_move_with_the_bed() {
    let none = Errors { speed_ratio: 0.0, turning_rad_per_um: 0.0, place_um: 0.0, heading_rad: 0.0, replan_ns: 0 };
    let poses = [pose(0.0, 0.0, 0.0), pose(0.0, 2000.0, 90.0), pose(0.0, 9000.0, 90.0)];
    let order = order(3, Turning::Clockwise, none, &poses);
    let far = pose(9000.0, 9000.0, 0.0);
    let stage = AssemblyStage::Single { robot: 0, states: [1, 0], approach: far, goal: far };
    let start = TrialStart { obstacles: &[], stages: &[&stage], poses: &poses, docked: &[false, false, true] };
    let mut trial = Trial::new(&order, none, start, 1, 0);
    let segment = |state: usize, strokes: u64| StrokeSegment { state, strokes, sets_arms: true };
    // No arm is down in state 0, the first two are in state 2.
    assert_eq!(trial.carry_out(&[segment(0, 10_000)]), Ok(()));
    let [driven, other, docked] = trial.poses[..] else { panic!("three robots") };
    assert!((driven.x_um - 100.0).abs() < 1e-6 && driven.y_um.abs() < 1e-6, "{driven:?}");
    assert!(other.x_um.abs() < 1e-6 && (other.y_um - 2100.0).abs() < 1e-6, "{other:?}");
    assert_eq!(trial.carry_out(&[segment(2, 1_650)]), Ok(()));
    let turned_rad = trial.poses[1].heading_rad - other.heading_rad;
    assert!((turned_rad + 0.1).abs() < 1e-9, "16.5 um on a circle of 165 um: {turned_rad}");
    assert_eq!((trial.poses[2], docked), (poses[2], poses[2]));
}

#[test]
fn threads_change_nothing() {
    let (order, motion) = single(pose(1500.0, 900.0, 30.0), Turning::Clockwise, errors(100));
    let one = simulate(&order, &motion, 50, 7, 1);
    assert!(one.is_some());
    assert_eq!(one, simulate(&order, &motion, 50, 7, 4));
    assert_ne!(one, simulate(&order, &motion, 50, 8, 4));
}

/// Scales of the published errors, and other figures, drawn afresh for every configuration.
fn drawn(random: &mut SplitMix64) -> (MicrorobotsOrder, MicrorobotsMotion) {
    let mut errors = errors([20, 100, 250, 1000][(random.unit() * 4.0) as usize]);
    errors.speed_ratio *= 2.0 * random.unit();
    errors.turning_rad_per_um *= 2.0 * random.unit();
    errors.place_um *= 2.0 * random.unit();
    errors.heading_rad *= 1.5 * random.unit();
    let turning = [Turning::Clockwise, Turning::Counterclockwise][(random.unit() * 2.0) as usize];
    let start = pose(700.0 + 2000.0 * random.unit(), 1500.0 * random.signed_unit(), 180.0 * random.signed_unit());
    let (mut order, mut motion) = single(start, turning, errors);
    let facts = Arc::make_mut(&mut order.facts);
    facts.docking.tolerance_um = 4.0 + 8.0 * random.unit();
    facts.fine.cycle_um = 5.0 + 10.0 * random.unit();
    facts.fine.length_um = 200.0 + 100.0 * random.unit();
    facts.robots[0].turning_radius_um = 140.0 + 60.0 * random.unit();
    facts.robots[0].step_um *= 0.5 + random.unit();
    let goal = pose(260.0, 0.0, 180.0);
    let share = 0.3 + 0.4 * random.unit();
    let approach = before(&facts.robots[0], goal, share, facts.fine.length_um);
    if let MicrorobotsStepMotion::Legs { stages, .. } = &mut motion.steps[0] {
        stages[0] = AssemblyStage::Single { robot: 0, states: [1, 0], approach, goal };
    }
    (order, motion)
}

#[test]
fn what_is_guaranteed_does_not_fail() {
    let mut random = SplitMix64::stream(5, 5);
    let mut count = 0;
    for _ in 0..60 {
        let (order, motion) = drawn(&mut random);
        let estimated = estimated_containments(&order, &motion).expect("the errors are known");
        if estimated[0].violated().is_none() {
            count += 1;
            let report = simulate(&order, &motion, 100, 11, 2).expect("the errors are known");
            assert_eq!(report.successes, 100, "{:?} {:?}", report.failures, estimated[0].containments);
            let docking = &report.dockings[0];
            let has = |check: ContainmentCheck| {
                estimated[0].containments.iter().find(|held| held.check == check).map(|held| held.needs)
            };
            let (needs_um, fine) = (has(ContainmentCheck::Place), order.facts.fine);
            // The estimate assumes that the place of the structure is known; the controller measures it.
            let known = order.facts.errors.expect("the errors are known");
            let structure_um = known.place_um + known.heading_rad * 260.0;
            assert!(
                needs_um.is_some_and(|needs_um| docking.across_um.max <= needs_um + structure_um),
                "{needs_um:?} {docking:?} {fine:?} {:?}",
                order.facts.errors
            );
            assert!(has(ContainmentCheck::Angle).is_some_and(|needs_rad| docking.incidence_rad.max <= needs_rad));
        }
    }
    assert!(count >= 15, "only {count} of 60 are guaranteed");
}

#[test]
fn published_errors_are_guaranteed() {
    let [right, left] = [Turning::Clockwise, Turning::Counterclockwise];
    for (replan_ms, turning) in [(50, right), (100, right), (300, right), (1000, right), (50, left), (300, left)] {
        let (mut order, motion) = single(pose(1500.0, 900.0, 30.0), turning, errors(replan_ms));
        Arc::make_mut(&mut order.facts).docking.tolerance_um = 7.0;
        let estimated = estimated_containments(&order, &motion).expect("the errors are known");
        assert_eq!(estimated[0].violated(), None, "{replan_ms}");
        let report = simulate(&order, &motion, 1000, 7, 2).expect("the errors are known");
        assert_eq!(report.successes, 1000);
    }
}

#[test]
fn larger_errors_are_not_guaranteed_and_fail_more_often() {
    let mut successes = Vec::new();
    for scale in [1.0, 3.0, 8.0] {
        let mut errors = errors(100);
        errors.place_um *= scale;
        errors.heading_rad *= scale;
        errors.turning_rad_per_um *= scale;
        let (mut order, motion) = single(pose(1500.0, 900.0, 30.0), Turning::Clockwise, errors);
        Arc::make_mut(&mut order.facts).docking.tolerance_um = 7.0;
        let estimated = estimated_containments(&order, &motion).expect("the errors are known");
        assert_eq!(estimated[0].violated().is_none(), scale == 1.0, "{scale}");
        successes.push(simulate(&order, &motion, 300, 7, 2).map_or(0, |report| report.successes));
    }
    assert!(successes[0] == 300 && successes[1] < 300 && successes[2] < successes[1], "{successes:?}");
}

#[test]
fn a_robot_in_the_way_is_run_into() {
    let (mut order, motion) = single(pose(1500.0, 900.0, 30.0), Turning::Clockwise, errors(100));
    let shape = crate::geometry::Shape::Disc { radius_um: 200.0 };
    let at = pose(900.0, 500.0, 0.0);
    let wall =
        crate::claims::microrobots::MicrorobotsObstacle { name: "wall".into(), shape, pose: at, span: Span::default() };
    order.obstacles = Arc::new(vec![wall]);
    let estimated = estimated_containments(&order, &motion).expect("the errors are known");
    let is_wall = |held: &&Containment| held.check == ContainmentCheck::Gross("wall".into());
    assert!(estimated[0].containments.iter().find(is_wall).is_some_and(|held| held.margin() < 0.0));
    let report = simulate(&order, &motion, 20, 7, 2).expect("the errors are known");
    assert_eq!(report.failures[0].reason, FailureReason::Collision("wall".into()));
}

/// Two robots that meet head on at the origin, some way from their approaches, and two legs with their path lengths.
pub fn pair(errors: Errors, second: Pose) -> (MicrorobotsOrder, MicrorobotsMotion) {
    let goals = [pose(-130.0, 0.0, 0.0), pose(130.0, 0.0, 180.0)];
    let starts = [pose(-2500.0, -1400.0, 70.0), second];
    let order = order(2, Turning::Clockwise, errors, &[starts[1], starts[0]]);
    let robots = [1, 0];
    let approach =
        [before(order.robot(0), goals[0], 1.0 / 3.0, 250.0), before(order.robot(0), goals[1], 2.0 / 3.0, 250.0)];
    let (sin, cos) = approach[0].heading_rad.sin_cos();
    // At least half a circle more than the second one needs.
    let facts = order.robot(0);
    let [from, to] = [starts[1], approach[1]].map(|pose| facts.orbit_centre_um(pose));
    let direction_rad = (to[1] - from[1]).atan2(to[0] - from[0]);
    let last_rad = (direction_rad - approach[1].heading_rad).rem_euclid(std::f64::consts::TAU);
    let run_um = (to[0] - from[0]).hypot(to[1] - from[1]) + 165.0 * (last_rad + std::f64::consts::PI);
    let intermediate =
        Pose { x_um: approach[0].x_um - run_um * cos, y_um: approach[0].y_um - run_um * sin, ..approach[0] };
    let stage = AssemblyStage::Pair {
        first: robots[0],
        second: robots[1],
        states: [2, 1, 0],
        intermediate,
        approach,
        goals,
        steered: Vec::new(),
    };
    let docks = vec![RobotDocking { robot: robots[0], leg: 0 }, RobotDocking { robot: robots[1], leg: 0 }];
    let steps = vec![MicrorobotsStepMotion::Legs { legs: Vec::new(), docks, stages: vec![stage] }];
    (order, MicrorobotsMotion { start: Crew { poses: vec![starts[1], starts[0]], docked: vec![false, false] }, steps })
}

fn scaled(scale: f64, replan_ms: u64) -> Errors {
    let mut errors = errors(replan_ms);
    errors.speed_ratio *= scale;
    errors.place_um *= scale;
    errors.heading_rad *= scale;
    errors.turning_rad_per_um *= scale;
    errors
}

#[test]
fn two_robots_surely_meet() {
    for (scale, second) in
        [(0.0, pose(400.0, 500.0, 10.0)), (0.2, pose(400.0, 500.0, 10.0)), (0.15, pose(350.0, 600.0, 190.0))]
    {
        let (order, motion) = pair(scaled(scale, 100), second);
        let estimated = estimated_containments(&order, &motion).expect("the errors are known");
        assert_eq!(estimated[0].violated(), None, "{scale}");
        let report = simulate(&order, &motion, 300, 7, 2).expect("the errors are known");
        assert_eq!(report.successes, 300, "{:?}", report.failures);
        let axes = estimated[0].containments.iter().find(|held| held.check == ContainmentCheck::Axes);
        assert!(axes.is_some_and(|held| report.dockings[0].across_um.max <= held.needs));
    }
}

#[test]
fn with_published_errors_two_robots_mostly_meet() {
    let (order, motion) = pair(errors(100), pose(400.0, 500.0, 10.0));
    let estimated = estimated_containments(&order, &motion).expect("the errors are known");
    assert!(estimated[0].violated().is_some());
    let report = simulate(&order, &motion, 200, 7, 2).expect("the errors are known");
    assert!((170..=200).contains(&report.successes), "{:?}", report.failures);
}

/// The pair of [`pair`], and a third robot that orbits meanwhile and docks behind the first.
fn three(errors: Errors) -> (MicrorobotsOrder, MicrorobotsMotion) {
    let (_, two) = pair(errors, pose(400.0, 500.0, 10.0));
    let third = pose(-900.0, 1500.0, 120.0);
    let poses = [third, two.start.poses[0], two.start.poses[1]];
    let order = order(3, Turning::Clockwise, errors, &poses);
    let MicrorobotsStepMotion::Legs { stages, .. } = &two.steps[0] else { unreachable!("it has legs") };
    let AssemblyStage::Pair { intermediate, approach, goals, .. } = stages[0] else { unreachable!("it is a pair") };
    let goal = pose(-390.0, 0.0, 0.0);
    let tail = before(order.robot(0), goal, 0.5, 250.0);
    let stages = vec![
        AssemblyStage::Pair {
            first: 2,
            second: 1,
            states: [3, 2, 1],
            intermediate,
            approach,
            goals,
            steered: Vec::new(),
        },
        AssemblyStage::Single { robot: 0, states: [1, 0], approach: tail, goal },
    ];
    let docks = [2, 1, 0].map(|robot| RobotDocking { robot, leg: 0 }).to_vec();
    let steps = vec![MicrorobotsStepMotion::Legs { legs: Vec::new(), docks, stages }];
    (order, MicrorobotsMotion { start: Crew { poses: poses.to_vec(), docked: vec![false; 3] }, steps })
}

#[test]
fn a_third_robot_follows_the_structure() {
    let (mut order, motion) = three(scaled(0.1, 100));
    Arc::make_mut(&mut order.facts).docking.tolerance_um = 7.0;
    let estimated = estimated_containments(&order, &motion).expect("the errors are known");
    assert_eq!(estimated.iter().map(|stage| stage.robots.len()).collect::<Vec<_>>(), [2, 1]);
    assert_eq!(estimated[0].violated(), None);
    // The possible displacement of the structure is counted twice near the structure itself, so the room seems too
    // small.
    assert!(estimated[1].violated().is_none_or(|held| held.check == ContainmentCheck::Gross("D3".into())));
    let report = simulate(&order, &motion, 300, 7, 2).expect("the errors are known");
    assert_eq!(report.successes, 300, "{:?}", report.failures);
    assert_eq!(report.dockings.iter().map(|docking| docking.robot).collect::<Vec<_>>(), [2, 1, 0]);
    // The structure is not where it should be, yet the third robot is in its place in it.
    assert!(report.dockings[2].heading_rad.max > 0.001 && report.dockings[2].across_um.max < 3.0, "{report:?}");
}
