//! Great circles, along which free tips travel about the part.

use super::rolling::MAX_CHORDS;
use crate::real::Real;
use nalgebra::Vector3;
use std::f64::consts::PI;

/// Directions that differ by less than this, or are opposite up to this, have no unique great circle.
const SAME_RAD: f64 = 1e-9;

/// Longest chord, however coarse the tolerance: 30 deg.
const MAX_CHORD_RAD: f64 = PI / 6.0;

/// A great circle that starts in a direction; both vectors are orthogonal unit vectors.
#[derive(Debug, Clone, Copy)]
pub struct Arc {
    from: Vector3<f64>,
    side: Vector3<f64>,
    /// 0 to π.
    pub angle_rad: f64,
}

impl Arc {
    /// The shorter arc between two unit vectors; between opposite ones, the arc that [`square_to`] selects.
    pub fn between(from: Vector3<f64>, to: Vector3<f64>) -> Arc {
        let along = from.dot(&to);
        let across = to - from * along;
        let side = if across.norm() > SAME_RAD { across.normalize() } else { square_to(from) };
        Arc { from, side, angle_rad: across.norm().arc_tangent_over(along) }
    }

    /// The unit vector at an angle from its start.
    pub fn at(&self, angle_rad: f64) -> Vector3<f64> {
        let (sin, cos) = angle_rad.sine_cosine();
        self.from * cos + self.side * sin
    }

    /// Number of equal chords such that none dips below the sphere by more than `dip_um`; `None` if that needs too many.
    pub fn chords(&self, radius_um: f64, dip_um: f64) -> Option<u32> {
        // acos would lose half of the digits.
        let chord_rad = 4.0 * (dip_um / (2.0 * radius_um)).min(1.0).sqrt().arc_sine();
        let count = (self.angle_rad / chord_rad.min(MAX_CHORD_RAD)).ceil().max(1.0);
        (count <= MAX_CHORDS).then_some(count as u32)
    }
}

/// A unit vector orthogonal to a given one: in the xy plane, unless the given one is nearly along z.
fn square_to(vector: Vector3<f64>) -> Vector3<f64> {
    let pole = if vector.z.abs() < 0.9 { Vector3::z() } else { Vector3::x() };
    pole.cross(&vector).normalize()
}

/// Arc by which a tip on a sphere steps aside from the point where a segment meets its sphere, to the nearest of the
/// tried places that is at least `apart_um` from the segment. `None` if the tip is already clear, or no place is.
pub fn aside(tip: Vector3<f64>, [from, to]: [Vector3<f64>; 2], apart_um: f64) -> Option<Arc> {
    const STEP_RAD: f64 = PI / 36.0;
    let radius_um = tip.norm();
    let is_clear = |place: Vector3<f64>| to_segment_um(place, from, to) >= apart_um;
    if is_clear(tip) {
        return None;
    }
    let here = tip / radius_um;
    let away = Arc::between(nearest(tip, from, to).try_normalize(0.0).unwrap_or(here), here);
    let steps = (0..36).map(|step| away.angle_rad + f64::from(step + 1) * STEP_RAD).filter(|angle| *angle <= PI);
    let mut clear = steps.filter(|angle| is_clear(away.at(*angle) * radius_um));
    clear.next().map(|angle| Arc::between(here, away.at(angle)))
}

/// The distance from a point to a segment.
pub fn to_segment_um(point: Vector3<f64>, from: Vector3<f64>, to: Vector3<f64>) -> f64 {
    (point - nearest(point, from, to)).norm()
}

fn nearest(point: Vector3<f64>, from: Vector3<f64>, to: Vector3<f64>) -> Vector3<f64> {
    let along = to - from;
    let length = along.norm_squared();
    let part = if length > 0.0 { ((point - from).dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
    from + along * part
}
