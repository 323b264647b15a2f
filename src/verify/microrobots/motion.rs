//! Motion of robots by strokes: the unicycle model, in the coordinates of the paper.
//!
//! Here a heading is measured clockwise from +y, and a curve is a turning radius, positive for a turn to the right; so
//! x' = sin, y' = cos (equation 4 of the paper). Input: a pose, a curve and a path length. Output: the pose after it,
//! exact up to rounding.

use super::bodies::JudgedBody;
use crate::geometry::Pose;
use crate::real::Real;
use crate::schedule::microrobots::RecordedPose;
use nalgebra::{Point2, Vector2};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Pose of a robot, in the coordinates of the paper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct RobotPlace {
    pub at: Point2<f64>,
    /// Heading, clockwise from +y.
    pub theta_rad: f64,
}

impl RobotPlace {
    pub fn of(pose: &Pose) -> RobotPlace {
        RobotPlace { at: Point2::new(pose.x_um, pose.y_um), theta_rad: FRAC_PI_2 - pose.heading_rad }
    }

    /// The pose as recorded in states: x, y, and the heading counter-clockwise from +x, between -180 and 180 degrees.
    pub fn recorded(self) -> RecordedPose {
        let heading_rad = turn_between(0.0, FRAC_PI_2 - self.theta_rad);
        RecordedPose::from(Pose { x_um: self.at.x, y_um: self.at.y, heading_rad })
    }

    /// The pose after a path length, on a curve or straight.
    pub fn driven(self, curve_um: Option<f64>, path_um: f64) -> RobotPlace {
        let (sin, cos) = self.theta_rad.sine_cosine();
        let Some(curve_um) = curve_um else {
            return RobotPlace { at: self.at + Vector2::new(sin, cos) * path_um, ..self };
        };
        let theta_rad = self.theta_rad + path_um / curve_um;
        let (later_sin, later_cos) = theta_rad.sine_cosine();
        let at = self.at + Vector2::new(cos - later_cos, later_sin - sin) * curve_um;
        RobotPlace { at, theta_rad: theta_rad.rem_euclid(TAU) }
    }

    /// The centre of the circle of a turn.
    pub fn centre(self, curve_um: f64) -> Point2<f64> {
        let (sin, cos) = self.theta_rad.sine_cosine();
        self.at + Vector2::new(cos, -sin) * curve_um
    }

    /// Distance from a pose and absolute angle to its heading, in micrometres and radians.
    pub fn off(self, pose: &Pose) -> [f64; 2] {
        let goal = RobotPlace::of(pose);
        [(self.at - goal.at).norm(), turn_between(self.theta_rad, goal.theta_rad).abs()]
    }
}

/// The shortest turn from one angle to another, between -180 and 180 degrees.
pub(super) fn turn_between(from_rad: f64, to_rad: f64) -> f64 {
    let turn_rad = (to_rad - from_rad).rem_euclid(TAU);
    if turn_rad > TAU / 2.0 { turn_rad - TAU } else { turn_rad }
}

/// Motion of a body in one train of strokes. Its methods take fractions of the path, from 0 to 1.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TrainMotion {
    pub start: RobotPlace,
    /// Turning radius, positive to the right; `None` with the arm up.
    pub curve_um: Option<f64>,
    /// Path length; 0 for a body that rests.
    pub path_um: f64,
    /// Half of the body's length and width.
    pub half_um: [f64; 2],
}

impl TrainMotion {
    /// The body at a fraction of the path.
    pub fn body(&self, share: f64) -> JudgedBody {
        let place = self.start.driven(self.curve_um, self.path_um * share);
        let (sin, cos) = place.theta_rad.sine_cosine();
        JudgedBody { centre: place.at, along: Vector2::new(sin, cos), half_um: self.half_um }
    }

    /// Half of the body's diagonal.
    fn half_diagonal_um(&self) -> f64 {
        self.half_um[0].hypotenuse(self.half_um[1])
    }

    /// Radius of the disc about the centre of its circle that the body never leaves.
    pub fn disc_radius_um(&self, curve_um: f64) -> f64 {
        (curve_um.abs() + self.half_um[1]).hypotenuse(self.half_um[0])
    }

    /// Upper bound on the path length of any point of the body.
    pub fn travel_um(&self) -> f64 {
        match self.curve_um {
            None => self.path_um,
            Some(curve_um) => self.path_um / curve_um.abs() * self.disc_radius_um(curve_um),
        }
    }

    /// The straight displacement of every point of the body; `None` if the body turns.
    pub fn shift(&self) -> Option<Vector2<f64>> {
        let (sin, cos) = self.start.theta_rad.sine_cosine();
        (self.curve_um.is_none() || self.path_um == 0.0).then(|| Vector2::new(sin, cos) * self.path_um)
    }

    /// A disc that contains the body between two fractions of the path, as centre and radius.
    pub fn disc(&self, [from, to]: [f64; 2]) -> (Point2<f64>, f64) {
        let half_path_um = self.path_um * (to - from) / 2.0;
        let middle = self.start.driven(self.curve_um, self.path_um * (from + to) / 2.0);
        let near = (middle.at, half_path_um + self.half_diagonal_um());
        match self.curve_um {
            Some(curve_um) if self.disc_radius_um(curve_um) < near.1 => {
                (self.start.centre(curve_um), self.disc_radius_um(curve_um))
            }
            Some(_) | None => near,
        }
    }

    /// The motion cut off after its first full turn, and its fraction of the whole path.
    pub fn first_turn(&self) -> (TrainMotion, f64) {
        let whole_um = self.curve_um.map_or(f64::INFINITY, |curve_um| TAU * curve_um.abs());
        if self.path_um <= whole_um {
            (*self, 1.0)
        } else {
            (TrainMotion { path_um: whole_um, ..*self }, whole_um / self.path_um)
        }
    }
}
