//! The parts on a board, with their cells.
//!
//! An assay may have many more parts than its board holds at once, so each beat costs the parts that are on the board.

use crate::device::electrode_array::ElectrodeCell;
use std::ops::Index;

/// Cells of the parts of a board during the replay.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PartsOnBoard {
    /// By part: its cell; `None` for one that is not on the board, as after a merge.
    cells: Vec<Option<ElectrodeCell>>,
    /// The parts on the board, in order.
    there: Vec<usize>,
}

impl PartsOnBoard {
    /// Parts on these cells.
    pub fn new(cells: Vec<Option<ElectrodeCell>>) -> PartsOnBoard {
        let there = (0..cells.len()).filter(|part| cells[*part].is_some()).collect();
        PartsOnBoard { cells, there }
    }

    /// The parts on the board with their cells, in order of the parts.
    pub fn iter(&self) -> impl Iterator<Item = (usize, ElectrodeCell)> {
        self.there.iter().filter_map(|part| Some((*part, self.cells[*part]?)))
    }

    /// Number of parts on the board.
    pub fn count(&self) -> usize {
        self.there.len()
    }

    /// Puts a part on a cell, whether or not it is on the board.
    pub fn put(&mut self, part: usize, cell: ElectrodeCell) {
        if self.cells[part].replace(cell).is_none() {
            let place = self.there.partition_point(|other| *other < part);
            self.there.insert(place, part);
        }
    }

    /// Takes a part off the board.
    pub fn remove(&mut self, part: usize) {
        if self.cells[part].take().is_some() {
            self.there.retain(|other| *other != part);
        }
    }
}

impl Index<usize> for PartsOnBoard {
    type Output = Option<ElectrodeCell>;

    fn index(&self, part: usize) -> &Option<ElectrodeCell> {
        &self.cells[part]
    }
}
