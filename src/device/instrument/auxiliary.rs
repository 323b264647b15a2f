//! Auxiliary outputs: what else a bench switches, at the steps of tasks and planned by nobody. A camera's trigger, a light, a valve.

use super::words;
use crate::device::{VocabularyField, WordChoice};
use serde::{Deserialize, Serialize};

/// The sorts of auxiliary outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum AuxiliarySort {
    Trigger,
    Digital,
}

impl AuxiliarySort {
    /// Every sort, in the order of the handbook.
    pub const ALL: &'static [AuxiliarySort] = &[AuxiliarySort::Trigger, AuxiliarySort::Digital];

    /// The name of its one channel.
    pub const CHANNEL: &'static str = "out";

    /// The sort's word in the language with its meaning.
    pub fn choice(self) -> WordChoice {
        let (name, doc) = match self {
            AuxiliarySort::Trigger => ("trigger", "an output that gives a pulse of one length, by `pulse NAME`"),
            AuxiliarySort::Digital => {
                ("digital", "an output of two levels, by `set NAME to high` and `set NAME to low`")
            }
        };
        WordChoice { name, doc }
    }

    /// The sort's word in the language.
    pub fn name(self) -> &'static str {
        self.choice().name
    }

    /// The fields of an output.
    pub fn fields(self) -> &'static [VocabularyField] {
        match self {
            AuxiliarySort::Trigger => words::TRIGGER,
            AuxiliarySort::Digital => words::DIGITAL,
        }
    }

    /// An output to start from.
    pub fn example(self) -> &'static str {
        match self {
            AuxiliarySort::Trigger => "output camera : trigger { duration: 5 ms }",
            AuxiliarySort::Digital => "output light : digital",
        }
    }
}

/// The facts of an auxiliary output. Before a schedule, after it and between what its steps say it is at 0 V.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct AuxiliaryOutput {
    /// Of the high level, in volts.
    pub high_v: f64,
    /// Length of a pulse, in nanoseconds; `None` for one of two levels.
    pub pulse_ns: Option<u64>,
}
