//! Brute force over the whole graph of a scene.

use super::geometry::{Point, clearance};
use super::scene::{Cell, Obstacle, Scene};
use std::cmp::Reverse;
use std::collections::{BTreeSet, BinaryHeap};

/// A clearance nearer to zero than this, in micrometres, cannot be decided reliably with floats.
const TOO_CLOSE_UM: f64 = 1e-6;

/// Cost of one switch.
pub type Weight = dyn Fn(usize, u32) -> f64;

/// The free moves of a scene, precomputed.
pub struct Graph {
    modules: [u32; 2],
    /// For each cell, whether it is free, and the masks of its free switches on either side.
    cells: Vec<(bool, [u32; 2])>,
}

impl Graph {
    /// `None` if some move is too close to an obstacle to decide with floats.
    pub fn new(scene: &Scene) -> Option<Graph> {
        let [left, right] = scene.modules;
        let mut cells = Vec::with_capacity(1 << (left + right));
        for number in 0..1 << (left + right) {
            let cell = [number >> right, number & ((1 << right) - 1)];
            let mut free = [0; 2];
            for (side, module) in switches(scene.modules) {
                free[side] |= u32::from(is_free(scene, cell, switched(cell, side, module))?) << module;
            }
            cells.push((is_free(scene, cell, cell)?, free));
        }
        Some(Graph { modules: scene.modules, cells })
    }

    pub fn is_free_cell(&self, cell: Cell) -> bool {
        self.cells[self.index(cell)].0
    }

    fn index(&self, [x, y]: Cell) -> usize {
        (x << self.modules[1] | y) as usize
    }

    /// The least cost from one cell to every other, infinite if there is no path (Dijkstra's algorithm).
    pub fn costs(&self, start: Cell, weight: &Weight) -> Vec<f64> {
        let mut costs = vec![f64::INFINITY; self.cells.len()];
        let mut queue = BinaryHeap::new();
        costs[self.index(start)] = 0.0;
        // The bits of a non-negative float sort like the float.
        queue.push(Reverse((0f64.to_bits(), start)));
        while let Some(Reverse((bits, cell))) = queue.pop() {
            let here = self.index(cell);
            if f64::from_bits(bits) > costs[here] {
                continue;
            }
            for (side, module) in switches(self.modules).filter(|(side, m)| self.cells[here].1[*side] >> m & 1 == 1) {
                let next = switched(cell, side, module);
                let cost = costs[here] + weight(side, module);
                if cost < costs[self.index(next)] {
                    costs[self.index(next)] = cost;
                    queue.push(Reverse((cost.to_bits(), next)));
                }
            }
        }
        costs
    }

    /// The least cost of a scene's task; `None` if there is no path.
    pub fn task(&self, scene: &Scene, weight: &Weight) -> Option<f64> {
        let leg = |from: Cell, to: Cell| self.costs(from, weight)[self.index(to)];
        let mut at = scene.start;
        let mut sum = 0.0;
        for stop in &scene.stops {
            sum += leg(at, *stop);
            at = *stop;
        }
        let nodes: Vec<Cell> = std::iter::once(at).chain(scene.visits.iter().copied()).collect();
        let between: Vec<Vec<f64>> =
            nodes.iter().map(|from| nodes.iter().map(|to| leg(*from, *to)).collect()).collect();
        sum += best_order(&between, 0, (1 << nodes.len()) - 2);
        sum.is_finite().then_some(sum)
    }
}

/// The least cost of visiting the nodes of a mask in any order.
fn best_order(between: &[Vec<f64>], at: usize, left: u32) -> f64 {
    let next = (0..between.len()).filter(|node| left >> node & 1 == 1);
    let costs = next.map(|node| between[at][node] + best_order(between, node, left & !(1 << node)));
    if left == 0 { 0.0 } else { costs.fold(f64::INFINITY, f64::min) }
}

/// The fewest pulses of a scene's task if modules may switch together, by breadth-first search over all sets of
/// modules; the outer `None` if floats cannot decide.
pub fn pulses(scene: &Scene) -> Option<Option<usize>> {
    let mut sum = 0;
    let mut at = scene.start;
    for stop in &scene.stops {
        match fewest_pulses(scene, at, *stop)? {
            Some(count) => sum += count,
            None => return Some(None),
        }
        at = *stop;
    }
    Some(Some(sum))
}

fn fewest_pulses(scene: &Scene, start: Cell, goal: Cell) -> Option<Option<usize>> {
    let [left, right] = scene.modules;
    let mut layer = vec![start];
    let mut seen = BTreeSet::from([start]);
    for count in 0.. {
        if layer.contains(&goal) {
            return Some(Some(count));
        }
        let mut next = Vec::new();
        for cell in &layer {
            for other in (0..1 << left).flat_map(|x| (0..1 << right).map(move |y| [x, y])) {
                if !seen.contains(&other) && is_free(scene, *cell, other)? {
                    seen.insert(other);
                    next.push(other);
                }
            }
        }
        if next.is_empty() {
            return Some(None);
        }
        layer = next;
    }
    None
}

/// Side (0 left, 1 right) and index of every module.
fn switches(modules: [u32; 2]) -> impl Iterator<Item = (usize, u32)> {
    (0..2).flat_map(move |side| (0..modules[side]).map(move |module| (side, module)))
}

fn switched(mut cell: Cell, side: usize, module: u32) -> Cell {
    cell[side] ^= 1 << module;
    cell
}

/// Whether the modules in which two cells differ may be switched at once. Until all have arrived, the tip is in the
/// rectangle between all of them reset and all of them set. `None` if floats cannot decide.
fn is_free(scene: &Scene, a: Cell, b: Cell) -> Option<bool> {
    let low = [a[0] & b[0], a[1] & b[1]];
    let high = [a[0] | b[0], a[1] | b[1]];
    let pitch_um = scene.pitch_um();
    let place = |cell: Cell| -> Point { [0, 1].map(|axis| f64::from(cell[axis]) * pitch_um[axis]) };
    let mut free = true;
    for obstacle in &scene.obstacles {
        match obstacle {
            Obstacle::Cells(from, to) => free &= (0..2).any(|axis| high[axis] < from[axis] || low[axis] > to[axis]),
            Obstacle::Solid(body) => {
                let clear_um = clearance(place(low), place(high), body) - scene.growth_um;
                if clear_um.abs() < TOO_CLOSE_UM {
                    return None;
                }
                free &= clear_um > 0.0;
            }
        }
    }
    Some(free)
}
