//! What a task claims of an electrode array.

use crate::device::electrode_array::{Cell, Facts};
use crate::source::Span;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A task of an electrode array.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ElectrodeArrayOrder {
    pub facts: Facts,
    /// Shared by all tasks of one device in one scene, like the parts.
    pub obstacles: Arc<Vec<Obstacle>>,
    /// The parts of the scene, in the order of writing. All tasks of one device in one schedule have parts of the same names.
    pub parts: Arc<Vec<Part>>,
    pub objective: Objective,
    pub planner: Planner,
    /// What the parts without a goal do.
    pub bystanders: Bystanders,
    pub steps: Vec<Step>,
}

/// What is minimised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Objective {
    /// The steps from the first move to the last arrival, over all steps of the task.
    Makespan,
    /// The steps until each part's last arrival, added up over parts and over the steps of the task.
    SumOfCosts,
}

/// How the plan is searched.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Planner {
    pub method: Method,
    /// States that the search of one step of the task may expand.
    pub expansions: u64,
}

/// The search methods.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// Tweeze's own: a first plan fast, then better ones, then the proof.
    Portfolio,
    /// The paper's algorithm 1 with its heuristic of equation 12.
    CooperativeAstar,
    /// The same with the plain heuristic of equation 13.
    PlainCooperativeAstar,
}

/// What the parts without a goal do.
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
pub struct Obstacle {
    /// The name in the scene.
    pub name: String,
    pub body: Body,
    #[serde(skip)]
    pub span: Span,
}

/// The extent of an obstacle.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Body {
    /// Electrodes, corners included; `from` is the lower corner in both axes. Centres keep the clearance of the facts from each.
    Electrodes { from: Cell, to: Cell },
    /// A part that is stuck with its centre there. Centres keep the separation of the facts from it.
    Fixed(Cell),
}

/// A part that the board carries.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Part {
    /// The name in the scene.
    pub name: String,
    /// Where it stands before the device's first task.
    pub cell: Cell,
    #[serde(skip)]
    pub span: Span,
}

/// One step of a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Step {
    pub action: Action,
    #[serde(skip)]
    pub span: Span,
}

/// What a step does.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Parts to their goals at the same time; the step ends when the last one has arrived.
    Move(Vec<Move>),
    /// Nothing moves for so long, in nanoseconds.
    Wait(u64),
}

/// What one part does in a step, or two that become one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Move {
    /// Index of the order's parts.
    pub part: usize,
    /// The part that it merges with at its goal: from then on that one is gone, and this one is both.
    pub with: Option<usize>,
    /// Where it has to come by, in this order; the last one is its goal. One stop where parts merge.
    pub stops: Vec<Stop>,
    #[serde(skip)]
    pub span: Span,
}

impl Move {
    /// Where it ends.
    pub fn goal(&self) -> &Stop {
        self.stops.last().expect("the checker gives every move a goal")
    }
}

/// A cell to be reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stop {
    pub cell: Cell,
    #[serde(skip)]
    pub span: Span,
}
