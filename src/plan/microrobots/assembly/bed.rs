//! State of the bed during an assembly: poses of the robots, legs driven so far, and the control states that steer
//! given robots.

use super::track::ArmTrack;
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::{Arm, Robot};
use crate::geometry::{Core, Pose, distance};
use crate::plan::microrobots::{AssemblyStage, Leg, RobotDocking};
use crate::real::Real;
use nalgebra::Point2;

/// The bed at some time of an assembly.
#[derive(Debug, Clone)]
pub struct AssemblyState<'a> {
    pub order: &'a MicrorobotsOrder,
    /// One entry per robot of the order, as in `docked`.
    pub poses: Vec<Pose>,
    pub docked: Vec<bool>,
    pub legs: Vec<Leg>,
    pub docks: Vec<RobotDocking>,
    pub stages: Vec<AssemblyStage>,
    /// The control state of the last leg before the assembly.
    before: Option<usize>,
}

/// A stage's addition to an assembly: its legs, at the end of which these robots dock.
#[derive(Debug, Clone)]
pub struct StageAddition {
    pub legs: Vec<Leg>,
    pub docking: Vec<usize>,
    /// In order of time.
    pub stages: Vec<AssemblyStage>,
}

impl<'a> AssemblyState<'a> {
    pub fn new(order: &'a MicrorobotsOrder, poses: &[Pose], docked: &[bool], before: Option<usize>) -> Self {
        let (poses, docked) = (poses.to_vec(), docked.to_vec());
        AssemblyState { order, poses, docked, legs: Vec::new(), docks: Vec::new(), stages: Vec::new(), before }
    }

    pub fn robot(&self, index: usize) -> &'a Robot {
        self.order.robot(index)
    }

    /// Gap between two bodies, each a robot in a pose; at most 0 where they overlap.
    pub fn gap_um(&self, one: (usize, Pose), other: (usize, Pose)) -> f64 {
        let core = Core::Polygon(self.outline(other.0, other.1).to_vec());
        distance::quadrilateral_core(self.outline(one.0, one.1), &core)
    }

    /// The corners of a body, in order around it.
    pub fn outline(&self, robot: usize, pose: Pose) -> [Point2<f64>; 4] {
        let facts = self.robot(robot);
        let (sin, cos) = pose.heading_rad.sine_cosine();
        let (half_um, side_um) = (facts.length_um / 2.0, facts.width_um / 2.0);
        [(half_um, side_um), (-half_um, side_um), (-half_um, -side_um), (half_um, -side_um)]
            .map(|(x, y)| Point2::new(pose.x_um + x * cos - y * sin, pose.y_um + x * sin + y * cos))
    }

    /// Robots that are neither docked nor in `steered`.
    pub fn others<'b>(&'b self, steered: &'b [usize]) -> impl Iterator<Item = usize> + 'b {
        (0..self.poses.len()).filter(move |robot| !self.docked[*robot] && !steered.contains(robot))
    }

    /// The control state with the fewest levels that sets these robots' arms as given, while all others that are not
    /// docked orbit and docked ones keep their arms up.
    pub fn state(&self, steered: &[(usize, Arm)]) -> Option<usize> {
        let arm = |state: usize, robot: usize| self.order.states[state].arms[self.order.robots[robot].row];
        let wanted = |robot: usize| match self.docked[robot] {
            true => Arm::Up,
            false => steered.iter().find(|one| one.0 == robot).map_or(Arm::Down, |one| one.1),
        };
        let fits = |state: &usize| (0..self.docked.len()).all(|robot| arm(*state, robot) == wanted(robot));
        let cycle = |state: &usize| self.order.states[*state].levels_v.len();
        (0..self.order.states.len()).filter(fits).min_by_key(cycle)
    }

    /// The bed after one more stage.
    pub fn after(&self, stretch: StageAddition) -> AssemblyState<'a> {
        let mut bed = self.clone();
        bed.poses = self.poses_after(&stretch.legs);
        bed.legs.extend(stretch.legs);
        let leg = bed.legs.len() - 1;
        bed.docks.extend(stretch.docking.iter().map(|&robot| RobotDocking { robot, leg }));
        stretch.docking.iter().for_each(|&robot| bed.docked[robot] = true);
        bed.stages.extend(stretch.stages);
        bed
    }

    fn poses_after(&self, legs: &[Leg]) -> Vec<Pose> {
        let mut poses = self.poses.clone();
        for leg in legs {
            for robot in self.others(&[]) {
                poses[robot] = leg.carried(self.order, robot, poses[robot]);
            }
        }
        poses
    }

    /// The control state of the last leg, of the assembly or before it.
    pub fn last_state(&self) -> Option<usize> {
        self.legs.last().map(|leg| leg.state).or(self.before)
    }
}

/// Legs from the track of the one steered robot, by the states in which it turns and runs straight.
pub fn legs_of_one(track: &ArmTrack, [turn, straight]: [usize; 2]) -> Vec<Leg> {
    let state = |arm| match arm {
        Arm::Down => turn,
        Arm::Up => straight,
    };
    track.pieces.iter().map(|&(arm, strokes)| Leg { state: state(arm), strokes }).collect()
}

/// Legs from the tracks of two robots, by the states in which both turn, only the second turns, and neither turns.
/// `None` if only the first would turn at some time.
pub fn legs_of_two(first: &ArmTrack, second: &ArmTrack, [both, one, none]: [usize; 3]) -> Option<Vec<Leg>> {
    let mut legs = Vec::new();
    let (mut firsts, mut seconds) = (first.pieces.iter().copied(), second.pieces.iter().copied());
    let (mut at, mut beside) = (firsts.next(), seconds.next());
    while let (Some((arm, left)), Some((other, rest))) = (at, beside) {
        let state = match (arm, other) {
            (Arm::Down, Arm::Down) => both,
            (Arm::Up, Arm::Down) => one,
            (Arm::Up, Arm::Up) => none,
            (Arm::Down, Arm::Up) => return None,
        };
        let strokes = left.min(rest);
        legs.push(Leg { state, strokes });
        at = if left > strokes { Some((arm, left - strokes)) } else { firsts.next() };
        beside = if rest > strokes { Some((other, rest - strokes)) } else { seconds.next() };
    }
    Some(legs)
}

/// The same legs; consecutive ones of the same state are merged.
pub fn joined(legs: impl IntoIterator<Item = Leg>) -> Vec<Leg> {
    let mut kept: Vec<Leg> = Vec::new();
    for leg in legs {
        match kept.last_mut() {
            Some(last) if last.state == leg.state => last.strokes += leg.strokes,
            Some(_) | None => kept.push(leg),
        }
    }
    kept
}
