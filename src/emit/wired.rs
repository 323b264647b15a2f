//! The part of a schedule that one instrument plays.

use super::{EmitError, Format};
use crate::device::instrument::{Drive, Family, Instrument, Start};
use crate::schedule::Schedule;

/// An instrument of the program with the channels wired to it.
pub struct WiredInstrument<'a> {
    pub name: &'a str,
    pub instrument: &'a Instrument,
    /// The schedule reduced to these channels, in the order of `drives`.
    pub schedule: Schedule,
    /// In channel order.
    pub drives: Vec<&'a Drive>,
    /// Whether the program has no other instrument.
    pub is_alone: bool,
    /// Whether other instruments of the program wait for a pulse to begin with this one.
    pub leads: bool,
}

/// The instruments of a family with their channels, by name.
///
/// # Errors
/// [`EmitError::NotWired`] where no channel is wired to an instrument of the family.
pub fn wired(format: Format, schedule: &Schedule, family: Family) -> Result<Vec<WiredInstrument<'_>>, EmitError> {
    let bench = &schedule.bench;
    let of_family = bench.instruments.iter().filter(|(_, instrument)| instrument.facts.family() == family);
    let found: Vec<WiredInstrument> = of_family
        .map(|(name, instrument)| {
            let drive = |index: usize| bench.drives.get(&schedule.channels[index].name);
            let own: Vec<(usize, &Drive)> = (0..schedule.channels.len())
                .filter_map(|index| Some((index, drive(index).filter(|drive| drive.instrument == *name)?)))
                .collect();
            let channels: Vec<usize> = own.iter().map(|(index, _)| *index).collect();
            let is_alone = bench.instruments.len() == 1;
            let leads = instrument.facts.start() == Start::Sender && !is_alone;
            let drives = own.into_iter().map(|(_, drive)| drive).collect();
            WiredInstrument { name, instrument, schedule: restricted_to(schedule, &channels), drives, is_alone, leads }
        })
        .filter(|wired| !wired.drives.is_empty())
        .collect();
    let family = (!schedule.channels.is_empty()).then_some(family);
    match found.is_empty() {
        true => Err(EmitError::NotWired { format, name: schedule.name.clone(), family }),
        false => Ok(found),
    }
}

/// The schedule reduced to some of its channels.
fn restricted_to(schedule: &Schedule, channels: &[usize]) -> Schedule {
    let place = |channel: u32| channels.iter().position(|index| *index == channel as usize);
    let places: Vec<Option<usize>> = (0..schedule.channels.len() as u32).map(place).collect();
    let actuations = schedule.actuations.iter().filter_map(|actuation| {
        let channel = places.get(actuation.channel as usize).copied().flatten()?;
        Some(crate::schedule::Actuation { channel: channel as u32, ..*actuation })
    });
    Schedule {
        name: schedule.name.clone(),
        source: schedule.source.clone(),
        duration_ns: schedule.duration_ns,
        channels: channels.iter().map(|index| schedule.channels[*index].clone()).collect(),
        actuations: actuations.collect(),
        steps: Vec::new(),
        plans: Vec::new(),
        holds: schedule.holds.clone(),
        bench: schedule.bench.clone(),
    }
}
