//! Replays the run of an electrode array.

use super::clock::Run;
use super::rule::Findings;
use super::{Replay, Standing, Terms, Unfit};
use crate::check::claims::electrode_array::{ElectrodeArrayOrder, Method, Objective};
use crate::schedule::Unit;
use std::collections::BTreeMap;

/// What the numbers of a channel are, if the device has one of that name.
pub(super) fn unit(channel: &str, order: &ElectrodeArrayOrder) -> Option<Unit> {
    order.facts.electrode(channel).map(|_| Unit::Volt)
}

/// What the claims say of a plan's record.
pub(super) fn terms(order: &ElectrodeArrayOrder) -> Terms {
    let objective = match order.objective {
        Objective::Makespan => "makespan",
        Objective::SumOfCosts => "sum_of_costs",
    };
    let planner = match order.planner.method {
        Method::Portfolio => "portfolio",
        Method::CooperativeAstar => "cooperative_astar",
        Method::PlainCooperativeAstar => "plain_cooperative_astar",
    };
    Terms { planner, objective, unit: "", scale: 1.0 }
}

/// A state in words.
pub(super) fn shown(parts: &BTreeMap<String, [u32; 2]>) -> String {
    let parts: Vec<String> = parts.iter().map(|(name, [column, row])| format!("{name} ({column}, {row})")).collect();
    parts.join(", ")
}

/// Asks what every rule takes for granted.
///
/// # Errors
/// When the claims are such that nothing can be held against them.
pub(super) fn check_claims(order: &ElectrodeArrayOrder) -> Result<(), Unfit> {
    let _ = order;
    Ok(())
}

/// Holds a run against its order.
pub(super) fn replay<'a>(
    run: &Run<'a>,
    order: &ElectrodeArrayOrder,
    standing: &mut Standing<'a>,
    findings: &mut Findings,
) -> Result<Replay, Unfit> {
    let _ = (run, order, standing, findings);
    Err(Unfit(String::new()))
}
