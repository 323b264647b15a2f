//! The controller's knowledge of the bed: measured poses, docked robots, and the place of the structure.
//!
//! Docked robots stand still, so their poses are the means of all measurements since they docked. The structure's place
//! is that of its first robots: a rotation by their measured headings and by the directions between them, each weighted
//! by the bound on its error, and a shift of their middle.

use super::follow::{CommandedCourse, Following, GATE, SLACK_RAD, SLACK_UM};
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::{Arm, Errors, wrapped_rad};
use crate::geometry::Pose;
use crate::plan::microrobots::control::StrokeSegment;
use crate::plan::microrobots::strategy::{StrategySolid, body, obstacles};
use crate::plan::microrobots::world::OrientedRectangle;
use crate::real::Real;
use std::f64::consts::{FRAC_PI_6, TAU};

/// Distance from its start, in lengths of its body, and angle within which a robot may be set down by hand. A robot
/// that is farther from where its commands lead has not merely slipped.
const PLACED_LENGTHS: f64 = 1.0;
const PLACED_RAD: f64 = FRAC_PI_6;

/// Most consecutive times that a robot may be measured where its commands cannot have brought it.
pub const MAX_ASTRAY: u32 = 5;

/// State of the bed as measured.
#[derive(Debug, Clone)]
pub struct Belief<'a> {
    pub order: &'a MicrorobotsOrder,
    pub errors: Errors,
    /// One for each robot of the order: the last accepted measurement, or the mean of a docked robot.
    pub poses: Vec<Pose>,
    pub docked: Vec<bool>,
    pub obstacles: Vec<StrategySolid>,
    /// Half of each body's diagonal.
    reaches_um: Vec<f64>,
    means: Vec<PoseMean>,
    /// Nominal path of each robot since the last accepted measurement, and the part of it with the arm down.
    since: Vec<[f64; 2]>,
    /// Where the commands bring each robot.
    courses: Vec<CommandedCourse>,
    /// A measurement that could not be true, but that the next one may confirm.
    suspects: Vec<Option<Pose>>,
    /// Robots whose places define that of the structure, with their planned poses.
    base: Vec<(usize, Pose)>,
    /// Motion from the planned place of the structure to its actual one.
    structure: Placement,
    is_first: bool,
}

/// A rigid motion: a turn about the origin, then a shift.
#[derive(Debug, Clone, Copy, Default)]
struct Placement {
    turn_rad: f64,
    shift_um: [f64; 2],
}

/// Mean of the poses of a robot at rest.
#[derive(Debug, Clone, Copy)]
struct PoseMean {
    first_rad: f64,
    x_um: f64,
    y_um: f64,
    off_rad: f64,
    count: f64,
}

/// Whether a measurement can be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sighting {
    Usable,
    /// This robot was not seen.
    Unseen(usize),
    /// This robot cannot have come to where it was measured.
    Doubtful(usize),
    /// This robot was off its commanded path too many times in a row.
    Astray(usize),
    /// This robot stays where neither its commands nor chance can have brought it.
    Moved(usize),
}

impl<'a> Belief<'a> {
    /// State before the first measurement; the poses are those that the plan begins with.
    pub fn new(order: &'a MicrorobotsOrder, errors: Errors, poses: &[Pose], docked: &[bool]) -> Self {
        // Reserves room for the two robots that begin a structure, so that nothing is allocated when they dock.
        let mut base = Vec::with_capacity(poses.len().max(2));
        base.extend((0..poses.len()).filter(|robot| docked[*robot]).map(|robot| (robot, poses[robot])));
        let reach_um = |robot: usize| order.robot(robot).length_um.hypotenuse(order.robot(robot).width_um) / 2.0;
        Belief {
            order,
            errors,
            reaches_um: (0..poses.len()).map(reach_um).collect(),
            poses: poses.to_vec(),
            docked: docked.to_vec(),
            obstacles: obstacles(order),
            means: vec![PoseMean::NONE; poses.len()],
            since: vec![[0.0; 2]; poses.len()],
            courses: poses.iter().map(|pose| CommandedCourse::new(*pose, &errors)).collect(),
            suspects: vec![None; poses.len()],
            base,
            structure: Placement::default(),
            is_first: true,
        }
    }

    /// Accepts a measurement that was made after some segments; nothing is accepted unless all of it can be used.
    /// Robots in `may_touch` were driven against others by the segments, and may have been stopped on their way.
    pub fn see(
        &mut self,
        measured: &[Option<Pose>],
        driven: &[StrokeSegment],
        may_touch: [Option<usize>; 2],
    ) -> Sighting {
        self.count(driven);
        if let Some(robot) = (0..self.poses.len()).find(|robot| at(measured, *robot).is_none()) {
            return Sighting::Unseen(robot);
        }
        if let Some(robot) = self.doubtful(measured).or_else(|| self.overlapping(measured)) {
            return Sighting::Doubtful(robot);
        }
        if let Some(robot) = self.moved(measured) {
            return Sighting::Moved(robot);
        }
        let astray = self.follow(measured, may_touch);
        self.is_first = false;
        self.since.fill([0.0; 2]);
        for robot in 0..self.poses.len() {
            let Some(pose) = at(measured, robot) else { continue };
            self.poses[robot] = match self.docked[robot] {
                true => self.means[robot].with(pose),
                false => pose,
            };
        }
        self.place_structure();
        astray.map_or(Sighting::Usable, Sighting::Astray)
    }

    /// First robot that cannot be where it was measured. The measurement is kept, since the next one may confirm it.
    fn doubtful(&mut self, measured: &[Option<Pose>]) -> Option<usize> {
        let mut doubtful = None;
        for robot in 0..self.poses.len() {
            let Some(pose) = at(measured, robot) else { continue };
            let can_be = match self.is_first {
                true => self.is_at_start(robot, pose),
                false => {
                    self.can_reach(robot, self.poses[robot], pose, self.since[robot])
                        || self.suspects[robot].is_some_and(|suspect| self.can_reach(robot, suspect, pose, [0.0; 2]))
                }
            };
            self.suspects[robot] = (!can_be).then_some(pose);
            if !can_be && doubtful.is_none() {
                doubtful = Some(robot);
            }
        }
        doubtful
    }

    /// First robot whose place was confirmed by the next measurement, but is also far from where the commands bring it.
    /// So its last place was not wrong, and no robot slips so far: it was moved, or is mistaken for another one.
    fn moved(&self, measured: &[Option<Pose>]) -> Option<usize> {
        let is_moved = |robot: usize, pose: Pose| {
            let slipped_um = PLACED_LENGTHS * self.order.robot(robot).length_um;
            !self.can_reach(robot, self.poses[robot], pose, self.since[robot])
                && !self.courses[robot].leads_within(&self.errors, pose, [slipped_um, PLACED_RAD])
        };
        (0..self.poses.len())
            .filter(|_| !self.is_first)
            .find(|robot| at(measured, *robot).is_some_and(|pose| is_moved(*robot, pose)))
    }

    /// Whether a robot is where it was set down, within what a hand can do, and is not mistaken for another one.
    fn is_at_start(&self, robot: usize, pose: Pose) -> bool {
        let (start, errors) = (self.poses[robot], self.errors);
        let off_um = |other: &Pose| (pose.x_um - other.x_um).hypotenuse(pose.y_um - other.y_um);
        let own_um = off_um(&start);
        let most_um = PLACED_LENGTHS * self.order.robot(robot).length_um + errors.place_um + SLACK_UM;
        let most_rad = PLACED_RAD + errors.heading_rad + SLACK_RAD;
        // If robots start side by side, the nearer start tells them apart.
        let is_nearer = |other: &Pose| off_um(other) + GATE * errors.place_um + SLACK_UM < own_um;
        own_um <= most_um
            && wrapped_rad(pose.heading_rad - start.heading_rad).abs() <= most_rad
            && !self.poses.iter().any(is_nearer)
    }

    /// First robot that is measured inside the body of another one by more than the errors of measurement allow.
    fn overlapping(&self, measured: &[Option<Pose>]) -> Option<usize> {
        let overlaps = |robot: usize, other: usize| {
            let (Some(one), Some(two)) = (at(measured, robot), at(measured, other)) else { return false };
            let (pair, poses) = ([robot, other], [one, two]);
            let may_um = self.order.facts.docking.tolerance_um + self.doubt_of_both_um(pair) + SLACK_UM;
            self.least_apart_um(pair, poses) <= 0.0 && self.apart_um(pair, poses) < -may_um
        };
        (0..self.poses.len()).find(|robot| (0..*robot).any(|other| overlaps(*robot, other)))
    }

    /// Distance between the bodies of two robots at some poses; negative where they overlap.
    pub fn apart_um(&self, pair: [usize; 2], poses: [Pose; 2]) -> f64 {
        let [one, other] = [0, 1].map(|nth| {
            let facts = self.order.robot(pair[nth]);
            OrientedRectangle::new(poses[nth], [facts.length_um / 2.0, facts.width_um / 2.0])
        });
        one.to_rectangle_um(&other)
    }

    /// Lower bound on the distance between two bodies, however they are turned.
    pub fn least_apart_um(&self, pair: [usize; 2], [one, other]: [Pose; 2]) -> f64 {
        let reaches_um = pair.map(|robot| self.reach_um(robot));
        (one.x_um - other.x_um).hypotenuse(one.y_um - other.y_um) - (reaches_um[0] + reaches_um[1])
    }

    /// Bound on the error of the distance between two measured bodies.
    pub fn doubt_of_both_um(&self, pair: [usize; 2]) -> f64 {
        pair.iter().map(|robot| self.doubt_um(self.reach_um(*robot))).sum()
    }

    /// Compares a measurement with where the commands bring each robot; returns the first one that was astray too
    /// often. Docked robots do not move.
    fn follow(&mut self, measured: &[Option<Pose>], may_touch: [Option<usize>; 2]) -> Option<usize> {
        let mut astray = None;
        for robot in (0..self.poses.len()).filter(|robot| !self.docked[*robot]) {
            let Some(pose) = at(measured, robot) else { continue };
            let was_stopped = may_touch.contains(&Some(robot)) && self.is_beside(robot, measured);
            let course = &mut self.courses[robot];
            if self.is_first {
                *course = CommandedCourse::new(pose, &self.errors);
                continue;
            }
            let following = course.follow(&self.errors, pose);
            if following == Following::Astray && !was_stopped {
                course.astray += 1;
            }
            if course.astray > MAX_ASTRAY && astray.is_none() {
                astray = Some(robot);
            }
        }
        astray
    }

    /// Whether another robot is near enough to touch this one.
    fn is_beside(&self, robot: usize, measured: &[Option<Pose>]) -> bool {
        let Some(own) = at(measured, robot) else { return false };
        let (aligned_um, _) = self.alignment();
        let near_um = aligned_um + self.order.facts.docking.tolerance_um + GATE * self.errors.place_um + SLACK_UM;
        (0..self.poses.len()).filter(|other| *other != robot).any(|other| {
            at(measured, other).is_some_and(|pose| self.least_apart_um([robot, other], [own, pose]) <= near_um)
        })
    }

    /// Half of a body's diagonal.
    pub fn reach_um(&self, robot: usize) -> f64 {
        self.reaches_um[robot]
    }

    /// Adds driven segments to the paths since the last accepted measurement.
    fn count(&mut self, driven: &[StrokeSegment]) {
        for (robot, since) in self.since.iter_mut().enumerate() {
            let (step_um, row) = (self.order.robot(robot).step_um, self.order.robots[robot].row);
            for segment in driven {
                let way_um = step_um * segment.strokes as f64;
                let arm = self.order.states[segment.state].arms[row];
                since[0] += way_um;
                since[1] += if arm == Arm::Down { way_um } else { 0.0 };
                self.courses[robot].drive(self.order.robot(robot), &self.errors, arm, way_um);
            }
        }
    }

    /// Whether a robot can have come from one measured pose to another on some path of this length, part of it turning;
    /// it may have been stopped on its way.
    fn can_reach(&self, robot: usize, from: Pose, to: Pose, [whole_um, turned_um]: [f64; 2]) -> bool {
        let (facts, errors) = (self.order.robot(robot), self.errors);
        // Robots that meet align themselves.
        let aligned = if whole_um == 0.0 { (0.0, 0.0) } else { self.alignment() };
        let most_um = (1.0 + errors.speed_ratio) * whole_um + GATE * errors.place_um + SLACK_UM + aligned.0;
        let turn_per_um = 1.0 / facts.turning_radius_um;
        let most_rad =
            (1.0 + errors.speed_ratio) * GATE * (turned_um * turn_per_um + whole_um * errors.turning_rad_per_um)
                + GATE * errors.heading_rad
                + SLACK_RAD
                + aligned.1;
        let off_um = (to.x_um - from.x_um).hypotenuse(to.y_um - from.y_um);
        let is_number = [to.x_um, to.y_um, to.heading_rad].into_iter().all(f64::is_finite);
        is_number && off_um <= most_um && wrapped_rad(to.heading_rad - from.heading_rad).abs() <= most_rad
    }

    fn alignment(&self) -> (f64, f64) {
        let docking = self.order.facts.docking;
        (docking.self_aligning_um, docking.self_aligning_rad)
    }

    /// Counts a robot as docked from now on.
    pub fn dock(&mut self, robot: usize) {
        self.docked[robot] = true;
        self.means[robot] = PoseMean::NONE;
        self.poses[robot] = self.means[robot].with(self.poses[robot]);
    }

    /// Begins the structure with these robots, at these planned poses.
    pub fn begin_structure(&mut self, base: [(usize, Pose); 2]) {
        self.base.clear();
        self.base.extend_from_slice(&base);
        self.place_structure();
    }

    /// A pose of the plan, moved along with the structure.
    pub fn moved_along(&self, pose: Pose) -> Pose {
        self.structure.moved(pose)
    }

    /// Distance from a robot's front, at a goal, to the nearest point of docked robots in `before` that lies ahead of
    /// that front; to their nearest corner if none does.
    pub fn gap_um(&self, robot: usize, goal: Pose, before: &[usize]) -> f64 {
        let (sin, cos) = goal.heading_rad.sine_cosine();
        let own = self.order.robot(robot);
        let (mut corner_um, mut front_um) = (f64::INFINITY, f64::INFINITY);
        for &other in before.iter().filter(|other| self.docked[**other]) {
            let seen = body(self.order.robot(other), self.poses[other], 0.0).map(|corner| {
                let (dx_um, dy_um) = (corner.x - goal.x_um, corner.y - goal.y_um);
                [dx_um * cos + dy_um * sin, dy_um * cos - dx_um * sin]
            });
            corner_um = seen.iter().fold(corner_um, |least, [ahead_um, _]| least.min(*ahead_um));
            for (at, one) in seen.iter().enumerate() {
                front_um = front_um.min(ahead_of_front_um(*one, seen[(at + 1) % seen.len()], own.width_um / 2.0));
            }
        }
        let nearest_um = if front_um.is_finite() { front_um } else { corner_um };
        if nearest_um.is_finite() { nearest_um - own.length_um / 2.0 } else { 0.0 }
    }

    /// Bound on the position error of a point at this distance from a measured robot.
    pub fn doubt_um(&self, lever_um: f64) -> f64 {
        self.errors.place_um + self.errors.heading_rad * lever_um
    }

    /// Bound on how far a robot whose place and heading are known deviates from its nominal path over a stretch.
    pub fn astray_um(&self, way_um: f64) -> f64 {
        (self.errors.turning_rad_per_um * way_um / 2.0 + self.errors.speed_ratio) * way_um
    }

    fn place_structure(&mut self) {
        if self.base.is_empty() {
            return;
        }
        let count = self.base.len() as f64;
        let middle = |of: &dyn Fn(&(usize, Pose)) -> [f64; 2]| {
            let sum = self.base.iter().map(of).fold([0.0; 2], |sum, at| [sum[0] + at[0], sum[1] + at[1]]);
            sum.map(|value| value / count)
        };
        let (planned, found) = (
            middle(&|(_, pose)| [pose.x_um, pose.y_um]),
            middle(&|(robot, _)| [self.poses[*robot].x_um, self.poses[*robot].y_um]),
        );
        let (mut cross, mut dot, mut turned, mut spread) = (0.0, 0.0, 0.0, 0.0);
        for (robot, pose) in &self.base {
            let (a, b) = (
                [pose.x_um - planned[0], pose.y_um - planned[1]],
                [self.poses[*robot].x_um - found[0], self.poses[*robot].y_um - found[1]],
            );
            cross += a[0] * b[1] - a[1] * b[0];
            dot += a[0] * b[0] + a[1] * b[1];
            spread += a[0] * a[0] + a[1] * a[1];
            turned += wrapped_rad(self.poses[*robot].heading_rad - pose.heading_rad) / count;
        }
        let by_heading = count / (self.errors.heading_rad * self.errors.heading_rad + 1e-12);
        let by_place = spread / (self.errors.place_um * self.errors.place_um + 1e-6);
        let between_rad = if spread > 0.0 { wrapped_rad(cross.arc_tangent_over(dot) - turned) } else { 0.0 };
        let turn_rad = turned + between_rad * by_place / (by_place + by_heading);
        let (sin, cos) = turn_rad.sine_cosine();
        let shift_um =
            [found[0] - (planned[0] * cos - planned[1] * sin), found[1] - (planned[0] * sin + planned[1] * cos)];
        self.structure = Placement { turn_rad, shift_um };
    }
}

/// The measured pose of a robot, if it was seen.
fn at(measured: &[Option<Pose>], robot: usize) -> Option<Pose> {
    measured.get(robot).copied().flatten()
}

impl Placement {
    fn moved(&self, pose: Pose) -> Pose {
        let (sin, cos) = self.turn_rad.sine_cosine();
        Pose {
            x_um: pose.x_um * cos - pose.y_um * sin + self.shift_um[0],
            y_um: pose.x_um * sin + pose.y_um * cos + self.shift_um[1],
            heading_rad: wrapped_rad(pose.heading_rad + self.turn_rad),
        }
    }
}

impl PoseMean {
    const NONE: PoseMean = PoseMean { first_rad: 0.0, x_um: 0.0, y_um: 0.0, off_rad: 0.0, count: 0.0 };

    /// Adds a pose and returns the mean.
    fn with(&mut self, pose: Pose) -> Pose {
        if self.count == 0.0 {
            self.first_rad = pose.heading_rad;
        }
        self.count += 1.0;
        self.x_um += (pose.x_um - self.x_um) / self.count;
        self.y_um += (pose.y_um - self.y_um) / self.count;
        self.off_rad += (wrapped_rad(pose.heading_rad - self.first_rad) - self.off_rad) / self.count;
        let heading_rad = (self.first_rad + self.off_rad).rem_euclid(TAU);
        Pose { x_um: self.x_um, y_um: self.y_um, heading_rad: wrapped_rad(heading_rad) }
    }
}

/// Least distance ahead of those points of an edge that are no farther to the side than half a width; infinite if there
/// are none. Of an edge along the heading only one end counts: the other one belongs to the next edge.
fn ahead_of_front_um(one: [f64; 2], other: [f64; 2], half_um: f64) -> f64 {
    let [low, high] = if one[1] <= other[1] { [one, other] } else { [other, one] };
    if high[1] < -half_um || low[1] > half_um {
        return f64::INFINITY;
    }
    let across_um = high[1] - low[1];
    let ahead_um = |side_um: f64| {
        let share = if across_um > 0.0 { ((side_um - low[1]) / across_um).clamp(0.0, 1.0) } else { 0.0 };
        low[0] + share * (high[0] - low[0])
    };
    ahead_um(-half_um).min(ahead_um(half_um))
}
