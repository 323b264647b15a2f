//! Cells of a board, as values of the language.

use crate::check::value::{Value, whole};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};

/// The whole numbers of a cell, which may lie off the board.
pub fn whole_cell(value: &Value) -> Option<[i64; 2]> {
    match value {
        Value::Point(point) if point.len() == 2 => Some([whole(point[0])?, whole(point[1])?]),
        _ => None,
    }
}

/// The cell of two numbers, if the board has it.
pub fn on_board([column, row]: [i64; 2], facts: &ElectrodeArrayFacts) -> Option<ElectrodeCell> {
    let cell = ElectrodeCell::new(u32::try_from(column).ok()?, u32::try_from(row).ok()?);
    facts.holds(cell).then_some(cell)
}
