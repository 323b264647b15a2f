//! Estimate of an assembly from given poses: strokes of its stages one after the other, and penalties for too little
//! room.
//!
//! Each robot makes its way from its turning circle straight to that of its approach. A robot that has waited first
//! turns to it: by half a circle on average, or as far as its orbit requires if that is known. Room is lacking where
//! the disc of a waiting robot, an obstacle or the path of a steered robot are too near to each other. A strip as wide
//! as the steered robot's orbit disc should be clear along its path, since a robot with errors drives circles there; a
//! strip as wide as its body must be clear. No claim rests on the estimate: plans are checked against the collision
//! rules.

use crate::claims::microrobots::{Dock, MicrorobotsOrder};
use crate::device::microrobots::{Arm, MicrorobotsObjective, Robot};
use crate::geometry::Pose;
use crate::geometry::distance::{point_segment, segment_core};
use crate::plan::microrobots::bound::together;
use crate::plan::microrobots::fine::Cycles;
use crate::plan::microrobots::free::turn_rad;
use crate::plan::microrobots::world::{BedPoses, CollisionWorld};
use crate::real::Real;
use nalgebra::Point2;
use std::f64::consts::{PI, TAU};

/// Room that is wanted beside the strip of a steered robot, as a share of its turning radius.
const WANTED_SHARE: f64 = 0.3;

/// Path that a micrometre of lacking room is worth: where room is wanted, and where it is required.
const WANTED: f64 = 2.0;
const REQUIRED: f64 = 20.0;

/// Most micrometres of lacking room that count in one place.
const MOST_LACKING_UM: f64 = 600.0;

/// Turns shorter than this count partly as full circles.
const EDGE_RAD: f64 = 0.05;

/// A point, or the centre of a turn.
type Point = [f64; 2];

/// Estimate for the robots and goals of one assembly.
pub struct AssemblyEstimate {
    robots: Vec<Robot>,
    /// Radius of each robot's orbit disc.
    reach_um: Vec<f64>,
    /// In order of docking; the first two together if `has_pair`.
    places: Vec<DockingPlace>,
    has_pair: bool,
    phases: OrbitPhases,
    /// Robots that are neither docked nor to dock, and orbit all the time.
    idle: Vec<usize>,
    world: CollisionWorld,
    /// Outline axes and half widths of docked bodies.
    rests: Vec<([Point2<f64>; 2], f64)>,
    orbit_keep_um: f64,
    keep_um: f64,
}

/// Where single robots are on their orbits when their turn comes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum OrbitPhases {
    /// Not known, since it depends on how long the first two robots take, or on the errors of the closed loop.
    Average,
    /// As all legs before have brought them there.
    Known,
}

/// A robot's place in the structure.
#[derive(Debug, Clone)]
pub struct DockingPlace {
    pub robot: usize,
    /// Pose at the start of its fine motion, and the centre of its turn there.
    approach: Pose,
    centre_um: Point,
    /// From the back of its body at the approach to the front at the goal.
    lane: [Point2<f64>; 2],
    /// The axis of its body at the goal.
    axis: [Point2<f64>; 2],
    /// Strokes of the fine motion of a single robot.
    fine_strokes: f64,
}

impl AssemblyEstimate {
    /// Estimate for an order; `None` if no robot is left to dock.
    pub fn new(order: &MicrorobotsOrder, world: &CollisionWorld, bed: &BedPoses, docks: &[Dock]) -> Option<Self> {
        let mut open: Vec<&Dock> = docks.iter().filter(|dock| !bed.docked[dock.robot]).collect();
        open.sort_by_key(|dock| together::lowering(order, dock.robot).count());
        let has_pair = !bed.docked.contains(&true) && open.len() >= 2;
        let places: Vec<DockingPlace> =
            open.iter().enumerate().map(|(at, dock)| place(order, &open, at, has_pair && at < 2, dock)).collect();
        let is_idle = |robot: &usize| !bed.docked[*robot] && open.iter().all(|dock| dock.robot != *robot);
        let robots: Vec<Robot> = (0..world.count()).map(|robot| order.robot(robot).clone()).collect();
        let rests = (0..world.count()).filter(|robot| bed.docked[*robot]);
        let rests = rests.map(|robot| (axis(&robots[robot], bed.poses[robot]), robots[robot].width_um / 2.0)).collect();
        (!places.is_empty()).then(|| AssemblyEstimate {
            reach_um: robots.iter().map(Robot::orbit_reach_um).collect(),
            robots,
            places,
            has_pair,
            phases: if has_pair || order.objective == MicrorobotsObjective::Failures {
                OrbitPhases::Average
            } else {
                OrbitPhases::Known
            },
            idle: (0..world.count()).filter(is_idle).collect(),
            world: world.clone(),
            rests,
            orbit_keep_um: order.facts.orbit_clearance_um,
            keep_um: order.facts.clearance_um,
        })
    }

    /// Estimated strokes of the assembly from these poses, penalties included.
    pub fn strokes(&self, poses: &[Pose]) -> f64 {
        let centres: Vec<Point> =
            self.robots.iter().zip(poses).map(|(robot, pose)| robot.orbit_centre_um(*pose)).collect();
        let singles = if self.has_pair { 2 } else { 0 };
        let mut lacking = self.orbits(&centres);
        let mut strokes = 0.0;
        if self.has_pair {
            let [driven, room] = self.pair(poses, &centres);
            (strokes, lacking) = (driven, lacking + room);
        }
        for at in singles..self.places.len() {
            let place = &self.places[at];
            strokes += self.single(place, poses[place.robot].heading_rad, centres[place.robot], strokes);
            lacking += self.lacking(at + 1, place, &[centres[place.robot], place.centre_um], &centres, at);
        }
        strokes + lacking
    }

    fn stroke_um(&self, robot: usize) -> f64 {
        self.robots[robot].step_um
    }

    /// Length and heading of the run from a turning circle to that of the approach, and the turn there.
    fn run(&self, place: &DockingPlace, centre_um: Point) -> [f64; 3] {
        let [dx, dy] = [0, 1].map(|axis| place.centre_um[axis] - centre_um[axis]);
        let aim_rad = dy.arc_tangent_over(dx);
        [dx.hypotenuse(dy), aim_rad, turn_rad(&self.robots[place.robot], aim_rad, place.approach.heading_rad)]
    }

    /// Length of the run and of the turn after it.
    fn way_um(&self, place: &DockingPlace, centre_um: Point) -> f64 {
        let [run_um, _, last_rad] = self.run(place, centre_um);
        run_um + self.robots[place.robot].turning_radius_um * last_rad
    }

    /// Strokes of a robot that has orbited for `waited` strokes since it had the given heading.
    fn single(&self, place: &DockingPlace, heading_rad: f64, centre_um: Point, waited: f64) -> f64 {
        let robot = &self.robots[place.robot];
        let [run_um, aim_rad, last_rad] = self.run(place, centre_um);
        let turns_rad = match self.phases {
            OrbitPhases::Average => PI + last_rad,
            OrbitPhases::Known => {
                let turned_rad = waited * robot.step_um / robot.turning_radius_um;
                let first_rad = (turn_rad(robot, heading_rad, aim_rad) - turned_rad).rem_euclid(TAU);
                sure_rad(first_rad) + sure_rad(last_rad)
            }
        };
        (run_um + robot.turning_radius_um * turns_rad) / robot.step_um + place.fine_strokes
    }

    /// Strokes of the first two robots: the first one's path to where it begins to run straight, then the second one's
    /// path.
    fn pair(&self, poses: &[Pose], centres: &[Point]) -> [f64; 2] {
        let [first, second] = [&self.places[0], &self.places[1]];
        let robots = [first, second].map(|place| &self.robots[place.robot]);
        let half = PI * robots[1].turning_radius_um / robots[1].step_um;
        let later = self.way_um(second, centres[second.robot]) / robots[1].step_um;
        let back_um = later * robots[0].step_um;
        let (sin, cos) = first.approach.heading_rad.sine_cosine();
        let turn_um = [first.centre_um[0] - back_um * cos, first.centre_um[1] - back_um * sin];
        let halt = DockingPlace { centre_um: turn_um, ..first.clone() };
        let pose = poses[first.robot];
        let here_um = centres[first.robot];
        let aim_rad = (turn_um[1] - here_um[1]).arc_tangent_over(turn_um[0] - here_um[0]);
        let begin_um = robots[0].turning_radius_um * turn_rad(robots[0], pose.heading_rad, aim_rad);
        let before = (begin_um + self.way_um(&halt, here_um)) / robots[0].step_um;
        let to_line = [here_um, turn_um];
        let line = [turn_um, first.centre_um];
        let mut lacking = self.lacking(2, first, &to_line, centres, 0) + self.lacking(2, first, &line, centres, 0);
        lacking += self.beside(first, &to_line, second.robot, centres[second.robot]);
        lacking += self.lacking(2, second, &[centres[second.robot], second.centre_um], centres, 0);
        [before + later + half, lacking]
    }

    /// Penalty in strokes for lacking room along a steered robot's path, while idle robots and those of the places from
    /// `later` on wait; the first `docked` places are taken.
    fn lacking(&self, later: usize, place: &DockingPlace, way: &[Point; 2], centres: &[Point], docked: usize) -> f64 {
        let waiting = self.places[later..].iter().map(|place| place.robot).chain(self.idle.iter().copied());
        let mut strokes: f64 = waiting.map(|robot| self.beside(place, way, robot, centres[robot])).sum();
        let [reach_um, half_um] = [self.reach_um[place.robot], self.robots[place.robot].width_um / 2.0];
        let line = way.map(|[x, y]| Point2::new(x, y));
        for body in self.world.obstacles() {
            let gap_um = segment_core(line, &body.core) - body.radius_um - self.keep_um;
            strokes += self.charge(place.robot, gap_um - reach_um, WANTED)
                + self.charge(place.robot, gap_um - half_um, REQUIRED);
        }
        let taken = self.places[..docked].iter().map(|place| (place.axis, self.robots[place.robot].width_um / 2.0));
        for (axis, wide_um) in self.rests.iter().copied().chain(taken) {
            let gap_um = apart_um(line, axis) - wide_um - self.keep_um;
            strokes += self.charge(place.robot, gap_um - reach_um, WANTED);
        }
        strokes
    }

    /// The same for one waiting robot: beside the path, and beside the last stretch before the goal.
    fn beside(&self, place: &DockingPlace, way: &[Point; 2], robot: usize, [x, y]: Point) -> f64 {
        let (at, disc_um) = (Point2::new(x, y), self.reach_um[robot] + self.orbit_keep_um);
        let [reach_um, half_um] = [self.reach_um[place.robot], self.robots[place.robot].width_um / 2.0];
        let gap_um = point_segment(at, way.map(|[x, y]| Point2::new(x, y))) - disc_um;
        let lane_um = point_segment(at, place.lane) - disc_um - half_um;
        let wanted_um = gap_um - reach_um - WANTED_SHARE * self.robots[place.robot].turning_radius_um;
        self.charge(place.robot, wanted_um, WANTED)
            + self.charge(place.robot, gap_um.min(lane_um + half_um) - half_um, REQUIRED)
    }

    /// Penalty in strokes for a gap below 0.
    fn charge(&self, robot: usize, gap_um: f64, weight: f64) -> f64 {
        (-gap_um).clamp(0.0, MOST_LACKING_UM) * weight / self.stroke_um(robot)
    }

    /// Penalty for orbits of waiting robots that are too near to each other, to obstacles and to docked bodies.
    fn orbits(&self, centres: &[Point]) -> f64 {
        let waits = |place: &DockingPlace| place.robot;
        let first = usize::from(self.has_pair);
        let waiting: Vec<usize> = self.places[first..].iter().map(waits).chain(self.idle.iter().copied()).collect();
        let mut strokes = 0.0;
        for (index, &robot) in waiting.iter().enumerate() {
            let at = Point2::new(centres[robot][0], centres[robot][1]);
            let disc_um = self.reach_um[robot] + self.orbit_keep_um;
            for body in self.world.obstacles() {
                let gap_um = segment_core([at; 2], &body.core) - body.radius_um - disc_um;
                strokes += self.charge(robot, gap_um, REQUIRED);
            }
            for (axis, wide_um) in &self.rests {
                strokes += self.charge(robot, point_segment(at, *axis) - wide_um - disc_um, REQUIRED);
            }
            for &other in &waiting[index + 1..] {
                let [dx, dy] = [0, 1].map(|axis| centres[robot][axis] - centres[other][axis]);
                strokes += self.charge(robot, dx.hypotenuse(dy) - disc_um - self.reach_um[other], REQUIRED);
            }
        }
        strokes
    }
}

/// Place of a dock, which is number `at` in the docking order.
fn place(order: &MicrorobotsOrder, open: &[&Dock], at: usize, is_paired: bool, dock: &Dock) -> DockingPlace {
    let (robot, goal, fine) = (order.robot(dock.robot), dock.goal.pose, &order.facts.fine);
    let (approach, fine_strokes) = if is_paired {
        let cycles = Cycles::<3>::symmetric(fine, &[0, 1].map(|at| order.robot(open[at].robot).step_um));
        let arms = if at == 0 { [Arm::Down, Arm::Up, Arm::Up] } else { [Arm::Down, Arm::Down, Arm::Up] };
        (cycles.backward(robot, arms, goal), cycles.total())
    } else {
        let cycles = Cycles::<2>::symmetric(fine, &[robot.step_um]);
        (cycles.backward(robot, [Arm::Down, Arm::Up], goal), cycles.total())
    };
    let axis = axis(robot, goal);
    let [back, _] = self::axis(robot, approach);
    let lane = [back, axis[1]];
    DockingPlace {
        robot: dock.robot,
        approach,
        centre_um: robot.orbit_centre_um(approach),
        lane,
        axis,
        fine_strokes: fine_strokes as f64,
    }
}

/// A turn, and a share of a full circle if it is so short that rounding may cost one.
fn sure_rad(turn_rad: f64) -> f64 {
    if turn_rad < EDGE_RAD { TAU - (TAU - EDGE_RAD) * turn_rad / EDGE_RAD } else { turn_rad }
}

/// The axis of a body, from its back to its front.
fn axis(robot: &Robot, pose: Pose) -> [Point2<f64>; 2] {
    let (sin, cos) = pose.heading_rad.sine_cosine();
    let half_um = robot.length_um / 2.0;
    [-half_um, half_um].map(|way_um| Point2::new(pose.x_um + way_um * cos, pose.y_um + way_um * sin))
}

/// Distance between two segments; where they cross, the least distance of an end of one from the other.
fn apart_um(one: [Point2<f64>; 2], other: [Point2<f64>; 2]) -> f64 {
    let to = |points: [Point2<f64>; 2], segment| points.map(|point| point_segment(point, segment));
    to(one, other).into_iter().chain(to(other, one)).fold(f64::INFINITY, f64::min)
}
