//! Is this hand possible, is this object one that it can turn, are these steps of it?

mod bench;
mod curve;
mod facts;
pub mod orientation;
mod part;
pub mod solid;
mod step;
mod steps;
mod walk;

pub use bench::HandScene;
pub use curve::ANGLE_NAME;
pub use facts::facts;
pub use walk::hands_agree;

#[cfg(test)]
mod tests;
