//! Unit tests of the replay's modules, each compared with a simpler method.

use super::bodies::JudgedBody;
use super::motion::{RobotPlace, TrainMotion, turn_between};
use super::relay::ArmHysteresis;
use super::sweep::{Evaluations, SweptGap};
use crate::device::microrobots::{Arm, MicrorobotsFacts, Robot, Turning, fixture};
use crate::geometry::Pose;
use crate::geometry::distance::quadrilateral_core;
use crate::geometry::shape::Core;
use crate::schedule::microrobots::RecordedPose;
use nalgebra::{Point2, Vector2};
use proptest::prelude::*;
use std::f64::consts::TAU;

fn robot([snap_down_v, release_v]: [f64; 2], turning: Turning) -> Robot {
    Robot { snap_down_v, release_v, turning, ..fixture::robot("D", 130.0, 0.5) }
}

/// The positions in which the arm of a robot can end, for both extremes of both margins and from both initial
/// positions.
fn extremes(robot: &Robot, margin_v: f64, levels: &[f64]) -> Vec<Arm> {
    let signs = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)];
    let end = |((snap, release), first): ((f64, f64), Arm)| {
        levels.iter().fold(first, |arm, level_v| match *level_v {
            level_v if level_v >= robot.snap_down_v + snap * margin_v => Arm::Down,
            level_v if level_v <= robot.release_v + release * margin_v => Arm::Up,
            _ => arm,
        })
    };
    signs.into_iter().flat_map(|signs| [Arm::Up, Arm::Down].map(|first| (signs, first))).map(end).collect()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 5000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn an_arm_is_known_as_all_extremes_agree(
        (snap_down_v, gap_v, margin_v) in (60.0..180.0f64, 0.1..60.0f64, 0.0..5.0f64),
        levels in prop::collection::vec(0.0..200.0f64, 0..6),
    ) {
        let robot = robot([snap_down_v, snap_down_v - gap_v], Turning::Clockwise);
        let facts = MicrorobotsFacts { margin_v, ..fixture::facts(vec![robot.clone()]) };
        let mut hysteresis = ArmHysteresis::new(&facts);
        levels.iter().for_each(|level_v| hysteresis.visit(*level_v));
        let ends = extremes(&robot, margin_v, &levels);
        let agreed = ends.iter().all(|arm| *arm == ends[0]).then_some(ends[0]);
        if hysteresis.arms[0].is_some() {
            prop_assert_eq!(hysteresis.arms[0], agreed);
        } else if gap_v > 2.0 * margin_v {
            prop_assert_eq!(agreed, None);
        }
        prop_assert_eq!(hysteresis.unknown().is_none(), hysteresis.arms[0].is_some());
    }

    #[test]
    fn ways_are_those_of_the_usual_coordinates(
        (x_um, y_um, heading_rad) in (-1e3..1e3f64, -1e3..1e3f64, -7.0..7.0f64),
        path_um in 0.0..3000.0f64,
        is_left: bool,
        is_down: bool,
    ) {
        let turning = if is_left { Turning::Counterclockwise } else { Turning::Clockwise };
        let robot = robot([100.0, 20.0], turning);
        let pose = Pose { x_um, y_um, heading_rad };
        let (arm, curve_um) = if is_down { (Arm::Down, Some(super::curve_um(&robot))) } else { (Arm::Up, None) };
        let moved = RobotPlace::of(&pose).driven(curve_um, path_um);
        let expected = robot.moved(pose, arm, path_um);
        prop_assert!(super::near(&moved.recorded(), &RecordedPose::from(expected)));
        let [off_um, off_rad] = moved.off(&expected);
        prop_assert!(off_um < 1e-9 && off_rad < 1e-9, "{off_um} {off_rad}");
        let centre = RobotPlace::of(&pose).centre(super::curve_um(&robot));
        let [x_um, y_um] = robot.orbit_centre_um(pose);
        prop_assert!((centre - Point2::new(x_um, y_um)).norm() < 1e-9);
    }

    #[test]
    fn a_gap_is_the_distance_or_the_least_shift(
        places in [(-300.0..300.0f64, -300.0..300.0f64, 0.0..7.0f64), (-300.0..300.0f64, -300.0..300.0f64, 0.0..7.0f64)],
        sizes in [(1.0..200.0f64, 1.0..100.0f64), (1.0..200.0f64, 1.0..100.0f64)],
    ) {
        let [one, other] = [0, 1].map(|at| {
            let ((x, y, angle_rad), (length, width)) = (places[at], sizes[at]);
            JudgedBody { centre: Point2::new(x, y), along: Vector2::new(angle_rad.cos(), angle_rad.sin()), half_um: [length, width] }
        });
        let gap_um = one.gap_um(&other);
        prop_assert!((gap_um - other.gap_um(&one)).abs() < 1e-9);
        let distance = quadrilateral_core(one.vertices(), &Core::Polygon(other.vertices().to_vec()));
        prop_assert!((distance - gap_um.max(0.0)).abs() < 1e-9, "{distance} {gap_um}");
        // In every direction the projections are no farther apart than the gap, and in one they are as far.
        let best = (0..7200).map(|at| {
            let (sin, cos) = (f64::from(at) * TAU / 7200.0).sin_cos();
            let shadow = |corner: Point2<f64>| corner.x * cos + corner.y * sin;
            let low = other.vertices().map(shadow).into_iter().fold(f64::INFINITY, f64::min);
            low - one.vertices().map(shadow).into_iter().fold(f64::NEG_INFINITY, f64::max)
        });
        let best = best.fold(f64::NEG_INFINITY, f64::max);
        prop_assert!(best <= gap_um + 1e-9 && best >= gap_um - 0.5, "{best} {gap_um}");
    }

    #[test]
    fn bounds_of_a_ride_hold(
        (theta_rad, path_um, curve) in (0.0..7.0f64, 0.0..2000.0f64, prop::option::of(any::<bool>())),
        shares in [0.0..1.0f64, 0.0..1.0f64, 0.0..1.0f64],
    ) {
        let curve_um = curve.map(|is_left| if is_left { -90.0 } else { 140.0 });
        let start = RobotPlace { at: Point2::new(3.0, 4.0), theta_rad };
        let motion = TrainMotion { start, curve_um, path_um, half_um: [120.0, 30.0] };
        let mut shares = shares;
        shares.sort_by(f64::total_cmp);
        let (centre, radius_um) = motion.disc([shares[0], shares[2]]);
        for (from, to) in motion.body(shares[1]).vertices().iter().zip(motion.body(shares[2]).vertices()) {
            prop_assert!((from - centre).norm() <= radius_um + 1e-9);
            prop_assert!((from - to).norm() <= motion.travel_um() * (shares[2] - shares[1]) + 1e-9);
        }
        let (once, part) = motion.first_turn();
        prop_assert!((once.path_um - part * path_um).abs() < 1e-9);
        if let Some(curve_um) = curve_um {
            prop_assert!(once.path_um <= TAU * curve_um.abs());
            let corner = motion.body(shares[1]).vertices().map(|corner| (corner - start.centre(curve_um)).norm());
            let farthest = corner.into_iter().fold(0.0, f64::max);
            prop_assert!((farthest - motion.disc_radius_um(curve_um)).abs() < 1e-9);
        }
    }

    #[test]
    fn halving_finds_what_is_deep_enough_and_nothing_else(
        (at, width, slope) in (0.0..1.0f64, 0.01..1.0f64, 1.0..1e4f64),
        deep in prop_oneof![Just(1e-3), Just(-1e-9)],
    ) {
        let gap = SweptGap {
            at: |share: f64| 5.0 - deep + slope * (share - at).abs().min(width),
            floor: |_| f64::NEG_INFINITY,
            travel_um: slope,
        };
        let found = gap.below([0.0, 1.0], 5.0, &mut Evaluations::default()).expect("enough evaluations");
        prop_assert_eq!(found.is_some(), deep > 0.0);
        if let Some(touch) = found {
            prop_assert!(touch.gap_um < 5.0 && (touch.share - at).abs() <= 1e-3);
        }
    }
}

#[test]
fn turns_are_the_shortest() {
    for (from, to, expected) in [(0.0, 1.0, 1.0), (1.0, 0.0, -1.0), (3.0, -3.0, TAU - 6.0), (0.5, 0.5 + 7.0 * TAU, 0.0)]
    {
        assert!((turn_between(from, to) - expected).abs() < 1e-12, "{from} {to}");
    }
}
