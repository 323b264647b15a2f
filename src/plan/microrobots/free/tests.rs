//! Shortest paths compared with all sums of two of many directions, and their ends.

use super::*;
use crate::device::microrobots::{Turning, fixture};
use proptest::prelude::*;

fn robot(radius_um: f64, turning: Turning) -> Robot {
    Robot { turning, ..fixture::robot("D1", radius_um, 0.015) }
}

fn pose(x_um: f64, y_um: f64, heading_rad: f64) -> Pose {
    Pose { x_um, y_um, heading_rad }
}

fn end(robot: &Robot, from: Pose, way: &[ArmSegment]) -> Pose {
    way.iter().fold(from, |pose, segment| robot.moved(pose, segment.arm, segment.way_um))
}

fn off(a: Pose, b: Pose) -> (f64, f64) {
    let turn_rad = (a.heading_rad - b.heading_rad).rem_euclid(TAU);
    ((a.x_um - b.x_um).hypot(a.y_um - b.y_um), turn_rad.min(TAU - turn_rad))
}

/// The least length over directions in steps of `1/PARTS` of the arc, for k = 0 and 1: a least sum needs two directions
/// at most.
fn brute_um(robot: &Robot, from: Pose, to: Pose) -> f64 {
    const PARTS: usize = 240;
    let sign = robot.turning.sign();
    let ([ax, ay], [bx, by]) = (robot.orbit_centre_um(from), robot.orbit_centre_um(to));
    let (dx, dy) = (bx - ax, by - ay);
    let first_rad = (sign * (to.heading_rad - from.heading_rad)).rem_euclid(TAU);
    let mut least_um = f64::INFINITY;
    for all_rad in [first_rad, first_rad + TAU] {
        let units: Vec<(f64, f64)> = (0..=PARTS)
            .map(|part| from.heading_rad + sign * all_rad * part as f64 / PARTS as f64)
            .map(|heading_rad| (heading_rad.cos(), heading_rad.sin()))
            .collect();
        for (at, a) in units.iter().enumerate() {
            for b in &units[at..] {
                let cross = a.0 * b.1 - a.1 * b.0;
                if cross.abs() < 1e-9 {
                    continue;
                }
                let (one_um, other_um) = ((dx * b.1 - dy * b.0) / cross, (a.0 * dy - a.1 * dx) / cross);
                if one_um >= 0.0 && other_um >= 0.0 {
                    least_um = least_um.min(one_um + other_um + robot.turning_radius_um * all_rad);
                }
            }
        }
    }
    least_um
}

#[test]
fn what_lies_ahead_costs_no_circle() {
    let robot = robot(200.0, Turning::Clockwise);
    for heading_rad in [0.0, 0.3, 2.0, -3.0, 0.1 + 0.2] {
        let from = pose(1234.5, -987.6, heading_rad);
        let ahead = robot.moved(from, Arm::Up, 7_000.0);
        let way = shortest(&robot, from, Pose { heading_rad: heading_rad + TAU, ..ahead });
        assert_eq!(way.len(), 1, "{way:?}");
        assert!((way[0].way_um - 7_000.0).abs() < 1e-6 && way[0].arm == Arm::Up);
        let turned = robot.moved(from, Arm::Down, 321.0);
        let way = shortest(&robot, from, turned);
        assert!(way.len() == 1 && way[0].arm == Arm::Down && (way[0].way_um - 321.0).abs() < 1e-6, "{way:?}");
        assert!(length_um(&shortest(&robot, from, from)) < 1e-6);
        let behind = Pose { x_um: 2.0 * from.x_um - ahead.x_um, y_um: 2.0 * from.y_um - ahead.y_um, ..from };
        assert!((distance_um(&robot, from, behind) - 7_000.0 - TAU * 200.0).abs() < 1e-6);
    }
}

#[test]
fn a_little_aside_costs_a_circle_on_one_side() {
    let robot = robot(200.0, Turning::Clockwise);
    let from = Pose::at(0.0, 0.0);
    // To the right, clockwise, and straight back to the heading: impossible without a circle.
    assert!(distance_um(&robot, from, pose(5_000.0, -3.0, 0.0)) > 5_000.0 + TAU * 199.0);
    assert!(distance_um(&robot, from, pose(5_000.0, -3.0, -0.1)) < 5_100.0);
}

#[test]
fn straight_turn_straight_is_found_where_it_is_best() {
    let robot = robot(100.0, Turning::Clockwise);
    let from = Pose::at(0.0, 0.0);
    let corner = robot.moved(robot.moved(from, Arm::Up, 800.0), Arm::Down, 100.0 * 1.6 * PI);
    let to = robot.moved(corner, Arm::Up, 500.0);
    let way = shortest(&robot, from, to);
    assert_eq!(way.iter().map(|segment| segment.arm).collect::<Vec<_>>(), [Arm::Up, Arm::Down, Arm::Up]);
    assert!((length_um(&way) - 1_300.0 - 160.0 * PI).abs() < 1e-6);
}

fn poses() -> impl Strategy<Value = (Pose, Pose)> {
    let place = || (-2_000.0..2_000.0f64, -2_000.0..2_000.0f64, -PI..PI);
    (place(), place()).prop_map(|(a, b)| (pose(a.0, a.1, a.2), pose(b.0, b.1, b.2)))
}

fn robots() -> impl Strategy<Value = Robot> {
    let turning = prop_oneof![Just(Turning::Clockwise), Just(Turning::Counterclockwise)];
    (30.0..400.0f64, turning).prop_map(|(radius_um, turning)| robot(radius_um, turning))
}

fn exact(pose: Pose) -> PoseWithin {
    PoseWithin { pose, slack: Precision { place_um: 0.0, heading_rad: 0.0 } }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn ways_end_at_their_goals_and_none_is_shorter(robot in robots(), (from, to) in poses()) {
        for word in words(&robot, from, to) {
            let (place_um, heading_rad) = off(end(&robot, from, &word.segments(robot.turning_radius_um)), to);
            prop_assert!(place_um < 1e-5 && heading_rad < 1e-8, "{word:?} {place_um} {heading_rad}");
        }
        let (found_um, brute_um) = (distance_um(&robot, from, to), brute_um(&robot, from, to));
        // Of the arc's directions, one lies within 4π/480 of the best one.
        prop_assert!(found_um <= brute_um + 1e-6 && brute_um <= found_um * 1.001, "{found_um} {brute_um}");
    }

    #[test]
    fn the_bound_holds_for_every_goal_within_the_slack(
        robot in robots(),
        (from, to) in poses(),
        (turn, share, heading) in (0.0..TAU, 0.0..1.0f64, -1.0..1.0f64),
    ) {
        for slack in [Precision { place_um: 0.5, heading_rad: 0.01 }, Precision { place_um: 300.0, heading_rad: 0.5 }] {
            let other = Pose {
                x_um: to.x_um + slack.place_um * share * turn.cos(),
                y_um: to.y_um + slack.place_um * share * turn.sin(),
                heading_rad: to.heading_rad + slack.heading_rad * heading,
            };
            let word = words(&robot, from, other)[0];
            let loose = |pose: Pose| PoseWithin { pose, slack };
            for (before, after) in [(exact(from), loose(to)), (loose(from), exact(other)), (loose(from), loose(to))] {
                let least_um = least_um(&robot, before, after);
                prop_assert!(least_um <= word.length_um(robot.turning_radius_um) + 1e-6, "{least_um} {word:?}");
            }
            let back = words(&robot, other, from)[0].length_um(robot.turning_radius_um);
            prop_assert!(least_um(&robot, loose(to), exact(from)) <= back + 1e-6);
            let segments = word.segments(robot.turning_radius_um).len();
            prop_assert!(fewest_segments(&robot, from, to, slack) <= segments);
        }
        let (least_um, best_um) = (least_um(&robot, exact(from), exact(to)), distance_um(&robot, from, to));
        prop_assert!(least_um <= best_um + 1e-6 && best_um - least_um < 0.5, "{least_um} {best_um}");
    }
}
