//! The wrenches that two fingers bear, as half-spaces, and whether a third finger can supply the rest.

use super::load::{GripDemand, Wrench};
use super::{Contact, TOLERANCE};
use crate::real::Real;

/// Least slope of a half-space along the chord that bounds the force there; below it the side counts as parallel to the chord.
const PARALLEL: f64 = 1e-12;

/// A side of a triangle of forces: `normal · f <= bound_un`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct ForceHalfPlane {
    normal: [f64; 2],
    bound_un: f64,
}

impl ForceHalfPlane {
    fn over_un(&self, force_un: &[f64; 2]) -> f64 {
        dot(self.normal, *force_un) - self.bound_un
    }

    fn has(&self, force_un: &[f64; 2]) -> bool {
        self.over_un(force_un) <= 0.0
    }
}

/// The forces available to a finger: a friction cone with a shifted apex, cut off at the greatest normal force.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ForceCone {
    at_um: [f64; 2],
    /// The first two are the sides of the cone.
    sides: [ForceHalfPlane; 3],
    /// In order; for an unbounded cone, the two at normal force 1.
    corners_un: [[f64; 2]; 3],
    /// Number of sides and corners: 2 for an unbounded cone.
    count: usize,
    /// Whether no force is available, because more is withheld for other loads than the finger can exert.
    nothing: bool,
}

impl ForceCone {
    /// `|tangential| <= friction (normal + apex_un)` and `normal <= most_un`; infinite if unbounded.
    pub fn of(contact: &Contact, friction: f64, apex_un: f64, most_un: f64) -> ForceCone {
        let inward = contact.normal.map(|part| -part);
        let along = [-inward[1], inward[0]];
        let size = friction.hypotenuse(1.0);
        let cone = |sign: f64| ForceHalfPlane {
            normal: [0, 1].map(|k| (sign * along[k] - friction * inward[k]) / size),
            bound_un: friction * apex_un / size,
        };
        let force =
            |normal_un: f64, tangential_un: f64| [0, 1].map(|k| inward[k] * normal_un + along[k] * tangential_un);
        let base_un = if most_un.is_finite() { most_un } else { 1.0 };
        let half_un = friction * (base_un + apex_un);
        let corners_un = [force(base_un, half_un), force(base_un, -half_un), force(-apex_un, 0.0)];
        let count = if most_un.is_finite() { 3 } else { 2 };
        let nothing = half_un < -TOLERANCE * friction * (base_un + apex_un.abs());
        let cap = ForceHalfPlane { normal: inward, bound_un: most_un };
        ForceCone { at_um: contact.point_um, sides: [cone(1.0), cone(-1.0), cap], corners_un, count, nothing }
    }

    fn cone(&self) -> &[ForceHalfPlane] {
        &self.sides[..2]
    }

    fn corners(&self) -> impl Iterator<Item = &[f64; 2]> + Clone {
        self.corners_un[..self.count].iter()
    }
}

/// A half-space of wrenches: `force · F + moment M <= bound_un`.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Half {
    force: [f64; 2],
    moment_per_um: f64,
    bound_un: f64,
}

impl Half {
    const NONE: Half = Half { force: [0.0; 2], moment_per_um: 0.0, bound_un: 0.0 };

    fn of(&self, wrench: &Wrench) -> f64 {
        self.force[0] * wrench.force_un[0]
            + self.force[1] * wrench.force_un[1]
            + self.moment_per_um * wrench.moment_un_um
    }

    fn plus(&self, factor: f64, other: &Half, other_factor: f64) -> Half {
        Half {
            force: [0, 1].map(|k| factor * self.force[k] + other_factor * other.force[k]),
            moment_per_um: factor * self.moment_per_um + other_factor * other.moment_per_um,
            bound_un: factor * self.bound_un + other_factor * other.bound_un,
        }
    }

    /// The same half-space with a unit normal, moments converted to forces at `arm_um`.
    fn scaled(self, arm_um: f64) -> Half {
        let size = (dot(self.force, self.force) + (self.moment_per_um * arm_um).whole_power(2)).sqrt();
        self.plus(1.0 / size, &Half::NONE, 0.0)
    }

    /// The forces at a point that leave the rest of a wrench in the half-space: half · (wrench − force) <= bound.
    fn left_at(&self, [x_um, y_um]: [f64; 2], wrench: &Wrench, slack_un: f64) -> ForceHalfPlane {
        let normal = [self.moment_per_um * y_um - self.force[0], -self.moment_per_um * x_um - self.force[1]];
        ForceHalfPlane { normal, bound_un: self.bound_un - self.of(wrench) + slack_un }
    }
}

/// The wrenches that two fingers bear. The one free unknown, the force along the line through both contacts, is
/// eliminated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct LineForce {
    halves: [Half; 9],
    count: usize,
    /// Whether one of the two can exert no force.
    nothing: bool,
    slack_un: f64,
}

impl LineForce {
    /// The wrenches of two fingers; none if their contacts coincide.
    pub fn between(a: &ForceCone, b: &ForceCone, arm_um: f64, slack_un: f64) -> LineForce {
        let mut line = LineForce { halves: [Half::NONE; 9], count: 0, nothing: true, slack_un };
        let (along, length_um) = chord(a, b);
        if a.nothing || b.nothing || length_um == 0.0 {
            return line;
        }
        line.nothing = false;
        let bounds = WrenchBounds::of(a, b, along, length_um);
        for (low, slope) in bounds.each() {
            if slope.abs() <= PARALLEL {
                line.push(low.scaled(arm_um));
            }
            for (high, rise) in bounds.each().filter(|(_, rise)| *slope < -PARALLEL && *rise > PARALLEL) {
                line.push(low.plus(*rise, high, -slope).scaled(arm_um));
            }
        }
        line
    }

    fn push(&mut self, half: Half) {
        self.halves[self.count] = half;
        self.count += 1;
    }

    fn halves(&self) -> &[Half] {
        &self.halves[..self.count]
    }

    /// Whether the two can exert a wrench.
    pub fn bears(&self, wrench: &Wrench) -> bool {
        !self.nothing && self.halves().iter().all(|half| half.of(wrench) <= half.bound_un + self.slack_un)
    }

    /// Whether the two and a third finger together meet a condition; without load and adhesion the third must press.
    pub fn takes(&self, third: &ForceCone, demand: &GripDemand) -> bool {
        let wrench = match demand {
            GripDemand::Squeeze => Wrench::NONE,
            GripDemand::Exert(wrench) => *wrench,
        };
        if self.nothing || third.nothing {
            return false;
        }
        let mut sides = [ForceHalfPlane { normal: [0.0; 2], bound_un: 0.0 }; 9];
        let mut within = [true; 3];
        for (half, side) in self.halves().iter().zip(&mut sides) {
            *side = half.left_at(third.at_um, &wrench, self.slack_un);
            let inside = third.corners().map(|corner| side.has(corner));
            if inside.clone().all(|is_inside| !is_inside) {
                return false;
            }
            within.iter_mut().zip(inside).for_each(|(within, is_inside)| *within &= is_inside);
        }
        if within[..third.count].contains(&true) {
            return true;
        }
        let mut left = ForcePolygon::of(third);
        sides[..self.count].iter().for_each(|side| left.cut(side));
        left.count > 0
    }
}

/// Whether some direction along the line through both contacts lies in both cones, so that the force may be arbitrarily large.
pub(super) fn are_antipodal(a: &ForceCone, b: &ForceCone) -> bool {
    let (along, _) = chord(a, b);
    let slopes = || {
        let of_a = a.cone().iter().map(|side| dot(side.normal, along));
        of_a.chain(b.cone().iter().map(|side| -dot(side.normal, along)))
    };
    slopes().all(|slope| slope <= TOLERANCE) || slopes().all(|slope| slope >= -TOLERANCE)
}

// The direction from one contact to the other, and their distance.
fn chord(a: &ForceCone, b: &ForceCone) -> ([f64; 2], f64) {
    let run_um = [b.at_um[0] - a.at_um[0], b.at_um[1] - a.at_um[1]];
    let length_um = dot(run_um, run_um).sqrt();
    (run_um.map(|part| part / length_um), length_um)
}

/// Half-spaces of wrenches and the force along the line: `half + slope · force <= bound`.
struct WrenchBounds {
    all: [(Half, f64); 6],
    count: usize,
}

impl WrenchBounds {
    fn of(a: &ForceCone, b: &ForceCone, along: [f64; 2], length_um: f64) -> WrenchBounds {
        let across = [-along[1], along[0]];
        // The transverse force of b follows from its moment about a, divided by the distance.
        let [x, y] = a.at_um.map(|part| part / length_um);
        let of_b = Half { force: [y, -x], moment_per_um: 1.0 / length_um, bound_un: 0.0 };
        let mut bounds = WrenchBounds { all: [(Half::NONE, 0.0); 6], count: 0 };
        for side in &a.sides[..a.count] {
            let free = Half { force: side.normal, moment_per_um: 0.0, bound_un: side.bound_un };
            bounds.push(free.plus(1.0, &of_b, -dot(side.normal, across)), dot(side.normal, along));
        }
        for side in &b.sides[..b.count] {
            let free = Half { bound_un: side.bound_un, ..Half::NONE };
            bounds.push(free.plus(1.0, &of_b, dot(side.normal, across)), -dot(side.normal, along));
        }
        bounds
    }

    fn push(&mut self, half: Half, slope: f64) {
        self.all[self.count] = (half, slope);
        self.count += 1;
    }

    fn each(&self) -> impl Iterator<Item = &(Half, f64)> {
        self.all[..self.count].iter()
    }
}

/// The corners of a convex polygon of forces, in order.
struct ForcePolygon {
    at_un: [[f64; 2]; 12],
    count: usize,
}

impl ForcePolygon {
    fn of(reach: &ForceCone) -> ForcePolygon {
        let mut corners = ForcePolygon { at_un: [[0.0; 2]; 12], count: reach.count };
        corners.at_un[..3].copy_from_slice(&reach.corners_un);
        corners
    }

    /// Clips to the inner side (Sutherland and Hodgman).
    fn cut(&mut self, side: &ForceHalfPlane) {
        let (all, count) = (self.at_un, self.count);
        self.count = 0;
        for k in 0..count {
            let (here, next) = (all[k], all[(k + 1) % count]);
            let (over_here, over_next) = (side.over_un(&here), side.over_un(&next));
            if over_here <= 0.0 {
                self.push(here);
            }
            if (over_here <= 0.0) != (over_next <= 0.0) {
                let part = over_here / (over_here - over_next);
                self.push([0, 1].map(|k| here[k] + part * (next[k] - here[k])));
            }
        }
    }

    fn push(&mut self, corner_un: [f64; 2]) {
        // Each half-plane adds at most one corner: 3 + 9.
        if self.count < self.at_un.len() {
            self.at_un[self.count] = corner_un;
            self.count += 1;
        }
    }
}

pub(super) fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}
