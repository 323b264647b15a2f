//! One step of a task as a problem in flat numbers.
//!
//! Input: the order, where its parts stand, and what the step asks for. Output: a [`Stage`]. Promise: every cell that a part's
//! centre may not take is blocked, and each blocked cell is known by what blocks it: the rim of the board, an obstacle grown
//! as the model says, or a part that stays where it is.

use super::board::{self, Agent, Board, Instance};
use crate::check::claims::electrode_array::{Body, Bystanders, ElectrodeArrayOrder, Move};
use crate::device::electrode_array::Cell;
use crate::source::Span;

/// A step of a task, ready for a planner.
pub struct Stage<'a> {
    pub instance: Instance,
    /// For each agent its part, and the move that asks for it, if one does.
    pub agents: Vec<Actor<'a>>,
    pub blockers: Vec<Blocker>,
    /// The board with nothing on it but its rim.
    pub bare: Board,
}

/// A part that may move in a step.
pub struct Actor<'a> {
    /// Index of the order's parts.
    pub part: usize,
    /// `None` for one that only steps aside.
    pub asked: Option<&'a Move>,
}

/// Something that closes a rectangle of cells to the centres of parts.
pub struct Blocker {
    pub name: String,
    pub span: Span,
    /// Columns and rows from 0, both ends included; may reach over the rim.
    pub columns: [i64; 2],
    pub rows: [i64; 2],
}

impl Blocker {
    /// Its cells on a board.
    pub fn cells(&self, board: &Board) -> impl Iterator<Item = board::Cell> + use<> {
        let clip = |[low, high]: [i64; 2], size: u32| low.max(0)..=high.min(i64::from(size) - 1);
        let (columns, width) = (clip(self.columns, board.width()), board.width());
        clip(self.rows, board.height())
            .flat_map(move |row| columns.clone().map(move |column| row as u32 * width + column as u32))
    }
}

/// The number of a cell on the planner's board.
pub fn flat(order: &ElectrodeArrayOrder, cell: Cell) -> board::Cell {
    (cell.row - 1) * order.facts.columns + (cell.column - 1)
}

/// The cell of a number on the planner's board.
pub fn cell(order: &ElectrodeArrayOrder, flat: board::Cell) -> Cell {
    Cell::new(flat % order.facts.columns + 1, flat / order.facts.columns + 1)
}

impl<'a> Stage<'a> {
    /// The stage of a step that asks for `moves`, the parts standing at `cells`.
    pub fn new(order: &ElectrodeArrayOrder, cells: &[Option<Cell>], moves: &'a [Move]) -> Stage<'a> {
        let asked = |part: usize| moves.iter().find(|action| action.part == part || action.with == Some(part));
        let (mut agents, mut actors, mut blockers) = (Vec::new(), Vec::new(), obstacles(order));
        // Those that are asked for come first, in the order of writing, which is their priority.
        for action in moves {
            for part in [Some(action.part), action.with].into_iter().flatten() {
                let Some(start) = cells[part] else { continue };
                let stops = action.stops.iter().map(|stop| flat(order, stop.cell)).collect();
                agents.push(Agent { start: flat(order, start), stops });
                actors.push(Actor { part, asked: Some(action) });
            }
        }
        for (part, standing) in cells.iter().enumerate() {
            let (Some(at), None) = (*standing, asked(part)) else { continue };
            match order.bystanders {
                Bystanders::Yield => {
                    agents.push(Agent { start: flat(order, at), stops: vec![flat(order, at)] });
                    actors.push(Actor { part, asked: None });
                }
                Bystanders::Stay => {
                    let part = &order.parts[part];
                    let name = format!("{} at {at}", part.name);
                    blockers.push(square(name, part.span, at, order.facts.separation.apart()));
                }
            }
        }
        let bare = bare(order);
        let mut board = bare.clone();
        for blocker in &blockers {
            blocker.cells(&bare).for_each(|cell| board.block(cell));
        }
        let merges = merges(&actors);
        let instance = Instance { board, separation: order.facts.separation.apart(), agents, merges };
        Stage { instance, agents: actors, blockers, bare }
    }
}

/// The pairs of agents that become one.
fn merges(actors: &[Actor]) -> Vec<[usize; 2]> {
    let partner = |actor: &Actor| actor.asked.and_then(|action| action.with).filter(|with| *with == actor.part);
    let seconds = actors.iter().enumerate().filter(|(_, actor)| partner(actor).is_some());
    seconds.map(|(second, _)| [second - 1, second]).collect()
}

/// The board with its rim, where no centre can be.
fn bare(order: &ElectrodeArrayOrder) -> Board {
    let facts = &order.facts;
    let mut board = Board::new(facts.columns, facts.rows);
    for row in 1..=facts.rows {
        for column in 1..=facts.columns {
            let cell = Cell::new(column, row);
            if !facts.reaches(cell) {
                board.block(flat(order, cell));
            }
        }
    }
    board
}

fn obstacles(order: &ElectrodeArrayOrder) -> Vec<Blocker> {
    let facts = &order.facts;
    let blocker = |obstacle: &crate::check::claims::electrode_array::Obstacle| match obstacle.body {
        Body::Fixed(cell) => square(obstacle.name.clone(), obstacle.span, cell, facts.separation.apart()),
        Body::Electrodes { from, to } => {
            let growth = i64::from(facts.clearance) - 1;
            let grown = |low: u32, high: u32| [i64::from(low) - 1 - growth, i64::from(high) - 1 + growth];
            Blocker {
                name: obstacle.name.clone(),
                span: obstacle.span,
                columns: grown(from.column, to.column),
                rows: grown(from.row, to.row),
            }
        }
    };
    order.obstacles.iter().map(blocker).collect()
}

/// All cells nearer than `distance` to a part that stays at `cell`.
fn square(name: String, span: Span, cell: Cell, distance: u32) -> Blocker {
    let reach = i64::from(distance) - 1;
    let around = |at: u32| [i64::from(at) - 1 - reach, i64::from(at) - 1 + reach];
    Blocker { name, span, columns: around(cell.column), rows: around(cell.row) }
}
