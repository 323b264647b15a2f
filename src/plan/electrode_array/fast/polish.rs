//! A legal plan made better until its bounds are met or the budget is spent.
//!
//! Method: large-neighbourhood search (MAPF-LNS: Li and others, IJCAI 2021): take out the paths of a few agents, plan them again one
//! after the other in a random order among the rest, keep what is not worse. Three ways to choose the few, each the more often
//! the more it has gained lately: a late agent with those in its way, agents that meet at one place, and any.
//! Guaranteed: the plan stays legal and never gets worse; it is optimal where it meets the bounds. Not guaranteed: an optimum
//! within any budget. Cost: one search for each agent of a neighbourhood of at most [`LARGEST`].

use super::super::board::{Cell, Costs, Objective, Paths};
use super::crew::{Crew, Wish};
use super::reservations::Others;
use crate::plan::search::Meter;

/// How many agents are planned again at once, at most.
const LARGEST: usize = 8;

/// How an objective compares two plans: makespan, how much too late in all, sum of costs; or sum of costs, makespan.
type Key = (u64, u64, u64);

/// The ways to choose a neighbourhood.
#[derive(Debug, Clone, Copy)]
enum Choice {
    /// A late agent and those who are in its way.
    Blockers,
    /// Those who come by one place.
    Crossing,
    Random,
}

const CHOICES: [Choice; 3] = [Choice::Blockers, Choice::Crossing, Choice::Random];

/// Weight of a choice at the beginning and at least.
const WEIGHTS: (u32, u32) = (1000, 100);

struct Polish<'c, 'a> {
    crew: &'c mut Crew<'a>,
    paths: Paths,
    objective: Objective,
    bounds: Costs,
    weights: [u32; CHOICES.len()],
    /// Whose turn it is to be the late agent.
    turn: usize,
}

/// Improves a plan; `bounds` are those of the agents alone.
pub(super) fn polish(crew: &mut Crew, paths: Paths, objective: Objective, bounds: Costs, meter: &mut Meter) -> Paths {
    crew.enter_all(&paths);
    let mut state = Polish { crew, paths, objective, bounds, weights: [WEIGHTS.0; CHOICES.len()], turn: 0 };
    while state.is_open() && meter.step().is_some() {
        state.round(meter);
    }
    state.paths
}

impl Polish<'_, '_> {
    fn is_open(&self) -> bool {
        Costs::of(&self.paths) != self.bounds
    }

    fn arrival(&self, agent: usize) -> u64 {
        self.paths[agent].len() as u64 - 1
    }

    fn delay(&self, agent: usize) -> u64 {
        self.arrival(agent) - u64::from(self.crew.least[agent])
    }

    fn key(&self) -> Key {
        let costs = Costs::of(&self.paths);
        match self.objective {
            Objective::Makespan => {
                let late = |path: &Vec<Cell>| (path.len() as u64 - 1).saturating_sub(self.bounds.makespan);
                (costs.makespan, self.paths.iter().map(late).sum(), costs.sum_of_costs)
            }
            Objective::SumOfCosts => (costs.sum_of_costs, costs.makespan, 0),
        }
    }

    /// One neighbourhood, planned again.
    fn round(&mut self, meter: &mut Meter) {
        let pick = self.pick();
        let size = 2 + self.crew.random.below(LARGEST - 1);
        let chosen = match CHOICES[pick] {
            Choice::Blockers => self.blockers(size, meter),
            Choice::Crossing => self.crossing(size),
            Choice::Random => self.any(size),
        };
        let before = self.key();
        let gained = self.again(&chosen, before, meter);
        let weight = &mut self.weights[pick];
        *weight = (*weight * 31 / 32 + if gained { WEIGHTS.0 } else { 0 }).max(WEIGHTS.1);
    }

    fn pick(&mut self) -> usize {
        let mut left = self.crew.random.below(self.weights.iter().sum::<u32>() as usize) as u32;
        self.weights
            .iter()
            .position(|weight| {
                left < *weight || {
                    left -= weight;
                    false
                }
            })
            .unwrap_or(0)
    }

    /// A late agent, by turns; where the makespan counts and is too long, every other time one that arrives last.
    fn late(&mut self) -> usize {
        let count = self.crew.count();
        let makespan = Costs::of(&self.paths).makespan;
        let too_long = self.objective == Objective::Makespan && makespan > self.bounds.makespan;
        let last_ones = too_long && self.crew.random.below(2) == 0;
        for step in 1..=count {
            let agent = (self.turn + step) % count;
            if (last_ones && self.arrival(agent) == makespan) || (!last_ones && self.delay(agent) > 0) {
                self.turn = agent;
                return agent;
            }
        }
        self.crew.random.below(count)
    }

    fn blockers(&mut self, size: usize, meter: &mut Meter) -> Vec<usize> {
        let agent = self.late();
        let way = self.crew.alone(agent, meter);
        let mut others = self.crew.conflicts(agent, &way);
        self.crew.random.shuffle(&mut others);
        let mut chosen = vec![agent];
        chosen.extend(others.into_iter().take(size - 1));
        self.fill(chosen, size.min(3))
    }

    fn crossing(&mut self, size: usize) -> Vec<usize> {
        let agent = self.late();
        let path = &self.paths[agent];
        let cell = path[self.crew.random.below(path.len())];
        let mut others: Vec<usize> = self.crew.table.visitors(cell).filter(|other| *other != agent).collect();
        others.sort_unstable();
        others.dedup();
        self.crew.random.shuffle(&mut others);
        let mut chosen = vec![agent];
        chosen.extend(others.into_iter().take(size - 1));
        self.fill(chosen, 2)
    }

    fn any(&mut self, size: usize) -> Vec<usize> {
        self.fill(Vec::new(), size)
    }

    /// Adds random agents up to a size.
    fn fill(&mut self, mut chosen: Vec<usize>, size: usize) -> Vec<usize> {
        let size = size.min(self.crew.count());
        while chosen.len() < size {
            let agent = self.crew.random.below(self.crew.count());
            if !chosen.contains(&agent) {
                chosen.push(agent);
            }
        }
        chosen
    }

    /// Plans the chosen agents again and keeps what is not worse; whether it is better.
    fn again(&mut self, chosen: &[usize], before: Key, meter: &mut Meter) -> bool {
        let old: Vec<_> = chosen.iter().map(|agent| (*agent, std::mem::take(&mut self.paths[*agent]))).collect();
        for (agent, path) in &old {
            self.crew.table.remove(*agent, path);
        }
        let mut order = chosen.to_vec();
        self.crew.random.shuffle(&mut order);
        let placed = self.place(&order, &old, meter);
        let after = (placed == order.len()).then(|| self.key());
        if after.is_some_and(|after| after <= before) {
            return after < Some(before);
        }
        for agent in &order[..placed] {
            self.crew.table.remove(*agent, &self.paths[*agent]);
        }
        for (agent, path) in old {
            self.crew.table.add(agent, &path);
            self.paths[agent] = path;
        }
        false
    }

    /// Plans agents in an order; how many of them before one had no path that could do.
    fn place(&mut self, order: &[usize], old: &[(usize, Vec<Cell>)], meter: &mut Meter) -> usize {
        let (limit, mut slack) = self.allowance(old);
        for (placed, agent) in order.iter().enumerate() {
            let least = u64::from(self.crew.least[*agent]);
            let limit = limit.min(least.saturating_add(slack)).min(u64::from(u32::MAX));
            let wish = Wish { others: Others::Hard, weight: 0, limit: limit as u32, delay: 0 };
            let Some(path) = self.crew.plan(*agent, wish, meter) else { return placed };
            slack -= (path.len() as u64 - 1 - least).min(slack);
            self.crew.table.add(*agent, &path);
            self.paths[*agent] = path;
        }
        order.len()
    }

    /// The latest arrival that may do for agents that are planned again, and how much they may all together lose.
    fn allowance(&self, old: &[(usize, Vec<Cell>)]) -> (u64, u64) {
        let arrival = |path: &Vec<Cell>| path.len() as u64 - 1;
        let slack = old.iter().map(|(agent, path)| arrival(path) - u64::from(self.crew.least[*agent])).sum();
        let ours = old.iter().map(|(_, path)| arrival(path)).max().unwrap_or(0);
        let theirs = self.paths.iter().filter(|path| !path.is_empty()).map(arrival).max().unwrap_or(0);
        match self.objective {
            Objective::SumOfCosts => (u64::MAX, slack),
            Objective::Makespan if ours.max(theirs) <= self.bounds.makespan => (self.bounds.makespan, slack),
            Objective::Makespan if ours > theirs => (ours - 1, u64::MAX),
            Objective::Makespan => (theirs, u64::MAX),
        }
    }
}
