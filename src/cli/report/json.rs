//! Reports of success as JSON, one object in a line.

use super::WrittenSchedule;
use crate::check::DeclarationTally;
use crate::claims::Order;
use crate::compile::Compiled;
use crate::emit::Format;
use crate::schedule::cost::cost;
use crate::schedule::{PlanRecord, Schedule};
use crate::verify::Verified;
use serde_json::{Value, json};

/// The report of `check`, with each schedule and its plans where they were asked for.
pub fn checked(file: &str, tally: DeclarationTally, schedules: Option<&[Verified]>) -> Value {
    let mut report = json!({ "checked": file, "declared": declared(tally) });
    if let Some(schedules) = schedules {
        report["schedules"] = schedules.iter().map(planned_schedule).collect();
    }
    report
}

fn declared(tally: DeclarationTally) -> Value {
    let DeclarationTally { devices, scenes, tasks, programs } = tally;
    json!({ "devices": devices, "scenes": scenes, "tasks": tasks, "programs": programs })
}

/// The report of a build that failed, of which a page was written.
pub fn failed(file: &str, page: &str) -> Value {
    json!({ "failed": file, "files": [page] })
}

/// The report of `build`: each schedule with its plans, the files written, and the formats that have no form for it.
pub fn built(file: &str, compiled: &Compiled, settings: &[String], written: &[WrittenSchedule]) -> Value {
    let schedules = compiled.schedules.iter().zip(written);
    let schedules: Vec<Value> = schedules.map(|(verified, written)| schedule(verified, written)).collect();
    json!({ "built": file, "declared": declared(compiled.tally), "settings": settings, "schedules": schedules })
}

fn schedule(verified: &Verified, written: &WrittenSchedule) -> Value {
    let mut report = planned_schedule(verified);
    report["files"] = written.names().collect();
    let left_out = |(format, why): &(Format, String)| json!({ "format": format.name(), "why": why });
    report["left_out"] = written.left_out.iter().map(left_out).collect();
    report
}

fn planned_schedule(verified: &Verified) -> Value {
    let (schedule, claims) = (verified.schedule(), verified.claims());
    let plans = schedule.plans.iter().zip(&claims.jobs).map(|(record, job)| plan(record, &job.order));
    let mut report = verified_schedule(schedule);
    report["plans"] = plans.collect();
    report
}

fn verified_schedule(schedule: &Schedule) -> Value {
    json!({
        "name": schedule.name,
        "channels": schedule.channels.len(),
        "actuations": schedule.actuations.len(),
        "duration_ns": schedule.duration_ns,
    })
}

fn plan(plan: &PlanRecord, order: &Order) -> Value {
    json!({
        "task": plan.task,
        "device": plan.device,
        "planner": plan.planner,
        "objective": plan.objective,
        "unit": plan.unit,
        "cost": plan.cost,
        "bound": plan.bound,
        "optimal": plan.optimal,
        "summary": cost(order, plan),
        "outcomes": plan.outcomes,
        "start_ns": plan.start_ns,
        "duration_ns": plan.duration_ns,
    })
}

/// The report of `verify`; bounds and optimality in a log are recorded and not derived again, so they are left out.
pub fn verified(log: &str, schedule: &Schedule, settings: &[String], against: Option<&str>) -> Value {
    json!({ "verified": log, "against": against, "settings": settings, "schedule": verified_schedule(schedule) })
}
