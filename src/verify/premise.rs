//! Whether the claims are such that a schedule can be checked against them at all.
//!
//! Input: claims. Output: nothing, or why not. Claims of the checker always pass; those of a hostile log may not,
//! and the rules rely on these checks.

use super::dimibot::is_frame;
use super::{Unfit, dimibot, electrode_array, fingers, microrobots};
use crate::claims::electrode_array::ElectrodeArrayOrder;
use crate::claims::microrobots::MicrorobotsOrder;
use crate::claims::{Claims, Job, Order, SharedScene, Timeline};
use std::collections::{BTreeMap, BTreeSet};

/// Greatest nesting of a timeline.
const MAX_DEPTH: usize = 256;

/// Checks the assumptions of all rules.
pub(super) fn check(claims: &Claims) -> Result<(), Unfit> {
    let mut runs = vec![0; claims.jobs.len()];
    count_runs(&claims.timeline, MAX_DEPTH, &mut runs)?;
    if let Some(job) = runs.iter().position(|runs| *runs != 1) {
        return Err(Unfit(format!("the claims run job {job} {} times in their timeline, not once", runs[job])));
    }
    claims.shared.iter().try_for_each(|scene| shared(scene, claims))?;
    let mut devices = BTreeMap::new();
    for job in &claims.jobs {
        requirements(job)?;
        match &job.order {
            Order::Dimibot(order) => dimibot::check_claims(order)?,
            Order::ElectrodeArray(order) => electrode_array::check_claims(order)?,
            Order::Microrobots(order) => microrobots::check_claims(order)?,
            Order::Fingers(order) => fingers::check_claims(order)?,
        }
        let first = devices.entry(job.device.as_str()).or_insert(job);
        if !same_facts(first, job) {
            return Err(Unfit(format!("the claims hold two sets of facts about the device `{}`", job.device)));
        }
        if !same_parts(first, job) {
            return Err(Unfit(format!("the claims hold two sets of parts on the device `{}`", job.device)));
        }
    }
    Ok(())
}

/// A shared scene places robots of the program, each where all its orders have it.
fn shared(scene: &SharedScene, claims: &Claims) -> Result<(), Unfit> {
    for (device, frame) in &scene.frames {
        let unfit = |why: &str| Err(Unfit(format!("the claims' scene `{}` places `{device}` {why}", scene.scene)));
        let jobs = || claims.jobs.iter().filter(|job| job.device == *device);
        if !is_frame(frame) {
            return unfit("nowhere");
        }
        if jobs().next().is_none() || jobs().any(|job| job.order.dimibot().is_none()) {
            return unfit("as a robot that the program does not run");
        }
        let places = jobs().filter_map(|job| job.order.dimibot()?.frame);
        if places.chain(claims.frame(device)).any(|other| other != *frame) {
            return unfit("at two places");
        }
    }
    Ok(())
}

fn count_runs(timeline: &Timeline, depth: usize, runs: &mut [u64]) -> Result<(), Unfit> {
    if depth == 0 {
        return Err(Unfit(format!("the claims' timeline nests deeper than {MAX_DEPTH} levels")));
    }
    match timeline {
        Timeline::Wait(_) => Ok(()),
        Timeline::Sequence(parts) | Timeline::Together(parts) => {
            parts.iter().try_for_each(|part| count_runs(part, depth - 1, runs))
        }
        Timeline::Run(job) => {
            let known = runs.len();
            let count = runs.get_mut(*job).ok_or_else(|| Unfit(format!("the claims run job {job} of {known} jobs")))?;
            *count += 1;
            Ok(())
        }
    }
}

fn requirements(job: &Job) -> Result<(), Unfit> {
    let outcomes = job.kind().vocabulary().outcomes;
    for requirement in &job.requirements {
        if !outcomes.iter().any(|outcome| outcome.name == requirement.outcome) {
            return Err(Unfit(format!("the claims limit `{}`, which is not an outcome", requirement.outcome)));
        }
        if !requirement.limit.is_finite() {
            return Err(Unfit(format!("the claims' limit of `{}` is not finite", requirement.outcome)));
        }
    }
    Ok(())
}

fn same_facts(one: &Job, other: &Job) -> bool {
    match (&one.order, &other.order) {
        (Order::Dimibot(one), Order::Dimibot(other)) => one.facts == other.facts,
        (Order::ElectrodeArray(one), Order::ElectrodeArray(other)) => one.facts == other.facts,
        (Order::Microrobots(one), Order::Microrobots(other)) => {
            let same = |one: &MicrorobotsOrder, other: &MicrorobotsOrder| {
                one.facts == other.facts && one.states == other.states
            };
            std::sync::Arc::ptr_eq(&one.facts, &other.facts) || same(one, other)
        }
        (Order::Fingers(one), Order::Fingers(other)) => one.facts == other.facts,
        (Order::Dimibot(_) | Order::ElectrodeArray(_) | Order::Microrobots(_) | Order::Fingers(_), _) => false,
    }
}

/// Parts are known by their names from one run of a device to the next.
fn same_parts(one: &Job, other: &Job) -> bool {
    match (&one.order, &other.order) {
        (Order::ElectrodeArray(one), Order::ElectrodeArray(other)) => {
            let names = |order: &ElectrodeArrayOrder| -> BTreeSet<String> {
                order.parts.iter().map(|part| part.name.clone()).collect()
            };
            std::sync::Arc::ptr_eq(&one.parts, &other.parts) || names(one) == names(other)
        }
        (Order::Microrobots(one), Order::Microrobots(other)) => {
            let rows = |order: &MicrorobotsOrder| order.robots.iter().map(|robot| robot.row).collect::<Vec<_>>();
            rows(one) == rows(other)
        }
        (Order::Fingers(one), Order::Fingers(other)) => one.part == other.part,
        (Order::Dimibot(_) | Order::ElectrodeArray(_) | Order::Microrobots(_) | Order::Fingers(_), _) => true,
    }
}
