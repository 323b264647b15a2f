//! `tweeze verify`: checks a log alone, or against a program that the user trusts.

use super::arguments::{ReportFormat, VerifyArguments};
use super::disk::{self, MAX_LOG_BYTES};
use super::errors::LogOrigin;
use super::library::{Disk, Embedded};
use super::waiting::ProgressLine;
use super::{Exit, errors, judge_recording, report, terminal};
use crate::check::Options;
use crate::claims::Claims;
use crate::cli::difference;
use crate::compile::{self, ProgramSource};
use crate::diagnostic::{Diagnostic, Sink};
use crate::emit::{Provenance, mcap};
use crate::log::{self, Log, LogError};
use crate::plan::watch::SearchWatch;
use crate::schedule::{Schedule, SourceRef};
use crate::source::Sources;
use crate::verify::{self, Verified, Violation};
use std::path::Path;
use std::sync::Arc;

/// A refusal: its diagnostics and the exit status.
pub struct Refusal {
    pub sources: Sources,
    pub sink: Sink,
    pub exit: Exit,
}

impl Refusal {
    pub fn one(diagnostic: Diagnostic, exit: Exit) -> Box<Refusal> {
        let mut sink = Sink::default();
        sink.push(diagnostic);
        Box::new(Refusal { sources: Sources::default(), sink, exit })
    }

    /// Reports the refusal; returns the exit status.
    pub fn report(&self, format: ReportFormat) -> Exit {
        terminal::report(&self.sink, &self.sources, format);
        self.exit
    }
}

/// Replays a log and prints the report, or the reason of the refusal.
pub fn run(arguments: &VerifyArguments) -> Exit {
    match judge(arguments) {
        Ok(text) => terminal::success(&text, arguments.quiet),
        Err(refusal) => refusal.report(arguments.report.format),
    }
}

fn judge(arguments: &VerifyArguments) -> Result<String, Box<Refusal>> {
    let path = &arguments.file;
    disk::settle(path).map_err(|error| Refusal::one(*error, Exit::Files))?;
    let bytes = disk::read_bytes(path, MAX_LOG_BYTES).map_err(|error| Refusal::one(*error, Exit::Files))?;
    let judged = match log::read(&bytes) {
        Err(LogError::Recorded) if arguments.replan => {
            return Err(Refusal::one(errors::no_plan_in(path), Exit::Usage));
        }
        Err(LogError::Recorded) => return judge_recording(arguments, &bytes),
        log => judge_log(path, &bytes, log)?,
    };
    drop(bytes);
    if arguments.tolerances.is_any() {
        let text =
            "tweeze: tolerances apply only to the recording of a controlled run; a plan must keep its claims exactly\n";
        terminal::to_stderr(text);
    }
    if let Some(trusted) = &arguments.against {
        against(arguments, trusted, &judged)?;
    }
    if arguments.replan {
        replan(path, &judged, arguments.report.format)?;
    }
    Ok(report(arguments, &judged))
}

/// Plans the program in a log again. The result must be the schedule in the log, with everything that the planner says
/// about it.
fn replan(path: &Path, judged: &Judged, format: ReportFormat) -> Result<(), Box<Refusal>> {
    let (schedule, Provenance { files, settings, .. }) = (judged.verified.schedule(), &judged.provenance);
    let (name, text) = &files[0];
    let options = options(&schedule.name, settings);
    let Derived { claims, sources } =
        derive(&ProgramSource { name, text, library: &Embedded(files), options: &options })?;
    let mut sink = Sink::default();
    let search = Arc::<SearchWatch>::default();
    let waiting = ProgressLine::begin(&search);
    let progress = &mut |index, count, task: &str| waiting.at(index, count, task);
    let replanned = search.over(|| compile::planned(&claims, &sources, &mut sink, progress));
    drop(waiting);
    let Some((_, replanned)) = replanned else {
        sink.push(errors::plans_nothing(path));
        return Err(Box::new(Refusal { sources, sink, exit: Exit::Refused }));
    };
    terminal::report(&sink, &sources, format);
    // Compared in the form that a log has, because a log omits what is only kept in memory.
    let [of_log, of_program] =
        [schedule, &replanned].map(|schedule| serde_json::to_vec(schedule).expect("all keys are texts"));
    match of_log == of_program {
        true => Ok(()),
        false => {
            let first = difference::first(&of_log, &of_program);
            Err(Refusal::one(errors::plans_another(path, first), Exit::Refused))
        }
    }
}

/// An accepted log.
pub struct Judged {
    /// The verified schedule.
    pub verified: Verified,
    pub provenance: Provenance,
    /// Version of the Tweeze that wrote it.
    version: String,
}

pub fn not_ours(version: &str) -> Box<Refusal> {
    Refusal::one(log::other_version(Some(version), None), Exit::Files)
}

/// Verifies a log on its own: it is intact, its program has the claims that it contains, its schedule keeps the claims,
/// and its messages show the schedule. Data are dropped as soon as they are no longer needed, because together
/// they may exceed the memory.
pub fn judge_bytes(path: &Path, bytes: &[u8]) -> Result<Judged, Box<Refusal>> {
    judge_log(path, bytes, log::read(bytes))
}

/// A log that breaks rules.
pub struct RefusedLog {
    pub schedule: Schedule,
    /// Claims and sources of the log's own program.
    pub derived: Derived,
    /// By time; at least one.
    pub violations: Vec<Violation>,
    pub provenance: Provenance,
}

/// The violations of a log's own claims; `None` if it was refused for another reason.
pub fn refused_bytes(path: &Path, bytes: &[u8]) -> Option<RefusedLog> {
    let Log { schedule, claims, files, settings, .. } = log::read(bytes).ok()?;
    let recorded = Embedding { name: &schedule.name, claims: &claims, files: &files, settings: &settings };
    let derived = own_claims(path, &recorded).ok()?;
    let violations = verify::violations(&schedule, &derived.claims).ok().filter(|list| !list.is_empty())?;
    Some(RefusedLog { schedule, derived, violations, provenance: Provenance { files, settings, is_recorded: true } })
}

/// As [`judge_bytes`], with the parsed log.
fn judge_log(path: &Path, bytes: &[u8], log: Result<Log, LogError>) -> Result<Judged, Box<Refusal>> {
    let log = log.map_err(|error| match error {
        LogError::NotALog => Refusal::one(errors::not_a_log(path), Exit::Files),
        error => Refusal::one(error.diagnostic(), Exit::Files),
    })?;
    let version = log.version.clone();
    // Another version may derive different claims from the same program, which is not a sign of editing.
    let of_its_version = |refusal| if version == env!("CARGO_PKG_VERSION") { refusal } else { not_ours(&version) };
    let recorded =
        Embedding { name: &log.schedule.name, claims: &log.claims, files: &log.files, settings: &log.settings };
    let own = own_claims(path, &recorded).map_err(of_its_version)?;
    if log.schedule.source != SourceRef::of(&own.sources) {
        return Err(of_its_version(Refusal::one(errors::parts_disagree(path, "the fingerprint"), Exit::Refused)));
    }
    let Log { schedule, claims, files, settings, series, version: _ } = log;
    drop(claims);
    let verified = replay(schedule, own)?;
    if let Some(fault) = log::series_fault(verified.schedule(), &series) {
        return Err(of_its_version(Refusal::one(fault.diagnostic(), Exit::Refused)));
    }
    drop(series);
    let provenance = Provenance { files, settings, is_recorded: true };
    match mcap::difference(bytes, &verified, &provenance) {
        Some(difference) => Err(of_its_version(Refusal::one(mcap::difference_diagnostic(&difference), Exit::Refused))),
        None => Ok(Judged { verified, provenance, version }),
    }
}

/// Claims of a program, with its sources for messages to point into.
pub struct Derived {
    pub claims: Claims,
    pub sources: Sources,
}

/// The program contained in a log or recording.
pub struct Embedding<'a> {
    /// Name of the task or program.
    pub name: &'a str,
    pub claims: &'a [u8],
    /// Name and text of each file, the program's own first; at least one.
    pub files: &'a [(String, String)],
    pub settings: &'a [String],
}

/// Derives the claims of the program in the log again; the claims in the log must agree.
pub fn own_claims(path: &Path, within: &Embedding) -> Result<Derived, Box<Refusal>> {
    let (name, text) = &within.files[0];
    let options = options(within.name, within.settings);
    let own = derive(&ProgramSource { name, text, library: &Embedded(within.files), options: &options });
    let own = own.map_err(|mut refusal| {
        refusal.sink.push(errors::program_in_log_has_errors(path));
        Box::new(Refusal { exit: Exit::Refused, ..*refusal })
    })?;
    match written(&own.claims) == within.claims {
        true => Ok(own),
        false => Err(Refusal::one(errors::parts_disagree(path, "a claim"), Exit::Refused)),
    }
}

/// Claims in the serialised form that is compared.
fn written(claims: &Claims) -> Vec<u8> {
    log::write_claims(claims).expect("all keys are texts")
}

/// Compiler options for the schedule of a name, with some settings.
fn options(name: &str, settings: &[String]) -> Options {
    Options { settings: settings.to_vec(), only: Some(name.to_owned()) }
}

/// Derives the claims of a program.
fn derive(program: &ProgramSource) -> Result<Derived, Box<Refusal>> {
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let checked = compile::check_program(program, &mut sources, &mut sink);
    let claims = checked.and_then(|checked| checked.claims.into_iter().next());
    match claims {
        Some(claims) => Ok(Derived { claims, sources }),
        None => Err(Box::new(Refusal { sources, sink, exit: Exit::Errors })),
    }
}

fn replay(schedule: Schedule, derived: Derived) -> Result<Verified, Box<Refusal>> {
    let mut sink = Sink::default();
    let accepted = verify::verify_program(schedule, &derived.claims, &derived.sources).into_verified(&mut sink);
    accepted.ok_or_else(|| Box::new(Refusal { sources: derived.sources, sink, exit: Exit::Refused }))
}

/// Refuses a log whose schedule breaks the claims of a trusted program.
fn keeps_the_claims_of(schedule: &Schedule, derived: &Derived) -> Result<(), Box<Refusal>> {
    let mut sink = Sink::default();
    match verify::violations(schedule, &derived.claims) {
        Ok(violations) if violations.is_empty() => return Ok(()),
        Ok(violations) => violations.into_iter().for_each(|violation| sink.push(violation.into())),
        Err(why) => sink.push(verify::inconclusive(&why)),
    }
    Err(Box::new(Refusal { sources: derived.sources.clone(), sink, exit: Exit::Refused }))
}

/// Checks the log against a trusted program.
fn against(arguments: &VerifyArguments, trusted: &Path, judged: &Judged) -> Result<(), Box<Refusal>> {
    let schedule = judged.verified.schedule();
    let own = written(judged.verified.claims());
    let derived = trusted_claims(arguments, trusted, &schedule.name, &judged.provenance.settings, &own)?;
    let same = claims_the_same(&arguments.file, LogOrigin::Build, trusted, &derived, &own);
    match (keeps_the_claims_of(schedule, &derived), same) {
        (Err(broken), Err(mut other)) => {
            other.sources = broken.sources;
            errors::first_of_each_rule(&broken.sink).into_iter().for_each(|broken| other.sink.push(broken));
            Err(other)
        }
        (Err(refusal), Ok(())) | (Ok(()), Err(refusal)) => Err(refusal),
        (Ok(()), Ok(())) => Ok(()),
    }
}

/// Claims of a trusted program, for a log with this name, these settings and claims. Nothing from the log reaches that
/// program: its settings are those of the command line. If the log has others, that is reported before any consequence
/// of it.
pub fn trusted_claims(
    arguments: &VerifyArguments,
    trusted: &Path,
    name: &str,
    settings: &[String],
    own: &[u8],
) -> Result<Derived, Box<Refusal>> {
    let text = disk::read_program(trusted).map_err(|error| Refusal::one(*error, Exit::Files))?;
    let disk = Disk::around(trusted);
    let file = disk.program_name();
    let options = options(name, &arguments.set);
    let unlike = errors::other_settings(&arguments.file, trusted, settings, &arguments.set);
    match (derive(&ProgramSource { name: &file, text: &text, library: &disk, options: &options }), unlike) {
        (Ok(derived), None) => Ok(derived),
        (Ok(derived), Some(unlike)) => match written(&derived.claims) == own {
            // The settings are equal to the program's own values.
            true => Ok(derived),
            false => Err(Refusal::one(unlike, Exit::Refused)),
        },
        (Err(mut refusal), unlike) => {
            unlike.into_iter().for_each(|unlike| refusal.sink.push(unlike));
            Err(refusal)
        }
    }
}

/// Refuses a log whose own program makes different claims from the trusted one.
pub fn claims_the_same(
    file: &Path,
    origin: LogOrigin,
    trusted: &Path,
    derived: &Derived,
    own: &[u8],
) -> Result<(), Box<Refusal>> {
    let claimed = written(&derived.claims);
    if own == claimed {
        return Ok(());
    }
    let first = difference::first(own, &claimed);
    Err(Refusal::one(errors::other_program(file, trusted, first, origin), Exit::Refused))
}

fn report(arguments: &VerifyArguments, judged: &Judged) -> String {
    let (schedule, settings) = (judged.verified.schedule(), &judged.provenance.settings);
    let file = arguments.file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let trusted = arguments.against.as_ref().map(|path| path.to_string_lossy().into_owned());
    let names: Vec<String> = [file.clone(), schedule.name.clone()].into_iter().chain(trusted.clone()).collect();
    if arguments.report.format == ReportFormat::Json {
        let log = arguments.file.to_string_lossy();
        let replanned = arguments.replan.then_some(&judged.verified);
        return format!("{}\n", report::json::verified(&log, schedule, settings, trusted.as_deref(), replanned));
    }
    let width = report::width(names.into_iter().chain(settings.iter().map(|setting| format!("--set {setting}"))));
    let program = terminal::name(&judged.provenance.files[0].0);
    let origin = format!("written by tweeze {} from {program}", judged.version);
    let mut text = terminal::line("Read", &file, width, &origin);
    text.push_str(&report::settings(settings, width));
    let replayed = format!("{} actuations replayed, 0 violations", schedule.actuations.len());
    text.push_str(&terminal::line("Verified", &schedule.name, width, &replayed));
    if let Some(trusted) = trusted {
        let with = if arguments.set.is_empty() { "" } else { " with the settings above" };
        let matches = format!("the log does what this program claims{with}");
        text.push_str(&terminal::line("Matches", &trusted, width, &matches));
    }
    match arguments.replan {
        true => text.push_str(&terminal::line("Replanned", &schedule.name, width, REPLANNED)),
        false => text.push_str(&terminal::line("Unchecked", &schedule.name, width, &unchecked_statements(schedule))),
    }
    text
}

const REPLANNED: &str =
    "planning the program again gives this plan, with its bounds, estimates, guarantees and remarks";

/// Statements of a log about its plans that no replay can check.
pub fn unchecked_statements(schedule: &Schedule) -> String {
    let optimal = schedule.plans.iter().filter(|plan| plan.optimal).count();
    let optima = match (optimal, schedule.plans.len()) {
        (0, _) => String::new(),
        (1, 1) => ", and that the plan is optimal".to_owned(),
        (optimal, plans) => format!(", and that {optimal} of {plans} plans are optimal"),
    };
    format!("the planner's bounds, estimates, guarantees and remarks{optima}: recorded but not derived again")
}
