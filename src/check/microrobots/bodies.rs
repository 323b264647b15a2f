//! Bodies of robots and obstacles, and the distances between them.

use crate::claims::microrobots::MicrorobotsObstacle;
use crate::device::microrobots::Robot;
use crate::geometry::{Pose, Rounded, distance};
use crate::real::Real;
use nalgebra::{Point2, Vector2};

/// Rounding allowed in a distance, in micrometres.
pub const SLACK_UM: f64 = 1e-6;

/// The body of a robot at a pose: a rectangle about the pose's place, its long side along the heading.
#[derive(Debug, Clone, Copy)]
pub struct RobotBody {
    /// Counter-clockwise, beginning at the front right.
    pub corners: [Point2<f64>; 4],
    centre: Point2<f64>,
    reach_um: f64,
}

impl RobotBody {
    /// The body of a robot at a pose.
    pub fn of(robot: &Robot, pose: Pose) -> RobotBody {
        let (half_um, side_um) = (robot.length_um / 2.0, robot.width_um / 2.0);
        let frame = pose.isometry();
        let corners = [(half_um, -side_um), (half_um, side_um), (-half_um, side_um), (-half_um, -side_um)];
        RobotBody {
            corners: corners.map(|(x_um, y_um)| frame * Point2::new(x_um, y_um)),
            centre: Point2::new(pose.x_um, pose.y_um),
            reach_um: half_um.hypotenuse(side_um),
        }
    }

    /// The outward normals of its sides, each with a corner of that side: front, left, back, right.
    pub fn sides(&self) -> [(Vector2<f64>, Point2<f64>); 4] {
        [0, 1, 2, 3].map(|at| {
            let along = (self.corners[(at + 1) % 4] - self.corners[at]).normalize();
            (Vector2::new(along.y, -along.x), self.corners[at])
        })
    }

    /// Distance from another body; a negative one is the depth of the overlap, the least shift that separates them.
    pub fn gap_um(&self, other: &RobotBody) -> f64 {
        let depth_um = self.way_out(other).map_or(0.0, |way| way.norm());
        if depth_um > 0.0 { -depth_um } else { self.way_to(other).norm() }
    }

    /// The shortest shift that brings it into touch with a body that it does not overlap.
    pub fn way_to(&self, other: &RobotBody) -> Vector2<f64> {
        let towards = self.corners.iter().map(|corner| nearest_of(*corner, &other.corners) - corner);
        let back = other.corners.iter().map(|corner| corner - nearest_of(*corner, &self.corners));
        let shorter = |one: Vector2<f64>, other: Vector2<f64>| if other.norm() < one.norm() { other } else { one };
        towards.chain(back).reduce(shorter).unwrap_or_default()
    }

    /// The shortest shift that brings it out of a body that it overlaps; `None` if they do not overlap.
    pub fn way_out(&self, other: &RobotBody) -> Option<Vector2<f64>> {
        let of_other = other.sides().map(|(normal, at)| normal * -self.beyond_um(normal, at));
        let own = self.sides().map(|(normal, at)| normal * other.beyond_um(normal, at));
        let lies_apart = other.sides().iter().any(|(normal, at)| self.beyond_um(*normal, *at) >= 0.0)
            || self.sides().iter().any(|(normal, at)| other.beyond_um(*normal, *at) >= 0.0);
        let shorter = |one: Vector2<f64>, other: Vector2<f64>| if other.norm() < one.norm() { other } else { one };
        of_other.into_iter().chain(own).reduce(shorter).filter(|_| !lies_apart)
    }

    /// Signed distance of its nearest corner from a line, along the normal; negative where the body reaches across.
    pub fn beyond_um(&self, normal: Vector2<f64>, at: Point2<f64>) -> f64 {
        self.corners.iter().map(|corner| (corner - at).dot(&normal)).fold(f64::INFINITY, f64::min)
    }
}

/// The point of a rectangle's rim that is nearest to a point.
fn nearest_of(point: Point2<f64>, corners: &[Point2<f64>; 4]) -> Point2<f64> {
    let sides = (0..4).map(|at| [corners[at], corners[(at + 1) % 4]]);
    let candidates = sides.map(|[from, to]| {
        let along = to - from;
        let share = ((point - from).dot(&along) / along.norm_squared()).clamp(0.0, 1.0);
        from + along * share
    });
    let nearer = |one: Point2<f64>, other: Point2<f64>| {
        if (other - point).norm() < (one - point).norm() { other } else { one }
    };
    candidates.reduce(nearer).unwrap_or(point)
}

/// An obstacle in the plane.
pub struct ObstacleSolid {
    body: Rounded,
    centre: Point2<f64>,
    reach_um: f64,
}

impl ObstacleSolid {
    /// `None` for a shape that cannot be placed, already reported for the scene.
    pub fn of(obstacle: &MicrorobotsObstacle) -> Option<ObstacleSolid> {
        let body = obstacle.shape.grown(&obstacle.pose, 0.0).ok()?;
        let corners = body.core.corners();
        let sum = corners.iter().fold(Vector2::zeros(), |sum, corner| sum + corner.coords);
        let centre = Point2::from(sum / corners.len() as f64);
        let farthest_um = corners.iter().map(|corner| (corner - centre).norm()).fold(0.0, f64::max);
        let reach_um = farthest_um + body.radius_um;
        Some(ObstacleSolid { body, centre, reach_um })
    }

    /// Distance of a robot's body from it; at most 0 where they touch. Exact only up to `enough_um`; above that a lower
    /// bound.
    pub fn gap_um(&self, body: &RobotBody, enough_um: f64) -> f64 {
        let least_um = (self.centre - body.centre).norm() - self.reach_um - body.reach_um;
        if least_um > enough_um {
            return least_um;
        }
        distance::quadrilateral_core(body.corners, &self.body.core) - self.body.radius_um
    }
}

/// Whether a gap is less than required; bodies that touch are always too near.
pub fn is_too_near(gap_um: f64, kept_um: f64) -> bool {
    gap_um < kept_um - SLACK_UM || gap_um <= SLACK_UM
}
