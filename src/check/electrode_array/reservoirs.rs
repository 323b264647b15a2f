//! The reservoirs of a board: their outlets, and the frames that dispense droplets.

use super::cells::{on_board, whole_cell};
use super::errors;
use crate::check::devices::CheckedDevice;
use crate::check::figures::Figures;
use crate::check::labels::DeviceLabel;
use crate::check::value::{ListValue, Value, whole};
use crate::device::electrode_array::{
    DispenseFrame, DispenseSequence, ElectrodeArrayFacts, ElectrodeCell, MAX_DISPENSE_FRAMES, ReservoirPads,
};
use crate::diagnostic::Sink;
use crate::source::{Span, Spanned};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

/// The fields that describe the reservoirs; all or none must be given.
const FIELDS: [&str; 3] = ["outlets", "dispense_frames", "dispense_frame_duration"];

/// The reservoir pads of a device that has fields for them; `facts` are its facts without them. `None` after an error.
pub fn of(facts: &ElectrodeArrayFacts, device: &CheckedDevice, sink: &mut Sink) -> Option<Option<Arc<ReservoirPads>>> {
    let (given, missing): (Vec<&str>, Vec<&str>) = FIELDS.iter().partition(|name| device.fields.contains_key(**name));
    if given.iter().any(|name| device.fields.get(*name).is_some_and(|field| field.value.is_unknown())) {
        return None;
    }
    let Some(first) = given.first() else { return Some(None) };
    if !missing.is_empty() {
        let labels = [DeviceLabel::field(first, "but not the others")];
        sink.push(device.labelled(errors::half_of_reservoirs(&missing), labels));
        return None;
    }
    let frame_ns = device.fields.clock_ns("dispense_frame_duration", sink)?;
    let list = |name: &str| match device.fields.get(name).map(|field| &field.value) {
        Some(Value::List(list)) => Some(Rc::clone(list)),
        _ => None,
    };
    let (outlets, tables) = (list("outlets")?, list("dispense_frames")?);
    if outlets.len() != tables.len() {
        let labels = [
            DeviceLabel::field("dispense_frames", format!("for {}", tables.len())),
            DeviceLabel::field("outlets", format!("{}", outlets.len())),
        ];
        sink.push(device.labelled(errors::frames_of_other_outlets(), labels));
        return None;
    }
    let mut reader = PadReader { facts, device, sink, owners: BTreeMap::new() };
    let both = outlets.iter().zip(tables.iter());
    let sequences: Option<Vec<DispenseSequence>> =
        both.map(|(outlet, frames)| reader.sequence(outlet, frames)).collect();
    let sequences = sequences?;
    // A frame begins and ends with a step of the board, like everything that is switched on it.
    let frame_ns = frame_ns.div_ceil(facts.step_ns).checked_mul(facts.step_ns)?;
    Some(Some(Arc::new(ReservoirPads { frame_ns, sequences })))
}

/// Reads the sequences, one reservoir after the other.
struct PadReader<'a> {
    facts: &'a ElectrodeArrayFacts,
    device: &'a CheckedDevice,
    sink: &'a mut Sink,
    /// The outlet that each pad belongs to, with a place in the source that names the pad.
    owners: BTreeMap<u32, (ElectrodeCell, Span)>,
}

impl PadReader<'_> {
    fn sequence(&mut self, at: &Spanned<Value>, frames: &Spanned<Value>) -> Option<DispenseSequence> {
        let number = |cell: ElectrodeCell| self.facts.map.as_ref().and_then(|map| map.channel(cell));
        let cell = whole_cell(&at.value).and_then(|pair| on_board(pair, self.facts));
        let Some((outlet, own)) = cell.and_then(|cell| Some((cell, number(cell)?))) else {
            let label = DeviceLabel::cell(at.span, "no numbered electrode");
            self.sink.push(self.device.labelled(errors::outlet_without_number(&at.value), [label]));
            return None;
        };
        if self.facts.on_channel_of(outlet).len() > 1 {
            let label = DeviceLabel::cell(at.span, "on a shared channel");
            self.sink.push(self.device.labelled(errors::outlet_shares_channel(outlet, own), [label]));
            return None;
        }
        let Value::List(list) = &frames.value else { return None };
        let read: Option<Vec<DispenseFrame>> = list.iter().map(|frame| self.frame(frame, outlet, own)).collect();
        let read = read?;
        let begins = read.first().is_some_and(|first| !first.pads.is_empty());
        let ends = read.last().is_some_and(|last| last.outlet);
        if !begins || !ends || read.len() > MAX_DISPENSE_FRAMES {
            let label = DeviceLabel::cell(frames.span, format!("{} frames", read.len()));
            self.sink.push(self.device.labelled(errors::makes_no_droplet(outlet, own), [label]));
            return None;
        }
        Some(DispenseSequence { outlet, frames: read })
    }

    fn frame(&mut self, frame: &Spanned<Value>, outlet: ElectrodeCell, own: u32) -> Option<DispenseFrame> {
        let Value::List(numbers) = &frame.value else { return None };
        let numbers: &ListValue = numbers;
        let mut read = DispenseFrame { pads: Vec::new(), outlet: false };
        for number in numbers.iter() {
            let Some(channel) = as_channel(&number.value) else {
                let label = DeviceLabel::cell(number.span, "no channel");
                self.sink.push(self.device.labelled(errors::nothing_in_frame(), [label]));
                return None;
            };
            if channel == own {
                read.outlet = true;
                continue;
            }
            let numbered = || self.facts.map.iter().flat_map(|map| map.numbered());
            if let Some((cell, _)) = numbered().find(|(_, other)| *other == channel) {
                let label = DeviceLabel::cell(number.span, format!("electrode {cell}"));
                self.sink.push(self.device.labelled(errors::frame_on_the_board(channel, outlet), [label]));
                return None;
            }
            let (owner, earlier) = *self.owners.entry(channel).or_insert((outlet, number.span));
            if owner != outlet {
                let labels = [DeviceLabel::cell(number.span, "here"), DeviceLabel::cell(earlier, "and here")];
                self.sink.push(self.device.labelled(errors::pad_of_two(channel, [owner, outlet]), labels));
                return None;
            }
            read.pads.push(channel);
        }
        read.pads.sort_unstable();
        read.pads.dedup();
        Some(read)
    }
}

fn as_channel(value: &Value) -> Option<u32> {
    match value {
        Value::Quantity(count) => u32::try_from(whole(*count)?).ok(),
        _ => None,
    }
}
