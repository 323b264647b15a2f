//! A robot that is brought to a structure.

use super::trial::{ContactManners, FailureReason, Met, Trial, TrialFailure};
use crate::device::microrobots::Arm;
use crate::geometry::Pose;
use crate::plan::microrobots::strategy::{
    Driver, Episode, GoalFrame, Phase, Pursuit, StrategyPiece, edge_gap_um, steered,
};
use crate::real::Real;
use std::f64::consts::TAU;

/// So often the end of the gross motion is tried.
pub const MAX_ROUNDS: usize = 20;

/// Greatest length of a gross motion, as a multiple of its nominal path.
const MAX_TIMES: f64 = 20.0;

/// Bisection steps to a contact; leaves an error far below a stroke.
const HALVINGS: usize = 40;

/// The robot of a stage.
pub struct SingleStage {
    pub robot: usize,
    /// Indices of the control states in which it turns and runs straight.
    pub states: [usize; 2],
    pub approach: Pose,
    pub goal: Pose,
}

impl SingleStage {
    fn state(&self, arm: Arm) -> usize {
        match arm {
            Arm::Down => self.states[0],
            Arm::Up => self.states[1],
        }
    }

    /// Gross motion, then fine motion.
    pub fn run(&self, trial: &mut Trial, episode: &Episode) -> Result<(), TrialFailure> {
        let Some(driver) = Driver::new(trial.order, self.robot) else { return Ok(()) };
        trial.begin(vec![self.robot]);
        let [approach, goal] = [self.approach, self.goal].map(|pose| trial.moved_along(pose));
        let frame = GoalFrame::new(driver.robot, goal, self.gap_um(trial, goal));
        self.approach(trial, &driver, Pursuit::new(&driver, episode.via_um[0].clone(), approach), &frame)?;
        self.dock(trial, &driver, &frame)
    }

    fn gap_um(&self, trial: &Trial, goal: Pose) -> f64 {
        let order = trial.order;
        let docked = (0..trial.poses.len()).filter(|robot| trial.docked[*robot]);
        let bodies: Vec<_> = docked.map(|robot| (order.robot(robot), trial.poses[robot])).collect();
        // Others may lie apart by their tolerance already.
        let tolerance_um = 3.0 * order.facts.docking.tolerance_um;
        edge_gap_um(order.robot(self.robot), goal, &bodies, tolerance_um).unwrap_or(0.0)
    }

    fn approach(
        &self,
        trial: &mut Trial,
        driver: &Driver,
        mut pursuit: Pursuit,
        frame: &GoalFrame,
    ) -> Result<(), TrialFailure> {
        let circle_um = TAU * driver.robot.turning_radius_um;
        let mut left_um = MAX_TIMES * (pursuit.left_um(driver, trial.poses[self.robot]) + circle_um);
        let mut rounds = 0;
        loop {
            trial.tick();
            let measured = trial.measured(self.robot);
            if pursuit.phase == Phase::Arrived {
                let is_there = driver.accepted().holds(pursuit.approach, measured);
                if is_there && steered(driver, frame, measured, [0.0, 1.0]).1 == 0.0 {
                    return Ok(());
                }
                rounds += 1;
                if rounds > MAX_ROUNDS {
                    let reason = if is_there { FailureReason::MissedCone } else { FailureReason::LeftCylinder };
                    return Err((self.robot, reason));
                }
                pursuit.retry(driver, measured);
            }
            for piece in pursuit.pieces(driver, measured, driver.interval_um) {
                left_um -= piece.way_um;
                trial.drive(self.state(piece.arm), self.robot, piece.way_um, ContactManners::Apart)?;
            }
            if left_um < 0.0 {
                return Err((self.robot, FailureReason::TimeLimit));
            }
        }
    }

    fn dock(&self, trial: &mut Trial, driver: &Driver, frame: &GoalFrame) -> Result<(), TrialFailure> {
        let interval_um = driver.fine_interval_um;
        let (mut share, mut aside_um, mut is_kept) = (0.0, 0.0, false);
        let mut left_um = 4.0 * trial.order.facts.fine.length_um;
        while left_um > 0.0 {
            trial.tick();
            if !is_kept {
                let measured = trial.measured(self.robot);
                (share, aside_um) = steered(driver, frame, measured, [0.0, 1.0]);
                is_kept = frame.gap_um(frame.seen(measured)) < interval_um + driver.kept_um;
            }
            let mut way_um = 0.0;
            while way_um < interval_um - 1e-9 {
                way_um += driver.cycle_um;
                for piece in cycle(share, driver.cycle_um) {
                    if self.touches(trial, frame, piece)? {
                        return self.judge(trial, frame, aside_um);
                    }
                }
            }
            left_um -= way_um;
        }
        Err((self.robot, FailureReason::MissedCone))
    }

    /// Drives a piece, or until the robot touches the edge.
    fn touches(&self, trial: &mut Trial, frame: &GoalFrame, piece: StrategyPiece) -> Result<bool, TrialFailure> {
        let state = self.state(piece.arm);
        let step_um = trial.order.robot(self.robot).step_um;
        let gap_um =
            |trial: &Trial, way_um: f64| frame.gap_um(frame.seen(trial.gone(self.robot, state, way_um / step_um)));
        if gap_um(trial, piece.way_um) > 0.0 {
            trial.drive(state, self.robot, piece.way_um, ContactManners::Docking)?;
            return Ok(false);
        }
        let (mut low_um, mut high_um) = (0.0, piece.way_um);
        for _ in 0..HALVINGS {
            let middle_um = (low_um + high_um) / 2.0;
            if gap_um(trial, middle_um) > 0.0 { low_um = middle_um } else { high_um = middle_um }
        }
        trial.drive(state, self.robot, low_um, ContactManners::Docking)?;
        Ok(true)
    }

    fn judge(&self, trial: &mut Trial, frame: &GoalFrame, aside_um: f64) -> Result<(), TrialFailure> {
        let docking = trial.order.facts.docking;
        let contact = frame.contact(frame.seen(trial.poses[self.robot]), 0.0);
        let ahead_um = frame.edge_um - trial.order.robot(self.robot).length_um / 2.0;
        let flat = frame.placed(Pose { x_um: ahead_um, y_um: contact.across_um, heading_rad: 0.0 });
        let (dx_um, dy_um) = (flat.x_um - self.goal.x_um, flat.y_um - self.goal.y_um);
        trial.met.push(Met {
            robot: self.robot,
            across_um: contact.across_um,
            along_um: dx_um * self.goal.heading_rad.cosine() + dy_um * self.goal.heading_rad.sine(),
            incidence_rad: contact.incidence_rad,
            heading_rad: crate::device::microrobots::wrapped_rad(flat.heading_rad - self.goal.heading_rad),
        });
        if contact.incidence_rad.abs() > docking.sticking_rad {
            return Err((self.robot, FailureReason::Angle));
        }
        if contact.across_um.abs() > docking.tolerance_um {
            let reason = if aside_um == 0.0 { FailureReason::Misplaced } else { FailureReason::MissedCone };
            return Err((self.robot, reason));
        }
        trial.poses[self.robot] = flat;
        trial.docked[self.robot] = true;
        Ok(())
    }
}

/// A cycle of the fine motion; its turns lie half before and half after, so that they do not lead or lag.
pub fn cycle(share: f64, cycle_um: f64) -> [StrategyPiece; 3] {
    let turning = StrategyPiece { arm: Arm::Down, way_um: share * cycle_um / 2.0 };
    [turning, StrategyPiece { arm: Arm::Up, way_um: (1.0 - share) * cycle_um }, turning]
}
