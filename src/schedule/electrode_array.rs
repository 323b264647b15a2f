//! States of an electrode array. The goals of its steps are cells, which are met exactly or not at all.

use super::cost::{Costed, count_of, proof};
use super::part_cells::PartCells;
use super::reached::{Reached, Reaching};
use super::{KindState, PlanRecord, State};
use crate::claims::electrode_array::{ElectrodeArrayObjective, ElectrodeArrayOrder};
use crate::device::electrode_array::ElectrodeArrayOutcome;
use crate::quantity::{count, digits};
use serde::{Deserialize, Serialize};

/// Cells of the parts of a board.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayState {
    /// A part that has merged into another is no longer listed.
    pub parts: PartCells,
}

impl KindState for ElectrodeArrayState {
    fn floats(&self) -> Vec<f64> {
        Vec::new()
    }

    fn cells(&self) -> Option<&PartCells> {
        Some(&self.parts)
    }
}

impl Reaching for ElectrodeArrayOrder {
    fn reached(&self, _nth: usize, _end: &State) -> Vec<Reached> {
        Vec::new()
    }
}

impl Costed for ElectrodeArrayOrder {
    /// `86 steps, optimal (bound 86); sum of costs 312, not proven optimal (bound 298)`: the minimised outcome comes first.
    fn cost(&self, plan: &PlanRecord) -> String {
        let steps = |value: f64| count(value as usize, "step");
        let sum = |value: f64| format!("sum of costs {}", digits(value));
        let reached = |outcome: ElectrodeArrayOutcome| count_of(plan, outcome.name());
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

    /// Number of steps of the board in the interval.
    fn work_in(&self, _plan: &PlanRecord, start_ns: u64, end_ns: u64) -> Option<String> {
        Some(count(end_ns.saturating_sub(start_ns) / self.facts.step_ns.max(1), "step"))
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
