//! Plain baseline: prioritised planning with space-time A* and re-ordering. A part without a path comes first in the
//! next priority order; after a plan or [`PATIENCE`] failures the order is shuffled.
//!
//! A textbook implementation: a binary heap, a hash set of (cell, instant), and for each position a check of every
//! path planned so far. Parts without a path yet are ignored.

use crate::clock::running;
use crate::scenes::Random;
use rustc_hash::{FxHashMap, FxHashSet};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, VecDeque};
use std::time::Duration;
use tweeze::plan::electrode_array::board::{BoardCosts, BoardObjective, CellIndex, Instance, Paths, position};

/// Failures before the order is shuffled.
const PATIENCE: u32 = 50;

/// A cell at an instant.
type Node = (CellIndex, u32);

/// Plans found within the time limit.
pub struct Found {
    pub first: Paths,
    pub best: Paths,
}

struct Baseline<'a> {
    instance: &'a Instance,
    /// For each part, the distances to its goal; `u32::MAX` if the goal cannot be reached.
    distances: Vec<Vec<u32>>,
    horizon: u32,
    /// In running time of this thread.
    deadline: Duration,
}

/// When the search ends.
#[derive(Clone, Copy, PartialEq)]
pub enum Until {
    First,
    TheEnd,
}

/// The first plan and the best one (makespan, then sum of costs) within a time limit; ends early if both bounds are
/// met.
pub fn run(instance: &Instance, bounds: BoardCosts, until: Until, time: Duration) -> Option<Found> {
    let distances = instance.agents.iter().map(|agent| distances(instance, agent.goal())).collect();
    let horizon = bounds.makespan as u32 * 2 + 64;
    let baseline = Baseline { instance, distances, horizon, deadline: running() + time };
    let mut chance = Random::new(1);
    let mut order: Vec<usize> = (0..instance.agents.len()).collect();
    let mut found: Option<Found> = None;
    let is_enough = |found: &Found| until == Until::First || BoardCosts::of(&found.best) == bounds;
    let mut failures = 0;
    while running() < baseline.deadline && !found.as_ref().is_some_and(is_enough) {
        match baseline.plan(&order) {
            Ok(paths) => {
                match &mut found {
                    Some(found) if key(&paths) < key(&found.best) => found.best = paths,
                    Some(_) => {}
                    None => found = Some(Found { first: paths.clone(), best: paths }),
                }
                failures = PATIENCE;
            }
            Err(at) => {
                order[..=at].rotate_right(1);
                failures += 1;
            }
        }
        if failures >= PATIENCE {
            shuffle(&mut order, &mut chance);
            failures = 0;
        }
    }
    found
}

fn shuffle(order: &mut [usize], chance: &mut Random) {
    for last in (1..order.len()).rev() {
        order.swap(last, chance.below(last as u32 + 1) as usize);
    }
}

fn key(paths: &Paths) -> (u64, u64) {
    BoardCosts::of(paths).key(BoardObjective::Makespan)
}

/// Breadth-first distances from a goal.
fn distances(instance: &Instance, goal: CellIndex) -> Vec<u32> {
    let mut distances = vec![u32::MAX; instance.board.cells()];
    distances[goal as usize] = 0;
    let mut open = VecDeque::from([goal]);
    while let Some(cell) = open.pop_front() {
        for next in instance.board.neighbours(cell) {
            if distances[next as usize] == u32::MAX {
                distances[next as usize] = distances[cell as usize] + 1;
                open.push_back(next);
            }
        }
    }
    distances
}

impl Baseline<'_> {
    /// A plan, or the position in the order of the part that found no path.
    fn plan(&self, order: &[usize]) -> Result<Paths, usize> {
        let mut paths: Paths = vec![vec![]; order.len()];
        for (at, part) in order.iter().enumerate() {
            let others: Vec<&[CellIndex]> = order[..at].iter().map(|other| paths[*other].as_slice()).collect();
            let path = self.search(*part, &others).ok_or(at)?;
            paths[*part] = path;
        }
        Ok(paths)
    }

    /// A* over (cell, instant), to an instant at the goal after which no other part passes near it.
    fn search(&self, part: usize, others: &[&[CellIndex]]) -> Option<Vec<CellIndex>> {
        let (start, goal) = (self.instance.agents[part].start, self.instance.agents[part].goal());
        let ahead = |cell: CellIndex| self.distances[part][cell as usize];
        let stays_from = self.stays_from(goal, others);
        let mut from: FxHashMap<Node, CellIndex> = FxHashMap::default();
        let mut closed: FxHashSet<Node> = FxHashSet::default();
        let mut open = BinaryHeap::from([(Reverse(ahead(start)), 0, start)]);
        if !self.is_free(start, 0, others) {
            return None;
        }
        while let Some((_, instant, cell)) = open.pop() {
            if !closed.insert((cell, instant)) {
                continue;
            }
            if cell == goal && instant >= stays_from {
                return Some(trace((cell, instant), &from));
            }
            if closed.len().is_multiple_of(1024) && running() >= self.deadline {
                return None;
            }
            let later = instant + 1;
            for next in self.instance.board.neighbours(cell).chain([cell]) {
                let known = closed.contains(&(next, later)) || from.contains_key(&(next, later));
                if later <= self.horizon && !known && self.is_free(next, later, others) {
                    from.insert((next, later), cell);
                    open.push((Reverse(later + ahead(next)), later, next));
                }
            }
        }
        None
    }

    /// Whether no other part is too near at the instants before, at and after `instant`.
    fn is_free(&self, cell: CellIndex, instant: u32, others: &[&[CellIndex]]) -> bool {
        let instants = instant.saturating_sub(1) as usize..=instant as usize + 1;
        others.iter().all(|path| {
            instants.clone().all(|at| self.instance.board.apart(cell, position(path, at)) >= self.instance.separation)
        })
    }

    /// The first instant from which a goal stays free.
    fn stays_from(&self, goal: CellIndex, others: &[&[CellIndex]]) -> u32 {
        let near = |cell: &CellIndex| self.instance.board.apart(goal, *cell) < self.instance.separation;
        others.iter().filter_map(|path| path.iter().rposition(near)).map(|last| last as u32 + 2).max().unwrap_or(0)
    }
}

fn trace(mut node: Node, from: &FxHashMap<Node, CellIndex>) -> Vec<CellIndex> {
    let mut path = vec![node.0];
    while node.1 > 0 {
        node = (from[&node], node.1 - 1);
        path.push(node.0);
    }
    path.reverse();
    while path.len() > 1 && path[path.len() - 2] == path[path.len() - 1] {
        path.pop();
    }
    path
}
