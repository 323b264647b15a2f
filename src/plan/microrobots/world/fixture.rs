//! Beds for tests.

use crate::claims::fixture::bed_order;
use crate::claims::microrobots::{Dock, MicrorobotsObstacle, MicrorobotsOrder, MicrorobotsStop, Precision};
use crate::device::microrobots::Robot;
use crate::device::microrobots::fixture::{facts, string_states};
pub use crate::device::microrobots::fixture::{pose, robot};
use crate::geometry::{Pose, Shape};
use crate::random::SplitMix64;
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

/// Goals, that of the robot that snaps last first: two head on, the others at their sides.
const SEATS: [[f64; 3]; 5] =
    [[-125.0, 0.0, 0.0], [125.0, 0.0, 180.0], [-125.0, 155.0, -90.0], [125.0, -155.0, 90.0], [125.0, 155.0, -90.0]];

/// A goal of a robot.
pub fn dock(robot: usize, pose: Pose) -> Dock {
    Dock { robot, goal: MicrorobotsStop { pose, span: Span::default(), origin: None } }
}

/// An assembly of up to five robots. Their random starts surround the structure, far enough from it and from one another
/// to orbit.
pub fn assembly(count: usize, random: &mut SplitMix64) -> (MicrorobotsOrder, Vec<Dock>) {
    let mut starts: Vec<Pose> = Vec::new();
    while starts.len() < count {
        let [x, y] = [0, 1].map(|_| 2_500.0 * random.signed_unit());
        let is_apart = |other: &Pose| (other.x_um - x).abs().max((other.y_um - y).abs()) > 900.0;
        if x.abs().max(y.abs()) > 900.0 && starts.iter().all(is_apart) {
            starts.push(pose(x, y, 180.0 * random.signed_unit()));
        }
    }
    let label = |index: usize| format!("D{}", index + 1);
    let placed = |(index, pose): (usize, Pose)| (robot(&label(index), 150.0 + 4.0 * index as f64, 0.015), pose);
    let seated = |(seat, [x, y, heading]): (usize, &[f64; 3])| dock(count - 1 - seat, pose(*x, *y, *heading));
    let docks = SEATS[..count].iter().enumerate().map(seated);
    (bed(starts.into_iter().enumerate().map(placed).collect(), Vec::new()), docks.collect())
}
