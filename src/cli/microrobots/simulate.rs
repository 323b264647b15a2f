//! `tweeze simulate`.

use super::control;
use super::remote::{RemotePilot, RemoteTask};
use crate::check::Options;
use crate::claims::microrobots::MicrorobotsOrder;
use crate::claims::{Claims, Job};
use crate::cli::arguments::{ReportFormat, SimulateArguments};
use crate::cli::loaded::Loaded;
use crate::cli::{Exit, errors, terminal};
use crate::compile::{self, ProgramSource};
use crate::diagnostic::Sink;
use crate::plan::microrobots::simulation::{EndedTrial, SimulatedBed};
use crate::plan::parallel::processors;
use crate::plan::{self, Motion, Plan};
use crate::quantity::digits;
use crate::simulate::{
    ControlPhase, DockingStatistics, Failures, ShareSpread, SimulationReport, Spread, simulate_disturbed,
};
use crate::source::Sources;
use serde_json::{Value, json};
use std::io;
use std::path::Path;

/// Simulates the assemblies of a program with imperfect robots and measurements.
pub fn run(arguments: &SimulateArguments) -> Exit {
    if arguments.record.is_some() && arguments.trials != 1 {
        terminal::to_stderr("tweeze: `--record` records a single trial: add `--trials 1`\n");
        return Exit::Usage;
    }
    if let Some((path, error)) = arguments.record.as_deref().and_then(|path| Some((path, unrecordable(path)?))) {
        terminal::report_one(errors::not_recorded(path, &error), arguments.report.format);
        return Exit::Files;
    }
    let options = Options { settings: arguments.settings.set.clone(), only: arguments.task.clone() };
    let loaded = match Loaded::read(&arguments.file, options, &arguments.report) {
        Ok(loaded) => loaded,
        Err(exit) => return exit,
    };
    let (mut sources, mut sink) = (Sources::default(), Sink::default());
    let lines = simulated(&loaded.program(&loaded.disk()), arguments, &mut sources, &mut sink);
    terminal::report(&sink, &sources, arguments.report.format);
    let lines = match lines {
        Ok(lines) => lines,
        Err(NoTrials::NotControlled(why)) => return control::refused(&why),
        Err(NoTrials::Fault(why)) => return terminal::fault(&why),
    };
    match lines {
        None => Exit::Errors,
        Some(lines) if lines.is_empty() => {
            eprintln!("{} has no assembly on a device with all error bounds: nothing to simulate", loaded.shown());
            Exit::Usage
        }
        Some(lines) => terminal::answer(&lines.join("\n")),
    }
}

/// Why a path cannot be recorded to, as far as can be checked without writing; the controller creates the file.
fn unrecordable(path: &Path) -> Option<io::Error> {
    if path.symlink_metadata().is_ok() {
        return Some(io::ErrorKind::AlreadyExists.into());
    }
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty())?;
    folder.metadata().err()
}

/// Why there are no results.
enum NoTrials {
    /// The program is not one that a controller runs.
    NotControlled(String),
    /// A controller could not be reached.
    Fault(String),
}

/// Simulates each assembly; `None` after an error in the program.
fn simulated(
    program: &ProgramSource,
    arguments: &SimulateArguments,
    sources: &mut Sources,
    sink: &mut Sink,
) -> Result<Option<Vec<String>>, NoTrials> {
    let Some(checked) = compile::check_program(program, sources, sink) else { return Ok(None) };
    let mut lines = Vec::new();
    let mut is_whole = true;
    for claims in &checked.claims {
        match plan::plan(claims, sink, &mut |_, _, _| ()) {
            Some(plans) => {
                let jobs = claims.jobs.iter().zip(&plans);
                let outcomes = jobs.filter_map(|(job, plan)| one(claims, job, plan, arguments, sources));
                lines.extend(outcomes.collect::<Result<Vec<String>, NoTrials>>()?);
            }
            None => is_whole = false,
        }
    }
    Ok(is_whole.then_some(lines))
}

/// Simulates one assembly; `None` if the job is not an assembly or the device has no error bounds.
fn one(
    claims: &Claims,
    job: &Job,
    plan: &Plan<Motion>,
    arguments: &SimulateArguments,
    sources: &Sources,
) -> Option<Result<String, NoTrials>> {
    let (trials, seed) = (u64::from(arguments.trials), arguments.seed);
    let report = match arguments.against_controller {
        false => simulate_disturbed(&plan.motion, arguments.disturbances(), trials, seed, processors()).map(Ok),
        true => against(claims, job, plan, arguments),
    };
    let report = match report? {
        Ok(report) => report,
        Err(why) => return Some(Err(why)),
    };
    let line = |step: usize| step_line(job, step, sources);
    if arguments.report.format == ReportFormat::Json {
        return Some(Ok(json(&job.task, seed, &report, &line).to_string()));
    }
    Some(Ok(format!("{}{}{}", summary(&job.task, seed, &report), dockings(&report), failures(&report, &line))))
}

/// Runs the trials against controllers in other processes, one process per trial.
fn against(
    claims: &Claims,
    job: &Job,
    plan: &Plan<Motion>,
    arguments: &SimulateArguments,
) -> Option<Result<SimulationReport, NoTrials>> {
    let (Motion::Microrobots(planned), Some(order)) = (&plan.motion, MicrorobotsOrder::of(&job.order)) else {
        return None;
    };
    let bed = SimulatedBed::new(order, &planned.motion, arguments.disturbances())?;
    if let Err(why) = control::controlled_bed(claims) {
        return Some(Err(NoTrials::NotControlled(why)));
    }
    let task = RemoteTask {
        file: &arguments.file,
        task: &claims.name,
        settings: &arguments.settings.set,
        record: arguments.record.as_deref(),
    };
    let trial = |index: u64| {
        let mut pilot = RemotePilot::start(order, &task)?;
        Ok(bed.trial(arguments.seed, index, &mut pilot))
    };
    let trials: Result<Vec<EndedTrial>, String> = (0..u64::from(arguments.trials)).map(trial).collect();
    Some(trials.map(|trials| bed.report(&trials)).map_err(NoTrials::Fault))
}

/// Line of a step in the program's text, from 1.
fn step_line(job: &Job, step: usize, sources: &Sources) -> Option<u32> {
    let order = MicrorobotsOrder::of(&job.order)?;
    order.steps.get(step).map(|step| sources.position(step.span).line)
}

/// The report as a JSON object.
fn json(task: &str, seed: u64, report: &SimulationReport, line: &dyn Fn(usize) -> Option<u32>) -> Value {
    let name = |robot: usize| report.names[robot].as_str();
    let docking = |docking: &DockingStatistics| {
        json!({
            "robot": name(docking.robot), "count": docking.count, "across_um": docking.across_um,
            "along_um": docking.along_um, "incidence_rad": docking.incidence_rad, "heading_rad": docking.heading_rad,
        })
    };
    let failure = |failure: &Failures| {
        json!({
            "robot": name(failure.robot), "reason": failure.reason, "phase": failure.phase, "step": failure.step,
            "line": line(failure.step), "count": failure.count,
        })
    };
    json!({
        "simulated": task,
        "seed": seed,
        "trials": report.trials,
        "successes": report.successes,
        "confidence_95": report.wilson,
        "time_s": report.time_s,
        "area_in_place": report.area_in_place,
        "area_of_shape": report.area_of_shape,
        "dockings": report.dockings.iter().map(docking).collect::<Vec<_>>(),
        "failures": report.failures.iter().map(failure).collect::<Vec<_>>(),
    })
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
    let share = |share: f64| format!("{:.1}", share * 100.0);
    let area = |area: ShareSpread| format!("{} / {} / {} %", share(area.mean), share(area.p5), share(area.min));
    let area = format!(
        "covered area of the goal: {}, as a shape {} (mean, 5 %, least)",
        area(report.area_in_place),
        area(report.area_of_shape)
    );
    let below = |text: &str| terminal::line("", "", task.chars().count(), text);
    format!("{line}{}{}", below(&format!("time of these: {time} s (mean, 95 %, longest)")), below(&area))
}

/// A row for each robot; each figure as its mean, 95th percentile and maximum.
fn dockings(report: &SimulationReport) -> String {
    let heading = ["robot", "docked", "across [um]", "along [um]", "incidence [deg]", "heading [deg]"];
    let degrees = 180.0 / std::f64::consts::PI;
    let row = |docking: &DockingStatistics| {
        let figures = [
            spread(docking.across_um, 1.0),
            spread(docking.along_um, 1.0),
            spread(docking.incidence_rad, degrees),
            spread(docking.heading_rad, degrees),
        ];
        [report.names[docking.robot].clone(), docking.count.to_string()].into_iter().chain(figures).collect()
    };
    let rows: Vec<Vec<String>> =
        std::iter::once(heading.map(str::to_owned).to_vec()).chain(report.dockings.iter().map(row)).collect();
    format!("\n  absolute errors: mean, 95th percentile, largest\n{}", terminal::aligned(&rows))
}

fn failures(report: &SimulationReport, line: &dyn Fn(usize) -> Option<u32>) -> String {
    let row = |failure: &Failures| {
        let line = line(failure.step).map(|line| format!(", line {line}")).unwrap_or_default();
        let (robot, reason) = (&report.names[failure.robot], failure.reason.clause());
        format!("  {} of {robot}{line}, {}: {reason}\n", failure.count, phase(failure.phase))
    };
    let lines: Vec<String> = report.failures.iter().map(row).collect();
    if lines.is_empty() { String::new() } else { format!("\n  failures\n{}", lines.concat()) }
}

fn phase(phase: ControlPhase) -> &'static str {
    match phase {
        ControlPhase::Legs => "in the legs of the program",
        ControlPhase::Wait => "while the bed waits",
        ControlPhase::Approach => "on its way",
        ControlPhase::Timing => "before it is synchronised with its partner",
        ControlPhase::Meeting => "on its way to its partner",
        ControlPhase::Fine => "in fine motion",
        ControlPhase::Contact => "at contact",
        ControlPhase::Over => "at the end",
    }
}

fn spread(spread: Spread, scale: f64) -> String {
    let figure = |value: f64| format!("{:.1}", value * scale);
    format!("{} / {} / {}", figure(spread.mean), figure(spread.p95), figure(spread.max))
}
