//! Words, numbers, strings and signs: their valid forms, and the diagnostics of invalid ones.

use super::errors;
use super::scan::{MAX_NESTING, Scan};
use super::slips;

/// Whether a character may stand in a name.
pub(crate) fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_' || (!c.is_ascii() && c.is_alphabetic())
}

/// Where the run of name characters at an offset ends.
pub(super) fn end_of_word(text: &str, at: usize) -> usize {
    text[at..].find(|c| !is_word(c)).map_or(text.len(), |length| at + length)
}

/// Greatest number of bytes of a name: it is repeated in every channel, file and message that uses it.
pub const MAX_NAME_BYTES: usize = 200;

/// A name or a word of the language.
pub(super) fn word(scan: &mut Scan) {
    let (start, end) = (scan.at, end_of_word(scan.text, scan.at));
    scan.at = end;
    if end - start > MAX_NAME_BYTES {
        let span = scan.span(start, end);
        scan.report(errors::name_too_long(span, end - start, MAX_NAME_BYTES));
        scan.cover(start, end);
    }
}

fn end_of_digits(text: &str, at: usize) -> usize {
    text[at..].find(|c: char| !c.is_ascii_digit() && c != '_').map_or(text.len(), |length| at + length)
}

fn is_digit_at(text: &str, at: usize) -> bool {
    text.as_bytes().get(at).is_some_and(u8::is_ascii_digit)
}

/// `/* … */`, which is blank to the grammar.
pub(super) fn block_comment(scan: &mut Scan) {
    let start = scan.at;
    let end = scan.rest().find("*/").map_or_else(|| scan.end_of_line(), |length| start + length + 2);
    let span = scan.span(start, start + 2);
    scan.report(errors::block_comment(span, &scan.text[start..end]));
    let mut line = start;
    while let Some(length) = scan.text[line..end].find('\n') {
        scan.replace(line, line + length, "");
        scan.at = line + length;
        scan.newline();
        line = scan.at;
    }
    scan.replace(line, end, "");
    scan.at = end;
}

/// `# …` or `% …`, which is blank to the grammar.
pub(super) fn foreign_comment(scan: &mut Scan) {
    let (start, end) = (scan.at, scan.end_of_line());
    let span = scan.span(start, start + 1);
    scan.report(errors::foreign_comment(span, &scan.text[start..end]));
    scan.replace(start, end, "");
    scan.at = end;
}

/// A string up to its closing quote, which must stand on the same line.
pub(super) fn string(scan: &mut Scan) {
    let start = scan.at;
    let line_end = scan.end_of_line();
    let Some(length) = scan.text[start + 1..line_end].find('"') else {
        let mut end = start + scan.text[start..line_end].trim_end().len();
        if scan.text[start..end].ends_with(" }") && scan.brackets.opened_after(scan.line_start) {
            end = start + scan.text[start..end - 1].trim_end().len();
        }
        let span = scan.span(start, end);
        scan.report(errors::unterminated_string(span, scan.text));
        scan.cover(start, end);
        scan.at = end;
        return;
    };
    let end = start + length + 2;
    scan.at = end;
    if let Some(brace) = open_hole(&scan.text[start + 1..end - 1]) {
        let span = scan.span(start + 1 + brace, start + 2 + brace);
        scan.report(errors::open_text_hole(span));
        scan.cover(start, end);
    } else if scan.text[start..end].bytes().filter(|byte| matches!(byte, b'(' | b'[')).count() > MAX_NESTING {
        let span = scan.span(start, start + 1);
        scan.report(errors::too_deep(span));
        scan.cover(start, end);
    }
}

/// Where a brace of a string's inside opens and does not close.
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

/// A number or a word `0b…`; a unit may be glued to it.
pub(super) fn number(scan: &mut Scan) {
    let (text, start) = (scan.text, scan.at);
    let word = &text[start..end_of_word(text, start)];
    if word.len() > 1 && matches!(word.as_bytes()[..2], [b'0', b'b' | b'B' | b'x' | b'X' | b'o' | b'O']) {
        let end = start + word.len();
        scan.at = end;
        let is_sound = word.starts_with("0b")
            && word[2..].bytes().all(|byte| matches!(byte, b'0' | b'1' | b'_'))
            && word[2..].contains(['0', '1']);
        if !is_sound {
            bad_number(scan, start, end, errors::bad_bits);
        }
        return;
    }
    let mut end = end_of_digits(text, start);
    if text[end..].starts_with('.') && is_digit_at(text, end + 1) {
        end = end_of_digits(text, end + 1);
        if text[end..].starts_with('.') && is_digit_at(text, end + 1) {
            let tail = text[end..].find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len() - end);
            return bad_number(scan, start, end + tail, errors::two_points);
        }
    } else if text[end..].starts_with('.') && !text[end + 1..].starts_with('.') {
        return bad_number(scan, start, end + 1, errors::bare_point);
    }
    if text[end..].starts_with(['e', 'E']) {
        let sign = usize::from(text[end + 1..].starts_with(['+', '-']));
        if is_digit_at(text, end + 1 + sign) {
            end = end_of_digits(text, end + 1 + sign);
        } else if sign == 1 || end_of_word(text, end) == end + 1 {
            return bad_number(scan, start, end + 1 + sign, errors::no_exponent);
        }
    }
    scan.at = end;
    decimal_comma(scan, start);
}

/// `0,8` where no list stands, read as 0.8.
fn decimal_comma(scan: &mut Scan, start: usize) {
    let (text, comma) = (scan.text, scan.at);
    if !scan.brackets.takes_entries() || !text[comma..].starts_with(',') || !is_digit_at(text, comma + 1) {
        return;
    }
    let end = end_of_digits(text, comma + 1);
    let written = &text[start..end];
    if written.bytes().all(|byte| byte.is_ascii_digit() || byte == b',') && !text[end..].starts_with([',', '.']) {
        let span = scan.span(start, end);
        if end - comma == 4 && !written.starts_with('0') {
            scan.report(slips::thousands_comma(span, written));
            scan.cover(start, end);
            scan.at = end;
            return;
        }
        scan.report(slips::decimal_comma(span, written));
        scan.replace(start, end, &written.replacen(',', ".", 1));
        scan.at = end;
    }
}

fn bad_number(
    scan: &mut Scan,
    start: usize,
    end: usize,
    finding: fn(crate::source::Span, &str) -> crate::diagnostic::Diagnostic,
) {
    let span = scan.span(start, end);
    scan.report(finding(span, &scan.text[start..end]));
    scan.cover(start, end);
    scan.at = end;
}

/// Whether `.5` stands here, and not a point between names or numbers.
pub(super) fn is_bare_fraction(scan: &Scan) -> bool {
    let before = scan.text[..scan.at].chars().next_back();
    is_digit_at(scan.text, scan.at + 1) && !before.is_some_and(|c| is_word(c) || matches!(c, ']' | ')' | '.'))
}

/// `.5`.
pub(super) fn bare_fraction(scan: &mut Scan) {
    let start = scan.at;
    let end = end_of_digits(scan.text, start + 1);
    bad_number(scan, start, end, errors::bare_fraction);
}

/// `;`: at a line's end it is blank to the grammar, elsewhere a comma.
pub(super) fn semicolon(scan: &mut Scan) {
    let start = scan.at;
    let rest = scan.text[start + 1..scan.end_of_line()].trim_start();
    let is_last = rest.is_empty() || rest.starts_with("//") || rest.starts_with('}');
    let span = scan.span(start, start + 1);
    scan.report(errors::semicolon(span));
    scan.replace(start, start + 1, if is_last { "" } else { "," });
    scan.at += 1;
}

/// Signs that people write for ours, and ours.
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

/// A sign; one that the language does not have is replaced by Tweeze's or covered.
pub(super) fn sign(scan: &mut Scan, first: char) {
    let start = scan.at;
    let end = start + first.len_utf8();
    scan.at = end;
    if matches!(first, ',' | ':' | '.' | '=' | '<' | '>' | '+' | '-' | '*' | '/' | '^' | '|' | '%') {
        return;
    }
    if scan.text[start..].starts_with("!=") {
        scan.at += 1;
        return;
    }
    if let Some((_, ours)) = SPELLINGS.iter().find(|(theirs, _)| *theirs == first) {
        let span = scan.span(start, end);
        scan.report(errors::foreign_sign(span, first, ours));
        scan.replace(start, end, ours);
        return;
    }
    if is_quote(first) {
        return quoted(scan, start, end);
    }
    let is_strange = |c: char| !c.is_whitespace() && !is_word(c) && !",:.=<>+-*/^|%()[]{}\"#;".contains(c);
    let end = scan.text[end..].find(|c| !is_strange(c)).map_or(scan.text.len(), |length| end + length);
    scan.at = end;
    let span = scan.span(start, end);
    scan.report(errors::foreign_character(span, scan.text));
    scan.cover(start, end);
}

fn is_quote(c: char) -> bool {
    matches!(c, '“' | '”' | '„' | '‘' | '’' | '\'' | '«' | '»' | '`')
}

/// A string in other quotes; the grammar reads it in ours.
fn quoted(scan: &mut Scan, start: usize, inside: usize) {
    let line_end = scan.end_of_line();
    let rest = &scan.text[inside..line_end];
    let close = rest.char_indices().find(|(_, c)| is_quote(*c) || *c == '"');
    let (close, end) = close.map_or((line_end, line_end), |(at, c)| (inside + at, inside + at + c.len_utf8()));
    let span = scan.span(start, end);
    scan.report(errors::foreign_quotes(span, &scan.text[inside..close]));
    if close == end || scan.text[inside..close].contains('{') {
        scan.cover(start, end);
    } else {
        scan.replace(start, inside - 1, "");
        scan.replace(inside - 1, inside, "\"");
        scan.replace(close, end, "\"");
    }
    scan.at = end;
}
