//! What a log shows of microrobots.

use super::Topic;
use super::frames::Mover;
use crate::check::claims::microrobots::MicrorobotsOrder;
use crate::verify::Verified;

/// How far the picture reaches along x.
pub fn width(_order: &MicrorobotsOrder) -> f64 {
    0.0
}

/// All topics of a device but its voltages, and its robots, which move.
pub fn topics(_verified: &Verified, _device: &str) -> (Vec<Topic>, Vec<Mover>) {
    (Vec::new(), Vec::new())
}
