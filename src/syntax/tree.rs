//! Syntax tree of one file: the text with its places, without meaning.
//!
//! Every node carries its span, and a child's span lies in its parent's. Parts that could not be read are
//! [`ExprKind::Error`] or an `Error` entry; their diagnostic was pushed during parsing, so later stages ignore them.
//! Verbs, fields, nouns and shapes are plain words here: device kinds add no node types.

use crate::source::{FileId, Span};

/// A word with its span.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ident {
    pub text: String,
    pub span: Span,
}

/// The `///` lines before a declaration, joined by line ends, without their slashes and one leading space.
pub type Doc = Option<String>;

/// One file.
#[derive(Debug, Clone)]
pub struct Tree {
    pub file: FileId,
    /// The `//!` lines at the top.
    pub doc: Doc,
    pub items: Vec<Item>,
    /// The names that unreadable declarations would have declared; later stages must not report them as unknown.
    pub broken_names: Vec<Ident>,
}

/// A declaration at the top of a file.
#[derive(Debug, Clone)]
pub enum Item {
    Use(Use),
    Let(Let),
    Device(Device),
    Instrument(Device),
    Output(Device),
    Scene(Scene),
    Task(Task),
    Program(Program),
    Wiring(Wiring),
    Error(Span),
}

impl Item {
    /// Its span, without its doc comment.
    pub fn span(&self) -> Span {
        match self {
            Item::Use(item) => item.span,
            Item::Let(item) => item.span,
            Item::Device(item) | Item::Instrument(item) | Item::Output(item) => item.span,
            Item::Scene(item) => item.span,
            Item::Task(item) => item.span,
            Item::Program(item) => item.span,
            Item::Wiring(item) => item.span,
            Item::Error(span) => *span,
        }
    }

    /// The task or program in this item; `None` for other declarations.
    pub fn runnable(&self) -> Option<Runnable<'_>> {
        let (Item::Task(Task { name, parameters, doc, entries, .. })
        | Item::Program(Program { name, parameters, doc, entries, .. })) = self
        else {
            return None;
        };
        Some(Runnable { name, parameters, doc, entries })
    }
}

/// A task or a program.
#[derive(Debug, Clone, Copy)]
pub struct Runnable<'t> {
    pub name: &'t Ident,
    pub parameters: &'t [Parameter],
    pub doc: &'t Doc,
    pub entries: &'t [Entry],
}

/// `use std.dimibot as d` or `use "bench.twz" as lab`.
#[derive(Debug, Clone)]
pub struct Use {
    pub path: UsePath,
    pub alias: Option<Ident>,
    pub span: Span,
}

/// Location of a used file.
#[derive(Debug, Clone)]
pub enum UsePath {
    /// `std.dimibot`: the words between the dots, `std` included.
    Library { words: Vec<Ident>, span: Span },
    /// `"bench.twz"`, relative to the file with the `use`.
    File(Text),
}

/// `let pitch = 70 um`.
#[derive(Debug, Clone)]
pub struct Let {
    pub doc: Doc,
    pub name: Ident,
    pub value: Expr,
    pub span: Span,
}

/// `device bot : dimibot.femto_st { left: 5 }`, or `instrument awg : waveform_generator { outputs: 2 }`, which has the
/// same form.
#[derive(Debug, Clone)]
pub struct Device {
    pub doc: Doc,
    pub name: Ident,
    pub base: Path,
    pub fields: Vec<Field>,
    pub span: Span,
}

/// `left: 5`, in a device, a shape, a task or a planner's options.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    pub doc: Doc,
    pub name: Ident,
    pub value: Expr,
    pub span: Span,
}

/// `scene dusty : bench { … }`.
#[derive(Debug, Clone)]
pub struct Scene {
    pub doc: Doc,
    pub name: Ident,
    pub base: Option<Path>,
    pub entries: Vec<SceneEntry>,
    pub span: Span,
}

/// An entry of a scene.
#[derive(Debug, Clone)]
pub enum SceneEntry {
    Object(Object),
    For(For<SceneEntry>),
    Error(Span),
}

/// `obstacle d[i] : disc { radius: 2 um } at (3 um, 4 um)`; the noun is the kind's word.
#[derive(Debug, Clone)]
pub struct Object {
    pub doc: Doc,
    pub noun: Ident,
    pub name: IndexedName,
    pub shape: Option<Expr>,
    pub at: Option<Expr>,
    pub span: Span,
}

/// A declared name with its indices: `d[i]`, `e[5, i]`.
#[derive(Debug, Clone, PartialEq)]
pub struct IndexedName {
    pub name: Ident,
    pub indices: Vec<Expr>,
    pub span: Span,
}

/// `for i, p in spots { … }`: one name takes the elements; with two, the first is the index.
#[derive(Debug, Clone)]
pub struct For<E> {
    /// The counter, where two names are given.
    pub counter: Option<Ident>,
    pub element: Ident,
    pub over: Expr,
    pub entries: Vec<E>,
    pub span: Span,
}

/// `task go(goal: cell) on bot in dusty { … }`.
#[derive(Debug, Clone)]
pub struct Task {
    pub doc: Doc,
    pub name: Ident,
    pub parameters: Vec<Parameter>,
    pub device: Path,
    pub scene: Option<Path>,
    pub entries: Vec<Entry>,
    pub span: Span,
}

/// `goal: cell`.
#[derive(Debug, Clone)]
pub struct Parameter {
    pub name: Ident,
    pub sort: Ident,
    pub span: Span,
}

/// `program day(p: cell) { run go(p), wait 5 ms }`.
#[derive(Debug, Clone)]
pub struct Program {
    pub doc: Doc,
    pub name: Ident,
    pub parameters: Vec<Parameter>,
    pub entries: Vec<Entry>,
    pub span: Span,
}

/// An entry of a task, a program, or a block of one.
#[derive(Debug, Clone)]
pub enum Entry {
    /// `precision: 0.25 um`.
    Field(Field),
    /// Settings (`minimize time`), steps (`move to (1, 2)`), `run`, `wait`, `together { … }`: all have the same form.
    Step(Step),
    For(For<Entry>),
    Error(Span),
}

/// A head word, at most one object, prepositions with values, at most one block:
/// `move m1 to (26, 31) via (3, 9)`, `apply state 2 for 3 s`, `minimize distance`, `together { … }`.
/// In `assemble { D3 to … }` the head is the object; the grammar makes no distinction.
#[derive(Debug, Clone)]
pub struct Step {
    pub head: Ident,
    /// The head's indices where it is an object, as in `D[i] to …`; empty otherwise.
    pub indices: Vec<Expr>,
    /// The noun before the object, as `state` in `apply state 2`.
    pub noun: Option<Ident>,
    pub object: Option<Expr>,
    pub phrases: Vec<Phrase>,
    pub block: Option<Vec<Entry>>,
    pub span: Span,
}

/// `to (26, 31)`.
#[derive(Debug, Clone)]
pub struct Phrase {
    pub preposition: Ident,
    pub value: Expr,
    pub span: Span,
}

/// `wiring bot { bl[i].set -> "Dev1/port0/line{2*i}" }`.
#[derive(Debug, Clone)]
pub struct Wiring {
    pub doc: Doc,
    pub device: Path,
    pub entries: Vec<WiringEntry>,
    pub span: Span,
}

/// An entry of a wiring.
#[derive(Debug, Clone)]
pub enum WiringEntry {
    Wire(Wire),
    /// A default field for all wires of the wiring that do not have it themselves.
    Field(Field),
    For(For<WiringEntry>),
    Error(Span),
}

/// `bl0.set -> "Dev1/port0/line0"`, or `bed -> awg.ch1 { gain: 50 }`.
#[derive(Debug, Clone)]
pub struct Wire {
    pub channel: Path,
    pub output: WireOutput,
    pub fields: Vec<Field>,
    pub span: Span,
}

/// Target of a wire.
#[derive(Debug, Clone)]
pub enum WireOutput {
    /// A name that Tweeze passes on unchanged.
    Named(Text),
    /// An instrument and its output.
    Instrument(Path),
}

/// Names with dots and indices: `dimibot.femto_st`, `bl[i].set`, `spots[0]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Path {
    /// Never empty.
    pub segments: Vec<IndexedName>,
    pub span: Span,
}

/// A string and the values in its braces.
#[derive(Debug, Clone, PartialEq)]
pub struct Text {
    pub parts: Vec<TextPart>,
    pub span: Span,
}

impl Text {
    /// Its characters; `None` if it has holes.
    pub fn plain(&self) -> Option<String> {
        let plain = |part: &'_ TextPart| match part {
            TextPart::Plain(plain) => Some(plain.clone()),
            TextPart::Hole(_) => None,
        };
        self.parts.iter().map(plain).collect()
    }
}

/// A piece of a string.
#[derive(Debug, Clone, PartialEq)]
pub enum TextPart {
    /// Plain characters, `{{` already turned into `{`.
    Plain(String),
    Hole(Expr),
}

/// A value as written.
#[derive(Debug, Clone, PartialEq)]
pub struct Expr {
    pub kind: ExprKind,
    pub span: Span,
}

/// The forms of a value.
#[derive(Debug, Clone, PartialEq)]
pub enum ExprKind {
    /// `35`, `1e-3`, `10_000`: the digits as written without `_`, a finite number in Rust's own notation.
    Number(String),
    /// `35 um/s`: the digits as in `Number`, and the unit as written.
    Quantity {
        number: String,
        unit: Ident,
    },
    /// `0b10001_00010`: its digits, `_` kept.
    Word(String),
    Text(Text),
    Bool(bool),
    Path(Path),
    /// `(x, y)` or `(x, y, z)`; a value in brackets alone is that value.
    Tuple(Vec<Expr>),
    List(Vec<Expr>),
    /// `0..4`, the end not included.
    Range {
        from: Box<Expr>,
        to: Box<Expr>,
    },
    Negative(Box<Expr>),
    Binary {
        left: Box<Expr>,
        operator: Operator,
        operator_span: Span,
        right: Box<Expr>,
    },
    /// `pose(1 um, 2 um, 90 deg)`, `go(p, 200 ms)`.
    Call {
        function: Path,
        arguments: Vec<Expr>,
    },
    /// `disc { radius: 2 um }`: the base with these fields changed.
    With {
        base: Path,
        fields: Vec<Field>,
    },
    Table(Table),
    /// Could not be read; the diagnostic has been pushed.
    Error,
}

/// The binary operators, loosest first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operator {
    Equal,
    NotEqual,
    Less,
    LessEqual,
    Greater,
    GreaterEqual,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
}

impl Operator {
    /// The operator as it is written.
    pub fn symbol(self) -> &'static str {
        match self {
            Operator::Equal => "==",
            Operator::NotEqual => "!=",
            Operator::Less => "<",
            Operator::LessEqual => "<=",
            Operator::Greater => ">",
            Operator::GreaterEqual => ">=",
            Operator::Add => "+",
            Operator::Subtract => "-",
            Operator::Multiply => "*",
            Operator::Divide => "/",
            Operator::Power => "^",
        }
    }
}

/// `table { robot | snap_down [V] … }`: a header and its rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Table {
    pub columns: Vec<Column>,
    pub rows: Vec<Row>,
}

/// `snap_down [V]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    pub name: Ident,
    pub unit: Option<Ident>,
}

/// One line of a table; as many cells as the table has columns.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    pub cells: Vec<Expr>,
    pub span: Span,
}
