//! The map of a board: which places have an electrode, the number of each on the board's driver, and which do not work.

use super::ElectrodeCell;
use serde::{Deserialize, Serialize};

/// Greatest number of a driver's channel.
pub const MAX_CHANNEL: u32 = 4095;

/// Electrodes of a board that is no plain rectangle of nameless electrodes.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ElectrodeMap {
    /// Columns of the board: the length of a row in `channels`.
    pub columns: u32,
    /// The number of each electrode's channel on the driver, 0 to [`MAX_CHANNEL`], row by row from row 1; `None` at a place without an
    /// electrode. Each number at most once. Empty where the electrodes have no numbers: then every place has one.
    pub channels: Vec<Option<u32>>,
    /// Electrodes that do not work, in order, each once.
    pub disabled: Vec<ElectrodeCell>,
}

impl ElectrodeMap {
    /// Whether a place of the board has an electrode.
    pub fn has_electrode(&self, cell: ElectrodeCell) -> bool {
        self.channels.is_empty() || self.channel(cell).is_some()
    }

    /// Whether the electrode at a place can be on.
    pub fn works(&self, cell: ElectrodeCell) -> bool {
        self.has_electrode(cell) && self.disabled.binary_search(&cell).is_err()
    }

    /// The number of an electrode's channel on the driver.
    pub fn channel(&self, cell: ElectrodeCell) -> Option<u32> {
        let row = cell.row.checked_sub(1)? as usize * self.columns as usize;
        *self.channels.get(row + cell.column.checked_sub(1)? as usize)?
    }

    /// Every numbered electrode with its number, row by row from row 1.
    pub fn numbered(&self) -> impl Iterator<Item = (ElectrodeCell, u32)> + '_ {
        self.channels.iter().zip(0u32..).filter_map(|(number, index)| {
            let cell = ElectrodeCell::new(index % self.columns + 1, index / self.columns + 1);
            number.map(|number| (cell, number))
        })
    }
}
