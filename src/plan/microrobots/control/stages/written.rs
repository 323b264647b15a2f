//! Legs carried out as written in the plan, interval by interval; and waits.

use super::{Progress, StopReason};
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::wrapped_rad;
use crate::geometry::Pose;
use crate::plan::microrobots::control::CommandSegments;
use crate::plan::microrobots::control::belief::Belief;
use crate::plan::microrobots::strategy::Episode;
use crate::plan::microrobots::{AssemblyStage, Leg};
use crate::real::Real;

/// Legs without corrections.
#[derive(Debug, Clone)]
pub struct WrittenStage<'a> {
    legs: &'a [Leg],
    /// Index of the current leg, and strokes of it that have been driven.
    at: usize,
    driven: u64,
    /// Strokes of one interval.
    interval: u64,
    /// Robots that dock at the end, with their goals.
    docks: [Option<(usize, Pose)>; 2],
    /// State in which these run straight, and strokes in it after the legs.
    straight: usize,
    pushed: u64,
}

impl<'a> WrittenStage<'a> {
    /// Stage of a step that docks nothing.
    pub fn new(order: &MicrorobotsOrder, legs: &'a [Leg]) -> Self {
        let replan_ns = order.facts.errors.map_or(0, |errors| errors.replan_ns);
        let interval = (replan_ns / order.facts.period_ns.max(1)).max(1);
        WrittenStage { legs, at: 0, driven: 0, interval, docks: [None; 2], straight: 0, pushed: 0 }
    }

    /// Stage of an assembly.
    pub fn of(order: &MicrorobotsOrder, episode: &Episode<'a>) -> Self {
        let (docks, straight) = match *episode.stage {
            AssemblyStage::Pair { first, second, goals, states, .. } => {
                ([Some((first, goals[0])), Some((second, goals[1]))], states[2])
            }
            AssemblyStage::Single { robot, goal, states, .. } => ([Some((robot, goal)), None], states[1]),
            AssemblyStage::BedLegs { .. } | AssemblyStage::Escort { .. } => ([None; 2], 0),
        };
        WrittenStage { docks, straight, ..WrittenStage::new(order, episode.legs) }
    }

    /// Lets the robots that dock run straight after the legs, on a path of at least this length.
    pub fn push(&mut self, order: &MicrorobotsOrder, way_um: f64) {
        let steps_um = self.docks.iter().flatten().map(|(robot, _)| order.robot(*robot).step_um);
        let least_um = steps_um.fold(f64::INFINITY, f64::min);
        self.pushed = (way_um / least_um).ceil() as u64;
    }

    /// The robots that dock at the end.
    pub fn docking(&self) -> [Option<usize>; 2] {
        self.docks.map(|dock| dock.map(|(robot, _)| robot))
    }

    /// Most segments of one interval: a leg has at least one stroke.
    pub fn most_segments(&self) -> usize {
        self.legs.len().min(usize::try_from(self.interval).unwrap_or(usize::MAX)).saturating_add(2)
    }

    pub fn proceed(&mut self, belief: &mut Belief, command: &mut CommandSegments) -> Progress {
        let mut left = self.interval;
        while let Some(leg) = self.legs.get(self.at).filter(|_| left > 0) {
            let strokes = (leg.strokes - self.driven).min(left);
            command.add(leg.state, strokes);
            left -= strokes;
            self.driven += strokes;
            if self.driven >= leg.strokes {
                (self.at, self.driven) = (self.at + 1, 0);
            }
        }
        if left == self.interval && self.pushed > 0 {
            command.add(self.straight, std::mem::take(&mut self.pushed));
            return Progress::Driving;
        }
        if left < self.interval { Progress::Driving } else { self.judge(belief) }
    }

    /// Whether the robots that should have docked are measured in their places.
    fn judge(&self, belief: &mut Belief) -> Progress {
        let docking = belief.order.facts.docking;
        let most_um = belief.order.precision.place_um.max(docking.tolerance_um) + belief.errors.place_um;
        for (robot, goal) in self.docks.into_iter().flatten() {
            let pose = belief.poses[robot];
            let off_um = (pose.x_um - goal.x_um).hypotenuse(pose.y_um - goal.y_um);
            let off_rad = wrapped_rad(pose.heading_rad - goal.heading_rad).abs();
            if off_um > most_um || off_rad > docking.sticking_rad {
                return Progress::Failed(StopReason::Misplaced, robot);
            }
        }
        self.docks.into_iter().flatten().for_each(|(robot, _)| belief.dock(robot));
        if let [Some(first), Some(second)] = self.docks {
            belief.begin_structure([first, second]);
        }
        Progress::Done
    }
}

/// A time without voltage.
#[derive(Debug, Clone)]
pub struct RestStage {
    duration_ns: u64,
    until_ns: Option<u64>,
}

impl RestStage {
    pub fn new(duration_ns: u64) -> Self {
        RestStage { duration_ns, until_ns: None }
    }

    pub fn proceed(&mut self, now_ns: u64) -> Progress {
        let until_ns = *self.until_ns.get_or_insert(now_ns.saturating_add(self.duration_ns));
        if now_ns < until_ns { Progress::Resting(until_ns) } else { Progress::Done }
    }
}
