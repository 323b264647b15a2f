//! Heaters, detectors and magnets: which electrodes they have, and how warm they are.

use super::errors;
use crate::claims::Job;
use crate::claims::electrode_array::{
    AssayOperation, BoardZone, ElectrodeArrayAction, ElectrodeArrayOrder, ZoneSort, ZoneStay,
};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
use crate::diagnostic::{Diagnostic, Sink};
use crate::source::Span;
use std::collections::BTreeMap;

/// Whether an electrode is in a zone.
pub fn is_in(zone: &BoardZone, cell: ElectrodeCell) -> bool {
    (zone.from.column..=zone.to.column).contains(&cell.column) && (zone.from.row..=zone.to.row).contains(&cell.row)
}

/// What is wrong with a zone beside those before it.
pub fn misplaced(zone: &BoardZone, before: &[BoardZone], facts: &ElectrodeArrayFacts) -> Option<Diagnostic> {
    let low = |other: &BoardZone| {
        ElectrodeCell::new(zone.from.column.max(other.from.column), zone.from.row.max(other.from.row))
    };
    let alike = before.iter().filter(|other| other.sort == zone.sort);
    if let Some((other, shared)) =
        alike.map(|other| (other, low(other))).find(|(other, low)| is_in(zone, *low) && is_in(other, *low))
    {
        return Some(errors::zones_overlap(zone, other, shared));
    }
    let sides = [zone.to.column - zone.from.column + 1, zone.to.row - zone.from.row + 1];
    let apart = facts.separation.apart();
    let has_room = zone.sort == ZoneSort::Detector && sides.iter().any(|side| *side > apart);
    has_room.then(|| errors::detector_too_large(zone, sides, apart))
}

/// Reports heaters that are to have two temperatures in one schedule.
pub fn agree(jobs: &[Job], sink: &mut Sink) {
    let mut temperatures: BTreeMap<(&str, &str), (f64, Span)> = BTreeMap::new();
    for job in jobs {
        let Some(order) = ElectrodeArrayOrder::of(&job.order) else { continue };
        let operations = order.steps.iter().flat_map(|step| operations_of(&step.action));
        for (operation, stay) in operations.flat_map(|one| one.zone_stays().map(move |stay| (one, stay))) {
            let ZoneStay { zone, temperature_k: Some(asked_k) } = stay else { continue };
            let Some(zone) = order.zones.get(zone) else { continue };
            let key = (job.device.as_str(), zone.name.as_str());
            let (first_k, first) = *temperatures.entry(key).or_insert((asked_k, operation.span));
            if first_k.to_bits() != asked_k.to_bits() {
                sink.push(errors::two_temperatures(&zone.name, (asked_k, operation.span), (first_k, first)));
                return;
            }
        }
    }
}

fn operations_of(action: &ElectrodeArrayAction) -> &[AssayOperation] {
    match action {
        ElectrodeArrayAction::Assay(operations) => operations,
        ElectrodeArrayAction::Move(_) | ElectrodeArrayAction::Wait(_) => &[],
    }
}
