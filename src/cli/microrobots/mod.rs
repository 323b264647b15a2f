//! Commands for beds of microrobots only: `tweeze simulate`, `tweeze control`, and `tweeze verify` of a recording.

mod control;
mod recorded;
mod remote;
mod simulate;

pub use control::{Address, run as run_control};
pub use recorded::judge as judge_recording;
pub use simulate::run as run_simulate;
