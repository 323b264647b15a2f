//! Plans of a stage on a board with shared channels.
//!
//! Method: a first plan with one agent after the other ([`super::prioritised`]), then [`joint`], which searches all
//! agents at once under the rule of channels. The other planners are not used: repair, large neighbourhoods and
//! configurations move agents one at a time, or shift their moves in time, which the rule does not allow.
//!
//! Guaranteed: a plan is legal; bounds hold for every plan; "none" is a proof under the rule, for an agent alone or by
//! exhausting the joint positions of some agents. If the budget ends first, the answer may be neither. Cost: that of
//! [`joint`]: two or three droplets are solved with proof on a board of 100 cells, more where they seldom block each
//! other.

use super::broadcast::SharedChannels;
use super::prioritised;
use crate::plan::electrode_array::board::{
    BoardAnswer, BoardCosts, BoardObjective, BoardPlan, Instance, NoBoardPlan, Paths,
};
use crate::plan::electrode_array::exact::tables::{ExactTables, NoExactTables};
use crate::plan::electrode_array::fast;
use crate::plan::electrode_array::joint::{self, JointAim, JointAnswer, NoJointPlan};
use crate::plan::search::Meter;

/// 1/N of the remaining budget for a first plan, for the secondary figure, and for each try to find a smaller set of
/// agents that exclude each other.
const FIRST_SHARE: u64 = 8;
const TIE_SHARE: u64 = 4;
const BLAME_SHARE: u64 = 4;

/// Plans a stage, within a limit on the steps if there is one; the counterpart of
/// [`crate::plan::electrode_array::portfolio::solve`] for shared channels.
pub fn solve(
    instance: &Instance,
    channels: &SharedChannels,
    objective: BoardObjective,
    limit: Option<u64>,
    meter: &mut Meter,
) -> BoardAnswer {
    let ignored = match fast::bounds(instance) {
        Ok(bounds) => bounds,
        Err(why) => return BoardAnswer::Impossible(why),
    };
    let tables = match ExactTables::new(instance) {
        Ok(tables) => tables,
        Err(NoExactTables::TooLarge) => return BoardAnswer::GaveUp(ignored),
        Err(NoExactTables::StopCutOff { agent, stop }) => {
            return BoardAnswer::Impossible(NoBoardPlan::TornByChannels { agent, stop });
        }
    };
    let least = (0..tables.agents()).map(|agent| u64::from(tables.least(agent)));
    let bounds = BoardCosts { makespan: least.clone().max().unwrap_or(0), sum_of_costs: least.sum() };
    if limit.is_some_and(|limit| limit < bounds.makespan) {
        return BoardAnswer::Impossible(NoBoardPlan::TooFewSteps { least: bounds.makespan });
    }
    let share = meter.left().steps / FIRST_SHARE;
    let best = meter.share(share, |share| prioritised::first(&tables, channels, objective, limit, share));
    let search = PinnedSearch { tables: &tables, objective, limit, bounds, best, meter };
    match objective {
        BoardObjective::Makespan => search.fewest_steps(),
        BoardObjective::SumOfCosts => search.least_sum(),
    }
}

struct PinnedSearch<'a> {
    tables: &'a ExactTables<'a>,
    objective: BoardObjective,
    limit: Option<u64>,
    bounds: BoardCosts,
    best: Option<Paths>,
    meter: &'a mut Meter,
}

impl PinnedSearch<'_> {
    fn everyone(&self) -> Vec<usize> {
        (0..self.tables.agents()).collect()
    }

    /// The limit in the type that the joint search takes.
    fn steps(limit: Option<u64>) -> Option<u32> {
        limit.map(|limit| u32::try_from(limit).unwrap_or(u32::MAX))
    }

    fn fewest_steps(mut self) -> BoardAnswer {
        let known = self.best.as_ref().map(|best| BoardCosts::of(best).makespan);
        if known == Some(self.bounds.makespan) {
            return self.with_least_sum();
        }
        let limit = known.map(|known| known - 1).or(self.limit);
        let aim = JointAim::Makespan { limit: Self::steps(limit) };
        match joint::search(self.tables, &self.everyone(), aim, self.meter) {
            JointAnswer::Found(paths) => {
                self.bounds.makespan = BoardCosts::of(&paths).makespan;
                self.best = Some(paths);
                self.with_least_sum()
            }
            JointAnswer::Impossible(why) => match known {
                Some(known) => {
                    self.bounds.makespan = known;
                    self.with_least_sum()
                }
                None => self.none(why),
            },
            JointAnswer::GaveUp(bound) => {
                self.bounds.makespan = self.bounds.makespan.max(bound);
                self.held()
            }
        }
    }

    fn least_sum(mut self) -> BoardAnswer {
        let met = self.best.as_ref().is_some_and(|best| BoardCosts::of(best).sum_of_costs == self.bounds.sum_of_costs);
        if met {
            return self.held();
        }
        let aim = JointAim::SumOfCosts { limit: Self::steps(self.limit) };
        match joint::search(self.tables, &self.everyone(), aim, self.meter) {
            JointAnswer::Found(paths) => {
                self.bounds.sum_of_costs = BoardCosts::of(&paths).sum_of_costs;
                self.best = Some(paths);
                self.held()
            }
            JointAnswer::Impossible(why) => self.none(why),
            JointAnswer::GaveUp(bound) => {
                self.bounds.sum_of_costs = self.bounds.sum_of_costs.max(bound);
                self.held()
            }
        }
    }

    /// Minimises the sum of costs among plans with the makespan of the best one, while that is quick.
    fn with_least_sum(mut self) -> BoardAnswer {
        let Some(best) = &self.best else { return self.held() };
        let costs = BoardCosts::of(best);
        if costs.sum_of_costs > self.bounds.sum_of_costs {
            let aim = JointAim::SumOfCosts { limit: Self::steps(Some(costs.makespan)) };
            let (tables, everyone) = (self.tables, self.everyone());
            let share = self.meter.left().steps / TIE_SHARE;
            let found = self.meter.share(share, |share| joint::search(tables, &everyone, aim, share));
            if let JointAnswer::Found(paths) = found
                && BoardCosts::of(&paths).key(self.objective) < costs.key(self.objective)
            {
                self.best = Some(paths);
            }
        }
        self.held()
    }

    /// The best known plan, if there is one, with the bounds.
    fn held(self) -> BoardAnswer {
        match self.best {
            Some(paths) => BoardAnswer::Found(BoardPlan { paths, bounds: self.bounds }),
            None => BoardAnswer::GaveUp(self.bounds),
        }
    }

    fn none(mut self, why: NoJointPlan) -> BoardAnswer {
        match (why, self.limit) {
            (NoJointPlan::WithinLimit, Some(limit)) => {
                BoardAnswer::Impossible(NoBoardPlan::TooFewSteps { least: limit + 1 })
            }
            (NoJointPlan::WithinLimit, None) => BoardAnswer::GaveUp(self.bounds),
            (NoJointPlan::AtAll, _) => BoardAnswer::Impossible(NoBoardPlan::Blocked { agents: self.blamed() }),
        }
    }

    /// Agents that exclude each other, whatever the others do: all agents, without those that are found not to be
    /// needed for that.
    fn blamed(&mut self) -> Vec<usize> {
        let mut agents = self.everyone();
        let (mut at, tables) = (0, self.tables);
        while at < agents.len() && agents.len() > 1 {
            let rest: Vec<usize> = agents.iter().copied().filter(|agent| *agent != agents[at]).collect();
            let share = self.meter.left().steps / BLAME_SHARE;
            let aim = JointAim::Makespan { limit: None };
            match self.meter.share(share, |share| joint::search(tables, &rest, aim, share)) {
                JointAnswer::Impossible(_) => agents = rest,
                JointAnswer::Found(_) | JointAnswer::GaveUp(_) => at += 1,
            }
        }
        agents
    }
}
