//! The frames that devices and what they move stand in, over time.
//!
//! Devices have no common frame in a program; pictures put them side by side along x.

use super::bench::Bench;
use super::{Topic, WORLD, foxglove};
use foxglove::{FrameTransform, FrameTransforms, Quaternion, Vector3};
use std::collections::BTreeMap;

/// Where something is, if it is still there.
pub type Place = Option<[f64; 3]>;

/// Something that moves in the frame of its device.
pub struct Mover {
    /// Its own frame.
    pub frame: String,
    pub device: String,
    /// Its places from each instant on, in order of time; `None` where it is no longer there.
    pub places: Vec<(u64, Place)>,
}

/// `/tf`: all frames whenever one of them moves, since a viewer that jumps in time reads the last message only.
pub fn topic(benches: &[Bench], movers: &[Mover]) -> Topic {
    let mut moves: BTreeMap<u64, Vec<(usize, Place)>> = BTreeMap::new();
    for (index, mover) in movers.iter().enumerate() {
        for (t_ns, place) in &mover.places {
            moves.entry(*t_ns).or_default().push((index, *place));
        }
    }
    let mut places: Vec<Place> = vec![None; movers.len()];
    let mut messages = Vec::new();
    for (t_ns, moved) in moves {
        for (index, place) in moved {
            places[index] = place;
        }
        let standing = benches
            .iter()
            .map(|bench| transform(t_ns, WORLD.to_owned(), bench.device.to_owned(), [bench.offset, 0.0, 0.0]));
        let moving = movers
            .iter()
            .zip(&places)
            .filter_map(|(mover, place)| Some(transform(t_ns, mover.device.clone(), mover.frame.clone(), (*place)?)));
        let transforms = standing.chain(moving).collect();
        messages.push((t_ns, foxglove::encode(&FrameTransforms { transforms })));
    }
    Topic::new::<FrameTransforms>("/tf", messages)
}

fn transform(t_ns: u64, parent_frame_id: String, child_frame_id: String, [x, y, z]: [f64; 3]) -> FrameTransform {
    FrameTransform {
        timestamp: foxglove::timestamp(t_ns),
        parent_frame_id,
        child_frame_id,
        translation: Some(Vector3 { x, y, z }),
        rotation: Some(Quaternion { x: 0.0, y: 0.0, z: 0.0, w: 1.0 }),
    }
}
