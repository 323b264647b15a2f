//! What the parser has to say: one function for each mistake.

use super::grammar::Rule;
use super::tree::{Column, Ident};
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

/// Where a list of entries stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    Top,
    Fields,
    Scene,
    Steps,
    Wires,
}

impl Place {
    /// What may stand there, with an example.
    pub fn wants(self) -> &'static str {
        match self {
            Place::Top => "a declaration, such as `let pitch = 70 um`",
            Place::Fields => "a field, such as `left: 5`",
            Place::Scene => "an object, such as `obstacle dust at (12, 7)`",
            Place::Steps => "a step or a setting, such as `move to (19, 28)`",
            Place::Wires => "a wire, such as `bl0.set -> \"Dev1/port0/line0\"`",
        }
    }
}

/// The span of the bytes `start..end` of the file of `span`.
pub(super) fn part(span: Span, start: usize, end: usize) -> Span {
    Span::new(span.file, start, end)
}

/// The first word, number or sign at an offset; empty only at the end of the text.
pub(super) fn token_at(text: &str, offset: usize) -> &str {
    let rest = &text[offset..];
    let Some(first) = rest.chars().next() else { return "" };
    let in_word = |c: char| c.is_alphanumeric() || c == '_';
    let in_sign = |c: char| "+-*/^<>=!.:".contains(c);
    let length = if in_word(first) {
        rest.find(|c| !in_word(c))
    } else if in_sign(first) {
        rest.find(|c| !in_sign(c))
    } else {
        Some(first.len_utf8())
    };
    &rest[..length.unwrap_or(rest.len())]
}

/// Where the last code before an offset ends: blanks, line ends and comments are passed by.
pub(super) fn code_end_before(text: &str, offset: usize) -> usize {
    let mut end = offset;
    loop {
        end = text[..end].trim_end().len();
        let line = text[..end].rfind('\n').map_or(0, |at| at + 1);
        match text[line..end].find("//") {
            Some(at) => end = line + at,
            None => return end,
        }
    }
}

/// The line of an offset up to that offset, without its indentation.
fn line_before(text: &str, offset: usize) -> &str {
    let start = text[..offset].rfind('\n').map_or(0, |at| at + 1);
    text[start..offset].trim()
}

/// The line of an offset from that offset on, without a comment.
fn line_after(text: &str, offset: usize) -> &str {
    let line = text[offset..].lines().next().unwrap_or("");
    line.split("//").next().unwrap_or("").trim()
}

/// The longest piece of the user's text that a message repeats, in characters.
const LONGEST_QUOTE: usize = 60;

/// A piece of the user's text for a message, cut where it is long; holes of the scan show as `…`.
pub(super) fn quote(text: &str) -> String {
    let mut quoted: String = text.chars().take(LONGEST_QUOTE).collect();
    if text.chars().nth(LONGEST_QUOTE).is_some() {
        quoted.push('…');
    }
    quoted.replace([super::scan::HOLE, super::scan::CUT], "…")
}

pub(super) fn late_brace(mark: Span, text: &str) -> Diagnostic {
    let brace = mark.end as usize;
    let line = quote(line_before(text, code_end_before(text, brace)));
    Diagnostic::new(Code::E0105, "`{` on a line of its own")
        .label(part(mark, brace, brace + 1), "this opens the block of the line above")
        .help(format!("write it at the end of that line: `{line} {{`"))
}

pub(super) fn leading_operator(mark: Span, text: &str) -> Diagnostic {
    let start = mark.end as usize;
    let operator = token_at(text, start);
    let line = quote(line_before(text, code_end_before(text, start)));
    Diagnostic::new(Code::E0106, format!("a line begins with `{operator}`"))
        .label(part(mark, start, start + operator.len()), "the value of the line above was complete without this")
        .help(format!("a line goes on after an operator, not before it: end the line above with `{line} {operator}`"))
}

pub(super) fn leading_preposition(mark: Span, text: &str) -> Diagnostic {
    let start = mark.end as usize;
    let word = token_at(text, start);
    let line = line_before(text, code_end_before(text, start));
    let joined = quote(&format!("{line} {}", line_after(text, start)));
    Diagnostic::new(Code::E0107, format!("a line begins with `{word}`"))
        .label(part(mark, start, start + word.len()), "this belongs to the line above")
        .help(format!("a step stands on one line: `{joined}`"))
}

pub(super) fn blank_before_bracket(mark: Span, text: &str) -> Diagnostic {
    let start = code_end_before(text, mark.start as usize);
    let name_start = text[..start].rfind(|c: char| !c.is_alphanumeric() && c != '_');
    let name = &text[name_start.map_or(0, |at| at + text[at..].chars().next().map_or(1, char::len_utf8))..start];
    let bracket = token_at(text, mark.end as usize);
    let place = part(mark, mark.start as usize, mark.end as usize + 1);
    Diagnostic::new(Code::E0108, format!("a blank between `{name}` and `{bracket}`"))
        .label(place, "no blank here")
        .help(format!("write `{name}{bracket}…`: an index or an argument joins its name"))
}

pub(super) fn wrong_colon(mark: Span, text: &str) -> Diagnostic {
    let sign = &text[mark.range()];
    let name = token_before(text, mark.start as usize);
    Diagnostic::new(Code::E0119, format!("`{sign}` between a field and its value"))
        .label(mark, "a field takes `:`")
        .help(format!("write `{name}: {}`", quote(line_after(text, mark.end as usize))))
}

pub(super) fn wrong_equals(mark: Span, text: &str) -> Diagnostic {
    let sign = &text[mark.range()];
    let name = token_before(text, mark.start as usize);
    Diagnostic::new(Code::E0119, format!("`{sign}` between a name and its value"))
        .label(mark, "`let` takes `=`")
        .help(format!("write `let {name} = {}`", quote(line_after(text, mark.end as usize))))
}

/// The word that ends before an offset.
fn token_before(text: &str, offset: usize) -> &str {
    let head = text[..offset].trim_end();
    let start = head.char_indices().rev().find(|(_, c)| !c.is_alphanumeric() && *c != '_');
    &head[start.map_or(0, |(at, c)| at + c.len_utf8())..]
}

pub(super) fn joined(mark: Span, text: &str) -> Diagnostic {
    let start = mark.end as usize;
    let word = token_at(text, start);
    Diagnostic::new(Code::E0103, format!("`{word}` begins anew on the same line"))
        .label(part(mark, start, start + word.len()), "what stands before this was complete")
        .help(format!("put a comma or a line end before `{word}`"))
}

pub(super) fn reserved_name(name: &Ident) -> Diagnostic {
    Diagnostic::new(Code::E0110, format!("`{}` is a reserved word", name.text))
        .label(name.span, "a name is declared here")
        .help(format!("take another name, such as `{}_1`", name.text))
}

pub(super) fn missing_value(at: Span, text: &str) -> Diagnostic {
    let end = code_end_before(text, at.start as usize);
    let mut start = end - token_before_sign(&text[..end]).len();
    if text[start..end].starts_with(':') {
        start -= text[..start].len() - text[..start].trim_end().len();
        start -= token_before(text, start).len();
    }
    let before = &text[start..end];
    Diagnostic::new(Code::E0102, format!("a value is missing after `{before}`"))
        .label(part(at, start, end), "a value belongs behind this")
        .help("write a number with its unit, such as `35 um`, a place, such as `(4 um, 2 um)`, or a name")
}

/// The last word or sign of a text.
fn token_before_sign(text: &str) -> &str {
    let Some(last) = text.chars().next_back() else { return "" };
    let in_word = |c: char| c.is_alphanumeric() || c == '_';
    let in_sign = |c: char| "+-*/^<>=!.".contains(c);
    let start = if in_word(last) {
        text.char_indices().rev().find(|(_, c)| !in_word(*c))
    } else if in_sign(last) {
        text.char_indices().rev().find(|(_, c)| !in_sign(*c))
    } else {
        return &text[text.len() - last.len_utf8()..];
    };
    &text[start.map_or(0, |(at, c)| at + c.len_utf8())..]
}

pub(super) fn too_many_operators(span: Span, count: usize) -> Diagnostic {
    let limit = super::values::MAX_OPERATORS;
    Diagnostic::new(Code::E0121, format!("{count} operators in one expression, at most {limit} are read"))
        .label(span, "this expression")
        .help("name parts of it with `let`")
}

pub(super) fn tuple_length(span: Span, count: usize) -> Diagnostic {
    Diagnostic::new(Code::E0127, format!("a place of {count} coordinates, it has 2 or 3"))
        .label(span, "this")
        .help("write `(x, y)` or `(x, y, z)` for a place, and `[a, b, c, d]` for a list")
}

pub(super) fn number_too_large(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0116, "a number beyond 1.8e308")
        .label(span, "no quantity is as large as this")
        .help("write the number with a unit of the right size, such as `5 km`")
}

pub(super) fn text_hole(span: Span, source: &str) -> Diagnostic {
    let title = if source.trim().is_empty() {
        "nothing in the braces of a string"
    } else {
        "no value in the braces of a string"
    };
    Diagnostic::new(Code::E0126, title)
        .label(span, "braces in a string hold a value")
        .help("write a value, as in `\"line{2*i}\"`, or `{{` for a brace")
}

pub(super) fn bad_row(span: Span, row: &str) -> Diagnostic {
    Diagnostic::new(Code::E0128, "a line of a table that is no row")
        .label(span, "expected values with `|` between them")
        .help(format!("a row is one line, such as `D1 | 92 | 31`; this is `{}`", quote(row.trim_end())))
}

pub(super) fn bad_header(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0128, "a table without a header")
        .label(span, "expected the names of the columns")
        .help("a table begins with its columns and their units, such as `robot | snap_down [V] | speed [um/s]`")
}

pub(super) fn row_length(span: Span, count: usize, columns: &[Column]) -> Diagnostic {
    let names: Vec<&str> = columns.iter().map(|column| column.name.text.as_str()).collect();
    let help = match names.get(count) {
        Some(missing) => format!("the value for `{missing}` is missing"),
        None => format!("the columns are `{}`", quote(&names.join(" | "))),
    };
    Diagnostic::new(Code::E0117, format!("a row of {count} cells in a table of {} columns", names.len()))
        .label(span, "every row fills every column")
        .help(help)
}

pub(super) fn object_without_name(noun: &Ident) -> Diagnostic {
    Diagnostic::new(Code::E0110, format!("this `{}` has no name", noun.text))
        .label(noun.span, "a name belongs behind this")
        .help(format!("write `{} NAME at …`", noun.text))
}

pub(super) fn loop_at_top(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0101, "`for` outside of a block")
        .label(part(span, span.start as usize, span.start as usize + 3), "nothing here can be repeated")
        .help("`for` stands inside a scene, a task, a program or a wiring")
}

pub(super) fn bad_head(rest: Span, rule: Rule, item: Span, text: &str) -> Diagnostic {
    let form = match rule {
        Rule::device_rest => "device NAME : KIND { … }",
        Rule::scene_rest => "scene NAME { … }` or `scene NAME : SCENE { … }",
        Rule::task_rest => "task NAME on DEVICE in SCENE { … }",
        Rule::program_rest => "program NAME { … }",
        _ => "wiring DEVICE { … }",
    };
    let end = rest.start as usize + text[rest.range()].trim_end().len();
    let start = end - text[rest.start as usize..end].trim_start().len();
    let word = token_at(text, item.start as usize);
    Diagnostic::new(Code::E0124, format!("this `{word}` does not say what it is about"))
        .label(part(rest, start, end), "expected otherwise here")
        .help(format!("write `{form}`"))
}
