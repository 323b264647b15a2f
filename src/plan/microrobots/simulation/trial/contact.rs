//! Contact of robots with their structure: when it happens, and whether they stick.
//!
//! Two robots that come head on touch where their bodies meet; they align themselves within the limits of the device,
//! and the structure is where they met. A single robot touches when a corner of its front comes to the edge that it
//! faces at its goal; it then lies flat against it. Robots that touch anything else have collided.

use super::{ContactRecord, FailureReason, Trial, motion};
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::{Robot, wrapped_rad};
use crate::geometry::Pose;
use crate::plan::microrobots::AssemblyStage;
use crate::plan::microrobots::strategy::{GoalFrame, StrategySolid, body, edge_gap_um};
use crate::real::Real;
use std::f64::consts::PI;

/// Bisection steps to a contact; they leave an error far below a stroke.
const HALVINGS: usize = 40;

/// A robot farther from its goal than this many lengths of the fine motion does not dock.
const NEAR_LENGTHS: f64 = 2.0;

/// A robot whose heading is off its goal's by more than this does not dock.
const FACING_RAD: f64 = 1.4;

/// The robots that may dock next.
#[derive(Debug, Clone, Copy)]
pub enum NextDocking {
    Pair {
        robots: [usize; 2],
        goals: [Pose; 2],
    },
    Single {
        robot: usize,
        /// As planned.
        goal: Pose,
        /// Frame of the actual goal, with its edge.
        frame: GoalFrame,
    },
}

impl NextDocking {
    /// Docking of a stage; `None` if nothing docks in it.
    pub fn of(trial: &Trial, stage: &AssemblyStage) -> Option<Self> {
        match *stage {
            AssemblyStage::Pair { first, second, goals, .. } => {
                Some(NextDocking::Pair { robots: [first, second], goals })
            }
            AssemblyStage::Single { robot, goal, .. } => {
                let there = trial.moved_along(goal);
                let frame = GoalFrame::new(trial.order.robot(robot), there, gap_um(trial, robot, there));
                Some(NextDocking::Single { robot, goal, frame })
            }
            AssemblyStage::BedLegs { .. } | AssemblyStage::Escort { .. } => None,
        }
    }

    /// The robots of the stage.
    pub fn robots(&self) -> impl Iterator<Item = usize> {
        match self {
            NextDocking::Pair { robots: [first, second], .. } => [Some(*first), Some(*second)],
            NextDocking::Single { robot, .. } => [Some(*robot), None],
        }
        .into_iter()
        .flatten()
    }

    /// Whether the robots are near enough to their goals to touch what they dock with.
    pub fn is_near(&self, trial: &Trial) -> bool {
        let is_near = |robot: usize, goal: Pose| {
            let pose = trial.poses[robot];
            let off_um = (pose.x_um - goal.x_um).hypotenuse(pose.y_um - goal.y_um);
            off_um <= NEAR_LENGTHS * trial.order.facts.fine.length_um
                && wrapped_rad(pose.heading_rad - goal.heading_rad).abs() <= FACING_RAD
        };
        match self {
            NextDocking::Pair { robots, goals } => robots.iter().zip(goals).all(|(robot, goal)| is_near(*robot, *goal)),
            NextDocking::Single { robot, frame, .. } => is_near(*robot, frame.goal),
        }
    }

    /// Whether they touch after `strokes` more strokes in a state.
    pub fn touches(&self, trial: &Trial, state: usize, strokes: f64) -> bool {
        match self {
            NextDocking::Pair { robots: [first, second], .. } => {
                let facts = [*first, *second].map(|robot| trial.order.robot(robot));
                let other = StrategySolid::standing(facts[1], trial.gone(*second, state, strokes));
                other.distance_um(&body(facts[0], trial.gone(*first, state, strokes), 0.0), 0.0) <= 0.0
            }
            NextDocking::Single { robot, frame, .. } => {
                let pose = trial.gone(*robot, state, strokes);
                frame.gap_um(frame.seen(pose)) <= 0.0 && is_before(trial, *robot, pose, frame)
            }
        }
    }

    /// Strokes until they touch, at most `most`.
    pub fn strokes_to_contact(&self, trial: &Trial, state: usize, most: f64) -> f64 {
        let (mut low, mut high) = (0.0, most);
        for _ in 0..HALVINGS {
            let middle = (low + high) / 2.0;
            if self.touches(trial, state, middle) { high = middle } else { low = middle }
        }
        low
    }

    /// Judges robots that touch: they stick in their places, or the trial fails.
    ///
    /// # Errors
    /// Why they do not stick in their places.
    pub fn judge(&self, trial: &mut Trial) -> Result<(), (usize, FailureReason)> {
        match self {
            NextDocking::Pair { robots, goals } => judge_pair(trial, *robots, *goals),
            NextDocking::Single { robot, goal, frame } => judge_single(trial, *robot, *goal, frame),
        }
    }

    /// Without errors, robots that are at their goals stick, though rounding may keep them apart.
    pub fn settle(&self, trial: &mut Trial) -> bool {
        let goals = match self {
            NextDocking::Pair { robots, goals } => [Some((robots[0], goals[0])), Some((robots[1], goals[1]))],
            NextDocking::Single { robot, frame, .. } => [Some((*robot, frame.goal)), None],
        };
        if !goals.iter().flatten().all(|(robot, goal)| is_at(trial.order, trial.poses[*robot], *goal)) {
            return false;
        }
        for (robot, goal) in goals.into_iter().flatten() {
            let (pose, goal) = (trial.poses[robot], goal);
            let (sin, cos) = goal.heading_rad.sine_cosine();
            let (dx_um, dy_um) = (pose.x_um - goal.x_um, pose.y_um - goal.y_um);
            let off_rad = wrapped_rad(pose.heading_rad - goal.heading_rad);
            let (along_um, across_um) = (dx_um * cos + dy_um * sin, dy_um * cos - dx_um * sin);
            trial.contacts.push(ContactRecord {
                robot,
                across_um,
                along_um,
                incidence_rad: off_rad,
                heading_rad: off_rad,
            });
            trial.docked[robot] = true;
        }
        true
    }
}

/// Whether a pose keeps the task's precision at a goal.
fn is_at(order: &MicrorobotsOrder, pose: Pose, goal: Pose) -> bool {
    let off_um = (pose.x_um - goal.x_um).hypotenuse(pose.y_um - goal.y_um);
    let off_rad = wrapped_rad(pose.heading_rad - goal.heading_rad).abs();
    off_um <= order.precision.place_um + 1e-6 && off_rad <= order.precision.heading_rad + 1e-9
}

/// Whether a robot that has come to the line of its edge is really in front of it, and not beside.
fn is_before(trial: &Trial, robot: usize, pose: Pose, frame: &GoalFrame) -> bool {
    let facts = trial.order.robot(robot);
    let across_um = frame.contact(frame.seen(pose), 0.0).across_um.abs();
    across_um <= facts.width_um && {
        let reach_um = trial.order.facts.docking.tolerance_um;
        let corners = body(facts, pose, 0.0);
        trial.docked_bodies().any(|solid| solid.distance_um(&corners, reach_um) <= reach_um)
    }
}

fn gap_um(trial: &Trial, robot: usize, goal: Pose) -> f64 {
    let order = trial.order;
    let docked = (0..trial.poses.len()).filter(|robot| trial.docked[*robot]);
    let bodies: Vec<_> = docked.map(|robot| (order.robot(robot), trial.poses[robot])).collect();
    // The others may already be apart by their tolerance.
    let tolerance_um = 3.0 * order.facts.docking.tolerance_um;
    edge_gap_um(order.robot(robot), goal, &bodies, tolerance_um).unwrap_or(0.0)
}

fn judge_single(trial: &mut Trial, robot: usize, goal: Pose, frame: &GoalFrame) -> Result<(), (usize, FailureReason)> {
    let docking = trial.order.facts.docking;
    let contact = frame.contact(frame.seen(trial.poses[robot]), 0.0);
    let ahead_um = frame.edge_um - trial.order.robot(robot).length_um / 2.0;
    let flat = frame.placed(Pose { x_um: ahead_um, y_um: contact.across_um, heading_rad: 0.0 });
    let (dx_um, dy_um) = (flat.x_um - goal.x_um, flat.y_um - goal.y_um);
    trial.contacts.push(ContactRecord {
        robot,
        across_um: contact.across_um,
        along_um: dx_um * goal.heading_rad.cosine() + dy_um * goal.heading_rad.sine(),
        incidence_rad: contact.incidence_rad,
        heading_rad: wrapped_rad(flat.heading_rad - goal.heading_rad),
    });
    if contact.incidence_rad.abs() > docking.sticking_rad {
        return Err((robot, FailureReason::Angle));
    }
    if contact.across_um.abs() > docking.tolerance_um {
        return Err((robot, FailureReason::Misplaced));
    }
    trial.poses[robot] = flat;
    trial.docked[robot] = true;
    Ok(())
}

fn judge_pair(trial: &mut Trial, robots: [usize; 2], goals: [Pose; 2]) -> Result<(), (usize, FailureReason)> {
    let docking = trial.order.facts.docking;
    let poses = robots.map(|robot| trial.poses[robot]);
    let facts = robots.map(|robot| trial.order.robot(robot));
    let off_rad = [0, 1].map(|at| wrapped_rad(poses[at].heading_rad - goals[at].heading_rad));
    let tilt_rad = (off_rad[0] + off_rad[1]) / 2.0;
    let noses = [0, 1].map(|at| nose(facts[at], poses[at]));
    let nominal = middle([0, 1].map(|at| nose(facts[at], goals[at])));
    let axis_rad = goals[0].heading_rad + tilt_rad;
    let (dx_um, dy_um) = (noses[1][0] - noses[0][0], noses[1][1] - noses[0][1]);
    let across_um = dy_um * axis_rad.cosine() - dx_um * axis_rad.sine();
    let met = middle(noses);
    let incidence_rad = wrapped_rad(poses[0].heading_rad - poses[1].heading_rad - PI);
    let along_um = (met[0] - nominal[0]).hypotenuse(met[1] - nominal[1]);
    for robot in robots {
        trial.contacts.push(ContactRecord { robot, across_um, along_um, incidence_rad, heading_rad: tilt_rad });
    }
    if incidence_rad.abs() > docking.self_aligning_rad {
        return Err((robots[0], FailureReason::Angle));
    }
    if across_um.abs() > docking.self_aligning_um {
        return Err((robots[0], FailureReason::Misplaced));
    }
    let at = |[x_um, y_um]: [f64; 2], heading_rad: f64| Pose { x_um, y_um, heading_rad };
    trial.structure = motion(at(nominal, 0.0), at(met, tilt_rad));
    for (robot, goal) in robots.into_iter().zip(goals) {
        trial.poses[robot] = trial.moved_along(goal);
        trial.docked[robot] = true;
    }
    Ok(())
}

/// The middle of a robot's front.
fn nose(robot: &Robot, pose: Pose) -> [f64; 2] {
    let (sin, cos) = pose.heading_rad.sine_cosine();
    [pose.x_um + robot.length_um / 2.0 * cos, pose.y_um + robot.length_um / 2.0 * sin]
}

fn middle([a, b]: [[f64; 2]; 2]) -> [f64; 2] {
    [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0]
}
