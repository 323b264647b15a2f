//! Bounding-box tree over the segments of a curve, for queries of nearby segments.
//!
//! Input: the segments and their nodes. Output: the segments near a point, nearest first, and two segments whose
//! chords meet. Promise: no relevant segment is missed; a query for a point costs about the logarithm of the number
//! of segments.

use super::follow::SegmentedCurve;
use super::jet::{cross, dot, minus};
use crate::real::Real;

/// Least and greatest coordinates.
#[derive(Debug, Clone, Copy)]
struct CoordinateBounds {
    low: [f64; 2],
    high: [f64; 2],
}

impl CoordinateBounds {
    const NONE: CoordinateBounds = CoordinateBounds { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };

    fn with(&self, other: &CoordinateBounds) -> CoordinateBounds {
        let low = [0, 1].map(|axis| self.low[axis].min(other.low[axis]));
        let high = [0, 1].map(|axis| self.high[axis].max(other.high[axis]));
        CoordinateBounds { low, high }
    }

    fn meets(&self, other: &CoordinateBounds) -> bool {
        (0..2).all(|axis| self.low[axis] <= other.high[axis] && other.low[axis] <= self.high[axis])
    }

    /// The square of the distance from a point.
    fn square(&self, point: [f64; 2]) -> f64 {
        let off = |axis: usize| (self.low[axis] - point[axis]).max(point[axis] - self.high[axis]).max(0.0);
        off(0).whole_power(2) + off(1).whole_power(2)
    }
}

/// A binary tree over the segments in order: the children of node i are 2 i and 2 i + 1; segment s is the leaf
/// `leaves` + s.
#[derive(Debug, Clone)]
pub(super) struct SegmentBoxes {
    bounds: Vec<CoordinateBounds>,
    leaves: usize,
}

impl SegmentBoxes {
    pub fn of(segmented: &SegmentedCurve) -> SegmentBoxes {
        let leaves = segmented.segments.len().next_power_of_two();
        let mut bounds = vec![CoordinateBounds::NONE; 2 * leaves];
        for (at, segment) in segmented.segments.iter().enumerate() {
            let [a, b] = [segmented.points_um[at], segmented.points_um[at + 1]];
            let sag = segment.sag_um;
            let low = [0, 1].map(|axis: usize| a[axis].min(b[axis]) - sag);
            let high = [0, 1].map(|axis: usize| a[axis].max(b[axis]) + sag);
            bounds[leaves + at] = CoordinateBounds { low, high };
        }
        for at in (1..leaves).rev() {
            bounds[at] = bounds[2 * at].with(&bounds[2 * at + 1]);
        }
        SegmentBoxes { bounds, leaves }
    }

    /// Calls `square` for segments, to get the square of their distance, as long as one may be nearer than the best.
    pub fn nearest(&self, point: [f64; 2], mut square: impl FnMut(usize, f64) -> f64) {
        let mut best = f64::INFINITY;
        let mut open = vec![(1, self.bounds[1].square(point))];
        while let Some((at, least)) = open.pop() {
            if least >= best || least.is_nan() {
                continue;
            }
            if at >= self.leaves {
                best = best.min(square(at - self.leaves, best));
                continue;
            }
            let mut children = [2 * at, 2 * at + 1].map(|child| (child, self.bounds[child].square(point)));
            if children[0].1 < children[1].1 {
                children.swap(0, 1);
            }
            open.extend(children);
        }
    }

    /// Two segments that are not neighbours and whose chords meet.
    pub fn crossing(&self, segmented: &SegmentedCurve) -> Option<[usize; 2]> {
        let count = segmented.segments.len();
        let chord = |at: usize| [segmented.points_um[at], segmented.points_um[at + 1]];
        let mut open = vec![(1, 1)];
        while let Some((a, b)) = open.pop() {
            if !self.bounds[a].meets(&self.bounds[b]) {
                continue;
            }
            let (a_leaf, b_leaf) = (a >= self.leaves, b >= self.leaves);
            if a_leaf && b_leaf {
                let (one, other) = (a - self.leaves, b - self.leaves);
                let apart = one.abs_diff(other);
                if apart > 1 && apart + 1 < count && meet(chord(one), chord(other)) {
                    return Some([one.min(other), one.max(other)]);
                }
            } else if a == b {
                open.extend([(2 * a, 2 * a), (2 * a + 1, 2 * a + 1), (2 * a, 2 * a + 1)]);
            } else if b_leaf || (!a_leaf && a < b) {
                open.extend([(2 * a, b), (2 * a + 1, b)]);
            } else {
                open.extend([(a, 2 * b), (a, 2 * b + 1)]);
            }
        }
        None
    }
}

/// Whether two closed segments meet.
fn meet(one: [[f64; 2]; 2], other: [[f64; 2]; 2]) -> bool {
    let side = |line: [[f64; 2]; 2], point: [f64; 2]| cross(minus(line[1], line[0]), minus(point, line[0]));
    let sides = [side(one, other[0]), side(one, other[1]), side(other, one[0]), side(other, one[1])];
    let in_line = |line: [[f64; 2]; 2], point: [f64; 2]| dot(minus(point, line[0]), minus(point, line[1])) <= 0.0;
    let touches = (sides[0] == 0.0 && in_line(one, other[0]))
        || (sides[1] == 0.0 && in_line(one, other[1]))
        || (sides[2] == 0.0 && in_line(other, one[0]))
        || (sides[3] == 0.0 && in_line(other, one[1]));
    touches || (sides[0] * sides[1] < 0.0 && sides[2] * sides[3] < 0.0)
}
