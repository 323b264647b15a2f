//! The default search of the DiMiBot planner.
//!
//! Problem: the cheapest sequence of single flips between two cells. Method: a greedy walk that only switches modules toward the goal, whose cost is
//! the XOR distance and therefore optimal when it arrives; then [`super::layers`]. Guaranteed: complete, and optimal unless the budget runs out.
//! One step of the budget is one settled cell.

use super::field::{Field, Reader};
use super::lattice::{Cell, Flip, Side, Weights};
use super::layers::{Layered, Search};
use super::outcome::{Outcome, Path, Proof};
use crate::plan::search::{Budget, GaveUp, Meter};

/// The cheapest path of single flips from `start` to `goal`.
pub fn shortest(field: &Field, start: Cell, goal: Cell, weights: &Weights, budget: Budget) -> Outcome<Path> {
    if let Some(proof) = outside(field, start, goal) {
        return Outcome::impossible(proof, 0);
    }
    let mut work = field.work();
    let (mut reader, space) = work.open(field);
    let ends = [start.pair(), goal.pair()];
    for (end, proof) in ends.iter().zip([Proof::StartCovered, Proof::GoalCovered]) {
        if reader.legal(*end).is_none() {
            return Outcome::impossible(proof, 0);
        }
    }
    if let Some(flips) = walk(&mut reader, ends) {
        let cost = weights.between(start, goal);
        let expanded = flips.len() as u64;
        return Outcome::Found(Path { flips, cost, bound: cost, expanded });
    }
    let mut meter = Meter::new(budget);
    if std::env::var("ENGINE").is_err() {
        let (reader, space) = work.open_guided(field);
        let found = space.search(reader, weights, ends, &mut meter);
        return guided(found, weights, meter.spent());
    }
    let found = Search::new(reader, space, weights, ends, &mut meter).run(ends);
    let base = weights.between(start, goal);
    outcome(found, base, meter.spent())
}

fn outcome(found: Layered, base: u64, expanded: u64) -> Outcome<Path> {
    match found {
        Layered::Path { flips, excess, bound } => {
            Outcome::Found(Path { flips, cost: base + excess, bound: base + bound, expanded })
        }
        Layered::StartShut(cells) => Outcome::impossible(Proof::StartShut { cells }, expanded),
        Layered::GoalShut(cells) => Outcome::impossible(Proof::GoalShut { cells }, expanded),
        Layered::GaveUp(gave_up) => Outcome::GaveUp(GaveUp { bound: base + gave_up.bound, ..gave_up }),
    }
}

fn guided(found: super::guided::Guided, weights: &Weights, expanded: u64) -> Outcome<Path> {
    use super::guided::Guided;
    match found {
        Guided::Path(flips) => {
            let cost = flips.iter().map(|flip| weights.of(*flip)).sum();
            Outcome::Found(Path { flips, cost, bound: cost, expanded })
        }
        Guided::StartShut(cells) => Outcome::impossible(Proof::StartShut { cells }, expanded),
        Guided::GoalShut(cells) => Outcome::impossible(Proof::GoalShut { cells }, expanded),
        Guided::GaveUp(report) => Outcome::GaveUp(report),
    }
}

/// The proof that there is no plan when a cell does not belong to the lattice.
pub(super) fn outside(field: &Field, start: Cell, goal: Cell) -> Option<Proof> {
    if !field.lattice().contains(start) {
        return Some(Proof::StartOutside);
    }
    (!field.lattice().contains(goal)).then_some(Proof::GoalOutside)
}

/// Switches the largest module that may switch and stands differently, until the goal is reached or none is left.
fn walk(reader: &mut Reader<'_>, [start, goal]: [[u32; 2]; 2]) -> Option<Vec<Flip>> {
    let mut at = start;
    let mut flips = Vec::with_capacity(((at[0] ^ goal[0]).count_ones() + (at[1] ^ goal[1]).count_ones()) as usize);
    while at != goal {
        let legal = reader.legal(at)?;
        let toward = |k: usize| legal[k] & (at[k] ^ goal[k]);
        let side = if toward(0) >= toward(1) { Side::Left } else { Side::Right };
        let module = toward(side.index()).checked_ilog2()?;
        at[side.index()] ^= 1 << module;
        flips.push(Flip { side, module: module as u8 });
    }
    Some(flips)
}
