//! Distance of each cell from a stop for an agent alone: exact, and the planner's only heuristic.
//!
//! Where the free cells form a rectangle, the distance is Manhattan's and nothing is stored. Elsewhere a breadth-first
//! search from the stop fills a table of two bytes per cell; tables are cached up to [`TABLES_BYTES`] and evicted
//! oldest first.

use std::collections::VecDeque;
use std::rc::Rc;

use rustc_hash::FxHashMap;

use crate::plan::electrode_array::board::{BoardGrid, CellIndex};
use crate::plan::search::Meter;

/// Memory for all tables together, in bytes: 400 tables of a board of 400 by 400.
const TABLES_BYTES: usize = 400 * 400 * 400 * 2;

/// Cells of a breadth-first search per step of the meter.
const CELLS_PER_STEP: u64 = 32;

/// Distance of a cell from which the stop is unreachable.
pub(in crate::plan::electrode_array) const UNREACHABLE: u32 = u32::MAX;

/// Table entry of such a cell.
const NO_WAY: u16 = u16::MAX;

/// The distances to one cell.
#[derive(Debug, Clone)]
pub(in crate::plan::electrode_array) enum DistanceField {
    Manhattan {
        column: u32,
        row: u32,
        width: u32,
    },
    /// Entries are exact up to 65,534 and saturate there, which keeps them lower bounds.
    Table(Rc<[u16]>),
}

impl DistanceField {
    /// Steps from a free cell, or [`UNREACHABLE`].
    #[inline]
    pub(in crate::plan::electrode_array) fn from(&self, cell: CellIndex) -> u32 {
        match self {
            DistanceField::Manhattan { column, row, width } => {
                (cell % width).abs_diff(*column) + (cell / width).abs_diff(*row)
            }
            DistanceField::Table(table) => match table[cell as usize] {
                NO_WAY => UNREACHABLE,
                steps => u32::from(steps),
            },
        }
    }
}

/// Distance fields of one board.
#[derive(Debug)]
pub(in crate::plan::electrode_array) struct Distances {
    open: bool,
    tables: FxHashMap<CellIndex, Rc<[u16]>>,
    oldest: VecDeque<CellIndex>,
}

impl Distances {
    pub(in crate::plan::electrode_array) fn of(board: &BoardGrid) -> Distances {
        Distances { open: board.free_rectangle().is_some(), tables: FxHashMap::default(), oldest: VecDeque::new() }
    }

    /// The distances to a free cell.
    pub(in crate::plan::electrode_array) fn to(
        &mut self,
        board: &BoardGrid,
        stop: CellIndex,
        meter: &mut Meter,
    ) -> DistanceField {
        if self.open {
            let (column, row) = board.place(stop);
            return DistanceField::Manhattan { column, row, width: board.width() };
        }
        if let Some(table) = self.tables.get(&stop) {
            return DistanceField::Table(Rc::clone(table));
        }
        meter.charge(board.cells() as u64 / CELLS_PER_STEP);
        while !self.oldest.is_empty() && (self.tables.len() + 1) * board.cells() * 2 > TABLES_BYTES {
            self.oldest.pop_front().map(|cell| self.tables.remove(&cell));
        }
        let table: Rc<[u16]> = flood(board, stop).into();
        self.oldest.push_back(stop);
        self.tables.insert(stop, Rc::clone(&table));
        DistanceField::Table(table)
    }
}

/// Breadth-first search over the free cells.
fn flood(board: &BoardGrid, stop: CellIndex) -> Vec<u16> {
    let mut table = vec![NO_WAY; board.cells()];
    let (mut ring, mut next) = (vec![stop], Vec::new());
    table[stop as usize] = 0;
    let mut steps = 0u16;
    while !ring.is_empty() {
        steps = (steps + 1).min(NO_WAY - 1);
        for cell in ring.drain(..) {
            for beside in board.neighbours(cell) {
                if table[beside as usize] == NO_WAY {
                    table[beside as usize] = steps;
                    next.push(beside);
                }
            }
        }
        std::mem::swap(&mut ring, &mut next);
    }
    table
}

#[cfg(test)]
mod tests;
