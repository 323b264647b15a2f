//! Report of beds of microrobots: their control matrix with levels and slack, and voltage tables for robots still to be
//! built.

use super::length;
use crate::check::microrobots::CheckedBed;
use crate::check::microrobots::relays::RelayRow;
use crate::check::microrobots::suggest::{self, SuggestLimits, Suggestion};
use crate::cli::Exit;
use crate::cli::arguments::DevicesArguments;
use crate::cli::terminal::{self, aligned};
use crate::device::microrobots::{ControlState, Robot};
use crate::quantity::{Dimension, Quantity, count, digits, to_decimals};
use std::fmt::Write;

/// The table of a bed, with the control states that the source can reach.
pub fn describe(name: &str, bed: &CheckedBed) -> String {
    let facts = &bed.facts;
    let head = format!(
        "{name}: microrobots, {}, each transition voltage ± {}, drive train {} to {}, source up to {}\n",
        count(facts.robots.len(), "robot"),
        volts(facts.margin_v),
        volts(facts.relax_v),
        volts(facts.flex_v),
        volts(facts.max_v)
    );
    let heading = ["robot", "snap-down", "release", "turning radius", "speed"].map(str::to_owned).to_vec();
    let robots = facts.robots.iter().map(|robot| row(robot, facts.period_ns));
    let robots: Vec<Vec<String>> = std::iter::once(heading).chain(robots).collect();
    let note = "control states: 1 is an arm that is down, which makes the robot turn\n";
    format!("{head}\n{}\n{note}{}", aligned(&robots), matrix(bed))
}

fn row(robot: &Robot, period_ns: u64) -> Vec<String> {
    let speed = Quantity::new(robot.step_um / period_ns as f64 * 1e3, Dimension::SPEED);
    let radius = length(robot.turning_radius_um);
    vec![robot.name.clone(), volts(robot.snap_down_v), volts(robot.release_v), radius, speed.to_string()]
}

/// A row for each control state and a column for each robot.
fn matrix(bed: &CheckedBed) -> String {
    let heading = std::iter::once("state".to_owned())
        .chain(bed.facts.robots.iter().map(|robot| robot.name.clone()))
        .chain(["slack", "levels of its control cycle"].map(str::to_owned));
    let row = |(index, state): (usize, &ControlState)| {
        let levels: Vec<String> = state.levels_v.iter().map(|level_v| volts(*level_v)).collect();
        std::iter::once(index.to_string())
            .chain(state.arms.iter().map(|arm| arm.digit().to_string()))
            .chain([volts(state.slack_v), levels.join(", ")])
            .collect()
    };
    let rows: Vec<Vec<String>> =
        std::iter::once(heading.collect()).chain(bed.states.iter().enumerate().map(row)).collect();
    aligned(&rows)
}

/// A voltage rounded to 0.01 V, which is finer than the data of a table.
fn volts(volts: f64) -> String {
    format!("{} V", rounded(volts))
}

fn rounded(volts: f64) -> String {
    digits(to_decimals(volts, 2))
}

/// Suggests a voltage table for robots that are still to be built.
pub fn suggest(arguments: &DevicesArguments) -> Exit {
    let (Some(robots), Some(margin_v), Some(max_v)) = (arguments.robots, arguments.margin, arguments.max) else {
        return Exit::Usage;
    };
    let drive_v = arguments.relax.zip(arguments.flex).map(|(relax_v, flex_v)| [relax_v, flex_v]);
    if let Some([relax_v, flex_v]) = drive_v.filter(|[relax_v, flex_v]| relax_v >= flex_v) {
        let (relax, flex) = (volts(relax_v), volts(flex_v));
        eprintln!("relax level {relax} must be below the flex level of {flex}");
        return Exit::Usage;
    }
    let limits = SuggestLimits { margin_v, max_v, drive_v, swing_v: arguments.swing };
    let suggestion = suggest::suggest(robots as usize, limits);
    match &suggestion.table {
        Some(table) => terminal::answer(&declaration(table, &suggestion, limits)),
        None => {
            eprintln!(
                "{robots} robots do not fit: with a margin of {} and a source of {}, at most {} can be distinguished",
                volts(margin_v),
                volts(max_v),
                count(suggestion.most, "robot")
            );
            Exit::Errors
        }
    }
}

/// A device declaration that can be pasted into a program.
fn declaration(table: &[RelayRow], suggestion: &Suggestion, limits: SuggestLimits) -> String {
    let mut text = format!(
        "// The best table for {} robots: every level of every control cycle may be off by {}. At most {} robots would fit.\n\
         // Only the voltages are suggested; the turning radius is an example.\n\
         use std.microrobots\n\n\
         device bed : microrobots.bed {{\n  robots: table {{\n    \
         robot | snap_down [V] | release [V] | turning_radius [um]\n",
        table.len(),
        volts(suggestion.slack_v),
        suggestion.most
    );
    for (label, row) in (1..).zip(table) {
        let name = format!("D{label}");
        let (snap_down, release) = (rounded(row.snap_down_v), rounded(row.release_v));
        // Writing to a string cannot fail.
        let _ = writeln!(text, "    {name:<5} | {snap_down:<13} | {release:<11} | 165");
    }
    let levels = [limits.margin_v, limits.max_v, suggestion.relax_v, suggestion.flex_v].map(rounded);
    let [margin, max, relax, flex] = levels;
    let _ =
        writeln!(text, "  }}\n  margin: {margin} V\n  max_voltage: {max} V\n  relax: {relax} V\n  flex: {flex} V\n}}");
    text
}
