//! Claims of a program: the checked form of one schedule to be built, with every name resolved and every number with
//! its unit.
//!
//! Planners read the claims as their order, the verifier as the rules. They are written into a log as JSON and
//! derived again from the embedded source when the log is verified; spans, which only messages need, are left out of
//! that form.

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

/// Definition of a value that a step refers to by name.
#[derive(Debug, Clone, PartialEq)]
pub struct ValueOrigin {
    pub span: Span,
    /// Text of the label at that place.
    pub text: String,
}

/// One schedule to be built: a program, or a single task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Claims {
    /// The program's or task's name, and the stem of its files.
    pub name: String,
    /// Order in time of the jobs.
    pub timeline: Timeline,
    /// Every run of a task, in source order; [`Timeline::Run`] has indices into this list.
    pub jobs: Vec<Job>,
    /// The physical output of each wired channel, by the channel's full name (`bot.bl0.set`).
    pub wires: BTreeMap<String, String>,
    /// The instruments behind the channels, if the program declares any.
    #[serde(default, skip_serializing_if = "Bench::is_empty")]
    pub bench: Bench,
    /// The auxiliary outputs that its tasks switch, by name.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub outputs: BTreeMap<String, AuxiliaryOutput>,
    /// Scenes in which two or more of the program's robots have a frame; these robots must never touch one another.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub shared: Vec<SharedScene>,
    /// Pairs of devices that run together in one scene without a check of their distance, because one of them has no
    /// frame there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub not_held: Vec<[String; 2]>,
    /// Place of the program's or task's declaration.
    #[serde(skip)]
    pub span: Span,
}

impl Claims {
    /// The first job of each kind, in source order.
    pub fn first_of_kinds(&self) -> impl Iterator<Item = &Job> {
        let is_first = |index: usize| self.jobs[..index].iter().all(|before| before.kind() != self.jobs[index].kind());
        (0..self.jobs.len()).filter(move |index| is_first(*index)).map(|index| &self.jobs[index])
    }

    /// Whether a device has a frame beside another one's, so that it may have to wait for it.
    pub fn is_shared(&self, device: &str) -> bool {
        self.shared.iter().any(|scene| scene.frames.contains_key(device))
    }

    /// Tolerance of a device's paths, in micrometres: the smallest of its jobs; `None` if its kind has none.
    pub fn tolerance_um(&self, device: &str) -> Option<f64> {
        self.least_of(device, |order| order.tolerance_um())
    }

    /// Margin of a device's switching voltages, in volts: the smallest of its jobs; `None` if its kind has none.
    pub fn margin_v(&self, device: &str) -> Option<f64> {
        self.least_of(device, |order| order.margin_v())
    }

    fn least_of(&self, device: &str, figure: impl Fn(&dyn KindOrder) -> Option<f64>) -> Option<f64> {
        let own = self.jobs.iter().filter(|job| job.device == device);
        own.filter_map(|job| figure(job.order.as_kind())).reduce(f64::min)
    }

    /// The frame of a device in pictures and beside others; it is the same in every scene of a program that places
    /// the device.
    pub fn frame(&self, device: &str) -> Option<Pose> {
        let shared = self.shared.iter().find_map(|scene| scene.frames.get(device));
        let own = || {
            let jobs = self.jobs.iter().filter(|job| job.device == device);
            jobs.filter_map(|job| job.order.as_kind().frame()).next()
        };
        shared.copied().or_else(own)
    }
}

/// A scene with the frames of the robots that a program places in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SharedScene {
    pub scene: String,
    /// The frame of each robot, by its device.
    pub frames: BTreeMap<String, Pose>,
}

/// Timeline of jobs on one clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Timeline {
    Run(usize),
    /// Idle time, in nanoseconds.
    Wait(u64),
    /// One after the other, each from the end of the previous one.
    Sequence(Vec<Timeline>),
    /// All from the same instant; what follows begins when the longest has ended.
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

    /// Nesting depth: 1 for a run or a wait.
    pub fn depth(&self) -> usize {
        match self {
            Timeline::Run(_) | Timeline::Wait(_) => 1,
            Timeline::Sequence(parts) | Timeline::Together(parts) => {
                1 + parts.iter().map(Timeline::depth).max().unwrap_or(0)
            }
        }
    }
}

/// Flattens a list of parts; those that `open` takes apart are replaced by their content.
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

/// Greatest nesting depth of a timeline. A log contains it as JSON, with two levels for each of these, and JSON
/// readers allow 128.
pub const MAX_TIMELINE_DEPTH: usize = 60;

/// One run of a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Job {
    pub task: String,
    pub device: String,
    /// The conditions on the outcome.
    pub requirements: Vec<Requirement>,
    pub order: Order,
    /// Actions on auxiliary outputs, in the order of the job's steps; in the order such a step has no duration.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<AuxiliaryEvent>,
    /// Waits for an input or a person, in the order of the job's steps.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub holds: Vec<Hold>,
    /// Place of the task's declaration.
    #[serde(skip)]
    pub span: Span,
    /// Place of the `run` step, or of the declaration if there is none.
    #[serde(skip)]
    pub run_span: Span,
}

impl Job {
    /// Number of steps.
    pub fn steps(&self) -> usize {
        each_kind!(Order, &self.order, order => order.steps.len())
    }

    /// Places of its steps in the source, in order.
    pub fn step_spans(&self) -> Vec<Span> {
        each_kind!(Order, &self.order, order => order.steps.iter().map(|step| step.span).collect())
    }

    /// Places in the source of the operations of a step in which several take place at the same time.
    pub fn operation_spans(&self, nth: usize) -> Vec<Span> {
        self.order.as_kind().operation_spans(nth)
    }

    /// The kind of the job's device.
    pub fn kind(&self) -> Kind {
        self.order.as_kind().kind()
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

/// Queries on every kind's order.
pub trait KindOrder {
    /// The kind of its device.
    fn kind(&self) -> Kind;

    /// Places in the source of the operations of a step in which several take place at the same time, in source
    /// order.
    fn operation_spans(&self, _nth: usize) -> Vec<Span> {
        Vec::new()
    }

    /// Whether the device holds what it carries only while a task runs, and releases it between its tasks.
    fn holds_in_runs_only(&self) -> bool {
        false
    }

    /// The device's frame in the scene, if the program states it.
    fn frame(&self) -> Option<Pose> {
        None
    }

    /// The state chosen for each position in its steps that is not one of the device's own, such as `cell (7, 14),
    /// 225.1 nm off`, with the position's place in the source. Empty for kinds where this is not known before
    /// planning.
    fn taken_for_places(&self) -> Vec<(Span, String)> {
        Vec::new()
    }

    /// Tolerance of the paths of the job, in micrometres; `None` if its kind has none. Planned paths use half of it.
    fn tolerance_um(&self) -> Option<f64> {
        None
    }

    /// Margin of the device's switching voltages, in volts; `None` if its kind has none.
    fn margin_v(&self) -> Option<f64> {
        None
    }
}

impl Order {
    /// The order through the interface that all kinds share.
    pub fn as_kind(&self) -> &dyn KindOrder {
        each_kind!(Order, self, order => order)
    }
}

/// A condition on an outcome: `require time <= 400 ms`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Requirement {
    /// The outcome's name in the vocabulary.
    pub outcome: String,
    pub relation: Relation,
    /// In SI units of the outcome's dimension.
    pub limit: f64,
    #[serde(skip)]
    pub span: Span,
}

/// Relative tolerance of a limit on a measured outcome; allows for rounding in a sum of floats that meets the limit
/// exactly.
const MEASURED_TOLERANCE: f64 = 1e-9;

/// Relative tolerance of a limit on a count or on a time in whole nanoseconds, where only the limit itself is
/// rounded, a few times in its arithmetic.
const COUNTED_TOLERANCE: f64 = 16.0 * f64::EPSILON;

impl Requirement {
    /// Relative tolerance of the limit.
    pub fn tolerance(&self) -> f64 {
        if is_counted(&self.outcome) { COUNTED_TOLERANCE } else { MEASURED_TOLERANCE }
    }

    /// Absolute tolerance of the limit, in its unit.
    pub fn slack(&self) -> f64 {
        self.limit.abs() * self.tolerance()
    }
}

/// Relation between an outcome and its limit.
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
    /// Its sign in the language.
    pub fn sign(self) -> &'static str {
        match self {
            Relation::Less => "<",
            Relation::AtMost => "<=",
            Relation::Equal => "==",
            Relation::AtLeast => ">=",
            Relation::More => ">",
        }
    }

    /// Whether the relation holds, up to a slack of at least 0 in the unit of both; a strict relation must hold by
    /// more than the slack.
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
