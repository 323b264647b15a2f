//! Motion of one robot during one leg, and the search for the first instant at which a distance is too small.

use super::{MARGIN_UM, MAX_SAMPLES, OrientedRectangle, RobotDimensions};
use crate::device::microrobots::Arm;
use crate::geometry::Pose;
use crate::geometry::distance::{Segment, segment_segment};
use crate::real::Real;
use nalgebra::Point2;

/// Most sections of an interval: beyond that its ends are the same number.
const MAX_SECTIONS: u32 = 200;

/// Kind of a robot's motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum MotionKind {
    Rests,
    Runs,
    Turns,
}

/// The motion of one robot. Instants are counted in strokes.
#[derive(Debug, Clone, Copy)]
pub(super) struct RobotTrack {
    pub kind: MotionKind,
    pub pose: Pose,
    pub strokes: f64,
    pub step_um: f64,
    /// Bound on the speed of any point of its body, per stroke.
    pub speed_um: f64,
    /// Centre of its orbit.
    pub centre_um: [f64; 2],
    pub reach_um: f64,
    axis: [f64; 2],
    /// Signed turning radius.
    curve_um: f64,
    half_um: [f64; 2],
    corner_um: f64,
}

impl RobotTrack {
    /// Track of a robot; without an arm position it rests.
    pub(super) fn new(body: &RobotDimensions, pose: Pose, arm: Option<Arm>, strokes: f64) -> Self {
        let robot = &body.robot;
        let (kind, speed_um) = match arm {
            None => (MotionKind::Rests, 0.0),
            Some(Arm::Up) => (MotionKind::Runs, robot.step_um),
            Some(Arm::Down) => (MotionKind::Turns, robot.step_um * body.reach_um / robot.turning_radius_um),
        };
        let (sin, cos) = pose.heading_rad.sine_cosine();
        RobotTrack {
            kind,
            pose,
            strokes,
            step_um: robot.step_um,
            speed_um,
            centre_um: robot.orbit_centre_facing_um(pose, [cos, sin]),
            reach_um: body.reach_um,
            axis: [cos, sin],
            curve_um: robot.turning.sign() * robot.turning_radius_um,
            half_um: body.half_um,
            corner_um: body.corner_um,
        }
    }

    /// The body at an instant.
    pub(super) fn at(&self, strokes: f64) -> OrientedRectangle {
        let (centre_um, axis) = match self.kind {
            MotionKind::Rests => ([self.pose.x_um, self.pose.y_um], self.axis),
            MotionKind::Runs => {
                let way_um = self.step_um * strokes;
                ([self.pose.x_um + way_um * self.axis[0], self.pose.y_um + way_um * self.axis[1]], self.axis)
            }
            MotionKind::Turns => {
                let (sin, cos) = (self.pose.heading_rad + self.step_um * strokes / self.curve_um).sine_cosine();
                ([self.centre_um[0] + self.curve_um * sin, self.centre_um[1] - self.curve_um * cos], [cos, sin])
            }
        };
        OrientedRectangle { centre_um, axis, half_um: self.half_um }
    }

    /// The pose at an instant.
    pub(super) fn pose_at(&self, strokes: f64) -> Pose {
        let OrientedRectangle { centre_um: [x_um, y_um], axis: [cos, sin], .. } = self.at(strokes);
        Pose { x_um, y_um, heading_rad: sin.arc_tangent_over(cos) }
    }

    /// A capsule (segment and radius) that contains the body at all times.
    pub(super) fn bound(&self) -> (Segment, f64) {
        let here = Point2::new(self.pose.x_um, self.pose.y_um);
        match self.kind {
            MotionKind::Rests => ([here; 2], self.corner_um),
            MotionKind::Runs => {
                let [x_um, y_um] = self.at(self.strokes).centre_um;
                ([here, Point2::new(x_um, y_um)], self.corner_um)
            }
            MotionKind::Turns => {
                let near_um = self.corner_um + self.speed_um * self.strokes;
                if near_um < self.reach_um {
                    return ([here; 2], near_um);
                }
                ([Point2::new(self.centre_um[0], self.centre_um[1]); 2], self.reach_um)
            }
        }
    }
}

/// Whether the bounding capsules alone prove that two tracks keep a distance.
pub(super) fn far_apart(one: &RobotTrack, other: &RobotTrack, keep_um: f64) -> bool {
    let ((a, a_um), (b, b_um)) = (one.bound(), other.bound());
    segment_segment(a, b) - a_um - b_um >= keep_um + MARGIN_UM
}

/// First instant of a span at which a distance that changes by at most `speed_um` per stroke may be less than
/// `keep_um`.
///
/// Nearer than half the margin counts as too near. Steps keep a quarter of the margin in reserve, so each advances by
/// at least another quarter.
pub(super) fn first_near(
    [from, to]: [f64; 2],
    speed_um: f64,
    keep_um: f64,
    distance_um: impl Fn(f64) -> f64,
) -> Option<f64> {
    let mut at = from;
    for _ in 0..MAX_SAMPLES {
        let room_um = distance_um(at) - keep_um;
        if room_um < MARGIN_UM / 2.0 {
            return Some(at);
        }
        if at >= to {
            return None;
        }
        at = (at + (room_um - MARGIN_UM / 4.0) / speed_um).min(to);
    }
    Some(at)
}

/// The same for a distance that is convex in time: its minimum is found by golden-section search.
pub(super) fn first_near_convex([from, to]: [f64; 2], keep_um: f64, distance_um: impl Fn(f64) -> f64) -> Option<f64> {
    let is_near = |at: f64| distance_um(at) - keep_um < MARGIN_UM / 2.0;
    if is_near(from) {
        return Some(from);
    }
    let share = (5.0_f64.sqrt() - 1.0) / 2.0;
    let (mut low, mut high) = (from, to);
    // On very long legs, adjacent floating-point instants are farther apart than the tolerance; the bound ends the
    // loop.
    let mut sections = 0..MAX_SECTIONS;
    let near = loop {
        let (left, right) = (high - share * (high - low), low + share * (high - low));
        let (at_left_um, at_right_um) = (distance_um(left), distance_um(right));
        match at_left_um < at_right_um {
            true if at_left_um - keep_um < MARGIN_UM / 2.0 => break Some(left),
            false if at_right_um - keep_um < MARGIN_UM / 2.0 => break Some(right),
            true => high = right,
            false => low = left,
        }
        if high - low < 1e-3 || sections.next().is_none() {
            break [low, high, to].into_iter().find(|at| is_near(*at));
        }
    };
    let (mut clear, mut near) = (from, near?);
    for _ in 0..MAX_SECTIONS {
        if near - clear <= 1.0 {
            break;
        }
        let middle = (clear + near) / 2.0;
        if is_near(middle) { near = middle } else { clear = middle }
    }
    Some(near)
}
