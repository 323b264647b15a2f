//! Content of a log for an electrode array: the board with its obstacles, the moving parts, the electrodes that are on, and
//! the path of each part.
//!
//! One unit of its pictures is one pitch of the board, so that a board of any size fills a viewer as a chess board does; the
//! topics' metadata give the length of a pitch. Electrode (1, 1) is the origin.

mod scene;

use super::LogTopic;
use super::bench;
use super::foxglove::{self, PosesInFrame};
use super::frames::{FramePlace, Mover, StandingPose};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
use crate::quantity::{Dimension, Quantity};
use crate::schedule::State;
use crate::verify::Verified;
use std::collections::BTreeMap;

/// Extent of its picture along x.
pub fn width(facts: &ElectrodeArrayFacts) -> f64 {
    f64::from(facts.columns)
}

/// The middle of an electrode in a picture.
fn place(cell: ElectrodeCell) -> [f64; 2] {
    [f64::from(cell.column) - 1.0, f64::from(cell.row) - 1.0]
}

/// Where the parts of a board are, from an instant on.
struct PartsMoment {
    t_ns: u64,
    parts: BTreeMap<String, ElectrodeCell>,
}

/// All topics of a device but its voltages, and its parts, which move.
pub fn topics(verified: &Verified, device: &str) -> (Vec<LogTopic>, Vec<Mover>) {
    let moments = moments(verified, device);
    let mut topics = vec![poses(device, &moments)];
    topics.extend(scene::topics(verified, device));
    let orders = bench::jobs(verified, device);
    if let Some(order) = orders.first().and_then(|(job, _)| job.order.electrode_array()) {
        let pitch = Quantity::new(order.facts.pitch_um() / 1e6, Dimension::LENGTH);
        let pitch = format!("1 unit is a pitch of {pitch}");
        topics.iter_mut().for_each(|topic| drop(topic.metadata.insert("scale".to_owned(), pitch.clone())));
    }
    (topics, movers(device, &moments))
}

/// The frame that goes with a part.
fn frame(device: &str, part: &str) -> String {
    format!("{device}/{part}")
}

/// Every place of every part: the states of all plans, and before each step of the board the old places once more, so that a
/// part that rests between steps is not drawn as if it crept.
fn moments(verified: &Verified, device: &str) -> Vec<PartsMoment> {
    let mut moments: Vec<PartsMoment> = Vec::new();
    for (job, plan) in bench::jobs(verified, device) {
        let Some(order) = job.order.electrode_array() else { continue };
        for timed in &plan.states {
            let State::ElectrodeArray { parts } = &timed.state else { continue };
            let parts: BTreeMap<String, ElectrodeCell> =
                parts.iter().map(|(name, [column, row])| (name.clone(), ElectrodeCell::new(*column, *row))).collect();
            let begins_ns = timed.t_ns.saturating_sub(order.facts.step_ns);
            let Some(last) = moments.last() else {
                moments.push(PartsMoment { t_ns: 0, parts });
                continue;
            };
            if last.parts == parts {
                continue;
            }
            if last.t_ns < begins_ns {
                let parts = last.parts.clone();
                moments.push(PartsMoment { t_ns: begins_ns, parts });
            }
            moments.push(PartsMoment { t_ns: timed.t_ns, parts });
        }
    }
    moments
}

/// `/<device>/poses`: all parts that are there, in the order of their names, which the metadata list.
fn poses(device: &str, moments: &[PartsMoment]) -> LogTopic {
    let message = |moment: &PartsMoment| {
        let places = moment.parts.values().map(|cell| place(*cell));
        let message = PosesInFrame {
            timestamp: foxglove::timestamp(moment.t_ns),
            frame_id: device.to_owned(),
            poses: places.filter_map(|[x, y]| foxglove::pose_at([x, y, 0.0])).collect(),
        };
        (moment.t_ns, foxglove::encode(&message))
    };
    let mut topic = LogTopic::new::<PosesInFrame>(format!("/{device}/poses"), moments.iter().map(message).collect());
    let names: Vec<&str> =
        moments.first().map_or_else(Vec::new, |moment| moment.parts.keys().map(String::as_str).collect());
    topic.metadata.insert("parts".to_owned(), names.join(" "));
    topic
}

/// The frame of each part, written when it moves or is gone.
fn movers(device: &str, moments: &[PartsMoment]) -> Vec<Mover> {
    let Some(first) = moments.first() else { return Vec::new() };
    let of_part = |name: &String| {
        let mut places: Vec<(u64, FramePlace)> = Vec::new();
        let mut last: Option<ElectrodeCell> = None;
        for (index, moment) in moments.iter().enumerate() {
            let cell = moment.parts.get(name).copied();
            let moves_next = moments.get(index + 1).is_some_and(|next| next.parts.get(name).copied() != cell);
            if index == 0 || cell != last || moves_next {
                let here = cell.map(place).map(|[x, y]| StandingPose::at([x, y, 0.0]));
                places.push((moment.t_ns, here));
            }
            last = cell;
        }
        Mover { frame: frame(device, name), device: device.to_owned(), places }
    };
    first.parts.keys().map(of_part).collect()
}

#[cfg(test)]
mod tests;
