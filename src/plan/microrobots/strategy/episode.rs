//! The stages of a plan, each with the nominal poses at its start and the paths of its robots.

use super::SAME_UM;
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::{Arm, wrapped_rad};
use crate::geometry::Pose;
use crate::plan::microrobots::{AssemblyStage, Leg, MicrorobotsMotion, MicrorobotsStepMotion, RobotDocking};
use crate::real::Real;

/// A stage with its context.
#[derive(Debug, Clone)]
pub struct Episode<'a> {
    /// Index into the order's steps.
    pub step: usize,
    pub stage: &'a AssemblyStage,
    /// Pose of each robot of the order at its start.
    pub poses: Vec<Pose>,
    pub docked: Vec<bool>,
    /// Legs of this stage only.
    pub legs: &'a [Leg],
    /// Legs from which the closed loop takes its paths: those of the stage, or others in their place.
    pub steered: &'a [Leg],
    /// Gross motion of each driven robot, in the order of driving: numbers of steered legs before its start and before
    /// its end.
    pub gross: Vec<[usize; 2]>,
    /// Turning centres between the start and the approach of each driven robot.
    pub via_um: Vec<Vec<[f64; 2]>>,
}

/// The stages of a plan in order of time.
pub fn episodes<'a>(order: &MicrorobotsOrder, motion: &'a MicrorobotsMotion) -> Vec<Episode<'a>> {
    let mut found = Vec::new();
    let mut crew = motion.start.clone();
    for (step, steps) in motion.steps.iter().enumerate() {
        let MicrorobotsStepMotion::Legs { legs, docks, stages } = steps else { continue };
        let numbered: Vec<(usize, &Leg)> = legs.iter().enumerate().collect();
        let mut at = 0;
        // The legs of an escort belong to the episode of its pair, in which the second robot is first brought near.
        for stage in stages.iter().filter(|stage| !matches!(stage, AssemblyStage::Escort { .. })) {
            let end = match stage {
                AssemblyStage::BedLegs { legs } => at + legs,
                AssemblyStage::Escort { .. } | AssemblyStage::Pair { .. } | AssemblyStage::Single { .. } => {
                    last_leg(stage, docks).map_or(legs.len(), |leg| leg + 1)
                }
            };
            let end = end.clamp(at, legs.len());
            found.push(episode(order, step, stage, &crew.poses, &crew.docked, &legs[at..end]));
            numbered[at..end].iter().for_each(|(index, leg)| crew.follow(order, *index, leg, docks));
            at = end;
            for (robot, goal) in goals(stage) {
                (crew.poses[robot], crew.docked[robot]) = (goal, true);
            }
        }
        numbered[at..].iter().for_each(|(index, leg)| crew.follow(order, *index, leg, docks));
    }
    found
}

/// The driven robots of a stage in the order of driving, with the poses at which each drive ends.
pub fn driven(stage: &AssemblyStage) -> Vec<(usize, Pose)> {
    match stage {
        AssemblyStage::Pair { first, second, intermediate, approach, .. } => {
            vec![(*first, *intermediate), (*second, approach[1])]
        }
        AssemblyStage::Escort { robot, to, .. } => vec![(*robot, *to)],
        AssemblyStage::Single { robot, approach, .. } => vec![(*robot, *approach)],
        AssemblyStage::BedLegs { .. } => Vec::new(),
    }
}

fn goals(stage: &AssemblyStage) -> Vec<(usize, Pose)> {
    match stage {
        AssemblyStage::Pair { first, second, goals, .. } => vec![(*first, goals[0]), (*second, goals[1])],
        AssemblyStage::Escort { .. } | AssemblyStage::BedLegs { .. } => Vec::new(),
        AssemblyStage::Single { robot, goal, .. } => vec![(*robot, *goal)],
    }
}

fn last_leg(stage: &AssemblyStage, docks: &[RobotDocking]) -> Option<usize> {
    let robots = driven(stage);
    docks.iter().filter(|dock| robots.iter().any(|(robot, _)| *robot == dock.robot)).map(|dock| dock.leg).max()
}

fn episode<'a>(
    order: &MicrorobotsOrder,
    step: usize,
    stage: &'a AssemblyStage,
    poses: &[Pose],
    docked: &[bool],
    legs: &'a [Leg],
) -> Episode<'a> {
    let (mut gross, mut via_um, mut begins) = (Vec::new(), Vec::new(), 0);
    let steered: &[Leg] = match stage {
        AssemblyStage::Pair { steered, .. } if !steered.is_empty() => steered,
        AssemblyStage::BedLegs { .. }
        | AssemblyStage::Escort { .. }
        | AssemblyStage::Pair { .. }
        | AssemblyStage::Single { .. } => legs,
    };
    for (robot, target) in driven(stage) {
        let way = poses_of(order, robot, poses[robot], steered);
        let ends = nearest(order, robot, &way[begins..], target) + begins;
        via_um.push(centres(order, robot, &way, &steered[..ends], begins));
        gross.push([begins, ends]);
        begins = ends;
    }
    Episode { step, stage, poses: poses.to_vec(), docked: docked.to_vec(), legs, steered, gross, via_um }
}

/// Poses of a robot before each leg, and after the last one.
pub fn poses_of(order: &MicrorobotsOrder, robot: usize, start: Pose, legs: &[Leg]) -> Vec<Pose> {
    let mut poses = vec![start];
    for leg in legs {
        let pose = poses[poses.len() - 1];
        poses.push(leg.carried(order, robot, pose));
    }
    poses
}

/// Number of legs after which a robot is nearest to a pose.
fn nearest(order: &MicrorobotsOrder, robot: usize, way: &[Pose], target: Pose) -> usize {
    let radius_um = order.robot(robot).turning_radius_um;
    let off_um = |pose: &Pose| {
        let turned_um = radius_um * wrapped_rad(pose.heading_rad - target.heading_rad).abs();
        (pose.x_um - target.x_um).hypotenuse(pose.y_um - target.y_um) + turned_um
    };
    let count = way.len();
    (0..count).min_by(|a, b| off_um(&way[*a]).total_cmp(&off_um(&way[*b]))).unwrap_or(0)
}

/// The centres about which a robot turns in some legs, except the first and the last one.
pub fn centres(order: &MicrorobotsOrder, robot: usize, way: &[Pose], legs: &[Leg], begins: usize) -> Vec<[f64; 2]> {
    let facts = order.robot(robot);
    let first_um = facts.orbit_centre_um(way[begins]);
    let last_um = facts.orbit_centre_um(way[legs.len()]);
    let is_other = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypotenuse(a[1] - b[1]) > SAME_UM;
    let mut found: Vec<[f64; 2]> = Vec::new();
    for (leg, pose) in legs.iter().zip(way).skip(begins) {
        let centre_um = facts.orbit_centre_um(*pose);
        let turns = order.states[leg.state].arms[order.robots[robot].row] == Arm::Down;
        if turns && is_other(centre_um, *found.last().unwrap_or(&first_um)) {
            found.push(centre_um);
        }
    }
    if found.last().is_some_and(|centre_um| !is_other(*centre_um, last_um)) {
        found.pop();
    }
    found
}
