//! Shared channels: the effect of one switch on all droplets in reach.
//!
//! Input: the channel numbers of the cells of a board. Output: the electrodes that a channel switches, and those of
//! them that act when it is on. Promise: the replay derives every electrode that is on from this module, so that the
//! rules on pulls see all electrodes of a channel. If an electrode of a shared channel acts on a droplet that it
//! should not carry, the broken rule is `Broadcast`. A channel counts as used if any of its electrodes carries or
//! holds a part. Cost: one pass over the map, then one lookup per electrode.

use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
use crate::verify::rule::Rule;
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeMap;

/// The channels of a board that switch several electrodes.
pub(super) struct JudgedChannels {
    /// The electrodes of each channel.
    groups: Vec<Vec<ElectrodeCell>>,
    /// Index in `groups` of each electrode that shares its channel.
    of: FxHashMap<ElectrodeCell, usize>,
    disabled: FxHashSet<ElectrodeCell>,
}

impl JudgedChannels {
    /// The shared channels of a board; none if its cells have no channel numbers.
    pub fn new(facts: &ElectrodeArrayFacts) -> JudgedChannels {
        let mut places: BTreeMap<u32, Vec<ElectrodeCell>> = BTreeMap::new();
        let (columns, channels) =
            facts.map.as_ref().map_or((1, &[][..]), |map| (map.columns.max(1), &map.channels[..]));
        for (place, number) in (0u32..).zip(channels) {
            let cell = ElectrodeCell::new(place % columns + 1, place / columns + 1);
            number.iter().for_each(|number| places.entry(*number).or_default().push(cell));
        }
        let groups: Vec<Vec<ElectrodeCell>> = places.into_values().filter(|cells| cells.len() > 1).collect();
        let with_group = |(group, cells): (usize, &Vec<ElectrodeCell>)| -> Vec<(ElectrodeCell, usize)> {
            cells.iter().map(|cell| (*cell, group)).collect()
        };
        let of = groups.iter().enumerate().flat_map(with_group).collect();
        let disabled = facts.map.iter().flat_map(|map| map.disabled.iter().copied()).collect();
        JudgedChannels { groups, of, disabled }
    }

    /// Number of electrodes on shared channels.
    pub fn electrodes(&self) -> usize {
        self.of.len()
    }

    /// Whether an electrode shares its channel.
    pub fn is_shared(&self, electrode: ElectrodeCell) -> bool {
        self.shared(electrode).is_some()
    }

    /// The electrodes on the channel of an electrode, including itself.
    pub fn switches(&self, electrode: ElectrodeCell) -> Vec<ElectrodeCell> {
        self.of.get(&electrode).map_or_else(|| vec![electrode], |group| self.groups[*group].clone())
    }

    /// The electrodes that act when the channel of an electrode is on: those that work. A channel of one electrode
    /// always acts.
    pub fn lights(&self, electrode: ElectrodeCell) -> Vec<ElectrodeCell> {
        let mut all = self.switches(electrode);
        if all.len() > 1 {
            all.retain(|cell| !self.disabled.contains(cell));
        }
        all
    }

    /// The shared channel of an electrode, as an index of this module.
    pub fn shared(&self, electrode: ElectrodeCell) -> Option<usize> {
        self.of.get(&electrode).copied()
    }

    /// The shared channels of some electrodes.
    pub fn all_shared<'e>(&self, electrodes: impl Iterator<Item = &'e ElectrodeCell>) -> FxHashSet<usize> {
        electrodes.filter_map(|electrode| self.shared(*electrode)).collect()
    }

    /// The rule that is broken if these electrodes act on a part that they must not.
    pub fn blamed(&self, acting: &[ElectrodeCell]) -> Rule {
        if acting.iter().any(|cell| self.is_shared(*cell)) { Rule::Broadcast } else { Rule::Pull }
    }
}
