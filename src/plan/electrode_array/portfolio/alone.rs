//! One part alone: the shortest path through its stops to its goal.
//!
//! Problem: most steps of long tasks move one part past parts that stay, and those are blocked cells. Method: A* with the Manhattan
//! distance (Hart, Nilsson, Raphael 1968), from stop to stop; a move toward the stop leaves the total estimate unchanged and any
//! other adds 2, so two stacks replace the queue. Guaranteed: the shortest path, or a proof that there is none. Cost: about the
//! cells of the path where few cells are blocked, at most the cells of the board for each stop.

use crate::plan::electrode_array::board::{BoardGrid, CellIndex, Instance, NoBoardPlan};
use rustc_hash::FxHashMap;

/// The path of the only agent of an instance. The error names the first stop that is cut off.
pub fn way(instance: &Instance) -> Result<Vec<CellIndex>, NoBoardPlan> {
    let agent = &instance.agents[0];
    let mut way = vec![agent.start];
    for (stop, &to) in agent.stops.iter().enumerate() {
        let from = way[way.len() - 1];
        let leg = leg(&instance.board, from, to).ok_or(NoBoardPlan::Closed { agent: 0, stop })?;
        way.extend(leg);
    }
    Ok(way)
}

/// The cells after `from` on a shortest path to `to`.
fn leg(board: &BoardGrid, from: CellIndex, to: CellIndex) -> Option<Vec<CellIndex>> {
    let mut parents: FxHashMap<CellIndex, CellIndex> = FxHashMap::default();
    // Open cells with their parents: those of the least estimate, and those of the next one.
    let (mut now, mut next) = (vec![(from, from)], Vec::new());
    loop {
        let Some((cell, parent)) = now.pop() else {
            if next.is_empty() {
                return None;
            }
            std::mem::swap(&mut now, &mut next);
            continue;
        };
        if parents.contains_key(&cell) {
            continue;
        }
        parents.insert(cell, parent);
        if cell == to {
            break;
        }
        let distance = board.manhattan(cell, to);
        for beside in board.neighbours(cell).filter(|beside| !parents.contains_key(beside)) {
            let queue = if board.manhattan(beside, to) < distance { &mut now } else { &mut next };
            queue.push((beside, cell));
        }
    }
    let mut leg = Vec::new();
    let mut cell = to;
    while cell != from {
        leg.push(cell);
        cell = parents[&cell];
    }
    leg.reverse();
    Some(leg)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::electrode_array::board::Agent;
    use crate::random::SplitMix64;
    use std::collections::VecDeque;

    /// Path length by a plain breadth-first search.
    fn plain(board: &BoardGrid, from: CellIndex, to: CellIndex) -> Option<usize> {
        let mut steps = vec![usize::MAX; board.cells()];
        let mut open = VecDeque::from([from]);
        steps[from as usize] = 0;
        while let Some(cell) = open.pop_front() {
            for beside in board.neighbours(cell) {
                if steps[beside as usize] == usize::MAX {
                    steps[beside as usize] = steps[cell as usize] + 1;
                    open.push_back(beside);
                }
            }
        }
        Some(steps[to as usize]).filter(|steps| *steps != usize::MAX)
    }

    #[test]
    fn ways_are_as_short_as_those_of_a_plain_search() {
        let mut random = SplitMix64::new(1);
        let mut draw = |count: u32| random.below(count as usize) as u32;
        let mut closed = 0;
        for _ in 0..400 {
            let (width, height) = (1 + draw(14), 1 + draw(14));
            let mut board = BoardGrid::new(width, height);
            for _ in 0..draw(width * height) {
                board.block(draw(width * height));
            }
            let free: Vec<CellIndex> = (0..width * height).filter(|cell| !board.is_blocked(*cell)).collect();
            if free.is_empty() {
                continue;
            }
            let mut pick = || free[draw(free.len() as u32) as usize];
            let (start, stops) = (pick(), vec![pick(), pick()]);
            let legs = [plain(&board, start, stops[0]), plain(&board, stops[0], stops[1])];
            let agents = vec![Agent { start, stops }];
            let instance = Instance { board, separation: 4, agents, merges: Vec::new() };
            match (way(&instance), legs) {
                (Ok(way), [Some(first), Some(second)]) => {
                    assert_eq!(way.len() - 1, first + second);
                    assert!(way.windows(2).all(|pair| instance.board.neighbours(pair[0]).any(|cell| cell == pair[1])));
                }
                (Err(NoBoardPlan::Closed { agent: 0, stop: 0 }), [None, _]) => closed += 1,
                (Err(NoBoardPlan::Closed { agent: 0, stop: 1 }), [Some(_), None]) => closed += 1,
                (answer, legs) => panic!("{answer:?}, but {legs:?}"),
            }
        }
        assert!(closed > 20, "both outcomes are met");
    }
}
