//! Content of a log for microrobots: the bed with its obstacles, each robot with its frame, path and orbit, and the
//! arms as numbers for plots. One unit of its pictures is one micrometre.

mod scene;

use crate::claims::microrobots::MicrorobotsOrder;
use crate::emit::Signals;
use crate::emit::identifier;
use crate::emit::mcap::foxglove::{self, PosesInFrame};
use crate::emit::mcap::frames::{FramePose, Mover};
use crate::emit::mcap::voltages::{MessageShape, encode_fields, repeat_values, schema};
use crate::emit::mcap::{LogTopic, Pictures, drawing};
use crate::emit::microrobots::motion::{BedMoment, BedMotion, goals};
use crate::geometry::Pose;
use crate::verify::Verified;
use std::collections::BTreeMap;

/// Name of the field for the control state of the bed.
const CONTROL: &str = "control";

/// Greatest distance of a robot's orbit from the robot's position.
fn orbit_um(order: &MicrorobotsOrder, robot: usize) -> f64 {
    let facts = order.robot(robot);
    facts.turning_radius_um + facts.orbit_reach_um()
}

/// The frame that moves with a robot.
fn frame(device: &str, robot: &str) -> String {
    format!("{device}/{robot}")
}

/// The pose rounded so that its numbers are the same on every machine.
fn frame_pose(pose: &Pose) -> FramePose {
    let place = drawing::snap(nalgebra::Point2::new(pose.x_um, pose.y_um));
    FramePose::turned([place.x, place.y, 0.0], pose.heading_rad)
}

impl Pictures for MicrorobotsOrder {
    fn topics(&self, verified: &Verified, _signals: &Signals, device: &str) -> (Vec<LogTopic>, Vec<Mover>) {
        let motion = BedMotion::new(verified, device);
        let mut topics = vec![poses(&motion, device)];
        topics.extend((0..motion.robots.len()).map(|robot| path(&motion, device, robot)));
        topics.extend(arms(&motion, device, verified.schedule().duration_ns));
        topics.extend(scene::topics(&motion, device));
        (topics, movers(&motion, device))
    }

    fn reach(&self) -> [f64; 2] {
        let starts = (0..self.robots.len()).map(|robot| (self.robots[robot].pose, orbit_um(self, robot)));
        let goals = goals(self).map(|(robot, stop)| (stop.pose, orbit_um(self, robot)));
        let obstacles = self.obstacles.iter().map(|obstacle| (obstacle.pose, 0.0));
        let ends =
            starts.chain(goals).chain(obstacles).map(|(pose, reach_um)| [pose.x_um - reach_um, pose.x_um + reach_um]);
        ends.fold([0.0; 2], |[low, high], [left, right]| [f64::min(low, left), f64::max(high, right)])
    }
}

/// `/<device>/poses`: all robots, in the order of the table, which the metadata list.
fn poses(motion: &BedMotion, device: &str) -> LogTopic {
    let message = |moment: &BedMoment| {
        let poses = moment.poses.iter().filter_map(|pose| frame_pose(pose).pose()).collect();
        let (timestamp, frame_id) = (foxglove::timestamp(moment.t_ns), device.to_owned());
        (moment.t_ns, foxglove::encode(&PosesInFrame { timestamp, frame_id, poses }))
    };
    let moments = motion.plans.iter().flat_map(|plan| &plan.moments);
    let mut topic = LogTopic::new::<PosesInFrame>(format!("/{device}/poses"), moments.map(message).collect());
    topic.metadata.insert("robots".to_owned(), motion.robots.join(" "));
    topic
}

/// `/<device>/path/<robot>`: the path of a robot in each plan.
fn path(motion: &BedMotion, device: &str, robot: usize) -> LogTopic {
    let messages = motion.plans.iter().map(|plan| {
        let poses = plan.moments.iter().filter_map(|moment| frame_pose(&moment.poses[robot]).pose()).collect();
        let (timestamp, frame_id) = (foxglove::timestamp(plan.start_ns), device.to_owned());
        (plan.start_ns, foxglove::encode(&PosesInFrame { timestamp, frame_id, poses }))
    });
    LogTopic::new::<PosesInFrame>(format!("/{device}/path/{}", motion.robots[robot]), messages.collect())
}

/// `/<device>/arms`: the control state and every arm (1 for down) as numbers. The old values are repeated before each
/// change, so that a plot shows no slope, and all at the instants at which voltages are repeated.
fn arms(motion: &BedMotion, device: &str, duration_ns: u64) -> Option<LogTopic> {
    let facts = &motion.plans.first()?.order.facts;
    let rows = facts.robots.iter().map(|robot| robot.name.as_str());
    let names = identifier::distinct_fields(std::iter::once(CONTROL).chain(rows.clone()));
    let mut held: BTreeMap<u64, Vec<f64>> = BTreeMap::new();
    for leg in motion.plans.iter().flat_map(|plan| &plan.legs) {
        let before =
            leg.start_ns.checked_sub(1).and_then(|before_ns| Some((before_ns, held.values().next_back()?.clone())));
        if let Some((before_ns, last)) = before {
            held.entry(before_ns).or_insert(last);
        }
        let arms = leg.arms.iter().map(|arm| f64::from(*arm));
        held.insert(leg.start_ns, std::iter::once(leg.control as f64).chain(arms).collect());
    }
    repeat_values(&mut held, duration_ns);
    let package = format!("tweeze.{}", identifier::distinct([device])[0]);
    let metadata = names.iter().cloned().zip(
        std::iter::once("index of the control state".to_owned())
            .chain(rows.map(|name| format!("steering arm of {name}: 0 up, 1 down"))),
    );
    Some(LogTopic {
        name: format!("/{device}/arms"),
        schema: schema(&package, "Arms", MessageShape::Fields(&names)),
        metadata: metadata.collect(),
        messages: held.into_iter().map(|(t_ns, values)| (t_ns, encode_fields(&values))).collect(),
    })
}

/// The frame of each robot, written whenever it has moved, and once more before it moves.
fn movers(motion: &BedMotion, device: &str) -> Vec<Mover> {
    let moments: Vec<&BedMoment> = motion.plans.iter().flat_map(|plan| &plan.moments).collect();
    let of_robot = |(robot, name): (usize, &String)| {
        let moved = |a: usize, b: usize| moments[a].poses[robot] != moments[b].poses[robot];
        let is_kept = |at: &usize| *at == 0 || moved(at - 1, *at) || (at + 1 < moments.len() && moved(*at, at + 1));
        let places = (0..moments.len()).filter(is_kept);
        let places = places.map(|at| (moments[at].t_ns, Some(frame_pose(&moments[at].poses[robot])))).collect();
        let facts = motion.plans.first().map(|plan| plan.order.robot(robot));
        let outline = facts.map_or_else(Vec::new, |facts| scene::outline(facts, robot));
        Mover { frame: frame(device, name), device: device.to_owned(), places, outline }
    };
    motion.robots.iter().enumerate().map(of_robot).collect()
}

#[cfg(test)]
mod tests;
