//! One robot's path among bodies at rest: the queries that every search repeats.

use super::tracks::{MotionKind, RobotTrack, first_near};
use super::{CollisionWorld, MARGIN_UM, OrientedRectangle, WorldObstacle};
use crate::device::microrobots::Arm;
use crate::geometry::distance::{point_core, point_segment};
use crate::geometry::{Pose, Rounded};
use crate::plan::microrobots::free::ArmSegment;
use crate::real::Real;
use nalgebra::Point2;
use std::f64::consts::TAU;

/// Instant of a collision that a query asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum CollisionInstant {
    /// The first instant at which the bodies are too near.
    First,
    /// Any instant from then on: enough to know whether they meet at all, and much cheaper.
    Any,
}

/// Query for a collision: the required clearance and the instant asked for.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearness {
    /// Required clearance, in micrometres.
    keep_um: f64,
    instant: CollisionInstant,
}

impl Nearness {
    /// Asks for the first instant nearer than `keep_um`.
    pub fn first(keep_um: f64) -> Nearness {
        Nearness { keep_um, instant: CollisionInstant::First }
    }

    /// Asks whether there is an instant nearer than `keep_um`.
    fn any(keep_um: f64) -> Nearness {
        Nearness { keep_um, instant: CollisionInstant::Any }
    }
}

/// Beyond the clearance plus this distance, a cheap lower bound replaces the distance of a robot from an obstacle.
const ENOUGH_UM: f64 = 2.0;

/// A disc, as swept by an orbiting robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OrbitDisc {
    pub centre_um: [f64; 2],
    pub radius_um: f64,
}

impl OrbitDisc {
    /// Distance to an obstacle; negative where they overlap.
    pub fn to_rounded_um(&self, body: &Rounded) -> f64 {
        let [x, y] = self.centre_um;
        point_core(Point2::new(x, y), &body.core) - body.radius_um - self.radius_um
    }

    /// Distance to another disc; negative where they overlap.
    pub fn to_disc_um(&self, other: &OrbitDisc) -> f64 {
        let [dx, dy] = [0, 1].map(|axis| self.centre_um[axis] - other.centre_um[axis]);
        dx.hypotenuse(dy) - self.radius_um - other.radius_um
    }
}

/// Things at rest on the bed, besides the obstacles, while one robot is driven.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Fixtures {
    /// Orbit discs of robots; they keep the orbit clearance.
    pub discs: Vec<OrbitDisc>,
    /// Bodies at rest.
    pub bodies: Vec<OrientedRectangle>,
}

/// An obstruction of one robot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Obstruction {
    /// Index into the order's obstacles.
    Obstacle(usize),
    /// Index into the fixtures' discs.
    Disc(usize),
    /// Index into the fixtures' bodies.
    Body(usize),
}

impl CollisionWorld {
    /// Obstruction of a robot on a segment of its path, if any: obstacles first, then discs and bodies.
    pub fn obstruction(
        &self,
        robot: usize,
        pose: Pose,
        stretch: ArmSegment,
        fixtures: &Fixtures,
    ) -> Option<Obstruction> {
        let driven = &self.bodies[robot];
        let strokes = stretch.way_um / driven.robot.step_um;
        let track = RobotTrack::new(driven, pose, Some(stretch.arm), strokes);
        let [body, orbit] = [self.keep_um, self.orbit_keep_um].map(Nearness::any);
        let obstacle = self.obstacles.iter().position(|other| meets_obstacle(&track, other, body).is_some());
        let disc = || fixtures.discs.iter().position(|disc| meets_disc(&track, disc, orbit).is_some());
        let rests = || fixtures.bodies.iter().position(|other| meets_rectangle(&track, other, body).is_some());
        obstacle
            .map(Obstruction::Obstacle)
            .or_else(|| disc().map(Obstruction::Disc))
            .or_else(|| rests().map(Obstruction::Body))
    }

    /// Obstruction of a robot on its path, and the segment where it occurs.
    pub fn obstruction_on(
        &self,
        robot: usize,
        from: Pose,
        way: &[ArmSegment],
        fixtures: &Fixtures,
    ) -> Option<(usize, Obstruction)> {
        let mut pose = from;
        way.iter().enumerate().find_map(|(index, stretch)| {
            let found = self.obstruction(robot, pose, *stretch, fixtures);
            pose = self.bodies[robot].robot.moved(pose, stretch.arm, stretch.way_um);
            found.map(|found| (index, found))
        })
    }

    /// Obstruction of a robot at a pose.
    pub fn obstruction_at(&self, robot: usize, pose: Pose, fixtures: &Fixtures) -> Option<Obstruction> {
        self.obstruction(robot, pose, ArmSegment { arm: Arm::Up, way_um: 0.0 }, fixtures)
    }

    /// Obstruction of the disc of an orbiting robot; other moving robots are not considered.
    pub fn obstruction_of_orbit(&self, disc: &OrbitDisc, fixtures: &Fixtures) -> Option<Obstruction> {
        let keep_um = self.orbit_keep_um + MARGIN_UM;
        let obstacle = self.obstacles.iter().position(|other| disc.to_rounded_um(&other.body) < keep_um);
        let theirs = || fixtures.discs.iter().position(|other| disc.to_disc_um(other) < keep_um);
        let near = |body: &OrientedRectangle| body.to_point_um(disc.centre_um) - disc.radius_um < keep_um;
        let rests = || fixtures.bodies.iter().position(near);
        obstacle
            .map(Obstruction::Obstacle)
            .or_else(|| theirs().map(Obstruction::Disc))
            .or_else(|| rests().map(Obstruction::Body))
    }

    /// Distance of a robot at a pose from everything at rest, beyond the required clearance; negative if it is too
    /// near.
    pub fn room_um(&self, robot: usize, pose: Pose, fixtures: &Fixtures) -> f64 {
        let body = self.rectangle(robot, pose);
        let obstacles = self.obstacles.iter().map(|other| body.to_rounded_um(&other.body) - self.keep_um);
        let bodies = fixtures.bodies.iter().map(|other| body.to_rectangle_um(other) - self.keep_um);
        let to_disc_um = |disc: &super::OrbitDisc| body.to_point_um(disc.centre_um) - disc.radius_um;
        let discs = fixtures.discs.iter().map(|disc| to_disc_um(disc) - self.orbit_keep_um);
        obstacles.chain(bodies).chain(discs).fold(f64::INFINITY, f64::min)
    }
}

/// The instant at which a robot is too near to an obstacle.
pub(super) fn meets_obstacle(track: &RobotTrack, obstacle: &WorldObstacle, asked: Nearness) -> Option<f64> {
    let (segment, radius_um) = track.bound();
    let WorldObstacle { body, bound: OrbitDisc { centre_um: [x, y], radius_um: bound_um } } = obstacle;
    let near_um = asked.keep_um + MARGIN_UM + radius_um;
    if point_segment(Point2::new(*x, *y), segment) - bound_um >= near_um {
        return None;
    }
    // A robot that runs straight is checked below, with all that it sweeps at once.
    if track.kind == MotionKind::Turns && point_core(segment[0], &body.core) - body.radius_um >= near_um {
        return None;
    }
    let enough_um = asked.keep_um + ENOUGH_UM;
    meets(track, asked, |rectangle| rectangle.nearly_to_rounded_um(body, enough_um))
}

/// The instant at which a robot is too near to a disc.
pub(super) fn meets_disc(track: &RobotTrack, disc: &OrbitDisc, asked: Nearness) -> Option<f64> {
    let ([x, y], keep_um) = (disc.centre_um, asked.keep_um + disc.radius_um);
    let (segment, radius_um) = track.bound();
    if point_segment(Point2::new(x, y), segment) - radius_um >= keep_um + MARGIN_UM {
        return None;
    }
    meets(track, Nearness { keep_um, ..asked }, |rectangle| rectangle.to_point_um(disc.centre_um))
}

fn meets_rectangle(track: &RobotTrack, body: &OrientedRectangle, asked: Nearness) -> Option<f64> {
    let (segment, radius_um) = track.bound();
    let [x, y] = body.centre_um;
    let corner_um = body.half_um[0].hypotenuse(body.half_um[1]);
    if point_segment(Point2::new(x, y), segment) - radius_um - corner_um >= asked.keep_um + MARGIN_UM {
        return None;
    }
    meets(track, asked, |rectangle| rectangle.to_rectangle_um(body))
}

/// The instant at which a body comes too near to something at rest.
fn meets(track: &RobotTrack, asked: Nearness, distance_um: impl Fn(&OrientedRectangle) -> f64) -> Option<f64> {
    let Nearness { keep_um, instant } = asked;
    if track.kind == MotionKind::Turns {
        // After a full turn the motion repeats.
        let strokes = track.strokes.min(TAU * track.speed_um.recip() * track.reach_um);
        return first_near([0.0, strokes], track.speed_um, keep_um, |at| distance_um(&track.at(at)));
    }
    let is_near = |strokes: f64| distance_um(&track.at(0.0).swept(track.step_um * strokes)) - keep_um < MARGIN_UM / 2.0;
    if !is_near(track.strokes) {
        return None;
    }
    if instant == CollisionInstant::Any {
        return Some(track.strokes);
    }
    let (mut clear, mut near) = (0.0, if is_near(0.0) { 0.0 } else { track.strokes });
    while near - clear > 1.0 {
        let middle = (clear + near) / 2.0;
        if is_near(middle) { near = middle } else { clear = middle }
    }
    Some(near)
}
