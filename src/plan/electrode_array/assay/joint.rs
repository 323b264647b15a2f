//! All agents of a small assay at once, where lists lead to no plan or to one that may not be the shortest.
//!
//! Method: A* over the positions of all agents with what each has done, one step of the board at a time; the estimate is that of the agent
//! with the longest way to its end. Guaranteed: a plan is legal and has the fewest steps, and "impossible" is said only after all positions
//! have been seen. Cost: one step of the budget for each joint position generated; no more than [`MAX_POSITIONS`] are kept.

use super::super::board::CellIndex;
use super::super::fast::UNREACHABLE;
use super::route::Ahead;
use super::{AssayProblem, Errand};
use crate::plan::search::{Meter, SearchAnswer};
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Assays of more agents are not searched: their joint positions are too many.
const MAX_AGENTS: usize = 5;

/// Greatest number of joint positions that are kept.
const MAX_POSITIONS: usize = 400_000;

/// Where an agent is, and what it has done; `None` once it is gone.
type JointStand = Option<AgentStand>;

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct AgentStand {
    cell: CellIndex,
    /// Errands done.
    done: u32,
    /// Steps for which it has been where the next one is, and no more than that takes.
    rested: u32,
}

/// A joint position and the one before it.
struct JointNode {
    stands: Box<[JointStand]>,
    instant: u32,
    parent: Option<u32>,
}

/// The courses of all agents in the fewest steps, none of more than `limit`; a search that gave up leaves it open whether there are any.
pub(super) fn fewest_steps(
    problem: &AssayProblem,
    ahead: &Ahead,
    limit: u32,
    meter: &mut Meter,
) -> SearchAnswer<Vec<Vec<CellIndex>>, (), ()> {
    if problem.errands.len() > MAX_AGENTS {
        return SearchAnswer::GaveUp(());
    }
    let stand = |start: CellIndex| Some(AgentStand { cell: start, done: 0, rested: 0 });
    let mut start: Box<[JointStand]> = problem.instance.agents.iter().map(|agent| stand(agent.start)).collect();
    settle(problem, &mut start);
    let mut search =
        JointSearch { problem, ahead, limit, nodes: Vec::new(), known: FxHashMap::default(), open: BinaryHeap::new() };
    search.enter(start, 0, None);
    while let Some(Reverse((_, _, index))) = search.open.pop() {
        if search.is_end(index) {
            return SearchAnswer::Found(search.courses(index));
        }
        if search.expand(index, meter).is_none() {
            return SearchAnswer::GaveUp(());
        }
    }
    SearchAnswer::Impossible(())
}

struct JointSearch<'a> {
    problem: &'a AssayProblem<'a>,
    ahead: &'a Ahead,
    /// Most steps of a plan.
    limit: u32,
    nodes: Vec<JointNode>,
    /// The earliest instant of each joint position.
    known: FxHashMap<Box<[JointStand]>, u32>,
    /// By estimated end, the later instant first.
    open: BinaryHeap<Reverse<(u32, Reverse<u32>, u32)>>,
}

impl JointSearch<'_> {
    fn is_end(&self, index: u32) -> bool {
        let stands = self.nodes[index as usize].stands.iter().enumerate();
        stands.filter_map(|(agent, stand)| Some((agent, (*stand)?))).all(|(agent, stand)| {
            let errands = &self.problem.errands[agent];
            stand.done as usize == errands.len() && errands.last().is_none_or(|last| last.stop == stand.cell)
        })
    }

    fn enter(&mut self, stands: Box<[JointStand]>, instant: u32, parent: Option<u32>) {
        let Some(left) = self.left(&stands) else { return };
        let least = instant.saturating_add(left);
        if least > self.limit || self.known.get(&stands).is_some_and(|known| *known <= instant) {
            return;
        }
        self.known.insert(stands.clone(), instant);
        let index = self.nodes.len() as u32;
        self.nodes.push(JointNode { stands, instant, parent });
        self.open.push(Reverse((least, Reverse(instant), index)));
    }

    /// Least steps to the end; `None` if an agent cannot come there.
    fn left(&self, stands: &[JointStand]) -> Option<u32> {
        let mut most = 0;
        for (agent, stand) in stands.iter().enumerate() {
            let Some(AgentStand { cell, done, rested }) = *stand else { continue };
            let errands = &self.problem.errands[agent];
            let (mut from, mut left) = (cell, 0u32);
            for (index, errand) in errands.iter().enumerate().skip((done as usize).min(errands.len() - 1)) {
                let way = self.ahead.steps(agent, index, from);
                if way == UNREACHABLE {
                    return None;
                }
                let stay = if index as u32 == done { errand.stay - rested } else { errand.stay };
                let is_due = index as u32 >= done;
                left = left.saturating_add(way).saturating_add(if is_due { stay } else { 0 });
                from = errand.stop;
            }
            most = most.max(left);
        }
        Some(most)
    }

    /// Adds all joint positions one step later; `None` when the meter or the room runs out.
    fn expand(&mut self, index: u32, meter: &mut Meter) -> Option<()> {
        let (stands, instant) = (self.nodes[index as usize].stands.clone(), self.nodes[index as usize].instant);
        let mut found = Vec::new();
        self.extend(&stands, &mut Vec::with_capacity(stands.len()), &mut found);
        for mut next in found {
            meter.step()?;
            settle(self.problem, &mut next);
            self.enter(next, instant + 1, Some(index));
        }
        (self.nodes.len() <= MAX_POSITIONS).then_some(())
    }

    /// All steps of the agents from one on, round those of the agents before it.
    fn extend(&self, from: &[JointStand], next: &mut Vec<JointStand>, found: &mut Vec<Box<[JointStand]>>) {
        let agent = next.len();
        let Some(stand) = from.get(agent) else {
            found.push(next.as_slice().into());
            return;
        };
        let Some(own) = stand else {
            next.push(None);
            self.extend(from, next, found);
            next.pop();
            return;
        };
        let beside = self.problem.instance.board.neighbours(own.cell);
        for cell in std::iter::once(own.cell).chain(beside) {
            if !(0..agent).all(|other| self.keeps_apart(from, (agent, cell), (other, next[other]))) {
                continue;
            }
            let rested = if cell == own.cell { own.rested + 1 } else { 0 };
            next.push(Some(AgentStand { cell, rested, ..*own }));
            self.extend(from, next, found);
            next.pop();
        }
    }

    /// Whether two agents keep the separation at both ends of a step and crosswise, but for the cell at which they are about to merge.
    fn keeps_apart(
        &self,
        from: &[JointStand],
        (agent, to): (usize, CellIndex),
        (other, other_next): (usize, JointStand),
    ) -> bool {
        let (Some(own), Some(theirs), Some(next)) = (from[agent], from[other], other_next) else { return true };
        let stop = meeting(self.problem, from, agent).filter(|(with, _)| *with == other).map(|(_, stop)| stop);
        let counts = |cell: &&CellIndex| Some(**cell) != stop;
        let (ours, others) = ([own.cell, to], [theirs.cell, next.cell]);
        let instance = self.problem.instance;
        ours.iter().filter(counts).all(|one| {
            others.iter().filter(counts).all(|other| instance.board.apart(*one, *other) >= instance.separation)
        })
    }

    /// The courses that lead to a node; those of agents that are gone end where they were last.
    fn courses(&self, end: u32) -> Vec<Vec<CellIndex>> {
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

    fn course(&self, chain: &[&JointNode], agent: usize) -> Vec<CellIndex> {
        let mut cells: Vec<CellIndex> =
            chain.iter().map_while(|node| node.stands[agent]).map(|stand| stand.cell).collect();
        if cells.len() < chain.len() {
            // It is gone as soon as it comes to its last stop.
            cells.extend(self.problem.errands[agent].last().map(|last| last.stop));
            return cells;
        }
        // After its last errand it rests where it came to last.
        let due = self.problem.errands[agent].len() as u32;
        let is_done = |node: &&JointNode| node.stands[agent].is_some_and(|stand| stand.done == due);
        let done = chain.iter().position(is_done).unwrap_or(0);
        let moved = cells.windows(2).rposition(|pair| pair[0] != pair[1]).map_or(0, |before| before + 1);
        cells.truncate(done.max(moved) + 1);
        cells
    }
}

/// The errand that an agent is to do next.
fn due(problem: &AssayProblem, stands: &[JointStand], agent: usize) -> Option<Errand> {
    problem.errands[agent].get(stands[agent]?.done as usize).copied()
}

/// The agent with which another is to merge next, if that one is to merge with it next too, and where.
fn meeting(problem: &AssayProblem, stands: &[JointStand], agent: usize) -> Option<(usize, CellIndex)> {
    let own = due(problem, stands, agent)?;
    let other = own.meets?;
    let theirs = due(problem, stands, other)?;
    (theirs.meets == Some(agent) && theirs.stop == own.stop).then_some((other, own.stop))
}

/// Does all errands that can be done where the agents are.
fn settle(problem: &AssayProblem, stands: &mut [JointStand]) {
    let ready = |stands: &[JointStand], agent: usize| {
        let own = due(problem, stands, agent)?;
        let stand = stands[agent]?;
        if stand.cell != own.stop || stand.rested < own.stay {
            return None;
        }
        match own.meets {
            None => Some((agent, None)),
            Some(_) => {
                let (other, stop) = meeting(problem, stands, agent)?;
                stands[other].is_some_and(|theirs| theirs.cell == stop).then_some((agent, Some(other)))
            }
        }
    };
    while let Some((agent, other)) = (0..stands.len()).find_map(|agent| ready(stands, agent)) {
        for one in std::iter::once(agent).chain(other) {
            stands[one] = stands[one]
                .map(|stand| AgentStand { done: stand.done + 1, rested: 0, ..stand })
                .filter(|stand| !(problem.is_gone[one] && stand.done as usize == problem.errands[one].len()));
        }
    }
    for agent in 0..stands.len() {
        let stay = due(problem, stands, agent)
            .filter(|own| stands[agent].is_some_and(|stand| stand.cell == own.stop))
            .map_or(0, |own| own.stay);
        if let Some(stand) = &mut stands[agent] {
            stand.rested = stand.rested.min(stay);
        }
    }
}
