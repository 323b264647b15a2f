//! The default planner: a plan quickly, then better ones, then the proof.
//!
//! Problem: one stage, many parts to their goals at the same time. A single part takes its shortest path ([`alone`]). Method for
//! several, in this order:
//! - In rounds of increasing length, [`fast::first`] searches for a plan, then [`lacam::first`] and, one part moving at a time,
//!   [`joint`]; then [`exact::prove`] for a reason why there is none (small joint spaces, parts that block each other), until one
//!   of them succeeds. Where that is a plan of many parts from a search of configurations, [`fast::first`] gets a longer turn.
//! - A small joint space is searched exhaustively.
//! - Until the objective meets its bound or their share of the budget is spent: [`fast::improve`] in rounds and, where a round
//!   leaves the makespan unchanged, [`fast::first`] within one step less. Where the bound is not met, the same again from the same
//!   first plan for the other objective, and from there back: a change that helps one may help the other.
//! - [`exact::prove`] with the rest of the budget, which improves plan and bounds until they meet.
//!
//! Guaranteed: the answer is a legal plan with bounds that hold for every plan, a proof that there is none, or neither when the
//! budget is spent. Same instance and budget, same answer. The figure that is not minimised is improved too, but only while that is
//! quick, and it is not proven optimal where that takes a search. Cost: one step of the budget is one node of one search.

use super::board::{BoardAnswer, BoardCosts, BoardObjective, BoardPlan, HeldBoardPlan, Instance, NoBoardPlan, Paths};
use super::exact::field::ExactTables;
use super::joint::{self, JointAim};
use super::{alone, exact, fast, lacam, timing};
use crate::plan::search::{Meter, SearchBudget};

/// Steps of the first round: nearly all instances that are not crowded need fewer.
const TURN_STEPS: u64 = 20_000;

/// Growth factor of the rounds.
const TURN_GROWTH: u64 = 4;

/// In each round, the search for a proof of impossibility gets one part in this many of the steps of the search for a plan.
const DOUBT_SHARE: u64 = 1;

/// One part in this many of the budget is reserved from the rounds for the proof that there is no plan.
const HARD_SHARE: u64 = 4;

/// One part in this many of the remaining budget goes to better plans, and one to better plans via the other objective.
const IMPROVE_SHARE: u64 = 4;
const OTHER_SHARE: u64 = 8;

/// One part in this many of the remaining budget goes to repaired paths where a search of configurations found a plan of many parts
/// first.
const REPAIR_SHARE: u64 = 4;

/// With more parts a proof is unlikely, so better plans get the whole remaining budget except one such part.
const CROWD: usize = 50;

/// Steps of one round of improvement, and of one search for a plan with a step less; each plus this many for each step of the
/// parts.
const ROUND_STEPS: u64 = 100_000;
const SQUEEZE_STEPS: u64 = 400_000;
const STEPS_PER_MOVE: u64 = 5;

/// Steps of one round for the figure that is not minimised, besides one for each step of the parts; all such rounds together get
/// one part in this many of the remaining budget.
const TIE_STEPS: u64 = 20_000;
const TIE_SHARE: u64 = 16;

/// A round gains little if it improves by less than one part in this many.
const TIE_GAIN: u64 = 500;

/// Solves a stage, within `limit` steps if there is a limit.
pub fn solve(instance: &Instance, objective: BoardObjective, limit: Option<u64>, budget: SearchBudget) -> BoardAnswer {
    if instance.agents.len() == 1 {
        return by_itself(instance, limit);
    }
    let bounds = match fast::bounds(instance) {
        Ok(bounds) => bounds,
        Err(why) => return BoardAnswer::Impossible(why),
    };
    let mut search = PortfolioSearch {
        instance,
        objective,
        limit,
        bounds,
        is_crowded: false,
        meter: Meter::new(budget),
        held: None,
    };
    match search.first() {
        Some(BoardAnswer::Found(BoardPlan { paths, .. })) => search.better(paths),
        Some(decided) => decided,
        None => exact::prove(instance, objective, None, limit, &mut search.meter),
    }
}

/// The plan of a single part, which nothing that moves can block.
fn by_itself(instance: &Instance, limit: Option<u64>) -> BoardAnswer {
    match alone::way(instance) {
        Err(why) => BoardAnswer::Impossible(why),
        Ok(way) => {
            let paths = vec![way];
            let bounds = BoardCosts::of(&paths);
            match limit {
                Some(limit) if bounds.makespan > limit => {
                    BoardAnswer::Impossible(NoBoardPlan::TooFewSteps { least: bounds.makespan })
                }
                Some(_) | None => BoardAnswer::Found(BoardPlan { paths, bounds }),
            }
        }
    }
}

struct PortfolioSearch<'a> {
    instance: &'a Instance,
    objective: BoardObjective,
    limit: Option<u64>,
    /// Lower bounds from the parts alone.
    bounds: BoardCosts,
    /// Many parts, for which short searches found no plan: plans with one step less are not sought either.
    is_crowded: bool,
    meter: Meter,
    /// Once there is a plan.
    held: Option<HeldBoardPlan>,
}

impl PortfolioSearch<'_> {
    /// A first plan, or the proof that there is none; `None` if neither was found within the shares.
    fn first(&mut self) -> Option<BoardAnswer> {
        let (instance, objective, limit, bounds) = (self.instance, self.objective, self.limit, self.bounds);
        let reserve = self.meter.left().steps / HARD_SHARE;
        let (mut steps, mut seed) = (TURN_STEPS, 1);
        while self.meter.left().steps > reserve {
            let most = self.meter.left().steps - reserve;
            let mut plan = self.within(limit, seed, steps.min(most));
            if plan.is_none() {
                let crowded = self.crowded(seed, steps.min(most)).and_then(|paths| self.shortened(paths));
                plan = crowded.map(|paths| self.or_repaired(paths, seed));
            }
            if let Some(paths) = plan {
                return Some(BoardAnswer::Found(BoardPlan { paths, bounds }));
            }
            let doubt = steps.min(most) / DOUBT_SHARE;
            match self.meter.share(doubt, |share| exact::prove(instance, objective, None, limit, share)) {
                BoardAnswer::GaveUp(_) => {}
                decided => return Some(decided),
            }
            steps = steps.saturating_mul(TURN_GROWTH);
            seed += 1;
        }
        None
    }

    /// A plan of any length for a crowded board: the best of three searches of configurations.
    fn crowded(&mut self, seed: u64, steps: u64) -> Option<Paths> {
        let instance = self.instance;
        let quick = self.searched(steps, |share| lacam::first(instance, seed, share));
        let any = self.searched(steps, |share| in_turns(instance, JointAim::Any, share));
        let fewest =
            any.as_ref().and_then(|_| self.searched(steps, |share| in_turns(instance, JointAim::Moves, share)));
        let plans = quick.into_iter().chain(any).chain(fewest);
        plans.min_by_key(|paths| BoardCosts::of(paths).key(self.objective))
    }

    /// A plan of a crowded board, or a better one by longer repair: configurations are searched one step at a time, and with many
    /// agents their plans are about twice as long as those of repaired paths, and hardly improve afterwards.
    fn or_repaired(&mut self, paths: Paths, seed: u64) -> Paths {
        if self.instance.agents.len() <= CROWD {
            return paths;
        }
        self.is_crowded = true;
        let repaired = self.within(self.limit, seed, self.meter.left().steps / REPAIR_SHARE);
        let key = |paths: &Paths| BoardCosts::of(paths).key(self.objective);
        repaired.filter(|repaired| key(repaired) < key(&paths)).unwrap_or(paths)
    }

    /// A plan shortened to keep the limit, if one is found.
    fn shortened(&mut self, mut paths: Paths) -> Option<Paths> {
        let Some(limit) = self.limit else { return Some(paths) };
        let end = self.meter.left().steps - self.meter.left().steps / IMPROVE_SHARE;
        let more = STEPS_PER_MOVE * self.bounds.sum_of_costs;
        let (instance, mut seed) = (self.instance, 1);
        while BoardCosts::of(&paths).makespan > limit && self.meter.left().steps > end {
            paths = self.searched(ROUND_STEPS + more, |share| {
                fast::improve(instance, paths.clone(), BoardObjective::Makespan, seed, share)
            });
            seed += 1;
        }
        (BoardCosts::of(&paths).makespan <= limit).then_some(paths)
    }

    /// A plan of at most `limit` steps, if one is found.
    fn within(&mut self, limit: Option<u64>, seed: u64, steps: u64) -> Option<Paths> {
        let instance = self.instance;
        let step_limit = limit.map(|limit| u32::try_from(limit).unwrap_or(u32::MAX));
        self.searched(steps, |share| fast::first(instance, fast::FirstPlanTerms { seed, step_limit }, share))
    }

    /// The best plan that the budget allows, starting from a first one.
    fn better(mut self, mut first: Paths) -> BoardAnswer {
        self.held = Some(HeldBoardPlan::begin(self.objective, BoardCosts::of(&first), self.bounds));
        if !self.is_met(&first) {
            let (instance, objective, limit) = (self.instance, self.objective, self.limit);
            let share = self.meter.left().steps - self.meter.left().steps / IMPROVE_SHARE;
            let looked = self.meter.share(share, |meter| exact::small(instance, objective, &first, limit, meter));
            match looked {
                Some((answer, true)) => return answer,
                Some((BoardAnswer::Found(BoardPlan { paths, bounds }), false)) => {
                    (first, self.bounds) = (paths, bounds)
                }
                Some((BoardAnswer::Impossible(_) | BoardAnswer::GaveUp(_), false)) | None => {}
            }
        }
        let all = self.meter.left().steps;
        let share = if self.instance.agents.len() > CROWD { all - all / IMPROVE_SHARE } else { all / IMPROVE_SHARE };
        let mut best = self.bettered(first.clone(), share);
        if !self.is_met(&best) {
            let objective = self.objective;
            self.objective = other(objective);
            let otherwise = self.bettered(first, self.meter.left().steps / OTHER_SHARE);
            self.objective = objective;
            let otherwise = self.bettered(otherwise, self.meter.left().steps / OTHER_SHARE);
            let key = |paths: &Paths| BoardCosts::of(paths).key(objective);
            best = if key(&otherwise) < key(&best) { otherwise } else { best };
        }
        if self.is_met(&best) {
            let paths = self.ties(best, 1);
            return BoardAnswer::Found(BoardPlan { paths, bounds: self.bounds });
        }
        exact::prove(self.instance, self.objective, Some(&best), self.limit, &mut self.meter)
    }

    /// A plan improved in rounds until it meets its bound or `steps` steps are spent.
    fn bettered(&mut self, mut best: Paths, steps: u64) -> Paths {
        let end = self.meter.left().steps - steps;
        let more = STEPS_PER_MOVE * self.bounds.sum_of_costs;
        let mut seed = 1;
        while !self.is_met(&best) && self.meter.left().steps > end {
            let before = BoardCosts::of(&best).makespan;
            best = self.round(best, seed, ROUND_STEPS + more);
            if self.objective == BoardObjective::Makespan
                && !self.is_crowded
                && BoardCosts::of(&best).makespan == before
                && before > self.bounds.makespan
            {
                let steps = (SQUEEZE_STEPS + more).min(self.meter.left().steps.saturating_sub(end));
                best = self.within(Some(before - 1), seed, steps).unwrap_or(best);
            }
            if let Some(held) = &mut self.held {
                held.offer(BoardCosts::of(&best), self.bounds);
            }
            seed += 1;
        }
        best
    }

    /// Improves the figure that is not minimised, in rounds until one of them gains little.
    fn ties(&mut self, mut paths: Paths, mut seed: u64) -> Paths {
        let steps = TIE_STEPS + self.bounds.sum_of_costs;
        let end = self.meter.left().steps - self.meter.left().steps / TIE_SHARE;
        while BoardCosts::of(&paths) != self.bounds && self.meter.left().steps > end {
            let before = BoardCosts::of(&paths);
            paths = self.round(paths, seed, steps.min(self.meter.left().steps - end));
            let after = BoardCosts::of(&paths);
            let total = |costs: BoardCosts| costs.makespan + costs.sum_of_costs;
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
        let keeps = self.limit.is_none_or(|limit| BoardCosts::of(&better).makespan <= limit);
        if keeps { better } else { paths }
    }

    /// Whether the objective meets its lower bound.
    fn is_met(&self, paths: &Paths) -> bool {
        let costs = BoardCosts::of(paths);
        match self.objective {
            BoardObjective::Makespan => costs.makespan <= self.bounds.makespan,
            BoardObjective::SumOfCosts => costs.sum_of_costs <= self.bounds.sum_of_costs,
        }
    }

    /// Runs one of many searches; one that took no step is charged one, so that the loop terminates.
    fn searched<T>(&mut self, steps: u64, search: impl FnOnce(&mut Meter) -> T) -> T {
        let before = self.meter.spent();
        let result = self.meter.share(steps, search);
        if self.meter.spent() == before {
            self.meter.charge(steps.max(1));
        }
        result
    }
}

/// The other objective.
fn other(objective: BoardObjective) -> BoardObjective {
    match objective {
        BoardObjective::Makespan => BoardObjective::SumOfCosts,
        BoardObjective::SumOfCosts => BoardObjective::Makespan,
    }
}

/// A plan found by moving one part at a time.
fn in_turns(instance: &Instance, aim: JointAim, meter: &mut Meter) -> Option<Paths> {
    let field = ExactTables::new(instance).ok()?;
    let everyone: Vec<usize> = (0..instance.agents.len()).collect();
    match joint::search(&field, &everyone, aim, meter) {
        joint::JointAnswer::Found(paths) => Some(timing::earliest(instance, &paths)),
        joint::JointAnswer::Impossible(_) | joint::JointAnswer::GaveUp(_) => None,
    }
}

/// A plan of fewest moves for a group that is not too large, if the meter suffices.
pub fn fewest_moves(instance: &Instance, meter: &mut Meter) -> Option<Paths> {
    in_turns(instance, JointAim::Moves, meter)
}
