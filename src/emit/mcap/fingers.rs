//! The pictures of a hand: the object, the tips, the forces at its contacts and its sections.

use super::Topic;
use super::frames::Mover;
use crate::check::claims::fingers::FingersOrder;
use crate::verify::Verified;

/// From where to where the picture reaches along x.
pub fn reach_um(order: &FingersOrder) -> [f64; 2] {
    [-order.facts.range_um[0], order.facts.range_um[0]]
}

/// All topics of a device but its positions, and its object and tips, which move.
pub fn topics(_verified: &Verified, _device: &str) -> (Vec<Topic>, Vec<Mover>) {
    (Vec::new(), Vec::new())
}
