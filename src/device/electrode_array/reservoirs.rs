//! How the reservoirs of a board make droplets: by pads of their own beside its electrodes, which are switched frame by frame.

use super::ElectrodeCell;
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// Most frames in which a reservoir makes a droplet.
pub const MAX_DISPENSE_FRAMES: usize = 64;

/// The pads of all reservoirs of a board.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ReservoirPads {
    /// Duration of a frame: a whole number of steps of the board.
    pub frame_ns: u64,
    /// In the order in which the device lists its outlets.
    pub sequences: Vec<DispenseSequence>,
}

/// The frames in which one reservoir makes a droplet.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DispenseSequence {
    /// The electrode on which the droplet is in the end.
    pub outlet: ElectrodeCell,
    /// At least one; the outlet is on in the last one.
    pub frames: Vec<DispenseFrame>,
}

/// What is on in a frame; all other pads of the board are off.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DispenseFrame {
    /// The driver's channels of the pads, in order.
    pub pads: Vec<u32>,
    /// Whether the electrode at the outlet is on.
    pub outlet: bool,
}

impl ReservoirPads {
    /// The frames of the reservoir at an outlet.
    pub fn at(&self, outlet: ElectrodeCell) -> Option<&DispenseSequence> {
        self.sequences.iter().find(|sequence| sequence.outlet == outlet)
    }

    /// Duration of all frames of a sequence.
    pub fn duration_ns(&self, sequence: &DispenseSequence) -> u64 {
        self.frame_ns.saturating_mul(sequence.frames.len() as u64)
    }

    /// The channels of all pads, in order.
    pub fn pads(&self) -> BTreeSet<u32> {
        self.sequences
            .iter()
            .flat_map(|sequence| &sequence.frames)
            .flat_map(|frame| frame.pads.iter().copied())
            .collect()
    }
}
