//! Bounds on how far a robot that is not corrected may be from its plan.

use crate::device::microrobots::{Arm, Errors, Robot};
use crate::real::Real;

/// Bounds on the distance of the centre of a robot's orbit from that of the plan, and on the difference of headings.
/// With both, a point of the body is off by at most the first plus its own distance from the centre times the second.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StrayBound {
    pub centre_um: f64,
    pub heading_rad: f64,
}

impl StrayBound {
    /// Bounds for a robot that was measured where the plan begins.
    pub fn measured(robot: &Robot, errors: &Errors) -> Self {
        let heading_rad = errors.heading_rad;
        StrayBound { centre_um: errors.place_um + robot.turning_radius_um * heading_rad, heading_rad }
    }

    /// Bounds after a nominal path with the arm down or up.
    ///
    /// The centre C of a robot of turning radius r that runs on a path of curvature k moves along its heading by (1 - r
    /// k) per unit of path. With the arm down, k is 1/r up to the error of turning; with the arm up, it is that error
    /// alone. The error of speed makes the path longer or shorter, and with the arm down the turn as well.
    pub fn after(self, robot: &Robot, arm: Arm, way_um: f64, errors: &Errors) -> Self {
        let radius_um = robot.turning_radius_um;
        let bent_rad = errors.turning_rad_per_um * way_um * (1.0 + errors.speed_ratio);
        let longer_um = errors.speed_ratio * way_um;
        let creep_um = radius_um * bent_rad;
        match arm {
            Arm::Down => StrayBound {
                centre_um: self.centre_um + creep_um,
                heading_rad: self.heading_rad + longer_um / radius_um + bent_rad,
            },
            Arm::Up => {
                let heading_rad = self.heading_rad + bent_rad;
                StrayBound { centre_um: self.centre_um + longer_um + way_um * heading_rad + creep_um, heading_rad }
            }
        }
    }

    /// Bound for the middle of the body.
    pub fn place_um(&self, robot: &Robot) -> f64 {
        self.centre_um + robot.turning_radius_um * self.heading_rad
    }

    /// Bound for the middle of its front.
    pub fn nose_um(&self, robot: &Robot) -> f64 {
        self.centre_um + robot.turning_radius_um.hypotenuse(robot.length_um / 2.0) * self.heading_rad
    }

    /// Bound for any point of the body.
    pub fn body_um(&self, robot: &Robot) -> f64 {
        self.centre_um + robot.orbit_reach_um() * self.heading_rad
    }
}
