//! Reads a log back without trusting it.
//!
//! Input: the bytes of an MCAP file. Output: a [`Log`] with the data that the verifier needs, or a [`LogError`] with
//! the fault and its place. Promise: every checksum is present and correct; no input makes it panic or hang; memory
//! stays within a small multiple of the limits below and of the file's own size. The content of the log is not judged
//! here, except by [`Log::series_fault`], which compares the recorded voltages and positions with the recorded
//! schedule.
//!
//! The records are parsed here (MCAP specification, version 0) and not by the `mcap` crate: version 0.26 panics on an
//! attachment that is shorter than its header says (`parse_record` slices up to four bytes before the end), and
//! ignores bytes after the last field of a record, in which an edited log could hide something from the reader.

mod error;
mod recording;
mod records;
mod series;

pub use error::{LogError, other_version};
pub use recording::{RecordedMessage, Recording, read_recording};
pub use series::{Bound, Samples, Series, SeriesColumn, SeriesFault, fault as series_fault};

use crate::claims::Claims;
use crate::schedule::{ChannelUnit, Schedule, json};
use crate::source::MAX_FILE_BYTES;
use records::{Attachment, Contents};

/// Most bytes of uncompressed messages in a log: those of an assay of some 3,000 operations.
pub const MAX_DATA_BYTES: u64 = 2 * 1024 * 1024 * 1024;

/// Largest message in a log, in bytes.
pub const MAX_MESSAGE_BYTES: u64 = 64 * 1024 * 1024;

/// Most messages in a log.
pub const MAX_MESSAGES: u64 = 4_000_000;

/// Most bytes of the message types and topics of a log together, each counted once; their parsed form takes some ten
/// times as much memory.
pub const MAX_DEFINITION_BYTES: u64 = 16 * 1024 * 1024;

/// Largest map of names to texts in one record, in bytes.
pub const MAX_MAP_BYTES: u64 = 8 * 1024 * 1024;

/// Most topics with channels in a log.
pub const MAX_DEVICES: u64 = 1000;

/// Largest schedule in a log, in bytes of JSON.
pub const MAX_SCHEDULE_BYTES: u64 = 256 * 1024 * 1024;

/// Largest claims in a log, in bytes of JSON.
pub const MAX_CLAIMS_BYTES: u64 = 64 * 1024 * 1024;

/// Name of the attachment with the schedule.
pub const SCHEDULE: &str = "schedule.json";

/// Name of the attachment with the claims.
pub const CLAIMS: &str = "claims.json";

/// Prefix of the names of attached source files.
pub const SOURCE_PREFIX: &str = "source/";

/// Version of the log's content; increased when a log of the previous version would be misjudged because its records,
/// its claims or the consequences of a program have changed. Logs without it have version 1.
pub const SCHEMA: u64 = 5;

/// The value of `format` in the attached claims.
pub const CLAIMS_FORMAT: &str = "tweeze-claims";

/// Name of the metadata record with the origin of the log.
pub const METADATA: &str = "tweeze";

/// Name of the metadata record of a recorded controlled run.
pub const RECORDING: &str = "tweeze-recording";

/// Topics of such a recording: lines of measured poses and lines of commands.
pub const MEASURED_TOPIC: &str = "/control/measured";
pub const COMMAND_TOPIC: &str = "/control/command";

/// The topic of a device's channels of one unit.
pub fn topic(device: &str, unit: ChannelUnit) -> String {
    format!("/{device}{}", suffix(unit))
}

/// Whether a topic is one of channels.
pub fn is_topic(name: &str) -> bool {
    name.starts_with('/')
        && [ChannelUnit::Volt, ChannelUnit::Micrometre].iter().any(|unit| name.ends_with(suffix(*unit)))
}

/// Suffix of the topics of channels, after the device's name.
fn suffix(unit: ChannelUnit) -> &'static str {
    match unit {
        ChannelUnit::Volt => "/voltages",
        ChannelUnit::Micrometre => "/positions",
    }
}

/// Metadata key suffix, after a field's path in a topic of channels, of the entry that names its [`Bound`].
pub const BOUND_SUFFIX: &str = ".bound";

/// Metadata key suffix, as [`BOUND_SUFFIX`], of the entry with the periods of the drive trains, in nanoseconds,
/// separated by spaces.
pub const PERIOD_SUFFIX: &str = ".period_ns";

/// Content of a log.
#[derive(Debug, Clone, PartialEq)]
pub struct Log {
    pub schedule: Schedule,
    /// The claims as recorded, in the form of [`write_claims`]; the authoritative ones are derived again from
    /// `files`.
    pub claims: Vec<u8>,
    /// Name and text of every source file, the program's own first.
    pub files: Vec<(String, String)>,
    /// The `--set` values.
    pub settings: Vec<String>,
    /// The version of Tweeze that wrote it.
    pub version: String,
    /// The recorded plots of the channels, one series for each device and unit.
    pub series: Vec<Series>,
}

/// Parses a log.
///
/// # Errors
/// See [`LogError`].
pub fn read(bytes: &[u8]) -> Result<Log, LogError> {
    read_with(bytes, &mut |_, _, _| ())
}

/// Parses a log, and calls `visit` with the topic, the instant in nanoseconds and the bytes of every message, in file
/// order.
///
/// # Errors
/// See [`LogError`]; `visit` was called for the messages before the fault.
pub fn read_with<'v>(bytes: &[u8], visit: &'v mut (dyn FnMut(&str, u64, &[u8]) + 'v)) -> Result<Log, LogError> {
    let contents = records::read(bytes, visit)?;
    if contents.metadata.contains_key(RECORDING) {
        return Err(LogError::Recorded);
    }
    of_this_schema(&contents, METADATA)?;
    let schedule = attached(&contents, SCHEDULE, MAX_SCHEDULE_BYTES)?;
    let schedule = json::read(schedule).map_err(|error| LogError::content(SCHEDULE, error.to_string()))?;
    let claims = attached(&contents, CLAIMS, MAX_CLAIMS_BYTES)?;
    check_form(claims).map_err(|what| LogError::content(CLAIMS, what))?;
    let version = provenance(&contents, METADATA, "version")?.to_owned();
    let settings = serde_json::from_str(provenance(&contents, METADATA, "settings")?)
        .map_err(|error| LogError::content(format!("metadata `{METADATA}`, entry `settings`"), error.to_string()))?;
    let program = provenance(&contents, METADATA, "program")?;
    if program != schedule.name {
        let what = format!("it is for `{}`, but the metadata name `{program}`", schedule.name);
        return Err(LogError::content(SCHEDULE, what));
    }
    let files = files(&contents)?;
    Ok(Log { schedule, claims: claims.to_vec(), files, settings, version, series: contents.series })
}

/// Refuses a log of another schema before any of its content is misread.
fn of_this_schema(contents: &Contents, record: &str) -> Result<(), LogError> {
    let Some(metadata) = contents.metadata.get(record) else { return Ok(()) };
    let entry = |key: &str| metadata.get(key).cloned();
    let schema = entry("schema").unwrap_or_else(|| "1".to_owned());
    match schema == SCHEMA.to_string() {
        true => Ok(()),
        false => Err(LogError::OtherSchema { schema, version: entry("version") }),
    }
}

/// Whether claims have the expected form. Their content is compared as text, and never parsed.
fn check_form(bytes: &[u8]) -> Result<(), String> {
    #[derive(serde::Deserialize)]
    struct Form {
        format: Option<String>,
        version: Option<u64>,
    }
    let form: Form = serde_json::from_slice(bytes).map_err(|error| error.to_string())?;
    match form.format.as_deref() == Some(CLAIMS_FORMAT) && form.version == Some(SCHEMA) {
        true => Ok(()),
        false => Err(format!("it is not of the format `{CLAIMS_FORMAT}`, version {SCHEMA}")),
    }
}

/// Serialises claims in the form that a log carries.
///
/// # Errors
/// That of the serializer, which cannot occur here: all keys are strings.
pub fn write_claims(claims: &Claims) -> Result<Vec<u8>, serde_json::Error> {
    #[derive(serde::Serialize)]
    struct LogDocument<'a> {
        format: &'static str,
        version: u64,
        #[serde(flatten)]
        claims: &'a Claims,
    }
    serde_json::to_vec(&LogDocument { format: CLAIMS_FORMAT, version: SCHEMA, claims })
}

/// The data of the only attachment with this name.
fn attached<'a>(contents: &Contents<'a>, name: &str, limit: u64) -> Result<&'a [u8], LogError> {
    let mut found = contents.attachments.iter().filter(|attachment| attachment.name == name);
    match (found.next(), found.next()) {
        (None, _) => Err(LogError::Missing { what: format!("attachment `{name}`") }),
        (Some(_), Some(second)) => Err(LogError::damaged(second.offset, format!("a second attachment `{name}`"))),
        (Some(attachment), None) => within(attachment, limit),
    }
}

fn within<'a>(attachment: &Attachment<'a>, limit: u64) -> Result<&'a [u8], LogError> {
    let bytes = attachment.data.len() as u64;
    if bytes > limit {
        let what = format!("attachment `{}`", attachment.name);
        return Err(LogError::TooLarge { offset: attachment.offset, what, bytes, limit });
    }
    Ok(attachment.data)
}

/// An entry of a metadata record.
fn provenance<'a>(contents: &'a Contents, record: &str, key: &str) -> Result<&'a str, LogError> {
    let missing = || LogError::Missing { what: format!("entry `{key}` of the metadata record `{record}`") };
    let metadata = contents.metadata.get(record).ok_or_else(missing)?;
    metadata.get(key).map(String::as_str).ok_or_else(missing)
}

fn files(contents: &Contents) -> Result<Vec<(String, String)>, LogError> {
    let mut names = std::collections::BTreeSet::new();
    let mut files = Vec::new();
    for attachment in &contents.attachments {
        let Some(name) = attachment.name.strip_prefix(SOURCE_PREFIX) else { continue };
        let data = within(attachment, MAX_FILE_BYTES as u64)?;
        let text = std::str::from_utf8(data)
            .map_err(|error| LogError::content(attachment.name.clone(), format!("it is not UTF-8: {error}")))?;
        if !names.insert(name) {
            return Err(LogError::damaged(attachment.offset, format!("a second attachment `{}`", attachment.name)));
        }
        files.push((name.to_owned(), text.to_owned()));
    }
    match files.is_empty() {
        true => Err(LogError::Missing { what: format!("attachment `{SOURCE_PREFIX}…` with the program's source") }),
        false => Ok(files),
    }
}

impl Log {
    /// The first place at which the recorded voltages and positions differ from the recorded schedule.
    pub fn series_fault(&self) -> Option<SeriesFault> {
        series::fault(&self.schedule, &self.series)
    }
}

#[cfg(test)]
mod tests;
