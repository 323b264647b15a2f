//! Limits on the stays of an assay.

use crate::claims::electrode_array::AssayOperation;
use crate::device::electrode_array::{ElectrodeArrayFacts, MAX_STAY_STEPS, MAX_STAY_STEPS_OF_PART};
use std::collections::BTreeMap;

/// Steps of the stays so far.
#[derive(Debug, Default)]
pub struct StaySteps {
    all: u64,
    /// By part.
    of_parts: BTreeMap<usize, u64>,
}

/// Stays that take more steps than can be planned.
#[derive(Debug)]
pub struct StayExcess {
    /// The part whose stays they are; `None` if they are those of all parts together.
    pub part: Option<usize>,
    /// The steps, and their limit.
    pub steps: [u64; 2],
}

impl StaySteps {
    /// Adds the stay of an operation; returns the limit that it exceeds, if it does.
    pub fn add(&mut self, operation: &AssayOperation, facts: &ElectrodeArrayFacts) -> Option<StayExcess> {
        let steps = operation.stay_steps(facts);
        self.all = self.all.saturating_add(steps);
        let own = self.of_parts.entry(operation.part).or_default();
        *own = own.saturating_add(steps);
        if *own > MAX_STAY_STEPS_OF_PART {
            return Some(StayExcess { part: Some(operation.part), steps: [*own, MAX_STAY_STEPS_OF_PART] });
        }
        (self.all > MAX_STAY_STEPS).then_some(StayExcess { part: None, steps: [self.all, MAX_STAY_STEPS] })
    }
}
