//! Orders, jobs and claims for tests.

use super::electrode_array::{
    BoardPart, Bystanders, ElectrodeArrayMethod, ElectrodeArrayObjective, ElectrodeArrayOrder, ElectrodeArrayPlanner,
    ElectrodeArrayStep,
};
use super::fingers::{FingersOrder, FingersPlanner, FingersStep, HandPart, Section};
use super::microrobots::{Assurance, MicrorobotsOrder, Placed, Precision};
use super::{Claims, Job, Order, Timeline};
use crate::device::electrode_array::ElectrodeArrayFacts;
use crate::device::fingers::FingersFacts;
use crate::device::microrobots::{ControlState, MicrorobotsFacts, MicrorobotsObjective};
use crate::geometry::Pose;
use crate::geometry::outline::Outline;
use crate::source::Span;
use std::sync::Arc;

/// A task on a bed without obstacles and without steps. Each robot is given by its row of the table and its pose.
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

/// A task on a hand, with the paper's ellipsoid in one plane.
pub fn hand_order(facts: FingersFacts, steps: Vec<FingersStep>) -> FingersOrder {
    let outline = Outline::Ellipse { semi_um: [16.0, 11.845] };
    let part = HandPart {
        name: "bead".to_owned(),
        xy: Section { outline, contacts: 74, opposite: Some(38), step_rad: 0.349 },
        xz: None,
        centre_um: [0.0; 3],
        position_um: [0.0; 3],
        span: Span::default(),
    };
    FingersOrder {
        facts: Arc::new(facts),
        part: Arc::new(part),
        precision_rad: 0.01,
        load_un: [0.0; 3],
        planner: FingersPlanner::JointAstar,
        expansions: 1000,
        looks: None,
        steps,
    }
}

pub fn job(task: &str, device: &str, order: Order) -> Job {
    Job {
        task: task.to_owned(),
        device: device.to_owned(),
        requirements: Vec::new(),
        events: Vec::new(),
        holds: Vec::new(),
        order,
        span: Span::default(),
        run_span: Span::default(),
    }
}

pub fn claims(name: &str, jobs: Vec<Job>, timeline: Timeline) -> Claims {
    Claims {
        name: name.to_owned(),
        timeline,
        jobs,
        wires: Default::default(),
        bench: Default::default(),
        outputs: Default::default(),
        shared: Vec::new(),
        not_held: Vec::new(),
        span: Span::default(),
    }
}
