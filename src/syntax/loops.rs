//! Loop heads in the style of other languages; each is read as far as possible, so that the fix keeps the user's own
//! loop.

use super::context::{self, part, quote};
use super::errors;
use super::words::{is_name, is_word};
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

/// Diagnoses a `for` that could not be read; `closes` is whether a `}` stands where its block would end.
pub(super) fn diagnose(span: Span, closes: bool, source: &str) -> Diagnostic {
    after_loop(span, source).or_else(|| foreign_head(span, closes, source)).unwrap_or_else(|| {
        Diagnostic::new(Code::E0122, "a `for` in the style of another language")
            .label(context::first_word(span, "for".len()), "expected names, `in`, and a list or range")
            .help("write `for i in 0..4 { … }` for 0 to 3, or `for p in list { … }`")
    })
}

/// A valid loop that is followed by something on the line of its closing brace.
fn after_loop(span: Span, source: &str) -> Option<Diagnostic> {
    let text = &source[span.range()];
    let (head, body) = text.split_once('{')?;
    let mut words = head.strip_prefix("for")?.split_whitespace();
    let is_ours = words.next().is_some_and(|name| name.starts_with(is_word)) && words.any(|word| word == "in");
    let mut depth = 1;
    let closes = |(_, sign): &(usize, char)| {
        depth += i32::from(*sign == '{') - i32::from(*sign == '}');
        depth == 0
    };
    let (close, _) = body.char_indices().filter(|_| is_ours).find(closes)?;
    let behind = body[close + 1..].lines().next()?;
    let word = behind.trim_start();
    let end = span.start as usize + head.len() + 1 + close + 1;
    (word.starts_with(is_word)).then(|| errors::joined(part(span, end, end + behind.len() - word.len()), source))
}

/// `for (i in 0..4) {`, `for i of list {`, `for i = 0:3 {`, `for (int i = 0; i < 4; i++) {`, `for i = 1, 3 do`,
/// `for i in 0..4` without its brace.
fn foreign_head(span: Span, closes: bool, source: &str) -> Option<Diagnostic> {
    let start = span.start as usize;
    let line = context::after(source, start).lines().next()?.split("//").next()?;
    let written = line.split('{').next()?.trim_end();
    let has_brace = line[written.len()..].trim_start().starts_with('{');
    let head = format!("for {}", translated_head(written.strip_prefix("for")?)?);
    let place = part(span, start, start + written.len());
    if head == written {
        let finding = Diagnostic::new(Code::E0122, "a `for` without its `{`");
        let finding = finding.label(place, "expected a block after this");
        let finding = finding.help(format!("write `{} {{`, and `}}` where the block ends", quote(&head)));
        return (!has_brace).then(|| if closes { finding.with_fix(place.after(), " {") } else { finding });
    }
    let finding = Diagnostic::new(Code::E0122, "a `for` in the style of another language")
        .label(place, "a `for` has names, `in`, and a list or a range, which excludes its end")
        .help(format!("write `{} {{`", quote(&head)));
    Some(match (has_brace, closes) {
        (true, _) => finding.with_fix_here(head),
        (false, true) => finding.with_fix_here(format!("{head} {{")),
        // The end of the block is unknown.
        (false, false) => finding,
    })
}

/// Translates the rest of a foreign `for` head to names, `in`, and a list or range.
fn translated_head(written: &str) -> Option<String> {
    let text = written.trim().trim_end_matches(':').trim_end();
    let text = ["do", "loop"].into_iter().find_map(|end| text.strip_suffix(end)?.strip_suffix(' ')).unwrap_or(text);
    let text = text.trim();
    let inside = text.strip_prefix('(').and_then(|text| text.strip_suffix(')')).unwrap_or(text).trim();
    let counted = inside.split(';').map(str::trim).collect::<Vec<_>>();
    if let [first, condition, step] = counted[..] {
        return counting(first, condition, step);
    }
    let text = without_sort(inside);
    let names = text.len() - text.trim_start_matches(|c| is_word(c) || matches!(c, ',' | ' ')).len();
    let (names, rest) = match [" in ", " of ", " from "].into_iter().filter_map(|word| text.find(word)).min() {
        Some(at) => (&text[..at], text[at..].trim_start()),
        None => text.split_at(names),
    };
    let range = ["in ", "of ", "from ", "<-", ":=", ":", "="].into_iter().find_map(|word| rest.strip_prefix(word))?;
    let are_names = names.split(',').all(|name| is_name(name.trim())) && names.split(',').count() <= 2;
    are_names.then_some(())?;
    Some(format!("{} in {}", names.trim(), range_of(range.trim())?))
}

/// Translates `i = 0`, `i < 4`, `i++`.
fn counting(first: &str, condition: &str, step: &str) -> Option<String> {
    let (name, first) = without_sort(first).split_once('=')?;
    let name = name.trim_end_matches(':').trim();
    let limit = condition.strip_prefix(name)?.trim_start();
    let range = match limit.strip_prefix("<=") {
        Some(last) => format!("{}..{}", first.trim(), exclusive_end(last.trim())),
        None => format!("{}..{}", first.trim(), limit.strip_prefix('<')?.trim()),
    };
    let step: String = step.chars().filter(|c| !c.is_whitespace()).collect();
    let by_one = [format!("{name}++"), format!("++{name}"), format!("{name}+=1"), format!("{name}={name}+1")];
    (is_name(name) && is_plain(&range) && by_one.contains(&step)).then(|| format!("{name} in {range}"))
}

/// The text without the type or keyword that other languages write before a name.
fn without_sort(text: &str) -> &str {
    let sorts = ["int ", "let ", "var ", "auto ", "const ", "local "];
    sorts.into_iter().find_map(|sort| text.strip_prefix(sort)).unwrap_or(text).trim_start()
}

/// Translates a list or range; a list stays as it is, and an inclusive end becomes an exclusive one.
fn range_of(written: &str) -> Option<String> {
    let call = written.strip_prefix("range(").and_then(|arguments| arguments.strip_suffix(')'));
    let range = match call.map(|arguments| arguments.split(',').map(str::trim).collect::<Vec<_>>()) {
        Some(arguments) => match arguments[..] {
            [end] => format!("0..{end}"),
            [first, end] => format!("{first}..{end}"),
            _ => return None,
        },
        None => match ["..=", "...", " to ", ":"].into_iter().find_map(|sign| written.split_once(sign)) {
            Some((first, last)) => format!("{}..{}", first.trim(), exclusive_end(last.trim())),
            None => match written.split_once(',').filter(|_| !written.contains(['(', '['])) {
                Some((first, last)) => format!("{}..{}", first.trim(), exclusive_end(last.trim())),
                None => written.to_owned(),
            },
        },
    };
    is_plain(&range).then_some(range)
}

/// The exclusive end of a range whose last element is given.
fn exclusive_end(last: &str) -> String {
    last.parse::<u32>()
        .ok()
        .and_then(|last| last.checked_add(1))
        .map_or_else(|| format!("{last} + 1"), |end| end.to_string())
}

/// Whether a list or range contains only characters that Tweeze knows.
fn is_plain(range: &str) -> bool {
    let is_known = |c: char| is_word(c) || " .,+-*/()[]".contains(c);
    !range.is_empty() && range.chars().all(is_known) && !range.ends_with("..") && !range.starts_with("..")
}
