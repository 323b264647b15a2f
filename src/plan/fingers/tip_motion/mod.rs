//! Motions of a hand's fingers: from the acts of a plan to the position of every tip over time.
//!
//! Input: a [`FingersCourse`], acts such as "turn by a step" or "finger 2 comes to contact 12". Output: a
//! [`FingersMotion`], straight moves that all tips make simultaneously.
//!
//! Method: while the part turns, the holding tips follow the rolling constraint, which has a closed form ([`rolling`]),
//! by chords of equal angles. A free tip waits on its own sphere ([`FingersFacts::sphere_um`]) about the part's origin,
//! outside everything that holds or is held and outside the spheres of the fingers before it. It travels along great
//! circles of this sphere, and approaches and leaves contacts along paths that [`ContactReach`] has tested. If the tip
//! of another free finger is in the way, that finger first steps aside on its own sphere.
//!
//! Guaranteed: holding tips stay within half the tolerance of exact rolling without slip at every instant, and are exact where a state
//! is recorded, also across a change of plane: a tip keeps rolling from where it is. Free tips keep the clearance, less the
//! tolerance, from the outline in their plane, from holding tips and from each other. Not guaranteed: the fastest motions. Cost grows
//! with the number of chords.

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

/// Most moves of a motion.
pub const MAX_MOVES: usize = 1_000_000;

/// A hand, and the sections of its part.
#[derive(Debug, Clone, Copy)]
pub struct HandSections<'a> {
    pub facts: &'a FingersFacts,
    pub xy: PreparedSection<'a>,
    /// `None` for a flat part.
    pub xz: Option<PreparedSection<'a>>,
}

/// A prepared section.
#[derive(Debug, Clone, Copy)]
pub struct PreparedSection<'a> {
    pub section: &'a Section,
    /// Curve of the section's outline.
    pub curve: &'a Curve,
    /// Approach paths of the section's contacts.
    pub reach: &'a ContactReach,
}

/// The planned acts of the fingers.
#[derive(Debug, Clone, PartialEq)]
pub struct FingersCourse {
    /// Initial stance.
    pub start: Stance,
    /// The acts of each step of the order.
    pub steps: Vec<Vec<FingerAct>>,
}

/// One act of the fingers.
#[derive(Debug, Clone, PartialEq)]
pub enum FingerAct {
    /// All fingers are free, and those with a contact in this grasp come to it, one after the other. A state is
    /// recorded at the end; its angle index is 1.
    Begin { plane: Plane, grasp: Vec<u32> },
    /// A turn in a plane begins: the angle index restarts at 1, and nothing moves. On a change of plane the fingers hold contact 1
    /// and the opposite one, if they hold.
    Turn(Plane),
    /// Rolls by this many steps, backwards if negative; a state is recorded after each one.
    Roll(i32),
    /// A free finger, counted from 0, comes to a contact. A state is recorded.
    Place { finger: usize, contact: u32 },
    /// A finger, counted from 0, leaves its contact. A state is recorded.
    Leave { finger: usize },
    /// All fingers that hold leave, one after the other in this order. A state is recorded after the last one.
    Release { order: Vec<usize> },
    /// Moves part and fingers, in the hand's frame. A state is recorded.
    Translate([f64; 3]),
    /// Nothing moves for this long, in nanoseconds.
    Wait(u64),
}

/// Reason why a course cannot be executed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum TipMotionError {
    /// A stage would exceed its range: the greatest excess in the whole course. Step, finger and axis count from 0.
    Range { step: usize, finger: usize, axis: usize, beyond_um: f64 },
    /// No path to or from a contact, counted from 1, is clear of the part and the holding tips.
    Blocked { step: usize, finger: usize, contact: u32 },
    /// A finger, counted from 0, that continues in another plane is too far from the contact there, counted from 1: each change of
    /// plane may add the difference between the outlines.
    OffContact { step: usize, finger: usize, contact: u32, off_um: f64 },
    /// The tolerance requires too many chords.
    TooFine { step: usize },
    /// The act does not fit the current state; no plan contains such an act.
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

    /// Radius of the sphere about the part's origin on which the tip of a finger, counted from 0, waits and travels.
    pub fn sphere_um(&self, finger: usize) -> f64 {
        let reach_um = self.xz.map_or(0.0, |side| side.curve.reach_um()).max(self.xy.curve.reach_um());
        self.facts.sphere_um(finger, reach_um)
    }

    /// The stance before the device's first task: the fingers evenly about the part, each on its sphere.
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

    /// The motion of the fingers in a course.
    ///
    /// # Errors
    /// See [`TipMotionError`]; [`TipMotionError::Range`] only if nothing else is wrong.
    pub fn motion(&self, course: &FingersCourse) -> Result<FingersMotion, TipMotionError> {
        motion::motion(self, course)
    }
}

/// The stance after a motion.
pub fn end(motion: &FingersMotion) -> Stance {
    let moves = || motion.steps.iter().flatten().rev();
    let tips_um = moves().next().map_or(&motion.start.tips_um, |last| &last.tips_um);
    let hold = moves().find_map(|last| last.state.as_ref()).unwrap_or(&motion.start.hold);
    Stance { tips_um: tips_um.clone(), hold: hold.clone() }
}

/// Duration of a motion; `None` if it exceeds a `u64`.
pub fn duration_ns(motion: &FingersMotion) -> Option<u64> {
    motion.steps.iter().flatten().try_fold(0, |sum: u64, stretch| sum.checked_add(stretch.duration_ns))
}

#[cfg(test)]
mod tests;
