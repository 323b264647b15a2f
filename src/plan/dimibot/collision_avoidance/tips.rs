//! Tip areas of placed robots in their scene, and which of them come near each other.
//!
//! Input: cells of a robot and the pose of its frame. Output: areas of the scene, in micrometres. Guaranteed: two areas are near if
//! their distance is at most the given gap. An area is a rectangle, a segment or a point; the distance is 0 unless a separating
//! line exists, and is otherwise measured between corners and edges.

use crate::claims::dimibot::in_scene_um;
use crate::device::dimibot::{DimibotFacts, LatticeCell};
use crate::geometry::shape::{Pose, Shape};
use nalgebra::{Point2, Vector2};

/// A robot placed in its scene.
#[derive(Debug, Clone)]
pub struct PlacedRobot {
    pub facts: DimibotFacts,
    pub frame: Pose,
}

/// A rectangle of the scene; degenerates to a segment where one module moves, and to a point where none does.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Area {
    /// In order around the rectangle.
    corners: [Point2<f64>; 4],
    low: [f64; 2],
    high: [f64; 2],
}

impl PlacedRobot {
    /// All positions of the tip's centre while the modules that differ between two cells switch, in any order.
    pub fn between(&self, from: LatticeCell, to: LatticeCell) -> Area {
        let (low, high) =
            (LatticeCell::new(from.x & to.x, from.y & to.y), LatticeCell::new(from.x | to.x, from.y | to.y));
        let around = [low, LatticeCell::new(high.x, low.y), high, LatticeCell::new(low.x, high.y)];
        let corners = around.map(|cell| Point2::from(in_scene_um(self.facts.place_um(cell), Some(&self.frame))));
        let extreme = |pick: fn(f64, f64) -> f64| {
            [0, 1].map(|axis| corners[1..].iter().fold(corners[0][axis], |value, corner| pick(value, corner[axis])))
        };
        Area { corners, low: extreme(f64::min), high: extreme(f64::max) }
    }

    /// The position of a cell.
    pub fn at(&self, cell: LatticeCell) -> Area {
        self.between(cell, cell)
    }

    /// An obstacle that contains all points within a distance of an area of this robot.
    pub fn obstacle(&self, area: &Area, around_um: f64) -> (Shape, Pose) {
        let [a, b, c, d] = area.corners;
        let size_um = [(b - a).norm(), (d - a).norm()];
        let (x_um, y_um) = ((a.x + c.x) / 2.0, (a.y + c.y) / 2.0);
        let pose = Pose { x_um, y_um, heading_rad: self.frame.heading_rad };
        let shape = match size_um {
            [0.0, 0.0] => Shape::Disc { radius_um: around_um },
            size_um => Shape::Box { size_um: size_um.map(|size| size + 2.0 * around_um) },
        };
        (shape, pose)
    }
}

impl Area {
    /// Whether the distance between two areas is at most `gap_um`.
    pub fn is_near(&self, other: &Area, gap_um: f64) -> bool {
        let boxes_meet = (0..2)
            .all(|axis| self.low[axis] - gap_um <= other.high[axis] && other.low[axis] - gap_um <= self.high[axis]);
        boxes_meet && self.distance_um(other) <= gap_um
    }

    /// Distance between two areas.
    pub fn distance_um(&self, other: &Area) -> f64 {
        if !self.is_parted_from(other) && !other.is_parted_from(self) {
            return 0.0;
        }
        let from = |one: &Area, other: &Area| {
            let pairs = one.corners.iter().flat_map(|corner| edges(&other.corners).map(|edge| to_edge(*corner, edge)));
            pairs.fold(f64::INFINITY, f64::min)
        };
        from(self, other).min(from(other, self))
    }

    /// Whether a line parallel or perpendicular to one of its edges separates it from another area.
    fn is_parted_from(&self, other: &Area) -> bool {
        edges(&self.corners).any(|[from, to]| {
            let way = to - from;
            [Vector2::new(-way.y, way.x), way].into_iter().any(|normal| {
                let reach = |area: &Area| {
                    let along = area.corners.map(|corner| (corner - from).dot(&normal));
                    let least = along.iter().copied().fold(f64::INFINITY, f64::min);
                    [least, along.iter().copied().fold(f64::NEG_INFINITY, f64::max)]
                };
                let ([low, high], [other_low, other_high]) = (reach(self), reach(other));
                high < other_low || other_high < low
            })
        }) || self.is_point() && other.is_point() && self.corners[0] != other.corners[0]
    }

    fn is_point(&self) -> bool {
        self.low == self.high
    }
}

fn edges(corners: &[Point2<f64>; 4]) -> impl Iterator<Item = [Point2<f64>; 2]> + use<> {
    let [a, b, c, d] = *corners;
    [[a, b], [b, c], [c, d], [d, a]].into_iter()
}

fn to_edge(point: Point2<f64>, [from, to]: [Point2<f64>; 2]) -> f64 {
    let (way, off) = (to - from, point - from);
    let square = way.norm_squared();
    let share = if square > 0.0 { (off.dot(&way) / square).clamp(0.0, 1.0) } else { 0.0 };
    (off - way * share).norm()
}
