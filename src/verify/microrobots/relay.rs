//! Possible positions of the steering arms under a voltage, when each transition voltage is known only within a
//! margin.
//!
//! Input: the levels of the bed, one after another. Output: for each arm up, down, or unknown. Promise: an arm
//! reported as up or down is so for every combination of transition voltages within their margins, from any initial
//! positions.

use crate::device::microrobots::{Arm, MicrorobotsFacts, Robot};

/// Voltages that differ by less count as equal, for the rounding of levels exactly at their limits.
const ROUNDING_V: f64 = 1e-9;

/// The arms of all rows of the table.
#[derive(Debug, Clone)]
pub(super) struct ArmHysteresis<'f> {
    facts: &'f MicrorobotsFacts,
    /// `None` for an arm that may be up or down.
    pub arms: Vec<Option<Arm>>,
}

impl<'f> ArmHysteresis<'f> {
    /// Arms in unknown positions.
    pub fn new(facts: &'f MicrorobotsFacts) -> ArmHysteresis<'f> {
        ArmHysteresis { facts, arms: vec![None; facts.robots.len()] }
    }

    /// Applies a level that lasts long enough for the arms to follow it.
    pub fn visit(&mut self, level_v: f64) {
        for (robot, arm) in self.facts.robots.iter().zip(&mut self.arms) {
            *arm = after(robot, self.facts.margin_v, level_v, *arm);
        }
    }

    /// The row of the first arm whose position is unknown.
    pub fn unknown(&self) -> Option<usize> {
        self.arms.iter().position(Option::is_none)
    }

    /// The row of the first arm that a level may move.
    pub fn moved_by(&self, level_v: f64) -> Option<usize> {
        let margin_v = self.facts.margin_v;
        let mut rows = self.facts.robots.iter().zip(&self.arms);
        rows.position(|(robot, arm)| after(robot, margin_v, level_v, *arm) != *arm)
    }

    /// The row of the first arm that is not certainly up.
    pub fn not_up(&self) -> Option<usize> {
        self.arms.iter().position(|arm| *arm != Some(Arm::Up))
    }
}

fn after(robot: &Robot, margin_v: f64, level_v: f64, arm: Option<Arm>) -> Option<Arm> {
    let over_snap_v = level_v - robot.snap_down_v;
    let over_release_v = level_v - robot.release_v;
    if over_snap_v >= margin_v - ROUNDING_V {
        return Some(Arm::Down);
    }
    if over_release_v <= ROUNDING_V - margin_v {
        return Some(Arm::Up);
    }
    let keeps = match arm? {
        Arm::Up => over_snap_v <= ROUNDING_V - margin_v,
        Arm::Down => over_release_v >= margin_v - ROUNDING_V,
    };
    arm.filter(|_| keeps)
}
