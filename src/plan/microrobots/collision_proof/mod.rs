//! Proof that robots meet something before a step can end, whatever control states are driven.
//!
//! Problem: every robot moves with every stroke, so a robot that merely stands by may run into an obstacle after a few
//! strokes, whether its arm is up or down; and where it could be saved, no control state may save another robot at the
//! same time. Input: the bed, some of its moving robots, and the fewest strokes after which the step could end. Output:
//! the collisions one of which must happen before that, or nothing, which proves nothing.
//!
//! Method: the control states are told apart by which of these robots have their arms down. Let t_s be the strokes
//! driven so far in states of pattern s. A robot has run p, the sum of the t_s in which its arm is up, and turned q, the
//! sum of the others. The heading then is that of its pose plus q / r. The turning centre rests while the robot turns
//! and moves along the heading while it runs. So it has moved by a sum of vectors whose lengths add up to p and whose
//! directions lie between the first heading and the present one, at an angle of w = q / r. The component of this sum
//! along the bisector of the two headings lies between p cos(w / 2) and p; the component across it is at most
//! p sin(w / 2). The poses after (p, q) therefore lie within a known distance of one pose. The space of the t_s is cut
//! into cubes. A cube is closed if, at the middle poses, a body is nearer to an obstacle or to another robot than the
//! clearance by more than any poses of the cube are off. A plan is a path in that space along which no t_s falls and
//! which enters no closed cube. The cubes that can be reached without entering one are searched depth first; if none is
//! as far as the step needs, there is no plan.
//!
//! Promise: a proof for every schedule that the verifier accepts, since it is looser than the collision rules by
//! `LOOSE_UM`. Not promised: that a proof is found where there is one. Robots that are left out are ignored, and so are
//! differences in room that depend only on where a robot has run straight. Cost: at most `MAX_CUBES` cubes, each with
//! the distances of the robots to the obstacles and to each other.

use super::world::{BedPoses, CollisionWorld, OrientedRectangle};
use crate::device::microrobots::Arm;
use crate::geometry::{Pose, Rounded};
use crate::real::Real;
use rustc_hash::FxHashSet;
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI};

/// Approach below the clearance that a proof does not count: larger than rounding and than what the verifier may miss.
pub const LOOSE_UM: f64 = 2e-3;

/// Side of a cube, as a share of the turning radius: of one robot alone, and of several, where larger ones are tried
/// first.
const ALONE_SHARE: f64 = 0.0125;
const TOGETHER_SHARES: [f64; 3] = [0.05, 0.025, 0.0125];

/// Most cubes along one axis; robots that come so far have no proof.
const MAX_CUBES_ALONG: u16 = 200;

/// Most cubes that are looked at.
const MAX_CUBES: usize = 100_000;

/// Most patterns of arms, so that a cube fits into its key.
const MAX_PATTERNS: usize = 8;

/// Bits of a cube's key for each pattern.
const KEY_BITS: usize = 16;

/// Robots one of which cannot be driven as far as a step needs.
#[derive(Debug, Clone, PartialEq)]
pub struct InevitableCollision {
    /// Every schedule meets one of them; ascending.
    pub collisions: Vec<StaticCollision>,
    /// Upper limit of the strokes before that.
    pub strokes: f64,
}

impl InevitableCollision {
    /// The robots of the collisions; ascending.
    pub fn robots(&self) -> Vec<usize> {
        let robots = self.collisions.iter().flat_map(|collision| match *collision {
            StaticCollision::Obstacle { robot, .. } => [robot, robot],
            StaticCollision::Robots { robot, other } => [robot, other],
        });
        robots.collect::<BTreeSet<usize>>().into_iter().collect()
    }

    /// The obstacles of the collisions; ascending.
    pub fn obstacles(&self) -> Vec<usize> {
        let obstacles = self.collisions.iter().filter_map(|collision| match *collision {
            StaticCollision::Obstacle { obstacle, .. } => Some(obstacle),
            StaticCollision::Robots { .. } => None,
        });
        obstacles.collect::<BTreeSet<usize>>().into_iter().collect()
    }
}

/// Two things that come too near to each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum StaticCollision {
    Obstacle { robot: usize, obstacle: usize },
    Robots { robot: usize, other: usize },
}

/// Robots of a bed of which a proof is asked for.
#[derive(Debug, Clone, Copy)]
pub struct CollisionQuestion<'a> {
    pub world: &'a CollisionWorld,
    pub bed: &'a BedPoses,
    /// Robots that are not docked.
    pub robots: &'a [usize],
    /// Whether robots must keep off one another; robots that dock need not.
    pub keep_apart: bool,
    /// The fewest strokes after which the first of them may come to rest.
    pub needed: f64,
}

impl CollisionQuestion<'_> {
    /// Proves that the robots cannot be driven for as many strokes as are needed; `None` if there is no such proof.
    pub fn inevitable(&self) -> Option<InevitableCollision> {
        let alone = [ALONE_SHARE];
        let shares: &[f64] = if self.robots.len() == 1 { &alone } else { &TOGETHER_SHARES };
        shares.iter().find_map(|share| ArmSpace::new(self, *share)?.inevitable())
    }
}

/// The strokes driven in each pattern of arms, cut into cubes.
struct ArmSpace<'a> {
    question: &'a CollisionQuestion<'a>,
    robots: Vec<ProofRobot>,
    /// By pattern, then by robot of the question: whether its arm is down.
    is_down: Vec<Vec<bool>>,
    /// Side of a cube, in strokes.
    side: f64,
    obstacles: Vec<&'a Rounded>,
}

/// A robot from its pose on.
struct ProofRobot {
    /// Index into the order's robots.
    robot: usize,
    heading_rad: f64,
    /// Turning centre at the start.
    centre_um: [f64; 2],
    /// Turning radius, positive for a turn to the left.
    curve_um: f64,
    step_um: f64,
    /// No point of the body is farther from the turning centre.
    reach_um: f64,
}

/// A body at the middle of all poses that a robot may have in a cube, and the greatest distance of any of its points
/// from where it may be.
struct CubeBody {
    body: OrientedRectangle,
    off_um: f64,
}

/// A cube by its index along each axis; 0 beyond the last pattern.
type Cube = [u16; MAX_PATTERNS];

impl<'a> ArmSpace<'a> {
    /// `None` if there are too many patterns, or if no robot moves.
    fn new(question: &'a CollisionQuestion<'a>, share: f64) -> Option<ArmSpace<'a>> {
        let CollisionQuestion { world, bed, robots, .. } = *question;
        let states = world.allowed_states(&bed.docked);
        let pattern = |state: usize| robots.iter().map(|robot| world.arm(state, *robot) == Arm::Down).collect();
        let is_down: BTreeSet<Vec<bool>> = states.map(pattern).collect();
        let robots: Vec<ProofRobot> =
            robots.iter().map(|robot| ProofRobot::new(world, *robot, bed.poses[*robot])).collect();
        let side =
            robots.iter().map(|robot| share * robot.curve_um.abs() / robot.step_um).fold(f64::INFINITY, f64::min);
        let fits = (1..=MAX_PATTERNS).contains(&is_down.len()) && side.is_finite() && side > 0.0;
        fits.then(|| ArmSpace {
            question,
            robots,
            is_down: is_down.into_iter().collect(),
            side,
            obstacles: world.obstacles().collect(),
        })
    }

    fn inevitable(&self) -> Option<InevitableCollision> {
        let patterns = self.is_down.len();
        let mut is_seen: FxHashSet<u128> = FxHashSet::default();
        let (mut open, mut collisions, mut most): (Vec<Cube>, BTreeSet<StaticCollision>, f64) =
            (vec![[0; MAX_PATTERNS]], BTreeSet::new(), 0.0);
        while let Some(cube) = open.pop() {
            if !is_seen.insert(key(&cube)) {
                continue;
            }
            if let Some(collision) = self.closed_by(&cube) {
                collisions.insert(collision);
                continue;
            }
            let driven: usize = cube[..patterns].iter().map(|index| usize::from(*index) + 1).sum();
            most = most.max(driven as f64 * self.side);
            let is_far = cube.iter().any(|index| *index + 1 == MAX_CUBES_ALONG);
            if most >= self.question.needed || is_far || is_seen.len() == MAX_CUBES {
                return None;
            }
            for pattern in (0..patterns).rev() {
                let mut next = cube;
                next[pattern] += 1;
                open.push(next);
            }
        }
        Some(InevitableCollision { collisions: collisions.into_iter().collect(), strokes: most })
    }

    /// A collision in every pose of a cube.
    fn closed_by(&self, cube: &Cube) -> Option<StaticCollision> {
        let near_um = self.question.world.keeps_um()[0] - LOOSE_UM;
        let mut bodies: Vec<CubeBody> = Vec::with_capacity(self.robots.len());
        for (at, one) in self.robots.iter().enumerate() {
            let [run, turn] = self.driven(cube, at);
            let body = one.body(self.question.world, run, turn);
            let is_met = |obstacle: &&Rounded| body.body.to_rounded_um(obstacle) < near_um - body.off_um;
            if let Some(obstacle) = self.obstacles.iter().position(is_met) {
                return Some(StaticCollision::Obstacle { robot: one.robot, obstacle });
            }
            bodies.push(body);
        }
        let pairs = (0..bodies.len()).flat_map(|one| (one + 1..bodies.len()).map(move |other| [one, other]));
        let mut pairs = pairs.filter(|_| self.question.keep_apart);
        let is_met = |[one, other]: &[usize; 2]| {
            let [one, other] = [&bodies[*one], &bodies[*other]];
            one.body.to_rectangle_um(&other.body) < near_um - one.off_um - other.off_um
        };
        pairs.find(is_met).map(|[one, other]| StaticCollision::Robots {
            robot: self.robots[one].robot,
            other: self.robots[other].robot,
        })
    }

    /// Least and most strokes in which a robot of the question has run and turned in a cube.
    fn driven(&self, cube: &Cube, robot: usize) -> [[f64; 2]; 2] {
        let mut driven = [[0.0; 2]; 2];
        for (index, is_down) in cube.iter().zip(&self.is_down) {
            let range = &mut driven[usize::from(is_down[robot])];
            range[0] += f64::from(*index) * self.side;
            range[1] += f64::from(*index + 1) * self.side;
        }
        driven
    }
}

/// A cube's indices in one number.
fn key(cube: &Cube) -> u128 {
    cube.iter().fold(0, |key, index| key << KEY_BITS | u128::from(*index))
}

impl ProofRobot {
    fn new(world: &CollisionWorld, robot: usize, pose: Pose) -> ProofRobot {
        let body = world.body(robot);
        ProofRobot {
            robot,
            heading_rad: pose.heading_rad,
            centre_um: body.robot.orbit_centre_um(pose),
            curve_um: body.robot.turning.sign() * body.robot.turning_radius_um,
            step_um: body.robot.step_um,
            reach_um: body.reach_um,
        }
    }

    /// The body after least and most strokes that it ran and turned.
    fn body(&self, world: &CollisionWorld, run: [f64; 2], turn: [f64; 2]) -> CubeBody {
        let [run_um, turn_um] = [run, turn].map(|range| range.map(|strokes| strokes * self.step_um));
        let radius_um = self.curve_um.abs();
        let half_rad = turn_um[1] / radius_um / 2.0;
        let cos = half_rad.min(PI).cosine();
        let along_um = [if cos > 0.0 { run_um[0] * cos } else { run_um[1] * cos }, run_um[1]];
        let across_um = run_um[1] * half_rad.min(FRAC_PI_2).sine();
        let off_um = ((along_um[1] - along_um[0]) / 2.0).hypotenuse(across_um);
        // All points of the body turn about the turning centre; none is farther from it than `reach_um`.
        let swing_um = self.reach_um * (turn_um[1] - turn_um[0]) / radius_um / 2.0;
        let middle_um = (along_um[0] + along_um[1]) / 2.0;
        let pose = self.middle(middle_um, half_rad, (turn_um[0] + turn_um[1]) / 2.0);
        CubeBody { body: world.rectangle(self.robot, pose), off_um: off_um + swing_um }
    }

    /// Pose after a turn of `turned_um` whose turning centre has moved by `along_um` along the bisector.
    fn middle(&self, along_um: f64, half_rad: f64, turned_um: f64) -> Pose {
        let (sin, cos) = (self.heading_rad + self.curve_um.signum() * half_rad).sine_cosine();
        let centre_um = [self.centre_um[0] + along_um * cos, self.centre_um[1] + along_um * sin];
        let heading_rad = self.heading_rad + turned_um / self.curve_um;
        let (sin, cos) = heading_rad.sine_cosine();
        Pose { x_um: centre_um[0] + self.curve_um * sin, y_um: centre_um[1] - self.curve_um * cos, heading_rad }
    }
}

#[cfg(test)]
mod tests;
