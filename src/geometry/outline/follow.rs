//! Cuts an outline into short segments on which arc length and parameter are polynomials of each other.
//!
//! Input: a form and where to begin. Output: the segments in order, with the arc length and the angle of the normal
//! at each node. Promise: on a segment the arc length is correct to [`WAY_UM`], the tangent turns by at most
//! [`MAX_TURN_RAD`], and the curve stays within `sag` of the chord. Lengths are integrals by eight-point Gauss
//! quadrature; a segment is halved until the halves agree with the whole.

use super::OutlineError;
use super::form::{OutlineForm, PieceParameter};
use super::jet::{Jet, cross, dot, minus, norm};
use crate::real::Real;

/// Greatest error of the arc length along one segment.
const WAY_UM: f64 = 1e-9;

/// Greatest error of the length of one segment.
const LENGTH_UM: f64 = 1e-10;

/// Greatest turn of the tangent along one segment.
const MAX_TURN_RAD: f64 = 0.1;

/// Greatest number of halvings of a piece.
const MAX_DEPTH: u32 = 36;

/// Greatest number of segments of a curve, besides those per piece.
const MAX_SEGMENTS: usize = 1 << 12;

/// Additional segments per piece: smooth outlines need two or three of them.
const SEGMENTS_PER_PIECE: usize = 8;

/// Number of points at which the direction of a piece is sampled before it is followed.
const DIRECTION_SAMPLES: u32 = 4;

/// The positive nodes of the eight-point Gauss rule, with their weights.
const GAUSS: [(f64, f64); 4] = [
    (0.183_434_642_495_649_8, 0.362_683_783_378_362),
    (0.525_532_409_916_329, 0.313_706_645_877_887_3),
    (0.796_666_477_413_626_7, 0.222_381_034_453_374_5),
    (0.960_289_856_497_536_3, 0.101_228_536_290_376_3),
];

/// A polynomial of degree five on [0, 1].
#[derive(Debug, Clone, Copy)]
struct Quintic([f64; 6]);

impl Quintic {
    /// Interpolates value, slope and second derivative at both ends.
    fn between(from: [f64; 3], to: [f64; 3]) -> Quintic {
        let value = to[0] - from[0] - from[1] - from[2] / 2.0;
        let slope = to[1] - from[1] - from[2];
        let bend = to[2] - from[2];
        let high = [
            10.0 * value - 4.0 * slope + bend / 2.0,
            -15.0 * value + 7.0 * slope - bend,
            6.0 * value - 3.0 * slope + bend / 2.0,
        ];
        Quintic([from[0], from[1], from[2] / 2.0, high[0], high[1], high[2]])
    }

    fn at(&self, x: f64) -> f64 {
        self.0.iter().rev().fold(0.0, |sum, power| sum * x + power)
    }
}

/// A short part of the curve.
#[derive(Debug, Clone, Copy)]
pub(super) struct CurveSegment {
    pub piece: usize,
    pub from_t: f64,
    pub to_t: f64,
    pub length_um: f64,
    /// Greatest distance of the curve from the chord.
    pub sag_um: f64,
    /// Parameter as a polynomial of arc length, and vice versa, both as shares of the segment.
    share_by_way: Quintic,
    share_by_t: Quintic,
}

impl CurveSegment {
    /// The parameter at an arc length from the beginning of the segment.
    pub fn t(&self, way_um: f64) -> f64 {
        self.from_t + (self.to_t - self.from_t) * self.share_by_way.at(way_um / self.length_um)
    }

    /// The arc length from the beginning of the segment at a parameter.
    pub fn way_um(&self, t: f64) -> f64 {
        self.length_um * self.share_by_t.at((t - self.from_t) / (self.to_t - self.from_t))
    }
}

/// Calls `sum` with the nodes and weights of the Gauss rule on a parameter interval.
pub(super) fn gauss(from: f64, to: f64, mut sum: impl FnMut(f64, f64)) {
    let (middle, half) = (f64::midpoint(from, to), (to - from) / 2.0);
    for (node, weight) in GAUSS {
        sum(middle - half * node, weight * half);
        sum(middle + half * node, weight * half);
    }
}

fn length(form: &OutlineForm, piece: usize, from: f64, to: f64) -> f64 {
    let mut sum = 0.0;
    gauss(from, to, |t, weight| sum += weight * form.at(piece, t).speed());
    sum
}

/// Angle from one direction to another.
pub(super) fn turn(from: [f64; 2], to: [f64; 2]) -> f64 {
    cross(from, to).arc_tangent_over(dot(from, to))
}

/// The segments of a curve and its nodes; there is one more node than segments, and the last node coincides with
/// the first.
#[derive(Debug, Clone, Default)]
pub(super) struct SegmentedCurve {
    pub segments: Vec<CurveSegment>,
    pub ways_um: Vec<f64>,
    /// The direction of the outward normal, continuous along the curve.
    pub turns_rad: Vec<f64>,
    pub points_um: Vec<[f64; 2]>,
    /// Unit tangents.
    pub tangents: Vec<[f64; 2]>,
}

impl SegmentedCurve {
    /// Follows a form for one lap, from a parameter of a piece.
    pub fn of(form: &OutlineForm, begin: PieceParameter) -> Result<SegmentedCurve, OutlineError> {
        let mut segmented = SegmentedCurve::default();
        let most = MAX_SEGMENTS + SEGMENTS_PER_PIECE * form.pieces();
        let spans = spans(form, begin);
        if let Some(point_um) = too_rough(form, &spans, most) {
            return Err(OutlineError::Rough { point_um });
        }
        let mut open: Vec<(usize, f64, f64, u32)> =
            spans.into_iter().rev().map(|(piece, from, to)| (piece, from, to, 0)).collect();
        while let Some((piece, from, to, depth)) = open.pop() {
            let ends = [form.at(piece, from), form.at(piece, to)];
            if segmented.segments.len() >= most || ends.iter().any(|end| !is_sound(end)) {
                return Err(OutlineError::Rough { point_um: ends[0].point });
            }
            match measured(form, piece, [from, to], &ends, depth) {
                Some(segment) => segmented.add(segment, &ends),
                None => {
                    let middle = f64::midpoint(from, to);
                    open.push((piece, middle, to, depth + 1));
                    open.push((piece, from, middle, depth + 1));
                }
            }
        }
        Ok(segmented)
    }

    fn add(&mut self, segment: CurveSegment, ends: &[Jet; 2]) {
        if self.ways_um.is_empty() {
            let normal = ends[0].normal();
            self.node(0.0, normal[1].arc_tangent_over(normal[0]), &ends[0]);
        }
        let at = self.segments.len();
        let turned = turn(self.tangents[at], ends[1].first);
        self.node(self.ways_um[at] + segment.length_um, self.turns_rad[at] + turned, &ends[1]);
        self.segments.push(segment);
    }

    fn node(&mut self, way_um: f64, turn_rad: f64, jet: &Jet) {
        let speed = jet.speed();
        self.ways_um.push(way_um);
        self.turns_rad.push(turn_rad);
        self.points_um.push(jet.point);
        self.tangents.push([jet.first[0] / speed, jet.first[1] / speed]);
    }
}

fn is_sound(jet: &Jet) -> bool {
    let speed = jet.speed();
    speed.is_finite() && speed > 1e-12
}

/// The smooth parts of the pieces, for one lap from a beginning.
fn spans(form: &OutlineForm, begin: PieceParameter) -> Vec<(usize, f64, f64)> {
    let pieces = form.pieces();
    let mut spans = Vec::new();
    let mut add = |piece: usize, low: f64, high: f64| {
        let cuts = form.cuts(piece);
        // A sliver beside a cut is left out: it is shorter than any reported length.
        let least = 1e-12 * (cuts[cuts.len() - 1] - cuts[0]);
        for pair in cuts.windows(2) {
            let (from, to) = (pair[0].max(low), pair[1].min(high));
            if to - from > least {
                spans.push((piece, from, to));
            }
        }
    };
    add(begin.piece, begin.t, f64::INFINITY);
    (1..pieces).for_each(|step| add((begin.piece + step) % pieces, f64::NEG_INFINITY, f64::INFINITY));
    add(begin.piece, f64::NEG_INFINITY, begin.t);
    spans
}

/// The point where a curve turns most sharply, if it certainly turns more than `most` segments allow: following such
/// a curve until they run out would take long.
fn too_rough(form: &OutlineForm, spans: &[(usize, f64, f64)], most: usize) -> Option<[f64; 2]> {
    let (mut all_rad, mut sharpest) = (0.0, (0.0, None));
    for &(piece, from, to) in spans {
        let mut before = form.at(piece, from);
        for look in 1..=DIRECTION_SAMPLES {
            let here = form.at(piece, from + (to - from) * f64::from(look) / f64::from(DIRECTION_SAMPLES));
            let turned_rad = turn(before.first, here.first).abs();
            all_rad += turned_rad;
            if turned_rad > sharpest.0 {
                sharpest = (turned_rad, Some(before.point));
            }
            before = here;
        }
    }
    sharpest.1.filter(|_| all_rad > MAX_TURN_RAD * most as f64)
}

/// The segment between two parameters; `None` if it must be halved.
fn measured(
    form: &OutlineForm,
    piece: usize,
    [from, to]: [f64; 2],
    ends: &[Jet; 2],
    depth: u32,
) -> Option<CurveSegment> {
    let last = depth >= MAX_DEPTH;
    let inner = [0.25, 0.5, 0.75].map(|share| from + share * (to - from));
    let jets = inner.map(|t| form.at(piece, t));
    let turned = turn(ends[0].first, jets[1].first).abs() + turn(jets[1].first, ends[1].first).abs();
    if turned > MAX_TURN_RAD && !last {
        return None;
    }
    let (first, second) = (length(form, piece, from, inner[1]), length(form, piece, inner[1], to));
    let whole = first + second;
    if (length(form, piece, from, to) - whole).abs() > LENGTH_UM.max(1e-14 * norm(ends[0].point)) && !last {
        return None;
    }
    let (dt, speeds) = (to - from, ends.map(|end| end.speed()));
    let speed_derivatives = ends.map(|end| end.speed_derivative());
    let by_way = |end: usize| {
        [
            end as f64,
            whole / (speeds[end] * dt),
            -speed_derivatives[end] / speeds[end].whole_power(3) * whole * whole / dt,
        ]
    };
    let by_t = |end: usize| [end as f64, speeds[end] * dt / whole, speed_derivatives[end] * dt * dt / whole];
    let chord = minus(ends[1].point, ends[0].point);
    let off = |jet: &Jet| (cross(chord, minus(jet.point, ends[0].point)) / norm(chord)).abs();
    let segment = CurveSegment {
        piece,
        from_t: from,
        to_t: to,
        length_um: whole,
        sag_um: 1e-9 + 2.0 * jets.iter().map(off).fold(0.0, f64::max),
        share_by_way: Quintic::between(by_way(0), by_way(1)),
        share_by_t: Quintic::between(by_t(0), by_t(1)),
    };
    let quarters = [length(form, piece, from, inner[0]), first, first + length(form, piece, inner[1], inner[2])];
    let fits = (0..3).all(|at| {
        let way_off = (segment.way_um(inner[at]) - quarters[at]).abs();
        let t_off = (segment.t(quarters[at]) - inner[at]).abs() * jets[at].speed();
        way_off.max(t_off) <= WAY_UM
    });
    (fits || last).then_some(segment)
}
