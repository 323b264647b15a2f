//! What tasks do to auxiliary outputs, and what they wait for.

use crate::device::instrument::HoldTerms;
use serde::{Deserialize, Serialize};

/// A step that switches an auxiliary output, at the instant at which the step before it has ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AuxiliaryEvent {
    /// Index of the job's steps.
    pub step: usize,
    /// The output's name.
    pub output: String,
    pub action: AuxiliaryAction,
}

/// A step that waits for an input or a person; to the device it is a wait of the duration in its terms.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hold {
    /// Index of the job's steps.
    pub step: usize,
    pub terms: HoldTerms,
}

/// What happens to an auxiliary output.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum AuxiliaryAction {
    /// It has the level at which it does not rest, for the length of a pulse.
    Pulse,
    /// It is high from here on, until it is set again or the schedule ends.
    High,
    /// It is low from here on.
    Low,
    /// It is at this voltage from here on; only where the output takes every one between its two levels.
    Volts(f64),
}
