//! Claims of a program: the checked form of one schedule to be built, without an unresolved name or a bare number.
//!
//! Planners read it as their order, the verifier as the rules. It is written into a log as JSON and derived again from the
//! embedded source when the log is verified; spans, which only messages need, are left out of that form.

pub mod auxiliary;
pub mod dimibot;
pub mod electrode_array;
pub mod fingers;
#[cfg(test)]
pub(crate) mod fixture;
pub mod microrobots;

use crate::device::instrument::{AuxiliaryOutput, Bench};
use crate::device::{Kind, each_kind, is_counted};
use crate::geometry::shape::Pose;
use crate::source::Span;
use auxiliary::{AuxiliaryEvent, Hold};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Where a value was given whose name stands in a step.
#[derive(Debug, Clone, PartialEq)]
pub struct ValueOrigin {
    pub span: Span,
    /// What a label says there.
    pub text: String,
}

/// One schedule to be built: a program, or a task on its own.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claims {
    /// The program's or task's name, and the stem of its files.
    pub name: String,
    /// When each job runs.
    pub timeline: Timeline,
    /// Every run of a task, in source order; [`Timeline::Run`] has indices into this list.
    pub jobs: Vec<Job>,
    /// The physical output of each wired channel, by the channel's full name (`bot.bl0.set`).
    pub wires: BTreeMap<String, String>,
    /// The instruments behind them, where the program declares any.
    #[serde(default, skip_serializing_if = "Bench::is_empty")]
    pub bench: Bench,
    /// The auxiliary outputs that its tasks switch, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub outputs: BTreeMap<String, AuxiliaryOutput>,
    /// The scenes in which two or more of the program's robots have a place: these never touch one another.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shared: Vec<SharedScene>,
    /// Devices that run together in one scene without a check of their distance, since one of them has no place there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_held: Vec<[String; 2]>,
    /// Where the program or task is declared.
    #[serde(skip)]
    pub span: Span,
}

impl Claims {
    /// The first job of each kind, in the order of writing.
    pub fn first_of_kinds(&self) -> impl Iterator<Item = &Job> {
        let is_first = |index: usize| self.jobs[..index].iter().all(|before| before.kind() != self.jobs[index].kind());
        (0..self.jobs.len()).filter(move |index| is_first(*index)).map(|index| &self.jobs[index])
    }

    /// Whether a device has a place beside another one's, so that it may need to wait for it.
    pub fn is_shared(&self, device: &str) -> bool {
        self.shared.iter().any(|scene| scene.frames.contains_key(device))
    }

    /// How far a device may be off its ways, in micrometres: the least figure of its jobs, if its kind has one.
    pub fn tolerance_um(&self, device: &str) -> Option<f64> {
        self.least_of(device, |order| order.tolerance_um())
    }

    /// How well the voltages are known at which a device does what it does: the least figure of its jobs, if its kind has one.
    pub fn margin_v(&self, device: &str) -> Option<f64> {
        self.least_of(device, |order| order.margin_v())
    }

    fn least_of(&self, device: &str, figure: impl Fn(&dyn KindOrder) -> Option<f64>) -> Option<f64> {
        let own = self.jobs.iter().filter(|job| job.device == device);
        own.filter_map(|job| figure(job.order.asked())).reduce(f64::min)
    }

    /// Where a device stands in pictures and beside others: the same in every scene of a program that places it.
    pub fn frame(&self, device: &str) -> Option<Pose> {
        let shared = self.shared.iter().find_map(|scene| scene.frames.get(device));
        let own = || {
            let jobs = self.jobs.iter().filter(|job| job.device == device);
            jobs.filter_map(|job| job.order.asked().frame()).next()
        };
        shared.copied().or_else(own)
    }
}

/// A scene with the robots of a program that have a place in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SharedScene {
    pub scene: String,
    /// Where the frame of each robot stands, by its device.
    pub frames: BTreeMap<String, Pose>,
}

/// Jobs on one clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Timeline {
    Run(usize),
    /// Nothing happens for this time.
    Wait(u64),
    /// One after the other, each from the end of the one before.
    Sequence(Vec<Timeline>),
    /// All from the same instant; the next part begins when the longest has ended.
    Together(Vec<Timeline>),
}

impl Timeline {
    /// The timeline simplified: without groups of one element, sequences within sequences, and groups within groups.
    #[must_use]
    pub fn flat(self) -> Timeline {
        match self {
            Timeline::Sequence(parts) => Timeline::Sequence(spliced(parts, |part| match part {
                Timeline::Sequence(parts) => Ok(parts),
                Timeline::Run(_) | Timeline::Wait(_) | Timeline::Together(_) => Err(part),
            })),
            Timeline::Together(parts) => Timeline::Together(spliced(parts, |part| match part {
                Timeline::Together(parts) => Ok(parts),
                Timeline::Run(_) | Timeline::Wait(_) | Timeline::Sequence(_) => Err(part),
            })),
            Timeline::Run(_) | Timeline::Wait(_) => self,
        }
    }

    /// Its nesting: 1 for a run or a wait.
    pub fn depth(&self) -> usize {
        match self {
            Timeline::Run(_) | Timeline::Wait(_) => 1,
            Timeline::Sequence(parts) | Timeline::Together(parts) => {
                1 + parts.iter().map(Timeline::depth).max().unwrap_or(0)
            }
        }
    }
}

/// Flat list of parts; those that `open` takes apart are replaced by their content.
fn spliced(parts: Vec<Timeline>, open: fn(Timeline) -> Result<Vec<Timeline>, Timeline>) -> Vec<Timeline> {
    let mut flat = Vec::with_capacity(parts.len());
    for part in parts {
        let part = match part.flat() {
            Timeline::Sequence(mut only) | Timeline::Together(mut only) if only.len() == 1 => only.swap_remove(0),
            other => other,
        };
        match open(part) {
            Ok(parts) => flat.extend(parts),
            Err(part) => flat.push(part),
        }
    }
    flat
}

/// Greatest nesting of a timeline. A log contains it as JSON, two levels for each of these, and JSON readers allow 128.
pub const MAX_TIMELINE_DEPTH: usize = 60;

/// One run of a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Job {
    pub task: String,
    pub device: String,
    /// The conditions on the outcome.
    pub requirements: Vec<Requirement>,
    pub order: Order,
    /// What it does to auxiliary outputs, in the order of its steps; such a step is one of no duration in the order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<AuxiliaryEvent>,
    /// Where it waits for an input or a person, in the order of its steps.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub holds: Vec<Hold>,
    /// Where the task is declared.
    #[serde(skip)]
    pub span: Span,
    /// Where it is run: the `run` step, or the declaration again.
    #[serde(skip)]
    pub run_span: Span,
}

impl Job {
    /// Number of steps.
    pub fn steps(&self) -> usize {
        each_kind!(Order, &self.order, order => order.steps.len())
    }

    /// Where each of its steps is written, in their order.
    pub fn step_spans(&self) -> Vec<Span> {
        each_kind!(Order, &self.order, order => order.steps.iter().map(|step| step.span).collect())
    }

    /// Where the operations of a step are written of which several take place at the same time.
    pub fn operation_spans(&self, nth: usize) -> Vec<Span> {
        self.order.asked().operation_spans(nth)
    }

    /// The kind of the job's device.
    pub fn kind(&self) -> Kind {
        self.order.asked().kind()
    }
}

/// A job in its kind's own terms.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    Dimibot(dimibot::DimibotOrder),
    ElectrodeArray(electrode_array::ElectrodeArrayOrder),
    Microrobots(microrobots::MicrorobotsOrder),
    Fingers(fingers::FingersOrder),
}

/// What every stage may ask of a kind's order.
pub trait KindOrder {
    /// The kind of its device.
    fn kind(&self) -> Kind;

    /// Where the operations of a step are written of which several take place at the same time, in the order of the program.
    fn operation_spans(&self, _nth: usize) -> Vec<Span> {
        Vec::new()
    }

    /// Whether what the device carries is held as long as a task runs, and let go between its tasks.
    fn holds_in_runs_only(&self) -> bool {
        false
    }

    /// Where the device stands in the scene, if the program says so.
    fn frame(&self) -> Option<Pose> {
        None
    }

    /// What is taken for each place of its steps that is none of the device's own, as `cell (7, 14), 225.1 nm off`, by where the place is
    /// written; where that is known before there is a plan.
    fn taken_for_places(&self) -> Vec<(Span, String)> {
        Vec::new()
    }

    /// How far the device may be off the ways of its job, in micrometres, if its kind has such a figure. Planned ways use half of it.
    fn tolerance_um(&self) -> Option<f64> {
        None
    }

    /// How well the voltages are known at which the device does what it does, in volts, if its kind has such a figure.
    fn margin_v(&self) -> Option<f64> {
        None
    }
}

impl Order {
    /// The order as its kind.
    pub fn asked(&self) -> &dyn KindOrder {
        each_kind!(Order, self, order => order)
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

/// Relative tolerance of a limit on a figure that is measured, not counted; allows for rounding in a sum of floats that meets the limit exactly.
const MEASURED_TOLERANCE: f64 = 1e-9;

/// The same of a count, or of a time in whole nanoseconds: only the limit is rounded, a few times in its arithmetic.
const COUNTED_TOLERANCE: f64 = 16.0 * f64::EPSILON;

impl Requirement {
    /// By how much, relative to the limit, an outcome may seem to miss it.
    pub fn tolerance(&self) -> f64 {
        if is_counted(&self.outcome) { COUNTED_TOLERANCE } else { MEASURED_TOLERANCE }
    }

    /// By how much an outcome may seem to miss the limit, in its unit.
    pub fn slack(&self) -> f64 {
        self.limit.abs() * self.tolerance()
    }
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

impl Relation {
    /// Whether an outcome and its limit compare so, up to a slack of at least 0 in their unit: what is excluded by less than that is not.
    pub fn holds(self, reached: f64, limit: f64, slack: f64) -> bool {
        match self {
            Relation::Less => reached < limit - slack,
            Relation::AtMost => reached <= limit + slack,
            Relation::Equal => (reached - limit).abs() <= slack,
            Relation::AtLeast => reached >= limit - slack,
            Relation::More => reached > limit + slack,
        }
    }
}
