//! The closed list of device kinds, and the vocabulary that each brings: fields, units, limits, verbs, shapes.
//!
//! A kind brings words, never syntax. The tables here are read by the checker, printed by `tweeze devices` and
//! offered by completions, so that the three cannot disagree. Nothing here judges a program.

pub mod dimibot;
pub mod electrode_array;
pub mod fingers;
pub mod microrobots;
pub mod shape;
mod words;

use crate::quantity::Dimension;
use serde::{Deserialize, Serialize};

/// Greatest limit of states that one search may expand: some ten gigabytes of memory.
pub const MAX_EXPANSIONS: u32 = 200_000_000;

/// The kinds of device.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    Dimibot,
    ElectrodeArray,
    Microrobots,
    Fingers,
}

impl Kind {
    /// Every kind, in the order of the handbook.
    pub const ALL: &'static [Kind] = &[Kind::Dimibot, Kind::ElectrodeArray, Kind::Microrobots, Kind::Fingers];

    /// The kind's word in the language.
    pub fn name(self) -> &'static str {
        self.vocabulary().name
    }

    /// The kind of a word.
    pub fn find(name: &str) -> Option<Kind> {
        Kind::ALL.iter().copied().find(|kind| kind.name() == name)
    }

    /// The kind's words.
    pub fn vocabulary(self) -> &'static Vocabulary {
        match self {
            Kind::Dimibot => &dimibot::VOCABULARY,
            Kind::ElectrodeArray => &electrode_array::VOCABULARY,
            Kind::Microrobots => &microrobots::VOCABULARY,
            Kind::Fingers => &fingers::VOCABULARY,
        }
    }
}

/// The words of a kind.
#[derive(Debug)]
pub struct Vocabulary {
    pub name: &'static str,
    pub summary: &'static str,
    /// A published device to start from, as `std.dimibot` and `dimibot.femto_st`.
    pub library: (&'static str, &'static str),
    /// The fields of a device.
    pub fields: &'static [VocabularyField],
    /// Objects of a scene.
    pub nouns: &'static [Noun],
    /// The `field: value` settings of a task, except `minimize`, `using`, `start at` and `require`.
    pub settings: &'static [VocabularyField],
    /// Sort of `start at` and of the field `home`; `None` if the scene determines the start of a task.
    pub state: Option<Sort>,
    /// Whether `together { … }` gives simultaneous goals.
    pub together: Together,
    /// Steps of a task.
    pub verbs: &'static [Verb],
    /// Objectives of `minimize`; the first is the default.
    pub objectives: &'static [WordChoice],
    /// Planners of `using`; the first is the default.
    pub planners: &'static [Planner],
    /// Outcomes that `require` compares.
    pub outcomes: &'static [Outcome],
    /// Names and content of the channels.
    pub channels: &'static str,
}

impl Vocabulary {
    /// The verb of a word.
    pub fn verb(&self, name: &str) -> Option<&'static Verb> {
        self.verbs.iter().find(|verb| verb.name == name)
    }

    /// The scene noun of a word.
    pub fn noun(&self, name: &str) -> Option<&'static Noun> {
        self.nouns.iter().find(|noun| noun.name == name)
    }
}

/// Whether a device can have several goals at the same time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Together {
    Yes,
    No,
}

/// A word with its meaning.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WordChoice {
    pub name: &'static str,
    pub doc: &'static str,
}

/// A field of a device, a shape, a task or a planner.
#[derive(Debug)]
pub struct VocabularyField {
    pub name: &'static str,
    pub sort: Sort,
    pub need: Need,
    pub doc: &'static str,
}

/// A quantity above zero.
const fn positive(dimension: Dimension) -> Sort {
    Sort::Quantity { dimension, range: Range::Positive }
}

/// A quantity of either sign.
const fn any(dimension: Dimension) -> Sort {
    Sort::Quantity { dimension, range: Range::Any }
}

/// A quantity of zero or above.
const fn not_negative(dimension: Dimension) -> Sort {
    Sort::Quantity { dimension, range: Range::NotNegative }
}

/// A field that may not be left out.
const fn required(name: &'static str, sort: Sort, doc: &'static str) -> VocabularyField {
    VocabularyField { name, sort, need: Need::Required, doc }
}

/// A field that may be left out; `without` describes the default.
const fn optional(name: &'static str, sort: Sort, without: &'static str, doc: &'static str) -> VocabularyField {
    VocabularyField { name, sort, need: Need::Optional(without), doc }
}

/// The option of a planner that limits its search, which is `default` steps where it is left out.
const fn expansions(default: &'static str, doc: &'static str) -> VocabularyField {
    let sort = Sort::Count { least: 1, most: MAX_EXPANSIONS };
    VocabularyField { name: "expansions", sort, need: Need::Optional(default), doc }
}

/// A planner by its word, with its options.
const fn planner(word: WordChoice, options: &'static [VocabularyField]) -> Planner {
    Planner { name: word.name, options, doc: word.doc }
}

/// An outcome by its word, with the dimension of its figure.
const fn outcome(word: WordChoice, dimension: Dimension) -> Outcome {
    Outcome { name: word.name, dimension, doc: word.doc }
}

/// Whether a field may be left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Need {
    Required,
    /// May be left out; the text describes the default.
    Optional(&'static str),
}

/// Sort of a field, an argument or an object.
#[derive(Debug, Clone, Copy)]
pub enum Sort {
    /// A whole number.
    Count { least: u32, most: u32 },
    /// A number with a unit, or a plain one where the dimension is a number.
    Quantity { dimension: Dimension, range: Range },
    /// One of these words.
    Word(&'static [WordChoice]),
    /// A state of the device: for the DiMiBot a word of its modules, or the cell or place that stands for it.
    State,
    /// Where to go: a cell or a place.
    Target,
    /// Where to go, in any order: a list of cells and places.
    Targets,
    /// A corner of a block of cells.
    Cell,
    /// A width and a height.
    Size,
    /// A place in an image.
    Pixel,
    /// The corners of a polygon.
    Places,
    /// A whole number, or one of these words.
    CountOrWord { least: u32, most: u32, words: &'static [WordChoice] },
    /// True or false.
    Flag,
    /// A shape of this form.
    Shape(shape::ShapeForm),
    /// A table with these columns, in any order, at least one row.
    Table(&'static [VocabularyField]),
    /// Something of the task's scene, by this noun.
    Object(&'static str),
    /// A bare word that names something, as in the first column of a table.
    Name,
    /// A place and a heading.
    Pose,
    /// A control state of microrobots: its number, or a word with a digit for each arm.
    Control,
    /// Three coordinates along x, y and z, each of this range.
    Vector { dimension: Dimension, range: Range },
    /// A contact for each finger, from 1, or 0 where the finger is free.
    Contacts,
    /// An orientation in space: `euler(…)` or `quaternion(…)`.
    Orientation,
    /// A length as an expression of the angle `t`, which goes once round from 0 deg to 360 deg.
    Curve,
    /// A string, as the name of a file.
    Text,
}

/// The values that a quantity may take, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// Above zero.
    Positive,
    /// Zero or above.
    NotNegative,
    /// Of either sign.
    Any,
}

impl Range {
    /// Whether a value is in the range.
    pub fn holds(self, value: f64) -> bool {
        match self {
            Range::Positive => value > 0.0,
            Range::NotNegative => value >= 0.0,
            Range::Any => true,
        }
    }

    /// The range in words.
    pub fn text(self) -> &'static str {
        match self {
            Range::Positive => "above 0",
            Range::NotNegative => "0 or above",
            Range::Any => "of either sign",
        }
    }
}

/// An object of a scene.
#[derive(Debug)]
pub struct Noun {
    pub name: &'static str,
    pub doc: &'static str,
    /// The shapes it may have.
    pub shapes: &'static [shape::ShapeForm],
}

/// A step of a task.
#[derive(Debug)]
pub struct Verb {
    pub name: &'static str,
    /// The word before the object, as `state` in `apply state 2`.
    pub noun: Option<&'static str>,
    pub object: Option<Sort>,
    pub phrases: &'static [VocabularyPhrase],
    /// The content of its braces, if it has them.
    pub block: Option<&'static Block>,
    pub doc: &'static str,
    pub example: &'static str,
}

/// The entries of a verb's braces, as `D3 to pose(…)` in `assemble { … }`: an object with prepositions, without a verb.
#[derive(Debug)]
pub struct Block {
    pub object: Sort,
    pub phrases: &'static [VocabularyPhrase],
}

/// A preposition that a verb understands.
#[derive(Debug)]
pub struct VocabularyPhrase {
    pub preposition: &'static str,
    pub sort: Sort,
    pub count: Count,
}

/// How often a preposition may be used in one step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Count {
    Once,
    AtMostOnce,
    /// In the order of writing.
    AnyNumber,
}

/// A planner.
#[derive(Debug)]
pub struct Planner {
    pub name: &'static str,
    pub options: &'static [VocabularyField],
    pub doc: &'static str,
}

/// A figure of a finished plan that `require` can limit and the report shows.
#[derive(Debug)]
pub struct Outcome {
    pub name: &'static str,
    pub dimension: Dimension,
    pub doc: &'static str,
}
