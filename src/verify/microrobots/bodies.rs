//! Distance of two bodies, or the depth of their overlap.
//!
//! Input: rectangles and points in micrometres. Output: distances in micrometres, exact up to rounding.

use crate::real::Real;
use nalgebra::{Point2, Vector2};

/// The rectangle of a robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct JudgedBody {
    pub centre: Point2<f64>,
    /// Unit vector along its heading.
    pub along: Vector2<f64>,
    /// Half of its length and width.
    pub half_um: [f64; 2],
}

impl JudgedBody {
    fn across(&self) -> Vector2<f64> {
        Vector2::new(-self.along.y, self.along.x)
    }

    /// The corners, in order round the body.
    pub fn vertices(&self) -> [Point2<f64>; 4] {
        let (length, width) = (self.along * self.half_um[0], self.across() * self.half_um[1]);
        [length + width, width - length, -length - width, length - width].map(|corner| self.centre + corner)
    }

    /// Distance of a point from the body; 0 within it.
    pub fn point_gap_um(&self, point: Point2<f64>) -> f64 {
        let beyond = |axis: Vector2<f64>, half_um: f64| ((point - self.centre).dot(&axis).abs() - half_um).max(0.0);
        beyond(self.along, self.half_um[0]).hypotenuse(beyond(self.across(), self.half_um[1]))
    }

    /// The distance between two bodies; if they overlap, the negative of the least shift that separates them.
    pub fn gap_um(&self, other: &JudgedBody) -> f64 {
        let axes = [self.along, self.across(), other.along, other.across()];
        let apart_um = axes.iter().map(|axis| self.apart_along_um(other, *axis)).fold(f64::NEG_INFINITY, f64::max);
        if apart_um <= 0.0 {
            return apart_um;
        }
        // If two convex bodies are apart, a corner of one of them is at the least distance.
        let ours = self.vertices().into_iter().map(|corner| other.point_gap_um(corner));
        let theirs = other.vertices().into_iter().map(|corner| self.point_gap_um(corner));
        ours.chain(theirs).fold(f64::INFINITY, f64::min)
    }

    /// Gap between the projections of two bodies on an axis.
    fn apart_along_um(&self, other: &JudgedBody, axis: Vector2<f64>) -> f64 {
        let half_um = |body: &JudgedBody| {
            body.half_um[0] * body.along.dot(&axis).abs() + body.half_um[1] * body.across().dot(&axis).abs()
        };
        (other.centre - self.centre).dot(&axis).abs() - half_um(self) - half_um(other)
    }

    /// The area swept by a body that moves straight along its heading.
    pub fn stretched(&self, path_um: f64) -> JudgedBody {
        let [length_um, width_um] = self.half_um;
        let centre = self.centre + self.along * (path_um / 2.0);
        JudgedBody { centre, half_um: [length_um + path_um / 2.0, width_um], ..*self }
    }
}
