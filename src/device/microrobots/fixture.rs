//! A bed for tests.

use super::{Arm, ControlState, Docking, Fine, MicrorobotsFacts, Robot, Turning};
use crate::geometry::Pose;

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

pub fn facts(robots: Vec<Robot>) -> MicrorobotsFacts {
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

/// The states of a STRING table: state j lowers the arms of the first j robots; `levels_v` gives its levels.
pub fn string_states(count: usize, slack_v: f64, levels_v: impl Fn(usize) -> Vec<f64>) -> Vec<ControlState> {
    let arm = |down: usize, row: usize| if row < down { Arm::Down } else { Arm::Up };
    let arms = |down: usize| (0..count).map(|row| arm(down, row)).collect();
    (0..=count).map(|down| ControlState { arms: arms(down), levels_v: levels_v(down), slack_v }).collect()
}
