//! `tweeze check`.

use super::arguments::{CheckArguments, CheckFormat, ReportFormat};
use super::loaded::Loaded;
use super::{Exit, report, terminal};
use crate::check::{DeclarationTally, Options};
use crate::compile;
use crate::diagnostic::{Sink, machine};
use crate::source::Sources;
use std::path::Path;

/// Checks each file separately; the exit status is the gravest one.
pub fn run(arguments: &CheckArguments) -> Exit {
    let mut exit = Exit::Done;
    let mut reports: Vec<(Sources, Sink)> = Vec::new();
    for file in &arguments.files {
        let (mut sources, mut sink) = (Sources::default(), Sink::default());
        let checked = one(file, arguments, &mut sources, &mut sink);
        match arguments.format.one_by_one() {
            Some(format) => terminal::report(&sink, &sources, format),
            None => reports.push((sources, sink)),
        }
        exit = exit.max(match checked {
            Ok(_) if arguments.quiet.is_quiet => Exit::Done,
            Ok((shown, tally)) => success(&shown, tally, arguments.format),
            Err(exit) => exit,
        });
    }
    if arguments.format == CheckFormat::Sarif {
        exit = exit.max(terminal::answer(&machine::sarif(&reports)));
    }
    exit
}

/// The name of a program and what it declares, or the exit status after an error.
fn one(
    file: &Path,
    arguments: &CheckArguments,
    sources: &mut Sources,
    sink: &mut Sink,
) -> Result<(String, DeclarationTally), Exit> {
    let options = Options { settings: arguments.settings.set.clone(), only: None };
    let loaded = Loaded::open(file, options).map_err(|diagnostic| {
        sink.push(*diagnostic);
        Exit::Files
    })?;
    let checked = compile::check(&loaded.program(&loaded.disk()), sources, sink);
    checked.map(|checked| (loaded.shown(), checked.tally)).ok_or(Exit::Errors)
}

fn success(shown: &str, tally: DeclarationTally, format: CheckFormat) -> Exit {
    match format.one_by_one() {
        Some(ReportFormat::Json) => terminal::answer(&format!("{}\n", report::json::checked(shown, tally))),
        Some(ReportFormat::Human | ReportFormat::Short | ReportFormat::Github) => {
            terminal::answer(&terminal::line("Checked", shown, 0, &report::tally(tally)))
        }
        None => Exit::Done,
    }
}
