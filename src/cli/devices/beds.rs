//! Beds of microrobots: their control matrix with levels and slack, and voltage tables for robots still to be built.

use super::aligned;
use super::program::length;
use crate::check::microrobots::Bed;
use crate::cli::arguments::DevicesArguments;
use crate::cli::{Exit, terminal};
use crate::device::microrobots::{ControlState, Robot};
use crate::quantity::{Dimension, Quantity, digits};

/// The table of a bed, and the control states that its voltage can reach.
pub fn told(name: &str, bed: &Bed) -> String {
    let facts = &bed.facts;
    let count = facts.robots.len();
    let plural = if count == 1 { "" } else { "s" };
    let head = format!(
        "{name}: microrobots, {count} robot{plural}, each transition voltage ± {}, drive train {} to {}, source up to {}\n",
        volts(facts.margin_v),
        volts(facts.relax_v),
        volts(facts.flex_v),
        volts(facts.max_v)
    );
    let heading = ["robot", "snap-down", "release", "turning radius", "speed"].map(str::to_owned).to_vec();
    let robots = facts.robots.iter().map(|robot| row(robot, facts.period_ns));
    let robots: Vec<Vec<String>> = std::iter::once(heading).chain(robots).collect();
    let note = "control states: 1 is an arm that is down, so that the robot turns\n";
    format!("{head}\n{}\n{note}{}", aligned(&robots), matrix(bed))
}

fn row(robot: &Robot, period_ns: u64) -> Vec<String> {
    let speed = Quantity::new(robot.step_um / period_ns as f64 * 1e3, Dimension::SPEED);
    let radius = length(robot.turning_radius_um);
    vec![robot.name.clone(), volts(robot.snap_down_v), volts(robot.release_v), radius, speed.to_string()]
}

/// A row for each control state, a column for each robot.
fn matrix(bed: &Bed) -> String {
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

/// A voltage to a hundredth of a volt, which is more than a table knows.
fn volts(volts: f64) -> String {
    format!("{} V", digits((volts * 100.0).round() / 100.0))
}

/// A table for robots that are still to be built.
pub fn suggest(arguments: &DevicesArguments) -> Exit {
    let _ = arguments;
    terminal::answer("")
}
