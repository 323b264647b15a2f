//! Beds for tests.

use crate::claims::fixture::bed_order;
use crate::claims::microrobots::{MicrorobotsObstacle, MicrorobotsOrder, Precision};
use crate::device::microrobots::Robot;
use crate::device::microrobots::fixture::{facts, string_states};
pub use crate::device::microrobots::fixture::{pose, robot};
use crate::geometry::{Pose, Shape};
use crate::source::Span;
use std::sync::Arc;

pub fn obstacle(name: &str, shape: Shape, pose: Pose) -> MicrorobotsObstacle {
    MicrorobotsObstacle { name: name.to_owned(), shape, pose, span: Span::default() }
}

/// A STRING bed: state j lowers the arms of the first j robots.
pub fn bed(robots: Vec<(Robot, Pose)>, obstacles: Vec<MicrorobotsObstacle>) -> MicrorobotsOrder {
    let count = robots.len();
    let states = string_states(count, 1.0, |down| vec![9.0; if down == 0 || down == count { 1 } else { 2 }]);
    let (robots, poses): (Vec<Robot>, Vec<Pose>) = robots.into_iter().unzip();
    MicrorobotsOrder {
        obstacles: Arc::new(obstacles),
        expansions: 16_000_000,
        precision: Precision { place_um: 0.5, heading_rad: 0.5_f64.to_radians() },
        ..bed_order(facts(robots), states, poses.into_iter().enumerate())
    }
}
