//! Is this bed possible, what can its voltage reach, is this scene possible for it, are these goals?

mod bodies;
mod docking;
mod facts;
mod goals;
mod ground;
pub mod relays;
pub mod suggest;
mod table;
mod validity;
mod walk;

pub use facts::bed;
pub use ground::BedScene;
pub use walk::beds_agree;

use crate::device::microrobots::{ControlState, MicrorobotsFacts};
use std::sync::Arc;

/// Ways that the search of one step may expand where the task does not say.
pub const DEFAULT_EXPANSIONS: u64 = 200_000;

/// A bed: its facts, and the control states that its voltage can reach.
#[derive(Debug, Clone)]
pub struct CheckedBed {
    pub facts: Arc<MicrorobotsFacts>,
    pub states: Arc<Vec<ControlState>>,
}

#[cfg(test)]
mod tests;
