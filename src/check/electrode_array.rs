//! Is this electrode array possible, is this scene possible for it, are these goals?

use super::Checker;
use super::claims::Job;
use super::claims::electrode_array::ElectrodeArrayOrder;
use super::devices::Device;
use super::tasks::{Parts, Site};
use crate::device::electrode_array;
use crate::diagnostic::Sink;

/// A scene as one device meets it.
#[derive(Clone)]
pub struct Judged;

/// The facts of a complete device; `None` after an error.
pub fn facts(device: &Device, sink: &mut Sink) -> Option<electrode_array::Facts> {
    let _ = (device, sink);
    None
}

/// Where parts stand between the tasks of a schedule, as far as that is known before planning.
pub fn places_agree(jobs: &[Job], sink: &mut Sink) {
    let _ = (jobs, sink);
}

impl Checker<'_> {
    /// A task's body in the kind's own terms; `None` after an error.
    pub fn electrode_array_order(
        &mut self,
        site: &Site,
        facts: &electrode_array::Facts,
        parts: Parts,
    ) -> Option<ElectrodeArrayOrder> {
        let _ = (site, facts, parts);
        None
    }
}
