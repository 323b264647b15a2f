//! The formulas of outlines, piece by piece: a point and its derivative by the parameter.
//!
//! Input: an outline of the claims. Output: its pieces, counter-clockwise and without gaps if the outline is valid.
//! The formulas differ from those of planners where others serve. A superellipse is eight graphs over its axes, not a
//! polar curve. A spline is given by its slopes at the points, found by iteration, not by its second derivatives,
//! found by elimination.

use crate::geometry::outline::Outline;
use crate::real::Real;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// A point on a piece, and its derivative by the parameter.
#[derive(Debug, Clone, Copy)]
pub struct ContourJet {
    pub point_um: [f64; 2],
    pub velocity: [f64; 2],
}

impl ContourJet {
    pub fn speed(&self) -> f64 {
        let [x, y] = self.velocity;
        (x * x + y * y).sqrt()
    }
}

/// A smooth part of an outline.
#[derive(Debug, Clone, Copy)]
pub enum Piece {
    /// An eighth of an ellipse; the parameter is the eccentric anomaly.
    Eighth { semi_um: [f64; 2], number: u8 },
    /// An eighth of |x/a|^n + |y/b|^n = 1, as a graph over the axis from which it is farther; the parameter is the
    /// coordinate on that axis.
    Octant { semi_um: [f64; 2], exponent: f64, number: u8 },
    /// A straight side, with a parameter from 0 to 1.
    Line { from_um: [f64; 2], to_um: [f64; 2] },
    /// A quarter of a circle; the parameter is the direction from its centre.
    Corner { centre_um: [f64; 2], radius_um: f64, number: u8 },
    /// A cubic by its ends and their slopes; the parameter is the length along the chord.
    Cubic { ends_um: [[f64; 2]; 2], slopes: [[f64; 2]; 2], chord_um: f64 },
}

impl Piece {
    /// The parameters at its beginning and end.
    pub fn range(&self) -> [f64; 2] {
        match *self {
            Piece::Eighth { number, .. } => [0, 1].map(|end| f64::from(number + end) * FRAC_PI_4),
            Piece::Octant { exponent, .. } => [0.0, diagonal(exponent)],
            Piece::Line { .. } => [0.0, 1.0],
            Piece::Corner { number, .. } => [0, 1].map(|end| f64::from(number + end) * FRAC_PI_2),
            Piece::Cubic { chord_um, .. } => [0.0, chord_um],
        }
    }

    pub fn at(&self, t: f64) -> ContourJet {
        match *self {
            Piece::Eighth { semi_um: [a, b], .. } => {
                let (s, c) = t.sine_cosine();
                ContourJet { point_um: [a * c, b * s], velocity: [-a * s, b * c] }
            }
            Piece::Octant { semi_um, exponent, number } => octant(semi_um, exponent, number, t),
            Piece::Line { from_um: [x, y], to_um } => {
                let [along, up] = [to_um[0] - x, to_um[1] - y];
                ContourJet { point_um: [x + along * t, y + up * t], velocity: [along, up] }
            }
            Piece::Corner { centre_um: [x, y], radius_um, .. } => {
                let (s, c) = t.sine_cosine();
                ContourJet {
                    point_um: [x + radius_um * c, y + radius_um * s],
                    velocity: [-radius_um * s, radius_um * c],
                }
            }
            Piece::Cubic { ends_um: [from, to], slopes, chord_um } => {
                let u = t / chord_um;
                let rest = 1.0 - u;
                let rise = [0, 1].map(|axis| (to[axis] - from[axis]) / chord_um);
                let point = |axis: usize| {
                    let bent = (slopes[0][axis] - rise[axis]) * rest - (slopes[1][axis] - rise[axis]) * u;
                    from[axis] + chord_um * u * (rise[axis] + rest * bent)
                };
                let velocity = |axis: usize| {
                    let [first, last] = [slopes[0][axis], slopes[1][axis]];
                    6.0 * u * rest * rise[axis] + rest * (1.0 - 3.0 * u) * first + u * (3.0 * u - 2.0) * last
                };
                ContourJet { point_um: [point(0), point(1)], velocity: [velocity(0), velocity(1)] }
            }
        }
    }

    /// Signed curvature, given the jet at `t`: positive where the outline is convex.
    pub fn curvature_per_um(&self, t: f64, jet: &ContourJet) -> f64 {
        let cube = jet.speed().whole_power(3);
        match *self {
            Piece::Eighth { semi_um: [a, b], .. } => a * b / cube,
            Piece::Octant { semi_um: [a, b], exponent: n, number } => {
                let low = graphed(n, number, t);
                let high = (1.0 - low.power(n)).power(1.0 / n);
                a * b * (n - 1.0) * low.power(n - 2.0) / high.power(2.0 * n - 1.0) / cube
            }
            Piece::Line { .. } => 0.0,
            Piece::Corner { radius_um, .. } => radius_um.recip(),
            Piece::Cubic { ends_um: [from, to], slopes, chord_um } => {
                let u = t / chord_um;
                let bend = |axis: usize| {
                    let rise = (to[axis] - from[axis]) / chord_um;
                    let [first, last] = [slopes[0][axis], slopes[1][axis]];
                    ((6.0 - 12.0 * u) * rise + (6.0 * u - 4.0) * first + (6.0 * u - 2.0) * last) / chord_um
                };
                (jet.velocity[0] * bend(1) - jet.velocity[1] * bend(0)) / cube
            }
        }
    }
}

/// The coordinate at which the graphs of a superellipse meet, in units of either semi-axis.
fn diagonal(n: f64) -> f64 {
    0.5f64.power(1.0 / n)
}

/// The coordinate on the axis over which an octant is a graph; in every second octant it runs backwards. Clamped to 0:
/// by rounding, a root on the axis may lie below it, where the power is not a number.
fn graphed(n: f64, number: u8, t: f64) -> f64 {
    let place = if number.is_multiple_of(2) { t } else { diagonal(n) - t };
    place.max(0.0)
}

fn octant(semi_um: [f64; 2], n: f64, number: u8, t: f64) -> ContourJet {
    let low = graphed(n, number, t);
    let share = low.power(n);
    let high = (1.0 - share).power(1.0 / n);
    let slope = if low > 0.0 { -(share / low) / ((1.0 - share) / high) } else { 0.0 };
    let (sign, high_axis, low_axis) = match number.is_multiple_of(2) {
        true => (1.0, number / 2, number / 2 + 1),
        false => (-1.0, number.div_ceil(2), number / 2),
    };
    // The axes in order: right, up, left, down.
    let directed = |axis: u8, value: f64| match axis % 4 {
        0 => [value * semi_um[0], 0.0],
        1 => [0.0, value * semi_um[1]],
        2 => [-value * semi_um[0], 0.0],
        _ => [0.0, -value * semi_um[1]],
    };
    let sum = |one: [f64; 2], other: [f64; 2]| [one[0] + other[0], one[1] + other[1]];
    ContourJet {
        point_um: sum(directed(high_axis, high), directed(low_axis, low)),
        velocity: sum(directed(high_axis, slope * sign), directed(low_axis, sign)),
    }
}

/// The pieces of an outline; `None` if its numbers are invalid.
pub fn all(outline: &Outline) -> Option<Vec<Piece>> {
    let is_size = |size_um: &f64| size_um.is_finite() && *size_um > 0.0;
    match outline {
        Outline::Ellipse { semi_um } => {
            let eighth = |number| Piece::Eighth { semi_um: *semi_um, number };
            semi_um.iter().all(is_size).then(|| (0..8).map(eighth).collect())
        }
        Outline::Superellipse { semi_um, exponent } => {
            let octant = |number| Piece::Octant { semi_um: *semi_um, exponent: *exponent, number };
            let is_sound = semi_um.iter().all(is_size) && exponent.is_finite() && *exponent >= 2.0;
            is_sound.then(|| (0..8).map(octant).collect())
        }
        Outline::RoundedRectangle { half_um, radius_um, centre_um } => {
            let is_sound = half_um.iter().chain([radius_um]).all(is_size)
                && half_um.iter().all(|half| half >= radius_um)
                && centre_um.iter().all(|place| place.is_finite());
            is_sound.then(|| rounded_rectangle(*half_um, *radius_um, *centre_um))
        }
        Outline::Spline { points_um } => spline(points_um),
    }
}

/// Sides and corners in turn, starting at the middle of the right side; each vertical side is two lines.
fn rounded_rectangle([x_um, y_um]: [f64; 2], radius_um: f64, middle_um: [f64; 2]) -> Vec<Piece> {
    let off_origin = |point_um: [f64; 2]| [0, 1].map(|axis| point_um[axis] + middle_um[axis]);
    let [a_um, b_um] = [x_um - radius_um, y_um - radius_um];
    let stops_um = [
        [x_um, 0.0],
        [x_um, b_um],
        [a_um, y_um],
        [-a_um, y_um],
        [-x_um, b_um],
        [-x_um, 0.0],
        [-x_um, -b_um],
        [-a_um, -y_um],
        [a_um, -y_um],
        [x_um, -b_um],
        [x_um, 0.0],
    ]
    .map(off_origin);
    let corner = |number, centre_um| Piece::Corner { centre_um: off_origin(centre_um), radius_um, number };
    let piece = |at: usize| match at {
        1 => corner(0, [a_um, b_um]),
        3 => corner(1, [-a_um, b_um]),
        6 => corner(2, [-a_um, -b_um]),
        8 => corner(3, [a_um, -b_um]),
        _ => Piece::Line { from_um: stops_um[at], to_um: stops_um[at + 1] },
    };
    (0..10).filter(|at| stops_um[*at] != stops_um[at + 1]).map(piece).collect()
}

/// Fewest points of a spline.
const MIN_POINTS: usize = 4;

/// Greatest number of Gauss-Seidel sweeps over the slopes of a spline; each at least halves their error.
const MAX_SWEEPS: usize = 80;

/// The periodic cubic spline through points, parametrised by the lengths of its chords: second derivatives of
/// neighbouring pieces agree at each point. The equations are solved by Gauss-Seidel iteration.
fn spline(points_um: &[[f64; 2]]) -> Option<Vec<Piece>> {
    let count = points_um.len();
    let next = |at: usize| if at + 1 == count { 0 } else { at + 1 };
    let before = |at: usize| if at == 0 { count - 1 } else { at - 1 };
    let run = |at: usize| [0, 1].map(|axis| points_um[next(at)][axis] - points_um[at][axis]);
    if count < MIN_POINTS {
        return None;
    }
    let chords_um: Vec<f64> = (0..count).map(|at| run(at)[0].hypotenuse(run(at)[1])).collect();
    if !chords_um.iter().all(|chord_um| chord_um.is_finite() && *chord_um > 0.0) {
        return None;
    }
    let rises: Vec<[f64; 2]> = (0..count).map(|at| run(at).map(|part| part / chords_um[at])).collect();
    let mut slopes = rises.clone();
    for _ in 0..MAX_SWEEPS {
        let mut change = 0.0f64;
        for at in 0..count {
            let [last, own] = [chords_um[before(at)], chords_um[at]];
            for axis in 0..2 {
                let pull = own * (3.0 * rises[before(at)][axis] - slopes[before(at)][axis])
                    + last * (3.0 * rises[at][axis] - slopes[next(at)][axis]);
                let slope = pull / (2.0 * (last + own));
                change = change.max((slope - slopes[at][axis]).abs());
                slopes[at][axis] = slope;
            }
        }
        if change < f64::EPSILON {
            break;
        }
    }
    let cubic = |at: usize| Piece::Cubic {
        ends_um: [points_um[at], points_um[next(at)]],
        slopes: [slopes[at], slopes[next(at)]],
        chord_um: chords_um[at],
    };
    Some((0..count).map(cubic).collect())
}
