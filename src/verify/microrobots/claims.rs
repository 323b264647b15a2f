//! Assumptions of the replay about the claims of microrobots.
//!
//! Input: an order. Output: nothing, or the reason why no run can be checked against it. Claims of the checker always
//! pass.

use super::super::InvalidClaims;
use super::super::geometry::solid::Solid;
use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder, MicrorobotsStop};
use crate::device::microrobots::{Arm, MAX_LEVELS, MAX_OBSTACLES, MAX_ROBOTS, MicrorobotsFacts, Robot};
use crate::geometry::Pose;
use crate::geometry::shape::MAX_EXTENT_UM;
use std::collections::BTreeSet;

/// Checks the assumptions of all rules.
///
/// # Errors
/// If no schedule can be checked against the claims.
pub(super) fn check_claims(order: &MicrorobotsOrder) -> Result<(), InvalidClaims> {
    facts(&order.facts)?;
    order.facts.robots.iter().try_for_each(robot)?;
    states(order)?;
    scene(order)?;
    order.steps.iter().try_for_each(|step| match &step.action {
        MicrorobotsAction::Apply { state, .. } => {
            demand(*state < order.states.len(), "apply a state that they do not have")
        }
        MicrorobotsAction::Drive { robot, stops } => {
            demand(*robot < order.robots.len(), "drive a robot that they do not have")?;
            demand(!stops.is_empty(), "drive a robot without a goal")?;
            stops.iter().try_for_each(stop)
        }
        MicrorobotsAction::Assemble(docks) => {
            let robots: BTreeSet<usize> = docks.iter().map(|dock| dock.robot).collect();
            demand(!docks.is_empty(), "assemble no robot")?;
            demand(robots.len() == docks.len(), "assemble a robot twice in one step")?;
            demand(robots.iter().all(|robot| *robot < order.robots.len()), "assemble a robot that they do not have")?;
            docks.iter().try_for_each(|dock| stop(&dock.goal))
        }
        MicrorobotsAction::Wait(_) => Ok(()),
    })
}

fn demand(holds: bool, why: &str) -> Result<(), InvalidClaims> {
    if holds { Ok(()) } else { Err(InvalidClaims(format!("the claims of microrobots {why}"))) }
}

fn is_length(value_um: f64) -> bool {
    (0.0..=MAX_EXTENT_UM).contains(&value_um)
}

fn facts(facts: &MicrorobotsFacts) -> Result<(), InvalidClaims> {
    demand((1..=MAX_ROBOTS).contains(&facts.robots.len()), "have no row in their table, or too many")?;
    let names: BTreeSet<&str> = facts.robots.iter().map(|robot| robot.name.as_str()).collect();
    demand(names.len() == facts.robots.len(), "have two robots with the same name")?;
    let volts = [facts.margin_v, facts.max_v, facts.relax_v, facts.flex_v];
    demand(volts.iter().all(|value| value.is_finite() && *value >= 0.0), "have a voltage out of range")?;
    demand(
        facts.relax_v <= facts.max_v && facts.flex_v <= facts.max_v,
        "drive with a higher voltage than the source gives",
    )?;
    demand(facts.period_ns > 0 && facts.period_ns.is_multiple_of(2), "have a stroke period that is zero or odd")?;
    demand(facts.dwell_ns > 0, "have a dwell time of 0")?;
    let fine = [facts.fine.length_um, facts.fine.cycle_um];
    let lengths = [facts.clearance_um, facts.orbit_clearance_um, facts.docking.tolerance_um, fine[0], fine[1]];
    demand(lengths.into_iter().all(is_length), "have a length out of range")
}

fn robot(robot: &Robot) -> Result<(), InvalidClaims> {
    let Robot { snap_down_v, release_v, turning_radius_um, step_um, length_um, width_um, .. } = *robot;
    let volts = [snap_down_v, release_v];
    demand(volts.into_iter().all(f64::is_finite) && release_v < snap_down_v, "have a robot that never releases")?;
    let sizes = [turning_radius_um, step_um, length_um, width_um];
    demand(sizes.into_iter().all(|value| value > 0.0 && is_length(value)), "have a robot with a size out of range")
}

fn states(order: &MicrorobotsOrder) -> Result<(), InvalidClaims> {
    let mut met = BTreeSet::new();
    for state in order.states.iter() {
        demand(state.arms.len() == order.facts.robots.len(), "have a control state of another table")?;
        demand(met.insert(state.digits()), "have a control state twice")?;
        demand(
            (1..=MAX_LEVELS as usize).contains(&state.levels_v.len()),
            "have a control state without levels, or with too many",
        )?;
        demand(state.levels_v.iter().all(|level| level.is_finite()), "have a level that is not finite")?;
    }
    demand(rest(order).is_some(), "have no control state with all arms up")
}

/// The control state with all arms up.
pub(super) fn rest(order: &MicrorobotsOrder) -> Option<usize> {
    order.states.iter().position(|state| state.arms.iter().all(|arm| *arm == Arm::Up))
}

fn scene(order: &MicrorobotsOrder) -> Result<(), InvalidClaims> {
    let rows: Vec<usize> = order.robots.iter().map(|robot| robot.row).collect();
    demand(rows.is_sorted_by(|one, other| one < other), "have robots in another order than their table")?;
    demand(rows.iter().all(|row| *row < order.facts.robots.len()), "have a robot that is not in the table")?;
    demand(order.robots.iter().all(|robot| is_place(&robot.pose)), "place a robot out of range")?;
    demand(order.obstacles.len() <= MAX_OBSTACLES, "have too many obstacles")?;
    let are_shapes = order.obstacles.iter().all(|obstacle| Solid::of(&obstacle.shape, &obstacle.pose).is_some());
    demand(are_shapes, "have an obstacle without a shape")?;
    let precision = [order.precision.place_um, order.precision.heading_rad];
    demand(precision.into_iter().all(|value| value.is_finite() && value >= 0.0), "have a precision out of range")
}

fn stop(stop: &MicrorobotsStop) -> Result<(), InvalidClaims> {
    demand(is_place(&stop.pose), "name a goal out of range")
}

fn is_place(pose: &Pose) -> bool {
    [pose.x_um, pose.y_um, pose.heading_rad].into_iter().all(|value| value.abs() <= MAX_EXTENT_UM)
}
