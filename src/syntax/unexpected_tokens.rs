//! Diagnoses the place where parsing of an entry stopped: a superfluous word, a missing word, or a word used for
//! another.

use super::context::{
    blanks_end, code_end_before, line_after, line_before, part, quote, token_at, token_before_sign, value_in,
    with_blanks,
};
use super::words::{PREPOSITIONS, is_word, meant_preposition};
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::Unit;
use crate::source::Span;

/// Diagnoses parsing that stopped at `at`, inside the bracket `open` if there is one.
pub(super) fn stopped(span: Span, at: usize, wants_value: bool, open: Option<char>, text: &str) -> Diagnostic {
    let token = token_at(&text[..span.end as usize], at);
    let wanted = match (wants_value, open) {
        (true, _) => "expected a value",
        (false, Some('(')) => "expected `,` or `)`",
        (false, Some('[')) => "expected `,` or `]`",
        (false, _) => "expected the end of the line",
    };
    if token.is_empty() {
        let before = code_end_before(text, span.end as usize);
        let start = before - token_before_sign(&text[..before]).len();
        return Diagnostic::new(Code::E0101, "this ends too early")
            .label(part(span, start, before), "expected more after this")
            .help("complete the line, or remove it");
    }
    let line = quote(line_before(text, at));
    let place = part(span, at, at + token.len());
    if let Some(found) = in_requirement(place, &line, token) {
        return found;
    }
    if token == "." && line.ends_with("..") {
        return Diagnostic::new(Code::E0101, "`...` does not continue a line")
            .label(part(span, at - 2, at + 1), "not part of the language")
            .help("remove it: a line continues after an operator or inside brackets")
            .with_fix(part(span, at - 2, at + 1), "");
    }
    let finding = Diagnostic::new(Code::E0101, format!("`{token}` does not belong here")).label(place, wanted);
    if let Some((ours, help)) = preposition(token) {
        return finding.help(help).with_fix(place, ours);
    }
    if token == "and" {
        return joined_by_and(place, text);
    }
    // A word that is not a preposition was read as a name: `dispense drop form dye`, `dispense drop from the dye`.
    let before = code_end_before(text, at);
    let word = &text[text[..before].trim_end_matches(is_word).len()..before];
    let word_place = part(span, before - word.len(), before);
    if is_article(word) {
        return article(word_place, text);
    }
    if let Some((ours, help)) = preposition(word) {
        return Diagnostic::new(Code::E0101, format!("`{word}` is not a preposition"))
            .label(word_place, "expected a preposition")
            .help(help)
            .with_fix(word_place, ours);
    }
    if line.ends_with('}') && PREPOSITIONS.contains(&token) {
        return finding.help("write an index in `[ ]`, as in `drop[2]`; a block ends the step");
    }
    if token == "{" && line.ends_with(':') {
        let has_bar = text[at..].lines().nth(1).is_some_and(|row| row.contains('|'));
        let word = if has_bar { "table" } else { "disc" };
        return finding.help(format!("write the kind of value before its braces, as in `{line} {word} {{ … }}`"));
    }
    if token == "(" && before == at && !word.is_empty() {
        return Diagnostic::new(Code::E0101, "an index in round brackets")
            .label(place, "an index belongs in `[ ]`")
            .help(format!("write `{word}[…]`"));
    }
    if let (None, Some(finding)) = (open, word_missing(place, &line, text)) {
        return finding;
    }
    finding.help("remove it, or begin a new line before it")
}

/// `move to (2, 2) and wait 5 ms`.
pub(super) fn joined_by_and(word: Span, text: &str) -> Diagnostic {
    Diagnostic::new(Code::E0101, "`and` does not join steps")
        .label(word, "the step before this ends here")
        .help("write a comma instead, or each step on a line of its own")
        .with_fix(with_blanks(word, text), ", ")
}

/// `drop(2)`; the bracket opens at byte `bracket`.
pub(super) fn round_index(whole: Span, bracket: usize, text: &str) -> Diagnostic {
    let end = whole.end as usize;
    let (name, index) = (&text[whole.start as usize..bracket], &text[bracket + 1..end - 1]);
    Diagnostic::new(Code::E0101, "an index in round brackets")
        .label(part(whole, bracket, end), "an index belongs in `[ ]`, and counts from 0")
        .help(format!("write `{name}[{}]`", quote(index)))
        .with_fix(part(whole, bracket, bracket + 1), "[")
        .with_fix(part(whole, end - 1, end), "]")
}

/// A value after a step without its preposition, such as the time in `mix a at (5, 3) 3 s`; `value` is its first word.
pub(super) fn word_missing(value: Span, line: &str, text: &str) -> Option<Diagnostic> {
    let at = value.start as usize;
    let rest = value_in(line_after(text, at));
    let line = line.rsplit('{').next().unwrap_or_default().trim_start();
    let is_number = rest.starts_with(|c: char| c.is_ascii_digit());
    let is_axis = matches!(token_at(rest, 0), "x" | "y" | "z");
    let mut behind = line.rsplit([' ', '\t']);
    let ends_in_number = |word: Option<&str>| word.is_some_and(|word| word.ends_with(|c: char| c.is_ascii_digit()));
    // `wait 5 000 ms` and `5 min 30 s` are adjacent numbers.
    let follows_number = is_number && {
        let last = behind.next();
        ends_in_number(last) || last.is_some_and(|unit| Unit::parse(unit).is_ok()) && ends_in_number(behind.next())
    };
    if follows_number || !(is_number || is_axis || rest.starts_with('(')) {
        return None;
    }
    let number = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.').len();
    let unit = token_at(rest[number..].trim_start(), 0);
    let has = |word: &str| line.split([' ', '\t']).any(|known| known == word);
    let word = match unit {
        "ns" | "us" | "ms" | "s" | "min" | "h" if is_number => Some("for"),
        "deg" | "rad" | "rev" if is_number => Some("by"),
        _ if is_axis => Some("about"),
        _ if rest.starts_with('(') && line.starts_with("move") => ["to", "via"].into_iter().find(|word| !has(word)),
        _ if rest.starts_with('(') => ["at", "to"].into_iter().find(|word| !has(word)),
        _ => None,
    };
    let before = code_end_before(text, at);
    let shown = quote(token_at(rest, 0));
    let finding = Diagnostic::new(Code::E0101, format!("a word is missing before `{shown}`"))
        .label(value, "the step takes a value only after a word such as `at` or `for`");
    Some(match word.filter(|word| !has(word)) {
        Some(word) => finding
            .help(format!("write `{} {word} {}`", quote(line), quote(rest)))
            .with_fix(part(value, before, at), format!(" {word} ")),
        None => finding.help("write the word that introduces it, or remove it; a new step begins on a new line"),
    })
}

/// Whether a word is an English article; `a` is excluded because it may be a name.
pub(super) fn is_article(word: &str) -> bool {
    matches!(word, "the" | "an")
}

/// An article before a name.
pub(super) fn article(word: Span, text: &str) -> Diagnostic {
    let end = blanks_end(text, word.end as usize);
    Diagnostic::new(Code::E0101, format!("`{}` is not part of the language", &text[word.range()]))
        .label(word, "names take no article")
        .help("remove it")
        .with_fix(part(word, word.start as usize, end), "")
}

/// Foreign prepositions and their equivalents in Tweeze.
const FOREIGN_PREPOSITIONS: &[(&str, &str)] = &[
    ("around", "about"),
    ("round", "about"),
    ("onto", "to"),
    ("into", "to"),
    ("towards", "to"),
    ("amongst", "among"),
    ("through", "via"),
    ("during", "for"),
    ("using", "with"),
];

/// The preposition that a word stands for, and the help to show.
fn preposition(word: &str) -> Option<(&'static str, String)> {
    let foreign = FOREIGN_PREPOSITIONS.iter().find(|(theirs, _)| *theirs == word);
    let foreign = foreign.map(|(_, ours)| (*ours, format!("write `{ours}`")));
    foreign.or_else(|| meant_preposition(word).map(|meant| (meant, format!("did you mean `{meant}`?"))))
}

/// Diagnoses a `require` at the place where parsing stopped.
fn in_requirement(token_span: Span, line: &str, token: &str) -> Option<Diagnostic> {
    let step = line.rsplit(['{', ',']).next().unwrap_or("").trim_start();
    step.strip_prefix("require").filter(|rest| rest.starts_with([' ', '\t']))?;
    let found = |title: &str, label: &str| Diagnostic::new(Code::E0101, title).label(token_span, label);
    match token {
        "=" if step.ends_with(['<', '>']) => {
            let sign = &step[step.len() - 1..];
            Some(
                found(&format!("a space in `{sign}=`"), "expected no space before this")
                    .help(format!("write `{sign}=`")),
            )
        }
        "=" if step.trim_end().ends_with("==") => {
            Some(found("`===` does not compare", "one `=` too many").help("write `==`").with_fix_here(""))
        }
        "=" => Some(found("`=` does not compare", "sets a value").help("write `==`").with_fix_here("==")),
        "and" => Some(
            found("`and` does not join conditions", "one condition each")
                .help("write a separate `require` for each, one per line: all of them must hold"),
        ),
        "or" => Some(
            found("`or` does not join conditions", "no alternatives")
                .help("choose one of them: every `require` of a task must hold"),
        ),
        _ => None,
    }
}
