//! The formulas of outlines: a point and its first two derivatives by a parameter.
//!
//! Input: an [`Outline`](super::Outline) whose numbers are in range. Output: an [`OutlineForm`], made of pieces, each
//! of them smooth. Promise: pieces follow one another counter-clockwise and without gaps; no parameter causes a
//! panic.

use super::jet::Jet;
use super::spline::Cubic;
use crate::real::Real;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A straight line or an arc of a circle, with its arc length as the parameter.
#[derive(Debug, Clone, Copy)]
pub(super) enum OutlineArc {
    Line { from: [f64; 2], along: [f64; 2] },
    Arc { centre: [f64; 2], radius_um: f64, from_rad: f64 },
}

/// A parameter of a piece.
#[derive(Debug, Clone, Copy)]
pub(super) struct PieceParameter {
    pub piece: usize,
    pub t: f64,
}

/// An outline as formulas.
#[derive(Debug, Clone)]
pub(super) enum OutlineForm {
    /// One piece; the parameter is the eccentric anomaly.
    Ellipse { semi: [f64; 2] },
    /// One piece; the parameter is the polar angle before scaling by the semi-axes.
    Superellipse { semi: [f64; 2], exponent: f64 },
    /// Lines and arcs with their lengths; the parameter of each begins at 0.
    Parts { parts: Vec<(OutlineArc, f64)> },
    /// The parameter of each piece begins at 0.
    Spline { cubics: Vec<Cubic> },
}

impl OutlineForm {
    /// A rectangle with rounded corners, from where the x axis leaves its right side; parts without length are left
    /// out.
    pub fn rounded(half: [f64; 2], radius_um: f64, [x, y]: [f64; 2]) -> OutlineForm {
        let [a, b] = [half[0] - radius_um, half[1] - radius_um];
        let line = |from, along, length| (OutlineArc::Line { from, along }, length);
        let arc = |centre, from_rad| (OutlineArc::Arc { centre, radius_um, from_rad }, radius_um * FRAC_PI_2);
        let all = [
            line([x + half[0], 0.0], [0.0, 1.0], b + y),
            arc([x + a, y + b], 0.0),
            line([x + a, y + half[1]], [-1.0, 0.0], a),
            line([x, y + half[1]], [-1.0, 0.0], a),
            arc([x - a, y + b], FRAC_PI_2),
            line([x - half[0], y + b], [0.0, -1.0], b),
            line([x - half[0], y], [0.0, -1.0], b),
            arc([x - a, y - b], 2.0 * FRAC_PI_2),
            line([x - a, y - half[1]], [1.0, 0.0], a),
            line([x, y - half[1]], [1.0, 0.0], a),
            arc([x + a, y - b], 3.0 * FRAC_PI_2),
            line([x + half[0], y - b], [0.0, 1.0], b - y),
        ];
        OutlineForm::Parts { parts: all.into_iter().filter(|(_, length)| *length > 0.0).collect() }
    }

    /// The part of a rectangle that the negative x axis meets, and the parameter there; `None` if that is exactly
    /// half way around.
    pub fn opposite_part(parts: &[(OutlineArc, f64)]) -> Option<PieceParameter> {
        let meets = |(piece, (part, length)): (usize, &(OutlineArc, f64))| match part {
            OutlineArc::Line { from: [_, y], along: [_, down] } if *down < 0.0 => {
                (0.0..=*length).contains(y).then_some(PieceParameter { piece, t: *y })
            }
            OutlineArc::Line { .. } | OutlineArc::Arc { .. } => None,
        };
        // The left side is split at its middle.
        parts.iter().enumerate().find_map(meets).filter(|place| place.t < parts[place.piece].1)
    }

    /// Number of pieces.
    pub fn pieces(&self) -> usize {
        match self {
            OutlineForm::Ellipse { .. } | OutlineForm::Superellipse { .. } => 1,
            OutlineForm::Parts { parts } => parts.len(),
            OutlineForm::Spline { cubics } => cubics.len(),
        }
    }

    /// The parameter range of a piece, with cuts where it may be less smooth.
    pub fn cuts(&self, piece: usize) -> Vec<f64> {
        match self {
            OutlineForm::Ellipse { .. } | OutlineForm::Superellipse { .. } => {
                (0..=8).map(|eighth| f64::from(eighth) * TAU / 8.0).collect()
            }
            OutlineForm::Parts { parts } => vec![0.0, parts[piece].1],
            OutlineForm::Spline { cubics } => vec![0.0, cubics[piece].length_um],
        }
    }

    /// Whether it can intersect itself.
    pub fn may_cross(&self) -> bool {
        match self {
            OutlineForm::Ellipse { .. } | OutlineForm::Superellipse { .. } | OutlineForm::Parts { .. } => false,
            OutlineForm::Spline { .. } => true,
        }
    }

    pub fn at(&self, piece: usize, t: f64) -> Jet {
        match self {
            OutlineForm::Ellipse { semi: [a, b] } => {
                let (s, c) = t.sine_cosine();
                Jet { point: [a * c, b * s], first: [-a * s, b * c], second: [-a * c, -b * s] }
            }
            OutlineForm::Superellipse { semi, exponent } => superellipse(*semi, *exponent, t),
            OutlineForm::Parts { parts } => part(&parts[piece].0, t),
            OutlineForm::Spline { cubics } => cubics[piece].at(t),
        }
    }
}

fn part(part: &OutlineArc, t: f64) -> Jet {
    match part {
        OutlineArc::Line { from, along } => {
            Jet { point: [from[0] + t * along[0], from[1] + t * along[1]], first: *along, second: [0.0, 0.0] }
        }
        OutlineArc::Arc { centre, radius_um, from_rad } => {
            let (s, c) = (from_rad + t / radius_um).sine_cosine();
            let point = [centre[0] + radius_um * c, centre[1] + radius_um * s];
            Jet { point, first: [-s, c], second: [-c / radius_um, -s / radius_um] }
        }
    }
}

/// r(φ) = (|cos φ|^n + |sin φ|^n)^(-1/n), scaled by the semi-axes; unlike the usual parametrisation it is smooth on
/// the axes.
fn superellipse(semi: [f64; 2], n: f64, t: f64) -> Jet {
    let (s, c) = t.sine_cosine();
    let [c_low, s_low] = [c.abs().power(n - 2.0), s.abs().power(n - 2.0)];
    let sum = c_low * c * c + s_low * s * s;
    let sum_1 = n * s * c * (s_low - c_low);
    let sum_2 = n * (n - 1.0) * (c_low * s * s + s_low * c * c) - n * sum;
    let r = sum.power(-1.0 / n);
    let share = sum_1 / sum;
    let r_1 = -r * share / n;
    let r_2 = r * ((1.0 / n + 1.0) / n * share * share - sum_2 / (n * sum));
    let jet = |low: f64, low_1: f64| [r * low, r_1 * low + r * low_1, r_2 * low + 2.0 * r_1 * low_1 - r * low];
    let (x, y) = (jet(c, -s), jet(s, c));
    let [a, b] = semi;
    Jet { point: [a * x[0], b * y[0]], first: [a * x[1], b * y[1]], second: [a * x[2], b * y[2]] }
}
