//! The schedule as JSON: format `tweeze-schedule`, version 2, as described by `schema/schedule.schema.json`.
//!
//! Input: a [`Schedule`], or the bytes of one. Promise: [`read`] returns exactly the input of [`write()`] except the
//! spans, every float bit for bit; the result has no index out of range, no instant beyond `u64`, no empty actuation,
//! and only swings of whole periods.

use super::{Actuation, Schedule, Swing};
use serde::{Deserialize, Serialize};
use serde_json::ser::{Formatter, PrettyFormatter, Serializer};
use std::io;

/// The value of `format`.
pub const FORMAT: &str = "tweeze-schedule";

/// The value of `version`; incremented when a reader of the old form would misread the new one.
pub const VERSION: u64 = 2;

/// Longest duration of a schedule that is written, in nanoseconds: about 146 years. Twice that still fits a `u64`.
pub const MAX_DURATION_NS: u64 = u64::MAX / 4;

#[derive(Serialize)]
struct ScheduleDocument<'a> {
    format: &'static str,
    version: u64,
    #[serde(flatten)]
    schedule: &'a Schedule,
}

#[derive(Deserialize)]
struct Header {
    format: String,
    version: u64,
}

/// Reason why bytes are not a schedule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ReadError {
    /// Not JSON, or not of this form; the fault and its position in words.
    Form(String),
    /// Another format or version.
    Version { format: String, version: u64 },
    /// An entry that contradicts another: its path (`actuations[3].channel`) and the fault.
    Contradiction { place: String, what: String },
}

impl std::fmt::Display for ReadError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            ReadError::Form(what) => f.write_str(what),
            ReadError::Version { format, version } => {
                write!(f, "format `{format}` version {version} is not `{FORMAT}` version {VERSION}")
            }
            ReadError::Contradiction { place, what } => write!(f, "`{place}` {what}"),
        }
    }
}

/// The schedule as UTF-8 text: one line for each channel, actuation, step and state.
///
/// A non-finite float becomes `null`, which no reader accepts; the emit stage refuses it beforehand.
pub fn write(schedule: &Schedule) -> Vec<u8> {
    let document = ScheduleDocument { format: FORMAT, version: VERSION, schedule };
    let mut bytes = Vec::new();
    let mut serializer = Serializer::with_formatter(&mut bytes, CompactLines::default());
    document.serialize(&mut serializer).expect("a schedule has string keys only, and memory takes all bytes");
    bytes.push(b'\n');
    bytes
}

/// Parses a schedule.
///
/// # Errors
/// See [`ReadError`]. Unknown fields are ignored, except those of a pose.
pub fn read(bytes: &[u8]) -> Result<Schedule, ReadError> {
    let form = |error: serde_json::Error| ReadError::Form(error.to_string());
    let Header { format, version } = serde_json::from_slice(bytes).map_err(form)?;
    if format != FORMAT || version != VERSION {
        return Err(ReadError::Version { format, version });
    }
    let schedule: Schedule = serde_json::from_slice(bytes).map_err(form)?;
    check(&schedule)?;
    Ok(schedule)
}

fn check(schedule: &Schedule) -> Result<(), ReadError> {
    let wrong = |place: String, what: &str| Err(ReadError::Contradiction { place, what: what.to_owned() });
    let too_late = |start: u64, duration: u64| start.max(duration) > MAX_DURATION_NS;
    if schedule.duration_ns > MAX_DURATION_NS {
        return wrong("duration_ns".into(), "is beyond the longest schedule");
    }
    for (index, actuation) in schedule.actuations.iter().enumerate() {
        let place = |field: &str| format!("actuations[{index}].{field}");
        if actuation.channel as usize >= schedule.channels.len() {
            return wrong(place("channel"), "names a channel that does not exist");
        }
        if actuation.step as usize >= schedule.steps.len() {
            return wrong(place("step"), "names a step that does not exist");
        }
        if actuation.duration_ns == 0 {
            return wrong(place("duration_ns"), "is zero");
        }
        if too_late(actuation.start_ns, actuation.duration_ns) {
            return wrong(place("start_ns"), "is beyond the longest schedule");
        }
        if let Some((field, what)) = actuation.swing.and_then(|swing| swing_fault(actuation, swing)) {
            return wrong(place(field), what);
        }
    }
    for (index, step) in schedule.steps.iter().enumerate() {
        if step.plan as usize >= schedule.plans.len() {
            return wrong(format!("steps[{index}].plan"), "names a plan that does not exist");
        }
        if too_late(step.start_ns, step.duration_ns) {
            return wrong(format!("steps[{index}].start_ns"), "is beyond the longest schedule");
        }
        for (nth, operation) in step.operations.iter().enumerate() {
            if too_late(operation.start_ns.max(operation.arrival_ns), operation.duration_ns) {
                return wrong(format!("steps[{index}].operations[{nth}]"), "is beyond the longest schedule");
            }
        }
    }
    for (index, hold) in schedule.holds.iter().enumerate() {
        if hold.step as usize >= schedule.steps.len() {
            return wrong(format!("holds[{index}].step"), "names a step that does not exist");
        }
        if too_late(hold.start_ns, hold.terms.duration_ns) {
            return wrong(format!("holds[{index}].start_ns"), "is beyond the longest schedule");
        }
    }
    for (index, plan) in schedule.plans.iter().enumerate() {
        let last_ns = plan.states.iter().map(|state| state.t_ns).max().unwrap_or(0);
        if too_late(plan.start_ns, plan.duration_ns) || last_ns > MAX_DURATION_NS {
            return wrong(format!("plans[{index}]"), "is beyond the longest schedule");
        }
    }
    Ok(())
}

/// Fault of a swing: the field and the reason; `None` if it is valid.
fn swing_fault(actuation: &Actuation, swing: Swing) -> Option<(&'static str, &'static str)> {
    let Swing { period_ns, levels } = swing;
    let bits = |values: [f64; 2]| values.map(f64::to_bits);
    if period_ns == 0 || !period_ns.is_multiple_of(2) {
        return Some(("swing.period_ns", "is zero or odd, so it has no halves"));
    }
    if !actuation.duration_ns.is_multiple_of(period_ns) {
        return Some(("duration_ns", "is not a whole number of its swing's periods"));
    }
    let agrees = bits(levels) == bits([actuation.from, actuation.to]);
    (!agrees).then_some(("swing.levels", "are not `from` and `to`"))
}

/// Depths of the lists whose elements get a line each: those of the document, and the states of a plan.
const DEPTHS_OF_LINES: [usize; 3] = [1, 2, 4];

/// Prints small values on one line and long lists on many.
#[derive(Default)]
struct CompactLines {
    depth: usize,
    pretty: PrettyFormatter<'static>,
}

impl CompactLines {
    fn gap<W: ?Sized + io::Write>(&self, writer: &mut W, first: bool, array: bool) -> io::Result<()> {
        if !first {
            writer.write_all(b",")?;
        }
        match DEPTHS_OF_LINES.contains(&self.depth) && (array || self.depth == 1) {
            true => write!(writer, "\n{:width$}", "", width = 2 * self.depth),
            false if first => Ok(()),
            false => writer.write_all(b" "),
        }
    }
}

impl Formatter for CompactLines {
    fn begin_array<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        writer.write_all(b"[")
    }

    fn end_array<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        writer.write_all(b"]")
    }

    fn begin_array_value<W: ?Sized + io::Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.gap(writer, first, true)
    }

    fn begin_object<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        writer.write_all(b"{")
    }

    fn end_object<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        writer.write_all(if self.depth == 0 { b"\n}" } else { b"}" })
    }

    fn begin_object_key<W: ?Sized + io::Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        self.gap(writer, first, false)
    }

    fn begin_object_value<W: ?Sized + io::Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.pretty.begin_object_value(writer)
    }
}
