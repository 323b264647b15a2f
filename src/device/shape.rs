//! The shapes that every kind may use: their words and their fields.

use super::{Field, Need, Range, Sort, required};
use crate::quantity::Dimension;

/// The forms of a shape.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Form {
    Disc,
    Box,
    Polygon,
    Capsule,
    Cells,
    Layout,
}

impl Form {
    /// Every form, in the order of the handbook.
    pub const ALL: &'static [Form] = &[Form::Disc, Form::Box, Form::Polygon, Form::Capsule, Form::Cells, Form::Layout];

    /// The forms that take up room wherever they are put.
    pub const SOLID: &'static [Form] = &[Form::Disc, Form::Box, Form::Polygon, Form::Capsule, Form::Cells];

    /// The form's word in the language.
    pub fn name(self) -> &'static str {
        match self {
            Form::Disc => "disc",
            Form::Box => "box",
            Form::Polygon => "polygon",
            Form::Capsule => "capsule",
            Form::Cells => "cells",
            Form::Layout => "layout",
        }
    }

    /// The form of a word.
    pub fn find(name: &str) -> Option<Form> {
        Form::ALL.iter().copied().find(|form| form.name() == name)
    }

    /// The fields that say how large it is.
    pub fn fields(self) -> &'static [Field] {
        match self {
            Form::Disc => &DISC,
            Form::Box => &BOX,
            Form::Polygon => &POLYGON,
            Form::Capsule => &CAPSULE,
            Form::Cells => &CELLS,
            Form::Layout => &LAYOUT,
        }
    }

    /// What it is.
    pub fn doc(self) -> &'static str {
        match self {
            Form::Disc => "all that lies within a radius of its origin",
            Form::Box => "a rectangle with its middle at the origin",
            Form::Polygon => "a closed outline through its points, convex or not",
            Form::Capsule => {
                "all that lies within a radius of a segment along its own x axis, its middle at the origin"
            }
            Form::Cells => "a block of lattice cells, both corners included",
            Form::Layout => "a part that electrodes carry: what it has underneath, and how wide it is",
        }
    }
}

const fn length(name: &'static str, range: Range, doc: &'static str) -> Field {
    let sort = Sort::Quantity { dimension: Dimension::LENGTH, range };
    Field { name, sort, need: Need::Required, doc }
}

const DISC: [Field; 1] = [length("radius", Range::Positive, "from the middle to the rim")];
const BOX: [Field; 1] =
    [required("size", Sort::Size, "full width along its own x axis and full height along its y axis")];
const POLYGON: [Field; 1] = [required("points", Sort::Places, "three corners or more, in order, not crossing")];
const CAPSULE: [Field; 2] = [
    length("length", Range::NotNegative, "from one round end's middle to the other's"),
    length("radius", Range::Positive, "from the segment to the rim"),
];
const CELLS: [Field; 2] =
    [required("from", Sort::Cell, "one corner, included"), required("to", Sort::Cell, "the opposite corner, included")];
const LAYOUT: [Field; 2] = [
    required(
        "electrodes",
        Sort::Cell,
        "how many electrodes it has along columns and along rows, every second one of the board's",
    ),
    Field {
        name: "half_width",
        sort: Sort::Quantity { dimension: Dimension::NUMBER, range: Range::Positive },
        need: Need::Required,
        doc: "from its centre to its rim, in pitches of the board",
    },
];
