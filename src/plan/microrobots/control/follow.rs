//! Check whether a robot is where its commands bring it.
//!
//! From a measured pose on, every stretch adds to how far the robot may be off its nominal path. Let v be the error of
//! the speed, t that of the turning per unit of path, p that of a measured place and h that of a measured heading; the
//! robot may be off by p and h at first. A stretch of length w then deviates from the nominal one by at most (heading
//! error so far) w + t w^2 / 2 + v w, and turns away from it by at most t w (1 + v), and by v w / R more on a circle of
//! radius R.
//!
//! A short stretch proves nothing: within the errors the robot may have followed it or stood still. So the nominal path
//! goes on from one measurement to the next until a measurement is either astray, or where only a robot that moved can
//! be.

use crate::device::microrobots::{Arm, Errors, Robot, wrapped_rad};
use crate::geometry::Pose;
use crate::real::Real;

/// Distance and angle granted to every measurement in addition to the bounds on its errors.
pub(super) const SLACK_UM: f64 = 0.1;
pub(super) const SLACK_RAD: f64 = 1e-3;

/// Multiple of an error's bound by which a measured pose may differ from the last one: both may be off.
pub(super) const GATE: f64 = 2.0;

/// The nominal path of a robot since a measurement.
#[derive(Debug, Clone, Copy)]
pub struct CommandedCourse {
    from: Pose,
    nominal: Pose,
    /// Bounds on how far it may be off the nominal pose.
    off_um: f64,
    off_rad: f64,
    way_um: f64,
    /// Number of consecutive times that it was not where its commands bring it.
    pub astray: u32,
}

/// Finding of a measurement about a robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Following {
    Followed,
    /// It may have followed, and may have stood still.
    Unclear,
    /// It is not where its commands can have brought it.
    Astray,
}

impl CommandedCourse {
    /// Begins at a measured pose.
    pub fn new(from: Pose, errors: &Errors) -> Self {
        let (off_um, off_rad) = (errors.place_um, errors.heading_rad);
        CommandedCourse { from, nominal: from, off_um, off_rad, way_um: 0.0, astray: 0 }
    }

    /// Drives the robot on.
    pub fn drive(&mut self, robot: &Robot, errors: &Errors, arm: Arm, way_um: f64) {
        let turned_rad = errors.turning_rad_per_um * way_um;
        let circle_rad = match arm {
            Arm::Up => 0.0,
            Arm::Down => errors.speed_ratio * way_um / robot.turning_radius_um,
        };
        self.nominal = robot.moved(self.nominal, arm, way_um);
        self.off_um += (self.off_rad + turned_rad / 2.0 + errors.speed_ratio) * way_um;
        self.off_rad += turned_rad * (1.0 + errors.speed_ratio) + circle_rad;
        self.way_um += way_um;
    }

    /// Whether a robot that follows, except for a slip of this distance and angle, may be measured there.
    pub fn leads_within(&self, errors: &Errors, measured: Pose, [slipped_um, slipped_rad]: [f64; 2]) -> bool {
        let off_um = self.off_um + errors.place_um + slipped_um;
        let off_rad = self.off_rad + errors.heading_rad + slipped_rad;
        is_within(measured, self.nominal, [off_um, off_rad])
    }

    /// Compares a measurement with the course. The course begins anew there, unless the measurement proves nothing.
    pub fn follow(&mut self, errors: &Errors, measured: Pose) -> Following {
        let is_there = self.leads_within(errors, measured, [0.0; 2]);
        let may_stand = is_within(measured, self.from, [GATE * errors.place_um, GATE * errors.heading_rad]);
        let following = match (is_there, may_stand) {
            (true, true) => return Following::Unclear,
            (true, false) => Following::Followed,
            // A robot that moves without a command was moved, which proves nothing about commands.
            (false, _) if self.way_um == 0.0 => Following::Unclear,
            (false, _) => Following::Astray,
        };
        let astray = if following == Following::Followed { 0 } else { self.astray };
        *self = CommandedCourse { astray, ..CommandedCourse::new(measured, errors) };
        following
    }
}

/// Whether a measured pose is this near to another one.
fn is_within(measured: Pose, pose: Pose, [off_um, off_rad]: [f64; 2]) -> bool {
    (measured.x_um - pose.x_um).hypotenuse(measured.y_um - pose.y_um) <= off_um + SLACK_UM
        && wrapped_rad(measured.heading_rad - pose.heading_rad).abs() <= off_rad + SLACK_RAD
}
