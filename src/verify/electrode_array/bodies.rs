//! How near the bodies of parts come to each other and to obstacles in one step of the board.
//!
//! A part is pulled, runs over and settles in a time of its own, so in a step it may be anywhere between its start and its end,
//! whatever another one does. What a part sweeps is the rectangle of its centre's way; two parts are as near as their rectangles.
//! With the distances of whole cells that is as strict as asking all four combinations of starts and ends.

use super::super::boxes::{Boxes, Extent};
use crate::check::claims::electrode_array::{Body, ElectrodeArrayOrder};
use crate::device::electrode_array::{Cell, Facts};
use nalgebra::Point2;
use rustc_hash::FxHashMap;

/// Where the centre of a part can be in one step of the board: a rectangle of cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Way {
    low: Cell,
    high: Cell,
}

impl Way {
    /// From a cell to another.
    pub fn new(from: Cell, to: Cell) -> Way {
        let low = Cell::new(from.column.min(to.column), from.row.min(to.row));
        Way { low, high: Cell::new(from.column.max(to.column), from.row.max(to.row)) }
    }

    /// Without the moments in which the centre is on one of its ends, or on the way to or from it; `None` if nothing is left.
    pub fn besides(from: Cell, to: Cell, goal: Cell) -> Option<Way> {
        match (from == goal, to == goal) {
            (false, false) => Some(Way::new(from, to)),
            (false, true) => Some(Way::new(from, from)),
            (true, false) => Some(Way::new(to, to)),
            (true, true) => None,
        }
    }

    /// The least Chebyshev distance of two centres.
    pub fn apart(&self, other: &Way) -> u32 {
        let gap = |low: u32, high: u32, other_low: u32, other_high: u32| {
            other_low.saturating_sub(high).max(low.saturating_sub(other_high))
        };
        let columns = gap(self.low.column, self.high.column, other.low.column, other.high.column);
        columns.max(gap(self.low.row, self.high.row, other.low.row, other.high.row))
    }
}

/// The least distance that two centres keep, in electrodes: the separation of the device, which leaves room for the oscillation
/// at the end of a move; and never so little that the bodies overlap.
pub(super) fn needed(facts: &Facts) -> u32 {
    let width = (2.0 * facts.layout.half_width_pitches).ceil();
    facts.separation.apart().max(width as u32)
}

/// The first two parts that come nearer than a distance, with how near they come. `apart` tells how near two parts come, by
/// their places in the list; `None` if there is nothing to keep between them.
pub(super) fn first_touch(
    ways: &[Way],
    needed: u32,
    apart: impl Fn(usize, usize) -> Option<u32>,
) -> Option<(usize, usize, u32)> {
    // A way is at most two cells long, so ways that come too near begin in neighbouring buckets.
    let bucket = |way: &Way| [way.low.column, way.low.row].map(|at| i64::from(at / needed.saturating_add(1)));
    let mut buckets: FxHashMap<[i64; 2], Vec<usize>> = FxHashMap::default();
    for (index, way) in ways.iter().enumerate() {
        buckets.entry(bucket(way)).or_default().push(index);
    }
    let around = |[column, row]: [i64; 2]| {
        (column - 1..=column + 1).flat_map(move |column| (row - 1..=row + 1).map(move |row| [column, row]))
    };
    ways.iter().enumerate().find_map(|(one, way)| {
        let near = around(bucket(way)).filter_map(|bucket| buckets.get(&bucket)).flatten();
        let later = near.filter(|other| **other > one);
        let touched =
            later.filter_map(|other| Some((*other, apart(one, *other)?))).filter(|(_, apart)| *apart < needed);
        touched.min().map(|(other, apart)| (one, other, apart))
    })
}

/// The obstacles of an order, ready to be asked.
pub(super) struct Scene {
    clearance: u32,
    needed: u32,
    /// Obstacles of electrodes, each with its index among the obstacles of the order.
    blocks: Vec<(usize, Way)>,
    block_boxes: Boxes,
    /// Parts that are stuck.
    fixed: Vec<(usize, Way)>,
    fixed_boxes: Boxes,
}

impl Scene {
    /// Sorts the obstacles.
    pub fn new(order: &ElectrodeArrayOrder) -> Scene {
        let (mut blocks, mut fixed) = (Vec::new(), Vec::new());
        for (index, obstacle) in order.obstacles.iter().enumerate() {
            match obstacle.body {
                Body::Electrodes { from, to } => blocks.push((index, Way::new(from, to))),
                Body::Fixed(cell) => fixed.push((index, Way::new(cell, cell))),
            }
        }
        let boxes = |bodies: &[(usize, Way)]| Boxes::new(bodies.iter().map(|(_, body)| extent(body)));
        let (block_boxes, fixed_boxes) = (boxes(&blocks), boxes(&fixed));
        let (clearance, needed) = (order.facts.clearance, needed(&order.facts));
        Scene { clearance, needed, blocks, block_boxes, fixed, fixed_boxes }
    }

    /// The first obstacle of electrodes that a centre is too near to, with its distance.
    pub fn blocked(&self, at: Cell) -> Option<(usize, u32)> {
        first(&self.blocks, &self.block_boxes, &Way::new(at, at), self.clearance - 1)
    }

    /// The first part that is stuck and that another comes too near to, with the distance.
    pub fn stuck(&self, way: &Way) -> Option<(usize, u32)> {
        first(&self.fixed, &self.fixed_boxes, way, self.needed - 1)
    }

    /// The first part that is stuck and that an electrode acts on.
    pub fn pulled(&self, electrode: Cell, reach: i64) -> Option<usize> {
        let reach = u32::try_from(reach).unwrap_or(0);
        first(&self.fixed, &self.fixed_boxes, &Way::new(electrode, electrode), reach).map(|(obstacle, _)| obstacle)
    }
}

/// The first of some bodies that lies no farther than a distance from an area, with its distance.
fn first(bodies: &[(usize, Way)], boxes: &Boxes, area: &Way, within: u32) -> Option<(usize, u32)> {
    let near = boxes.meeting(&extent(area).widened(f64::from(within)));
    near.first().map(|at| (bodies[*at].0, bodies[*at].1.apart(area)))
}

fn extent(way: &Way) -> Extent {
    Extent::of(&[way.low, way.high].map(|cell| Point2::new(f64::from(cell.column), f64::from(cell.row))))
}
