//! What a build tells of a plan for microrobots.

use super::{Note, Told, Topic, count, proof, reached, rounded};
use crate::schedule::PlanRecord;

/// `12.3 s in 9 switches, optimal (bound 12.3 s)`.
pub fn cost(plan: &PlanRecord) -> String {
    let figure = |seconds: f64| format!("{} s", rounded(seconds));
    let switches = count(plan.outcomes.get("switches").copied().unwrap_or_default() as usize, "switch");
    format!("{} in {switches}, {}", figure(plan.cost), proof(plan, figure))
}

/// Whether each goal of an assembly is guaranteed under the device's error bounds.
pub fn notes(run: &Told) -> Vec<Note> {
    let remarks = run.plan.remarks.iter();
    let assured = remarks.map(|remark| (Topic::Guaranteed, format!("{}: {}", remark.subject, remark.text)));
    assured.chain(reached(run)).collect()
}
