//! Tables that the exact searches share: the moves of each agent, and its distance to its goal through its stops.
//!
//! A single agent walks over nodes: a node is a cell and the number of stops visited, in one number, `stage * cells +
//! cell`. The distances respect blocked cells and, where channels are shared, steps that would tear an agent apart;
//! they are exact for an agent that is alone.

use crate::plan::electrode_array::board::{CellIndex, Instance};
use crate::plan::electrode_array::channels::broadcast::AgentStep;
use fixedbitset::FixedBitSet;

/// A cell and the number of stops visited: `stage * cells + cell`.
pub type StagedCell = u32;

/// Distance of an unreachable goal.
pub const FAR: u32 = u32::MAX;

/// Tables with more entries than this are not built; 4 bytes each.
const MOST_ENTRIES: u64 = 1 << 25;

/// Column and row of a cell, from 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellPlace {
    pub column: i32,
    pub row: i32,
}

/// The tables of one instance.
pub struct ExactTables<'a> {
    pub instance: &'a Instance,
    cells: u32,
    places: Vec<CellPlace>,
    /// The free neighbours of each cell, itself first; unused entries repeat the cell.
    steps: Vec<[CellIndex; 5]>,
    /// Cells where no agent can rest, since shared channels would tear it apart there.
    restless: FixedBitSet,
    ways: Vec<AgentDistances>,
    /// For each pair, at `one * agents + other`: whether they merge.
    merged: Vec<bool>,
}

/// Distances of one agent.
struct AgentDistances {
    start: StagedCell,
    goal: StagedCell,
    /// By node: steps to the goal through the remaining stops.
    distances: Vec<u32>,
    /// It merges on its goal and so never leaves it.
    absorbed: bool,
}

/// Why the tables were not built.
pub enum NoExactTables {
    /// The tables would be too large.
    TooLarge,
    /// Blocked cells cut this agent off from this stop.
    StopCutOff { agent: usize, stop: usize },
}

impl<'a> ExactTables<'a> {
    /// Builds the tables; an error if some agent cannot reach its goal even alone.
    pub fn new(instance: &'a Instance) -> Result<ExactTables<'a>, NoExactTables> {
        let board = &instance.board;
        let stages = instance.agents.iter().map(|agent| agent.stops.len() as u64).sum::<u64>();
        if (stages + 8).saturating_mul(board.cells() as u64) > MOST_ENTRIES {
            return Err(NoExactTables::TooLarge);
        }
        let cells = board.cells() as u32;
        let place = |(column, row): (u32, u32)| CellPlace { column: column as i32, row: row as i32 };
        let places = (0..cells).map(|cell| place(board.place(cell))).collect();
        let is_torn = |from: CellIndex, to: CellIndex| {
            board.channels().is_some_and(|channels| channels.tears_apart(AgentStep { from, to }))
        };
        let steps = (0..cells).map(|cell| steps_at(instance, cell, |to| !is_torn(cell, to))).collect();
        let back: Vec<[CellIndex; 5]> =
            (0..cells).map(|cell| steps_at(instance, cell, |from| !is_torn(from, cell))).collect();
        let mut restless = FixedBitSet::with_capacity(cells as usize);
        (0..cells).filter(|cell| is_torn(*cell, *cell)).for_each(|cell| restless.insert(cell as usize));
        let count = instance.agents.len();
        let mut merged = vec![false; count * count];
        for [one, other] in &instance.merges {
            merged[one * count + other] = true;
            merged[other * count + one] = true;
        }
        let mut tables =
            ExactTables { instance, cells, places, steps, restless, ways: Vec::with_capacity(count), merged };
        let open = if board.channels().is_none() { board.free_rectangle() } else { None };
        let mut flooding = Flooding { back, open, queue: Vec::with_capacity(cells as usize) };
        for agent in 0..count {
            let way = tables.way(agent, &mut flooding)?;
            tables.ways.push(way);
        }
        Ok(tables)
    }

    fn way(&self, agent: usize, flooding: &mut Flooding) -> Result<AgentDistances, NoExactTables> {
        let stops = &self.instance.agents[agent].stops;
        let mut distances = vec![FAR; stops.len() * self.cells as usize];
        let mut onward = 0;
        for (stage, stop) in stops.iter().enumerate().rev() {
            let layer = &mut distances[stage * self.cells as usize..][..self.cells as usize];
            flooding.flood(self, *stop, onward, layer);
            let before = if stage == 0 { self.instance.agents[agent].start } else { stops[stage - 1] };
            onward = layer[before as usize];
            if onward == FAR {
                return Err(NoExactTables::StopCutOff { agent, stop: stage });
            }
        }
        let goal = self.cells * (stops.len() as u32 - 1) + stops[stops.len() - 1];
        let absorbed = self.instance.merges.iter().any(|pair| pair.contains(&agent));
        let start = self.advanced(agent, 0, self.instance.agents[agent].start);
        Ok(AgentDistances { start, goal, distances, absorbed })
    }

    /// The node of an agent that enters a cell with `stage` stops visited.
    #[inline]
    fn advanced(&self, agent: usize, stage: u32, cell: CellIndex) -> StagedCell {
        let stops = &self.instance.agents[agent].stops;
        let mut stage = stage as usize;
        while stage + 1 < stops.len() && stops[stage] == cell {
            stage += 1;
        }
        stage as u32 * self.cells + cell
    }

    /// Number of agents.
    pub fn agents(&self) -> usize {
        self.ways.len()
    }

    /// Number of nodes of an agent.
    pub fn nodes(&self, agent: usize) -> usize {
        self.ways[agent].distances.len()
    }

    /// Number of nodes of an agent from which its goal is reachable.
    pub fn reaching(&self, agent: usize) -> u64 {
        self.ways[agent].distances.iter().filter(|distance| **distance != FAR).count() as u64
    }

    #[inline]
    pub fn start(&self, agent: usize) -> StagedCell {
        self.ways[agent].start
    }

    /// The node of its final arrival.
    #[inline]
    pub fn goal(&self, agent: usize) -> StagedCell {
        self.ways[agent].goal
    }

    /// Whether it never leaves its goal once there.
    #[inline]
    pub fn is_absorbed(&self, agent: usize) -> bool {
        self.ways[agent].absorbed
    }

    /// Steps from a node to the goal for the agent alone; [`FAR`] if there is no path.
    #[inline]
    pub fn distance(&self, agent: usize, node: StagedCell) -> u32 {
        self.ways[agent].distances[node as usize]
    }

    /// Steps from start to goal for the agent alone.
    pub fn least(&self, agent: usize) -> u32 {
        self.distance(agent, self.start(agent))
    }

    #[inline]
    pub fn cell(&self, node: StagedCell) -> CellIndex {
        if node < self.cells { node } else { node % self.cells }
    }

    #[inline]
    pub fn place(&self, cell: CellIndex) -> CellPlace {
        self.places[cell as usize]
    }

    /// The nodes that an agent can reach in one step.
    #[inline]
    pub fn next(&self, agent: usize, node: StagedCell) -> impl Iterator<Item = StagedCell> + '_ {
        let cell = self.cell(node);
        let stage = if node < self.cells { 0 } else { node / self.cells };
        let stays = self.ways[agent].absorbed && node == self.ways[agent].goal;
        let steps = &self.steps[cell as usize];
        let moves = if stays { &steps[..1] } else { &steps[..] };
        moves
            .iter()
            .enumerate()
            .filter(move |(k, to)| if *k == 0 { !self.restless.contains(cell as usize) } else { **to != cell })
            .map(move |(_, to)| self.advanced(agent, stage, *to))
    }

    /// Whether it can rest at a node.
    #[inline]
    pub fn may_rest(&self, node: StagedCell) -> bool {
        !self.restless.contains(self.cell(node) as usize)
    }

    /// Whether two steps exclude each other because of shared channels.
    #[inline]
    pub fn clash(&self, one: [CellIndex; 2], other: [CellIndex; 2]) -> bool {
        let step = |[from, to]: [CellIndex; 2]| AgentStep { from, to };
        self.instance.board.channels().is_some_and(|channels| channels.clash(step(one), step(other)))
    }

    #[inline]
    pub fn is_merged(&self, one: usize, other: usize) -> bool {
        self.merged[one * self.ways.len() + other]
    }

    /// Whether two places are nearer to each other than the separation.
    #[inline]
    pub fn are_near(&self, one: CellPlace, other: CellPlace) -> bool {
        (one.column - other.column).abs().max((one.row - other.row).abs()) < self.instance.separation as i32
    }

    /// Whether the cells of two agents at the same or at neighbouring instants violate the separation.
    #[inline]
    pub fn too_near(&self, one: usize, at: CellIndex, other: usize, other_at: CellIndex) -> bool {
        if !self.are_near(self.place(at), self.place(other_at)) {
            return false;
        }
        let goal = self.cell(self.ways[one].goal);
        !(self.is_merged(one, other) && (at == goal || other_at == goal))
    }
}

/// A cell and those of its free neighbours that satisfy `is_taken`; unused entries repeat the cell.
fn steps_at(instance: &Instance, cell: CellIndex, is_taken: impl Fn(CellIndex) -> bool) -> [CellIndex; 5] {
    let mut steps = [cell; 5];
    let taken = instance.board.neighbours(cell).filter(|beside| is_taken(*beside));
    for (place, to) in steps[1..].iter_mut().zip(taken) {
        *place = to;
    }
    steps
}

/// Breadth-first search for the distances to all stops.
struct Flooding {
    /// By cell: the cells from which an agent can enter it.
    back: Vec<[CellIndex; 5]>,
    /// The corners of the free cells, if they form a rectangle and channels are not shared.
    open: Option<[(u32, u32); 2]>,
    queue: Vec<CellIndex>,
}

impl Flooding {
    /// Fills in the distances to a cell, counted from `first`.
    fn flood(&mut self, tables: &ExactTables, from: CellIndex, first: u32, distances: &mut [u32]) {
        if let Some([low, high]) = self.open {
            let board = &tables.instance.board;
            let (column, row) = board.place(from);
            for r in low.1..=high.1 {
                let across = first + r.abs_diff(row);
                let line = &mut distances[board.cell(low.0, r) as usize..=board.cell(high.0, r) as usize];
                line.iter_mut().zip(low.0..).for_each(|(steps, c)| *steps = across + c.abs_diff(column));
            }
            return;
        }
        distances[from as usize] = first;
        self.queue.clear();
        self.queue.push(from);
        let mut head = 0;
        while let Some(&cell) = self.queue.get(head) {
            head += 1;
            let onward = distances[cell as usize] + 1;
            for to in &self.back[cell as usize][1..] {
                if distances[*to as usize] == FAR {
                    distances[*to as usize] = onward;
                    self.queue.push(*to);
                }
            }
        }
    }
}
