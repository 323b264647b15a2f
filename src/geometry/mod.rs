//! Device-free mathematics of the plane.

pub mod distance;
pub mod shape;
