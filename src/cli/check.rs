//! `tweeze check`.

use super::arguments::{CheckArguments, CheckFormat, ReportFormat};
use super::file_snapshots::FileSnapshots;
use super::loaded::Loaded;
use super::report::{Detail, LiveReport, ReportedBuild};
use super::{Exit, build, disk, report, terminal, watch};
use crate::check::{Checked, DeclarationTally, Options};
use crate::compile::{self, CompileOutcome, ProgramSource};
use crate::diagnostic::{Sink, machine};
use crate::source::Sources;
use crate::verify::Verified;
use std::collections::BTreeSet;
use std::path::Path;

/// Checks each file separately; returns the gravest exit status.
pub fn run(arguments: &CheckArguments) -> Exit {
    if !arguments.watch {
        return check(arguments, &mut FileSnapshots::default());
    }
    if arguments.files.iter().any(|file| disk::is_standard_input(file)) {
        return build::misused(
            "check",
            "standard input contains one program, which does not change: --watch needs a file",
        );
    }
    watch::watch(&arguments.files, arguments.quiet, |needed| check(arguments, needed))
}

/// Checks each program; adds the files that they need to `needed`.
fn check(arguments: &CheckArguments, needed: &mut FileSnapshots) -> Exit {
    let mut exit = Exit::Done;
    let mut reports: Vec<(Sources, Sink)> = Vec::new();
    for file in &arguments.files {
        let (mut sources, mut sink) = (Sources::default(), Sink::default());
        let checked = one(file, needed, arguments, &mut sources, &mut sink);
        match arguments.format.one_by_one() {
            Some(format) => terminal::report(&sink, &sources, format),
            None => reports.push((sources, sink)),
        }
        exit = exit.max(match checked {
            Ok(_) if arguments.quiet.is_quiet => Exit::Done,
            Ok(checked) => success(&checked, arguments),
            Err(exit) => exit,
        });
    }
    if arguments.format == CheckFormat::Sarif {
        exit = exit.max(terminal::answer(&machine::sarif(&reports)));
    }
    exit
}

/// A program without errors.
struct CheckedProgram {
    /// Name in messages.
    shown: String,
    tally: DeclarationTally,
    /// `None` unless requested.
    schedules: Option<Vec<Verified>>,
    /// Exit status of printing the lines of its plans.
    exit: Exit,
}

/// Checks one program; the error is the exit status after its diagnostics were reported. Adds the files that it needs
/// to `needed`.
fn one(
    file: &Path,
    needed: &mut FileSnapshots,
    arguments: &CheckArguments,
    sources: &mut Sources,
    sink: &mut Sink,
) -> Result<CheckedProgram, Exit> {
    let options = Options { settings: arguments.settings.set.clone(), only: None };
    let loaded = Loaded::open(file, options).map_err(|diagnostic| {
        sink.push(*diagnostic);
        Exit::Files
    })?;
    let (disk, shown) = (loaded.disk(), loaded.shown());
    let program = loaded.program(&disk);
    let checked = match arguments.plan {
        true => planned(&loaded, &program, arguments, sources, sink),
        false => match compile::check_program(&program, sources, sink) {
            Some(Checked { tally, .. }) => Ok(CheckedProgram { shown, tally, schedules: None, exit: Exit::Done }),
            None => Err(Exit::Errors),
        },
    };
    needed.add(disk.asked());
    checked
}

/// As `one`, with a verified plan for each schedule; reports both as planning proceeds.
fn planned(
    loaded: &Loaded,
    program: &ProgramSource,
    arguments: &CheckArguments,
    sources: &mut Sources,
    sink: &mut Sink,
) -> Result<CheckedProgram, Exit> {
    let has_lines = arguments.format.one_by_one().is_some_and(|format| format != ReportFormat::Json);
    let formats = BTreeSet::new();
    let mut live = LiveReport::begin(ReportedBuild {
        program: loaded.path(),
        settings: &loaded.options.settings,
        output: Path::new(""),
        formats: &formats,
        is_printed: has_lines && !arguments.quiet.is_quiet,
        detail: Detail::Usual,
    });
    let outcome = live.search().over(|| compile::compile(program, sources, sink, &mut live));
    let exit = live.end();
    match outcome {
        CompileOutcome::Compiled(compiled) => Ok(CheckedProgram {
            shown: loaded.shown(),
            tally: compiled.tally,
            schedules: Some(compiled.schedules),
            exit,
        }),
        CompileOutcome::Errors => Err(Exit::Errors),
        CompileOutcome::Refused => Err(Exit::Refused),
    }
}

fn success(checked: &CheckedProgram, arguments: &CheckArguments) -> Exit {
    let CheckedProgram { shown, tally, schedules, exit } = checked;
    match (arguments.format.one_by_one(), schedules) {
        (Some(ReportFormat::Json), _) => {
            terminal::answer(&format!("{}\n", report::json::checked(shown, *tally, schedules.as_deref())))
        }
        // The lines have been printed already.
        (Some(ReportFormat::Human | ReportFormat::Short | ReportFormat::Github), Some(_)) => *exit,
        (Some(ReportFormat::Human | ReportFormat::Short | ReportFormat::Github), None) => {
            terminal::answer(&terminal::line("Checked", shown, 0, &report::tally(*tally)))
        }
        (None, _) => Exit::Done,
    }
}
