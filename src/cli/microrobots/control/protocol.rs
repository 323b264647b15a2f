//! Line protocol of `tweeze control`: parses measurements and writes commands.

use crate::claims::microrobots::MicrorobotsOrder;
use crate::geometry::Pose;
use crate::schedule::control::MeasuredLine;
use crate::schedule::microrobots::RecordedPose;
use serde::Serialize;

/// Latest time of a measurement, so that the end times of commands do not overflow: 146 years after 0.
const MAX_T_NS: u64 = u64::MAX / 4;

/// Greatest coordinate of a measurement, a kilometre, and greatest heading: beyond them the motion of a robot would be
/// lost in rounding.
const MAX_COORDINATE_UM: f64 = 1e9;
const MAX_HEADING_DEG: f64 = 1e6;

/// A measurement: its time, and for each robot of the order its pose if it was seen.
#[derive(Debug)]
pub struct Measured {
    pub t_ns: u64,
    pub poses: Vec<Option<Pose>>,
}

/// Parses a line of measured poses.
///
/// # Errors
/// A message that says what is wrong with the line.
pub fn measured(order: &MicrorobotsOrder, line: &str) -> Result<Measured, String> {
    let line = line.trim();
    if !line.starts_with('{') {
        return Err(r#"a line must be one JSON object: {"t_ns": …, "robots": {…}}"#.to_owned());
    }
    // There is only one line, so only the column is useful.
    let wrong = |error: serde_json::Error| {
        error.to_string().replace(" at line 1 column ", " at column ").replace("expected f64", "expected a number")
    };
    let MeasuredLine { t_ns, robots } = serde_json::from_str(line).map_err(wrong)?;
    if t_ns > MAX_T_NS {
        return Err(format!("`t_ns` is {t_ns}; it must be at most {MAX_T_NS}"));
    }
    let names: Vec<&str> = (0..order.robots.len()).map(|robot| order.robot(robot).name.as_str()).collect();
    if let Some(unknown) = robots.keys().find(|name| !names.contains(&name.as_str())) {
        return Err(format!("`{unknown}` is not a robot of the scene, which has {}", names.join(", ")));
    }
    let is_beyond = |pose: &RecordedPose| {
        let coordinates = [pose.x_um, pose.y_um];
        coordinates.iter().any(|um| um.abs() > MAX_COORDINATE_UM) || pose.heading_deg.abs() > MAX_HEADING_DEG
    };
    if let Some((name, _)) = robots.iter().find(|(_, pose)| pose.as_ref().is_some_and(is_beyond)) {
        return Err(format!(
            "`{name}` is measured beyond {MAX_COORDINATE_UM} um or {MAX_HEADING_DEG} deg, where numbers are too coarse to show a motion"
        ));
    }
    let pose = |name: &&str| robots.get(*name)?.as_ref().map(RecordedPose::pose);
    Ok(Measured { t_ns, poses: names.iter().map(pose).collect() })
}

/// The first line of the output: figures of the device that every command relies on.
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

/// The answer to a line that is not a measurement.
pub fn error(number: u64, why: &str) -> String {
    #[derive(Serialize)]
    struct ErrorLine<'a> {
        error: &'a str,
        input_line: u64,
    }
    written(&ErrorLine { error: why, input_line: number })
}

/// An object as a line. Keys are strings and numbers are finite, so serialisation cannot fail.
pub fn written(line: &impl Serialize) -> String {
    let mut text = serde_json::to_string(line).expect("keys are texts and numbers finite");
    text.push('\n');
    text
}
