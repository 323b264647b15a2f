//! `tweeze check`.

use super::arguments::CheckArguments;
use super::disk::{self, Disk};
use super::{Exit, terminal};
use crate::check::Options;
use crate::compile::{self, Program};
use crate::diagnostic::Sink;
use crate::source::Sources;
use std::path::Path;

/// Checks each file by itself; the gravest outcome is the answer.
pub fn run(arguments: &CheckArguments) -> Exit {
    let exits = arguments.files.iter().map(|file| one(file, arguments));
    exits.fold(Exit::Done, Exit::max)
}

fn one(file: &Path, arguments: &CheckArguments) -> Exit {
    let text = match disk::read_program(file) {
        Ok(text) => text,
        Err(diagnostic) => {
            terminal::report_one(*diagnostic, arguments.report.format);
            return Exit::Files;
        }
    };
    let options = Options { settings: arguments.settings.set.clone(), only: None };
    let name = file.to_string_lossy();
    let program = Program { name: &name, text: &text, library: &Disk, options: &options };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let checked = compile::check(&program, &mut sources, &mut sink);
    terminal::report(&sink, &sources, arguments.report.format);
    match checked {
        Some(checked) => {
            let line = terminal::line("Checked", &name, 0, &super::report::tally(checked.tally));
            terminal::answer(&line)
        }
        None => Exit::Errors,
    }
}
