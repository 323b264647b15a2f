//! Outlines from lists of points.
//!
//! Input: a closed polyline, from a section of a mesh, a picture or a formula. Output: a spline. Promise: linear time
//! in the number of points; the result is deterministic; a smoothed outline has at most [`MAX_SMOOTHED`] points and
//! stays, averaged over a step, within about the unevenness of the polyline, unless corners are sharper than the
//! finest step.

use super::jet::{cross, dot, minus, norm};
use super::{MAX_UM, MIN_POINTS, Outline, OutlineError, spline_form};
use crate::real::Real;
use std::f64::consts::{PI, TAU};

/// Greatest number of points of a polyline that is smoothed.
pub const MAX_POLYGON: usize = 1_000_000;

/// Greatest number of points of a smoothed outline.
pub const MAX_SMOOTHED: usize = 512;

/// Fewest points of a smoothed outline.
const MIN_SMOOTHED: usize = 96;

/// Cutoffs of the low-pass filter: waves shorter than the perimeter divided by this number are damped. The lowest
/// cutoff whose outline is near enough to the polyline is used.
const CUTOFFS: [usize; 9] = [8, 12, 16, 24, 32, 48, 64, 96, 128];

/// Waves are damped by 1 / (1 + (k / cutoff)^ORDER).
const ORDER: i32 = 6;

/// Least and greatest tolerance, as shares of the size.
const NEAR: [f64; 2] = [1e-4, 1e-2];

impl Outline {
    /// A smooth outline along a closed polyline of up to [`MAX_POLYGON`] points, clockwise or not.
    ///
    /// Points are spread evenly, by arc length along the polyline, and short waves, which come from its straight
    /// sides or from noise, are damped. The strength follows from the polyline itself: from the distance of its
    /// typical corner to the line through its neighbours.
    ///
    /// # Errors
    /// The fault of the points; [`Curve::of`](super::Curve::of) reports whether the outline intersects itself.
    pub fn from_polygon(points_um: &[[f64; 2]]) -> Result<Outline, OutlineError> {
        if points_um.len() > MAX_POLYGON {
            return Err(OutlineError::TooManyPoints(points_um.len()));
        }
        if !points_um.iter().flatten().all(|number| number.abs() <= MAX_UM) {
            return Err(OutlineError::Number);
        }
        let mut ring = points_um.to_vec();
        ring.dedup();
        while ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        if ring.len() < MIN_POINTS {
            return Err(OutlineError::TooFewPoints(ring.len()));
        }
        let size_um = size(&ring);
        let area_um2 = area(&ring);
        if area_um2.abs() <= 1e-9 * size_um * size_um {
            return Err(OutlineError::NoArea);
        }
        if area_um2 < 0.0 {
            ring.reverse();
        }
        let near_um = unevenness(&ring).clamp(NEAR[0] * size_um, NEAR[1] * size_um);
        let smoothed = smooth(&ring, near_um);
        spline_form(&smoothed)?;
        Ok(Outline::Spline { points_um: smoothed })
    }
}

/// Pairs of neighbours of a ring, the last with the first included.
fn sides(ring: &[[f64; 2]]) -> impl Iterator<Item = [[f64; 2]; 2]> + '_ {
    (0..ring.len()).map(|at| [ring[at], ring[if at + 1 == ring.len() { 0 } else { at + 1 }]])
}

/// Half of the diagonal of a ring's bounding box.
fn size(ring: &[[f64; 2]]) -> f64 {
    let extent = |axis: usize| {
        let of_axis = ring.iter().map(|point| point[axis]);
        of_axis.clone().fold(f64::NEG_INFINITY, f64::max) - of_axis.fold(f64::INFINITY, f64::min)
    };
    extent(0).hypotenuse(extent(1)) / 2.0
}

/// Signed area, computed relative to the first corner, so that a ring far from the origin loses no digits.
fn area(ring: &[[f64; 2]]) -> f64 {
    sides(ring).map(|[a, b]| cross(minus(a, ring[0]), minus(b, ring[0])) / 2.0).sum()
}

/// Median distance of a corner from the line through its neighbours.
fn unevenness(ring: &[[f64; 2]]) -> f64 {
    let count = ring.len();
    let mut offs: Vec<f64> = (0..count)
        .map(|at| {
            let [before, here, after] = [ring[(at + count - 1) % count], ring[at], ring[(at + 1) % count]];
            let (line, off) = (minus(after, before), minus(here, before));
            let length = norm(line);
            if length > 0.0 { (cross(line, off) / length).abs() } else { norm(off) }
        })
        .collect();
    let middle = count / 2;
    *offs.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// A closed curve as a Fourier series: for each k, the factors of cos and sin for x and y.
struct Waves(Vec<[[f64; 2]; 2]>);

impl Waves {
    /// Fourier coefficients of samples that are averages over equal steps; the attenuation by averaging is compensated.
    fn of(averages: &[[f64; 2]]) -> Waves {
        let count = averages.len();
        let circle: Vec<(f64, f64)> = (0..count).map(|step| (TAU * step as f64 / count as f64).sine_cosine()).collect();
        let wave = |k: usize| {
            let mut factors = [[0.0; 2]; 2];
            for (step, average) in averages.iter().enumerate() {
                let (s, c) = circle[k * step % count];
                for axis in 0..2 {
                    factors[0][axis] += average[axis] * c;
                    factors[1][axis] += average[axis] * s;
                }
            }
            let angle = PI * k as f64 / count as f64;
            let share = if k == 0 { 1.0 } else { 2.0 * angle / angle.sine() };
            factors.map(|of_wave| of_wave.map(|factor| factor * share / count as f64))
        };
        Waves((0..count / 2).map(wave).collect())
    }

    /// Points at equal steps, with short waves damped.
    fn points(&self, count: usize, cutoff: usize) -> Vec<[f64; 2]> {
        let circle: Vec<(f64, f64)> = (0..count).map(|step| (TAU * step as f64 / count as f64).sine_cosine()).collect();
        let point = |step: usize| {
            let mut point = [0.0; 2];
            for (k, [cosine, sine]) in self.0.iter().enumerate().take(count / 2) {
                let (s, c) = circle[k * step % count];
                let damping = 1.0 + (k as f64 / cutoff as f64).whole_power(ORDER);
                (0..2).for_each(|axis| point[axis] += (cosine[axis] * c + sine[axis] * s) / damping);
            }
            point
        };
        (0..count).map(point).collect()
    }
}

fn smooth(ring: &[[f64; 2]], near_um: f64) -> Vec<[f64; 2]> {
    let averages = averages(ring);
    let waves = Waves::of(&averages);
    let undamped = waves.points(MAX_SMOOTHED, usize::MAX);
    let is_near = |cutoff: usize| {
        let damped = waves.points(MAX_SMOOTHED, cutoff);
        damped.iter().zip(&undamped).all(|(a, b)| norm(minus(*a, *b)) <= near_um)
    };
    let last = CUTOFFS[CUTOFFS.len() - 1];
    let cutoff = CUTOFFS.into_iter().find(|cutoff| is_near(*cutoff)).unwrap_or(last);
    waves.points((6 * cutoff).clamp(MIN_SMOOTHED, MAX_SMOOTHED), cutoff)
}

/// The averages of the points over equal steps of arc length.
fn averages(ring: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let perimeter: f64 = sides(ring).map(|[a, b]| norm(minus(b, a))).sum();
    let step = perimeter / MAX_SMOOTHED as f64;
    let mut sums = vec![[0.0; 2]; MAX_SMOOTHED];
    let mut way = 0.0;
    for [a, b] in sides(ring) {
        let along = minus(b, a);
        let length = dot(along, along).sqrt();
        let end = way + length;
        let (mut from, mut bin) = (way, ((way / step) as usize).min(MAX_SMOOTHED - 1));
        while from < end {
            let is_last = bin + 1 == MAX_SMOOTHED;
            let to = if is_last { end } else { end.min((bin + 1) as f64 * step) };
            let share = (f64::midpoint(from, to) - way) / length;
            (0..2).for_each(|axis| sums[bin][axis] += (to - from) * (a[axis] + share * along[axis]));
            from = to;
            bin = if is_last { bin } else { bin + 1 };
        }
        way = end;
    }
    sums.into_iter().map(|sum| sum.map(|of_axis| of_axis / step)).collect()
}
