//! Decompositions of an orientation according to docs/language.md: up to three turns about z and y, each by the nearest
//! number of steps or the next one, the short way round or the long one.
//!
//! The exact angles are found by search: the middle one from its effect on the axis of the first turn, the others from
//! the remaining rotation.

use nalgebra::{UnitQuaternion, Vector3};
use std::f64::consts::{PI, TAU};

/// Turns about z (`true`) or y, in steps.
pub type Turns = Vec<(bool, i32)>;

fn about(is_about_z: bool, angle_rad: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(if is_about_z { Vector3::z() } else { Vector3::y() } * angle_rad)
}

/// The three angles of turns about one axis, the other, and the first again: both solutions, or those with one turn
/// left out.
fn exact(goal: UnitQuaternion<f64>, first: bool) -> Vec<[f64; 3]> {
    let axis = if first { Vector3::z() } else { Vector3::y() };
    // The middle turn tilts the axis by exactly its own angle.
    let middle = (goal * axis).angle(&axis);
    let off = |angles: [f64; 3]| {
        let [a, b, c] = angles;
        (about(first, a) * about(!first, b) * about(first, c)).angle_to(&goal)
    };
    if middle < 1e-9 {
        let whole = best(&|a| off([a, 0.0, 0.0]));
        return vec![[whole, 0.0, 0.0]];
    }
    if middle > PI - 1e-9 {
        return vec![[best(&|a| off([a, PI, 0.0])), PI, 0.0], [0.0, PI, best(&|c| off([0.0, PI, c]))]];
    }
    let solution = |middle: f64| {
        // First the turn before it, then the turn after it.
        let there = best(&|a| (about(first, a) * about(!first, middle) * axis).angle(&(goal * axis)));
        [there, middle, best(&|c| off([there, middle, c]))]
    };
    vec![solution(middle), solution(-middle)]
}

/// The angle that minimises a function with a single minimum: sampled all round, then ever more finely.
fn best(of: &dyn Fn(f64) -> f64) -> f64 {
    let mut at = 0.0;
    let mut width = PI;
    while width > 1e-13 {
        let tried = (-8..=8).map(|k| at + width * f64::from(k) / 8.0);
        at = tried.min_by(|one, other| of(*one).total_cmp(&of(*other))).expect("seventeen");
        width /= 3.0;
    }
    at
}

/// All decompositions without duplicates; a step is `z_rad` about z and `y_rad` about y.
pub fn ways(goal: UnitQuaternion<f64>, [z_rad, y_rad]: [f64; 2]) -> Vec<Turns> {
    let mut found: Vec<Turns> = Vec::new();
    for first in [true, false] {
        for angles in exact(goal, first) {
            let axes = [first, !first, first];
            let choices = [0, 1, 2].map(|at| {
                let step_rad = if axes[at] { z_rad } else { y_rad };
                numbers(angles[at], step_rad)
            });
            for a in &choices[0] {
                for b in &choices[1] {
                    for c in &choices[2] {
                        let way = joined([(axes[0], *a), (axes[1], *b), (axes[2], *c)]);
                        if !found.contains(&way) {
                            found.push(way);
                        }
                    }
                }
            }
        }
    }
    found
}

/// The nearest number of steps and the next one, the short way and the long one; none exceeds about a full turn.
fn numbers(angle_rad: f64, step_rad: f64) -> Vec<i32> {
    let short = (angle_rad + PI).rem_euclid(TAU) - PI;
    let mut all = Vec::new();
    for angle in [short, short - TAU.copysign(short)] {
        if angle != short && short.abs() < 1e-2 {
            continue;
        }
        let exact = angle / step_rad;
        let nearest = exact.round();
        let next = if exact < nearest { nearest - 1.0 } else { nearest + 1.0 };
        all.extend([nearest, next].into_iter().filter(|steps| steps.abs() * step_rad <= TAU * 1.01));
    }
    all.into_iter().map(|steps| steps as i32).collect()
}

/// Removes zero turns and merges consecutive turns about the same axis.
fn joined(turns: [(bool, i32); 3]) -> Turns {
    let mut joined: Turns = Vec::new();
    for (is_about_z, steps) in turns {
        match joined.last_mut() {
            Some((last, sum)) if *last == is_about_z => *sum += steps,
            Some(_) | None => joined.push((is_about_z, steps)),
        }
        joined.retain(|(_, steps)| *steps != 0);
    }
    joined
}
