//! Claims of a task on an electrode array.

use super::{KindOrder, Order, ValueOrigin};
use crate::device::Kind;
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
pub use crate::device::electrode_array::{ElectrodeArrayMethod, ElectrodeArrayObjective};
use crate::source::Span;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A task of an electrode array.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayOrder {
    pub facts: ElectrodeArrayFacts,
    /// Shared by all tasks of one device in one scene, like the parts.
    pub obstacles: Arc<Vec<ElectrodeArrayObstacle>>,
    /// The parts of the scene, in the order of writing. All tasks of one device in one schedule have parts of the same names.
    pub parts: Arc<Vec<BoardPart>>,
    pub objective: ElectrodeArrayObjective,
    pub planner: ElectrodeArrayPlanner,
    /// Whether parts without a goal may move.
    pub bystanders: Bystanders,
    pub steps: Vec<ElectrodeArrayStep>,
}

impl KindOrder for ElectrodeArrayOrder {
    fn kind(&self) -> Kind {
        Kind::ElectrodeArray
    }

    fn operation_spans(&self, nth: usize) -> Vec<Span> {
        match self.steps.get(nth).map(|step| &step.action) {
            Some(ElectrodeArrayAction::Assay(operations)) => {
                operations.iter().map(|operation| operation.span).collect()
            }
            Some(ElectrodeArrayAction::Move(_) | ElectrodeArrayAction::Wait(_)) | None => Vec::new(),
        }
    }
}

impl ElectrodeArrayOrder {
    /// A job's order, if it is one of this kind.
    pub fn of(order: &Order) -> Option<&ElectrodeArrayOrder> {
        if let Order::ElectrodeArray(order) = order { Some(order) } else { None }
    }
}

/// How the plan is searched.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ElectrodeArrayPlanner {
    pub method: ElectrodeArrayMethod,
    /// States that the search of one step of the task may expand.
    pub expansions: u64,
}

/// Whether parts without a goal may move.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Bystanders {
    /// They do not move.
    Stay,
    /// They may step aside, and come back before the step of the task ends.
    Yield,
}

/// Something that no part may come near.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayObstacle {
    /// The name in the scene.
    pub name: String,
    pub body: ElectrodeArrayObstacleBody,
    #[serde(skip)]
    pub span: Span,
}

/// The extent of an obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ElectrodeArrayObstacleBody {
    /// Electrodes, corners included; `from` is the lower corner in both axes. Centres keep the clearance of the facts from each.
    Electrodes { from: ElectrodeCell, to: ElectrodeCell },
    /// A part that is stuck with its centre there. Centres keep the separation of the facts from it.
    Fixed(ElectrodeCell),
}

/// A part that the board carries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BoardPart {
    /// The name in the scene.
    pub name: String,
    /// Where it stands before the device's first task; `None` for a droplet that a reservoir dispenses.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cell: Option<ElectrodeCell>,
    #[serde(skip)]
    pub span: Span,
}

/// One step of a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayStep {
    pub action: ElectrodeArrayAction,
    #[serde(skip)]
    pub span: Span,
}

/// Action of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ElectrodeArrayAction {
    /// Parts to their goals at the same time; the step ends when the last one has arrived.
    Move(Vec<ElectrodeArrayMove>),
    /// Operations of which those of one part follow each other in this order; what different parts do depends on nothing but where they
    /// merge. The step ends when all are done.
    Assay(Vec<AssayOperation>),
    /// Nothing moves for this time, in nanoseconds.
    Wait(u64),
}

/// Action of one part in a step, or of two that become one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayMove {
    /// Index of the order's parts.
    pub part: usize,
    /// The part that it merges with at its goal: from then on that one is gone, and this one is both.
    pub with: Option<usize>,
    /// Its stops, in order; the last one is its goal. One stop where parts merge.
    pub stops: Vec<ElectrodeArrayStop>,
    #[serde(skip)]
    pub span: Span,
}

impl ElectrodeArrayMove {
    /// Where it ends.
    pub fn goal(&self) -> &ElectrodeArrayStop {
        self.stops.last().expect("the checker gives every move a goal")
    }
}

/// A cell to be reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayStop {
    pub cell: ElectrodeCell,
    #[serde(skip)]
    pub span: Span,
    /// Where it was given, if a name stands in the step.
    #[serde(skip)]
    pub origin: Option<ValueOrigin>,
}

/// What one part of an assay does, or two that become one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AssayOperation {
    /// Index of the order's parts.
    pub part: usize,
    /// The part that it merges with at its stop: from then on that one is gone, and this one is both.
    pub with: Option<usize>,
    /// Its stops, in order; one where parts merge. None: it stays where its last operation left it.
    pub stops: Vec<ElectrodeArrayStop>,
    /// The least time for which it stays at the last stop, in nanoseconds.
    pub stay_ns: u64,
    /// Whether it comes onto the board at its one stop, the outlet of a reservoir, which dispenses it while it stays.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub comes: bool,
    /// Whether it leaves the board at the last stop and is gone from then on.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub leaves: bool,
    #[serde(skip)]
    pub span: Span,
}

impl AssayOperation {
    /// The parts that take part in it.
    pub fn parts(&self) -> impl Iterator<Item = usize> + use<> {
        [Some(self.part), self.with].into_iter().flatten()
    }

    /// The part that is gone when it is done.
    pub fn gone(&self) -> Option<usize> {
        self.with.or(self.leaves.then_some(self.part))
    }
}
