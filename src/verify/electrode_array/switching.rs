//! Which electrodes are on in each step of the board.
//!
//! Input: from which step of the board to which each electrode is on. Output: the set of those that are on, step by step. Cost: n log n
//! for n actuations.

use crate::device::electrode_array::ElectrodeCell;
use rustc_hash::FxHashSet;

/// An electrode that is on from the beginning of a step of the board to the beginning of another.
#[derive(Debug, Clone, Copy)]
pub(super) struct ElectrodePulse {
    pub cell: ElectrodeCell,
    pub from: u64,
    pub to: u64,
}

/// An electrode switched at the beginning of a step of the board; off is ordered before on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Change {
    Off,
    On,
}

/// The electrodes that are on in the course of a step of the task.
#[derive(Debug, Default)]
pub(super) struct Switching {
    /// By step of the board, from the last to the first.
    changes: Vec<(u64, Change, ElectrodeCell)>,
    pub on: FxHashSet<ElectrodeCell>,
}

impl Switching {
    /// Before the first step of the board.
    pub fn new(pulses: &[ElectrodePulse]) -> Switching {
        let both = |pulse: &ElectrodePulse| [(pulse.from, Change::On, pulse.cell), (pulse.to, Change::Off, pulse.cell)];
        let mut changes: Vec<_> = pulses.iter().flat_map(both).collect();
        changes.sort_unstable_by(|one, other| other.cmp(one));
        Switching { changes, on: FxHashSet::default() }
    }

    /// Goes on to a step of the board, never back.
    pub fn advance(&mut self, beat: u64) {
        while let Some((_, change, cell)) = self.changes.pop_if(|(at, ..)| *at <= beat) {
            match change {
                Change::On => self.on.insert(cell),
                Change::Off => self.on.remove(&cell),
            };
        }
    }
}
