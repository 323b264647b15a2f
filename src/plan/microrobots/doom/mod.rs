//! Proof that a robot meets an obstacle before a step can end, whatever control states are driven.
//!
//! The problem: every robot moves with every stroke, so a robot that merely stands by may run into an obstacle after a few strokes, whether
//! its arm is up or down. Input: the bed, a robot's pose, and the path that it makes in the shortest time in which the step could end.
//! Output: the obstacles that it must meet before that, or nothing, which proves nothing.
//!
//! Method: only the robot's own arm counts; every sequence of control states is one of its arm positions. Let p be the path that it has run
//! straight and q the path on which it has turned. Its heading then is that of its pose and q / r. Its turning centre rests while it turns
//! and is moved along the heading while it runs, so it has moved by a sum of vectors of lengths that add up to p and of directions between
//! the first heading and the present one, at an angle of w = q / r: by a vector whose component along the middle of the two headings lies
//! between p cos(w / 2) and p, and whose component across it is at most p sin(w / 2). So the poses after (p, q) lie within a known distance
//! of one pose. The plane of p and q is cut into squares; one is closed if at its middle pose the body is nearer to an obstacle than the
//! clearance by more than any pose of the square is off. A plan is a path in the plane to the right and up, and it is stopped by closed
//! squares. What can be reached without entering one is searched depth first; if none of it is as far as the step needs, there is no plan.
//!
//! Promise: a proof for every schedule that the verifier accepts, since it is looser than the collision rules by `LOOSE_UM`. Not
//! promised: that one is found where there is one; other robots are ignored, and so is room that only differs by where a robot has run
//! straight. Cost: at most `MAX_SQUARES` squares along each axis, each with a look at all obstacles near.

use super::world::World;
use crate::geometry::{Pose, Rounded};
use crate::real::Real;
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI};

/// Approach below the clearance that a proof does not count: more than the verifier may leave undetected, and than rounding.
const LOOSE_UM: f64 = 2e-3;

/// Side of a square of the plane, as a share of the turning radius.
const SQUARE_SHARE: f64 = 0.0125;

/// Most squares along one axis; a robot that comes so far is not doomed.
const MAX_SQUARES: usize = 200;

/// A robot that cannot be driven as far as a step needs.
#[derive(Debug, Clone, PartialEq)]
pub struct DoomedRobot {
    pub robot: usize,
    /// Indices of the obstacles that it meets, ascending; one of them on each way.
    pub obstacles: Vec<usize>,
    /// It makes no longer path than this.
    pub way_um: f64,
}

/// The proof that a robot cannot be driven for `needed_um` of its path from a pose, whatever its arm does; `None` if there is none.
pub fn doomed(world: &World, robot: usize, pose: Pose, needed_um: f64) -> Option<DoomedRobot> {
    let plane = ArmPlane::new(world, robot, pose);
    let mut is_seen = vec![false; MAX_SQUARES * MAX_SQUARES];
    let (mut open, mut obstacles, mut most): (Vec<[usize; 2]>, BTreeSet<usize>, usize) =
        (vec![[0, 0]], BTreeSet::new(), 0);
    while let Some([run, turn]) = open.pop() {
        if std::mem::replace(&mut is_seen[run * MAX_SQUARES + turn], true) {
            continue;
        }
        if let Some(obstacle) = plane.closed_by([run, turn]) {
            obstacles.insert(obstacle);
            continue;
        }
        most = most.max(run + turn + 2);
        if most as f64 * plane.side_um >= needed_um || run + 1 == MAX_SQUARES || turn + 1 == MAX_SQUARES {
            return None;
        }
        open.extend([[run, turn + 1], [run + 1, turn]]);
    }
    Some(DoomedRobot { robot, obstacles: obstacles.into_iter().collect(), way_um: most as f64 * plane.side_um })
}

/// The plane of a robot's straight and turning paths.
struct ArmPlane<'a> {
    world: &'a World,
    robot: usize,
    heading_rad: f64,
    /// Turning centre at the start.
    centre_um: [f64; 2],
    /// Turning radius, positive for a turn to the left.
    curve_um: f64,
    side_um: f64,
    obstacles: Vec<&'a Rounded>,
}

impl<'a> ArmPlane<'a> {
    fn new(world: &'a World, robot: usize, pose: Pose) -> ArmPlane<'a> {
        let facts = &world.body(robot).robot;
        ArmPlane {
            world,
            robot,
            heading_rad: pose.heading_rad,
            centre_um: facts.orbit_centre_um(pose),
            curve_um: facts.turning.sign() * facts.turning_radius_um,
            side_um: SQUARE_SHARE * facts.turning_radius_um,
            obstacles: world.obstacles().collect(),
        }
    }

    /// The obstacle that the robot is too near to in every pose of a square.
    fn closed_by(&self, [run, turn]: [usize; 2]) -> Option<usize> {
        let (radius_um, from_um) = (self.curve_um.abs(), run as f64 * self.side_um);
        let (to_um, turned_um) = (from_um + self.side_um, turn as f64 * self.side_um);
        let half_rad = (turned_um + self.side_um) / radius_um / 2.0;
        let cos = half_rad.min(PI).cosine();
        let along_um = [if cos > 0.0 { from_um * cos } else { to_um * cos }, to_um];
        let across_um = to_um * half_rad.min(FRAC_PI_2).sine();
        let off_um = ((along_um[1] - along_um[0]) / 2.0).hypotenuse(across_um);
        // All points of the body turn about its turning centre, none farther from it than this.
        let swing_um = self.world.body(self.robot).reach_um * self.side_um / radius_um / 2.0;
        let body =
            self.world.rectangle(self.robot, self.middle((along_um[0] + along_um[1]) / 2.0, half_rad, turned_um));
        let near_um = self.world.keeps_um()[0] - LOOSE_UM - off_um - swing_um;
        self.obstacles.iter().position(|obstacle| body.to_rounded_um(obstacle) < near_um)
    }

    /// The pose whose turning centre has moved so far along a direction, after half a square more than a turn.
    fn middle(&self, along_um: f64, half_rad: f64, turned_um: f64) -> Pose {
        let (sin, cos) = (self.heading_rad + self.curve_um.signum() * half_rad).sine_cosine();
        let centre_um = [self.centre_um[0] + along_um * cos, self.centre_um[1] + along_um * sin];
        let heading_rad = self.heading_rad + (turned_um + self.side_um / 2.0) / self.curve_um;
        let (sin, cos) = heading_rad.sine_cosine();
        Pose { x_um: centre_um[0] + self.curve_um * sin, y_um: centre_um[1] - self.curve_um * cos, heading_rad }
    }
}

#[cfg(test)]
mod tests;
