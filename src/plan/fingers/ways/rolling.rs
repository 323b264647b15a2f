//! Where the centre of a tip is that rolls on an outline.
//!
//! Rolling without slip in a plane is holonomic: a tip that only translates moves like the material of the part at its contact, which
//! gives u + θ = const for its rolling coordinate u (the turn of the normal plus the way over the tip's radius) and the part's angle θ.
//! So the tip's centre is R(θ)(p(u) + l2·n(u)) exactly, and nothing is integrated.

use crate::device::fingers::FingersFacts;
use crate::geometry::outline::Curve;
use crate::real::Real;
use nalgebra::Vector2;

/// The most chords of a rolling step or of an arc.
pub const MAX_CHORDS: f64 = 4096.0;

/// The centre of a tip that touches at a rolling coordinate, and the direction of the normal there, in the section's coordinates.
pub fn tip(curve: &Curve, facts: &FingersFacts, rolled_rad: f64) -> (Vector2<f64>, f64) {
    let spot = curve.spot(curve.way_rolled_um(rolled_rad, facts.tip_radius_um));
    let (sin, cos) = spot.normal_rad.sine_cosine();
    (Vector2::from(spot.point_um) + Vector2::new(cos, sin) * facts.tip_radius_um, spot.normal_rad)
}

/// How far a chord may be from the arc, as a share of how far the part reaches: what the tips' deviation turns the part by, about.
const CHORD_RAD: f64 = 1e-4;

/// Into how many equal chords a rolling step is cut, so that no tip is farther than half the tolerance from where it should be at
/// any instant, nor so far that the part is turned by more than about 0.006 deg in between; `None` if that needs too many.
///
/// Tips that go by chords are a little inside of the arcs, so that what they turn the part by, taken at each instant without slip,
/// drifts from what they turn it by over whole steps. It is this drift that the second limit keeps below 0.01 deg for each full turn.
///
/// The second derivative of the centre by the angle is R(θ)(n/(κ + 1/l2) − p), and a chord over an angle h is off by at most an
/// eighth of h² times its norm.
pub fn chords(curve: &Curve, facts: &FingersFacts, step_rad: f64) -> Option<u32> {
    let least_per_um = curve.least_curvature_per_um() + 1.0 / facts.tip_radius_um;
    let bend_um = curve.reach_um() + 1.0 / least_per_um;
    let off_um = (facts.tolerance_um / 2.0).min(CHORD_RAD * curve.reach_um());
    let count = (step_rad * (bend_um / (8.0 * off_um)).sqrt()).ceil().max(1.0);
    (least_per_um > 0.0 && count <= MAX_CHORDS).then_some(count as u32)
}
