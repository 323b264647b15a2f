//! Lower bounds on the duration, the strokes and the control cycles of any plan of a job, over all control states it
//! may use and all stopping places within the precision.
//!
//! Problem: every robot moves with every stroke, so the pose of a robot when its turn comes depends on the plan; and a
//! plan that stops short within the precision saves a part of its path, and of the next one. Method: all plans of a job
//! agree on the poses of the robots at its start and after states that are applied before anything is driven and, up to
//! the precision, on the poses of a robot at its stops and docks. Between two such poses of one robot, the steps
//! together have at least as many strokes as its shortest path, and robots that come together hold one another up
//! ([`together`]). So the instants of the job are related by least differences, and the bound is the longest path
//! through them. Strokes are bounded by the longest path that counts them alone. Control cycles are counted where the
//! pose before a step does not depend on the plan: one for each part of the shortest path.
//!
//! Promise: no schedule that keeps the claims is faster, or has fewer strokes or control cycles. Not promised: that the
//! bound is attained; obstacles, other robots in the way and rounding to whole strokes are ignored. Cost: `MAX_EARLIER`
//! shortest paths for each stop and dock, and the square of the robots of an assembly.

pub mod together;

use super::free::{self, PoseWithin};
use super::{Crew, Leg, leg_ns};
use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder, MicrorobotsStop};
use crate::geometry::Pose;
use std::collections::BTreeSet;
use together::{EXACT, RobotArrival};

/// Number of earlier poses of its robot to which a stop is related: the latest ones.
const MAX_EARLIER: usize = 8;

/// Lower bounds on the figures of any plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LeastFigures {
    pub time_ns: u64,
    pub strokes: u64,
    /// Control cycles.
    pub switches: u64,
}

/// Lower bounds on the figures of any plan of these steps, from the current state of the robots.
pub fn least(order: &MicrorobotsOrder, start: &Crew) -> LeastFigures {
    let mut course = JobPrefix::new(order, start);
    order.steps.iter().for_each(|step| course.follow(&step.action));
    let latest = course.latest();
    LeastFigures { time_ns: course.at_ns[latest], strokes: course.strokes[latest], switches: course.switches }
}

/// Least number of strokes of any path of a robot from near one pose to near another.
fn least_strokes(order: &MicrorobotsOrder, robot: usize, from: PoseWithin, to: PoseWithin) -> u64 {
    together::least_strokes(order, vec![RobotArrival { robot, from, to }])
}

/// Pose of a robot at an instant that every plan shares.
#[derive(Debug, Clone, Copy)]
struct KnownPlace {
    instant: usize,
    at: PoseWithin,
}

/// A job up to one of its steps.
struct JobPrefix<'a> {
    order: &'a MicrorobotsOrder,
    /// Earliest time of each instant.
    at_ns: Vec<u64>,
    /// Time without strokes up to each instant in every plan: waits and control cycles.
    still_ns: Vec<u64>,
    /// Least number of strokes up to each instant.
    strokes: Vec<u64>,
    /// Least number of control cycles so far.
    switches: u64,
    /// For each robot of the order, in order of time.
    known: Vec<Vec<KnownPlace>>,
    docked: Vec<bool>,
    /// Poses of all robots, as long as they do not depend on the plan.
    poses: Option<Vec<Pose>>,
}

impl<'a> JobPrefix<'a> {
    fn new(order: &'a MicrorobotsOrder, start: &Crew) -> Self {
        let known = start
            .poses
            .iter()
            .map(|pose| vec![KnownPlace { instant: 0, at: PoseWithin { pose: *pose, slack: EXACT } }]);
        JobPrefix {
            order,
            at_ns: vec![0],
            still_ns: vec![0],
            strokes: vec![0],
            switches: 0,
            known: known.collect(),
            docked: start.docked.clone(),
            poses: Some(start.poses.clone()),
        }
    }

    fn latest(&self) -> usize {
        self.at_ns.len() - 1
    }

    fn follow(&mut self, action: &MicrorobotsAction) {
        match action {
            MicrorobotsAction::Wait(duration_ns) => {
                self.goes_by(*duration_ns, *duration_ns);
                self.know();
            }
            MicrorobotsAction::Apply { state, duration_ns } => self.apply(*state, *duration_ns),
            MicrorobotsAction::Drive { robot, stops } => {
                let first = stops.first().map(|stop| self.known_legs(*robot, stop));
                self.switches += first.unwrap_or(0) as u64;
                self.poses = None;
                stops.iter().for_each(|stop| self.arrive(&[(*robot, stop)]));
            }
            MicrorobotsAction::Assemble(docks) => {
                let most = docks.iter().map(|dock| self.known_legs(dock.robot, &dock.goal)).max();
                self.switches += most.unwrap_or(0) as u64;
                self.poses = None;
                let open: Vec<(usize, &MicrorobotsStop)> =
                    docks.iter().filter(|dock| !self.docked[dock.robot]).map(|dock| (dock.robot, &dock.goal)).collect();
                self.arrive(&open);
                open.iter().for_each(|(robot, _)| self.docked[*robot] = true);
            }
        }
    }

    /// Adds an instant `time_ns` after the latest one; for `still_ns` of that time there are no strokes.
    fn goes_by(&mut self, time_ns: u64, still_ns: u64) {
        let latest = self.latest();
        self.at_ns.push(self.at_ns[latest].saturating_add(time_ns));
        self.still_ns.push(self.still_ns[latest].saturating_add(still_ns));
        self.strokes.push(self.strokes[latest]);
    }

    fn apply(&mut self, state: usize, duration_ns: u64) {
        let facts = &self.order.facts;
        let leg = Leg { state, strokes: duration_ns.div_ceil(facts.period_ns) };
        let time_ns = leg_ns(self.order, leg);
        self.goes_by(time_ns, leg_ns(self.order, Leg { strokes: 0, ..leg }));
        let latest = self.latest();
        self.strokes[latest] = self.strokes[latest].saturating_add(leg.strokes);
        self.switches += 1;
        let order = self.order;
        for (robot, pose) in self.poses.iter_mut().flatten().enumerate().filter(|(robot, _)| !self.docked[*robot]) {
            *pose = leg.carried(order, robot, *pose);
        }
        self.know();
    }

    /// Records that the current poses do not depend on the plan; earlier records become useless.
    fn know(&mut self) {
        let instant = self.latest();
        for (known, pose) in self.known.iter_mut().zip(self.poses.iter().flatten()) {
            *known = vec![KnownPlace { instant, at: PoseWithin { pose: *pose, slack: EXACT } }];
        }
    }

    /// Records that robots reach stops; if there are several robots, they stay there.
    fn arrive(&mut self, stops: &[(usize, &MicrorobotsStop)]) {
        let cycles_ns = stops.iter().map(|(robot, stop)| self.cycles_ns(*robot, stop)).max().unwrap_or(0);
        self.goes_by(cycles_ns, cycles_ns);
        let instant = self.latest();
        let moving: Vec<&(usize, &MicrorobotsStop)> = stops.iter().filter(|(robot, _)| !self.docked[*robot]).collect();
        let known = |robot: usize| self.known[robot].iter().rev().take(MAX_EARLIER);
        let earlier: BTreeSet<usize> =
            moving.iter().flat_map(|(robot, _)| known(*robot)).map(|known| known.instant).collect();
        for earlier in earlier {
            let arrivals = moving.iter().filter_map(|(robot, stop)| {
                let from = known(*robot).find(|known| known.instant == earlier)?;
                let to = PoseWithin { pose: stop.pose, slack: self.order.precision };
                Some(RobotArrival { robot: *robot, from: from.at, to })
            });
            let strokes = together::least_strokes(self.order, arrivals.collect());
            let still_ns = self.still_ns[instant] - self.still_ns[earlier];
            let driven_ns = strokes.saturating_mul(self.order.facts.period_ns).saturating_add(still_ns);
            self.at_ns[instant] = self.at_ns[instant].max(self.at_ns[earlier].saturating_add(driven_ns));
            self.strokes[instant] = self.strokes[instant].max(self.strokes[earlier].saturating_add(strokes));
        }
        for (robot, stop) in moving {
            let at = PoseWithin { pose: stop.pose, slack: self.order.precision };
            self.known[*robot].push(KnownPlace { instant, at });
        }
    }

    /// Duration of the control cycles that a robot needs after the previous instant; 0 if its pose then is not known.
    fn cycles_ns(&self, robot: usize, stop: &MicrorobotsStop) -> u64 {
        let levels = self.order.states.iter().map(|state| state.levels_v.len()).min().unwrap_or(0);
        (self.legs(robot, stop) * levels) as u64 * self.order.facts.dwell_ns
    }

    /// Legs that a robot needs after the previous instant; 0 if its pose then is not known.
    fn legs(&self, robot: usize, stop: &MicrorobotsStop) -> usize {
        let (order, goal) = (self.order, PoseWithin { pose: stop.pose, slack: self.order.precision });
        let Some(known) = self.known[robot].last().filter(|known| known.instant == self.latest()) else { return 0 };
        if self.docked[robot] || least_strokes(order, robot, known.at, goal) == 0 {
            return 0;
        }
        match known.at.slack == EXACT {
            true => free::fewest_segments(order.robot(robot), known.at.pose, goal.pose, goal.slack),
            false => 1,
        }
    }

    /// Legs that a step needs until its first stop; 0 if the poses before the step depend on the plan.
    fn known_legs(&self, robot: usize, stop: &MicrorobotsStop) -> usize {
        if self.poses.is_some() { self.legs(robot, stop) } else { 0 }
    }
}

#[cfg(test)]
mod tests {
    use super::super::world::fixture::{bed, pose, robot};
    use super::*;
    use crate::device::microrobots::Arm;

    /// The bound never exceeds the strokes in which a path was driven, and equals them for a straight path.
    #[test]
    fn a_way_needs_no_more_strokes_than_it_is_driven_in() {
        let order = bed(vec![(robot("D1", 150.0, 0.015), pose(0.0, 0.0, 30.0))], Vec::new());
        let facts = order.robot(0);
        let from = order.robots[0].pose;
        let exact = |pose: Pose| PoseWithin { pose, slack: EXACT };
        for strokes in [1, 2, 1000, 123_456] {
            for arm in [Arm::Up, Arm::Down] {
                let to = facts.moved(from, arm, f64::from(strokes) * facts.step_um);
                let least = least_strokes(&order, 0, exact(from), exact(to));
                assert!(least <= strokes as u64, "{least} strokes where {strokes} do, arm {arm:?}");
                assert!(arm == Arm::Down || least == strokes as u64, "{least} of {strokes} strokes");
            }
        }
    }
}
