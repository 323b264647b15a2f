//! Distances in the plane between the area swept by a tip and the core of a body.
//!
//! Input: points in micrometres. Output: the distance between two closed sets, 0 if they meet, in micrometres.
//! Promise: no safety margin, no tolerance; the error is that of a few roundings of the coordinates, about 1e-15 of
//! the largest one. Planners and the checker use this file; the verifier has its own measurements in
//! `verify::geometry`.

use super::fault::{Fault, inject};
use super::shape::Core;
use nalgebra::Point2;

/// A closed segment; its two ends may coincide.
pub type Segment = [Point2<f64>; 2];

/// Distance of a point from a segment.
pub fn point_segment(point: Point2<f64>, segment: Segment) -> f64 {
    point_segment_squared(point, segment).sqrt()
}

/// The square of the distance of a point from a segment.
pub(super) fn point_segment_squared(point: Point2<f64>, [a, b]: Segment) -> f64 {
    let along = b - a;
    let square = along.norm_squared();
    if square == 0.0 {
        return (point - a).norm_squared();
    }
    let share = ((point - a).dot(&along) / square).clamp(0.0, 1.0);
    (point - (a + along * share)).norm_squared()
}

/// Distance between two segments.
pub fn segment_segment(one: Segment, other: Segment) -> f64 {
    if cross(one, other) {
        return 0.0;
    }
    let ends = [
        point_segment(one[0], other),
        point_segment(one[1], other),
        point_segment(other[0], one),
        point_segment(other[1], one),
    ];
    ends.into_iter().fold(f64::INFINITY, f64::min)
}

/// Distance of a segment from a filled polygon, read by the even-odd rule.
pub fn segment_polygon(segment: Segment, corners: &[Point2<f64>]) -> f64 {
    if inside(segment[0], corners) {
        return 0.0;
    }
    edges(corners).map(|edge| segment_segment(segment, edge)).fold(f64::INFINITY, f64::min)
}

/// Distance of a segment from the core of a body.
pub fn segment_core(segment: Segment, core: &Core) -> f64 {
    let distance_um = match core {
        Core::Point(point) => point_segment(*point, segment),
        Core::Segment(other) => segment_segment(segment, *other),
        Core::Polygon(corners) => segment_polygon(segment, corners),
    };
    inject(Fault::Distance, distance_um)
}

/// Distance of a point from the outline of the core of a body.
pub fn point_outline(point: Point2<f64>, core: &Core) -> f64 {
    let distance_um = match core {
        Core::Point(other) => point_segment(point, [*other; 2]),
        Core::Segment(segment) => point_segment(point, *segment),
        Core::Polygon(corners) => edges(corners).map(|edge| point_segment(point, edge)).fold(f64::INFINITY, f64::min),
    };
    inject(Fault::Distance, distance_um)
}

/// Distance of a point from the core of a body, 0 inside.
pub fn point_core(point: Point2<f64>, core: &Core) -> f64 {
    match core {
        Core::Polygon(corners) if inside(point, corners) => 0.0,
        Core::Polygon(_) | Core::Point(_) | Core::Segment(_) => point_outline(point, core),
    }
}

/// Whether a segment crosses the outline of the core of a body.
pub fn crosses(segment: Segment, core: &Core) -> bool {
    match core {
        Core::Point(_) => false,
        Core::Segment(other) => cross(segment, *other),
        Core::Polygon(corners) => edges(corners).any(|edge| cross(segment, edge)),
    }
}

/// Distance of a filled quadrilateral, corners in order around it, from the core of a body.
pub fn quadrilateral_core(quadrilateral: [Point2<f64>; 4], core: &Core) -> f64 {
    let within = match core {
        Core::Point(point) | Core::Segment([point, _]) => Some(point),
        Core::Polygon(corners) => corners.first(),
    };
    if within.is_some_and(|point| inside(*point, &quadrilateral)) {
        return 0.0;
    }
    edges(&quadrilateral).map(|edge| segment_core(edge, core)).fold(f64::INFINITY, f64::min)
}

/// Whether a point is inside a polygon by the even-odd rule. On the border the answer is arbitrary; there the
/// distance to an edge is 0 anyway.
pub(super) fn inside(point: Point2<f64>, corners: &[Point2<f64>]) -> bool {
    edges(corners).fold(false, |inside, [a, b]| {
        let spans = (a.y > point.y) != (b.y > point.y);
        let right = spans && point.x < a.x + (b.x - a.x) * ((point.y - a.y) / (b.y - a.y));
        inside != right
    })
}

/// The edges of a polygon, each from a corner to the next one.
pub(super) fn edges(corners: &[Point2<f64>]) -> impl Iterator<Item = Segment> + '_ {
    corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| [*a, *b])
}

/// Whether each segment has the ends of the other strictly on opposite sides. Segments that only touch are covered by
/// the distances of their ends.
fn cross([a, b]: Segment, [c, d]: Segment) -> bool {
    let side = |p: Point2<f64>, q: Point2<f64>, r: Point2<f64>| (q - p).perp(&(r - p));
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}

#[cfg(test)]
mod tests;
