//! Collision model of the bed during planning: its bodies, and the first collision of a plan's legs.
//!
//! Input: the robots, obstacles and control states of an order; the poses of the robots; legs. Output: the first
//! violation of the collision rules, or none. The rules: a moving body keeps the clearance from obstacles and
//! other bodies; the disc of a robot that turns by a full turn or more keeps the orbit clearance from everything; a
//! robot that docks may approach the structure in the last stretch.
//!
//! Method: conservative advancement (Mirtich, 1996): the distance at an instant, divided by the greatest relative
//! speed, is a time during which nothing can happen. Two bodies that both run straight need no such steps: their
//! distance is convex in time. A body that runs straight past something at rest sweeps a rectangle.
//!
//! Promise: stricter than the rules by [`MARGIN_UM`], so that rounding decides nothing. A case that is not decided
//! within `MAX_SAMPLES` instants of one pair in one leg counts as a collision. Cost: pairs of robots + robots ×
//! obstacles for each leg, most of them decided by bounding volumes alone.

mod bed;
mod pairs;
mod rectangle;
mod statics;
mod tracks;

pub use bed::BedPoses;
pub use rectangle::OrientedRectangle;
pub use statics::{Fixtures, Obstruction, OrbitDisc};

use super::{Leg, RobotDocking};
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::{Arm, Robot};
use crate::geometry::{Pose, Rounded};
use crate::real::Real;
use std::f64::consts::TAU;
use tracks::RobotTrack;

/// Margin by which the planner is stricter than the rules.
pub const MARGIN_UM: f64 = 1e-3;

/// Tolerance of a full turn.
const MARGIN_RAD: f64 = 1e-6;

/// Most instants at which one pair is sampled during one leg.
const MAX_SAMPLES: u32 = 200_000;

/// The bodies, arms and clearances of an order, against which its legs are checked.
#[derive(Debug, Clone)]
pub struct CollisionWorld {
    bodies: Vec<RobotDimensions>,
    obstacles: Vec<WorldObstacle>,
    /// By control state, then by robot of the order.
    arms: Vec<Arm>,
    keep_um: f64,
    orbit_keep_um: f64,
    /// Largest overlap of docked bodies.
    overlap_um: f64,
    /// Length of the last stretch before docking.
    fine_um: f64,
}

/// A placed obstacle.
#[derive(Debug, Clone)]
struct WorldObstacle {
    body: Rounded,
    /// A bounding disc.
    bound: OrbitDisc,
}

/// Dimensions of a robot.
#[derive(Debug, Clone)]
pub struct RobotDimensions {
    pub robot: Robot,
    pub half_um: [f64; 2],
    /// Distance from its centre to its corners.
    pub corner_um: f64,
    /// Radius of its orbit disc.
    pub reach_um: f64,
}

/// A violation of the collision rules.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Collision {
    /// A body and an obstacle.
    Obstacle { robot: usize, obstacle: usize },
    /// Two bodies.
    Robots { robot: usize, other: usize },
    /// The disc of an orbiting robot, and an obstacle.
    OrbitObstacle { robot: usize, obstacle: usize },
    /// The disc of an orbiting robot, and a body.
    OrbitRobot { robot: usize, other: usize },
    /// Two orbit discs.
    Orbits { robot: usize, other: usize },
}

/// The first violation of the collision rules.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstCollision {
    pub collision: Collision,
    /// Index into the legs.
    pub leg: usize,
    /// Strokes of the leg completed by then.
    pub strokes: f64,
    /// Pose of the first robot of the collision at that time.
    pub at: Pose,
    /// Pose of the other robot at that time; of the first one, if there is no other.
    pub with: Pose,
}

impl CollisionWorld {
    /// The bed of an order. Obstacles whose shape cannot be placed are dropped: the checker rejects them.
    pub fn new(order: &MicrorobotsOrder) -> Self {
        let facts = &order.facts;
        let bodies: Vec<RobotDimensions> =
            order.robots.iter().map(|placed| RobotDimensions::new(&facts.robots[placed.row])).collect();
        let obstacles = order.obstacles.iter().filter_map(|obstacle| obstacle.shape.grown(&obstacle.pose, 0.0).ok());
        let arms_of = |state: usize| order.robots.iter().map(move |placed| order.states[state].arms[placed.row]);
        CollisionWorld {
            bodies,
            obstacles: obstacles.map(WorldObstacle::new).collect(),
            arms: (0..order.states.len()).flat_map(arms_of).collect(),
            keep_um: facts.clearance_um,
            orbit_keep_um: facts.orbit_clearance_um,
            overlap_um: facts.docking.tolerance_um,
            fine_um: facts.fine.length_um + facts.fine.cycle_um,
        }
    }

    /// Number of robots.
    pub fn count(&self) -> usize {
        self.bodies.len()
    }

    /// Number of control states.
    pub fn state_count(&self) -> usize {
        self.arms.len().checked_div(self.bodies.len()).unwrap_or(0)
    }

    /// The dimensions of a robot.
    pub fn body(&self, robot: usize) -> &RobotDimensions {
        &self.bodies[robot]
    }

    /// The bodies of the obstacles.
    pub fn obstacles(&self) -> impl Iterator<Item = &Rounded> {
        self.obstacles.iter().map(|obstacle| &obstacle.body)
    }

    /// The same bed with larger clearances: a path that is free there stays free when it is displaced by `room_um`.
    pub fn widened(&self, room_um: f64) -> Self {
        CollisionWorld { keep_um: self.keep_um + room_um, orbit_keep_um: self.orbit_keep_um + room_um, ..self.clone() }
    }

    /// The clearances of bodies and of discs.
    pub fn keeps_um(&self) -> [f64; 2] {
        [self.keep_um, self.orbit_keep_um]
    }

    /// Arm position of a robot in a control state.
    pub fn arm(&self, state: usize, robot: usize) -> Arm {
        self.arms[state * self.bodies.len() + robot]
    }

    /// Whether a control state keeps the arms of all docked robots up; a stroke with one of them down would turn the
    /// structure.
    fn keeps_docked_arms_up(&self, state: usize, docked: &[bool]) -> bool {
        (0..self.count()).all(|robot| !docked[robot] || self.arm(state, robot) == Arm::Up)
    }

    /// The control states that keep the arms of all docked robots up.
    pub fn allowed_states<'a>(&'a self, docked: &'a [bool]) -> impl Iterator<Item = usize> + 'a {
        (0..self.state_count()).filter(|state| self.keeps_docked_arms_up(*state, docked))
    }

    /// Path of the fastest robot that is not docked in one stroke; 0 if none moves.
    pub fn fastest_step_um(&self, docked: &[bool]) -> f64 {
        let moving = self.bodies.iter().zip(docked).filter(|(_, docked)| !**docked);
        moving.map(|(body, _)| body.robot.step_um).fold(0.0, f64::max)
    }

    /// The rectangle of a robot at a pose.
    pub fn rectangle(&self, robot: usize, pose: Pose) -> OrientedRectangle {
        OrientedRectangle::new(pose, self.bodies[robot].half_um)
    }

    /// The disc that a robot at a pose sweeps on its orbit.
    pub fn disc(&self, robot: usize, pose: Pose) -> OrbitDisc {
        let body = &self.bodies[robot];
        OrbitDisc { centre_um: body.robot.orbit_centre_um(pose), radius_um: body.reach_um }
    }

    /// Path length of a robot's centre in `strokes` strokes.
    pub fn way_um(&self, robot: usize, strokes: u64) -> f64 {
        self.bodies[robot].robot.step_um * strokes as f64
    }

    /// Moves all robots that are not docked by a leg.
    pub fn advance(&self, poses: &mut [Pose], docked: &[bool], leg: Leg) {
        for (robot, pose) in poses.iter_mut().enumerate().filter(|(robot, _)| !docked[*robot]) {
            *pose = self.bodies[robot].robot.moved(*pose, self.arm(leg.state, robot), self.way_um(robot, leg.strokes));
        }
    }

    /// First violation of the collision rules during the legs; turns before them do not count.
    pub fn first_collision(
        &self,
        start: &[Pose],
        docked: &[bool],
        legs: &[Leg],
        docks: &[RobotDocking],
    ) -> Option<FirstCollision> {
        let mut course = LegCursor::new(self, start, docked, legs, docks);
        (0..legs.len()).find_map(|leg| course.follow(leg))
    }

    /// Number of legs that violate the collision rules; turns before them do not count.
    pub fn colliding_legs(&self, start: &[Pose], docked: &[bool], legs: &[Leg], docks: &[RobotDocking]) -> usize {
        let mut course = LegCursor::new(self, start, docked, legs, docks);
        (0..legs.len()).filter(|leg| course.follow(*leg).is_some()).count()
    }
}

impl WorldObstacle {
    fn new(body: Rounded) -> Self {
        let [min_um, max_um] = [body.bounds().min_um, body.bounds().max_um];
        let centre_um = [0, 1].map(|axis| (min_um[axis] + max_um[axis]) / 2.0);
        let radius_um = (max_um[0] - min_um[0]).hypotenuse(max_um[1] - min_um[1]) / 2.0;
        WorldObstacle { body, bound: OrbitDisc { centre_um, radius_um } }
    }
}

impl RobotDimensions {
    fn new(robot: &Robot) -> Self {
        let half_um = [robot.length_um / 2.0, robot.width_um / 2.0];
        let (corner_um, reach_um) = (half_um[0].hypotenuse(half_um[1]), robot.orbit_reach_um());
        RobotDimensions { robot: robot.clone(), half_um, corner_um, reach_um }
    }

    /// The turning angle of a path.
    pub fn turn_rad(&self, way_um: f64) -> f64 {
        way_um / self.robot.turning_radius_um
    }
}

/// State while legs are followed.
struct LegCursor<'a> {
    world: &'a CollisionWorld,
    legs: &'a [Leg],
    docks: &'a [RobotDocking],
    poses: Vec<Pose>,
    docked: Vec<bool>,
    /// By leg, then by robot: whether the leg belongs to a stretch in which the robot's arm stays down for a full turn
    /// or more.
    orbits: Vec<bool>,
    tracks: Vec<RobotTrack>,
    /// For each robot, the instant of this leg from which it may come near the structure.
    fine_from: Vec<f64>,
}

impl<'a> LegCursor<'a> {
    fn new(
        world: &'a CollisionWorld,
        start: &[Pose],
        docked: &[bool],
        legs: &'a [Leg],
        docks: &'a [RobotDocking],
    ) -> Self {
        let count = world.count();
        let mut course = LegCursor {
            world,
            legs,
            docks,
            poses: start.to_vec(),
            docked: docked.to_vec(),
            orbits: vec![false; legs.len() * count],
            tracks: Vec::with_capacity(count),
            fine_from: vec![f64::INFINITY; count],
        };
        (0..count).filter(|robot| !docked[*robot]).for_each(|robot| course.mark_orbits(robot));
        course
    }

    /// The leg after which a robot rests.
    fn last_leg(&self, robot: usize) -> usize {
        self.docks.iter().find(|dock| dock.robot == robot).map_or(usize::MAX, |dock| dock.leg)
    }

    fn mark_orbits(&mut self, robot: usize) {
        let (count, last) = (self.world.count(), self.last_leg(robot));
        let moving = self.legs.len().min(last.saturating_add(1));
        let is_down = |leg: usize| self.world.arm(self.legs[leg].state, robot) == Arm::Down;
        let mut leg = 0;
        while leg < moving {
            let stretch = (leg..moving).take_while(|leg| is_down(*leg)).count();
            let strokes = self.legs[leg..leg + stretch].iter().map(|leg| leg.strokes).fold(0, u64::saturating_add);
            let turn_rad = self.world.bodies[robot].turn_rad(self.world.way_um(robot, strokes));
            if turn_rad >= TAU - MARGIN_RAD {
                (leg..leg + stretch).for_each(|leg| self.orbits[leg * count + robot] = true);
            }
            leg += stretch.max(1);
        }
    }

    /// Returns the first collision of a leg, if any, and advances the state to its end.
    fn follow(&mut self, leg: usize) -> Option<FirstCollision> {
        let Leg { state, strokes } = self.legs[leg];
        self.tracks.clear();
        for robot in 0..self.world.count() {
            let arm = (!self.docked[robot]).then(|| self.world.arm(state, robot));
            self.tracks.push(RobotTrack::new(&self.world.bodies[robot], self.poses[robot], arm, strokes as f64));
        }
        (0..self.world.count()).for_each(|robot| self.fine_from[robot] = self.fine_from(leg, robot));
        let hit = self.collision(leg);
        self.world.advance(&mut self.poses, &self.docked, self.legs[leg]);
        self.docks.iter().filter(|dock| dock.leg == leg).for_each(|dock| self.docked[dock.robot] = true);
        hit
    }

    /// Instant of a leg from which a robot is in the last stretch of its path; minus infinity for docked robots.
    fn fine_from(&self, leg: usize, robot: usize) -> f64 {
        if self.docked[robot] {
            return f64::NEG_INFINITY;
        }
        let last = self.last_leg(robot);
        if last >= self.legs.len() || last < leg {
            return f64::INFINITY;
        }
        let left: u64 = self.legs[leg..=last].iter().map(|leg| leg.strokes).fold(0, u64::saturating_add);
        left as f64 - (self.world.fine_um - MARGIN_UM) / self.world.bodies[robot].robot.step_um
    }

    /// Instant from which two robots may come as near as docked ones; infinite if never.
    fn near_from(&self, one: usize, other: usize) -> f64 {
        let together = self.last_leg(one) == self.last_leg(other) || self.docked[one] || self.docked[other];
        if together { self.fine_from[one].max(self.fine_from[other]) } else { f64::INFINITY }
    }
}

#[cfg(test)]
pub mod fixture;
#[cfg(test)]
mod tests;
