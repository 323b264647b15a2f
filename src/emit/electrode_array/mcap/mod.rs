//! Content of a log for an electrode array: the board with its obstacles, the moving parts, the electrodes that are on,
//! and the path of each part.
//!
//! One unit of its pictures is one micrometre, as for every device. Electrode (1, 1) is the origin; `/<device>/cells`
//! has the electrodes of the parts in the coordinates of the language.

mod scene;

use crate::claims::electrode_array::ElectrodeArrayOrder;
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
use crate::emit::Signals;
use crate::emit::electrode_array::motion::{PartsMoment, moments, place};
use crate::emit::identifier;
use crate::emit::mcap::cloud::SpaceStroke;
use crate::emit::mcap::foxglove::{self, PoseInFrame};
use crate::emit::mcap::frames::{FramePlace, FramePose, Mover};
use crate::emit::mcap::voltages::{MAX_FIELDS, MessageShape, encode_fields, repeat_values, schema};
use crate::emit::mcap::{LogTopic, Pictures};
use crate::verify::Verified;
use std::collections::{BTreeMap, BTreeSet};

impl Pictures for ElectrodeArrayOrder {
    fn topics(&self, verified: &Verified, _signals: &Signals, device: &str) -> (Vec<LogTopic>, Vec<Mover>) {
        let moments = moments(verified, device);
        let movers = movers(self, device, &moments);
        let mut topics: Vec<LogTopic> = movers.iter().map(|mover| pose(device, mover)).collect();
        topics.extend(cells(device, &moments, verified.schedule().duration_ns));
        topics.extend(scene::topics(verified, device));
        (topics, movers)
    }

    fn beats(&self, verified: &Verified, device: &str) -> Vec<(u64, String)> {
        let moments = moments(verified, device);
        let pairs = moments.windows(2).filter(|pair| pair[0].parts != pair[1].parts);
        pairs.map(|pair| (pair[0].t_ns, moves(&pair[0], &pair[1]))).collect()
    }

    fn reach(&self) -> [f64; 2] {
        [0.0, f64::from(self.facts.columns) * self.facts.pitch_um()]
    }
}

/// Greatest number of parts named in the entry of a beat.
const MAX_NAMED: usize = 12;

/// Text of which parts move to which electrode, in the coordinates of the language.
fn moves(before: &PartsMoment, after: &PartsMoment) -> String {
    let moved = names([before, after]).into_iter().filter(|name| after.parts.get(*name) != before.parts.get(*name));
    let words: Vec<String> = moved
        .map(|name| match after.parts.get(name) {
            Some(cell) => format!("{name} to {cell}"),
            None => format!("{name} merges"),
        })
        .collect();
    match words.len() {
        0..=MAX_NAMED => words.join(", "),
        count => format!("{} and {} more", words[..MAX_NAMED].join(", "), count - MAX_NAMED),
    }
}

/// The parts that are present at any of the moments; dispensed ones come later than others.
fn names<'m>(moments: impl IntoIterator<Item = &'m PartsMoment>) -> BTreeSet<&'m String> {
    moments.into_iter().flat_map(|moment| moment.parts.keys()).collect()
}

/// The frame that moves with a part.
fn frame(device: &str, part: &str) -> String {
    format!("{device}/{part}")
}

/// The middle of an electrode in a picture.
fn place_um(facts: &ElectrodeArrayFacts, cell: ElectrodeCell) -> [f64; 2] {
    place(cell).map(|pitches| pitches * facts.pitch_um())
}

/// `/<device>/pose/<part>`: the pose of a part while it is present.
fn pose(device: &str, mover: &Mover) -> LogTopic {
    let message = |(t_ns, place): &(u64, FramePlace)| {
        let (timestamp, frame_id) = (foxglove::timestamp(*t_ns), device.to_owned());
        let pose = (*place)?.pose();
        Some((*t_ns, foxglove::encode(&PoseInFrame { timestamp, frame_id, pose })))
    };
    let part = mover.frame.strip_prefix(device).unwrap_or_default();
    LogTopic::new::<PoseInFrame>(format!("/{device}/pose{part}"), mover.places.iter().filter_map(message).collect())
}

/// `/<device>/cells`: column and row of every part as numbers, from 1; NaN while a part is absent. `None` without
/// parts, or for more parts than a message type has fields for.
fn cells(device: &str, moments: &[PartsMoment], duration_ns: u64) -> Option<LogTopic> {
    let names: Vec<&String> = names(moments).into_iter().collect();
    if names.is_empty() || 2 * names.len() > MAX_FIELDS {
        return None;
    }
    let words: Vec<String> = names.iter().flat_map(|name| [format!("{name}_column"), format!("{name}_row")]).collect();
    let fields = identifier::distinct_fields(words.iter().map(String::as_str));
    let numbers = |moment: &PartsMoment| {
        let cell = |name: &&String| moment.parts.get(*name).map(|cell| [cell.column, cell.row].map(f64::from));
        names.iter().flat_map(|name| cell(name).unwrap_or([f64::NAN; 2])).collect::<Vec<f64>>()
    };
    let mut held: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for moment in moments {
        // Just before a part arrives it is still at its old cell.
        let before = held.values().next_back().cloned();
        if let (Some(before_ns), Some(values)) = (moment.t_ns.checked_sub(1), before) {
            held.entry(before_ns).or_insert(values);
        }
        held.insert(moment.t_ns, numbers(moment));
    }
    repeat_values(&mut held, duration_ns);
    let package = format!("tweeze.{}", identifier::distinct([device])[0]);
    let whole = names.iter().flat_map(|name| [format!("column of {name}, from 1"), format!("row of {name}, from 1")]);
    Some(LogTopic {
        name: format!("/{device}/cells"),
        schema: schema(&package, "Cells", MessageShape::Fields(&fields)),
        metadata: fields.iter().cloned().zip(whole).collect(),
        messages: held.into_iter().map(|(t_ns, values)| (t_ns, encode_fields(&values))).collect(),
    })
}

/// The frame of each part, written when it moves or is gone.
fn movers(order: &ElectrodeArrayOrder, device: &str, moments: &[PartsMoment]) -> Vec<Mover> {
    let names: Vec<&String> = names(moments).into_iter().collect();
    let numbers: BTreeMap<&String, usize> = names.iter().enumerate().map(|(number, name)| (*name, number)).collect();
    // Cells by part index at one moment. In long assays few of the many parts are present at a time; a lookup of each
    // part at each moment would dominate the run time.
    let at = |moment: &PartsMoment| {
        let mut cells: Vec<Option<ElectrodeCell>> = vec![None; names.len()];
        for (name, cell) in &moment.parts {
            cells[numbers[name]] = Some(*cell);
        }
        cells
    };
    let mut places: Vec<Vec<(u64, FramePlace)>> = vec![Vec::new(); names.len()];
    let (mut before, mut here) = (None, moments.first().map(at));
    for (index, moment) in moments.iter().enumerate() {
        let next = moments.get(index + 1).map(at);
        let Some(cells) = here else { break };
        for (part, cell) in cells.iter().enumerate() {
            let is_other =
                |there: &Option<Vec<Option<ElectrodeCell>>>| there.as_ref().is_some_and(|there| there[part] != *cell);
            if index == 0 || is_other(&before) || is_other(&next) {
                let place = cell.map(|cell| place_um(&order.facts, cell)).map(|[x, y]| FramePose::at([x, y, 0.0]));
                places[part].push((moment.t_ns, place));
            }
        }
        (before, here) = (Some(cells), next);
    }
    let of_part = |(name, places): (&String, Vec<(u64, FramePlace)>)| {
        let index = order.parts.iter().position(|part| part.name == *name)?;
        let outline = vec![SpaceStroke::from(&scene::part_outline(&order.facts, index))];
        Some(Mover { frame: frame(device, name), device: device.to_owned(), places, outline })
    };
    names.iter().copied().zip(places).filter_map(of_part).collect()
}

#[cfg(test)]
mod tests;
