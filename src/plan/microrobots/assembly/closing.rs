//! Paths of a given length: straight, turn, straight, turn, straight.
//!
//! Input: a robot, its start and end pose, the length of its path, and the least length of its last straight segment.
//! Output: such paths, as many as a grid of first segments gives. Promise: every path is exact up to rounding. Method:
//! given the first segment l0 and the sum of both turns (known up to full circles), the ends of the middle segment l1
//! lie on a ray whose points are known up to the last segment l2, and |w - l2 u| = P - l2 has one solution, where w is
//! the vector between the centres of the two circles, u the last heading and P the length of l1 and l2 together.

use crate::device::microrobots::{Arm, Robot};
use crate::geometry::Pose;
use crate::plan::microrobots::free::{ArmSegment, joined, length_um, turn_rad, words};
use crate::real::Real;
use std::f64::consts::TAU;

/// Number of first segments tried, evenly over the available length.
const FIRST_STRETCHES: usize = 24;

/// Increment of the straight segments of detours, as a share of the turning radius.
const STRETCH_SHARE: f64 = 0.25;

/// Numbers of full circles beyond those that the headings require: 0 to `CIRCLES - 1`.
pub const CIRCLES: usize = 4;

/// Rounding tolerance of a segment of length 0, in micrometres.
const ROUNDING_UM: f64 = 1e-6;

/// Required path.
#[derive(Debug, Clone, Copy)]
pub struct ClosingRequest {
    pub from: Pose,
    pub to: Pose,
    pub length_um: f64,
    pub least_last_um: f64,
    /// By number of full circles, whether paths with them are wanted.
    pub circles: [bool; CIRCLES],
}

/// Turn, straight, turn: the path between two poses that always exists; none of its arcs is a full circle.
pub fn turn_straight_turn(robot: &Robot, from: Pose, to: Pose) -> [ArmSegment; 3] {
    let [from_centre, to_centre] = [from, to].map(|pose| robot.orbit_centre_um(pose));
    let (dx_um, dy_um) = (to_centre[0] - from_centre[0], to_centre[1] - from_centre[1]);
    let straight_um = dx_um.hypotenuse(dy_um);
    let heading_rad = if straight_um > ROUNDING_UM { dy_um.arc_tangent_over(dx_um) } else { from.heading_rad };
    let turn_um = |from_rad, to_rad| robot.turning_radius_um * turn_rad(robot, from_rad, to_rad);
    [
        ArmSegment { arm: Arm::Down, way_um: turn_um(from.heading_rad, heading_rad) },
        ArmSegment { arm: Arm::Up, way_um: straight_um },
        ArmSegment { arm: Arm::Down, way_um: turn_um(heading_rad, to.heading_rad) },
    ]
}

/// Paths between two poses, the shortest first: straight by one of the first lengths, turn–straight–turn, straight by
/// one of the last lengths.
pub fn detours(robot: &Robot, from: Pose, to: Pose, firsts_um: &[f64], lasts_um: &[f64]) -> Vec<Vec<ArmSegment>> {
    let way = |first_um: f64, last_um: f64| {
        let [leave, arrive] = [robot.moved(from, Arm::Up, first_um), robot.moved(to, Arm::Up, -last_um)];
        let run = |way_um| ArmSegment { arm: Arm::Up, way_um };
        let middle = turn_straight_turn(robot, leave, arrive);
        [run(first_um)].into_iter().chain(middle).chain([run(last_um)]).collect::<Vec<ArmSegment>>()
    };
    let mut ways: Vec<Vec<ArmSegment>> = firsts_um
        .iter()
        .flat_map(|&first_um| lasts_um.iter().map(move |&last_um| (first_um, last_um)))
        .map(|(a, b)| way(a, b))
        .collect();
    ways.sort_by(|a, b| length_um(a).total_cmp(&length_um(b)));
    ways
}

/// Lengths from 0 on, in increments of a share of the robot's turning radius.
pub fn stretches(robot: &Robot, count: usize) -> Vec<f64> {
    (0..count).map(|index| index as f64 * STRETCH_SHARE * robot.turning_radius_um).collect()
}

/// Sum of all turns of a path between two poses, with `circles` full circles beyond those that the headings require.
pub fn turned_rad(robot: &Robot, [from, to]: [Pose; 2], circles: usize) -> f64 {
    turn_rad(robot, from.heading_rad, to.heading_rad) + TAU * circles as f64
}

/// The paths without a needless edge, with or without full circles at their start, whose length is the required one up
/// to a slack. They are limits of [`closings`] in which segments are empty and no segment may be any longer.
pub fn shortest_of_length(robot: &Robot, asked: &ClosingRequest, slack_um: f64) -> Vec<Vec<ArmSegment>> {
    let circle_um = TAU * robot.turning_radius_um;
    let with_circles = |way: &[ArmSegment], circles: usize| {
        let circles = ArmSegment { arm: Arm::Down, way_um: circle_um * circles as f64 };
        joined([circles].into_iter().chain(way.iter().copied()))
    };
    let last_um = |way: &[ArmSegment]| way.last().filter(|last| last.arm == Arm::Up).map_or(0.0, |last| last.way_um);
    let fits = |way: &Vec<ArmSegment>| {
        (length_um(way) - asked.length_um).abs() <= slack_um && last_um(way) >= asked.least_last_um - slack_um
    };
    let ways = words(robot, asked.from, asked.to).map(|word| word.segments(robot.turning_radius_um));
    let mut found: Vec<Vec<ArmSegment>> = Vec::new();
    for way in ways.iter().flat_map(|way| (0..CIRCLES).map(|circles| with_circles(way, circles))).filter(fits) {
        if !found.contains(&way) {
            found.push(way);
        }
    }
    found
}

/// Paths of the required length: those without a first segment first, then those with few full circles.
pub fn closings(robot: &Robot, asked: &ClosingRequest) -> Vec<Vec<ArmSegment>> {
    let most_um = asked.length_um - asked.least_last_um;
    let first_um = |index: usize| most_um * index as f64 / FIRST_STRETCHES as f64;
    let wanted = || (0..CIRCLES).filter(|circles| asked.circles[*circles]);
    let circles = |index: usize| wanted().map(move |circles| (first_um(index), circles));
    let tried = (0..FIRST_STRETCHES).flat_map(circles).filter(|tried| tried.0 >= 0.0);
    tried.flat_map(|(first_um, circles)| closing(robot, asked, first_um, circles)).collect()
}

/// The paths with this first segment and number of full circles: none, one, or two that differ in the place of the
/// circles.
fn closing(robot: &Robot, asked: &ClosingRequest, first_um: f64, circles: usize) -> Vec<Vec<ArmSegment>> {
    let ClosingRequest { from, to, length_um, least_last_um, .. } = *asked;
    let [from_centre, to_centre] = [from, to].map(|pose| robot.orbit_centre_um(pose));
    let [(from_sin, from_cos), (sin, cos)] = [from, to].map(|pose| pose.heading_rad.sine_cosine());
    let dx_um = to_centre[0] - from_centre[0] - first_um * from_cos;
    let dy_um = to_centre[1] - from_centre[1] - first_um * from_sin;
    let turned_rad = turned_rad(robot, [from, to], circles);
    let radius_um = robot.turning_radius_um;
    let left_um = length_um - first_um - radius_um * turned_rad;
    let slack_um = 2.0 * (left_um - dx_um * cos - dy_um * sin);
    if left_um < dx_um.hypotenuse(dy_um) || slack_um < ROUNDING_UM {
        return Vec::new();
    }
    let last_um = (left_um * left_um - dx_um * dx_um - dy_um * dy_um) / slack_um;
    let middle_um = left_um - last_um;
    if last_um < least_last_um || middle_um < 0.0 {
        return Vec::new();
    }
    let heading_rad = (dy_um - last_um * sin).arc_tangent_over(dx_um - last_um * cos);
    let turn_rad = turn_rad(robot, from.heading_rad, heading_rad);
    let way = |first_rad: f64| {
        vec![
            ArmSegment { arm: Arm::Up, way_um: first_um },
            ArmSegment { arm: Arm::Down, way_um: radius_um * first_rad },
            ArmSegment { arm: Arm::Up, way_um: middle_um },
            ArmSegment { arm: Arm::Down, way_um: radius_um * (turned_rad - first_rad) },
            ArmSegment { arm: Arm::Up, way_um: last_um },
        ]
    };
    let turns = [turn_rad, turn_rad + TAU * circles as f64, turn_rad + TAU * circles.saturating_sub(1) as f64];
    let mut ways: Vec<Vec<ArmSegment>> = Vec::new();
    for first_rad in turns.into_iter().filter(|first_rad| *first_rad <= turned_rad) {
        let way = way(first_rad);
        if !ways.contains(&way) {
            ways.push(way);
        }
    }
    ways
}
