//! LaCAM: a first plan on crowded boards, by a search over configurations of all parts whose successors are generated
//! by rules.
//!
//! Problem: boards so dense that no order of the agents works and that conflicting paths cannot be repaired. Method:
//! LaCAM (K. Okumura, "LaCAM: search-based algorithm for quick multi-agent pathfinding", AAAI 2023): depth first over
//! configurations; each visit of a configuration generates one successor ([`step`]), the first time without
//! constraints, then with one more agent constrained each time, breadth first, so that eventually every successor is
//! generated.
//!
//! Guaranteed: legal paths; the same instance, seed and budget give the same plan. Not guaranteed: a short plan, or any
//! within a given budget; failure proves nothing here. Cost: one step of the meter is one agent's move; memory is 8
//! bytes for each agent of a configuration, and some 400 MB in all.

mod step;

use super::board::{CellIndex, Instance, Paths};
use super::exact::tables::{ExactTables, StagedCell};
use super::joint;
use super::joint::states::States;
use super::portfolio::timing;
use crate::plan::search::Meter;
use crate::random::SplitMix64;
use std::collections::VecDeque;
use step::ConfigurationGenerator;

/// No constraint, or no agent.
const NONE: u32 = u32::MAX;

/// Constraint on the next cell of one agent, added to the constraint `before` and all that precede it.
#[derive(Clone, Copy)]
struct Constraint {
    before: u32,
    /// Number of constrained agents, including this one.
    depth: u32,
    agent: u32,
    to: StagedCell,
}

struct LacamSearch<'a> {
    tables: &'a ExactTables<'a>,
    /// The agents, those with the greatest distances first.
    farthest: Vec<usize>,
    states: States,
    /// For each state and each agent: the steps since it was last on its goal.
    waited: Vec<u16>,
    /// For each state, its untried constraints.
    open: Vec<VecDeque<u32>>,
    constraints: Vec<Constraint>,
    random: SplitMix64,
}

/// A plan, if one is found before the meter or the memory runs out.
pub fn first(instance: &Instance, seed: u64, meter: &mut Meter) -> Option<Paths> {
    let tables = ExactTables::new(instance).ok()?;
    let mut farthest: Vec<usize> = (0..tables.agents()).collect();
    farthest.sort_by_key(|agent| std::cmp::Reverse(tables.least(*agent)));
    let mut search = LacamSearch {
        tables: &tables,
        farthest,
        states: States::new(tables.agents()),
        waited: vec![],
        open: vec![],
        constraints: vec![],
        random: SplitMix64::new(seed),
    };
    let last = search.run(meter)?;
    Some(timing::earliest(instance, &search.paths(last)))
}

impl LacamSearch<'_> {
    /// Runs the search; returns the state in which every agent is on its goal.
    fn run(&mut self, meter: &mut Meter) -> Option<u32> {
        let agents = self.tables.agents();
        let starts: Vec<StagedCell> = (0..agents).map(|agent| self.tables.start(agent)).collect();
        let mut stack = vec![self.enter(&starts, NONE)?];
        let mut step = ConfigurationGenerator::new(self.tables);
        while let Some(&state) = stack.last() {
            if self.is_final(state) {
                return Some(state);
            }
            let Some(constraint) = self.open[state as usize].pop_front() else {
                stack.pop();
                continue;
            };
            if meter.left().steps == 0 || self.states.is_full() {
                return None;
            }
            meter.charge(agents as u64);
            let order = self.order(state);
            self.refine(state, constraint, &order);
            let fixed = self.fixed(constraint);
            let Some(next) = step.make(self.states.words(state), &order, &fixed, &mut self.random) else { continue };
            match self.states.find_known(&next) {
                Some(known) => stack.push(known),
                None => stack.push(self.enter(&next, state)?),
            }
        }
        None
    }

    /// Adds a new state.
    fn enter(&mut self, nodes: &[StagedCell], parent: u32) -> Option<u32> {
        let state = self.states.insert(nodes, 0, parent)?;
        for (agent, node) in nodes.iter().enumerate() {
            let before = if parent == NONE { 0 } else { self.waited[parent as usize * nodes.len() + agent] };
            let waited = if *node == self.tables.goal(agent) { 0 } else { before.saturating_add(1) };
            self.waited.push(waited);
        }
        self.open.push(VecDeque::from([NONE]));
        Some(state)
    }

    fn is_final(&self, state: u32) -> bool {
        self.states.words(state).iter().enumerate().all(|(agent, node)| *node == self.tables.goal(agent))
    }

    /// Priority order: longest time away from the goal first, then the greatest initial distance.
    fn order(&self, state: u32) -> Vec<usize> {
        let count = self.tables.agents();
        let waited = &self.waited[state as usize * count..][..count];
        let mut order = self.farthest.clone();
        order.sort_by_key(|agent| std::cmp::Reverse(waited[*agent]));
        order
    }

    /// Adds one constraint for each possible next cell of one more agent.
    fn refine(&mut self, state: u32, constraint: u32, order: &[usize]) {
        let depth = self.constraints.get(constraint as usize).map_or(0, |constraint| constraint.depth);
        let Some(&agent) = order.get(depth as usize) else { return };
        let mut moves: Vec<StagedCell> = self.tables.next(agent, self.states.words(state)[agent]).collect();
        self.random.shuffle(&mut moves);
        for to in moves {
            self.open[state as usize].push_back(self.constraints.len() as u32);
            self.constraints.push(Constraint { before: constraint, depth: depth + 1, agent: agent as u32, to });
        }
    }

    /// All agents that a constraint covers, with their next nodes.
    fn fixed(&self, mut constraint: u32) -> Vec<(usize, StagedCell)> {
        let mut fixed = vec![];
        while let Some(one) = self.constraints.get(constraint as usize) {
            fixed.push((one.agent as usize, one.to));
            constraint = one.before;
        }
        fixed
    }

    fn paths(&self, mut state: u32) -> Paths {
        let mut paths: Vec<Vec<CellIndex>> = vec![vec![]; self.tables.agents()];
        while state != NONE {
            for (path, node) in paths.iter_mut().zip(self.states.words(state)) {
                path.push(self.tables.cell(*node));
            }
            state = self.states.parent(state);
        }
        for path in &mut paths {
            path.reverse();
            joint::trim(path);
        }
        paths
    }
}
