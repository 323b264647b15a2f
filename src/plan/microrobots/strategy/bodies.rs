//! Possible collision partners of a robot.

use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::Robot;
use crate::geometry::distance::quadrilateral_core;
use crate::geometry::{Core, Pose};
use crate::real::Real;
use nalgebra::Point2;

/// An overlap with a front below this counts as lying ahead of it.
const TOUCHING_UM: f64 = 1.0;

/// The corners of a robot's body, in order around it.
pub type BodyCorners = [Point2<f64>; 4];

/// The body of a robot, shrunk by `less_um` on every side.
pub fn body(robot: &Robot, pose: Pose, less_um: f64) -> BodyCorners {
    let (sin, cos) = pose.heading_rad.sine_cosine();
    let (a, b) = ((robot.length_um / 2.0 - less_um).max(0.0), (robot.width_um / 2.0 - less_um).max(0.0));
    [(-a, -b), (a, -b), (a, b), (-a, b)]
        .map(|(x, y)| Point2::new(pose.x_um + x * cos - y * sin, pose.y_um + x * sin + y * cos))
}

/// A solid that occupies a part of the bed.
#[derive(Debug, Clone)]
pub struct StrategySolid {
    /// Name in messages.
    pub name: String,
    core: Core,
    radius_um: f64,
    /// A bounding disc.
    middle: Point2<f64>,
    reach_um: f64,
}

impl StrategySolid {
    fn new(name: String, core: Core, radius_um: f64) -> Self {
        let points = core.corners();
        let sum = points.iter().fold(nalgebra::Vector2::zeros(), |sum, point| sum + point.coords);
        let middle = Point2::from(sum / points.len().max(1) as f64);
        let reach_um = points.iter().map(|point| (point - middle).norm()).fold(0.0, f64::max) + radius_um;
        StrategySolid { name, core, radius_um, middle, reach_um }
    }

    /// The body of a robot at rest.
    pub fn standing(robot: &Robot, pose: Pose) -> Self {
        StrategySolid::new(robot.name.clone(), Core::Polygon(body(robot, pose, 0.0).to_vec()), 0.0)
    }

    /// The disc that an orbiting robot sweeps, enlarged.
    pub fn orbit(robot: &Robot, pose: Pose, growth_um: f64) -> Self {
        let [x_um, y_um] = robot.orbit_centre_um(pose);
        let name = format!("the orbit of {}", robot.name);
        StrategySolid::new(name, Core::Point(Point2::new(x_um, y_um)), robot.orbit_reach_um() + growth_um)
    }

    /// Whether all of it lies ahead of the front of a robot at its goal, up to a contact tolerance.
    pub fn is_ahead(&self, robot: &Robot, goal: Pose) -> bool {
        let (sin, cos) = goal.heading_rad.sine_cosine();
        let ahead_um = |point: &Point2<f64>| (point.x - goal.x_um) * cos + (point.y - goal.y_um) * sin;
        let nearest_um = self.core.corners().iter().map(ahead_um).fold(f64::INFINITY, f64::min) - self.radius_um;
        nearest_um >= robot.length_um / 2.0 - TOUCHING_UM
    }

    /// Distance of a body from it; exact below `enough_um`, and a lower bound beyond.
    pub fn distance_um(&self, body: &BodyCorners, enough_um: f64) -> f64 {
        let middle = nalgebra::center(&body[0], &body[2]);
        let half_um = (body[2] - body[0]).norm() / 2.0;
        let least_um = (middle - self.middle).norm() - half_um - self.reach_um;
        if least_um > enough_um {
            return least_um;
        }
        quadrilateral_core(*body, &self.core) - self.radius_um
    }
}

/// The obstacles of an order.
pub fn obstacles(order: &MicrorobotsOrder) -> Vec<StrategySolid> {
    let solid = |obstacle: &crate::claims::microrobots::MicrorobotsObstacle| {
        let grown = obstacle.shape.grown(&obstacle.pose, 0.0).ok()?;
        Some(StrategySolid::new(obstacle.name.clone(), grown.core, grown.radius_um))
    };
    order.obstacles.iter().filter_map(solid).collect()
}

/// Signed distance between a robot's front at its goal and the nearest of some bodies that it faces; `None` if none is
/// within the tolerance. A body beside its path, whose side is farther forward, is not faced.
pub fn edge_gap_um(robot: &Robot, goal: Pose, bodies: &[(&Robot, Pose)], tolerance_um: f64) -> Option<f64> {
    let (sin, cos) = goal.heading_rad.sine_cosine();
    let at_goal = body(robot, goal, 0.0);
    let ahead_um = |corner: &Point2<f64>| (corner.x - goal.x_um) * cos + (corner.y - goal.y_um) * sin;
    let aside_um = |corner: &Point2<f64>| (corner.y - goal.y_um) * cos - (corner.x - goal.x_um) * sin;
    let gap_um = |&(other, pose): &(&Robot, Pose)| {
        let touches = StrategySolid::standing(other, pose).distance_um(&at_goal, tolerance_um) <= tolerance_um;
        let corners = body(other, pose, 0.0);
        let nearest_um = corners.iter().map(ahead_um).fold(f64::INFINITY, f64::min);
        let (right_um, left_um) = corners
            .iter()
            .map(aside_um)
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), aside| (least.min(aside), most.max(aside)));
        let is_ahead = right_um < robot.width_um / 2.0 && left_um > -robot.width_um / 2.0;
        let gap_um = nearest_um - robot.length_um / 2.0;
        (touches && is_ahead && gap_um >= -tolerance_um - 1e-6).then_some(gap_um)
    };
    bodies.iter().filter_map(gap_um).min_by(f64::total_cmp)
}
