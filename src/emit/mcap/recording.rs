//! The recording of a controlled run as MCAP: measurements, commands and decisions, each line as it was exchanged.
//!
//! It has two topics of JSON messages, `/control/measured` and `/control/command`, at the times of the measurements.
//! The source files and the claims are attached as in the log of a plan, and the metadata record `tweeze-recording`
//! names the version, the program and its settings. Nothing in it depends on a clock, so the same measurements give the
//! same bytes.

use super::difference::Comparison;
use super::{CLAIMS, EmitError, Format, LIBRARY, Provenance, SOURCE_PREFIX, attach, options};
use crate::claims::Claims;
use crate::log::{self, RecordedMessage};
use crate::schedule::control::ControlLine;
use crate::source::MAX_FILE_BYTES;
use ::mcap::write::NoSeek;
use ::mcap::{McapError, Writer, records};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Number of messages after which the file is flushed.
const FLUSHED_MESSAGES: u32 = 100;

/// The schema of both kinds of lines.
const SCHEMA: &str = include_str!("../../../schema/control.schema.json");

/// A recording in progress.
pub struct Recorder<W: Write> {
    writer: Writer<NoSeek<W>>,
    /// Channel id of each topic, and the number of its messages.
    topics: [(u16, u32); 2],
}

/// Kind of a line of the exchange.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RecordedLine {
    Measured,
    Command,
}

impl<W: Write> Recorder<W> {
    /// Begins a recording of the single task of some claims.
    ///
    /// # Errors
    /// [`EmitError`] if it cannot be written, or a source file is too large.
    pub fn begin(to: W, claims: &Claims, provenance: &Provenance) -> Result<Self, EmitError> {
        let mut writer = options().create(NoSeek::new(to)).map_err(failed)?;
        let entries = [
            ("version", env!("CARGO_PKG_VERSION").to_owned()),
            ("schema", log::SCHEMA.to_string()),
            ("program", claims.name.clone()),
            ("settings", serde_json::to_string(&provenance.settings).map_err(unwritable)?),
            ("library", LIBRARY.to_owned()),
        ];
        let metadata = entries.into_iter().map(|(key, value)| (key.to_owned(), value)).collect();
        let metadata = records::Metadata { name: log::RECORDING.to_owned(), metadata };
        writer.write_metadata(&metadata).map_err(failed)?;
        let written = log::write_claims(claims).map_err(unwritable)?;
        attach(&mut writer, CLAIMS, "application/json", &written, log::MAX_CLAIMS_BYTES)?;
        for (name, text) in &provenance.files {
            let name = format!("{SOURCE_PREFIX}{name}");
            attach(&mut writer, &name, "text/plain", text.as_bytes(), MAX_FILE_BYTES as u64)?;
        }
        let schema = writer.add_schema("tweeze.Control", "jsonschema", SCHEMA.as_bytes()).map_err(failed)?;
        let mut topic = |name: &str| writer.add_channel(schema, name, "json", &BTreeMap::new()).map_err(failed);
        let topics = [(topic(log::MEASURED_TOPIC)?, 0), (topic(log::COMMAND_TOPIC)?, 0)];
        Ok(Recorder { writer, topics })
    }

    /// Adds a line at the time of its measurement.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn add(&mut self, line: RecordedLine, t_ns: u64, json: &str) -> io::Result<()> {
        let (channel_id, sequence) = &mut self.topics[line as usize];
        let header =
            records::MessageHeader { channel_id: *channel_id, sequence: *sequence, log_time: t_ns, publish_time: t_ns };
        *sequence += 1;
        let is_due = *sequence % FLUSHED_MESSAGES == 0;
        self.writer.write_to_known_channel(&header, json.as_bytes()).map_err(of_disk)?;
        if is_due { self.writer.flush().map_err(of_disk) } else { Ok(()) }
    }

    /// Ends the recording.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn finish(mut self) -> io::Result<()> {
        self.writer.finish().map(drop).map_err(of_disk)
    }
}

/// Whether a file is, byte for byte, the recording of some lines, so that it contains nothing else and viewers show
/// each line at its time.
pub fn is_as_recorded(bytes: &[u8], claims: &Claims, provenance: &Provenance, lines: &[RecordedMessage]) -> bool {
    let mut comparison = Comparison::with(bytes);
    again(&mut comparison, claims, provenance, lines).is_ok() && comparison.is_whole()
}

/// Records lines that were recorded before.
fn again(
    to: &mut impl Write,
    claims: &Claims,
    provenance: &Provenance,
    lines: &[RecordedMessage],
) -> Result<(), EmitError> {
    let mut recorder = Recorder::begin(to, claims, provenance)?;
    let mut last_ns = 0;
    for RecordedMessage { text, line } in lines {
        let (kind, t_ns) = match line {
            ControlLine::Measured(line) => (RecordedLine::Measured, line.t_ns.max(last_ns)),
            ControlLine::Command(line) => (RecordedLine::Command, line.t_ns),
        };
        last_ns = t_ns;
        recorder.add(kind, t_ns, text).map_err(|error| failed(McapError::Io(error)))?;
    }
    recorder.finish().map_err(|error| failed(McapError::Io(error)))
}

/// The I/O error of a failed write. Lines of any length fit, so only the disk can refuse one.
fn of_disk(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other.to_string()),
    }
}

fn failed(error: McapError) -> EmitError {
    EmitError::Failed { format: Format::Mcap, detail: error.to_string() }
}

fn unwritable(error: serde_json::Error) -> EmitError {
    EmitError::Failed { format: Format::Mcap, detail: error.to_string() }
}
