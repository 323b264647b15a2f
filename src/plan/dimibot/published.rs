//! The algorithms compared in Chalvet, Haddab and Lutz 2016, on the implicit graph: selectable by name, for comparison.
//!
//! Each finds an optimal path, proves that there is none, or runs out of budget; one step is one cell taken from the queue. Two
//! slips of the paper are corrected: Algorithm 2 assigns every stage's position (inside its loop), and the stages of a
//! non-symmetric robot are matched from the largest stroke down. Algorithm 3's heuristic is used as printed: it counts nothing for
//! a stage whose two modules both differ, so it is admissible but weak.

use super::field::LatticeField;
use super::lattice::{Flip, Lattice, LatticeCell, Side, SwitchWeights, bits};
use super::lines::LineReader;
use super::outcome::{DimibotAnswer, FlipPath, Proof};
use super::shortest::outside;
use crate::plan::search::{Meter, SearchBudget};
use crate::real::Real;
use rustc_hash::FxHashMap;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Dijkstra's algorithm (section 4.2).
pub fn dijkstra(
    field: &LatticeField,
    start: LatticeCell,
    goal: LatticeCell,
    weights: &SwitchWeights,
    budget: SearchBudget,
) -> DimibotAnswer<FlipPath> {
    best_first(field, start, goal, weights, budget, |_| 0)
}

/// A* with the straight-line distance in frame R1 (section 4.3), scaled so that it stays admissible for any weights.
pub fn astar(
    field: &LatticeField,
    start: LatticeCell,
    goal: LatticeCell,
    weights: &SwitchWeights,
    budget: SearchBudget,
) -> DimibotAnswer<FlipPath> {
    let estimate = straight_line(field.lattice(), goal, weights);
    best_first(field, start, goal, weights, budget, estimate)
}

/// A* with Algorithm 3's heuristic on the positions in the hypercube graph (section 5.2; section 6 for non-symmetric robots).
pub fn hypercube_astar(
    field: &LatticeField,
    start: LatticeCell,
    goal: LatticeCell,
    weights: &SwitchWeights,
    budget: SearchBudget,
) -> DimibotAnswer<FlipPath> {
    let stages = HypercubeStages::new(field.lattice(), weights);
    let estimate = move |cell: LatticeCell| stages.remaining(cell, goal);
    best_first(field, start, goal, weights, budget, estimate)
}

/// Straight-line distance times the least cost per distance of any module, rounded down.
fn straight_line(lattice: &Lattice, goal: LatticeCell, weights: &SwitchWeights) -> impl Fn(LatticeCell) -> u64 + use<> {
    let stroke = SwitchWeights::distance(lattice);
    let cheapest =
        all_flips(lattice).map(|flip| weights.of(flip) as f64 / stroke.of(flip) as f64).fold(f64::INFINITY, f64::min);
    let unit = [Side::Left, Side::Right].map(|side| stroke.of(Flip::of_bit(side, 1)) as f64);
    move |cell| {
        let run = f64::from(cell.x.abs_diff(goal.x)) * unit[0];
        let rise = f64::from(cell.y.abs_diff(goal.y)) * unit[1];
        // Slightly reduced, so that rounding up at an exact integer cannot make it inadmissible.
        (run.hypotenuse(rise) * cheapest * (1.0 - 1e-12)) as u64
    }
}

fn all_flips(lattice: &Lattice) -> impl Iterator<Item = Flip> {
    let of = |side| bits(lattice.last(side)).map(move |bit| Flip::of_bit(side, bit));
    of(Side::Left).chain(of(Side::Right)).collect::<Vec<_>>().into_iter()
}

/// The dimensions of the hypercube graph: 4 elements where a stage has a module on both sides, 2 where it has one.
struct HypercubeStages {
    /// For each stage the weight of a step along its dimension and the bit of its left and right module, if it has one.
    stages: Vec<(u64, [Option<u32>; 2])>,
}

impl HypercubeStages {
    fn new(lattice: &Lattice, weights: &SwitchWeights) -> Self {
        let count = lattice.modules[0].max(lattice.modules[1]);
        let stage = |down: u32| {
            let bit = |side: Side| {
                let module = lattice.modules[side.index()].checked_sub(down + 1)?;
                Some(1_u32 << module)
            };
            let modules = Side::BOTH.map(bit);
            let cost = |side: Side| modules[side.index()].map(|b| weights.of(Flip::of_bit(side, b)));
            let weight = Side::BOTH.into_iter().filter_map(cost).min().unwrap_or(0);
            (weight, modules)
        };
        HypercubeStages { stages: (0..count).map(stage).collect() }
    }

    /// Algorithm 2: the row of a cell in one dimension, in the order 00, 01, 11, 10 of (left, right).
    fn position(cell: LatticeCell, modules: [Option<u32>; 2]) -> u32 {
        let on = |at: u32, bit: Option<u32>| bit.is_some_and(|b| at & b != 0);
        match (on(cell.x, modules[0]), on(cell.y, modules[1])) {
            (false, false) => 1,
            (false, true) => 2,
            (true, true) => 3,
            // A stage without a right module has the elements 1 and 2 only.
            (true, false) if modules[1].is_none() => 2,
            (true, false) => 4,
        }
    }

    /// Algorithm 3.
    fn remaining(&self, cell: LatticeCell, goal: LatticeCell) -> u64 {
        let along = |(weight, modules): &(u64, [Option<u32>; 2])| {
            let apart = HypercubeStages::position(cell, *modules).abs_diff(HypercubeStages::position(goal, *modules));
            u64::from(apart % 2) * weight
        };
        self.stages.iter().map(along).sum()
    }
}

/// Least cost so far of each cell, and the flip that led to it.
type ReachedCells = FxHashMap<LatticeCell, (u64, Option<Flip>)>;
type Queue = BinaryHeap<Reverse<(u64, u64, LatticeCell)>>;

fn best_first(
    field: &LatticeField,
    start: LatticeCell,
    goal: LatticeCell,
    weights: &SwitchWeights,
    budget: SearchBudget,
    estimate: impl Fn(LatticeCell) -> u64,
) -> DimibotAnswer<FlipPath> {
    if let Some(proof) = refused(field, start, goal) {
        return DimibotAnswer::impossible(proof, 0);
    }
    let mut meter = Meter::new(budget);
    let mut reached = ReachedCells::from_iter([(start, (0, None))]);
    let mut queue = Queue::from([Reverse((estimate(start), 0, start))]);
    let mut work = field.work();
    let (mut reader, _) = work.open(field);
    while let Some(Reverse((total, cost, cell))) = queue.pop() {
        if cell == goal {
            let flips = trail(&reached, goal);
            return DimibotAnswer::Found(FlipPath { flips, cost, bound: cost, expanded: meter.spent() });
        }
        if reached.get(&cell).is_some_and(|(best, _)| *best < cost) {
            continue;
        }
        if meter.step().is_none() {
            return DimibotAnswer::GaveUp(meter.gave_up(total));
        }
        for flip in legal_flips(&mut reader, cell) {
            let (next, cost) = (cell.after(flip), cost + weights.of(flip));
            if improves(&mut reached, next, cost, flip) {
                queue.push(Reverse((cost + estimate(next), cost, next)));
            }
        }
    }
    let cells = reached.len() as u64;
    DimibotAnswer::impossible(Proof::StartShut { cells }, meter.spent())
}

/// Dijkstra's algorithm from both ends (section 4.2).
pub fn bidirectional_dijkstra(
    field: &LatticeField,
    start: LatticeCell,
    goal: LatticeCell,
    weights: &SwitchWeights,
    budget: SearchBudget,
) -> DimibotAnswer<FlipPath> {
    if let Some(proof) = refused(field, start, goal) {
        return DimibotAnswer::impossible(proof, 0);
    }
    let mut meter = Meter::new(budget);
    let mut reached = [start, goal].map(|end| ReachedCells::from_iter([(end, (0, None))]));
    let mut queues = [start, goal].map(|end| Queue::from([Reverse((0, 0, end))]));
    let mut best = (start == goal).then_some((0, start));
    let mut work = field.work();
    let (mut reader, _) = work.open(field);
    loop {
        let tops = [0, 1].map(|k: usize| queues[k].peek().map(|top| top.0.0));
        let [Some(from_start), Some(from_goal)] = tops else {
            break;
        };
        if best.is_some_and(|(cost, _)| from_start + from_goal >= cost) {
            break;
        }
        let k = usize::from(from_goal < from_start);
        let Some(Reverse((_, cost, cell))) = queues[k].pop() else {
            break;
        };
        if reached[k].get(&cell).is_some_and(|(known, _)| *known < cost) {
            continue;
        }
        if meter.step().is_none() {
            return DimibotAnswer::GaveUp(meter.gave_up(from_start + from_goal));
        }
        for flip in legal_flips(&mut reader, cell) {
            let (next, cost) = (cell.after(flip), cost + weights.of(flip));
            if !improves(&mut reached[k], next, cost, flip) {
                continue;
            }
            queues[k].push(Reverse((cost, cost, next)));
            if let Some((rest, _)) = reached[1 - k].get(&next) {
                best = best.into_iter().chain([(cost + rest, next)]).min();
            }
        }
    }
    joined(&reached, best, &meter, queues[0].is_empty())
}

fn joined(
    reached: &[ReachedCells; 2],
    best: Option<(u64, LatticeCell)>,
    meter: &Meter,
    start_is_shut: bool,
) -> DimibotAnswer<FlipPath> {
    let expanded = meter.spent();
    match best {
        Some((cost, middle)) => {
            let mut flips = trail(&reached[0], middle);
            flips.extend(trail(&reached[1], middle).into_iter().rev());
            DimibotAnswer::Found(FlipPath { flips, cost, bound: cost, expanded })
        }
        None if start_is_shut => {
            let cells = reached[0].len() as u64;
            DimibotAnswer::impossible(Proof::StartShut { cells }, expanded)
        }
        None => {
            let cells = reached[1].len() as u64;
            DimibotAnswer::impossible(Proof::GoalShut { cells }, expanded)
        }
    }
}

fn refused(field: &LatticeField, start: LatticeCell, goal: LatticeCell) -> Option<Proof> {
    outside(field, start, goal)
        .or_else(|| field.legal(start).is_none().then_some(Proof::StartCovered))
        .or_else(|| field.legal(goal).is_none().then_some(Proof::GoalCovered))
}

fn legal_flips(reader: &mut LineReader<'_>, cell: LatticeCell) -> impl Iterator<Item = Flip> + use<> {
    let [left, right] = reader.legal(cell.pair()).unwrap_or([0, 0]);
    let of = |side, mask| bits(mask).map(move |bit| Flip::of_bit(side, bit));
    of(Side::Left, left).chain(of(Side::Right, right))
}

fn improves(reached: &mut ReachedCells, cell: LatticeCell, cost: u64, by: Flip) -> bool {
    let known = reached.entry(cell).or_insert((u64::MAX, None));
    let better = cost < known.0;
    if better {
        *known = (cost, Some(by));
    }
    better
}

/// Flips from the search's origin to the cell.
fn trail(reached: &ReachedCells, mut cell: LatticeCell) -> Vec<Flip> {
    let mut flips = Vec::new();
    while let Some((_, Some(flip))) = reached.get(&cell) {
        flips.push(*flip);
        cell = cell.after(*flip);
    }
    flips.reverse();
    flips
}
