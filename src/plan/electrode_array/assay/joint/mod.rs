//! Joint search for all agents of a small assay, used where lists yield no plan or one that may not be the shortest.
//!
//! Method: A* over the joint positions of all agents, with the errands done, one step of the board at a time. For the
//! fewest steps, the heuristic is the longest remaining time of any agent. For the least sum of costs, each agent costs
//! 1 per step until it settles: it then moves no more, which it may do as soon as all its remaining work is at its
//! cell; the heuristic is the sum of the agents' remaining steps until then. Only traces that may still contaminate an
//! agent are kept, and positions with fewer traces dominate those with more. Guaranteed: a plan is legal and has the
//! least cost; "impossible" is returned only after all positions have been visited, with the cells that they reach; the
//! bound of a search that gave up holds. Cost: one step of the budget for each joint position generated; at most about
//! [`MAX_POSITIONS`] are kept.

mod positions;
mod stands;

use super::route::StopDistances;
use super::{AgentCourse, AssayProblem, ErrandLag, SplitErrand};
use crate::plan::electrode_array::board::{BoardObjective, CellIndex, MetCells};
use crate::plan::electrode_array::channels::broadcast::{AgentStep, PulledStep, SharedChannels};
use crate::plan::electrode_array::fast::UNREACHABLE;
use crate::plan::search::{Meter, SearchAnswer};
use positions::{IDLE, JointPosition, JointStandings, KnownPositions, LeftTraces, harmful};
use stands::{AgentStand, JointStand, at_start, due, is_done, may_begin, meeting, settle, start};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Most agents of an assay that is searched; more have too many joint positions.
const MAX_AGENTS: usize = 5;

/// Number of joint positions kept after which the search gives up.
const MAX_POSITIONS: usize = 400_000;

/// The cells that each agent has reached, ascending.
pub(super) type AgentCells = Vec<Vec<CellIndex>>;

/// A joint position with its predecessor.
struct JointNode {
    position: JointPosition,
    instant: u32,
    /// Cost so far: steps for the makespan, or the sum of the agents' steps.
    cost: u32,
    parent: Option<u32>,
}

/// Terms of the search.
#[derive(Debug, Clone, Copy)]
pub(super) struct JointTerms {
    pub objective: BoardObjective,
    /// Most steps of a plan.
    pub limit: u32,
}

/// Whether a problem is small enough for the joint search.
pub(super) fn takes(problem: &AssayProblem) -> bool {
    let contents = problem.traces.as_ref().map_or(0, |traces| traces.washes.len());
    problem.errands.len() <= MAX_AGENTS && contents <= u64::BITS as usize
}

/// The courses of least cost. A search that gave up does not decide whether there are any; it returns a lower bound on
/// the objective.
pub(super) fn least(
    problem: &AssayProblem,
    ahead: &StopDistances,
    terms: JointTerms,
    meter: &mut Meter,
) -> SearchAnswer<Vec<AgentCourse>, AgentCells, u32> {
    if !takes(problem) {
        return SearchAnswer::GaveUp(0);
    }
    let is_due = |agent: usize| problem.enters[agent] || problem.parents[agent].is_some();
    let stand = |agent: usize| if is_due(agent) { JointStand::NotEntered } else { start(problem, agent) };
    let before: Vec<JointStand> = (0..problem.errands.len()).map(stand).collect();
    let mut search = JointSearch {
        problem,
        ahead,
        terms,
        nodes: Vec::new(),
        known: KnownPositions::new(terms.objective == BoardObjective::Makespan || terms.limit != u32::MAX),
        harmful: harmful(problem),
        open: BinaryHeap::new(),
    };
    let cells = problem.traces.as_ref().map_or(0, |_| problem.instance.board.cells());
    let mut starts = Vec::new();
    let none_before = PositionBefore { left: &vec![0; cells], waits: &vec![IDLE; problem.lags.len()], settled: 0 };
    search.arrive(before.into(), none_before, &mut starts);
    starts.into_iter().for_each(|start| search.enter(start, 0, 0, None));
    while let Some(Reverse((bound, _, index))) = search.open.pop() {
        if search.is_end(index) {
            return SearchAnswer::Found(search.courses(index));
        }
        if search.expand(index, meter).is_none() {
            return SearchAnswer::GaveUp(bound);
        }
    }
    SearchAnswer::Impossible(search.reached())
}

struct JointSearch<'a> {
    problem: &'a AssayProblem<'a>,
    ahead: &'a StopDistances,
    terms: JointTerms,
    nodes: Vec<JointNode>,
    known: KnownPositions,
    /// By agent and number of errands done: one bit for each content whose traces may still contaminate it.
    harmful: Vec<Vec<u64>>,
    /// By estimated total cost; of equal ones, the later instant comes first.
    open: BinaryHeap<Reverse<(u32, Reverse<u32>, u32)>>,
}

/// State that a joint position inherits from its predecessor.
#[derive(Clone, Copy)]
struct PositionBefore<'a> {
    left: &'a [u64],
    waits: &'a [u32],
    settled: u8,
}

impl JointSearch<'_> {
    /// The cells of all positions found.
    fn reached(&self) -> AgentCells {
        let mut met = MetCells::new(self.problem.errands.len(), self.problem.instance.board.cells());
        for node in &self.nodes {
            for (agent, stand) in node.position.standings.stands.iter().enumerate() {
                stand.there().into_iter().for_each(|stand| met.meet(agent, stand.cell));
            }
        }
        met.listed()
    }

    fn is_end(&self, index: u32) -> bool {
        let has_done = |(agent, stand): (usize, &JointStand)| match stand {
            JointStand::NotEntered => false,
            JointStand::Gone => true,
            JointStand::There(stand) => {
                let errands = &self.problem.errands[agent];
                stand.done as usize == errands.len() && errands.last().is_none_or(|last| last.stop == stand.cell)
            }
        };
        self.nodes[index as usize].position.standings.stands.iter().enumerate().all(has_done)
    }

    fn enter(&mut self, position: JointPosition, instant: u32, cost: u32, parent: Option<u32>) {
        let Some((longest, sum)) = self.least_left(&position.standings) else { return };
        if instant.saturating_add(longest) > self.terms.limit {
            return;
        }
        if !self.known.takes(&position, instant, cost) {
            return;
        }
        let least = match self.terms.objective {
            BoardObjective::Makespan => instant.saturating_add(longest),
            BoardObjective::SumOfCosts => cost.saturating_add(sum),
        };
        let index = self.nodes.len() as u32;
        self.nodes.push(JointNode { position, instant, cost, parent });
        self.open.push(Reverse((least, Reverse(instant), index)));
    }

    /// Lower bounds: on the steps to the end, and on the sum over all unsettled agents of the steps until their last
    /// move. `None` if an agent cannot reach its end.
    fn least_left(&self, position: &JointStandings) -> Option<(u32, u32)> {
        let (mut longest, mut sum) = (0, 0u32);
        for (agent, stand) in position.stands.iter().enumerate() {
            let stand = match stand {
                JointStand::NotEntered => at_start(self.problem, agent),
                JointStand::There(stand) => *stand,
                JointStand::Gone => continue,
            };
            let (end, moves) = self.left_of(agent, stand)?;
            longest = longest.max(end);
            if position.settled >> agent & 1 == 0 {
                sum = sum.saturating_add(moves);
            }
        }
        Some((longest, sum))
    }

    /// Least steps of an agent to its end, and to its last move.
    fn left_of(&self, agent: usize, AgentStand { cell, done, rested }: AgentStand) -> Option<(u32, u32)> {
        let errands = &self.problem.errands[agent];
        let (mut from, mut left, mut moves) = (cell, 0u32, 0);
        for (index, errand) in errands.iter().enumerate().skip((done as usize).min(errands.len() - 1)) {
            let is_mixing = index as u32 == done && errand.mixes.is_some() && rested > 0;
            let way = if is_mixing { 0 } else { self.ahead.steps(agent, index, from) };
            if way == UNREACHABLE {
                return None;
            }
            let stay = if index as u32 == done { errand.stay - rested } else { errand.stay };
            let is_due = index as u32 >= done;
            left = left.saturating_add(way);
            moves = if way > 0 { left } else { moves };
            left = left.saturating_add(if is_due { stay } else { 0 });
            moves = if is_due && errand.mixes.is_some() && stay > 0 { left } else { moves };
            from = errand.stop;
        }
        Some((left, moves))
    }

    /// Adds all joint positions one step later; `None` when the meter or the memory limit runs out.
    fn expand(&mut self, index: u32, meter: &mut Meter) -> Option<()> {
        let JointNode { position, instant, cost, .. } = &self.nodes[index as usize];
        let JointPosition { standings: JointStandings { stands, waits, settled }, left } = position;
        let (instant, settled, mut moved) = (*instant, *settled, Vec::new());
        let charged = match self.terms.objective {
            BoardObjective::Makespan => 1,
            BoardObjective::SumOfCosts => stands.len() as u32 - settled.count_ones(),
        };
        let cost = cost + charged;
        self.extend(stands, settled, &mut Vec::with_capacity(stands.len()), &mut moved);
        let mut found = Vec::new();
        let before = PositionBefore { left, waits, settled };
        moved.into_iter().for_each(|next| self.arrive(next, before, &mut found));
        for next in found {
            meter.step()?;
            self.enter(next, instant + 1, cost, Some(index));
        }
        (self.nodes.len() <= MAX_POSITIONS).then_some(())
    }

    /// Does the errands that can be done at the agents' new cells, and appends the positions with each choice of agents
    /// that enter then; positions with contamination are left out.
    fn arrive(&self, mut next: Box<[JointStand]>, before: PositionBefore, found: &mut Vec<JointPosition>) {
        let cell = |stand: &JointStand| Some(stand.there()?.cell);
        let cells = self.problem.traces.as_ref().map_or(Vec::new(), |_| next.iter().map(cell).collect());
        settle(self.problem, &mut next);
        let mut with_new = Vec::new();
        self.append_entries(&next, 0, &mut with_new);
        for stands in with_new {
            let left = self.trodden(&cells, &stands, before.left);
            let Some((left, waits)) = left.zip(self.waited(&stands, before.waits)) else { continue };
            for settled in self.settlings(&stands, before.settled) {
                let standings = JointStandings { stands: stands.clone(), waits: waits.clone(), settled };
                found.push(JointPosition { standings, left: left.clone() });
            }
        }
    }

    /// The sets of agents that may be settled from a position on, one bit per agent: those settled already, those that
    /// are gone, and any subset of those that need not move any more.
    fn settlings(&self, stands: &[JointStand], settled: u8) -> Vec<u8> {
        if self.terms.objective == BoardObjective::Makespan {
            return vec![0];
        }
        let mut sets = vec![settled];
        for agent in (0..stands.len()).filter(|agent| settled >> agent & 1 == 0) {
            let stand = match stands[agent] {
                JointStand::Gone => {
                    sets.iter_mut().for_each(|set| *set |= 1 << agent);
                    continue;
                }
                JointStand::There(stand) => stand,
                JointStand::NotEntered => at_start(self.problem, agent),
            };
            if self.left_of(agent, stand).is_some_and(|(_, moves)| moves == 0) {
                sets.extend(sets.clone().into_iter().map(|set| set | 1 << agent));
            }
        }
        sets
    }

    /// The waits of all lags one step later; `None` if one is too long for the work that must be done by its end.
    fn waited(&self, stands: &[JointStand], before: &[u32]) -> Option<Box<[u32]>> {
        let wait = |(lag, before): (&ErrandLag, &u32)| {
            if is_done(stands, &lag.of) || !lag.after.iter().all(|place| is_done(stands, place)) {
                return Some(IDLE);
            }
            let now = if *before == IDLE { 0 } else { before + 1 };
            (now < self.problem.most_to_end(lag)).then_some(now)
        };
        self.problem.lags.iter().zip(before).map(wait).collect()
    }

    /// The traces on all cells after agents have arrived at some of them; `None` if that contaminates one.
    fn trodden(&self, cells: &[Option<CellIndex>], stands: &[JointStand], left: &[u64]) -> Option<LeftTraces> {
        let mut left: LeftTraces = left.into();
        let Some(traces) = &self.problem.traces else { return Some(left) };
        // An agent that is dispensed where another one leaves at that instant is there together with it.
        let mut now: Vec<(CellIndex, usize)> = Vec::new();
        let touch = |(agent, stand): (usize, &JointStand)| {
            let contents = &traces.contents[agent];
            let (cell, done) = match stand {
                JointStand::NotEntered => return None,
                JointStand::There(stand) => (Some(stand.cell), stand.done as usize),
                JointStand::Gone => (cells[agent], contents.len() - 1),
            };
            Some((cell?, contents[done]))
        };
        // A wash removes traces at the instant at which it arrives.
        for (cell, _) in stands.iter().enumerate().filter_map(touch).filter(|(_, content)| traces.washes[*content]) {
            left[cell as usize] = 0;
        }
        for (cell, content) in stands.iter().enumerate().filter_map(touch) {
            let own = &mut left[cell as usize];
            if traces.washes[content] {
                continue;
            }
            if now.iter().any(|(there, with)| *there == cell && traces.harms[content][*with]) {
                return None;
            }
            now.push((cell, content));
            let does_harm = |before: &usize| *own >> before & 1 == 1 && traces.harms[*before][content];
            if (0..traces.washes.len()).any(|before| does_harm(&before)) {
                return None;
            }
            *own |= 1 << content;
        }
        let harmful = stands.iter().enumerate().map(|(agent, stand)| match stand {
            JointStand::NotEntered => self.harmful[agent][0],
            JointStand::There(stand) => self.harmful[agent][stand.done as usize],
            JointStand::Gone => 0,
        });
        let harmful = harmful.fold(0, |all, bits| all | bits);
        left.iter_mut().for_each(|left| *left &= harmful);
        Some(left)
    }

    /// All combined steps of the agents from `next.len()` on, given the steps of the agents before.
    fn extend(&self, from: &[JointStand], settled: u8, next: &mut Vec<JointStand>, found: &mut Vec<Box<[JointStand]>>) {
        let agent = next.len();
        let Some(stand) = from.get(agent) else {
            found.extend(self.with_split_off(from, next));
            return;
        };
        let JointStand::There(own) = stand else {
            next.push(*stand);
            self.extend(from, settled, next, found);
            next.pop();
            return;
        };
        for stand in self.steps_of(from, agent, *own) {
            let is_settled = settled >> agent & 1 == 1;
            if (is_settled && stand.cell != own.cell) || self.is_torn(from, agent, *own, stand) {
                continue;
            }
            if (0..agent).all(|other| self.keeps_apart(from, agent, stand, other, next[other])) {
                next.push(JointStand::There(stand));
                self.extend(from, settled, next, found);
                next.pop();
            }
        }
    }

    fn channels(&self) -> Option<&SharedChannels> {
        self.problem.instance.board.channels()
    }

    /// The split of an agent in a step, if it has one.
    fn split_in_step(&self, from: &[JointStand], agent: usize, next: AgentStand) -> Option<SplitErrand> {
        let has_split = from[agent].there().is_some_and(|own| next.done > own.done);
        due(self.problem, from, agent).filter(|_| has_split)?.splits
    }

    /// The step of an agent from a cell, with the cell to which its other half is pulled, if it splits.
    fn pulled(&self, from: &[JointStand], agent: usize, cell: CellIndex, next: AgentStand) -> PulledStep {
        let split = self.split_in_step(from, agent, next);
        let split_electrode = split.map(|split| self.problem.instance.agents[split.child].start);
        PulledStep { step: AgentStep { from: cell, to: next.cell }, split_electrode }
    }

    /// Whether shared channels tear an agent apart in a step, or the half that splits off in it.
    fn is_torn(&self, from: &[JointStand], agent: usize, own: AgentStand, next: AgentStand) -> bool {
        let Some(channels) = self.channels() else { return false };
        let step = self.pulled(from, agent, own.cell, next);
        let Some(split) = self.split_in_step(from, agent, next) else { return channels.tears_apart_pulled(step) };
        let to = self.problem.instance.agents[split.child].start;
        let half = PulledStep { step: AgentStep { from: split.from, to }, split_electrode: Some(next.cell) };
        channels.tears_apart_pulled(step) || channels.tears_apart_pulled(half) || channels.clash_pulled(step, half)
    }

    /// All steps of an agent, ignoring the others.
    fn steps_of(&self, from: &[JointStand], agent: usize, own: AgentStand) -> Vec<AgentStand> {
        let (problem, due) = (self.problem, due(self.problem, from, agent));
        let around = due.and_then(|due| due.mixes).map(|around| &problem.loops[around]);
        let round = |around: &Vec<CellIndex>| AgentStand {
            cell: around[(own.rested as usize + 1) % around.len()],
            rested: own.rested + 1,
            ..own
        };
        if let Some(around) = around.filter(|_| own.rested > 0) {
            let next = round(around);
            return (!problem.instance.board.is_blocked(next.cell)).then_some(next).into_iter().collect();
        }
        // Rest before the predecessors are done does not count.
        let may_begin = may_begin(problem, from, agent);
        let rested = if around.is_some() || !may_begin { 0 } else { own.rested + 1 };
        let mut steps = vec![AgentStand { rested, ..own }];
        // An agent that has entered must be dispensed first.
        let is_dispensed = problem.enters[agent] && own.done == 0;
        if !is_dispensed {
            let beside = problem.instance.board.neighbours(own.cell);
            steps.extend(beside.map(|cell| AgentStand { cell, rested: 0, ..own }));
        }
        let begins = around.filter(|around| may_begin && around[0] == own.cell).map(round);
        steps.extend(begins.filter(|next| !problem.instance.board.is_blocked(next.cell)));
        let split = due.filter(|due| may_begin && due.splits.is_some_and(|split| split.from == own.cell));
        steps.extend(split.map(|due| AgentStand { cell: due.stop, done: own.done + 1, rested: 0 }));
        steps
    }

    /// A joint position with the agents that split off in the step to it; `None` if one of them comes too near to
    /// another agent.
    fn with_split_off(&self, from: &[JointStand], next: &[JointStand]) -> Option<Box<[JointStand]>> {
        let (problem, instance) = (self.problem, self.problem.instance);
        let splits = |agent: usize| Some((agent, self.split_in_step(from, agent, next[agent].there()?)?));
        let splits: Vec<(usize, SplitErrand)> = (0..next.len()).filter_map(splits).collect();
        let mut all: Box<[JointStand]> = next.into();
        for (_, split) in &splits {
            all[split.child] = start(problem, split.child);
        }
        let is_clear = |(agent, split): &(usize, SplitErrand)| {
            let ours = [split.from, instance.agents[split.child].start];
            let split_electrode = all[*agent].there().map(|stand| stand.cell);
            let half = PulledStep { step: AgentStep { from: ours[0], to: ours[1] }, split_electrode };
            (0..all.len()).filter(|other| other != agent && *other != split.child).all(|other| {
                let parent = splits.iter().find(|(_, theirs)| theirs.child == other);
                let before = parent.map(|(_, theirs)| theirs.from).or(from[other].there().map(|stand| stand.cell));
                let after = all[other].there();
                let step = before.zip(after).map(|(cell, next)| match parent {
                    Some((parent, _)) => PulledStep {
                        step: AgentStep { from: cell, to: next.cell },
                        split_electrode: all[*parent].there().map(|stand| stand.cell),
                    },
                    None => self.pulled(from, other, cell, next),
                });
                let clashes =
                    self.channels().zip(step).is_some_and(|(channels, step)| channels.clash_pulled(half, step));
                let mut theirs = before.into_iter().chain(after.map(|stand| stand.cell));
                !clashes
                    && theirs
                        .all(|theirs| ours.iter().all(|own| instance.board.apart(*own, theirs) >= instance.separation))
            })
        };
        splits.iter().all(is_clear).then_some(all)
    }

    /// Appends all ways in which agents from index `from` on can enter at this instant, including none. Agents that
    /// enter have no errand done yet.
    fn append_entries(&self, stands: &[JointStand], from: usize, found: &mut Vec<Box<[JointStand]>>) {
        let is_due = |agent: &usize| {
            stands[*agent] == JointStand::NotEntered
                && self.problem.parents[*agent].is_none()
                && may_begin(self.problem, stands, *agent)
        };
        let Some(agent) = (from..stands.len()).find(is_due) else {
            found.push(stands.into());
            return;
        };
        self.append_entries(stands, agent + 1, found);
        let instance = self.problem.instance;
        let own = instance.agents[agent].start;
        let mut there = stands.iter().filter_map(|stand| stand.there());
        if there.all(|other| instance.board.apart(own, other.cell) >= instance.separation) {
            let mut stands = stands.to_vec();
            stands[agent] = start(self.problem, agent);
            self.append_entries(&stands, agent + 1, found);
        }
    }

    /// Whether two agents keep the separation at both ends of a step and crosswise, except at the cell where they are
    /// about to merge. If one leaves that cell again, it needs the separation, since the electrode of the other one
    /// would pull it too.
    fn keeps_apart(
        &self,
        from: &[JointStand],
        agent: usize,
        own_next: AgentStand,
        other: usize,
        other_next: JointStand,
    ) -> bool {
        let both = (from[agent].there(), from[other].there(), other_next.there());
        let (Some(own), Some(theirs), Some(next)) = both else { return true };
        let stop = meeting(self.problem, from, agent).filter(|(with, _)| *with == other).map(|(_, stop)| stop);
        let (ours, others) = ([own.cell, own_next.cell], [theirs.cell, next.cell]);
        let merges_at = |cells: [CellIndex; 2]| stop.filter(|stop| cells[1] == *stop);
        let (our_merge, their_merge) = (merges_at(ours), merges_at(others));
        let instance = self.problem.instance;
        let clash = |channels: &SharedChannels| {
            let ours = self.pulled(from, agent, own.cell, own_next);
            channels.clash_pulled(ours, self.pulled(from, other, theirs.cell, next))
        };
        if self.channels().is_some_and(clash) {
            return false;
        }
        ours.iter().filter(|cell| Some(**cell) != our_merge).all(|one| {
            let mut theirs = others.iter().filter(|cell| Some(**cell) != their_merge);
            theirs.all(|other| instance.board.apart(*one, *other) >= instance.separation)
        })
    }

    /// The courses that lead to a node; that of an agent that is gone ends at its last stop.
    fn courses(&self, end: u32) -> Vec<AgentCourse> {
        let mut chain = Vec::new();
        let mut at = Some(end);
        while let Some(index) = at {
            let node = &self.nodes[index as usize];
            chain.push(node);
            at = node.parent;
        }
        chain.reverse();
        let agents = 0..self.problem.errands.len();
        agents.map(|agent| self.course(&chain, agent)).collect()
    }

    fn course(&self, chain: &[&JointNode], agent: usize) -> AgentCourse {
        let since =
            chain.iter().take_while(|node| node.position.standings.stands[agent] == JointStand::NotEntered).count();
        let there = chain[since..].iter().map_while(|node| node.position.standings.stands[agent].there());
        let mut cells: Vec<CellIndex> = there.map(|stand| stand.cell).collect();
        if since + cells.len() < chain.len() {
            // It is gone as soon as it arrives at its last stop.
            cells.extend(self.problem.errands[agent].last().map(|last| last.stop));
            return AgentCourse { since: since as u32, cells };
        }
        // After its last errand it stays at its last cell.
        let due = self.problem.errands[agent].len() as u32;
        let is_done =
            |node: &&JointNode| node.position.standings.stands[agent].there().is_some_and(|stand| stand.done == due);
        let done = chain.iter().position(is_done).unwrap_or(0);
        let mut course = AgentCourse { since: since as u32, cells };
        course.end_at(done as u32);
        course
    }
}

#[cfg(test)]
mod tests {
    use super::super::{AssayPlan, Errand, ErrandPlace};
    use super::*;
    use crate::plan::electrode_array::board::{Agent, BoardGrid, Instance};
    use crate::plan::electrode_array::fast::Distances;
    use crate::plan::search::SearchBudget;

    /// One agent splits in the third step, after two steps of travel; the other one's stay of two steps counts only
    /// from then on.
    #[test]
    fn rest_counts_once_what_comes_before_is_done() {
        let board = BoardGrid::new(7, 2);
        let cell = |column: u32, row: u32| board.cell(column, row);
        let starts = [cell(0, 1), cell(6, 0), cell(6, 1)];
        let errand = |stop: CellIndex| Errand { stop, stay: 0, meets: None, mixes: None, splits: None };
        let split = SplitErrand { from: cell(5, 1), child: 2 };
        let errands = vec![
            vec![Errand { stay: 2, ..errand(starts[0]) }],
            vec![errand(cell(5, 1)), Errand { splits: Some(split), ..errand(cell(4, 1)) }],
            vec![errand(starts[2])],
        ];
        let agents = errands
            .iter()
            .zip(starts)
            .map(|(own, start)| Agent { start, stops: own.iter().map(|errand| errand.stop).collect() });
        let agents = agents.collect();
        let instance = Instance { board, separation: 2, agents, merges: Vec::new() };
        let problem = AssayProblem {
            instance: &instance,
            enters: vec![false; 3],
            parents: vec![None, None, Some(1)],
            loops: Vec::new(),
            afters: vec![vec![vec![ErrandPlace { agent: 1, errand: 1 }]], vec![Vec::new(); 2], vec![Vec::new()]],
            errands,
            lags: Vec::new(),
            releases: Vec::new(),
            relaxed_schedules: Vec::new(),
            operations: Vec::new(),
            is_gone: vec![false; 3],
            traces: None,
        };
        let mut meter = Meter::new(SearchBudget::of(100_000));
        let ahead = StopDistances::new(&problem, &mut Distances::of(&instance.board), &mut meter);
        let terms = JointTerms { objective: BoardObjective::Makespan, limit: u32::MAX };
        let SearchAnswer::Found(courses) = least(&problem, &ahead, terms, &mut meter) else {
            panic!("there is a plan")
        };
        assert_eq!(AssayPlan::costs(&courses).makespan, 5);
    }
}
