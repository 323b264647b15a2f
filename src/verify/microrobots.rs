//! Replays the runs of microrobots from the voltage of the bed alone.

use super::clock::Run;
use super::rule::Findings;
use super::{Halt, Replay, Standing, Terms, Unfit};
use crate::check::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::CHANNEL;
use crate::schedule::Unit;
use std::collections::BTreeMap;

/// What a channel's numbers are, if the bed has it.
pub(super) fn unit(channel: &str) -> Option<Unit> {
    (channel == CHANNEL).then_some(Unit::Volt)
}

/// What the claims say of a plan's record.
pub(super) fn terms() -> Terms {
    Terms { planner: "one_way_dubins", objective: "time", outcome: "time", unit: "s", scale: 1.0 }
}

/// The objective that minimises an outcome.
pub(super) fn minimized_as(outcome: &'static str) -> Option<&'static str> {
    (outcome == "time").then_some("time")
}

/// Whether a recorded pose is the replayed one, but for rounding.
pub(super) fn near(_recorded: &[f64; 3], _replayed: &[f64; 3]) -> bool {
    false
}

/// A state in words.
pub(super) fn shown(control: usize, poses: &BTreeMap<String, [f64; 3]>) -> String {
    format!("control state {control} with {} robots", poses.len())
}

/// Asks what every rule takes for granted.
pub(super) fn check_claims(_order: &MicrorobotsOrder) -> Result<(), Unfit> {
    Ok(())
}

/// Holds a run against its order.
pub(super) fn replay<'a>(
    _run: &Run<'a>,
    _order: &MicrorobotsOrder,
    _standing: &mut Standing<'a>,
    _findings: &mut Findings,
) -> Result<Replay<'a>, Halt> {
    Err(Halt::Unfit(Unfit("microrobots are not replayed yet".to_owned())))
}
