//! The line protocol of a controlled run: measured poses in, commands out, one JSON object per line.
//!
//! Documented in `docs/control.md`; the schema is `schema/control.schema.json`. `tweeze control` exchanges the lines,
//! a recording holds them, and the verifier judges them. Times are integer nanoseconds of the measurements' own
//! clock.

use super::RecordedPose;
use crate::device::microrobots::control::{ControlPhase, StopReason};
use serde::de::{Error, MapAccess, Unexpected, Visitor};
use serde::{Deserialize, Deserializer, Serialize};
use std::collections::BTreeMap;
use std::fmt;
use std::marker::PhantomData;

/// A line of measured poses.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeasuredLine {
    #[serde(deserialize_with = "whole")]
    pub t_ns: u64,
    /// By the names of the scene, each once. A robot that is `None` or missing was not seen.
    #[serde(deserialize_with = "each_once")]
    pub robots: BTreeMap<String, Option<RecordedPose>>,
}

/// From here on a double may stand for several integers: 2^53.
const EXACT_BELOW: f64 = 9_007_199_254_740_992.0;

/// Reads an integer, also if a program that works in floating point wrote it as `1.0` or `1e9`.
fn whole<'de, D: Deserializer<'de>>(reader: D) -> Result<u64, D::Error> {
    struct Whole;
    impl Visitor<'_> for Whole {
        type Value = u64;

        fn expecting(&self, text: &mut fmt::Formatter) -> fmt::Result {
            text.write_str("a whole number of ns, at least 0")
        }

        fn visit_u64<E: Error>(self, number: u64) -> Result<u64, E> {
            Ok(number)
        }

        fn visit_f64<E: Error>(self, number: f64) -> Result<u64, E> {
            let is_whole = number.fract() == 0.0 && (0.0..EXACT_BELOW).contains(&number);
            if is_whole { Ok(number as u64) } else { Err(E::invalid_value(Unexpected::Float(number), &self)) }
        }
    }
    reader.deserialize_any(Whole)
}

/// Reads a map and rejects duplicate keys: of two poses of one robot neither can be trusted.
fn each_once<'de, D, V>(reader: D) -> Result<BTreeMap<String, V>, D::Error>
where
    D: Deserializer<'de>,
    V: Deserialize<'de>,
{
    struct EachOnce<V>(PhantomData<V>);
    impl<'de, V: Deserialize<'de>> Visitor<'de> for EachOnce<V> {
        type Value = BTreeMap<String, V>;

        fn expecting(&self, text: &mut fmt::Formatter) -> fmt::Result {
            text.write_str("an object of robots by name")
        }

        fn visit_map<A: MapAccess<'de>>(self, mut entries: A) -> Result<Self::Value, A::Error> {
            let mut found = BTreeMap::new();
            while let Some((name, value)) = entries.next_entry::<String, V>()? {
                if found.contains_key(&name) {
                    return Err(A::Error::custom(format!("`{name}` occurs twice")));
                }
                found.insert(name, value);
            }
            Ok(found)
        }
    }
    reader.deserialize_map(EachOnce(PhantomData))
}

/// A command, with the fields that every command has.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CommandLine {
    /// Time of the measurement that it answers.
    pub t_ns: u64,
    pub command: CommandWord,
    /// When the next measurement is due; `None` if nothing follows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub until_ns: Option<u64>,
    /// With `drive` only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub segments: Option<Vec<SegmentLine>>,
    /// With `stop` only, like the message.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub reason: Option<StopReason>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub message: Option<String>,
    /// With `stop` only: the robot concerned, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot: Option<String>,
    /// With `stop` for `blocked` only: the obstacle or the other robot.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub in_the_way: Option<String>,
    /// Index into the task's steps.
    pub step: usize,
    /// Line of the step in the program's text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub line: Option<u32>,
    pub phase: ControlPhase,
    /// Names of the robots that are driven on purpose; others may move along.
    pub driven: Vec<String>,
    /// Names of the robots that are taken to be docked.
    pub docked: Vec<String>,
}

/// Kind of command.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CommandWord {
    /// Play the segments one after the other, then the relax level.
    Drive,
    /// 0 V until `until_ns`.
    Rest,
    /// The last command is still in force.
    Continue,
    /// 0 V: the task is done.
    Finished,
    /// 0 V: the task was given up.
    Stop,
}

/// Strokes in one control state.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SegmentLine {
    /// One digit for each robot of the table, 1 for an arm that is down.
    pub state: String,
    /// Levels of the control cycle that comes first; empty if the arms are in that state already.
    pub levels_v: Vec<f64>,
    pub strokes: u64,
}

/// A line of the control protocol.
#[derive(Debug, Clone, PartialEq)]
pub enum ControlLine {
    Measured(MeasuredLine),
    Command(CommandLine),
}

impl ControlLine {
    /// The line as it is in a recording, without its line end.
    ///
    /// # Errors
    /// That of the serializer, which cannot occur here: all keys are strings.
    pub fn written(&self) -> Result<String, serde_json::Error> {
        match self {
            ControlLine::Measured(line) => serde_json::to_string(line),
            ControlLine::Command(line) => serde_json::to_string(line),
        }
    }
}
