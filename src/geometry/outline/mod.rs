//! Closed smooth outlines in the plane: their forms, and points, normals and curvatures along them by arc length.
//!
//! Input: an [`Outline`] in micrometres. Output: a [`Curve`], parametrised counter-clockwise by arc length, which
//! begins at the outermost point on the positive x axis. Promise: arc lengths, normals and curvatures agree with one
//! another to [`PRECISION_UM`].

mod boxes;
mod follow;
mod form;
mod jet;
mod resample;
mod spline;
#[cfg(test)]
mod tests;

use super::fault::{Fault, inject};
use boxes::SegmentBoxes;
use follow::{SegmentedCurve, gauss, turn};
use form::{OutlineForm, PieceParameter};
use jet::{cross, dot, minus, norm};
pub use resample::{MAX_POLYGON, MAX_SMOOTHED};
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Greatest error of a [`Curve`] relative to its outline, in micrometres.
pub const PRECISION_UM: f64 = 1e-6;

/// Fewest points of a spline.
pub const MIN_POINTS: usize = 4;

/// Greatest number of points of a spline.
pub const MAX_POINTS: usize = 4096;

/// Greatest coordinate or semi-axis, in micrometres.
pub const MAX_UM: f64 = 1e6;

/// Least mean thickness of an outline, in micrometres: twice its area divided by its perimeter.
pub const MIN_THICKNESS_UM: f64 = 0.001;

/// Least depth of the origin inside an outline, in micrometres: far above the difference between the two geometries.
pub const MIN_INSIDE_UM: f64 = 1e-6;

/// Least semi-axis, half width or corner radius, in micrometres.
pub const MIN_UM: f64 = 1e-3;

/// Range of the exponents of superellipses.
pub const EXPONENTS: [f64; 2] = [2.0, 10.0];

/// A closed smooth outline around the origin, in micrometres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outline {
    /// Semi-axes along x and y.
    Ellipse { semi_um: [f64; 2] },
    /// |x/a|^n + |y/b|^n = 1, n from 2 to 10.
    Superellipse { semi_um: [f64; 2], exponent: f64 },
    /// Half widths along x and y, the corner radius, and the centre; the x axis leaves it through its right side, not
    /// through a corner.
    RoundedRectangle {
        half_um: [f64; 2],
        radius_um: f64,
        #[serde(default, skip_serializing_if = "is_origin")]
        centre_um: [f64; 2],
    },
    /// A periodic cubic spline through these points, counter-clockwise.
    Spline { points_um: Vec<[f64; 2]> },
}

fn is_origin(point_um: &[f64; 2]) -> bool {
    *point_um == [0.0; 2]
}

/// A point of a curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    pub point_um: [f64; 2],
    /// The direction of the outward normal; it grows by 2π per lap, and decreases where the outline is concave.
    pub normal_rad: f64,
    /// Positive where the outline is convex.
    pub curvature_per_um: f64,
}

/// The point of an outline that is nearest to a given point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    pub way_um: f64,
    /// Negative inside.
    pub distance_um: f64,
}

/// Reason why an outline cannot be followed.
#[derive(Debug, Clone, PartialEq)]
pub enum OutlineError {
    /// A number that is not finite, too large, or out of the range that its form allows.
    Number,
    /// A spline has too few points.
    TooFewPoints(usize),
    /// A spline or a polyline has too many points.
    TooManyPoints(usize),
    /// Two neighbouring points coincide; the index of the first.
    RepeatedPoint(usize),
    /// It encloses no area.
    NoArea,
    /// Its mean thickness is below [`MIN_THICKNESS_UM`]: more a line than an outline, which cannot be followed
    /// reliably.
    Thin,
    /// It intersects itself at these two arc lengths.
    Crossing { ways_um: [f64; 2] },
    /// It has a corner, or bends too sharply to be followed, near this point.
    Rough { point_um: [f64; 2] },
    /// The x axis does not meet it on both sides of the origin, or the origin is outside.
    OffOrigin,
}

/// An outline prepared for queries.
#[derive(Debug, Clone)]
pub struct Curve {
    form: OutlineForm,
    segmented: SegmentedCurve,
    boxes: SegmentBoxes,
    perimeter_um: f64,
    opposite_um: f64,
    area_um2: f64,
    centre_um: [f64; 2],
    reach_um: f64,
    least_curvature_per_um: f64,
}

impl Curve {
    /// Prepares an outline.
    ///
    /// # Errors
    /// See [`OutlineError`].
    pub fn of(outline: &Outline) -> Result<Curve, OutlineError> {
        let form = formulas(outline)?;
        let (begin, opposite) = axis_places(&form)?;
        let mut segmented = SegmentedCurve::of(&form, begin)?;
        let boxes = SegmentBoxes::of(&segmented);
        if form.may_cross() {
            uncrossed(&segmented, &boxes)?;
        }
        close(&mut segmented);
        let perimeter_um = segmented.ways_um[segmented.segments.len()];
        let (area_um2, centre_um) = area_and_centre(&form, &segmented);
        Curve::with(form, segmented, boxes, opposite, perimeter_um, area_um2, centre_um)
    }

    fn with(
        form: OutlineForm,
        segmented: SegmentedCurve,
        boxes: SegmentBoxes,
        opposite: Option<PieceParameter>,
        perimeter_um: f64,
        area_um2: f64,
        centre_um: [f64; 2],
    ) -> Result<Curve, OutlineError> {
        let opposite_um = opposite.map_or(perimeter_um / 2.0, |place| way_at(&segmented, place));
        let (reach_um, least_curvature_per_um) = (0.0, 0.0);
        let mut curve = Curve {
            form,
            segmented,
            boxes,
            perimeter_um,
            opposite_um,
            area_um2,
            centre_um,
            reach_um,
            least_curvature_per_um,
        };
        if curve.nearest([0.0, 0.0]).distance_um > -MIN_INSIDE_UM {
            return Err(OutlineError::OffOrigin);
        }
        if 2.0 * curve.area_um2 < MIN_THICKNESS_UM * curve.perimeter_um {
            return Err(OutlineError::Thin);
        }
        curve.reach_um = -curve.least(|spot| -norm(spot.point_um));
        curve.least_curvature_per_um = curve.least(|spot| spot.curvature_per_um);
        Ok(curve)
    }

    /// The length of one lap.
    pub fn perimeter_um(&self) -> f64 {
        inject(Fault::Perimeter, self.perimeter_um)
    }

    /// Greatest distance from the origin.
    pub fn reach_um(&self) -> f64 {
        self.reach_um
    }

    /// The enclosed area, in square micrometres.
    pub fn area_um2(&self) -> f64 {
        self.area_um2
    }

    /// The centroid of the enclosed area.
    pub fn centre_um(&self) -> [f64; 2] {
        self.centre_um
    }

    /// The point at an arc length, which may exceed the perimeter or be negative (laps). The normal's angle counts
    /// laps too.
    pub fn point_at(&self, way_um: f64) -> CurvePoint {
        let laps = (way_um / self.perimeter_um).floor();
        let way_um = way_um - laps * self.perimeter_um;
        let (at, t) = self.place(way_um);
        let jet = self.form.at(self.segmented.segments[at].piece, t);
        let turned = turn(self.segmented.tangents[at], jet.first);
        CurvePoint {
            point_um: [inject(Fault::OutlinePoint, jet.point[0]), jet.point[1]],
            normal_rad: inject(Fault::Normal, self.segmented.turns_rad[at] + turned + laps * TAU),
            curvature_per_um: jet.curvature(),
        }
    }

    /// The segment at an arc length within the first lap, and the parameter in it.
    fn place(&self, way_um: f64) -> (usize, f64) {
        let ways_um = &self.segmented.ways_um;
        let at = ways_um.partition_point(|way| *way <= way_um).saturating_sub(1).min(self.segmented.segments.len() - 1);
        (at, self.segmented.segments[at].t(way_um - ways_um[at]))
    }

    /// The point nearest to a given one; its arc length is in the first lap.
    pub fn nearest(&self, point_um: [f64; 2]) -> Nearest {
        let mut found = NearestPlace { square: f64::INFINITY, way_um: 0.0, sign: f64::NAN };
        if point_um.iter().all(|number| number.is_finite()) {
            self.boxes.nearest(point_um, |at, best| {
                if self.may_be_nearer(at, point_um, best) {
                    self.foot(at, point_um).filter(|foot| foot.square < found.square).inspect(|foot| found = *foot);
                }
                found.square
            });
        }
        Nearest { way_um: found.way_um, distance_um: inject(Fault::Outline, found.square.sqrt() * found.sign) }
    }

    /// Whether the chord is near enough that the segment may contain a nearer point.
    fn may_be_nearer(&self, at: usize, point_um: [f64; 2], square: f64) -> bool {
        let [a, b] = [self.segmented.points_um[at], self.segmented.points_um[at + 1]];
        let (chord, off) = (minus(b, a), minus(point_um, a));
        let share = (dot(off, chord) / dot(chord, chord)).clamp(0.0, 1.0);
        let reach = square.sqrt() + self.segmented.segments[at].sag_um;
        let gap = [off[0] - share * chord[0], off[1] - share * chord[1]];
        dot(gap, gap) <= reach * reach
    }

    /// Derivative of half the squared distance with respect to arc length, at a node.
    fn slope(&self, node: usize, point_um: [f64; 2]) -> f64 {
        dot(minus(self.segmented.points_um[node], point_um), self.segmented.tangents[node])
    }

    /// The point of a segment nearest to a given one.
    fn foot(&self, at: usize, point_um: [f64; 2]) -> Option<NearestPlace> {
        let segment = &self.segmented.segments[at];
        let slopes = [self.slope(at, point_um), self.slope(at + 1, point_um)];
        if slopes[0] < 0.0 && slopes[1] > 0.0 {
            let begin = segment.from_t + (segment.to_t - segment.from_t) * slopes[0] / (slopes[0] - slopes[1]);
            return Some(self.perpendicular(at, point_um, begin));
        }
        let gaps = [at, at + 1].map(|node| minus(point_um, self.segmented.points_um[node]));
        let node = usize::from(dot(gaps[1], gaps[1]) < dot(gaps[0], gaps[0]));
        let square = dot(gaps[node], gaps[node]);
        let [x, y] = self.segmented.tangents[at + node];
        let sign = if dot(gaps[node], [y, -x]) < 0.0 { -1.0 } else { 1.0 };
        square.is_finite().then_some(NearestPlace { square, way_um: self.segmented.ways_um[at + node], sign })
    }

    /// Newton's method for the point where the connection is perpendicular to the curve, bracketed by two slopes of
    /// opposite sign.
    fn perpendicular(&self, at: usize, point_um: [f64; 2], begin: f64) -> NearestPlace {
        let segment = &self.segmented.segments[at];
        let (mut low, mut high, mut t) = (segment.from_t, segment.to_t, begin);
        let mut jet = self.form.at(segment.piece, t);
        for _ in 0..MAX_ITERATIONS {
            let gap = minus(jet.point, point_um);
            let slope = dot(gap, jet.first);
            if slope > 0.0 {
                high = t
            } else {
                low = t
            }
            let step = slope / (dot(jet.first, jet.first) + dot(gap, jet.second));
            let next = t - step;
            let (before, within) = (t, next >= low && next <= high);
            t = if within { next } else { f64::midpoint(low, high) };
            jet = self.form.at(segment.piece, t);
            if (t - before).abs() * jet.speed() < NEWTON_UM {
                break;
            }
        }
        let gap = minus(point_um, jet.point);
        let sign = if dot(gap, jet.normal()) < 0.0 { -1.0 } else { 1.0 };
        NearestPlace { square: dot(gap, gap), way_um: self.segmented.ways_um[at] + segment.way_um(t), sign }
    }

    /// Rotation of the object while a tip rolls from arc length 0 to `way_um`: the integral of κ + 1/l2, which is the
    /// rotation of the normal plus the arc length over the tip's radius.
    pub fn rolled_rad(&self, way_um: f64, tip_radius_um: f64) -> f64 {
        inject(Fault::Rolled, self.point_at(way_um).normal_rad - self.segmented.turns_rad[0] + way_um / tip_radius_um)
    }

    /// The arc length at which a tip has rolled by this angle: the inverse of [`Curve::rolled_rad`], for tips that
    /// reach every point (κ > -1/l2). For other tips it is one of several solutions, or an arbitrary number if there
    /// is none.
    pub fn way_rolled_um(&self, rolled_rad: f64, tip_radius_um: f64) -> f64 {
        let once_rad = TAU + self.perimeter_um / tip_radius_um;
        let laps = (rolled_rad / once_rad).floor();
        let wanted_rad = rolled_rad - laps * once_rad;
        let segmented = &self.segmented;
        let at_node =
            |node: usize| segmented.turns_rad[node] - segmented.turns_rad[0] + segmented.ways_um[node] / tip_radius_um;
        let (mut first, mut last) = (0, segmented.segments.len());
        while last - first > 1 {
            let middle = usize::midpoint(first, last);
            if at_node(middle) <= wanted_rad { first = middle } else { last = middle }
        }
        let (mut low, mut high) = (segmented.ways_um[first], segmented.ways_um[last]);
        let share = (wanted_rad - at_node(first)) / (at_node(last) - at_node(first));
        let mut way_um = low + (high - low) * share.clamp(0.0, 1.0);
        for _ in 0..MAX_ITERATIONS {
            let spot = self.point_at(way_um);
            let off = spot.normal_rad - segmented.turns_rad[0] + way_um / tip_radius_um - wanted_rad;
            if off > 0.0 {
                high = way_um
            } else {
                low = way_um
            }
            let next = way_um - off / (spot.curvature_per_um + tip_radius_um.recip());
            let before = way_um;
            way_um = if next >= low && next <= high { next } else { f64::midpoint(low, high) };
            if (way_um - before).abs() < NEWTON_UM {
                break;
            }
        }
        inject(Fault::WayRolled, way_um + laps * self.perimeter_um)
    }

    /// The arc length of the outermost point on the negative x axis.
    pub fn opposite_um(&self) -> f64 {
        self.opposite_um
    }

    /// The least signed curvature, per micrometre.
    pub fn least_curvature_per_um(&self) -> f64 {
        self.least_curvature_per_um
    }

    /// The least value along the curve: each local minimum among the nodes is refined by golden-section search on
    /// both sides.
    fn least(&self, value: impl Fn(&CurvePoint) -> f64) -> f64 {
        let ways_um = &self.segmented.ways_um;
        let count = self.segmented.segments.len();
        let at = |way_um: f64| value(&self.point_at(way_um));
        let values: Vec<f64> = ways_um[..count].iter().map(|way_um| at(*way_um)).collect();
        let before = |node: usize| if node == 0 { count - 1 } else { node - 1 };
        let best = (0..count).min_by(|a, b| values[*a].total_cmp(&values[*b])).unwrap_or(0);
        let is_low = |node: usize| values[node] < values[before(node)] && values[node] <= values[(node + 1) % count];
        let mut least = values.get(best).copied().unwrap_or(f64::NAN);
        for node in (0..count).filter(|node| *node == best || is_low(*node)) {
            let around_um = if node == 0 { self.perimeter_um } else { 0.0 };
            for (mut low, mut high) in
                [(ways_um[before(node)] - around_um, ways_um[node]), (ways_um[node], ways_um[node + 1])]
            {
                for _ in 0..SECTIONS {
                    let inner = [low + (high - low) * GOLDEN, high - (high - low) * GOLDEN];
                    let values = inner.map(at);
                    least = least.min(values[0]).min(values[1]);
                    if values[0] < values[1] { high = inner[1] } else { low = inner[0] }
                }
            }
        }
        least
    }
}

/// Greatest number of Newton steps, bisections included.
const MAX_ITERATIONS: usize = 60;

/// Step size below which Newton's method ends.
const NEWTON_UM: f64 = 1e-9;

/// Number of golden-section steps in an interval.
const SECTIONS: usize = 40;

/// The smaller share of the golden section.
const GOLDEN: f64 = 0.381_966_011_250_105_1;

/// A candidate for the nearest point.
#[derive(Debug, Clone, Copy)]
struct NearestPlace {
    square: f64,
    way_um: f64,
    /// -1 inside, 1 outside.
    sign: f64,
}

/// The formulas of an outline, with all its numbers checked to be in range.
fn formulas(outline: &Outline) -> Result<OutlineForm, OutlineError> {
    match outline {
        Outline::Ellipse { semi_um } => sizes(semi_um).map(|()| OutlineForm::Ellipse { semi: *semi_um }),
        Outline::Superellipse { semi_um, exponent } => {
            sizes(semi_um)?;
            let in_range = (EXPONENTS[0]..=EXPONENTS[1]).contains(exponent);
            in_range
                .then_some(OutlineForm::Superellipse { semi: *semi_um, exponent: *exponent })
                .ok_or(OutlineError::Number)
        }
        Outline::RoundedRectangle { half_um, radius_um, centre_um } => {
            sizes(half_um)?;
            let in_range = (MIN_UM..=half_um[0].min(half_um[1])).contains(radius_um)
                && centre_um[0].is_finite()
                && (centre_um[1] == 0.0 || centre_um[1].abs() < half_um[1] - radius_um);
            in_range.then(|| OutlineForm::rounded(*half_um, *radius_um, *centre_um)).ok_or(OutlineError::Number)
        }
        Outline::Spline { points_um } => spline_form(points_um),
    }
}

fn sizes(semi_um: &[f64; 2]) -> Result<(), OutlineError> {
    if semi_um.iter().any(|semi| !semi.is_finite() || *semi < 0.0 || *semi > MAX_UM) {
        return Err(OutlineError::Number);
    }
    if semi_um.iter().any(|semi| *semi < MIN_UM) {
        return Err(OutlineError::NoArea);
    }
    Ok(())
}

fn spline_form(points_um: &[[f64; 2]]) -> Result<OutlineForm, OutlineError> {
    let count = points_um.len();
    if count < MIN_POINTS {
        return Err(OutlineError::TooFewPoints(count));
    }
    if count > MAX_POINTS {
        return Err(OutlineError::TooManyPoints(count));
    }
    // NaN fails this test too.
    if !points_um.iter().flatten().all(|number| number.abs() <= MAX_UM) {
        return Err(OutlineError::Number);
    }
    let extent_um = points_um.iter().map(|point| norm(*point)).fold(0.0, f64::max);
    let next = |at: usize| points_um[(at + 1) % count];
    if let Some(at) = (0..count).find(|at| norm(minus(next(*at), points_um[*at])) <= LEAST_GAP * extent_um) {
        return Err(OutlineError::RepeatedPoint(at));
    }
    let cubics = spline::through(points_um);
    let area_um2 = spline::area(&cubics);
    if area_um2.is_nan() || area_um2.abs() <= (MIN_UM * MIN_UM).max(LEAST_GAP * extent_um * extent_um) {
        return Err(OutlineError::NoArea);
    }
    if area_um2 < 0.0 {
        let reversed: Vec<[f64; 2]> = points_um.iter().rev().copied().collect();
        return Ok(OutlineForm::Spline { cubics: spline::through(&reversed) });
    }
    Ok(OutlineForm::Spline { cubics })
}

/// Least distance of two neighbouring points, as a share of the extent.
const LEAST_GAP: f64 = 1e-9;

/// The outermost points of a form on the x axis: the beginning of the curve, and the opposite point unless that is
/// exactly half way around.
fn axis_places(form: &OutlineForm) -> Result<(PieceParameter, Option<PieceParameter>), OutlineError> {
    let first = PieceParameter { piece: 0, t: 0.0 };
    let cubics = match form {
        OutlineForm::Spline { cubics } => cubics,
        OutlineForm::Parts { parts } => return Ok((first, OutlineForm::opposite_part(parts))),
        OutlineForm::Ellipse { .. } | OutlineForm::Superellipse { .. } => return Ok((first, None)),
    };
    let roots = (0..cubics.len()).flat_map(|piece| {
        let end_y = cubics[(piece + 1) % cubics.len()].at(0.0).point[1];
        cubics[piece].roots_y(end_y).into_iter().map(move |t| PieceParameter { piece, t })
    });
    let x = |place: &PieceParameter| cubics[place.piece].at(place.t).point[0];
    let (right, left): (Vec<PieceParameter>, Vec<PieceParameter>) = roots.partition(|place| x(place) > 0.0);
    let begin = right.into_iter().max_by(|a, b| x(a).total_cmp(&x(b)));
    let opposite = left.into_iter().min_by(|a, b| x(a).total_cmp(&x(b)));
    match (begin, opposite) {
        (Some(begin), Some(opposite)) => Ok((begin, Some(opposite))),
        (None, _) | (_, None) => Err(OutlineError::OffOrigin),
    }
}

/// The arc length of a parameter along a curve.
fn way_at(segmented: &SegmentedCurve, place: PieceParameter) -> f64 {
    let off = |at: usize| {
        let segment = &segmented.segments[at];
        if segment.piece != place.piece {
            return f64::INFINITY;
        }
        (segment.from_t - place.t).max(place.t - segment.to_t).max(0.0)
    };
    let nearest = (0..segmented.segments.len()).min_by(|a, b| off(*a).total_cmp(&off(*b)));
    nearest.map_or(f64::NAN, |at| segmented.ways_um[at] + segmented.segments[at].way_um(place.t))
}

/// Checks that a curve does not intersect itself and turns exactly once.
fn uncrossed(segmented: &SegmentedCurve, boxes: &SegmentBoxes) -> Result<(), OutlineError> {
    if let Some(pair) = boxes.crossing(segmented) {
        return Err(OutlineError::Crossing { ways_um: pair.map(|at| segmented.ways_um[at]) });
    }
    let turned_rad = segmented.turns_rad[segmented.segments.len()] - segmented.turns_rad[0];
    if (turned_rad - TAU).abs() > 1e-3 {
        return Err(OutlineError::Rough { point_um: segmented.points_um[0] });
    }
    Ok(())
}

/// Makes the last node coincide with the first one.
fn close(segmented: &mut SegmentedCurve) {
    let last = segmented.segments.len();
    segmented.turns_rad[last] = segmented.turns_rad[0] + TAU;
    segmented.points_um[last] = segmented.points_um[0];
    segmented.tangents[last] = segmented.tangents[0];
}

/// Green's theorem: the area is ∮ (x dy - y dx) / 2, its moments are ∮ x² dy / 2 and -∮ y² dx / 2.
fn area_and_centre(form: &OutlineForm, segmented: &SegmentedCurve) -> (f64, [f64; 2]) {
    let (mut area, mut moment) = (0.0, [0.0; 2]);
    for segment in &segmented.segments {
        gauss(segment.from_t, segment.to_t, |t, weight| {
            let jet = form.at(segment.piece, t);
            let [x, y] = jet.point;
            area += weight * cross(jet.point, jet.first) / 2.0;
            moment[0] += weight * x * x * jet.first[1] / 2.0;
            moment[1] -= weight * y * y * jet.first[0] / 2.0;
        });
    }
    (area, moment.map(|of_axis| of_axis / area))
}
