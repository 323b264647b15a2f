//! `tweeze verify`: from a log alone, or against a program that the user trusts.

use super::arguments::VerifyArguments;
use super::disk::{self, MAX_LOG_BYTES};
use super::library::{Disk, Embedded};
use super::{Exit, errors, terminal};
use crate::check::Options;
use crate::check::claims::Claims;
use crate::check::imports::Library;
use crate::compile::{self, Program};
use crate::diagnostic::{Diagnostic, Sink};
use crate::emit::{Provenance, mcap};
use crate::schedule::source_ref;
use crate::source::Sources;
use crate::verify::log::{self, Log};
use crate::verify::{self, Verdict, Verified};
use std::path::Path;

/// A refusal on its way to the terminal: what was found, and the answer.
struct Refusal {
    sources: Sources,
    sink: Sink,
    exit: Exit,
}

impl Refusal {
    fn one(diagnostic: Diagnostic, exit: Exit) -> Box<Refusal> {
        let mut sink = Sink::default();
        sink.push(diagnostic);
        Box::new(Refusal { sources: Sources::default(), sink, exit })
    }
}

/// Replays a log; every step that refuses it says why.
pub fn run(arguments: &VerifyArguments) -> Exit {
    match judge(arguments) {
        Ok(text) => terminal::answer(&text),
        Err(refusal) => {
            terminal::report(&refusal.sink, &refusal.sources, arguments.report.format);
            refusal.exit
        }
    }
}

fn judge(arguments: &VerifyArguments) -> Result<String, Box<Refusal>> {
    let path = &arguments.file;
    let bytes = disk::read_bytes(path, MAX_LOG_BYTES).map_err(|error| Refusal::one(*error, Exit::Files))?;
    let log = log::read(&bytes).map_err(|error| Refusal::one(error.diagnostic(), Exit::Files))?;
    // Another version may derive something else from the same program: that is no sign of an edit.
    let of_its_version = |refusal| if log.version == env!("CARGO_PKG_VERSION") { refusal } else { not_ours(&log) };
    let own = own_claims(path, &log).map_err(of_its_version)?;
    let verified = replay(&log, &own)?;
    shows_the_same(&bytes, &log, &verified).map_err(of_its_version)?;
    if let Some(trusted) = &arguments.against {
        against(path, trusted, &log, &own.claims)?;
    }
    Ok(report(arguments, &log))
}

fn not_ours(log: &Log) -> Box<Refusal> {
    Refusal::one(log::other_version(Some(&log.version), None), Exit::Files)
}

/// The claims of a program, and its files for messages to point into.
struct Derived {
    claims: Claims,
    sources: Sources,
}

/// The claims of the program in the log, derived again; what the log says of itself must agree.
fn own_claims(path: &Path, log: &Log) -> Result<Derived, Box<Refusal>> {
    let (name, text) = &log.files[0];
    let own = derive(name, text, &Embedded(&log.files), log).map_err(|mut refusal| {
        refusal.sink.push(errors::program_in_log_has_errors(path));
        Box::new(Refusal { exit: Exit::Refused, ..*refusal })
    })?;
    if log.schedule.source != source_ref(name, text) {
        return Err(Refusal::one(errors::parts_disagree(path, "the fingerprint"), Exit::Refused));
    }
    if as_json(&own.claims).as_ref() != Some(&log.claims_json) {
        return Err(Refusal::one(errors::parts_disagree(path, "a claim"), Exit::Refused));
    }
    Ok(own)
}

fn as_json(claims: &Claims) -> Option<serde_json::Value> {
    serde_json::to_value(claims).ok()
}

/// The claims of a program, with the log's own settings, for the schedule of the log's name.
fn derive(name: &str, text: &str, library: &dyn Library, log: &Log) -> Result<Derived, Box<Refusal>> {
    let options = Options { settings: log.settings.clone(), only: Some(log.schedule.name.clone()) };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let checked = compile::check(&Program { name, text, library, options: &options }, &mut sources, &mut sink);
    let claims = checked.and_then(|checked| checked.claims.into_iter().next());
    match claims {
        Some(claims) => Ok(Derived { claims, sources }),
        None => Err(Box::new(Refusal { sources, sink, exit: Exit::Errors })),
    }
}

fn replay(log: &Log, derived: &Derived) -> Result<Verified, Box<Refusal>> {
    let mut sink = Sink::default();
    match verify::verify(log.schedule.clone(), &derived.claims) {
        Verdict::Accepted(verified) => return Ok(verified),
        Verdict::Rejected(violations) => violations.into_iter().for_each(|violation| sink.push(violation.into())),
        Verdict::Inconclusive { why } => sink.push(verify::inconclusive(&why)),
    }
    Err(Box::new(Refusal { sources: derived.sources.clone(), sink, exit: Exit::Refused }))
}

/// Every voltage, picture and line of the log must be that of its schedule.
fn shows_the_same(bytes: &[u8], log: &Log, verified: &Verified) -> Result<(), Box<Refusal>> {
    if let Some(fault) = log.voltage_fault() {
        return Err(Refusal::one(fault.diagnostic(), Exit::Refused));
    }
    let provenance = Provenance { files: log.files.clone(), settings: log.settings.clone() };
    match mcap::difference(bytes, verified, &provenance) {
        Some(difference) => Err(Refusal::one(mcap::difference_diagnostic(&difference), Exit::Refused)),
        None => Ok(()),
    }
}

/// Holds the log against a program that the user trusts.
fn against(path: &Path, trusted: &Path, log: &Log, own: &Claims) -> Result<(), Box<Refusal>> {
    let text = disk::read_program(trusted).map_err(|error| Refusal::one(*error, Exit::Files))?;
    let disk = Disk::round(trusted);
    let derived = derive(&disk.program_name(), &text, &disk, log)?;
    replay(log, &derived)?;
    if as_json(&derived.claims) != as_json(own) {
        return Err(Refusal::one(errors::other_program(path, trusted), Exit::Refused));
    }
    Ok(())
}

fn report(arguments: &VerifyArguments, log: &Log) -> String {
    let file = arguments.file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let trusted = arguments.against.as_ref().map(|path| path.to_string_lossy().into_owned());
    let names = [Some(file.as_str()), Some(log.schedule.name.as_str()), trusted.as_deref()];
    let width = names.into_iter().flatten().map(str::len).max().unwrap_or(0);
    let origin = format!("written by tweeze {} from {}", log.version, log.files[0].0);
    let mut text = terminal::line("Read", &file, width, &origin);
    let replayed = format!("{} actuations replayed, 0 violations", log.schedule.actuations.len());
    text.push_str(&terminal::line("Verified", &log.schedule.name, width, &replayed));
    if let Some(trusted) = trusted {
        text.push_str(&terminal::line("Matches", &trusted, width, "the log does what this program claims"));
    }
    text
}
