//! Checks of beds, of the reach of their voltages, of scenes and of goals.

mod bodies;
mod docking;
mod errors;
mod facts;
mod goals;
mod ground;
pub mod relays;
pub mod suggest;
mod table;
mod validity;
mod walk;

use super::devices::CheckedDevice;
use super::tasks::{Parts, TaskSite};
use super::{CheckedFacts, Checker, KindChecks, KindFacts};
use crate::claims::{Job, Order};
use crate::device::microrobots::{CHANNEL, ControlState, MicrorobotsFacts};
use crate::diagnostic::Sink;
use std::rc::Rc;
use std::sync::Arc;

/// A bed: its facts, and the control states that its voltage can reach.
#[derive(Debug, Clone)]
pub struct CheckedBed {
    pub facts: Arc<MicrorobotsFacts>,
    pub states: Arc<Vec<ControlState>>,
}

impl CheckedFacts for Rc<CheckedBed> {
    fn channel_examples(&self) -> Vec<String> {
        vec![CHANNEL.to_owned()]
    }

    fn order(&self, checker: &mut Checker, site: &TaskSite, parts: Parts) -> Option<Order> {
        checker.microrobots_order(site, self, parts).map(Order::Microrobots)
    }
}

/// The checks of the kind.
pub struct MicrorobotsChecks;

pub const CHECKS: MicrorobotsChecks = MicrorobotsChecks;

impl KindChecks for MicrorobotsChecks {
    fn facts(&self, device: &CheckedDevice, sink: &mut Sink) -> Option<KindFacts> {
        facts::bed(device, sink).map(|bed| KindFacts::Microrobots(Rc::new(bed)))
    }

    fn check_continuity(&self, jobs: &mut [Job], sink: &mut Sink) {
        walk::check_beds(jobs, sink);
    }
}

#[cfg(test)]
mod tests;
