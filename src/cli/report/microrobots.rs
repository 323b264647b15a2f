//! Report on a plan for microrobots.

use super::{Note, ReportTopic, ReportedRun, count, figure_of, proof, reached, rounded};
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::MicrorobotsOutcome;
use crate::schedule::PlanRecord;

/// `12.3 s in 9 switches, optimal (bound 12.3 s)`.
pub fn cost(plan: &PlanRecord) -> String {
    let figure = |seconds: f64| format!("{} s", rounded(seconds));
    let switches = count(figure_of(plan, MicrorobotsOutcome::Switches.name()) as usize, "switch");
    format!("{} in {switches}, {}", figure(plan.cost), proof(plan, figure))
}

/// Whether each goal of an assembly is guaranteed under the device's error bounds, where robots end, and which ones are not there.
pub fn notes(run: &ReportedRun, order: &MicrorobotsOrder) -> Vec<Note> {
    let remarks = run.plan.remarks.iter();
    let assured = remarks.map(|remark| (ReportTopic::Guaranteed, format!("{}: {}", remark.subject, remark.text)));
    assured.chain(reached(run)).chain(absent(order)).collect()
}

/// The robots of the table that the scene leaves out.
fn absent(order: &MicrorobotsOrder) -> Option<Note> {
    let is_absent = |row: &usize| order.robots.iter().all(|robot| robot.row != *row);
    let rows = (0..order.facts.robots.len()).filter(is_absent);
    let names: Vec<&str> = rows.map(|row| order.facts.robots[row].name.as_str()).collect();
    let line = format!("{} of the table, left out by the scene: taken not to be on the bed", names.join(", "));
    (!names.is_empty()).then_some((ReportTopic::Absent, line))
}
