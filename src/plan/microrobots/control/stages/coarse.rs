//! One robot driven through its stops: the gross motion of an assembly, on the way of the plan.
//!
//! A robot with errors cannot be brought to its stop exactly: it counts as there once it is measured within the cylinder that the
//! errors allow, and the drive is repeated otherwise.

use super::single::{MAX_ROUNDS, MAX_TIMES, whole_strokes};
use super::{Progress, StopReason, add_pieces, strokes};
use crate::claims::microrobots::{MicrorobotsOrder, MicrorobotsStop};
use crate::device::microrobots::{Arm, wrapped_rad};
use crate::geometry::Pose;
use crate::plan::microrobots::Leg;
use crate::plan::microrobots::control::belief::Belief;
use crate::plan::microrobots::control::{Drive, Segment};
use crate::plan::microrobots::strategy::{Cylinder, Driver, Phase, Pursuit, PursuitCircle, centres, poses_of};
use crate::real::Real;
use std::f64::consts::TAU;

/// A robot on its way through stops.
#[derive(Debug, Clone)]
pub struct DriveStage<'a> {
    pub robot: usize,
    driver: Driver<'a>,
    /// Indices of the control states in which it turns and runs straight.
    states: [usize; 2],
    /// The way to each stop.
    pursuits: Vec<Pursuit>,
    at: usize,
    rounds: usize,
    left_um: Option<f64>,
}

impl<'a> DriveStage<'a> {
    /// `None` if the device has no two states for it that keep the arms of docked robots up.
    pub fn new(
        order: &'a MicrorobotsOrder,
        (robot, start): (usize, Pose),
        stops: &[MicrorobotsStop],
        docked: &[bool],
        legs: &[Leg],
    ) -> Option<Self> {
        let driver = whole_strokes(Driver::new(order, robot)?);
        let states = [state(order, robot, Arm::Down, docked, legs)?, state(order, robot, Arm::Up, docked, legs)?];
        let way = poses_of(order, robot, start, legs);
        let (mut begins, mut pursuits) = (0, Vec::new());
        for stop in stops {
            let ends = begins + nearest(&way[begins..], stop.pose, driver.robot.turning_radius_um);
            let via_um = centres(order, robot, &way, &legs[..ends], begins);
            pursuits.push(Pursuit::new(&driver, via_um, stop.pose));
            begins = ends;
        }
        Some(DriveStage { robot, driver, states, pursuits, at: 0, rounds: 0, left_um: None })
    }

    /// How far from its stops it is measured at most when it counts as there.
    pub fn accepted(&self) -> Cylinder {
        self.driver.accepted()
    }

    pub fn proceed(&mut self, belief: &mut Belief, drive: &mut Drive) -> Progress {
        let measured = belief.poses[self.robot];
        let driver = &self.driver;
        loop {
            let Some(pursuit) = self.pursuits.get_mut(self.at) else { return Progress::Done };
            let circle_um = TAU * driver.robot.turning_radius_um;
            let left_um = self.left_um.get_or_insert(MAX_TIMES * (pursuit.left_um(driver, measured) + circle_um));
            if pursuit.phase == Phase::Arrived {
                if driver.accepted().holds(pursuit.approach, measured) {
                    (self.at, self.rounds, self.left_um) = (self.at + 1, 0, None);
                    continue;
                }
                self.rounds += 1;
                if self.rounds > MAX_ROUNDS {
                    return Progress::Failed(StopReason::LeftCylinder, self.robot);
                }
                pursuit.retry(driver, measured);
            }
            let [turning, straight] = self.states;
            // A circle for the lag alone is put off until the errors of the run ask for one, and one that there is no room for as well.
            let is_put_off = |circle: PursuitCircle| {
                let strokes = strokes(belief, self.robot, circle.way_um);
                let circle_on = [Segment { state: turning, strokes, sets_arms: false }];
                circle.is_for_lag || belief.collision_ahead(&circle_on, [None; 2]).is_some()
            };
            let pieces = pursuit.pieces_without(driver, measured, driver.interval_um, is_put_off);
            *left_um -= pieces.iter().map(|piece| piece.way_um).sum::<f64>();
            if *left_um < 0.0 {
                return Progress::Failed(StopReason::TimeLimit, self.robot);
            }
            add_pieces(belief, drive, self.robot, pieces, |arm| if arm == Arm::Down { turning } else { straight });
            return Progress::Driving;
        }
    }
}

/// The state in which a robot's arm is so: of those of the legs the one with most strokes, otherwise the first that keeps docked arms up.
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
