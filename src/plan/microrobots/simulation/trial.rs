//! One trial: true poses of the robots, their measurements, and the time.

use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::{Arm, Errors};
use crate::geometry::Pose;
use crate::plan::microrobots::strategy::{BodyCorners, Driver, Episode, StrategySolid, bent, body};
use crate::random::SplitMix64;
use crate::real::Real;
use nalgebra::{Isometry2, Vector2};
use serde::Serialize;
use std::f64::consts::TAU;

/// Bodies are compared after each such stretch of their path.
const STRIDE_UM: f64 = 10.0;

/// Why a trial failed.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum FailureReason {
    /// After the greatest number of rounds it had still not reached the start of the fine motion.
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
}

/// Which robot of the order failed, and why.
pub type TrialFailure = (usize, FailureReason);

/// How a robot met its structure.
#[derive(Debug, Clone, PartialEq)]
pub struct Met {
    pub robot: usize,
    pub across_um: f64,
    pub along_um: f64,
    pub incidence_rad: f64,
    pub heading_rad: f64,
}

/// A trial that is over.
#[derive(Debug, Clone, PartialEq)]
pub struct EndedTrial {
    pub met: Vec<Met>,
    pub failure: Option<TrialFailure>,
    pub time_ns: u64,
}

/// How errors are drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Manner {
    /// Each robot keeps an extreme of each error.
    Corner,
    /// Another extreme in each interval.
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
    /// From where the structure should be to where it is.
    pub structure: Isometry2<f64>,
    pub met: Vec<Met>,
    obstacles: &'a [StrategySolid],
    scene: Vec<StrategySolid>,
    bodies: Vec<StrategySolid>,
    active: Vec<usize>,
    drifts: Vec<Drift>,
    manner: Manner,
    random: SplitMix64,
    step: Option<usize>,
    state: Option<usize>,
    time_ns: f64,
    spent_ns: f64,
}

/// Permitted contact of a moving body with docked ones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ContactManners {
    /// Touch none.
    Apart,
    /// Overlap them by the docking tolerance; those that are driven may touch each other.
    Docking,
}

impl<'a> Trial<'a> {
    pub fn new(
        order: &'a MicrorobotsOrder,
        errors: Errors,
        obstacles: &'a [StrategySolid],
        start: (&[Pose], &[bool]),
        (seed, index): (u64, u64),
    ) -> Self {
        let mut random = SplitMix64::stream(seed, index);
        let manner = [Manner::Corner, Manner::Shaken, Manner::Mixed, Manner::Mixed][(index % 4) as usize];
        let drifts = start.0.iter().map(|_| Drift::biased(&mut random, manner, &errors)).collect();
        Trial {
            order,
            errors,
            poses: start.0.to_vec(),
            docked: start.1.to_vec(),
            structure: Isometry2::identity(),
            met: Vec::new(),
            obstacles,
            scene: Vec::new(),
            bodies: Vec::new(),
            active: Vec::new(),
            drifts,
            manner,
            random,
            step: None,
            state: None,
            time_ns: 0.0,
            spent_ns: 0.0,
        }
    }

    /// The stage begins in which these robots are driven or watched; the others orbit.
    pub fn begin(&mut self, active: Vec<usize>) {
        let order = self.order;
        self.scene = self.obstacles.to_vec();
        self.bodies.clear();
        for robot in (0..self.poses.len()).filter(|robot| !active.contains(robot)) {
            let (facts, pose) = (order.robot(robot), self.poses[robot]);
            if self.docked[robot] {
                self.bodies.push(StrategySolid::standing(facts, pose));
            } else if let Some(driver) = Driver::new(order, robot) {
                self.scene.push(StrategySolid::orbit(facts, pose, driver.orbit_error_um()));
            }
        }
        self.active = active;
    }

    /// Takes over the plan's poses of robots that are not docked, at the beginning of a step of the task; docked ones keep their
    /// true poses.
    pub fn take(&mut self, episode: &Episode) {
        if self.step.replace(episode.step) == Some(episode.step) {
            return;
        }
        for (robot, is_docked) in self.docked.iter_mut().enumerate().filter(|(_, is_docked)| !**is_docked) {
            self.poses[robot] = episode.poses[robot];
            *is_docked = episode.docked[robot];
        }
    }

    /// The next measurement is due: an interval is over.
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

    /// The pose of a robot as it is measured.
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

    /// Drives the bed in a state for a nominal path length of a robot.
    pub fn drive(
        &mut self,
        state: usize,
        robot: usize,
        way_um: f64,
        manners: ContactManners,
    ) -> Result<(), TrialFailure> {
        if way_um <= 0.0 {
            return Ok(());
        }
        let strokes = way_um / self.order.robot(robot).step_um;
        self.spend(state, strokes);
        let strides = (way_um / STRIDE_UM).ceil().max(1.0);
        for _ in 0..strides as u64 {
            for index in 0..self.active.len() {
                let active = self.active[index];
                self.poses[active] = self.gone(active, state, strokes / strides);
            }
            self.collide(manners)?;
        }
        for other in (0..self.poses.len()).filter(|other| !self.docked[*other] && !self.active.contains(other)) {
            let facts = self.order.robot(other);
            self.poses[other] = facts.moved(self.poses[other], self.arm(other, state), strokes * facts.step_um);
        }
        Ok(())
    }

    /// True pose of a robot after `strokes` strokes in a state.
    pub fn gone(&self, robot: usize, state: usize, strokes: f64) -> Pose {
        if self.docked[robot] {
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

    fn spend(&mut self, state: usize, strokes: f64) {
        if self.state != Some(state) {
            let levels = self.order.states[state].levels_v.len() as f64;
            self.spent_ns += levels * self.order.facts.dwell_ns as f64;
            self.state = Some(state);
        }
        self.spent_ns += strokes * self.order.facts.period_ns as f64;
    }

    fn collide(&self, manners: ContactManners) -> Result<(), TrialFailure> {
        for (index, &robot) in self.active.iter().enumerate().filter(|(_, robot)| !self.docked[**robot]) {
            let facts = self.order.robot(robot);
            let whole = body(facts, self.poses[robot], 0.0);
            hit(robot, &self.scene, &whole)?;
            match manners {
                ContactManners::Apart => {
                    hit(robot, &self.bodies, &whole)?;
                    for &other in &self.active[index + 1..] {
                        let solid = StrategySolid::standing(self.order.robot(other), self.poses[other]);
                        hit(robot, std::slice::from_ref(&solid), &whole)?;
                    }
                }
                ContactManners::Docking => {
                    let core = body(facts, self.poses[robot], self.order.facts.docking.tolerance_um);
                    hit(robot, &self.bodies, &core)?;
                }
            }
        }
        Ok(())
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

fn hit(robot: usize, solids: &[StrategySolid], body: &BodyCorners) -> Result<(), TrialFailure> {
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
