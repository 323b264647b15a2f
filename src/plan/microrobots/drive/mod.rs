//! Drives one robot through its stops, while all others move along with every stroke.
//!
//! Input: the bed, the robot, the stops. Output: legs of the whole bed under which the robot reaches every stop at the
//! end of a leg without a forbidden collision; or why none were found.
//!
//! Method: first one or two trains of strokes that end within the precision, where they cost less than the path to the
//! stop itself; then the path of the driven robot alone (`paths`), in whole strokes (`strokes`). Any control state with
//! its arm in the position that a leg needs can drive this leg; states are tried leg by leg, depth first, those first
//! in which the fewest other robots run, since robots that turn stay in place (`choice`). If no choice is free of
//! collisions, the collision partner becomes an obstacle of the driven robot: the body of a robot where they met, or
//! the disc of one that orbits; and the path is searched again.
//!
//! Promise: the legs are free of collisions by `CollisionWorld::first_collision`, and the stops are met within the
//! precision. Not promised: that legs are found where there are some, nor the fewest strokes. Apart from those short
//! drives the stops themselves are targeted; drives that save strokes by stopping short within the precision are not
//! searched. For lower bounds see `bound`.

mod choice;

use super::free::{self, ArmSegment};
use super::paths::{PathFailure, PathRequest};
use super::strokes::{self, StrokeTrain};
use super::world::{BedPoses, Collision, CollisionWorld, FirstCollision, Fixtures, Obstruction};
use super::{Leg, legs_cost};
use crate::claims::microrobots::{MicrorobotsOrder, Precision};
use crate::device::microrobots::Arm;
use crate::geometry::Pose;
use crate::plan::search::{Meter, SearchBudget};
use crate::real::Real;
use choice::TrainChoice;

/// Most collision partners that become obstacles on the way to one stop.
const MAX_ROUNDS: usize = 8;

/// A drive request: the robot, its stops, and the bed.
#[derive(Clone, Copy)]
pub struct DriveRequest<'a> {
    pub order: &'a MicrorobotsOrder,
    pub world: &'a CollisionWorld,
    pub bed: &'a BedPoses,
    pub robot: usize,
    /// In order; the last one is the goal.
    pub stops: &'a [Pose],
}

impl DriveRequest<'_> {
    /// The control states that keep the arms of docked robots up.
    fn states(&self) -> impl Iterator<Item = usize> + '_ {
        self.world.allowed_states(&self.bed.docked)
    }
}

/// The legs of a successful drive.
#[derive(Debug, Clone, PartialEq)]
pub struct DrivePlan {
    /// Consecutive legs differ in their states, unless a stop lies between them. Empty if the robot is at its goal
    /// already.
    pub legs: Vec<Leg>,
    /// Number of legs after which each stop is met; ascending.
    pub met: Vec<usize>,
    pub strokes: u64,
    /// Strokes of the shortest path to the stops themselves, without obstacles. Drives that stop short within the
    /// precision may have fewer.
    pub exact_strokes: u64,
    /// Whether it has at most `exact_strokes` plus one per leg, or replaces such a drive because it costs less: fewer
    /// control cycles may be worth more strokes.
    pub direct: bool,
    /// Steps of the budget spent.
    pub spent: u64,
}

/// Why a robot does not reach a stop.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StuckDrive {
    /// Index into the stops.
    pub stop: usize,
    pub reason: StuckReason,
    /// Steps of the budget spent.
    pub spent: u64,
    /// Number of paths for which control states were tried.
    pub paths: usize,
}

/// What stands in the way of a drive.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum DriveBlocker {
    /// Index into the order's obstacles.
    Obstacle(usize),
    /// The body of a robot.
    Robot(usize),
    /// The orbit disc of a robot.
    Orbit(usize),
}

/// Reason of a failed drive.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StuckReason {
    /// A proof: the robot is docked.
    Docked,
    /// A proof if every plan has the robot here before this stop: it must turn, and no control state lowers its arm
    /// while keeping those of docked robots up.
    NeverTurns,
    /// A proof if every plan has the robot here before this stop: it must run straight, and no control state raises its
    /// arm while keeping those of docked robots up.
    NeverRuns,
    /// A proof if every plan has the robot here before this stop: at its current pose it is too near to this to move.
    Start(DriveBlocker),
    /// At the stop it is too near to this. No proof: it may stop elsewhere within the precision.
    Goal(DriveBlocker),
    /// No path around this was found. No proof.
    Blocked(DriveBlocker),
    /// The budget ran out; this blocks the shortest path. No proof.
    GaveUp(DriveBlocker),
    /// The precision is finer than whole strokes can achieve. No proof.
    TooFine,
    /// The budget ran out during the choice of control states. No proof.
    OutOfBudget,
    /// It has a path, but every choice of control states that was tried causes a collision; this is the latest one. No
    /// proof.
    Meets(FirstCollision),
}

impl StuckReason {
    /// Whether the reason proves that there is no drive from the robot's current pose.
    pub fn is_proof(&self) -> bool {
        match self {
            StuckReason::Docked | StuckReason::NeverTurns | StuckReason::NeverRuns | StuckReason::Start(_) => true,
            StuckReason::Goal(_) | StuckReason::Blocked(_) | StuckReason::GaveUp(_) | StuckReason::TooFine => false,
            StuckReason::OutOfBudget | StuckReason::Meets(_) => false,
        }
    }
}

/// Drives a robot through its stops.
///
/// # Errors
/// See [`StuckReason`].
pub fn drive(request: &DriveRequest, budget: SearchBudget) -> Result<DrivePlan, StuckDrive> {
    let mut progress =
        DriveProgress { request, meter: Meter::new(budget), legs: Vec::new(), met: Vec::new(), paths: 0, extra: 0 };
    for (stop, goal) in request.stops.iter().enumerate() {
        let stuck = |reason, progress: &DriveProgress| StuckDrive {
            stop,
            reason,
            spent: progress.meter.spent(),
            paths: progress.paths,
        };
        progress.reach(*goal).map_err(|reason| stuck(reason, &progress))?;
        progress.met.push(progress.legs.len());
    }
    Ok(progress.driven())
}

/// Legs up to a stop, under construction.
struct DriveProgress<'a> {
    request: &'a DriveRequest<'a>,
    meter: Meter,
    legs: Vec<Leg>,
    met: Vec<usize>,
    paths: usize,
    /// Strokes beyond those of the drives to the stops themselves, where those cost more.
    extra: u64,
}

impl DriveProgress<'_> {
    fn pose(&self) -> Pose {
        let mut poses = self.request.bed.poses.clone();
        self.legs.iter().for_each(|leg| self.request.world.advance(&mut poses, &self.request.bed.docked, *leg));
        poses[self.request.robot]
    }

    /// Adds the legs up to a stop.
    fn reach(&mut self, goal: Pose) -> Result<(), StuckReason> {
        let DriveRequest { order, world, bed, robot, .. } = *self.request;
        let from = self.pose();
        if strokes::is_within(from, goal, order.precision) {
            return Ok(());
        }
        if bed.docked[robot] {
            return Err(StuckReason::Docked);
        }
        self.can_steer(from, goal)?;
        let around = Around::docked(world, bed, robot);
        let exact = PathRequest { world, robot, from, to: goal, fixtures: &around.fixtures };
        let Some(short) = self.stop_short(exact) else {
            self.legs = self.reach_exactly(from, goal, around)?;
            return Ok(());
        };
        // Around obstacles the path to the stop itself is longer, so the short drive is kept.
        let is_clear = exact.direct().is_ok();
        let exact = if is_clear { self.reach_exactly(from, goal, around).ok() } else { None };
        let cost = |legs: &[Leg]| legs_cost(order, legs);
        // Each leg may be rounded up by one stroke.
        let rounded = |legs: &[Leg]| legs.iter().map(|leg| leg.strokes.saturating_sub(1)).sum::<u64>();
        self.legs = match exact {
            Some(exact) if cost(&exact) <= cost(&short) => exact,
            Some(exact) => {
                self.extra += rounded(&short).saturating_sub(rounded(&exact));
                short
            }
            None => short,
        };
        Ok(())
    }

    /// The legs so far and those to a stop itself, around the given things and the collision partners found on the way.
    fn reach_exactly(&mut self, from: Pose, goal: Pose, mut around: Around) -> Result<Vec<Leg>, StuckReason> {
        let DriveRequest { order, world, robot, .. } = *self.request;
        let mut last = None;
        for _ in 0..MAX_ROUNDS {
            let found = match self.find(from, goal, &around) {
                Ok(way) => way,
                // The added obstacles close the path: the collision that led to them is the better explanation.
                Err(reason) => return Err(last.map_or(reason, StuckReason::Meets)),
            };
            let trains = strokes::whole(&world.body(robot).robot, from, goal, &found, order.precision);
            match self.choose(&trains.ok_or(StuckReason::TooFine)?) {
                Ok(legs) => return Ok(legs),
                Err(StuckReason::Meets(hit)) => {
                    last = Some(hit);
                    if !around.add(self.request, &self.legs, hit) {
                        break;
                    }
                }
                Err(reason) => return Err(reason),
            }
        }
        self.other_word(from, goal, last)
    }

    /// The legs so far and the best one or two trains that end within the precision of a stop.
    fn stop_short(&mut self, exact: PathRequest) -> Option<Vec<Leg>> {
        let DriveRequest { order, world, robot, .. } = *self.request;
        let facts = &world.body(robot).robot;
        let mut best: Option<Vec<Leg>> = None;
        for trains in strokes::short(facts, exact.from, exact.to, order.precision) {
            let way: Vec<ArmSegment> = trains.iter().map(|train| train.segment(facts)).collect();
            if world.obstruction_on(robot, exact.from, &way, exact.fixtures).is_some() {
                continue;
            }
            // An error is dropped: control states that are lacking here also are for the stop itself, and that drive
            // reports why.
            let Ok(legs) = self.choose(&trains) else { continue };
            if best.as_ref().is_none_or(|best| legs_cost(order, &legs) < legs_cost(order, best)) {
                best = Some(legs);
            }
        }
        best
    }

    /// Path of the robot alone. Unless the free optimum is clear, it leaves room for rounding to whole strokes where it
    /// can.
    fn find(&mut self, from: Pose, to: Pose, around: &Around) -> Result<Vec<ArmSegment>, StuckReason> {
        let DriveRequest { order, world, robot, .. } = *self.request;
        let exact = PathRequest { world, robot, from, to, fixtures: &around.fixtures };
        if let Ok(found) = exact.direct() {
            return Ok(found.segments);
        }
        let wide = world.widened(strokes::ASTRAY * order.precision.place_um);
        let found = PathRequest { world: &wide, ..exact }.find(&mut self.meter);
        let found = found.or_else(|failure| match failure {
            PathFailure::GaveUp(_) => Err(failure),
            PathFailure::Start(_) | PathFailure::Goal(_) | PathFailure::Blocked(_) => exact.find(&mut self.meter),
        });
        found.map(|found| found.segments).map_err(|failure| around.reason(failure))
    }

    /// Legs along the other free path, on which the other robots move differently.
    fn other_word(&mut self, from: Pose, goal: Pose, last: Option<FirstCollision>) -> Result<Vec<Leg>, StuckReason> {
        let DriveRequest { order, world, bed, robot, .. } = *self.request;
        let around = Around::docked(world, bed, robot);
        let facts = &world.body(robot).robot;
        let way = free::words(facts, from, goal)[1].segments(facts.turning_radius_um);
        let meets = last.map_or(StuckReason::TooFine, StuckReason::Meets);
        if world.obstruction_on(robot, from, &way, &around.fixtures).is_some() {
            return Err(meets);
        }
        let trains = strokes::whole(facts, from, goal, &way, order.precision).ok_or(meets)?;
        self.choose(&trains).map_err(|_| meets)
    }

    fn choose(&mut self, trains: &[StrokeTrain]) -> Result<Vec<Leg>, StuckReason> {
        self.paths += 1;
        TrainChoice::new(self.request, &self.legs, trains).run(&mut self.meter)
    }

    /// Whether control states put the arm in the positions that every path needs.
    fn can_steer(&self, from: Pose, goal: Pose) -> Result<(), StuckReason> {
        let DriveRequest { order, world, robot, .. } = *self.request;
        let has = |arm: Arm| self.request.states().any(|state| world.arm(state, robot) == arm);
        let facts = &world.body(robot).robot;
        // Without a turn the heading stays the same; without a run the turning centre does.
        let Precision { place_um, heading_rad } = order.precision;
        let turn_rad = free::turn_rad(facts, from.heading_rad, goal.heading_rad);
        let (sin, cos) = from.heading_rad.sine_cosine();
        let [dx, dy] = [goal.x_um - from.x_um, goal.y_um - from.y_um];
        let ahead = (dy * cos - dx * sin).abs() <= place_um && dx * cos + dy * sin >= -place_um;
        let straight = turn_rad.min(std::f64::consts::TAU - turn_rad) <= heading_rad && ahead;
        let [a, b] = [from, goal].map(|pose| facts.orbit_centre_um(pose));
        let about = (a[0] - b[0]).hypotenuse(a[1] - b[1]) <= place_um + facts.turning_radius_um * heading_rad;
        if !straight && !has(Arm::Down) {
            return Err(StuckReason::NeverTurns);
        }
        if !about && !has(Arm::Up) {
            return Err(StuckReason::NeverRuns);
        }
        Ok(())
    }

    fn driven(self) -> DrivePlan {
        let DriveRequest { world, bed, robot, stops, .. } = *self.request;
        let facts = &world.body(robot).robot;
        let start = std::iter::once(&bed.poses[robot]);
        let exact_um: f64 = start.chain(stops).zip(stops).map(|(from, to)| free::distance_um(facts, *from, *to)).sum();
        let strokes = self.legs.iter().map(|leg| leg.strokes).sum();
        let exact_strokes = (exact_um / facts.step_um - ROUNDING).ceil().max(0.0) as u64;
        DrivePlan {
            met: self.met,
            strokes,
            exact_strokes,
            direct: strokes <= exact_strokes + self.extra + self.legs.len() as u64,
            spent: self.meter.spent(),
            legs: self.legs,
        }
    }
}

/// Rounding allowance of a number of strokes.
const ROUNDING: f64 = 1e-3;

/// Bodies and discs at rest, or assumed to be, with their robots.
struct Around {
    fixtures: Fixtures,
    /// Robots of the fixtures' bodies and discs.
    bodies: Vec<usize>,
    discs: Vec<usize>,
}

impl Around {
    /// The docked bodies.
    fn docked(world: &CollisionWorld, bed: &BedPoses, robot: usize) -> Self {
        let bodies: Vec<usize> = (0..world.count()).filter(|other| bed.docked[*other] && *other != robot).collect();
        let rectangles = bodies.iter().map(|other| world.rectangle(*other, bed.poses[*other])).collect();
        Around { fixtures: Fixtures { discs: Vec::new(), bodies: rectangles }, bodies, discs: Vec::new() }
    }

    fn blocker(&self, obstruction: Obstruction) -> DriveBlocker {
        match obstruction {
            Obstruction::Obstacle(obstacle) => DriveBlocker::Obstacle(obstacle),
            Obstruction::Disc(disc) => DriveBlocker::Orbit(self.discs[disc]),
            Obstruction::Body(body) => DriveBlocker::Robot(self.bodies[body]),
        }
    }

    fn reason(&self, failure: PathFailure) -> StuckReason {
        match failure {
            PathFailure::Start(found) => StuckReason::Start(self.blocker(found)),
            PathFailure::Goal(found) => StuckReason::Goal(self.blocker(found)),
            PathFailure::Blocked(found) => StuckReason::Blocked(self.blocker(found)),
            PathFailure::GaveUp(found) => StuckReason::GaveUp(self.blocker(found)),
        }
    }

    /// Adds the collision partner as an obstacle; `false` if the driven robot did not collide, or the obstacle exists
    /// already.
    fn add(&mut self, request: &DriveRequest, legs: &[Leg], hit: FirstCollision) -> bool {
        let DriveRequest { world, bed, robot, .. } = *request;
        let (other, with) = match hit.collision {
            Collision::Robots { robot: one, other } if one == robot => (other, hit.with),
            Collision::Robots { robot: other, other: one } if one == robot => (other, hit.at),
            Collision::OrbitRobot { robot: other, other: one } if one == robot => (other, hit.at),
            Collision::Robots { .. }
            | Collision::OrbitRobot { .. }
            | Collision::Obstacle { .. }
            | Collision::OrbitObstacle { .. }
            | Collision::Orbits { .. } => return false,
        };
        let mut poses = bed.poses.clone();
        legs.iter().for_each(|leg| world.advance(&mut poses, &bed.docked, *leg));
        let here = world.disc(other, poses[other]);
        let there = world.disc(other, with);
        let stays = here.to_disc_um(&there) < 1e-3 - 2.0 * here.radius_um;
        if stays && !self.discs.contains(&other) {
            self.fixtures.discs.push(here);
            self.discs.push(other);
            return true;
        }
        let body = world.rectangle(other, with);
        let is_new = !self.fixtures.bodies.contains(&body);
        self.fixtures.bodies.push(body);
        self.bodies.push(other);
        is_new
    }
}

#[cfg(test)]
mod tests;
