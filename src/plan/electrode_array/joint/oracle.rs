//! Reference searches and a plan checker for the tests, written from the definitions alone.

use crate::plan::electrode_array::board::{Agent, BoardGrid, BoardObjective, CellIndex, Instance, Paths, position};
use std::collections::{BTreeMap, BTreeSet};

/// Cells, number of stops visited, and which agents have arrived for good.
type Joint = (Vec<CellIndex>, Vec<usize>, Vec<bool>);

/// Whether agents may step from some cells to others, under a rule besides that of separation.
pub type StepRule<'a> = &'a dyn Fn(&[CellIndex], &[CellIndex]) -> bool;

/// The least makespan or sum of costs; `None` if there is no plan.
pub fn least(instance: &Instance, objective: BoardObjective) -> Option<u64> {
    least_by(instance, objective, &|_, _| true)
}

/// The same under one more rule.
pub fn least_by(instance: &Instance, objective: BoardObjective, rule: StepRule) -> Option<u64> {
    let cells: Vec<CellIndex> = instance.agents.iter().map(|agent| agent.start).collect();
    let done = cells.iter().enumerate().map(|(agent, cell)| passed(instance, agent, 0, *cell)).collect();
    let first: Joint = (cells, done, vec![false; instance.agents.len()]);
    let mut open = BTreeSet::from([(0, first.clone())]);
    let mut costs = BTreeMap::from([(first, 0)]);
    while let Some((cost, joint)) = open.pop_first() {
        if costs[&joint] < cost {
            continue;
        }
        if joint.2.iter().all(|settled| *settled) {
            return Some(cost);
        }
        for (more, next) in followers(instance, objective, &joint, rule) {
            if costs.get(&next).is_none_or(|known| *known > cost + more) {
                costs.insert(next.clone(), cost + more);
                open.insert((cost + more, next));
            }
        }
    }
    None
}

fn passed(instance: &Instance, agent: usize, mut done: usize, at: CellIndex) -> usize {
    while instance.agents[agent].stops.get(done) == Some(&at) {
        done += 1;
    }
    done
}

/// Successors: one agent arrives for good at no cost, or all make a step.
fn followers(instance: &Instance, objective: BoardObjective, joint: &Joint, rule: StepRule) -> Vec<(u64, Joint)> {
    let (cells, done, settled) = joint;
    let mut found = vec![];
    for (agent, asked) in instance.agents.iter().enumerate() {
        if !settled[agent] && cells[agent] == asked.goal() && done[agent] == asked.stops.len() {
            let mut next = joint.clone();
            next.2[agent] = true;
            found.push((0, next));
        }
    }
    let moving = settled.iter().filter(|settled| !**settled).count() as u64;
    let cost = if objective == BoardObjective::Makespan { 1 } else { moving };
    let mut partial: Vec<Vec<CellIndex>> = vec![vec![]];
    for agent in 0..cells.len() {
        let goal = instance.agents[agent].goal();
        let merged_there = instance.merges.iter().any(|pair| pair.contains(&agent)) && cells[agent] == goal;
        let mut to = vec![cells[agent]];
        if !settled[agent] && !merged_there {
            to.extend(instance.board.neighbours(cells[agent]));
        }
        partial =
            partial.iter().flat_map(|head| to.iter().map(move |cell| [head.clone(), vec![*cell]].concat())).collect();
    }
    for next in partial.into_iter().filter(|next| keeps_rule(instance, cells, next) && rule(cells, next)) {
        let done = (0..next.len()).map(|agent| passed(instance, agent, done[agent], next[agent])).collect();
        found.push((cost, (next, done, settled.clone())));
    }
    found
}

fn keeps_rule(instance: &Instance, from: &[CellIndex], to: &[CellIndex]) -> bool {
    let pairs = (0..from.len()).flat_map(|one| (0..one).map(move |other| (one, other)));
    pairs.into_iter().all(|(one, other)| {
        let near = |at: CellIndex, other_at: CellIndex| instance.too_near(one, at, other, other_at);
        !near(to[one], to[other]) && !near(to[one], from[other]) && !near(from[one], to[other])
    })
}

/// The first violation of a plan, if any.
pub fn fault(instance: &Instance, paths: &Paths) -> Option<String> {
    fault_by(instance, paths, &|_, _| true)
}

/// The same under one more rule.
pub fn fault_by(instance: &Instance, paths: &Paths, rule: StepRule) -> Option<String> {
    if paths.len() != instance.agents.len() {
        return Some("not one path for each agent".into());
    }
    let end = paths.iter().map(Vec::len).max().unwrap_or(0);
    for (agent, (asked, path)) in instance.agents.iter().zip(paths).enumerate() {
        let done = path.iter().fold(0, |done, cell| passed(instance, agent, done, *cell));
        let steps_well = path
            .windows(2)
            .all(|pair| pair[0] == pair[1] || instance.board.neighbours(pair[0]).any(|to| to == pair[1]));
        let waits_at_end = path.len() > 1 && path[path.len() - 2] == path[path.len() - 1];
        let leaves = instance.merges.iter().any(|pair| pair.contains(&agent))
            && path[..path.len() - 1].iter().any(|cell| *cell == asked.goal());
        if path[0] != asked.start
            || done < asked.stops.len()
            || path.last() != asked.stops.last()
            || !steps_well
            || waits_at_end
            || leaves
        {
            return Some(format!("path of agent {agent}: {path:?} for {asked:?}"));
        }
    }
    for instant in 0..end {
        let at = |instant: usize| -> Vec<CellIndex> { paths.iter().map(|path| position(path, instant)).collect() };
        if !keeps_rule(instance, &at(instant), &at(instant)) || !keeps_rule(instance, &at(instant), &at(instant + 1)) {
            return Some(format!("the rule after instant {instant}"));
        }
        if instant + 1 < end && !rule(&at(instant), &at(instant + 1)) {
            return Some(format!("the other rule after instant {instant}"));
        }
    }
    None
}

/// A small deterministic source of random numbers (Marsaglia's xorshift).
pub struct Chance(pub u64);

impl Chance {
    pub fn below(&mut self, limit: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % limit
    }
}

/// Shape of random instances.
#[derive(Clone, Copy)]
pub struct Shape {
    pub width: u32,
    pub height: u32,
    pub separation: u32,
    pub agents: usize,
    pub blocked_percent: u64,
    /// Most stops before the goal.
    pub vias: u64,
    pub merges: bool,
}

/// A random instance that keeps the invariants; `None` if there are too few cells.
pub fn random(shape: Shape, chance: &mut Chance) -> Option<Instance> {
    let mut board = BoardGrid::new(shape.width, shape.height);
    for cell in 0..board.cells() as CellIndex {
        if chance.below(100) < shape.blocked_percent {
            board.block(cell);
        }
    }
    let merges = if shape.merges { vec![[0, 1]] } else { vec![] };
    let starts = spread(&board, shape, shape.agents, chance)?;
    let mut goals = spread(&board, shape, shape.agents - merges.len(), chance)?;
    if shape.merges {
        goals.insert(0, goals[0]);
    }
    let mut agents = vec![];
    for (index, (start, goal)) in starts.into_iter().zip(goals).enumerate() {
        let vias = if shape.vias == 0 || shape.merges && index < 2 { 0 } else { chance.below(shape.vias + 1) };
        let mut stops = vec![];
        for _ in 0..vias {
            stops.push(free(&board, chance)?);
        }
        stops.push(goal);
        agents.push(Agent { start, stops });
    }
    Some(Instance { board, separation: shape.separation, agents, merges })
}

fn free(board: &BoardGrid, chance: &mut Chance) -> Option<CellIndex> {
    (0..200).map(|_| chance.below(board.cells() as u64) as CellIndex).find(|cell| !board.is_blocked(*cell))
}

fn spread(board: &BoardGrid, shape: Shape, count: usize, chance: &mut Chance) -> Option<Vec<CellIndex>> {
    let mut found: Vec<CellIndex> = vec![];
    for _ in 0..count {
        let fits = |cell: &CellIndex| found.iter().all(|other| board.apart(*cell, *other) >= shape.separation);
        let cell = (0..200).filter_map(|_| free(board, chance)).find(fits)?;
        found.push(cell);
    }
    Some(found)
}
