//! Exact plans for a few parts: a search of their joint space.
//!
//! Problem: a group of agents, all others ignored, from their starts to their goals. Method: A* over joint nodes with
//! the agents' own distances as lower bound (for the makespan the largest, for the sum of costs their sum); the agents'
//! moves are chosen one after the other, so that a move too near to an earlier one prunes all its extensions (compare
//! T. Standley, "Finding Optimal Solutions to Cooperative Pathfinding Problems", AAAI 2010). For the sum of costs a
//! node records for each agent whether it has arrived for good; only agents that have not are charged for a step.
//!
//! Where only the moves matter, or only whether there is a plan, one agent moves at a time. This loses nothing: a move
//! never comes near a place that is being left, so the moves of one step may equally be made one after the other, and
//! the fewest moves in turn are the fewest of all. With shared channels that is not so, and neither question is asked.
//! For any plan, the distances are weighted by `HURRY` and the moves of the result are made as early as possible.
//!
//! Guaranteed, while the budget lasts: a plan of least cost, or the proof that there is none; under a limit on the
//! steps, none within it. Not guaranteed: good tie-breaking between plans of the same cost. The number of joint nodes
//! is the product of the agents' nodes, so two parts fit on most boards and more on small ones. One step of the budget
//! is one tried move of one agent; memory is at most some 50 bytes for each, and some 400 MB in all.

use super::board::{CellIndex, MetCells, Paths};
use super::exact::tables::{ExactTables, FAR, StagedCell};
use crate::plan::search::{Meter, SearchAnswer};
use states::States;

pub mod states;

/// Aim of the search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointAim {
    /// Any plan, or the proof that there is none.
    Any,
    /// The fewest moves, whatever the steps.
    Moves,
    /// The least makespan, or none within this many steps.
    Makespan { limit: Option<u32> },
    /// The least sum of costs, or none within this many steps.
    SumOfCosts { limit: Option<u32> },
}

/// Result for a group: a plan that is best for the aim, with a path for each member in its order. A search that gave up
/// returns a lower bound on the cost of every plan.
pub type JointAnswer = SearchAnswer<Paths, NoJointPlan, u64>;

/// Why a group has no plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NoJointPlan {
    /// There is none at all.
    AtAll,
    /// There is none within the limit; beyond it nothing is known.
    WithinLimit,
}

/// Heuristic weight where any plan is sufficient.
const HURRY: u32 = 4;

/// Larger groups are not searched.
const MOST_MEMBERS: usize = 64;

/// The same for the sum of costs, where each joint position has up to 2 variants per member: arrived for good or not.
const MOST_SUMMED: usize = 12;

/// Searches for the agents of `group` alone.
pub fn search(tables: &ExactTables, group: &[usize], aim: JointAim, meter: &mut Meter) -> JointAnswer {
    if group.is_empty() {
        return JointAnswer::Found(vec![]);
    }
    let most = if matches!(aim, JointAim::SumOfCosts { .. }) { MOST_SUMMED } else { MOST_MEMBERS };
    if group.len() > most {
        return JointAnswer::GaveUp(0);
    }
    let mut search = JointSearch::new(tables, group, aim);
    search.begin();
    search.run(meter)
}

/// The cells that each member of a group without a plan can reach when the members move in turn, ascending; only cells
/// from which the member alone could still reach its goal. `None` if the meter runs out, or if there is a plan.
pub fn reached(tables: &ExactTables, group: &[usize], meter: &mut Meter) -> Option<Vec<Vec<CellIndex>>> {
    if group.is_empty() || group.len() > MOST_MEMBERS {
        return None;
    }
    let mut search = JointSearch::new(tables, group, JointAim::Any);
    search.begin();
    let JointAnswer::Impossible(_) = search.run(meter) else { return None };
    let mut met = MetCells::new(group.len(), tables.instance.board.cells());
    for state in 0..search.states.count() {
        let words = search.states.words(state)[..group.len()].iter();
        words.enumerate().for_each(|(member, word)| met.meet(member, tables.cell(word >> 1)));
    }
    Some(met.listed())
}

/// One agent's part of a joint node: its node, and whether it has arrived for good.
type AgentWord = u32;

const PARKED: AgentWord = 1;

struct JointSearch<'a> {
    tables: &'a ExactTables<'a>,
    group: &'a [usize],
    aim: JointAim,
    states: States,
    /// Open list: indices of states by lower bound on the total cost.
    open: Vec<Vec<u32>>,
    lowest: usize,
    /// Whether a state was pruned because of the limit.
    limited: bool,
}

impl<'a> JointSearch<'a> {
    fn new(tables: &'a ExactTables, group: &'a [usize], aim: JointAim) -> Self {
        let timed = matches!(aim, JointAim::SumOfCosts { limit: Some(_) });
        let states = States::new(group.len() + usize::from(timed));
        JointSearch { tables, group, aim, states, open: vec![], lowest: 0, limited: false }
    }

    fn begin(&mut self) {
        let mut words: Vec<AgentWord> = self.group.iter().map(|agent| self.tables.start(*agent) * 2).collect();
        words.resize(self.states.width(), 0);
        self.insert_with_parking(&mut words, 0, 0, u32::MAX, &[]);
    }

    /// Inserts a state in each variant of which agents, among those just arrived at their goals, stay for good. Recursion is at
    /// most [`MOST_SUMMED`] deep.
    fn insert_with_parking(
        &mut self,
        words: &mut Vec<AgentWord>,
        member: usize,
        cost: u32,
        parent: u32,
        before: &[AgentWord],
    ) {
        if !matches!(self.aim, JointAim::SumOfCosts { .. }) || member == self.group.len() {
            return self.insert(words, cost, parent);
        }
        let arrives = words[member] >> 1 == self.tables.goal(self.group[member]);
        let was_there = before.get(member).is_some_and(|word| *word >> 1 == words[member] >> 1);
        if arrives && !was_there && words[member] & PARKED == 0 {
            words[member] |= PARKED;
            self.insert_with_parking(words, member + 1, cost, parent, before);
            words[member] &= !PARKED;
            if self.tables.is_absorbed(self.group[member]) {
                return;
            }
        }
        self.insert_with_parking(words, member + 1, cost, parent, before);
    }

    fn insert(&mut self, words: &[AgentWord], cost: u32, parent: u32) {
        let Some(ahead) = self.ahead(words) else { return };
        if self.exceeds_limit(words, cost) {
            self.limited = true;
            return;
        }
        if let Some(state) = self.states.insert(words, cost, parent) {
            let bound = match self.aim {
                JointAim::Any => (cost + ahead.saturating_mul(HURRY)) as usize,
                JointAim::Moves | JointAim::Makespan { .. } | JointAim::SumOfCosts { .. } => (cost + ahead) as usize,
            };
            if self.open.len() <= bound {
                self.open.resize_with(bound + 1, Vec::new);
            }
            self.open[bound].push(state);
            self.lowest = self.lowest.min(bound);
        }
    }

    /// Lower bound on the remaining cost; `None` if an agent cannot reach its goal.
    fn ahead(&self, words: &[AgentWord]) -> Option<u32> {
        let mut largest = 0;
        let mut sum = 0u32;
        for (agent, word) in self.group.iter().zip(words) {
            let distance = self.own_distance(*agent, *word);
            if distance == FAR {
                return None;
            }
            largest = largest.max(distance);
            sum = sum.saturating_add(distance);
        }
        Some(match self.aim {
            JointAim::Makespan { .. } => largest,
            JointAim::Any | JointAim::Moves | JointAim::SumOfCosts { .. } => sum,
        })
    }

    /// Least steps of an agent. One that waits on its goal without having arrived for good must leave it and come back:
    /// 2 steps.
    fn own_distance(&self, agent: usize, word: AgentWord) -> u32 {
        let distance = self.tables.distance(agent, word >> 1);
        let unsettled = matches!(self.aim, JointAim::SumOfCosts { .. }) && word & PARKED == 0 && distance == 0;
        if unsettled { 2 } else { distance }
    }

    fn exceeds_limit(&self, words: &[AgentWord], cost: u32) -> bool {
        let largest =
            || self.group.iter().zip(words).map(|(agent, word)| self.own_distance(*agent, *word)).max().unwrap_or(0);
        match self.aim {
            JointAim::Any
            | JointAim::Moves
            | JointAim::Makespan { limit: None }
            | JointAim::SumOfCosts { limit: None } => false,
            JointAim::Makespan { limit: Some(limit) } => cost + largest() > limit,
            JointAim::SumOfCosts { limit: Some(limit) } => words[self.group.len()] + largest() > limit,
        }
    }

    fn run(&mut self, meter: &mut Meter) -> JointAnswer {
        let mut ply = Ply::new(self.group.len());
        while let Some(state) = self.pop() {
            if self.is_final(state) {
                return JointAnswer::Found(self.paths(state));
            }
            let expanded = match self.aim {
                JointAim::Any | JointAim::Moves => self.expand_in_turns(state, meter),
                JointAim::Makespan { .. } | JointAim::SumOfCosts { .. } => self.expand(state, &mut ply, meter),
            };
            if self.states.is_full() || expanded.is_none() {
                let bound = if self.aim == JointAim::Any { 0 } else { self.lowest as u64 };
                return JointAnswer::GaveUp(bound);
            }
        }
        if self.limited {
            JointAnswer::Impossible(NoJointPlan::WithinLimit)
        } else {
            JointAnswer::Impossible(NoJointPlan::AtAll)
        }
    }

    /// The open state with the least bound; each state is returned once.
    fn pop(&mut self) -> Option<u32> {
        while self.lowest < self.open.len() {
            match self.open[self.lowest].pop() {
                Some(state) if self.states.close(state) => return Some(state),
                Some(_) => {}
                None => self.lowest += 1,
            }
        }
        None
    }

    fn is_final(&self, state: u32) -> bool {
        let words = self.states.words(state);
        self.group.iter().zip(words).all(|(agent, word)| match self.aim {
            JointAim::Any | JointAim::Moves | JointAim::Makespan { .. } => word >> 1 == self.tables.goal(*agent),
            JointAim::SumOfCosts { .. } => word & PARKED != 0,
        })
    }

    /// Inserts all states one step later.
    fn expand(&mut self, state: u32, ply: &mut Ply, meter: &mut Meter) -> Option<()> {
        let before = self.states.words(state).to_vec();
        let cost = self.states.cost(state) + self.step_cost(&before);
        let mut words = before.clone();
        if let Some(instant) = words.get_mut(self.group.len()) {
            *instant += 1;
        }
        let mut member = 0;
        ply.fill(self.tables, self.group[0], 0, before[0]);
        loop {
            match ply.moves[member].pop() {
                Some(word) => {
                    meter.step()?;
                    if !self.fits(member, word, &before, &words) {
                        continue;
                    }
                    words[member] = word;
                    if member + 1 < self.group.len() {
                        member += 1;
                        ply.fill(self.tables, self.group[member], member, before[member]);
                    } else {
                        self.insert_with_parking(&mut words.clone(), 0, cost, state, &before);
                    }
                }
                None if member == 0 => return Some(()),
                None => member -= 1,
            }
        }
    }

    /// Inserts all states one move of one agent later.
    fn expand_in_turns(&mut self, state: u32, meter: &mut Meter) -> Option<()> {
        let mut words = self.states.words(state).to_vec();
        let cost = self.states.cost(state) + 1;
        let tables = self.tables;
        for member in 0..self.group.len() {
            let here = words[member];
            for node in tables.next(self.group[member], here >> 1).skip(1) {
                meter.step()?;
                if self.is_clear(member, node, &words) {
                    words[member] = node * 2;
                    self.insert(&words, cost, state);
                }
                words[member] = here;
            }
        }
        Some(())
    }

    /// Whether a member may move to a node while the others stay.
    fn is_clear(&self, member: usize, node: StagedCell, words: &[AgentWord]) -> bool {
        let (agent, cell) = (self.group[member], self.tables.cell(node));
        let mut others = self.group.iter().zip(words).enumerate().filter(|(other, _)| *other != member);
        others.all(|(_, (other, word))| !self.tables.too_near(agent, cell, *other, self.tables.cell(word >> 1)))
    }

    fn step_cost(&self, before: &[AgentWord]) -> u32 {
        match self.aim {
            JointAim::Any | JointAim::Moves | JointAim::Makespan { .. } => 1,
            JointAim::SumOfCosts { .. } => {
                before[..self.group.len()].iter().filter(|word| **word & PARKED == 0).count() as u32
            }
        }
    }

    /// Whether a move of a member is compatible with those of the members before it.
    fn fits(&self, member: usize, word: AgentWord, before: &[AgentWord], words: &[AgentWord]) -> bool {
        let cell = |word: AgentWord| self.tables.cell(word >> 1);
        let (from, to) = (cell(before[member]), cell(word));
        (0..member).all(|other| {
            let (other_from, other_to) = (cell(before[other]), cell(words[other]));
            let near = |at: CellIndex, other_at: CellIndex| {
                self.tables.too_near(self.group[member], at, self.group[other], other_at)
            };
            !near(to, other_to)
                && !near(to, other_from)
                && !near(from, other_to)
                && !self.tables.clash([from, to], [other_from, other_to])
        })
    }

    /// The paths to a final state; each ends at its last arrival.
    fn paths(&self, state: u32) -> Paths {
        let mut paths: Paths = vec![vec![]; self.group.len()];
        let mut at = state;
        while at != u32::MAX {
            for (path, word) in paths.iter_mut().zip(self.states.words(at)) {
                path.push(self.tables.cell(word >> 1));
            }
            at = self.states.parent(at);
        }
        for path in &mut paths {
            path.reverse();
            trim(path);
        }
        paths
    }
}

/// The untried moves of each member, in the expansion of one state.
struct Ply {
    moves: Vec<Vec<AgentWord>>,
}

impl Ply {
    fn new(members: usize) -> Self {
        Ply { moves: vec![Vec::with_capacity(5); members] }
    }

    fn fill(&mut self, tables: &ExactTables, agent: usize, member: usize, word: AgentWord) {
        let moves = &mut self.moves[member];
        if word & PARKED != 0 {
            moves.extend(tables.may_rest(word >> 1).then_some(word));
            return;
        }
        moves.extend(tables.next(agent, word >> 1).map(|node: StagedCell| node * 2));
        // The move that comes closest to the goal must be tried last: the bucket is a stack, so it leaves first.
        moves.sort_by_key(|word| std::cmp::Reverse(tables.distance(agent, *word >> 1)));
        moves.reverse();
    }
}

/// Drops the wait at the end of a path, so that its last position is the last arrival.
pub(super) fn trim(path: &mut Vec<CellIndex>) {
    while path.len() > 1 && path[path.len() - 2] == path[path.len() - 1] {
        path.pop();
    }
}

#[cfg(test)]
pub(super) mod oracle;
#[cfg(test)]
mod tests;
