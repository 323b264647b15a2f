//! What parts leave on the cells of a board, for the brute force: one bit for each fluid.

use super::Stand;
use super::program::{Assay, Cell, Fluid, NOWHERE, Operation};

pub struct Traces {
    size: Cell,
    /// By part and number of things done: its fluids.
    fluids: Vec<Vec<u32>>,
    /// What is avoided in what.
    avoided: Vec<(u32, u32)>,
    washes: u32,
}

fn bit(fluid: Fluid) -> u32 {
    match fluid {
        Fluid::Part(part) => 1 << part,
        Fluid::Reservoir(reservoir) => 1 << (16 + reservoir),
    }
}

impl Traces {
    pub fn of(assay: &Assay) -> Traces {
        let first = |(part, cell): (usize, &Cell)| if *cell == NOWHERE { 0 } else { bit(Fluid::Part(part)) };
        let mut now: Vec<u32> = assay.parts.iter().enumerate().map(first).collect();
        let mut fluids: Vec<Vec<u32>> = vec![Vec::new(); now.len()];
        for operation in &assay.operations {
            match operation {
                Operation::Move(part, stops) => fluids[*part].extend(stops.iter().map(|_| now[*part])),
                Operation::Incubate(part, ..) | Operation::Mix(part, ..) | Operation::Discard(part, _) => {
                    fluids[*part].push(now[*part]);
                }
                Operation::Dispense(part, reservoir) => {
                    now[*part] = bit(Fluid::Reservoir(*reservoir));
                    fluids[*part].push(now[*part]);
                }
                Operation::Split(half, part, ..) => {
                    fluids[*part].extend([now[*part]; 2]);
                    now[*half] = now[*part];
                    fluids[*half].push(now[*half]);
                }
                Operation::Merge(part, with, _) => {
                    fluids[*part].push(now[*part]);
                    fluids[*with].push(now[*with]);
                    let both = now[*part] | now[*with];
                    (now[*part], now[*with]) = (both, both);
                }
            }
        }
        fluids.iter_mut().zip(now).for_each(|(own, last)| own.push(last));
        let avoided = assay.avoided.iter().map(|(of, within)| (bit(*of), bit(*within))).collect();
        let washes = assay.washes.iter().map(|fluid| bit(*fluid)).sum();
        Traces { size: assay.size, fluids, avoided, washes }
    }

    /// A board on which nothing is left; of no cells where nothing is avoided.
    pub fn clean(&self) -> Vec<u32> {
        let cells = if self.avoided.is_empty() { 0 } else { self.size.0 * self.size.1 };
        vec![0; cells as usize]
    }

    /// What is left once parts have come to some cells and done there what they do; none if one of them comes to what it must not touch.
    pub fn left(&self, cells: &[Option<Cell>], stands: &[Stand], left: &[u32]) -> Option<Vec<u32>> {
        let mut left = left.to_vec();
        if left.is_empty() {
            return Some(left);
        }
        // Who was here in this step already; who leaves as another is dispensed there is there with it.
        let mut now: Vec<(Cell, u32)> = Vec::new();
        let there = stands.iter().enumerate().filter_map(|(part, stand)| {
            let (cell, own) = match stand {
                Some((cell, done, ..)) => (Some(*cell), self.fluids[part][*done]),
                None => (cells[part], self.fluids[part][self.fluids[part].len() - 1]),
            };
            Some((cell.filter(|cell| *cell != NOWHERE)?, own))
        });
        let mut there: Vec<(Cell, u32)> = there.collect();
        // What a wash takes away is gone at the instant at which it comes.
        there.sort_by_key(|(_, own)| own & !self.washes != 0);
        for ((column, row), own) in there {
            let here = &mut left[((row - 1) * self.size.0 + column - 1) as usize];
            if own & !self.washes == 0 {
                *here = 0;
                continue;
            }
            let has = |fluids: u32, fluid: u32| fluids & fluid != 0;
            let harms = |left: u32, comes: u32| {
                self.avoided.iter().any(|(of, within)| has(left, *of) && has(comes, *within) && !has(comes, *of))
            };
            let mut with = now.iter().filter(|(other, _)| *other == (column, row));
            if harms(*here, own) || with.any(|(_, other)| harms(own, *other)) {
                return None;
            }
            now.push(((column, row), own));
            *here |= own;
        }
        Some(left)
    }
}
