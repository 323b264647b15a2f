//! Drawing shared by the pictures of all kinds: obstacles, names, numbers, and paths limited to what paper shows.

use super::drawing::{Drawing, HAIR_PT, PaperView, PlacedLabel, ShapeStyle, TextStyle};
use super::strobe::ranges;
use crate::geometry::{Core, Pose, Shape};
use crate::real::Real;
use nalgebra::Point2;

/// Greatest number of drawn obstacles.
pub const MAX_OBSTACLES: usize = 4_000;

/// Greatest number of obstacles, or of parts, with names.
pub const MAX_NAMES: usize = 60;

/// Greatest number of corners of one path.
pub const MAX_CORNERS: usize = 5_000;

/// Margin of a scene, as a share of its larger side.
const RIM: f64 = 0.03;

/// A path with at most [`MAX_CORNERS`] corners.
pub struct ThinnedPath {
    pub points: Vec<[f64; 2]>,
    /// `, every 4th corner`, or nothing.
    pub remark: String,
}

/// A path, thinned if it is long.
pub fn thinned(way: &[[f64; 2]]) -> ThinnedPath {
    let stride = way.len().div_ceil(MAX_CORNERS).max(1);
    let kept = way.iter().enumerate().filter(|(index, _)| index % stride == 0 || index + 1 == way.len());
    let remark = match stride {
        1 => String::new(),
        _ => format!(", every {} corner", ordinal(stride as u32)),
    };
    ThinnedPath { points: kept.map(|(_, point)| *point).collect(), remark }
}

/// `2nd`, `3rd`, `4th`.
pub fn ordinal(number: u32) -> String {
    let ending = match (number % 10, number % 100) {
        (1, rest) if rest != 11 => "st",
        (2, rest) if rest != 12 => "nd",
        (3, rest) if rest != 13 => "rd",
        (_, _) => "th",
    };
    format!("{number}{ending}")
}

/// A path without repeated points and without points on the straight line between their neighbours.
pub fn simplified(places: impl IntoIterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    const ROUNDING: f64 = 1e-9;
    let mut way: Vec<[f64; 2]> = Vec::new();
    for place in places {
        if way.last() == Some(&place) {
            continue;
        }
        if let [.., a, b] = way[..] {
            let [along, next] = [[b[0] - a[0], b[1] - a[1]], [place[0] - b[0], place[1] - b[1]]];
            let across = along[0] * next[1] - along[1] * next[0];
            let ahead = along[0] * next[0] + along[1] * next[1];
            if across.abs() <= ROUNDING * ahead {
                way.pop();
            }
        }
        way.push(place);
    }
    way
}

/// The bounding box of places, grown by a length and a margin.
pub fn about(places: impl IntoIterator<Item = [f64; 2]>, more: f64) -> [[f64; 2]; 2] {
    let mut low = [f64::INFINITY; 2];
    let mut high = [f64::NEG_INFINITY; 2];
    for place in places {
        for axis in [0, 1] {
            low[axis] = low[axis].min(place[axis] - more);
            high[axis] = high[axis].max(place[axis] + more);
        }
    }
    if low[0] > high[0] {
        return [[0.0; 2], [1.0; 2]];
    }
    let rim = RIM * (high[0] - low[0]).max(high[1] - low[1]).max(1e-6);
    [low.map(|value| value - rim), high.map(|value| value + rim)]
}

/// The position at an instant, interpolated linearly between places at instants in order.
pub fn between<T>(places: &[(u64, T)], t_ns: u64, place: impl Fn(&T) -> [f64; 2]) -> Option<[f64; 2]> {
    let after = places.partition_point(|(other_ns, _)| *other_ns <= t_ns);
    let (start_ns, here) = places.get(after.saturating_sub(1))?;
    let here = place(here);
    match places.get(after).filter(|_| after > 0) {
        Some((end_ns, next)) => {
            let share = (t_ns - start_ns) as f64 / (end_ns - start_ns) as f64;
            let next = place(next);
            Some(
                [0, 1]
                    .map(|axis| if share == 0.0 { here[axis] } else { here[axis] + (next[axis] - here[axis]) * share }),
            )
        }
        None => Some(here),
    }
}

/// Draws a shape at its pose, grown by a length. A shape that cannot be placed, which the checker refuses, is not
/// drawn.
pub fn solid(shape: &Shape, pose: &Pose, growth_um: f64, color: &'static str, view: &PaperView, to: &mut Drawing) {
    let Ok(body) = shape.grown(pose, growth_um) else { return };
    let radius_pt = body.radius_um * view.scale;
    let wide = ShapeStyle::filled(color).with_stroke(color, 2.0 * radius_pt);
    let points = |points: &[Point2<f64>]| view.all(points.iter().map(|point| [point.x, point.y]));
    match &body.core {
        Core::Point(point) => to.disc(view.at([point.x, point.y]), radius_pt.max(0.8), ShapeStyle::filled(color), &[]),
        Core::Segment(ends) => to.line(&points(ends), ShapeStyle::line(color, (2.0 * radius_pt).max(HAIR_PT)), &[]),
        Core::Polygon(corners) if radius_pt > 0.0 => to.shape(&points(corners), wide, &[]),
        Core::Polygon(corners) => to.shape(&points(corners), ShapeStyle::filled(color), &[]),
    }
}

/// The name of an object, on it or beside it.
pub fn name(name: &str, at: [f64; 2]) -> PlacedLabel {
    PlacedLabel { text: name.to_owned(), text_style: TextStyle::SMALL, at, radius_pt: 2.0, may_cover: true }
}

/// The strobe numbers of a place.
pub fn numbers(numbers: &[usize], at: [f64; 2], radius_pt: f64) -> PlacedLabel {
    PlacedLabel { text: ranges(numbers), text_style: TextStyle::SMALL, at, radius_pt, may_cover: false }
}

/// The middle of the bounding box of a placed shape.
pub fn middle(shape: &Shape, pose: &Pose) -> [f64; 2] {
    let own = [pose.x_um, pose.y_um];
    let Ok(body) = shape.grown(pose, 0.0) else { return own };
    let points = match body.core {
        Core::Point(_) | Core::Segment(_) => return own,
        Core::Polygon(corners) => corners,
    };
    let [low, high] = about(points.iter().map(|point| [point.x, point.y]), 0.0);
    [(low[0] + high[0]) / 2.0, (low[1] + high[1]) / 2.0]
}

/// Legend text of obstacles, with their number if not all are drawn or named.
pub fn obstacles_text(all: usize, drawn: usize) -> String {
    match all {
        0 | 1 => "obstacle".to_owned(),
        _ if drawn < all => format!("obstacle, the first {drawn} of {all}"),
        _ if all > MAX_NAMES => format!("obstacle, {all} without names"),
        _ => "obstacle".to_owned(),
    }
}

/// Points of a circle or an arc, from one angle to another in radians.
pub fn arc([x, y]: [f64; 2], radius_um: f64, [from_rad, to_rad]: [f64; 2]) -> Vec<[f64; 2]> {
    const CORNERS: u32 = 48;
    let corner = |index: u32| {
        let (sin, cos) = (from_rad + (to_rad - from_rad) * f64::from(index) / f64::from(CORNERS)).sine_cosine();
        [x + radius_um * cos, y + radius_um * sin]
    };
    (0..=CORNERS).map(corner).collect()
}
