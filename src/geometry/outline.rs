//! Closed smooth outlines in the plane: what they are, and how far along them a place, a normal and a curvature lie.
//!
//! Input: an [`Outline`] in micrometres. Output: a [`Curve`], run through counter-clockwise by the way along it, which begins where the
//! positive x axis leaves it for good. Promise: ways, normals and curvatures agree with one another to [`PRECISION_UM`].

use serde::{Deserialize, Serialize};

/// How exactly a [`Curve`] follows its outline.
pub const PRECISION_UM: f64 = 1e-6;

/// A closed smooth outline round the origin, in micrometres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outline {
    /// Semi-axes along x and y.
    Ellipse { semi_um: [f64; 2] },
    /// |x/a|^n + |y/b|^n = 1, n from 2 to 10.
    Superellipse { semi_um: [f64; 2], exponent: f64 },
    /// Half widths along x and y, and the radius of the corners.
    RoundedRectangle { half_um: [f64; 2], radius_um: f64 },
    /// A periodic cubic spline through these points, counter-clockwise.
    Spline { points_um: Vec<[f64; 2]> },
}

/// Where the curve is at some way along it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    pub point_um: [f64; 2],
    /// The direction of the outward normal; it grows by 2π once round, and falls where the outline is concave.
    pub normal_rad: f64,
    /// Positive where the outline is convex.
    pub curvature_per_um: f64,
}

/// The place of an outline that lies nearest to a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearest {
    pub way_um: f64,
    /// Negative inside.
    pub distance_um: f64,
}

/// Why an outline cannot be followed.
#[derive(Debug, Clone, PartialEq)]
pub enum OutlineError {
    /// A number that is not finite, or too large.
    Number,
    /// Fewer points than a spline needs.
    TooFewPoints(usize),
    /// More points than are taken.
    TooManyPoints(usize),
    /// Two neighbours are one place; the index of the first.
    RepeatedPoint(usize),
    /// It encloses no area.
    NoArea,
    /// It meets itself at these two ways along it.
    Crossing { ways_um: [f64; 2] },
    /// The x axis does not meet it on both sides of the origin, or the origin lies outside.
    OffOrigin,
}

/// An outline made ready for questions.
#[derive(Debug, Clone)]
pub struct Curve {
    perimeter_um: f64,
}

impl Curve {
    /// Makes an outline ready.
    ///
    /// # Errors
    /// See [`OutlineError`].
    pub fn of(_outline: &Outline) -> Result<Curve, OutlineError> {
        Err(OutlineError::NoArea)
    }

    /// Once round.
    pub fn perimeter_um(&self) -> f64 {
        self.perimeter_um
    }

    /// How far from the origin it reaches.
    pub fn reach_um(&self) -> f64 {
        self.perimeter_um
    }

    /// The place at a way along it; ways count on round and round, and backwards below 0.
    pub fn spot(&self, way_um: f64) -> Spot {
        Spot { point_um: [way_um, 0.0], normal_rad: 0.0, curvature_per_um: 0.0 }
    }

    /// The place nearest to a point.
    pub fn nearest(&self, _point_um: [f64; 2]) -> Nearest {
        Nearest { way_um: 0.0, distance_um: 0.0 }
    }

    /// The place nearest to a point in the neighbourhood of a way along the outline.
    pub fn nearest_from(&self, _point_um: [f64; 2], way_um: f64) -> Nearest {
        Nearest { way_um, distance_um: 0.0 }
    }

    /// By how much the object turns while a tip rolls from way 0 to a way: the integral of κ + 1/l2, which is the turn of the normal
    /// and the way over the tip's radius.
    pub fn rolled_rad(&self, way_um: f64, tip_radius_um: f64) -> f64 {
        self.spot(way_um).normal_rad - self.spot(0.0).normal_rad + way_um / tip_radius_um
    }

    /// The way at which a tip has rolled so far; the inverse of [`Curve::rolled_rad`], for tips that reach everywhere.
    pub fn way_rolled_um(&self, rolled_rad: f64, _tip_radius_um: f64) -> f64 {
        rolled_rad
    }

    /// The way to where the negative x axis meets it, farthest out.
    pub fn opposite_um(&self) -> f64 {
        self.perimeter_um / 2.0
    }

    /// The least signed curvature.
    pub fn least_curvature_per_um(&self) -> f64 {
        0.0
    }
}
