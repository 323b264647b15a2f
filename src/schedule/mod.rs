//! The timed form shared by all kinds: channels, actuations in integer nanoseconds, and the steps that caused them.
//!
//! Data only: `lower` makes it, `verify` judges it, `emit` writes it, `log` reads it. Promise: actuations are sorted
//! by start, then channel; a channel has at most one value at a time; every actuation knows its step, every step its
//! source span. The only floats are the values of actuations and the figures of plans.

pub mod cost;
pub mod dimibot;
pub mod electrode_array;
pub mod fingers;
pub mod json;
pub mod levels;
pub mod microrobots;
mod part_cells;
pub mod reached;
mod speed_jumps;

pub use microrobots::control;
pub use part_cells::PartCells;
pub use reached::Reached;
pub use speed_jumps::SpeedJump;

use crate::device::each_kind;
use crate::device::instrument::{self, Bench, HoldTerms};
use crate::diagnostic::Remark;
use crate::source::{FileId, Sources, Span};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// The timed actuations of a program, with its steps and plans.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    /// The name of the program or task.
    pub name: String,
    pub source: SourceRef,
    /// From time 0 to the end of the last step, rests included.
    pub duration_ns: u64,
    pub channels: Vec<Channel>,
    pub actuations: Vec<Actuation>,
    pub steps: Vec<ScheduledStep>,
    /// One for each job of the claims, in the same order.
    pub plans: Vec<PlanRecord>,
    /// Waits for an input or a person, in order of time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub holds: Vec<ScheduledHold>,
    /// The instruments that play the channels, if the program declares any.
    #[serde(default, skip_serializing_if = "Bench::is_empty")]
    pub bench: Bench,
}

/// An interval of the schedule in which nothing changes; the clock continues from its end as soon as the awaited
/// event has come.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScheduledHold {
    /// Index into the schedule's steps.
    pub step: u32,
    pub start_ns: u64,
    #[serde(flatten)]
    pub terms: HoldTerms,
}

impl ScheduledHold {
    /// The instant at which the interval ends.
    pub fn end_ns(&self) -> u64 {
        self.start_ns + self.terms.duration_ns
    }
}

/// The program's own file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct SourceRef {
    pub file: String,
    /// SHA-256 of the file's bytes, in lower-case hexadecimal.
    pub sha256: String,
    /// The `--set` values that replace those of the text, `pitch=80um`, in the order given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub settings: Vec<String>,
}

impl SourceRef {
    /// Refers to the first file of a program.
    pub fn of(sources: &Sources) -> SourceRef {
        let own = sources.file(FileId(0));
        let settings = sources.settings().map(|(name, value)| format!("{name}={value}")).collect();
        SourceRef { file: own.name.clone(), sha256: sha256(&own.text), settings }
    }
}

/// SHA-256 of a text, in lower-case hexadecimal.
pub fn sha256(text: &str) -> String {
    Sha256::digest(text.as_bytes()).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// One output: a voltage, or the position of a stage.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// With the device's name in front: `bot.bl4.set`.
    pub name: String,
    pub device: String,
    pub unit: ChannelUnit,
    /// The physical output, if a `wiring` names one.
    pub wire: Option<String>,
    /// Rest value of a voltage: before and after the schedule, between its actuations, and when the schedule is
    /// aborted. 0 V for the channels of devices.
    #[serde(default, skip_serializing_if = "instrument::is_zero")]
    pub rest_v: f64,
}

/// Unit of a channel's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum ChannelUnit {
    #[serde(rename = "V")]
    Volt,
    /// Position of a stage. A hand's channels have a value at every instant of their runs, actuation after actuation
    /// without a gap.
    #[serde(rename = "um")]
    Micrometre,
}

impl ChannelUnit {
    /// Its symbol in reports and files.
    pub fn symbol(self) -> &'static str {
        match self {
            ChannelUnit::Volt => "V",
            ChannelUnit::Micrometre => "um",
        }
    }
}

/// A channel's value over an interval, linear between two values. Outside of its actuations a voltage is at rest; a
/// stage stays where it last was or, before its first actuation, where that one begins.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Actuation {
    /// Index into the schedule's channels.
    pub channel: u32,
    pub start_ns: u64,
    /// Above zero.
    pub duration_ns: u64,
    pub from: f64,
    pub to: f64,
    /// A value that alternates between two levels during the whole actuation; `from` and `to` are then the first and
    /// the last of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub swing: Option<Swing>,
    /// Index into the schedule's steps.
    pub step: u32,
}

/// A square wave: half of each period at one level, then half at the other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Swing {
    /// Even and above zero; the actuation lasts a whole number of periods.
    pub period_ns: u64,
    /// In the order in which they occur.
    pub levels: [f64; 2],
}

impl Actuation {
    /// The instant at which it ends.
    pub fn end_ns(&self) -> u64 {
        self.start_ns + self.duration_ns
    }

    /// The values at its ends, or the levels of its swing.
    pub fn levels(&self) -> [f64; 2] {
        self.swing.map_or([self.from, self.to], |swing| swing.levels)
    }
}

impl Schedule {
    /// The actuations of each channel, in order of time.
    pub fn by_channel(&self) -> Vec<Vec<&Actuation>> {
        let mut by_channel = vec![Vec::new(); self.channels.len()];
        for actuation in &self.actuations {
            if let Some(list) = by_channel.get_mut(actuation.channel as usize) {
                list.push(actuation);
            }
        }
        by_channel.iter_mut().for_each(|list: &mut Vec<&Actuation>| list.sort_by_key(|actuation| actuation.start_ns));
        by_channel
    }
}

/// The greatest common divisor of two times; of 0 and a time it is the time.
pub fn common_divisor_ns(mut a: u64, mut b: u64) -> u64 {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// One step of a task, on the clock.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ScheduledStep {
    pub task: String,
    /// Index into the schedule's plans.
    pub plan: u32,
    /// The step's text as the user wrote it, on one line.
    pub text: String,
    /// The file that contains it.
    pub file: String,
    pub line: u32,
    pub column: u32,
    pub start_ns: u64,
    pub duration_ns: u64,
    /// Values that it reaches, for goals that are not met exactly by their nature.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reached: Vec<Reached>,
    /// The operations of a step in which operations overlap, in the order of the program.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub operations: Vec<ScheduledOperation>,
    #[serde(skip)]
    pub span: Span,
}

impl ScheduledStep {
    /// The instant at which it ends.
    pub fn end_ns(&self) -> u64 {
        self.start_ns + self.duration_ns
    }
}

/// One operation, on the clock, of a step in which several take place at the same time. The operations of one part
/// follow each other without a gap.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScheduledOperation {
    /// The parts that take part in it; in a merge, the one that remains comes first.
    pub parts: Vec<String>,
    /// The operation's text as the user wrote it, on one line; in the file of the step.
    pub text: String,
    pub line: u32,
    pub column: u32,
    /// Column and row of the cell that the plan chose, if the program names several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<[u32; 2]>,
    /// When the first of its parts becomes free for it.
    pub start_ns: u64,
    /// When the last of its parts reaches the place of the operation; the rest of the operation is a stay.
    pub arrival_ns: u64,
    /// Counted from the start.
    pub duration_ns: u64,
    #[serde(skip)]
    pub span: Span,
}

impl ScheduledOperation {
    /// The instant at which it ends.
    pub fn end_ns(&self) -> u64 {
        self.start_ns + self.duration_ns
    }
}

/// A planner's record of one job, with the states of its plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanRecord {
    pub task: String,
    pub device: String,
    pub kind: crate::device::Kind,
    pub planner: String,
    pub objective: String,
    /// Unit of `cost` and `bound`; empty for a count.
    pub unit: String,
    pub cost: f64,
    /// Lower bound: no plan costs less.
    pub bound: f64,
    /// Whether `cost` is proven to be minimal.
    pub optimal: bool,
    /// Every outcome that the kind has, by the keys of the vocabulary's [outcomes](crate::device::Outcome::key).
    pub outcomes: std::collections::BTreeMap<String, f64>,
    /// Lower bounds on outcomes other than the minimised one, by the same keys.
    #[serde(default, skip_serializing_if = "std::collections::BTreeMap::is_empty")]
    pub bounds: std::collections::BTreeMap<String, f64>,
    pub start_ns: u64,
    pub duration_ns: u64,
    /// The state at the beginning and after every change, in order of time.
    pub states: Vec<TimedState>,
    /// Further notes of the planner.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub remarks: Vec<Remark>,
}

impl PlanRecord {
    /// The instant at which it ends.
    pub fn end_ns(&self) -> u64 {
        self.start_ns + self.duration_ns
    }
}

/// A state that holds from an instant on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TimedState {
    pub t_ns: u64,
    #[serde(flatten)]
    pub state: State,
}

/// Queries on every kind's state.
trait KindState {
    /// Its non-integer numbers.
    fn floats(&self) -> Vec<f64>;

    /// Column and row of each part by its name, for kinds whose parts are on cells.
    fn cells(&self) -> Option<&PartCells> {
        None
    }
}

impl State {
    /// Its non-integer numbers.
    pub fn floats(&self) -> Vec<f64> {
        each_kind!(State, self, state => state.floats())
    }

    /// Column and row of each part by its name, for kinds whose parts are on cells.
    pub fn cells(&self) -> Option<&PartCells> {
        each_kind!(State, self, state => state.cells())
    }
}

/// The kind's own state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum State {
    Dimibot(dimibot::DimibotState),
    ElectrodeArray(electrode_array::ElectrodeArrayState),
    Microrobots(microrobots::MicrorobotsState),
    Fingers(fingers::FingersState),
}
