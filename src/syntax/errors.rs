//! Diagnostics of the parser: one function per mistake.

use super::context::{
    after, blanks_end, code_end_before, first_word, line_after, line_before, line_part, part, quote, token_at,
    token_before, token_before_sign, value_in, visible, with_blanks,
};
use super::grammar::Rule;
use super::tree::{Column, Ident};
use super::words::{is_invisible, is_name, is_word, starts_item};
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

/// Sort of block that a list of entries belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum ListPlace {
    Fields,
    Scene,
    Steps,
    Wires,
}

impl ListPlace {
    /// The entries that the list takes, with an example.
    pub fn wants(self) -> &'static str {
        match self {
            ListPlace::Fields => "a field, such as `left: 5`",
            ListPlace::Scene => "an object, such as `obstacle dust at (12, 7)`",
            ListPlace::Steps => "a step or a setting, such as `move to (19, 28)`",
            ListPlace::Wires => "a wire, such as `bl0.set -> \"Dev1/port0/line0\"`",
        }
    }
}

pub(super) fn late_brace(mark: Span, text: &str) -> Diagnostic {
    let brace = mark.end as usize;
    let end = code_end_before(text, brace);
    let line = quote(line_before(text, end));
    Diagnostic::new(Code::E0105, "`{` on a line of its own")
        .label(part(mark, brace, brace + 1), "this opens the block of the line above")
        .help(format!("write it at the end of that line: `{line} {{`"))
        .with_fix(part(mark, end, end), " {")
        .with_fix(line_part(mark, brace, brace + 1, text), "")
}

pub(super) fn leading_operator(mark: Span, text: &str) -> Diagnostic {
    let start = mark.end as usize;
    let operator = token_at(text, start);
    let end = code_end_before(text, start);
    let line = quote(line_before(text, end));
    Diagnostic::new(Code::E0106, format!("a line begins with `{operator}`"))
        .label(part(mark, start, start + operator.len()), "the value of the line above was complete without this")
        .help(format!(
            "a line continues after an operator, not before one: end the line above with `{line} {operator}`"
        ))
        .with_fix(part(mark, end, end), format!(" {operator}"))
        .with_fix(part(mark, start, blanks_end(text, start + operator.len())), "")
}

pub(super) fn leading_preposition(mark: Span, text: &str) -> Diagnostic {
    let start = mark.end as usize;
    let word = token_at(text, start);
    let end = code_end_before(text, start);
    let line = line_before(text, end);
    let joined = quote(&format!("{line} {}", line_after(text, start)));
    let finding = Diagnostic::new(Code::E0107, format!("a line begins with `{word}`"))
        .label(part(mark, start, start + word.len()), "this belongs to the line above")
        .help(format!("write the step on one line: `{joined}`"));
    // Joining the lines would let a comment between them swallow the rest of the step.
    if text[end..start].trim().is_empty() { finding.with_fix(part(mark, end, start), " ") } else { finding }
}

pub(super) fn blank_before_bracket(mark: Span, text: &str) -> Diagnostic {
    let start = code_end_before(text, mark.start as usize);
    let name = token_before(text, start);
    let bracket = token_at(text, mark.end as usize);
    let place = part(mark, mark.start as usize, mark.end as usize + 1);
    Diagnostic::new(Code::E0108, format!("a space between `{name}` and `{bracket}`"))
        .label(place, "expected no space here")
        .help(format!("write `{name}{bracket}…`: an index or an argument follows its name directly"))
        .with_fix(part(mark, start, mark.end as usize), "")
}

pub(super) fn wrong_colon(mark: Span, text: &str) -> Diagnostic {
    let sign = &text[mark.range()];
    let name = token_before(text, mark.start as usize);
    Diagnostic::new(Code::E0119, format!("`{sign}` where `:` belongs"))
        .label(mark, "`:` goes between a name and its value")
        .help(format!("write `{name}: {}`", quote(value_in(line_after(text, mark.end as usize)))))
        .with_fix(with_blanks(mark, text), ": ")
}

pub(super) fn wrong_equals(mark: Span, text: &str) -> Diagnostic {
    let sign = &text[mark.range()];
    let name = token_before(text, mark.start as usize);
    Diagnostic::new(Code::E0119, format!("`{sign}` where `=` belongs"))
        .label(mark, "`let` takes `=`")
        .help(format!("write `let {name} = {}`", quote(line_after(text, mark.end as usize))))
        .with_fix(with_blanks(mark, text), " = ")
}

pub(super) fn joined(mark: Span, text: &str) -> Diagnostic {
    let start = mark.end as usize;
    let word = token_at(text, start);
    let end = text[..start].trim_end_matches([' ', '\t']).len();
    let is_item = starts_item(after(text, start));
    Diagnostic::new(Code::E0103, format!("`{word}` begins anew on the same line"))
        .label(part(mark, start, start + word.len()), "what comes before this is complete")
        .help(format!("put a comma or a line end before `{word}`"))
        .with_fix(part(mark, end, start), if is_item { "\n" } else { ", " })
}

pub(super) fn reserved_name(name: &Ident) -> Diagnostic {
    Diagnostic::new(Code::E0110, format!("`{}` is a reserved word", name.text))
        .label(name.span, "expected a name")
        .help(format!("use another name, such as `{}_1`", name.text))
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
        .label(part(at, start, end), "expected a value after this")
        .help("write a number with its unit, such as `35 um`, a place, such as `(4 um, 2 um)`, or a name")
}

pub(super) fn too_many_operators(span: Span, count: usize) -> Diagnostic {
    let limit = super::MAX_OPERATORS;
    Diagnostic::new(Code::E0121, format!("{count} operators in one expression; the limit is {limit}"))
        .label(span, "this expression")
        .help("name parts of it with `let`")
}

pub(super) fn tuple_length(span: Span, count: usize) -> Diagnostic {
    Diagnostic::new(Code::E0127, format!("a place has 2 or 3 coordinates, not {count}"))
        .label(span, "this")
        .help("write `(x, y)` or `(x, y, z)` for a place, and `[a, b, c, d]` for a list")
}

pub(super) fn number_too_large(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0116, "a number above 1.8e308")
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

pub(super) fn bad_row(span: Span, text: &str) -> Diagnostic {
    let row = text[span.range()].trim_end();
    Diagnostic::new(Code::E0128, "a line of a table that is not a row")
        .label(span, "expected values with `|` between them")
        .help(format!("a row is one line, such as `D1 | 92 | 31`; this is `{}`", quote(row)))
}

pub(super) fn bar_before_row(span: Span) -> Diagnostic {
    let mark = first_word(span, 1);
    Diagnostic::new(Code::E0128, "a row that begins with `|`")
        .label(mark, "`|` goes between values")
        .help("remove it: a row is one line, such as `D1 | 92 | 31`")
        .with_fix(mark, "")
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
        .help("`for` belongs inside a scene, a task, a program or a wiring")
}

pub(super) fn bad_head(rest: Span, rule: Rule, item: Span, text: &str) -> Diagnostic {
    let form = match rule {
        Rule::device_rest => "device NAME : KIND { … }",
        Rule::instrument_rest => "instrument NAME : FAMILY { … }",
        Rule::output_rest => "output NAME : trigger { … }` or `output NAME : digital { … }",
        Rule::scene_rest => "scene NAME { … }` or `scene NAME : SCENE { … }",
        Rule::task_rest => "task NAME on DEVICE in SCENE { … }",
        Rule::program_rest => "program NAME { … }",
        _ => "wiring DEVICE { … }",
    };
    let place = visible(rest, text);
    let word = token_at(text, item.start as usize);
    Diagnostic::new(Code::E0124, format!("the head of this `{word}` is incomplete"))
        .label(place, "reading stopped here")
        .help(format!("write `{form}`"))
}

pub(super) fn name_too_long(span: Span, bytes: usize, limit: usize) -> Diagnostic {
    Diagnostic::new(Code::E0129, format!("a name of {bytes} bytes; the limit is {limit}"))
        .label(span, "too long")
        .help("give it a shorter name")
}

pub(super) fn too_deep(span: Span) -> Diagnostic {
    let limit = super::MAX_NESTING;
    Diagnostic::new(Code::E0120, format!("brackets or blocks nested more than {limit} levels deep"))
        .label(span, format!("this is level {}", limit + 1))
        .help("name the inner parts with `let`")
}

pub(super) fn stray_bracket(span: Span, text: &str) -> Diagnostic {
    let bracket = &text[span.range()];
    Diagnostic::new(Code::E0112, format!("`{bracket}` closes nothing"))
        .label(span, "no bracket is open here")
        .help("remove it, or write the bracket that it should close")
}

pub(super) fn unclosed_bracket(span: Span, text: &str, closing: u8) -> Diagnostic {
    let (bracket, closing) = (&text[span.range()], closing as char);
    Diagnostic::new(Code::E0114, format!("`{bracket}` is not closed"))
        .label(span, "opened here")
        .help(format!("write `{closing}` after its contents; without it, the end of the line closes the bracket"))
}

pub(super) fn unclosed_brace(span: Span, text: &str, item: Option<Span>) -> Diagnostic {
    let opener = quote(line_before(text, span.end as usize));
    let finding = Diagnostic::new(Code::E0113, "`{` is not closed").label(span, "opened here");
    match item {
        Some(item) => {
            let word = token_at(text, item.start as usize);
            finding
                .label(part(item, item.start as usize, item.start as usize + word.len()), "assumed closed before this")
                .help(format!("write `}}` where the block `{opener}` ends"))
        }
        None => finding.help(format!("write `}}` where the block `{opener}` ends; the file ends without it")),
    }
}

pub(super) fn unterminated_string(span: Span, text: &str) -> Diagnostic {
    let written = quote(&text[span.range()]);
    Diagnostic::new(Code::E0115, "a string does not end on its line")
        .label(span, "opened here")
        .help(format!("close it: `{written}\"`"))
        .with_fix(span.after(), "\"")
}

pub(super) fn open_text_hole(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0126, "a brace in a string is not closed")
        .label(span, "this opens a value")
        .help("write `{{` for a brace, or close the value with `}`")
}

/// A block comment; `ends_line` is whether nothing follows it on its last line.
pub(super) fn block_comment(span: Span, comment: &str, ends_line: bool) -> Diagnostic {
    let words = comment.trim_start_matches("/*").trim_end_matches("*/").trim();
    let first = words.lines().next().unwrap_or("").trim();
    let written = format!("// {}", quote(first));
    let help = match ends_line {
        true => format!("write `{written}`"),
        false => format!("write `{written}` on a line of its own, above this one"),
    };
    let finding = Diagnostic::new(Code::E0125, "a comment in `/* */`")
        .label(span, "comments begin with `//` and end at the end of the line")
        .help(help);
    if !ends_line || !comment.ends_with("*/") || comment.len() < "/**/".len() {
        return finding;
    }
    let at = |offset: usize| span.start as usize + offset;
    let body = comment.len() - "*/".len();
    let mut finding = finding.with_fix(part(span, at(0), at(2)), "//");
    for (line, _) in comment[..body].match_indices('\n') {
        let start = blanks_end(comment, line + 1);
        // A star at the beginning of a line is decoration of the comment.
        let star = usize::from(comment[start..body].starts_with('*'));
        let gap = if star == 0 && start < body { "// " } else { "//" };
        finding = finding.with_fix(part(span, at(start), at(start + star)), gap);
    }
    finding.with_fix(part(span, at(body), at(comment.len())), "")
}

pub(super) fn foreign_comment(span: Span, comment: &str) -> Diagnostic {
    let mark = comment.chars().next().unwrap_or('#');
    let words = comment.trim_start_matches(mark);
    Diagnostic::new(Code::E0125, format!("a comment that begins with `{mark}`"))
        .label(span, "comments begin with `//`")
        .help(format!("write `// {}`", quote(words.trim())))
        .with_fix(
            first_word(span, comment.len() - words.len()),
            if words.starts_with([' ', '\t']) { "//" } else { "// " },
        )
}

/// A `;`; `fix` is the replacement.
pub(super) fn semicolon(span: Span, fix: &str) -> Diagnostic {
    let help = match fix {
        "," => "write a comma: it is the only separator inside brackets",
        _ => "remove it: a field, a step or a declaration ends at the end of the line or at a comma",
    };
    Diagnostic::new(Code::E0104, "a `;`").label(span, "not a separator").help(help).with_fix_here(fix)
}

pub(super) fn foreign_sign(span: Span, theirs: char, ours: &str) -> Diagnostic {
    let (title, help) = match ours {
        " " => ("a non-breaking space".to_owned(), "write an ordinary space".to_owned()),
        _ => (format!("`{theirs}` is not part of the language"), format!("write `{ours}`")),
    };
    Diagnostic::new(Code::E0118, title).label(span, "this character").help(help).with_fix_here(ours)
}

pub(super) fn foreign_signs(span: Span, theirs: &str, ours: &str) -> Diagnostic {
    Diagnostic::new(Code::E0118, format!("`{theirs}` is not part of the language"))
        .label(span, "from another language")
        .help(format!("write `{ours}`"))
        .with_fix_here(ours)
}

pub(super) fn foreign_quotes(span: Span, inside: &str) -> Diagnostic {
    Diagnostic::new(Code::E0118, "quotation marks that are not part of the language")
        .label(span, "write strings in plain double quotes")
        .help(format!("write `\"{}\"`", quote(inside)))
        .with_fix_here(format!("\"{inside}\""))
}

pub(super) fn transpose(mark: Span) -> Diagnostic {
    Diagnostic::new(Code::E0118, "`'` is not part of the language")
        .label(mark, "from another language")
        .help("remove it: lists are neither rows nor columns")
        .with_fix_here("")
}

/// A quoted field name, as in `'right': 5`.
pub(super) fn quoted_name(span: Span, name: &str) -> Diagnostic {
    Diagnostic::new(Code::E0118, format!("quotes around the name `{name}`"))
        .label(span, "names are written without quotes")
        .help(format!("write `{name}`"))
        .with_fix_here(name)
}

pub(super) fn foreign_character(span: Span, text: &str) -> Diagnostic {
    let written = &text[span.range()];
    let help = match written.chars().next() {
        Some('°') => "write `deg`, as in `80 deg`",
        Some('±') => "remove it: a figure of this kind already applies in both directions",
        Some('&') => "write a separate `require` line for each condition",
        Some('\\') if text[span.end as usize..].starts_with('"') => {
            "strings have no escape sequences: use single quotes inside, as in `\"the 'blue' chip\"`"
        }
        Some('\\') => "a line continues after an operator or inside brackets, without a marker",
        _ => "remove it: names consist of letters, digits and `_`",
    };
    let fix = match written {
        "°" => Some(" deg"),
        "±" => Some(""),
        _ => None,
    };
    if written.chars().all(is_invisible) {
        let codes: Vec<String> = written.chars().take(3).map(|c| format!("U+{:04X}", c as u32)).collect();
        return Diagnostic::new(Code::E0118, format!("an invisible character, {}", codes.join(" ")))
            .label(span, "it is here")
            .help("remove it: such characters often come with text copied from a web page")
            .with_fix_here("");
    }
    let shown: String =
        written.chars().flat_map(|c| if is_invisible(c) { c.escape_unicode().collect() } else { vec![c] }).collect();
    let finding = Diagnostic::new(Code::E0118, format!("`{}` is not part of the language", quote(&shown)))
        .label(span, "this character")
        .help(help);
    match fix {
        Some(fix) => finding.with_fix_here(fix),
        None => finding,
    }
}

fn bad_number(span: Span, title: String, help: String) -> Diagnostic {
    Diagnostic::new(Code::E0116, title).label(span, "this number").help(help)
}

pub(super) fn bad_bits(span: Span, written: &str) -> Diagnostic {
    let is_word = written.starts_with("0b") || written.starts_with("0B");
    let help = if is_word {
        "a word consists of digits 0 and 1, one for each module, as in `0b10001_00010`"
    } else {
        "numbers are decimal, such as `35` or `1e-3`; words begin with `0b`"
    };
    bad_number(span, format!("`{}` is neither a number nor a word", quote(written)), help.to_owned())
}

pub(super) fn two_points(span: Span, written: &str) -> Diagnostic {
    let help = "a number has one decimal point, as in `1.5`; a range has two points together, as in `0..4`";
    bad_number(span, format!("`{}` has more than one decimal point", quote(written)), help.to_owned())
}

pub(super) fn bare_point(span: Span, written: &str) -> Diagnostic {
    let digits = quote(written.trim_end_matches('.'));
    bad_number(span, format!("`{}` ends with a point", quote(written)), format!("write `{digits}` or `{digits}.0`"))
        .with_fix_here(written.trim_end_matches('.'))
}

pub(super) fn bare_fraction(span: Span, written: &str) -> Diagnostic {
    bad_number(span, format!("`{}` begins with a point", quote(written)), format!("write `0{}`", quote(written)))
        .with_fix_here(format!("0{written}"))
}

pub(super) fn no_exponent(span: Span, written: &str) -> Diagnostic {
    let digits = written.trim_end_matches(['e', 'E', '+', '-']);
    let help = format!("write `{0}` or an exponent, such as `{0}e-3`", quote(digits));
    bad_number(span, format!("`{}` has an empty exponent", quote(written)), help)
}

pub(super) fn misplaced_doc(span: Span, text: &str) -> Diagnostic {
    let comment = &text[span.range()];
    let words = comment[3..].trim();
    let mark = first_word(span, 3);
    let before = line_before(text, span.start as usize);
    let finding = Diagnostic::new(Code::E0109, "a doc comment that documents nothing");
    if comment.starts_with("//!") {
        return finding
            .label(span, "`//!` documents the file and belongs at its top")
            .help(format!("write `// {}`, or move it to the top of the file", quote(words)))
            .with_fix(mark, "//");
    }
    if before.is_empty() {
        return finding
            .label(span, "no declaration, field or object follows")
            .help(format!("write `// {}`", quote(words)))
            .with_fix(mark, "//");
    }
    finding.label(span, "`///` documents the item after it, not before it").help(format!(
        "put it on a line of its own above `{}`, or write `// {}`",
        quote(before),
        quote(words)
    ))
}

pub(super) fn foreign_word(word: Span, text: &str) -> Diagnostic {
    let written = &text[word.range()];
    Diagnostic::new(Code::E0122, format!("`{written}` is not a word of the language"))
        .label(word, "from another language")
        .help(super::foreign_words::help(written).unwrap_or_default())
}

pub(super) fn let_in_block(span: Span, text: &str) -> Diagnostic {
    let line = text.lines().next().unwrap_or("");
    Diagnostic::new(Code::E0123, "`let` inside a block")
        .label(first_word(span, "let".len()), "`let` belongs at the top level of a file")
        .help(format!("move `{}` out of the braces", quote(line.trim_end())))
}

pub(super) fn item_in_block(span: Span, word: &str) -> Diagnostic {
    Diagnostic::new(Code::E0123, format!("`{word}` inside a block"))
        .label(first_word(span, word.len()), "declarations belong at the top level of a file")
        .help(format!("move this `{word}` out of the braces, or close the block above it with `}}`"))
}

pub(super) fn lonely_preposition(span: Span, word: &str) -> Diagnostic {
    Diagnostic::new(Code::E0107, format!("a line begins with `{word}`"))
        .label(first_word(span, word.len()), "there is no step before this that it could belong to")
        .help(format!("begin with the step's verb, as in `move {word} …`"))
}

pub(super) fn lonely_operator(span: Span, word: &str) -> Diagnostic {
    Diagnostic::new(Code::E0106, format!("a line begins with `{word}`"))
        .label(first_word(span, word.len()), "nothing here begins with an operator")
        .help("a line continues after an operator: end the line above with it")
}

pub(super) fn missing_colon(span: Span, name: &str, text: &str) -> Diagnostic {
    let value = text[name.len()..].lines().next().unwrap_or("").trim();
    Diagnostic::new(Code::E0119, format!("`:` is missing after `{name}`"))
        .label(first_word(span, name.len()), "a field takes `:` before its value")
        .help(format!("write `{name}: {}`", quote(value)))
        .with_fix(first_word(span, name.len()).after(), ":")
}

pub(super) fn not_an_entry(span: Span, place: ListPlace, text: &str) -> Diagnostic {
    let line = text[span.range()].lines().next().unwrap_or("");
    Diagnostic::new(Code::E0101, format!("`{}` does not belong here", quote(line)))
        .label(part(span, span.start as usize, span.start as usize + line.len()), "this could not be read")
        .help(format!("expected {}", place.wants()))
}

pub(super) fn bad_short_item(rest: Span, rule: Rule, text: &str) -> Diagnostic {
    let finding = Diagnostic::new(Code::E0124, "this declaration cannot be read completely")
        .label(visible(rest, text), "reading stopped here");
    if rule == Rule::use_rest {
        return finding.help("write it as `use std.dimibot` or `use \"bench.twz\" as lab`");
    }
    // `let s = [(1, 1) (2, 2)]`
    let before = code_end_before(text, rest.start as usize);
    let opens = |line: &str| line.matches(['[', '(']).count() > line.matches([']', ')']).count();
    if rule == Rule::let_rest && text[..before].ends_with([')', ']', '"']) && opens(line_before(text, before)) {
        let behind = part(rest, before, before);
        let token = token_at(text, rest.start as usize);
        return Diagnostic::new(Code::E0103, format!("a comma is missing before `{}`", quote(token)))
            .label(visible(rest, text), "the value before this is complete")
            .help("separate the values of a list with commas, as in `[(3, 9), (8, 3)]`")
            .with_fix(behind, ",");
    }
    // `let n 3`
    let (line, at) = (line_before(text, rest.start as usize), rest.start as usize);
    let value = line_after(text, at).trim_start_matches('=').trim();
    // Several words in a row are not a value.
    let is_value = is_name(value) || !value.starts_with(|c: char| c.is_alphabetic());
    match line.strip_prefix("let ").map(str::trim) {
        Some(name) if is_name(name) && is_value => {
            finding.help(format!("write `let {name} = {}`", quote(value))).with_fix(part(rest, at, at), "= ")
        }
        Some(_) | None => finding.help("write it as `let pitch = 70 um`"),
    }
}

pub(super) fn misspelt_item(span: Span, text: &str, right: &str) -> Diagnostic {
    let word = token_at(text, 0);
    let line = text.lines().next().unwrap_or("").trim_end();
    Diagnostic::new(Code::E0111, format!("no declaration begins with `{word}`"))
        .label(first_word(span, word.len()), format!("did you mean `{right}`?"))
        .help(format!("write `{right}{}`", quote(&line[word.len()..])))
        .with_fix_here(right)
}

const ITEM_WORDS: &str = "`use`, `let`, `device`, `instrument`, `output`, `scene`, `task`, `program` or `wiring`";

pub(super) fn unknown_item(span: Span, text: &str) -> Diagnostic {
    let word = token_at(text, 0);
    Diagnostic::new(Code::E0111, format!("no declaration begins with `{word}`"))
        .label(first_word(span, word.len()), "unknown here")
        .help(format!("a declaration begins with {ITEM_WORDS}"))
}

pub(super) fn value_without_let(span: Span, text: &str) -> Diagnostic {
    let line = text.lines().next().unwrap_or("").trim_end();
    let word = token_at(text, 0);
    let value = line[word.len()..].trim_start_matches([' ', '\t', ':', '=']);
    let start = span.start as usize;
    if let Some(noun) = declared_with_braces(value) {
        return Diagnostic::new(Code::E0111, format!("`{word}` is declared without its keyword"))
            .label(first_word(span, word.len()), "a declaration begins with its keyword")
            .help(format!("write `{noun} {word} : {}`", quote(value)))
            .with_fix(part(span, start, start), format!("{noun} "))
            .with_fix(part(span, start + word.len(), start + (line.len() - value.len())), " : ");
    }
    Diagnostic::new(Code::E0111, format!("`{word}` is given a value without `let`"))
        .label(first_word(span, word.len()), "a declaration begins with its keyword")
        .help(format!("write `let {word} = {}`", quote(value)))
        .with_fix(part(span, start, start), "let ")
        .with_fix(part(span, start + word.len(), start + (line.len() - value.len())), " = ")
}

/// The noun of a declaration whose kind and fields were written as a value: `dimibot.femto_st { … }`.
fn declared_with_braces(value: &str) -> Option<&'static str> {
    let kind = value.split('{').next().filter(|kind| kind.len() < value.len())?.trim();
    // A single word before braces may be a shape, which is a value.
    let is_kind =
        kind.starts_with(char::is_alphabetic) && kind.contains('.') && kind.chars().all(|c| is_word(c) || c == '.');
    let is_instrument = kind.split('.').any(|part| part == "instruments");
    is_kind.then_some(if is_instrument { "instrument" } else { "device" })
}

pub(super) fn not_an_item(span: Span, text: &str) -> Diagnostic {
    let line = text.lines().next().unwrap_or("").trim_end();
    Diagnostic::new(Code::E0101, format!("`{}` is outside of every block", quote(line)))
        .label(first_word(span, line.len()), "expected a declaration")
        .help(format!("a declaration begins with {ITEM_WORDS}; steps belong in a task, objects in a scene"))
}

pub(super) fn unreadable(whole: Span) -> Diagnostic {
    Diagnostic::new(Code::E0120, "this file is nested too deeply to be read")
        .label(whole, "the whole file")
        .help("name the inner parts with `let`")
}

pub(super) fn not_a_value(whole: Span, text: &str) -> Diagnostic {
    Diagnostic::new(Code::E0102, format!("`{}` is not a value", quote(text)))
        .label(whole, "expected a value")
        .help("write a number with its unit, such as `80um`, a place, such as `(4 um, 2 um)`, or a list")
}
