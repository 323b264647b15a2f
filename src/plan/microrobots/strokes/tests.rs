//! Paths in whole strokes end within the precision.

use super::*;
use crate::device::microrobots::{Arm, Turning};
use crate::plan::microrobots::free::{self, joined, length_um};
use crate::plan::microrobots::world::fixture;
use proptest::prelude::*;
use std::f64::consts::TAU;

const PRECISION: Precision = Precision { place_um: 0.5, heading_rad: 0.5 * TAU / 360.0 };

fn robot(radius_um: f64, step_um: f64, turning: Turning) -> Robot {
    Robot { turning, ..fixture::robot("D1", radius_um, step_um) }
}

fn robots() -> impl Strategy<Value = Robot> {
    let turning = prop_oneof![Just(Turning::Clockwise), Just(Turning::Counterclockwise)];
    (30.0..400.0f64, 0.01..0.02f64, turning)
        .prop_map(|(radius_um, step_um, turning)| robot(radius_um, step_um, turning))
}

fn pose() -> impl Strategy<Value = Pose> {
    (-10_000.0..10_000.0f64, -10_000.0..10_000.0f64, -180.0..180.0f64).prop_map(|(x, y, deg)| fixture::pose(x, y, deg))
}

fn missed(robot: &Robot, from: Pose, goal: Pose, trains: &[StrokeTrain]) -> (f64, f64) {
    let end = end(robot, from, trains);
    ((end.x_um - goal.x_um).hypot(end.y_um - goal.y_um), wrapped_rad(end.heading_rad - goal.heading_rad).abs())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_000, failure_persistence: None, ..ProptestConfig::default() })]

    /// The goal is near to where one or two trains end.
    #[test]
    fn short_drives_are_found_where_there_are_some(
        robot in robots(), from in pose(), turn in 0u64..60_000, run in 0u64..200_000, kind in 0usize..4, off in (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64),
    ) {
        let precision = Precision { place_um: 20.0, heading_rad: 2.0 * TAU / 360.0 };
        let [turned, ran] = [(Arm::Down, turn), (Arm::Up, run)].map(|(arm, strokes)| StrokeTrain { arm, strokes });
        let known = [vec![turned, ran], vec![ran, turned], vec![turned], vec![ran]][kind].clone();
        let end_there = end(&robot, from, &known);
        // The goal may lie to the side of a run.
        let goal = Pose {
            x_um: end_there.x_um + off.0 * precision.place_um / 2.0,
            y_um: end_there.y_um + off.1 * precision.place_um / 2.0,
            heading_rad: end_there.heading_rad + off.2 * precision.heading_rad * 0.9,
        };
        let found = short(&robot, from, goal, precision);
        prop_assert!(found.iter().all(|trains| is_within(end(&robot, from, trains), goal, precision) && trains.len() <= 2));
        let strokes = |trains: &[StrokeTrain]| trains.iter().map(|train| train.strokes).sum::<u64>() as f64 * robot.step_um;
        let most_um = strokes(&known) + 2.0 * precision.place_um + 3.0 * robot.turning_radius_um * precision.heading_rad;
        // A turn of nearly nothing may become a full one: only a heading equal to the goal's needs none.
        let is_clear = turn as f64 * robot.step_um / robot.turning_radius_um > 3.0 * precision.heading_rad;
        if is_clear || kind == 3 {
            prop_assert!(found.iter().any(|trains| strokes(trains) <= most_um), "{known:?} {found:?} {goal:?}");
        }
    }

    #[test]
    fn shortest_ways_end_at_their_goals(robot in robots(), from in pose(), far in pose(), near in pose()) {
        let beside = Pose { x_um: from.x_um + near.x_um / 50.0, y_um: from.y_um + near.y_um / 50.0, ..near };
        let beneath = Pose { x_um: from.x_um + near.x_um / 1e5, y_um: from.y_um + near.y_um / 1e5, ..from };
        for goal in [far, beside, beneath] {
            for word in free::words(&robot, from, goal) {
                let way = word.segments(robot.turning_radius_um);
                let trains = whole(&robot, from, goal, &way, PRECISION);
                prop_assert!(trains.is_some(), "{way:?}");
                let trains = trains.unwrap();
                let (place_um, heading_rad) = missed(&robot, from, goal, &trains);
                prop_assert!(place_um < 0.08 && heading_rad < 1e-3, "{place_um} {heading_rad} {way:?} {trains:?}");
                prop_assert!(trains.len() <= way.len() + 4, "{way:?} {trains:?}");
                let strokes: u64 = trains.iter().map(|train| train.strokes).sum();
                let extra_um = strokes as f64 * robot.step_um - length_um(&way);
                // An edge in two parts, half a stroke of turning to either side, is longer by half of that angle
                // squared.
                let bent_um = length_um(&way) * (robot.step_um / robot.turning_radius_um).powi(2) / 8.0;
                let rounded_um = robot.step_um * trains.len() as f64 + 0.1;
                prop_assert!(extra_um.abs() < rounded_um + bent_um, "{extra_um} {bent_um} {way:?}");
            }
        }
    }

    #[test]
    fn long_ways_with_many_corners_end_at_their_goals(
        robot in robots(),
        from in pose(),
        parts in prop::collection::vec((0.0..4_000.0f64, 0.0..3.0f64), 1..8),
    ) {
        let both = |(run_um, turn_rad): &(f64, f64)| {
            [(Arm::Down, turn_rad * robot.turning_radius_um), (Arm::Up, *run_um)].map(|(arm, way_um)| ArmSegment { arm, way_um })
        };
        let way = joined(parts.iter().flat_map(both));
        let goal = way.iter().fold(from, |pose, segment| robot.moved(pose, segment.arm, segment.way_um));
        let trains = whole(&robot, from, goal, &way, PRECISION);
        prop_assert!(trains.is_some(), "{way:?}");
        let (place_um, heading_rad) = missed(&robot, from, goal, &trains.unwrap());
        prop_assert!(place_um < 0.2 && heading_rad < 1e-3, "{place_um} {heading_rad} {way:?}");
    }
}

#[test]
fn a_precision_below_a_stroke_is_not_promised() {
    let robot = robot(200.0, 0.02, Turning::Clockwise);
    let (from, goal) = (Pose::at(0.0, 0.0), Pose::at(1_000.009, 0.0));
    let way = free::shortest(&robot, from, goal);
    let within = |place_um: f64| whole(&robot, from, goal, &way, Precision { place_um, ..PRECISION }).is_some();
    assert!(within(0.02) && !within(0.001));
    assert_eq!(whole(&robot, from, from, &[], PRECISION), Some(Vec::new()));
}

#[test]
fn a_heading_has_a_precision_of_its_own() {
    let goal = fixture::pose(10.0, 20.0, 179.9);
    let within = |x_um: f64, degrees: f64| is_within(fixture::pose(x_um, 20.0, degrees), goal, PRECISION);
    assert!(within(10.0, 179.9) && within(10.49, 179.5) && within(10.0, -179.7), "up to 0.5 um and 0.5 deg");
    assert!(!within(10.51, 179.9) && !within(10.0, 179.3) && !within(10.0, -179.5) && !within(10.0, 0.0));
}
