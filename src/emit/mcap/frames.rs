//! Coordinate frames of devices and of the objects that they move, over time.
//!
//! Devices that a scene places have their frame there; pictures put the others side by side along x.

use super::cloud::{SpaceStroke, space_cloud};
use super::{LogTopic, WORLD, foxglove};
use crate::real::Real;
use foxglove::{FrameTransform, FrameTransforms, PointCloud, Pose, Quaternion, Vector3};
use std::collections::BTreeMap;

/// Position and orientation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FramePose {
    pub place: [f64; 3],
    /// A unit quaternion w, x, y, z.
    turn: [f64; 4],
}

/// Rounding grid of quaternions: their last bits differ between machines, and those of a log must not.
const GRID: f64 = 1e9;

impl FramePose {
    /// A pose without rotation.
    pub fn at(place: [f64; 3]) -> FramePose {
        FramePose { place, turn: [1.0, 0.0, 0.0, 0.0] }
    }

    /// A pose turned about z by an angle, counter-clockwise.
    pub fn turned(place: [f64; 3], heading_rad: f64) -> FramePose {
        let (sin, cos) = (heading_rad / 2.0).sine_cosine();
        FramePose::oriented(place, [cos, 0.0, 0.0, sin])
    }

    /// A pose turned by a unit quaternion w, x, y, z.
    pub fn oriented(place: [f64; 3], turn: [f64; 4]) -> FramePose {
        // Adding 0 turns minus zero into zero.
        FramePose { place, turn: turn.map(|value| (value * GRID).round() / GRID + 0.0) }
    }

    /// The pose as a message.
    pub fn pose(&self) -> Option<Pose> {
        Some(Pose { position: Some(self.translation()), orientation: Some(self.rotation()) })
    }

    fn translation(&self) -> Vector3 {
        let [x, y, z] = self.place;
        Vector3 { x, y, z }
    }

    fn rotation(&self) -> Quaternion {
        let [w, x, y, z] = self.turn;
        Quaternion { x, y, z, w }
    }
}

/// The pose of something; `None` once it is gone.
pub type FramePlace = Option<FramePose>;

/// Something that moves in the frame of its device.
pub struct Mover {
    /// Its own frame.
    pub frame: String,
    pub device: String,
    /// Its poses from each instant on, in order of time; `None` where it is gone.
    pub places: Vec<(u64, FramePlace)>,
    /// Its outline in its own frame; empty if another topic shows it.
    pub outline: Vec<SpaceStroke>,
}

/// Approximate number of points along an outline.
const OUTLINE_POINTS: f64 = 300.0;

impl Mover {
    /// `/<frame>/points`: the outline as points that move with the frame, for viewers that show no scenes; no points
    /// while it is gone.
    pub(in crate::emit) fn points(&self) -> Option<LogTopic> {
        if self.outline.is_empty() {
            return None;
        }
        let pairs = self.outline.iter().flat_map(|stroke| stroke.corners.windows(2));
        let length = pairs.map(|pair| nalgebra::distance(&pair[0], &pair[1])).sum::<f64>();
        let mut was_there = None;
        let mut messages = Vec::new();
        for (t_ns, place) in &self.places {
            if was_there.replace(place.is_some()) != Some(place.is_some()) {
                let strokes = if place.is_some() { &self.outline[..] } else { &[] };
                let cloud = space_cloud(strokes, &self.frame, *t_ns, length / OUTLINE_POINTS);
                messages.push((*t_ns, foxglove::encode(&cloud)));
            }
        }
        Some(LogTopic::new::<PointCloud>(format!("/{}/points", self.frame), messages))
    }
}

/// `/tf`: all frames whenever one of them moves, since a viewer that jumps in time reads the last message only.
/// `devices` are the poses of their frames.
pub fn topic(devices: &[(&str, FramePose)], movers: &[Mover]) -> LogTopic {
    let mut moves: BTreeMap<u64, Vec<(usize, FramePlace)>> = BTreeMap::new();
    for (index, mover) in movers.iter().enumerate() {
        for (t_ns, place) in &mover.places {
            moves.entry(*t_ns).or_default().push((index, *place));
        }
    }
    // In long assays few of the many parts are present at a time.
    let mut present: BTreeMap<usize, FramePose> = BTreeMap::new();
    let mut messages = Vec::new();
    for (t_ns, moved) in moves {
        for (index, place) in moved {
            match place {
                Some(place) => present.insert(index, place),
                None => present.remove(&index),
            };
        }
        let of_device =
            |(device, pose): &(&str, FramePose)| transform(t_ns, WORLD.to_owned(), (*device).to_owned(), *pose);
        let standing = devices.iter().map(of_device);
        let moving = present.iter().map(|(index, place)| {
            let mover = &movers[*index];
            transform(t_ns, mover.device.clone(), mover.frame.clone(), *place)
        });
        let transforms = standing.chain(moving).collect();
        messages.push((t_ns, foxglove::encode(&FrameTransforms { transforms })));
    }
    LogTopic::new::<FrameTransforms>("/tf", messages)
}

fn transform(t_ns: u64, parent_frame_id: String, child_frame_id: String, pose: FramePose) -> FrameTransform {
    FrameTransform {
        timestamp: foxglove::timestamp(t_ns),
        parent_frame_id,
        child_frame_id,
        translation: Some(pose.translation()),
        rotation: Some(pose.rotation()),
    }
}
