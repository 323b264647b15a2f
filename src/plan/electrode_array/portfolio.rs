//! The default planner: a plan fast, then better ones, then the proof.
//!
//! Problem: one stage, many parts to their goals at the same time. Method, in this order:
//! - [`fast::first`] for a short while; what it does not find is either hard or impossible, so [`exact::prove`] has a short look
//!   at small joint spaces and parts that block each other, and then [`fast::first`] may go on;
//! - [`fast::improve`] in rounds, until the objective meets its bound or its share of the budget is spent;
//! - [`exact::prove`] with what is left, which betters plan and bounds until they meet.
//!
//! Guaranteed: the answer is a legal plan with bounds that hold for every plan, a proof that there is none, or neither when the
//! budget is spent. Same instance and budget, same answer. What is not minimised is bettered too, but only for a while, and not
//! proven where that takes a search. Cost: one step of the budget is one node of one search.

use super::board::{Answer, Costs, Instance, Objective, Paths};
use super::{exact, fast};
use crate::plan::search::{Budget, Meter};

/// Steps of the first look for a plan: nearly all instances that are not crowded need fewer.
const QUICK_STEPS: u64 = 300_000;

/// The part of what is left for the look at what may be impossible.
const DOUBT_SHARE: u64 = 8;

/// The part of what is left for a first plan, once it is known to be hard.
const HARD_SHARE: u64 = 2;

/// The part of what is left for better plans.
const IMPROVE_SHARE: u64 = 4;

/// Steps of one round of improvement.
const ROUND_STEPS: u64 = 100_000;

/// The most steps for what is not minimised, and the part of what is left that they are.
const TIE_STEPS: u64 = 500_000;
const TIE_SHARE: u64 = 16;

/// A plan for a stage of at most `limit` steps.
pub fn solve(instance: &Instance, objective: Objective, limit: Option<u64>, budget: Budget) -> Answer {
    let bounds = match fast::bounds(instance) {
        Ok(bounds) => bounds,
        Err(why) => return Answer::Impossible(why),
    };
    let mut search = Search { instance, objective, limit, bounds, meter: Meter::new(budget) };
    match search.first() {
        Some(Answer::Found { paths, .. }) => search.better(paths),
        Some(decided) => decided,
        None => exact::prove(instance, objective, None, limit, &mut search.meter),
    }
}

struct Search<'a> {
    instance: &'a Instance,
    objective: Objective,
    limit: Option<u64>,
    /// Those of the parts each by itself.
    bounds: Costs,
    meter: Meter,
}

impl Search<'_> {
    /// A first plan, or the proof that there is none; `None` if neither was found within its shares.
    fn first(&mut self) -> Option<Answer> {
        let (instance, objective, limit, bounds) = (self.instance, self.objective, self.limit, self.bounds);
        let step_limit = limit.map(|limit| u32::try_from(limit).unwrap_or(u32::MAX));
        let found = |paths: Option<Paths>| paths.map(|paths| Answer::Found { paths, bounds });
        let fast = |seed: u64| move |share: &mut Meter| fast::first(instance, fast::Terms { seed, step_limit }, share);
        let quick = QUICK_STEPS.min(self.meter.left().steps / HARD_SHARE);
        if let Some(plan) = found(self.spend(quick, fast(1))) {
            return Some(plan);
        }
        let doubt = self.meter.left().steps / DOUBT_SHARE;
        match self.spend(doubt, |share| exact::prove(instance, objective, None, limit, share)) {
            Answer::GaveUp { .. } => {}
            decided => return Some(decided),
        }
        let hard = self.meter.left().steps / HARD_SHARE;
        found(self.spend(hard, fast(2)))
    }

    /// The best plan that the budget allows from a first one on.
    fn better(mut self, first: Paths) -> Answer {
        let mut best = first;
        let end = self.meter.left().steps - self.meter.left().steps / IMPROVE_SHARE;
        let mut seed = 1;
        while !self.is_met(&best) && self.meter.left().steps > end {
            best = self.round(best, seed, ROUND_STEPS);
            seed += 1;
        }
        if self.is_met(&best) {
            let paths = self.ties(best, seed);
            return Answer::Found { paths, bounds: self.bounds };
        }
        exact::prove(self.instance, self.objective, Some(&best), self.limit, &mut self.meter)
    }

    /// Betters what is not minimised.
    fn ties(&mut self, paths: Paths, seed: u64) -> Paths {
        let costs = Costs::of(&paths);
        if costs.makespan <= self.bounds.makespan && costs.sum_of_costs <= self.bounds.sum_of_costs {
            return paths;
        }
        let steps = TIE_STEPS.min(self.meter.left().steps / TIE_SHARE);
        self.round(paths, seed, steps)
    }

    /// One round of improvement; a plan that breaks the limit is not taken.
    fn round(&mut self, paths: Paths, seed: u64, steps: u64) -> Paths {
        let (instance, objective) = (self.instance, self.objective);
        let before = self.meter.spent();
        let better = self.spend(steps, |share| fast::improve(instance, paths.clone(), objective, seed, share));
        // A round that had nothing to search still is a round, so that rounds end.
        if self.meter.spent() == before {
            self.meter.charge(steps.max(1));
        }
        let keeps = self.limit.is_none_or(|limit| Costs::of(&better).makespan <= limit);
        if keeps { better } else { paths }
    }

    /// Whether the objective is as low as can be.
    fn is_met(&self, paths: &Paths) -> bool {
        let costs = Costs::of(paths);
        match self.objective {
            Objective::Makespan => costs.makespan <= self.bounds.makespan,
            Objective::SumOfCosts => costs.sum_of_costs <= self.bounds.sum_of_costs,
        }
    }

    /// Runs a search on so many steps of what is left.
    fn spend<T>(&mut self, steps: u64, search: impl FnOnce(&mut Meter) -> T) -> T {
        let mut part = Meter::new(Budget::of(steps.min(self.meter.left().steps)));
        let result = search(&mut part);
        self.meter.charge(part.spent());
        result
    }
}
