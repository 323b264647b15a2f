//! Droplets held by a magnet: whether the bench raises a magnet meanwhile, and whether a droplet split afterwards stays
//! over it.

use super::errors;
use crate::claims::auxiliary::AuxiliaryAction;
use crate::claims::electrode_array::{AssayOperation, BoardZone, ElectrodeArrayOrder, ZoneSort};
use crate::claims::{Claims, Job};
use crate::device::instrument::{Bench, Drive, InstrumentFacts};
use crate::diagnostic::Sink;
use std::collections::{BTreeMap, BTreeSet};

/// Warns of droplets that are held while all magnets that the bench switches are down, once per magnet of a scene.
/// `idle` are the wired outputs that no step switches.
pub fn raised(claims: &Claims, idle: &[(String, Drive)], sink: &mut Sink) {
    let bench = &claims.bench;
    let own = bench.drives.iter().filter_map(|(channel, drive)| Some((channel.split('.').next()?, drive)));
    let own = own.filter(|(name, _)| claims.outputs.contains_key(*name));
    let all = own.chain(idle.iter().map(|(name, drive)| (name.as_str(), drive)));
    let switches: BTreeSet<&str> =
        all.filter(|(_, drive)| raises_a_magnet(bench, drive)).map(|(name, _)| name).collect();
    let Some(first) = switches.first() else { return };
    let rests_high = |name: &&str| claims.outputs.get(*name).is_some_and(|output| output.rest_v == output.high_v);
    let mut up: BTreeSet<&str> = switches.iter().copied().filter(rests_high).collect();
    let mut warned = BTreeSet::new();
    for job in &claims.jobs {
        let Some(order) = ElectrodeArrayOrder::of(&job.order) else {
            job.events.iter().for_each(|event| set(&mut up, &switches, &event.output, event.action));
            continue;
        };
        for (index, step) in order.steps.iter().enumerate() {
            let now = job.events.iter().filter(|event| event.step == index);
            now.for_each(|event| set(&mut up, &switches, &event.output, event.action));
            for operation in step.action.operations().iter().filter(|_| up.is_empty()) {
                if let Some(magnet) =
                    magnet_of(order, operation).filter(|magnet| warned.insert((&job.device, &magnet.name)))
                {
                    sink.push(errors::no_magnet_raised(&magnet.name, operation.span, first));
                }
            }
        }
    }
}

/// Whether a drive switches a magnet of a board's driver.
fn raises_a_magnet(bench: &Bench, drive: &Drive) -> bool {
    match bench.instruments.get(&drive.instrument).map(|instrument| &instrument.facts) {
        Some(InstrumentFacts::ElectrodeDriver(facts)) => facts.magnet_outputs().any(|magnet| magnet == drive.output),
        Some(
            InstrumentFacts::WaveformGenerator(_)
            | InstrumentFacts::DataAcquisition(_)
            | InstrumentFacts::StageController(_)
            | InstrumentFacts::MachineController(_),
        )
        | None => false,
    }
}

fn set<'c>(up: &mut BTreeSet<&'c str>, switches: &BTreeSet<&'c str>, output: &str, action: AuxiliaryAction) {
    let Some(output) = switches.get(output) else { return };
    match action {
        // The length of a pulse is not checked: whoever writes one has thought of the magnet.
        AuxiliaryAction::High | AuxiliaryAction::Pulse => drop(up.insert(output)),
        AuxiliaryAction::Low => drop(up.remove(output)),
        // Graded outputs switch no magnet.
        AuxiliaryAction::Volts(_) => {}
    }
}

/// The magnet at which an operation holds its part.
fn magnet_of<'o>(order: &'o ElectrodeArrayOrder, operation: &AssayOperation) -> Option<&'o BoardZone> {
    let zone = order.zones.get(operation.zone?.zone)?;
    (zone.sort == ZoneSort::Magnet).then_some(zone)
}

/// Warns of droplets that are split right after they were held, if they leave the magnet or the other half does not.
pub fn halves_stay(jobs: &[Job], sink: &mut Sink) {
    // By device and part: the magnet that last held it, if nothing has happened to it since.
    let mut held: BTreeMap<(&str, &str), &BoardZone> = BTreeMap::new();
    for job in jobs {
        let Some(order) = ElectrodeArrayOrder::of(&job.order) else { continue };
        for operation in order.steps.iter().flat_map(|step| step.action.operations()) {
            let part = (job.device.as_str(), order.parts[operation.part].name.as_str());
            let before = held.remove(&part);
            if let (Some(magnet), Some(half), Some(end)) = (before, operation.splits, operation.stops.last()) {
                let stays = [end.cell, half.cell].map(|cell| magnet.contains(cell));
                if stays != [true, false] {
                    let other = order.parts[half.part].name.as_str();
                    let cells = [end.cell, half.cell];
                    sink.push(errors::beads_left_behind([part.1, other], cells, stays, magnet, operation.span));
                }
            }
            if let Some(magnet) = magnet_of(order, operation) {
                held.insert(part, magnet);
            }
        }
    }
}
