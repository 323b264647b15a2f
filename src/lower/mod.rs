//! Lowering: turns the plans of a program's jobs into its [`Schedule`](crate::schedule::Schedule), with all
//! actuations on one clock.
//!
//! Input: the claims and a [`Plan`](crate::plan::Plan) for each job. Output: a schedule. Each kind turns a plan into
//! a [`clock::LoweredRun`], timed from its own instant 0; [`clock`] places the runs according to the timeline.

mod bench;
pub mod clock;
mod dimibot;
pub(crate) mod electrode_array;
pub(crate) mod fingers;
mod holds;
pub mod microrobots;
mod outputs;
mod sampled;
mod stages;
pub mod timeline;
mod wired_channel;

pub use clock::lower;

use crate::device::each_kind;
use crate::plan::Motion;
use crate::schedule::ChannelUnit;
use clock::LoweredRun;

/// Lowering of a kind's plans.
trait Lowered {
    /// The plan, timed from its own instant 0; `None` if its duration exceeds a `u64`.
    fn run(&self) -> Option<LoweredRun>;

    /// The channels of the device that the schedule lists, without the device's name: all of them for a device with
    /// few channels; for one with very many, those used by some run of the device. `own` are these runs.
    fn channels(&self, own: &mut dyn Iterator<Item = &LoweredRun>) -> Vec<(String, ChannelUnit)>;
}

/// The lowering of a motion.
fn lowered<'a>(motion: &'a Motion) -> &'a dyn Lowered {
    each_kind!(Motion, motion, planned => planned)
}
