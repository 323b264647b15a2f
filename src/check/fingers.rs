//! Is this hand possible, is this object one that it can turn, are these steps of it?

use super::Checker;
use super::devices::Device;
use super::tasks::{Parts, Site};
use crate::check::claims::fingers::FingersOrder;
use crate::device::fingers::Facts;
use crate::diagnostic::Sink;

/// The facts of a hand; `None` after an error.
pub fn facts(_device: &Device, _sink: &mut Sink) -> Option<Facts> {
    None
}

impl Checker<'_> {
    /// A task's body in the kind's own terms; `None` after an error.
    pub fn fingers_order(&mut self, _site: &Site, _facts: &Facts, _parts: Parts) -> Option<FingersOrder> {
        None
    }
}
