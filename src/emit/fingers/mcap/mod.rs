//! Content of a log for a hand: the part with its two sections and its pose, the tips, the grasps with the forces at
//! their contacts, and the path of each tip. One unit of its pictures is one micrometre.
//!
//! The part and each tip have frames of their own that move in the hand's.

mod scene;
mod solid;

use crate::claims::fingers::{FingersAction, FingersOrder};
use crate::emit::Signals;
use crate::emit::fingers::motion::{HandMoment, HandMotion, PartPose};
use crate::emit::mcap::drawing;
use crate::emit::mcap::foxglove::{self, PoseInFrame};
use crate::emit::mcap::frames::{FramePlace, FramePose, Mover};
use crate::emit::mcap::{LogTopic, Pictures};
use crate::geometry::outline::Curve;
use crate::verify::Verified;

/// The frame that moves with the part.
fn part_frame(device: &str, part: &str) -> String {
    format!("{device}/{part}")
}

/// The frame that moves with a tip; names of parts have no slash.
fn tip_frame(device: &str, finger: usize) -> String {
    format!("{device}/finger/f{}", finger + 1)
}

/// The pose rounded so that its numbers are the same on every machine.
fn frame_pose(pose: &PartPose) -> FramePose {
    FramePose::oriented(pose.position_um.map(drawing::snapped), pose.orientation)
}

impl Pictures for FingersOrder {
    fn topics(&self, verified: &Verified, signals: &Signals, device: &str) -> (Vec<LogTopic>, Vec<Mover>) {
        let motion = HandMotion::new(verified, signals, device);
        let mut topics = vec![pose(&motion, device)];
        topics.extend(scene::topics(&motion, device));
        (topics, movers(&motion, device))
    }

    /// A hand works in three dimensions.
    fn tilt_deg(&self) -> f64 {
        60.0
    }

    fn reach(&self) -> [f64; 2] {
        let sections = [Some(&self.part.xy), self.part.xz.as_ref()].into_iter().flatten();
        let reaches = sections.filter_map(|section| Some(Curve::of(&section.outline).ok()?.reach_um()));
        let facts = &self.facts;
        let round_um = f64::from(facts.fingers) * (2.0 * facts.tip_radius_um + facts.clearance_um);
        let carried_um = self.steps.iter().map(|step| match step.action {
            FingersAction::Translate([x_um, ..]) => x_um.abs(),
            FingersAction::Grasp(_)
            | FingersAction::Rotate { .. }
            | FingersAction::Orient { .. }
            | FingersAction::Release
            | FingersAction::Wait(_) => 0.0,
        });
        let reach_um = reaches.fold(0.0, f64::max) + round_um + carried_um.sum::<f64>();
        let [x_um, ..] = self.part.position_um;
        [x_um - reach_um, x_um + reach_um].map(drawing::snapped)
    }
}

/// `/<device>/pose`: the part in the hand's frame, written whenever it has moved, and once more before it moves.
fn pose(motion: &HandMotion, device: &str) -> LogTopic {
    let message = |(t_ns, place): (u64, FramePlace)| {
        let (timestamp, frame_id) = (foxglove::timestamp(t_ns), device.to_owned());
        let pose = place.and_then(|pose| pose.pose());
        (t_ns, foxglove::encode(&PoseInFrame { timestamp, frame_id, pose }))
    };
    let places = placed(motion, |moment| frame_pose(&moment.part));
    LogTopic::new::<PoseInFrame>(format!("/{device}/pose"), places.into_iter().map(message).collect())
}

fn movers(motion: &HandMotion, device: &str) -> Vec<Mover> {
    let tips = (0..motion.fingers).map(|finger| Mover {
        frame: tip_frame(device, finger),
        device: device.to_owned(),
        places: placed(motion, |moment| FramePose::at(moment.tips_um[finger].map(drawing::snapped))),
        outline: motion.plans.first().map_or_else(Vec::new, |plan| scene::tip_outline(plan.order, finger)),
    });
    let part = motion.part().map(|part| Mover {
        frame: part_frame(device, part),
        device: device.to_owned(),
        places: placed(motion, |moment| frame_pose(&moment.part)),
        // Included in the points of the scene.
        outline: Vec::new(),
    });
    part.into_iter().chain(tips).collect()
}

/// Poses at each moment at which something has moved, or from which it moves.
fn placed(motion: &HandMotion, of: impl Fn(&HandMoment) -> FramePose) -> Vec<(u64, FramePlace)> {
    let moments = motion.plans.iter().flat_map(|plan| &plan.moments);
    let places: Vec<(u64, FramePose)> = moments.map(|moment| (moment.t_ns, of(moment))).collect();
    let moved = |a: usize, b: usize| places[a].1 != places[b].1;
    let is_kept = |at: &usize| *at == 0 || moved(at - 1, *at) || (at + 1 < places.len() && moved(*at, at + 1));
    (0..places.len()).filter(is_kept).map(|at| (places[at].0, Some(places[at].1))).collect()
}

#[cfg(test)]
mod tests;
