//! Droplets that a person puts onto a board, since none of its reservoirs is wired: the time and place at which each is
//! due.

use crate::claims::Claims;
use crate::claims::electrode_array::{ElectrodeArrayAction, ElectrodeArrayOrder};
use crate::verify::Verified;
use serde_json::json;
use std::collections::BTreeSet;

/// The droplets that come onto boards without pads, each with the instant from which the electrode at its outlet is on:
/// the start of the step in which it comes, or the previous state of the board, whichever is later. Halves of a split
/// come from no reservoir and are left out.
pub fn dispensed(verified: &Verified) -> Vec<serde_json::Value> {
    let (schedule, halves) = (verified.schedule(), halves(verified.claims()));
    let mut found: Vec<(u64, &str, [u32; 2])> = Vec::new();
    let has_pads = |device: &str| {
        let is_pad = |name: &str| Some(name.strip_prefix(device)?.strip_prefix('.')?.starts_with("pad"));
        schedule.channels.iter().any(|channel| is_pad(&channel.name) == Some(true))
    };
    let by_hand = (0..).zip(&schedule.plans).filter(|(_, plan)| !has_pads(&plan.device));
    for (index, plan) in by_hand {
        let begin_ns = |t_ns: u64| {
            let steps = schedule.steps.iter().filter(|step| step.plan == index && step.start_ns < t_ns);
            steps.map(|step| step.start_ns).max().unwrap_or(plan.start_ns)
        };
        for pair in plan.states.windows(2) {
            let (Some(before), Some(after)) = (pair[0].state.cells(), pair[1].state.cells()) else { continue };
            let is_new = |name: &str| !before.contains(name) && !halves.contains(&(plan.device.as_str(), name));
            let come = after.iter().filter(|(name, _)| is_new(name));
            let due_ns = || pair[0].t_ns.max(begin_ns(pair[1].t_ns));
            found.extend(come.map(|(name, cell)| (due_ns(), name, cell)));
        }
    }
    found.sort();
    found
        .into_iter()
        .map(|(at_ns, name, cell)| json!({ "at_s": at_ns as f64 / 1e9, "droplet": name, "outlet": cell }))
        .collect()
}

/// Devices and names of the droplets that are split off others.
fn halves(claims: &Claims) -> BTreeSet<(&str, &str)> {
    let orders = claims.jobs.iter().filter_map(|job| Some((job.device.as_str(), ElectrodeArrayOrder::of(&job.order)?)));
    let halves = orders.flat_map(|(device, order)| {
        let assays = order.steps.iter().filter_map(|step| match &step.action {
            ElectrodeArrayAction::Assay(operations) => Some(operations),
            ElectrodeArrayAction::Move(_) | ElectrodeArrayAction::Wait(_) => None,
        });
        let parts = assays.flatten().filter_map(|operation| Some(operation.splits?.part));
        parts.filter_map(move |part| Some((device, order.parts.get(part)?.name.as_str())))
    });
    halves.collect()
}
