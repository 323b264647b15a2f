//! Centre of a tip that rolls on an outline.
//!
//! Rolling without slip in a plane is holonomic: a tip that only translates moves like the material of the part at its contact,
//! which gives u + θ = const for its rolling coordinate u (the turn of the normal plus the arc length over the tip's radius) and
//! the part's angle θ. So the tip's centre is R(θ)(p(u) + l2·n(u)) exactly, and no integration is needed.

use crate::device::fingers::FingersFacts;
use crate::geometry::outline::Curve;
use crate::real::Real;
use nalgebra::Vector2;

/// Most chords of a rolling step or of an arc.
pub const MAX_CHORDS: f64 = 4096.0;

/// The centre of a tip in contact at a rolling coordinate, and the direction of the normal there, in the section's coordinates.
pub fn tip(curve: &Curve, facts: &FingersFacts, rolled_rad: f64) -> (Vector2<f64>, f64) {
    let spot = curve.point_at(curve.way_rolled_um(rolled_rad, facts.tip_radius_um));
    let (sin, cos) = spot.normal_rad.sine_cosine();
    (Vector2::from(spot.point_um) + Vector2::new(cos, sin) * facts.tip_radius_um, spot.normal_rad)
}

/// Largest deviation of a chord from the arc, as a share of the part's reach: about the angle by which it turns the part.
const CHORD_RAD: f64 = 1e-4;

/// Number of equal chords per rolling step such that no tip deviates by more than half the tolerance at any instant,
/// nor turns the part by more than about 0.006 deg in between; `None` if that needs too many.
///
/// Tips on chords are slightly inside the arcs, so the rotation that they cause, integrated without slip, drifts from the rotation
/// over whole steps. The second limit keeps this drift below 0.01 deg per full turn.
///
/// The second derivative of the centre with respect to the angle is R(θ)(n/(κ + 1/l2) − p), and a chord over an angle h deviates by
/// at most an eighth of h² times its norm.
pub fn chords(curve: &Curve, facts: &FingersFacts, step_rad: f64) -> Option<u32> {
    let least_per_um = curve.least_curvature_per_um() + 1.0 / facts.tip_radius_um;
    let bend_um = curve.reach_um() + 1.0 / least_per_um;
    let off_um = (facts.tolerance_um / 2.0).min(CHORD_RAD * curve.reach_um());
    let count = (step_rad * (bend_um / (8.0 * off_um)).sqrt()).ceil().max(1.0);
    (least_per_um > 0.0 && count <= MAX_CHORDS).then_some(count as u32)
}
