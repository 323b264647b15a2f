//! Compares a log with the one that its schedule gives, so that edits show up.

use super::{LIBRARY, LogTopic, Provenance, Signals};
use crate::diagnostic::{Code, Diagnostic};
use crate::log;
use crate::verify::Verified;
use std::io::{self, Write};

/// The difference between a log and the one written from a schedule; `None` if they are the same byte for byte.
///
/// Names the first message that differs, is missing or is superfluous, by topic and time, or else the part that
/// differs. The log may be anything: unreadable parts count as different.
pub fn difference(log_bytes: &[u8], verified: &Verified, provenance: &Provenance) -> Option<String> {
    let mut comparison = Comparison::with(log_bytes);
    let topics = super::read_topics(verified).map(|(topics, _)| topics);
    let written = topics.and_then(|topics| super::write_to(&mut comparison, topics, verified, provenance));
    match written {
        Ok(()) if comparison.is_whole() => None,
        Err(error) if !comparison.differs => Some(error.diagnostic().title),
        Ok(()) | Err(_) => {
            let mut search = MessageComparison::new(super::topics(verified, &Signals::new(verified.schedule())));
            let read = log::read_with(log_bytes, &mut |topic, t_ns, data| search.compare(topic, t_ns, data));
            Some(match read {
                Ok(log) => search.found().unwrap_or_else(|| part(&log, verified, provenance)),
                Err(error) => error.diagnostic().title,
            })
        }
    }
}

/// Receives the written bytes and compares them with the log, so that no second log is held in memory.
pub(super) struct Comparison<'a> {
    /// The part of the log not yet compared.
    rest: &'a [u8],
    differs: bool,
}

impl<'a> Comparison<'a> {
    pub fn with(bytes: &'a [u8]) -> Self {
        Comparison { rest: bytes, differs: false }
    }

    /// Whether exactly the bytes of the log were written.
    pub fn is_whole(&self) -> bool {
        self.rest.is_empty() && !self.differs
    }
}

impl Write for Comparison<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self.rest.strip_prefix(bytes).filter(|_| !self.differs) {
            Some(rest) => {
                self.rest = rest;
                Ok(bytes.len())
            }
            None => {
                self.differs = true;
                Err(io::Error::other("the logs differ"))
            }
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// The diagnostic for the terminal.
pub fn difference_diagnostic(difference: &str) -> Diagnostic {
    Diagnostic::new(Code::E0847, format!("the log does not show its schedule: {difference}"))
        .help("the log was changed after it was written: build the program again")
}

/// The expected messages, and the first difference found.
struct MessageComparison {
    topics: Vec<LogTopic>,
    /// Number of messages seen of each topic.
    seen: Vec<usize>,
    found: Option<String>,
}

impl MessageComparison {
    fn new(topics: Vec<LogTopic>) -> Self {
        let seen = vec![0; topics.len()];
        MessageComparison { topics, seen, found: None }
    }

    fn compare(&mut self, topic: &str, t_ns: u64, data: &[u8]) {
        if self.found.is_some() {
            return;
        }
        let Some(index) = self.topics.iter().position(|expected| expected.name == topic) else {
            self.found = Some(format!("`{topic}` at {t_ns} ns is not a topic of this schedule"));
            return;
        };
        let expected = self.topics[index].messages.get(self.seen[index]);
        self.seen[index] += 1;
        self.found = match expected {
            Some((expected_ns, bytes)) if *expected_ns == t_ns && bytes == data => None,
            Some((expected_ns, _)) if *expected_ns < t_ns => Some(missing(topic, *expected_ns)),
            Some((expected_ns, _)) if *expected_ns == t_ns => {
                Some(format!("the message of `{topic}` at {t_ns} ns differs"))
            }
            Some(_) | None => Some(format!("`{topic}` has an extra message at {t_ns} ns")),
        };
    }

    /// The first difference, after all messages of the log were compared.
    fn found(self) -> Option<String> {
        let rest = self.topics.iter().zip(&self.seen);
        let missing =
            rest.filter_map(|(topic, seen)| Some((topic.messages.get(*seen)?.0, topic))).min_by_key(|(t_ns, _)| *t_ns);
        self.found.or_else(|| missing.map(|(t_ns, topic)| self::missing(&topic.name, t_ns)))
    }
}

fn missing(topic: &str, t_ns: u64) -> String {
    format!("the message of `{topic}` at {t_ns} ns is missing")
}

/// Differences outside the messages.
fn part(log: &log::Log, verified: &Verified, provenance: &Provenance) -> String {
    let claims = log::write_claims(verified.claims()).ok();
    let parts = [
        (log.schedule != *verified.schedule(), "the attached schedule differs"),
        (Some(&log.claims) != claims.as_ref(), "the attached claims differ"),
        (log.files != provenance.files, "the attached source files differ"),
        (log.settings != provenance.settings, "the recorded settings differ"),
    ];
    let differing = parts.iter().find(|(differs, _)| *differs);
    differing.map_or_else(
        || format!("names, index or packing of the file are not as {LIBRARY} writes them"),
        |(_, what)| (*what).to_owned(),
    )
}
