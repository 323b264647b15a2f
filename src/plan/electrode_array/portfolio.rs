//! The default planner: a plan fast, then better ones, then the proof.
//!
//! Problem: one stage, many parts to their goals at the same time. A part by itself has its shortest way ([`alone`]). Method for
//! several, in this order:
//! - By turns, each longer than the one before, [`fast::first`] looks for a plan, then [`lacam::first`] and, one part moving at a
//!   time, [`joint`]; then [`exact::prove`] for a reason why there is none (small joint spaces, parts that block each other)
//!   until one of them has found something. Where that is a plan of many parts by configurations, [`fast::first`] gets a longer turn.
//! - A small joint space is searched as a whole.
//! - Until the objective meets its bound or their share of the budget is spent: [`fast::improve`] in rounds and, where a round leaves
//!   the makespan as it was, [`fast::first`] within one step less. Where the bound is not met, the same again from the same first plan
//!   for the other objective, and from there back: what serves one may serve the other.
//! - [`exact::prove`] with what is left, which betters plan and bounds until they meet.
//!
//! Guaranteed: the answer is a legal plan with bounds that hold for every plan, a proof that there is none, or neither when the
//! budget is spent. Same instance and budget, same answer. What is not minimised is bettered too, but only while that goes quickly,
//! and not proven where that takes a search. Cost: one step of the budget is one node of one search.

use super::board::{BoardAnswer, BoardCosts, BoardObjective, BoardPlan, Instance, NoBoardPlan, Paths};
use super::exact::field::ExactTables;
use super::joint::{self, JointAim};
use super::{alone, exact, fast, lacam, timing};
use crate::plan::search::{Meter, SearchBudget};

/// Steps of the first turn: nearly all instances that are not crowded need fewer.
const TURN_STEPS: u64 = 20_000;

/// How many times longer each turn is than the one before.
const TURN_GROWTH: u64 = 4;

/// In a turn, the look at what may be impossible gets this part of the steps of the look for a plan.
const DOUBT_SHARE: u64 = 1;

/// The part of the budget that the turns leave for the proof that there is no plan.
const HARD_SHARE: u64 = 4;

/// The part of what is left for better plans, and that for better plans from one that serves the other objective.
const IMPROVE_SHARE: u64 = 4;
const OTHER_SHARE: u64 = 8;

/// The part of what is left for repaired paths where a search of configurations has found a plan of many parts first.
const REPAIR_SHARE: u64 = 4;

/// With more parts a proof is hardly to be had, and better plans get all but one of the shares.
const CROWD: usize = 50;

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
pub fn solve(instance: &Instance, objective: BoardObjective, limit: Option<u64>, budget: SearchBudget) -> BoardAnswer {
    if instance.agents.len() == 1 {
        return by_itself(instance, limit);
    }
    let bounds = match fast::bounds(instance) {
        Ok(bounds) => bounds,
        Err(why) => return BoardAnswer::Impossible(why),
    };
    let mut search =
        PortfolioSearch { instance, objective, limit, bounds, is_crowded: false, meter: Meter::new(budget) };
    match search.first() {
        Some(BoardAnswer::Found(BoardPlan { paths, .. })) => search.better(paths),
        Some(decided) => decided,
        None => exact::prove(instance, objective, None, limit, &mut search.meter),
    }
}

/// The plan of a part that nothing that moves can be in the way of.
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
    /// Those of the parts each by itself.
    bounds: BoardCosts,
    /// Many parts, of which short searches found no plan: they are not asked for a plan with a step less either.
    is_crowded: bool,
    meter: Meter,
}

impl PortfolioSearch<'_> {
    /// A first plan, or the proof that there is none; `None` if neither was found within its shares.
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

    /// A plan of any length for a crowded board: the best one of three searches of configurations.
    fn crowded(&mut self, seed: u64, steps: u64) -> Option<Paths> {
        let instance = self.instance;
        let quick = self.searched(steps, |share| lacam::first(instance, seed, share));
        let any = self.searched(steps, |share| in_turns(instance, JointAim::Any, share));
        let fewest =
            any.as_ref().and_then(|_| self.searched(steps, |share| in_turns(instance, JointAim::Moves, share)));
        let plans = quick.into_iter().chain(any).chain(fewest);
        plans.min_by_key(|paths| BoardCosts::of(paths).key(self.objective))
    }

    /// A plan of a crowded board, or a better one that repair finds with more time: configurations are searched one step at a time, and
    /// with many agents their plans are about twice as long as those of paths that are repaired, and are hardly bettered afterwards.
    fn or_repaired(&mut self, paths: Paths, seed: u64) -> Paths {
        if self.instance.agents.len() <= CROWD {
            return paths;
        }
        self.is_crowded = true;
        let repaired = self.within(self.limit, seed, self.meter.left().steps / REPAIR_SHARE);
        let key = |paths: &Paths| BoardCosts::of(paths).key(self.objective);
        repaired.filter(|repaired| key(repaired) < key(&paths)).unwrap_or(paths)
    }

    /// A plan made to keep the limit, if that is found.
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

    /// The best plan that the budget allows from a first one on.
    fn better(mut self, mut first: Paths) -> BoardAnswer {
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

    /// A plan improved in rounds until it meets its bound or so many steps are spent.
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
            seed += 1;
        }
        best
    }

    /// Betters what is not minimised, in rounds until one of them gains little.
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

    /// Whether the objective is as low as can be.
    fn is_met(&self, paths: &Paths) -> bool {
        let costs = BoardCosts::of(paths);
        match self.objective {
            BoardObjective::Makespan => costs.makespan <= self.bounds.makespan,
            BoardObjective::SumOfCosts => costs.sum_of_costs <= self.bounds.sum_of_costs,
        }
    }

    /// Runs a search that is one of many: if it took no step it still counts as done, so that there is an end.
    fn searched<T>(&mut self, steps: u64, search: impl FnOnce(&mut Meter) -> T) -> T {
        let before = self.meter.spent();
        let result = self.meter.share(steps, search);
        if self.meter.spent() == before {
            self.meter.charge(steps.max(1));
        }
        result
    }
}

/// The objective that is not this one.
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

/// The plan of fewest moves of a group that is not too large, if the meter lasts.
pub fn fewest_moves(instance: &Instance, meter: &mut Meter) -> Option<Paths> {
    in_turns(instance, JointAim::Moves, meter)
}
