//! Initial legs of a step: the whole bed moves before the step proper, which then finds more room or a faster way.
//! Drives take them from a random tree ([`super::initial_leg_tree`]). Assemblies search for theirs
//! ([`super::initial_leg_search`]), and draw them at random, as here, only if that finds none.
//!
//! Problem: every robot moves with every stroke, so what stands in the way of a step, and which orbit lies over a goal,
//! depend on where the step begins. Method: random sequences of a few legs in control states that keep docked arms up,
//! from a fixed seed; the caller plans its step from where each ends and keeps the best. Guaranteed: the legs are free
//! of collisions, consecutive legs have different states, and the same request gives the same sequences. Not
//! guaranteed: that one of them helps. Cost: one check of its legs against the collision rules per sequence.

use super::world::{BedPoses, CollisionWorld};
use super::{Leg, RobotDocking};
use crate::geometry::Pose;
use crate::random::SplitMix64;

/// Most initial legs of a step.
const MAX_LEGS: usize = 3;

/// Most sequences drawn in search of one that is free of collisions; then the iterator ends.
const MAX_DRAWS: usize = 16;

/// Shortest path of a leg, as a share of the longest.
const SHORTEST_SHARE: f64 = 0.02;

/// Lower limit on the path of the longest leg, in micrometres: a few bodies, so that robots that stand close have a
/// choice.
const LEAST_SPAN_UM: f64 = 800.0;

/// Initial legs, and the bed after them.
#[derive(Debug, Clone)]
pub struct InitialLegs {
    pub legs: Vec<Leg>,
    pub bed: BedPoses,
}

/// Draws of initial legs for a bed, in a fixed random order.
pub struct RandomInitialLegs<'a> {
    world: &'a CollisionWorld,
    bed: &'a BedPoses,
    random: SplitMix64,
    /// Control states that keep the arms of docked robots up.
    states: Vec<usize>,
    /// Strokes of the longest leg.
    most_strokes: u64,
}

impl<'a> RandomInitialLegs<'a> {
    /// Initial legs for robots with these goals; another seed gives other sequences.
    pub fn new(
        world: &'a CollisionWorld,
        bed: &'a BedPoses,
        goals: impl Iterator<Item = Pose>,
        seed: u64,
    ) -> RandomInitialLegs<'a> {
        let moving = (0..world.count()).filter(|robot| !bed.docked[*robot]);
        let poses: Vec<Pose> = moving.map(|robot| bed.poses[robot]).chain(goals).collect();
        let extent_um = |of: fn(&Pose) -> f64| {
            let all = || poses.iter().map(of);
            all().fold(f64::NEG_INFINITY, f64::max) - all().fold(f64::INFINITY, f64::min)
        };
        let span_um = extent_um(|pose| pose.x_um).max(extent_um(|pose| pose.y_um)).max(LEAST_SPAN_UM);
        let step_um = world.fastest_step_um(&bed.docked);
        RandomInitialLegs {
            world,
            bed,
            random: SplitMix64::new(seed),
            states: world.allowed_states(&bed.docked).filter(|_| step_um > 0.0).collect(),
            most_strokes: (span_um / step_um.max(f64::MIN_POSITIVE)) as u64,
        }
    }

    /// Draws random legs. Short ones are more likely, and so are few, since a repeated state is dropped.
    fn draw(&mut self) -> Vec<Leg> {
        let mut legs: Vec<Leg> = Vec::with_capacity(MAX_LEGS);
        for _ in 0..=self.random.below(MAX_LEGS) {
            let state = self.states[self.random.below(self.states.len())];
            let share = SHORTEST_SHARE + (1.0 - SHORTEST_SHARE) * self.random.unit() * self.random.unit();
            let strokes = ((self.most_strokes as f64 * share) as u64).max(1);
            if legs.last().is_none_or(|last| last.state != state) {
                legs.push(Leg { state, strokes });
            }
        }
        legs
    }
}

impl Iterator for RandomInitialLegs<'_> {
    type Item = InitialLegs;

    fn next(&mut self) -> Option<InitialLegs> {
        const NONE: [RobotDocking; 0] = [];
        if self.states.is_empty() {
            return None;
        }
        for _ in 0..MAX_DRAWS {
            let legs = self.draw();
            if self.bed.first_collision(self.world, &legs, &NONE).is_none() {
                let mut bed = self.bed.clone();
                bed.follow(self.world, &legs, &NONE);
                return Some(InitialLegs { legs, bed });
            }
        }
        None
    }
}
