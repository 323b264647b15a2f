//! The problem of many parts on one board, in flat numbers: cells, the rule of distance, what is asked, what a plan is.
//!
//! A cell is one number, `row * width + column`, both from 0. One step moves each part to one of its four neighbours or leaves it.
//! The rule of distance is a rule about pairs of positions at the same and at neighbouring instants: a part at `q` at instant
//! `t` and another at `p` at `t - 1`, `t` or `t + 1` keep the Chebyshev distance of the rule. That is the rule for steps
//! "all four combinations of the starts and ends of two parts", taken apart into single positions, so a path is legal exactly if
//! no position of it lies too near to three positions of another; no pair of moves has to be looked at.

use crate::plan::search::SearchAnswer;
use fixedbitset::FixedBitSet;

/// A cell: `row * width + column`, both from 0.
pub type CellIndex = u32;

/// The cells that the centre of a part may take.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BoardGrid {
    width: u32,
    height: u32,
    /// One bit for each cell, row by row; set where a centre may not be.
    blocked: FixedBitSet,
}

impl BoardGrid {
    /// A board without a blocked cell; at most `u32::MAX` cells.
    pub fn new(width: u32, height: u32) -> BoardGrid {
        let cells = width as usize * height as usize;
        BoardGrid { width, height, blocked: FixedBitSet::with_capacity(cells) }
    }

    /// Columns.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// How many cells there are, blocked ones with them.
    pub fn cells(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The cell of a column and a row, both from 0.
    pub fn cell(&self, column: u32, row: u32) -> CellIndex {
        row * self.width + column
    }

    /// Column and row of a cell, both from 0.
    pub fn place(&self, cell: CellIndex) -> (u32, u32) {
        (cell % self.width, cell / self.width)
    }

    /// Blocks one cell.
    pub fn block(&mut self, cell: CellIndex) {
        self.blocked.insert(cell as usize);
    }

    /// Whether no centre may be there.
    #[inline]
    pub fn is_blocked(&self, cell: CellIndex) -> bool {
        self.blocked.contains(cell as usize)
    }

    /// Blocks every cell nearer than `distance` (Chebyshev) to a place, which need not lie on the board.
    pub fn block_around(&mut self, (column, row): (i64, i64), distance: u32) {
        let reach = i64::from(distance) - 1;
        let columns = (column - reach).max(0)..=(column + reach).min(i64::from(self.width) - 1);
        for row in (row - reach).max(0)..=(row + reach).min(i64::from(self.height) - 1) {
            for column in columns.clone() {
                self.block(self.cell(column as u32, row as u32));
            }
        }
    }

    /// The cells nearer than `distance` (Chebyshev) to a cell, itself and blocked ones with them.
    #[inline]
    pub fn around(&self, cell: CellIndex, distance: u32) -> impl Iterator<Item = CellIndex> + use<> {
        let (reach, width) = (distance - 1, self.width);
        let (column, row) = self.place(cell);
        let columns = column.saturating_sub(reach)..=column.saturating_add(reach).min(width - 1);
        let rows = row.saturating_sub(reach)..=row.saturating_add(reach).min(self.height - 1);
        rows.flat_map(move |row| columns.clone().map(move |column| row * width + column))
    }

    /// Chebyshev distance of two cells.
    #[inline]
    pub fn apart(&self, one: CellIndex, other: CellIndex) -> u32 {
        let ((c, r), (d, s)) = (self.place(one), self.place(other));
        c.abs_diff(d).max(r.abs_diff(s))
    }

    /// Manhattan distance of two cells.
    #[inline]
    pub fn manhattan(&self, one: CellIndex, other: CellIndex) -> u32 {
        let ((c, r), (d, s)) = (self.place(one), self.place(other));
        c.abs_diff(d) + r.abs_diff(s)
    }

    /// The free neighbours of a cell: right, left, down, up.
    #[inline]
    pub fn neighbours(&self, cell: CellIndex) -> impl Iterator<Item = CellIndex> + '_ {
        let (column, row) = self.place(cell);
        let beside = [
            (column + 1 < self.width).then(|| cell + 1),
            (column > 0).then(|| cell - 1),
            (row > 0).then(|| cell - self.width),
            (row + 1 < self.height).then(|| cell + self.width),
        ];
        beside.into_iter().flatten().filter(|cell| !self.is_blocked(*cell))
    }
}

/// What is asked of one part in one stage.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Agent {
    pub start: CellIndex,
    /// Where it has to come by, in this order; the last one is its goal, where it stays. Never empty: a part that only
    /// steps aside has its start as its goal.
    pub stops: Vec<CellIndex>,
}

impl Agent {
    /// Where it ends.
    pub fn goal(&self) -> CellIndex {
        *self.stops.last().expect("an agent has a goal")
    }
}

/// One stage: parts that move at the same time. Parts that cannot move are blocked cells.
///
/// Starts keep the rule among each other, and so do goals (the pairs of `merges` apart); no start, stop or goal is blocked. The
/// order of the agents is their priority where a planner uses one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Instance {
    pub board: BoardGrid,
    /// The least Chebyshev distance of two centres at the same and at neighbouring instants; at least 1.
    pub separation: u32,
    pub agents: Vec<Agent>,
    /// Pairs that have one common goal, the smaller index first. For them a position on that goal is never too near, and
    /// each of them stays on it from its first instant there. Neither has other stops.
    pub merges: Vec<[usize; 2]>,
}

impl Instance {
    /// The common goal of two agents that merge.
    pub fn merge_cell(&self, one: usize, other: usize) -> Option<CellIndex> {
        let pair = [one.min(other), one.max(other)];
        self.merges.contains(&pair).then(|| self.agents[one].goal())
    }

    /// Whether two positions of two agents, at the same or at neighbouring instants, are too near.
    #[inline]
    pub fn too_near(&self, (one, at): (usize, CellIndex), (other, other_at): (usize, CellIndex)) -> bool {
        self.board.apart(at, other_at) < self.separation
            && !self.merge_cell(one, other).is_some_and(|goal| at == goal || other_at == goal)
    }
}

/// The way of each agent, from its start to its last arrival at its goal: position `t` is where it is at instant `t`; past the end
/// it stays on its goal.
pub type Paths = Vec<Vec<CellIndex>>;

/// Where an agent is at an instant.
#[inline]
pub fn position(path: &[CellIndex], instant: usize) -> CellIndex {
    path[instant.min(path.len() - 1)]
}

/// What is minimised. Both break ties by the other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoardObjective {
    /// The instant of the last arrival.
    Makespan,
    /// The sum over all agents of the instant of their last arrival.
    SumOfCosts,
}

/// A makespan and a sum of costs: of a plan, or below every plan.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BoardCosts {
    pub makespan: u64,
    pub sum_of_costs: u64,
}

impl BoardCosts {
    /// Those of a plan.
    pub fn of(paths: &Paths) -> BoardCosts {
        let arrivals = paths.iter().map(|path| path.len() as u64 - 1);
        BoardCosts { makespan: arrivals.clone().max().unwrap_or(0), sum_of_costs: arrivals.sum() }
    }

    /// In the order in which an objective compares.
    pub fn key(self, objective: BoardObjective) -> (u64, u64) {
        match objective {
            BoardObjective::Makespan => (self.makespan, self.sum_of_costs),
            BoardObjective::SumOfCosts => (self.sum_of_costs, self.makespan),
        }
    }
}

/// What became of a stage; a search that gave up has bounds below which there is no plan.
pub type BoardAnswer = SearchAnswer<BoardPlan, NoBoardPlan, BoardCosts>;

/// A plan of a stage, with bounds below which there is none; whatever meets its bound is proven optimal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BoardPlan {
    pub paths: Paths,
    pub bounds: BoardCosts,
}

/// Why there is no plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NoBoardPlan {
    /// This agent alone cannot come to this of its stops: blocked cells close the way.
    Closed { agent: usize, stop: usize },
    /// These agents cannot pass one another, whatever the others do; the fewest that were found.
    Blocked { agents: Vec<usize> },
    /// There are plans, or there may be, but none with so few steps.
    TooFewSteps { least: u64 },
}
