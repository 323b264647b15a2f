//! Report on an electrode array's plan.

use super::{count, figure_of, proof};
use crate::claims::electrode_array::{ElectrodeArrayObjective, ElectrodeArrayOrder};
use crate::device::electrode_array::ElectrodeArrayOutcome;
use crate::quantity::digits;
use crate::schedule::PlanRecord;

/// `86 steps, optimal (bound 86); sum of costs 312, not proven optimal (bound 298)`: the minimised outcome comes first.
pub fn cost(plan: &PlanRecord, order: &ElectrodeArrayOrder) -> String {
    let steps = |value: f64| count(value as usize, "step");
    let sum = |value: f64| format!("sum of costs {}", digits(value));
    let reached = |outcome: ElectrodeArrayOutcome| figure_of(plan, outcome.name());
    match order.objective {
        ElectrodeArrayObjective::Makespan => {
            let other = bounded(plan, ElectrodeArrayOutcome::SumOfCosts);
            format!(
                "{}, {}; {}{other}",
                steps(plan.cost),
                proof(plan, digits),
                sum(reached(ElectrodeArrayOutcome::SumOfCosts))
            )
        }
        ElectrodeArrayObjective::SumOfCosts => {
            let other = bounded(plan, ElectrodeArrayOutcome::Steps);
            format!(
                "{}, {}; {}{other}",
                sum(plan.cost),
                proof(plan, digits),
                steps(reached(ElectrodeArrayOutcome::Steps))
            )
        }
    }
}

/// The bound on an outcome that was not minimised, if the planner knows one.
fn bounded(plan: &PlanRecord, outcome: ElectrodeArrayOutcome) -> String {
    let name = outcome.name();
    let (Some(bound), Some(reached)) = (plan.bounds.get(name), plan.outcomes.get(name)) else {
        return String::new();
    };
    let word = if bound >= reached { "optimal" } else { "not proven optimal" };
    format!(", {word} (bound {})", digits(*bound))
}
