//! `tweeze verify` for the recording of a controlled run.

use crate::cli::arguments::{ReportFormat, VerifyArguments};
use crate::cli::errors::LogOrigin;
use crate::cli::verify::{Derived, Embedding, Refusal, claims_the_same, not_ours, own_claims, trusted_claims};
use crate::cli::{Exit, errors, report, terminal};
use crate::diagnostic::Sink;
use crate::emit::Provenance;
use crate::emit::mcap::recording::is_as_recorded;
use crate::log::{self, Recording};
use crate::quantity::{digits, to_decimals};
use crate::schedule::control::ControlLine;
use crate::verify::microrobots::recorded::{self, GoalReached, RecordedRun, Tolerances};
use serde_json::{Value, json};

/// Verifies a recording and returns its report: the recording is intact, its program has the claims that it contains,
/// and the commands and measurements keep them.
///
/// # Errors
/// The refusal.
pub fn judge(arguments: &VerifyArguments, bytes: &[u8]) -> Result<String, Box<Refusal>> {
    let path = &arguments.file;
    let recording = log::read_recording(bytes).map_err(|error| Refusal::one(error.diagnostic(), Exit::Files))?;
    let Recording { task, claims, files, settings, version, lines } = recording;
    let of_its_version = |refusal| if version == env!("CARGO_PKG_VERSION") { refusal } else { not_ours(&version) };
    let within = Embedding { name: &task, claims: &claims, files: &files, settings: &settings };
    let own = own_claims(path, &within).map_err(of_its_version)?;
    let provenance = Provenance { files, settings, is_recorded: true };
    if !is_as_recorded(bytes, &own.claims, &provenance, &lines) {
        return Err(of_its_version(Refusal::one(errors::recording_differs(path), Exit::Refused)));
    }
    let lines: Vec<&ControlLine> = lines.iter().map(|message| &message.line).collect();
    let run = match &arguments.against {
        None => judged(arguments, &lines, own)?,
        Some(trusted) => {
            let theirs = trusted_claims(arguments, trusted, &task, &provenance.settings, &claims)?;
            claims_the_same(&arguments.file, LogOrigin::Run, trusted, &theirs, &claims)?;
            judged(arguments, &lines, theirs)?
        }
    };
    Ok(match arguments.report.format {
        ReportFormat::Json => format!("{}\n", as_json(arguments, &task, &provenance.settings, &run)),
        ReportFormat::Human | ReportFormat::Short | ReportFormat::Github => {
            as_text(arguments, &task, &version, &provenance, &run)
        }
    })
}

/// Judges the lines; messages point into the files of the claims.
fn judged(arguments: &VerifyArguments, lines: &[&ControlLine], derived: Derived) -> Result<RecordedRun, Box<Refusal>> {
    let granted = &arguments.tolerances;
    let tolerances = Tolerances {
        path_um: granted.path_tolerance,
        goal_um: granted.goal_tolerance,
        heading_rad: granted.heading_tolerance,
        time_ns: granted.time_tolerance,
    };
    recorded::judge(lines, &derived.claims, &derived.sources, tolerances).map_err(|violations| {
        let mut sink = Sink::default();
        violations.into_iter().for_each(|violation| sink.push(violation.into()));
        Box::new(Refusal { sources: derived.sources, sink, exit: Exit::Refused })
    })
}

fn as_text(
    arguments: &VerifyArguments,
    task: &str,
    version: &str,
    provenance: &Provenance,
    run: &RecordedRun,
) -> String {
    let file = arguments.file.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    let trusted = arguments.against.as_ref().map(|path| path.to_string_lossy().into_owned());
    let robots = run.goals.iter().map(|goal| goal.robot.clone());
    let settings = provenance.settings.iter().map(|setting| format!("--set {setting}"));
    let names = [file.clone(), task.to_owned()].into_iter().chain(trusted.clone()).chain(robots).chain(settings);
    let width = report::width(names);
    let program = terminal::name(&provenance.files[0].0);
    let origin = format!("recorded by tweeze {version} from {program}");
    let mut text = terminal::line("Read", &file, width, &origin);
    text.push_str(&report::settings(&provenance.settings, width));
    let s = |ns: u64| digits(ns as f64 / 1e9);
    let RecordedRun { measurements, commands, strokes, set_aside, duration_ns, farthest, goals } = run;
    let aside = match set_aside {
        0 => String::new(),
        some => format!(", {some} set aside"),
    };
    let took =
        format!("{measurements} measurements{aside}, {commands} commands, {strokes} strokes in {} s", s(*duration_ns));
    text.push_str(&terminal::line("Verified", task, width, &format!("{took}, 0 violations")));
    if let Some(far) = farthest {
        let (off, allowed) = (rounded(far.off_um), rounded(far.allowed_um));
        let at = format!("at most {off} um off the commanded path, at {} s; {allowed} um is allowed", s(far.at_ns));
        text.push_str(&terminal::line("Followed", &far.robot, width, &at));
    }
    for goal in goals {
        text.push_str(&terminal::line(
            if goal.is_docked { "Docked" } else { "Reached" },
            &goal.robot,
            width,
            &near(goal),
        ));
    }
    if let Some(trusted) = trusted {
        text.push_str(&terminal::line("Matches", &trusted, width, "the run did what this program claims"));
    }
    text
}

/// Distance at which a goal was reached, with the limit.
fn near(goal: &GoalReached) -> String {
    let place = if goal.is_docked { "its place in the structure" } else { "its goal" };
    let [off, may] = [goal.off_um, goal.allowed_um].map(rounded);
    let [turned, may_turn] = [goal.off_rad, goal.allowed_rad].map(|rad| rounded(rad.to_degrees()));
    format!("{off} um and {turned} deg off {place}; {may} um and {may_turn} deg are allowed")
}

/// Rounds to two decimals, which is precise enough beside measurement errors.
fn rounded(value: f64) -> String {
    digits(to_decimals(value, 2))
}

fn as_json(arguments: &VerifyArguments, task: &str, settings: &[String], run: &RecordedRun) -> Value {
    let goal = |goal: &GoalReached| {
        json!({
            "robot": goal.robot,
            "docked": goal.is_docked,
            "off_um": goal.off_um,
            "allowed_um": goal.allowed_um,
            "off_deg": goal.off_rad.to_degrees(),
            "allowed_deg": goal.allowed_rad.to_degrees(),
        })
    };
    let farthest = run.farthest.as_ref().map(
        |far| json!({ "robot": far.robot, "at_ns": far.at_ns, "off_um": far.off_um, "allowed_um": far.allowed_um }),
    );
    json!({
        "verified": arguments.file.to_string_lossy(),
        "against": arguments.against.as_ref().map(|path| path.to_string_lossy()),
        "settings": settings,
        "recording": {
            "task": task,
            "measurements": run.measurements,
            "commands": run.commands,
            "strokes": run.strokes,
            "set_aside": run.set_aside,
            "duration_ns": run.duration_ns,
            "farthest": farthest,
            "goals": run.goals.iter().map(goal).collect::<Vec<Value>>(),
        },
    })
}
