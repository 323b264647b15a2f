//! Words, numbers, strings and signs: their valid forms, and diagnostics for invalid ones.

use super::cursor::Cursor;
use super::words::{end_of_word, is_name, is_word};
use super::{MAX_NESTING, errors, foreign_syntax, known_mistakes};

/// Greatest number of bytes in a name: every channel, file and message that uses a name repeats it.
pub const MAX_NAME_BYTES: usize = 200;

/// Scans a name or a word of the language.
pub(super) fn word(cursor: &mut Cursor) {
    let (start, end) = (cursor.at, end_of_word(cursor.text, cursor.at));
    cursor.at = end;
    if end - start > MAX_NAME_BYTES {
        let span = cursor.span(start, end);
        cursor.report(errors::name_too_long(span, end - start, MAX_NAME_BYTES));
        cursor.cover(start, end);
    }
    if cursor.text[start..end] == *"require"
        && let Some((words, sign)) = foreign_syntax::comparison(&cursor.text[end..cursor.end_of_line()])
    {
        let (from, to) = (end + words.start, end + words.end);
        let finding = foreign_syntax::comparison_in_words(cursor.span(from, to), start, sign, cursor.text);
        cursor.report(finding);
        cursor.replace(from, to, sign);
    }
}

fn end_of_digits(text: &str, at: usize) -> usize {
    text[at..].find(|c: char| !c.is_ascii_digit() && c != '_').map_or(text.len(), |length| at + length)
}

fn is_digit_at(text: &str, at: usize) -> bool {
    text.as_bytes().get(at).is_some_and(u8::is_ascii_digit)
}

/// Scans `/* … */`, which the grammar sees as spaces.
pub(super) fn block_comment(cursor: &mut Cursor) {
    let start = cursor.at;
    let end = cursor.rest().find("*/").map_or_else(|| cursor.end_of_line(), |length| start + length + 2);
    let span = cursor.span(start, start + 2);
    let ends_line = cursor.text[end..].lines().next().is_none_or(|rest| rest.trim().is_empty());
    cursor.report(errors::block_comment(span, &cursor.text[start..end], ends_line));
    let mut line = start;
    while let Some(length) = cursor.text[line..end].find('\n') {
        cursor.replace(line, line + length, "");
        cursor.at = line + length;
        cursor.newline();
        line = cursor.at;
    }
    cursor.replace(line, end, "");
    cursor.at = end;
}

/// Scans `# …` or `% …`, which the grammar sees as spaces.
pub(super) fn foreign_comment(cursor: &mut Cursor) {
    let (start, end) = (cursor.at, cursor.end_of_line());
    let span = cursor.span(start, start + 1);
    cursor.report(errors::foreign_comment(span, &cursor.text[start..end]));
    cursor.replace(start, end, "");
    cursor.at = end;
}

/// Scans a string up to its closing quote, which must be on the same line.
pub(super) fn string(cursor: &mut Cursor) {
    let start = cursor.at;
    let line_end = cursor.end_of_line();
    let Some(length) = cursor.text[start + 1..line_end].find('"') else {
        let mut end = start + cursor.text[start..line_end].trim_end().len();
        if cursor.text[start..end].ends_with(" }") && cursor.brackets.opened_after(cursor.line_start) {
            end = start + cursor.text[start..end - 1].trim_end().len();
        }
        let span = cursor.span(start, end);
        cursor.report(errors::unterminated_string(span, cursor.text));
        cursor.cover(start, end);
        cursor.at = end;
        return;
    };
    let end = start + length + 2;
    cursor.at = end;
    if let Some(brace) = open_hole(&cursor.text[start + 1..end - 1]) {
        let span = cursor.span(start + 1 + brace, start + 2 + brace);
        cursor.report(errors::open_text_hole(span));
        cursor.cover(start, end);
    } else if cursor.text[start..end].bytes().filter(|byte| matches!(byte, b'(' | b'[')).count() > MAX_NESTING {
        let span = cursor.span(start, start + 1);
        cursor.report(errors::too_deep(span));
        cursor.cover(start, end);
    }
}

/// Offset of a brace inside a string that opens and does not close.
fn open_hole(inside: &str) -> Option<usize> {
    let mut at = 0;
    while let Some(length) = inside[at..].find('{') {
        let brace = at + length;
        if inside[brace + 1..].starts_with('{') {
            at = brace + 2;
            continue;
        }
        match inside[brace..].find('}') {
            Some(length) => at = brace + length + 1,
            None => return Some(brace),
        }
    }
    None
}

/// Scans a number or a word `0b…`; a unit may follow without a space.
pub(super) fn number(cursor: &mut Cursor) {
    let (text, start) = (cursor.text, cursor.at);
    let word = &text[start..end_of_word(text, start)];
    if word.len() > 1 && matches!(word.as_bytes()[..2], [b'0', b'b' | b'B' | b'x' | b'X' | b'o' | b'O']) {
        let end = start + word.len();
        cursor.at = end;
        let is_sound = word.starts_with("0b")
            && word[2..].bytes().all(|byte| matches!(byte, b'0' | b'1' | b'_'))
            && word[2..].contains(['0', '1']);
        if !is_sound {
            bad_number(cursor, start, end, errors::bad_bits);
        }
        return;
    }
    let mut end = end_of_digits(text, start);
    if text[end..].starts_with('.') && is_digit_at(text, end + 1) {
        end = end_of_digits(text, end + 1);
        if text[end..].starts_with('.') && is_digit_at(text, end + 1) {
            let tail = text[end..].find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len() - end);
            return bad_number(cursor, start, end + tail, errors::two_points);
        }
    } else if text[end..].starts_with('.') && !text[end + 1..].starts_with('.') {
        return bad_number(cursor, start, end + 1, errors::bare_point);
    }
    if text[end..].starts_with(['e', 'E']) {
        let sign = usize::from(text[end + 1..].starts_with(['+', '-']));
        if is_digit_at(text, end + 1 + sign) {
            end = end_of_digits(text, end + 1 + sign);
        } else if sign == 1 || end_of_word(text, end) == end + 1 {
            return bad_number(cursor, start, end + 1 + sign, errors::no_exponent);
        }
    }
    cursor.at = end;
    decimal_comma(cursor, start);
}

/// Scans the rest of `0,8` outside lists, and reads it as 0.8.
fn decimal_comma(cursor: &mut Cursor, start: usize) {
    let (text, comma) = (cursor.text, cursor.at);
    if !cursor.brackets.takes_entries() || !text[comma..].starts_with(',') || !is_digit_at(text, comma + 1) {
        return;
    }
    let end = end_of_digits(text, comma + 1);
    let written = &text[start..end];
    if written.bytes().all(|byte| byte.is_ascii_digit() || byte == b',') && !text[end..].starts_with([',', '.']) {
        let span = cursor.span(start, end);
        if end - comma == 4 && !written.starts_with('0') {
            cursor.report(known_mistakes::thousands_comma(span, written));
            cursor.cover(start, end);
            cursor.at = end;
            return;
        }
        cursor.report(known_mistakes::decimal_comma(span, written));
        cursor.replace(start, end, &written.replacen(',', ".", 1));
        cursor.at = end;
    }
}

fn bad_number(
    cursor: &mut Cursor,
    start: usize,
    end: usize,
    finding: fn(crate::source::Span, &str) -> crate::diagnostic::Diagnostic,
) {
    let span = cursor.span(start, end);
    cursor.report(finding(span, &cursor.text[start..end]));
    cursor.cover(start, end);
    cursor.at = end;
}

/// Whether `.5` begins here, as opposed to a point between names or numbers.
pub(super) fn is_bare_fraction(cursor: &Cursor) -> bool {
    let before = cursor.text[..cursor.at].chars().next_back();
    is_digit_at(cursor.text, cursor.at + 1) && !before.is_some_and(|c| is_word(c) || matches!(c, ']' | ')' | '.'))
}

/// Scans `.5`.
pub(super) fn bare_fraction(cursor: &mut Cursor) {
    let start = cursor.at;
    let end = end_of_digits(cursor.text, start + 1);
    bad_number(cursor, start, end, errors::bare_fraction);
}

/// Scans `;`: the grammar sees it as a space at the end of a line and as a comma elsewhere.
pub(super) fn semicolon(cursor: &mut Cursor) {
    let start = cursor.at;
    let rest = cursor.text[start + 1..cursor.end_of_line()].trim_start();
    let is_last = rest.is_empty() || rest.starts_with("//") || rest.starts_with('}');
    let span = cursor.span(start, start + 1);
    let fix = match is_last {
        true => "",
        false if cursor.brackets.is_empty() => "\n",
        false => ",",
    };
    cursor.report(errors::semicolon(span, fix));
    cursor.replace(start, start + 1, if is_last { "" } else { "," });
    cursor.at += 1;
}

/// Degrees Celsius, as two characters or as one.
const DEGREES: &[&str] = &["°C", "℃"];

/// Lookalike characters and their equivalents in Tweeze.
const SPELLINGS: &[(char, &str)] = &[
    ('−', "-"),
    ('–', "-"),
    ('×', "*"),
    ('·', "*"),
    ('÷', "/"),
    ('≤', "<="),
    ('≥', ">="),
    ('≠', "!="),
    ('→', "->"),
    ('…', ".."),
    ('²', "^2"),
    ('³', "^3"),
    ('\u{a0}', " "),
];

/// Foreign signs of two characters and their equivalents in Tweeze.
const SIGN_PAIRS: &[(&str, &str)] = &[("**", "^"), ("~=", "!="), ("<>", "!=")];

/// Scans a sign; one that the language does not have is replaced by its equivalent or covered.
pub(super) fn sign(cursor: &mut Cursor, first: char) {
    let start = cursor.at;
    let end = start + first.len_utf8();
    cursor.at = end;
    if let Some((theirs, ours)) = SIGN_PAIRS.iter().find(|(theirs, _)| cursor.text[start..].starts_with(theirs)) {
        let end = start + theirs.len();
        cursor.at = end;
        let span = cursor.span(start, end);
        cursor.report(errors::foreign_signs(span, theirs, ours));
        cursor.replace(start, end, ours);
        return;
    }
    if matches!(first, ',' | ':' | '.' | '=' | '<' | '>' | '+' | '-' | '*' | '/' | '^' | '|' | '%') {
        return;
    }
    if cursor.text[start..].starts_with("!=") {
        cursor.at += 1;
        return;
    }
    if let Some((_, ours)) = SPELLINGS.iter().find(|(theirs, _)| *theirs == first) {
        let span = cursor.span(start, end);
        cursor.report(errors::foreign_sign(span, first, ours));
        cursor.replace(start, end, ours);
        return;
    }
    if is_quote(first) {
        return quoted(cursor, start, end);
    }
    if let Some(unit) = DEGREES.iter().find(|unit| cursor.text[start..].starts_with(**unit)) {
        cursor.at = start + unit.len();
        let span = cursor.span(start, cursor.at);
        cursor.report(errors::foreign_signs(span, unit, "degC"));
        // The unit is longer than the sign, so it also takes the space before it.
        match cursor.text[..start].ends_with(' ') {
            true => cursor.replace(start - 1, cursor.at, "degC"),
            false => cursor.cover(start, cursor.at),
        }
        return;
    }
    let is_strange = |c: char| !c.is_whitespace() && !is_word(c) && !",:.=<>+-*/^|%()[]{}\"#;".contains(c);
    let end = cursor.text[end..].find(|c| !is_strange(c)).map_or(cursor.text.len(), |length| end + length);
    cursor.at = end;
    let span = cursor.span(start, end);
    cursor.report(errors::foreign_character(span, cursor.text));
    cursor.cover(start, end);
}

pub(super) fn is_quote(c: char) -> bool {
    matches!(c, '“' | '”' | '„' | '‘' | '’' | '\'' | '«' | '»' | '`')
}

/// Scans a string in foreign quotes; the grammar reads it in double quotes.
fn quoted(cursor: &mut Cursor, start: usize, inside: usize) {
    let line_end = cursor.end_of_line();
    let rest = &cursor.text[inside..line_end];
    let close = rest.char_indices().find(|(_, c)| is_quote(*c) || *c == '"');
    let (close, end) = close.map_or((line_end, line_end), |(at, c)| (inside + at, inside + at + c.len_utf8()));
    let span = cursor.span(start, end);
    let is_transpose = close == end && cursor.text[start..inside] == *"'" && cursor.text[..start].ends_with([']', ')']);
    if is_transpose {
        let mark = cursor.span(start, inside);
        cursor.report(errors::transpose(mark));
        cursor.cover(start, inside);
        cursor.at = inside;
        return;
    }
    let name = &cursor.text[inside..close];
    if close < end && is_name(name) && cursor.text[end..].trim_start_matches([' ', '\t']).starts_with(':') {
        cursor.report(errors::quoted_name(span, name));
        cursor.replace(start, inside, "");
        cursor.replace(close, end, "");
        cursor.at = end;
        return;
    }
    cursor.report(errors::foreign_quotes(span, name));
    if close == end || cursor.text[inside..close].contains('{') {
        cursor.cover(start, end);
    } else {
        cursor.replace(start, inside - 1, "");
        cursor.replace(inside - 1, inside, "\"");
        cursor.replace(close, end, "\"");
    }
    cursor.at = end;
}
