//! Checks of beds, of the reach of their voltages, of scenes and of goals.

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

/// Default limit of expansions in the search of one step.
pub const DEFAULT_EXPANSIONS: u64 = 200_000;

/// A bed: its facts, and the control states that its voltage can reach.
#[derive(Debug, Clone)]
pub struct CheckedBed {
    pub facts: Arc<MicrorobotsFacts>,
    pub states: Arc<Vec<ControlState>>,
}

#[cfg(test)]
mod tests;
