//! A robot's body as an oriented rectangle, and its distances.

use crate::geometry::distance::{Segment, crosses, point_outline, quadrilateral_core};
use crate::geometry::{Pose, Rounded};
use crate::real::Real;
use nalgebra::Point2;

/// An oriented rectangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrientedRectangle {
    pub centre_um: [f64; 2],
    /// Cosine and sine of the heading of its length.
    pub axis: [f64; 2],
    /// Half its length and half its width.
    pub half_um: [f64; 2],
}

impl OrientedRectangle {
    /// The rectangle of a body at a pose.
    pub fn new(pose: Pose, half_um: [f64; 2]) -> Self {
        let (sin, cos) = pose.heading_rad.sine_cosine();
        OrientedRectangle { centre_um: [pose.x_um, pose.y_um], axis: [cos, sin], half_um }
    }

    /// The rectangle that it sweeps when it moves along its length.
    pub fn swept(&self, way_um: f64) -> Self {
        let [x_um, y_um] = self.centre_um;
        let [cos, sin] = self.axis;
        let half = way_um / 2.0;
        OrientedRectangle {
            centre_um: [x_um + half * cos, y_um + half * sin],
            half_um: [self.half_um[0] + half.abs(), self.half_um[1]],
            ..*self
        }
    }

    /// The corners in order around it.
    pub fn corners(&self) -> [[f64; 2]; 4] {
        let [x_um, y_um] = self.centre_um;
        let [cos, sin] = self.axis;
        let [a_um, b_um] = self.half_um;
        [(a_um, b_um), (-a_um, b_um), (-a_um, -b_um), (a_um, -b_um)]
            .map(|(along_um, left_um)| [x_um + along_um * cos - left_um * sin, y_um + along_um * sin + left_um * cos])
    }

    fn local(&self, [x_um, y_um]: [f64; 2]) -> [f64; 2] {
        let (dx, dy) = (x_um - self.centre_um[0], y_um - self.centre_um[1]);
        let [cos, sin] = self.axis;
        [dx * cos + dy * sin, dy * cos - dx * sin]
    }

    /// Distance to a point, 0 inside.
    pub fn to_point_um(&self, point_um: [f64; 2]) -> f64 {
        let [along_um, left_um] = self.local(point_um);
        (along_um.abs() - self.half_um[0]).max(0.0).hypotenuse((left_um.abs() - self.half_um[1]).max(0.0))
    }

    /// Distance to a body, 0 on contact; negative if the body is rounded and its core is nearer than its radius.
    pub fn to_rounded_um(&self, body: &Rounded) -> f64 {
        quadrilateral_core(self.corners().map(|[x, y]| Point2::new(x, y)), &body.core) - body.radius_um
    }

    /// Like [`Self::to_rounded_um`], but may return a lower bound above `enough_um` instead: the distance of the body
    /// beyond one of the sides, which is much cheaper.
    pub fn nearly_to_rounded_um(&self, body: &Rounded, enough_um: f64) -> f64 {
        let [a_um, b_um] = self.half_um;
        let (mut back_um, mut front_um, mut right_um, mut left_um) =
            (f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY);
        let mut nearest_um2 = f64::INFINITY;
        for point in body.core.corners() {
            let [along_um, aside_um] = self.local([point.x, point.y]);
            (back_um, front_um) = (back_um.min(along_um), front_um.max(along_um));
            (right_um, left_um) = (right_um.min(aside_um), left_um.max(aside_um));
            let (ahead_um, beside_um) = ((along_um.abs() - a_um).max(0.0), (aside_um.abs() - b_um).max(0.0));
            nearest_um2 = nearest_um2.min(ahead_um * ahead_um + beside_um * beside_um);
        }
        let beyond_um = (back_um.max(-front_um) - a_um).max(right_um.max(-left_um) - b_um);
        if beyond_um - body.radius_um > enough_um {
            return beyond_um - body.radius_um;
        }
        let theirs_um = nearest_um2.sqrt();
        if beyond_um > 0.0 {
            // A line separates the two, so the nearest point of one of them is a corner.
            let own = self.corners().into_iter().map(|[x, y]| point_outline(Point2::new(x, y), &body.core));
            return own.fold(theirs_um, f64::min) - body.radius_um;
        }
        match theirs_um == 0.0 || crosses(self.spine(), &body.core) {
            true => -body.radius_um,
            false => self.to_rounded_um(body),
        }
    }

    /// Centre line along its length.
    fn spine(&self) -> Segment {
        let ([x_um, y_um], [cos, sin], along_um) = (self.centre_um, self.axis, self.half_um[0]);
        [-along_um, along_um].map(|along_um| Point2::new(x_um + along_um * cos, y_um + along_um * sin))
    }

    /// Distance between two rectangles; negative where they overlap, by the least translation that separates them.
    ///
    /// The overlap of two convex polygons is the least of their overlaps along the normals of their sides; if they do
    /// not overlap, a corner of one is nearest to the other.
    pub fn to_rectangle_um(&self, other: &OrientedRectangle) -> f64 {
        let apart_um = self.apart_um(other).max(other.apart_um(self));
        if apart_um <= 0.0 {
            return apart_um;
        }
        let of = |one: &OrientedRectangle, two: &OrientedRectangle| {
            two.corners().into_iter().map(|corner| one.to_point_um(corner)).fold(f64::INFINITY, f64::min)
        };
        of(self, other).min(of(other, self))
    }

    /// Distance of another rectangle beyond the sides of this one.
    fn apart_um(&self, other: &OrientedRectangle) -> f64 {
        let [along_um, left_um] = self.local(other.centre_um);
        let cos = (self.axis[0] * other.axis[0] + self.axis[1] * other.axis[1]).abs();
        let sin = (self.axis[0] * other.axis[1] - self.axis[1] * other.axis[0]).abs();
        let [a_um, b_um] = other.half_um;
        let beyond_um = along_um.abs() - self.half_um[0] - a_um * cos - b_um * sin;
        beyond_um.max(left_um.abs() - self.half_um[1] - a_um * sin - b_um * cos)
    }
}
