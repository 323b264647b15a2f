//! Distances of parts from one another and from obstacles in one beat.
//!
//! Each part is pulled, overshoots and settles at its own pace, so in a beat it may be anywhere between its start and
//! its end, independently of the others. The rectangle of its centre's path is its swept area, and the distance
//! between two parts is that between their rectangles. As distances are whole cells, this is as strict as checking all
//! four combinations of starts and ends.

use super::super::boxes::{Extent, GroupedBoxes};
use crate::claims::electrode_array::{ElectrodeArrayObstacleBody, ElectrodeArrayOrder};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
use nalgebra::Point2;
use rustc_hash::FxHashMap;

/// Swept area of a part's centre in one beat: a rectangle of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SweptCells {
    low: ElectrodeCell,
    high: ElectrodeCell,
}

impl SweptCells {
    /// The path from one cell to another.
    pub fn new(from: ElectrodeCell, to: ElectrodeCell) -> SweptCells {
        let low = ElectrodeCell::new(from.column.min(to.column), from.row.min(to.row));
        SweptCells { low, high: ElectrodeCell::new(from.column.max(to.column), from.row.max(to.row)) }
    }

    /// The path without the goal cell and the moves to or from it; `None` if nothing is left.
    pub fn besides(from: ElectrodeCell, to: ElectrodeCell, goal: ElectrodeCell) -> Option<SweptCells> {
        match (from == goal, to == goal) {
            (false, false) => Some(SweptCells::new(from, to)),
            (false, true) => Some(SweptCells::new(from, from)),
            (true, false) => Some(SweptCells::new(to, to)),
            (true, true) => None,
        }
    }

    /// Least Chebyshev distance between two centres, in electrodes.
    pub fn apart(&self, other: &SweptCells) -> u32 {
        let gap = |low: u32, high: u32, other_low: u32, other_high: u32| {
            other_low.saturating_sub(high).max(low.saturating_sub(other_high))
        };
        let columns = gap(self.low.column, self.high.column, other.low.column, other.high.column);
        columns.max(gap(self.low.row, self.high.row, other.low.row, other.high.row))
    }

    /// One cell of each path, the two nearest to each other.
    pub fn nearest(&self, other: &SweptCells) -> [ElectrodeCell; 2] {
        let columns = nearest_of_ranges([self.low.column, self.high.column], [other.low.column, other.high.column]);
        let rows = nearest_of_ranges([self.low.row, self.high.row], [other.low.row, other.high.row]);
        [0, 1].map(|at| ElectrodeCell::new(columns[at], rows[at]))
    }
}

/// The coordinates of two ranges that are nearest to each other.
fn nearest_of_ranges([low, high]: [u32; 2], [other_low, other_high]: [u32; 2]) -> [u32; 2] {
    if high < other_low {
        [high, other_low]
    } else if other_high < low {
        [low, other_high]
    } else {
        [low.max(other_low); 2]
    }
}

/// Least distance between two centres, in electrodes: the separation of the device, which includes the oscillation at
/// the end of a move, or the width of a body if that is more.
pub(super) fn needed(facts: &ElectrodeArrayFacts) -> u32 {
    let width = (2.0 * facts.layout.half_width_pitches).ceil();
    facts.separation.apart().max(width as u32)
}

/// The first two parts that come nearer than `needed`, with their distance. `apart` gives the distance between two
/// parts by their indices in `paths`; `None` if no distance is required between them.
pub(super) fn first_touch(
    paths: &[SweptCells],
    needed: u32,
    apart: impl Fn(usize, usize) -> Option<u32>,
) -> Option<(usize, usize, u32)> {
    // A path is at most two cells long, so paths that come too near are in the same or in neighbouring buckets.
    let bucket = |way: &SweptCells| [way.low.column, way.low.row].map(|at| i64::from(at / needed.saturating_add(1)));
    let mut buckets: FxHashMap<[i64; 2], Vec<usize>> = FxHashMap::default();
    for (index, way) in paths.iter().enumerate() {
        buckets.entry(bucket(way)).or_default().push(index);
    }
    let around = |[column, row]: [i64; 2]| {
        (column - 1..=column + 1).flat_map(move |column| (row - 1..=row + 1).map(move |row| [column, row]))
    };
    paths.iter().enumerate().find_map(|(one, way)| {
        let near = around(bucket(way)).filter_map(|bucket| buckets.get(&bucket)).flatten();
        let later = near.filter(|other| **other > one);
        let touched =
            later.filter_map(|other| Some((*other, apart(one, *other)?))).filter(|(_, apart)| *apart < needed);
        touched.min().map(|(other, apart)| (one, other, apart))
    })
}

/// The obstacles of an order, prepared for queries.
pub(super) struct BoardObstacles {
    clearance: u32,
    needed: u32,
    /// Obstacles that cover electrodes, each with its index among the obstacles of the order.
    blocks: Vec<(usize, SweptCells)>,
    block_boxes: GroupedBoxes,
    /// Stuck parts, each with its index among the obstacles of the order.
    fixed: Vec<(usize, SweptCells)>,
    fixed_boxes: GroupedBoxes,
}

impl BoardObstacles {
    /// Sorts the obstacles of an order by kind.
    pub fn new(order: &ElectrodeArrayOrder) -> BoardObstacles {
        let (mut blocks, mut fixed) = (Vec::new(), Vec::new());
        for (index, obstacle) in order.obstacles.iter().enumerate() {
            match obstacle.body {
                ElectrodeArrayObstacleBody::Electrodes { from, to } => blocks.push((index, SweptCells::new(from, to))),
                ElectrodeArrayObstacleBody::Fixed(cell) => fixed.push((index, SweptCells::new(cell, cell))),
            }
        }
        let boxes = |bodies: &[(usize, SweptCells)]| GroupedBoxes::new(bodies.iter().map(|(_, body)| extent(body)));
        let (block_boxes, fixed_boxes) = (boxes(&blocks), boxes(&fixed));
        let (clearance, needed) = (order.facts.clearance, needed(&order.facts));
        BoardObstacles { clearance, needed, blocks, block_boxes, fixed, fixed_boxes }
    }

    /// The first obstacle of electrodes that is too near to a centre, with its distance.
    pub fn blocked(&self, at: ElectrodeCell) -> Option<(usize, u32)> {
        first(&self.blocks, &self.block_boxes, &SweptCells::new(at, at), self.clearance - 1)
    }

    /// The first stuck part that is too near to a path, with its distance.
    pub fn stuck(&self, way: &SweptCells) -> Option<(usize, u32)> {
        first(&self.fixed, &self.fixed_boxes, way, self.needed - 1)
    }

    /// The obstacle of electrodes nearest to a centre, if it is within a distance: its index, with the centre and the
    /// obstacle's nearest cell.
    pub fn nearest_block(&self, at: ElectrodeCell, within: u32) -> Option<(usize, [ElectrodeCell; 2])> {
        nearest(&self.blocks, &self.block_boxes, &SweptCells::new(at, at), within)
    }

    /// As [`Self::nearest_block`], for stuck parts.
    pub fn nearest_stuck(&self, way: &SweptCells, within: u32) -> Option<(usize, [ElectrodeCell; 2])> {
        nearest(&self.fixed, &self.fixed_boxes, way, within)
    }

    /// The first stuck part that an electrode acts on.
    pub fn pulled(&self, electrode: ElectrodeCell, reach: i64) -> Option<usize> {
        let reach = u32::try_from(reach).unwrap_or(0);
        first(&self.fixed, &self.fixed_boxes, &SweptCells::new(electrode, electrode), reach)
            .map(|(obstacle, _)| obstacle)
    }
}

/// The first body within a distance from an area, with its distance.
fn first(bodies: &[(usize, SweptCells)], boxes: &GroupedBoxes, area: &SweptCells, within: u32) -> Option<(usize, u32)> {
    let near = boxes.meeting(&extent(area).widened(f64::from(within)));
    near.first().map(|at| (bodies[*at].0, bodies[*at].1.apart(area)))
}

/// The nearest body within a distance from an area, with the two nearest cells.
fn nearest(
    bodies: &[(usize, SweptCells)],
    boxes: &GroupedBoxes,
    area: &SweptCells,
    within: u32,
) -> Option<(usize, [ElectrodeCell; 2])> {
    let near = boxes.meeting(&extent(area).widened(f64::from(within))).into_iter();
    let (obstacle, body) = near.map(|at| &bodies[at]).min_by_key(|(_, body)| body.apart(area))?;
    Some((*obstacle, area.nearest(body)))
}

fn extent(way: &SweptCells) -> Extent {
    Extent::of(&[way.low, way.high].map(|cell| Point2::new(f64::from(cell.column), f64::from(cell.row))))
}
