//! Recognition of docking, as the judge of schedules defines it: at the first end of a leg at which a robot is within
//! the precision of its goal, and its body is within the docking tolerance of one that is docked, or of one that is at
//! its own goal then.
//!
//! Input: a stretch whose robots end at their goals. Output: the same, cut after the leg at which they dock; with short
//! cycles that is before the last leg. Promise: the judge, whose arithmetic differs in the last digits, recognises
//! these dockings and no others.

use super::StuckAssembly;
use super::bed::{AssemblyState, StageAddition};
use super::track::miss;
use crate::claims::microrobots::{Dock, Precision};
use crate::geometry::Pose;
use crate::plan::microrobots::Leg;

/// Tolerance for rounding of places and gaps, in micrometres.
const ROUNDING_UM: f64 = 1e-5;

/// The same for headings.
const ROUNDING_RAD: f64 = 1e-8;

/// Upper limit of the rounding tolerance, as a share of the limit that it widens or narrows.
const ROUNDING_SHARE: f64 = 0.01;

/// Cuts a stretch where its robots dock.
///
/// # Errors
/// If they do not dock, or not all at the same time, or if another robot docks.
pub fn cut_at_docking(
    bed: &AssemblyState,
    docks: &[Dock],
    mut stretch: StageAddition,
) -> Result<StageAddition, StuckAssembly> {
    let [surely, perhaps] = [-1.0, 1.0].map(|sign| first_docking(bed, docks, &stretch.legs, sign));
    let mut due = stretch.docking.clone();
    due.sort_unstable();
    match &surely {
        Some((leg, robots)) if *robots == due && perhaps == surely => {
            stretch.legs.truncate(leg + 1);
            Ok(stretch)
        }
        Some(_) | None => Err(apart(bed, docks, &stretch)),
    }
}

/// First leg after which robots dock, and these robots; `sign` widens or narrows the limits by the rounding tolerance.
fn first_docking(bed: &AssemblyState, docks: &[Dock], legs: &[Leg], sign: f64) -> Option<(usize, Vec<usize>)> {
    let limit = |value: f64, rounding: f64| value + sign * rounding.min(ROUNDING_SHARE * value);
    let Precision { place_um, heading_rad } = bed.order.precision;
    let precision = Precision { place_um: limit(place_um, ROUNDING_UM), heading_rad: limit(heading_rad, ROUNDING_RAD) };
    let tolerance_um = limit(bed.order.facts.docking.tolerance_um, ROUNDING_UM);
    let open: Vec<&Dock> = docks.iter().filter(|dock| !bed.docked[dock.robot]).collect();
    let mut poses = bed.poses.clone();
    for (index, leg) in legs.iter().enumerate() {
        open.iter().for_each(|dock| poses[dock.robot] = leg.carried(bed.order, dock.robot, poses[dock.robot]));
        let is_there = |dock: &&&Dock| miss(precision, poses[dock.robot], dock.goal.pose) <= 1.0;
        let there: Vec<usize> = open.iter().filter(is_there).map(|dock| dock.robot).collect();
        let touches = |robot: &usize| nearest_um(bed, &poses, *robot, &there) <= tolerance_um;
        let mut docking: Vec<usize> = there.iter().copied().filter(touches).collect();
        if !docking.is_empty() {
            docking.sort_unstable();
            return Some((index, docking));
        }
    }
    None
}

/// Gap between a robot and the nearest one with which it may dock.
fn nearest_um(bed: &AssemblyState, poses: &[Pose], robot: usize, there: &[usize]) -> f64 {
    let holds = |other: &usize| *other != robot && (bed.docked[*other] || there.contains(other));
    let gap_um = |other: usize| bed.gap_um((robot, poses[robot]), (other, poses[other]));
    (0..poses.len()).filter(holds).map(gap_um).fold(f64::INFINITY, f64::min)
}

/// Reason why the robots of a stretch do not dock at its end.
fn apart(bed: &AssemblyState, docks: &[Dock], stretch: &StageAddition) -> StuckAssembly {
    let go = |mut poses: Vec<Pose>, leg: &Leg| {
        bed.others(&[]).for_each(|robot| poses[robot] = leg.carried(bed.order, robot, poses[robot]));
        poses
    };
    let poses = stretch.legs.iter().fold(bed.poses.clone(), go);
    let gaps = stretch.docking.iter().map(|&robot| (robot, nearest_um(bed, &poses, robot, &stretch.docking)));
    let widest = gaps.max_by(|a, b| a.1.total_cmp(&b.1));
    let tolerance_um = bed.order.facts.docking.tolerance_um;
    match widest.filter(|(_, gap_um)| *gap_um > (1.0 - ROUNDING_SHARE) * tolerance_um - ROUNDING_UM) {
        Some((robot, gap_um)) => StuckAssembly::Loose { robot, gap_um },
        None => StuckAssembly::Coarse {
            robot: stretch.docking.first().or(docks.first().map(|dock| &dock.robot)).copied().unwrap_or(0),
        },
    }
}
