//! The default search of the DiMiBot planner.
//!
//! Problem: the cheapest sequence of single flips between two cells. Method: a greedy walk that only switches modules toward the
//! goal, whose cost is the XOR distance and therefore optimal when it arrives; then [`super::journey`]. Guaranteed: complete, and
//! optimal unless the budget runs out. One step of the budget is one cell queued.

use super::field::LatticeField;
use super::journey::LatticeJourney;
use super::lattice::{Flip, LatticeCell, Side, SwitchWeights, bits};
use super::lines::LineReader;
use super::outcome::{DimibotAnswer, FlipPath, Proof};
use crate::plan::search::SearchBudget;

/// The cheapest path of single flips from `start` to `goal`.
pub fn shortest(
    field: &LatticeField,
    start: LatticeCell,
    goal: LatticeCell,
    weights: &SwitchWeights,
    budget: SearchBudget,
) -> DimibotAnswer<FlipPath> {
    if let Some(proof) = outside(field, start, goal) {
        return DimibotAnswer::impossible(proof, 0);
    }
    let mut work = field.work();
    let (mut reader, space) = work.open(field);
    let ends = [start.pair(), goal.pair()];
    if start != goal
        && let Some(flips) = walk(&mut reader, ends)
    {
        let cost = weights.between(start, goal);
        let expanded = flips.len() as u64;
        return DimibotAnswer::Found(FlipPath { flips, cost, bound: cost, expanded });
    }
    for (end, proof) in ends.into_iter().zip([Proof::StartCovered, Proof::GoalCovered]) {
        if reader.legal(end).is_none() {
            return DimibotAnswer::impossible(proof, 0);
        }
    }
    if start == goal {
        return DimibotAnswer::Found(FlipPath { flips: Vec::new(), cost: 0, bound: 0, expanded: 0 });
    }
    LatticeJourney::new(reader, weights, ends, budget).run(space)
}

/// The proof that there is no plan, if a cell does not belong to the lattice.
pub(super) fn outside(field: &LatticeField, start: LatticeCell, goal: LatticeCell) -> Option<Proof> {
    if !field.lattice().contains(start) {
        return Some(Proof::StartOutside);
    }
    (!field.lattice().contains(goal)).then_some(Proof::GoalOutside)
}

/// A path that only switches modules whose states differ, so that no path is cheaper. First all modules of one side
/// before all of the other, in both orders, are tried; then a greedy walk that always switches the largest legal one.
/// Every cell entered is checked, so it fails if an end is covered, unless start and goal are the same.
fn walk(reader: &mut LineReader<'_>, [start, goal]: [[u32; 2]; 2]) -> Option<Vec<Flip>> {
    let differing = [start[0] ^ goal[0], start[1] ^ goal[1]];
    let mut flips = Vec::with_capacity((differing[0].count_ones() + differing[1].count_ones()) as usize);
    for first in Side::BOTH {
        let second = first.other();
        let mut corner = start;
        corner[first.index()] = goal[first.index()];
        if stretch_is_free(reader, start, goal, first) && stretch_is_free(reader, corner, goal, second) {
            for side in [first, second] {
                flips.extend(bits(differing[side.index()]).map(|bit| Flip::of_bit(side, bit)));
            }
            return Some(flips);
        }
    }
    let mut at = start;
    while at != goal {
        let legal = reader.legal(at)?;
        let toward = |k: usize| legal[k] & (at[k] ^ goal[k]);
        let side = if toward(0) >= toward(1) { Side::Left } else { Side::Right };
        let bit = 1 << toward(side.index()).checked_ilog2()?;
        at[side.index()] ^= bit;
        flips.push(Flip::of_bit(side, bit));
    }
    Some(flips)
}

/// Whether all differing modules of the side may switch from this cell, in any order.
fn stretch_is_free(reader: &mut LineReader<'_>, at: [u32; 2], goal: [u32; 2], side: Side) -> bool {
    let (k, across) = (side.index(), side.other().index());
    match reader.free_run(side, at[across], at[k]) {
        Some([low, high]) => low <= at[k] & goal[k] && at[k] | goal[k] <= high,
        None => false,
    }
}
