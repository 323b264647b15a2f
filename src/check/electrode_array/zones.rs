//! Heaters, detectors and magnets: their electrodes and temperatures.

use super::errors;
use crate::claims::Job;
use crate::claims::electrode_array::{BoardZone, ElectrodeArrayOrder, ZoneSort, ZoneStay};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
use crate::device::instrument::{Bench, InstrumentFacts, heater_setting};
use crate::diagnostic::{Diagnostic, Sink};
use crate::quantity::{Dimension, Quantity};
use crate::source::Span;
use std::collections::{BTreeMap, BTreeSet};

/// Diagnostic for a zone that overlaps an earlier one of its sort, or for a detector longer than the separation.
pub fn misplaced(zone: &BoardZone, before: &[BoardZone], facts: &ElectrodeArrayFacts) -> Option<Diagnostic> {
    let low = |other: &BoardZone| {
        ElectrodeCell::new(zone.from.column.max(other.from.column), zone.from.row.max(other.from.row))
    };
    let alike = before.iter().filter(|other| other.sort == zone.sort);
    if let Some((other, shared)) =
        alike.map(|other| (other, low(other))).find(|(other, low)| zone.contains(*low) && other.contains(*low))
    {
        return Some(errors::zones_overlap(zone, other, shared));
    }
    let sides = [zone.to.column - zone.from.column + 1, zone.to.row - zone.from.row + 1];
    let apart = facts.separation.apart();
    let has_room = zone.sort == ZoneSort::Detector && sides.iter().any(|side| *side > apart);
    has_room.then(|| errors::detector_too_large(zone, sides, apart))
}

/// Reports heaters that need two temperatures in one schedule.
pub fn check_temperatures(jobs: &[Job], sink: &mut Sink) {
    let mut temperatures: BTreeMap<(&str, &str), (f64, Span)> = BTreeMap::new();
    for Heating { device, heater, asked_k, span } in heatings(jobs) {
        let (first_k, first) = *temperatures.entry((device, heater)).or_insert((asked_k, span));
        if first_k.to_bits() != asked_k.to_bits() {
            sink.push(errors::two_temperatures(heater, asked_k, span, first_k, first));
            return;
        }
    }
}

/// Warns, once per heater of the scene, of a temperature that no heater of the board's driver is set to, where the
/// bench sets one.
pub fn warn_of_unset_heaters(jobs: &[Job], bench: &Bench, sink: &mut Sink) {
    let drivers = bench.instruments.iter().filter_map(|(name, instrument)| match &instrument.facts {
        InstrumentFacts::ElectrodeDriver(facts) => Some((name.as_str(), facts)),
        InstrumentFacts::WaveformGenerator(_)
        | InstrumentFacts::DataAcquisition(_)
        | InstrumentFacts::StageController(_)
        | InstrumentFacts::MachineController(_) => None,
    });
    let set: Vec<(&str, u32, u32)> = drivers
        .flat_map(|(name, facts)| facts.heaters_degc.iter().map(move |(number, degc)| (name, *number, *degc)))
        .collect();
    let mut warned = BTreeSet::new();
    for heating in heatings(jobs) {
        let setting = heater_setting(Quantity::new(heating.asked_k, Dimension::TEMPERATURE));
        let is_set = set.iter().any(|heater| Some(heater.2) == setting);
        if !set.is_empty() && !is_set && warned.insert((heating.device, heating.heater)) {
            sink.push(errors::no_heater_so_warm(heating.heater, heating.asked_k, heating.span, setting, &set));
        }
    }
}

/// A stay at a heater.
struct Heating<'j> {
    device: &'j str,
    /// The heater's name in the scene.
    heater: &'j str,
    asked_k: f64,
    span: Span,
}

/// All stays at heaters, in the order of the steps.
fn heatings(jobs: &[Job]) -> impl Iterator<Item = Heating<'_>> {
    let orders = jobs.iter().filter_map(|job| Some((job.device.as_str(), ElectrodeArrayOrder::of(&job.order)?)));
    orders.flat_map(|(device, order)| {
        let operations = order.steps.iter().flat_map(|step| step.action.operations());
        let stays = operations.flat_map(|one| one.zone_stays().map(move |stay| (one.span, stay)));
        stays.filter_map(move |(span, ZoneStay { zone, temperature_k })| {
            let heater = order.zones.get(zone)?.name.as_str();
            Some(Heating { device, heater, asked_k: temperature_k?, span })
        })
    })
}
