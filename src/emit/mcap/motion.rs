//! Where the end-effectors are: poses over time, the whole way of each plan, and the frames they stand in.
//!
//! A module snaps at some instant within its pulse, so the old pose is said again at the pulse's start and the new one at its
//! end. Devices have no common frame in a program; pictures put them side by side along x.

use super::scene::Bench;
use super::{Signals, Topic, WORLD, foxglove};
use crate::schedule::{PlanRecord, State, TimedState};
use crate::verify::Verified;
use std::collections::{BTreeMap, BTreeSet};

use foxglove::{FrameTransform, FrameTransforms, PoseInFrame, PosesInFrame, Quaternion, Vector3};

/// The frame that goes with a device's end-effector.
pub fn tip_frame(device: &str) -> String {
    format!("{device}/tip")
}

/// `/<device>/pose` and `/<device>/path` for each device that moves, and `/tf`.
pub fn topics(verified: &Verified, signals: &Signals) -> Vec<Topic> {
    let benches = Bench::all(verified);
    let mut topics = Vec::new();
    let mut moves: BTreeMap<u64, Vec<(usize, [f64; 3])>> = BTreeMap::new();
    for (index, bench) in benches.iter().enumerate() {
        let poses = poses(verified, signals, bench.device);
        for (t_ns, place) in &poses {
            moves.entry(*t_ns).or_default().push((index, *place));
        }
        let pose = |&(t_ns, place): &(u64, [f64; 3])| {
            let message = PoseInFrame {
                timestamp: foxglove::timestamp(t_ns),
                frame_id: bench.device.to_owned(),
                pose: foxglove::pose_at(place),
            };
            (t_ns, foxglove::encode(&message))
        };
        topics.push(Topic::new::<PoseInFrame>(format!("/{}/pose", bench.device), poses.iter().map(pose).collect()));
        topics.push(path(verified, bench.device));
    }
    topics.push(Topic::new::<FrameTransforms>("/tf", frames(&benches, &moves)));
    topics
}

/// All frames whenever one of them moves: a viewer that jumps in time reads the last message only.
fn frames(benches: &[Bench], moves: &BTreeMap<u64, Vec<(usize, [f64; 3])>>) -> Vec<(u64, Vec<u8>)> {
    let mut tips: Vec<Option<[f64; 3]>> = vec![None; benches.len()];
    let mut messages = Vec::new();
    for (t_ns, moved) in moves {
        for (index, place) in moved {
            tips[*index] = Some(*place);
        }
        let standing = benches
            .iter()
            .map(|bench| transform(*t_ns, WORLD.to_owned(), bench.device.to_owned(), [bench.offset_um, 0.0, 0.0]));
        let tips = benches.iter().zip(&tips).filter_map(|(bench, tip)| {
            Some(transform(*t_ns, bench.device.to_owned(), tip_frame(bench.device), (*tip)?))
        });
        let transforms = standing.chain(tips).collect();
        messages.push((*t_ns, foxglove::encode(&FrameTransforms { transforms })));
    }
    messages
}

/// The plans of a device, in order of time.
pub fn plans<'a>(verified: &'a Verified, device: &str) -> Vec<&'a PlanRecord> {
    let mut plans: Vec<_> = verified.schedule().plans.iter().filter(|plan| plan.device == device).collect();
    plans.sort_by_key(|plan| plan.start_ns);
    plans
}

/// Where the end-effector is in a state.
pub fn place(state: &TimedState) -> [f64; 3] {
    match state.state {
        State::Dimibot { position_um: [x, y], .. } => [x, y, 0.0],
        State::ElectrodeArray { .. } => [0.0; 3],
    }
}

/// The end-effector of a device over time: each new place at the instant of its state, and the old one at the start of the
/// pulse that leads there. Before its first task it stands where that begins.
fn poses(verified: &Verified, signals: &Signals, device: &str) -> Vec<(u64, [f64; 3])> {
    let channels = &signals.schedule.channels;
    let of_device = |channel: u32| channels.get(channel as usize).is_some_and(|channel| channel.device == device);
    let actuations = signals.schedule.actuations.iter().filter(|actuation| of_device(actuation.channel));
    let starts: BTreeSet<u64> = actuations.map(|actuation| actuation.start_ns).collect();
    let mut poses: Vec<(u64, [f64; 3])> = Vec::new();
    for state in plans(verified, device).iter().flat_map(|plan| &plan.states) {
        if poses.is_empty() {
            poses.push((0, place(state)));
        }
        if let Some(&(last_ns, old)) = poses.last() {
            let start_ns = starts.range(..state.t_ns).next_back().copied();
            if let Some(start_ns) = start_ns.filter(|start_ns| *start_ns > last_ns) {
                poses.push((start_ns, old));
            }
        }
        if poses.last() != Some(&(state.t_ns, place(state))) {
            poses.push((state.t_ns, place(state)));
        }
    }
    poses
}

fn path(verified: &Verified, device: &str) -> Topic {
    let message = |plan: &&PlanRecord| {
        let message = PosesInFrame {
            timestamp: foxglove::timestamp(plan.start_ns),
            frame_id: device.to_owned(),
            poses: plan.states.iter().filter_map(|state| foxglove::pose_at(place(state))).collect(),
        };
        (plan.start_ns, foxglove::encode(&message))
    };
    Topic::new::<PosesInFrame>(format!("/{device}/path"), plans(verified, device).iter().map(message).collect())
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
