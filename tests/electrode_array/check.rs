//! Independent checker of plans: walks through a plan step by step and examines each move.
//!
//! It shares only the types of the problem with the planner: columns and rows are separated again, and the rule is
//! checked on moves (all four combinations of the starts and ends of two parts), where the planner checks single
//! positions.

use tweeze::plan::electrode_array::board::{BoardAnswer, BoardCosts, BoardPlan, CellIndex, Instance, Paths};

/// Column and row.
type Place = (i64, i64);

/// What is wrong with a plan; `None` if it is legal.
pub fn fault(instance: &Instance, paths: &Paths) -> Option<String> {
    if paths.len() != instance.agents.len() {
        return Some(format!("{} paths for {} parts", paths.len(), instance.agents.len()));
    }
    let alone = (0..paths.len()).find_map(|part| fault_alone(instance, part, &paths[part]));
    alone.or_else(|| fault_together(instance, paths))
}

/// Asserts that the plan of an answer is legal and that its bounds do not exceed its costs; returns the costs, counted
/// here, and the bounds.
pub fn judged(instance: &Instance, answer: &BoardAnswer) -> Option<(BoardCosts, BoardCosts)> {
    let BoardAnswer::Found(BoardPlan { paths, bounds }) = answer else { return None };
    assert_eq!(fault(instance, paths), None, "{instance:?}");
    let arrivals = paths.iter().map(|path| path.len() as u64 - 1);
    let costs = BoardCosts { makespan: arrivals.clone().max().unwrap_or(0), sum_of_costs: arrivals.sum() };
    assert!(bounds.makespan <= costs.makespan, "{bounds:?} above {costs:?}: {instance:?}");
    assert!(bounds.sum_of_costs <= costs.sum_of_costs, "{bounds:?} above {costs:?}: {instance:?}");
    Some((costs, *bounds))
}

fn place(instance: &Instance, cell: CellIndex) -> Place {
    let width = instance.board.width();
    (i64::from(cell % width), i64::from(cell / width))
}

/// Checks one part: from its start over free cells, one at a time, through its stops to its goal.
fn fault_alone(instance: &Instance, part: usize, path: &[CellIndex]) -> Option<String> {
    let agent = &instance.agents[part];
    let mut stops = agent.stops.iter().peekable();
    for (instant, cell) in path.iter().enumerate() {
        if *cell as usize >= instance.board.cells() || instance.board.is_blocked(*cell) {
            return Some(format!("{part} is on a blocked cell at {instant}"));
        }
        let from = place(instance, path[instant.saturating_sub(1)]);
        let to = place(instance, *cell);
        if (from.0 - to.0).abs() + (from.1 - to.1).abs() > 1 {
            return Some(format!("{part} jumps to its place of {instant}"));
        }
        while stops.next_if(|stop| *stop == cell).is_some() {}
    }
    let goal = agent.stops.last()?;
    if path.first() != Some(&agent.start) || path.last() != Some(goal) {
        return Some(format!("{part} starts or ends elsewhere"));
    }
    if path.len() > 1 && path[path.len() - 2] == *goal {
        return Some(format!("{part} has arrived before its path ends"));
    }
    let merges = instance.merges.iter().flatten().any(|merging| *merging == part);
    if merges && path[..path.len() - 1].contains(goal) {
        return Some(format!("{part} leaves the goal where it merges"));
    }
    stops.next().map(|stop| format!("{part} leaves out {stop}"))
}

/// Checks every step of all parts for moves that come too close to one another.
fn fault_together(instance: &Instance, paths: &Paths) -> Option<String> {
    let last = paths.iter().map(Vec::len).max().unwrap_or(0);
    let mut crowd = Crowd::new(instance);
    (0..last.max(1)).find_map(|step| {
        let at = |path: &[CellIndex], instant: usize| path[instant.min(path.len() - 1)];
        let moves: Vec<[CellIndex; 2]> = paths.iter().map(|path| [at(path, step), at(path, step + 1)]).collect();
        crowd.fault(&moves).map(|fault| format!("{fault} in step {step}"))
    })
}

/// Spatial grid of squares as wide as the separation, so that only parts in neighbouring squares can be too close.
struct Crowd<'a> {
    instance: &'a Instance,
    columns: i64,
    rows: i64,
    squares: Vec<Vec<(usize, CellIndex)>>,
    filled: Vec<usize>,
}

impl<'a> Crowd<'a> {
    fn new(instance: &'a Instance) -> Self {
        let side = i64::from(instance.separation);
        let count = |size: u32| i64::from(size) / side + 1;
        let (columns, rows) = (count(instance.board.width()), count(instance.board.height()));
        Crowd { instance, columns, rows, squares: vec![vec![]; (columns * rows) as usize], filled: vec![] }
    }

    fn square(&self, cell: CellIndex) -> Place {
        let (column, row) = place(self.instance, cell);
        (column / i64::from(self.instance.separation), row / i64::from(self.instance.separation))
    }

    fn fault(&mut self, moves: &[[CellIndex; 2]]) -> Option<String> {
        for square in self.filled.drain(..) {
            self.squares[square].clear();
        }
        for (part, ends) in moves.iter().enumerate() {
            for cell in ends {
                if let Some(other) = self.too_near(part, *cell) {
                    return Some(format!("{part} and {other} are too near"));
                }
            }
            for cell in ends {
                let (column, row) = self.square(*cell);
                let square = (row * self.columns + column) as usize;
                self.squares[square].push((part, *cell));
                self.filled.push(square);
            }
        }
        None
    }

    /// A part before this one that is too close to it here.
    fn too_near(&self, part: usize, cell: CellIndex) -> Option<usize> {
        let (column, row) = self.square(cell);
        self.around(column, row).find(|(other, at)| self.clash(part, cell, *other, *at)).map(|(other, _)| *other)
    }

    fn around(&self, column: i64, row: i64) -> impl Iterator<Item = &(usize, CellIndex)> {
        let columns = (column - 1).max(0)..=(column + 1).min(self.columns - 1);
        let rows = (row - 1).max(0)..=(row + 1).min(self.rows - 1);
        let squares = rows.flat_map(move |row| columns.clone().map(move |column| (row, column)));
        squares.flat_map(|(row, column)| &self.squares[(row * self.columns + column) as usize])
    }

    fn clash(&self, part: usize, cell: CellIndex, other: usize, at: CellIndex) -> bool {
        let (one, two) = (place(self.instance, cell), place(self.instance, at));
        let apart = (one.0 - two.0).abs().max((one.1 - two.1).abs());
        let merge = self.instance.merges.contains(&[other, part]);
        let goal = self.instance.agents[part].stops.last();
        let excused = merge && (goal == Some(&cell) || goal == Some(&at));
        apart < i64::from(self.instance.separation) && !excused
    }
}
