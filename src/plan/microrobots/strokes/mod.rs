//! Rounding of a path to whole strokes.
//!
//! Problem: a stroke moves a robot by some nanometres and turns it by step / radius; a heading that is off by half of
//! that is off by micrometres at the end of a long leg.
//!
//! Method: as in `free`, the path is the polyline of the centres of the robot's turning circle, and its headings are
//! counted in strokes of turning. Edge by edge, the polyline's next corner is aimed at from the robot's exact position,
//! so errors do not accumulate. An edge whose rounded heading would miss its corner by too much is run in two parts
//! with one stroke of turning between them: the two neighbouring headings span every direction between them, so only
//! the rounding of their lengths remains. The last corner is that of the rounded last heading.
//!
//! Promise: the end is within the given precision of the goal, or nothing is returned; it is computed from the robot's
//! exact steps. The path differs from the given one by less than [`ASTRAY`] of the precision at its corners, apart from
//! rounding of single strokes.

use super::free::{ArmSegment, turn_rad};
use crate::claims::microrobots::Precision;
use crate::device::microrobots::{Arm, Robot, wrapped_rad};
use crate::geometry::Pose;
use crate::real::Real;
use std::f64::consts::{FRAC_PI_2, PI};

/// Share of the precision that one rounded heading may cost at the goal.
const AT_GOAL: f64 = 0.08;

/// Share of the precision at which no better rounding is sought.
const GOOD: f64 = 0.15;

/// Share of the precision by which a path may miss its corners.
pub const ASTRAY: f64 = 0.5;

/// Strokes of turning by which an edge may be rotated to compensate for the previous one.
const MOST_CORRECTION: f64 = 200.0;

/// Strokes with the arm in one position.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StrokeTrain {
    pub arm: Arm,
    /// At least 1.
    pub strokes: u64,
}

impl StrokeTrain {
    /// Its path.
    pub fn segment(self, robot: &Robot) -> ArmSegment {
        ArmSegment { arm: self.arm, way_um: robot.step_um * self.strokes as f64 }
    }
}

/// Pose of a robot after its trains.
pub fn end(robot: &Robot, from: Pose, trains: &[StrokeTrain]) -> Pose {
    trains.iter().fold(from, |pose, train| robot.moved(pose, train.arm, train.segment(robot).way_um))
}

/// Distance of a pose from a goal; headings are ignored.
fn missed_um(pose: Pose, goal: Pose) -> f64 {
    (pose.x_um - goal.x_um).hypotenuse(pose.y_um - goal.y_um)
}

/// Whether a pose is within the precision of another.
pub fn is_within(pose: Pose, goal: Pose, precision: Precision) -> bool {
    missed_um(pose, goal) <= precision.place_um
        && wrapped_rad(pose.heading_rad - goal.heading_rad).abs() <= precision.heading_rad
}

/// A path to a goal in whole strokes; `None` if its end is not within the precision, as with a precision below a stroke.
pub fn whole(
    robot: &Robot,
    from: Pose,
    goal: Pose,
    way: &[ArmSegment],
    precision: Precision,
) -> Option<Vec<StrokeTrain>> {
    let edges = edges(robot, way);
    let turned = edges.turned.round();
    // After rounding, an edge may need one stroke of turning more than the last heading.
    let choices = [(ASTRAY, turned), (ASTRAY, turned + 1.0), (0.0, turned), (0.0, turned + 1.0)];
    let mut best: Option<(f64, Vec<StrokeTrain>)> = None;
    for (astray, turned) in choices {
        let mut rounding = Rounding::new(robot, from, turned);
        let tolerances_um = [AT_GOAL, astray].map(|share| share * precision.place_um);
        rounding.follow(&edges, rounding.middle_of(goal, turned), tolerances_um);
        rounding.turn_to(turned);
        let end = end(robot, from, &rounding.trains);
        let missed_um = missed_um(end, goal);
        if is_within(end, goal, precision) && best.as_ref().is_none_or(|(least_um, _)| missed_um < *least_um) {
            best = Some((missed_um, rounding.trains));
        }
        if best.as_ref().is_some_and(|(least_um, _)| *least_um <= GOOD * precision.place_um) {
            break;
        }
    }
    best.map(|(_, trains)| trains)
}

/// Number of headings, on each side of the goal's, that are tried for the end of a short drive.
const HEADINGS: i32 = 16;

/// Drives of one or two trains that end within the precision of a goal: a turn and then a run, or a run and then a
/// turn, with up to half a turn or with more, each where it ends nearest to the goal. Empty if no such drive reaches
/// the goal.
///
/// Where the goal itself needs three trains or a full turn, one or two trains often end within the precision of it.
pub fn short(robot: &Robot, from: Pose, goal: Pose, precision: Precision) -> Vec<Vec<StrokeTrain>> {
    let offsets = (-HEADINGS..=HEADINGS).map(|at| precision.heading_rad * f64::from(at) / f64::from(HEADINGS));
    let mut headings: Vec<f64> = offsets.map(|off_rad| goal.heading_rad + off_rad).collect();
    headings.push(from.heading_rad);
    // Indexed by the order of the trains and by whether the turn is more than half a turn.
    let mut found: [Option<(f64, Vec<StrokeTrain>)>; 4] = [const { None }; 4];
    for heading_rad in headings {
        let turn_um = turn_rad(robot, from.heading_rad, heading_rad) * robot.turning_radius_um;
        let is_long = usize::from(turn_um > PI * robot.turning_radius_um);
        for (which, order) in [[Arm::Down, Arm::Up], [Arm::Up, Arm::Down]].into_iter().enumerate() {
            let trains = turn_and_run(robot, from, goal, turn_um, order);
            let end = end(robot, from, &trains);
            let missed_um = missed_um(end, goal);
            let best = &mut found[2 * which + is_long];
            let is_nearer = best.as_ref().is_none_or(|(least_um, _)| missed_um < *least_um);
            if is_nearer && is_within(end, goal, precision) {
                *best = Some((missed_um, trains));
            }
        }
    }
    let mut found: Vec<Vec<StrokeTrain>> = found.into_iter().flatten().map(|(_, trains)| trains).collect();
    found.dedup();
    found
}

/// A turn of this length and a run, in this order, that end as near to a goal as they can. A train shorter than a
/// stroke is left out.
fn turn_and_run(robot: &Robot, from: Pose, goal: Pose, turn_um: f64, order: [Arm; 2]) -> Vec<StrokeTrain> {
    let turn = (turn_um / robot.step_um).round();
    let turned = robot.moved(from, Arm::Down, turn * robot.step_um);
    let (sin, cos) = if order[0] == Arm::Down { turned } else { from }.heading_rad.sine_cosine();
    let ahead_um = (goal.x_um - turned.x_um) * cos + (goal.y_um - turned.y_um) * sin;
    let run = (ahead_um / robot.step_um).round().max(0.0);
    let strokes = |arm: Arm| if arm == Arm::Down { turn } else { run };
    let trains = order.map(|arm| StrokeTrain { arm, strokes: strokes(arm) as u64 });
    trains.into_iter().filter(|train| train.strokes > 0).collect()
}

/// A path as a polyline of turning centres.
struct PolylineEdges {
    /// Strokes of turning before each edge, and its length.
    edges: Vec<(f64, f64)>,
    /// Total strokes of turning.
    turned: f64,
}

fn edges(robot: &Robot, way: &[ArmSegment]) -> PolylineEdges {
    let mut found = PolylineEdges { edges: Vec::new(), turned: 0.0 };
    for segment in way {
        match segment.arm {
            Arm::Down => found.turned += segment.way_um / robot.step_um,
            Arm::Up => found.edges.push((found.turned, segment.way_um)),
        }
    }
    found
}

/// State of the rounding of a path.
struct Rounding<'a> {
    robot: &'a Robot,
    from: Pose,
    /// Current turning centre.
    middle_um: [f64; 2],
    /// Strokes of turning so far: a whole number.
    turned: f64,
    /// Most strokes of turning of any edge.
    most: f64,
    trains: Vec<StrokeTrain>,
}

impl<'a> Rounding<'a> {
    fn new(robot: &'a Robot, from: Pose, most: f64) -> Self {
        let middle_um = robot.orbit_centre_um(from);
        Rounding { robot, from, middle_um, turned: 0.0, most, trains: Vec::new() }
    }

    fn heading_rad(&self, turned: f64) -> f64 {
        self.from.heading_rad + self.robot.turning.sign() * turned * self.robot.step_um / self.robot.turning_radius_um
    }

    fn unit(&self, turned: f64) -> [f64; 2] {
        let (sin, cos) = self.heading_rad(turned).sine_cosine();
        [cos, sin]
    }

    /// Turning centre at a goal that is reached with a rounded heading.
    fn middle_of(&self, goal: Pose, turned: f64) -> [f64; 2] {
        self.robot.orbit_centre_um(Pose { heading_rad: self.heading_rad(turned), ..goal })
    }

    /// Follows the edges to the last centre; the tolerances are that of the last corner and that of the others.
    fn follow(&mut self, edges: &PolylineEdges, goal_um: [f64; 2], [goal_tolerance_um, tolerance_um]: [f64; 2]) {
        let mut corner_um = self.middle_um;
        for (index, (turned, length_um)) in edges.edges.iter().enumerate() {
            let unit = self.unit(*turned);
            corner_um = [0, 1].map(|axis| corner_um[axis] + length_um * unit[axis]);
            match edges.edges.get(index + 1) {
                None => self.run_to(goal_um, *turned, goal_tolerance_um),
                // The miss at a corner must not reverse the next edge.
                Some((later, next_um)) => {
                    let room = (later - turned).clamp(1.0, MOST_CORRECTION) / 4.0;
                    let swing_um = next_um * room * self.robot.step_um / self.robot.turning_radius_um;
                    self.run_to(corner_um, *turned, tolerance_um.min(swing_um));
                }
            }
        }
    }

    /// Runs to a corner with a heading near the planned one.
    fn run_to(&mut self, corner_um: [f64; 2], planned: f64, tolerance_um: f64) {
        let [dx, dy] = [0, 1].map(|axis| corner_um[axis] - self.middle_um[axis]);
        let stroke_rad = self.robot.step_um / self.robot.turning_radius_um;
        let off_rad = wrapped_rad(self.robot.turning.sign() * (dy.arc_tangent_over(dx) - self.heading_rad(planned)));
        if off_rad.abs() > FRAC_PI_2 || dx.hypotenuse(dy) < self.robot.step_um / 2.0 {
            return;
        }
        let aim = (planned + off_rad / stroke_rad).min(self.most).max(self.turned);
        let nearest = aim.round();
        let unit = self.unit(nearest);
        let missed_um = (dx * unit[1] - dy * unit[0]).abs();
        if missed_um <= tolerance_um || aim == self.turned || aim == self.most {
            return self.run(nearest, dx * unit[0] + dy * unit[1]);
        }
        let [low, high] = [self.unit(aim.floor()), self.unit(aim.floor() + 1.0)];
        let second_um = (low[0] * dy - low[1] * dx) / (low[0] * high[1] - low[1] * high[0]);
        let second_um = (second_um / self.robot.step_um).round().max(0.0) * self.robot.step_um;
        let first_um = (dx - second_um * high[0]) * low[0] + (dy - second_um * high[1]) * low[1];
        self.run(aim.floor(), first_um);
        self.run(aim.floor() + 1.0, second_um);
    }

    /// Runs straight with a heading.
    fn run(&mut self, turned: f64, way_um: f64) {
        let strokes = (way_um / self.robot.step_um).round();
        if strokes >= 1.0 {
            self.turn_to(turned);
            let unit = self.unit(turned);
            let way_um = strokes * self.robot.step_um;
            self.middle_um = [0, 1].map(|axis| self.middle_um[axis] + way_um * unit[axis]);
            self.push(Arm::Up, strokes);
        }
    }

    fn turn_to(&mut self, turned: f64) {
        if turned > self.turned {
            self.push(Arm::Down, turned - self.turned);
            self.turned = turned;
        }
    }

    fn push(&mut self, arm: Arm, strokes: f64) {
        // The strokes of a path of a metre are far below 2^53.
        let strokes = strokes as u64;
        match self.trains.last_mut() {
            Some(last) if last.arm == arm => last.strokes += strokes,
            Some(_) | None => self.trains.push(StrokeTrain { arm, strokes }),
        }
    }
}

#[cfg(test)]
mod tests;
