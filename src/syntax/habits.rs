//! Habits of other languages that newcomers bring: each gets one diagnostic that says how the same is written here.

use super::around::{line_before, part, quote, token_at, with_blanks};
use super::words::is_word;
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

/// A step in the manner of another language, which could not be read.
pub(super) fn step(span: Span, source: &str) -> Option<Diagnostic> {
    let text = &source[span.range()];
    let head = token_at(text, 0);
    let rest = &text[head.len()..];
    let at = span.start as usize;
    if !head.starts_with(is_word) {
        return None;
    }
    if let Some(method) = rest.strip_prefix('.') {
        return method_call(span, head, method);
    }
    if head == "set" {
        let name = rest.trim_start();
        let name = &name[..name.len() - name.trim_start_matches(is_word).len()];
        let sign = at + text.find('=')?;
        let level = source[sign + 1..span.end as usize].trim_start_matches('=').trim();
        let sign = part(span, sign, sign + 1);
        return (!name.is_empty()).then(|| {
            Diagnostic::new(Code::E0119, "`=` where `to` belongs")
                .label(sign, "between an output and its level stands `to`")
                .help(format!("write `set {name} to {}`", quote(level)))
                .mended(with_blanks(sign, source), " to ")
        });
    }
    let argument = rest.strip_prefix('(')?.trim_start();
    let name = token_at(argument, 0);
    (name.starts_with(is_word) && argument[name.len()..].trim_start().starts_with('=')).then(|| {
        Diagnostic::new(Code::E0101, "a step in the manner of a call")
            .label(part(span, at, at + head.len() + 1), "steps have no brackets")
            .help("a step is a verb and prepositions, as in `move to (1, 2)`")
    })
}

/// `bot.move_to(1, 2)`, `time.sleep(0.5)`.
fn method_call(span: Span, object: &str, method: &str) -> Option<Diagnostic> {
    let name = token_at(method, 0);
    if !name.starts_with(is_word) || !method[name.len()..].starts_with('(') {
        return None;
    }
    let start = span.start as usize;
    let help = match name {
        "sleep" | "pause" | "wait" | "delay" => "write `wait` with a time and its unit, as in `wait 500 ms`",
        _ => "begin with the verb: the device of a task stands in its head, as in `task go on bot { move to (1, 2) }`",
    };
    let whole = part(span, start, start + object.len() + 1 + name.len());
    Some(Diagnostic::new(Code::E0101, "a step in the manner of a call").label(whole, "steps are no methods").help(help))
}

/// `for i = 0:4`, `for i in 0:4`: the range of a loop, in which the end is meant to be.
pub(super) fn colon_range(span: Span, source: &str) -> Option<Diagnostic> {
    let text = source[span.range()].lines().next()?;
    let name = text.strip_prefix("for")?.trim_start();
    let counter = token_at(name, 0);
    let rest = name[counter.len()..].trim_start();
    let range = rest.strip_prefix("in").or_else(|| rest.strip_prefix('='))?.trim_start();
    let digits = |text: &str| text.len() - text.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let (first, last) = range.split_once(':')?;
    let last = &last[..digits(last)];
    let end = last.parse::<u32>().ok()?.checked_add(1)?;
    let start = span.start as usize + (text.len() - range.len());
    let place = part(span, start, start + first.len() + 1 + last.len());
    (!first.is_empty() && digits(first) == first.len() && counter.starts_with(is_word)).then(|| {
        Diagnostic::new(Code::E0122, "a range in the manner of another language")
            .label(place, "a range is written with `..`, and its end is not in it")
            .help(format!("write `for {counter} in {first}..{end} {{ … }}` for {first} to {last}"))
    })
}

/// What stopped reading inside the list of a declaration at `at`: a matrix, or a loop.
pub(super) fn list(span: Span, at: usize, source: &str) -> Option<Diagnostic> {
    let text = &source[span.start as usize..at];
    let open = text.rfind('[').filter(|open| !text[*open..].contains(']'))?;
    let token = token_at(source, at);
    if token == "for" {
        return Some(
            Diagnostic::new(Code::E0122, "a list that is computed by a `for`")
                .label(part(span, at, at + token.len()), "of another language")
                .help("write the elements out, or repeat the step: `for i in 0..4 { move to (i, 2) }`"),
        );
    }
    let start = span.start as usize + open;
    let (rest, _) = source[start + 1..span.end as usize].split_once(']')?;
    let rows: Vec<Vec<&str>> = rest
        .split([';', '\n'])
        .map(|row| row.split([' ', '\t', ',']).filter(|cell| !cell.is_empty()).collect())
        .filter(|row: &Vec<&str>| !row.is_empty())
        .collect();
    let is_number = |cell: &&str| cell.starts_with(|c: char| c.is_ascii_digit() || c == '-');
    let is_matrix = rest.contains(';') && rows.iter().all(|row| row.len() == 2 && row.iter().all(is_number));
    is_matrix.then(|| {
        let places: Vec<String> = rows.iter().map(|row| format!("({}, {})", row[0], row[1])).collect();
        let list = format!("[{}]", places.join(", "));
        let whole = part(span, start, start + rest.len() + 2);
        Diagnostic::new(Code::E0122, "a matrix")
            .label(whole, "of another language")
            .help(format!("write a list of places, `{}`", quote(&list)))
            .mended(whole, list)
    })
}

/// `7 // 2`, of which everything from the signs on is a comment.
pub(super) fn whole_division(comment: Span, source: &str) -> Option<Diagnostic> {
    let divisor = source[comment.range()].strip_prefix("//")?.trim();
    let is_number =
        divisor.starts_with(|c: char| c.is_ascii_digit()) && divisor.chars().all(|c| c.is_ascii_digit() || c == '.');
    let follows_value = || line_before(source, comment.start as usize).ends_with(|c: char| is_word(c) || c == ')');
    (is_number && follows_value()).then(|| {
        Diagnostic::new(Code::W0101, "a comment that may be meant as a division")
            .label(comment, "`//` begins a comment")
            .help(format!("write `floor(… / {divisor})` for a whole quotient, or a word into the comment"))
    })
}

/// `from std import dimibot` at the head of a line.
pub(super) fn import(span: Span, text: &str) -> Option<Diagnostic> {
    let words: Vec<&str> = text.split_whitespace().collect();
    let (["from", "std", "import", file], true) = (words.get(..4)?, words.len() == 4) else { return None };
    Some(
        Diagnostic::new(Code::E0122, "`from … import` is not of the language")
            .label(span, "of another language")
            .help(format!("write `use std.{}`", quote(file)))
            .mended(span, format!("use std.{file}")),
    )
}

/// `device my-bot …`, `device "bot" …`: a name as it cannot be, of which `rest` is what could not be read; `before` is the text up to it.
pub(super) fn name(rest: Span, source: &str) -> Option<Diagnostic> {
    let start = rest.start as usize;
    let text = &source[rest.range()];
    let ends = |text: &str| text.len() - text.trim_start_matches(|c| is_word(c) || c == '-').len();
    if text.starts_with('-') {
        let first = source[..start].len() - source[..start].trim_end_matches(is_word).len();
        let whole = &source[start - first..start + ends(text)];
        let written = whole.replace('-', "_");
        return (first > 0).then(|| {
            Diagnostic::new(Code::E0110, format!("`{}` is no name", quote(whole)))
                .label(part(rest, start - first, start - first + whole.len()), "names are letters, digits and `_`")
                .help(format!("write `{}`", quote(&written)))
                .mended_here(written)
        });
    }
    let inside = text.strip_prefix('"')?.split('"').next()?;
    let is_name = inside.starts_with(is_word) && inside.chars().all(is_word);
    (is_name && !inside.starts_with(|c: char| c.is_ascii_digit())).then(|| {
        Diagnostic::new(Code::E0110, "a name in quotes")
            .label(part(rest, start, start + inside.len() + 2), "names stand without quotes")
            .help(format!("write `{}`", quote(inside)))
            .mended_here(inside)
    })
}
