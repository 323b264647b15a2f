//! Initial legs of a drive from a random tree: the states of the bed that legs lead to, explored evenly.
//!
//! Problem: sequences of legs drawn at once mostly meet something where the bed is crowded, and short ones do not lead
//! far. Method: a rapidly exploring random tree (LaValle, 1998) over the poses of all robots. A pose of one robot is
//! drawn, more often of the driven one, and the state of the bed nearest to it in that pose is extended by a leg in a
//! random control state, cut before the first collision. Every new state is returned with the legs to it. Guaranteed:
//! consecutive legs have different states, no leg meets anything from where it begins, and the same request gives the
//! same legs. Not guaranteed: that a state is found from which the goal is reached; and a robot that turns by a full
//! turn or more keeps a larger clearance during all legs of that turn, so the caller checks all legs. Cost: a search
//! through all states, and one or two checks of a leg, for each state.

use super::Leg;
use super::initial_legs::InitialLegs;
use super::world::{BedPoses, CollisionWorld};
use crate::device::microrobots::wrapped_rad;
use crate::geometry::Pose;
use crate::random::SplitMix64;
use std::f64::consts::TAU;

/// Margin of the square in which poses are drawn, around the robots, their goals and the obstacles.
const MARGIN_UM: f64 = 500.0;

/// Longest path of a leg, and the shortest one, in micrometres.
const LONGEST_UM: f64 = 1_500.0;
const SHORTEST_UM: f64 = 5.0;

/// Draws without a new state after which the tree ends.
const MAX_VAIN_DRAWS: usize = 10_000;

/// A random tree of the states of a bed.
pub struct InitialLegTree<'a> {
    world: &'a CollisionWorld,
    /// The driven robot.
    driven: usize,
    random: SplitMix64,
    /// Control states that keep the arms of docked robots up.
    states: Vec<usize>,
    /// Robots that are not docked.
    moving: Vec<usize>,
    /// Path of the fastest of them in one stroke.
    step_um: f64,
    /// Least and greatest coordinate of the poses drawn, by axis.
    square_um: [[f64; 2]; 2],
    nodes: Vec<TreeNode>,
    /// By robot, then by node.
    poses: Vec<Vec<Pose>>,
}

/// A state of the bed, and the legs to it.
#[derive(Clone)]
struct TreeNode {
    bed: BedPoses,
    legs: Vec<Leg>,
}

impl<'a> InitialLegTree<'a> {
    /// The tree of a bed whose robot `driven` is to reach these stops.
    pub fn new(
        world: &'a CollisionWorld,
        bed: &BedPoses,
        driven: usize,
        stops: &[Pose],
        seed: u64,
    ) -> InitialLegTree<'a> {
        let moving: Vec<usize> = (0..world.count()).filter(|robot| !bed.docked[*robot]).collect();
        let robots = bed.poses.iter().chain(stops).map(|pose| [[pose.x_um; 2], [pose.y_um; 2]]);
        let obstacles = world.obstacles().map(|obstacle| {
            let (min_um, max_um) = (obstacle.bounds().min_um, obstacle.bounds().max_um);
            [0, 1].map(|axis| [min_um[axis], max_um[axis]])
        });
        let joined = |one: [[f64; 2]; 2], other: [[f64; 2]; 2]| {
            [0, 1].map(|axis| [one[axis][0].min(other[axis][0]), one[axis][1].max(other[axis][1])])
        };
        let square_um = robots.chain(obstacles).reduce(joined).unwrap_or_default();
        InitialLegTree {
            world,
            driven,
            random: SplitMix64::new(seed),
            states: world.allowed_states(&bed.docked).collect(),
            step_um: world.fastest_step_um(&bed.docked),
            moving,
            square_um: square_um.map(|[least, most]| [least - MARGIN_UM, most + MARGIN_UM]),
            poses: bed.poses.iter().map(|pose| vec![*pose]).collect(),
            nodes: vec![TreeNode { bed: bed.clone(), legs: Vec::new() }],
        }
    }

    /// The node with the pose nearest to a random one, or in every fourth case a random node.
    fn drawn(&mut self) -> usize {
        let random = &mut self.random;
        let robot = match random.below(2) {
            0 => self.driven,
            _ => self.moving[random.below(self.moving.len())],
        };
        let [x_um, y_um] = self.square_um.map(|[least, most]| least + (most - least) * random.unit());
        let heading_rad = TAU * random.unit();
        if random.below(4) == 0 {
            return random.below(self.nodes.len());
        }
        let radius_um = self.world.body(robot).robot.turning_radius_um;
        let far_um2 = |pose: &Pose| {
            let [dx, dy] = [pose.x_um - x_um, pose.y_um - y_um];
            let across_um = wrapped_rad(pose.heading_rad - heading_rad).abs() * radius_um;
            dx * dx + dy * dy + across_um * across_um
        };
        let nearest = self.poses[robot].iter().map(far_um2).enumerate().min_by(|one, other| one.1.total_cmp(&other.1));
        nearest.map_or(0, |nearest| nearest.0)
    }

    /// A random leg from a node, cut before its first collision; `None` if too little is left.
    fn leg(&mut self, node: usize) -> Option<Leg> {
        let node = &self.nodes[node];
        let state = self.states[self.random.below(self.states.len())];
        if node.legs.last().is_some_and(|last| last.state == state) {
            return None;
        }
        let [first, second, third] = [self.random.unit(), self.random.unit(), self.random.unit()];
        let leg = Leg { state, strokes: ((SHORTEST_UM + LONGEST_UM * first * second * third) / self.step_um) as u64 };
        let Some(hit) = node.bed.first_collision(self.world, &[leg], &[]) else { return Some(leg) };
        let share = self.random.unit();
        let leg = Leg { strokes: (hit.strokes * (1.0 - share * share)) as u64, ..leg };
        let is_free = leg.strokes as f64 * self.step_um >= SHORTEST_UM
            && node.bed.first_collision(self.world, &[leg], &[]).is_none();
        is_free.then_some(leg)
    }
}

impl Iterator for InitialLegTree<'_> {
    type Item = InitialLegs;

    fn next(&mut self) -> Option<InitialLegs> {
        if self.states.is_empty() || self.step_um == 0.0 {
            return None;
        }
        for _ in 0..MAX_VAIN_DRAWS {
            let from = self.drawn();
            let Some(leg) = self.leg(from) else { continue };
            let TreeNode { mut bed, mut legs } = self.nodes[from].clone();
            bed.follow(self.world, &[leg], &[]);
            legs.push(leg);
            self.poses.iter_mut().zip(&bed.poses).for_each(|(poses, pose)| poses.push(*pose));
            self.nodes.push(TreeNode { bed: bed.clone(), legs: legs.clone() });
            return Some(InitialLegs { legs, bed });
        }
        None
    }
}

#[cfg(test)]
mod tests;
