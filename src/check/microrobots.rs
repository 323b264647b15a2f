//! Checks of STRING microrobots: the table, what its voltages can reach, the scene, the steps.

pub mod relays;
pub mod suggest;

use super::Checker;
use super::claims::microrobots::{MicrorobotsOrder, Obstacle, Placed};
use super::devices::Device;
use super::tasks::{Parts, Site};
use crate::device::microrobots::{ControlState, Facts};
use crate::diagnostic::Sink;
use std::sync::Arc;

/// A bed: its facts, and the control states that its voltage can reach.
#[derive(Debug, Clone)]
pub struct Bed {
    pub facts: Arc<Facts>,
    pub states: Arc<Vec<ControlState>>,
}

/// A scene as a bed sees it.
#[derive(Debug, Clone)]
pub struct Ground {
    pub obstacles: Arc<Vec<Obstacle>>,
    pub robots: Arc<Vec<Placed>>,
}

/// The facts of a device; `None` after an error.
pub fn bed(_device: &Device, _sink: &mut Sink) -> Option<Bed> {
    None
}

impl Checker<'_> {
    /// A task's body in the kind's own terms; `None` after an error.
    pub fn microrobots_order(&mut self, _site: &Site, _bed: &Bed, _parts: Parts) -> Option<MicrorobotsOrder> {
        None
    }
}
