//! The one timed form of all kinds: channels, actuations in integer nanoseconds, the steps that caused them.
//!
//! Data only: `lower` makes it, `verify` judges it, `emit` writes it, `log` reads it. Promise: actuations are sorted by start, then
//! channel; a channel has at most one value at a time; every actuation knows its step, every step its source span. There are no floats
//! but the values of actuations and the figures of plans.

pub mod cost;
pub mod dimibot;
pub mod electrode_array;
pub mod fingers;
pub mod json;
pub mod levels;
pub mod microrobots;
pub mod reached;
mod turns;

pub use microrobots::control;
pub use reached::Reached;
pub use turns::Turn;

use crate::device::each_kind;
use crate::device::instrument::{self, Bench, HoldTerms};
use crate::diagnostic::Remark;
use crate::source::{FileId, Sources, Span};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// The timed actuations of a program, with its steps and plans.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Schedule {
    /// The program's or task's name.
    pub name: String,
    pub source: SourceRef,
    /// From the first instant to the end of the last step, rests included.
    pub duration_ns: u64,
    pub channels: Vec<Channel>,
    pub actuations: Vec<Actuation>,
    pub steps: Vec<ScheduledStep>,
    /// One for each job of the claims, in their order.
    pub plans: Vec<PlanRecord>,
    /// Where it waits for an input or a person, in order of time.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub holds: Vec<ScheduledHold>,
    /// The instruments that play the channels, where the program declares any.
    #[serde(default, skip_serializing_if = "Bench::is_empty")]
    pub bench: Bench,
}

/// A stretch in which nothing changes: the clock goes on from its end as soon as what is waited for has come.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScheduledHold {
    /// Index of the schedule's steps.
    pub step: u32,
    pub start_ns: u64,
    #[serde(flatten)]
    pub terms: HoldTerms,
}

impl ScheduledHold {
    /// The instant at which its stretch ends.
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
    /// The values that replace those of the text, `pitch=80um`, in the order in which they were given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub settings: Vec<String>,
}

impl SourceRef {
    /// Names the first file of a program.
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

/// One output of an instrument.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Channel {
    /// With the device in front: `bot.bl4.set`.
    pub name: String,
    pub device: String,
    pub unit: ChannelUnit,
    /// The physical output, where a `wiring` names one.
    pub wire: Option<String>,
    /// A voltage's value before the schedule, after it, between its actuations and when it is broken off: 0 V for the channels of devices.
    #[serde(default, skip_serializing_if = "instrument::is_zero")]
    pub rest_v: f64,
}

/// Unit of a channel's numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub enum ChannelUnit {
    #[serde(rename = "V")]
    Volt,
    /// Where a stage is. A hand's channels have a value at every instant of their runs, one stretch after the other.
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

/// A channel's value over a stretch of time, from one number in a straight line to another; outside of its actuations a
/// voltage is at rest, and a stage stays where it was last, or where it is first wanted.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Actuation {
    /// Index of the schedule's channels.
    pub channel: u32,
    pub start_ns: u64,
    /// Above zero.
    pub duration_ns: u64,
    pub from: f64,
    pub to: f64,
    /// Where the value swings between two levels all the time; `from` and `to` are then the first and the last of them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub swing: Option<Swing>,
    /// Index of the schedule's steps.
    pub step: u32,
}

/// A repeated segment: half of each period at the one level, then half at the other.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Swing {
    /// Even and above zero; the actuation lasts a whole number of periods.
    pub period_ns: u64,
    /// In the order in which they come.
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
    /// The actuations of each channel, in the order of time.
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

/// The greatest common divisor of two times; that of 0 and a time is the time.
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
    /// Index of the schedule's plans.
    pub plan: u32,
    /// As written by the user, on one line.
    pub text: String,
    /// The file it stands in.
    pub file: String,
    pub line: u32,
    pub column: u32,
    pub start_ns: u64,
    pub duration_ns: u64,
    /// Values that it reaches, where goals are by nature not met exactly.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reached: Vec<Reached>,
    /// Where its operations overlap, each of them, in the order of the program.
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

/// One operation of a step in which several take place at the same time, on the clock. Those of one part follow each other without a
/// gap.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ScheduledOperation {
    /// The parts that take part in it; of two that merge, the one that remains is the first.
    pub parts: Vec<String>,
    /// As written by the user, on one line; in the file of the step.
    pub text: String,
    pub line: u32,
    pub column: u32,
    /// Column and row of the cell that the plan has chosen for it, where the program names several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub at: Option<[u32; 2]>,
    /// When the first of its parts is free for it.
    pub start_ns: u64,
    /// When the last of its parts has come to where it takes place; the rest of it is a stay.
    pub arrival_ns: u64,
    /// From the start on.
    pub duration_ns: u64,
    #[serde(skip)]
    pub span: Span,
}

impl ScheduledOperation {
    /// The instant at which it is done.
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
    /// No plan costs less.
    pub bound: f64,
    /// Whether `cost` is proven to be the least.
    pub optimal: bool,
    /// Every figure that the kind knows, by the keys of the vocabulary's [outcomes](crate::device::Outcome::key).
    pub outcomes: std::collections::BTreeMap<String, f64>,
    /// Lower bounds of other outcomes than the minimised one: no plan is below them; by the same keys.
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
    /// The first instant after it.
    pub fn end_ns(&self) -> u64 {
        self.start_ns + self.duration_ns
    }
}

/// A state from an instant on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct TimedState {
    pub t_ns: u64,
    #[serde(flatten)]
    pub state: State,
}

/// What every kind's state can be asked.
trait KindState {
    /// The numbers in it that are not whole.
    fn floats(&self) -> Vec<f64>;

    /// The column and row of each part by its name, where parts stand on cells.
    fn cells(&self) -> Option<&std::collections::BTreeMap<String, [u32; 2]>> {
        None
    }
}

impl State {
    /// The numbers in it that are not whole.
    pub fn floats(&self) -> Vec<f64> {
        each_kind!(State, self, state => state.floats())
    }

    /// The column and row of each part by its name, where parts stand on cells.
    pub fn cells(&self) -> Option<&std::collections::BTreeMap<String, [u32; 2]>> {
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
