//! Contacts of a section that a tip can reach and leave while other tips hold.
//!
//! Input: a curve, the hand's facts, the number of contacts. Output: a [`ContactReach`], which answers for every contact and any
//! holding tips. Method: from its contact a tip moves straight out along the normal by [`FingersFacts::slow_um`], and then straight
//! on in the first clear direction of a fixed fan about the normal, until no part of the object or of a holding tip can be near.
//! Each contact and each direction is tested once against the outline, and once against each tip; a query is then the conjunction
//! of some masks.
//!
//! Guaranteed: along a path the tip's centre keeps `tip_radius + clearance` from the outline, except on the slow stretch, where it
//! keeps the tip's radius, both less a quarter of the tolerance; and two radii and the clearance from holding tips, less a part in
//! 10⁹. Not guaranteed: that a contact without a path in the fan has no path. Cost grows with contacts² × directions.

use super::rolling;
use crate::device::fingers::FingersFacts;
use crate::geometry::outline::Curve;
use crate::real::Real;
use nalgebra::Vector2;

/// Directions of the fan: an odd number, at most 16.
const FAN: u32 = 11;

/// Angle between neighbouring directions of the fan: 15 deg.
const FAN_STEP_RAD: f64 = std::f64::consts::PI / 12.0;

/// Relative tolerance of the distance between two tips.
const TIP_SLACK: f64 = 1e-9;

/// Samples of an outline that share a bounding circle.
const BLOCK: usize = 16;

/// Least and greatest number of samples of an outline.
const SAMPLES: [f64; 2] = [256.0, 16_384.0];

/// The paths to the contacts of one section, in its coordinates. Contacts are counted from 0.
#[derive(Debug, Clone)]
pub struct ContactReach {
    starts: Vec<RetreatStart>,
    /// At k·c + i: the directions in which the path of contact k is clear of a tip on contact i, and of the outline; at k·c + k:
    /// those in which it is clear of the outline.
    masks: Vec<u16>,
}

/// Common start of the paths of one contact.
#[derive(Debug, Clone, Copy)]
struct RetreatStart {
    touch_um: Vector2<f64>,
    bend_um: Vector2<f64>,
    normal_rad: f64,
}

/// Path of a tip's centre outwards from its contact, in the section's coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RetreatPath {
    /// Centre of the tip in contact.
    pub touch_um: Vector2<f64>,
    /// End of the slow stretch.
    pub bend_um: Vector2<f64>,
    /// Direction from there.
    pub towards: Vector2<f64>,
}

impl RetreatPath {
    /// Its intersection with a circle about the part's origin that encloses the bend.
    pub fn end_um(&self, radius_um: f64) -> Vector2<f64> {
        self.bend_um + self.towards * ray_um(self.bend_um, self.towards, radius_um)
    }
}

impl ContactReach {
    /// Tests all paths.
    pub fn new(curve: &Curve, facts: &FingersFacts, contacts: u32) -> ContactReach {
        let count = contacts as usize;
        let starts: Vec<RetreatStart> =
            (0..count).map(|contact| retreat_start(curve, facts, contact, contacts)).collect();
        let mut reach = ContactReach { masks: vec![0; count * count], starts };
        // A tip that moves away from a convex outline stays clear of it.
        let rim = (curve.least_curvature_per_um() < 0.0).then(|| Rim::of(curve, facts));
        let radius_um = facts.sphere_um(0, curve.reach_um());
        for contact in 0..count {
            reach.test(contact, rim.as_ref(), facts, radius_um);
        }
        reach
    }

    /// Number of contacts.
    pub fn contacts(&self) -> usize {
        self.starts.len()
    }

    /// Whether a tip can reach contact k, and leave it, while others hold i and j; `false` if two of them coincide.
    #[inline]
    pub fn reaches(&self, i: usize, j: usize, k: usize) -> bool {
        let row = k * self.starts.len();
        i != j && i != k && j != k && self.masks[row + i] & self.masks[row + j] != 0
    }

    /// The first path of the fan to a contact that is clear of tips on others.
    pub fn way(&self, contact: usize, holding: &[usize]) -> Option<RetreatPath> {
        if holding.contains(&contact) {
            return None;
        }
        let row = contact * self.starts.len();
        let clear = holding.iter().fold(self.masks[row + contact], |mask, other| mask & self.masks[row + other]);
        (clear != 0).then(|| self.starts[contact].way(clear.trailing_zeros()))
    }

    /// The first order in which tips can come to contacts that are initially free, and in whose reverse they can leave, as indices
    /// of the contacts. `None` also for more than three contacts.
    pub fn order(&self, contacts: &[usize]) -> Option<Vec<usize>> {
        const ORDERS: [[usize; 3]; 6] = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let is_clear = |order: &Vec<usize>| {
            let at: Vec<usize> = order.iter().map(|index| contacts[*index]).collect();
            (0..at.len()).all(|index| self.way(at[index], &at[..index]).is_some())
        };
        let orders = ORDERS.iter().map(|order| order.iter().copied().filter(|index| *index < contacts.len()).collect());
        orders.filter(|_| contacts.len() <= 3).find(is_clear)
    }

    /// Fills the row of a contact.
    fn test(&mut self, contact: usize, rim: Option<&Rim>, facts: &FingersFacts, radius_um: f64) {
        let start = self.starts[contact];
        let ways: Vec<(u16, Vector2<f64>)> = (0..FAN)
            .map(|direction| (1 << direction, start.way(direction).end_um(radius_um)))
            .filter(|(_, end)| rim.is_none_or(|rim| rim.lets_pass(&start, *end, facts)))
            .collect();
        let apart_um = (2.0 * facts.tip_radius_um + facts.clearance_um) * (1.0 - TIP_SLACK);
        for other in 0..self.starts.len() {
            let tip = self.starts[other].touch_um;
            let is_clear = |[from, to]: [Vector2<f64>; 2]| square_to_segment(tip, from, to) >= apart_um * apart_um;
            let mask = if other == contact {
                ways.iter().fold(0, |mask, (bit, _)| mask | bit)
            } else if is_clear([start.touch_um, start.bend_um]) {
                ways.iter().filter(|(_, end)| is_clear([start.bend_um, *end])).fold(0, |mask, (bit, _)| mask | bit)
            } else {
                0
            };
            self.masks[contact * self.starts.len() + other] = mask;
        }
    }
}

impl RetreatStart {
    /// The path in a direction of the fan: first the normal, then alternately to its sides.
    fn way(&self, direction: u32) -> RetreatPath {
        let side = if direction % 2 == 1 { 1.0 } else { -1.0 };
        let towards_rad = self.normal_rad + side * f64::from(direction.div_ceil(2)) * FAN_STEP_RAD;
        let (sin, cos) = towards_rad.sine_cosine();
        RetreatPath { touch_um: self.touch_um, bend_um: self.bend_um, towards: Vector2::new(cos, sin) }
    }
}

fn retreat_start(curve: &Curve, facts: &FingersFacts, contact: usize, contacts: u32) -> RetreatStart {
    let round_rad = curve.rolled_rad(curve.perimeter_um(), facts.tip_radius_um);
    let (touch_um, normal_rad) = rolling::tip(curve, facts, contact as f64 * round_rad / f64::from(contacts));
    let (sin, cos) = normal_rad.sine_cosine();
    RetreatStart { touch_um, bend_um: touch_um + Vector2::new(cos, sin) * facts.slow_um(), normal_rad }
}

/// An outline as points, so dense that the nearest point is hardly farther than the outline itself.
struct Rim {
    points_um: Vec<Vector2<f64>>,
    /// A bounding circle of each block of points.
    blocks: Vec<(Vector2<f64>, f64)>,
}

impl Rim {
    /// Samples an outline. A sample at h/2 from the nearest place is farther by about h²/8·(1/l2 + κ); the spacing h
    /// makes this an eighth of the tolerance.
    fn of(curve: &Curve, facts: &FingersFacts) -> Rim {
        let perimeter_um = curve.perimeter_um();
        let coarse =
            (0..256).map(|index| curve.point_at(perimeter_um * f64::from(index) / 256.0).curvature_per_um.abs());
        let bend_per_um = coarse.fold(1.0 / facts.tip_radius_um, f64::max) + 1.0 / facts.tip_radius_um;
        let spacing_um = (facts.tolerance_um / bend_per_um).sqrt();
        let count = (perimeter_um / spacing_um).ceil().clamp(SAMPLES[0], SAMPLES[1]);
        let point = |index: u32| Vector2::from(curve.point_at(perimeter_um * f64::from(index) / count).point_um);
        let points_um: Vec<Vector2<f64>> = (0..count as u32).map(point).collect();
        let blocks = points_um.chunks(BLOCK).map(circle).collect();
        Rim { points_um, blocks }
    }

    /// Whether a tip stays clear of the outline on the path to a contact from a distant place.
    fn lets_pass(&self, start: &RetreatStart, end_um: Vector2<f64>, facts: &FingersFacts) -> bool {
        let slow_um = facts.tip_radius_um - facts.tolerance_um / 8.0;
        self.keeps([start.touch_um, start.bend_um], slow_um)
            && self.keeps([start.bend_um, end_um], slow_um + facts.clearance_um)
    }

    /// Whether all points are at least `apart_um` from a segment.
    fn keeps(&self, [from, to]: [Vector2<f64>; 2], apart_um: f64) -> bool {
        let is_far = |point: &Vector2<f64>, apart_um: f64| square_to_segment(*point, from, to) >= apart_um * apart_um;
        let mut blocks = self.points_um.chunks(BLOCK).zip(&self.blocks);
        apart_um <= 0.0
            || blocks.all(|(points, (middle, radius_um))| {
                is_far(middle, apart_um + radius_um) || points.iter().all(|point| is_far(point, apart_um))
            })
    }
}

fn circle(points: &[Vector2<f64>]) -> (Vector2<f64>, f64) {
    let middle = points[points.len() / 2];
    (middle, points.iter().map(|point| (point - middle).norm()).fold(0.0, f64::max))
}

/// Squared distance from a point to a segment.
fn square_to_segment(point: Vector2<f64>, from: Vector2<f64>, to: Vector2<f64>) -> f64 {
    let (along, off) = (to - from, point - from);
    let length = along.norm_squared();
    let part = if length > 0.0 { (off.dot(&along) / length).clamp(0.0, 1.0) } else { 0.0 };
    (off - along * part).norm_squared()
}

/// Distance at which a ray from inside a circle about the origin leaves it; 0 from outside.
fn ray_um(from: Vector2<f64>, towards: Vector2<f64>, radius_um: f64) -> f64 {
    let half = from.dot(&towards);
    let within = radius_um * radius_um - from.norm_squared();
    if within <= 0.0 { 0.0 } else { (half * half + within).sqrt() - half }
}
