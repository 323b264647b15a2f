//! One step of a task as a problem on flat cell indices.
//!
//! Input: the order, the cells of its parts, and the moves of the step. Output: a [`BoardStage`]. Guaranteed: every
//! cell that a part's centre may not take is blocked, and the cause of each blocked cell is known: the rim of the
//! board, an obstacle grown according to the model, or a part that stays.

use super::board::{self, Agent, BoardGrid, Instance};
use super::channels::broadcast::SharedChannels;
use crate::claims::electrode_array::{
    Bystanders, ElectrodeArrayAction, ElectrodeArrayMove, ElectrodeArrayObstacle, ElectrodeArrayObstacleBody,
    ElectrodeArrayOrder,
};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
use crate::plan::errors;
use crate::source::Span;
use std::ops::RangeInclusive;

/// A step of a task, ready for a planner.
pub struct BoardStage<'a> {
    pub instance: Instance,
    /// For each agent its part, and its move if it has one.
    pub agents: Vec<Actor<'a>>,
    pub ground: &'a BoardGround<'a>,
    /// The parts that stay.
    standing: Vec<CellBlocker<'a>>,
}

/// The board and its obstacles, common to all steps of a task.
pub struct BoardGround<'a> {
    obstacles: Vec<CellBlocker<'a>>,
    /// The board without obstacles, except its rim.
    pub bare: BoardGrid,
    /// The board with its obstacles.
    board: BoardGrid,
}

impl<'a> BoardGround<'a> {
    /// The board of an order and its obstacles, each grown according to the model.
    pub fn new(order: &'a ElectrodeArrayOrder) -> BoardGround<'a> {
        let obstacles: Vec<CellBlocker> =
            order.obstacles.iter().map(|obstacle| grown(obstacle, &order.facts)).collect();
        let bare = bare(order);
        let mut board = bare.clone();
        cover(&mut board, &obstacles);
        let stuck = order.obstacles.iter().filter_map(|obstacle| match obstacle.body {
            ElectrodeArrayObstacleBody::Fixed(cell) => Some(cell),
            ElectrodeArrayObstacleBody::Electrodes { .. } => None,
        });
        SharedChannels::of(&order.facts, stuck).into_iter().for_each(|channels| board.share(channels));
        BoardGround { obstacles, bare, board }
    }

    /// The obstacles, each grown.
    pub fn obstacles(&self) -> &[CellBlocker<'a>] {
        &self.obstacles
    }

    /// The board with its obstacles.
    pub fn board(&self) -> &BoardGrid {
        &self.board
    }
}

/// A part that may move in a step.
pub struct Actor<'a> {
    /// Index into the order's parts.
    pub part: usize,
    /// `None` for a part that only yields.
    pub asked: Option<&'a ElectrodeArrayMove>,
}

impl Actor<'_> {
    /// Its part's name, and the span for messages: that of its move, or of its part if it only yields.
    pub fn named<'o>(&self, order: &'o ElectrodeArrayOrder) -> (&'o str, Span) {
        let part = &order.parts[self.part];
        (&part.name, self.asked.map_or(part.span, |action| action.span))
    }
}

/// A rectangle of cells that the centres of parts may not take.
pub struct CellBlocker<'a> {
    name: &'a str,
    /// Its cell, if it is a part that stays.
    at: Option<ElectrodeCell>,
    pub span: Span,
    /// Columns and rows from 0, both ends included; may extend beyond the rim.
    pub columns: [i64; 2],
    pub rows: [i64; 2],
}

impl CellBlocker<'_> {
    /// Its name in messages.
    pub fn name(&self) -> String {
        self.at.map_or(self.name.to_owned(), |at| format!("{} at {at}", self.name))
    }

    /// Its columns and rows, clipped to a board.
    fn clipped(&self, board: &BoardGrid) -> [RangeInclusive<i64>; 2] {
        let clip = |[low, high]: [i64; 2], size: u32| low.max(0)..=high.min(i64::from(size) - 1);
        [clip(self.columns, board.width()), clip(self.rows, board.height())]
    }

    /// Whether it covers a cell of a board.
    pub fn covers(&self, cell: board::CellIndex, board: &BoardGrid) -> bool {
        let [column, row] = [i64::from(cell % board.width()), i64::from(cell / board.width())];
        (self.columns[0]..=self.columns[1]).contains(&column) && (self.rows[0]..=self.rows[1]).contains(&row)
    }

    /// Its cells on a board.
    pub fn cells(&self, board: &BoardGrid) -> impl Iterator<Item = board::CellIndex> + use<> {
        let ([columns, rows], width) = (self.clipped(board), board.width());
        rows.flat_map(move |row| columns.clone().map(move |column| row as u32 * width + column as u32))
    }

    /// Number of cells of a board that it covers.
    pub fn area(&self, board: &BoardGrid) -> usize {
        self.clipped(board).into_iter().map(Iterator::count).product()
    }
}

/// Blocks the cells of blockers by two-dimensional prefix sums: the cost is the number of cells plus the number of
/// blockers, however large these are.
fn cover(board: &mut BoardGrid, blockers: &[CellBlocker]) {
    let width = board.width() as usize + 1;
    // Differences of the number of blockers that cover a cell, along rows and along columns.
    let mut changes = vec![0i32; width * (board.height() as usize + 1)];
    for [columns, rows] in blockers.iter().map(|blocker| blocker.clipped(board)) {
        if columns.is_empty() || rows.is_empty() {
            continue;
        }
        let [from, to] = [*columns.start() as usize, *columns.end() as usize + 1];
        let [low, high] = [*rows.start() as usize * width, (*rows.end() as usize + 1) * width];
        changes[low + from] += 1;
        changes[low + to] -= 1;
        changes[high + from] -= 1;
        changes[high + to] += 1;
    }
    let mut over = vec![0i32; width];
    for row in 0..board.height() {
        let mut covered = 0;
        for column in 0..board.width() {
            let at = column as usize;
            over[at] += changes[row as usize * width + at];
            covered += over[at];
            if covered > 0 {
                board.block(board.cell(column, row));
            }
        }
    }
}

/// The flat index of a cell.
pub fn flat(order: &ElectrodeArrayOrder, cell: ElectrodeCell) -> board::CellIndex {
    (cell.row - 1) * order.facts.columns + (cell.column - 1)
}

/// The cell of a flat index.
pub fn cell(order: &ElectrodeArrayOrder, flat: board::CellIndex) -> ElectrodeCell {
    ElectrodeCell::new(flat % order.facts.columns + 1, flat / order.facts.columns + 1)
}

impl<'a> BoardStage<'a> {
    /// The stage of a step with `moves`, given the `cells` of the parts.
    pub fn new(
        order: &'a ElectrodeArrayOrder,
        ground: &'a BoardGround<'a>,
        cells: &[Option<ElectrodeCell>],
        moves: &'a [ElectrodeArrayMove],
    ) -> BoardStage<'a> {
        let asked = |part: usize| moves.iter().find(|action| action.part == part || action.with == Some(part));
        let (mut agents, mut actors, mut standing) = (Vec::new(), Vec::new(), Vec::new());
        // Parts with moves come first, in written order, which is their priority.
        for action in moves {
            for part in action.parts() {
                let Some(start) = cells[part] else { continue };
                let stops = action.stops.iter().map(|stop| flat(order, stop.cell)).collect();
                agents.push(Agent { start: flat(order, start), stops });
                actors.push(Actor { part, asked: Some(action) });
            }
        }
        for (part, cell) in cells.iter().enumerate() {
            let (Some(at), None) = (*cell, asked(part)) else { continue };
            match order.bystanders {
                Bystanders::Yield => {
                    agents.push(Agent { start: flat(order, at), stops: vec![flat(order, at)] });
                    actors.push(Actor { part, asked: None });
                }
                Bystanders::Stay => {
                    let part = &order.parts[part];
                    let around = square(&part.name, part.span, at, order.facts.separation.apart());
                    standing.push(CellBlocker { at: Some(at), ..around });
                }
            }
        }
        let mut board = ground.board.clone();
        for blocker in &standing {
            blocker.cells(&ground.bare).for_each(|cell| board.block(cell));
        }
        if let Some(channels) = ground.board.channels() {
            let stay = standing.iter().filter_map(|blocker| blocker.at).map(|at| flat(order, at));
            board.share(channels.with_standing(&stay.collect::<Vec<_>>()));
        }
        let merges = merges(&actors);
        let instance = Instance { board, separation: order.facts.separation.apart(), agents, merges };
        BoardStage { instance, agents: actors, ground, standing }
    }

    /// The cells of the parts that stay.
    pub fn standing_cells(&self, order: &ElectrodeArrayOrder) -> impl Iterator<Item = board::CellIndex> {
        self.standing_parts(order).map(|(_, at)| at)
    }

    /// The parts that stay, each with its cell.
    pub fn standing_parts(&self, order: &ElectrodeArrayOrder) -> impl Iterator<Item = (&str, board::CellIndex)> {
        self.standing.iter().filter_map(|blocker| Some((blocker.name, flat(order, blocker.at?))))
    }

    /// The first few distinct goals, as text.
    pub fn goals(&self) -> String {
        const MAX_NAMED: usize = 3;
        let mut goals: Vec<ElectrodeCell> = Vec::new();
        for goal in self.agents.iter().filter_map(|actor| Some(actor.asked?.goal().cell)) {
            if !goals.contains(&goal) {
                goals.push(goal);
            }
        }
        errors::listed(goals.iter().map(ElectrodeCell::to_string), MAX_NAMED)
    }

    /// The names of the parts that stay.
    pub fn standing_names(&self) -> impl Iterator<Item = &str> {
        self.standing.iter().map(|blocker| blocker.name)
    }

    /// All blockers, obstacles first.
    pub fn blockers(&self) -> impl Iterator<Item = &CellBlocker<'a>> {
        self.ground.obstacles.iter().chain(&self.standing)
    }
}

/// The pairs of agents that merge.
fn merges(actors: &[Actor]) -> Vec<[usize; 2]> {
    let partner = |actor: &Actor| actor.asked.and_then(|action| action.with).filter(|with| *with == actor.part);
    let seconds = actors.iter().enumerate().filter(|(_, actor)| partner(actor).is_some());
    seconds.map(|(second, _)| [second - 1, second]).collect()
}

/// The board without obstacles; its rim, which no centre can take, is blocked.
fn bare(order: &ElectrodeArrayOrder) -> BoardGrid {
    let facts = &order.facts;
    let mut board = BoardGrid::new(facts.columns, facts.rows);
    for row in 1..=facts.rows {
        for column in 1..=facts.columns {
            let cell = ElectrodeCell::new(column, row);
            if !facts.reaches(cell) {
                board.block(flat(order, cell));
            }
        }
    }
    board
}

/// An obstacle, grown according to the model.
fn grown<'a>(obstacle: &'a ElectrodeArrayObstacle, facts: &ElectrodeArrayFacts) -> CellBlocker<'a> {
    match obstacle.body {
        ElectrodeArrayObstacleBody::Fixed(cell) => {
            square(&obstacle.name, obstacle.span, cell, facts.separation.apart())
        }
        ElectrodeArrayObstacleBody::Electrodes { from, to } => {
            let growth = i64::from(facts.clearance) - 1;
            let grown = |low: u32, high: u32| [i64::from(low) - 1 - growth, i64::from(high) - 1 + growth];
            CellBlocker {
                name: &obstacle.name,
                at: None,
                span: obstacle.span,
                columns: grown(from.column, to.column),
                rows: grown(from.row, to.row),
            }
        }
    }
}

/// Blocker of all cells nearer than `distance` to a part that stays at `cell`.
fn square<'a>(name: &'a str, span: Span, cell: ElectrodeCell, distance: u32) -> CellBlocker<'a> {
    let reach = i64::from(distance) - 1;
    let around = |at: u32| [i64::from(at) - 1 - reach, i64::from(at) - 1 + reach];
    CellBlocker { name, at: None, span, columns: around(cell.column), rows: around(cell.row) }
}

/// Visits the stages of all steps with moves; `look` gets the index of the step, its stage, and the cells before it.
pub fn each_stage(
    order: &ElectrodeArrayOrder,
    ground: &BoardGround,
    start: &[Option<ElectrodeCell>],
    mut look: impl FnMut(usize, &BoardStage, &[Option<ElectrodeCell>]),
) {
    let mut cells = start.to_vec();
    for (index, step) in order.steps.iter().enumerate() {
        if let ElectrodeArrayAction::Move(moves) = &step.action {
            look(index, &BoardStage::new(order, ground, &cells, moves), &cells);
            arrive(&mut cells, moves);
        }
    }
}

/// The cells of every part of the order over time, from the paths of the agents.
pub fn moves_of(
    order: &ElectrodeArrayOrder,
    stage: &BoardStage,
    cells: &[Option<ElectrodeCell>],
    paths: &board::Paths,
) -> Vec<Vec<ElectrodeCell>> {
    let mut motion: Vec<Vec<ElectrodeCell>> = cells.iter().map(|cell| cell.iter().copied().collect()).collect();
    for (actor, path) in stage.agents.iter().zip(paths) {
        motion[actor.part] = path.iter().map(|flat| cell(order, *flat)).collect();
    }
    motion
}

/// Updates the cells of the parts after moves.
pub fn arrive(cells: &mut [Option<ElectrodeCell>], moves: &[ElectrodeArrayMove]) {
    for action in moves {
        cells[action.part] = Some(action.goal().cell);
        if let Some(gone) = action.with {
            cells[gone] = None;
        }
    }
}
