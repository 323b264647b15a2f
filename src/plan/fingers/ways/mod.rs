//! The ways of a hand's fingers: from what a plan does to where every tip is when.
//!
//! Input: a [`FingersCourse`], acts such as "turn by a step" or "finger 2 comes to contact 12". Output: a [`FingersMotion`], straight stretches that
//! all tips run through at the same time.
//!
//! Method: while the part turns, the tips that hold follow the rolling constraint, which has a closed form ([`rolling`]), by chords of
//! equal angles. A free tip waits on a sphere of its own ([`FingersFacts::sphere_um`]) about the part's origin, beyond everything that holds
//! or is held and beyond the spheres of the fingers before it; it travels on a great circle of it, and comes and leaves by ways that
//! [`ContactReach`] has tested. Where the tip of another free finger is in the way, that one first steps aside on its own sphere.
//!
//! Promise: tips that hold are within half the tolerance of where rolling without slip has them, at every instant, and exactly there
//! where a state is recorded, also from one plane to the other: a tip rolls on from where it is; free tips keep the clearance from the outline in their plane, from tips that
//! hold and from each other, less than the tolerance excepted. Not promised: the fastest ways. Cost grows with the number of chords.

mod motion;
mod reach;
pub mod rolling;
mod sphere;

pub use reach::{ContactReach, RetreatPath};

use super::{FingersMotion, HeldGrasp, Stance};
use crate::claims::fingers::Section;
use crate::device::fingers::{FingersFacts, Plane};
use crate::geometry::outline::Curve;
use crate::real::Real;
use std::f64::consts::TAU;

/// The most stretches of a motion.
pub const MAX_MOVES: usize = 1_000_000;

/// A hand, and the sections of its part.
#[derive(Debug, Clone, Copy)]
pub struct HandSections<'a> {
    pub facts: &'a FingersFacts,
    pub xy: PreparedSection<'a>,
    /// `None` for a flat part.
    pub xz: Option<PreparedSection<'a>>,
}

/// A section made ready.
#[derive(Debug, Clone, Copy)]
pub struct PreparedSection<'a> {
    pub section: &'a Section,
    /// Of the section's outline.
    pub curve: &'a Curve,
    /// Of the curve with the section's contacts.
    pub reach: &'a ContactReach,
}

/// What the fingers do, as a plan has it.
#[derive(Debug, Clone, PartialEq)]
pub struct FingersCourse {
    /// Where everything is at first.
    pub start: Stance,
    /// One for each step of the order.
    pub steps: Vec<Vec<FingerAct>>,
}

/// One thing that the fingers do.
#[derive(Debug, Clone, PartialEq)]
pub enum FingerAct {
    /// All fingers are free, and those that hold a contact of this grasp come to it, one after the other. A state is recorded at the
    /// end; its angle index is 1.
    Begin { plane: Plane, grasp: Vec<u32> },
    /// A turn in a plane begins: the angle index is 1 again, and nothing moves. Into another plane the fingers hold contact 1 and the
    /// opposite one, if they hold.
    Turn(Plane),
    /// So many steps on in the turn, backwards if negative; a state is recorded after each one.
    Roll(i32),
    /// A free finger, counted from 0, comes to a contact. A state is recorded.
    Place { finger: usize, contact: u32 },
    /// A finger, counted from 0, leaves its contact. A state is recorded.
    Leave { finger: usize },
    /// All fingers that hold leave, one after the other in this order. A state is recorded after the last one.
    Release { order: Vec<usize> },
    /// Part and fingers, in the hand's frame. A state is recorded.
    Translate([f64; 3]),
    /// Nothing moves for so long, in nanoseconds.
    Wait(u64),
}

/// Why a course cannot be carried out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum WayError {
    /// A stage would have to reach farther than it does: what lacks most in the whole course. Step, finger and axis count from 0.
    Range { step: usize, finger: usize, axis: usize, beyond_um: f64 },
    /// No way to or from a contact, counted from 1, is clear of the part and the tips that hold.
    Blocked { step: usize, finger: usize, contact: u32 },
    /// A finger, counted from 0, that goes on in another plane is too far from the contact there, counted from 1: each change of plane
    /// may add to it what the outlines disagree by.
    Adrift { step: usize, finger: usize, contact: u32, off_um: f64 },
    /// The tolerance asks for too many chords.
    TooFine { step: usize },
    /// The act does not fit the state that it meets; no plan has such a one.
    Unfit { step: usize },
}

impl<'a> HandSections<'a> {
    /// The section in a plane, if the part has one.
    pub fn side(&self, plane: Plane) -> Option<PreparedSection<'a>> {
        match plane {
            Plane::Xy => Some(self.xy),
            Plane::Xz => self.xz,
        }
    }

    /// The radius of the sphere about the part's origin on which the tip of a finger, counted from 0, waits and travels.
    pub fn sphere_um(&self, finger: usize) -> f64 {
        let reach_um = self.xz.map_or(0.0, |side| side.curve.reach_um()).max(self.xy.curve.reach_um());
        self.facts.sphere_um(finger, reach_um)
    }

    /// Where everything is before the device's first task: the fingers evenly about the part, each on its sphere.
    pub fn home(&self, position_um: [f64; 3]) -> Stance {
        let fingers = self.facts.fingers as usize;
        let tip = |finger: usize| {
            let (sin, cos) = (TAU * finger as f64 / fingers as f64).sine_cosine();
            let [x, y, z] = position_um;
            [x + self.sphere_um(finger) * cos, y + self.sphere_um(finger) * sin, z]
        };
        let hold = HeldGrasp {
            grasp: vec![0; fingers],
            plane: Plane::Xy,
            angle_index: 1,
            position_um,
            orientation: [1.0, 0.0, 0.0, 0.0],
        };
        Stance { tips_um: (0..fingers).map(tip).collect(), hold }
    }

    /// How the fingers move in a course.
    ///
    /// # Errors
    /// See [`WayError`]; [`WayError::Range`] only where nothing else is wrong.
    pub fn motion(&self, course: &FingersCourse) -> Result<FingersMotion, WayError> {
        motion::motion(self, course)
    }
}

/// Where everything is after a motion.
pub fn end(motion: &FingersMotion) -> Stance {
    let moves = || motion.steps.iter().flatten().rev();
    let tips_um = moves().next().map_or(&motion.start.tips_um, |last| &last.tips_um);
    let hold = moves().find_map(|last| last.state.as_ref()).unwrap_or(&motion.start.hold);
    Stance { tips_um: tips_um.clone(), hold: hold.clone() }
}

/// How long a motion lasts; `None` if that is longer than a `u64` counts.
pub fn duration_ns(motion: &FingersMotion) -> Option<u64> {
    motion.steps.iter().flatten().try_fold(0, |sum: u64, stretch| sum.checked_add(stretch.duration_ns))
}

#[cfg(test)]
mod tests;
