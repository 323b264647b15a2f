//! Dispensing sequences: reservoirs dispense droplets by pads of their own beside the board's electrodes, switched
//! frame by frame.

use super::ElectrodeCell;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Most frames of one dispensing sequence.
pub const MAX_DISPENSE_FRAMES: usize = 64;

/// The pads and dispensing sequences of all reservoirs of a board.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReservoirPads {
    /// Duration of a frame: a whole number of steps of the board.
    pub frame_ns: u64,
    /// In the order in which the device lists the outlets.
    pub sequences: Vec<DispenseSequence>,
}

/// The frames in which one reservoir dispenses a droplet.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DispenseSequence {
    /// The electrode on which the dispensed droplet ends.
    pub outlet: ElectrodeCell,
    /// At least one; the outlet is on in the last one.
    pub frames: Vec<DispenseFrame>,
}

/// The pads that are on during a frame; all other pads of the board are off.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DispenseFrame {
    /// The driver's channels of the pads, sorted.
    pub pads: Vec<u32>,
    /// Whether the electrode at the outlet is on.
    pub outlet: bool,
}

impl ReservoirPads {
    /// The sequence of the reservoir at an outlet.
    pub fn at(&self, outlet: ElectrodeCell) -> Option<&DispenseSequence> {
        self.sequences.iter().find(|sequence| sequence.outlet == outlet)
    }

    /// Duration of all frames of a sequence together.
    pub fn duration_ns(&self, sequence: &DispenseSequence) -> u64 {
        self.frame_ns.saturating_mul(sequence.frames.len() as u64)
    }

    /// The channels of all pads, sorted.
    pub fn pads(&self) -> BTreeSet<u32> {
        self.sequences
            .iter()
            .flat_map(|sequence| &sequence.frames)
            .flat_map(|frame| frame.pads.iter().copied())
            .collect()
    }
}
