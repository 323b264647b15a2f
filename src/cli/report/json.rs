//! Reports of success as JSON, one object per line.

use super::WrittenSchedule;
use crate::check::DeclarationTally;
use crate::claims::Order;
use crate::compile::Compiled;
use crate::emit::Format;
use crate::schedule::cost::{cost, work_in};
use crate::schedule::reached::Reached;
use crate::schedule::{PlanRecord, Schedule};
use crate::verify::Verified;
use serde_json::{Value, json};

/// The report of `check`, with each schedule and its plans if they were requested.
pub fn checked(file: &str, tally: DeclarationTally, schedules: Option<&[Verified]>) -> Value {
    let mut report = json!({ "checked": file, "declared": declared(tally) });
    if let Some(schedules) = schedules {
        report["schedules"] = schedules
            .iter()
            .map(|verified| {
                let mut report = planned_schedule(verified);
                report["steps"] = steps(verified);
                report
            })
            .collect();
    }
    report
}

fn declared(tally: DeclarationTally) -> Value {
    let DeclarationTally { devices, scenes, tasks, programs } = tally;
    json!({ "devices": devices, "scenes": scenes, "tasks": tasks, "programs": programs })
}

/// The report of a failed build for which a page was written.
pub fn failed(file: &str, page: &str) -> Value {
    json!({ "failed": file, "files": [page] })
}

/// The report of `build`: each schedule with its plans, the files written, and the formats that cannot represent it.
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

/// Cost and reached values of each step, and of each operation if several run at the same time, with their places in
/// the source.
fn steps(verified: &Verified) -> Value {
    let (schedule, claims) = (verified.schedule(), verified.claims());
    let mut entries = Vec::new();
    for step in &schedule.steps {
        let nth = step.plan as usize;
        let (Some(plan), Some(job)) = (schedule.plans.get(nth), claims.jobs.get(nth)) else { continue };
        let mut enter = |(line, column): (u32, u32), start_ns: u64, duration_ns: u64, reached: &[Reached]| {
            let value = |reached: &Reached| json!({ "value": reached.value(), "text": reached.to_string() });
            entries.push(json!({
                "task": step.task,
                "file": step.file,
                "line": line,
                "column": column,
                "start_ns": start_ns,
                "duration_ns": duration_ns,
                "takes": work_in(&job.order, plan, start_ns, start_ns + duration_ns),
                "reached": reached.iter().filter(|reached| reached.is_off()).map(value).collect::<Value>(),
            }));
        };
        enter((step.line, step.column), step.start_ns, step.duration_ns, &step.reached);
        for operation in &step.operations {
            enter((operation.line, operation.column), operation.start_ns, operation.duration_ns, &[]);
        }
    }
    Value::Array(entries)
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

/// The report of `verify`; bounds and optimality from the log are omitted unless it was planned again.
pub fn verified(
    log: &str,
    schedule: &Schedule,
    settings: &[String],
    against: Option<&str>,
    replanned: Option<&Verified>,
) -> Value {
    let report = replanned.map_or_else(|| verified_schedule(schedule), planned_schedule);
    json!({
        "verified": log,
        "against": against,
        "replanned": replanned.is_some(),
        "settings": settings,
        "schedule": report,
    })
}
