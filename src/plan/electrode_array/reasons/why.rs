//! Finds the blockers of a part that cannot reach its goal.
//!
//! Problem: the smallest set of blockers whose removal opens a path (minimum constraint removal, NP-hard; Hauser 2014).
//! Method: the path that enters the fewest blockers, each counted at every entry, and a deletion filter on the set that
//! it crosses. Guaranteed: without the named ones there is a path, and a single named blocker is the smallest set. Not
//! guaranteed: that several are the fewest. Cost: linear in the cells of the board and of all blockers, once more for
//! each blocker on the path.

use crate::plan::electrode_array::board::{self, BoardGrid};
use crate::plan::electrode_array::stage::{BoardStage, CellBlocker};
use crate::plan::errors::Removal;
use std::collections::VecDeque;

/// If the blockers cover more cells than this in total, none is blamed.
const MAX_COVERED: usize = 1 << 23;

/// The blockers to remove, as indices into the stage's, so that a path leads from one cell to another, and what is
/// known about their removal.
pub fn why(stage: &BoardStage, from: board::CellIndex, to: board::CellIndex) -> (Vec<usize>, Removal) {
    let board = &stage.ground.bare;
    let covered: usize = stage.blockers().map(|blocker| blocker.area(board)).sum();
    if covered > MAX_COVERED {
        return (Vec::new(), Removal::Unknown);
    }
    let Some(mut crossed) = fewest_entered(stage, from, to) else { return (Vec::new(), Removal::Unknown) };
    let mut at = 0;
    while at < crossed.len() {
        let tried: Vec<usize> = crossed.iter().copied().filter(|index| *index != crossed[at]).collect();
        if is_open(stage, &tried, from, to) {
            crossed = tried;
        } else {
            at += 1;
        }
    }
    let removal = if crossed.len() == 1 { Removal::OpensAndIsSmallest } else { Removal::Opens };
    (crossed, removal)
}

/// The blockers on a path with the fewest entries.
fn fewest_entered(stage: &BoardStage, from: board::CellIndex, to: board::CellIndex) -> Option<Vec<usize>> {
    let board = &stage.ground.bare;
    let blockers: Vec<&CellBlocker> = stage.blockers().collect();
    let over = Covering::new(board, &blockers);
    let mut cost = vec![u32::MAX; board.cells()];
    let mut parent = vec![board::CellIndex::MAX; board.cells()];
    // Buckets by cost; an optimal path enters each blocker at most once.
    let mut buckets: Vec<VecDeque<board::CellIndex>> = vec![VecDeque::new(); blockers.len() + 2];
    cost[from as usize] = 0;
    buckets[0].push_back(from);
    let mut lowest = 0;
    while lowest < buckets.len() {
        let Some(here) = buckets[lowest].pop_front() else {
            lowest += 1;
            continue;
        };
        if cost[here as usize] as usize != lowest {
            continue;
        }
        for next in board.neighbours(here) {
            let entered = over.entered(here, next);
            let through = lowest + entered;
            if through < cost[next as usize] as usize && through < buckets.len() {
                cost[next as usize] = through as u32;
                parent[next as usize] = here;
                buckets[through].push_back(next);
            }
        }
    }
    (cost[to as usize] != u32::MAX).then(|| {
        let mut crossed: Vec<usize> = Vec::new();
        let mut here = to;
        while here != from {
            crossed.extend(over.of(here).iter().map(|index| *index as usize));
            here = parent[here as usize];
        }
        crossed.sort_unstable();
        crossed.dedup();
        crossed
    })
}

/// All cells that a part can reach; `None` if the blockers cover too many cells.
pub fn reached(stage: &BoardStage, from: board::CellIndex) -> Option<Vec<board::CellIndex>> {
    let covered: usize = stage.blockers().map(|blocker| blocker.area(&stage.ground.bare)).sum();
    (covered <= MAX_COVERED).then(|| {
        let mut met = Vec::new();
        flood(stage, &[], from, |cell| {
            met.push(cell);
            true
        });
        met
    })
}

/// Whether a path exists without some blockers.
fn is_open(stage: &BoardStage, gone: &[usize], from: board::CellIndex, to: board::CellIndex) -> bool {
    let mut is_met = false;
    flood(stage, gone, from, |cell| {
        is_met |= cell == to;
        !is_met
    });
    is_met
}

/// Visits the cells that can be reached without some blockers, nearest first, until `visit` returns false.
fn flood(stage: &BoardStage, gone: &[usize], from: board::CellIndex, mut visit: impl FnMut(board::CellIndex) -> bool) {
    let mut board = stage.ground.bare.clone();
    for (index, blocker) in stage.blockers().enumerate() {
        if !gone.contains(&index) {
            blocker.cells(&stage.ground.bare).for_each(|cell| board.block(cell));
        }
    }
    let mut met = vec![false; board.cells()];
    let mut open = VecDeque::from([from]);
    met[from as usize] = true;
    while let Some(here) = open.pop_front() {
        if !visit(here) {
            return;
        }
        for next in board.neighbours(here) {
            if !std::mem::replace(&mut met[next as usize], true) {
                open.push_back(next);
            }
        }
    }
}

/// The blockers of each cell, ascending, in one flat list.
struct Covering {
    starts: Vec<u32>,
    indices: Vec<u32>,
}

impl Covering {
    fn new(board: &BoardGrid, blockers: &[&CellBlocker]) -> Covering {
        let mut starts = vec![0; board.cells() + 1];
        for blocker in blockers {
            blocker.cells(board).for_each(|cell| starts[cell as usize + 1] += 1);
        }
        for at in 1..starts.len() {
            starts[at] += starts[at - 1];
        }
        let mut next = starts.clone();
        let mut indices = vec![0; starts[board.cells()] as usize];
        for (index, blocker) in blockers.iter().enumerate() {
            for cell in blocker.cells(board) {
                indices[next[cell as usize] as usize] = index as u32;
                next[cell as usize] += 1;
            }
        }
        Covering { starts, indices }
    }

    fn of(&self, cell: board::CellIndex) -> &[u32] {
        &self.indices[self.starts[cell as usize] as usize..self.starts[cell as usize + 1] as usize]
    }

    /// Number of blockers that cover `next` but not `here`.
    fn entered(&self, here: board::CellIndex, next: board::CellIndex) -> usize {
        let before = self.of(here);
        self.of(next).iter().filter(|index| before.binary_search(index).is_err()).count()
    }
}
