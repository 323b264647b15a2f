//! Brute force over every state of a task: the cells visited, the next step, and the place of the tip.
//!
//! Based on docs/language.md and the paper; shares no code with the compiler. Figures are integers: distance in units
//! of the finer pitch, switches, pulses.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

pub type Cell = [u32; 2];

/// Distance, switches and pulses of a plan.
pub type Figures = [u64; 3];

/// A part of a task.
#[derive(Debug, Clone)]
pub enum Part {
    To(Cell),
    /// In any order.
    All(Vec<Cell>),
}

/// An obstacle in half cells: an even number is a cell, an odd one the gap after it.
#[derive(Debug, Clone, Copy)]
pub struct Block {
    pub low: Cell,
    pub high: Cell,
}

#[derive(Debug, Clone)]
pub struct Lattice {
    pub modules: [u32; 2],
    pub blocks: Vec<Block>,
}

impl Lattice {
    /// Whether the whole rectangle between two cells is free, in which the tip may be while the differing modules
    /// switch.
    pub fn is_free(&self, a: Cell, b: Cell) -> bool {
        let low = [0, 1].map(|axis| 2 * (a[axis] & b[axis]));
        let high = [0, 1].map(|axis| 2 * (a[axis] | b[axis]));
        !self
            .blocks
            .iter()
            .any(|block| (0..2).all(|axis| block.low[axis] <= high[axis] && low[axis] <= block.high[axis]))
    }

    fn cells(&self) -> Vec<Cell> {
        let [left, right] = self.modules;
        (0..1 << left).flat_map(|x| (0..1 << right).map(move |y| [x, y])).collect()
    }

    /// For each cell, the cells that one pulse leads to.
    fn moves(&self, with_pulses: bool) -> BTreeMap<Cell, Vec<(Cell, Figures)>> {
        let cells = self.cells();
        let mut next: BTreeMap<Cell, Vec<(Cell, Figures)>> = BTreeMap::new();
        for cell in &cells {
            let is_move = |to: &&Cell| **to != *cell && (with_pulses || self.figures(*cell, **to)[1] == 1);
            let moves = cells.iter().filter(is_move).filter(|to| self.is_free(*cell, **to));
            next.insert(*cell, moves.map(|to| (*to, self.figures(*cell, *to))).collect());
        }
        next
    }

    /// Figures of switching from one cell to the other.
    fn figures(&self, a: Cell, b: Cell) -> Figures {
        let finest = self.modules[0].max(self.modules[1]);
        let masks = [a[0] ^ b[0], a[1] ^ b[1]];
        let way = |axis: usize| u64::from(masks[axis]) << (finest - self.modules[axis]);
        [way(0) + way(1), u64::from(masks[0].count_ones() + masks[1].count_ones()), 1]
    }
}

/// The index of the next part, and the visited cells of that part.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct TaskProgress {
    part: usize,
    visited: u32,
}

/// The Pareto front of a task: the figures of all plans that no other plan dominates.
pub fn front(lattice: &Lattice, start: Cell, parts: &[Part], with_pulses: bool) -> Vec<Figures> {
    let mut all = Vec::new();
    for figures in fronts(lattice, start, parts, with_pulses).into_values().flatten() {
        add(&mut all, figures);
    }
    all
}

/// The same for each final cell.
pub fn fronts(lattice: &Lattice, start: Cell, parts: &[Part], with_pulses: bool) -> BTreeMap<Cell, Vec<Figures>> {
    let next = lattice.moves(with_pulses);
    let mut known: BTreeMap<(TaskProgress, Cell), Vec<Figures>> = BTreeMap::new();
    let mut ends: BTreeMap<Cell, Vec<Figures>> = BTreeMap::new();
    let mut queue = BinaryHeap::from([Reverse(([0; 3], TaskProgress { part: 0, visited: 0 }, start))]);
    while let Some(Reverse((figures, progress, cell))) = queue.pop() {
        if !add(known.entry((progress, cell)).or_default(), figures) {
            continue;
        }
        if progress.part == parts.len() {
            add(ends.entry(cell).or_default(), figures);
            continue;
        }
        if let Some(progress) = advanced(parts, progress, cell) {
            queue.push(Reverse((figures, progress, cell)));
        }
        for (to, more) in &next[&cell] {
            let sum = [0, 1, 2].map(|k| figures[k] + more[k]);
            queue.push(Reverse((sum, progress, *to)));
        }
    }
    ends
}

/// Progress of a task once the tip is on a cell; `None` if there is none.
fn advanced(parts: &[Part], progress: TaskProgress, cell: Cell) -> Option<TaskProgress> {
    let next = TaskProgress { part: progress.part + 1, visited: 0 };
    match &parts[progress.part] {
        Part::To(goal) => (*goal == cell).then_some(next),
        Part::All(places) => {
            let here = places.iter().enumerate().filter(|(_, place)| **place == cell);
            let visited = here.fold(progress.visited, |visited, (index, _)| visited | 1 << index);
            let is_done = visited == (1 << places.len()) - 1;
            (visited != progress.visited).then_some(if is_done { next } else { TaskProgress { visited, ..progress } })
        }
    }
}

/// The least figures in the order of a key that must be monotone in each figure; for tasks that are too long for a
/// front.
pub fn least(lattice: &Lattice, start: Cell, parts: &[Part], key: impl Fn(Figures) -> Figures) -> Option<Figures> {
    let next = lattice.moves(false);
    let mut done: BTreeSet<(TaskProgress, Cell)> = BTreeSet::new();
    let mut queue = BinaryHeap::from([Reverse((key([0; 3]), [0; 3], TaskProgress { part: 0, visited: 0 }, start))]);
    while let Some(Reverse((_, figures, progress, cell))) = queue.pop() {
        if progress.part == parts.len() {
            return Some(figures);
        }
        if !done.insert((progress, cell)) {
            continue;
        }
        if let Some(progress) = advanced(parts, progress, cell) {
            queue.push(Reverse((key(figures), figures, progress, cell)));
            // A tip on a place has visited it.
            continue;
        }
        for (to, more) in &next[&cell] {
            let sum = [0, 1, 2].map(|k| figures[k] + more[k]);
            queue.push(Reverse((key(sum), sum, progress, *to)));
        }
    }
    None
}

/// Adds figures unless a known entry dominates them; returns whether they were added.
fn add(known: &mut Vec<Figures>, figures: Figures) -> bool {
    let is_within = |a: &Figures, b: &Figures| (0..3).all(|k| a[k] <= b[k]);
    if known.iter().any(|other| is_within(other, &figures)) {
        return false;
    }
    known.retain(|other| !is_within(&figures, other));
    known.push(figures);
    true
}
