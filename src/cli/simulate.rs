//! `tweeze simulate`.

use super::arguments::SimulateArguments;
use super::devices::aligned;
use super::loaded::Loaded;
use super::{Exit, terminal};
use crate::check::Options;
use crate::claims::Job;
use crate::compile::{self, CompileRequest};
use crate::diagnostic::Sink;
use crate::plan::{self, Plan};
use crate::quantity::digits;
use crate::simulate::microrobots::{Dockings, FailureReason, Failures, SimulationReport, Spread};
use crate::simulate::simulate;
use crate::source::Sources;

/// Runs the assemblies of a program against robots and measurements with errors.
pub fn run(arguments: &SimulateArguments) -> Exit {
    let options = Options { settings: arguments.settings.set.clone(), only: arguments.task.clone() };
    let loaded = match Loaded::read(&arguments.file, options, &arguments.report) {
        Ok(loaded) => loaded,
        Err(exit) => return exit,
    };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let told = told(&loaded.program(&loaded.disk()), arguments, &mut sources, &mut sink);
    terminal::report(&sink, &sources, arguments.report.format);
    match told {
        None => Exit::Errors,
        Some(told) if told.is_empty() => {
            eprintln!("{} has no assembly on a device with all error bounds: nothing to simulate", loaded.shown());
            Exit::Usage
        }
        Some(told) => terminal::answer(&told.join("\n")),
    }
}

/// Outcomes of each assembly; `None` after an error.
fn told(
    program: &CompileRequest,
    arguments: &SimulateArguments,
    sources: &mut Sources,
    sink: &mut Sink,
) -> Option<Vec<String>> {
    let checked = compile::check(program, sources, sink)?;
    let mut told = Vec::new();
    let mut is_whole = true;
    for claims in &checked.claims {
        match plan::plan(claims, sink, &mut |_, _, _| ()) {
            Some(plans) => {
                told.extend(claims.jobs.iter().zip(&plans).filter_map(|(job, plan)| one(job, plan, arguments)))
            }
            None => is_whole = false,
        }
    }
    is_whole.then_some(told)
}

/// Outcomes of one assembly; `None` if there is none, or if the device does not bound its errors.
fn one(job: &Job, plan: &Plan, arguments: &SimulateArguments) -> Option<String> {
    let order = job.order.microrobots()?;
    let threads = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let (trials, seed) = (u64::from(arguments.trials), arguments.seed);
    let report = simulate(&job.order, &plan.motion, trials, seed, threads)?;
    let name = |robot: usize| order.robot(robot).name.clone();
    Some(format!("{}{}{}", summary(&job.task, seed, &report), dockings(&report, &name), failures(&report, &name)))
}

fn summary(task: &str, seed: u64, report: &SimulationReport) -> String {
    let percent = |share: f64| format!("{} %", digits((share * 1e4).round() / 100.0));
    let share = report.successes as f64 / report.trials.max(1) as f64;
    let [low, high] = report.wilson.map(percent);
    let counted = format!(
        "{} of {} trials succeeded: {}, between {low} and {high} with 95 % confidence (seed {seed})",
        report.successes,
        report.trials,
        percent(share)
    );
    let time = spread(report.time_s, 1.0);
    let line = terminal::line("Simulated", task, 0, &counted);
    if report.successes == 0 {
        return line;
    }
    format!(
        "{line}{}",
        terminal::line("", "", task.chars().count(), &format!("time of those: {time} s (mean, 95 %, longest)"))
    )
}

/// A row for each robot, each figure as its mean, the 95th percentile and the largest.
fn dockings(report: &SimulationReport, name: &impl Fn(usize) -> String) -> String {
    let heading = ["robot", "docked", "across [um]", "along [um]", "incidence [deg]", "heading [deg]"];
    let degrees = 180.0 / std::f64::consts::PI;
    let row = |docking: &Dockings| {
        let figures = [
            spread(docking.across_um, 1.0),
            spread(docking.along_um, 1.0),
            spread(docking.incidence_rad, degrees),
            spread(docking.heading_rad, degrees),
        ];
        [name(docking.robot), docking.count.to_string()].into_iter().chain(figures).collect()
    };
    let rows: Vec<Vec<String>> =
        std::iter::once(heading.map(str::to_owned).to_vec()).chain(report.dockings.iter().map(row)).collect();
    format!("\n  errors without their signs: mean, 95th percentile, largest\n{}", aligned(&rows))
}

fn failures(report: &SimulationReport, name: &impl Fn(usize) -> String) -> String {
    let line =
        |failure: &Failures| format!("  {} of {}: {}\n", failure.count, name(failure.robot), reason(&failure.reason));
    let lines: Vec<String> = report.failures.iter().map(line).collect();
    if lines.is_empty() { String::new() } else { format!("\n  failures\n{}", lines.concat()) }
}

fn reason(reason: &FailureReason) -> String {
    match reason {
        FailureReason::LeftCylinder => "it did not get to where the fine motion begins".to_owned(),
        FailureReason::MissedCone => "its goal was not within reach of the fine motion".to_owned(),
        FailureReason::Misplaced => "it docked too far from its place".to_owned(),
        FailureReason::Angle => "it met its structure at too large an angle".to_owned(),
        FailureReason::Collision(thing) => format!("it ran into {thing}"),
        FailureReason::TimeLimit => "it took too long".to_owned(),
    }
}

fn spread(spread: Spread, scale: f64) -> String {
    let figure = |value: f64| format!("{:.1}", value * scale);
    format!("{} / {} / {}", figure(spread.mean), figure(spread.p95), figure(spread.max))
}
