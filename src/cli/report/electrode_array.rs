//! What people read of an electrode array's plan.

use super::{ReportedDevice, ReportedOrder, count, figure_of, length, proof};
use crate::claims::Claims;
use crate::claims::electrode_array::{ElectrodeArrayObjective, ElectrodeArrayOrder};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeArrayOutcome};
use crate::quantity::digits;
use crate::schedule::PlanRecord;

impl ReportedOrder for ElectrodeArrayOrder {
    /// `86 steps, optimal (bound 86); sum of costs 312, not proven optimal (bound 298)`: the minimised outcome comes first.
    fn cost(&self, plan: &PlanRecord) -> String {
        let steps = |value: f64| count(value as usize, "step");
        let sum = |value: f64| format!("sum of costs {}", digits(value));
        let reached = |outcome: ElectrodeArrayOutcome| figure_of(plan, outcome.name());
        let (minimised, other, reached) = match self.objective {
            ElectrodeArrayObjective::Makespan => {
                let other = ElectrodeArrayOutcome::SumOfCosts;
                (steps(plan.cost), other, sum(reached(other)))
            }
            ElectrodeArrayObjective::SumOfCosts => {
                let other = ElectrodeArrayOutcome::Steps;
                (sum(plan.cost), other, steps(reached(other)))
            }
        };
        format!("{minimised}, {}; {reached}{}", proof(plan, digits), bounded(plan, other))
    }
}

impl ReportedDevice for ElectrodeArrayFacts {
    fn told(&self, name: &str, _claims: &[Claims]) -> String {
        let (columns, rows, pitch) = (self.columns, self.rows, length(self.pitch_um()));
        format!("{name}: electrode_array, {columns} x {rows} electrodes {pitch} apart\n")
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
