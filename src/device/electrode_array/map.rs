//! The map of a board: which places have an electrode, the number of each on the board's driver, and which do not work.

use super::ElectrodeCell;
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};

/// Greatest number of a driver's channel.
pub const MAX_CHANNEL: u32 = 4095;

/// Most electrodes of a board that share their channels.
pub const MAX_SHARING: usize = 10_000;

/// Electrodes of a board that is no plain rectangle of nameless electrodes.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct ElectrodeMap {
    /// Columns of the board: the length of a row in `channels`.
    pub columns: u32,
    /// The number of each electrode's channel on the driver, 0 to [`MAX_CHANNEL`], row by row from row 1; `None` at a place without an
    /// electrode. A number at several places is a shared channel: one switch for all of them. Empty where the electrodes have no numbers:
    /// then every place has one, with a channel of its own.
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

    /// The electrodes on the channel of one, itself among them, row by row from row 1.
    pub fn on_channel_of(&self, cell: ElectrodeCell) -> Vec<ElectrodeCell> {
        match self.channel(cell) {
            Some(own) => self.numbered().filter(|(_, number)| *number == own).map(|(cell, _)| cell).collect(),
            None => vec![cell],
        }
    }

    /// The first of them.
    pub fn first_on_channel_of(&self, cell: ElectrodeCell) -> ElectrodeCell {
        let own = self.channel(cell);
        self.numbered().find(|(_, number)| Some(*number) == own).map_or(cell, |(first, _)| first)
    }

    /// Whether some channel switches several electrodes.
    pub fn is_shared(&self) -> bool {
        let mut known = BTreeSet::new();
        self.channels.iter().flatten().any(|number| !known.insert(*number))
    }

    /// The channels with their electrodes, each row by row from row 1; none where the electrodes have no numbers.
    pub fn by_channel(&self) -> BTreeMap<u32, Vec<ElectrodeCell>> {
        let mut channels: BTreeMap<u32, Vec<ElectrodeCell>> = BTreeMap::new();
        self.numbered().for_each(|(cell, number)| channels.entry(number).or_default().push(cell));
        channels
    }

    /// Every numbered electrode with its number, row by row from row 1.
    pub fn numbered(&self) -> impl Iterator<Item = (ElectrodeCell, u32)> + '_ {
        self.channels.iter().zip(0u32..).filter_map(|(number, index)| {
            let cell = ElectrodeCell::new(index % self.columns + 1, index / self.columns + 1);
            number.map(|number| (cell, number))
        })
    }
}
