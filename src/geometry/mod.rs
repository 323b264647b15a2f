//! Device-free mathematics of the plane.

pub mod shape;
