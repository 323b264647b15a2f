//! Replays the run of a hand from the positions of its stages alone.

use super::clock::Run;
use super::rule::Findings;
use super::{Halt, Replay, Standing, Terms, Unfit};
use crate::check::claims::fingers::{FingersOrder, Planner};
use crate::device::fingers::finger_axis;
use crate::schedule::{State, Unit};

/// What a channel's numbers are, if the hand has it.
pub(super) fn unit(channel: &str, order: &FingersOrder) -> Option<Unit> {
    let (finger, _) = finger_axis(channel)?;
    (finger < order.facts.fingers as usize).then_some(Unit::Micrometre)
}

/// What the claims say of a plan's record.
pub(super) fn terms(order: &FingersOrder) -> Terms {
    let planner = match order.planner {
        Planner::JointAstar => "joint_astar",
        Planner::PublishedAstar => "published_astar",
        Planner::GreedyDecomposition => "greedy_decomposition",
    };
    Terms { planner, objective: "effort", outcome: "effort", unit: "deg", scale: 180.0 / std::f64::consts::PI }
}

/// The objective that minimises an outcome.
pub(super) fn minimized_as(outcome: &'static str) -> Option<&'static str> {
    (outcome == "effort").then_some("effort")
}

/// Asks what every rule takes for granted.
pub(super) fn check_claims(_order: &FingersOrder) -> Result<(), Unfit> {
    Ok(())
}

/// Whether a recorded state is the replayed one, but for rounding.
pub(super) fn near(_recorded: &State, _replayed: &State) -> bool {
    false
}

/// A state in words.
pub(super) fn shown(_state: &State) -> String {
    String::new()
}

/// Holds a run against its order.
pub(super) fn replay<'a>(
    _run: &Run<'a>,
    _order: &FingersOrder,
    _standing: &mut Standing<'a>,
    _findings: &mut Findings,
) -> Result<Replay<'a>, Halt> {
    Err(Halt::Unfit(Unfit("no judge of hands".to_owned())))
}
