//! Motion of an end-effector: poses over time, and the whole path of each plan.
//!
//! A module snaps at some instant within its pulse, so the old pose is repeated at the start of the pulse and the new
//! one is written at its end.

use crate::emit::dimibot::motion::place;
use crate::emit::mcap::LogTopic;
use crate::emit::mcap::foxglove::{self, PoseInFrame, PosesInFrame};
use crate::emit::motion::plans;
use crate::verify::Verified;

/// The frame that moves with a device's end-effector.
pub fn tip_frame(device: &str) -> String {
    format!("{device}/tip")
}

/// `/<device>/pose`, the pose of the end-effector at each of these instants, and `/<device>/path`.
pub fn topics(verified: &Verified, device: &str, poses: &[(u64, [f64; 3])]) -> [LogTopic; 2] {
    let pose = |&(t_ns, place): &(u64, [f64; 3])| {
        let message = PoseInFrame {
            timestamp: foxglove::timestamp(t_ns),
            frame_id: device.to_owned(),
            pose: foxglove::pose_at(place),
        };
        (t_ns, foxglove::encode(&message))
    };
    [LogTopic::new::<PoseInFrame>(format!("/{device}/pose"), poses.iter().map(pose).collect()), path(verified, device)]
}

/// Greatest number of places in one message of a path. Readers of logs handle this many easily, and Tweeze's own
/// accepts 64 MiB.
const MAX_PLACES: usize = 10_000;

/// The path of each plan. A long one is split into several messages, each at the instant of its first place, which is
/// the last place of the one before.
fn path(verified: &Verified, device: &str) -> LogTopic {
    let mut messages = Vec::new();
    for plan in plans(verified, device) {
        for first in (0..plan.states.len().max(1)).step_by(MAX_PLACES) {
            let states = plan.states.iter().skip(first).take(MAX_PLACES + 1);
            let t_ns = plan.states.get(first).filter(|_| first > 0).map_or(plan.start_ns, |state| state.t_ns);
            let message = PosesInFrame {
                timestamp: foxglove::timestamp(t_ns),
                frame_id: device.to_owned(),
                poses: states.filter_map(|state| foxglove::pose_at(place(state))).collect(),
            };
            messages.push((t_ns, foxglove::encode(&message)));
        }
    }
    LogTopic::new::<PosesInFrame>(format!("/{device}/path"), messages)
}
