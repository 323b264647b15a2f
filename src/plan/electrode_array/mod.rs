//! The planner of electrode arrays: many parts at once from their cells to their goals, one step of the platform after the other.

pub mod board;
pub mod exact;
pub mod joint;
pub mod published;
