//! Droplets one after the other, which negotiate about the cells that their traces would close to others.
//!
//! Where droplets keep out of each other's traces, lists fail: each agent takes its shortest way, and leaves there what closes it to those
//! that come later. Here nobody is closed out at first.
//!
//! Method: the droplets (agents that merge, or come out of one another) do their errands in turn, the first of an order as far as it
//! can. Each way is a cheapest one, on which cells with harmful traces are dear, but open. Each cell at which harm was done gets dearer
//! for everyone, and all ways are planned anew, until none does harm: negotiated congestion (PathFinder: McMurchie and Ebeling, FPGA 1995),
//! with traces in place of wires. In time, each move is made as soon as those that were near its cell before, in this order, have left, so
//! droplets that keep apart do their errands at the same time, and who comes to a cell after whom stays what it was. Then orders in which a
//! droplet has another place, as long as they are no worse.
//!
//! Guaranteed: a plan is legal. Not guaranteed: that one is found, or that it is short: nobody steps aside for a droplet that comes later.
//! Cost: one step of the budget for each [`CELLS_PER_STEP`] cells that the search of a way expands, and for each [`INSTANTS_PER_STEP`]
//! instants of the courses.

use super::super::board::{BoardObjective, CellIndex};
use super::aside::as_replayed;
use super::bound::{self, AssayBounds};
use super::lists::{below, last_done, moved_to};
use super::route::Ahead;
use super::{AgentCourse, AssayPlan, AssayProblem, Errand, SplitErrand, Traces};
use crate::plan::search::Meter;
use crate::random::SplitMix64;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Most rounds of negotiation until an order is given up.
const ROUNDS: usize = 240;

/// Orders that are tried until there is a plan, and then without a better one.
const ORDERS: usize = 500;

/// Most rounds of negotiation of an order that is to be better than a known one.
const ROUNDS_OF_OTHERS: usize = 12;

/// Cells of the search of a way for one step of the budget.
const CELLS_PER_STEP: u64 = 4;

/// Instants of courses for one step of the budget.
const INSTANTS_PER_STEP: u64 = 16;

/// What a step costs,
const STEP_COST: u32 = 2;

/// what one of a wash to a cell about which nobody negotiates, or where nothing is left,
const IDLE_WASH_COST: u32 = 5;

/// what more to a cell with harmful traces,
const HARM_COST: u32 = 120;

/// and what more from then on to a cell at which harm was done.
const TOLL: u32 = 3;

/// One change of an order in this many brings forward the droplet that is done last.
const LAST_IN: usize = 4;

/// Seed of the changes of orders.
const SEED: u64 = 1;

/// The best courses found, if any.
pub(super) fn best(
    problem: &AssayProblem,
    ahead: &Ahead,
    (objective, least): (BoardObjective, &AssayBounds),
    meter: &mut Meter,
) -> Option<Vec<AgentCourse>> {
    let mut negotiation = Negotiation::new(problem, ahead);
    let mut random = SplitMix64::new(SEED);
    let key = |courses: &[AgentCourse]| AssayPlan::costs(courses).key(objective);
    let mut order = negotiation.in_order_of_program();
    let mut best = negotiation.courses(&order, ROUNDS, meter);
    let mut idle = 0;
    while idle < ORDERS && order.len() > 1 && meter.left().steps > 0 {
        if best.as_ref().is_some_and(|best| AssayPlan::is_least(best, objective, least.costs)) {
            break;
        }
        let other = negotiation.changed(&order, best.as_deref().filter(|_| idle % LAST_IN == 0), &mut random);
        idle += 1;
        if best.is_none() {
            negotiation.ways.tolls.fill(0);
        }
        let tolls = negotiation.ways.tolls.clone();
        let rounds = if best.is_some() { ROUNDS_OF_OTHERS } else { ROUNDS };
        let found = negotiation.courses(&other, rounds, meter);
        let keys = [&best, &found].map(|courses| courses.as_ref().map(|courses| key(courses)));
        match keys {
            [Some(_), None] => negotiation.ways.tolls = tolls,
            [Some(known), Some(new)] if new > known => negotiation.ways.tolls = tolls,
            [known, new] => {
                idle = if known == new { idle } else { 0 };
                (best, order) = (found, other);
            }
        }
    }
    best
}

struct Negotiation<'a> {
    problem: &'a AssayProblem<'a>,
    /// By droplet, its agents.
    drops: Vec<Vec<usize>>,
    /// By droplet: those whose errands come before some of its own.
    befores: Vec<Vec<usize>>,
    ways: CheapestWay<'a>,
}

impl<'a> Negotiation<'a> {
    fn new(problem: &'a AssayProblem<'a>, ahead: &'a Ahead) -> Negotiation<'a> {
        let heads = bound::drops(problem);
        let mut drops: Vec<Vec<usize>> = vec![Vec::new(); problem.errands.len()];
        let mut befores = drops.clone();
        for (agent, drop) in heads.iter().enumerate() {
            drops[*drop].push(agent);
            let others = problem.afters[agent].iter().flatten().map(|before| heads[before.agent]);
            befores[*drop].extend(others.filter(|other| other != drop));
        }
        let ways = CheapestWay::new(ahead, problem.instance.board.cells());
        Negotiation { problem, drops, befores, ways }
    }

    /// The droplet of an agent whose course is the longest.
    fn last_done(&self, courses: &[AgentCourse]) -> Option<usize> {
        let last = last_done(courses).pop()?;
        self.drops.iter().position(|agents| agents.contains(&last))
    }

    /// The droplets in the order of their first operations.
    fn in_order_of_program(&self) -> Vec<usize> {
        let first = |drop: &usize| {
            let own = self.drops[*drop].iter().flat_map(|agent| &self.problem.operations[*agent]);
            own.flatten().copied().min().unwrap_or(usize::MAX)
        };
        let mut order: Vec<usize> = (0..self.drops.len()).filter(|drop| !self.drops[*drop].is_empty()).collect();
        order.sort_by_key(first);
        order
    }

    /// An order in which a droplet has another place; that which some courses end with comes earlier.
    fn changed(&self, order: &[usize], ends_with: Option<&[AgentCourse]>, random: &mut SplitMix64) -> Vec<usize> {
        let last = ends_with.and_then(|courses| self.last_done(courses));
        let place = order.iter().position(|drop| Some(*drop) == last);
        let from = place.unwrap_or(below(random, order.len()));
        let to = below(random, place.map_or(order.len(), |place| place + 1));
        moved_to(order, from, to)
    }

    /// An order with each droplet behind those that come before it, as far as that is possible.
    fn sorted(&self, order: &[usize]) -> Vec<usize> {
        let mut sorted = Vec::with_capacity(order.len());
        let mut is_seen = vec![false; self.drops.len()];
        // A droplet is there twice: until those before it are sorted, and then.
        let mut open: Vec<(usize, bool)> = order.iter().rev().map(|drop| (*drop, false)).collect();
        while let Some((drop, is_last)) = open.pop() {
            if is_last {
                sorted.push(drop);
            } else if !std::mem::replace(&mut is_seen[drop], true) {
                open.push((drop, true));
                open.extend(self.befores[drop].iter().rev().map(|before| (*before, false)));
            }
        }
        sorted
    }

    /// Courses that do no harm, with the droplets in an order.
    fn courses(&mut self, order: &[usize], rounds: usize, meter: &mut Meter) -> Option<Vec<AgentCourse>> {
        let order = &self.sorted(order);
        for _ in 0..rounds {
            meter.step()?;
            let mut turns = DropletTurns::new(self.problem);
            let is_done = turns.run(&self.drops, order, &mut self.ways);
            let instants: u64 = turns.courses.iter().map(|course| course.cells.len() as u64).sum();
            meter.charge(std::mem::take(&mut self.ways.steps) + instants / INSTANTS_PER_STEP);
            is_done?;
            if turns.harmed.is_empty() {
                return as_replayed(self.problem, turns.courses);
            }
            turns.harmed.iter().for_each(|cell| self.ways.tolls[*cell as usize] += TOLL);
        }
        None
    }
}

/// From when on a cell is clear of the agent that was near it last, and of all others.
#[derive(Clone, Copy, Default)]
struct ClearFrom {
    last: usize,
    of_last: u32,
    of_others: u32,
}

impl ClearFrom {
    /// The instant from which on the cell is clear of all agents but one.
    fn but(self, agent: usize) -> u32 {
        if self.last == agent { self.of_others } else { self.of_last }
    }

    /// Notes that the cell is clear of an agent from an instant on.
    fn note(&mut self, agent: usize, from: u32) {
        if self.last == agent {
            self.of_last = self.of_last.max(from);
        } else if from >= self.of_last {
            *self = ClearFrom { last: agent, of_last: from, of_others: self.of_last };
        } else {
            self.of_others = self.of_others.max(from);
        }
    }
}

/// The agents while they take turns.
struct DropletTurns<'a> {
    problem: &'a AssayProblem<'a>,
    courses: Vec<AgentCourse>,
    /// By agent, where it is, if it is there.
    stands: Vec<Option<CellIndex>>,
    /// By agent, of the errands done so far.
    done_at: Vec<Vec<u32>>,
    /// By cell.
    clear_from: Vec<ClearFrom>,
    /// By cell, the contents that were left there since it was washed.
    soil: Vec<Vec<usize>>,
    /// The cells at which harm was done.
    harmed: Vec<CellIndex>,
}

impl<'a> DropletTurns<'a> {
    fn new(problem: &'a AssayProblem<'a>) -> DropletTurns<'a> {
        let (count, cells) = (problem.errands.len(), problem.instance.board.cells());
        let mut turns = DropletTurns {
            problem,
            courses: vec![AgentCourse::default(); count],
            stands: vec![None; count],
            done_at: vec![Vec::new(); count],
            clear_from: vec![ClearFrom::default(); cells],
            soil: vec![Vec::new(); cells],
            harmed: Vec::new(),
        };
        for agent in (0..count).filter(|agent| !problem.comes[*agent] && problem.parents[*agent].is_none()) {
            turns.appear(agent, 0);
        }
        turns
    }

    /// All errands in turn, of the droplets in an order; `None` if one cannot be done.
    fn run(&mut self, drops: &[Vec<usize>], order: &[usize], ways: &mut CheapestWay) -> Option<()> {
        let mut operate = |drop: &usize| self.operate(self.next_of(&drops[*drop])?, ways);
        // Whose way is barred waits for those behind it.
        while order.iter().any(|drop| operate(drop).is_some()) {}
        let is_done = |(errands, done): (&Vec<Errand>, &Vec<u32>)| errands.len() == done.len();
        self.problem.errands.iter().zip(&self.done_at).all(is_done).then_some(())
    }

    /// Of some agents the one whose next errand comes first in the program, of those that can be done.
    fn next_of(&self, agents: &[usize]) -> Option<usize> {
        let operation = |agent: &&usize| {
            let own = &self.problem.operations[**agent];
            own[self.done_at[**agent].len()..].iter().flatten().next().copied().unwrap_or(usize::MAX)
        };
        agents.iter().filter(|agent| self.is_due(**agent)).min_by_key(operation).copied()
    }

    fn is_due(&self, agent: usize) -> bool {
        let Some(errand) = self.errand(agent).filter(|_| self.may_begin(agent)) else { return false };
        errand.meets.is_none_or(|other| {
            self.errand(other).is_some_and(|theirs| theirs.meets == Some(agent)) && self.may_begin(other)
        })
    }

    /// The next errand of an agent.
    fn errand(&self, agent: usize) -> Option<Errand> {
        self.problem.errands[agent].get(self.done_at[agent].len()).copied()
    }

    /// Whether an agent is there, or comes with its next errand, and all is done that this one comes after.
    fn may_begin(&self, agent: usize) -> bool {
        let next = self.done_at[agent].len();
        let is_there = self.stands[agent].is_some() || (self.problem.comes[agent] && next == 0);
        let afters = self.problem.afters[agent].get(next).into_iter().flatten();
        is_there && afters.into_iter().all(|before| before.errand < self.done_at[before.agent].len())
    }

    /// The instant at which all is done that the next errand of an agent comes after.
    fn begins(&self, agent: usize) -> u32 {
        let afters = self.problem.afters[agent].get(self.done_at[agent].len()).into_iter().flatten();
        afters.map(|before| self.done_at[before.agent][before.errand]).max().unwrap_or(0)
    }

    /// The last instant of an agent's course so far.
    fn now(&self, agent: usize) -> u32 {
        self.courses[agent].until() - 1
    }

    fn operate(&mut self, agent: usize, ways: &mut CheapestWay) -> Option<()> {
        let errand = self.errand(agent)?;
        let begins = self.begins(agent);
        if let Some(split) = errand.splits {
            return self.split(agent, (errand, split), begins);
        }
        if let Some(other) = errand.meets {
            return self.merge([agent, other], errand.stop, ways);
        }
        if let Some(around) = errand.mixes {
            let board = &self.problem.instance.board;
            let is_open = |cell: &CellIndex| self.is_clear(*cell, agent) && !board.is_blocked(*cell);
            self.problem.loops[around].iter().all(is_open).then_some(())?;
        }
        if self.stands[agent].is_none() {
            self.is_clear(errand.stop, agent).then_some(())?;
            self.appear(agent, begins.max(self.free_from(errand.stop, agent)));
        }
        self.travel(agent, errand.stop, None, ways)?;
        match errand.mixes {
            Some(around) => self.mix(agent, (around, errand.stay), begins),
            None => self.rest(agent, self.now(agent).max(begins) + errand.stay),
        }
        self.note_done(agent);
        Some(())
    }

    /// An agent comes to its start.
    fn appear(&mut self, agent: usize, since: u32) {
        let start = self.problem.instance.agents[agent].start;
        self.courses[agent] = AgentCourse { since, cells: vec![start] };
        self.stands[agent] = Some(start);
        self.touch(agent, start, 0);
    }

    /// An agent stays where it is until an instant.
    fn rest(&mut self, agent: usize, until: u32) {
        let Some(here) = self.stands[agent] else { return };
        let course = &mut self.courses[agent];
        let count = (until + 1).saturating_sub(course.since) as usize;
        course.cells.resize(count.max(course.cells.len()), here);
    }

    /// An agent comes to a cell at an instant.
    fn step(&mut self, agent: usize, cell: CellIndex, at: u32) {
        self.rest(agent, at - 1);
        self.leave(agent, at);
        self.courses[agent].cells.push(cell);
        self.stands[agent] = Some(cell);
    }

    /// An agent is no longer where it is from an instant on.
    fn leave(&mut self, agent: usize, at: u32) {
        let Some(cell) = self.stands[agent].take() else { return };
        let instance = self.problem.instance;
        for near in instance.board.around(cell, instance.separation) {
            self.clear_from[near as usize].note(agent, at + 1);
        }
    }

    /// The instant from which on a cell is clear of all others that were near it.
    fn free_from(&self, cell: CellIndex, agent: usize) -> u32 {
        self.clear_from[cell as usize].but(agent)
    }

    /// Whether a cell is clear of all agents that are there but one.
    fn is_clear(&self, cell: CellIndex, but: usize) -> bool {
        let instance = self.problem.instance;
        let is_apart = |at: &CellIndex| instance.board.apart(*at, cell) >= instance.separation;
        (0..self.stands.len()).filter(|agent| *agent != but).all(|agent| self.stands[agent].iter().all(is_apart))
    }

    /// What an agent contains after some errands more, where traces matter.
    fn content(&self, agent: usize, more: usize) -> Option<(&'a Traces, usize)> {
        let traces = self.problem.traces.as_ref()?;
        Some((traces, traces.contents[agent][self.done_at[agent].len() + more]))
    }

    /// Whether what an agent contains after some errands more comes to harm on a cell.
    fn is_harmful(&self, agent: usize, cell: CellIndex, more: usize) -> bool {
        self.content(agent, more)
            .is_some_and(|(traces, content)| self.soil[cell as usize].iter().any(|left| traces.harms[*left][content]))
    }

    /// Whether an agent takes away what others left.
    fn washes(&self, agent: usize) -> bool {
        self.content(agent, 0).is_some_and(|(traces, content)| traces.washes[content])
    }

    /// Notes what an agent does and leaves on a cell, with what it contains after some errands more.
    fn touch(&mut self, agent: usize, cell: CellIndex, more: usize) {
        let Some((traces, content)) = self.content(agent, more) else { return };
        if self.is_harmful(agent, cell, more) {
            self.harmed.push(cell);
        }
        let soil = &mut self.soil[cell as usize];
        if traces.washes[content] {
            soil.clear();
        } else if !soil.contains(&content) {
            soil.push(content);
        }
    }

    /// An agent goes to a cell; where another one waits for it there, the cells near it are free for it from an instant on.
    fn travel(
        &mut self,
        agent: usize,
        to: CellIndex,
        waits: Option<(usize, u32)>,
        ways: &mut CheapestWay,
    ) -> Option<()> {
        let instance = self.problem.instance;
        let query = WayQuery { agent, to, waits: waits.map(|(other, _)| other) };
        for cell in ways.cheapest(self, query)? {
            let is_near = instance.board.apart(cell, to) < instance.separation;
            let near_from = waits.filter(|_| is_near).map_or(0, |(_, from)| from);
            self.step(agent, cell, (self.now(agent) + 1).max(self.free_from(cell, agent)).max(near_from));
            // Who comes to another one is there as both together.
            self.touch(agent, cell, usize::from(waits.is_some() && cell == to));
        }
        Some(())
    }

    /// Two agents merge at a cell: one of them waits there for the other.
    fn merge(&mut self, both: [usize; 2], stop: CellIndex, ways: &mut CheapestWay) -> Option<()> {
        let begins = both.map(|agent| self.begins(agent)).into_iter().fold(0, u32::max);
        let [first, second] = if self.stands[both[1]] == Some(stop) { [both[1], both[0]] } else { both };
        let [waits, comes] = match self.travel(first, stop, None, ways) {
            Some(()) => [first, second],
            None => {
                self.travel(second, stop, None, ways)?;
                [second, first]
            }
        };
        self.travel(comes, stop, Some((waits, self.now(waits).max(begins) + 1)), ways)?;
        let at = both.map(|agent| self.now(agent)).into_iter().fold(begins, u32::max);
        both.iter().for_each(|agent| self.rest(*agent, at));
        both.iter().for_each(|agent| self.note_done(*agent));
        for agent in both {
            if self.stands[agent].is_some() {
                self.touch(agent, stop, 0);
            }
        }
        Some(())
    }

    /// An agent goes round its loop for some steps.
    fn mix(&mut self, agent: usize, (around, steps): (usize, u32), begins: u32) {
        let around = &self.problem.loops[around];
        let cell = |step: u32| around[step as usize % around.len()];
        let earliest = |step: u32| self.free_from(cell(step), agent).saturating_sub(step);
        let first_round = 1..=steps.min(around.len() as u32);
        let begins = first_round.map(earliest).max().unwrap_or(0).max(begins).max(self.now(agent));
        for step in 1..=steps {
            self.step(agent, cell(step), begins + step);
            self.touch(agent, cell(step), 0);
        }
    }

    /// An agent is pulled apart.
    fn split(&mut self, agent: usize, (errand, split): (Errand, SplitErrand), begins: u32) -> Option<()> {
        let cells = [errand.stop, self.problem.instance.agents[split.child].start];
        cells.iter().all(|cell| self.is_clear(*cell, agent)).then_some(())?;
        let free = cells.map(|cell| self.free_from(cell, agent)).into_iter().fold(0, u32::max);
        let at = (self.now(agent).max(begins) + 1).max(free);
        self.step(agent, errand.stop, at);
        self.note_done(agent);
        self.touch(agent, errand.stop, 0);
        self.appear(split.child, at);
        Some(())
    }

    /// The next errand of an agent is done at the end of its course so far.
    fn note_done(&mut self, agent: usize) {
        let at = self.now(agent);
        self.done_at[agent].push(at);
        if self.problem.is_gone[agent] && self.errand(agent).is_none() {
            self.leave(agent, at);
        }
    }
}

/// From where an agent is, to where.
#[derive(Clone, Copy)]
struct WayQuery {
    agent: usize,
    to: CellIndex,
    /// Who waits for it there.
    waits: Option<usize>,
}

/// The search of a cheapest way, with buffers that consecutive searches reuse.
struct CheapestWay<'a> {
    ahead: &'a Ahead,
    /// By cell: what a step to it costs beyond the usual.
    tolls: Vec<u32>,
    /// Steps of the budget that were taken and not charged yet.
    steps: u64,
    /// By cell: its least cost so far, and the cell before it.
    costs: Vec<(u32, CellIndex)>,
    is_taken: Vec<bool>,
    /// By least cost of the whole way, the longer part of it first.
    open: BinaryHeap<Reverse<(u32, Reverse<u32>, CellIndex)>>,
}

impl CheapestWay<'_> {
    fn new(ahead: &Ahead, cells: usize) -> CheapestWay<'_> {
        let (tolls, costs, is_taken) = (vec![0; cells], vec![(u32::MAX, 0); cells], vec![false; cells]);
        CheapestWay { ahead, tolls, steps: 0, costs, is_taken, open: BinaryHeap::new() }
    }

    /// The cells of a cheapest way round those that are there, after the first one; `None` if there is none.
    fn cheapest(&mut self, turns: &DropletTurns, query: WayQuery) -> Option<Vec<CellIndex>> {
        let from = turns.stands[query.agent]?;
        let instance = turns.problem.instance;
        self.costs.fill((u32::MAX, 0));
        self.is_taken.fill(false);
        self.open.clear();
        let others = (0..turns.stands.len()).filter(|other| *other != query.agent && Some(*other) != query.waits);
        for cell in others.filter_map(|other| turns.stands[other]) {
            for near in instance.board.around(cell, instance.separation) {
                self.is_taken[near as usize] = true;
            }
        }
        self.costs[from as usize] = (0, from);
        let mut expanded = 0;
        let washes = turns.washes(query.agent);
        let errand = turns.done_at[query.agent].len();
        let ahead = |cell: CellIndex| self.ahead.steps(query.agent, errand, cell).saturating_mul(STEP_COST);
        self.open.push(Reverse((0, Reverse(0), from)));
        while let Some(Reverse((_, Reverse(cost), cell))) = self.open.pop() {
            if cost > self.costs[cell as usize].0 {
                continue;
            }
            if cell == query.to {
                break;
            }
            expanded += 1;
            for next in instance.board.neighbours(cell).filter(|next| !self.is_taken[*next as usize]) {
                let more = usize::from(query.waits.is_some() && next == query.to);
                let toll = self.tolls[next as usize];
                let cost = cost
                    + match washes {
                        // A wash goes where it is of use.
                        true if toll > 0 && !turns.soil[next as usize].is_empty() => STEP_COST,
                        true => IDLE_WASH_COST,
                        false if turns.is_harmful(query.agent, next, more) => STEP_COST + toll + HARM_COST,
                        false => STEP_COST + toll,
                    };
                if cost < self.costs[next as usize].0 {
                    self.costs[next as usize] = (cost, cell);
                    self.open.push(Reverse((cost.saturating_add(ahead(next)), Reverse(cost), next)));
                }
            }
        }
        self.steps += expanded / CELLS_PER_STEP;
        self.way(from, query.to)
    }

    /// The way that was found; `None` if its end was not reached.
    fn way(&self, from: CellIndex, mut cell: CellIndex) -> Option<Vec<CellIndex>> {
        let mut way = Vec::new();
        if self.costs[cell as usize].0 == u32::MAX {
            return None;
        }
        while cell != from {
            way.push(cell);
            cell = self.costs[cell as usize].1;
        }
        way.reverse();
        Some(way)
    }
}
