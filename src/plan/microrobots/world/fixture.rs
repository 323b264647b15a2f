//! Beds for tests.

use crate::claims::microrobots::{Assurance, MicrorobotsObstacle, MicrorobotsOrder, Placed, Precision};
use crate::device::microrobots::{Arm, ControlState, Docking, Fine, MicrorobotsFacts, Robot, Turning};
use crate::geometry::{Pose, Shape};
use crate::source::Span;
use std::sync::Arc;

pub fn pose(x_um: f64, y_um: f64, heading_deg: f64) -> Pose {
    Pose { x_um, y_um, heading_rad: heading_deg.to_radians() }
}

/// A robot of typical size that turns clockwise.
pub fn robot(name: &str, turning_radius_um: f64, step_um: f64) -> Robot {
    Robot {
        name: name.to_owned(),
        snap_down_v: 110.0,
        release_v: 20.0,
        turning_radius_um,
        step_um,
        turning: Turning::Clockwise,
        length_um: 250.0,
        width_um: 60.0,
    }
}

pub fn obstacle(name: &str, shape: Shape, pose: Pose) -> MicrorobotsObstacle {
    MicrorobotsObstacle { name: name.to_owned(), shape, pose, span: Span::default() }
}

/// A STRING bed: state j lowers the arms of the first j robots.
pub fn bed(robots: Vec<(Robot, Pose)>, obstacles: Vec<MicrorobotsObstacle>) -> MicrorobotsOrder {
    let count = robots.len();
    let state = |down: usize| ControlState {
        arms: (0..count).map(|robot| if robot < down { Arm::Down } else { Arm::Up }).collect(),
        levels_v: vec![9.0; if down == 0 || down == count { 1 } else { 2 }],
        slack_v: 1.0,
    };
    let placed = |(row, (_, pose)): (usize, &(Robot, Pose))| Placed { row, pose: *pose, span: Span::default() };
    MicrorobotsOrder {
        states: Arc::new((0..=count).map(state).collect()),
        obstacles: Arc::new(obstacles),
        robots: Arc::new(robots.iter().enumerate().map(placed).collect()),
        expansions: 16_000_000,
        objective: crate::device::microrobots::MicrorobotsObjective::Time,
        precision: Precision { place_um: 0.5, heading_rad: 0.5_f64.to_radians() },
        assurance: Assurance::Reported,
        steps: Vec::new(),
        facts: Arc::new(facts(robots.into_iter().map(|(robot, _)| robot).collect())),
    }
}

fn facts(robots: Vec<Robot>) -> MicrorobotsFacts {
    MicrorobotsFacts {
        robots,
        margin_v: 2.0,
        max_v: 200.0,
        relax_v: 60.0,
        flex_v: 100.0,
        period_ns: 50_000,
        dwell_ns: 1_000_000,
        clearance_um: 10.0,
        orbit_clearance_um: 20.0,
        docking: Docking {
            self_aligning_rad: 60.0_f64.to_radians(),
            self_aligning_um: 80.0,
            sticking_rad: 45.0_f64.to_radians(),
            tolerance_um: 1.0,
        },
        fine: Fine { length_um: 200.0, cycle_um: 10.0 },
        errors: None,
        watchdog_ns: None,
    }
}
