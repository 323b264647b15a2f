//! `tweeze check`.

use super::arguments::CheckArguments;
use super::loaded::Loaded;
use super::{Exit, terminal};
use crate::check::Options;
use crate::compile;
use crate::diagnostic::Sink;
use crate::source::Sources;
use std::path::Path;

/// Checks each file separately; the exit status is the gravest one.
pub fn run(arguments: &CheckArguments) -> Exit {
    let exits = arguments.files.iter().map(|file| one(file, arguments));
    exits.fold(Exit::Done, Exit::max)
}

fn one(file: &Path, arguments: &CheckArguments) -> Exit {
    let options = Options { settings: arguments.settings.set.clone(), only: None };
    let loaded = match Loaded::read(file, options, &arguments.report) {
        Ok(loaded) => loaded,
        Err(exit) => return exit,
    };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let checked = compile::check(&loaded.program(&loaded.disk()), &mut sources, &mut sink);
    terminal::report(&sink, &sources, arguments.report.format);
    match checked {
        Some(checked) => {
            let line = terminal::line("Checked", &loaded.shown(), 0, &super::report::tally(checked.tally));
            terminal::answer(&line)
        }
        None => Exit::Errors,
    }
}
