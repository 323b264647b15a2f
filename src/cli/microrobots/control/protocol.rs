//! The lines of `tweeze control`: measured poses in, commands out, each one JSON object.
//!
//! Described for people in `docs/control.md`, for programs in `schema/control.schema.json`.

use crate::claims::microrobots::MicrorobotsOrder;
use crate::geometry::Pose;
use crate::plan::microrobots::control::{Command, ControlPhase, Controller, Segment, Stop, StopReason};
use crate::quantity::digits;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A line of measured poses.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MeasuredLine {
    t_ns: u64,
    robots: BTreeMap<String, Option<MeasuredPose>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct MeasuredPose {
    x_um: f64,
    y_um: f64,
    heading_deg: f64,
}

/// A measurement: its time, and a pose for each robot of an order that was seen.
#[derive(Debug)]
pub struct Measured {
    pub t_ns: u64,
    pub poses: Vec<Option<Pose>>,
}

/// Reads a line of measured poses.
///
/// # Errors
/// What is wrong with it, for people.
pub fn measured(order: &MicrorobotsOrder, line: &str) -> Result<Measured, String> {
    let MeasuredLine { t_ns, robots } = serde_json::from_str(line).map_err(|error| error.to_string())?;
    let names: Vec<&str> = (0..order.robots.len()).map(|robot| order.robot(robot).name.as_str()).collect();
    if let Some(unknown) = robots.keys().find(|name| !names.contains(&name.as_str())) {
        return Err(format!("`{unknown}` is no robot of the scene, which has {}", names.join(", ")));
    }
    let pose = |name: &&str| {
        let MeasuredPose { x_um, y_um, heading_deg } = robots.get(*name)?.as_ref()?;
        Some(Pose { x_um: *x_um, y_um: *y_um, heading_rad: heading_deg.to_radians() })
    };
    Ok(Measured { t_ns, poses: names.iter().map(pose).collect() })
}

/// The first line of the answers: figures of the device that every command relies on.
pub fn greeting(order: &MicrorobotsOrder, task: &str) -> String {
    #[derive(Serialize)]
    struct Greeting<'a> {
        control: &'a str,
        version: &'static str,
        robots: Vec<&'a str>,
        dwell_ns: u64,
        period_ns: u64,
        flex_v: f64,
        relax_v: f64,
        interval_ns: u64,
        watchdog_ns: u64,
    }
    let facts = &order.facts;
    written(&Greeting {
        control: task,
        version: env!("CARGO_PKG_VERSION"),
        robots: (0..order.robots.len()).map(|robot| order.robot(robot).name.as_str()).collect(),
        dwell_ns: facts.dwell_ns,
        period_ns: facts.period_ns,
        flex_v: facts.flex_v,
        relax_v: facts.relax_v,
        interval_ns: facts.errors.map_or(0, |errors| errors.replan_ns),
        watchdog_ns: facts.watchdog_ns(),
    })
}

/// A command with what belongs to every one of them.
#[derive(Serialize)]
struct CommandLine<'a> {
    t_ns: u64,
    command: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    until_ns: Option<u64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    segments: Option<Vec<SegmentLine<'a>>>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reason: Option<StopReason>,
    #[serde(skip_serializing_if = "Option::is_none")]
    message: Option<String>,
    step: usize,
    #[serde(skip_serializing_if = "Option::is_none")]
    line: Option<u32>,
    phase: ControlPhase,
    driven: Vec<&'a str>,
    docked: Vec<&'a str>,
}

#[derive(Serialize)]
struct SegmentLine<'a> {
    state: String,
    /// Empty where the arms are in that state already.
    levels_v: &'a [f64],
    strokes: u64,
}

/// A line of the program's text for each step of the order.
pub struct StepLines(pub Vec<u32>);

/// The decision of a controller behind a command.
pub struct Decision {
    step: usize,
    phase: ControlPhase,
    driven: Vec<usize>,
    docked: Vec<usize>,
}

impl Decision {
    /// What the controller does now.
    pub fn of(controller: &Controller, order: &MicrorobotsOrder) -> Decision {
        Decision {
            step: controller.step(),
            phase: controller.phase(),
            driven: controller.driven().into_iter().flatten().collect(),
            docked: (0..order.robots.len()).filter(|robot| controller.is_docked(*robot)).collect(),
        }
    }
}

/// A command as a line.
pub fn command(
    order: &MicrorobotsOrder,
    lines: &StepLines,
    decision: &Decision,
    t_ns: u64,
    command: Command,
) -> String {
    let name = |robot: &usize| order.robot(*robot).name.as_str();
    let (word, until_ns, segments, stop) = match command {
        Command::Drive { segments, until_ns } => ("drive", Some(until_ns), Some(segments), None),
        Command::Rest { until_ns } => ("rest", Some(until_ns), None, None),
        Command::Continue { until_ns } => ("continue", Some(until_ns), None, None),
        Command::Finished => ("finished", None, None, None),
        Command::Stop(stop) => ("stop", None, None, Some(stop)),
    };
    let segment = |segment: &Segment| {
        let state = &order.states[segment.state];
        let levels_v: &[f64] = if segment.sets_arms { &state.levels_v } else { &[] };
        SegmentLine { state: state.digits(), levels_v, strokes: segment.strokes }
    };
    let segments = segments.map(|segments| segments.iter().map(segment).collect());
    written(&CommandLine {
        t_ns,
        command: word,
        until_ns,
        segments,
        reason: stop.map(|stop| stop.reason),
        message: stop.map(|stop| stopped(order, stop)),
        step: decision.step,
        line: lines.0.get(decision.step).copied(),
        phase: decision.phase,
        driven: decision.driven.iter().map(name).collect(),
        docked: decision.docked.iter().map(name).collect(),
    })
}

/// The answer to a line that is no measurement.
pub fn error(number: u64, why: &str) -> String {
    #[derive(Serialize)]
    struct ErrorLine<'a> {
        error: &'a str,
        input_line: u64,
    }
    written(&ErrorLine { error: why, input_line: number })
}

/// Why a task was given up, for people.
pub fn stopped(order: &MicrorobotsOrder, stop: Stop) -> String {
    let robot = stop.robot.map_or("a robot", |robot| order.robot(robot).name.as_str());
    match stop.reason {
        StopReason::LeftCylinder => format!("`{robot}` did not get to where its motion should end, in all its rounds"),
        StopReason::MissedCone => format!("the goal of `{robot}` is not within reach of the fine motion"),
        StopReason::Misplaced => format!("`{robot}` is measured at its structure, but too far from its place"),
        StopReason::TimeLimit => format!("`{robot}` took too long"),
        StopReason::Unseen => format!("`{robot}` was not seen in too many measurements in a row"),
        StopReason::Doubtful => format!("`{robot}` was measured too often where it cannot be"),
        StopReason::Silence => {
            let watchdog_s = order.facts.watchdog_ns() as f64 / 1e9;
            format!("no measurement came for {} s after the end of the last command", digits(watchdog_s))
        }
        StopReason::Closed => "the measurements ended before the task was done".to_owned(),
        StopReason::Clock => "the time of a measurement lies before that of the last one".to_owned(),
        StopReason::Garbled => "too many lines in a row are no measurements".to_owned(),
    }
}

/// A line with its end. Keys are strings and numbers are finite, so that writing cannot fail.
fn written(line: &impl Serialize) -> String {
    let mut text = serde_json::to_string(line).unwrap_or_default();
    text.push('\n');
    text
}
