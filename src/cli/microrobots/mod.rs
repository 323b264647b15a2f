//! Commands that only beds of microrobots have: `tweeze simulate` and `tweeze control`.

mod control;
mod remote;
mod simulate;

pub use control::{Address, run as run_control};
pub use simulate::run as run_simulate;
