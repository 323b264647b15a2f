//! The default planner: finds a plan quickly, then improves it, then proves it optimal.
//!
//! Problem: one stage; many parts move to their goals at the same time. A single part takes its shortest path
//! ([`alone`]). Method for several parts, in this order (where channels are shared, [`channels`] has another):
//! - In rounds of increasing budget, until one succeeds: [`fast::first`] searches for a plan, except where the parts
//!   are dense; then [`lacam::first`] and, with one part moving at a time, [`joint`]; then [`exact::prove`] looks for a
//!   reason why there is none (small joint spaces, parts that block each other).
//! - A small joint space is searched exhaustively.
//! - Until the objective meets its bound or their share of the budget is spent: [`fast::improve`] in rounds and, where
//!   a round hardly shortens the makespan, [`fast::first`] and [`fast::tighten`] within a limit between the bound and
//!   the best known makespan: with many parts, finding a new plan within a limit is faster than shortening a long one.
//!   Where the bound is not met, the same again from the same first plan for the other objective, and from there back:
//!   a change that helps one may help the other. Once a round hardly helps, pairs of parts are searched for a greater
//!   bound on the makespan ([`exact::raised`]).
//! - [`exact::prove`] with the rest of the budget, which improves plan and bounds until they meet.
//!
//! Guaranteed: the answer is a legal plan with bounds that hold for every plan, a proof that there is none, or neither
//! when the budget is spent. The same instance and budget give the same answer. The secondary figure is improved too,
//! but only while that is quick, and it is not proven optimal where that takes a search. Cost: one step of the budget
//! is one node of one search.

mod alone;
pub mod timing;

use super::board::{
    BoardAnswer, BoardCosts, BoardObjective, BoardPlan, BoardPlanProgress, CellIndex, Instance, NoBoardPlan, Paths,
};
use super::exact::tables::ExactTables;
use super::fast::ImprovementAim;
use super::joint::{self, JointAim};
use super::{channels, exact, fast, lacam};
use crate::plan::search::{Meter, SearchBudget};

/// Budget of the first round, and its least value per step of the bound on the sum of costs: nearly all instances that
/// are not crowded need less.
const TURN_STEPS: u64 = 20_000;
const TURN_STEPS_PER_MOVE: u64 = 2;

/// Growth factor of the rounds.
const TURN_GROWTH: u64 = 4;

/// In each round, the proof of impossibility gets 1/N of the budget of the search for a plan.
const DOUBT_SHARE: u64 = 1;

/// 1/N of the budget is kept from the rounds for the proof that there is no plan.
const HARD_SHARE: u64 = 4;

/// 1/N of the remaining budget for improvement, and for improvement via the other objective.
const IMPROVE_SHARE: u64 = 4;
const OTHER_SHARE: u64 = 8;

/// Makespan limit of the first round, in per cent of the bound; a limit makes the search for each path smaller.
const ROOMY_PERCENT: u64 = 150;

/// Parts are dense if their cells, each with the cells within the separation and overlaps counted repeatedly, exceed
/// this percentage of the free cells. Then a priority order hardly ever works, and none is tried in the first rounds.
const DENSE_PERCENT: u64 = 112;
const DENSE_ROUNDS: u64 = 3;

/// The first plan by a search of configurations may take as many steps as all parts need for this many times the bound
/// on the makespan.
const WALK_BOUNDS: u64 = 16;

/// Parts above which a proof is unlikely.
const CROWD: usize = 36;

/// With more than `CROWD` parts, improvement gets the whole remaining budget except 1/N.
const CROWD_PROOF_SHARE: u64 = 16;

/// With more than `CROWD` parts, a makespan above this percentage of its bound is first brought near the bound by a new
/// plan.
const FAR_PERCENT: u64 = 120;

/// Makespan limit of that new plan, in per cent of the bound.
const NEAR_PERCENT: u64 = 110;

/// The search for that new plan gets at least 1/N of the steps for improvement.
const FAR_SHARE: u64 = 3;

/// A round has stalled if it shortens the makespan by less than 1/N.
const SHORTER: u64 = 50;

/// Budgets of the first round of improvement and of the first search for a plan within a limit; each gets
/// `STEPS_PER_MOVE` more per step of the bound on the sum of costs.
const ROUND_STEPS: u64 = 100_000;
const SQUEEZE_STEPS: u64 = 400_000;
const STEPS_PER_MOVE: u64 = 5;

/// Budget of one round for the secondary figure, besides one step per step of the bound on the sum of costs; all such
/// rounds together get 1/N of the remaining budget.
const TIE_STEPS: u64 = 20_000;
const TIE_SHARE: u64 = 16;

/// A round gains little if it improves by at most 1/N.
const TIE_GAIN: u64 = 500;

/// Solves a stage, within `limit` steps if there is a limit.
pub fn solve(instance: &Instance, objective: BoardObjective, limit: Option<u64>, budget: SearchBudget) -> BoardAnswer {
    solve_metered(instance, objective, limit, &mut Meter::new(budget))
}

/// [`solve`], with the steps of a meter.
pub fn solve_metered(
    instance: &Instance,
    objective: BoardObjective,
    limit: Option<u64>,
    meter: &mut Meter,
) -> BoardAnswer {
    if let Some(channels) = instance.board.channels() {
        return channels::solve(instance, channels, objective, limit, meter);
    }
    if instance.agents.len() == 1 {
        return by_itself(instance, limit);
    }
    let bounds = match fast::bounds(instance) {
        Ok(bounds) => bounds,
        Err(why) => return BoardAnswer::Impossible(why),
    };
    let mut search = PortfolioSearch { instance, objective, limit, bounds, is_raised: false, meter, progress: None };
    match search.first() {
        Some(BoardAnswer::Found(BoardPlan { paths, .. })) => search.better(paths),
        Some(decided) => decided,
        None => exact::prove(instance, objective, None, limit, search.meter),
    }
}

/// The first plan of [`solve`], if it finds one.
pub fn first(instance: &Instance, objective: BoardObjective, budget: SearchBudget) -> Option<Paths> {
    let bounds = fast::bounds(instance).ok()?;
    let meter = &mut Meter::new(budget);
    match (PortfolioSearch { instance, objective, limit: None, bounds, is_raised: false, meter, progress: None })
        .first()?
    {
        BoardAnswer::Found(BoardPlan { paths, .. }) => Some(paths),
        BoardAnswer::Impossible(_) | BoardAnswer::GaveUp(_) => None,
    }
}

/// The plan of a single part, which no moving part can block.
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
    /// Lower bounds; initially those of the parts alone.
    bounds: BoardCosts,
    /// Whether the bound on the makespan was raised by pairs of parts.
    is_raised: bool,
    meter: &'a mut Meter,
    /// Progress display; `None` until there is a plan.
    progress: Option<BoardPlanProgress>,
}

impl PortfolioSearch<'_> {
    /// A first plan, or the proof that there is none; `None` if neither was found within the shares.
    fn first(&mut self) -> Option<BoardAnswer> {
        let (instance, objective, limit, bounds) = (self.instance, self.objective, self.limit, self.bounds);
        let reserve = self.meter.left().steps / HARD_SHARE;
        let (mut steps, mut seed) = (TURN_STEPS.max(TURN_STEPS_PER_MOVE * bounds.sum_of_costs), 1);
        while self.meter.left().steps > reserve {
            let most = self.meter.left().steps - reserve;
            let roomy = (seed == 1).then_some(bounds.makespan * ROOMY_PERCENT / 100);
            let mut plan = None;
            if seed > DENSE_ROUNDS || !self.is_dense() {
                plan = self.within(limit.into_iter().chain(roomy).min(), seed, steps.min(most));
            }
            if plan.is_none() {
                plan = self.crowded(seed, steps.min(most)).and_then(|paths| self.shortened(paths));
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

    /// Whether the parts are so many and so close that a priority order hardly ever works.
    fn is_dense(&self) -> bool {
        let Instance { board, separation, agents, .. } = self.instance;
        let free = (0..board.cells() as CellIndex).filter(|cell| !board.is_blocked(*cell)).count() as u64;
        let around = u64::from(2 * separation + 1).pow(2);
        agents.len() > CROWD && agents.len() as u64 * around * 100 > free * DENSE_PERCENT
    }

    /// A plan of any length for a crowded board: the best of three searches of configurations.
    fn crowded(&mut self, seed: u64, steps: u64) -> Option<Paths> {
        let instance = self.instance;
        let walk = instance.agents.len() as u64 * self.bounds.makespan * WALK_BOUNDS;
        let quick = self.searched(steps.max(walk), |share| lacam::first(instance, seed, share));
        let any = self.searched(steps, |share| in_turns(instance, JointAim::Any, share));
        let fewest =
            any.as_ref().and_then(|_| self.searched(steps, |share| in_turns(instance, JointAim::Moves, share)));
        let plans = quick.into_iter().chain(any).chain(fewest);
        plans.min_by_key(|paths| BoardCosts::of(paths).key(self.objective))
    }

    /// A plan shortened to keep the limit, if one is found.
    fn shortened(&mut self, mut paths: Paths) -> Option<Paths> {
        let Some(limit) = self.limit else { return Some(paths) };
        let end = self.meter.left().steps - self.meter.left().steps / IMPROVE_SHARE;
        let more = STEPS_PER_MOVE * self.bounds.sum_of_costs;
        let (instance, mut seed) = (self.instance, 1);
        while BoardCosts::of(&paths).makespan > limit && self.meter.left().steps > end {
            paths = self.searched(ROUND_STEPS + more, |share| {
                fast::improve(instance, paths.clone(), ImprovementAim::Costs(BoardObjective::Makespan), seed, share)
            });
            seed += 1;
        }
        (BoardCosts::of(&paths).makespan <= limit).then_some(paths)
    }

    /// A plan of at most `limit` steps, if one is found.
    fn within(&mut self, limit: Option<u64>, seed: u64, steps: u64) -> Option<Paths> {
        let instance = self.instance;
        let step_limit = limit.map(|limit| u32::try_from(limit).unwrap_or(u32::MAX));
        let terms = fast::FirstPlanTerms { seed, step_limit, most_conflicts: None };
        self.searched(steps, |share| fast::first(instance, terms, share))
    }

    /// The best plan that the budget allows, starting from a first one.
    fn better(mut self, mut first: Paths) -> BoardAnswer {
        self.progress = Some(BoardPlanProgress::begin(self.objective, BoardCosts::of(&first), self.bounds));
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
        let share =
            if self.instance.agents.len() > CROWD { all - all / CROWD_PROOF_SHARE } else { all / IMPROVE_SHARE };
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
        exact::prove(self.instance, self.objective, Some(&best), self.limit, self.meter)
    }

    /// Improves a plan in rounds until it meets its bound or `steps` steps are spent. Where a round hardly shortens it,
    /// plans within a limit on the makespan are sought instead; each time that fails, both get more steps.
    fn bettered(&mut self, mut best: Paths, steps: u64) -> Paths {
        let end = self.meter.left().steps - steps;
        let more = STEPS_PER_MOVE * self.bounds.sum_of_costs;
        let (mut round_steps, mut squeeze_steps) = (ROUND_STEPS + more, SQUEEZE_STEPS + more);
        let (mut seed, mut failures) = (1, 0);
        while !self.is_met(&best) && self.meter.left().steps > end {
            let before = self.lateness(&best);
            best = self.round(best, seed, round_steps.min(self.meter.left().steps - end));
            let makespan = BoardCosts::of(&best).makespan;
            let lateness = self.lateness(&best);
            let is_stalled = before.saturating_sub(lateness) * SHORTER < before && makespan > self.bounds.makespan;
            let is_crowd = self.instance.agents.len() > CROWD;
            if is_stalled && !is_crowd && !std::mem::replace(&mut self.is_raised, true) {
                self.raise(makespan);
                if self.is_met(&best) {
                    break;
                }
            }
            let left = self.meter.left().steps.saturating_sub(end);
            if self.objective == BoardObjective::Makespan && is_stalled && left > 0 {
                let is_far = makespan * 100 > self.bounds.makespan * FAR_PERCENT;
                let is_new = failures == 0 && is_far && is_crowd;
                let aim = if is_new { SqueezeAim::New } else { SqueezeAim::turn(failures) };
                let most = if is_new { squeeze_steps.max(steps / FAR_SHARE) } else { squeeze_steps };
                match self.squeezed(&best, aim, seed, most.min(left)) {
                    Some(shorter) => (best, failures) = (shorter, 0),
                    None => {
                        failures += 1;
                        round_steps += round_steps / 2;
                        squeeze_steps += squeeze_steps / 2;
                    }
                }
            }
            if let Some(progress) = &mut self.progress {
                progress.offer(BoardCosts::of(&best), self.bounds);
            }
            seed += 1;
        }
        best
    }

    /// Raises the bound on the makespan, at most to that of a known plan.
    fn raise(&mut self, most: u64) {
        let (instance, known) = (self.instance, self.bounds.makespan);
        let share = self.meter.left().steps / exact::RAISE_SHARE;
        self.bounds.makespan = self.meter.share(share, |meter| exact::raised(instance, known, most, meter));
    }

    /// Measure that a round is to reduce: the makespan or, for a crowd, in which many parts are late, the steps after
    /// the makespan's bound, summed over all parts.
    fn lateness(&self, paths: &Paths) -> u64 {
        if self.instance.agents.len() <= CROWD {
            return BoardCosts::of(paths).makespan;
        }
        paths.iter().map(|path| (path.len() as u64 - 1).saturating_sub(self.bounds.makespan)).sum()
    }

    /// A plan nearer to the bound on the makespan, if one is found.
    fn squeezed(&mut self, best: &Paths, aim: SqueezeAim, seed: u64, steps: u64) -> Option<Paths> {
        let (bound, makespan) = (self.bounds.makespan, BoardCosts::of(best).makespan);
        let limit = match aim {
            SqueezeAim::New => bound * NEAR_PERCENT / 100,
            SqueezeAim::HalfNew | SqueezeAim::HalfTightened => (bound + makespan) / 2,
            SqueezeAim::OneLessNew | SqueezeAim::OneLessTightened => makespan - 1,
        };
        let instance = self.instance;
        let terms = fast::FirstPlanTerms {
            seed,
            step_limit: Some(u32::try_from(limit.min(makespan - 1)).unwrap_or(u32::MAX)),
            most_conflicts: Some(instance.agents.len()),
        };
        self.searched(steps, |share| match aim {
            SqueezeAim::New | SqueezeAim::HalfNew | SqueezeAim::OneLessNew => fast::first(instance, terms, share),
            SqueezeAim::HalfTightened | SqueezeAim::OneLessTightened => fast::tighten(instance, best, terms, share),
        })
    }

    /// Improves the secondary figure, in rounds until one of them gains little.
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

    /// One round of improvement; a plan that breaks the limit is discarded.
    fn round(&mut self, paths: Paths, seed: u64, steps: u64) -> Paths {
        let (instance, objective) = (self.instance, self.objective);
        let aim = match objective {
            BoardObjective::Makespan if instance.agents.len() > CROWD => ImprovementAim::LateArrivals,
            BoardObjective::Makespan | BoardObjective::SumOfCosts => ImprovementAim::Costs(objective),
        };
        let better = self.searched(steps, |share| fast::improve(instance, paths.clone(), aim, seed, share));
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

    /// Runs one of many searches. If it took no step, its whole share is charged, so that the loop terminates.
    fn searched<T>(&mut self, steps: u64, search: impl FnOnce(&mut Meter) -> T) -> T {
        let before = self.meter.spent();
        let result = self.meter.share(steps, search);
        if self.meter.spent() == before {
            self.meter.charge(steps.max(1));
        }
        result
    }
}

/// Limit on the makespan of a shorter plan, and whether that plan is new or derived from the best one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SqueezeAim {
    /// Near the bound.
    New,
    /// Halfway between the best plan and the bound.
    HalfNew,
    HalfTightened,
    /// One step less than the best plan.
    OneLessNew,
    OneLessTightened,
}

impl SqueezeAim {
    /// The aim after a number of failures.
    fn turn(failures: usize) -> SqueezeAim {
        const TURNS: [SqueezeAim; 4] =
            [SqueezeAim::HalfNew, SqueezeAim::OneLessNew, SqueezeAim::HalfTightened, SqueezeAim::OneLessTightened];
        TURNS[failures % TURNS.len()]
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
    let tables = ExactTables::new(instance).ok()?;
    let everyone: Vec<usize> = (0..instance.agents.len()).collect();
    match joint::search(&tables, &everyone, aim, meter) {
        joint::JointAnswer::Found(paths) => Some(timing::earliest(instance, &paths)),
        joint::JointAnswer::Impossible(_) | joint::JointAnswer::GaveUp(_) => None,
    }
}

/// A plan of fewest moves for a group that is not too large, if the meter suffices.
pub fn fewest_moves(instance: &Instance, meter: &mut Meter) -> Option<Paths> {
    // With shared channels, the moves of one step cannot always be made one after the other.
    instance.board.channels().is_none().then_some(())?;
    in_turns(instance, JointAim::Moves, meter)
}
