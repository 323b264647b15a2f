//! Proof that a robot meets an obstacle before a step can end, whatever control states are driven.
//!
//! Problem: every robot moves with every stroke, so a robot that merely stands by may run into an obstacle after a few
//! strokes, whether its arm is up or down. Input: the bed, a robot's pose, and the path that it makes in the shortest
//! time in which the step could end. Output: the obstacles that it must meet before that, or nothing, which proves
//! nothing.
//!
//! Method: only the robot's own arm counts, so a sequence of control states is a sequence of its arm positions. Let p
//! be the path run straight so far and q the path turned. The heading then is that of its pose plus q / r. The turning
//! centre rests while the robot turns and moves along the heading while it runs. So it has moved by a sum of vectors
//! whose lengths add up to p and whose directions lie between the first heading and the present one, at an angle of w =
//! q / r. The component of this sum along the bisector of the two headings lies between p cos(w / 2) and p; the
//! component across it is at most p sin(w / 2). The poses after (p, q) therefore lie within a known distance of one
//! pose. The plane of p and q is cut into squares. A square is closed if, at its middle pose, the body is nearer to an
//! obstacle than the clearance by more than any pose of the square is off. A plan is a path in the plane to the right
//! and up that enters no closed square. The squares that can be reached without entering one are searched depth first;
//! if none is as far as the step needs, there is no plan.
//!
//! Promise: a proof for every schedule that the verifier accepts, since it is looser than the collision rules by
//! `LOOSE_UM`. Not promised: that a proof is found where there is one. Other robots are ignored, and so are differences
//! in room that depend only on where the robot has run straight. Cost: at most `MAX_SQUARES` squares along each axis,
//! each with distances to the obstacles.

use super::world::CollisionWorld;
use crate::geometry::{Pose, Rounded};
use crate::real::Real;
use std::collections::BTreeSet;
use std::f64::consts::{FRAC_PI_2, PI};

/// Approach below the clearance that a proof does not count: larger than rounding and than what the verifier may miss.
const LOOSE_UM: f64 = 2e-3;

/// Side of a square of the plane, as a share of the turning radius.
const SQUARE_SHARE: f64 = 0.0125;

/// Most squares along one axis; a robot that comes so far has no proof.
const MAX_SQUARES: usize = 200;

/// The collision of a robot that cannot be driven as far as a step needs.
#[derive(Debug, Clone, PartialEq)]
pub struct InevitableCollision {
    pub robot: usize,
    /// Indices of the obstacles that it meets, ascending; every path meets one of them.
    pub obstacles: Vec<usize>,
    /// Upper limit of the path that it can make.
    pub way_um: f64,
}

/// Proves that a robot cannot be driven for `needed_um` of its path from a pose, whatever its arm does; `None` if there
/// is no such proof.
pub fn inevitable_collision(
    world: &CollisionWorld,
    robot: usize,
    pose: Pose,
    needed_um: f64,
) -> Option<InevitableCollision> {
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
    Some(InevitableCollision { robot, obstacles: obstacles.into_iter().collect(), way_um: most as f64 * plane.side_um })
}

/// The plane of a robot's straight and turning paths.
struct ArmPlane<'a> {
    world: &'a CollisionWorld,
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
    fn new(world: &'a CollisionWorld, robot: usize, pose: Pose) -> ArmPlane<'a> {
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
        // All points of the body turn about the turning centre; none is farther from it than `reach_um`.
        let swing_um = self.world.body(self.robot).reach_um * self.side_um / radius_um / 2.0;
        let body =
            self.world.rectangle(self.robot, self.middle((along_um[0] + along_um[1]) / 2.0, half_rad, turned_um));
        let near_um = self.world.keeps_um()[0] - LOOSE_UM - off_um - swing_um;
        self.obstacles.iter().position(|obstacle| body.to_rounded_um(obstacle) < near_um)
    }

    /// Pose whose turning centre has moved by `along_um` along the bisector, after a turn of half a square more than
    /// `turned_um`.
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
