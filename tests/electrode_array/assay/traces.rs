//! Traces of fluids on the cells of a board, for the brute force: one bit per fluid.

use super::Stand;
use super::program::{Assay, Cell, Fluid, NOWHERE, Operation};

pub struct Traces {
    size: Cell,
    /// Fluids of each part, by part and number of operations done.
    fluids: Vec<Vec<u32>>,
    /// Pairs of fluids (of, within): traces of the first contaminate the second.
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

    /// A board without traces; without cells if no contamination is possible.
    pub fn clean(&self) -> Vec<u32> {
        let cells = if self.avoided.is_empty() { 0 } else { self.size.0 * self.size.1 };
        vec![0; cells as usize]
    }

    /// The traces after parts have arrived at cells and done what they do there; `None` if one of them touches a trace
    /// that contaminates it.
    pub fn left(&self, cells: &[Option<Cell>], stands: &[Stand], left: &[u32]) -> Option<Vec<u32>> {
        let mut left = left.to_vec();
        if left.is_empty() {
            return Some(left);
        }
        // Droplets that were on a cell in this step already: one that leaves while another is dispensed there shares
        // the cell with it.
        let mut now: Vec<(Cell, u32)> = Vec::new();
        let there = stands.iter().enumerate().filter_map(|(part, stand)| {
            let (cell, own) = match stand {
                Some((cell, done, ..)) => (Some(*cell), self.fluids[part][*done]),
                None => (cells[part], self.fluids[part][self.fluids[part].len() - 1]),
            };
            Some((cell.filter(|cell| *cell != NOWHERE)?, own))
        });
        let mut there: Vec<(Cell, u32)> = there.collect();
        // Washes come first, because they remove traces at the instant at which they arrive.
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
