//! Docking of a robot with a structure: gross motion, fine motion, contact.

use super::{ControlPhase, Progress, StopReason, add_pieces, strokes};
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::Arm;
use crate::geometry::Pose;
use crate::plan::microrobots::AssemblyStage;
use crate::plan::microrobots::control::CommandSegments;
use crate::plan::microrobots::control::belief::Belief;
use crate::plan::microrobots::strategy::{Episode, GoalFrame, Phase, Pursuit, SteeringModel, edge_gap_um, steered};
use std::f64::consts::TAU;

/// Most attempts at the end of the gross motion.
pub const MAX_ROUNDS: usize = 20;

/// Greatest length of a gross motion, as a multiple of its nominal path.
pub const MAX_TIMES: f64 = 20.0;

/// Greatest length of a fine motion, as a multiple of its nominal path.
pub const MAX_FINE_TIMES: f64 = 4.0;

/// Most pushes of a robot against its structure.
pub const MAX_PUSHES: usize = 5;

/// Greatest angle from lying flat, in addition to the errors of measurements.
const FLAT_RAD: f64 = 0.01;

/// The robot of a stage.
#[derive(Debug, Clone)]
pub struct SingleStage<'a> {
    pub robot: usize,
    model: SteeringModel<'a>,
    /// Indices of the control states in which it turns and runs straight.
    states: [usize; 2],
    /// Approach and goal as planned.
    approach: Pose,
    goal: Pose,
    /// The docked robots that it faces at its goal.
    before: Vec<usize>,
    pursuit: Pursuit,
    phase: ControlPhase,
    has_begun: bool,
    rounds: usize,
    left_um: f64,
    share: f64,
    aside_um: f64,
    is_kept: bool,
    pushes: usize,
    /// Whether the last push began with the robot as near as one that touches.
    is_pushed_on: bool,
}

impl<'a> SingleStage<'a> {
    pub fn new(order: &'a MicrorobotsOrder, episode: &Episode) -> Option<Self> {
        let &AssemblyStage::Single { robot, states, approach, goal } = episode.stage else { return None };
        let model = whole_strokes(SteeringModel::new(order, robot)?);
        let tolerance_um = 3.0 * order.facts.docking.tolerance_um;
        let is_before = |other: &usize| {
            let body = [(order.robot(*other), episode.poses[*other])];
            episode.docked[*other] && edge_gap_um(model.robot, goal, &body, tolerance_um).is_some()
        };
        let before = (0..episode.poses.len()).filter(is_before).collect();
        let pursuit = Pursuit::new(&model, episode.via_um.first().cloned().unwrap_or_default(), approach);
        Some(SingleStage {
            robot,
            model,
            states,
            approach,
            goal,
            before,
            pursuit,
            phase: ControlPhase::Approach,
            has_begun: false,
            rounds: 0,
            left_um: 0.0,
            share: 0.0,
            aside_um: 0.0,
            is_kept: false,
            pushes: 0,
            is_pushed_on: false,
        })
    }

    pub fn phase(&self) -> ControlPhase {
        self.phase
    }

    pub fn proceed(&mut self, belief: &mut Belief, command: &mut CommandSegments) -> Progress {
        let goal = belief.moved_along(self.goal);
        let frame = GoalFrame::new(self.model.robot, goal, belief.gap_um(self.robot, goal, &self.before));
        if self.phase == ControlPhase::Approach {
            match self.approach(belief, command, &frame) {
                Progress::Done => {
                    self.phase = ControlPhase::Fine;
                    self.left_um = MAX_FINE_TIMES * belief.order.facts.fine.length_um;
                }
                progress => return progress,
            }
        }
        self.fine(belief, command, &frame)
    }

    fn approach(&mut self, belief: &mut Belief, command: &mut CommandSegments, frame: &GoalFrame) -> Progress {
        let measured = belief.poses[self.robot];
        let approach = belief.moved_along(self.approach);
        if !self.has_begun || self.pursuit.is_far(&self.model, measured) {
            self.pursuit.aim(&self.model, approach);
        }
        if !self.has_begun {
            self.has_begun = true;
            let circle_um = TAU * self.model.robot.turning_radius_um;
            self.left_um = MAX_TIMES * (self.pursuit.left_um(&self.model, measured) + circle_um);
        }
        if self.pursuit.phase == Phase::Arrived {
            let is_there = self.model.accepted().holds(self.pursuit.approach, measured);
            if is_there && steered(&self.model, frame, measured, [0.0, 1.0]).1 == 0.0 {
                return Progress::Done;
            }
            self.rounds += 1;
            if self.rounds > MAX_ROUNDS {
                let reason = if is_there { StopReason::MissedCone } else { StopReason::LeftCylinder };
                return Progress::Failed(reason, self.robot);
            }
            self.pursuit.aim(&self.model, approach);
            self.pursuit.retry(&self.model, measured);
        }
        let pieces = self.pursuit.pieces(&self.model, measured, self.model.interval_um);
        self.left_um -= pieces.iter().map(|piece| piece.way_um).sum::<f64>();
        if self.left_um < 0.0 {
            return Progress::Failed(StopReason::TimeLimit, self.robot);
        }
        let [turning, straight] = self.states;
        add_pieces(belief, command, self.robot, pieces, |arm| if arm == Arm::Down { turning } else { straight });
        Progress::Driving
    }

    fn fine(&mut self, belief: &mut Belief, command: &mut CommandSegments, frame: &GoalFrame) -> Progress {
        let measured = belief.poses[self.robot];
        let seen = frame.seen(measured);
        if self.phase == ControlPhase::Contact {
            // A robot that sticks lies flat.
            let is_flat = seen.heading_rad.abs() <= 2.0 * belief.errors.heading_rad + FLAT_RAD;
            let (gap_um, touching_um) = (frame.gap_um(seen), touching_um(belief, self.model.robot.width_um));
            if is_flat && gap_um <= touching_um {
                if self.is_pushed_on {
                    return self.judge(belief, seen);
                }
                self.is_pushed_on = true;
                command.add(self.states[1], strokes(belief, self.robot, push_on_um(gap_um, touching_um)));
                return Progress::Driving;
            }
            // It was not there yet.
            (self.phase, self.is_pushed_on) = (ControlPhase::Fine, false);
        }
        if !self.is_kept {
            (self.share, self.aside_um) = steered(&self.model, frame, measured, [0.0, 1.0]);
            self.is_kept = frame.gap_um(seen) < self.model.fine_interval_um + self.model.kept_um;
        }
        let turn_per_um = self.share / self.model.robot.turning_radius_um;
        let way_um = frame.met(seen, turn_per_um).map_or(f64::INFINITY, |contact| contact.way_um);
        if way_um > self.model.fine_interval_um {
            self.left_um -= self.model.fine_interval_um;
            if self.left_um < 0.0 {
                return Progress::Failed(StopReason::MissedCone, self.robot);
            }
            self.cycles(belief, command, self.model.fine_interval_um);
            return Progress::Driving;
        }
        self.pushes += 1;
        if self.pushes > MAX_PUSHES {
            return Progress::Failed(StopReason::MissedCone, self.robot);
        }
        self.phase = ControlPhase::Contact;
        self.last_cycles(belief, command, way_um);
        let push_um = push_um(belief, self.model.robot.width_um, way_um) + again_um(self.pushes, self.model.cycle_um);
        command.add(self.states[1], strokes(belief, self.robot, push_um));
        Progress::Driving
    }

    /// Whole cycles; their turns lie half before and half after the straight run, so that they do not lead or lag.
    fn cycles(&self, belief: &Belief, command: &mut CommandSegments, way_um: f64) {
        let count = (way_um / self.model.cycle_um).round().max(1.0);
        let cycle_um = way_um / count;
        let turning = strokes(belief, self.robot, self.share * cycle_um / 2.0);
        let straight = strokes(belief, self.robot, (1.0 - self.share) * cycle_um);
        for _ in 0..count as u64 {
            command.add(self.states[0], turning);
            command.add(self.states[1], straight);
            command.add(self.states[0], turning);
        }
    }

    /// The cycles before the contact; the last one turns first and then runs straight, so that the arm is up when the
    /// robot sticks.
    fn last_cycles(&self, belief: &Belief, command: &mut CommandSegments, way_um: f64) {
        let last_um = way_um.min(self.model.cycle_um);
        if way_um - last_um > self.model.cycle_um / 2.0 {
            self.cycles(belief, command, way_um - last_um);
        }
        let last_um = if way_um - last_um > self.model.cycle_um / 2.0 { last_um } else { way_um };
        command.add(self.states[0], strokes(belief, self.robot, self.share * last_um));
        command.add(self.states[1], strokes(belief, self.robot, (1.0 - self.share) * last_um));
    }

    /// Judges a robot that was pushed against its structure and touches it.
    fn judge(&self, belief: &mut Belief, seen: Pose) -> Progress {
        let most_um = belief.order.facts.docking.tolerance_um + 2.0 * belief.doubt_um(self.model.robot.length_um);
        if seen.y_um.abs() > most_um {
            let reason = if self.aside_um == 0.0 { StopReason::Misplaced } else { StopReason::MissedCone };
            return Progress::Failed(reason, self.robot);
        }
        belief.dock(self.robot);
        Progress::Done
    }
}

/// The model of a robot that accepts what whole strokes can reach; rounding to strokes acts like an error.
pub fn whole_strokes(mut model: SteeringModel) -> SteeringModel {
    let step_um = model.robot.step_um;
    model.errors.place_um = model.errors.place_um.max(2.0 * step_um);
    model.errors.heading_rad = model.errors.heading_rad.max(2.0 * step_um / model.robot.turning_radius_um);
    model
}

/// Measured gap up to which a robot that was pushed against something touches it: the errors of both measured places.
pub fn touching_um(belief: &Belief, width_um: f64) -> f64 {
    2.0 * belief.doubt_um(width_um / 2.0) + 2.0 * belief.order.robot(0).step_um + 0.5
}

/// Path of a push after one that leaves open whether the robot touches, so that it certainly does.
pub fn push_on_um(gap_um: f64, touching_um: f64) -> f64 {
    gap_um.max(0.0) + touching_um
}

/// Path by which a repeated push is longer than the first one: bodies that come askew touch later than their fronts
/// would.
pub fn again_um(pushes: usize, cycle_um: f64) -> f64 {
    pushes.saturating_sub(1) as f64 * cycle_um / 2.0
}

/// Path beyond the measured contact that ensures that a robot touches.
pub fn push_um(belief: &Belief, width_um: f64, way_um: f64) -> f64 {
    touching_um(belief, width_um) + belief.errors.speed_ratio * way_um
}
