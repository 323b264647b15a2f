//! Faults of a log.

use super::{SCHEMA, SeriesFault};
use crate::diagnostic::{Code, Diagnostic};

/// Reason why a file is not a log that can be judged.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LogError {
    /// It does not begin like an MCAP file.
    NotALog,
    /// It is truncated; `offset` is where more data should follow.
    Truncated { offset: u64 },
    /// A checksum is wrong or missing, or records contradict each other; `offset` is the beginning of the record.
    Damaged { offset: u64, what: String },
    /// A part exceeds the size limit of the reader.
    TooLarge { offset: u64, what: String, bytes: u64, limit: u64 },
    /// A part that every Tweeze log has is missing.
    Missing { what: String },
    /// It is not the log of a plan but the recording of a controlled run.
    Recorded,
    /// The log has another schema, written by the named version of Tweeze.
    OtherSchema { schema: String, version: Option<String> },
    /// A part is intact but does not have the required content.
    Content { place: String, what: String },
}

impl LogError {
    pub(super) fn damaged(offset: u64, what: impl Into<String>) -> LogError {
        LogError::Damaged { offset, what: what.into() }
    }

    pub(super) fn content(place: impl Into<String>, what: impl Into<String>) -> LogError {
        LogError::Content { place: place.into(), what: what.into() }
    }

    /// The error as a diagnostic.
    pub fn diagnostic(&self) -> Diagnostic {
        const AGAIN: &str = "build the program again, or fetch another copy of the log";
        match self {
            LogError::NotALog => Diagnostic::new(Code::E0840, "the file does not begin like an MCAP log")
                .help("`tweeze verify` reads the `.mcap` file that `tweeze build` writes"),
            LogError::Truncated { offset } => {
                Diagnostic::new(Code::E0841, format!("the log is truncated: more data must follow byte {offset}"))
                    .help(format!("{AGAIN}; for the recording of a controlled run, `mcap recover` saves what is left"))
            }
            LogError::Damaged { offset, what } => {
                Diagnostic::new(Code::E0842, format!("the log is damaged at byte {offset}: {what}")).help(AGAIN)
            }
            LogError::TooLarge { offset, what, bytes, limit } => Diagnostic::new(
                Code::E0843,
                format!("{what} at byte {offset} of the log declares {bytes}; the limit is {limit}"),
            )
            .help("no log of Tweeze is that large; build the program again"),
            LogError::Missing { what } => Diagnostic::new(Code::E0844, format!("the log has no {what}"))
                .help("`tweeze verify` reads the `.mcap` file that `tweeze build` or `tweeze control --record` writes"),
            LogError::Recorded => {
                Diagnostic::new(Code::E0844, "the file is the recording of a controlled run, not the log of a plan")
                    .help("`tweeze verify` judges recordings; build the program to see its plan")
            }
            LogError::OtherSchema { schema, version } => other_version(version.as_deref(), Some(schema)),
            LogError::Content { place, what } => {
                Diagnostic::new(Code::E0845, format!("{place} of the log cannot be read: {what}")).help(AGAIN)
            }
        }
    }
}

/// Diagnostic for a log of another version, and of another schema if one is given; such a log is not judged.
///
/// Texts from the log are printed without control characters and truncated.
pub fn other_version(version: Option<&str>, schema: Option<&str>) -> Diagnostic {
    let clean = |text: &str| text.chars().filter(|c| !c.is_control()).take(40).collect::<String>();
    let writer = version.map_or_else(|| "an unknown version of tweeze".to_owned(), |v| format!("tweeze {}", clean(v)));
    let own = env!("CARGO_PKG_VERSION");
    let title = match schema {
        Some(schema) => {
            let schema = clean(schema);
            format!(
                "the log was written by {writer} in schema {schema}; this is tweeze {own}, which reads schema {SCHEMA}"
            )
        }
        None => format!("the log was written by {writer}; this tweeze {own} does not derive it from its program"),
    };
    Diagnostic::new(Code::E0848, title).help(format!(
        "verify it with {writer}, or build its program again with this version: the log contains the source"
    ))
}

impl SeriesFault {
    /// The fault as a diagnostic.
    pub fn diagnostic(&self) -> Diagnostic {
        Diagnostic::new(Code::E0846, format!("the voltages or positions in the log differ from its schedule: {self}"))
            .help("the log was changed after it was written; build the program again")
    }
}
