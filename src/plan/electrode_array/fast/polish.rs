//! Improves a legal plan until its bounds are met or the budget is spent.
//!
//! Method: large-neighbourhood search (MAPF-LNS: Li and others, IJCAI 2021): remove the paths of a few agents, replan them one
//! after the other in a random order among the rest, and keep a result that is not worse. Three ways to choose the few, weighted by
//! their recent gains: a late agent with those that block it, agents that meet at one place, and random ones. Guaranteed: the plan
//! stays legal and never gets worse; it is optimal where it meets the bounds. Not guaranteed: an optimum within any budget. Cost:
//! one search for each agent of a neighbourhood ([`SIZES`]).

use super::ImprovementAim;
use super::planned_instance::{PathTerms, PlannedInstance};
use super::reservations::Others;
use crate::plan::electrode_array::board::{BoardCosts, BoardObjective, CellIndex, Paths};
use crate::plan::search::Meter;
use crate::random::SplitMix64;

/// The sizes of neighbourhoods.
const SIZES: [usize; 6] = [1, 2, 3, 4, 5, 8];

/// Sort key of a plan under an aim: makespan, sum of excess arrival times, sum of costs; or sum of costs, makespan; or
/// sum of squared excess arrival times, makespan, sum of costs.
type PlanKey = (u64, u64, u64);

/// The ways to choose a neighbourhood.
#[derive(Debug, Clone, Copy)]
enum NeighbourhoodChoice {
    /// A late agent and those that block it.
    Blockers,
    /// Agents that pass one place.
    Crossing,
    Random,
}

const CHOICES: [NeighbourhoodChoice; 3] =
    [NeighbourhoodChoice::Blockers, NeighbourhoodChoice::Crossing, NeighbourhoodChoice::Random];

/// What the replanned agents may spend, so that the plan does not get worse.
struct Allowance {
    /// Latest arrival of each of them.
    limit: u64,
    /// Their delays together.
    delay: u64,
    /// The squares of their excess arrival times together.
    lateness: u64,
}

/// Adaptive choice among options, weighted by their recent gains per step.
#[derive(Debug)]
struct AdaptiveWeights<const N: usize>([u64; N]);

impl<const N: usize> AdaptiveWeights<N> {
    /// Credit of a gain at no cost.
    const MOST: u64 = 1 << 20;
    /// Least weight of an option, as a share of [`Self::MOST`], so that each is tried now and then.
    const LEAST: u64 = Self::MOST >> 12;
    /// Number of steps that halves the credit of a gain.
    const HALVE: u64 = 64;

    fn pick(&self, random: &mut SplitMix64) -> usize {
        let mut left = random.below(self.0.iter().sum::<u64>() as usize) as u64;
        for (option, weight) in self.0.iter().enumerate() {
            if left < *weight {
                return option;
            }
            left -= weight;
        }
        0
    }

    fn learn(&mut self, option: usize, gained: bool, steps: u64) {
        let credit = if gained { Self::MOST * Self::HALVE / (Self::HALVE + steps) } else { 0 };
        let weight = &mut self.0[option];
        *weight = (*weight * 31 / 32 + credit / 32).max(Self::LEAST);
    }
}

/// Initial weight of each option.
const EVEN: u64 = 1 << 14;

struct Polish<'c, 'a> {
    planned: &'c mut PlannedInstance<'a>,
    paths: Paths,
    aim: ImprovementAim,
    bounds: BoardCosts,
    choices: AdaptiveWeights<{ CHOICES.len() }>,
    sizes: AdaptiveWeights<{ SIZES.len() }>,
    /// Agent whose turn as the late one is next.
    turn: usize,
}

/// Improves a plan; `bounds` are those of the agents alone.
pub(super) fn polish(
    planned: &mut PlannedInstance,
    paths: Paths,
    aim: ImprovementAim,
    bounds: BoardCosts,
    meter: &mut Meter,
) -> Paths {
    planned.enter_all(&paths);
    let mut state = Polish {
        planned,
        paths: paths.clone(),
        aim,
        bounds,
        choices: AdaptiveWeights([EVEN; CHOICES.len()]),
        sizes: AdaptiveWeights([EVEN; SIZES.len()]),
        turn: 0,
    };
    while state.is_open() && meter.step().is_some() {
        state.round(meter);
    }
    // A smaller excess may have cost more in the sum of costs than the last arrival has gained, and a smaller sum of
    // squares may have made the last arrival later.
    let objective = aim.final_objective();
    let worse = BoardCosts::of(&state.paths).key(objective) > BoardCosts::of(&paths).key(objective);
    if worse { paths } else { state.paths }
}

impl Polish<'_, '_> {
    fn is_open(&self) -> bool {
        BoardCosts::of(&self.paths) != self.bounds
    }

    fn arrival(&self, agent: usize) -> u64 {
        self.paths[agent].len() as u64 - 1
    }

    fn delay(&self, agent: usize) -> u64 {
        self.arrival(agent) - u64::from(self.planned.least[agent])
    }

    /// Arrival time beyond the bound on the makespan.
    fn excess(&self, arrival: u64) -> u64 {
        arrival.saturating_sub(self.bounds.makespan)
    }

    fn key(&self) -> PlanKey {
        let costs = BoardCosts::of(&self.paths);
        let excesses = (0..self.paths.len()).map(|agent| self.excess(self.arrival(agent)));
        match self.aim {
            ImprovementAim::Costs(BoardObjective::Makespan) => (costs.makespan, excesses.sum(), costs.sum_of_costs),
            ImprovementAim::Costs(BoardObjective::SumOfCosts) => (costs.sum_of_costs, costs.makespan, 0),
            ImprovementAim::LateArrivals => {
                (excesses.map(|excess| excess * excess).sum(), costs.makespan, costs.sum_of_costs)
            }
        }
    }

    /// Replans one neighbourhood.
    fn round(&mut self, meter: &mut Meter) {
        let pick = self.choices.pick(&mut self.planned.random);
        let pick_size = self.sizes.pick(&mut self.planned.random);
        let size = SIZES[pick_size];
        let chosen = match CHOICES[pick] {
            NeighbourhoodChoice::Blockers => self.blockers(size, meter),
            NeighbourhoodChoice::Crossing => self.crossing(size),
            NeighbourhoodChoice::Random => self.any(size),
        };
        let (before, spent) = (self.key(), meter.spent());
        let gained = self.again(&chosen, before, meter);
        let steps = meter.spent() - spent;
        self.choices.learn(pick, gained, steps);
        self.sizes.learn(pick_size, gained, steps);
    }

    /// A late agent, in turn. If the makespan is minimised and above its bound, half of the time one that arrives last.
    fn late(&mut self) -> usize {
        let count = self.planned.count();
        let makespan = BoardCosts::of(&self.paths).makespan;
        let too_long = self.aim.final_objective() == BoardObjective::Makespan && makespan > self.bounds.makespan;
        let last_ones = too_long && self.planned.random.below(2) == 0;
        for step in 1..=count {
            let agent = (self.turn + step) % count;
            if (last_ones && self.arrival(agent) == makespan) || (!last_ones && self.delay(agent) > 0) {
                self.turn = agent;
                return agent;
            }
        }
        self.planned.random.below(count)
    }

    fn blockers(&mut self, size: usize, meter: &mut Meter) -> Vec<usize> {
        let agent = self.late();
        let way = self.planned.alone(agent, meter);
        let mut others = self.planned.conflicts(agent, &way);
        self.planned.random.shuffle(&mut others);
        let mut chosen = vec![agent];
        chosen.extend(others.into_iter().take(size - 1));
        self.fill(chosen, size.min(2))
    }

    fn crossing(&mut self, size: usize) -> Vec<usize> {
        let agent = self.late();
        let path = &self.paths[agent];
        let cell = path[self.planned.random.below(path.len())];
        let mut others: Vec<usize> = self.planned.table.visitors(cell).filter(|other| *other != agent).collect();
        others.sort_unstable();
        others.dedup();
        self.planned.random.shuffle(&mut others);
        let mut chosen = vec![agent];
        chosen.extend(others.into_iter().take(size - 1));
        self.fill(chosen, size.min(2))
    }

    fn any(&mut self, size: usize) -> Vec<usize> {
        self.fill(Vec::new(), size)
    }

    /// Fills the neighbourhood to a size with random agents.
    fn fill(&mut self, mut chosen: Vec<usize>, size: usize) -> Vec<usize> {
        let size = size.min(self.planned.count());
        while chosen.len() < size {
            let agent = self.planned.random.below(self.planned.count());
            if !chosen.contains(&agent) {
                chosen.push(agent);
            }
        }
        chosen
    }

    /// Replans the chosen agents and keeps a result that is not worse; returns whether it is better.
    fn again(&mut self, chosen: &[usize], before: PlanKey, meter: &mut Meter) -> bool {
        for agent in chosen {
            self.planned.table.hide(*agent);
        }
        let mut order = chosen.to_vec();
        self.planned.random.shuffle(&mut order);
        let mut found = self.place(&order, meter);
        if found.len() == order.len() {
            self.swap(&order, &mut found);
            let after = self.key();
            if after <= before {
                self.accept(&order, &found);
                return after < before;
            }
            self.swap(&order, &mut found);
        }
        for (turn, agent) in order.iter().enumerate() {
            let instead = found.get(turn).filter(|_| turn + 1 < order.len());
            self.planned.table.reject(*agent, instead.map(Vec::as_slice));
        }
        false
    }

    fn swap(&mut self, order: &[usize], found: &mut [Vec<CellIndex>]) {
        for (agent, path) in order.iter().zip(found) {
            std::mem::swap(&mut self.paths[*agent], path);
        }
    }

    /// Updates the table to the new paths; that of the last agent in the order is not in it yet.
    fn accept(&mut self, order: &[usize], old: &[Vec<CellIndex>]) {
        if let Some(last) = order.last() {
            self.planned.table.add_instead(*last, &self.paths[*last]);
        }
        for (agent, path) in order.iter().zip(old) {
            self.planned.table.accept(*agent, path);
        }
    }

    /// Plans agents in an order, up to the first one without an acceptable path; all but the last of the order are
    /// entered in the table.
    fn place(&mut self, order: &[usize], meter: &mut Meter) -> Vec<Vec<CellIndex>> {
        let mut allowance = self.allowance(order);
        let mut found = Vec::with_capacity(order.len());
        for (turn, agent) in order.iter().enumerate() {
            let least = u64::from(self.planned.least[*agent]);
            // A path that arrives later than these would make the plan worse, whatever the rest of the chosen agents do.
            let in_delay = least.saturating_add(allowance.delay);
            let in_lateness = self.bounds.makespan.saturating_add(allowance.lateness.isqrt());
            let limit = allowance.limit.min(in_delay).min(in_lateness).min(u64::from(u32::MAX));
            let terms =
                PathTerms { others: Others::Hard, weight: 0, haste: 0, limit: limit as u32, delay: 0, detour: None };
            let Some(path) = self.planned.plan(*agent, terms, meter) else { break };
            let arrival = path.len() as u64 - 1;
            allowance.delay -= (arrival - least).min(allowance.delay);
            allowance.lateness -= self.excess(arrival).pow(2).min(allowance.lateness);
            if turn + 1 < order.len() {
                self.planned.table.add_instead(*agent, &path);
            }
            found.push(path);
        }
        found
    }

    fn allowance(&self, chosen: &[usize]) -> Allowance {
        let unlimited = Allowance { limit: u64::MAX, delay: u64::MAX, lateness: u64::MAX };
        let delay = chosen.iter().map(|agent| self.delay(*agent)).sum();
        let ours = chosen.iter().map(|agent| self.arrival(*agent)).max().unwrap_or(0);
        let rest = (0..self.planned.count()).filter(|agent| !chosen.contains(agent));
        let theirs = rest.map(|agent| self.arrival(agent)).max().unwrap_or(0);
        let is_met = ours.max(theirs) <= self.bounds.makespan;
        // With the makespan at its bound, only the sum of costs can improve. Above it, the latest arrival counts first:
        // if it is among the chosen agents, they must all arrive earlier; otherwise they may arrive as late as the
        // others. Where all late arrivals count, one agent may arrive later if others arrive so much earlier.
        match self.aim {
            ImprovementAim::Costs(BoardObjective::SumOfCosts) => Allowance { delay, ..unlimited },
            ImprovementAim::Costs(BoardObjective::Makespan) | ImprovementAim::LateArrivals if is_met => {
                Allowance { limit: self.bounds.makespan, delay, ..unlimited }
            }
            ImprovementAim::Costs(BoardObjective::Makespan) if ours > theirs => {
                Allowance { limit: ours - 1, ..unlimited }
            }
            ImprovementAim::Costs(BoardObjective::Makespan) => Allowance { limit: theirs, ..unlimited },
            ImprovementAim::LateArrivals => {
                let lateness = chosen.iter().map(|agent| self.excess(self.arrival(*agent)).pow(2)).sum();
                Allowance { lateness, ..unlimited }
            }
        }
    }
}
