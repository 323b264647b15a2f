//! Distance between two convex bodies: the widest gap between their projections (separating axes).
//!
//! Input: the corners of each body in order round it, in micrometres; one is a point, two are a segment. Output: their
//! distance, 0 where they meet. On every line, the projections of two convex bodies are no farther apart than the
//! bodies. On one line they are exactly as far apart; it is perpendicular to an edge, or runs from a corner of one
//! body to a corner of the other (the dual of the least distance of two points). So each line examined gives a lower
//! bound, and the greatest is exact up to a few roundings.

use crate::geometry::fault::{Fault, inject};
use nalgebra::{Point2, Vector2};

/// The distance between two bodies; infinite if one has no corner.
pub fn apart_um(one: &[Point2<f64>], other: &[Point2<f64>]) -> f64 {
    if one.is_empty() || other.is_empty() {
        return f64::INFINITY;
    }
    let across = sides(one).chain(sides(other)).map(|[a, b]| Vector2::new(a.y - b.y, b.x - a.x));
    let between = one.iter().flat_map(|a| other.iter().map(move |b| b - a));
    let apart_um = across.chain(between).map(|line| gap_um(one, other, line)).fold(0.0, f64::max);
    inject(Fault::JudgedDistance, apart_um)
}

/// Each corner with the next one, and the last with the first.
pub fn sides(corners: &[Point2<f64>]) -> impl Iterator<Item = [Point2<f64>; 2]> + '_ {
    corners.iter().zip(corners.iter().cycle().skip(1)).map(|(a, b)| [*a, *b])
}

/// The nearest points of two bodies that are apart: a corner of one of them, and a point on a side of the other. The
/// bodies may be concave. `None` if one has no corner.
pub fn nearest_points(one: &[Point2<f64>], other: &[Point2<f64>]) -> Option<[Point2<f64>; 2]> {
    let to_sides = |corners: &[Point2<f64>], body: &[Point2<f64>]| {
        let pairs: Vec<[Point2<f64>; 2]> = corners
            .iter()
            .flat_map(|corner| sides(body).map(|side| [*corner, nearest_of_side(side, *corner)]))
            .collect();
        pairs
    };
    let turned = to_sides(other, one).into_iter().map(|[theirs, ours]| [ours, theirs]);
    let pairs = to_sides(one, other).into_iter().chain(turned);
    pairs.min_by(|[a, b], [c, d]| (a - b).norm_squared().total_cmp(&(c - d).norm_squared()))
}

fn nearest_of_side([from, to]: [Point2<f64>; 2], point: Point2<f64>) -> Point2<f64> {
    from + (to - from) * share_of_side([from, to], point)
}

/// The fraction of a side at which it is nearest to a point; 0 for a side without length.
pub fn share_of_side([from, to]: [Point2<f64>; 2], point: Point2<f64>) -> f64 {
    let (way, square) = (to - from, (to - from).norm_squared());
    if square > 0.0 { ((point - from).dot(&way) / square).clamp(0.0, 1.0) } else { 0.0 }
}

/// A point moved by a length towards another one.
pub fn towards(from: Point2<f64>, to: Point2<f64>, by_um: f64) -> Point2<f64> {
    let apart_um = (to - from).norm();
    if apart_um > 0.0 { from + (to - from) * (by_um / apart_um) } else { from }
}

/// Gap between the projections of two bodies on a line; at most 0 where they overlap, or if the line has no direction.
fn gap_um(one: &[Point2<f64>], other: &[Point2<f64>], line: Vector2<f64>) -> f64 {
    let length_um = line.norm();
    if length_um == 0.0 {
        return 0.0;
    }
    // Measured from a corner, so that bodies far from the origin lose no digits.
    let shadow = |body: &[Point2<f64>]| {
        let places = body.iter().map(|corner| (corner - one[0]).dot(&line));
        places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], place| [low.min(place), high.max(place)])
    };
    let ([low, high], [other_low, other_high]) = (shadow(one), shadow(other));
    (other_low - high).max(low - other_high) / length_um
}
