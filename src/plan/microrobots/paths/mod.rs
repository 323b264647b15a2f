//! The shortest path of one robot around obstacles, discs and bodies at rest.
//!
//! Input: the bed, a robot, two poses, and fixtures on the bed besides the obstacles. Output: a path whose every
//! segment is free, with a lower bound on its length; or why there is none.
//!
//! Method: the free optimum first (`free`): if it is unobstructed it is optimal. Otherwise A* over polylines of the
//! centres of the robot's turning circle, as in `free`: the corners come from a finite set around the fixtures
//! (`corners`), and a state is a corner with the heading that led there. The heuristic is the larger of the free
//! optimum and the shortest polyline over free edges (`graph`). The first state from which the free optimum is
//! unobstructed ends the search. A turn is tested only when its end is expanded (lazy A*; Cohen, Phillips, Likhachev,
//! 2014). Several searches follow one another, each with more corners and a larger heuristic weight (`STAGES`): corners
//! that cost the least alone come first. The result is then shortened by moving its corners (`shorten`).
//!
//! Promise: a returned path is free. Not promised: that one is found where there is one, or that it is the shortest,
//! unless its length equals the bound. Cost grows with corners² × headings; each expanded state is a step of the
//! budget.

mod corners;
mod graph;
mod shorten;

use super::free::{self, ArmSegment, joined};
use super::world::{CollisionWorld, Fixtures, Obstruction};
use crate::device::microrobots::{Arm, Robot};
use crate::geometry::Pose;
use crate::plan::search::Meter;
use crate::real::Real;
use corners::OrderedCorners;
use graph::Graph;
use rustc_hash::FxHashMap;
use std::cmp::{Ordering, Reverse};
use std::collections::BinaryHeap;
use std::f64::consts::TAU;

/// The searches, one after the other until one finds a path.
const STAGES: [PathSearchSettings; 5] = [
    PathSearchSettings { corners: 48, weight: 1.0, states: 1_000 },
    PathSearchSettings { corners: 96, weight: 1.2, states: 2_000 },
    PathSearchSettings { corners: 192, weight: 1.5, states: 4_000 },
    PathSearchSettings { corners: 384, weight: 2.0, states: 20_000 },
    PathSearchSettings { corners: 640, weight: 3.0, states: 40_000 },
];

/// Settings of one search.
struct PathSearchSettings {
    /// Number of corners used.
    corners: usize,
    /// Heuristic weight (weighted A*): above 1 the search is greedier, and its path may be longer by this factor.
    weight: f64,
    /// Most expanded states, unless the budget ends earlier.
    states: u64,
}

/// States whose headings differ by less than this coincide.
const SAME_HEADING_RAD: f64 = TAU / 90.0;

/// Pairs of corners for one step of the budget; most of them need no test.
const EDGES_A_STEP: u64 = 64;

/// Most states of one search, open or closed.
const MAX_STATES: usize = 2_000_000;

/// A path request.
#[derive(Clone, Copy)]
pub struct PathRequest<'a> {
    pub world: &'a CollisionWorld,
    pub robot: usize,
    pub from: Pose,
    pub to: Pose,
    pub fixtures: &'a Fixtures,
}

/// A free path.
#[derive(Debug, Clone, PartialEq)]
pub struct FreePath {
    pub segments: Vec<ArmSegment>,
    pub length_um: f64,
    /// Lower bound on any path to the goal, whatever the surroundings.
    pub bound_um: f64,
}

/// Why there is no path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathFailure {
    /// A proof: the robot is too near to this at its start.
    Start(Obstruction),
    /// A proof: it would be too near to this at its goal.
    Goal(Obstruction),
    /// Every path over the corners that were tried is blocked; this blocks the shortest one. No proof.
    Blocked(Obstruction),
    /// The budget ran out; this blocks the shortest path. No proof.
    GaveUp(Obstruction),
}

impl<'a> PathRequest<'a> {
    /// A path around everything.
    pub fn find(&self, meter: &mut Meter) -> Result<FreePath, PathFailure> {
        let blocked = match self.direct() {
            Ok(found) => return Ok(found),
            Err(blocked) => blocked,
        };
        let at = |pose| self.world.obstruction_at(self.robot, pose, self.fixtures);
        at(self.from).map_or(Ok(()), |found| Err(PathFailure::Start(found)))?;
        at(self.to).map_or(Ok(()), |found| Err(PathFailure::Goal(found)))?;
        let bound_um = free::distance_um(self.facts(), self.from, self.to);
        let mut corners = OrderedCorners::around(self);
        for stage in STAGES {
            let corners = corners.first(self, stage.corners);
            let edges = (corners.len() * corners.len()) as u64 / EDGES_A_STEP;
            if meter.left().steps <= edges {
                return Err(PathFailure::GaveUp(blocked));
            }
            meter.charge(edges);
            if let Some(way) = CornerSearch::new(self, corners, stage).run(meter, blocked)? {
                let way = shorten::shortened(self, way);
                return Ok(FreePath { length_um: free::length_um(&way), segments: way, bound_um });
            }
        }
        Err(PathFailure::Blocked(blocked))
    }

    /// The free optimum if it is unobstructed, or the other free path if it is as short; otherwise the obstruction of
    /// the optimum.
    pub fn direct(&self) -> Result<FreePath, Obstruction> {
        let words = free::words(self.facts(), self.from, self.to);
        let radius_um = self.facts().turning_radius_um;
        let bound_um = words[0].length_um(radius_um);
        let tried = words.map(|word| {
            let way = word.segments(radius_um);
            match self.obstruction_on(self.from, &way) {
                None => Ok(FreePath { length_um: free::length_um(&way), segments: way, bound_um }),
                Some(found) => Err(found),
            }
        });
        let [one, other] = tried;
        one.or_else(|blocked| match other {
            // The longer one is a valid path, but perhaps not the best one around the obstruction: the search decides.
            Ok(found) if found.length_um <= bound_um + free::SLACK_UM => Ok(found),
            Ok(_) | Err(_) => Err(blocked),
        })
    }

    fn facts(&self) -> &'a Robot {
        &self.world.body(self.robot).robot
    }

    fn obstruction_on(&self, from: Pose, way: &[ArmSegment]) -> Option<Obstruction> {
        self.world.obstruction_on(self.robot, from, way, self.fixtures).map(|(_, found)| found)
    }

    fn is_free(&self, from: Pose, way: &[ArmSegment]) -> bool {
        self.obstruction_on(from, way).is_none()
    }

    fn end(&self, from: Pose, way: &[ArmSegment]) -> Pose {
        way.iter().fold(from, |pose, segment| self.facts().moved(pose, segment.arm, segment.way_um))
    }

    /// The pose of a robot with this turning centre.
    fn pose_about(&self, [x_um, y_um]: [f64; 2], heading_rad: f64) -> Pose {
        let [dx, dy] = self.facts().orbit_centre_um(Pose { x_um: 0.0, y_um: 0.0, heading_rad });
        Pose { x_um: x_um - dx, y_um: y_um - dy, heading_rad }
    }

    /// The turn and the run from a pose to a turning centre; `None` if the robot's centre is there already.
    fn leg_to(&self, from: Pose, middle_um: [f64; 2]) -> Option<[ArmSegment; 2]> {
        let here_um = self.facts().orbit_centre_um(from);
        let [dx, dy] = [0, 1].map(|axis| middle_um[axis] - here_um[axis]);
        let way_um = dx.hypotenuse(dy);
        let turn_rad = free::turn_rad(self.facts(), from.heading_rad, dy.arc_tangent_over(dx));
        let turn = ArmSegment { arm: Arm::Down, way_um: turn_rad * self.facts().turning_radius_um };
        (way_um > SHORTEST_UM).then_some([turn, ArmSegment { arm: Arm::Up, way_um }])
    }
}

/// Edges between corners are longer than this.
const SHORTEST_UM: f64 = 0.5;

/// A search over a set of corners.
struct CornerSearch<'a> {
    request: &'a PathRequest<'a>,
    corners: &'a [[f64; 2]],
    graph: Graph<'a>,
    stage: PathSearchSettings,
    states: Vec<CornerState>,
    queue: BinaryHeap<Reverse<CornerEntry>>,
    /// Least cost at which a corner was expanded, by heading.
    done: FxHashMap<(u32, u16), f64>,
}

/// A corner with the heading that led there.
#[derive(Clone, Copy)]
struct CornerState {
    pose: Pose,
    cost_um: f64,
    corner: u32,
    before: u32,
}

/// Index of the start, which is not a corner.
const START: u32 = u32::MAX;

#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct CornerEntry {
    estimate_um: TotallyOrdered,
    state: u32,
}

/// A number in the order of [`f64::total_cmp`].
#[derive(Debug, Clone, Copy)]
struct TotallyOrdered(f64);

impl Ord for TotallyOrdered {
    fn cmp(&self, other: &Self) -> Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl PartialOrd for TotallyOrdered {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for TotallyOrdered {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for TotallyOrdered {}

impl<'a> CornerSearch<'a> {
    fn new(request: &'a PathRequest<'a>, corners: &'a [[f64; 2]], stage: PathSearchSettings) -> Self {
        let (states, queue, done) = (Vec::new(), BinaryHeap::new(), FxHashMap::default());
        let mut search =
            CornerSearch { request, corners, graph: Graph::new(request, corners), stage, states, queue, done };
        search.push(CornerState { pose: request.from, cost_um: 0.0, corner: START, before: START });
        search
    }

    /// The cheapest path over the corners; `None` if there is none.
    fn run(mut self, meter: &mut Meter, blocked: Obstruction) -> Result<Option<Vec<ArmSegment>>, PathFailure> {
        let mut taken = 0;
        while let Some(Reverse(CornerEntry { state: index, .. })) = self.queue.pop() {
            if taken >= self.stage.states {
                return Ok(None);
            }
            taken += 1;
            meter.step().ok_or(PathFailure::GaveUp(blocked))?;
            let state = self.states[index as usize];
            if self.is_done(&state) || !self.is_reached(&state) {
                continue;
            }
            self.settle(&state);
            let rest = free::shortest(self.request.facts(), state.pose, self.request.to);
            if self.request.is_free(state.pose, &rest) {
                return Ok(Some(self.path_to(index, rest)));
            }
            self.expand(index);
            if self.states.len() > MAX_STATES {
                return Err(PathFailure::GaveUp(blocked));
            }
        }
        Ok(None)
    }

    fn key(state: &CornerState) -> (u32, u16) {
        (state.corner, (state.pose.heading_rad.rem_euclid(TAU) / SAME_HEADING_RAD) as u16)
    }

    fn is_done(&self, state: &CornerState) -> bool {
        self.done.get(&Self::key(state)).is_some_and(|cost_um| *cost_um <= state.cost_um)
    }

    fn settle(&mut self, state: &CornerState) {
        self.done.insert(Self::key(state), state.cost_um);
    }

    /// Whether the last leg to a state is free. Runs between corners were already tested for the graph.
    fn is_reached(&self, state: &CornerState) -> bool {
        let Some(before) = self.states.get(state.before as usize) else { return true };
        let leg = self.request.leg_to(before.pose, self.corners[state.corner as usize]);
        let asked = if before.corner == START { 2 } else { 1 };
        leg.is_some_and(|leg| self.request.is_free(before.pose, &leg[..asked]))
    }

    fn expand(&mut self, index: u32) {
        let state = self.states[index as usize];
        for corner in 0..self.corners.len() {
            let leads_on = self.graph.rest_um(corner).is_finite()
                && (state.corner == START || self.graph.leads(state.corner as usize, corner));
            if !leads_on {
                continue;
            }
            let Some(leg) = self.request.leg_to(state.pose, self.corners[corner]) else { continue };
            let heading_rad = state.pose.heading_rad
                + self.request.facts().turning.sign() * leg[0].way_um / self.request.facts().turning_radius_um;
            let pose = self.request.pose_about(self.corners[corner], heading_rad);
            let cost_um = state.cost_um + leg[0].way_um + leg[1].way_um;
            self.push(CornerState { pose, cost_um, corner: corner as u32, before: index });
        }
    }

    fn push(&mut self, state: CornerState) {
        let corner = (state.corner != START).then_some(state.corner as usize);
        if self.is_done(&state) {
            return;
        }
        let known_um = corner.map_or(0.0, |corner| self.graph.rest_um(corner));
        let turn_rad = free::turn_rad(self.request.facts(), state.pose.heading_rad, self.request.to.heading_rad);
        let known_um = known_um + turn_rad * self.request.facts().turning_radius_um;
        let rest_um = free::distance_um(self.request.facts(), state.pose, self.request.to);
        let estimate_um = TotallyOrdered(state.cost_um + self.stage.weight * rest_um.max(known_um));
        self.queue.push(Reverse(CornerEntry { estimate_um, state: self.states.len() as u32 }));
        self.states.push(state);
    }

    fn path_to(&self, index: u32, rest: Vec<ArmSegment>) -> Vec<ArmSegment> {
        let mut legs: Vec<[ArmSegment; 2]> = Vec::new();
        let mut state = &self.states[index as usize];
        while let Some(before) = self.states.get(state.before as usize) {
            legs.extend(self.request.leg_to(before.pose, self.corners[state.corner as usize]));
            state = before;
        }
        joined(legs.into_iter().rev().flatten().chain(rest))
    }
}

#[cfg(test)]
mod tests;
