//! The devices of a program, with all derived figures.

use super::{beds, hands};
use crate::check::Options;
use crate::check::devices::KindFacts;
use crate::claims::Claims;
use crate::cli::arguments::DevicesArguments;
use crate::cli::loaded::Loaded;
use crate::cli::{Exit, terminal};
use crate::compile;
use crate::device::dimibot::Side;
use crate::diagnostic::Sink;
use crate::quantity::{Dimension, Quantity};
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
    let checked = compile::check(&loaded.program(&loaded.disk()), &mut sources, &mut sink);
    terminal::report(&sink, &sources, arguments.report.format);
    let Some(checked) = checked else { return Exit::Errors };
    let devices: Vec<String> = checked.devices.iter().map(|(name, facts)| told(name, facts, &checked.claims)).collect();
    terminal::answer(&if devices.is_empty() {
        format!("{} declares no device\n", loaded.shown())
    } else {
        devices.join("\n")
    })
}

fn told(name: &str, facts: &KindFacts, claims: &[Claims]) -> String {
    match facts {
        KindFacts::Dimibot(facts) => {
            let [left, right] = Side::BOTH.map(|side| facts.modules(side));
            let [left_um, right_um] = Side::BOTH.map(|side| length(facts.pitch_um(side)));
            format!("{name}: dimibot, {left} modules of {left_um} left, {right} of {right_um} right\n")
        }
        KindFacts::ElectrodeArray(facts) => {
            let (columns, rows, pitch) = (facts.columns, facts.rows, length(facts.pitch_um()));
            format!("{name}: electrode_array, {columns} x {rows} electrodes {pitch} apart\n")
        }
        KindFacts::Microrobots(bed) => beds::told(name, bed),
        KindFacts::Fingers(facts) => hands::told(name, facts, claims),
    }
}

/// A length for people.
pub fn length(um: f64) -> String {
    Quantity::new(um / 1e6, Dimension::LENGTH).to_string()
}
