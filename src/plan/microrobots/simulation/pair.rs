//! The first two robots, which are brought together.

use super::single::MAX_ROUNDS;
use super::trial::{ContactManners, FailureReason, Met, Trial, TrialFailure, motion};
use crate::device::microrobots::{Arm, Robot, wrapped_rad};
use crate::geometry::Pose;
use crate::plan::microrobots::AssemblyStage;
use crate::plan::microrobots::strategy::{
    Couple, Episode, Phase, Pursuit, SHARES, StrategySolid, body, centres, poses_of, steered,
};
use crate::real::Real;
use std::f64::consts::PI;

/// Intervals of one gross motion.
const MAX_INTERVALS: usize = 20_000;

/// Share of the distance of self-alignment that is used before the fine motion.
const ALIGNED_SHARE: f64 = 0.5;

/// Bisection steps to a contact; leaves an error far below a stroke.
const HALVINGS: usize = 40;

/// The two robots of a stage.
struct PairMeeting<'a> {
    couple: Couple<'a>,
    robots: [usize; 2],
    /// Both turn, only the second turns, none of the two turns.
    states: [usize; 3],
    goals: [Pose; 2],
}

/// Stage 1, stage 2, and again if they do not come at once; then the fine motion.
pub fn run(trial: &mut Trial, episode: &Episode) -> Result<(), TrialFailure> {
    let &AssemblyStage::Pair { first, second, states, intermediate, approach, goals } = episode.stage else {
        return Ok(());
    };
    let Some(couple) = Couple::new(trial.order, [first, second], intermediate, approach) else { return Ok(()) };
    let mut meeting = PairMeeting { couple, robots: [first, second], states, goals };
    trial.begin(vec![first, second]);
    let [mut first_via_um, mut second_via_um] = meeting.bring_near(trial, episode)?;
    for round in 0..MAX_ROUNDS {
        let via_um = [std::mem::take(&mut first_via_um), std::mem::take(&mut second_via_um)];
        meeting.stage_1(trial, &via_um, round)?;
        meeting.stage_2(trial, &via_um[1])?;
        if meeting.is_within_reach(trial) {
            return meeting.dock(trial);
        }
    }
    Err((second, FailureReason::LeftCylinder))
}

impl PairMeeting<'_> {
    /// Brings the second robot to the orbit from which it is driven, if it is not there yet; returns the via centres of both.
    fn bring_near(&self, trial: &mut Trial, episode: &Episode) -> Result<[Vec<[f64; 2]>; 2], TrialFailure> {
        let [first, second] = self.robots;
        let Some(&[_, ends]) = episode.gross.first() else { return Ok([Vec::new(), Vec::new()]) };
        let via_um = |at: usize| episode.via_um.get(at).cloned().unwrap_or_default();
        let row = trial.order.robots[second].row;
        let runs = |leg: &crate::plan::microrobots::Leg| trial.order.states[leg.state].arms[row] == Arm::Up;
        let Some(begins) = episode.legs[..ends].iter().rposition(runs).map(|leg| leg + 1) else {
            return Ok([via_um(0), via_um(1)]);
        };
        let way = poses_of(trial.order, second, episode.poses[second], &episode.legs[..begins]);
        let halt = way[begins];
        let via = centres(trial.order, second, &way, &episode.legs[..begins], 0);
        let driver = &self.couple.drivers[1];
        let mut pursuit = Pursuit::new(driver, via, halt);
        self.pursue(trial, 1, &mut pursuit, |pursuit| pursuit.phase == Phase::Turning)?;
        let way = poses_of(trial.order, first, episode.poses[first], &episode.legs[..ends]);
        Ok([centres(trial.order, first, &way, &episode.legs[..ends], begins), via_um(1)])
    }

    fn state(&self, which: usize, arm: Arm) -> usize {
        match (which, arm) {
            (0, Arm::Down) => self.states[0],
            (0, Arm::Up) | (_, Arm::Down) => self.states[1],
            (_, Arm::Up) => self.states[2],
        }
    }

    fn measured(&self, trial: &Trial) -> [Pose; 2] {
        self.robots.map(|robot| trial.measured(robot))
    }

    /// Drives one of the two until a condition holds.
    fn pursue(
        &self,
        trial: &mut Trial,
        which: usize,
        pursuit: &mut Pursuit,
        is_done: impl Fn(&Pursuit) -> bool,
    ) -> Result<(), TrialFailure> {
        for _ in 0..MAX_INTERVALS {
            if is_done(pursuit) {
                return Ok(());
            }
            trial.tick();
            self.interval(trial, which, pursuit)?;
        }
        Err((self.robots[which], FailureReason::TimeLimit))
    }

    fn interval(&self, trial: &mut Trial, which: usize, pursuit: &mut Pursuit) -> Result<(), TrialFailure> {
        let driver = &self.couple.drivers[which];
        let measured = trial.measured(self.robots[which]);
        for piece in pursuit.pieces(driver, measured, driver.interval_um) {
            trial.drive(self.state(which, piece.arm), self.robots[which], piece.way_um, ContactManners::Apart)?;
        }
        Ok(())
    }

    /// The first robot to its line, while the second orbits, until it is there in time.
    fn stage_1(&mut self, trial: &mut Trial, via_um: &[Vec<[f64; 2]>; 2], round: usize) -> Result<(), TrialFailure> {
        let (first, accepted) = (self.robots[0], self.couple.drivers[0].accepted());
        let second = Pursuit::new(&self.couple.drivers[1], via_um[1].clone(), self.couple.approach[1]);
        self.couple.give_time(&second, trial.measured(self.robots[1]), round);
        let mut pursuit = Pursuit::new(&self.couple.drivers[0], via_um[0].clone(), self.couple.intermediate());
        let mut rounds = 0;
        for _ in 0..MAX_INTERVALS {
            trial.tick();
            let measured = self.measured(trial);
            if pursuit.phase == Phase::Arrived {
                let late_um = self.couple.late_um([&pursuit, &second], measured);
                let is_there = accepted.holds(pursuit.approach, measured[0]);
                if is_there && late_um.abs() <= self.couple.begun_um() {
                    return Ok(());
                }
                rounds += 1;
                if rounds > MAX_ROUNDS {
                    return Err((first, FailureReason::LeftCylinder));
                }
                match is_there {
                    true => {
                        let via_um = self.couple.racetrack(late_um);
                        pursuit = Pursuit::new(&self.couple.drivers[0], via_um, self.couple.intermediate());
                    }
                    false => pursuit.retry(&self.couple.drivers[0], measured[0]),
                }
            } else if pursuit.is_far(&self.couple.drivers[0], measured[0]) {
                self.couple.slide(&mut pursuit, &second, measured);
            }
            self.interval(trial, 0, &mut pursuit)?;
        }
        Err((first, FailureReason::TimeLimit))
    }

    /// The second robot to its approach, while the first runs straight; given up when the first has come too far.
    fn stage_2(&self, trial: &mut Trial, via_um: &[[f64; 2]]) -> Result<(), TrialFailure> {
        let (driver, first) = (&self.couple.drivers[1], self.robots[0]);
        let accepted = driver.accepted();
        let mut pursuit = Pursuit::new(driver, via_um.to_vec(), self.couple.approach[1]);
        for _ in 0..MAX_INTERVALS {
            trial.tick();
            let measured = self.measured(trial);
            let is_passed = self.couple.run_um(trial.measured(first)) < -self.couple.missed_um;
            let is_there = pursuit.phase == Phase::Arrived && accepted.holds(pursuit.approach, measured[1]);
            if is_there || is_passed {
                return Ok(());
            }
            if pursuit.phase == Phase::Arrived {
                pursuit.retry(driver, measured[1]);
            }
            if pursuit.phase == Phase::Facing && self.couple.has_time(&pursuit, measured) {
                trial.drive(self.states[1], self.robots[1], driver.interval_um, ContactManners::Apart)?;
                continue;
            }
            self.interval(trial, 1, &mut pursuit)?;
        }
        Err((self.robots[1], FailureReason::TimeLimit))
    }

    /// Whether the two arrive together, and the error that fine motion cannot correct is within self-alignment.
    fn is_within_reach(&self, trial: &Trial) -> bool {
        let measured = self.measured(trial);
        let frames = self.couple.frames(self.goals, measured);
        let aside_um =
            [0, 1].map(|at| steered(&self.couple.drivers[at], &frames[at], measured[at], SHARES[at]).1.abs());
        let most_um = ALIGNED_SHARE * trial.order.facts.docking.self_aligning_um;
        self.couple.run_um(measured[0]).abs() <= self.couple.missed_um && aside_um[0] + aside_um[1] <= most_um
    }

    fn dock(&self, trial: &mut Trial) -> Result<(), TrialFailure> {
        let driver = &self.couple.drivers[0];
        let interval_um = driver.fine_interval_um;
        let (mut shares, mut is_kept) = ([0.0; 2], false);
        let mut left_um = 4.0 * trial.order.facts.fine.length_um;
        while left_um > 0.0 {
            trial.tick();
            if !is_kept {
                let measured = self.measured(trial);
                let frames = self.couple.frames(self.goals, measured);
                shares = [0, 1].map(|at| steered(&self.couple.drivers[at], &frames[at], measured[at], SHARES[at]).0);
                is_kept = frames[0].gap_um(frames[0].seen(measured[0])) < interval_um + driver.kept_um;
            }
            let mut way_um = 0.0;
            while way_um < interval_um - 1e-9 {
                way_um += driver.cycle_um;
                for (state, piece_um) in self.cycle(shares, driver.cycle_um) {
                    if self.touch(trial, state, piece_um)? {
                        return self.judge(trial);
                    }
                }
            }
            left_um -= way_um;
        }
        Err((self.robots[0], FailureReason::MissedCone))
    }

    /// A cycle of three primitives, half before and half after the straight one.
    fn cycle(&self, [first, second]: [f64; 2], cycle_um: f64) -> [(usize, f64); 5] {
        let [both, one, none] = self.states;
        let (turning_um, second_um) = (first * cycle_um / 2.0, (second - first) * cycle_um / 2.0);
        let straight_um = (1.0 - second) * cycle_um;
        [(both, turning_um), (one, second_um), (none, straight_um), (one, second_um), (both, turning_um)]
    }

    /// Drives a piece, or until the two touch.
    fn touch(&self, trial: &mut Trial, state: usize, way_um: f64) -> Result<bool, TrialFailure> {
        let [first, second] = self.robots;
        let facts = self.robots.map(|robot| trial.order.robot(robot));
        let touches = |trial: &Trial, way_um: f64| {
            let strokes = way_um / facts[0].step_um;
            let other = StrategySolid::standing(facts[1], trial.gone(second, state, strokes));
            other.distance_um(&body(facts[0], trial.gone(first, state, strokes), 0.0), 0.0) <= 0.0
        };
        if !touches(trial, way_um) {
            trial.drive(state, first, way_um, ContactManners::Docking)?;
            return Ok(false);
        }
        let (mut low_um, mut high_um) = (0.0, way_um);
        for _ in 0..HALVINGS {
            let middle_um = (low_um + high_um) / 2.0;
            if touches(trial, middle_um) { high_um = middle_um } else { low_um = middle_um }
        }
        trial.drive(state, first, low_um, ContactManners::Docking)?;
        Ok(true)
    }

    fn judge(&self, trial: &mut Trial) -> Result<(), TrialFailure> {
        let docking = trial.order.facts.docking;
        let poses = self.robots.map(|robot| trial.poses[robot]);
        let facts = self.robots.map(|robot| trial.order.robot(robot));
        let off_rad = [0, 1].map(|at| wrapped_rad(poses[at].heading_rad - self.goals[at].heading_rad));
        let tilt_rad = (off_rad[0] + off_rad[1]) / 2.0;
        let noses = [0, 1].map(|at| nose(facts[at], poses[at]));
        let nominal = middle([0, 1].map(|at| nose(facts[at], self.goals[at])));
        let axis_rad = self.goals[0].heading_rad + tilt_rad;
        let (dx_um, dy_um) = (noses[1][0] - noses[0][0], noses[1][1] - noses[0][1]);
        let across_um = dy_um * axis_rad.cosine() - dx_um * axis_rad.sine();
        let met = middle(noses);
        let incidence_rad = wrapped_rad(poses[0].heading_rad - poses[1].heading_rad - PI);
        let along_um = (met[0] - nominal[0]).hypotenuse(met[1] - nominal[1]);
        for robot in self.robots {
            trial.met.push(Met { robot, across_um, along_um, incidence_rad, heading_rad: tilt_rad });
        }
        if incidence_rad.abs() > docking.self_aligning_rad {
            return Err((self.robots[0], FailureReason::Angle));
        }
        if across_um.abs() > docking.self_aligning_um {
            return Err((self.robots[0], FailureReason::Misplaced));
        }
        let at = |[x_um, y_um]: [f64; 2], heading_rad: f64| Pose { x_um, y_um, heading_rad };
        trial.structure = motion(at(nominal, 0.0), at(met, tilt_rad));
        for (robot, goal) in self.robots.into_iter().zip(self.goals) {
            trial.poses[robot] = trial.moved_along(goal);
            trial.docked[robot] = true;
        }
        Ok(())
    }
}

/// The middle of a robot's front.
fn nose(robot: &Robot, pose: Pose) -> [f64; 2] {
    let (sin, cos) = pose.heading_rad.sine_cosine();
    [pose.x_um + robot.length_um / 2.0 * cos, pose.y_um + robot.length_um / 2.0 * sin]
}

fn middle([a, b]: [[f64; 2]; 2]) -> [f64; 2] {
    [(a[0] + b[0]) / 2.0, (a[1] + b[1]) / 2.0]
}
