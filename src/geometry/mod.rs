//! Device-free geometry in micrometres: shapes and their placement, outlines, meshes, distances, and intersections of
//! lines and rectangles with shapes.

pub mod distance;
pub(crate) mod fault;
pub mod mesh;
pub mod outline;
pub mod polygon;
pub mod section;
pub mod shape;

pub use section::PlaneAxis;
pub use shape::{Core, Pose, Rounded, Shape, ShapeError};
