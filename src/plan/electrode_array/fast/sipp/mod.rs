//! The path of one agent among the others' paths: its stops in order, then its goal, where it stays.
//!
//! Method: safe-interval path planning (Phillips and Likhachev, ICRA 2011) over the safe intervals ("segments") of
//! [`Reservations`], with soft segments at a cost as in SIPPS (Li and others, AAAI 2022). The separation rule forbids single
//! positions and no moves, so the earliest arrival in each segment dominates all later ones. Guaranteed with hard segments only and
//! no haste: a path with the earliest last arrival within the limit, if the meter lets the search end. With haste it may arrive
//! later, by at most that fraction of the earliest arrival. With soft ones: a path of least cost plus arrival in the given weights,
//! as far as earliest arrivals represent the others. Cost: one step for each expanded node; there are at most as many nodes as
//! segments times stops, with soft segments a few times as many.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::ops::Range;

use super::distances::{DistanceField, UNREACHABLE};
use super::reservations::{IntervalQuery, NEVER, Reservations, SafeInterval};
use crate::plan::electrode_array::board::{BoardGrid, CellIndex};
use crate::plan::search::Meter;
use crate::random::SplitMix64;

/// No node.
const NONE: u32 = u32::MAX;

/// The unit of [`Query::haste`].
const GRAIN: u64 = 16;

/// Input of a search.
pub(super) struct Query<'a> {
    pub(super) board: &'a BoardGrid,
    pub(super) start: CellIndex,
    pub(super) route: &'a StopRoute,
    pub(super) interval_query: IntervalQuery<'a>,
    /// Value of one unit of conflict cost, in instants.
    pub(super) weight: u32,
    /// Extra weight of the heuristic, in parts of [`GRAIN`] (weighted A*): a larger value heads straight for the goal.
    pub(super) haste: u32,
    /// Latest arrival.
    pub(super) limit: u32,
    /// The agent stays on its start until this instant.
    pub(super) delay: u32,
}

/// The stops of an agent, with the distances to each of them.
#[derive(Debug, Clone)]
pub(super) struct StopRoute {
    stops: Vec<(CellIndex, DistanceField)>,
    /// Distance from each stop to the end of the route.
    rest: Vec<u32>,
}

impl StopRoute {
    /// `stops` must not be empty. The error is the index of the first stop that is unreachable from the previous one.
    pub(super) fn new(start: CellIndex, stops: Vec<(CellIndex, DistanceField)>) -> Result<StopRoute, usize> {
        let mut from = start;
        for (index, (stop, field)) in stops.iter().enumerate() {
            if field.from(from) == UNREACHABLE {
                return Err(index);
            }
            from = *stop;
        }
        let mut rest = vec![0; stops.len()];
        for index in (1..stops.len()).rev() {
            rest[index - 1] = rest[index] + stops[index].1.from(stops[index - 1].0);
        }
        Ok(StopRoute { stops, rest })
    }

    /// Steps from a cell to the end of the route once `layer` stops are passed.
    #[inline]
    pub(super) fn steps(&self, cell: CellIndex, layer: u32) -> u32 {
        self.stops[layer as usize].1.from(cell).saturating_add(self.rest[layer as usize])
    }

    fn last(&self) -> u32 {
        self.stops.len() as u32 - 1
    }

    /// Number of stops passed once the agent is on a cell.
    #[inline]
    pub(super) fn passed(&self, cell: CellIndex, mut layer: u32) -> u32 {
        while layer < self.last() && self.stops[layer as usize].0 == cell {
            layer += 1;
        }
        layer
    }
}

/// A non-dominated arrival in a segment: no known one is both as early and as cheap.
#[derive(Debug, Clone, Copy)]
struct SippNode {
    cell: CellIndex,
    segment: u32,
    layer: u32,
    arrival: u32,
    cost: u32,
    parent: u32,
    /// Next node of the same segment and layer.
    sibling: u32,
    closed: bool,
}

/// The search, with buffers that consecutive searches reuse.
#[derive(Debug)]
pub(super) struct Sipp {
    round: u32,
    /// By cell: the round in which its segments were listed, and their range in `segments`.
    listed: Vec<(u32, u32, u32)>,
    segments: Vec<SafeInterval>,
    /// By segment and layer: the first node of its list.
    heads: Vec<u32>,
    nodes: Vec<SippNode>,
    open: BinaryHeap<Reverse<(u64, u32)>>,
    /// The instant from which the goal is free for ever.
    earliest: u32,
}

impl Sipp {
    pub(super) fn new(board: &BoardGrid) -> Sipp {
        Sipp {
            round: 0,
            listed: vec![(0, 0, 0); board.cells()],
            segments: Vec::new(),
            heads: Vec::new(),
            nodes: Vec::new(),
            open: BinaryHeap::new(),
            earliest: 0,
        }
    }

    /// A path, unless there is none within the limit or the meter runs out.
    pub(super) fn plan(
        &mut self,
        query: &Query,
        reservations: &mut Reservations,
        random: &mut SplitMix64,
        meter: &mut Meter,
    ) -> Option<Vec<CellIndex>> {
        self.begin(query, reservations)?;
        while let Some(Reverse((_, index))) = self.open.pop() {
            let node = self.nodes[index as usize];
            if node.closed {
                continue;
            }
            self.nodes[index as usize].closed = true;
            meter.step()?;
            if self.is_end(query, &node) {
                return Some(self.path(index));
            }
            self.expand(query, reservations, random, index, node);
        }
        None
    }

    /// Queues the start; `None` if start or goal is unavailable.
    fn begin(&mut self, query: &Query, reservations: &mut Reservations) -> Option<()> {
        self.round += 1;
        self.segments.clear();
        self.heads.clear();
        self.nodes.clear();
        self.open.clear();
        let (_, end) = self.list(query, reservations, query.interval_query.goal);
        let last = self.segments.get((end as usize).checked_sub(1)?)?;
        if last.to != NEVER {
            return None;
        }
        self.earliest = last.from;
        let (first, end) = self.list(query, reservations, query.start);
        let (segment, cost) = self.after(first..end, query.delay)?;
        let layer = query.route.passed(query.start, 0);
        let start = SippNode {
            cell: query.start,
            segment,
            layer,
            arrival: query.delay,
            cost,
            parent: NONE,
            sibling: NONE,
            closed: false,
        };
        self.push(query, start, 0);
        Some(())
    }

    /// The segment that contains the instant `delay` if the agent stays from the first instant on, and the cost until then.
    fn after(&self, segments: Range<u32>, delay: u32) -> Option<(u32, u32)> {
        let (mut until, mut cost) = (0, 0);
        for segment in segments {
            let SafeInterval { from, to, cost: more } = self.segments[segment as usize];
            if from != until {
                return None;
            }
            (until, cost) = (to, cost + more);
            if delay < to {
                return Some((segment, cost));
            }
        }
        None
    }

    /// The segments of a cell, listed once per search.
    fn list(&mut self, query: &Query, reservations: &mut Reservations, cell: CellIndex) -> (u32, u32) {
        let (round, first, end) = self.listed[cell as usize];
        if round == self.round {
            return (first, end);
        }
        let first = self.segments.len() as u32;
        reservations.segments(cell, &query.interval_query, &mut self.segments);
        let end = self.segments.len() as u32;
        self.heads.resize(end as usize * (query.route.last() as usize + 1), NONE);
        self.listed[cell as usize] = (self.round, first, end);
        (first, end)
    }

    fn is_end(&self, query: &Query, node: &SippNode) -> bool {
        node.cell == query.interval_query.goal
            && node.layer == query.route.last()
            && self.segments[node.segment as usize].to == NEVER
    }

    fn expand(
        &mut self,
        query: &Query,
        reservations: &mut Reservations,
        random: &mut SplitMix64,
        index: u32,
        node: SippNode,
    ) {
        let leave = self.segments[node.segment as usize].to;
        self.enter(query, index, node, node.segment + 1, node.cell, 0);
        if node.cell == query.interval_query.goal && !query.interval_query.partners.is_empty() {
            return;
        }
        let mut dice = random.next_u64();
        for cell in query.board.neighbours(node.cell) {
            let (first, end) = self.list(query, reservations, cell);
            dice >>= 12;
            let past = self.segments[first as usize..end as usize].partition_point(|one| one.to <= node.arrival + 1);
            for segment in first + past as u32..end {
                if self.segments[segment as usize].from > leave {
                    break;
                }
                self.enter(query, index, node, segment, cell, dice as u32 & 0xfff);
            }
        }
    }

    /// Adds the node for moving or waiting into a segment, if possible and not dominated by a known node.
    fn enter(&mut self, query: &Query, parent: u32, node: SippNode, segment: u32, cell: CellIndex, dice: u32) {
        let (waits, leave) = (cell == node.cell, self.segments[node.segment as usize].to);
        let Some(target) = self.segments.get(segment as usize).copied() else { return };
        if waits && (segment >= self.listed[cell as usize].2 || target.from != leave) {
            return;
        }
        let arrival = target.from.max(node.arrival + 1);
        if arrival > leave {
            return;
        }
        let cost = node.cost + target.cost;
        let layer = query.route.passed(cell, node.layer);
        let (mut other, head) = self.head(query, segment, layer);
        let mut before = NONE;
        while other != NONE {
            let known = self.nodes[other as usize];
            if known.cost <= cost && known.arrival <= arrival {
                return;
            }
            if cost <= known.cost && arrival <= known.arrival {
                self.nodes[other as usize].closed = true;
                match before {
                    NONE => self.heads[head] = known.sibling,
                    _ => self.nodes[before as usize].sibling = known.sibling,
                }
            } else {
                before = other;
            }
            other = known.sibling;
        }
        let sibling = self.heads[head];
        self.push(query, SippNode { cell, segment, layer, arrival, cost, parent, sibling, closed: false }, dice);
    }

    fn head(&self, query: &Query, segment: u32, layer: u32) -> (u32, usize) {
        let head = segment as usize * (query.route.last() as usize + 1) + layer as usize;
        (self.heads[head], head)
    }

    fn push(&mut self, query: &Query, node: SippNode, dice: u32) {
        let ahead = query.route.steps(node.cell, node.layer);
        if ahead == UNREACHABLE {
            return;
        }
        let total = (node.arrival.saturating_add(ahead)).max(self.earliest);
        if total > query.limit {
            return;
        }
        let index = self.nodes.len() as u32;
        let (_, head) = self.head(query, node.segment, node.layer);
        self.heads[head] = index;
        self.nodes.push(node);
        let worth = u64::from(total) + u64::from(query.weight) * u64::from(node.cost);
        let first = (GRAIN * worth + u64::from(query.haste) * u64::from(ahead)).min(u64::from(u32::MAX));
        let second = u64::from(ahead.min(0xf_ffff));
        self.open.push(Reverse((first << 32 | second << 12 | u64::from(dice), index)));
    }

    /// The positions up to the last arrival.
    fn path(&self, end: u32) -> Vec<CellIndex> {
        let mut chain = vec![self.nodes[end as usize]];
        while let Some(node) = chain.last().filter(|node| node.parent != NONE) {
            chain.push(self.nodes[node.parent as usize]);
        }
        let mut path: Vec<CellIndex> = Vec::new();
        for node in chain.iter().rev() {
            let before = path.last().copied().unwrap_or(node.cell);
            path.resize(node.arrival as usize, before);
            path.push(node.cell);
        }
        while path.len() > 1 && path[path.len() - 1] == path[path.len() - 2] {
            path.pop();
        }
        path
    }
}

#[cfg(test)]
mod tests;
