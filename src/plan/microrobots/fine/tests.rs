//! Interpolated turning against a simulation of its cycles.

use super::*;
use crate::device::microrobots::Turning;

fn robot(turning: Turning, turning_radius_um: f64) -> Robot {
    let step_um = 0.01;
    let (snap_down_v, release_v, length_um, width_um) = (100.0, 40.0, 260.0, 60.0);
    Robot { name: "D1".into(), snap_down_v, release_v, turning_radius_um, step_um, turning, length_um, width_um }
}

fn pose(x_um: f64, y_um: f64, heading_deg: f64) -> Pose {
    Pose { x_um, y_um, heading_rad: heading_deg.to_radians() }
}

/// The point at a path length along a bend.
fn along(robot: &Robot, from: Pose, radius_um: f64, way_um: f64) -> [f64; 2] {
    let wider = Robot { turning_radius_um: radius_um, ..robot.clone() };
    let end = wider.moved(from, Arm::Down, way_um);
    [end.x_um, end.y_um]
}

/// Drives cycles with these shares of the arm, and returns their least distance from a point.
fn nearest_um(robot: &Robot, from: Pose, shares: &[(Arm, f64)], cycle_um: f64, [x, y]: [f64; 2]) -> f64 {
    let (mut pose, mut best_um) = (from, f64::INFINITY);
    for _ in 0..80 {
        for (arm, share) in shares {
            for _ in 0..50 {
                pose = robot.moved(pose, *arm, share * cycle_um / 50.0);
                best_um = best_um.min((pose.x_um - x).hypot(pose.y_um - y));
            }
        }
    }
    best_um
}

#[test]
fn a_bend_passes_through_its_place() {
    for turning in [Turning::Clockwise, Turning::Counterclockwise] {
        let robot = robot(turning, 170.0);
        for heading_deg in [-170.0, -40.0, 0.0, 95.0] {
            let from = pose(3.0, -8.0, heading_deg);
            for (radius_um, way_um) in [(170.0, 90.0), (400.0, 210.0), (1200.0, 700.0), (200.0, 900.0)] {
                let found = bend(&robot, from, along(&robot, from, radius_um, way_um)).unwrap();
                assert!((1.0 / found.turn_per_um - radius_um).abs() < 1e-6);
                assert!((found.way_um - way_um).abs() < 1e-6);
            }
        }
    }
}

#[test]
fn places_that_no_bend_reaches_are_told() {
    let robot = robot(Turning::Clockwise, 170.0);
    let from = pose(0.0, 0.0, 0.0);
    assert_eq!(bend(&robot, from, [100.0, 1.0]), Err(Unreachable::OtherSide { off_um: 1.0 }));
    assert_eq!(bend(&robot, from, [-5.0, 0.0]), Err(Unreachable::Behind { off_um: 5.0 }));
    assert_eq!(bend(&robot, from, [50.0, 0.0]), Ok(Bend { turn_per_um: 0.0, way_um: 50.0 }));
}

#[test]
fn shares_of_two_primitives_steer_through_the_place() {
    for turning in [Turning::Clockwise, Turning::Counterclockwise] {
        let robot = robot(turning, 170.0);
        let from = pose(10.0, 20.0, 33.0);
        for radius_um in [175.0, 200.0, 340.0, 900.0, 5000.0] {
            let place_um = along(&robot, from, radius_um, 200.0);
            let found = two(&robot, 10.0, from, place_um).unwrap();
            assert!((found.shares[0] - 170.0 / radius_um).abs() < 0.02, "{found:?}");
            let shares = [(Arm::Down, found.shares[0]), (Arm::Up, found.shares[1])];
            let off_um = nearest_um(&robot, from, &shares, 10.0, place_um);
            assert!(off_um < 0.15, "radius {radius_um}: {off_um}");
        }
    }
}

/// The printed formula has the shares exchanged: 3 parts of 10 turning give 333 um of a 100 um radius, and not 143 um.
#[test]
fn the_radius_is_that_of_the_corrected_formula() {
    let robot = robot(Turning::Clockwise, 100.0);
    let cycles = Cycles::<2> { strokes: [3, 7], count: 2000 };
    let from = pose(0.0, 0.0, 0.0);
    let end = cycles.forward(&robot, [Arm::Down, Arm::Up], from);
    let radius_um = 1.0 / bend(&robot, from, [end.x_um, end.y_um]).unwrap().turn_per_um;
    assert!((radius_um - 1000.0 / 3.0).abs() < 0.2, "{radius_um}");
    let arms = [[Arm::Down, Arm::Up, Arm::Up], [Arm::Down, Arm::Down, Arm::Up]];
    for (arms, expected_um) in arms.into_iter().zip([300.0, 150.0]) {
        let end = Cycles { strokes: [1, 1, 1], count: 5000 }.forward(&robot, arms, from);
        let radius_um = 1.0 / bend(&robot, from, [end.x_um, end.y_um]).unwrap().turn_per_um;
        assert!((radius_um - expected_um).abs() < 0.1, "{radius_um}");
    }
}

#[test]
fn ranges_of_three_primitives_are_the_published_ones() {
    let robot = robot(Turning::Clockwise, 100.0);
    let from = pose(0.0, 0.0, 90.0);
    let first = |radius_um: f64| three_for_first(&robot, 0.01, from, along(&robot, from, radius_um, 100.0));
    let second = |radius_um: f64| three_for_second(&robot, 0.01, from, along(&robot, from, radius_um, 100.0));
    assert!(first(300.5).is_ok() && first(1e6).is_ok());
    assert!(matches!(first(299.5), Err(Unreachable::TooNarrow { least_um, .. }) if (least_um - 300.0).abs() < 1e-9));
    assert!(second(100.5).is_ok() && second(149.5).is_ok());
    assert!(matches!(second(150.5), Err(Unreachable::TooWide { most_um, .. }) if (most_um - 150.0).abs() < 1e-9));
    assert!(matches!(second(99.5), Err(Unreachable::TooNarrow { .. })));
    let shares = first(600.0).unwrap().shares;
    assert!((shares[0] - 1.0 / 6.0).abs() < 1e-4 && (shares[2] - 1.0 / 3.0).abs() < 1e-12);
    let shares = second(125.0).unwrap().shares;
    assert!((shares[0] - 1.0 / 3.0).abs() < 1e-12 && (shares[2] - 0.2).abs() < 1e-4);
}

#[test]
fn both_of_two_robots_are_steered_at_once() {
    let robots = [robot(Turning::Clockwise, 160.0), robot(Turning::Counterclockwise, 180.0)];
    let poses = [pose(0.0, 0.0, 10.0), pose(500.0, 0.0, 170.0)];
    let places_um = [along(&robots[0], poses[0], 700.0, 200.0), along(&robots[1], poses[1], 250.0, 200.0)];
    let found = three_for_both([&robots[0], &robots[1]], [10.0; 2], poses, places_um).unwrap();
    assert!((found.shares.iter().sum::<f64>() - 1.0).abs() < 1e-12);
    let patterns = [[Arm::Down, Arm::Up, Arm::Up], [Arm::Down, Arm::Down, Arm::Up]];
    for robot in 0..2 {
        let shares: Vec<(Arm, f64)> = patterns[robot].into_iter().zip(found.shares).collect();
        assert!(nearest_um(&robots[robot], poses[robot], &shares, 10.0, places_um[robot]) < 0.15);
    }
    let swapped =
        three_for_both([&robots[1], &robots[0]], [10.0; 2], [poses[1], poses[0]], [places_um[1], places_um[0]]);
    assert!(matches!(swapped, Err(Unreachable::OutOfOrder { .. })));
}

#[test]
fn cycles_go_back_as_they_went() {
    let fine = Fine { length_um: 200.0, cycle_um: 10.0 };
    let robot = robot(Turning::Counterclockwise, 165.0);
    let cycles = Cycles::<3>::symmetric(&fine, &[0.009, robot.step_um]);
    assert_eq!(cycles.strokes.iter().sum::<u64>(), 1000);
    assert_eq!(cycles.count, 20);
    let arms = [Arm::Down, Arm::Up, Arm::Up];
    let goal = pose(1000.0, -400.0, 123.0);
    let back = cycles.forward(&robot, arms, cycles.backward(&robot, arms, goal));
    assert!((back.x_um - goal.x_um).hypot(back.y_um - goal.y_um) < 1e-9);
    let legs: Vec<Leg> = cycles.legs([3, 2, 1]).collect();
    assert_eq!(legs.len(), 60);
    assert_eq!(legs.iter().map(|leg| leg.strokes).sum::<u64>(), cycles.total());
    assert_eq!(legs[2].state, 1);
}

/// However short the fine motion and its cycles are, each primitive occurs at least once, and no cycle exceeds its limit of
/// strokes.
#[test]
fn short_fine_motions_still_end_straight() {
    for (length_um, cycle_um) in [(0.005, 0.001), (0.02, 0.02), (0.1, 0.03), (5.0, 10.0)] {
        let cycles = Cycles::<2>::symmetric(&Fine { length_um, cycle_um }, &[0.01]);
        assert!(cycles.count >= 1 && cycles.strokes.iter().all(|strokes| *strokes >= 1), "{cycles:?}");
    }
    assert_eq!(split([0.25, 0.75], 10), [3, 7]);
    assert_eq!(split([0.0, 1.0], 7), [0, 7]);
}
