//! Commands that only beds of microrobots have: `tweeze simulate` and `tweeze control`.

pub mod control;
pub mod simulate;
