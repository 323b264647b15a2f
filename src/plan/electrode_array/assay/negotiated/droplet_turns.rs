//! Agents move one after the other to their errands. Each enters a cell as soon as the agents that were near it before
//! have left, by a cheapest path, on which contamination and waiting have a price.

use crate::plan::electrode_array::assay::route::StopDistances;
use crate::plan::electrode_array::assay::{AgentCourse, AssayProblem, Errand, ErrandPlace, SplitErrand, Traces};
use crate::plan::electrode_array::board::CellIndex;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Cells expanded by the path search for one step of the budget.
pub(super) const CELLS_PER_STEP: u64 = 4;

/// Cost of a step.
const STEP_COST: u32 = 2;

/// Cost of a step of a wash to a cell without toll or without traces.
const IDLE_WASH_COST: u32 = 5;

/// Extra cost of a step to a cell with harmful traces.
const HARM_COST: u32 = 120;

/// Cost of waiting as long as the lower bound on the makespan. It exceeds that of one contamination, so that an agent
/// takes a detour rather than wait long for a cell, however long the stays are.
const WAIT_COST: u64 = 200;

/// The instants from which a cell is clear: of the agent that left it last, and of all others.
#[derive(Clone, Copy, Default)]
struct ClearFrom {
    last: usize,
    of_last: u32,
    of_others: u32,
}

impl ClearFrom {
    /// The instant from which the cell is clear of all agents except one.
    fn but(self, agent: usize) -> u32 {
        if self.last == agent { self.of_others } else { self.of_last }
    }

    /// Records that the cell is clear of an agent from an instant on.
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

/// State of the agents while they take turns.
pub(super) struct DropletTurns<'a> {
    problem: &'a AssayProblem<'a>,
    pub(super) courses: Vec<AgentCourse>,
    /// By agent, its cell; `None` while it is not on the board.
    stands: Vec<Option<CellIndex>>,
    /// By agent, the instants at which its errands so far were done.
    done_at: Vec<Vec<u32>>,
    /// By cell.
    clear_from: Vec<ClearFrom>,
    /// By cell, the contents left there since its last wash.
    soil: Vec<Vec<usize>>,
    /// The cells where contamination occurred, possibly repeated.
    pub(super) harmed: Vec<CellIndex>,
}

impl<'a> DropletTurns<'a> {
    pub(super) fn new(problem: &'a AssayProblem<'a>) -> DropletTurns<'a> {
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
        for agent in (0..count).filter(|agent| !problem.enters[*agent] && problem.parents[*agent].is_none()) {
            turns.appear(agent, 0);
        }
        turns
    }

    /// Does all errands in an order; `None` if one cannot be done.
    pub(super) fn run(&mut self, order: &[ErrandPlace], ways: &mut CheapestWay) -> Option<()> {
        let mut open = order.to_vec();
        // An errand whose path is blocked waits for later ones.
        while let Some(done) =
            open.iter().position(|place| self.is_next(*place) && self.operate(place.agent, ways).is_some())
        {
            open.remove(done);
            open.retain(|place| self.done_at[place.agent].len() <= place.errand);
        }
        open.is_empty().then_some(())
    }

    /// Whether an errand is its agent's next one, and can be done.
    fn is_next(&self, place: ErrandPlace) -> bool {
        self.done_at[place.agent].len() == place.errand && self.is_due(place.agent)
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

    /// Whether an agent is on the board, or enters with its next errand, and all predecessors of that are done.
    fn may_begin(&self, agent: usize) -> bool {
        let next = self.done_at[agent].len();
        let is_there = self.stands[agent].is_some() || (self.problem.enters[agent] && next == 0);
        let afters = self.problem.afters[agent].get(next).into_iter().flatten();
        is_there && afters.into_iter().all(|before| before.errand < self.done_at[before.agent].len())
    }

    /// The instant at which all predecessors of an agent's next errand are done.
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
            return self.split(agent, errand, split, begins);
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
            Some(around) => self.mix(agent, around, errand.stay, begins),
            None => self.rest(agent, self.now(agent).max(begins) + errand.stay),
        }
        self.note_done(agent);
        Some(())
    }

    /// Puts an agent at its start.
    fn appear(&mut self, agent: usize, since: u32) {
        let start = self.problem.instance.agents[agent].start;
        self.courses[agent] = AgentCourse { since, cells: vec![start] };
        self.stands[agent] = Some(start);
        self.touch(agent, start, 0);
    }

    /// Keeps an agent where it is until an instant.
    fn rest(&mut self, agent: usize, until: u32) {
        let Some(here) = self.stands[agent] else { return };
        let course = &mut self.courses[agent];
        let count = (until + 1).saturating_sub(course.since) as usize;
        course.cells.resize(count.max(course.cells.len()), here);
    }

    /// Moves an agent to a cell, where it arrives at an instant.
    fn step(&mut self, agent: usize, cell: CellIndex, at: u32) {
        self.rest(agent, at - 1);
        self.leave(agent, at);
        self.courses[agent].cells.push(cell);
        self.stands[agent] = Some(cell);
    }

    /// Takes an agent off its cell from an instant on.
    fn leave(&mut self, agent: usize, at: u32) {
        let Some(cell) = self.stands[agent].take() else { return };
        let instance = self.problem.instance;
        for near in instance.board.around(cell, instance.separation) {
            self.clear_from[near as usize].note(agent, at + 1);
        }
    }

    /// The instant from which a cell is clear of all other agents that were near it.
    fn free_from(&self, cell: CellIndex, agent: usize) -> u32 {
        self.clear_from[cell as usize].but(agent)
    }

    /// Whether a cell is clear of the current positions of all agents except one.
    fn is_clear(&self, cell: CellIndex, but: usize) -> bool {
        let instance = self.problem.instance;
        let is_apart = |at: &CellIndex| instance.board.apart(*at, cell) >= instance.separation;
        (0..self.stands.len()).filter(|agent| *agent != but).all(|agent| self.stands[agent].iter().all(is_apart))
    }

    /// The contents of an agent after `more` further errands, where traces matter.
    fn content(&self, agent: usize, more: usize) -> Option<(&'a Traces, usize)> {
        let traces = self.problem.traces.as_ref()?;
        Some((traces, traces.contents[agent][self.done_at[agent].len() + more]))
    }

    /// Whether an agent, with its contents after `more` further errands, is contaminated on a cell.
    fn is_harmful(&self, agent: usize, cell: CellIndex, more: usize) -> bool {
        self.content(agent, more)
            .is_some_and(|(traces, content)| self.soil[cell as usize].iter().any(|left| traces.harms[*left][content]))
    }

    /// Whether an agent is a wash, which removes traces.
    fn washes(&self, agent: usize) -> bool {
        self.content(agent, 0).is_some_and(|(traces, content)| traces.washes[content])
    }

    /// Records the trace of an agent on a cell, and any contamination, with its contents after `more` further errands.
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

    /// Moves an agent to a cell. If another one waits for it there (`waits`), it enters the cells near it no earlier
    /// than the given instant.
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
            // At the meeting itself it has the merged contents.
            self.touch(agent, cell, usize::from(waits.is_some() && cell == to));
        }
        Some(())
    }

    /// Merges two agents at a cell: one waits there for the other.
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

    /// Moves an agent round its loop for some steps.
    fn mix(&mut self, agent: usize, around: usize, steps: u32, begins: u32) {
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

    /// Splits an agent.
    fn split(&mut self, agent: usize, errand: Errand, split: SplitErrand, begins: u32) -> Option<()> {
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

    /// Records that the next errand of an agent is done at the end of its course so far.
    fn note_done(&mut self, agent: usize) {
        let at = self.now(agent);
        self.done_at[agent].push(at);
        if self.problem.is_gone[agent] && self.errand(agent).is_none() {
            self.leave(agent, at);
        }
    }
}

/// Query for a path from an agent's cell to a stop.
#[derive(Clone, Copy)]
struct WayQuery {
    agent: usize,
    to: CellIndex,
    /// The agent that waits for it there.
    waits: Option<usize>,
}

/// Cheapest-path search, with buffers that consecutive searches reuse.
pub(super) struct CheapestWay<'a> {
    ahead: &'a StopDistances,
    /// Lower bound on the makespan of every plan, at least 1.
    least: u64,
    /// By cell: extra cost of a step to it.
    pub(super) tolls: Vec<u32>,
    /// Budget steps taken but not charged yet.
    pub(super) steps: u64,
    /// By cell: its least cost so far, and the cell before it.
    costs: Vec<(u32, CellIndex)>,
    /// By cell: the instant at which the agent arrives there on that path.
    arrivals: Vec<u32>,
    is_taken: Vec<bool>,
    /// By estimated cost of the whole path; of equal ones, that with the greater cost so far comes first.
    open: BinaryHeap<Reverse<(u32, Reverse<u32>, CellIndex)>>,
}

impl CheapestWay<'_> {
    pub(super) fn new(ahead: &StopDistances, least: u64, cells: usize) -> CheapestWay<'_> {
        CheapestWay {
            ahead,
            least: least.max(1),
            tolls: vec![0; cells],
            steps: 0,
            costs: vec![(u32::MAX, 0); cells],
            arrivals: vec![0; cells],
            is_taken: vec![false; cells],
            open: BinaryHeap::new(),
        }
    }

    /// The cells of a cheapest path around the other agents' current cells, without the first one; `None` if there is
    /// none.
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
        self.arrivals[from as usize] = turns.now(query.agent);
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
                let arrival = (self.arrivals[cell as usize] + 1).max(turns.free_from(next, query.agent));
                let waited = arrival - self.arrivals[cell as usize] - 1;
                let cost = cost
                    + u32::try_from(u64::from(waited) * WAIT_COST / self.least).unwrap_or(HARM_COST)
                    + match washes {
                        // A wash prefers cells that need it.
                        true if toll > 0 && !turns.soil[next as usize].is_empty() => STEP_COST,
                        true => IDLE_WASH_COST,
                        false if turns.is_harmful(query.agent, next, more) => STEP_COST + toll + HARM_COST,
                        false => STEP_COST + toll,
                    };
                if cost < self.costs[next as usize].0 {
                    self.costs[next as usize] = (cost, cell);
                    self.arrivals[next as usize] = arrival;
                    self.open.push(Reverse((cost.saturating_add(ahead(next)), Reverse(cost), next)));
                }
            }
        }
        self.steps += expanded / CELLS_PER_STEP;
        self.way(from, query.to)
    }

    /// The path found; `None` if the search did not reach its end.
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
