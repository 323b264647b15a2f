//! What a program claims: the checked form of one schedule to be built, without an unresolved name or a bare number.
//!
//! Planners read it as their order, the verifier as the law. It is written into a log as JSON and derived again from the
//! embedded source when the log is verified, so spans, which only messages need, are left out of that form.

pub mod dimibot;
pub mod electrode_array;
pub mod fingers;
pub mod microrobots;

use crate::device::Kind;
use crate::source::Span;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

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
            Order::ElectrodeArray(order) => order.steps.len(),
            Order::Microrobots(order) => order.steps.len(),
            Order::Fingers(order) => order.steps.len(),
        }
    }

    /// The kind of the job's device.
    pub fn kind(&self) -> Kind {
        match &self.order {
            Order::Dimibot(_) => Kind::Dimibot,
            Order::ElectrodeArray(_) => Kind::ElectrodeArray,
            Order::Microrobots(_) => Kind::Microrobots,
            Order::Fingers(_) => Kind::Fingers,
        }
    }
}

/// What a job is in its kind's own terms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    Dimibot(dimibot::DimibotOrder),
    ElectrodeArray(electrode_array::ElectrodeArrayOrder),
    Microrobots(microrobots::MicrorobotsOrder),
    Fingers(fingers::FingersOrder),
}

impl Order {
    /// The order, if it is a DiMiBot's.
    pub fn dimibot(&self) -> Option<&dimibot::DimibotOrder> {
        match self {
            Order::Dimibot(order) => Some(order),
            Order::ElectrodeArray(_) | Order::Microrobots(_) | Order::Fingers(_) => None,
        }
    }

    /// The order, if it is an electrode array's.
    pub fn electrode_array(&self) -> Option<&electrode_array::ElectrodeArrayOrder> {
        match self {
            Order::ElectrodeArray(order) => Some(order),
            Order::Dimibot(_) | Order::Microrobots(_) | Order::Fingers(_) => None,
        }
    }

    /// The order, if it is of microrobots.
    pub fn microrobots(&self) -> Option<&microrobots::MicrorobotsOrder> {
        match self {
            Order::Microrobots(order) => Some(order),
            Order::Dimibot(_) | Order::ElectrodeArray(_) | Order::Fingers(_) => None,
        }
    }

    /// The order, if it is of a hand.
    pub fn fingers(&self) -> Option<&fingers::FingersOrder> {
        match self {
            Order::Fingers(order) => Some(order),
            Order::Dimibot(_) | Order::ElectrodeArray(_) | Order::Microrobots(_) => None,
        }
    }
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
