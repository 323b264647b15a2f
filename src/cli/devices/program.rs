//! The devices of a program, with all derived figures.

use crate::check::Options;
use crate::cli::arguments::DevicesArguments;
use crate::cli::loaded::Loaded;
use crate::cli::{Exit, report, terminal};
use crate::compile;
use crate::diagnostic::{Code, Sink};
use crate::source::Sources;
use std::path::Path;

/// Checks a program and reports each of its devices.
pub fn run(file: &Path, arguments: &DevicesArguments) -> Exit {
    let options = Options { settings: arguments.settings.set.clone(), only: None };
    let loaded = match Loaded::read(file, options, &arguments.report) {
        Ok(loaded) => loaded,
        Err(exit) => return exit,
    };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let checked = compile::check_program(&loaded.program(&loaded.disk()), &mut sources, &mut sink);
    // A file with devices only has nothing to build, which does not matter here.
    terminal::report(&sink.retained(|finding| finding.code != Code::W0503), &sources, arguments.report.format);
    let Some(checked) = checked else { return Exit::Errors };
    let devices: Vec<String> =
        checked.devices.iter().map(|(name, facts)| report::device(name, facts, &checked.claims)).collect();
    terminal::answer(&if devices.is_empty() {
        format!("{} declares no device\n", loaded.shown())
    } else {
        devices.join("\n")
    })
}
