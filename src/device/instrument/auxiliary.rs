//! Auxiliary outputs: what else a bench switches, at the steps of tasks and planned by nobody. A camera's trigger, a light, a heater.
//! And what the steps of tasks wait for: an input of the bench, or a person.

use super::Level;
use super::words::{DIGITAL, LEVEL, TRIGGER};
use crate::device::{VocabularyField, words::words};
use serde::{Deserialize, Serialize};

words! {
    /// The sorts of auxiliary outputs, in the order of the handbook.
    pub enum AuxiliarySort {
        Trigger = "trigger": "an output that gives a pulse of one length, by `pulse NAME`",
        Digital = "digital": "an output of two levels, by `set NAME to high` and `set NAME to low`",
        Level = "level": "an output of any voltage between two, by `set NAME to 60 %`",
    }
}

impl AuxiliarySort {
    /// The name of its one channel.
    pub const CHANNEL: &'static str = "out";

    /// The fields of an output.
    pub fn fields(self) -> &'static [VocabularyField] {
        match self {
            AuxiliarySort::Trigger => TRIGGER,
            AuxiliarySort::Digital => DIGITAL,
            AuxiliarySort::Level => LEVEL,
        }
    }

    /// An output to start from.
    pub fn example(self) -> &'static str {
        match self {
            AuxiliarySort::Trigger => "output camera : trigger { duration: 5 ms }",
            AuxiliarySort::Digital => "output light : digital",
            AuxiliarySort::Level => "output heater : level { from: 0 V, to: 10 V }",
        }
    }
}

/// The facts of an auxiliary output. Before a schedule, after it, when it is broken off and between what its steps say it is at rest.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AuxiliaryOutput {
    /// Of the high level or of 100 %, in volts.
    pub high_v: f64,
    /// Of the low level or of 0 %, in volts.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub low_v: f64,
    /// At rest, in volts: one of the two levels, or between them where it is graded.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rest_v: f64,
    /// Length of a pulse, in nanoseconds; `None` for one that is set to levels.
    pub pulse_ns: Option<u64>,
    /// Whether it takes every voltage between its two levels.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_graded: bool,
}

/// What a program waits for, and how long.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct HoldTerms {
    pub awaited: Awaited,
    /// How long the wait is on the clock: its longest, if it is bounded. Above zero, in nanoseconds.
    pub duration_ns: u64,
    /// Whether the schedule is broken off when that time is over; otherwise it goes on whenever what it waits for has come.
    pub is_bounded: bool,
}

/// What a program waits for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Awaited {
    Input {
        /// As it is shown: `card.port0.line5`, or the name that the program gives in quotes.
        name: String,
        /// The instrument that reads it, if the program declares it, and its input there: `port0.line5`.
        place: Option<(String, String)>,
        /// The level that is waited for.
        level: Level,
    },
    /// A person who is asked to do something.
    Person { prompt: String },
}

impl Awaited {
    /// What is waited for, in words.
    pub fn shown(&self) -> String {
        match self {
            Awaited::Input { name, level, .. } => format!("`{name}` to be {}", level.name()),
            Awaited::Person { .. } => "a person".to_owned(),
        }
    }
}

/// Whether a figure is left out of a text.
pub fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
