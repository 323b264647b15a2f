//! Gross motion: from centre to centre, always with a lag, and finally to a heading.

use super::{SteeringModel, StrategyPiece, turn};
use crate::device::microrobots::{Arm, wrapped_rad};
use crate::geometry::Pose;
use crate::real::Real;
use std::f64::consts::{PI, TAU};

/// The end of a list of pieces.
const NOTHING: StrategyPiece = StrategyPiece { arm: Arm::Up, way_um: 0.0 };

/// Purpose of the next measurement.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Turn towards a new target; a circle if it lies less than the lag ahead.
    Facing,
    /// Run towards the target; drift to the good side is corrected.
    Running,
    /// Finish the run without correction, because the target is too near.
    Finishing,
    /// Turn to the heading of the approach.
    Turning,
    /// Check whether it has arrived.
    Arrived,
}

/// The gross motion of a robot.
#[derive(Debug, Clone)]
pub struct Pursuit {
    /// Turning centres; the last one is that of the approach.
    pub centres_um: Vec<[f64; 2]>,
    pub approach: Pose,
    /// Index of the current target.
    pub next: usize,
    pub phase: Phase,
}

impl Pursuit {
    /// Gross motion via these centres; that of the approach itself is appended.
    pub fn new(model: &SteeringModel, mut via_um: Vec<[f64; 2]>, approach: Pose) -> Self {
        via_um.push(model.robot.orbit_centre_um(approach));
        Pursuit { centres_um: via_um, approach, next: 0, phase: Phase::Facing }
    }

    /// Restarts via these centres; that of the approach itself is appended.
    pub fn restart(&mut self, model: &SteeringModel, via_um: &[[f64; 2]], approach: Pose) {
        self.centres_um.clear();
        self.centres_um.extend_from_slice(via_um);
        self.centres_um.push(model.robot.orbit_centre_um(approach));
        (self.approach, self.next, self.phase) = (approach, 0, Phase::Facing);
    }

    /// Continues after a final measurement that was not accepted: turns further if that suffices, otherwise restarts.
    pub fn retry(&mut self, model: &SteeringModel, measured: Pose) {
        let ahead_rad = model.side() * wrapped_rad(self.approach.heading_rad - measured.heading_rad);
        let [x_um, y_um] = model.robot.orbit_centre_um(measured);
        let [last_x_um, last_y_um] = self.last_um();
        let is_near = (last_x_um - x_um).hypotenuse(last_y_um - y_um) <= model.left_alone_um();
        self.phase = if is_near && ahead_rad > 0.0 { Phase::Turning } else { Phase::Facing };
        self.next = if self.phase == Phase::Turning { self.centres_um.len() } else { self.centres_um.len() - 1 };
    }

    /// Changes the approach.
    pub fn aim(&mut self, model: &SteeringModel, approach: Pose) {
        self.approach = approach;
        if let Some(last_um) = self.centres_um.last_mut() {
            *last_um = model.robot.orbit_centre_um(approach);
        }
    }

    /// Whether the approach can still be changed.
    pub fn is_far(&self, model: &SteeringModel, measured: Pose) -> bool {
        let is_last = self.next + 1 == self.centres_um.len();
        let near_um = 2.0 * (model.interval_um + model.guard_um());
        self.next < self.centres_um.len() && !(is_last && self.target(model, measured).distance_um < near_um)
    }

    fn last_um(&self) -> [f64; 2] {
        self.centres_um[self.centres_um.len() - 1]
    }

    /// Returns the robot's actions until the next measurement, in order, of at most `most_um` path length; they are
    /// shorter if the robot rests for the measurement.
    pub fn pieces(&mut self, model: &SteeringModel, measured: Pose, most_um: f64) -> [StrategyPiece; 2] {
        self.pieces_without(model, measured, most_um, |_| false)
    }

    /// The same without the circles that may be put off: the robot runs on, and a circle is due later only if the
    /// errors of the run bring it past its direction.
    pub fn pieces_without(
        &mut self,
        model: &SteeringModel,
        measured: Pose,
        most_um: f64,
        is_put_off: impl Fn(PursuitCircle) -> bool,
    ) -> [StrategyPiece; 2] {
        self.skip_captured(model, measured);
        match self.phase {
            Phase::Facing | Phase::Running => self.towards(model, measured, most_um, is_put_off),
            Phase::Finishing => self.finish(model, measured, most_um),
            Phase::Turning => self.last_turn(model, measured, most_um),
            Phase::Arrived => [NOTHING; 2],
        }
    }

    /// Nominal turn that is due before the robot runs on, in micrometres of its path.
    pub fn due_turn_um(&self, model: &SteeringModel, measured: Pose) -> f64 {
        match self.phase {
            Phase::Facing | Phase::Running if self.next < self.centres_um.len() => {
                let target = self.target(model, measured);
                let turn_rad = self.turn_rad(model, &target);
                let may_wait = target.circle(model, turn_rad).is_some();
                if may_wait { 0.0 } else { turn_rad * model.robot.turning_radius_um }
            }
            Phase::Facing | Phase::Running | Phase::Finishing | Phase::Turning | Phase::Arrived => 0.0,
        }
    }

    fn skip_captured(&mut self, model: &SteeringModel, measured: Pose) {
        while self.phase == Phase::Facing && self.target(model, measured).distance_um <= model.left_alone_um() {
            self.pass();
        }
    }

    fn pass(&mut self) {
        self.next += 1;
        self.phase = if self.next < self.centres_um.len() { Phase::Facing } else { Phase::Turning };
    }

    fn target(&self, model: &SteeringModel, measured: Pose) -> PursuitTarget {
        let [x_um, y_um] = model.robot.orbit_centre_um(measured);
        let [to_x_um, to_y_um] = self.centres_um[self.next];
        let (dx_um, dy_um) = (to_x_um - x_um, to_y_um - y_um);
        let ahead_rad = turn(model.side() * (dy_um.arc_tangent_over(dx_um) - measured.heading_rad));
        // A target behind by rounding only does not lie a full circle ahead.
        let ahead_rad = if ahead_rad > TAU - 1e-9 { 0.0 } else { ahead_rad };
        PursuitTarget { distance_um: dx_um.hypotenuse(dy_um), ahead_rad }
    }

    fn towards(
        &mut self,
        model: &SteeringModel,
        measured: Pose,
        most_um: f64,
        is_put_off: impl Fn(PursuitCircle) -> bool,
    ) -> [StrategyPiece; 2] {
        let target = self.target(model, measured);
        let turn_rad = self.turn_rad(model, &target);
        let turn_rad = if target.circle(model, turn_rad).is_some_and(is_put_off) { 0.0 } else { turn_rad };
        let is_near = target.distance_um <= model.interval_um + model.guard_um();
        let most_um = if is_near { most_um.min(model.near_interval_um) } else { most_um };
        let turn_um = turn_rad / ((1.0 + model.errors.speed_ratio) * model.steepest_per_um());
        let turning = StrategyPiece { arm: Arm::Down, way_um: turn_um.min(most_um) };
        if turn_um > most_um {
            return [turning, NOTHING];
        }
        let run_um = (target.distance_um * (target.ahead_rad - turn_rad).cosine()).max(0.0);
        let left_um = most_um - turn_um;
        self.phase = if run_um <= left_um + model.guard_um() { Phase::Finishing } else { Phase::Running };
        if run_um <= left_um {
            self.pass();
        }
        [turning, StrategyPiece { arm: Arm::Up, way_um: run_um.min(left_um) }]
    }

    /// Angle to turn; never beyond the lag, whatever the errors.
    fn turn_rad(&self, model: &SteeringModel, target: &PursuitTarget) -> f64 {
        let lag_rad = model.lag_rad(target.distance_um);
        let is_noise = target.ahead_rad >= TAU - model.aim_error_rad(target.distance_um) - 1e-9;
        let is_behind = self.phase == Phase::Facing && lag_rad > target.ahead_rad + 1e-9;
        if is_behind {
            target.ahead_rad + TAU - lag_rad
        } else if is_noise && self.phase == Phase::Running {
            0.0
        } else {
            (target.ahead_rad - lag_rad).max(0.0)
        }
    }

    fn finish(&mut self, model: &SteeringModel, measured: Pose, most_um: f64) -> [StrategyPiece; 2] {
        let target = self.target(model, measured);
        let run_um = (target.distance_um * target.ahead_rad.cosine()).max(0.0);
        if run_um <= most_um {
            self.pass();
        }
        [StrategyPiece { arm: Arm::Up, way_um: run_um.min(most_um) }, NOTHING]
    }

    fn last_turn(&mut self, model: &SteeringModel, measured: Pose, most_um: f64) -> [StrategyPiece; 2] {
        let left_rad = model.side() * (self.approach.heading_rad - measured.heading_rad);
        let is_over = turn(-left_rad) <= model.accepted().heading_rad;
        let turn_um = if is_over { 0.0 } else { turn(left_rad) * model.robot.turning_radius_um };
        if turn_um <= model.near_interval_um {
            self.phase = Phase::Arrived;
            return [StrategyPiece { arm: Arm::Down, way_um: turn_um }, NOTHING];
        }
        let way_um = (turn_um - model.near_interval_um / 2.0).min(most_um);
        [StrategyPiece { arm: Arm::Down, way_um }, NOTHING]
    }

    /// Lower bound on the remaining path length, for the most favourable heading.
    pub fn least_um(&self, model: &SteeringModel, pose: Pose) -> f64 {
        let [x_um, y_um] = model.robot.orbit_centre_um(pose);
        let Some([to_x_um, to_y_um]) = self.centres_um.get(self.next) else { return self.left_um(model, pose) };
        let lag_rad = model.lag_rad((to_x_um - x_um).hypotenuse(to_y_um - y_um));
        let heading_rad = (to_y_um - y_um).arc_tangent_over(to_x_um - x_um) - model.side() * (lag_rad + 1e-6);
        let (sin, cos) = heading_rad.sine_cosine();
        let arm_um = model.side() * model.robot.turning_radius_um;
        self.left_um(model, Pose { x_um: x_um + arm_um * sin, y_um: y_um - arm_um * cos, heading_rad })
    }

    /// Remaining nominal path length from a pose, assuming that corrections cost nothing except the circles they cause.
    pub fn left_um(&self, model: &SteeringModel, pose: Pose) -> f64 {
        let radius_um = model.robot.turning_radius_um;
        let [mut x_um, mut y_um] = model.robot.orbit_centre_um(pose);
        let (mut heading_rad, mut way_um) = (pose.heading_rad, 0.0);
        // A target behind by less than the noise does not lie a full circle ahead.
        let ahead = |to_rad: f64, from_rad: f64, slack_rad: f64| {
            let turned_rad = turn(model.side() * (to_rad - from_rad));
            if turned_rad > TAU - slack_rad { turned_rad - TAU } else { turned_rad }
        };
        for [to_x_um, to_y_um] in self.centres_um.iter().skip(self.next) {
            let (dx_um, dy_um) = (to_x_um - x_um, to_y_um - y_um);
            let distance_um = dx_um.hypotenuse(dy_um);
            if distance_um > model.left_alone_um() {
                let direction_rad = dy_um.arc_tangent_over(dx_um);
                let lag_rad = model.lag_rad(distance_um);
                let turned_rad = match self.phase {
                    // A target within the lag costs a circle.
                    Phase::Facing => lag_rad + ahead(direction_rad, heading_rad + model.side() * lag_rad, 0.0),
                    Phase::Running | Phase::Finishing | Phase::Turning | Phase::Arrived => {
                        ahead(direction_rad, heading_rad, 0.5)
                    }
                };
                way_um += radius_um * turned_rad + distance_um;
                heading_rad = direction_rad;
            }
            (x_um, y_um) = (*to_x_um, *to_y_um);
        }
        let slack_rad = model.accepted().heading_rad;
        way_um + radius_um * ahead(self.approach.heading_rad, heading_rad, slack_rad)
    }
}

impl SteeringModel<'_> {
    /// Largest curvature that the errors allow.
    fn steepest_per_um(&self) -> f64 {
        1.0 / self.robot.turning_radius_um + self.errors.turning_rad_per_um
    }
}

/// A circle, since a robot turns to one side only.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PursuitCircle {
    /// Nominal, in micrometres of the robot's path.
    pub way_um: f64,
    /// The target lies ahead by less than the lag, so it may be reached without the circle.
    pub is_for_lag: bool,
}

/// Target of a turning centre.
struct PursuitTarget {
    distance_um: f64,
    /// Angle to turn until the heading points to it; from 0 to a full turn.
    ahead_rad: f64,
}

impl PursuitTarget {
    /// The circle that a turn towards the target amounts to, if the target lies almost ahead.
    fn circle(&self, model: &SteeringModel, turn_rad: f64) -> Option<PursuitCircle> {
        let lag_rad = model.lag_rad(self.distance_um);
        let is_ahead = self.ahead_rad < lag_rad;
        let is_circle = turn_rad > PI && (is_ahead || self.ahead_rad > TAU - 2.0 * lag_rad);
        is_circle.then_some(PursuitCircle { way_um: turn_rad * model.robot.turning_radius_um, is_for_lag: is_ahead })
    }
}
