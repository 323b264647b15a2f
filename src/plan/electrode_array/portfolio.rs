//! The default planner: a plan fast, then better ones, then the proof.
//!
//! Problem: one stage, many parts to their goals at the same time. Method: [`fast::first`] within a part of the budget,
//! [`fast::improve`] within another, and [`exact::prove`] with what is left, which betters plan and bounds until they meet.
//! Guaranteed: the answer is a legal plan with bounds that hold for every plan, a proof that there is none, or neither when the
//! budget is spent. Same instance and budget, same answer. Cost: one step of the budget is one node of one search.

use super::board::{Answer, Costs, Instance, Objective};
use super::{exact, fast};
use crate::plan::search::{Budget, Meter};

/// The part of the budget for a first plan.
const FIRST_SHARE: u64 = 2;

/// The part of what is left then for better ones.
const IMPROVE_SHARE: u64 = 4;

/// Decides between plans that are as good.
const SEED: u64 = 1;

/// A plan for a stage of at most `limit` steps.
pub fn solve(instance: &Instance, objective: Objective, limit: Option<u64>, budget: Budget) -> Answer {
    let bounds = match fast::bounds(instance) {
        Ok(bounds) => bounds,
        Err(why) => return Answer::Impossible(why),
    };
    let mut meter = Meter::new(budget);
    let step_limit = limit.map(|limit| u32::try_from(limit).unwrap_or(u32::MAX));
    let terms = fast::Terms { seed: SEED, step_limit };
    let first = spend(&mut meter, FIRST_SHARE, |share| fast::first(instance, terms, share));
    let known = first.map(|paths| {
        if meets(Costs::of(&paths), bounds) {
            return paths;
        }
        let better =
            spend(&mut meter, IMPROVE_SHARE, |share| fast::improve(instance, paths.clone(), objective, SEED, share));
        let keeps = limit.is_none_or(|limit| Costs::of(&better).makespan <= limit);
        if keeps { better } else { paths }
    });
    if let Some(paths) = &known
        && meets(Costs::of(paths), bounds)
    {
        return Answer::Found { bounds, paths: paths.clone() };
    }
    exact::prove(instance, objective, known.as_ref(), limit, &mut meter)
}

/// Whether both costs are as low as can be.
fn meets(costs: Costs, bounds: Costs) -> bool {
    costs.makespan <= bounds.makespan && costs.sum_of_costs <= bounds.sum_of_costs
}

/// Runs a search on a part of what is left.
fn spend<T>(meter: &mut Meter, share: u64, search: impl FnOnce(&mut Meter) -> T) -> T {
    let mut part = Meter::new(Budget::of(meter.left().steps / share));
    let result = search(&mut part);
    meter.charge(part.spent());
    result
}
