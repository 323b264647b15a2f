//! A plan of a hand as the positions of its stages, on a clock of its own.
//!
//! Each axis of each finger has a value at every instant of a run: ramps while it moves, and one stretch as long as it stays.

use super::clock::Run;
use crate::check::claims::fingers::FingersOrder;
use crate::plan::fingers::Motion;

/// A plan from its own instant 0; `None` if it lasts longer than a `u64` counts.
pub fn run(_order: &FingersOrder, _motion: &Motion) -> Option<Run> {
    None
}
