//! Auxiliary outputs, such as a camera trigger, a light or a heater: switched by steps of tasks, without planning.
//! Also the inputs and persons that steps of tasks wait for.

use super::Level;
use super::words::{DIGITAL, LEVEL, TRIGGER};
use crate::device::{VocabularyField, words::words};
use serde::{Deserialize, Serialize};

words! {
    /// The sorts of auxiliary outputs, in the order of the handbook.
    pub enum AuxiliarySort {
        Trigger = "trigger": "an output that gives a pulse of fixed length, with `pulse NAME`",
        Digital = "digital": "an output with two levels, with `set NAME to high` and `set NAME to low`",
        Level = "level": "an output of any voltage between two limits, with `set NAME to 60 %`",
    }
}

impl AuxiliarySort {
    /// The name of an output's one channel.
    pub const CHANNEL: &'static str = "out";

    /// The fields of an output.
    pub fn fields(self) -> &'static [VocabularyField] {
        match self {
            AuxiliarySort::Trigger => TRIGGER,
            AuxiliarySort::Digital => DIGITAL,
            AuxiliarySort::Level => LEVEL,
        }
    }

    /// An example of a declaration to start from.
    pub fn example(self) -> &'static str {
        match self {
            AuxiliarySort::Trigger => "output camera : trigger { duration: 5 ms }",
            AuxiliarySort::Digital => "output light : digital",
            AuxiliarySort::Level => "output heater : level { from: 0 V, to: 10 V }",
        }
    }
}

/// Facts of an auxiliary output. It is at rest before and after a schedule, when the schedule is aborted, and
/// whenever no step sets it.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AuxiliaryOutput {
    /// Voltage of the high level or of 100 %.
    pub high_v: f64,
    /// Voltage of the low level or of 0 %.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub low_v: f64,
    /// Rest voltage: one of the two levels, or between them if the output is graded.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub rest_v: f64,
    /// Pulse length, in nanoseconds; `None` for an output that is set to levels.
    pub pulse_ns: Option<u64>,
    /// Whether it takes any voltage between its two levels.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_graded: bool,
}

/// What a program waits for, and for how long.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct HoldTerms {
    pub awaited: Awaited,
    /// Duration of the wait on the clock, in nanoseconds, above zero; the longest one if the wait is bounded.
    pub duration_ns: u64,
    /// Whether the schedule is aborted when that time has passed; otherwise it continues as soon as the wait is over,
    /// however late.
    pub is_bounded: bool,
}

/// What a program waits for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Awaited {
    Input {
        /// Displayed name: `card.port0.line5`, or the name that the program gives in quotes.
        name: String,
        /// The instrument that reads the input, if the program declares it, and the input's name there:
        /// `port0.line5`.
        place: Option<(String, String)>,
        /// The awaited level.
        level: Level,
    },
    /// A person who is asked to do something.
    Person { prompt: String },
}

impl Awaited {
    /// The awaited event, in words.
    pub fn shown(&self) -> String {
        match self {
            Awaited::Input { name, level, .. } => format!("`{name}` to be {}", level.name()),
            Awaited::Person { .. } => "a person".to_owned(),
        }
    }
}

/// Whether a value is zero, for serde to skip it.
pub fn is_zero(value: &f64) -> bool {
    *value == 0.0
}
