//! One trial: true poses of the robots, their measurements, and the time.

mod contact;

use super::area::AreaMatch;
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::{Arm, Errors};
use crate::geometry::Pose;
use crate::plan::microrobots::AssemblyStage;
use crate::plan::microrobots::control::{ControlPhase, Stop, StopReason, StrokeSegment};
use crate::plan::microrobots::strategy::{BodyCorners, StrategySolid, bent, body};
use crate::random::SplitMix64;
use crate::real::Real;
use contact::NextDocking;
use nalgebra::{Isometry2, Vector2};
use serde::Serialize;
use std::f64::consts::TAU;

/// Path between two comparisons of bodies, in micrometres.
const STRIDE_UM: f64 = 10.0;

/// Reason why a trial failed.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureReason {
    /// It had not reached the start of the fine motion after the greatest number of rounds.
    LeftCylinder,
    /// The goal was not within the reach of the fine motion.
    MissedCone,
    /// It met its structure farther from its place than the docking tolerance, though its goal was within reach.
    Misplaced,
    /// It met its structure at an angle at which it does not align itself.
    Angle,
    /// It ran into something of this name.
    Collision(String),
    /// It took too long.
    TimeLimit,
    /// The controller counted it as docked, but it was not.
    NotDocked,
    /// It was not seen, or measured where it cannot be, too many times in a row.
    Unmeasured,
    /// It did not follow the commands too many times in a row.
    Astray,
    /// The controller stopped because it would have driven the robot into something of this name.
    Blocked(String),
    /// The controller stopped for lack of measurements.
    Silence,
}

impl FailureReason {
    /// Clause about the robot: what happened to it.
    pub fn clause(&self) -> String {
        match self {
            FailureReason::LeftCylinder => "it did not reach the start of its fine motion".to_owned(),
            FailureReason::MissedCone => "its goal was out of reach of the fine motion".to_owned(),
            FailureReason::Misplaced => "it docked too far from its place".to_owned(),
            FailureReason::Angle => "it met its structure at too large an angle".to_owned(),
            FailureReason::Collision(thing) => format!("it ran into {thing}"),
            FailureReason::TimeLimit => "it took too long".to_owned(),
            FailureReason::NotDocked => "the controller took it for docked, but it was not".to_owned(),
            FailureReason::Unmeasured => "it was too often not measured, or measured where it cannot be".to_owned(),
            FailureReason::Astray => "it did not follow the commands".to_owned(),
            FailureReason::Blocked(thing) => format!("it was stopped before it ran into {thing}"),
            FailureReason::Silence => "no measurements arrived".to_owned(),
        }
    }

    /// Failure that corresponds to a controller's reason to give up.
    fn of(stop: Stop, order: &MicrorobotsOrder) -> FailureReason {
        match stop.reason {
            StopReason::LeftCylinder => FailureReason::LeftCylinder,
            StopReason::MissedCone => FailureReason::MissedCone,
            StopReason::Misplaced => FailureReason::Misplaced,
            StopReason::TimeLimit => FailureReason::TimeLimit,
            StopReason::Unseen | StopReason::Doubtful => FailureReason::Unmeasured,
            StopReason::Astray | StopReason::Moved => FailureReason::Astray,
            StopReason::Blocked => {
                FailureReason::Blocked(stop.in_the_way.map_or("something", |thing| thing.name(order)).to_owned())
            }
            StopReason::Silence
            | StopReason::Closed
            | StopReason::Clock
            | StopReason::Garbled
            | StopReason::Interrupted
            | StopReason::Unread
            | StopReason::Unrecorded => FailureReason::Silence,
        }
    }
}

/// Which robot failed, why and when.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TrialFailure {
    /// Index into the order's robots.
    pub robot: usize,
    pub reason: FailureReason,
    /// Index into the order's steps.
    pub step: usize,
    /// Phase of the controller.
    pub phase: ControlPhase,
}

impl TrialFailure {
    /// The failure of a trial that a controller gave up.
    pub fn stopped(stop: Stop, order: &MicrorobotsOrder) -> TrialFailure {
        let reason = FailureReason::of(stop, order);
        TrialFailure { robot: stop.robot.unwrap_or(0), reason, step: stop.step, phase: stop.phase }
    }
}

/// How a robot met its structure.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactRecord {
    pub robot: usize,
    pub across_um: f64,
    pub along_um: f64,
    pub incidence_rad: f64,
    pub heading_rad: f64,
}

/// A trial that is over.
#[derive(Debug, Clone, PartialEq)]
pub struct EndedTrial {
    pub contacts: Vec<ContactRecord>,
    pub failure: Option<TrialFailure>,
    pub time_ns: u64,
    /// Area match of a trial that succeeded.
    pub area: Option<AreaMatch>,
}

/// Manner in which errors are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Manner {
    /// Each robot keeps an extreme of each error.
    Corner,
    /// Each robot takes another extreme in each interval.
    Shaken,
    /// A part that stays and a part that changes.
    Mixed,
}

/// Errors of a robot's figures in this interval.
#[derive(Debug, Clone, Copy, Default)]
struct Drift {
    speed_bias: f64,
    curl_bias: f64,
    speed: f64,
    curl: f64,
    /// Errors of the measurement, as shares of the bounds: place, direction, heading.
    noise: [f64; 3],
}

/// A trial in progress.
pub struct Trial<'a> {
    pub order: &'a MicrorobotsOrder,
    pub errors: Errors,
    pub poses: Vec<Pose>,
    pub docked: Vec<bool>,
    /// Motion from the planned place of the structure to its actual one.
    pub structure: Isometry2<f64>,
    pub contacts: Vec<ContactRecord>,
    obstacles: &'a [StrategySolid],
    /// Bodies of docked robots.
    bodies: Vec<StrategySolid>,
    /// Stages in which robots dock, in order of time, and the number of them that are over.
    stages: &'a [&'a AssemblyStage],
    over: usize,
    next: Option<NextDocking>,
    drifts: Vec<Drift>,
    /// Robots that do not move until the next measurement.
    pub stalled: Vec<bool>,
    manner: Manner,
    random: SplitMix64,
    time_ns: f64,
    spent_ns: f64,
}

/// The bed before a trial.
#[derive(Debug, Clone, Copy)]
pub struct TrialStart<'a> {
    pub obstacles: &'a [StrategySolid],
    /// Stages in which robots dock, in order of time.
    pub stages: &'a [&'a AssemblyStage],
    pub poses: &'a [Pose],
    pub docked: &'a [bool],
}

/// A robot, and why it failed.
type Mishap = (usize, FailureReason);

impl<'a> Trial<'a> {
    pub fn new(order: &'a MicrorobotsOrder, errors: Errors, start: TrialStart<'a>, seed: u64, index: u64) -> Self {
        let mut random = SplitMix64::stream(seed, index);
        let manner = [Manner::Corner, Manner::Shaken, Manner::Mixed, Manner::Mixed][(index % 4) as usize];
        let drifts = start.poses.iter().map(|_| Drift::biased(&mut random, manner, &errors)).collect();
        let mut trial = Trial {
            order,
            errors,
            poses: start.poses.to_vec(),
            docked: start.docked.to_vec(),
            structure: Isometry2::identity(),
            contacts: Vec::new(),
            obstacles: start.obstacles,
            bodies: Vec::new(),
            stages: start.stages,
            over: 0,
            next: None,
            drifts,
            stalled: vec![false; start.poses.len()],
            manner,
            random,
            time_ns: 0.0,
            spent_ns: 0.0,
        };
        trial.begin();
        trial
    }

    /// Begins the next stage, in which other robots may dock.
    fn begin(&mut self) {
        let standing = |robot: usize| StrategySolid::standing(self.order.robot(robot), self.poses[robot]);
        self.bodies = (0..self.poses.len()).filter(|robot| self.docked[*robot]).map(standing).collect();
        let stage = self.stages.get(self.over).copied();
        self.next = stage.and_then(|stage| NextDocking::of(self, stage));
    }

    /// Bodies of docked robots.
    pub fn docked_bodies(&self) -> impl Iterator<Item = &StrategySolid> {
        self.bodies.iter()
    }

    /// Ends an interval: the next measurement is due.
    pub fn tick(&mut self) {
        self.time_ns += self.spent_ns.max(if self.spent_ns > 0.0 { self.errors.replan_ns as f64 } else { 0.0 });
        self.spent_ns = 0.0;
        for drift in &mut self.drifts {
            drift.draw(&mut self.random, self.manner, &self.errors);
        }
    }

    pub fn time_ns(&self) -> u64 {
        (self.time_ns + self.spent_ns) as u64
    }

    /// Measured pose of a robot.
    pub fn measured(&self, robot: usize) -> Pose {
        let pose = self.poses[robot];
        let [share, direction, heading] = self.drifts[robot].noise;
        let off_um = self.errors.place_um * share;
        Pose {
            x_um: pose.x_um + off_um * direction.cosine(),
            y_um: pose.y_um + off_um * direction.sine(),
            heading_rad: pose.heading_rad + self.errors.heading_rad * heading,
        }
    }

    /// Carries a command out.
    ///
    /// # Errors
    /// The first robot that runs into something, or docks out of its place.
    pub fn carry_out(&mut self, segments: &[StrokeSegment]) -> Result<(), Mishap> {
        for segment in segments {
            self.spend(segment);
            let mut left = segment.strokes as f64;
            while left > 0.0 {
                left -= self.drive(segment.state, left)?;
            }
        }
        if self.errors.are_zero() && self.next.is_some_and(|next| next.settle(self)) {
            self.over += 1;
            self.begin();
        }
        Ok(())
    }

    /// Lets the bed rest until an instant, if that is still to come.
    pub fn rest_until(&mut self, until_ns: u64) {
        self.spent_ns = self.spent_ns.max(until_ns as f64 - self.time_ns);
    }

    /// Checks that all robots that should have docked did.
    ///
    /// # Errors
    /// The first robot that did not; `step` is the step in progress.
    pub fn all_docked(&self, step: usize) -> Result<(), TrialFailure> {
        match self.next.and_then(|next| next.robots().find(|robot| !self.docked[*robot])) {
            Some(robot) => {
                Err(TrialFailure { robot, reason: FailureReason::NotDocked, step, phase: ControlPhase::Over })
            }
            None => Ok(()),
        }
    }

    /// Drives the bed in a state for `strokes` strokes, or until robots dock. Returns the strokes that were driven.
    fn drive(&mut self, state: usize, strokes: f64) -> Result<f64, Mishap> {
        let moving = (0..self.poses.len()).filter(|robot| !self.docked[*robot]);
        let step_um = moving.map(|robot| self.order.robot(robot).step_um).fold(0.0, f64::max);
        let strides = (strokes * step_um / STRIDE_UM).ceil().max(1.0);
        let stride = strokes / strides;
        for index in 0..strides as u64 {
            let before = index as f64 * stride;
            let is_near = self.next.is_some_and(|next| next.is_near(self));
            if let Some(next) = self.next.filter(|next| is_near && next.touches(self, state, stride)) {
                let part = next.strokes_to_contact(self, state, stride);
                for robot in 0..self.poses.len() {
                    let until_contact = if self.is_driven(robot) { part } else { before + part };
                    self.poses[robot] = self.gone(robot, state, until_contact);
                }
                next.judge(self)?;
                self.over += 1;
                self.begin();
                return Ok(before + part);
            }
            for robot in 0..self.poses.len() {
                if self.is_driven(robot) {
                    self.poses[robot] = self.gone(robot, state, stride);
                }
            }
            self.collide_driven(state, before + stride, is_near)?;
        }
        for robot in 0..self.poses.len() {
            if !self.is_driven(robot) {
                self.poses[robot] = self.gone(robot, state, strokes);
            }
        }
        self.collide_others()?;
        Ok(strokes)
    }

    /// Whether a robot is checked after every stride: one that may dock next, or any robot if none may.
    fn is_driven(&self, robot: usize) -> bool {
        self.next.is_none_or(|next| next.robots().any(|driven| driven == robot))
    }

    /// True pose of a robot after `strokes` strokes in a state.
    pub fn gone(&self, robot: usize, state: usize, strokes: f64) -> Pose {
        if self.docked[robot] || self.stalled[robot] {
            return self.poses[robot];
        }
        let (facts, drift) = (self.order.robot(robot), self.drifts[robot]);
        let turn_per_um = match self.arm(robot, state) {
            Arm::Up => drift.curl,
            Arm::Down => facts.turning.sign() / facts.turning_radius_um + drift.curl,
        };
        bent(self.poses[robot], turn_per_um, strokes * facts.step_um * (1.0 + drift.speed))
    }

    fn arm(&self, robot: usize, state: usize) -> Arm {
        self.order.states[state].arms[self.order.robots[robot].row]
    }

    fn spend(&mut self, segment: &StrokeSegment) {
        if segment.sets_arms {
            let levels = self.order.states[segment.state].levels_v.len() as f64;
            self.spent_ns += levels * self.order.facts.dwell_ns as f64;
        }
        self.spent_ns += segment.strokes as f64 * self.order.facts.period_ns as f64;
    }

    /// Collisions of the robots that are checked after every stride, after some strokes of a segment; the others are
    /// still where they began it.
    fn collide_driven(&self, state: usize, strokes: f64, is_near: bool) -> Result<(), Mishap> {
        let count = self.poses.len();
        for robot in (0..count).filter(|robot| !self.docked[*robot] && self.is_driven(*robot)) {
            let facts = self.order.robot(robot);
            let whole = body(facts, self.poses[robot], 0.0);
            hit(robot, self.obstacles, &whole)?;
            match is_near {
                false => hit(robot, &self.bodies, &whole)?,
                true => {
                    let core = body(facts, self.poses[robot], self.order.facts.docking.tolerance_um);
                    hit(robot, &self.bodies, &core)?;
                }
            }
            for other in (0..count).filter(|other| *other != robot && !self.docked[*other]) {
                let is_partner = self.is_driven(other);
                if (is_partner && (is_near || other < robot)) || self.is_apart(robot, other, strokes) {
                    continue;
                }
                let pose = if is_partner { self.poses[other] } else { self.gone(other, state, strokes) };
                let solid = StrategySolid::standing(self.order.robot(other), pose);
                hit(robot, std::slice::from_ref(&solid), &whole)?;
            }
        }
        Ok(())
    }

    /// Collisions of the other robots, at the end of a segment.
    fn collide_others(&self) -> Result<(), Mishap> {
        let count = self.poses.len();
        for robot in (0..count).filter(|robot| !self.docked[*robot] && !self.is_driven(*robot)) {
            let whole = body(self.order.robot(robot), self.poses[robot], 0.0);
            hit(robot, self.obstacles, &whole)?;
            hit(robot, &self.bodies, &whole)?;
            for other in (0..robot).filter(|other| !self.docked[*other] && !self.is_driven(*other)) {
                if !self.is_apart(robot, other, 0.0) {
                    let solid = StrategySolid::standing(self.order.robot(other), self.poses[other]);
                    hit(robot, std::slice::from_ref(&solid), &whole)?;
                }
            }
        }
        Ok(())
    }

    /// Whether two bodies are certainly apart, wherever the second has gone in `strokes` strokes.
    fn is_apart(&self, robot: usize, other: usize, strokes: f64) -> bool {
        let [one, two] = [robot, other].map(|robot| self.order.robot(robot));
        let [a, b] = [robot, other].map(|robot| self.poses[robot]);
        let reach_um = (one.length_um + one.width_um + two.length_um + two.width_um) / 2.0;
        let gone_um = strokes * two.step_um * (1.0 + self.errors.speed_ratio);
        let (dx_um, dy_um) = (a.x_um - b.x_um, a.y_um - b.y_um);
        dx_um * dx_um + dy_um * dy_um > (reach_um + gone_um) * (reach_um + gone_um)
    }

    /// A pose of the plan, moved along with the structure.
    pub fn moved_along(&self, pose: Pose) -> Pose {
        let moved = self.structure * pose.isometry();
        let place = moved.translation.vector;
        Pose { x_um: place.x, y_um: place.y, heading_rad: moved.rotation.angle() }
    }
}

/// The rigid motion that brings one pose to another.
pub fn motion(from: Pose, to: Pose) -> Isometry2<f64> {
    let turned = Isometry2::new(Vector2::zeros(), to.heading_rad - from.heading_rad);
    let start = turned * Vector2::new(from.x_um, from.y_um);
    Isometry2::new(Vector2::new(to.x_um, to.y_um) - start, to.heading_rad - from.heading_rad)
}

fn hit(robot: usize, solids: &[StrategySolid], body: &BodyCorners) -> Result<(), Mishap> {
    match solids.iter().find(|solid| solid.distance_um(body, 0.0) <= 0.0) {
        Some(solid) => Err((robot, FailureReason::Collision(solid.name.clone()))),
        None => Ok(()),
    }
}

impl Drift {
    fn biased(random: &mut SplitMix64, manner: Manner, errors: &Errors) -> Self {
        let (speed, curl, heading) = match manner {
            Manner::Corner | Manner::Shaken => (random.sign(), random.sign(), random.sign()),
            Manner::Mixed => (random.signed_unit(), random.signed_unit(), random.signed_unit()),
        };
        let (speed_bias, curl_bias) = (speed * errors.speed_ratio, curl * errors.turning_rad_per_um);
        let noise = [1.0, random.unit() * TAU, heading];
        Drift { speed_bias, curl_bias, speed: speed_bias, curl: curl_bias, noise }
    }

    fn draw(&mut self, random: &mut SplitMix64, manner: Manner, errors: &Errors) {
        match manner {
            Manner::Corner => {}
            Manner::Shaken => *self = Drift::biased(random, manner, errors),
            Manner::Mixed => {
                let mixed = |bias: f64, other: f64| (bias + other) / 2.0;
                self.speed = mixed(self.speed_bias, random.signed_unit() * errors.speed_ratio);
                self.curl = mixed(self.curl_bias, random.signed_unit() * errors.turning_rad_per_um);
                self.noise = [random.unit().sqrt(), random.unit() * TAU, random.signed_unit()];
            }
        }
    }
}
