//! `tweeze fmt`.

use super::arguments::{FmtArguments, ReportFormat};
use super::{Exit, disk, errors, terminal};
use crate::diagnostic::{Diagnosed, Diagnostic, Sink};
use crate::format;
use crate::source::Sources;
use serde_json::json;
use similar::TextDiff;
use std::path::{Path, PathBuf};

/// Formats each program; returns the gravest exit status.
pub fn run(arguments: &FmtArguments) -> Exit {
    let mut exit = Exit::Done;
    for argument in &arguments.files {
        match programs(argument) {
            Ok(files) => exit = files.iter().map(|file| one(file, arguments)).fold(exit, Exit::max),
            Err(diagnostic) => exit = exit.max(unreadable(*diagnostic, arguments)),
        }
    }
    exit
}

fn unreadable(diagnostic: Diagnostic, arguments: &FmtArguments) -> Exit {
    terminal::report_one(diagnostic, arguments.report.format);
    Exit::Files
}

/// The files that an argument stands for.
fn programs(argument: &Path) -> Diagnosed<Vec<PathBuf>> {
    if !argument.is_dir() {
        return Ok(vec![argument.to_owned()]);
    }
    let files = disk::programs_in(argument)?;
    if files.is_empty() { Err(Box::new(errors::nothing_to_format(argument))) } else { Ok(files) }
}

fn one(file: &Path, arguments: &FmtArguments) -> Exit {
    let is_input = disk::is_standard_input(file);
    let (path, text) = match disk::read_argument(file) {
        Ok(read) => read,
        Err(diagnostic) => return unreadable(*diagnostic, arguments),
    };
    let name = path.to_string_lossy();
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let id = sources.add(&*name, text.as_str());
    let formatted = format::format(id, &text, &mut sink);
    terminal::report(&sink, &sources, arguments.report.format);
    let exit = if sink.errors() > 0 { Exit::Errors } else { Exit::Done };
    let writes = !arguments.check && !arguments.diff;
    if writes && is_input {
        return exit.max(terminal::answer(&formatted));
    }
    if formatted == text {
        return exit;
    }
    let is_json = arguments.report.format == ReportFormat::Json;
    let answered = match (arguments.diff, arguments.check) {
        (true, _) => terminal::answer(&difference(&name, &text, &formatted)),
        (false, true) => terminal::answer(&match is_json {
            true => format!("{}\n", json!({ "not_canonical": name })),
            false => format!("{}\n", terminal::name(&name)),
        }),
        (false, false) => match disk::replace(file, &formatted) {
            Ok(()) => terminal::answer(&match is_json {
                true => format!("{}\n", json!({ "formatted": name })),
                false => terminal::line("Formatted", &name, 0, ""),
            }),
            Err(diagnostic) => unreadable(*diagnostic, arguments),
        },
    };
    let status = if arguments.check { Exit::Errors } else { Exit::Done };
    exit.max(answered).max(status)
}

/// Unified diff of the changes.
fn difference(name: &str, before: &str, after: &str) -> String {
    let name = terminal::name(name);
    TextDiff::from_lines(before, after).unified_diff().header(&name, &format!("{name} (canonical)")).to_string()
}
