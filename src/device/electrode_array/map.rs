//! The map of a board: where it has electrodes, their channel numbers on the driver, and which of them do not work.

use super::ElectrodeCell;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Greatest channel number of a driver.
pub const MAX_CHANNEL: u32 = 4095;

/// Most electrodes of a board that share their channels.
pub const MAX_SHARING: usize = 10_000;

/// Electrodes of a board that is not a plain rectangle of unnumbered electrodes.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ElectrodeMap {
    /// Columns of the board: the length of a row in `channels`.
    pub columns: u32,
    /// The channel number of each electrode on the driver, 0 to [`MAX_CHANNEL`], row by row from row 1; `None` at a
    /// place without an electrode. A number that occurs several times is a shared channel: one switch for all of its
    /// electrodes. Empty if the electrodes have no numbers; then every place has an electrode with its own channel.
    pub channels: Vec<Option<u32>>,
    /// Electrodes that do not work, sorted, each once.
    pub disabled: Vec<ElectrodeCell>,
}

impl ElectrodeMap {
    /// Whether a place of the board has an electrode.
    pub fn has_electrode(&self, cell: ElectrodeCell) -> bool {
        self.channels.is_empty() || self.channel(cell).is_some()
    }

    /// Whether there is a working electrode at a place.
    pub fn works(&self, cell: ElectrodeCell) -> bool {
        self.has_electrode(cell) && self.disabled.binary_search(&cell).is_err()
    }

    /// The channel number of an electrode on the driver.
    pub fn channel(&self, cell: ElectrodeCell) -> Option<u32> {
        let row = cell.row.checked_sub(1)? as usize * self.columns as usize;
        *self.channels.get(row + cell.column.checked_sub(1)? as usize)?
    }

    /// The electrodes on the same channel as one, itself included, row by row from row 1.
    pub fn on_channel_of(&self, cell: ElectrodeCell) -> Vec<ElectrodeCell> {
        match self.channel(cell) {
            Some(own) => self.numbered().filter(|(_, number)| *number == own).map(|(cell, _)| cell).collect(),
            None => vec![cell],
        }
    }

    /// The first electrode on the same channel as one, row by row from row 1.
    pub fn first_on_channel_of(&self, cell: ElectrodeCell) -> ElectrodeCell {
        let own = self.channel(cell);
        self.numbered().find(|(_, number)| Some(*number) == own).map_or(cell, |(first, _)| first)
    }

    /// Whether some channel switches several electrodes.
    pub fn is_shared(&self) -> bool {
        let mut known = BTreeSet::new();
        self.channels.iter().flatten().any(|number| !known.insert(*number))
    }

    /// The electrodes of each channel, row by row from row 1; empty if the electrodes have no numbers.
    pub fn by_channel(&self) -> BTreeMap<u32, Vec<ElectrodeCell>> {
        let mut channels: BTreeMap<u32, Vec<ElectrodeCell>> = BTreeMap::new();
        self.numbered().for_each(|(cell, number)| channels.entry(number).or_default().push(cell));
        channels
    }

    /// Every numbered electrode with its channel number, row by row from row 1.
    pub fn numbered(&self) -> impl Iterator<Item = (ElectrodeCell, u32)> + '_ {
        self.channels.iter().zip(0u32..).filter_map(|(number, index)| {
            let cell = ElectrodeCell::new(index % self.columns + 1, index / self.columns + 1);
            number.map(|number| (cell, number))
        })
    }
}
