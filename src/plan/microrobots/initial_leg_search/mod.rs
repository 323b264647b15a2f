//! Initial legs of an assembly, or of what is left of one: the whole bed moves so that every robot begins near its place
//! and waits out of the way.
//!
//! Problem: every robot moves with every stroke. After the initial legs, robots are steered one after the other while
//! the rest orbit where they are. Any path that all of them make at the same time before is saved, and where they then
//! wait decides whether others get past. Method: threshold accepting. Each descent changes a short sequence of control
//! states and strokes, from another beginning and with its own random numbers; a change is kept if it does not worsen
//! the estimate of the whole assembly (`estimate`) by more than a shrinking random threshold, and the legs meet
//! nothing. Guaranteed: the legs keep the collision rules if no robot has been turning before, consecutive legs have
//! different states, and the same request gives the same legs. Not guaranteed: that the estimate is met, or that an
//! assembly is found after them. Cost: `ROUNDS` estimates for each descent.

mod estimate;

use super::initial_leg_changes::{LegChanges, merge_equal};
use super::initial_legs::InitialLegs;
use super::world::{BedPoses, CollisionWorld};
use super::{Leg, RobotDocking};
use crate::claims::microrobots::{Dock, MicrorobotsOrder};
use crate::geometry::Pose;
use crate::plan::parallel;
use crate::random::SplitMix64;
use estimate::AssemblyEstimate;

/// Most legs.
const MAX_LEGS: usize = 14;

/// Changes tried in one descent.
const ROUNDS: usize = 16_000;

/// Most legs with which a descent begins; every fourth descent, from the first on, begins with none.
const FIRST_LEGS: usize = 4;

/// Upper limit, at the beginning, of the path by which a change may worsen the estimate.
const HEAT_UM: f64 = 400.0;

/// Search for the initial legs of an assembly.
pub struct InitialLegSearch<'a> {
    order: &'a MicrorobotsOrder,
    world: &'a CollisionWorld,
    bed: &'a BedPoses,
    estimate: AssemblyEstimate,
    changes: LegChanges,
    /// Control state of the leg before, from which the first one differs.
    before: Option<usize>,
}

/// Candidate legs, and the cost of them and of the assembly after them, in strokes.
#[derive(Debug, Clone)]
struct InitialLegsCandidate {
    legs: Vec<Leg>,
    cost: f64,
}

impl<'a> InitialLegSearch<'a> {
    /// Search for robots with these goals, after a leg in control state `before`; `roomy` is the order with the
    /// clearances that the assembly keeps after the initial legs. `None` if there is nothing to move.
    pub fn new(
        order: &'a MicrorobotsOrder,
        roomy: &MicrorobotsOrder,
        world: &'a CollisionWorld,
        bed: &'a BedPoses,
        docks: &[Dock],
        before: Option<usize>,
    ) -> Option<InitialLegSearch<'a>> {
        let changes = LegChanges::new(world, &bed.docked)?;
        let estimate = AssemblyEstimate::new(roomy, world, bed, docks)?;
        Some(InitialLegSearch { order, world, bed, estimate, changes, before })
    }

    /// The best initial legs of descents with the seeds from 1 on, as far as there are any.
    pub fn descents(&self, count: usize) -> Vec<InitialLegs> {
        let descend = |descent: usize| self.descend(descent as u64 + 1);
        parallel::in_order(count, parallel::processors(), descend).into_iter().flatten().collect()
    }

    /// Runs one descent and returns its best initial legs; `None` if it is best to have none.
    pub fn descend(&self, seed: u64) -> Option<InitialLegs> {
        let mut random = SplitMix64::stream(seed, self.changes.state_count() as u64);
        let mut now = self.beginning(seed, &mut random);
        let mut best = now.clone();
        for round in 0..ROUNDS {
            let mut legs = now.legs.clone();
            for _ in 0..=random.below(2) {
                self.changes.change(&mut legs, &mut random);
            }
            self.changes.tidy(&mut legs);
            let cost = self.cost(&legs);
            let cooled = 1.0 - round as f64 / ROUNDS as f64;
            let allowed = HEAT_UM / self.changes.step_um() * cooled * cooled * random.unit();
            if cost < now.cost + allowed && legs.len() <= MAX_LEGS && self.is_free(&legs) {
                now = InitialLegsCandidate { legs, cost };
                if now.cost < best.cost {
                    best = now.clone();
                }
            }
        }
        self.followed(best.legs)
    }

    /// Changes initial legs by one random change; `None` if they stay the same, meet something or become empty.
    pub fn varied(&self, initial: &InitialLegs, random: &mut SplitMix64) -> Option<InitialLegs> {
        let mut legs = initial.legs.clone();
        self.changes.change(&mut legs, random);
        self.changes.tidy(&mut legs);
        let is_new = legs != initial.legs && self.is_free(&legs);
        is_new.then(|| self.followed(legs)).flatten()
    }

    fn followed(&self, legs: Vec<Leg>) -> Option<InitialLegs> {
        let mut bed = self.bed.clone();
        bed.follow(self.world, &legs, &NO_DOCKS);
        (!legs.is_empty()).then_some(InitialLegs { legs, bed })
    }

    fn beginning(&self, seed: u64, random: &mut SplitMix64) -> InitialLegsCandidate {
        let mut legs = Vec::new();
        if seed % 4 != 1 {
            for _ in 0..=random.below(FIRST_LEGS) {
                legs.push(self.changes.leg(random));
            }
            merge_equal(&mut legs);
            if !self.is_free(&legs) {
                legs.clear();
            }
        }
        let cost = self.cost(&legs);
        InitialLegsCandidate { legs, cost }
    }

    fn is_free(&self, legs: &[Leg]) -> bool {
        let goes_on = self.before.is_some() && legs.first().map(|leg| leg.state) == self.before;
        !goes_on && self.world.first_collision(&self.bed.poses, &self.bed.docked, legs, &NO_DOCKS).is_none()
    }

    /// Cost in strokes of the legs, with their control cycles, and of the estimate after them.
    fn cost(&self, legs: &[Leg]) -> f64 {
        let mut poses: Vec<Pose> = self.bed.poses.clone();
        legs.iter().for_each(|leg| self.world.advance(&mut poses, &self.bed.docked, *leg));
        let facts = &self.order.facts;
        let cycle = |leg: &Leg| self.order.states[leg.state].levels_v.len() as f64 * facts.dwell_ns as f64;
        let driven: f64 = legs.iter().map(|leg| leg.strokes as f64 + cycle(leg) / facts.period_ns as f64).sum();
        driven + self.estimate.strokes(&poses)
    }
}

const NO_DOCKS: [RobotDocking; 0] = [];

#[cfg(test)]
mod tests;
