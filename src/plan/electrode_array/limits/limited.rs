//! Plans of a task whose best plan breaks a limit: the candidate plans of every step, and the best combination of one
//! per step.
//!
//! Problem: limits on the steps, sum of costs and moves of a whole task. After each step every part is on a cell that
//! the program names, so the steps are independent, and the figures of a task are the sums of theirs. Method: for each
//! step, candidate plans that are not dominated: on small boards all of them ([`labels`]); elsewhere the least sum of
//! costs for decreasing limits on the steps (the ε-constraint method: Haimes, Lasdon, Wismer, IEEE Transactions on
//! Systems, Man and Cybernetics 1, 1971) and, where moves are limited, the plan of fewest moves. Then one plan per step
//! is chosen so that the limits are kept and the objective is least.
//!
//! Guaranteed: plans keep all limits. Where the answer is proven, no other plan of the task is better, or none keeps
//! the limits. Cost: each step gets its budget once more.

use super::labels::{self, BoardFigures, PlanLimits};
use crate::plan::electrode_array::board::{
    BoardAnswer, BoardCosts, BoardObjective, BoardPlan, CellIndex, Instance, NoBoardPlan, Paths, position,
};
use crate::plan::electrode_array::channels::broadcast::SharedChannels;
use crate::plan::electrode_array::portfolio;
use crate::plan::search::{Meter, SearchBudget};

/// No limit.
pub const UNLIMITED: u64 = u64::MAX;

/// 1/N of a step's budget for the search for its whole Pareto front.
const LABELS_SHARE: u64 = 4;

/// 1/N of the remaining budget for each of the other searches.
const SEARCH_SHARE: u64 = 2;

/// Most partial combinations, of plans of the first steps, that are kept.
const MOST_CHOICES: usize = 4096;

/// The candidate plans of one step.
pub struct PlanFront {
    choices: Vec<(Paths, BoardFigures)>,
    /// Lower bounds on the figures of the step.
    pub bounds: BoardFigures,
    /// Whether each plan within the upper limits has at least as much of every figure as one of the choices. Assumes
    /// that no figure must reach a least value.
    is_whole: bool,
    /// Whether the same holds where a figure must reach a least value.
    reaches: bool,
    /// Where channels are shared: the channels, which decide whether parts can rest together, and the cells of the
    /// parts that stay.
    shared: Option<(SharedChannels, Vec<CellIndex>)>,
}

/// Limits on a step within its task.
#[derive(Debug, Clone, Copy)]
pub struct AskedStep {
    pub objective: BoardObjective,
    /// The limits of the task, minus the bounds of the other steps.
    pub limits: PlanLimits,
    /// Whether no other step moves parts, so that one plan is enough.
    pub is_only: bool,
    pub expansions: u64,
}

/// Steps, sum of costs and moves of a plan.
pub fn figures(paths: &Paths) -> BoardFigures {
    let costs = BoardCosts::of(paths);
    let moves = |path: &Vec<u32>| path.windows(2).filter(|pair| pair[0] != pair[1]).count() as u64;
    [costs.makespan, costs.sum_of_costs, paths.iter().map(moves).sum()]
}

/// The candidate plans of a step, given one plan with its bounds; `standing` are the cells of the parts that stay.
pub fn front(
    instance: &Instance,
    standing: Vec<CellIndex>,
    paths: &Paths,
    bounds: BoardFigures,
    asked: AskedStep,
) -> PlanFront {
    let choices = vec![(paths.clone(), figures(paths))];
    let shared = instance.board.channels().map(|channels| (channels.clone(), standing));
    let front = PlanFront { choices, bounds, is_whole: true, reaches: false, shared };
    let [_, least_sum, least_moves] = asked.limits.least;
    if instance.agents.len() == 1 && [least_sum, least_moves] == [0, 0] {
        // A shortest path has the least of every figure; where it must have more steps, it waits.
        return front;
    }
    let mut meter = Meter::new(SearchBudget::of(asked.expansions / LABELS_SHARE));
    if let Some(choices) = labels::front(instance, asked.limits, &mut meter) {
        return PlanFront { choices, reaches: true, ..front };
    }
    let mut search = LimitedTaskSearch { instance, asked, front, left: asked.expansions };
    search.run();
    search.front
}

struct LimitedTaskSearch<'a> {
    instance: &'a Instance,
    asked: AskedStep,
    front: PlanFront,
    left: u64,
}

impl LimitedTaskSearch<'_> {
    fn run(&mut self) {
        let most = self.asked.limits.most;
        if most[2] != UNLIMITED {
            self.front.is_whole = false;
            let mut meter = Meter::new(self.share());
            if let Some(paths) = portfolio::fewest_moves(self.instance, &mut meter) {
                self.front.bounds[2] = figures(&paths)[2];
                self.keep(paths);
            }
        }
        let is_done = self.asked.objective == BoardObjective::Makespan && self.fewest_steps();
        if !is_done {
            self.fewer_and_fewer_steps();
        }
    }

    fn share(&mut self) -> SearchBudget {
        let share = self.left / SEARCH_SHARE;
        self.left -= share;
        SearchBudget::of(share)
    }

    fn keep(&mut self, paths: Paths) -> BoardFigures {
        let figures = figures(&paths);
        self.front.choices.push((paths, figures));
        figures
    }

    fn solve(&mut self, objective: BoardObjective, steps: u64) -> BoardAnswer {
        let budget = self.share();
        portfolio::solve(self.instance, objective, (steps != UNLIMITED).then_some(steps), budget)
    }

    /// Searches for the fewest steps; returns whether no further search is needed.
    fn fewest_steps(&mut self) -> bool {
        let [steps, sum, _] = self.asked.limits.most;
        let known = self.front.choices[0].1;
        if known[0] <= self.front.bounds[0].min(steps) && known[1] > sum {
            // The fewest steps are known; what is sought is a smaller sum of costs at that number.
            return false;
        }
        match self.solve(BoardObjective::Makespan, steps) {
            BoardAnswer::Found(BoardPlan { paths, bounds }) => {
                self.front.bounds[0] = self.front.bounds[0].max(bounds.makespan);
                let figures = self.keep(paths);
                self.asked.is_only && figures[0] <= self.front.bounds[0] && figures[1] <= sum
            }
            BoardAnswer::Impossible(why) => {
                self.raise_steps(&why);
                true
            }
            BoardAnswer::GaveUp(_) => {
                self.front.is_whole = false;
                false
            }
        }
    }

    fn raise_steps(&mut self, why: &NoBoardPlan) {
        match why {
            NoBoardPlan::TooFewSteps { least } => self.front.bounds[0] = self.front.bounds[0].max(*least),
            NoBoardPlan::Closed { .. } | NoBoardPlan::TornByChannels { .. } | NoBoardPlan::Blocked { .. } => {}
        }
    }

    /// Minimises the sum of costs within the limit on steps, then within fewer steps than that plan has, and so on.
    fn fewer_and_fewer_steps(&mut self) {
        let [mut steps, most_sum, _] = self.asked.limits.most;
        let mut is_first = true;
        loop {
            let (paths, bound) = match self.solve(BoardObjective::SumOfCosts, steps) {
                BoardAnswer::Found(BoardPlan { paths, bounds }) => (paths, bounds.sum_of_costs),
                BoardAnswer::Impossible(why) if is_first => return self.raise_steps(&why),
                BoardAnswer::Impossible(_) => return,
                BoardAnswer::GaveUp(_) => {
                    self.front.is_whole = false;
                    return;
                }
            };
            if is_first {
                self.front.bounds[1] = self.front.bounds[1].max(bound);
            }
            is_first = false;
            let figures = self.keep(paths);
            if bound > most_sum {
                return;
            }
            self.front.is_whole &= figures[1] <= bound;
            let is_enough = match self.asked.objective {
                BoardObjective::SumOfCosts => true,
                BoardObjective::Makespan => figures[1] > most_sum,
            };
            if self.asked.is_only && is_enough || figures[0] <= self.front.bounds[0] {
                return;
            }
            if self.left < SEARCH_SHARE {
                self.front.is_whole = false;
                return;
            }
            steps = figures[0] - 1;
        }
    }
}

/// Best combination of the steps' plans within the limits.
pub enum Chosen {
    /// One plan for each step, and a lower bound on the objective of all plans that keep the limits.
    Kept { paths: Vec<Paths>, bound: u64 },
    /// None of the plans found keeps the limits; `is_proven` if none exists.
    Broken { is_proven: bool },
}

/// The best combination of one plan per step.
pub fn choose(fronts: &[PlanFront], limits: PlanLimits, objective: BoardObjective) -> Chosen {
    let bounds = sum(fronts.iter().map(|front| front.bounds));
    if exceeds(bounds, limits.most) || exceeds(limits.least, limits.most) {
        return Chosen::Broken { is_proven: true };
    }
    let (partials, cut) = combined(fronts, limits);
    let is_whole = !cut && fronts.iter().all(|front| front.is_whole);
    let reaches = fronts.iter().all(|front| front.reaches) || limits.least == [0; 3];
    let candidates = partials.iter().map(|partial| (picked(fronts, partial), partial.figures));
    let candidates = candidates.filter_map(|(paths, figures)| delayed(fronts, paths, figures, limits));
    let first = match objective {
        BoardObjective::Makespan => 0,
        BoardObjective::SumOfCosts => 1,
    };
    let key = |figures: &BoardFigures| (figures[first], figures[1 - first], figures[2]);
    match candidates.min_by_key(|(_, figures)| key(figures)) {
        Some((paths, figures)) => {
            let least = bounds[first].max(limits.least[first]);
            let bound = if is_whole && reaches { figures[first] } else { least.min(figures[first]) };
            Chosen::Kept { paths, bound }
        }
        None => Chosen::Broken { is_proven: is_whole && (reaches || partials.is_empty()) },
    }
}

/// The least value of a figure among the plans found that keep the limits.
pub fn least_known(fronts: &[PlanFront], limits: PlanLimits, figure: usize) -> Option<u64> {
    let (partials, _) = combined(fronts, PlanLimits { least: [0; 3], ..limits });
    let enough = partials.iter().filter(|partial| !exceeds(limits.least, partial.figures));
    enough.map(|partial| partial.figures[figure]).min()
}

/// One plan for each of the first steps.
#[derive(Clone)]
struct Partial {
    figures: BoardFigures,
    picks: Vec<u32>,
}

/// All non-dominated combinations within the upper limits, and whether some were dropped.
fn combined(fronts: &[PlanFront], limits: PlanLimits) -> (Vec<Partial>, bool) {
    let mut partials = vec![Partial { figures: [0; 3], picks: vec![] }];
    let mut cut = false;
    for (turn, front) in fronts.iter().enumerate() {
        let rest = sum(fronts[turn + 1..].iter().map(|front| front.bounds));
        let mut longer: Vec<Partial> = vec![];
        for partial in &partials {
            for (pick, (_, own)) in front.choices.iter().enumerate() {
                let figures = sum([partial.figures, *own].into_iter());
                let is_covered = longer.iter().any(|known| limits.covers(&known.figures, &figures));
                if exceeds(sum([figures, rest].into_iter()), limits.most) || is_covered {
                    continue;
                }
                longer.retain(|known| !limits.covers(&figures, &known.figures));
                let picks = partial.picks.iter().copied().chain([pick as u32]).collect();
                longer.push(Partial { figures, picks });
            }
        }
        longer.sort_by_key(|partial| partial.figures);
        cut |= longer.len() > MOST_CHOICES;
        longer.truncate(MOST_CHOICES);
        partials = longer;
    }
    (partials, cut)
}

fn picked(fronts: &[PlanFront], partial: &Partial) -> Vec<Paths> {
    fronts.iter().zip(&partial.picks).map(|(front, pick)| front.choices[*pick as usize].0.clone()).collect()
}

/// The combination, changed to keep the lower limits too: if steps are missing, all parts of one step wait before they
/// move, or as soon as they can. `None` if that is not possible.
fn delayed(
    fronts: &[PlanFront],
    mut paths: Vec<Paths>,
    figures: BoardFigures,
    limits: PlanLimits,
) -> Option<(Vec<Paths>, BoardFigures)> {
    let missing = limits.least[0].saturating_sub(figures[0]);
    let movers = |paths: &Paths| paths.iter().filter(|path| path.len() > 1).count();
    if missing > 0 {
        if missing > MOST_DELAY {
            return None;
        }
        let rests = paths.iter_mut().zip(fronts).filter_map(|(paths, front)| Some((front.first_rest(paths)?, paths)));
        let (rest, step) = rests.min_by_key(|(_, paths)| movers(paths))?;
        for path in step.iter_mut().filter(|path| path.len() > rest + 1) {
            let here = position(path, rest);
            path.splice(rest..rest, (0..missing).map(|_| here));
        }
    }
    let figures = sum(paths.iter().map(self::figures));
    (!exceeds(figures, limits.most) && !exceeds(limits.least, figures)).then_some((paths, figures))
}

impl PlanFront {
    /// The first instant of a plan, before its last one, at which all parts can rest where they are; `None` if there is
    /// none.
    fn first_rest(&self, paths: &Paths) -> Option<usize> {
        let longest = paths.iter().map(Vec::len).max().unwrap_or(1);
        let may_rest = |instant: &usize| {
            self.shared.as_ref().is_none_or(|(channels, standing)| {
                let cells = paths.iter().map(|path| position(path, *instant)).chain(standing.iter().copied());
                channels.may_rest(&cells.collect::<Vec<_>>())
            })
        };
        (0..longest - 1).find(may_rest)
    }
}

/// Longest wait that is inserted, in steps.
const MOST_DELAY: u64 = 100_000;

fn sum(figures: impl Iterator<Item = BoardFigures>) -> BoardFigures {
    let add = |one: BoardFigures, other: BoardFigures| {
        [0, 1, 2].map(|figure: usize| one[figure].saturating_add(other[figure]))
    };
    figures.fold([0; 3], add)
}

/// Whether some figure is above its limit.
pub fn exceeds(figures: BoardFigures, most: BoardFigures) -> bool {
    figures.iter().zip(most).any(|(figure, most)| *figure > most)
}
