//! Content of a log for a DiMiBot: end-effector, path, obstacles and lattice. One unit of its pictures is one micrometre.

pub mod motion;
mod points;
pub mod scene;

use super::frames::{Mover, StandingPose};
use super::{LogTopic, Signals};
use crate::device::dimibot::DimibotFacts;
use crate::verify::Verified;

/// Extent of its picture along x and y.
pub fn extent_um(facts: &DimibotFacts) -> [f64; 2] {
    scene::extent_um(facts)
}

/// All topics of a device except its voltages, and its moving frames.
pub fn topics(verified: &Verified, signals: &Signals, device: &str) -> (Vec<LogTopic>, Vec<Mover>) {
    let poses = motion::poses(verified, signals, device);
    let mut topics = Vec::from(motion::topics(verified, device, &poses));
    topics.extend(points::topics(verified, device));
    topics.extend(scene::topics(verified, device));
    let places = poses.into_iter().map(|(t_ns, place)| (t_ns, Some(StandingPose::at(place)))).collect();
    (topics, vec![Mover { frame: motion::tip_frame(device), device: device.to_owned(), places }])
}
