//! Checks of multi-finger hands: whether a hand is possible, whether it can turn a part, and whether the steps of its
//! tasks are possible.

mod errors;
mod facts;
mod orientation;
mod part;
mod scene;
mod step;
mod steps;
mod walk;

use super::devices::CheckedDevice;
use super::tasks::{Parts, TaskSite};
use super::{CheckedFacts, Checker, KindChecks, KindFacts};
use crate::claims::{Job, Order};
use crate::device::fingers::FingersFacts;
use crate::diagnostic::Sink;
use std::sync::Arc;

impl CheckedFacts for Arc<FingersFacts> {
    fn channel_examples(&self) -> Vec<String> {
        self.channels()
    }

    fn moves_stages(&self) -> bool {
        true
    }

    fn order(&self, checker: &mut Checker, site: &TaskSite, parts: Parts) -> Option<Order> {
        checker.fingers_order(site, self, parts).map(Order::Fingers)
    }
}

/// The checks of the kind.
pub struct FingersChecks;

pub const CHECKS: FingersChecks = FingersChecks;

impl KindChecks for FingersChecks {
    fn facts(&self, device: &CheckedDevice, sink: &mut Sink) -> Option<KindFacts> {
        facts::facts(device, sink).map(|facts| KindFacts::Fingers(Arc::new(facts)))
    }

    fn check_continuity(&self, jobs: &mut [Job], sink: &mut Sink) {
        walk::check_hands(jobs, sink);
    }
}

#[cfg(test)]
mod tests;
