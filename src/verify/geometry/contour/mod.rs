//! Closed smooth outlines: the contact of a tip, and its arc length along the outline.
//!
//! Input: an outline of the claims, in micrometres. Output: a [`Contour`], parametrised counter-clockwise by arc
//! length from its farthest crossing of the positive x axis. Planners look arc lengths up in tables of polynomials;
//! here each is integrated on demand, by five-point Gauss quadrature from the preceding node. The nearest point is
//! found by branch and bound, with bounds from the arc length between nodes, then by regula falsi. Promise: arc
//! lengths, normals and distances are correct to about 1e-9 um for outlines that the checker accepts; no other outline
//! causes a panic or an endless loop.

mod piece;
#[cfg(test)]
mod tests;

use crate::geometry::fault::{Fault, inject};
use crate::geometry::outline::Outline;
use crate::real::Real;
use piece::{ContourJet, Piece};
use std::f64::consts::{PI, TAU};

/// Greatest turn of the tangent from one node to the next.
const MAX_TURN_RAD: f64 = 0.12;

/// Greatest error of the arc length between two nodes: the larger of a length and a fraction of the distance from the
/// origin.
const WAY_UM: f64 = 1e-11;
const WAY_SHARE: f64 = 1e-14;

/// Greatest number of halvings of a piece.
const MAX_HALVINGS: u32 = 40;

/// Greatest number of nodes: a fixed part, and a part per piece.
const MAX_NODES: [usize; 2] = [1 << 13, 16];

/// Greatest number of halvings towards the other end in search of the sign beside a root.
const MAX_HALVINGS_BESIDE: i32 = 30;

/// Greatest number of iterations of a root search.
const MAX_STEPS: usize = 100;

/// A root is accepted when the residual, or the step as a fraction of the search interval, is this small.
const ROOT_UM: f64 = 1e-13;
const ROOT_SHARE: f64 = 1e-12;

/// Nodes and weights of five-point Gauss quadrature on -1 to 1.
const GAUSS: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_1),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_5),
    (0.906_179_845_938_664, 0.236_926_885_056_189_1),
];

/// A part of a piece between two nodes.
#[derive(Debug, Clone, Copy)]
struct ContourSpan {
    piece: usize,
    from_t: f64,
    to_t: f64,
}

/// The point between two spans.
#[derive(Debug, Clone, Copy)]
struct ContourNode {
    arc_length_um: f64,
    point_um: [f64; 2],
    tangent: [f64; 2],
    /// The direction of the outward normal, continuous along the outline.
    normal_rad: f64,
}

/// The point of an outline nearest to a given point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foot {
    pub arc_length_um: f64,
    /// Signed distance of the given point from the outline; negative inside.
    pub distance_um: f64,
    pub point_um: [f64; 2],
    /// The direction of the outward normal.
    pub normal_rad: f64,
    /// Turn of the normal from the start of the outline.
    pub turned_rad: f64,
    /// Positive where the outline is convex.
    pub curvature_per_um: f64,
}

impl Foot {
    /// Turn of a part while a tip of this radius rolls from the start of the outline to here.
    pub fn turn_of_tip_rad(&self, tip_radius_um: f64) -> f64 {
        inject(Fault::JudgedRoll, self.turned_rad + self.arc_length_um / tip_radius_um)
    }
}

/// A closed smooth outline round the origin.
#[derive(Debug)]
pub struct Contour {
    pieces: Vec<Piece>,
    spans: Vec<ContourSpan>,
    /// One more than there are spans; the last one coincides with the first.
    nodes: Vec<ContourNode>,
    farthest_um: f64,
}

impl Contour {
    /// Prepares an outline; `None` if it has corners, is too rough, or does not run once round the origin.
    pub fn of(outline: &Outline) -> Option<Contour> {
        match outline {
            Outline::Spline { points_um } => Contour::from_pieces(outline).or_else(|| {
                let points_um = points_um.iter().rev().copied().collect();
                Contour::from_pieces(&Outline::Spline { points_um })
            }),
            Outline::Ellipse { .. } | Outline::Superellipse { .. } | Outline::RoundedRectangle { .. } => {
                Contour::from_pieces(outline)
            }
        }
    }

    fn from_pieces(outline: &Outline) -> Option<Contour> {
        let pieces = piece::all(outline)?;
        let spans = begun_on_axis(&pieces, halved(&pieces)?)?;
        let nodes = nodes(&pieces, &spans)?;
        let mut contour = Contour { pieces, spans, nodes, farthest_um: 0.0 };
        let turned_rad = contour.last().normal_rad - contour.nodes[0].normal_rad;
        if (turned_rad - TAU).abs() > 1e-3 || contour.foot([0.0, 0.0])?.distance_um >= 0.0 {
            return None;
        }
        contour.farthest_um = contour.farthest_um();
        Some(contour)
    }

    fn last(&self) -> &ContourNode {
        &self.nodes[self.spans.len()]
    }

    /// The perimeter.
    pub fn round_um(&self) -> f64 {
        self.last().arc_length_um - self.nodes[0].arc_length_um
    }

    /// Greatest distance from the origin.
    pub fn radius_um(&self) -> f64 {
        self.farthest_um
    }

    /// The farthest crossing of the negative x axis.
    pub fn opposite(&self) -> Option<Foot> {
        let roots = (0..self.spans.len()).flat_map(|at| axis_roots(&self.pieces, self.spans[at]).map(move |t| (at, t)));
        let x_um = |(at, t): &(usize, f64)| self.jet(*at, *t).point_um[0];
        let left = roots.filter(|place| x_um(place) < 0.0);
        let (at, t) = left.min_by(|one, other| x_um(one).total_cmp(&x_um(other)))?;
        Some(self.foot_at(at, t, 0, self.jet(at, t).point_um))
    }

    /// The contact of a tip of this radius after it has turned the part by an angle, from the start of the outline.
    /// Assumes that the tip can touch all of the outline.
    pub fn rolled_to(&self, turn_rad: f64, tip_radius_um: f64) -> Option<Foot> {
        let first_rad = self.nodes[0].normal_rad;
        let turn_to = |node: &ContourNode| node.normal_rad - first_rad + node.arc_length_um / tip_radius_um;
        let once_rad = turn_to(self.last());
        let laps = (turn_rad / once_rad).floor();
        let rest_rad = turn_rad - laps * once_rad;
        let at =
            self.nodes.partition_point(|node| turn_to(node) <= rest_rad).saturating_sub(1).min(self.spans.len() - 1);
        let span = self.spans[at];
        // As a length, to suit the root's tolerance.
        let off_um = |t: f64| {
            let foot = self.foot_at(at, t, 0, self.jet(at, t).point_um);
            (foot.turned_rad + foot.arc_length_um / tip_radius_um - rest_rad) * tip_radius_um
        };
        let ends = [span.from_t, span.to_t].map(|t| (t, off_um(t)));
        let t = if ends[0].1 < 0.0 && ends[1].1 > 0.0 { root(off_um, ends) } else { span.from_t };
        laps.is_finite().then(|| self.foot_at(at, t, laps as i64, self.jet(at, t).point_um))
    }

    /// The point of the outline nearest to a given point; its arc length lies in the first lap. `None` if a coordinate
    /// is not finite.
    ///
    /// Between two nodes the distance is at least half of the amount by which the sum of the nodes' distances exceeds
    /// the arc length.
    pub fn foot(&self, point_um: [f64; 2]) -> Option<Foot> {
        if !point_um.iter().all(|number| number.is_finite()) {
            return None;
        }
        let to_node_um = |node: usize| length(minus(point_um, self.nodes[node].point_um));
        let mut best = (to_node_um(0), 0, self.spans[0].from_t);
        let mut open = vec![(0, self.spans.len(), best.0, best.0)];
        while let Some((from, to, from_um, to_um)) = open.pop() {
            let least_um = (from_um + to_um - (self.nodes[to].arc_length_um - self.nodes[from].arc_length_um)) / 2.0;
            if least_um > best.0 {
                continue;
            }
            if to - from == 1 {
                let t = self.foot_in(from, point_um);
                let near_um = length(minus(point_um, self.jet(from, t).point_um));
                if near_um < best.0 {
                    best = (near_um, from, t);
                }
                continue;
            }
            let middle = usize::midpoint(from, to);
            let middle_um = to_node_um(middle);
            if middle_um < best.0 {
                best = (middle_um, middle, self.spans[middle].from_t);
            }
            let halves = [(from, middle, from_um, middle_um), (middle, to, middle_um, to_um)];
            open.extend(if from_um < to_um { [halves[1], halves[0]] } else { halves });
        }
        let (_, at, t) = best;
        Some(self.foot_at(at, t, 0, point_um))
    }

    /// The nearest point, by descent from the arc length of an earlier one; its own arc length continues from that
    /// one.
    pub fn foot_near(&self, point_um: [f64; 2], arc_length_um: f64) -> Option<Foot> {
        let laps = (arc_length_um / self.round_um()).floor();
        let own_um = arc_length_um - laps * self.round_um();
        let count = self.spans.len();
        let mut at = self.nodes.partition_point(|node| node.arc_length_um <= own_um).saturating_sub(1).min(count - 1);
        let mut lap = laps as i64;
        let is_ahead = self.offset_um(at, point_um) < 0.0;
        for _ in 0..count {
            let beyond = if is_ahead { -self.offset_um(at + 1, point_um) } else { self.offset_um(at, point_um) };
            if beyond.is_nan() || beyond <= 0.0 {
                break;
            }
            (at, lap) = match (is_ahead, at) {
                (true, at) if at + 1 == count => (0, lap.saturating_add(1)),
                (true, at) => (at + 1, lap),
                (false, 0) => (count - 1, lap.saturating_sub(1)),
                (false, at) => (at - 1, lap),
            };
        }
        let foot = self.foot_at(at, self.foot_in(at, point_um), lap, point_um);
        (laps.is_finite() && foot.distance_um.is_finite()).then_some(foot)
    }

    /// Offset of a node from the foot of a point, along the node's tangent.
    fn offset_um(&self, node: usize, point_um: [f64; 2]) -> f64 {
        dot(minus(self.nodes[node].point_um, point_um), self.nodes[node].tangent)
    }

    /// The parameter of the point of a span that is nearest to a given point.
    fn foot_in(&self, at: usize, point_um: [f64; 2]) -> f64 {
        let span = self.spans[at];
        let ends = [(span.from_t, self.offset_um(at, point_um)), (span.to_t, self.offset_um(at + 1, point_um))];
        let offset_um = |t: f64| {
            let jet = self.jet(at, t);
            dot(minus(jet.point_um, point_um), jet.velocity) / jet.speed()
        };
        if let Some(ends) = rising(offset_um, ends) {
            return root(offset_um, ends);
        }
        let [from_um, to_um] = [at, at + 1].map(|node| length(minus(point_um, self.nodes[node].point_um)));
        if to_um < from_um { span.to_t } else { span.from_t }
    }

    fn jet(&self, at: usize, t: f64) -> ContourJet {
        self.pieces[self.spans[at].piece].at(t)
    }

    /// The foot with a given span, parameter and lap, for a point.
    fn foot_at(&self, at: usize, t: f64, lap: i64, point_um: [f64; 2]) -> Foot {
        let (span, node, lap) = (self.spans[at], self.nodes[at], lap as f64);
        let piece = &self.pieces[span.piece];
        let jet = piece.at(t);
        let [x, y] = jet.velocity;
        let turned_rad = node.normal_rad - self.nodes[0].normal_rad + turn_rad(node.tangent, jet.velocity);
        let gap_um = minus(point_um, jet.point_um);
        let sign = if gap_um[0] * y - gap_um[1] * x < 0.0 { -1.0 } else { 1.0 };
        Foot {
            arc_length_um: node.arc_length_um + arc_um(piece, [span.from_t, t]) + lap * self.round_um(),
            distance_um: inject(Fault::JudgedOutline, sign * length(gap_um)),
            point_um: jet.point_um,
            normal_rad: inject(Fault::JudgedNormal, (-x).arc_tangent_over(y)),
            turned_rad: turned_rad + lap * TAU,
            curvature_per_um: piece.curvature_per_um(t, &jet),
        }
    }

    /// The greatest distance from the origin: at a node, or at a local maximum between two nodes.
    fn farthest_um(&self) -> f64 {
        let of_node = self.nodes.iter().map(|node| length(node.point_um)).fold(0.0, f64::max);
        let tops = (0..self.spans.len()).filter_map(|at| {
            let fall = |t: f64| {
                let jet = self.jet(at, t);
                -dot(jet.point_um, jet.velocity) / jet.speed()
            };
            let ends = [self.spans[at].from_t, self.spans[at].to_t].map(|t| (t, fall(t)));
            rising(fall, ends).map(|ends| length(self.jet(at, root(fall, ends)).point_um))
        });
        tops.fold(of_node, f64::max)
    }
}

/// Bisects pieces into spans until each has a small turn of the tangent and an accurate arc length.
fn halved(pieces: &[Piece]) -> Option<Vec<ContourSpan>> {
    let whole = |piece: usize| {
        let [from_t, to_t] = pieces[piece].range();
        (ContourSpan { piece, from_t, to_t }, 0)
    };
    let mut open: Vec<(ContourSpan, u32)> = (0..pieces.len()).rev().map(whole).collect();
    let mut spans = Vec::new();
    while let Some((span, halvings)) = open.pop() {
        let piece = &pieces[span.piece];
        let middle_t = f64::midpoint(span.from_t, span.to_t);
        let jets = [span.from_t, middle_t, span.to_t].map(|t| piece.at(t));
        let is_sound =
            |jet: &ContourJet| jet.speed().is_finite() && jet.speed() > 0.0 && length(jet.point_um).is_finite();
        if !jets.iter().all(is_sound) || spans.len() >= MAX_NODES[0] + MAX_NODES[1] * pieces.len() {
            return None;
        }
        let turned = |one: usize| turn_rad(jets[one].velocity, jets[one + 1].velocity).abs();
        let halves_um = arc_um(piece, [span.from_t, middle_t]) + arc_um(piece, [middle_t, span.to_t]);
        let off_um = (arc_um(piece, [span.from_t, span.to_t]) - halves_um).abs();
        let is_fine =
            turned(0) + turned(1) <= MAX_TURN_RAD && off_um <= WAY_UM.max(WAY_SHARE * length(jets[1].point_um));
        if is_fine || halvings == MAX_HALVINGS {
            spans.push(span);
        } else {
            open.push((ContourSpan { from_t: middle_t, ..span }, halvings + 1));
            open.push((ContourSpan { to_t: middle_t, ..span }, halvings + 1));
        }
    }
    Some(spans)
}

/// The spans in order, starting at the farthest crossing of the positive x axis.
fn begun_on_axis(pieces: &[Piece], mut spans: Vec<ContourSpan>) -> Option<Vec<ContourSpan>> {
    let x_um = |(at, t): &(usize, f64)| pieces[spans[*at].piece].at(*t).point_um[0];
    let roots = (0..spans.len()).flat_map(|at| axis_roots(pieces, spans[at]).map(move |t| (at, t)));
    let right = roots.filter(|place| x_um(place) > 0.0);
    let (at, t) = right.max_by(|one, other| x_um(one).total_cmp(&x_um(other)))?;
    let span = spans[at];
    spans.rotate_left(at);
    spans[0].from_t = t;
    spans.push(ContourSpan { to_t: t, ..span });
    // The rest of a span beside the start may be mere rounding.
    let is_wide = |span: &ContourSpan| {
        let [from_t, to_t] = pieces[span.piece].range();
        span.to_t - span.from_t > 1e-12 * (to_t - from_t)
    };
    spans.retain(is_wide);
    Some(spans)
}

/// The parameters at which a span meets the x axis.
fn axis_roots(pieces: &[Piece], span: ContourSpan) -> impl Iterator<Item = f64> + use<> {
    let piece = pieces[span.piece];
    let height_um = |t: f64| piece.at(t).point_um[1];
    let rise = |t: f64| piece.at(t).velocity[1];
    let mut stops = vec![span.from_t];
    // The span may rise and fall again.
    if rise(span.from_t) * rise(span.to_t) < 0.0 {
        stops.push(root(rise, [span.from_t, span.to_t].map(|t| (t, rise(t)))));
    }
    stops.push(span.to_t);
    let on_axis: Vec<f64> = stops.iter().copied().filter(|t| height_um(*t) == 0.0).collect();
    let pairs: Vec<[(f64, f64); 2]> =
        stops.windows(2).map(|pair| [pair[0], pair[1]].map(|t| (t, height_um(t)))).collect();
    let crossed = pairs.into_iter().filter(|[from, to]| from.1 * to.1 < 0.0);
    let between: Vec<f64> = crossed.map(|ends| root(height_um, ends)).collect();
    on_axis.into_iter().chain(between)
}

/// The nodes of spans, in order; one more than there are spans.
fn nodes(pieces: &[Piece], spans: &[ContourSpan]) -> Option<Vec<ContourNode>> {
    let place = |span: &ContourSpan, t: f64| {
        let jet = pieces[span.piece].at(t);
        let speed = jet.speed();
        (jet.point_um, jet.velocity.map(|part| part / speed))
    };
    let (point_um, tangent) = place(spans.first()?, spans.first()?.from_t);
    let normal_rad = (-tangent[0]).arc_tangent_over(tangent[1]);
    let mut nodes = vec![ContourNode { arc_length_um: 0.0, point_um, tangent, normal_rad }];
    for span in spans {
        let before = nodes[nodes.len() - 1];
        let (point_um, tangent) = place(span, span.to_t);
        let normal_rad = before.normal_rad + turn_rad(before.tangent, tangent);
        let arc_length_um = before.arc_length_um + arc_um(&pieces[span.piece], [span.from_t, span.to_t]);
        nodes.push(ContourNode { arc_length_um, point_um, tangent, normal_rad });
    }
    let (first, last) = (nodes[0], nodes.len() - 1);
    nodes[last] = ContourNode { normal_rad: nodes[last].normal_rad, arc_length_um: nodes[last].arc_length_um, ..first };
    Some(nodes)
}

/// The arc length of a piece between two parameters.
fn arc_um(piece: &Piece, [from_t, to_t]: [f64; 2]) -> f64 {
    if from_t == to_t {
        return 0.0;
    }
    let (middle_t, half_t) = (f64::midpoint(from_t, to_t), (to_t - from_t) / 2.0);
    let sum = GAUSS.iter().map(|(node, weight)| weight * piece.at(middle_t + half_t * node).speed()).sum::<f64>();
    sum * half_t
}

/// A bracket within two ends in which a function rises from below 0 to above it, if there is one. If the function is 0
/// at one end, as on the axes of an outline, the sign beside that end counts, provided the other end has the right
/// sign.
fn rising(function: impl Fn(f64) -> f64, [from, to]: [(f64, f64); 2]) -> Option<[(f64, f64); 2]> {
    let beside = |end: (f64, f64), other: (f64, f64), sign: f64| {
        if end.1 * sign > 0.0 {
            return Some(end);
        }
        let nearer = |halving: i32| end.0 + (other.0 - end.0) * 0.5f64.whole_power(halving);
        let found = (1..=MAX_HALVINGS_BESIDE).map(|halving| (nearer(halving), function(nearer(halving))));
        let mut found = found.filter(|(_, value)| value * sign > 0.0);
        if end.1 == 0.0 && other.1 * sign < 0.0 { found.next() } else { None }
    };
    Some([beside(from, to, -1.0)?, beside(to, from, 1.0)?])
}

/// Root of a function with opposite signs at the two ends, by regula falsi with the Illinois modification: the value
/// at an end that is retained is halved.
fn root(function: impl Fn(f64) -> f64, [mut one, mut other]: [(f64, f64); 2]) -> f64 {
    let least_t = ROOT_SHARE * (other.0 - one.0).abs();
    for _ in 0..MAX_STEPS {
        let mut t = other.0 - other.1 * (other.0 - one.0) / (other.1 - one.1);
        if !t.is_finite() {
            t = f64::midpoint(one.0, other.0);
        }
        let value = function(t);
        let is_near = value.abs() <= ROOT_UM || (t - other.0).abs() <= least_t;
        if value * other.1 < 0.0 {
            one = other;
        } else {
            one.1 /= 2.0;
        }
        other = (t, value);
        if is_near {
            break;
        }
    }
    other.0
}

/// Turn from one direction to another, between -180 and 180 degrees.
fn turn_rad(from: [f64; 2], to: [f64; 2]) -> f64 {
    let turn_rad = to[1].arc_tangent_over(to[0]) - from[1].arc_tangent_over(from[0]);
    if turn_rad > PI {
        turn_rad - TAU
    } else if turn_rad <= -PI {
        turn_rad + TAU
    } else {
        turn_rad
    }
}

fn dot(a: [f64; 2], b: [f64; 2]) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn length(a: [f64; 2]) -> f64 {
    (a[0] * a[0] + a[1] * a[1]).sqrt()
}
