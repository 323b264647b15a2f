//! Values of expressions.

use crate::device::shape::ShapeForm;
use crate::device::{Need, VocabularyField};
use crate::geometry::mesh::Mesh;
use crate::quantity::{Dimension, Quantity};
use crate::source::{Span, Spanned};
use std::collections::BTreeMap;
use std::rc::Rc;

/// A constant value. [`Value::Unknown`] is the value after a diagnostic, or of a parameter without an argument;
/// values derived from it are unknown too, so that one mistake is reported once.
#[derive(Debug, Clone, PartialEq)]
pub enum Value {
    Quantity(Quantity),
    Bool(bool),
    Text(String),
    Word(ModuleWord),
    /// Two or three coordinates of one dimension: numbers make a cell, lengths a place, pixels a place in an image.
    Point(Vec<Quantity>),
    Pose(PoseValue),
    List(Rc<ListValue>),
    /// Whole numbers, the end not included.
    Range {
        from: i64,
        to: i64,
    },
    /// A unit quaternion w, x, y, z.
    Orientation([f64; 4]),
    /// Lengths in micrometres at equal steps of the angle `t` over a full turn.
    Curve(Rc<Vec<f64>>),
    Mesh(Rc<MeshFile>),
    Board(Rc<BoardFile>),
    Shape(ShapeValue),
    Table(Rc<TableValue>),
    Object(ObjectName),
    Unknown,
}

/// The digits of a word, one for each module.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ModuleWord {
    pub bits: u64,
    pub width: u32,
}

/// A place and a heading; the place in lengths, or in pixels until it is known in which image.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoseValue {
    pub x: Quantity,
    pub y: Quantity,
    pub heading: Quantity,
}

impl PoseValue {
    /// A place without a heading faces along x.
    pub fn unturned(x: Quantity, y: Quantity) -> PoseValue {
        PoseValue { x, y, heading: Quantity::new(0.0, Dimension::ANGLE) }
    }
}

/// An object of a scene, by its noun and its name; the task determines the scene.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ObjectName {
    pub noun: &'static str,
    pub name: String,
    /// Where the name stands, without its indices.
    pub word: Span,
}

/// Mesh from a file, in the file's own unit.
#[derive(Debug, Clone, PartialEq)]
pub struct MeshFile {
    /// The path as written in the program.
    pub path: String,
    pub mesh: Mesh,
}

/// A board that a file describes.
#[derive(Debug, Clone, PartialEq)]
pub struct BoardFile {
    /// The path as written in the program.
    pub path: String,
    pub columns: u32,
    pub rows: u32,
    /// The number of the channel under each place, row by row from the lowest; `None` without an electrode.
    pub channels: Vec<Option<u32>>,
    pub left_out: LeftOut,
}

/// Names of the electrodes of a file that are not cells of the board, in the order of the file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct LeftOut {
    /// On one channel with others, some of which are off the lattice.
    pub sharing: Vec<String>,
    /// At places of the lattice that are disconnected from the others.
    pub cut_off: Vec<String>,
    /// Of another size than most, between the places of the others, or away from all of them.
    pub off_lattice: Vec<String>,
}

/// Values in order; elements may be lists.
#[derive(Debug, Clone, PartialEq)]
pub struct ListValue {
    elements: Vec<Spanned<Value>>,
    /// Depth of nested lists in it, from 1.
    depth: usize,
}

impl ListValue {
    /// A list of elements.
    pub fn new(elements: Vec<Spanned<Value>>) -> ListValue {
        let depth = elements.iter().map(|element| match &element.value {
            Value::List(list) => list.depth,
            _ => 0,
        });
        ListValue { depth: depth.max().unwrap_or(0) + 1, elements }
    }

    /// Depth of nested lists in it, from 1.
    pub fn depth(&self) -> usize {
        self.depth
    }
}

impl std::ops::Deref for ListValue {
    type Target = [Spanned<Value>];

    fn deref(&self) -> &[Spanned<Value>] {
        &self.elements
    }
}

/// Fields that were given and accepted, by name, with the table that has the defaults of the others.
#[derive(Debug, Clone)]
pub struct Accepted {
    table: &'static [VocabularyField],
    given: BTreeMap<&'static str, Spanned<Value>>,
}

impl Accepted {
    /// Fields of a table, none of them given.
    pub fn new(table: &'static [VocabularyField]) -> Self {
        Accepted { table, given: BTreeMap::new() }
    }

    /// Default of a field that is left out, if the table has one.
    pub fn default_of(&self, name: &str) -> Option<Quantity> {
        match self.table.iter().find(|field| field.name == name)?.need {
            Need::Default(figure) => Some(figure.quantity()),
            Need::Required | Need::Optional(_) => None,
        }
    }
}

impl std::ops::Deref for Accepted {
    type Target = BTreeMap<&'static str, Spanned<Value>>;

    fn deref(&self) -> &Self::Target {
        &self.given
    }
}

impl std::ops::DerefMut for Accepted {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.given
    }
}

impl IntoIterator for Accepted {
    type Item = (&'static str, Spanned<Value>);
    type IntoIter = std::collections::btree_map::IntoIter<&'static str, Spanned<Value>>;

    fn into_iter(self) -> Self::IntoIter {
        self.given.into_iter()
    }
}

impl PartialEq for Accepted {
    fn eq(&self, other: &Self) -> bool {
        self.given == other.given
    }
}

/// A shape with the fields given to it.
#[derive(Debug, Clone, PartialEq)]
pub struct ShapeValue {
    pub form: ShapeForm,
    pub fields: Accepted,
}

/// The columns of a table, each cell with its place.
#[derive(Debug, Clone, PartialEq)]
pub struct TableValue {
    pub columns: Vec<(String, Span)>,
    pub rows: Vec<Vec<Spanned<Value>>>,
}

impl Value {
    /// Its sort, with an article: `a length`, `a cell`, `a list`.
    pub fn describe(&self) -> String {
        match self {
            Value::Quantity(quantity) => quantity.dimension.with_article(),
            Value::Bool(_) => "true or false".to_owned(),
            Value::Text(_) => "a string".to_owned(),
            Value::Word(word) => format!("a word of {} digits", word.width),
            Value::Point(coordinates) => describe_point(coordinates),
            Value::Pose(_) => "a pose".to_owned(),
            Value::List(_) => "a list".to_owned(),
            Value::Range { .. } => "a range".to_owned(),
            Value::Orientation(_) => "an orientation".to_owned(),
            Value::Curve(_) => "a curve".to_owned(),
            Value::Mesh(_) => "a file of triangles".to_owned(),
            Value::Board(_) => "a file of electrodes".to_owned(),
            Value::Shape(shape) => shape.form.with_article(),
            Value::Table(_) => "a table".to_owned(),
            Value::Object(object) => format!("the {} `{}`", object.noun, object.name),
            Value::Unknown => "an unknown value".to_owned(),
        }
    }

    /// Its sort, and its value where that helps: `a voltage (35 V)`.
    pub fn describe_fully(&self) -> String {
        match self {
            Value::Quantity(quantity) if quantity.dimension == Dimension::NUMBER => {
                format!("the plain number {quantity}")
            }
            Value::Quantity(quantity) => format!("{} ({quantity})", quantity.dimension.with_article()),
            _ => self.describe(),
        }
    }

    /// A plain number.
    pub fn number(value: f64) -> Value {
        Value::Quantity(Quantity::number(value))
    }

    /// Number of its elements that are visited one by one.
    pub fn elements(&self) -> usize {
        match self {
            Value::List(list) => list.len(),
            Value::Table(table) => table.rows.len() * table.columns.len(),
            _ => 0,
        }
    }

    /// Whether it is a temperature on the Celsius scale, or has one among its coordinates.
    pub fn is_celsius(&self) -> bool {
        match self {
            Value::Quantity(quantity) => quantity.is_celsius,
            Value::Point(coordinates) => coordinates.iter().any(|coordinate| coordinate.is_celsius),
            _ => false,
        }
    }

    /// Whether it is unknown.
    pub fn is_unknown(&self) -> bool {
        matches!(self, Value::Unknown)
    }
}

fn describe_point(coordinates: &[Quantity]) -> String {
    let dimension = coordinates.first().map_or(Dimension::NUMBER, |quantity| quantity.dimension);
    match (dimension, coordinates.len()) {
        (Dimension::NUMBER, 2) => "a cell".to_owned(),
        (Dimension::LENGTH, 2) => "a place".to_owned(),
        (Dimension::LENGTH, 3) => "a place in space".to_owned(),
        (Dimension::PIXELS, 2) => "a place in pixels".to_owned(),
        (_, count) => format!("a point of {count} {}s", dimension.name()),
    }
}

/// The largest whole number that a double counts exactly.
const MAX_WHOLE: f64 = 9_007_199_254_740_992.0;

/// Rounding tolerance of quotients and sums, relative to their size or to 1, whichever is greater.
const ROUNDING: f64 = 1e-12;

/// The whole number that a plain number is but for rounding, as `0.3 / 0.1` is 3; `None` otherwise.
pub fn whole(quantity: Quantity) -> Option<i64> {
    let nearest = quantity.si.round();
    let is_near = (quantity.si - nearest).abs() <= ROUNDING * nearest.abs().max(1.0);
    let is_whole = quantity.dimension == Dimension::NUMBER && is_near && nearest.abs() <= MAX_WHOLE;
    is_whole.then_some(nearest as i64)
}
