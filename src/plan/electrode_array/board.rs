//! The problem of many parts on one board, on flat cell indices: cells, the separation rule, instances and plans.
//!
//! A cell is one number, `row * width + column`, both from 0. In one step each part moves to one of its four neighbours
//! or stays. The separation rule concerns pairs of positions at the same and at neighbouring instants: a part at `q` at
//! instant `t` and another at `p` at `t - 1`, `t` or `t + 1` keep the required Chebyshev distance. It is equivalent to
//! the rule for steps, "all four combinations of the starts and ends of two parts", split into single positions: a path
//! is legal exactly if each of its positions keeps the distance from the three positions of every other path at `t -
//! 1`, `t` and `t + 1`. Pairs of moves need no check.

use super::channels::broadcast::SharedChannels;
use crate::claims::electrode_array::ElectrodeArrayObjective;
use crate::plan::search::SearchAnswer;
use crate::plan::watch::IncumbentPlan;
use fixedbitset::FixedBitSet;

/// A cell: `row * width + column`, both from 0.
pub type CellIndex = u32;

/// A board: the cells that the centre of a part may take.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BoardGrid {
    width: u32,
    height: u32,
    /// One bit per cell, row by row; set where no centre may be.
    blocked: FixedBitSet,
    /// `None` where each electrode has a channel of its own.
    channels: Option<Box<SharedChannels>>,
}

impl BoardGrid {
    /// A board without a blocked cell; at most `u32::MAX` cells.
    pub fn new(width: u32, height: u32) -> BoardGrid {
        let cells = width as usize * height as usize;
        BoardGrid { width, height, blocked: FixedBitSet::with_capacity(cells), channels: None }
    }

    /// Gives the board shared channels.
    pub fn share(&mut self, channels: SharedChannels) {
        self.channels = Some(Box::new(channels));
    }

    /// The same board with a channel for each electrode.
    #[must_use]
    pub fn unshared(self) -> BoardGrid {
        BoardGrid { channels: None, ..self }
    }

    /// Its shared channels, if it has any.
    #[inline]
    pub fn channels(&self) -> Option<&SharedChannels> {
        self.channels.as_deref()
    }

    /// Number of columns.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Number of cells, including blocked ones.
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

    /// Whether the cell is forbidden to centres.
    #[inline]
    pub fn is_blocked(&self, cell: CellIndex) -> bool {
        self.blocked.contains(cell as usize)
    }

    /// Blocks every cell nearer than `distance` (Chebyshev) to a place, which may lie outside the board.
    pub fn block_around(&mut self, column: i64, row: i64, distance: u32) {
        let reach = i64::from(distance) - 1;
        let columns = (column - reach).max(0)..=(column + reach).min(i64::from(self.width) - 1);
        for row in (row - reach).max(0)..=(row + reach).min(i64::from(self.height) - 1) {
            for column in columns.clone() {
                self.block(self.cell(column as u32, row as u32));
            }
        }
    }

    /// Lowest and highest corner, as (column, row), of the rectangle of free cells; `None` if the free cells form no
    /// rectangle.
    pub fn free_rectangle(&self) -> Option<[(u32, u32); 2]> {
        let mut free =
            (0..self.cells() as CellIndex).filter(|cell| !self.is_blocked(*cell)).map(|cell| self.place(cell));
        let first = free.next()?;
        let (mut low, mut high, mut count) = (first, first, 1);
        for (column, row) in free {
            low = (low.0.min(column), low.1.min(row));
            high = (high.0.max(column), high.1.max(row));
            count += 1;
        }
        (u64::from(high.0 - low.0 + 1) * u64::from(high.1 - low.1 + 1) == count).then_some([low, high])
    }

    /// The cells nearer than `distance` (Chebyshev) to a cell, including itself and blocked ones.
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

/// Task of one part in one stage.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Agent {
    pub start: CellIndex,
    /// Cells to visit in this order; the last one is its goal, where it stays. Never empty: the goal of a part that
    /// only yields is its start.
    pub stops: Vec<CellIndex>,
}

impl Agent {
    /// The cell where it ends.
    pub fn goal(&self) -> CellIndex {
        *self.stops.last().expect("an agent has a goal")
    }
}

/// One stage: parts that move at the same time. Parts that cannot move are represented by blocked cells.
///
/// Starts keep the rule pairwise, and so do goals (except the pairs of `merges`); no start, stop or goal is blocked. The order of
/// the agents is their priority where a planner uses one.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Instance {
    pub board: BoardGrid,
    /// Least Chebyshev distance of two centres at the same and at neighbouring instants; at least 1.
    pub separation: u32,
    pub agents: Vec<Agent>,
    /// Pairs that share one goal, the smaller index first. For such a pair, a position on that goal is never too near;
    /// each agent stays there from its first arrival. Neither has other stops.
    pub merges: Vec<[usize; 2]>,
}

impl Instance {
    /// The common goal of two agents that merge.
    pub fn merge_cell(&self, one: usize, other: usize) -> Option<CellIndex> {
        let pair = [one.min(other), one.max(other)];
        self.merges.contains(&pair).then(|| self.agents[one].goal())
    }

    /// Whether positions of two agents, at the same or at neighbouring instants, violate the separation rule.
    #[inline]
    pub fn too_near(&self, one: usize, at: CellIndex, other: usize, other_at: CellIndex) -> bool {
        self.board.apart(at, other_at) < self.separation
            && !self.merge_cell(one, other).is_some_and(|goal| at == goal || other_at == goal)
    }
}

/// The path of each agent, from its start to its last arrival at its goal: position `t` is its cell at instant `t`.
/// Afterwards it stays on its goal.
pub type Paths = Vec<Vec<CellIndex>>;

/// The cell of an agent at an instant.
#[inline]
pub fn position(path: &[CellIndex], instant: usize) -> CellIndex {
    path[instant.min(path.len() - 1)]
}

/// Objective to minimise. Each breaks ties by the other one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BoardObjective {
    /// The instant of the last arrival.
    Makespan,
    /// The sum over all agents of the instant of their last arrival.
    SumOfCosts,
}

impl BoardObjective {
    /// The objective of a task.
    pub fn of(objective: ElectrodeArrayObjective) -> BoardObjective {
        match objective {
            ElectrodeArrayObjective::Makespan => BoardObjective::Makespan,
            ElectrodeArrayObjective::SumOfCosts => BoardObjective::SumOfCosts,
        }
    }
}

/// A makespan and a sum of costs, of a plan or as lower bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct BoardCosts {
    pub makespan: u64,
    pub sum_of_costs: u64,
}

impl BoardCosts {
    /// The costs of a plan.
    pub fn of(paths: &Paths) -> BoardCosts {
        let arrivals = paths.iter().map(|path| path.len() as u64 - 1);
        BoardCosts { makespan: arrivals.clone().max().unwrap_or(0), sum_of_costs: arrivals.sum() }
    }

    /// Lexicographic key under an objective.
    pub fn key(self, objective: BoardObjective) -> (u64, u64) {
        match objective {
            BoardObjective::Makespan => (self.makespan, self.sum_of_costs),
            BoardObjective::SumOfCosts => (self.sum_of_costs, self.makespan),
        }
    }
}

/// Progress display of the best plan of a stage so far.
#[derive(Debug)]
pub struct BoardPlanProgress {
    objective: BoardObjective,
    costs: BoardCosts,
    bounds: BoardCosts,
    held: IncumbentPlan,
}

impl BoardPlanProgress {
    /// Begins with a first plan and the lower bounds on every plan.
    pub fn begin(objective: BoardObjective, costs: BoardCosts, bounds: BoardCosts) -> BoardPlanProgress {
        BoardPlanProgress { objective, costs, bounds, held: IncumbentPlan::begin(|| summary(objective, costs, bounds)) }
    }

    /// Offers another plan, which may be better, and the current bounds.
    pub fn offer(&mut self, costs: BoardCosts, bounds: BoardCosts) {
        if costs.key(self.objective) < self.costs.key(self.objective) {
            self.costs = costs;
        }
        self.bounds = bounds;
        self.held.improve(|| summary(self.objective, self.costs, self.bounds));
    }
}

fn summary(objective: BoardObjective, costs: BoardCosts, bounds: BoardCosts) -> String {
    let (cost, bound) = (costs.key(objective).0, bounds.key(objective).0);
    match objective {
        BoardObjective::Makespan => format!("{cost} steps, least {bound}"),
        BoardObjective::SumOfCosts => format!("{cost} steps of all parts, least {bound}"),
    }
}

/// Result for one stage. A search that gave up returns lower bounds on every plan.
pub type BoardAnswer = SearchAnswer<BoardPlan, NoBoardPlan, BoardCosts>;

/// A plan of one stage with lower bounds; a cost that meets its bound is proven optimal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BoardPlan {
    pub paths: Paths,
    pub bounds: BoardCosts,
}

/// The cells that each agent reaches in a search.
pub struct MetCells {
    /// By agent and cell.
    is_met: Vec<Vec<bool>>,
}

impl MetCells {
    /// An empty set for a board of `cells` cells.
    pub fn new(agents: usize, cells: usize) -> MetCells {
        MetCells { is_met: vec![vec![false; cells]; agents] }
    }

    /// Records that an agent reaches a cell.
    pub fn meet(&mut self, agent: usize, cell: CellIndex) {
        self.is_met[agent][cell as usize] = true;
    }

    /// The cells of each agent, ascending.
    pub fn listed(self) -> Vec<Vec<CellIndex>> {
        let cells = |own: Vec<bool>| (0..).zip(own).filter_map(|(cell, is_met)| is_met.then_some(cell)).collect();
        self.is_met.into_iter().map(cells).collect()
    }
}

/// Why there is no plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum NoBoardPlan {
    /// Blocked cells cut this agent off from this stop, even when it is alone on the board.
    Closed { agent: usize, stop: usize },
    /// Shared channels keep this agent from this stop, even when it is alone: their other electrodes, switched along
    /// its way, would pull it apart.
    TornByChannels { agent: usize, stop: usize },
    /// These agents cannot pass one another, whatever the others do; the smallest set found that cannot.
    Blocked { agents: Vec<usize> },
    /// No plan keeps the limit on steps, though one without the limit exists or may exist; `least` is a lower bound on
    /// the steps.
    TooFewSteps { least: u64 },
}
