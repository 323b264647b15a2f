//! Judges a schedule against the device models and the program's claims, trusting nothing of the planner.
//!
//! Input: a [`Schedule`] and the [`Claims`] of its program. Output: a [`Verified`] schedule, or what is wrong with it.
//! Promise: only this stage can make a `Verified` value, and only such a value can be emitted. No predicate is shared with a
//! planner: places come from the kinematic matrix, sweeps from distances between segments and shapes.

pub mod log;

use crate::check::claims::Claims;
use crate::schedule::Schedule;

/// A schedule that was replayed without a violation, with the claims that it keeps.
#[derive(Debug, Clone)]
pub struct Verified {
    schedule: Schedule,
    claims: Claims,
}

impl Verified {
    /// The schedule.
    pub fn schedule(&self) -> &Schedule {
        &self.schedule
    }

    /// What it was held against.
    pub fn claims(&self) -> &Claims {
        &self.claims
    }

    /// Takes a schedule on trust, for the tests of the stages that come after this one.
    #[cfg(test)]
    pub(crate) fn assume(schedule: Schedule, claims: Claims) -> Self {
        Verified { schedule, claims }
    }
}
