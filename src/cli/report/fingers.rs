//! What a build tells of a plan for a hand.

use super::{Note, Told, proof, rounded};
use crate::schedule::PlanRecord;

/// `2300 deg in 8 reconfigurations, optimal (bound 2300 deg)`.
pub fn cost(plan: &PlanRecord) -> String {
    let figure = |degrees: f64| format!("{} deg", rounded(degrees));
    let reconfigurations = plan.outcomes.get("reconfigurations").copied().unwrap_or_default() as usize;
    let noun = if reconfigurations == 1 { "reconfiguration" } else { "reconfigurations" };
    format!("{} in {reconfigurations} {noun}, {}", figure(plan.cost), proof(plan, figure))
}

/// What else is told of a run.
pub fn notes(_run: &Told) -> Vec<Note> {
    Vec::new()
}
