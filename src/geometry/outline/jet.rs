//! A point of a curve with its first two derivatives, and vector operations in the plane.

use crate::real::Real;

/// A point with its first two derivatives by the parameter.
#[derive(Debug, Clone, Copy)]
pub(super) struct Jet {
    pub point: [f64; 2],
    pub first: [f64; 2],
    pub second: [f64; 2],
}

impl Jet {
    pub fn speed(&self) -> f64 {
        norm(self.first)
    }

    pub fn normal(&self) -> [f64; 2] {
        let speed = self.speed();
        [self.first[1] / speed, -self.first[0] / speed]
    }

    pub fn curvature(&self) -> f64 {
        cross(self.first, self.second) / self.speed().whole_power(3)
    }

    /// The derivative of the speed.
    pub fn speed_derivative(&self) -> f64 {
        dot(self.first, self.second) / self.speed()
    }
}

pub(super) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(super) fn cross(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(super) fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

pub(super) fn norm(a: [f64; 2]) -> f64 {
    a[0].hypotenuse(a[1])
}
