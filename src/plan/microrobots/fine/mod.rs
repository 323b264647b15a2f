//! Interpolated turning: the fine motion over the last stretch to the goals.
//!
//! Input: a robot, its pose, and the point through which it must pass, or the length of its last stretch. Output: the shares of a
//! cycle with its arm down, or why there are none; and cycles of whole strokes, applied forwards or backwards. Promise: whole
//! cycles are exact in both directions up to the rounding of `f64`; a share leads through its point up to third order in the
//! cycle's length. Source: the paper's section 3.1, with the shares of its two-primitive radius exchanged, and the robot's index in
//! its third equation corrected: an arm that is down for a share ρ of the path bends it to the radius r / ρ.

use super::Leg;
use crate::device::microrobots::{Arm, Fine, Robot};
use crate::geometry::Pose;
use crate::real::Real;

/// Corrections of a share for the lead of its own turns; each gains about two digits.
const CORRECTIONS: usize = 6;

/// Rounding tolerance of the range of a share.
const SHARE_TOLERANCE: f64 = 1e-9;

/// Shares of both robots' arms down, of only the second's, and of neither, without corrections.
pub const SYMMETRIC: [f64; 3] = [1.0 / 3.0; 3];

/// A circle through a point, on the side to which the robot turns; or the straight line to it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bend {
    /// 1 / radius; 0 for the straight line.
    pub turn_per_um: f64,
    /// Arc length to the point.
    pub way_um: f64,
}

/// Shares of a cycle, in the order of its primitives, that lead through a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steering<const K: usize> {
    /// They sum to 1.
    pub shares: [f64; K],
    /// Path length of the robot to the point; of the first robot, if there are two.
    pub way_um: f64,
}

/// Why no shares of a cycle lead through a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Unreachable {
    /// It lies on the side to which the robot does not turn, this far from the robot's axis.
    OtherSide { off_um: f64 },
    /// It lies on the axis, behind the robot.
    Behind { off_um: f64 },
    /// The circle through it is narrower than the least radius that the shares allow.
    TooNarrow { radius_um: f64, least_um: f64 },
    /// The circle through it is wider than the greatest radius that the shares allow.
    TooWide { radius_um: f64, most_um: f64 },
    /// The first robot would have to turn for a larger share than the second, which turns whenever the first does.
    OutOfOrder { first: f64, second: f64 },
}

/// The circle that leaves a pose along its heading and passes through a point: the paper's equation 1.
pub fn bend(robot: &Robot, pose: Pose, [x_um, y_um]: [f64; 2]) -> Result<Bend, Unreachable> {
    let (sin, cos) = pose.heading_rad.sine_cosine();
    let (dx_um, dy_um) = (x_um - pose.x_um, y_um - pose.y_um);
    let ahead_um = dx_um * cos + dy_um * sin;
    let aside_um = robot.turning.sign() * (dy_um * cos - dx_um * sin);
    if aside_um < 0.0 {
        return Err(Unreachable::OtherSide { off_um: -aside_um });
    }
    if aside_um == 0.0 {
        let straight = Bend { turn_per_um: 0.0, way_um: ahead_um };
        return if ahead_um < 0.0 { Err(Unreachable::Behind { off_um: -ahead_um }) } else { Ok(straight) };
    }
    let turn_per_um = 2.0 * aside_um / (dx_um * dx_um + dy_um * dy_um);
    Ok(Bend { turn_per_um, way_um: 2.0 * aside_um.arc_tangent_over(ahead_um) / turn_per_um })
}

/// Shares of turning and of running straight that lead one robot through a point: everything that its two primitives reach.
pub fn two(robot: &Robot, cycle_um: f64, pose: Pose, place_um: [f64; 2]) -> Result<Steering<2>, Unreachable> {
    let (share, way_um) = share(robot, cycle_um, pose, place_um, [0.0, 1.0])?;
    Ok(Steering { shares: [share, 1.0 - share], way_um })
}

/// Shares of three primitives that lead the first of two robots through a point, while the second keeps its nominal radius: radii
/// from three times the first one's own upwards.
pub fn three_for_first(
    first: &Robot,
    cycle_um: f64,
    pose: Pose,
    place_um: [f64; 2],
) -> Result<Steering<3>, Unreachable> {
    let (share, way_um) = share(first, cycle_um, pose, place_um, [0.0, SYMMETRIC[0]])?;
    Ok(Steering { shares: [share, 2.0 / 3.0 - share, 1.0 / 3.0], way_um })
}

/// Shares of three primitives that lead the second of two robots through a point, while the first keeps its nominal radius: radii
/// from the second one's own to one and a half times it.
pub fn three_for_second(
    second: &Robot,
    cycle_um: f64,
    pose: Pose,
    place_um: [f64; 2],
) -> Result<Steering<3>, Unreachable> {
    let (share, way_um) = share(second, cycle_um, pose, place_um, [2.0 / 3.0, 1.0])?;
    Ok(Steering { shares: [1.0 / 3.0, share - 1.0 / 3.0, 1.0 - share], way_um })
}

/// Shares of three primitives that lead two robots through a point each. Their paths may differ in length.
pub fn three_for_both(
    [first, second]: [&Robot; 2],
    cycles_um: [f64; 2],
    poses: [Pose; 2],
    places_um: [[f64; 2]; 2],
) -> Result<Steering<3>, Unreachable> {
    let (first_share, way_um) = share(first, cycles_um[0], poses[0], places_um[0], [0.0, 1.0])?;
    let (second_share, _) = share(second, cycles_um[1], poses[1], places_um[1], [0.0, 1.0])?;
    if first_share > second_share + SHARE_TOLERANCE {
        return Err(Unreachable::OutOfOrder { first: first_share, second: second_share });
    }
    let both = first_share.min(second_share);
    Ok(Steering { shares: [both, second_share - both, 1.0 - second_share], way_um })
}

/// The share of the path with the arm down, and the path length.
///
/// Every cycle begins with its turns, so on average the heading leads that of the circle by half of the turn that one cycle's
/// straight share delays: the circle is computed from that leading heading.
fn share(
    robot: &Robot,
    cycle_um: f64,
    pose: Pose,
    place_um: [f64; 2],
    [least, most]: [f64; 2],
) -> Result<(f64, f64), Unreachable> {
    let radius_um = robot.turning_radius_um;
    let mut found = bend(robot, pose, place_um);
    for _ in 0..CORRECTIONS {
        let share = found.map_or(0.0, |bend| (bend.turn_per_um * radius_um).min(1.0));
        let lead_rad = share * (1.0 - share) * cycle_um / (2.0 * radius_um);
        let heading_rad = pose.heading_rad + robot.turning.sign() * lead_rad;
        found = bend(robot, Pose { heading_rad, ..pose }, place_um);
    }
    let Bend { turn_per_um, way_um } = found?;
    let share = turn_per_um * radius_um;
    if share > most + SHARE_TOLERANCE {
        return Err(Unreachable::TooNarrow { radius_um: 1.0 / turn_per_um, least_um: radius_um / most });
    }
    if share < least - SHARE_TOLERANCE {
        return Err(Unreachable::TooWide { radius_um: 1.0 / turn_per_um, most_um: radius_um / least });
    }
    Ok((share.clamp(least, most), way_um))
}

/// Whole strokes of each primitive of a cycle, and the number of cycles. The last primitive runs straight.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Cycles<const K: usize> {
    pub strokes: [u64; K],
    pub count: u64,
}

impl<const K: usize> Cycles<K> {
    /// Equal shares over the whole fine motion, for robots with these steps; the fastest one covers the device's length.
    pub fn symmetric(fine: &Fine, steps_um: &[f64]) -> Self {
        let step_um = steps_um.iter().copied().fold(f64::MIN_POSITIVE, f64::max);
        let parts = K.max(1) as u64;
        let strokes = ((fine.cycle_um / step_um) as u64).max(parts);
        let count = (fine.length_um / (strokes as f64 * step_um)).round().max(1.0) as u64;
        Cycles { strokes: split([1.0 / parts as f64; K], strokes), count }
    }

    /// Total number of strokes.
    pub fn total(&self) -> u64 {
        self.strokes.iter().sum::<u64>() * self.count
    }

    /// Pose to which it brings a robot whose arm has these positions in the primitives.
    pub fn forward(&self, robot: &Robot, arms: [Arm; K], from: Pose) -> Pose {
        let go = |pose, (arm, strokes): (Arm, u64)| robot.moved(pose, arm, robot.step_um * strokes as f64);
        (0..self.count).fold(from, |pose, _| arms.into_iter().zip(self.strokes).fold(pose, go))
    }

    /// Pose from which it brings a robot to a goal.
    pub fn backward(&self, robot: &Robot, arms: [Arm; K], goal: Pose) -> Pose {
        let go = |pose, (arm, strokes): (Arm, u64)| robot.moved(pose, arm, -robot.step_um * strokes as f64);
        (0..self.count).fold(goal, |pose, _| arms.into_iter().zip(self.strokes).rev().fold(pose, go))
    }

    /// As legs in the states of the primitives; a primitive without strokes has none.
    pub fn legs(&self, states: [usize; K]) -> impl Iterator<Item = Leg> + '_ {
        let cycle = move |_| states.into_iter().zip(self.strokes).map(|(state, strokes)| Leg { state, strokes });
        (0..self.count).flat_map(cycle).filter(|leg| leg.strokes > 0)
    }
}

/// Whole strokes of a cycle from its shares; they add up to `strokes`.
pub fn split<const K: usize>(shares: [f64; K], strokes: u64) -> [u64; K] {
    let (mut share, mut given) = (0.0, 0);
    shares.map(|part| {
        share += part;
        let until = ((share * strokes as f64).round() as u64).clamp(given, strokes);
        let part = until - given;
        given = until;
        part
    })
}

#[cfg(test)]
mod tests;
