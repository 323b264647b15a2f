//! `tweeze view`: the page of a program or a log, in the browser.

use super::arguments::{BuildArguments, QuietArgument, ReportFormat, ViewArguments};
use super::disk::{self, Destination, MAX_LOG_BYTES};
use super::failed::{self, FailedBuild};
use super::file_snapshots::FileSnapshots;
use super::formats::EmitChoice;
use super::verify::{Refusal, RefusedLog};
use super::{Exit, build, errors, report, terminal, verify, watch};
use crate::emit::{self, Format, Provenance, RefusedSchedule};
use std::path::{Path, PathBuf};

/// Writes the pages of a program, or the page of a log once it is verified, and opens them.
pub fn run(arguments: &ViewArguments) -> Exit {
    let has_ending = |ending| arguments.file.extension().is_some_and(|own| own.eq_ignore_ascii_case(ending));
    if has_ending("json") {
        terminal::report_one(errors::no_program_to_show(&arguments.file), arguments.report.format);
        return Exit::Files;
    }
    let is_log = has_ending("mcap");
    if !arguments.watch {
        let written = match is_log {
            true => of_log(arguments),
            false => of_program(arguments, &mut FileSnapshots::default()),
        };
        return shown(arguments, !arguments.no_open, written);
    }
    if is_log || disk::is_standard_input(&arguments.file) {
        return build::misused("view", "a log or standard input does not change: --watch needs a program file");
    }
    let mut opens = !arguments.no_open;
    let quiet = QuietArgument { is_quiet: false };
    watch::watch(std::slice::from_ref(&arguments.file), quiet, |needed| {
        shown(arguments, std::mem::take(&mut opens), of_program(arguments, needed))
    })
}

/// Reports the files written and opens the pages.
fn shown(arguments: &ViewArguments, opens: bool, written: Result<WrittenPages, FailedBuild>) -> Exit {
    let (exit, pages) = match written {
        Ok(written) => written,
        Err(FailedBuild { exit, page }) => {
            failed::tell(&arguments.file, page.as_deref(), &build_arguments(arguments));
            (exit, page.into_iter().collect())
        }
    };
    if opens {
        pages.iter().for_each(|page| open(page));
    }
    exit
}

/// The exit status of the report, and the paths of the pages.
type WrittenPages = (Exit, Vec<PathBuf>);

fn of_program(arguments: &ViewArguments, needed: &mut FileSnapshots) -> Result<WrittenPages, FailedBuild> {
    build::built(&arguments.file, &build_arguments(arguments), needed).map(|built| (built.exit, built.files))
}

fn build_arguments(arguments: &ViewArguments) -> BuildArguments {
    BuildArguments {
        files: Vec::new(),
        task: arguments.task.clone(),
        emit: vec![EmitChoice::One(Format::Html)],
        keep_best: false,
        at: None,
        watch: arguments.watch,
        output: arguments.output.clone(),
        force: arguments.force,
        verbose: false,
        settings: arguments.settings.clone(),
        quiet: QuietArgument { is_quiet: false },
        report: arguments.report.clone(),
    }
}

fn of_log(arguments: &ViewArguments) -> Result<WrittenPages, FailedBuild> {
    let (path, format) = (&arguments.file, arguments.report.format);
    let files = |error: Box<crate::diagnostic::Diagnostic>| {
        terminal::report_one(*error, format);
        Exit::Files
    };
    disk::settle(path).map_err(files)?;
    let bytes = disk::read_bytes(path, MAX_LOG_BYTES).map_err(files)?;
    let judged = verify::judge_bytes(path, &bytes).map_err(|refusal| of_refused_log(arguments, &bytes, &refusal))?;
    let pages = emit::emit(Format::Html, &judged.verified, &judged.provenance).map_err(|error| {
        terminal::report_one(error.diagnostic(), format);
        Exit::Errors
    })?;
    let inputs = FileSnapshots::of([path]);
    let to = destination(arguments, &judged.provenance, &inputs);
    let pages = failed::put(&pages, &to, format)?;
    let schedule = judged.verified.schedule();
    let names: Vec<String> = pages.iter().map(|page| page.to_string_lossy().into_owned()).collect();
    if format == ReportFormat::Json {
        let log = path.to_string_lossy();
        let verified = report::json::verified(&log, schedule, &judged.provenance.settings, None, None);
        return Ok((terminal::answer(&format!("{verified}\n")), pages));
    }
    let width = report::width(names.iter().cloned().chain([schedule.name.clone()]));
    let replayed = format!("{} actuations replayed, 0 violations", schedule.actuations.len());
    let mut text = terminal::line("Verified", &schedule.name, width, &replayed);
    text.push_str(&terminal::line("Unchecked", &schedule.name, width, &verify::unchecked_statements(schedule)));
    names.iter().for_each(|name| text.push_str(&terminal::line("Wrote", name, width, "")));
    Ok((terminal::answer(&text), pages))
}

/// Destination of the page of a log.
fn destination<'a>(
    arguments: &'a ViewArguments,
    provenance: &'a Provenance,
    inputs: &'a FileSnapshots,
) -> Destination<'a> {
    let logged = provenance.files.first().map(|(name, _)| name.as_str());
    Destination { folder: &arguments.output, program: &arguments.file, logged, force: arguments.force, inputs }
}

/// Writes the page of a refused log, if it was refused for breaking rules.
fn of_refused_log(arguments: &ViewArguments, bytes: &[u8], refusal: &Refusal) -> FailedBuild {
    let (path, format) = (&arguments.file, arguments.report.format);
    let exit = refusal.report(format);
    let Some(RefusedLog { schedule, derived, violations, provenance }) = verify::refused_bytes(path, bytes) else {
        return exit.into();
    };
    let is_whole = crate::verify::is_consistent(&schedule, &derived.claims);
    let refused = RefusedSchedule::new(&schedule, is_whole, &derived.claims, violations, &derived.sources);
    let page = match emit::refused_page(&failed::stem(path), &refused, &provenance) {
        Ok(page) => page,
        Err(error) => {
            terminal::report_one(error.diagnostic(), format);
            return exit.into();
        }
    };
    let inputs = FileSnapshots::of([path]);
    let to = destination(arguments, &provenance, &inputs);
    match failed::put(&[page], &to, format) {
        Ok(mut names) => FailedBuild { exit, page: names.pop() },
        Err(exit) => exit.into(),
    }
}

/// Opens a page in the browser; if no browser starts, asks the user to open it.
fn open(page: &Path) {
    if open::that_detached(page).is_err() {
        terminal::to_stderr(&format!("no browser could be started: open `{}` yourself\n", page.display()));
    }
}
