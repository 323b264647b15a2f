//! Finds plans of many agents fast and improves them. It proves nothing but simple bounds.
//!
//! Problem: agents on a grid that all move at the same time, each through its stops to its goal, with separation kept
//! ([`super::board`]). Method: prioritised planning with safe intervals (Phillips and Likhachev, ICRA 2011); where no
//! order works, repair of conflicting paths (MAPF-LNS2: Li and others, AAAI 2022); then large-neighbourhood search
//! (MAPF-LNS: Li and others, IJCAI 2021).
//!
//! Guaranteed: every plan is legal; [`improve`] never returns a worse one; [`bounds`] are lower bounds on every plan;
//! the same input, seed and budget give the same plan. Not guaranteed: that a plan is found where there is one, or an
//! optimum. Where there is no plan the search ends with its meter.
//!
//! Cost: one step of the meter is one expanded node of the search of one agent, one round of repair or improvement, or
//! 32 cells of a distance table; the last search or table may overdraw it by the latter. Memory grows with the cells
//! (36 bytes each), with the moves of all paths times the separation (24 bytes each times two), and with at most 128 MB
//! of tables.

mod distances;
mod planned_instance;
mod polish;
mod prioritise;
mod repair;
mod reservations;
mod sipp;
mod weights;

use super::board::{BoardCosts, BoardObjective, CellIndex, Instance, NoBoardPlan, Paths};
use crate::plan::search::{Meter, SearchBudget};
pub(super) use distances::{DistanceField, Distances, UNREACHABLE};
use planned_instance::PlannedInstance;
use prioritise::PrioritisedOutcome;

/// Boards with more cells are not planned.
pub const MAX_CELLS: usize = 1 << 21;

/// Conditions on a first plan besides the instance.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FirstPlanTerms {
    /// Random seed; any number.
    pub seed: u64,
    /// Latest arrival of an agent.
    pub step_limit: Option<u32>,
    /// Most pairs of agents whose paths may conflict when repair begins; with more, repair rarely succeeds.
    pub most_conflicts: Option<usize>,
}

impl FirstPlanTerms {
    fn most_pairs(self) -> usize {
        self.most_conflicts.unwrap_or(usize::MAX)
    }
}

/// What [`improve`] reduces first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ImprovementAim {
    /// The figure of an objective.
    Costs(BoardObjective),
    /// The makespan of a crowd in which many agents arrive after its bound: the sum of the squares of the time by which
    /// they do. It shows progress where the last arrival stays as it is, and still weighs the last ones most.
    LateArrivals,
}

impl ImprovementAim {
    /// The objective that the plan serves in the end.
    fn final_objective(self) -> BoardObjective {
        match self {
            ImprovementAim::Costs(objective) => objective,
            ImprovementAim::LateArrivals => BoardObjective::Makespan,
        }
    }
}

/// Lower bounds: the makespan and the sum of costs of agents that ignore one another. An error if an agent alone cannot
/// reach a stop. Costs a breadth-first search per stop, or nothing where the free cells form a rectangle.
pub fn bounds(instance: &Instance) -> Result<BoardCosts, NoBoardPlan> {
    let mut unlimited = Meter::new(SearchBudget::of(u64::MAX));
    let mut distances = distances::Distances::of(&instance.board);
    let least = planned_instance::individual(instance, &mut distances, &mut unlimited)?;
    Ok(total(&least))
}

/// A first plan, unless the meter runs out, an agent is enclosed, or the board has more than [`MAX_CELLS`].
pub fn first(instance: &Instance, terms: FirstPlanTerms, meter: &mut Meter) -> Option<Paths> {
    let mut planned = begin(instance, terms, meter)?;
    match prioritise::prioritise(&mut planned, meter) {
        PrioritisedOutcome::Plan(paths) => Some(paths),
        PrioritisedOutcome::Part(part) => repair::repair(&mut planned, part, terms.most_pairs(), meter),
    }
}

/// A plan within a step limit, made from a longer legal plan: paths that arrive too late are replanned and repaired.
/// Returns `None` in the same cases as [`first`].
pub fn tighten(instance: &Instance, paths: &Paths, terms: FirstPlanTerms, meter: &mut Meter) -> Option<Paths> {
    let mut planned = begin(instance, terms, meter)?;
    let limit = u64::from(planned.step_limit);
    let arrives = |path: &&Vec<CellIndex>| path.len() as u64 - 1 <= limit;
    let part = paths.iter().map(|path| Some(path).filter(arrives).cloned()).collect();
    repair::repair(&mut planned, part, terms.most_pairs(), meter)
}

/// State for a first plan; `None` where the board is too large or the limit is below the bound.
fn begin<'a>(instance: &'a Instance, terms: FirstPlanTerms, meter: &mut Meter) -> Option<PlannedInstance<'a>> {
    if instance.board.cells() > MAX_CELLS {
        return None;
    }
    let mut planned = PlannedInstance::new(instance, terms.seed, meter).ok()?;
    planned.step_limit = terms.step_limit.unwrap_or(planned.step_limit);
    (u64::from(planned.step_limit) >= total(&planned.least).makespan).then_some(planned)
}

/// The best plan found, starting from a legal one, which is returned if none is better under the objective. Ends early
/// if both bounds are met.
pub fn improve(instance: &Instance, paths: Paths, aim: ImprovementAim, seed: u64, meter: &mut Meter) -> Paths {
    if instance.board.cells() > MAX_CELLS {
        return paths;
    }
    let Ok(mut planned) = PlannedInstance::new(instance, seed, meter) else { return paths };
    let bounds = total(&planned.least);
    polish::polish(&mut planned, paths, aim, bounds, meter)
}

fn total(least: &[u32]) -> BoardCosts {
    BoardCosts {
        makespan: least.iter().copied().max().unwrap_or(0).into(),
        sum_of_costs: least.iter().copied().map(u64::from).sum(),
    }
}

#[cfg(test)]
mod tests;
