//! The shapes that every kind may use: their words and their fields.

use super::words::words;
use super::{Need, Range, Sort, VocabularyField, optional, required};
use crate::quantity::Dimension;
use serde::{Deserialize, Serialize};

/// A plane through an object's origin, fixed to the object, in which it has an outline.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Plane {
    /// The object turns about its own z axis.
    Xy,
    /// The object turns about its own y axis.
    Xz,
}

impl Plane {
    /// Both planes, in the paper's order.
    pub const ALL: [Plane; 2] = [Plane::Xy, Plane::Xz];

    /// The plane's own coordinate axes in the object's frame: a positive turn carries the first one towards the
    /// second.
    ///
    /// Both planes share the first axis, along x: contact 1, the paper's I, is where this axis leaves the object.
    pub const fn axes(self) -> [[f64; 3]; 2] {
        match self {
            Plane::Xy => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
            Plane::Xz => [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0]],
        }
    }

    /// The axis of a turn in this plane, in the object's frame; right-handed.
    pub const fn normal(self) -> [f64; 3] {
        match self {
            Plane::Xy => [0.0, 0.0, 1.0],
            Plane::Xz => [0.0, 1.0, 0.0],
        }
    }

    /// Its name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Plane::Xy => "xy",
            Plane::Xz => "xz",
        }
    }
}

words! {
    /// The forms of a shape, in the order of the handbook.
    pub enum ShapeForm {
        Disc = "disc": "everything within a radius of its origin",
        Box = "box": "a rectangle with its centre at the origin",
        Polygon = "polygon": "a closed outline through its points, convex or not",
        Capsule = "capsule": "everything within a radius of a segment along its own x axis, its centre at the origin",
        Cells = "cells": "a block of lattice cells, both corners included",
        Layout = "layout": "a part carried by electrodes: the electrodes under it, and its width",
        Ellipsoid = "ellipsoid": "an ellipsoid with its axes along x, y and z",
        Superellipsoid = "superellipsoid": "an ellipsoid whose flanks are flattened: |x/a|^n + |y/b|^n + |z/c|^n = 1",
        RoundedBox = "rounded_box": "a box with its centre at the origin, its edges and corners rounded",
        Profile = "profile": "a flat part: its outline in the plane xy, by points or by a curve; it turns about z only",
        Sections = "sections": "a solid given by its outlines in the planes xy and xz, which meet on the x axis",
        Mesh = "mesh": "a solid of triangles from an STL file, of which the sections through the origin are used",
        Image = "image": "a camera image of the scene: x along its rows, y down its columns, in pixels",
    }
}

impl ShapeForm {
    /// The forms that are solid in the plane.
    pub const SOLID: &'static [ShapeForm] =
        &[ShapeForm::Disc, ShapeForm::Box, ShapeForm::Polygon, ShapeForm::Capsule, ShapeForm::Cells];

    /// Whether the form is spatial: the shape of a part that fingers turn.
    pub fn is_spatial(self) -> bool {
        match self {
            ShapeForm::Ellipsoid
            | ShapeForm::Superellipsoid
            | ShapeForm::RoundedBox
            | ShapeForm::Profile
            | ShapeForm::Sections
            | ShapeForm::Mesh => true,
            ShapeForm::Disc
            | ShapeForm::Box
            | ShapeForm::Polygon
            | ShapeForm::Capsule
            | ShapeForm::Cells
            | ShapeForm::Layout
            | ShapeForm::Image => false,
        }
    }

    /// Its name with an article: `a disc`, `an ellipsoid`.
    pub fn with_article(self) -> String {
        match self {
            ShapeForm::Ellipsoid | ShapeForm::Image => format!("an {}", self.name()),
            ShapeForm::Cells | ShapeForm::Sections => format!("a shape of {}", self.name()),
            ShapeForm::Disc
            | ShapeForm::Box
            | ShapeForm::Polygon
            | ShapeForm::Capsule
            | ShapeForm::Layout
            | ShapeForm::Superellipsoid
            | ShapeForm::RoundedBox
            | ShapeForm::Profile
            | ShapeForm::Mesh => format!("a {}", self.name()),
        }
    }

    /// The fields of its dimensions.
    pub fn fields(self) -> &'static [VocabularyField] {
        match self {
            ShapeForm::Disc => &DISC,
            ShapeForm::Box => &BOX,
            ShapeForm::Polygon => &POLYGON,
            ShapeForm::Capsule => &CAPSULE,
            ShapeForm::Cells => &CELLS,
            ShapeForm::Layout => &LAYOUT,
            ShapeForm::Ellipsoid => &ELLIPSOID,
            ShapeForm::Superellipsoid => &SUPERELLIPSOID,
            ShapeForm::RoundedBox => &ROUNDED_BOX,
            ShapeForm::Profile => &PROFILE,
            ShapeForm::Sections => &SECTIONS,
            ShapeForm::Mesh => &MESH,
            ShapeForm::Image => &IMAGE,
        }
    }
}

const fn length(name: &'static str, range: Range, doc: &'static str) -> VocabularyField {
    let sort = Sort::Quantity { dimension: Dimension::LENGTH, range };
    VocabularyField { name, sort, need: Need::Required, doc }
}

const DISC: [VocabularyField; 1] = [length("radius", Range::Positive, "from the centre to the rim")];
const BOX: [VocabularyField; 1] =
    [required("size", Sort::Size, "full width along its own x axis and full height along its y axis")];
const POLYGON: [VocabularyField; 1] =
    [required("points", Sort::Places, "three or more corners, in order, not crossing")];
const CAPSULE: [VocabularyField; 2] = [
    length("length", Range::NotNegative, "from the centre of one round end to that of the other"),
    length("radius", Range::Positive, "from the segment to the rim"),
];
const CELLS: [VocabularyField; 2] =
    [required("from", Sort::Cell, "one corner, included"), required("to", Sort::Cell, "the opposite corner, included")];
const LAYOUT: [VocabularyField; 2] = [
    required(
        "electrodes",
        Sort::Cell,
        "number of electrodes under it along columns and along rows, every second one of the board's",
    ),
    VocabularyField {
        name: "half_width",
        sort: Sort::Quantity { dimension: Dimension::NUMBER, range: Range::Positive },
        need: Need::Required,
        doc: "from its centre to its rim, in pitches of the board",
    },
];

const VECTOR: Sort = Sort::Vector { dimension: Dimension::LENGTH, range: Range::Positive };
const MATERIAL: VocabularyField = optional(
    "material",
    Sort::Quantity { dimension: Dimension::DENSITY, range: Range::Positive },
    "without weight",
    "its density, such as `f.silicon`; with it the part has a weight",
);
const ELLIPSOID: [VocabularyField; 2] = [required("axes", VECTOR, "its semi-axes along x, y and z"), MATERIAL];
const SUPERELLIPSOID: [VocabularyField; 3] = [
    required("axes", VECTOR, "its semi-axes along x, y and z"),
    required(
        "exponent",
        Sort::Quantity { dimension: Dimension::NUMBER, range: Range::Positive },
        "n: 2 makes an ellipsoid, 4 is nearly a box; from 2 to 10",
    ),
    MATERIAL,
];
const ROUNDED_BOX: [VocabularyField; 3] = [
    required("size", VECTOR, "its full width along x, y and z"),
    length("radius", Range::Positive, "of its edges, at most half of the least width"),
    MATERIAL,
];
const PROFILE: [VocabularyField; 3] = [
    optional(
        "points",
        Sort::Places,
        "`x` and `y`",
        "four or more points of the outline, in order around it, not crossing",
    ),
    optional("x", Sort::Curve, "`points`", "along x, as an expression of the angle `t`: `16 um * cos(t)`"),
    optional("y", Sort::Curve, "`points`", "along y, as an expression of the angle `t`: `12 um * sin(t)`"),
];
const SECTIONS: [VocabularyField; 3] = [
    required("xy", Sort::Shape(ShapeForm::Profile), "its outline in the plane xy, by x and y"),
    required("xz", Sort::Shape(ShapeForm::Profile), "its outline in the plane xz, by x and z (written as x and y)"),
    optional(
        "centre_of_mass",
        Sort::Vector { dimension: Dimension::LENGTH, range: Range::Any },
        "the origin, where both outlines are centred there",
        "where a load acts, in the coordinates of the outlines",
    ),
];
const MESH: [VocabularyField; 3] = [
    required("file", Sort::Text, "an STL file beside the program, ASCII or binary; a closed surface"),
    length("unit", Range::Positive, "length of 1 in the file, such as `1 um`"),
    MATERIAL,
];
const IMAGE: [VocabularyField; 3] = [
    VocabularyField {
        name: "scale",
        sort: Sort::Quantity { dimension: Dimension::SCALE, range: Range::Positive },
        need: Need::Required,
        doc: "width and height of a pixel in the scene, such as `0.32 um/px`",
    },
    optional("origin", Sort::Pixel, "(0 px, 0 px)", "the pixel that lies at the place where the image is put"),
    optional("mirrored", Sort::Flag, "false", "whether the camera shows the scene from behind, or through one mirror"),
];
