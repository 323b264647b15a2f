//! Lowering: from the plans of a program's jobs to its [`Schedule`](crate::schedule::Schedule), actuations on one clock.
//!
//! Input: the claims and a [`Plan`](crate::plan::Plan) for each job. Output: a schedule. Each kind turns a plan into a [`clock::LoweredRun`]
//! of its own, from its own instant 0; [`clock`] puts the runs where the timeline wants them.

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

/// What a kind brings to this stage, on its plans.
trait Lowered {
    /// The plan from its own instant 0; `None` if it lasts longer than a `u64` counts.
    fn run(&self) -> Option<LoweredRun>;

    /// The channels of the device that the schedule lists, without the device's name: of a few all, of very many those that some run
    /// of the device uses. `own` are these runs.
    fn channels(&self, own: &mut dyn Iterator<Item = &LoweredRun>) -> Vec<(String, ChannelUnit)>;
}

/// The lowering of a motion.
fn lowered<'a>(motion: &'a Motion) -> &'a dyn Lowered {
    each_kind!(Motion, motion, planned => planned)
}
