//! Motion of a droplet round its mixing loop.

use crate::device::electrode_array::ElectrodeCell;

/// The rim of a block of electrodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Loop {
    /// The cell with the least column and row.
    pub corner: ElectrodeCell,
    /// Columns and rows.
    sides: [u32; 2],
}

impl Loop {
    /// The loop with a corner and a number of columns and rows.
    pub fn new(corner: ElectrodeCell, sides: [u32; 2]) -> Loop {
        Loop { corner, sides }
    }

    /// Whether the anticlockwise loop leads from one cell directly to another: to the right along the lowest row, up
    /// along the last column, to the left along the highest row, down along the first column.
    fn leads(&self, from: ElectrodeCell, to: ElectrodeCell) -> bool {
        let along = [from.column.checked_sub(self.corner.column), from.row.checked_sub(self.corner.row)];
        let [Some(column), Some(row)] = along else { return false };
        let [columns, rows] = self.sides.map(|side| side - 1);
        let due = if row == 0 && column < columns {
            [1, 0]
        } else if column == columns && row < rows {
            [0, 1]
        } else if row == rows && (1..=columns).contains(&column) {
            [-1, 0]
        } else if column == 0 && (1..=rows).contains(&row) {
            [0, -1]
        } else {
            return false;
        };
        [(from.column, to.column), (from.row, to.row)].map(|(from, to)| i64::from(to) - i64::from(from)) == due
    }
}

/// Progress of a droplet round its loop.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Mixing {
    /// The beat after which it left the corner, and the last beat of its uninterrupted motion since.
    round: Option<(u64, u64)>,
    /// Its cell before its last move, and the beat of that move.
    moved: Option<(ElectrodeCell, u64)>,
}

impl Mixing {
    /// Notes a move in a beat.
    pub fn come_from(&mut self, from: ElectrodeCell, beat: u64) {
        self.moved = Some((from, beat));
    }

    /// The beat after which it began to go round, if it is still going round after this one. It can begin only after
    /// `free`, the beat of its last other act.
    pub fn since(&mut self, around: Loop, cell: ElectrodeCell, free: u64, beat: u64) -> Option<u64> {
        let (from, _) =
            self.moved.filter(|(from, moved)| *moved == beat && beat > free && around.leads(*from, cell))?;
        self.round = match self.round {
            Some((since, until)) if until + 1 >= beat => Some((since, beat)),
            Some(_) | None => (from == around.corner).then_some((beat - 1, beat)),
        };
        self.round.map(|(since, _)| since)
    }
}
