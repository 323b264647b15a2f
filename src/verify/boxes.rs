//! Finds the boxes that meet an area, by a two-level list that avoids most comparisons.
//!
//! Input: axis-aligned boxes. Output: those that meet an area, touching included, in ascending order of index. Cost of
//! a query: one comparison per group, plus one per member of the groups that meet the area.

use nalgebra::Point2;

/// Boxes per group.
const GROUP: usize = 32;

/// An axis-aligned box, borders included.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Extent {
    pub low: [f64; 2],
    pub high: [f64; 2],
}

impl Extent {
    /// Bounding box of some points; of no points, a box that meets none.
    pub fn of(points: &[Point2<f64>]) -> Extent {
        let none = Extent { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };
        points.iter().fold(none, |all, point| all.with(Extent { low: [point.x, point.y], high: [point.x, point.y] }))
    }

    /// The box widened on all sides.
    pub fn widened(self, by: f64) -> Extent {
        Extent { low: self.low.map(|value| value - by), high: self.high.map(|value| value + by) }
    }

    fn with(self, other: Extent) -> Extent {
        let both = |pick: fn(f64, f64) -> f64, a: [f64; 2], b: [f64; 2]| [pick(a[0], b[0]), pick(a[1], b[1])];
        Extent { low: both(f64::min, self.low, other.low), high: both(f64::max, self.high, other.high) }
    }

    /// Whether the two have a point in common.
    pub fn meets(&self, other: &Extent) -> bool {
        (0..2).all(|axis| self.low[axis] <= other.high[axis] && other.low[axis] <= self.high[axis])
    }

    /// The greater of the signed gaps of the two boxes along x and y; at most 0 if they meet.
    pub fn gap_um(&self, other: &Extent) -> f64 {
        let along = |axis: usize| (self.low[axis] - other.high[axis]).max(other.low[axis] - self.high[axis]);
        along(0).max(along(1))
    }

    fn centre(&self, axis: usize) -> f64 {
        self.low[axis] / 2.0 + self.high[axis] / 2.0
    }
}

/// Boxes with their indices, in groups of neighbours.
#[derive(Debug, Default)]
pub(super) struct GroupedBoxes {
    groups: Vec<(Extent, Vec<(Extent, usize)>)>,
}

impl GroupedBoxes {
    /// Groups boxes into strips by x, and each strip into groups by y.
    pub fn new(extents: impl Iterator<Item = Extent>) -> GroupedBoxes {
        let mut all: Vec<(Extent, usize)> = extents.enumerate().map(|(index, extent)| (extent, index)).collect();
        let strips = (all.len() as f64 / GROUP as f64).sqrt().ceil().max(1.0) as usize;
        let strip = all.len().div_ceil(strips).max(1);
        all.sort_by(|a, b| a.0.centre(0).total_cmp(&b.0.centre(0)));
        let mut groups = Vec::new();
        for strip in all.chunks_mut(strip) {
            strip.sort_by(|a, b| a.0.centre(1).total_cmp(&b.0.centre(1)));
            groups.extend(strip.chunks(GROUP).map(|group| {
                let outer = group.iter().skip(1).fold(group[0].0, |outer, (extent, _)| outer.with(*extent));
                (outer, group.to_vec())
            }));
        }
        GroupedBoxes { groups }
    }

    /// The indices of the boxes that meet an area, ascending.
    pub fn meeting(&self, area: &Extent) -> Vec<usize> {
        let near = self.groups.iter().filter(|(outer, _)| outer.meets(area)).flat_map(|(_, group)| group);
        let mut found: Vec<usize> = near.filter(|(extent, _)| extent.meets(area)).map(|(_, index)| *index).collect();
        found.sort_unstable();
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn extent() -> impl Strategy<Value = Extent> {
        (-9..9i32, -9..9i32, 0..4i32, 0..4i32).prop_map(|(x, y, wide, high)| {
            let [x, y, wide, high] = [x, y, wide, high].map(f64::from);
            Extent { low: [x, y], high: [x + wide, y + high] }
        })
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn none_is_missed(all in prop::collection::vec(extent(), 0..300), area in extent()) {
            let meets = |one: &Extent| {
                (0..2).all(|axis| one.low[axis].max(area.low[axis]) <= one.high[axis].min(area.high[axis]))
            };
            let expected: Vec<usize> = (0..all.len()).filter(|index| meets(&all[*index])).collect();
            prop_assert_eq!(GroupedBoxes::new(all.into_iter()).meeting(&area), expected);
        }
    }
}
