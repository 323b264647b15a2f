//! Intersections of axis-parallel lines and rectangles with a [`Rounded`] body.
//!
//! Input: a body and a line `y = at` (along x) or `x = at` (along y), or a rectangle. Output: the closed intervals of
//! the line inside the body, or whether the closed rectangle touches the closed body. Promise: exact for every form
//! up to the rounding of `f64`; the intervals of one body may overlap each other and are not sorted.

use super::distance::{Segment, edges, inside, point_segment_squared};
use super::shape::{Core, Rounded};
use crate::real::Real;
use nalgebra::Point2;

/// One of the two axis directions of the plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PlaneAxis {
    /// Along x.
    X,
    /// Along y.
    Y,
}

/// A closed axis-parallel rectangle in µm, `min` ≤ `max` in both coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rectangle {
    /// Lower left corner.
    pub min_um: [f64; 2],
    /// Upper right corner.
    pub max_um: [f64; 2],
}

impl Rounded {
    /// The smallest rectangle that encloses the body.
    pub fn bounds(&self) -> Rectangle {
        let r = self.radius_um;
        let (mut min_um, mut max_um) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in self.core.corners() {
            for k in 0..2 {
                min_um[k] = min_um[k].min(p[k] - r);
                max_um[k] = max_um[k].max(p[k] + r);
            }
        }
        Rectangle { min_um, max_um }
    }

    /// Appends the closed intervals in which the line along `axis` at cross coordinate `at_um` is inside the body.
    pub fn section(&self, axis: PlaneAxis, at_um: f64, found: &mut Vec<[f64; 2]>) {
        let line = |p: Point2<f64>| match axis {
            PlaneAxis::X => [p.x, p.y - at_um],
            PlaneAxis::Y => [p.y, p.x - at_um],
        };
        let r = self.radius_um;
        match &self.core {
            Core::Point(p) => found.extend(disc_section(line(*p), r)),
            Core::Segment([a, b]) => found.extend(capsule_section(line(*a), line(*b), r)),
            Core::Polygon(corners) => {
                let edges = || edges(corners).map(|[a, b]| (line(a), line(b)));
                found.extend(edges().filter_map(|(a, b)| capsule_section(a, b, r)));
                inner_section(edges(), found);
            }
        }
    }

    /// Whether the closed rectangle and the closed body have a point in common.
    pub fn touches(&self, rectangle: &Rectangle) -> bool {
        let reach = self.radius_um * self.radius_um;
        match &self.core {
            Core::Point(p) => rectangle.distance_squared(p) <= reach,
            Core::Segment(ends) => rectangle.near_segment(*ends, reach),
            Core::Polygon(corners) => {
                edges(corners).any(|edge| rectangle.near_segment(edge, reach))
                    || inside(rectangle.min_um.into(), corners)
            }
        }
    }
}

impl Rectangle {
    fn distance_squared(&self, p: &Point2<f64>) -> f64 {
        let gap = |k: usize| (self.min_um[k] - p[k]).max(p[k] - self.max_um[k]).max(0.0);
        gap(0).whole_power(2) + gap(1).whole_power(2)
    }

    // Two disjoint convex sets are nearest at a corner of one of them, so corners and crossings decide.
    fn near_segment(&self, segment: Segment, reach: f64) -> bool {
        segment.iter().any(|end| self.distance_squared(end) <= reach)
            || self.crosses(segment)
            || self.corners().into_iter().any(|corner| point_segment_squared(corner, segment) <= reach)
    }

    fn corners(&self) -> [Point2<f64>; 4] {
        let ([x0, y0], [x1, y1]) = (self.min_um, self.max_um);
        [(x0, y0), (x1, y0), (x1, y1), (x0, y1)].map(|(x, y)| Point2::new(x, y))
    }

    // Clips the segment against the four sides (Liang and Barsky).
    fn crosses(&self, [a, b]: Segment) -> bool {
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for k in 0..2 {
            let run = b[k] - a[k];
            let (low, high) = (self.min_um[k] - a[k], self.max_um[k] - a[k]);
            if run == 0.0 {
                if low > 0.0 || high < 0.0 {
                    return false;
                }
                continue;
            }
            let (near, far) = (low / run, high / run);
            from = from.max(near.min(far));
            to = to.min(near.max(far));
        }
        from <= to
    }
}

// In the next three functions, a point is [along the line, offset from the line].
fn disc_section([along, off]: [f64; 2], r: f64) -> Option<[f64; 2]> {
    // (r − d)(r + d) keeps digits that r² − d² would lose near a tangent.
    let square = (r - off.abs()) * (r + off.abs());
    (square >= 0.0).then(|| [along - square.sqrt(), along + square.sqrt()])
}

// A capsule is convex, so its section is the convex hull of the sections of its end discs and of its two straight
// sides.
fn capsule_section(a: [f64; 2], b: [f64; 2], r: f64) -> Option<[f64; 2]> {
    let (run, rise) = (b[0] - a[0], b[1] - a[1]);
    let length = run.hypotenuse(rise);
    let ends = [disc_section(a, r), disc_section(b, r)];
    let sides = [r, -r].map(|side| {
        let shift = match length > 0.0 {
            true => [-rise / length * side, run / length * side],
            false => return None,
        };
        crossing([a[0] + shift[0], a[1] + shift[1]], [b[0] + shift[0], b[1] + shift[1]])
    });
    ends.into_iter().chain(sides).flatten().reduce(|p, q| [p[0].min(q[0]), p[1].max(q[1])])
}

fn crossing(a: [f64; 2], b: [f64; 2]) -> Option<[f64; 2]> {
    if (a[1] <= 0.0) == (b[1] <= 0.0) {
        return None;
    }
    let t = (a[1] / (a[1] - b[1])).clamp(0.0, 1.0);
    let at = a[0] + t * (b[0] - a[0]);
    Some([at, at])
}

fn inner_section(edges: impl Iterator<Item = ([f64; 2], [f64; 2])>, found: &mut Vec<[f64; 2]>) {
    let mut cuts: Vec<f64> = edges.filter_map(|(a, b)| crossing(a, b)).map(|[at, _]| at).collect();
    cuts.sort_by(f64::total_cmp);
    found.extend(cuts.chunks_exact(2).map(|pair| [pair[0], pair[1]]));
}

#[cfg(test)]
mod tests;
