//! The shortest path of one robot between two poses without obstacles (a one-sided Dubins path).
//!
//! Problem: a robot runs straight (arm up) or turns to one side, always the same, on a circle of radius r (arm down).
//!
//! Method: consider the centre of its turning circle. While the robot turns, the centre rests; while it runs straight,
//! the centre moves along the heading. So a path is a polyline from the first centre c0 to the last one c1; its edges
//! are run with the heading at that time, the turns happen at its corners, and it costs its length + r × the total
//! turning angle T. Headings only change in one sense, so T = T0 + 2πk, where T0 in [0, 2π) is the angle from the first
//! heading to the last one. Let d = c1 − c0.
//!
//! For given T the edges express d as a sum of vectors whose directions lie in the arc of headings that the turn
//! sweeps, and every order of headings along the arc is a path. The least sum of lengths is the gauge of d with respect
//! to the convex hull of that arc of the unit circle and the origin:
//! - d points into the arc: |d| by one edge, which is least, since no sum is below |d|. That is turn–straight–turn.
//! - d points beside the arc, and T0 > π: the hull is bounded there by the chord between the first and the last
//!   heading, and the least sum uses these two only. That is straight–turn–straight.
//! - d points beside the arc, and T0 ≤ π: d is no such sum. (At T0 = π the arc is a closed half-circle, and d points to
//!   its other side.)
//! - k ≥ 1: the arc is the whole circle, |d| by one edge; k = 1 is the cheapest of these.
//!
//! So the optimum is turn–straight–turn with T = T0 if d points into the arc, and otherwise the better of
//! straight–turn–straight with T0 (if T0 > π) and turn–straight–turn with T0 + 2π. Shorter words are these with zeros
//! in them. Everything has a closed form.
//!
//! Promise: the path ends at the goal up to [`SLACK_UM`] and [`SLACK_RAD`]. Without these slacks, rounding could cost a
//! full circle for a goal exactly ahead.

use crate::claims::microrobots::Precision;
use crate::device::microrobots::{Arm, Robot};
use crate::geometry::Pose;
use crate::real::Real;
use std::f64::consts::{PI, TAU};

/// Lateral miss of the goal that is tolerated to save a turn.
pub const SLACK_UM: f64 = 1e-6;

/// The same for headings.
pub const SLACK_RAD: f64 = 1e-9;

/// A segment of a robot's path with its arm in one position.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ArmSegment {
    pub arm: Arm,
    /// Path length of its centre, at least 0.
    pub way_um: f64,
}

/// A path of at most five segments: turn, run, turn, run, turn.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct DubinsWord {
    pub turns_rad: [f64; 3],
    pub runs_um: [f64; 2],
}

impl DubinsWord {
    /// Path length of the centre of a robot with this turning radius.
    pub fn length_um(&self, radius_um: f64) -> f64 {
        self.runs_um[0] + self.runs_um[1] + radius_um * (self.turns_rad[0] + self.turns_rad[1] + self.turns_rad[2])
    }

    /// The segments that are not empty; adjacent ones with the same arm position are merged.
    pub fn segments(&self, radius_um: f64) -> Vec<ArmSegment> {
        let turn = |index: usize| ArmSegment { arm: Arm::Down, way_um: radius_um * self.turns_rad[index] };
        let run = |index: usize| ArmSegment { arm: Arm::Up, way_um: self.runs_um[index] };
        joined([turn(0), run(0), turn(1), run(1), turn(2)])
    }
}

/// The same path without empty segments; adjacent ones with the same arm position are merged.
pub fn joined(segments: impl IntoIterator<Item = ArmSegment>) -> Vec<ArmSegment> {
    let mut kept: Vec<ArmSegment> = Vec::new();
    for segment in segments.into_iter().filter(|segment| segment.way_um > 0.0) {
        match kept.last_mut() {
            Some(last) if last.arm == segment.arm => last.way_um += segment.way_um,
            Some(_) | None => kept.push(segment),
        }
    }
    kept
}

/// Length of a path.
pub fn length_um(way: &[ArmSegment]) -> f64 {
    way.iter().map(|segment| segment.way_um).sum()
}

/// A shortest path.
pub fn shortest(robot: &Robot, from: Pose, to: Pose) -> Vec<ArmSegment> {
    words(robot, from, to)[0].segments(robot.turning_radius_um)
}

/// Length of a shortest path.
pub fn distance_um(robot: &Robot, from: Pose, to: Pose) -> f64 {
    distance_about_um(robot, CentredPose::of(robot, from), CentredPose::of(robot, to))
}

/// Length of a shortest path between poses that are given by their turning centres.
pub fn distance_about_um(robot: &Robot, from: CentredPose, to: CentredPose) -> f64 {
    MirroredJourney::new(robot, from, to).words()[0].length_um(robot.turning_radius_um)
}

/// A pose by its turning centre.
#[derive(Debug, Clone, Copy)]
pub struct CentredPose {
    pub centre_um: [f64; 2],
    pub heading_rad: f64,
    /// Cosine and sine of the heading.
    pub axis: [f64; 2],
}

impl CentredPose {
    pub fn of(robot: &Robot, pose: Pose) -> CentredPose {
        let (sin, cos) = pose.heading_rad.sine_cosine();
        let axis = [cos, sin];
        CentredPose { centre_um: robot.orbit_centre_facing_um(pose, axis), heading_rad: pose.heading_rad, axis }
    }
}

/// The paths without a needless edge, the shortest first: turn–straight–turn, and straight–turn–straight. If the latter
/// does not exist, both entries are the former.
pub fn words(robot: &Robot, from: Pose, to: Pose) -> [DubinsWord; 2] {
    MirroredJourney::new(robot, CentredPose::of(robot, from), CentredPose::of(robot, to)).words()
}

/// Angle from one heading to another in the robot's turning sense, in [0, 2π); almost 2π counts as 0.
pub fn turn_rad(robot: &Robot, from_rad: f64, to_rad: f64) -> f64 {
    snapped((robot.turning.sign() * (to_rad - from_rad)).rem_euclid(TAU), SLACK_RAD)
}

fn snapped(turn_rad: f64, slack_rad: f64) -> f64 {
    if turn_rad >= TAU - slack_rad { 0.0 } else { turn_rad }
}

/// Start and goal in terms of the turning centres, mirrored so that headings increase while the robot turns.
struct MirroredJourney {
    radius_um: f64,
    /// From the first centre to the last one, in the frame of the first heading.
    along_um: [f64; 2],
    distance_um: f64,
    /// Angle from the first heading to the direction of the last centre.
    aim_rad: f64,
    /// T0 of the module's documentation.
    turn_rad: f64,
}

impl MirroredJourney {
    fn new(robot: &Robot, from: CentredPose, to: CentredPose) -> Self {
        let [cos, sin] = from.axis;
        let [dx, dy] = [0, 1].map(|axis| to.centre_um[axis] - from.centre_um[axis]);
        let along_um = [dx * cos + dy * sin, robot.turning.sign() * (dy * cos - dx * sin)];
        let distance_um = along_um[0].hypotenuse(along_um[1]);
        let aim_rad = along_um[1].arc_tangent_over(along_um[0]).rem_euclid(TAU);
        let turn_rad = turn_rad(robot, from.heading_rad, to.heading_rad);
        MirroredJourney { radius_um: robot.turning_radius_um, along_um, distance_um, aim_rad, turn_rad }
    }

    /// See [`words`].
    fn words(&self) -> [DubinsWord; 2] {
        let one = self.turn_run_turn();
        match self.run_turn_run() {
            None => [one, one],
            Some(other) if other.length_um(self.radius_um) < one.length_um(self.radius_um) => [other, one],
            Some(other) => [one, other],
        }
    }

    fn turn_run_turn(&self) -> DubinsWord {
        if self.distance_um <= SLACK_UM {
            return DubinsWord { turns_rad: [self.turn_rad, 0.0, 0.0], runs_um: [0.0; 2] };
        }
        let slack_rad = SLACK_RAD.max(SLACK_UM / self.distance_um);
        let aim_rad = snapped(self.aim_rad, slack_rad);
        let (first_rad, all_rad) = if aim_rad <= self.turn_rad + slack_rad {
            (aim_rad.min(self.turn_rad), self.turn_rad)
        } else {
            (aim_rad, self.turn_rad + TAU)
        };
        DubinsWord { turns_rad: [first_rad, all_rad - first_rad, 0.0], runs_um: [self.distance_um, 0.0] }
    }

    fn run_turn_run(&self) -> Option<DubinsWord> {
        let (sin, cos) = self.turn_rad.sine_cosine();
        let last_um = self.along_um[1] / sin;
        let first_um = self.along_um[0] - last_um * cos;
        let holds = sin.abs() > SLACK_RAD && first_um >= 0.0 && last_um >= 0.0;
        holds.then_some(DubinsWord { turns_rad: [0.0, self.turn_rad, 0.0], runs_um: [first_um, last_um] })
    }
}

/// Lower bounds on every path from a pose within a slack of one pose to a pose within a slack of another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LeastWays {
    /// Least and greatest turn without a full circle, in micrometres of path; every path turns by an amount between
    /// them, plus whole circles. The least may be negative: then there is a path that turns by nearly nothing.
    pub turn_um: [f64; 2],
    /// Path length of one full circle.
    pub circle_um: f64,
    /// Least straight travel of a path without an additional full circle; infinite if there is none.
    pub direct_um: f64,
    /// Least straight travel of any path.
    pub run_um: f64,
}

impl LeastWays {
    /// Least length of a path that turns by this many additional full circles; infinite if there is none.
    pub fn length_um(&self, circles: u64) -> f64 {
        let run_um = if circles == 0 { self.direct_um } else { self.run_um };
        run_um + (self.turn_um[0] + self.circle_um * circles as f64).max(0.0)
    }
}

/// A pose with its tolerance.
#[derive(Debug, Clone, Copy)]
pub struct PoseWithin {
    pub pose: Pose,
    pub slack: Precision,
}

/// Lower bound on the length of any path from a pose within a slack of the first to a pose within a slack of the second.
pub fn least_um(robot: &Robot, from: PoseWithin, to: PoseWithin) -> f64 {
    let ways = least_ways(robot, from, to);
    ways.length_um(0).min(ways.length_um(1))
}

/// The optimum of the module's documentation with every quantity at its cheapest within the slacks: each centre lies
/// within place + r × heading of the pose's own, and the frame of the first heading may be rotated by its slack.
pub fn least_ways(robot: &Robot, from: PoseWithin, to: PoseWithin) -> LeastWays {
    let (journey, before, after) = (
        MirroredJourney::new(robot, CentredPose::of(robot, from.pose), CentredPose::of(robot, to.pose)),
        from.slack,
        to.slack,
    );
    let off_rad = before.heading_rad + after.heading_rad + SLACK_RAD;
    let off_um = before.place_um + after.place_um + journey.radius_um * off_rad + SLACK_UM;
    let is_nearly_round = journey.turn_rad >= TAU - off_rad;
    let middle_rad = if is_nearly_round { journey.turn_rad - TAU } else { journey.turn_rad };
    let run_um = (journey.distance_um - off_um).max(0.0);
    let direct_um = if is_nearly_round { run_um } else { journey.direct_um(before, off_rad, off_um, run_um) };
    LeastWays {
        turn_um: [middle_rad - off_rad, middle_rad + off_rad].map(|turn_rad| journey.radius_um * turn_rad),
        circle_um: TAU * journey.radius_um,
        direct_um,
        run_um,
    }
}

impl MirroredJourney {
    /// Least straight travel without an additional full circle.
    fn direct_um(&self, before: Precision, off_rad: f64, off_um: f64, run_um: f64) -> f64 {
        if run_um == 0.0 {
            return run_um;
        }
        let spread_rad = (off_um / self.distance_um).arc_sine() + before.heading_rad;
        let is_ahead = self.aim_rad - spread_rad <= self.turn_rad + off_rad || self.aim_rad + spread_rad >= TAU;
        if is_ahead {
            run_um
        } else if self.turn_rad + off_rad <= PI {
            f64::INFINITY
        } else {
            self.chord_um(off_um, off_rad, before.heading_rad).max(run_um)
        }
    }

    /// Least sum of two edges along the first and the last heading, up to `off_um`, in a frame that may be rotated. The
    /// chord's normal bisects the gap between the two headings, and the sum is the component of d along it / the cosine
    /// of half the gap.
    fn chord_um(&self, off_um: f64, off_rad: f64, tilt_rad: f64) -> f64 {
        let middle_rad = (self.turn_rad + TAU) / 2.0;
        let (sin, cos) = middle_rad.sine_cosine();
        let swing_um = self.distance_um * (off_rad / 2.0 + tilt_rad);
        let part_um = self.along_um[0] * cos + self.along_um[1] * sin - off_um - swing_um;
        let gap_rad = (TAU - self.turn_rad - off_rad).max(0.0);
        part_um / (gap_rad / 2.0).cosine()
    }
}

/// Least number of segments of any path that ends within `slack` of the goal.
pub fn fewest_segments(robot: &Robot, from: Pose, to: Pose, slack: Precision) -> usize {
    let journey = MirroredJourney::new(robot, CentredPose::of(robot, from), CentredPose::of(robot, to));
    let off_um = slack.place_um + journey.radius_um * slack.heading_rad;
    let straight = journey.turn_rad <= slack.heading_rad || journey.turn_rad >= TAU - slack.heading_rad;
    let (sin, cos) = journey.turn_rad.sine_cosine();
    let [along_um, aside_um] = journey.along_um;
    let on_first = aside_um.abs() <= off_um;
    let on_last = (aside_um * cos - along_um * sin).abs() <= off_um + journey.distance_um * slack.heading_rad;
    let there = (from.x_um - to.x_um).hypotenuse(from.y_um - to.y_um) <= slack.place_um;
    if straight && there {
        0
    } else if journey.distance_um <= off_um || (straight && on_first) {
        1
    } else if on_first || on_last {
        2
    } else {
        3
    }
}

#[cfg(test)]
mod tests;
