//! Reads the recording of a controlled run back without trusting it.
//!
//! Input: the bytes of an MCAP file written by `tweeze control --record`. Output: a [`Recording`], or a [`LogError`]
//! with the fault and its place. Promise: that of [`log`](super). The content is not judged here.

use super::records;
use super::{
    CLAIMS, COMMAND_TOPIC, LogError, MAX_CLAIMS_BYTES, MEASURED_TOPIC, RECORDING, attached, check_form, files,
    of_this_schema, provenance,
};
use crate::schedule::control::ControlLine;
use serde::Deserialize;

/// Content of a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// Name of the task.
    pub task: String,
    /// The claims as recorded; the authoritative ones are derived again from `files`.
    pub claims: Vec<u8>,
    /// Name and text of every source file, the program's own first.
    pub files: Vec<(String, String)>,
    /// The `--set` values.
    pub settings: Vec<String>,
    /// The version of Tweeze that wrote it.
    pub version: String,
    /// In file order.
    pub lines: Vec<RecordedMessage>,
}

/// A recorded line of the control protocol.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedMessage {
    /// The bytes, which may have spaces that the canonical line lacks.
    pub text: String,
    pub line: ControlLine,
}

/// Parses a recording.
///
/// # Errors
/// See [`LogError`].
pub fn read_recording(bytes: &[u8]) -> Result<Recording, LogError> {
    let (mut lines, mut fault) = (Vec::new(), None);
    let contents = records::read(bytes, &mut |topic, log_ns, data| {
        if fault.is_none() {
            match message(topic, log_ns, data) {
                Ok(message) => lines.push(message),
                Err(error) => fault = Some(error),
            }
        }
    })?;
    of_this_schema(&contents, RECORDING)?;
    if let Some(fault) = fault {
        return Err(fault);
    }
    let claims = attached(&contents, CLAIMS, MAX_CLAIMS_BYTES)?;
    check_form(claims).map_err(|what| LogError::content(CLAIMS, what))?;
    let entry = |key: &str| provenance(&contents, RECORDING, key);
    let settings = serde_json::from_str(entry("settings")?)
        .map_err(|error| LogError::content(format!("metadata `{RECORDING}`, entry `settings`"), error.to_string()))?;
    Ok(Recording {
        task: entry("program")?.to_owned(),
        claims: claims.to_vec(),
        files: files(&contents)?,
        settings,
        version: entry("version")?.to_owned(),
        lines,
    })
}

fn message(topic: &str, log_ns: u64, data: &[u8]) -> Result<RecordedMessage, LogError> {
    let place = || format!("topic `{topic}` at {log_ns} ns");
    let text =
        std::str::from_utf8(data).map_err(|error| LogError::content(place(), format!("it is not UTF-8: {error}")))?;
    let line = match topic {
        MEASURED_TOPIC => parsed(text).map(ControlLine::Measured),
        COMMAND_TOPIC => parsed(text).map(ControlLine::Command),
        _ => Err("it is not a topic of a recording".to_owned()),
    };
    let line = line.map_err(|what| LogError::content(place(), what))?;
    Ok(RecordedMessage { text: text.to_owned(), line })
}

fn parsed<'d, T: Deserialize<'d>>(text: &'d str) -> Result<T, String> {
    serde_json::from_str(text).map_err(|error| error.to_string())
}
