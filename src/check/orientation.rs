//! Orientations in space: from Euler angles and quaternions in a program to unit quaternions.
//!
//! A turn is about an axis of the turned body (intrinsic), so that successive turns multiply from left to right.

use crate::device::shape::Plane;
use nalgebra::{Quaternion, Unit, UnitQuaternion, Vector3};

/// Greatest deviation of a quaternion's length from 1.
pub const NORM_SLACK: f64 = 1e-3;

pub type Orientation = UnitQuaternion<f64>;

/// The quaternion of intrinsic turns about z, y and z, in radians.
pub fn from_euler([a, b, c]: [f64; 3]) -> [f64; 4] {
    let [y, z] = [Plane::Xz, Plane::Xy].map(Plane::normal);
    written(&(about(z, a) * about(y, b) * about(z, c)))
}

/// A quaternion of length 1, its first number not negative.
pub fn unit(numbers: [f64; 4]) -> [f64; 4] {
    written(&read(numbers))
}

/// The orientation of a quaternion w, x, y, z.
pub fn read([w, x, y, z]: [f64; 4]) -> Orientation {
    UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
}

/// The quaternion w, x, y, z as claims hold it, with w not negative.
pub fn written(orientation: &Orientation) -> [f64; 4] {
    let q = orientation.quaternion();
    let sign = if q.w < 0.0 { -1.0 } else { 1.0 };
    // Adding zero turns -0 into 0.
    [q.w, q.i, q.j, q.k].map(|number| sign * number + 0.0)
}

/// A turn about an axis of length 1.
pub fn about([x, y, z]: [f64; 3], angle_rad: f64) -> Orientation {
    UnitQuaternion::from_axis_angle(&Unit::new_unchecked(Vector3::new(x, y, z)), angle_rad)
}
