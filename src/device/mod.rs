//! The closed list of device kinds and the vocabulary of each: fields, units, limits, verbs, shapes.
//!
//! A kind adds words, never syntax. The checker, `tweeze devices` and completions all read the tables here, so the
//! three cannot disagree. Nothing here judges a program.
//!
//! # What a fifth kind costs
//!
//! Files of its own, all of one name: facts and words here, and a file or a folder in each of `claims`, `check`,
//! `plan`, `schedule`, `lower`, `verify`, `emit` and `cli/report`; also `stdlib/<kind>.twz` (with its line in
//! `src/stdlib.rs`), an example, and corpus cases. Each stage calls it through a small trait in the stage's `mod.rs`.
//! The shared files that name it are these:
//!
//! | file | what it gets |
//! |---|---|
//! | `src/device/mod.rs` | the module, and a place in the list of `for_each_kind` |
//! | `src/claims/mod.rs` | the module, a variant of `Order` |
//! | `src/check/mod.rs` | the module, a variant of `KindFacts` |
//! | `src/plan/mod.rs` | the module, a variant of `Motion` |
//! | `src/schedule/mod.rs` | the module, a variant of `State` |
//! | `src/lower/mod.rs` | the module |
//! | `src/verify/mod.rs` | the module |
//! | `src/simulate/mod.rs` | whether it is simulated |
//! | `src/emit/mod.rs` | the module |
//! | `src/emit/sheet/mod.rs` | the module, if there is anything to load |
//! | `src/cli/report/mod.rs` | the module |
//! | `src/cli/mod.rs` | commands of its own, if it has any |
//!
//! `tests/tidy.rs` checks this table against the code, and counts the lines.

mod described;
pub mod dimibot;
pub mod electrode_array;
pub mod fingers;
pub mod instrument;
pub mod microrobots;
pub mod shape;
pub(crate) mod words;

use crate::quantity::{Dimension, Quantity, Unit, grouped};
use serde::{Deserialize, Serialize};
use std::fmt;

/// Largest node-expansion limit of one search: some ten gigabytes of memory.
pub const MAX_EXPANSIONS: u32 = 200_000_000;

/// Widest workspace, in micrometres: within it the rounding of a double stays far below the margins of planning.
pub const MAX_REACH_UM: f64 = 1e5;

/// Most digits of a word that stands for a state: one for each of [`Sort::State`]'s modules.
pub const MAX_WORD_DIGITS: u32 = 40;

/// Calls a macro with the list of all kinds, each by its module and its variant, in the order of the handbook. Code
/// that is the same for every kind is generated from this list: `$make` receives `$given`, then the list.
macro_rules! for_each_kind {
    ($make:ident, $given:tt) => {
        $make! { $given dimibot Dimibot, electrode_array ElectrodeArray, microrobots Microrobots, fingers Fingers }
    };
}

/// Matches on the kind, for any enum that has one single-field variant per kind: evaluates the same expression for
/// every variant, with the variant's content bound to a name, as in `each_kind!(Order, &job.order, order =>
/// order.steps.len())`.
macro_rules! each_kind {
    ($of:ident, $value:expr, $content:ident => $result:expr) => {
        $crate::device::for_each_kind!(each_kind, { $of, $value, $content, $result })
    };
    ({ $of:ident, $value:expr, $content:ident, $result:expr } $($module:ident $kind:ident),+) => {
        match $value { $($of::$kind($content) => $result,)+ }
    };
}

macro_rules! kinds {
    ({} $($module:ident $kind:ident),+) => {
        /// The kinds of device.
        #[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Kind {
            $($kind,)+
        }

        impl Kind {
            /// Every kind, in the order of the handbook.
            pub const ALL: &'static [Kind] = &[$(Kind::$kind),+];

            /// The words that the kind adds to the language.
            pub fn vocabulary(self) -> &'static Vocabulary {
                match self { $(Kind::$kind => &$module::VOCABULARY,)+ }
            }
        }
    };
}

pub(crate) use {each_kind, for_each_kind};

for_each_kind!(kinds, {});

impl Kind {
    /// The kind's name in the language.
    pub fn name(self) -> &'static str {
        self.vocabulary().name
    }

    /// The kind with this name, if there is one.
    pub fn find(name: &str) -> Option<Kind> {
        Kind::ALL.iter().copied().find(|kind| kind.name() == name)
    }
}

/// The vocabulary of a kind.
#[derive(Debug)]
pub struct Vocabulary {
    pub name: &'static str,
    pub summary: &'static str,
    /// A published device to start from, as (module, device): `std.dimibot` and `dimibot.femto_st`.
    pub library: (&'static str, &'static str),
    /// The fields of a device.
    pub fields: &'static [VocabularyField],
    /// Objects of a scene.
    pub nouns: &'static [Noun],
    /// The `field: value` settings of a task, except `minimize`, `using`, `start at` and `require`.
    pub settings: &'static [VocabularyField],
    /// Sort of `start at` and of the field `home`; `None` if the scene determines where a task starts.
    pub state: Option<Sort>,
    /// Whether `together { … }` gives simultaneous goals.
    pub together: Together,
    /// Whether `assay { … }` gives operations that depend on each other only through the parts they share.
    pub assay: Assay,
    /// Whether a program may place a device in a scene by a frame.
    pub frames: Frames,
    /// Steps of a task.
    pub verbs: &'static [Verb],
    /// Conditions on a whole task; they precede its steps, also in `for`.
    pub conditions: &'static [Verb],
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
    /// The verb with this name.
    pub fn verb(&self, name: &str) -> Option<&'static Verb> {
        self.verbs.iter().find(|verb| verb.name == name)
    }

    /// The verb with this name that takes `noun`, if there is one; otherwise the verb of that name.
    pub fn verb_of(&self, name: &str, noun: Option<&str>) -> Option<&'static Verb> {
        let with_noun = self.verbs.iter().find(|verb| verb.name == name && verb.noun.is_some() && verb.noun == noun);
        with_noun.or_else(|| self.verb(name))
    }

    /// Verbs and conditions: the words that can begin an entry of a task.
    pub fn verbs_and_conditions(&self) -> impl Iterator<Item = &'static Verb> + use<> {
        self.verbs.iter().chain(self.conditions)
    }

    /// The condition with this name.
    pub fn condition(&self, name: &str) -> Option<&'static Verb> {
        self.conditions.iter().find(|condition| condition.name == name)
    }

    /// The scene noun with this name.
    pub fn noun(&self, name: &str) -> Option<&'static Noun> {
        self.nouns.iter().find(|noun| noun.name == name)
    }
}

/// Whether the values of an outcome are whole numbers: counts, or times in nanoseconds. An outcome name has the same
/// unit in all kinds.
pub fn is_counted(outcome: &str) -> bool {
    let mut outcomes = Kind::ALL.iter().flat_map(|kind| kind.vocabulary().outcomes);
    outcomes.any(|known| known.name == outcome && known.unit.is_counted())
}

/// The condition with this name, of any kind.
pub fn condition_of_any_kind(word: &str) -> Option<&'static Verb> {
    Kind::ALL.iter().find_map(|kind| kind.vocabulary().condition(word))
}

/// Whether a device can have several goals at the same time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Together {
    Yes,
    /// With the reason, as messages give it.
    No(&'static str),
}

/// Whether a device carries many parts, each of which performs its operations in its own time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Assay {
    Yes,
    No,
}

/// Whether devices of the kind can be placed in a scene by a frame, beside others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Frames {
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
pub const fn positive(dimension: Dimension) -> Sort {
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

/// A mandatory field.
pub const fn required(name: &'static str, sort: Sort, doc: &'static str) -> VocabularyField {
    VocabularyField { name, sort, need: Need::Required, doc }
}

/// An optional field with a default.
const fn defaulted(name: &'static str, sort: Sort, default: DefaultFigure, doc: &'static str) -> VocabularyField {
    VocabularyField { name, sort, need: Need::Default(default), doc }
}

/// An optional field; `without` describes what applies if it is missing.
pub const fn optional(name: &'static str, sort: Sort, without: &'static str, doc: &'static str) -> VocabularyField {
    VocabularyField { name, sort, need: Need::Optional(without), doc }
}

/// The planner option that limits the search, in node expansions.
const fn expansions(default: u32, doc: &'static str) -> VocabularyField {
    budget("expansions", MAX_EXPANSIONS, default, doc)
}

/// A planner option that limits its search to at most `most`; `default` applies if it is missing.
const fn budget(name: &'static str, most: u32, default: u32, doc: &'static str) -> VocabularyField {
    defaulted(name, Sort::Count { least: 1, most }, DefaultFigure::count(default), doc)
}

/// A planner with its options.
const fn planner(word: WordChoice, options: &'static [VocabularyField]) -> Planner {
    Planner { name: word.name, options, doc: word.doc }
}

/// An outcome, with the unit of its value in schedules.
const fn outcome(word: WordChoice, unit: OutcomeUnit) -> Outcome {
    Outcome { name: word.name, unit, doc: word.doc }
}

/// Whether a field may be left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Need {
    Required,
    /// Optional, with this default.
    Default(DefaultFigure),
    /// Optional; the text describes what applies if it is missing.
    Optional(&'static str),
}

/// The default of a field, for the vocabulary's text and for the checker.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DefaultFigure {
    value: f64,
    /// Empty for a plain number.
    unit: &'static str,
}

impl DefaultFigure {
    /// A value in a unit of the closed list.
    const fn new(value: f64, unit: &'static str) -> Self {
        DefaultFigure { value, unit }
    }

    const fn count(value: u32) -> Self {
        DefaultFigure { value: value as f64, unit: "" }
    }

    /// The quantity, parsed as if it were written in the program.
    pub fn quantity(self) -> Quantity {
        let unit = if self.unit.is_empty() { Ok(Unit::ONE) } else { Unit::parse(self.unit) };
        let quantity = unit.ok().and_then(|unit| unit.of(&self.value.to_string()));
        quantity.expect("only units of the closed list are named in the compiler")
    }
}

/// As the language writes it, with spaces between thousands: `0.5 deg`, `200 000`.
impl fmt::Display for DefaultFigure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let is_whole = self.value.fract() == 0.0;
        let number = if is_whole { grouped(self.value as u64) } else { self.value.to_string() };
        if self.unit.is_empty() { f.write_str(&number) } else { write!(f, "{number} {}", self.unit) }
    }
}

/// Sort of values of a field, an argument or an object.
#[derive(Debug, Clone, Copy)]
pub enum Sort {
    /// A whole number.
    Count { least: u32, most: u32 },
    /// A number with a unit, or a plain one where the dimension is a number.
    Quantity { dimension: Dimension, range: Range },
    /// One of these words.
    Word(&'static [WordChoice]),
    /// A state of the device: for the DiMiBot a word of its modules, or the cell or place that denotes it.
    State,
    /// A destination: a cell or a place.
    Target,
    /// Destinations in any order: a list of cells and places.
    Targets,
    /// A corner of a block of cells.
    Cell,
    /// A list of cells.
    Cells,
    /// Lists of whole numbers from 0, one for each row of a board, the top row first; the word `none` marks an empty
    /// place.
    CountRows { most: u32 },
    /// Lists of lists of whole numbers from 0.
    CountTables { most: u32 },
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
    /// An object of the task's scene with this noun.
    Object(&'static str),
    /// A cell, or an object of the task's scene with this noun that covers cells.
    Site(&'static str),
    /// A list of cells and objects with this noun.
    Sites(&'static str),
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
    /// A length as an expression of the angle `t`, from 0 deg to 360 deg.
    Curve,
    /// A string, such as the name of a file.
    Text,
    /// The name of a file that describes a board of electrodes.
    Board(BoardLimits),
}

/// Limits on a board that is read from a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoardLimits {
    /// Greatest channel number.
    pub most_channel: u32,
    /// Most columns, and rows.
    pub most_side: u32,
}

/// The word for an empty place of a board.
pub const NONE: &str = "none";

/// The values that a quantity may take, in SI units.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// Above zero.
    Positive,
    /// Zero or above.
    NotNegative,
    /// Of either sign.
    Any,
    /// Of either sign, but not zero.
    NotZero,
    /// From 0 to 1.
    Share,
}

impl Range {
    /// Whether a value is in the range.
    pub fn contains(self, value: f64) -> bool {
        match self {
            Range::Positive => value > 0.0,
            Range::NotNegative => value >= 0.0,
            Range::Any => true,
            Range::NotZero => value != 0.0,
            Range::Share => (0.0..=1.0).contains(&value),
        }
    }

    /// The range in words.
    pub fn text(self) -> &'static str {
        match self {
            Range::Positive => "above 0",
            Range::NotNegative => "0 or above",
            Range::Any => "of either sign",
            Range::NotZero => "other than 0",
            Range::Share => "from 0 % to 100 %",
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

impl Noun {
    /// A noun of an enum of nouns, with the shapes that it may have.
    pub const fn of(word: WordChoice, shapes: &'static [shape::ShapeForm]) -> Noun {
        Noun { name: word.name, doc: word.doc, shapes }
    }
}

/// A step of a task, or a condition on the whole task.
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

/// A verb without object, prepositions or block.
const fn verb(word: WordChoice) -> Verb {
    Verb { name: word.name, noun: None, object: None, phrases: &[], block: None, doc: word.doc, example: "" }
}

/// The entries of a verb's braces: an object with prepositions and without a verb, as `D3 to pose(…)` in `assemble {
/// … }`.
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

/// How many times a preposition may occur in one step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Count {
    Once,
    /// Once, or not at all if the step has this other preposition.
    OnceUnless(&'static str),
    AtMostOnce,
    /// Repeatable; the order of writing counts.
    AnyNumber,
}

impl Count {
    /// Whether a step without the preposition is incomplete.
    pub const fn is_needed(self) -> bool {
        matches!(self, Count::Once | Count::OnceUnless(_))
    }
}

/// A planner.
#[derive(Debug)]
pub struct Planner {
    pub name: &'static str,
    pub options: &'static [VocabularyField],
    pub doc: &'static str,
}

/// A value of a finished plan that `require` can limit and the report shows.
#[derive(Debug)]
pub struct Outcome {
    pub name: &'static str,
    pub unit: OutcomeUnit,
    pub doc: &'static str,
}

impl Outcome {
    /// Its key in a schedule, with its unit as the last word: `distance_um`; a count has no unit suffix.
    pub fn key(&self) -> String {
        match self.unit.suffix() {
            "" => self.name.to_owned(),
            suffix => format!("{}_{suffix}", self.name),
        }
    }
}

/// Rounds a converted value to twelve digits, so that 2240 deg are not written as 2239.9999999999995.
fn without_noise(figure: f64) -> f64 {
    format!("{figure:.11e}").parse().unwrap_or(figure)
}

/// Units of outcomes in schedules; the same as those of all other numbers there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OutcomeUnit {
    Count,
    Degree,
    Joule,
    Micrometre,
    Nanosecond,
}

impl OutcomeUnit {
    pub const fn dimension(self) -> Dimension {
        match self {
            OutcomeUnit::Count => Dimension::NUMBER,
            OutcomeUnit::Degree => Dimension::ANGLE,
            OutcomeUnit::Joule => Dimension::ENERGY,
            OutcomeUnit::Micrometre => Dimension::LENGTH,
            OutcomeUnit::Nanosecond => Dimension::TIME,
        }
    }

    /// Unit suffix of a key; empty for a count.
    pub const fn suffix(self) -> &'static str {
        match self {
            OutcomeUnit::Count => "",
            OutcomeUnit::Degree => "deg",
            OutcomeUnit::Joule => "j",
            OutcomeUnit::Micrometre => "um",
            OutcomeUnit::Nanosecond => "ns",
        }
    }

    /// Whether values in this unit are whole numbers.
    pub const fn is_counted(self) -> bool {
        match self {
            OutcomeUnit::Count | OutcomeUnit::Nanosecond => true,
            OutcomeUnit::Degree | OutcomeUnit::Joule | OutcomeUnit::Micrometre => false,
        }
    }

    /// Converts from SI units to this unit; whole for nanoseconds.
    pub fn of_si(self, si: f64) -> f64 {
        match self {
            OutcomeUnit::Count | OutcomeUnit::Joule => si,
            OutcomeUnit::Degree => without_noise(si.to_degrees()),
            OutcomeUnit::Micrometre => without_noise(si * 1e6),
            OutcomeUnit::Nanosecond => (si * 1e9).round(),
        }
    }

    /// Converts from this unit to SI units.
    pub fn to_si(self, figure: f64) -> f64 {
        match self {
            OutcomeUnit::Count | OutcomeUnit::Joule => figure,
            OutcomeUnit::Degree => figure.to_radians(),
            OutcomeUnit::Micrometre => figure / 1e6,
            OutcomeUnit::Nanosecond => figure / 1e9,
        }
    }
}
