//! The shapes that every kind may use: their words and their fields.

use super::{Need, Range, Sort, VocabularyField, optional, required};
use crate::quantity::Dimension;

/// The forms of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum ShapeForm {
    Disc,
    Box,
    Polygon,
    Capsule,
    Cells,
    Layout,
    Ellipsoid,
    Superellipsoid,
    RoundedBox,
    Profile,
    Sections,
    Mesh,
    Image,
}

impl ShapeForm {
    /// Every form, in the order of the handbook.
    pub const ALL: &'static [ShapeForm] = &[
        ShapeForm::Disc,
        ShapeForm::Box,
        ShapeForm::Polygon,
        ShapeForm::Capsule,
        ShapeForm::Cells,
        ShapeForm::Layout,
        ShapeForm::Ellipsoid,
        ShapeForm::Superellipsoid,
        ShapeForm::RoundedBox,
        ShapeForm::Profile,
        ShapeForm::Sections,
        ShapeForm::Mesh,
        ShapeForm::Image,
    ];

    /// The forms that take up room wherever they are put.
    pub const SOLID: &'static [ShapeForm] =
        &[ShapeForm::Disc, ShapeForm::Box, ShapeForm::Polygon, ShapeForm::Capsule, ShapeForm::Cells];

    /// Whether it is a shape of something that fingers turn.
    pub fn is_of_space(self) -> bool {
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

    /// The form's word in the language.
    pub fn name(self) -> &'static str {
        match self {
            ShapeForm::Disc => "disc",
            ShapeForm::Box => "box",
            ShapeForm::Polygon => "polygon",
            ShapeForm::Capsule => "capsule",
            ShapeForm::Cells => "cells",
            ShapeForm::Layout => "layout",
            ShapeForm::Ellipsoid => "ellipsoid",
            ShapeForm::Superellipsoid => "superellipsoid",
            ShapeForm::RoundedBox => "rounded_box",
            ShapeForm::Profile => "profile",
            ShapeForm::Sections => "sections",
            ShapeForm::Mesh => "mesh",
            ShapeForm::Image => "image",
        }
    }

    /// Its word with an article: `a disc`, `an ellipsoid`.
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

    /// The form of a word.
    pub fn find(name: &str) -> Option<ShapeForm> {
        ShapeForm::ALL.iter().copied().find(|form| form.name() == name)
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

    /// Its description.
    pub fn doc(self) -> &'static str {
        match self {
            ShapeForm::Disc => "all that lies within a radius of its origin",
            ShapeForm::Box => "a rectangle with its middle at the origin",
            ShapeForm::Polygon => "a closed outline through its points, convex or not",
            ShapeForm::Capsule => {
                "all that lies within a radius of a segment along its own x axis, its middle at the origin"
            }
            ShapeForm::Cells => "a block of lattice cells, both corners included",
            ShapeForm::Layout => "a part carried by electrodes: the electrodes under it, and its width",
            ShapeForm::Ellipsoid => "an ellipsoid with its axes along x, y and z",
            ShapeForm::Superellipsoid => "an ellipsoid whose flanks are flattened: |x/a|^n + |y/b|^n + |z/c|^n = 1",
            ShapeForm::RoundedBox => "a box with its middle at the origin, its edges and corners rounded",
            ShapeForm::Profile => {
                "a flat part: its outline in the plane xy, by points or by a curve; it turns about z only"
            }
            ShapeForm::Sections => "a solid given by its outlines in the planes xy and xz, which meet on the x axis",
            ShapeForm::Mesh => "a solid of triangles from an STL file, whose sections through the origin are taken",
            ShapeForm::Image => "a camera image of the scene: x along its rows, y down its columns, in pixels",
        }
    }
}

const fn length(name: &'static str, range: Range, doc: &'static str) -> VocabularyField {
    let sort = Sort::Quantity { dimension: Dimension::LENGTH, range };
    VocabularyField { name, sort, need: Need::Required, doc }
}

const DISC: [VocabularyField; 1] = [length("radius", Range::Positive, "from the middle to the rim")];
const BOX: [VocabularyField; 1] =
    [required("size", Sort::Size, "full width along its own x axis and full height along its y axis")];
const POLYGON: [VocabularyField; 1] =
    [required("points", Sort::Places, "three corners or more, in order, not crossing")];
const CAPSULE: [VocabularyField; 2] = [
    length("length", Range::NotNegative, "from one round end's middle to the other's"),
    length("radius", Range::Positive, "from the segment to the rim"),
];
const CELLS: [VocabularyField; 2] =
    [required("from", Sort::Cell, "one corner, included"), required("to", Sort::Cell, "the opposite corner, included")];
const LAYOUT: [VocabularyField; 2] = [
    required(
        "electrodes",
        Sort::Cell,
        "how many electrodes it has along columns and along rows, every second one of the board's",
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
    "its density, as `f.silicon`; with it the part has a weight",
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
        "four points or more of the outline, in order round it, not crossing",
    ),
    optional("x", Sort::Curve, "`points`", "along x, as an expression of the angle `t`: `16 um * cos(t)`"),
    optional("y", Sort::Curve, "`points`", "along y, as an expression of the angle `t`: `12 um * sin(t)`"),
];
const SECTIONS: [VocabularyField; 2] = [
    required("xy", Sort::Shape(ShapeForm::Profile), "its outline in the plane xy, by x and y"),
    required("xz", Sort::Shape(ShapeForm::Profile), "its outline in the plane xz, by x and z (written as x and y)"),
];
const MESH: [VocabularyField; 3] = [
    required("file", Sort::Text, "an STL file beside the program, ASCII or binary; a closed surface"),
    length("unit", Range::Positive, "length of 1 in the file, as `1 um`"),
    MATERIAL,
];
const IMAGE: [VocabularyField; 3] = [
    VocabularyField {
        name: "scale",
        sort: Sort::Quantity { dimension: Dimension::SCALE, range: Range::Positive },
        need: Need::Required,
        doc: "width and height of a pixel in the scene, as `0.32 um/px`",
    },
    optional("origin", Sort::Pixel, "(0 px, 0 px)", "the pixel that lies at the place where the image is put"),
    optional("mirrored", Sort::Flag, "false", "whether the camera shows the scene from behind, or by one mirror"),
];
