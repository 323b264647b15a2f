//! `tweeze build`.

use super::arguments::BuildArguments;
use super::disk::{self, Disk};
use super::waiting::Waiting;
use super::{Exit, terminal};
use crate::check::claims::Claims;
use crate::check::claims::dimibot::{Action, Asked, Stop};
use crate::check::{Options, Tally};
use crate::compile::{self, Compiled, Outcome, Program};
use crate::device::dimibot::{Cell, Side};
use crate::diagnostic::Sink;
use crate::emit::{self, Format, OutputFile, Provenance};
use crate::quantity::{Dimension, Quantity, digits};
use crate::schedule::{PlanRecord, Schedule, State, TimedState};
use crate::source::Sources;
use crate::verify::Verified;
use std::collections::BTreeSet;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

/// Runs of one schedule that the report shows; the rest is counted.
const MAX_PLAN_LINES: usize = 20;

/// Builds a program and writes the whole set of its files, or nothing.
pub fn run(arguments: &BuildArguments) -> Exit {
    let format = arguments.report.format;
    let text = match disk::read_program(&arguments.file) {
        Ok(text) => text,
        Err(diagnostic) => {
            terminal::report_one(*diagnostic, format);
            return Exit::Files;
        }
    };
    let options = Options { settings: arguments.settings.set.clone(), only: arguments.task.clone() };
    let name = arguments.file.to_string_lossy();
    let program = Program { name: &name, text: &text, library: &Disk, options: &options };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let waiting = Waiting::begin();
    let outcome =
        compile::compile(&program, &mut sources, &mut sink, &mut |index, count, task| waiting.at(index, count, task));
    drop(waiting);
    terminal::report(&sink, &sources, format);
    match outcome {
        Outcome::Errors => Exit::Errors,
        Outcome::Refused => Exit::Refused,
        Outcome::Compiled(compiled) => write(arguments, &compiled, &provenance(&sources, &options)),
    }
}

/// The user's files of a program; the standard library comes with the compiler, and settings are no files.
pub fn provenance(sources: &Sources, options: &Options) -> Provenance {
    let is_own = |name: &str| !name.starts_with("std.") && !name.starts_with("--set ");
    let own = sources.files().filter(|(_, file)| is_own(&file.name));
    let files = own.map(|(_, file)| (file.name.clone(), file.text.to_string())).collect();
    Provenance { files, settings: options.settings.clone() }
}

fn write(arguments: &BuildArguments, compiled: &Compiled, provenance: &Provenance) -> Exit {
    let formats: BTreeSet<Format> = arguments.emit.iter().copied().collect();
    let mut files: Vec<OutputFile> = Vec::new();
    let mut written: Vec<Vec<String>> = Vec::new();
    for verified in &compiled.schedules {
        let mut names = Vec::new();
        for format in &formats {
            match emit::emit(*format, verified, provenance) {
                Ok(set) => {
                    names.extend(set.iter().map(|file| shown(&arguments.output, &file.name)));
                    files.extend(set);
                }
                Err(error) => {
                    terminal::report_one(error.diagnostic(), arguments.report.format);
                    return Exit::Errors;
                }
            }
        }
        written.push(names);
    }
    if let Err(diagnostic) = disk::write_all(&arguments.output, &files) {
        terminal::report_one(*diagnostic, arguments.report.format);
        return Exit::Files;
    }
    terminal::answer(&report(arguments, compiled, &written))
}

/// Where a file stands, as the user would write it.
fn shown(folder: &Path, name: &str) -> String {
    let path = if folder == Path::new(".") { PathBuf::from(name) } else { folder.join(name) };
    path.to_string_lossy().into_owned()
}

/// What was done, line by line.
fn report(arguments: &BuildArguments, compiled: &Compiled, written: &[Vec<String>]) -> String {
    let file = arguments.file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let paths = written.iter().flatten().cloned();
    let subjects = compiled.schedules.iter().flat_map(subjects).chain(paths).chain([file.clone()]);
    let width = subjects.map(|subject| subject.chars().count()).max().unwrap_or(0);
    let mut text = terminal::line("Checked", &file, width, &tally(compiled.tally));
    for verified in &compiled.schedules {
        planned(verified, width, &mut text);
    }
    for verified in &compiled.schedules {
        let schedule = verified.schedule();
        let replayed = format!("{} replayed, 0 violations", count(schedule.actuations.len(), "actuation"));
        text.push_str(&terminal::line("Verified", &schedule.name, width, &replayed));
    }
    for (verified, paths) in compiled.schedules.iter().zip(written) {
        let mut figures = figures(verified.schedule());
        for path in paths {
            text.push_str(&terminal::line("Wrote", path, width, &figures));
            figures.clear();
        }
    }
    text
}

/// The names that the lines of a schedule begin with: its runs, where they are not all of it, with its own name before.
fn subjects(verified: &Verified) -> Vec<String> {
    let schedule = verified.schedule();
    let subject = |plan: &PlanRecord| match plan.task == schedule.name {
        true => plan.task.clone(),
        false => format!("{}: {}", schedule.name, plan.task),
    };
    schedule.plans.iter().take(MAX_PLAN_LINES).map(subject).collect()
}

fn planned(verified: &Verified, width: usize, text: &mut String) {
    let (schedule, claims) = (verified.schedule(), verified.claims());
    for ((plan, job), subject) in schedule.plans.iter().zip(&claims.jobs).zip(subjects(verified)) {
        let Some(order) = job.order.dimibot() else { continue };
        let pitches = Side::BOTH.map(|side| order.facts.pitch_um(side));
        let cell_um = (pitches[0] == pitches[1]).then_some(pitches[0]);
        text.push_str(&terminal::line("Planned", &subject, width, &cost(plan, cell_um)));
    }
    let more = schedule.plans.len().saturating_sub(MAX_PLAN_LINES);
    if more > 0 {
        text.push_str(&terminal::line("", "", width, &format!("and {} more", count(more, "run"))));
    }
    for line in orders(schedule, claims) {
        text.push_str(&terminal::line("Visits", "", width, &line));
    }
    for line in nearest(claims) {
        text.push_str(&terminal::line("Nearest", "", width, &line));
    }
}

/// In which order each `visit` comes to its places.
fn orders(schedule: &Schedule, claims: &Claims) -> Vec<String> {
    let mut lines = Vec::new();
    for (index, (plan, job)) in schedule.plans.iter().zip(&claims.jobs).enumerate() {
        let Some(order) = job.order.dimibot() else { continue };
        let steps = schedule.steps.iter().filter(|step| step.plan as usize == index);
        for (step, claim) in steps.zip(&order.steps) {
            if let Action::Visit(stops) = &claim.action {
                lines.push(visited(stops, &plan.states, step.start_ns..=step.start_ns + step.duration_ns));
            }
        }
    }
    lines.truncate(MAX_PLAN_LINES);
    lines
}

/// The stops in the order in which states of a stretch of time first stand at them.
fn visited(stops: &[Stop], states: &[TimedState], during: RangeInclusive<u64>) -> String {
    // The state in which the stretch begins may be older than it.
    let before = states.iter().rev().find(|state| state.t_ns <= *during.start());
    let within = states.iter().filter(|state| during.contains(&state.t_ns));
    let mut order: Vec<Cell> = Vec::new();
    for state in before.into_iter().chain(within) {
        let State::Dimibot { cell: [x, y], .. } = state.state else { continue };
        let cell = Cell::new(x, y);
        if stops.iter().any(|stop| stop.cell == cell) && !order.contains(&cell) {
            order.push(cell);
        }
    }
    order.iter().map(Cell::to_string).collect::<Vec<_>>().join(" → ")
}

/// `29.88 um (70 r) in 9 switches, optimal (bound 29.88 um)`; in cells only where they are squares.
fn cost(plan: &PlanRecord, cell_um: Option<f64>) -> String {
    let figure = |value: f64| match plan.unit.as_str() {
        "" => digits(value),
        unit => format!("{} {unit}", rounded(value)),
    };
    let switches = plan.outcomes.get("switches").copied().unwrap_or_default();
    let cells = match cell_um {
        Some(cell_um) if plan.objective == "distance" => format!(" ({} r)", (plan.cost / cell_um).round()),
        _ => String::new(),
    };
    let proof = match plan.optimal {
        true => format!("optimal (bound {})", figure(plan.bound)),
        false => format!("not proven optimal (bound {})", figure(plan.bound)),
    };
    let switches = count(switches as usize, "switch");
    match plan.objective.as_str() {
        "switches" => format!("{switches}, {proof}"),
        _ => format!("{}{cells} in {switches}, {proof}", figure(plan.cost)),
    }
}

/// A figure for the report: two decimals, more where the value is small.
fn rounded(value: f64) -> String {
    if value.abs() >= 1.0 { digits((value * 100.0).round() / 100.0) } else { digits(value) }
}

/// How far the cells that were taken for places lie from them.
fn nearest(claims: &Claims) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for job in &claims.jobs {
        let Some(order) = job.order.dimibot() else { continue };
        let stops = order.steps.iter().flat_map(|step| match &step.action {
            Action::Move(stops) | Action::Visit(stops) => stops.as_slice(),
            Action::Wait(_) => &[],
        });
        for stop in stops {
            let Asked::Place([x_um, y_um]) = stop.asked else { continue };
            let [cell_x_um, cell_y_um] = order.facts.place_um(stop.cell);
            let off = length((cell_x_um - x_um).hypot(cell_y_um - y_um));
            let line = format!("({}, {}) is cell {}, {off} off", length(x_um), length(y_um), stop.cell);
            if !lines.contains(&line) && lines.len() < MAX_PLAN_LINES {
                lines.push(line);
            }
        }
    }
    lines
}

fn length(um: f64) -> String {
    let rounded = (um * 1e4).round() / 1e4;
    Quantity::new(rounded / 1e6, Dimension::LENGTH).to_string()
}

/// `20 channels, 9 actuations, 135 ms, 270 mJ`.
fn figures(schedule: &Schedule) -> String {
    let energy_j: f64 = schedule.plans.iter().filter_map(|plan| plan.outcomes.get("energy")).sum();
    format!(
        "{}, {}, {}, {}",
        count(schedule.channels.len(), "channel"),
        count(schedule.actuations.len(), "actuation"),
        Quantity::new(schedule.duration_ns as f64 / 1e9, Dimension::TIME),
        Quantity::new(energy_j, Dimension::ENERGY),
    )
}

/// `1 device, 1 scene, 2 tasks`.
pub fn tally(tally: Tally) -> String {
    let parts =
        [(tally.devices, "device"), (tally.scenes, "scene"), (tally.tasks, "task"), (tally.programs, "program")];
    let parts: Vec<String> = parts.into_iter().filter(|part| part.0 > 0).map(|(n, noun)| count(n, noun)).collect();
    if parts.is_empty() { "nothing declared".to_owned() } else { parts.join(", ") }
}

fn count(number: usize, noun: &str) -> String {
    let plural = if noun.ends_with("ch") { "es" } else { "s" };
    format!("{number} {noun}{}", if number == 1 { "" } else { plural })
}
