//! A hand: fingers on translation stages that hold a micro-object between their tips and turn it.
//!
//! Facts, frames and vocabulary of the kind. Tips are spheres that translate and never turn; the object rolls on
//! them. Source of the model: Kumar, Gauthier, Dahmouche, *Path planning for 3-D in-hand manipulation of
//! micro-objects using rotation decomposition*, Micromachines 12(8), 986, 2021. Doc comments say where an error of
//! that text is corrected.

pub use super::shape::Plane;
use crate::geometry::fault::{Fault, inject};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

#[cfg(test)]
pub(crate) mod fixture;
pub mod sampling;
mod words;

pub use words::{FingersObjective, FingersOutcome, FingersPlanner, FingersVerb, HandNoun, TurnAxis, VOCABULARY};

/// Fewest fingers with which a hand can regrasp an object.
pub const MIN_FINGERS: u32 = 3;

/// Greatest number of fingers of one hand.
pub const MAX_FINGERS: u32 = 6;

/// Greatest number of fingers that hold the object at the same time.
pub const MAX_HOLDING: usize = 3;

/// Greatest number of steps in one turn: 1 deg each.
pub const MAX_STEPS_PER_TURN: u32 = 360;

/// Greatest number of contacts on one section.
pub const MAX_CONTACTS: u32 = 512;

/// Largest share of friction, pull-off and greatest force that a plan may keep in reserve while tips roll.
pub const MAX_RESERVE: f64 = 0.9;

/// Greatest number of three-finger grasps that the planner considers: those of one section, times the number of
/// angles if a load makes them differ.
pub const MAX_GRASPS: usize = 1 << 29;

/// Largest budget of grasp evaluations for one task: about a minute, over two in the slowest task measured, and some
/// gigabytes of memory.
pub const MAX_GRASP_EVALUATIONS: u32 = 1_000_000_000;

/// Default budget of grasp evaluations for one task: mostly less than 10 s; 21 s in the slowest of the random tasks
/// that were measured.
pub const DEFAULT_GRASP_EVALUATIONS: u32 = 150_000_000;

/// The axes of a stage, in coordinate order.
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// Whether tips stick to the object.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Adhesion {
    /// A tip sticks and must be pulled off.
    Sticking,
    /// Tips can only push.
    Absent,
}

/// Facts of a device of this kind: the fields of its declaration.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FingersFacts {
    /// [`MIN_FINGERS`] to [`MAX_FINGERS`]; at most [`MAX_HOLDING`] of them hold at the same time.
    pub fingers: u32,
    /// The paper's l2.
    pub tip_radius_um: f64,
    pub adhesion: Adhesion,
    /// Force that pulls a tip off the object, in micronewtons; applies only with [`Adhesion::Sticking`].
    pub pull_off_un: f64,
    /// Greatest normal force of one tip, in micronewtons.
    pub max_force_un: f64,
    /// Friction coefficient of a tip on the object, above 0.
    pub friction: f64,
    /// Number of rotation steps in 360 deg: the nominal step is 360 deg divided by it.
    pub steps_per_turn: u32,
    /// κ: the fingers that stay must resist κ times the pull-off force of the finger that leaves.
    pub removal_safety: f64,
    /// Cost of placing or removing a finger, in degrees rolled by one finger; whole.
    pub gaiting_cost_deg: f64,
    /// Least distance between two tips, and between a free tip and the object, in micrometres.
    pub clearance_um: f64,
    /// Distance along the normal, in micrometres, within which a tip approaches or leaves its contact slowly.
    pub retract_um: f64,
    /// Speed of a free tip along its path.
    pub speed_um_per_s: f64,
    /// Speed of a tip within `retract_um` of its contact.
    pub approach_um_per_s: f64,
    /// Greatest speed of a holding tip.
    pub rolling_um_per_s: f64,
    /// Force with which the support holds the object before the first grasp and after a release, in micronewtons.
    pub support_un: f64,
    /// Travel of each stage along x, y and z to both sides of the hand's origin.
    pub range_um: [f64; 3],
    /// Tolerance of contacts while rolling and touching, in micrometres; planned paths keep within half of it.
    pub tolerance_um: f64,
    /// The soft finger's coefficient of torsional friction: greatest torque about a contact's normal, divided by the
    /// force that presses and sticks.
    pub torsion_um: f64,
    /// The share of friction, pull-off and greatest force that a planned grasp keeps in reserve while it rolls; 0 to
    /// [`MAX_RESERVE`].
    pub rolling_reserve: f64,
}

impl FingersFacts {
    /// The nominal rotation step, the paper's Δθ.
    pub fn step_rad(&self) -> f64 {
        inject(Fault::Step, TAU / f64::from(self.steps_per_turn))
    }

    /// Force that pulls a tip off, in micronewtons; zero without adhesion.
    pub fn sticking_un(&self) -> f64 {
        match self.adhesion {
            Adhesion::Sticking => inject(Fault::Sticking, self.pull_off_un),
            Adhesion::Absent => 0.0,
        }
    }

    /// Distance from its contact within which a tip moves slowly; never less than the clearance.
    pub fn slow_um(&self) -> f64 {
        inject(Fault::Slow, self.retract_um.max(self.clearance_um))
    }

    /// Radius of the sphere about the object's origin on which the free tip of a finger, counted from 0, waits and
    /// travels, for an object that extends to `reach_um`. Each finger has its own sphere, clear of the holding tips,
    /// of the object and of the spheres of the fingers before it, although chords of the sphere dip below it by the
    /// tolerance.
    pub fn sphere_um(&self, finger: usize, reach_um: f64) -> f64 {
        let beyond_um = (2.0 * (self.tip_radius_um + self.clearance_um)).max(self.slow_um());
        let apart_um = 2.0 * self.tip_radius_um + self.clearance_um + self.tolerance_um;
        reach_um + self.tip_radius_um + beyond_um + self.tolerance_um + finger as f64 * apart_um
    }

    /// The names of the channels, without the device's name: finger 1's x, y and z, then finger 2's.
    pub fn channels(&self) -> Vec<String> {
        (0..self.fingers as usize).flat_map(|finger| (0..AXES.len()).map(move |axis| channel(finger, axis))).collect()
    }
}

/// The channel of a finger's axis, both counted from 0: `f1.x` for the first.
pub fn channel(finger: usize, axis: usize) -> String {
    format!("f{}.{}", finger + 1, AXES[axis])
}

/// The finger and the axis of a channel, both counted from 0; `None` if the name is not that of a channel.
pub fn finger_axis(channel: &str) -> Option<(usize, usize)> {
    let (finger, axis) = channel.strip_prefix('f')?.split_once('.')?;
    let axis = AXES.iter().position(|name| *name == axis)?;
    let is_plain = finger.bytes().all(|digit| digit.is_ascii_digit()) && !finger.starts_with('0');
    let number: usize = finger.parse().ok().filter(|_| is_plain)?;
    Some((number.checked_sub(1)?, axis))
}
