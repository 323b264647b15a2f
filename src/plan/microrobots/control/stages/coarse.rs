//! Drive of one robot through its stops: the gross motion of an assembly, on the path of the plan.
//!
//! A robot with errors cannot be brought to its stop exactly. It counts as there once it is measured within the
//! cylinder that the errors allow; otherwise the drive is repeated.

use super::single::{MAX_ROUNDS, MAX_TIMES, whole_strokes};
use super::{Progress, StopReason, add_pieces, strokes};
use crate::claims::microrobots::{MicrorobotsOrder, MicrorobotsStop};
use crate::device::microrobots::{Arm, wrapped_rad};
use crate::geometry::Pose;
use crate::plan::microrobots::Leg;
use crate::plan::microrobots::control::belief::Belief;
use crate::plan::microrobots::control::{CommandSegments, StrokeSegment};
use crate::plan::microrobots::drive;
use crate::plan::microrobots::strategy::{Cylinder, Phase, Pursuit, PursuitCircle, SteeringModel, centres, poses_of};
use crate::plan::microrobots::world::{BedPoses, CollisionWorld};
use crate::plan::search::SearchBudget;
use crate::real::Real;
use std::f64::consts::TAU;

/// Most searches for a new path from a measured pose, and the budget of each in steps of the drive planner: an answer
/// must not be late.
const MAX_NEW_PATHS: usize = 32;
const NEW_PATH_BUDGET: SearchBudget = SearchBudget::of(6_000);

/// Clearances that a new path keeps, as shares of the device's: a robot that was led astray may have less room than the
/// plan keeps.
const CLEARANCES: [f64; 2] = [1.0, 0.5];
const NO_CLEARANCE: [f64; 1] = [0.0];

/// A robot on its way through stops.
#[derive(Debug, Clone)]
pub struct DriveStage<'a> {
    pub robot: usize,
    order: &'a MicrorobotsOrder,
    stops: Vec<MicrorobotsStop>,
    new_paths: usize,
    /// Whether the last command turned the robot for all of its length.
    is_turning: bool,
    model: SteeringModel<'a>,
    /// Indices of the control states in which it turns and runs straight.
    states: [usize; 2],
    /// Path to each stop.
    pursuits: Vec<Pursuit>,
    at: usize,
    rounds: usize,
    left_um: Option<f64>,
}

impl<'a> DriveStage<'a> {
    /// `None` if the device has no two states for it that keep the arms of docked robots up.
    pub fn new(
        order: &'a MicrorobotsOrder,
        robot: usize,
        start: Pose,
        stops: &[MicrorobotsStop],
        docked: &[bool],
        legs: &[Leg],
    ) -> Option<Self> {
        let model = whole_strokes(SteeringModel::new(order, robot)?);
        let states = [state(order, robot, Arm::Down, docked, legs)?, state(order, robot, Arm::Up, docked, legs)?];
        let way = poses_of(order, robot, start, legs);
        let (mut begins, mut pursuits) = (0, Vec::new());
        for stop in stops {
            let ends = begins + nearest(&way[begins..], stop.pose, model.robot.turning_radius_um);
            let via_um = centres(order, robot, &way, &legs[..ends], begins);
            pursuits.push(Pursuit::new(&model, via_um, stop.pose));
            begins = ends;
        }
        let (stops, new_paths, is_turning) = (stops.to_vec(), 0, false);
        Some(DriveStage {
            robot,
            order,
            stops,
            new_paths,
            is_turning,
            model,
            states,
            pursuits,
            at: 0,
            rounds: 0,
            left_um: None,
        })
    }

    /// Replans the rest of the path from the measured poses of all robots; `false` if no path was found, or too many
    /// were sought.
    pub fn find_new_path(&mut self, belief: &Belief) -> bool {
        self.find_path_with(&CLEARANCES, belief) || self.find_path_with(&NO_CLEARANCE, belief)
    }

    fn find_path_with(&mut self, clearances: &[f64], belief: &Belief) -> bool {
        self.new_paths += 1;
        if self.new_paths > MAX_NEW_PATHS {
            return false;
        }
        let rest = self.stops[self.at.min(self.stops.len())..].to_vec();
        let stops: Vec<Pose> = rest.iter().map(|stop| stop.pose).collect();
        let bed = BedPoses::new(belief.poses.clone(), belief.docked.clone());
        let world = CollisionWorld::new(self.order);
        let [keep_um, _] = world.keeps_um();
        let driven = |share: f64| {
            let world = world.widened(-keep_um * (1.0 - share));
            let request =
                drive::DriveRequest { order: self.order, world: &world, bed: &bed, robot: self.robot, stops: &stops };
            drive::drive(&request, NEW_PATH_BUDGET).ok()
        };
        let found = clearances.iter().copied().find_map(driven);
        let start = belief.poses[self.robot];
        let anew = |legs: &[Leg]| DriveStage::new(self.order, self.robot, start, &rest, &belief.docked, legs);
        let stage = found.and_then(|found| anew(&found.legs));
        match stage {
            Some(stage) => {
                *self = DriveStage { new_paths: self.new_paths, is_turning: true, ..stage };
                true
            }
            None => false,
        }
    }

    /// Greatest measured distance from a stop at which the robot counts as there.
    pub fn accepted(&self) -> Cylinder {
        self.model.accepted()
    }

    pub fn proceed(&mut self, belief: &mut Belief, command: &mut CommandSegments) -> Progress {
        let measured = belief.poses[self.robot];
        loop {
            let has_no_room = self.begins_turn_without_room(belief, measured);
            if has_no_room && !self.find_path_with(&CLEARANCES, belief) {
                if self.runs_on(belief, command) {
                    return Progress::Driving;
                }
                self.find_path_with(&NO_CLEARANCE, belief);
            }
            let model = &self.model;
            let Some(pursuit) = self.pursuits.get_mut(self.at) else { return Progress::Done };
            let left_um = self.left_um.get_or_insert_with(|| most_um(pursuit, model, measured));
            if pursuit.phase == Phase::Arrived {
                if model.accepted().holds(pursuit.approach, measured) {
                    (self.at, self.rounds, self.left_um) = (self.at + 1, 0, None);
                    continue;
                }
                self.rounds += 1;
                if self.rounds > MAX_ROUNDS {
                    return Progress::Failed(StopReason::LeftCylinder, self.robot);
                }
                pursuit.retry(model, measured);
            }
            let [turning, straight] = self.states;
            let room_um = room_um(belief, model);
            // A circle for the lag alone is put off until the errors of the run require one; so is a circle without
            // room.
            let is_put_off = |circle: PursuitCircle| {
                circle.is_for_lag || !has_room(belief, self.robot, turning, circle.way_um, room_um)
            };
            let pieces = pursuit.pieces_without(model, measured, model.interval_um, is_put_off);
            self.is_turning = pieces[0].arm == Arm::Down && pieces[0].way_um >= model.interval_um;
            *left_um -= pieces.iter().map(|piece| piece.way_um).sum::<f64>();
            if *left_um < 0.0 {
                return Progress::Failed(StopReason::TimeLimit, self.robot);
            }
            add_pieces(belief, command, self.robot, pieces, |arm| if arm == Arm::Down { turning } else { straight });
            return Progress::Driving;
        }
    }

    /// Runs straight on until the next measurement, if there is room: farther on there may be room to turn. `false`
    /// otherwise.
    fn runs_on(&mut self, belief: &Belief, command: &mut CommandSegments) -> bool {
        let (way_um, straight) = (self.model.interval_um, self.states[1]);
        let Some(pursuit) = self.pursuits.get(self.at) else { return false };
        let measured = belief.poses[self.robot];
        let left_um = self.left_um.get_or_insert_with(|| most_um(pursuit, &self.model, measured));
        if *left_um < way_um || !has_room(belief, self.robot, straight, way_um, room_um(belief, &self.model)) {
            return false;
        }
        *left_um -= way_um;
        command.add(straight, strokes(belief, self.robot, way_um));
        true
    }

    /// Whether the robot is about to begin a turn that leads into something: drift may require one where the plan has
    /// none.
    fn begins_turn_without_room(&self, belief: &Belief, measured: Pose) -> bool {
        let Some(pursuit) = self.pursuits.get(self.at).filter(|_| !self.is_turning) else { return false };
        let turn_um = pursuit.due_turn_um(&self.model, measured);
        turn_um > self.model.interval_um
            && !has_room(belief, self.robot, self.states[0], turn_um, room_um(belief, &self.model))
    }
}

/// The longest path to a stop before the drive is given up.
fn most_um(pursuit: &Pursuit, model: &SteeringModel, measured: Pose) -> f64 {
    MAX_TIMES * (pursuit.left_um(model, measured) + TAU * model.robot.turning_radius_um)
}

/// Distance that a turn must keep from other things: once begun it must be completed, and where it leads is less
/// certain than where the robot is.
fn room_um(belief: &Belief, model: &SteeringModel) -> f64 {
    belief.doubt_um(2.0 * model.robot.turning_radius_um) + belief.astray_um(model.interval_um)
}

/// Whether a robot can turn over this path in a control state.
fn has_room(belief: &Belief, robot: usize, turning: usize, way_um: f64, room_um: f64) -> bool {
    let strokes = strokes(belief, robot, way_um);
    let turn = [StrokeSegment { state: turning, strokes, sets_arms: false }];
    belief.has_room(room_um, &turn)
}

/// Control state with a robot's arm in this position: among those that keep docked arms up, the one with most strokes
/// in the legs, or else the first.
fn state(order: &MicrorobotsOrder, robot: usize, arm: Arm, docked: &[bool], legs: &[Leg]) -> Option<usize> {
    let fits = |state: &usize| {
        let arms = &order.states[*state].arms;
        let is_up = |other: usize| arms[order.robots[other].row] == Arm::Up;
        arms[order.robots[robot].row] == arm && (0..docked.len()).all(|other| !docked[other] || is_up(other))
    };
    let strokes = |state: usize| legs.iter().filter(|leg| leg.state == state).map(|leg| leg.strokes).sum::<u64>();
    (0..order.states.len()).filter(fits).min_by_key(|state| (std::cmp::Reverse(strokes(*state)), *state))
}

/// Number of legs after which a robot is nearest to a pose.
fn nearest(way: &[Pose], target: Pose, radius_um: f64) -> usize {
    let off_um = |pose: &Pose| {
        let turned_um = radius_um * wrapped_rad(pose.heading_rad - target.heading_rad).abs();
        (pose.x_um - target.x_um).hypotenuse(pose.y_um - target.y_um) + turned_um
    };
    (0..way.len()).min_by(|a, b| off_um(&way[*a]).total_cmp(&off_um(&way[*b]))).unwrap_or(0)
}
