//! Cells of a board, as values of the language.

use crate::check::value::{Value, whole};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};

/// The column and row of a cell as whole numbers; it may lie off the board.
pub fn whole_cell(value: &Value) -> Option<[i64; 2]> {
    match value {
        Value::Point(point) if point.len() == 2 => Some([whole(point[0])?, whole(point[1])?]),
        _ => None,
    }
}

/// The cell of a column and a row, if it is on the board.
pub fn on_board([column, row]: [i64; 2], facts: &ElectrodeArrayFacts) -> Option<ElectrodeCell> {
    let cell = ElectrodeCell::new(u32::try_from(column).ok()?, u32::try_from(row).ok()?);
    facts.is_on_board(cell).then_some(cell)
}
