//! Device-free plane geometry in micrometres: shapes, where they are placed, and how lines and rectangles meet them.

pub mod distance;
pub(crate) mod fault;
pub mod mesh;
pub mod outline;
pub mod polygon;
pub mod section;
pub mod shape;

pub use section::Axis;
pub use shape::{Core, Pose, Rounded, Shape, ShapeError};
