//! Obstacles in their places, without inflation.
//!
//! Input: a shape and a pose of the claims, in micrometres and radians. Output: the distance of a convex body from the
//! obstacle. Obstacles are not inflated: callers compare the gap with the required clearance.

use super::super::boxes::Extent;
use super::convex::{apart_um, nearest_points, sides, towards};
use crate::geometry::fault::{Fault, inject};
use crate::geometry::shape::MAX_EXTENT_UM;
use crate::geometry::{Pose, Shape};
use crate::real::Real;
use nalgebra::Point2;

/// A placed shape: all points within a radius of its frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Solid {
    frame: Frame,
    radius_um: f64,
}

/// The corners of a shape, in scene coordinates.
#[derive(Debug, Clone, PartialEq)]
enum Frame {
    /// A point, a segment, or a convex polygon.
    Convex(Vec<Point2<f64>>),
    /// A filled polygon that may be concave.
    Outline(Vec<Point2<f64>>),
}

impl Solid {
    /// Places a shape. `None` if it is invalid: a number is out of range, or a polygon has fewer than three corners.
    pub fn of(shape: &Shape, pose: &Pose) -> Option<Solid> {
        let (corners, radius_um) = parts(shape);
        let numbers = [pose.x_um, pose.y_um, pose.heading_rad, radius_um];
        let in_range = |number: &f64| number.abs() <= MAX_EXTENT_UM;
        let is_sound = radius_um >= 0.0
            && corners.iter().flatten().chain(&numbers).all(in_range)
            && match shape {
                Shape::Point | Shape::Disc { .. } => true,
                Shape::Box { size_um } => size_um.iter().all(|size_um| *size_um >= 0.0 && in_range(size_um)),
                Shape::Capsule { length_um, .. } => *length_um >= 0.0 && in_range(length_um),
                Shape::Polygon { points_um } => points_um.len() >= 3,
            };
        let (sin, cos) = pose.heading_rad.sine_cosine();
        let x_um = inject(Fault::JudgedPlace, pose.x_um);
        let place = |[x, y]: &[f64; 2]| Point2::new(x_um + (x * cos - y * sin), pose.y_um + (x * sin + y * cos));
        let corners = corners.iter().map(place).collect();
        let frame = match shape {
            Shape::Polygon { .. } => Frame::Outline(corners),
            Shape::Point | Shape::Disc { .. } | Shape::Box { .. } | Shape::Capsule { .. } => Frame::Convex(corners),
        };
        is_sound.then_some(Solid { frame, radius_um })
    }

    /// Bounding box.
    pub fn extent(&self) -> Extent {
        match &self.frame {
            Frame::Convex(corners) | Frame::Outline(corners) => Extent::of(corners).widened(self.radius_um),
        }
    }

    /// Distance of a convex body, its corners in order, from the obstacle; 0 or a negative number if they overlap.
    pub fn gap_um(&self, body: &[Point2<f64>]) -> f64 {
        let apart_um = match &self.frame {
            Frame::Convex(corners) => apart_um(corners, body),
            Frame::Outline(corners) => apart_from_outline_um(corners, body),
        };
        apart_um - self.radius_um
    }

    /// The nearest points of the obstacle and of a convex body apart from it; `None` for a body without corners.
    pub fn nearest_points(&self, body: &[Point2<f64>]) -> Option<[Point2<f64>; 2]> {
        let (Frame::Convex(corners) | Frame::Outline(corners)) = &self.frame;
        let [ours, theirs] = nearest_points(corners, body)?;
        Some([towards(ours, theirs, self.radius_um), theirs])
    }
}

/// The corners of a shape in its own coordinates, and the radius about them.
fn parts(shape: &Shape) -> (Vec<[f64; 2]>, f64) {
    match shape {
        Shape::Point => (vec![[0.0, 0.0]], 0.0),
        Shape::Disc { radius_um } => (vec![[0.0, 0.0]], *radius_um),
        Shape::Box { size_um: [width_um, height_um] } => {
            let corner = |x: f64, y: f64| [x * width_um, y * height_um];
            (vec![corner(0.5, 0.5), corner(-0.5, 0.5), corner(-0.5, -0.5), corner(0.5, -0.5)], 0.0)
        }
        Shape::Polygon { points_um } => (points_um.clone(), 0.0),
        Shape::Capsule { length_um, radius_um } => (vec![[0.5 * length_um, 0.0], [-0.5 * length_um, 0.0]], *radius_um),
    }
}

/// Distance of a convex body from a filled polygon. A body that meets no side is entirely inside or entirely outside;
/// one that contains the whole polygon meets its sides.
fn apart_from_outline_um(corners: &[Point2<f64>], body: &[Point2<f64>]) -> f64 {
    if body.first().is_some_and(|point| winds_round(corners, *point)) {
        return 0.0;
    }
    let area = Extent::of(body);
    sides(corners).fold(f64::INFINITY, |least_um, side| match Extent::of(&side).gap_um(&area) < least_um {
        true => least_um.min(apart_um(&side, body)),
        false => least_um,
    })
}

/// Whether an outline has a non-zero winding number round a point: its sides cross the ray to the right more often one
/// way than the other. For a point on the outline, either answer is possible.
fn winds_round(corners: &[Point2<f64>], point: Point2<f64>) -> bool {
    let crossing = |[a, b]: [Point2<f64>; 2]| {
        let is_left = (b - a).perp(&(point - a));
        match (a.y <= point.y, b.y <= point.y) {
            (true, false) if is_left > 0.0 => 1,
            (false, true) if is_left < 0.0 => -1,
            (true | false, true | false) => 0,
        }
    };
    sides(corners).map(crossing).sum::<i32>() != 0
}
