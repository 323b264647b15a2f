//! Content of a log for an electrode array: the board with its obstacles, the moving parts, the electrodes that are on, and
//! the path of each part.
//!
//! One unit of its pictures is one pitch of the board, so that a board of any size fills a viewer as a chess board does; the
//! topics' metadata give the length of a pitch. Electrode (1, 1) is the origin.

mod scene;

use super::foxglove::{self, PosesInFrame};
use super::frames::{FramePlace, Mover, StandingPose};
use super::{LogTopic, Pictures, Signals};
use crate::claims::electrode_array::ElectrodeArrayOrder;
use crate::device::electrode_array::ElectrodeCell;
use crate::emit::course::electrode_array::{PartsMoment, moments, place};
use crate::quantity::{Dimension, Quantity};
use crate::verify::Verified;

impl Pictures for ElectrodeArrayOrder {
    fn topics(&self, verified: &Verified, _signals: &Signals, device: &str) -> (Vec<LogTopic>, Vec<Mover>) {
        let moments = moments(verified, device);
        let mut topics = vec![poses(device, &moments)];
        topics.extend(scene::topics(verified, device));
        let pitch = Quantity::new(self.facts.pitch_um() / 1e6, Dimension::LENGTH);
        let pitch = format!("1 unit is a pitch of {pitch}");
        topics.iter_mut().for_each(|topic| drop(topic.metadata.insert("scale".to_owned(), pitch.clone())));
        (topics, movers(device, &moments))
    }

    fn reach(&self) -> [f64; 2] {
        [0.0, f64::from(self.facts.columns)]
    }
}

/// The frame that goes with a part.
fn frame(device: &str, part: &str) -> String {
    format!("{device}/{part}")
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
