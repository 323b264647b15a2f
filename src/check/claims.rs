//! What a program claims: the checked form of one schedule to be built, without an unresolved name or a bare number.
//!
//! Planners read it as their order, the verifier as the law. It is written into a log as JSON and derived again from the
//! embedded source when the log is verified, so spans, which only messages need, are left out of that form.

use crate::device::{Kind, dimibot};
use crate::geometry::shape::{Pose, Shape};
use crate::source::{Span, Spanned};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::Arc;

/// One schedule to be built: a program, or a task on its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claims {
    /// The program's or task's name, and the stem of its files.
    pub name: String,
    /// When each job runs.
    pub timeline: Timeline,
    /// Every run of a task, in the order of writing; [`Timeline::Run`] holds indices of this list.
    pub jobs: Vec<Job>,
    /// The physical output of each wired channel, by the channel's full name (`bot.bl0.set`).
    pub wires: BTreeMap<String, String>,
    /// Where the program or task is declared.
    #[serde(skip)]
    pub span: Span,
}

/// Jobs on one clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Timeline {
    Run(usize),
    /// Nothing happens for so long.
    Wait(u64),
    /// One after the other, each from the end of the one before.
    Sequence(Vec<Timeline>),
    /// All from the same instant; what follows begins when the longest has ended.
    Together(Vec<Timeline>),
}

/// One run of a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Job {
    pub task: String,
    pub device: String,
    /// The conditions on the outcome.
    pub requirements: Vec<Requirement>,
    pub order: Order,
    /// Where the task is declared.
    #[serde(skip)]
    pub span: Span,
    /// Where it is run: the `run` step, or the declaration again.
    #[serde(skip)]
    pub run_span: Span,
}

impl Job {
    /// How many steps it has.
    pub fn steps(&self) -> usize {
        match &self.order {
            Order::Dimibot(order) => order.steps.len(),
        }
    }

    /// The kind of the job's device.
    pub fn kind(&self) -> Kind {
        match &self.order {
            Order::Dimibot(_) => Kind::Dimibot,
        }
    }
}

/// What a job is in its kind's own terms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    Dimibot(DimibotOrder),
}

/// `require time <= 400 ms`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Requirement {
    /// A name of the vocabulary's outcomes.
    pub outcome: String,
    pub relation: Relation,
    /// In SI units of the outcome's dimension.
    pub limit: f64,
    #[serde(skip)]
    pub span: Span,
}

/// How an outcome and its limit compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Relation {
    Less,
    AtMost,
    Equal,
    AtLeast,
    More,
}

/// A task of a DiMiBot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DimibotOrder {
    pub facts: dimibot::Facts,
    /// Shared by all tasks of one device in one scene.
    pub obstacles: Arc<Vec<Obstacle>>,
    pub objective: Objective,
    pub planner: Planner,
    pub simultaneous: dimibot::Simultaneous,
    /// How far the cell taken for a place may lie from it; without it any nearest cell will do.
    pub precision_um: Option<f64>,
    /// `start at`, where the task says it; else the robot stands where its last task left it, or at home.
    pub start: Option<Spanned<dimibot::Cell>>,
    pub steps: Vec<Step>,
}

/// What is minimised.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Objective {
    Distance,
    Switches,
    Time,
    Energy,
}

impl Objective {
    /// Its word in the language.
    pub fn name(self) -> &'static str {
        match self {
            Objective::Distance => "distance",
            Objective::Switches => "switches",
            Objective::Time => "time",
            Objective::Energy => "energy",
        }
    }

    /// The unit of its cost in schedules and reports; a count has none.
    pub fn unit(self) -> &'static str {
        match self {
            Objective::Distance => "um",
            Objective::Switches => "",
            Objective::Time => "ms",
            Objective::Energy => "mJ",
        }
    }
}

/// How the plan is searched; all agree on its cost.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Planner {
    pub method: Method,
    /// States that one search may expand.
    pub expansions: u64,
}

/// The search methods, by the names of [`dimibot::PLANNERS`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    StagedAstar,
    Dijkstra,
    BidirectionalDijkstra,
    Astar,
    HypercubeAstar,
}

impl Method {
    /// Its word in the language.
    pub fn name(self) -> &'static str {
        match self {
            Method::StagedAstar => "staged_astar",
            Method::Dijkstra => "dijkstra",
            Method::BidirectionalDijkstra => "bidirectional_dijkstra",
            Method::Astar => "astar",
            Method::HypercubeAstar => "hypercube_astar",
        }
    }
}

/// What the tip must not touch.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Obstacle {
    /// The name in the scene.
    pub name: String,
    pub body: Body,
    #[serde(skip)]
    pub span: Span,
}

/// The extent of an obstacle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Body {
    /// Lattice cells, corners included, as in the paper: not grown. `from` is the lower corner in both axes.
    Cells { from: dimibot::Cell, to: dimibot::Cell },
    /// A body in the workspace, to be grown by tip radius and repeatability.
    Solid { shape: Shape, pose: Pose },
}

/// One step of a DiMiBot's task.
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
    /// Through the stops in their order; the last one is the goal.
    Move(Vec<Stop>),
    /// Through all stops, in whatever order is best.
    Visit(Vec<Stop>),
    /// Nothing is switched for so long.
    Wait(u64),
}

/// A place to be reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Stop {
    pub asked: Asked,
    /// The cell that stands for it.
    pub cell: dimibot::Cell,
    #[serde(skip)]
    pub span: Span,
}

/// What the program asked for.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Asked {
    Cell,
    /// A place, from word 0 along the axes of R1.
    Place([f64; 2]),
}
