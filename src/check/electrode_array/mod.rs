//! Checks of an electrode array: is the device feasible, does the scene fit it, and can the goals be met?

mod among;
mod board;
mod cells;
mod contamination;
mod cover;
mod errors;
mod forces;
mod goals;
mod liquids;
mod magnets;
mod map;
mod motion;
mod physics;
mod positions;
mod reservoirs;
mod scene;
mod stay_steps;
mod stays;
mod teams;
mod washes;
mod zones;

use super::devices::CheckedDevice;
use super::tasks::{Parts, TaskSite};
use super::wiring::NumberedChannels;
use super::{CheckedFacts, Checker, KindChecks, KindFacts};
use crate::claims::{Claims, Job, Order};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell, ElectrodeMap};
use crate::device::instrument::Drive;
use crate::diagnostic::Sink;
use crate::quantity::Quantity;
use std::collections::BTreeSet;
use std::rc::Rc;

/// Largest default limit of expanded states.
const MOST_BY_DEFAULT: u64 = 64_000_000;

/// Default limit of expanded states in the search of one step: 16 million, plus 2 for each pair of part and cell, at
/// most 64 million.
pub fn default_expansions(facts: &ElectrodeArrayFacts, parts: usize) -> u64 {
    let cells = u64::from(facts.columns) * u64::from(facts.rows);
    let more = cells.saturating_mul(2 * parts as u64);
    (16_000_000 + more).min(MOST_BY_DEFAULT)
}

impl CheckedFacts for Rc<ElectrodeArrayFacts> {
    fn channel_examples(&self) -> Vec<String> {
        let last = ElectrodeCell::new(self.columns, self.rows);
        [ElectrodeCell::new(1, 1), last]
            .map(|cell| ElectrodeArrayFacts::channel(self.first_on_channel_of(cell)))
            .to_vec()
    }

    fn all_channels(&self) -> Vec<String> {
        let cells =
            (1..=self.rows).flat_map(|row| (1..=self.columns).map(move |column| ElectrodeCell::new(column, row)));
        let firsts = self.map.as_ref().map(|map| first_of_channels(map)).filter(|firsts| !firsts.is_empty());
        let names = |cell: &ElectrodeCell| firsts.as_ref().is_none_or(|firsts| firsts.contains(cell));
        let electrodes = cells.filter(names).map(ElectrodeArrayFacts::channel);
        let pads = self.reservoirs.iter().flat_map(|reservoirs| reservoirs.pads());
        electrodes.chain(pads.map(ElectrodeArrayFacts::pad_channel)).collect()
    }

    fn pitch(&self) -> Option<String> {
        Some(format!("cells of {}", Quantity::length_um(self.pitch_um())))
    }

    fn has_channel(&self, name: &str) -> bool {
        self.electrode(name).is_some() || self.pad(name).is_some()
    }

    fn shared_channel(&self, name: &str) -> Option<String> {
        let first = self.first_on_channel_of(self.named_electrode(name)?);
        Some(ElectrodeArrayFacts::channel(first)).filter(|channel| channel != name)
    }

    fn numbered_channels(&self) -> Option<NumberedChannels> {
        let numbered = self.map.iter().flat_map(|map| {
            let firsts = first_of_channels(map);
            map.numbered().filter(move |(cell, _)| firsts.contains(cell))
        });
        let named = numbered.map(|(cell, number)| (ElectrodeArrayFacts::channel(cell), number));
        let pads = self.reservoirs.iter().flat_map(|reservoirs| reservoirs.pads());
        let pads = pads.map(|pad| (ElectrodeArrayFacts::pad_channel(pad), pad));
        Some(NumberedChannels { on_v: self.potential_v, channels: named.chain(pads).collect() })
    }

    fn order(&self, checker: &mut Checker, site: &TaskSite, parts: Parts) -> Option<Order> {
        checker.electrode_array_order(site, self, parts).map(Order::ElectrodeArray)
    }
}

/// The first electrode of each numbered channel of a board; it gives the channel its name.
fn first_of_channels(map: &ElectrodeMap) -> BTreeSet<ElectrodeCell> {
    map.by_channel().values().filter_map(|cells| cells.first().copied()).collect()
}

/// The checks of electrode arrays.
pub struct ElectrodeArrayChecks;

pub const CHECKS: ElectrodeArrayChecks = ElectrodeArrayChecks;

impl KindChecks for ElectrodeArrayChecks {
    fn facts(&self, device: &CheckedDevice, sink: &mut Sink) -> Option<KindFacts> {
        board::facts(device, sink).map(|facts| KindFacts::ElectrodeArray(Rc::new(facts)))
    }

    fn check_continuity(&self, jobs: &mut [Job], sink: &mut Sink) {
        let errors = sink.errors();
        let mut before = positions::check_positions(jobs, sink);
        if sink.errors() == errors && washes::insert_washes(jobs, &before, sink) {
            before = positions::check_positions(jobs, sink);
        }
        contamination::check_contamination(jobs, before, sink);
        zones::check_temperatures(jobs, sink);
    }

    fn warn_of_mismatches(&self, claims: &Claims, idle: &[(String, Drive)], sink: &mut Sink) {
        zones::warn_of_unset_heaters(&claims.jobs, &claims.bench, sink);
        liquids::warn_of_wide_droplets(&claims.jobs, sink);
        magnets::raised(claims, idle, sink);
        magnets::halves_stay(&claims.jobs, sink);
    }
}

#[cfg(test)]
mod tests;
