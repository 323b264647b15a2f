//! Solid shapes in the plane and their placement.
//!
//! Input: a shape in its own frame, a pose and a growth, all in micrometres and radians. Output: a [`Rounded`] body,
//! that is, a core (point, segment or filled polygon) and a radius. Promise: the body is exactly the Minkowski sum of
//! the placed shape with a disc of radius `growth_um`.

use super::fault::{Fault, inject};
use nalgebra::{Isometry2, Point2, Vector2};
use serde::{Deserialize, Serialize};

/// Largest accepted coordinate or extent, in micrometres (one metre). Beyond it the rounding of `f64` approaches the
/// planner's safety margin.
pub const MAX_EXTENT_UM: f64 = 1e6;

/// A solid shape in its own frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    /// The origin alone.
    Point,
    /// A disc about the origin.
    Disc {
        /// Radius, ≥ 0.
        radius_um: f64,
    },
    /// A rectangle centred on the origin.
    Box {
        /// Width along local x and height along local y, both ≥ 0.
        size_um: [f64; 2],
    },
    /// A simple polygon, convex or not, closed from the last point to the first.
    Polygon {
        /// At least three corners, in either sense of rotation.
        points_um: Vec<[f64; 2]>,
    },
    /// All points within `radius_um` of a segment that is centred on the origin and lies along local x.
    Capsule {
        /// Length of the segment between the two centres, ≥ 0.
        length_um: f64,
        /// Radius, ≥ 0.
        radius_um: f64,
    },
}

/// Pose of a shape's own frame in the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// World x of the shape's origin.
    pub x_um: f64,
    /// World y of the shape's origin.
    pub y_um: f64,
    /// Rotation from world x to local x, counter-clockwise.
    pub heading_rad: f64,
}

impl Pose {
    /// A pose without rotation.
    pub const fn at(x_um: f64, y_um: f64) -> Self {
        Pose { x_um, y_um, heading_rad: 0.0 }
    }

    /// The rigid motion from the shape's frame to the world.
    pub fn isometry(&self) -> Isometry2<f64> {
        Isometry2::new(Vector2::new(self.x_um, self.y_um), self.heading_rad)
    }

    /// The pose in the coordinates of a frame at `frame` in the world.
    pub fn seen_from(&self, frame: &Pose) -> Pose {
        let place = frame.isometry().inverse_transform_point(&Point2::new(self.x_um, self.y_um));
        Pose { x_um: place.x, y_um: place.y, heading_rad: self.heading_rad - frame.heading_rad }
    }
}

/// The core of a [`Rounded`] body.
#[derive(Clone, Debug, PartialEq)]
pub enum Core {
    /// A single point.
    Point(Point2<f64>),
    /// A closed segment.
    Segment([Point2<f64>; 2]),
    /// A filled simple polygon.
    Polygon(Vec<Point2<f64>>),
}

impl Core {
    /// Its point, its two ends, or its corners in order around it (µm).
    pub fn corners(&self) -> &[Point2<f64>] {
        match self {
            Core::Point(point) => std::slice::from_ref(point),
            Core::Segment(ends) => ends,
            Core::Polygon(corners) => corners,
        }
    }
}

/// All points of the world within `radius_um` of a core.
#[derive(Clone, Debug, PartialEq)]
pub struct Rounded {
    /// The core, in world coordinates (µm).
    pub core: Core,
    /// Distance from the core up to which points belong to the body (µm, ≥ 0).
    pub radius_um: f64,
}

/// Reason why a shape cannot be placed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ShapeError {
    /// A number is not finite, or larger than [`MAX_EXTENT_UM`].
    OutOfRange,
    /// A radius, a size, a length or the growth is negative.
    Negative,
    /// A polygon has fewer than three corners.
    TooFewCorners,
}

impl Shape {
    /// The shape at `pose`, grown by a disc of radius `growth_um`.
    ///
    /// # Errors
    /// See [`ShapeError`]. Whether a polygon is simple is not checked; a self-crossing one is read by the even-odd rule.
    pub fn grown(&self, pose: &Pose, growth_um: f64) -> Result<Rounded, ShapeError> {
        self.check()?;
        check_range([pose.x_um, pose.y_um, pose.heading_rad, growth_um])?;
        check_sign([growth_um])?;
        let frame = Pose { x_um: inject(Fault::Place, pose.x_um), ..*pose }.isometry();
        let place = |x, y| frame * Point2::new(x, y);
        let (core, own_radius_um) = match self {
            Shape::Point => (Core::Point(place(0.0, 0.0)), 0.0),
            Shape::Disc { radius_um } => (Core::Point(place(0.0, 0.0)), *radius_um),
            Shape::Box { size_um: [w, h] } => {
                let (a, b) = (w / 2.0, h / 2.0);
                let corners = [(-a, -b), (a, -b), (a, b), (-a, b)];
                let corners = corners.map(|(x, y)| place(x, y)).to_vec();
                (Core::Polygon(corners), 0.0)
            }
            Shape::Polygon { points_um } => {
                let corners = points_um.iter().map(|[x, y]| place(*x, *y)).collect();
                (Core::Polygon(corners), 0.0)
            }
            Shape::Capsule { length_um, radius_um } => {
                let half = length_um / 2.0;
                let ends = [place(-half, 0.0), place(half, 0.0)];
                (Core::Segment(ends), *radius_um)
            }
        };
        let radius_um = inject(Fault::Grown, own_radius_um + growth_um);
        Ok(Rounded { core, radius_um })
    }

    fn check(&self) -> Result<(), ShapeError> {
        match self {
            Shape::Point => Ok(()),
            Shape::Disc { radius_um } => check_length([*radius_um]),
            Shape::Box { size_um } => check_length(*size_um),
            Shape::Capsule { length_um, radius_um } => check_length([*length_um, *radius_um]),
            Shape::Polygon { points_um } if points_um.len() < 3 => Err(ShapeError::TooFewCorners),
            Shape::Polygon { points_um } => points_um.iter().try_for_each(|p| check_range(*p)),
        }
    }
}

fn check_length<const K: usize>(values: [f64; K]) -> Result<(), ShapeError> {
    check_range(values)?;
    check_sign(values)
}

fn check_range<const K: usize>(values: [f64; K]) -> Result<(), ShapeError> {
    match values.iter().all(|v| v.abs() <= MAX_EXTENT_UM) {
        true => Ok(()),
        false => Err(ShapeError::OutOfRange),
    }
}

fn check_sign<const K: usize>(values: [f64; K]) -> Result<(), ShapeError> {
    match values.iter().all(|v| *v >= 0.0) {
        true => Ok(()),
        false => Err(ShapeError::Negative),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_placed_about_its_centre() {
        let pose = Pose { x_um: 1.0, y_um: 2.0, heading_rad: std::f64::consts::FRAC_PI_2 };
        let shape = Shape::Box { size_um: [4.0, 2.0] };
        let body = shape.grown(&pose, 0.5).unwrap();
        assert_eq!(body.radius_um, 0.5);
        let Core::Polygon(corners) = body.core else { panic!("a box has a polygon as its core") };
        assert!((corners[0] - Point2::new(2.0, 0.0)).norm() < 1e-12);
    }

    #[test]
    fn bad_numbers_are_refused() {
        let at = Pose::at(0.0, 0.0);
        let disc = |radius_um| Shape::Disc { radius_um }.grown(&at, 0.0);
        assert!(disc(0.0).is_ok());
        assert_eq!(disc(-1e-12), Err(ShapeError::Negative));
        assert_eq!(disc(f64::NAN), Err(ShapeError::OutOfRange));
        assert!(disc(MAX_EXTENT_UM).is_ok());
        assert_eq!(disc(MAX_EXTENT_UM * 1.001), Err(ShapeError::OutOfRange));
        let points_um = vec![[0.0, 0.0], [1.0, 0.0]];
        let two = Shape::Polygon { points_um }.grown(&at, 0.0);
        assert_eq!(two, Err(ShapeError::TooFewCorners));
    }
}
