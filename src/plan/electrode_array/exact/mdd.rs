//! All paths of one agent with one cost, as a multi-value decision diagram: one layer per instant (Sharon et al., "The increasing
//! cost tree search for optimal multi-agent pathfinding", Artificial Intelligence 195, 2013).

use super::constraint::{AgentConstraint, Ban, OutOfSteps};
use super::tables::{CellPlace, ExactTables, FAR, StagedCell};
use crate::plan::electrode_array::board::{CellIndex, position};
use crate::plan::search::Meter;

/// The nodes on paths of exactly this cost.
#[derive(Debug)]
pub struct MultiValueDecisionDiagram {
    /// Start index of each layer, and the end.
    starts: Vec<u32>,
    nodes: Vec<StagedCell>,
    /// Column and row of each node.
    places: Vec<CellPlace>,
    /// Start index of the edges of each node, and the end.
    edge_starts: Vec<u32>,
    /// Positions of successors within the next layer.
    edges: Vec<u32>,
    /// Least and greatest column and row of each layer.
    extents: Vec<CellExtent>,
}

/// Least and greatest column and row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellExtent {
    pub columns: (i32, i32),
    pub rows: (i32, i32),
}

impl CellExtent {
    const EMPTY: CellExtent = CellExtent { columns: (i32::MAX, i32::MIN), rows: (i32::MAX, i32::MIN) };

    fn with(self, place: CellPlace) -> CellExtent {
        CellExtent {
            columns: (self.columns.0.min(place.column), self.columns.1.max(place.column)),
            rows: (self.rows.0.min(place.row), self.rows.1.max(place.row)),
        }
    }

    /// The bounding box of both.
    pub fn join(self, other: CellExtent) -> CellExtent {
        let corner = |column: i32, row: i32| CellPlace { column, row };
        self.with(corner(other.columns.0, other.rows.0)).with(corner(other.columns.1, other.rows.1))
    }

    /// Whether every place of one is at least `distance` (Chebyshev) from every place of the other.
    pub fn is_apart(&self, other: &CellExtent, distance: i32) -> bool {
        let gap = |one: (i32, i32), two: (i32, i32)| (two.0 - one.1).max(one.0 - two.1);
        gap(self.columns, other.columns).max(gap(self.rows, other.rows)) >= distance
    }
}

impl MultiValueDecisionDiagram {
    /// The paths of an agent that meet its constraints and arrive exactly at `cost`, which must be reachable. Charges
    /// one step for each node.
    pub fn new(
        tables: &ExactTables,
        agent: usize,
        constraint: &AgentConstraint,
        cost: u32,
        meter: &mut Meter,
    ) -> Result<MultiValueDecisionDiagram, OutOfSteps> {
        let reached = forward(tables, agent, constraint, cost, meter)?;
        let kept = backward(tables, agent, reached);
        Ok(MultiValueDecisionDiagram::linked(tables, agent, &kept))
    }

    /// The paths over the kept nodes; `None` if none is left.
    pub fn filtered(
        &self,
        tables: &ExactTables,
        agent: usize,
        keep: impl Fn(u32, usize) -> bool,
    ) -> Option<MultiValueDecisionDiagram> {
        let mut kept: Vec<Vec<StagedCell>> = vec![];
        let mut last_seen = vec![u32::MAX; tables.nodes(agent)];
        for instant in 0..=self.cost() {
            let layer =
                self.at(instant).iter().enumerate().filter(|(place, _)| keep(instant, *place)).map(|(_, node)| *node);
            let layer: Vec<StagedCell> =
                layer.filter(|node| instant == 0 || last_seen[*node as usize] == instant).collect();
            for node in &layer {
                tables.next(agent, *node).for_each(|to| last_seen[to as usize] = instant + 1);
            }
            kept.push(layer);
        }
        let kept = backward(tables, agent, kept);
        (!kept[0].is_empty()).then(|| MultiValueDecisionDiagram::linked(tables, agent, &kept))
    }

    /// Number of nodes.
    pub fn size(&self) -> usize {
        self.nodes.len()
    }

    fn linked(tables: &ExactTables, agent: usize, kept: &[Vec<StagedCell>]) -> MultiValueDecisionDiagram {
        let mut mdd = MultiValueDecisionDiagram {
            starts: vec![0],
            nodes: vec![],
            places: vec![],
            edge_starts: vec![0],
            edges: vec![],
            extents: vec![],
        };
        let mut places = vec![u32::MAX; tables.nodes(agent)];
        for (instant, layer) in kept.iter().enumerate() {
            let next: &[StagedCell] = kept.get(instant + 1).map_or(&[], Vec::as_slice);
            next.iter().zip(0..).for_each(|(node, place)| places[*node as usize] = place);
            for node in layer {
                let targets =
                    tables.next(agent, *node).map(|to| places[to as usize]).filter(|place| *place != u32::MAX);
                mdd.edges.extend(targets);
                mdd.edge_starts.push(mdd.edges.len() as u32);
            }
            next.iter().for_each(|node| places[*node as usize] = u32::MAX);
            mdd.nodes.extend_from_slice(layer);
            mdd.places.extend(layer.iter().map(|node| tables.place(tables.cell(*node))));
            mdd.starts.push(mdd.nodes.len() as u32);
            let extent =
                layer.iter().fold(CellExtent::EMPTY, |extent, node| extent.with(tables.place(tables.cell(*node))));
            mdd.extents.push(extent);
        }
        mdd
    }

    /// The instant of arrival.
    pub fn cost(&self) -> u32 {
        self.extents.len() as u32 - 1
    }

    /// The nodes at an instant; after the arrival, the goal.
    #[inline]
    pub fn at(&self, instant: u32) -> &[StagedCell] {
        let layer = instant.min(self.cost()) as usize;
        &self.nodes[self.starts[layer] as usize..self.starts[layer + 1] as usize]
    }

    /// Columns and rows of the nodes at an instant.
    #[inline]
    pub fn places(&self, instant: u32) -> &[CellPlace] {
        let layer = instant.min(self.cost()) as usize;
        &self.places[self.starts[layer] as usize..self.starts[layer + 1] as usize]
    }

    #[inline]
    pub fn extent(&self, instant: u32) -> CellExtent {
        self.extents[instant.min(self.cost()) as usize]
    }

    /// Positions, within the next layer, of the successors of a node.
    #[inline]
    pub fn edges(&self, instant: u32, place: usize) -> &[u32] {
        if instant >= self.cost() {
            return &[0];
        }
        let node = self.starts[instant as usize] as usize + place;
        &self.edges[self.edge_starts[node] as usize..self.edge_starts[node + 1] as usize]
    }

    /// Number of nodes outside `ban`, and number of all nodes, in the layer with the fewest nodes outside while the ban
    /// is in force.
    pub fn outside(&self, tables: &ExactTables, ban: &Ban) -> (usize, usize) {
        let instants = ban.from..=ban.until.min(self.cost().max(ban.from));
        let counts = instants.map(|instant| {
            let layer = self.at(instant);
            (layer.iter().filter(|node| !ban.covers(tables, tables.cell(**node))).count(), layer.len())
        });
        counts.min().unwrap_or((1, 1))
    }

    /// The path that conflicts with the fewest of `others`; ties go to the node that comes earlier in its layer.
    pub fn best_path(&self, tables: &ExactTables, agent: usize, others: &[(usize, &[CellIndex])]) -> Vec<CellIndex> {
        let cost = self.cost();
        let mut tolls = vec![0u32; self.nodes.len()];
        for instant in (0..=cost).rev() {
            let close = self.close_by(tables, instant, others);
            for place in 0..self.at(instant).len() {
                let index = self.starts[instant as usize] as usize + place;
                let cell = tables.cell(self.nodes[index]);
                let own = close
                    .iter()
                    .filter(|(other, cells)| cells.iter().any(|at| tables.too_near(agent, cell, *other, *at)));
                let next = self.starts[(instant + 1).min(cost) as usize] as usize;
                let onward = self.edges(instant, place).iter().map(|to| tolls[next + *to as usize]).min();
                tolls[index] = own.count() as u32 + if instant == cost { 0 } else { onward.unwrap_or(0) };
            }
        }
        self.walk(tables, &tolls)
    }

    fn walk(&self, tables: &ExactTables, tolls: &[u32]) -> Vec<CellIndex> {
        let mut path = vec![tables.cell(self.nodes[0])];
        let mut place = 0;
        for instant in 0..self.cost() {
            let next = self.starts[instant as usize + 1] as usize;
            let cheapest = self.edges(instant, place).iter().min_by_key(|to| tolls[next + **to as usize]);
            place = *cheapest.expect("every node lies on a path") as usize;
            path.push(tables.cell(self.nodes[next + place]));
        }
        path
    }

    /// The others that come near the layer of an instant, with their positions around it.
    fn close_by(
        &self,
        tables: &ExactTables,
        instant: u32,
        others: &[(usize, &[CellIndex])],
    ) -> Vec<(usize, [CellIndex; 3])> {
        let extent = self.extent(instant);
        let around = |path: &[CellIndex]| {
            let instant = instant as usize;
            [position(path, instant.saturating_sub(1)), position(path, instant), position(path, instant + 1)]
        };
        let separation = tables.instance.separation as i32;
        others
            .iter()
            .map(|(other, path)| (*other, around(path)))
            .filter(|(_, cells)| {
                !cells.iter().all(|cell| extent.is_apart(&CellExtent::EMPTY.with(tables.place(*cell)), separation))
            })
            .collect()
    }
}

/// The nodes reachable at each instant that leave enough time for the rest.
fn forward(
    tables: &ExactTables,
    agent: usize,
    constraint: &AgentConstraint,
    cost: u32,
    meter: &mut Meter,
) -> Result<Vec<Vec<StagedCell>>, OutOfSteps> {
    let mut layers = vec![vec![tables.start(agent)]];
    let mut last_seen = vec![0u32; tables.nodes(agent)];
    for instant in 1..=cost {
        let bans: Vec<Ban> = constraint.bans_at(instant).copied().collect();
        let mut layer = vec![];
        for node in &layers[instant as usize - 1] {
            meter.step().ok_or(OutOfSteps)?;
            for next in tables.next(agent, *node) {
                let distance = tables.distance(agent, next);
                let is_late = distance == FAR || instant + distance > cost;
                if is_late
                    || last_seen[next as usize] == instant
                    || bans.iter().any(|ban| ban.covers(tables, tables.cell(next)))
                {
                    continue;
                }
                last_seen[next as usize] = instant;
                layer.push(next);
            }
        }
        layers.push(layer);
    }
    Ok(layers)
}

/// Of the reachable nodes, those from which the last layer is reachable.
fn backward(tables: &ExactTables, agent: usize, mut layers: Vec<Vec<StagedCell>>) -> Vec<Vec<StagedCell>> {
    let mut alive_at = vec![u32::MAX; tables.nodes(agent)];
    for instant in (0..layers.len()).rev() {
        if instant + 1 < layers.len() {
            layers[instant]
                .retain(|node| tables.next(agent, *node).any(|to| alive_at[to as usize] == instant as u32 + 1));
        }
        layers[instant].iter().for_each(|node| alive_at[*node as usize] = instant as u32);
    }
    layers
}
