//! Proves bounds and finds optimal plans for many parts on one board, or proves that there is no plan.
//!
//! Problem: an [`Instance`], a [`BoardObjective`], and possibly a plan to be judged or improved. Methods, in this
//! order:
//!
//! - The distances of the agents alone bound both costs; a plan that meets its bound is proven at once.
//! - A small joint space is searched exhaustively ([`joint`]); that decides every question.
//! - Without a plan, the joint spaces of pairs are searched for agents that cannot pass one another, whatever the
//!   others do.
//! - Conflict-based search on independent groups (`tree`, `groups`): for the sum of costs directly; for the makespan by
//!   testing increasing numbers of steps, starting from the lower bound. Before that, pairs of agents often prove that
//!   a number is too small (`joint_mdd`).
//! - Still without a plan: the joint space of all agents, as far as the budget allows.
//!
//! Guaranteed: bounds and reasons are proven, plans keep the rule, and everything ends within the budget. With an
//! unlimited budget every instance would be decided. Not guaranteed: that a given budget suffices; that ties are broken
//! by the other objective, except in small joint spaces when the makespan comes first; that the agents named by
//! [`NoBoardPlan::Blocked`] are the fewest. Cost: exponential in the number of agents that meet in tight places, close
//! to linear where few do.
//!
//! One step of the budget is one node of one agent's search or of its layers, or one move tried in a joint space;
//! memory stays below some 50 bytes a step.

mod constraint;
mod cover;
mod groups;
mod joint_mdd;
mod mdd;
mod pair;
mod split;
pub mod tables;
mod tree;

use super::board::{
    BoardAnswer, BoardCosts, BoardObjective, BoardPlan, BoardPlanProgress, CellIndex, Instance, NoBoardPlan, Paths,
};
use super::joint::{self, JointAim, NoJointPlan, trim};
use super::portfolio::timing;
use crate::plan::search::{Meter, SearchBudget};
use constraint::ALWAYS;
use groups::WantedBounds;
use tables::{ExactTables, NoExactTables};
use tree::TreeAnswer;

/// Joint spaces with at most this many states are searched exhaustively.
const SMALL: u64 = 1 << 20;

/// 1/N of the remaining budget is left to the other methods by a search of a small joint space.
const JOINT_SHARE: u64 = 4;

/// 1/N of the remaining budget for all pairs that may block; each pair gets 1/N of what remains of that.
const PAIRS_SHARE: u64 = 2;
const PAIR_SHARE: u64 = 2;

/// Budget, in moves tried, for the cells that agents without a plan reach; they are shown in a picture.
const REACH_BUDGET: SearchBudget = SearchBudget::of(4_000_000);

/// 1/N of the remaining budget for the main search if there is no incumbent, since that search may not end if there is
/// no plan.
const OPEN_SHARE: u64 = 2;

/// 1/N of the remaining budget for a better sum of costs at the least makespan.
const POLISH_SHARE: u64 = 4;

/// 1/N of the remaining budget for proofs by pairs that a number of steps is too small.
pub const RAISE_SHARE: u64 = 64;

/// Proves as much as the budget allows: improves the bounds and the incumbent until they meet, or proves that there is no plan.
///
/// The incumbent must be a legal plan. With `limit`, plans of more steps do not count. The bounds of the answer hold for every plan
/// of the instance within the limit; a plan that meets the bound of the objective is proven optimal. [`NoBoardPlan::TooFewSteps`]
/// names the least sufficient number of steps if the budget sufficed to find it, otherwise a proven lower bound on it.
pub fn prove(
    instance: &Instance,
    objective: BoardObjective,
    incumbent: Option<&Paths>,
    limit: Option<u64>,
    meter: &mut Meter,
) -> BoardAnswer {
    let limit = limit.map(|limit| limit.min(u64::from(ALWAYS - 1)) as u32);
    let within = |paths: &&Paths| limit.is_none_or(|limit| BoardCosts::of(paths).makespan <= u64::from(limit));
    let best = incumbent.filter(within).cloned();
    match ExactTables::new(instance) {
        Ok(tables) => Prover::new(&tables, objective, best, limit, meter).run(),
        Err(NoExactTables::StopCutOff { agent, stop }) => BoardAnswer::Impossible(NoBoardPlan::Closed { agent, stop }),
        Err(NoExactTables::TooLarge) => unsearched(best, manhattan_bounds(instance)),
    }
}

/// Searches only a small joint space. Returns the answer as [`prove`] does, and whether it is final; `None` if some
/// agent is cut off or the tables are too large.
pub fn small(
    instance: &Instance,
    objective: BoardObjective,
    incumbent: &Paths,
    limit: Option<u64>,
    meter: &mut Meter,
) -> Option<(BoardAnswer, bool)> {
    let limit = limit.map(|limit| limit.min(u64::from(ALWAYS - 1)) as u32);
    let tables = ExactTables::new(instance).ok()?;
    let mut prover = Prover::new(&tables, objective, Some(incumbent.clone()), limit, meter);
    match prover.by_small_joint_space() {
        Some(ProofEnd::Impossible(why)) => Some((BoardAnswer::Impossible(why), true)),
        Some(ProofEnd::Proven) => Some((unsearched(prover.best, prover.bounds), true)),
        None => Some((unsearched(prover.best, prover.bounds), false)),
    }
}

/// A lower bound on the makespan: `known`, raised by one step at a time while pairs of agents prove that no plan keeps
/// it, up to `most`.
pub fn raised(instance: &Instance, known: u64, most: u64, meter: &mut Meter) -> u64 {
    let Ok(tables) = ExactTables::new(instance) else { return known };
    let is_excluded = |steps: &u64| u32::try_from(*steps).is_ok_and(|steps| joint_mdd::excludes(&tables, steps, meter));
    known + (known..most).take_while(is_excluded).count() as u64
}

/// The cells that each of some agents without a plan reaches while they keep apart, by agent; `None` if there are too
/// many joint positions, or channels are shared.
pub fn reached(instance: &Instance, agents: &[usize]) -> Option<Vec<Vec<CellIndex>>> {
    // With shared channels, agents that move at once reach other cells than agents that move in turn.
    let tables = ExactTables::new(instance).ok().filter(|_| instance.board.channels().is_none())?;
    joint::reached(&tables, agents, &mut Meter::new(REACH_BUDGET))
}

fn unsearched(best: Option<Paths>, bounds: BoardCosts) -> BoardAnswer {
    match best {
        Some(paths) => BoardAnswer::Found(BoardPlan { paths, bounds }),
        None => BoardAnswer::GaveUp(bounds),
    }
}

/// Lower bounds from the Manhattan distances along the stops.
fn manhattan_bounds(instance: &Instance) -> BoardCosts {
    let length = |agent: &super::board::Agent| {
        let from = std::iter::once(agent.start).chain(agent.stops.iter().copied());
        from.zip(&agent.stops).map(|(from, to)| u64::from(instance.board.manhattan(from, *to))).sum::<u64>()
    };
    let lengths = instance.agents.iter().map(length);
    BoardCosts { makespan: lengths.clone().max().unwrap_or(0), sum_of_costs: lengths.sum() }
}

/// The state of a proof.
struct Prover<'a, 'm> {
    tables: &'a ExactTables<'a>,
    objective: BoardObjective,
    best: Option<Paths>,
    limit: Option<u32>,
    bounds: BoardCosts,
    meter: &'m mut Meter,
    /// Progress display; `None` until there is a plan.
    progress: Option<BoardPlanProgress>,
}

/// Outcome of a proof.
enum ProofEnd {
    /// The best plan meets its bound.
    Proven,
    Impossible(NoBoardPlan),
}

impl<'a, 'm> Prover<'a, 'm> {
    fn new(
        tables: &'a ExactTables<'a>,
        objective: BoardObjective,
        best: Option<Paths>,
        limit: Option<u32>,
        meter: &'m mut Meter,
    ) -> Self {
        let costs = (0..tables.agents()).map(|agent| u64::from(tables.least(agent)));
        let bounds = BoardCosts { makespan: costs.clone().max().unwrap_or(0), sum_of_costs: costs.sum() };
        let mut prover = Prover { tables, objective, best, limit, bounds, meter, progress: None };
        prover.show_progress();
        prover
    }

    fn run(mut self) -> BoardAnswer {
        match self.decide() {
            Some(ProofEnd::Impossible(why)) => BoardAnswer::Impossible(why),
            Some(ProofEnd::Proven) | None => unsearched(self.best, self.bounds),
        }
    }

    fn decide(&mut self) -> Option<ProofEnd> {
        if self.is_met() {
            return Some(ProofEnd::Proven);
        }
        if let Some(done) = self.by_small_joint_space() {
            return Some(done);
        }
        if self.best.is_none()
            && let Some(agents) = self.blocked_pair()
        {
            return Some(ProofEnd::Impossible(NoBoardPlan::Blocked { agents }));
        }
        if self.limit.is_some_and(|limit| u64::from(limit) < self.bounds.makespan) {
            return Some(self.too_few_steps());
        }
        let done = match self.objective {
            BoardObjective::Makespan => self.by_makespan(),
            BoardObjective::SumOfCosts => self.by_sum_of_costs(),
        };
        if done.is_some() || self.best.is_some() {
            return done;
        }
        self.by_whole_joint_space()
    }

    /// Whether the best plan meets the bound of the objective.
    fn is_met(&self) -> bool {
        self.best.as_ref().is_some_and(|paths| {
            let costs = BoardCosts::of(paths);
            match self.objective {
                BoardObjective::Makespan => costs.makespan <= self.bounds.makespan,
                BoardObjective::SumOfCosts => costs.sum_of_costs <= self.bounds.sum_of_costs,
            }
        })
    }

    /// Keeps a plan if it is better than the incumbent.
    fn offer(&mut self, mut paths: Paths) {
        paths.iter_mut().for_each(trim);
        let key = |paths: &Paths| BoardCosts::of(paths).key(self.objective);
        if self.limit.is_some_and(|limit| BoardCosts::of(&paths).makespan > u64::from(limit)) {
            return;
        }
        if self.best.as_ref().is_none_or(|best| key(&paths) < key(best)) {
            self.best = Some(paths);
            self.show_progress();
        }
    }

    /// Updates the progress display.
    fn show_progress(&mut self) {
        let Some(costs) = self.best.as_ref().map(BoardCosts::of) else { return };
        match &mut self.progress {
            Some(progress) => progress.offer(costs, self.bounds),
            None => self.progress = Some(BoardPlanProgress::begin(self.objective, costs, self.bounds)),
        }
    }

    fn everyone(&self) -> Vec<usize> {
        (0..self.tables.agents()).collect()
    }

    /// Whether the joint space is small, counting for each agent the nodes from which its goal is reachable.
    fn is_small(&self) -> bool {
        self.everyone()
            .into_iter()
            .try_fold(1u64, |product, agent| product.checked_mul(self.tables.reaching(agent)))
            .is_some_and(|all| all <= SMALL)
    }

    /// Both costs exactly, each within its share of the budget; ties are then broken by the other cost.
    fn by_small_joint_space(&mut self) -> Option<ProofEnd> {
        if !self.is_small() {
            return None;
        }
        if self.best.is_none() {
            match self.jointly(JointAim::Any) {
                joint::JointAnswer::Found(paths) => self.offer(timing::earliest(self.tables.instance, &paths)),
                joint::JointAnswer::Impossible(NoJointPlan::AtAll) => {
                    return Some(ProofEnd::Impossible(self.blocked_among(self.everyone())));
                }
                joint::JointAnswer::Impossible(NoJointPlan::WithinLimit) | joint::JointAnswer::GaveUp(_) => {}
            }
        }
        match self.objective {
            BoardObjective::Makespan => {
                let decided = self.makespan_of_small_joint_space();
                if decided.is_some() {
                    return decided;
                }
                if self.is_met() {
                    let limit = Some(self.bounds.makespan as u32);
                    if let joint::JointAnswer::Found(paths) = self.jointly(JointAim::SumOfCosts { limit }) {
                        self.offer(paths);
                    }
                }
            }
            BoardObjective::SumOfCosts => {
                self.sum_of_small_joint_space();
                let decided = self.makespan_of_small_joint_space();
                if decided.is_some() {
                    return decided;
                }
                self.fewest_steps_of_least_sum();
            }
        }
        self.is_met().then_some(ProofEnd::Proven)
    }

    /// The least makespan, or the proof that there is no plan within the limit.
    fn makespan_of_small_joint_space(&mut self) -> Option<ProofEnd> {
        let least = match self.jointly(JointAim::Makespan { limit: None }) {
            joint::JointAnswer::Found(paths) => {
                let least = BoardCosts::of(&paths).makespan;
                self.offer(paths);
                least
            }
            joint::JointAnswer::Impossible(NoJointPlan::AtAll) => {
                return Some(ProofEnd::Impossible(self.blocked_among(self.everyone())));
            }
            joint::JointAnswer::GaveUp(bound) => bound,
            joint::JointAnswer::Impossible(NoJointPlan::WithinLimit) => return None,
        };
        self.bounds.makespan = self.bounds.makespan.max(least);
        let exceeds = self.limit.is_some_and(|limit| self.bounds.makespan > u64::from(limit));
        exceeds.then_some(ProofEnd::Impossible(NoBoardPlan::TooFewSteps { least: self.bounds.makespan }))
    }

    /// The least sum of costs within the limit.
    fn sum_of_small_joint_space(&mut self) {
        // Without instants in the state the space is much smaller, and often the least sum already keeps the limit.
        self.sum_within(None);
        if self.limit.is_some() && !self.is_met() {
            self.sum_within(self.limit);
        }
    }

    fn sum_within(&mut self, limit: Option<u32>) {
        match self.jointly(JointAim::SumOfCosts { limit }) {
            joint::JointAnswer::Found(paths) => {
                self.bounds.sum_of_costs = self.bounds.sum_of_costs.max(BoardCosts::of(&paths).sum_of_costs);
                self.offer(paths);
            }
            joint::JointAnswer::GaveUp(bound) => self.bounds.sum_of_costs = self.bounds.sum_of_costs.max(bound),
            joint::JointAnswer::Impossible(_) => {}
        }
    }

    /// The least makespan among plans with the least sum of costs.
    fn fewest_steps_of_least_sum(&mut self) {
        let Some(least) = self.best.as_ref().filter(|_| self.is_met()).map(BoardCosts::of) else { return };
        for steps in self.bounds.makespan..least.makespan {
            match self.jointly(JointAim::SumOfCosts { limit: Some(steps as u32) }) {
                joint::JointAnswer::Found(paths) => self.offer(paths),
                joint::JointAnswer::Impossible(NoJointPlan::WithinLimit) => {}
                joint::JointAnswer::Impossible(NoJointPlan::AtAll) | joint::JointAnswer::GaveUp(_) => return,
            }
            if self.best.as_ref().is_some_and(|best| BoardCosts::of(best).makespan <= steps) {
                return;
            }
        }
    }

    /// A joint search for everyone on a share of the budget.
    fn jointly(&mut self, aim: JointAim) -> joint::JointAnswer {
        let group = self.everyone();
        let steps = self.meter.left().steps - self.meter.left().steps / JOINT_SHARE;
        self.spend(steps, |tables, meter| joint::search(tables, &group, aim, meter))
    }

    /// A pair of agents that cannot pass one another.
    fn blocked_pair(&mut self) -> Option<Vec<usize>> {
        let steps = self.meter.left().steps / PAIRS_SHARE;
        self.spend(steps, |tables, meter| {
            let pairs = (0..tables.agents()).flat_map(|other| (0..other).map(move |one| [one, other]));
            for pair in pairs {
                let steps = meter.left().steps / PAIR_SHARE;
                let outcome = meter.share(steps, |meter| joint::search(tables, &pair, JointAim::Any, meter));
                meter.charge(1);
                if outcome == joint::JointAnswer::Impossible(NoJointPlan::AtAll) {
                    return Some(pair.to_vec());
                }
            }
            None
        })
    }

    /// Runs a search with a share of the budget.
    fn spend<T>(&mut self, steps: u64, search: impl FnOnce(&ExactTables, &mut Meter) -> T) -> T {
        self.meter.share(steps, |meter| search(self.tables, meter))
    }

    /// A subset without a plan that is as small as this finds: agents are dropped one by one while the rest still has
    /// none.
    fn blocked_among(&mut self, mut agents: Vec<usize>) -> NoBoardPlan {
        let mut place = 0;
        while place < agents.len() && agents.len() > 2 {
            let mut fewer = agents.clone();
            fewer.remove(place);
            let steps = self.meter.left().steps / OPEN_SHARE;
            if self.spend(steps, |tables, meter| joint::search(tables, &fewer, JointAim::Any, meter))
                == joint::JointAnswer::Impossible(NoJointPlan::AtAll)
            {
                agents = fewer;
            } else {
                place += 1;
            }
        }
        NoBoardPlan::Blocked { agents }
    }

    /// Tests increasing numbers of steps, starting from the lower bound.
    fn by_makespan(&mut self) -> Option<ProofEnd> {
        let share = if self.best.is_some() { 1 } else { OPEN_SHARE };
        let mut own = Meter::new(SearchBudget::of(self.meter.left().steps / share));
        let done = self.raise_makespan(&mut own);
        self.meter.charge_metered(own.spent());
        if matches!(done, Some(ProofEnd::Proven)) {
            self.polish();
        }
        done
    }

    fn raise_makespan(&mut self, meter: &mut Meter) -> Option<ProofEnd> {
        while !self.is_met() {
            if self.limit.is_some_and(|limit| self.bounds.makespan > u64::from(limit)) {
                return Some(self.too_few_steps());
            }
            let steps = self.bounds.makespan as u32;
            match within(self.tables, steps, meter) {
                TreeAnswer::Found { paths, .. } => {
                    self.offer(paths);
                    return Some(ProofEnd::Proven);
                }
                TreeAnswer::Nothing => {
                    self.bounds.makespan += 1;
                    self.show_progress();
                }
                TreeAnswer::GaveUp { .. } => return None,
            }
        }
        Some(ProofEnd::Proven)
    }

    /// Improves the sum of costs of a plan whose makespan is proven.
    fn polish(&mut self) {
        let Some(best) = &self.best else { return };
        let costs = BoardCosts::of(best);
        let wanted = WantedBounds { least: 0, most: costs.makespan as u32, ceiling: costs.sum_of_costs };
        let steps = self.meter.left().steps / POLISH_SHARE;
        if let TreeAnswer::Found { paths, .. } =
            self.spend(steps, |tables, meter| groups::search(tables, wanted, meter))
        {
            self.offer(paths);
        }
    }

    fn by_sum_of_costs(&mut self) -> Option<ProofEnd> {
        let ceiling = self.best.as_ref().map_or(u64::MAX, |paths| BoardCosts::of(paths).sum_of_costs);
        let wanted = WantedBounds { least: 0, most: self.limit.unwrap_or(ALWAYS), ceiling };
        let share = if self.best.is_some() { 1 } else { OPEN_SHARE };
        let steps = self.meter.left().steps / share;
        match self.spend(steps, |tables, meter| groups::search(tables, wanted, meter)) {
            TreeAnswer::Found { paths, cost } => {
                self.bounds.sum_of_costs = self.bounds.sum_of_costs.max(cost);
                self.offer(paths);
                Some(ProofEnd::Proven)
            }
            TreeAnswer::Nothing if self.best.is_some() => {
                self.bounds.sum_of_costs = ceiling;
                Some(ProofEnd::Proven)
            }
            TreeAnswer::Nothing if self.limit.is_some() => Some(self.too_few_steps()),
            TreeAnswer::Nothing => {
                let everyone = self.everyone();
                Some(ProofEnd::Impossible(self.blocked_among(everyone)))
            }
            TreeAnswer::GaveUp { bound } => {
                self.bounds.sum_of_costs = self.bounds.sum_of_costs.max(bound);
                None
            }
        }
    }

    /// Reports that there is no plan within the limit. Searches for the number of steps that suffices, as far as the
    /// budget allows.
    fn too_few_steps(&mut self) -> ProofEnd {
        let past_limit = u64::from(self.limit.unwrap_or(0)) + 1;
        self.bounds.makespan = self.bounds.makespan.max(past_limit);
        loop {
            let steps = self.bounds.makespan as u32;
            let share = self.meter.left().steps / OPEN_SHARE;
            match self.spend(share, |tables, meter| within(tables, steps, meter)) {
                TreeAnswer::Nothing => self.bounds.makespan += 1,
                TreeAnswer::Found { .. } | TreeAnswer::GaveUp { .. } => break,
            }
        }
        ProofEnd::Impossible(NoBoardPlan::TooFewSteps { least: self.bounds.makespan })
    }

    fn by_whole_joint_space(&mut self) -> Option<ProofEnd> {
        let group = self.everyone();
        let aim = JointAim::Makespan { limit: self.limit };
        let aim = if self.limit.is_some() { aim } else { JointAim::Any };
        match joint::search(self.tables, &group, aim, self.meter) {
            joint::JointAnswer::Found(paths) => self.offer(timing::earliest(self.tables.instance, &paths)),
            joint::JointAnswer::Impossible(NoJointPlan::AtAll) => {
                return Some(ProofEnd::Impossible(self.blocked_among(group)));
            }
            joint::JointAnswer::Impossible(NoJointPlan::WithinLimit) => return Some(self.too_few_steps()),
            joint::JointAnswer::GaveUp(_) => {}
        }
        None
    }
}

/// A plan in which everyone arrives within `steps` steps, whatever the sum of costs.
fn within(tables: &ExactTables, steps: u32, meter: &mut Meter) -> TreeAnswer {
    let share = meter.left().steps / RAISE_SHARE;
    if meter.share(share, |meter| joint_mdd::excludes(tables, steps, meter)) {
        return TreeAnswer::Nothing;
    }
    groups::search(tables, exactly(steps), meter)
}

/// Plans in which everyone arrives within `steps` steps, whatever their sum of costs.
fn exactly(steps: u32) -> WantedBounds {
    WantedBounds { least: steps, most: steps, ceiling: u64::MAX }
}

#[cfg(test)]
mod tests;
