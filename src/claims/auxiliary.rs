//! Actions of tasks on auxiliary outputs, and the events that tasks wait for.

use crate::device::instrument::HoldTerms;
use serde::{Deserialize, Serialize};

/// A step that switches an auxiliary output, at the instant at which the previous step ends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AuxiliaryEvent {
    /// Index into the job's steps.
    pub step: usize,
    /// The output's name.
    pub output: String,
    pub action: AuxiliaryAction,
}

/// A step that waits for an input or a person; for the device it is a wait of the duration in its terms.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hold {
    /// Index into the job's steps.
    pub step: usize,
    pub terms: HoldTerms,
}

/// Action on an auxiliary output.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AuxiliaryAction {
    /// Takes the level that is not the rest level, for the length of a pulse.
    Pulse,
    /// Goes high, until it is set again or the schedule ends.
    High,
    /// Goes low, likewise.
    Low,
    /// Takes this voltage, likewise; only for an output that takes any voltage between its two levels.
    Volts(f64),
}
