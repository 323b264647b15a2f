//! Interpolated turning: the fine motion over the last stretch to the goals.
//!
//! Input: the length of the last stretch and the robots' steps. Output: cycles of whole strokes, applied forwards or
//! backwards. Promise: whole cycles are exact in both directions up to the rounding of `f64`. Source: the paper's
//! section 3.1, with the shares of its two-primitive radius exchanged, and the robot's index in its third equation
//! corrected: an arm that is down for a share ρ of the path bends it to the radius r / ρ.

use super::Leg;
use crate::device::microrobots::{Arm, Fine, Robot};
use crate::geometry::Pose;

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

    /// The cycles as legs in the states of the primitives; a primitive without strokes has no leg.
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
