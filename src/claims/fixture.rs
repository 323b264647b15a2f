//! Orders for tests.

use super::electrode_array::{
    BoardPart, Bystanders, ElectrodeArrayMethod, ElectrodeArrayObjective, ElectrodeArrayOrder, ElectrodeArrayPlanner,
    ElectrodeArrayStep,
};
use super::microrobots::{Assurance, MicrorobotsOrder, Placed, Precision};
use crate::device::electrode_array::ElectrodeArrayFacts;
use crate::device::microrobots::{ControlState, MicrorobotsFacts, MicrorobotsObjective};
use crate::geometry::Pose;
use crate::source::Span;
use std::sync::Arc;

/// A task on a bed without obstacles and without steps. Each robot has its row of the table and its place.
pub fn bed_order(
    facts: MicrorobotsFacts,
    states: Vec<ControlState>,
    robots: impl IntoIterator<Item = (usize, Pose)>,
) -> MicrorobotsOrder {
    let placed = |(row, pose): (usize, Pose)| Placed { row, pose, span: Span::default() };
    MicrorobotsOrder {
        facts: Arc::new(facts),
        states: Arc::new(states),
        obstacles: Arc::default(),
        robots: Arc::new(robots.into_iter().map(placed).collect()),
        expansions: 1000,
        objective: MicrorobotsObjective::Time,
        precision: Precision { place_um: 0.5, heading_rad: 0.01 },
        assurance: Assurance::Reported,
        steps: Vec::new(),
    }
}

/// A task on a board without obstacles.
pub fn board_order(
    facts: ElectrodeArrayFacts,
    parts: impl IntoIterator<Item = BoardPart>,
    steps: Vec<ElectrodeArrayStep>,
) -> ElectrodeArrayOrder {
    ElectrodeArrayOrder {
        facts,
        obstacles: Arc::default(),
        parts: Arc::new(parts.into_iter().collect()),
        zones: Arc::default(),
        objective: ElectrodeArrayObjective::Makespan,
        planner: ElectrodeArrayPlanner { method: ElectrodeArrayMethod::Portfolio, expansions: 1000 },
        bystanders: Bystanders::Stay,
        contents: Vec::new(),
        contamination: Default::default(),
        steps,
    }
}
