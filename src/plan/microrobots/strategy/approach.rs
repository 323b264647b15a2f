//! Fine motion: the curvature with which a robot docks in its place.

use super::SteeringModel;
use crate::device::microrobots::{Robot, wrapped_rad};
use crate::geometry::Pose;
use crate::real::Real;

/// Bisection steps for a curvature; the error is then far below the resolution of a cycle.
const HALVINGS: usize = 40;

/// Newton steps for the path length to the contact.
const NEWTON_STEPS: usize = 20;

/// A goal in its robot's frame: x ahead, y to the side to which it turns, so that every robot seems to turn
/// counter-clockwise.
#[derive(Debug, Clone, Copy)]
pub struct GoalFrame {
    pub goal: Pose,
    /// +1 if the robot turns counter-clockwise.
    side: f64,
    /// Position of the edge that it meets, ahead of the goal's middle.
    pub edge_um: f64,
    length_um: f64,
    width_um: f64,
}

/// Contact of a robot with an edge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EdgeContact {
    /// Lateral offset from its place once its front lies flat; positive is the side to which it turns.
    pub across_um: f64,
    /// Angle between its heading and the normal of the edge, before it lies flat.
    pub incidence_rad: f64,
    /// Path length to the contact.
    pub way_um: f64,
}

impl GoalFrame {
    /// The edge lies at the robot's front when it is at its goal, up to a gap.
    pub fn new(robot: &Robot, goal: Pose, gap_um: f64) -> Self {
        GoalFrame {
            goal,
            side: robot.turning.sign(),
            edge_um: robot.length_um / 2.0 + gap_um,
            length_um: robot.length_um,
            width_um: robot.width_um,
        }
    }

    /// A pose of the world in the goal's frame.
    pub fn seen(&self, pose: Pose) -> Pose {
        let (sin, cos) = self.goal.heading_rad.sine_cosine();
        let (dx_um, dy_um) = (pose.x_um - self.goal.x_um, pose.y_um - self.goal.y_um);
        Pose {
            x_um: dx_um * cos + dy_um * sin,
            y_um: self.side * (dy_um * cos - dx_um * sin),
            heading_rad: self.side * wrapped_rad(pose.heading_rad - self.goal.heading_rad),
        }
    }

    /// Distance of a pose from contact with the edge; negative when it is past it.
    pub fn gap_um(&self, seen: Pose) -> f64 {
        let (sin, cos) = seen.heading_rad.sine_cosine();
        self.edge_um - seen.x_um - self.length_um / 2.0 * cos - self.width_um / 2.0 * sin.abs()
    }

    /// Contact of a robot whose pose touches the edge.
    pub fn contact(&self, seen: Pose, way_um: f64) -> EdgeContact {
        let (sin, cos) = seen.heading_rad.sine_cosine();
        let lean_um = self.width_um / 2.0 * (1.0 - cos) * sin.signum();
        let across_um = seen.y_um + self.length_um / 2.0 * sin + lean_um;
        EdgeContact { across_um, incidence_rad: seen.heading_rad, way_um }
    }

    /// Contact of a robot that continues with a curvature; `None` if it turns away before.
    pub fn met(&self, seen: Pose, turn_per_um: f64) -> Option<EdgeContact> {
        let mut way_um = self.gap_um(seen).max(0.0);
        for _ in 0..NEWTON_STEPS {
            let there = bent(seen, turn_per_um, way_um);
            let (sin, cos) = there.heading_rad.sine_cosine();
            let lever_um = self.length_um / 2.0 * sin - self.width_um / 2.0 * cos * sin.signum();
            let speed = cos - turn_per_um * lever_um;
            if speed <= 0.1 {
                return None;
            }
            let step_um = self.gap_um(there) / speed;
            way_um = (way_um + step_um).max(0.0);
            if step_um.abs() < 1e-7 {
                break;
            }
        }
        Some(self.contact(bent(seen, turn_per_um, way_um), way_um))
    }

    /// A pose of the goal's frame in the world frame.
    pub fn placed(&self, seen: Pose) -> Pose {
        let (sin, cos) = self.goal.heading_rad.sine_cosine();
        let y_um = self.side * seen.y_um;
        Pose {
            x_um: self.goal.x_um + seen.x_um * cos - y_um * sin,
            y_um: self.goal.y_um + seen.x_um * sin + y_um * cos,
            heading_rad: wrapped_rad(self.goal.heading_rad + self.side * seen.heading_rad),
        }
    }
}

/// A pose after a path of this length and curvature, counter-clockwise.
pub fn bent(pose: Pose, turn_per_um: f64, way_um: f64) -> Pose {
    // The chord of an arc, in the direction of its midpoint: exact, and valid for the straight line too.
    let half_rad = turn_per_um * way_um / 2.0;
    let chord_um = if half_rad.abs() < 1e-6 { way_um } else { way_um * half_rad.sine() / half_rad };
    let (sin, cos) = (pose.heading_rad + half_rad).sine_cosine();
    Pose {
        x_um: pose.x_um + chord_um * cos,
        y_um: pose.y_um + chord_um * sin,
        heading_rad: pose.heading_rad + 2.0 * half_rad,
    }
}

/// The share of turning, within bounds, that docks a robot in its place; and the lateral offset from its place with
/// that share, 0 if the place is within reach.
pub fn steered(model: &SteeringModel, frame: &GoalFrame, measured: Pose, [least, most]: [f64; 2]) -> (f64, f64) {
    let seen = frame.seen(measured);
    let per_um = 1.0 / model.robot.turning_radius_um;
    let across = |share: f64| frame.met(seen, share * per_um).map_or(f64::INFINITY, |contact| contact.across_um);
    let (mut low, mut high) = (least, most);
    let (at_low_um, at_high_um) = (across(low), across(high));
    if at_low_um >= 0.0 {
        return (low, at_low_um);
    }
    if at_high_um <= 0.0 {
        return (high, at_high_um);
    }
    for _ in 0..HALVINGS {
        let middle = (low + high) / 2.0;
        if across(middle) < 0.0 { low = middle } else { high = middle }
    }
    ((low + high) / 2.0, 0.0)
}
