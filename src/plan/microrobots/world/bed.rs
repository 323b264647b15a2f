//! State of the bed between steps: poses of the robots, and the legs since their arms were last up.

use super::{CollisionWorld, FirstCollision};
use crate::device::microrobots::Arm;
use crate::geometry::Pose;
use crate::plan::microrobots::{Leg, RobotDocking};

/// Poses of the robots, and the recent legs during which some arm stayed down: its turn continues to count in later
/// legs.
#[derive(Debug, Clone, PartialEq)]
pub struct BedPoses {
    /// Pose of each robot of the order.
    pub poses: Vec<Pose>,
    /// Whether it is docked.
    pub docked: Vec<bool>,
    /// Poses and docked robots before the recorded legs.
    before: (Vec<Pose>, Vec<bool>),
    legs: Vec<Leg>,
    docks: Vec<RobotDocking>,
}

impl BedPoses {
    /// A bed at rest: all arms are up.
    pub fn new(poses: Vec<Pose>, docked: Vec<bool>) -> Self {
        BedPoses { before: (poses.clone(), docked.clone()), poses, docked, legs: Vec::new(), docks: Vec::new() }
    }

    /// Raises all arms.
    pub fn rest(&mut self) {
        *self = BedPoses::new(std::mem::take(&mut self.poses), std::mem::take(&mut self.docked));
    }

    /// First collision in the coming legs. Its leg is an index into them; 0 if an orbit disc was already
    /// violated in the recorded legs.
    pub fn first_collision(
        &self,
        world: &CollisionWorld,
        legs: &[Leg],
        docks: &[RobotDocking],
    ) -> Option<FirstCollision> {
        let past = self.legs.len();
        if past == 0 {
            return world.first_collision(&self.poses, &self.docked, legs, docks);
        }
        let (all, docks) = self.with_recorded(legs, docks);
        let hit = world.first_collision(&self.before.0, &self.before.1, &all, &docks);
        hit.map(|hit| FirstCollision { leg: hit.leg.saturating_sub(past), ..hit })
    }

    /// Number of legs that violate the collision rules, among the recorded and the coming ones.
    pub fn colliding_legs(&self, world: &CollisionWorld, legs: &[Leg], docks: &[RobotDocking]) -> usize {
        let (all, docks) = self.with_recorded(legs, docks);
        world.colliding_legs(&self.before.0, &self.before.1, &all, &docks)
    }

    /// The recorded legs and dockings, then the given ones.
    fn with_recorded(&self, legs: &[Leg], docks: &[RobotDocking]) -> (Vec<Leg>, Vec<RobotDocking>) {
        let later = docks.iter().map(|dock| RobotDocking { leg: dock.leg + self.legs.len(), ..*dock });
        (self.legs.iter().chain(legs).copied().collect(), self.docks.iter().copied().chain(later).collect())
    }

    /// Advances through legs.
    pub fn follow(&mut self, world: &CollisionWorld, legs: &[Leg], docks: &[RobotDocking]) {
        let past = self.legs.len();
        for (index, leg) in legs.iter().enumerate() {
            world.advance(&mut self.poses, &self.docked, *leg);
            docks.iter().filter(|dock| dock.leg == index).for_each(|dock| self.docked[dock.robot] = true);
        }
        self.legs.extend(legs);
        self.docks.extend(docks.iter().map(|dock| RobotDocking { leg: dock.leg + past, ..*dock }));
        self.forget(world);
    }

    /// Drops the recorded legs before the earliest one since which some arm has stayed down.
    fn forget(&mut self, world: &CollisionWorld) {
        let held = |robot: &usize| {
            let down = |leg: &&Leg| world.arm(leg.state, *robot) == Arm::Down;
            self.legs.iter().rev().take_while(down).count()
        };
        let moving = (0..world.count()).filter(|robot| !self.docked[*robot]);
        let dropped = self.legs.len() - moving.map(|robot| held(&robot)).max().unwrap_or(0);
        for (index, leg) in self.legs.drain(..dropped).enumerate() {
            world.advance(&mut self.before.0, &self.before.1, leg);
            self.docks.iter().filter(|dock| dock.leg == index).for_each(|dock| self.before.1[dock.robot] = true);
        }
        self.docks.retain_mut(|dock| match dock.leg.checked_sub(dropped) {
            Some(leg) => {
                dock.leg = leg;
                true
            }
            None => false,
        });
    }
}
