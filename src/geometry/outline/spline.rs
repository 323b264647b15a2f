//! A periodic cubic spline through points.
//!
//! Input: at least three points, no two neighbours coincident. Output: one cubic for each point, to the next one.
//! Promise: point, slope and second derivative are continuous all around. The parameter is the chord length; the
//! equations are cyclic and tridiagonal, and are solved with the Sherman-Morrison formula in linear time.

use super::jet::{Jet, cross, minus, norm};

/// a + b s + c s² + d s³ for s from 0 to `length_um`.
#[derive(Debug, Clone, Copy)]
pub(super) struct Cubic {
    pub length_um: f64,
    powers: [[f64; 2]; 4],
}

impl Cubic {
    pub fn at(&self, s: f64) -> Jet {
        let [a, b, c, d] = self.powers;
        let each = |make: &dyn Fn(usize) -> f64| [make(0), make(1)];
        Jet {
            point: each(&|axis| a[axis] + s * (b[axis] + s * (c[axis] + s * d[axis]))),
            first: each(&|axis| b[axis] + s * (2.0 * c[axis] + s * 3.0 * d[axis])),
            second: each(&|axis| 2.0 * c[axis] + 6.0 * d[axis] * s),
        }
    }

    /// Parameters where y is 0; an end on the axis counts. The next cubic begins at `end_y`, so that different
    /// rounding at the end of this one cannot hide a root between the two.
    pub fn roots_y(&self, end_y: f64) -> Vec<f64> {
        let y = |s: f64| if s == self.length_um { end_y } else { self.at(s).point[1] };
        let mut ends = vec![0.0];
        ends.extend(self.flat_y().into_iter().filter(|s| *s > 0.0 && *s < self.length_um));
        ends.push(self.length_um);
        let mut roots: Vec<f64> = ends.iter().copied().filter(|s| y(*s) == 0.0).collect();
        roots.extend(
            ends.windows(2).filter(|pair| y(pair[0]) * y(pair[1]) < 0.0).map(|pair| bisect(y, pair[0], pair[1])),
        );
        roots
    }

    /// Parameters where the derivative of y is 0, sorted.
    fn flat_y(&self) -> Vec<f64> {
        let [_, b, c, d] = self.powers.map(|power| power[1]);
        let square = c * c - 3.0 * b * d;
        if square < 0.0 {
            return Vec::new();
        }
        // The numerically stable quadratic formula for b + 2 c s + 3 d s².
        let sum = -(c + c.signum() * square.sqrt());
        let mut roots = vec![b / sum, sum / (3.0 * d)];
        roots.retain(|root| root.is_finite());
        roots.sort_by(f64::total_cmp);
        roots
    }
}

fn bisect(y: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let sign = y(low).signum();
    for _ in 0..80 {
        let middle = f64::midpoint(low, high);
        if y(middle) * sign > 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    f64::midpoint(low, high)
}

/// The cubics of the spline, in the order of the points.
pub(super) fn through(points: &[[f64; 2]]) -> Vec<Cubic> {
    let n = points.len();
    let next = |at: usize| if at + 1 == n { 0 } else { at + 1 };
    let lengths: Vec<f64> = (0..n).map(|at| norm(minus(points[next(at)], points[at]))).collect();
    let bends = [0, 1].map(|axis| bends(&lengths, &points.iter().map(|point| point[axis]).collect::<Vec<_>>()));
    let cubic = |at: usize| {
        let h = lengths[at];
        let mut powers = [[0.0; 2]; 4];
        for axis in 0..2 {
            let [from, to] = [bends[axis][at], bends[axis][next(at)]];
            let slope = (points[next(at)][axis] - points[at][axis]) / h - h * (2.0 * from + to) / 6.0;
            let of_axis = [points[at][axis], slope, from / 2.0, (to - from) / (6.0 * h)];
            (0..4).for_each(|power| powers[power][axis] = of_axis[power]);
        }
        Cubic { length_um: h, powers }
    };
    (0..n).map(cubic).collect()
}

/// The second derivatives of one coordinate at the points.
fn bends(lengths: &[f64], values: &[f64]) -> Vec<f64> {
    let n = values.len();
    let before = |at: usize| if at == 0 { n - 1 } else { at - 1 };
    let slopes: Vec<f64> = (0..n).map(|at| (values[(at + 1) % n] - values[at]) / lengths[at]).collect();
    let right: Vec<f64> = (0..n).map(|at| 6.0 * (slopes[at] - slopes[before(at)])).collect();
    // The cyclic corner entry becomes a rank-one update: A = T + u vᵗ with u = (-g, 0 … corner), v = (1, 0 … -corner
    // / g).
    let corner = lengths[n - 1];
    let diagonal = |at: usize| 2.0 * (lengths[before(at)] + lengths[at]);
    let gain = diagonal(0);
    let mut main: Vec<f64> = (0..n).map(diagonal).collect();
    main[0] += gain;
    main[n - 1] += corner * corner / gain;
    let mut push = vec![0.0; n];
    push[0] = -gain;
    push[n - 1] = corner;
    let plain = tridiagonal(&main, lengths, right);
    let pushed = tridiagonal(&main, lengths, push);
    let read = |x: &[f64]| x[0] - x[n - 1] * corner / gain;
    let share = read(&plain) / (1.0 + read(&pushed));
    plain.iter().zip(&pushed).map(|(x, z)| x - share * z).collect()
}

/// Solves a symmetric tridiagonal system; `side[i]` couples i and i + 1.
fn tridiagonal(main: &[f64], side: &[f64], mut right: Vec<f64>) -> Vec<f64> {
    let n = main.len();
    let mut pivot = main.to_vec();
    for at in 1..n {
        let share = side[at - 1] / pivot[at - 1];
        pivot[at] -= share * side[at - 1];
        right[at] -= share * right[at - 1];
    }
    right[n - 1] /= pivot[n - 1];
    for at in (0..n - 1).rev() {
        right[at] = (right[at] - side[at] * right[at + 1]) / pivot[at];
    }
    right
}

/// The area that the cubics enclose, positive if counter-clockwise; the three-point Gauss rule is exact here.
pub(super) fn area(cubics: &[Cubic]) -> f64 {
    let nodes = [(-0.6_f64.sqrt(), 5.0 / 18.0), (0.0, 8.0 / 18.0), (0.6_f64.sqrt(), 5.0 / 18.0)];
    let of = |cubic: &Cubic| -> f64 {
        let share = |(node, weight): (f64, f64)| {
            let jet = cubic.at(cubic.length_um * (1.0 + node) / 2.0);
            weight * cubic.length_um * cross(jet.point, jet.first) / 2.0
        };
        nodes.into_iter().map(share).sum()
    };
    cubics.iter().map(of).sum()
}
