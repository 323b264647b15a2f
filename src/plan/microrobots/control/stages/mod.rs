//! The stages of a task, each a state machine of its own.

mod coarse;
mod pair;
mod single;
mod written;

use super::CommandSegments;
use super::belief::Belief;
use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder};
use crate::device::microrobots::Arm;
use crate::device::microrobots::control::{ControlPhase, StopReason};
use crate::plan::microrobots::guarantee::carried_out_as_written;
use crate::plan::microrobots::strategy::Cylinder;
use crate::plan::microrobots::strategy::{Episode, StrategyPiece, episodes};
use crate::plan::microrobots::{AssemblyStage, MicrorobotsMotion, MicrorobotsStepMotion};
use coarse::DriveStage;
use pair::PairStage;
use single::SingleStage;
use written::{RestStage, WrittenStage};

/// Answer of a stage to a measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Progress {
    /// The command has its segments; without any, the bed holds still until the next measurement.
    Driving,
    /// The bed is without voltage until this instant.
    Resting(u64),
    /// The stage is over, and the measurement goes to the next one.
    Done,
    Failed(StopReason, usize),
}

/// A stage with its step.
#[derive(Debug, Clone)]
pub struct StepStage<'a> {
    /// Index into the order's steps.
    pub step: usize,
    pub stage: ControlStage<'a>,
}

/// A stage of a task.
#[derive(Debug, Clone)]
pub enum ControlStage<'a> {
    Written(WrittenStage<'a>),
    Rest(RestStage),
    Drive(Box<DriveStage<'a>>),
    Pair(Box<PairStage<'a>>),
    Single(Box<SingleStage<'a>>),
}

impl ControlStage<'_> {
    /// The next actions after a measurement.
    pub fn proceed(&mut self, belief: &mut Belief, command: &mut CommandSegments, now_ns: u64) -> Progress {
        match self {
            ControlStage::Written(stage) => stage.proceed(belief, command),
            ControlStage::Rest(stage) => stage.proceed(now_ns),
            ControlStage::Drive(stage) => stage.proceed(belief, command),
            ControlStage::Pair(stage) => stage.proceed(belief, command),
            ControlStage::Single(stage) => stage.proceed(belief, command),
        }
    }

    /// Looks for another path if the commanded one would lead into something; `false` if there is none.
    pub fn find_new_path(&mut self, belief: &Belief) -> bool {
        match self {
            ControlStage::Drive(stage) => stage.find_new_path(belief),
            ControlStage::Written(_) | ControlStage::Rest(_) | ControlStage::Pair(_) | ControlStage::Single(_) => false,
        }
    }

    pub fn phase(&self) -> ControlPhase {
        match self {
            ControlStage::Written(_) => ControlPhase::Legs,
            ControlStage::Rest(_) => ControlPhase::Wait,
            ControlStage::Drive(_) => ControlPhase::Approach,
            ControlStage::Pair(stage) => stage.phase(),
            ControlStage::Single(stage) => stage.phase(),
        }
    }

    pub fn driven(&self) -> [Option<usize>; 2] {
        match self {
            ControlStage::Written(_) | ControlStage::Rest(_) => [None; 2],
            ControlStage::Drive(stage) => [Some(stage.robot), None],
            ControlStage::Pair(stage) => stage.robots.map(Some),
            ControlStage::Single(stage) => [Some(stage.robot), None],
        }
    }

    /// The robots that are driven against each other, or against docked ones, on purpose.
    pub fn may_touch(&self) -> [Option<usize>; 2] {
        if let ControlStage::Written(stage) = self {
            return stage.docking();
        }
        match self.phase() {
            ControlPhase::Fine | ControlPhase::Contact => self.driven(),
            ControlPhase::Legs
            | ControlPhase::Wait
            | ControlPhase::Approach
            | ControlPhase::Timing
            | ControlPhase::Meeting
            | ControlPhase::Over => [None; 2],
        }
    }

    /// Upper bound on the segments of one command.
    pub fn most_segments(&self, order: &MicrorobotsOrder) -> usize {
        match self {
            ControlStage::Written(stage) => stage.most_segments(),
            ControlStage::Rest(_) => 0,
            ControlStage::Drive(_) => 2,
            // Cycles of up to five segments.
            ControlStage::Pair(_) | ControlStage::Single(_) => {
                let fine = order.facts.fine;
                5 * (fine.length_um / fine.cycle_um).ceil().max(1.0) as usize + 8
            }
        }
    }
}

/// The stages of a plan in order of time.
pub fn stages<'a>(order: &'a MicrorobotsOrder, motion: &'a MicrorobotsMotion) -> Vec<StepStage<'a>> {
    let all = episodes(order, motion);
    let pushed_um = carried_out_as_written(order, motion);
    let mut found = Vec::new();
    let mut crew = motion.start.clone();
    for (step, steps) in motion.steps.iter().enumerate() {
        let mut push = |stage: ControlStage<'a>| found.push(StepStage { step, stage });
        let (legs, docks) = match steps {
            MicrorobotsStepMotion::Wait(duration_ns) => {
                push(ControlStage::Rest(RestStage::new(*duration_ns)));
                continue;
            }
            MicrorobotsStepMotion::Legs { legs, docks, .. } => (legs, docks),
        };
        let of_step = || all.iter().filter(|episode| episode.step == step);
        of_step().filter_map(|episode| of_episode(order, episode, pushed_um.is_some())).for_each(&mut push);
        if of_step().next().is_none() {
            push(of_other(order, step, &crew.poses, &crew.docked, legs));
        }
        legs.iter().enumerate().for_each(|(index, leg)| crew.follow(order, index, leg, docks));
    }
    push_last(order, &mut found, pushed_um.unwrap_or(0.0));
    found
}

/// Lets the robots of a last stage that is carried out as written run on by `pushed_um`, so that they touch what they
/// dock with.
fn push_last(order: &MicrorobotsOrder, stages: &mut [StepStage], pushed_um: f64) {
    if let Some(StepStage { stage: ControlStage::Written(stage), .. }) = stages.last_mut() {
        stage.push(order, pushed_um);
    }
}

/// Control stage of an assembly stage; as written if the errors are so small that this is sure to succeed.
fn of_episode<'a>(order: &'a MicrorobotsOrder, episode: &Episode<'a>, is_written: bool) -> Option<ControlStage<'a>> {
    // Only tests of the strategy alone have stages without legs.
    if is_written && !episode.legs.is_empty() {
        return Some(ControlStage::Written(WrittenStage::of(order, episode)));
    }
    match *episode.stage {
        AssemblyStage::BedLegs { .. } => Some(ControlStage::Written(WrittenStage::of(order, episode))),
        AssemblyStage::Single { .. } => {
            SingleStage::new(order, episode).map(|stage| ControlStage::Single(Box::new(stage)))
        }
        AssemblyStage::Escort { .. } => None,
        AssemblyStage::Pair { .. } => PairStage::new(order, episode).map(|stage| ControlStage::Pair(Box::new(stage))),
    }
}

/// Control stage of a step that assembles nothing.
fn of_other<'a>(
    order: &'a MicrorobotsOrder,
    step: usize,
    poses: &[crate::geometry::Pose],
    docked: &[bool],
    legs: &'a [crate::plan::microrobots::Leg],
) -> ControlStage<'a> {
    let is_exact = order.facts.is_exact();
    let written = || ControlStage::Written(WrittenStage::new(order, legs));
    match order.steps.get(step).map(|step| &step.action) {
        Some(MicrorobotsAction::Drive { robot, stops }) if !is_exact => {
            let stage = DriveStage::new(order, *robot, poses[*robot], stops, docked, legs);
            stage.map_or_else(written, |stage| ControlStage::Drive(Box::new(stage)))
        }
        Some(
            MicrorobotsAction::Drive { .. }
            | MicrorobotsAction::Apply { .. }
            | MicrorobotsAction::Assemble(_)
            | MicrorobotsAction::Wait(_),
        )
        | None => written(),
    }
}

/// Greatest measured distance from their goals at which drives count as done; `None` if nothing is driven in closed
/// loop.
pub fn drives_end_within(stages: &[StepStage]) -> Option<Cylinder> {
    let drives = stages.iter().filter_map(|one| match &one.stage {
        ControlStage::Drive(stage) => Some(stage.accepted()),
        ControlStage::Written(_) | ControlStage::Single(_) | ControlStage::Pair(_) | ControlStage::Rest(_) => None,
    });
    drives.reduce(|one, other| Cylinder {
        radius_um: one.radius_um.max(other.radius_um),
        heading_rad: one.heading_rad.max(other.heading_rad),
    })
}

/// Adds the actions of a robot to a command; `state` gives the control state of an arm.
pub fn add_pieces(
    belief: &Belief,
    command: &mut CommandSegments,
    robot: usize,
    pieces: [StrategyPiece; 2],
    state: impl Fn(Arm) -> usize,
) {
    pieces.into_iter().for_each(|piece| command.add(state(piece.arm), strokes(belief, robot, piece.way_um)));
}

/// Whole strokes of a nominal path of a robot.
pub fn strokes(belief: &Belief, robot: usize, way_um: f64) -> u64 {
    (way_um.max(0.0) / belief.order.robot(robot).step_um).round() as u64
}
