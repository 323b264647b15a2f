//! The default planner: a plan fast, then better ones, then the proof.
//!
//! Problem: one stage, many parts to their goals at the same time. A part by itself has its shortest way ([`alone`]). Method for
//! several, in this order:
//! - By turns, each longer than the one before, [`fast::first`] looks for a plan and [`exact::prove`] for a reason why there is
//!   none (small joint spaces, parts that block each other) until one of them has found something.
//! - Until the objective meets its bound or their share of the budget is spent: [`fast::improve`] in rounds and, where a round leaves
//!   the makespan as it was, [`fast::first`] within one step less.
//! - [`exact::prove`] with what is left, which betters plan and bounds until they meet.
//!
//! Guaranteed: the answer is a legal plan with bounds that hold for every plan, a proof that there is none, or neither when the
//! budget is spent. Same instance and budget, same answer. What is not minimised is bettered too, but only while that goes quickly,
//! and not proven where that takes a search. Cost: one step of the budget is one node of one search.

use super::board::{Answer, Costs, Instance, Objective, Paths, Why};
use super::{alone, exact, fast};
use crate::plan::search::{Budget, Meter};

/// Steps of the first turn: nearly all instances that are not crowded need fewer.
const TURN_STEPS: u64 = 20_000;

/// How many times longer each turn is than the one before.
const TURN_GROWTH: u64 = 4;

/// In a turn, the look at what may be impossible gets this part of the steps of the look for a plan.
const DOUBT_SHARE: u64 = 1;

/// The part of the budget that the turns leave for the proof that there is no plan.
const HARD_SHARE: u64 = 4;

/// The part of what is left for better plans.
const IMPROVE_SHARE: u64 = 4;

/// Steps of one round of improvement, and of one look for a plan with a step less; and so many more for each step of the parts.
const ROUND_STEPS: u64 = 100_000;
const SQUEEZE_STEPS: u64 = 400_000;
const STEPS_PER_MOVE: u64 = 5;

/// Steps of one round for what is not minimised, besides one for each step of the parts; and the part of what is left that all are
/// at most.
const TIE_STEPS: u64 = 20_000;
const TIE_SHARE: u64 = 16;

/// A round gains little if it is no more than this part.
const TIE_GAIN: u64 = 500;

/// A plan for a stage of at most `limit` steps.
pub fn solve(instance: &Instance, objective: Objective, limit: Option<u64>, budget: Budget) -> Answer {
    if instance.agents.len() == 1 {
        return by_itself(instance, limit);
    }
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

/// The plan of a part that nothing that moves can be in the way of.
fn by_itself(instance: &Instance, limit: Option<u64>) -> Answer {
    match alone::way(instance) {
        Err(why) => Answer::Impossible(why),
        Ok(way) => {
            let paths = vec![way];
            let bounds = Costs::of(&paths);
            match limit {
                Some(limit) if bounds.makespan > limit => {
                    Answer::Impossible(Why::TooFewSteps { least: bounds.makespan })
                }
                Some(_) | None => Answer::Found { paths, bounds },
            }
        }
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
        let reserve = self.meter.left().steps / HARD_SHARE;
        let (mut steps, mut seed) = (TURN_STEPS, 1);
        while self.meter.left().steps > reserve {
            let most = self.meter.left().steps - reserve;
            if let Some(paths) = self.within(limit, seed, steps.min(most)) {
                return Some(Answer::Found { paths, bounds });
            }
            let doubt = steps.min(most) / DOUBT_SHARE;
            match self.spend(doubt, |share| exact::prove(instance, objective, None, limit, share)) {
                Answer::GaveUp { .. } => {}
                decided => return Some(decided),
            }
            steps = steps.saturating_mul(TURN_GROWTH);
            seed += 1;
        }
        None
    }

    /// A plan of at most `limit` steps, if one is found.
    fn within(&mut self, limit: Option<u64>, seed: u64, steps: u64) -> Option<Paths> {
        let instance = self.instance;
        let step_limit = limit.map(|limit| u32::try_from(limit).unwrap_or(u32::MAX));
        self.searched(steps, |share| fast::first(instance, fast::Terms { seed, step_limit }, share))
    }

    /// The best plan that the budget allows from a first one on.
    fn better(mut self, first: Paths) -> Answer {
        let mut best = first;
        let end = self.meter.left().steps - self.meter.left().steps / IMPROVE_SHARE;
        let more = STEPS_PER_MOVE * self.bounds.sum_of_costs;
        let mut seed = 1;
        while !self.is_met(&best) && self.meter.left().steps > end {
            let before = Costs::of(&best).makespan;
            best = self.round(best, seed, ROUND_STEPS + more);
            if self.objective == Objective::Makespan
                && Costs::of(&best).makespan == before
                && before > self.bounds.makespan
            {
                let steps = (SQUEEZE_STEPS + more).min(self.meter.left().steps.saturating_sub(end));
                best = self.within(Some(before - 1), seed, steps).unwrap_or(best);
            }
            seed += 1;
        }
        if self.is_met(&best) {
            let paths = self.ties(best, seed);
            return Answer::Found { paths, bounds: self.bounds };
        }
        exact::prove(self.instance, self.objective, Some(&best), self.limit, &mut self.meter)
    }

    /// Betters what is not minimised, in rounds until one of them gains little.
    fn ties(&mut self, mut paths: Paths, mut seed: u64) -> Paths {
        let steps = TIE_STEPS + self.bounds.sum_of_costs;
        let end = self.meter.left().steps - self.meter.left().steps / TIE_SHARE;
        while Costs::of(&paths) != self.bounds && self.meter.left().steps > end {
            let before = Costs::of(&paths);
            paths = self.round(paths, seed, steps.min(self.meter.left().steps - end));
            let after = Costs::of(&paths);
            let total = |costs: Costs| costs.makespan + costs.sum_of_costs;
            if total(before).saturating_sub(total(after)) <= total(before) / TIE_GAIN {
                break;
            }
            seed += 1;
        }
        paths
    }

    /// One round of improvement; a plan that breaks the limit is not taken.
    fn round(&mut self, paths: Paths, seed: u64, steps: u64) -> Paths {
        let (instance, objective) = (self.instance, self.objective);
        let better = self.searched(steps, |share| fast::improve(instance, paths.clone(), objective, seed, share));
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

    /// Runs a search that is one of many: if it took no step it still counts as done, so that there is an end.
    fn searched<T>(&mut self, steps: u64, search: impl FnOnce(&mut Meter) -> T) -> T {
        let before = self.meter.spent();
        let result = self.spend(steps, search);
        if self.meter.spent() == before {
            self.meter.charge(steps.max(1));
        }
        result
    }

    /// Runs a search on so many steps of what is left.
    fn spend<T>(&mut self, steps: u64, search: impl FnOnce(&mut Meter) -> T) -> T {
        let mut part = Meter::new(Budget::of(steps.min(self.meter.left().steps)));
        let result = search(&mut part);
        self.meter.charge(part.spent());
        result
    }
}
