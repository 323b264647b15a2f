//! Conversion of the language's shapes to shapes of the plane.

use super::errors;
use super::solid;
use super::value::{PoseValue, ShapeValue, Value};
use crate::device::shape::ShapeForm;
use crate::diagnostic::Diagnostic;
use crate::geometry::polygon;
use crate::geometry::shape::{MAX_EXTENT_UM, Pose, Shape};
use crate::quantity::{Dimension, Quantity};
use crate::source::Span;
use std::f64::consts::TAU;

/// Greatest number of corners of a polygon: the test for self-intersection compares every pair of sides.
pub const MAX_CORNERS: usize = 2_000;

/// Diagnostic for an impossible shape, if it is one.
pub fn impossible(shape: &ShapeValue, span: Span) -> Option<Diagnostic> {
    match shape.form {
        ShapeForm::Disc | ShapeForm::Capsule | ShapeForm::Cells | ShapeForm::Layout | ShapeForm::Image => None,
        ShapeForm::Ellipsoid
        | ShapeForm::Superellipsoid
        | ShapeForm::RoundedBox
        | ShapeForm::Profile
        | ShapeForm::Sections
        | ShapeForm::Mesh => solid::of(shape, span).err().map(|wrong| *wrong),
        ShapeForm::Box => {
            let at = field_span(shape, "size", span);
            let is_flat = size_um(shape).iter().any(|side| *side <= 0.0);
            let help = "write a wall without width as a `capsule` with a small radius";
            is_flat.then(|| errors::bad_shape(at, "a box has no width or no height", "both must be above 0", help))
        }
        ShapeForm::Polygon => impossible_polygon(&corners_um(shape), field_span(shape, "points", span)),
    }
}

fn impossible_polygon(corners: &[[f64; 2]], at: Span) -> Option<Diagnostic> {
    let count = format!("a polygon has {} corners", corners.len());
    if corners.len() > MAX_CORNERS {
        let why = format!("at most {MAX_CORNERS} are allowed");
        return Some(errors::bad_shape(at, &count, &why, "split it into several polygons"));
    }
    Some(match polygon::fault(corners)? {
        polygon::PolygonFault::TooFewCorners => {
            errors::bad_shape(at, &count, "at least 3 are needed", "write a line as a `capsule` with a small radius")
        }
        polygon::PolygonFault::NoArea => errors::bad_shape(
            at,
            "a polygon has no area",
            "its corners lie on one line",
            "write a line as a `capsule` with a small radius",
        ),
        polygon::PolygonFault::RepeatedCorner(corner) => {
            let why = format!("corner {corner} and the next coincide");
            errors::bad_shape(at, "a polygon has the same corner twice", &why, "remove one of the two")
        }
        polygon::PolygonFault::Crossing(a, b) => {
            let why = format!("the sides from corners {a} and {b} meet");
            errors::bad_shape(at, "a polygon crosses itself", &why, "give the corners in order round the outline")
        }
    })
}

fn field_span(shape: &ShapeValue, field: &str, otherwise: Span) -> Span {
    shape.fields.get(field).map_or(otherwise, |value| value.span)
}

fn length_um(shape: &ShapeValue, field: &str) -> f64 {
    match shape.fields.get(field).map(|field| &field.value) {
        Some(Value::Quantity(quantity)) if quantity.dimension == Dimension::LENGTH => quantity.in_unit("um"),
        _ => 0.0,
    }
}

fn size_um(shape: &ShapeValue) -> [f64; 2] {
    match shape.fields.get("size").map(|field| &field.value) {
        Some(Value::Point(point)) => point_um(point),
        _ => [0.0; 2],
    }
}

fn corners_um(shape: &ShapeValue) -> Vec<[f64; 2]> {
    match shape.fields.get("points").map(|field| &field.value) {
        Some(Value::List(list)) => list
            .iter()
            .filter_map(|corner| match &corner.value {
                Value::Point(point) => Some(point_um(point)),
                _ => None,
            })
            .collect(),
        _ => Vec::new(),
    }
}

/// A place in micrometres; the point must have two lengths.
pub fn point_um(point: &[Quantity]) -> [f64; 2] {
    [point[0].in_unit("um"), point[1].in_unit("um")]
}

/// A shape of the plane; `None` for a block of cells, which has no size without a lattice.
pub fn in_plane(shape: &ShapeValue) -> Option<Shape> {
    match shape.form {
        ShapeForm::Disc => Some(Shape::Disc { radius_um: length_um(shape, "radius") }),
        ShapeForm::Box => Some(Shape::Box { size_um: size_um(shape) }),
        ShapeForm::Polygon => Some(Shape::Polygon { points_um: corners_um(shape) }),
        ShapeForm::Capsule => {
            Some(Shape::Capsule { length_um: length_um(shape, "length"), radius_um: length_um(shape, "radius") })
        }
        ShapeForm::Cells | ShapeForm::Layout | ShapeForm::Image => None,
        ShapeForm::Ellipsoid | ShapeForm::Superellipsoid | ShapeForm::RoundedBox => None,
        ShapeForm::Profile | ShapeForm::Sections | ShapeForm::Mesh => None,
    }
}

/// Greatest heading with a known direction: a million turns, where a double is rounded by less than 1e-7 deg.
pub const MAX_HEADING_RAD: f64 = 1e6 * TAU;

/// Pose of an object; `None` where the value is neither a place nor a pose in lengths.
pub fn pose_of(at: &Value) -> Option<Pose> {
    let pose = match at {
        Value::Pose(pose) if pose.x.dimension == Dimension::LENGTH => *pose,
        Value::Point(point) if point.len() == 2 && point[0].dimension == Dimension::LENGTH => {
            PoseValue::unturned(point[0], point[1])
        }
        _ => return None,
    };
    let PoseValue { x, y, heading } = pose;
    // Whole turns are removed. A heading too large for that is left for its kind to reject.
    let is_known = (TAU..=MAX_HEADING_RAD).contains(&heading.si.abs());
    let heading_rad = if is_known { heading.si % TAU } else { heading.si };
    Some(Pose { x_um: x.in_unit("um"), y_um: y.in_unit("um"), heading_rad })
}

/// Whether a heading is small enough for its direction to be known; [`pose_of`] has removed whole turns from those.
pub fn heading_is_known(pose: &Pose) -> bool {
    pose.heading_rad.abs() <= MAX_HEADING_RAD
}

/// Whether a shape and its pose are within the range of exact geometry.
pub fn within_extent(shape: &Shape, pose: &Pose) -> bool {
    pose.x_um.abs().max(pose.y_um.abs()) <= MAX_EXTENT_UM && shape.grown(pose, 0.0).is_ok()
}
