//! Orientations in space, and the turns of whole steps that reach them.
//!
//! A turn is about an axis of the part (intrinsic), so that successive turns multiply from left to right.

use crate::check::orientation;
pub use crate::check::orientation::{Orientation, read, written};
use crate::claims::fingers::{FingersTurn, HandPart};
use crate::device::fingers::Plane;
use crate::real::Real;
use nalgebra::{Unit, UnitQuaternion, Vector3};
use std::f64::consts::{PI, TAU};

/// Greatest number of decompositions of one step that a plan chooses from.
pub const MAX_DECOMPOSITIONS: usize = 48;

/// Sine of the middle angle below which the first and the last turn share their axis, so that only one of them is left.
const FLAT: f64 = 1e-9;

/// A turn in a plane of the part.
pub fn about(plane: Plane, angle_rad: f64) -> Orientation {
    orientation::about(plane.normal(), angle_rad)
}

/// A turn about the part's x axis.
pub fn about_x(angle_rad: f64) -> Orientation {
    UnitQuaternion::from_axis_angle(&Vector3::x_axis(), angle_rad)
}

/// Orientation of a part after some turns of whole steps.
pub fn after(turns: &[FingersTurn], part: &HandPart) -> Orientation {
    turns.iter().fold(UnitQuaternion::identity(), |reached, turn| {
        let step_rad = part.section(turn.plane).map_or(0.0, |section| section.step_rad);
        reached * about(turn.plane, f64::from(turn.steps) * step_rad)
    })
}

/// A decomposition into turns that reaches an orientation, and its error.
#[derive(Debug, Clone, PartialEq)]
pub struct TurnSequence {
    pub turns: Vec<FingersTurn>,
    pub off_rad: f64,
}

/// Number of choices: for each of three angles the short way or the long one, and the nearest number of steps or the
/// next one.
const CHOICES: u32 = 1 << 6;

/// Share by which a turn of whole steps may exceed 360 deg.
const FULL_SLACK: f64 = 1e-2;

/// The decompositions into up to three turns of whole steps in alternating planes that come near a relative
/// orientation: both solutions of its angles, with either plane first, each angle in either direction, and by the
/// nearest number of steps or the next one. Without duplicates, sorted by total turning, the least first.
pub fn decompositions(goal: &Orientation, part: &HandPart) -> Vec<TurnSequence> {
    let mut found: Vec<TurnSequence> = Vec::new();
    for first in Plane::ALL {
        for angles in euler_angles(goal, first) {
            for choice in 0..CHOICES {
                let Some(turns) = whole_turns(angles, choice, first, part) else { continue };
                if found.iter().all(|sequence| sequence.turns != turns) {
                    let off_rad = after(&turns, part).angle_to(goal);
                    found.push(TurnSequence { turns, off_rad });
                }
            }
        }
    }
    found.sort_by(|one, other| effort(one, part).total_cmp(&effort(other, part)));
    found
}

fn effort(sequence: &TurnSequence, part: &HandPart) -> f64 {
    let step = |plane| part.section(plane).map_or(0.0, |section| section.step_rad);
    sequence.turns.iter().map(|turn| f64::from(turn.steps.abs()) * step(turn.plane)).sum()
}

/// The angles of three turns, the first and the last in one plane, the middle one in the other: one entry for each
/// solution.
fn euler_angles(goal: &Orientation, first: Plane) -> Vec<[f64; 3]> {
    // z, y, z in these coordinates is y, z, y in the part's own: x reversed, y and z exchanged.
    let swap = match first {
        Plane::Xy => UnitQuaternion::identity(),
        Plane::Xz => {
            let half = std::f64::consts::FRAC_1_SQRT_2;
            UnitQuaternion::from_axis_angle(&Unit::new_unchecked(Vector3::new(0.0, half, half)), PI)
        }
    };
    let r = (swap * goal * swap.inverse()).to_rotation_matrix();
    let sine = r[(0, 2)].hypotenuse(r[(1, 2)]);
    if sine < FLAT {
        let (whole, half) = (r[(1, 0)].arc_tangent_over(r[(0, 0)]), r[(1, 0)].arc_tangent_over(-r[(0, 0)]));
        // Upside down, the last turn is subtracted from the first.
        return if r[(2, 2)] > 0.0 { vec![[whole, 0.0, 0.0]] } else { vec![[-half, PI, 0.0], [0.0, PI, half]] };
    }
    let (a, b, c) = (
        r[(1, 2)].arc_tangent_over(r[(0, 2)]),
        sine.arc_tangent_over(r[(2, 2)]),
        r[(2, 1)].arc_tangent_over(-r[(2, 0)]),
    );
    vec![[a, b, c], [a + PI, -b, c + PI]]
}

/// Rounds each angle to the nearest whole number of steps or the next one, the short way or the long one, as the bits
/// of `choice` select; `None` where that is not a turn of its own.
fn whole_turns(angles: [f64; 3], choice: u32, first: Plane, part: &HandPart) -> Option<Vec<FingersTurn>> {
    let other = match first {
        Plane::Xy => Plane::Xz,
        Plane::Xz => Plane::Xy,
    };
    let mut turns: Vec<FingersTurn> = Vec::new();
    for (index, (angle, plane)) in angles.into_iter().zip([first, other, first]).enumerate() {
        let short = (angle + PI).rem_euclid(TAU) - PI;
        let is_bit = |bit: usize| choice >> bit & 1 == 1;
        let (is_long, is_next) = (is_bit(index), is_bit(index + 3));
        let section = part.section(plane);
        if section.is_none() && short.abs() < FLAT && !is_long && !is_next {
            continue;
        }
        let step_rad = section?.step_rad;
        let angle = if is_long { short - TAU.copysign(short) } else { short };
        let exact = angle / step_rad;
        let nearest = exact.round();
        let other = if exact < nearest { nearest - 1.0 } else { nearest + 1.0 };
        let steps = if is_next { other } else { nearest };
        // A full turn is not a distinct way to stay in place.
        if steps.abs() * step_rad > TAU * (1.0 + FULL_SLACK) || is_long && short.abs() < FULL_SLACK {
            return None;
        }
        let steps = steps as i32;
        match turns.last_mut() {
            // The turn between them came to no steps.
            Some(FingersTurn { plane: last, steps: sum }) if *last == plane => *sum += steps,
            Some(_) | None => turns.push(FingersTurn { plane, steps }),
        }
        turns.retain(|turn| turn.steps != 0);
    }
    Some(turns)
}
