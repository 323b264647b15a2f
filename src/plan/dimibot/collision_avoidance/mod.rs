//! Collision avoidance between robots that share a scene: pulses wait for one another, or a robot detours around another.
//!
//! Problem: given plans made for each robot alone, find plans on one clock in which no two tips ever touch. Method:
//! prioritised planning (Erdmann and Lozano-Pérez, *On multiple moving objects*, Algorithmica 2, 1987): each run is
//! timed against the runs planned before it, along its own best path with waits; if that fails, along a detour around
//! the places where other robots stay, or around all places that they visit. The branches of a `together` are planned
//! in several orders, with and without the assumption that robots not yet planned make way. Guaranteed: plans that keep
//! every gap. Not guaranteed: completeness or optimality; a plan stays `optimal` only if its cost is still that of the
//! robot alone.

mod timing;
mod tips;
mod tries;

use super::DimibotMotion;
use crate::claims::dimibot::DimibotOrder;
use crate::claims::{Claims, Job};
use crate::device::dimibot::{DimibotObjective, DimibotOutcome};
use crate::diagnostic::Sink;
use crate::plan::{Motion, Optimality, Plan, errors};
use crate::quantity::digits;
use std::collections::BTreeMap;
use tips::PlacedRobot;
use tries::{FoundPlans, TryFailure, TryReason, attempt, tries};

/// Budget of area comparisons, shared by all attempts.
const COMPARISONS: u64 = 400_000_000;

/// Plans robots that share a scene so that they never touch; `None` if no such plans were found, which has been reported.
pub fn avoid_collisions<'a>(
    claims: &'a Claims,
    plans: Vec<Plan<Motion<'a>>>,
    sink: &mut Sink,
) -> Option<Vec<Plan<Motion<'a>>>> {
    if claims.shared.is_empty() {
        return Some(plans);
    }
    let robots = robots(claims);
    let mut allowed = COMPARISONS;
    let (mut best, mut first_failure): (Option<FoundPlans>, Option<TryFailure>) = (None, None);
    for policy in tries(claims, &robots) {
        match attempt(claims, &robots, &plans, policy, &mut allowed) {
            Ok(found) if found.is_untouched() => return Some(found.plans),
            Ok(found) if best.as_ref().is_none_or(|best| found.rank < best.rank) => best = Some(found),
            Ok(_) => {}
            Err(failure) if failure.reason == TryReason::Spent => {
                first_failure.get_or_insert(failure);
                break;
            }
            Err(failure) => {
                first_failure.get_or_insert(failure);
            }
        }
    }
    match (best, first_failure) {
        (Some(best), _) => return Some(best.plans),
        (None, Some(failure)) => sink.push(report(claims, &failure)),
        (None, None) => {}
    }
    None
}

/// The robots that share a scene, by device.
fn robots(claims: &Claims) -> BTreeMap<&str, PlacedRobot> {
    let placed = claims.shared.iter().flat_map(|scene| &scene.frames);
    let robot = |(device, frame): (&'_ String, &_)| {
        let job = claims.jobs.iter().find(|job| job.device == *device)?;
        Some((job.device.as_str(), PlacedRobot { facts: DimibotOrder::of(&job.order)?.facts.clone(), frame: *frame }))
    };
    placed.filter_map(robot).collect()
}

fn report(claims: &Claims, failure: &TryFailure) -> crate::diagnostic::Diagnostic {
    let job: &Job = &claims.jobs[failure.job];
    let names: Vec<String> = failure.with.iter().map(|name| format!("`{name}`")).collect();
    let (device, with) = (&job.device, names.join(" and "));
    let other = failure.with_job.map(|other| claims.jobs[other].run_span);
    let at_ms = digits(failure.at_ns as f64 / 1e6);
    let why = match failure.reason {
        TryReason::Met => format!("at {at_ms} ms it meets {with}"),
        TryReason::EndTogether => format!("at {at_ms} ms it meets {with}, and it ends where {with} then stands"),
        TryReason::Missed => {
            format!("it starts at {at_ms} ms; no wait or detour was found that keeps its requirements")
        }
        TryReason::NoWay => format!("no path was found from the cell where `{device}` then stands"),
        TryReason::Spent => {
            format!("it starts at {at_ms} ms; the search ended after {COMPARISONS} comparisons")
        }
    };
    let help = match failure.reason {
        TryReason::EndTogether => errors::SeparationRemedy::OtherEnds,
        TryReason::Met | TryReason::Missed | TryReason::NoWay | TryReason::Spent => {
            errors::SeparationRemedy::OtherTimes
        }
    };
    errors::not_apart([device.as_str(), &with], job.run_span, &why, other, help)
}

/// A plan with delays before its pulses, on the robot's own best path or on a detour. Its bounds are those of the robot
/// alone; it stays optimal only if it costs no more than that plan.
fn delayed(alone: &Plan<DimibotMotion>, mut plan: Plan<DimibotMotion>, delays: Vec<u64>) -> Plan<DimibotMotion> {
    let idle_ns: u64 = delays.iter().sum();
    if let Some(time_s) = plan.outcomes.get_mut(DimibotOutcome::Time.name()) {
        let ns = (*time_s * 1e9).round() + idle_ns as f64;
        *time_s = ns / 1e9;
    }
    if plan.objective == DimibotObjective::Time.name() {
        plan.cost += idle_ns as f64 / 1e6;
    }
    plan.bound = alone.bound;
    plan.bounds = alone.bounds.clone();
    plan.proof = match alone.proof {
        Optimality::Proven if plan.cost <= alone.cost => Optimality::Proven,
        Optimality::Proven | Optimality::Open => Optimality::Open,
    };
    plan.motion.delays = if idle_ns > 0 { delays } else { Vec::new() };
    plan
}
