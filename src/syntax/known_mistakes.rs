//! Mistakes that are recognised by their shape. Each gets one diagnostic with its fix, where the general ones could
//! only name the place at which parsing stopped.

use super::context::{self, part, quote, token_at};
use super::errors::ListPlace;
use super::foreign_syntax;
use super::tree::{Expr, ExprKind, Field};
use super::words::{PREPOSITIONS, end_of_word, is_name, is_word};
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

/// Diagnoses an unreadable entry of a block, if it is a known mistake.
pub(super) fn entry(span: Span, place: ListPlace, source: &str) -> Option<Diagnostic> {
    let text = &source[span.range()];
    if let Some(finding) = foreign_comment(span, text) {
        return Some(finding);
    }
    match place {
        ListPlace::Wires => wire(span, source),
        ListPlace::Scene => {
            object_name(span, text).or_else(|| object_without_at(span, text)).or_else(|| shape_behind_place(span, text))
        }
        ListPlace::Steps => foreign_syntax::step(span, source),
        ListPlace::Fields => None,
    }
}

/// `out = card.ao0`, which was read as a field: no field of a wiring has an output as its value.
pub(super) fn equals_in_wire(field: &Field, source: &str) -> Option<Diagnostic> {
    let between = part(field.span, field.name.span.end as usize, field.value.span.start as usize);
    let sign = source[between.range()].trim();
    let is_output = matches!(&field.value.kind, ExprKind::Path(path) if path.segments.len() > 1);
    if !is_output || !matches!(sign, "=" | ":=") {
        return None;
    }
    let at = between.start as usize + source[between.range()].find(sign)?;
    let mark = part(between, at, at + sign.len());
    let (name, output) = (&field.name.text, &source[field.value.span.range()]);
    Some(
        Diagnostic::new(Code::E0119, format!("`{sign}` where `->` belongs"))
            .label(mark, "`->` goes between a channel and its output")
            .help(format!("write `{name} -> {}`", quote(output)))
            .with_fix(mark, "->"),
    )
}

/// `bl0.set: "…"`, `bl0.set = "…"`, or an output without quotes.
fn wire(span: Span, source: &str) -> Option<Diagnostic> {
    let text = &source[span.range()];
    let channel = text.len() - text.trim_start_matches(|c| is_word(c) || matches!(c, '.' | '[' | ']')).len();
    let rest = text[channel..].trim_start();
    let sign = ["->", "=>", ":=", ":", "="].into_iter().find(|sign| rest.starts_with(sign))?;
    let output = rest[sign.len()..].trim();
    // String prefixes of other languages.
    let bare = output.strip_prefix(['f', 'r', 'b']).filter(|bare| bare.starts_with('"')).unwrap_or(output);
    // An output of an instrument is written without quotes: `card.port0.line3 { … }`.
    let path = output.split([' ', '\t', '{']).next().unwrap_or_default();
    let is_path = path.contains('.') && path.chars().all(|c| is_word(c) || matches!(c, '.' | '[' | ']'));
    // `card.port0.line(2 * i) { … }`
    let (written, fields) = output.split_at(output.find('{').unwrap_or(output.len()));
    let is_indexed = written.contains('.')
        && written.contains('(')
        && written.chars().all(|c| is_word(c) || matches!(c, '.' | '(' | ')' | ' ' | '*' | '+' | '-'));
    let quoted = match is_path || bare.starts_with('"') {
        true => bare.to_owned(),
        false if is_indexed => format!("{}{fields}", written.replace('(', "[").replace(')', "]")),
        false => format!("\"{output}\""),
    };
    // Several words may be a path with a slip in it; quoted, it would be a plain name and lead to no instrument.
    let is_sure =
        is_path || is_indexed || bare.starts_with('"') || output.chars().all(|c| is_word(c) || "/-".contains(c));
    let fix = match is_sure {
        true => format!("write `{} -> {}`", &text[..channel], quote(&quoted)),
        false => "write an output of an instrument as `card.port0.line0`, and any other name in quotes".to_owned(),
    };
    let start = span.start as usize + (text.len() - rest.len());
    if sign != "->" {
        let finding = Diagnostic::new(Code::E0119, format!("`{sign}` where `->` belongs"))
            .label(part(span, start, start + sign.len()), "`->` goes between a channel and its output")
            .help(fix);
        let whole = part(span, span.start as usize + channel, span.start as usize + text.trim_end().len());
        return Some(if is_sure { finding.with_fix(whole, format!(" -> {quoted}")) } else { finding });
    }
    let at = span.start as usize + (text.len() - rest[sign.len()..].trim_start().len());
    let next = output[path.len()..].trim_start();
    if is_path && next.starts_with(is_word) {
        let (behind, next_at) = (at + path.len(), at + output.len() - next.len());
        let token = token_at(next, 0);
        return Some(
            Diagnostic::new(Code::E0103, format!("a comma is missing before `{}`", quote(token)))
                .label(part(span, next_at, next_at + token.len()), "the wire before this is complete")
                .help("separate wires with commas, or write each on a line of its own")
                .with_fix(part(span, behind, behind), ","),
        );
    }
    (quoted != output && !output.is_empty() && !output.starts_with('"')).then(|| {
        let (title, note) = match is_indexed {
            true => ("an index in round brackets", "an index belongs in `[ ]`"),
            false => ("an output without quotes", "an output is a string"),
        };
        let finding = Diagnostic::new(Code::E0101, title).label(part(span, at, at + output.len()), note).help(fix);
        if is_sure { finding.with_fix_here(quoted) } else { finding }
    })
}

/// `… -- the supply` or `… % the supply` after an entry.
pub(super) fn foreign_comment(span: Span, text: &str) -> Option<Diagnostic> {
    let line = text.lines().next().unwrap_or_default();
    let found = ["--", "%"].into_iter().filter_map(|mark| {
        let at = line.match_indices(mark).map(|(at, _)| at).find(|at| {
            let before = &line[..*at];
            // `%` may also be a unit after a number, or a remainder of names.
            let words = line[at + mark.len()..].trim();
            let are_words = words.contains(' ') && words.chars().all(|c| c.is_alphabetic() || " ,.".contains(c));
            let is_unit = before.trim_end().ends_with(|c: char| c.is_ascii_digit());
            // After a quantity, as in `wait 5 ms % settle`, it is neither.
            let mut last = before.trim_end().rsplit([' ', '\t']);
            let is_name = last.next().is_some_and(|unit| unit.ends_with(is_word));
            let is_quantity =
                is_name && last.next().is_some_and(|number| number.ends_with(|c: char| c.is_ascii_digit()));
            let is_percent = mark == "%" && (is_unit || is_name && !are_words && !is_quantity);
            !is_percent && before.matches('"').count().is_multiple_of(2) && before.ends_with([' ', '\t'])
        })?;
        (!line[at + mark.len()..].trim().is_empty()).then_some((at, mark))
    });
    let (at, mark) = found.min()?;
    Some(comment_behind(span, span.start as usize + at, mark, line[at + mark.len()..].trim()))
}

/// A comment that begins at a byte with a foreign mark; `words` is its text.
fn comment_behind(span: Span, at: usize, mark: &str, words: &str) -> Diagnostic {
    Diagnostic::new(Code::E0125, format!("a comment that begins with `{mark}`"))
        .label(part(span, at, at + mark.len()), "comments begin with `//`")
        .help(format!("write `// {}`", quote(words)))
        .with_fix_here("//")
}

/// `obstacle glass-bead …`, `obstacle 1bead …`.
fn object_name(span: Span, text: &str) -> Option<Diagnostic> {
    let noun = token_at(text, 0);
    let rest = text[noun.len()..].trim_start_matches([' ', '\t']);
    let name = rest.split([' ', '\t', ':', '\n', '{']).next().filter(|name| !name.is_empty())?;
    let is_written_so = name.chars().all(|c| is_word(c) || matches!(c, '-' | '.' | '#' | '\''));
    let is_name = name.chars().all(is_word) && !name.starts_with(|c: char| c.is_ascii_digit());
    let has_letter = name.chars().any(|c| is_word(c) && !c.is_ascii_digit());
    if !noun.starts_with(is_word) || !is_written_so || is_name || !has_letter {
        return None;
    }
    let letters: String = name.chars().map(|c| if is_word(c) { c } else { '_' }).collect();
    let digits = letters.len() - letters.trim_start_matches(|c: char| c.is_ascii_digit()).len();
    let fixed = format!("{}{}", &letters[digits..], &letters[..digits]);
    let at = span.start as usize + (text.len() - rest.len());
    Some(
        Diagnostic::new(Code::E0110, format!("`{}` is not a valid name", quote(name)))
            .label(part(span, at, at + name.len()), "names consist of letters, digits and `_`, and begin with a letter")
            .help(format!("write `{noun} {}`", quote(&fixed)))
            .with_fix_here(fixed),
    )
}

/// `part part m1 …`, `obstacle the dust …`: a superfluous word before a name. Returns the finding and the span of the
/// line.
pub(super) fn word_before_name(span: Span, source: &str) -> Option<(Diagnostic, Span)> {
    let start = span.start as usize;
    let line = context::after(source, start).lines().next().unwrap_or_default();
    let words: Vec<&str> = line.split([' ', '\t']).filter(|word| !word.is_empty()).take(3).collect();
    let [noun, extra, name] = words[..] else { return None };
    let is_extra = is_name(noun) && (extra == noun || matches!(extra, "the" | "an" | "a"));
    let name = &name[..end_of_word(name, 0)];
    if !is_extra || !is_name(name) || PREPOSITIONS.contains(&name) {
        return None;
    }
    let at = start + noun.len() + line[noun.len()..].find(extra)?;
    let next = at + extra.len() + line[at + extra.len() - start..].find(name)?;
    let title = match extra == noun {
        true => format!("`{noun}` is repeated"),
        false => format!("`{extra}` is not part of the language"),
    };
    let finding = Diagnostic::new(Code::E0101, title)
        .label(part(span, at, at + extra.len()), "expected a name")
        .help(format!("write `{noun} {name}`"))
        .with_fix(part(span, at, next), "");
    let end = start + line.find(['}', ';']).filter(|_| !line.contains('{')).unwrap_or(line.len());
    Some((finding, part(span, start, end.max(span.end as usize))))
}

/// `obstacle dust (12, 7)`, `part m1 : ea.droplet (12, 7)`.
pub(super) fn object_without_at(span: Span, text: &str) -> Option<Diagnostic> {
    let line = text.lines().next()?.trim_end();
    let place = line.rfind('(').filter(|_| line.ends_with(')'))?;
    let before = line[..place].trim_end();
    let mut words = before.split_whitespace();
    let (first, second) = (words.next().unwrap_or_default(), words.next().unwrap_or_default());
    if PREPOSITIONS.contains(&second) && second != "at" {
        return Some(
            Diagnostic::new(Code::E0101, format!("`{} {second} …` is a step, but this is a scene", quote(first)))
                .label(part(span, span.start as usize, span.start as usize + line.len()), "not an object")
                .help("steps belong in the braces of a task: `task go on bot in bench { … }`"),
        );
    }
    let is_object = before.split_whitespace().count() == 2 || before.contains(':');
    let (at, gap) = (span.start as usize + place, if line[..place].ends_with([' ', '\t']) { "at " } else { " at " });
    (is_object && !before.ends_with(" at") && !before.contains(" at ")).then(|| {
        Diagnostic::new(Code::E0101, "`at` is missing")
            .label(part(span, at, span.start as usize + line.len()), "expected `at` before the place of an object")
            .help(format!("write `{} at {}`", quote(before), quote(&line[place..])))
            .with_fix(part(span, at, at), gap)
    })
}

/// `obstacle bead at (4 um, 2 um) : disc { … }`, with the shape after its place.
fn shape_behind_place(span: Span, text: &str) -> Option<Diagnostic> {
    let line = text.lines().next()?.trim_end();
    let at = line.find(" at ")?;
    let colon = at + line[at..].find(':')?;
    let (object, place, shape) = (&line[..at], line[at + " at ".len()..colon].trim(), line[colon + 1..].trim());
    let is_whole = place.ends_with(')') && shape.matches('{').count() == shape.matches('}').count();
    if object.contains(':') || !is_whole || shape.is_empty() {
        return None;
    }
    let whole = part(span, span.start as usize, span.start as usize + line.len());
    let fixed = format!("{object} : {shape} at {place}");
    Some(
        Diagnostic::new(Code::E0101, "a shape after the place of its object")
            .label(part(span, span.start as usize + colon, span.start as usize + line.len()), "belongs before `at`")
            .help(format!("write `{}`", quote(&fixed)))
            .with_fix(whole, fixed),
    )
}

/// Where the value at the end of a line begins, after `to`, `at`, `from`, `via` or `visit`.
fn places_from(before: &str) -> Option<usize> {
    let seen = before.len() - context::before(before, before.len()).len();
    let line = before[seen..].rfind('\n').map_or(seen, |end| seen + end + 1);
    let words = [" to ", " at ", " from ", " via ", "visit "];
    let at = words.iter().filter_map(|word| before[line..].rfind(word).map(|at| line + at + word.len())).max()?;
    let value = before[at..].trim_start();
    let is_value = value.starts_with(|c: char| c.is_ascii_digit() || c == '(') && !value.contains(['{', '}']);
    is_value.then(|| before.len() - value.len())
}

/// Coordinates or places without brackets around them, as in `move to 19, 28`, where the unreadable entry is their
/// second part.
pub(super) fn rest_of_place(span: Span, source: &str) -> Option<Diagnostic> {
    let is_value = source[span.range()].starts_with(|c: char| c.is_ascii_digit() || c == '(');
    let before = source[..span.start as usize].trim_end_matches([' ', '\t']).strip_suffix(',').filter(|_| is_value)?;
    let start = places_from(before)?;
    let line = context::after(source, start).lines().next().unwrap_or_default();
    let end = line.find(['}', '{']).unwrap_or(line.len());
    let written = line[..end].split("//").next().unwrap_or_default();
    // `move to 19, 28 via (3, 4)`: the place ends before the next word.
    let ends = PREPOSITIONS.iter().filter(|word| **word != "via").filter_map(|word| written.find(&format!(" {word} ")));
    let via = written.find(" via ").filter(|_| !written.starts_with('('));
    let end = ends.chain(via).min().unwrap_or(written.len());
    let written = written[..end].trim_end_matches([' ', '\t', ';']);
    let place = part(span, start, start + written.len());
    let is_via = before[..start].trim_end().ends_with(" via");
    let (title, fix, brackets) = match written.starts_with('(') {
        true if is_via => ("places without a word between them", repeated_via(written), None),
        true if before[..start].trim_end().ends_with("move to") => {
            let help =
                "write a step for each place, or `via` before those on the way, as in `move to (8, 3) via (3, 9)`";
            let finding = Diagnostic::new(Code::E0127, "places without a word between them");
            return Some(finding.label(place, "a comma ends an entry here").help(help));
        }
        true => ("places without brackets around them", format!("write a list: `[{}]`", quote(written)), Some("[]")),
        false if written.ends_with(')') && !written.contains('(') => {
            let help = format!("write `({}`", quote(written));
            let finding =
                Diagnostic::new(Code::E0114, "`(` is missing").label(place, "expected `(` before this").help(help);
            return Some(finding.with_fix(part(place, place.start as usize, place.start as usize), "("));
        }
        false => ("coordinates without brackets around them", format!("write `({})`", quote(written)), Some("()")),
    };
    let finding = Diagnostic::new(Code::E0127, title).label(place, "a comma ends an entry here").help(fix);
    Some(match brackets {
        Some(brackets) => {
            let start = part(place, place.start as usize, place.start as usize);
            finding.with_fix(start, &brackets[..1]).with_fix(place.after(), &brackets[1..])
        }
        None => finding.with_fix_here(places_with_via(written)),
    })
}

/// Help for `via (3, 9), (8, 3)`: the word belongs before each place.
fn repeated_via(places: &str) -> String {
    format!("write `via` before each of them: `via {}`", quote(&places_with_via(places)))
}

fn places_with_via(places: &str) -> String {
    places.replace("),", ") via ").replace("  ", " ")
}

/// `let k = 5, 4`, where `rest` was read as a separate declaration; `value` is the part before the comma.
pub(super) fn let_without_brackets(value: Span, rest: Span, source: &str) -> Option<Diagnostic> {
    let between = source.get(value.end as usize..rest.start as usize)?;
    let is_value = source[rest.range()].starts_with(|c: char| c.is_ascii_digit() || matches!(c, '(' | '[' | '-'));
    if between.trim() != "," || between.contains('\n') || !is_value {
        return None;
    }
    let line = source[rest.range()].lines().next().unwrap_or_default();
    let end = rest.start as usize + line.split("//").next().unwrap_or_default().trim_end().len();
    let whole = part(value, value.start as usize, end);
    let written = &source[whole.range()];
    let [open, close] = if written.contains('(') { ["[", "]"] } else { ["(", ")"] };
    Some(
        Diagnostic::new(Code::E0127, "values without brackets around them")
            .label(whole, "a comma ends a declaration here")
            .help(format!("write `{open}{}{close}`", quote(written)))
            .with_fix(part(whole, whole.start as usize, whole.start as usize), open)
            .with_fix(whole.after(), close),
    )
}

/// `let k: cell = …`.
pub(super) fn sort_of_let(span: Span, text: &str) -> Option<Diagnostic> {
    let name = text.strip_prefix("let")?.trim_start();
    let rest = name.trim_start_matches(is_word);
    let sort = rest.trim_start().strip_prefix(':')?.trim_start();
    let value = sort.trim_start_matches(is_word).trim_start().strip_prefix('=')?.trim();
    let name = &name[..name.len() - rest.len()];
    let at = span.start as usize + (text.len() - rest.len());
    let end = at + (rest.len() - sort.len()) + end_of_word(sort, 0);
    Some(
        Diagnostic::new(Code::E0124, "`let` takes no sort")
            .label(part(span, at, end), "the sort follows from the value")
            .help(format!("write `let {name} = {}`", quote(value.lines().next().unwrap_or_default())))
            .with_fix_here(""),
    )
}

/// `set light to on`, or `set light on`: `on` is reserved for the device of a task.
pub(super) fn level_on(step: Span, source: &str) -> Option<Diagnostic> {
    let text = source[step.range()].trim_end();
    let words: Vec<&str> = text.split_whitespace().collect();
    let (["set", name, "to", "on"] | ["set", name, "on"]) = words[..] else { return None };
    let end = step.start as usize + text.len();
    Some(
        Diagnostic::new(Code::E0122, "`on` is not a level of an output")
            .label(part(step, end - "on".len(), end), "expected `high` or `low`")
            .help(format!("write `set {} to high`", quote(name)))
            .with_fix_here(if words.len() == 4 { "high" } else { "to high" }),
    )
}

/// `pulse voltage: 20 V`.
pub(super) fn blank_in_name(span: Span, text: &str) -> Option<Diagnostic> {
    let (name, value) = text.split_once(':')?;
    let words: Vec<&str> = name.split_whitespace().collect();
    let are_words = words.len() > 1 && words.iter().all(|word| word.chars().all(is_word));
    are_words.then(|| {
        let value = value.lines().next().unwrap_or_default().trim();
        Diagnostic::new(Code::E0119, format!("a space in the name `{}`", quote(&words.join(" "))))
            .label(
                part(span, span.start as usize, span.start as usize + name.trim_end().len()),
                "names contain no spaces",
            )
            .help(format!("write `{}: {}`", quote(&words.join("_")), quote(value)))
            .with_fix_here(words.join("_"))
    })
}

/// Diagnoses what stopped parsing inside a value: a remainder as in `19 % 4`, `=<`, a named argument, a missing comma.
pub(super) fn in_value(span: Span, at: usize, open: Option<char>, source: &str) -> Option<Diagnostic> {
    let token = token_at(&source[..span.end as usize], at);
    let place = part(span, at, at + token.len());
    if context::line_before(source, at).ends_with('%') {
        let finding = Diagnostic::new(Code::E0101, "`%` is the unit per cent, not a remainder");
        return Some(
            finding
                .label(place, "what comes before this is complete")
                .help("write `a - b * floor(a / b)` for the remainder of `a / b`"),
        );
    }
    if let Some((_, right)) = [("=<", "<="), ("=>", ">=")].into_iter().find(|(wrong, _)| *wrong == token) {
        let finding = Diagnostic::new(Code::E0101, format!("`{token}` is not a comparison"));
        let finding = finding.label(place, "`=` comes last").help(format!("write `{right}`"));
        return Some(finding.with_fix_here(right));
    }
    if token == ":" && open == Some('(') {
        return Some(
            Diagnostic::new(Code::E0101, "a named argument")
                .label(place, "arguments have no names")
                .help("remove the name: arguments follow the order of the parameters, as in `run fetch((19, 28))`"),
        );
    }
    if token == "then" {
        let finding = Diagnostic::new(Code::E0101, "`then` is not part of the language")
            .label(place, "what comes before this is complete");
        return Some(
            finding.help("steps run one after the other: write the next one after a comma, or on a line of its own"),
        );
    }
    if context::line_before(source, at).trim_start().starts_with("avoid contamination ") {
        let finding = Diagnostic::new(Code::E0101, "contamination is avoided in one direction at a time");
        return Some(
            finding
                .label(place, "expected the end of the line")
                .help("write `avoid A in B`, and `avoid B in A` where both must stay clean, with the names of fluids"),
        );
    }
    if token == "before" {
        let finding = Diagnostic::new(Code::E0101, "`before` is not part of the language")
            .label(place, "what comes before this is complete");
        return Some(finding.help("write `after NAME` at the operation of an `assay` that comes later"));
    }
    open.filter(|open| matches!(open, '(' | '[')).and_then(|open| missing_comma(span, at, open, source))
}

/// `(4.0 um 2.5 um)`, in a bracket that is open at byte `at`.
fn missing_comma(span: Span, at: usize, open: char, source: &str) -> Option<Diagnostic> {
    let rest = context::after(source, at);
    let is_number = rest.starts_with(|c: char| c.is_ascii_digit());
    let length = rest.find(|c: char| !(is_word(c) || (is_number && c == '.'))).unwrap_or(rest.len());
    let token = &rest[..length.max(token_at(rest, 0).len())];
    if !token.starts_with(|c: char| is_word(c) || c == '(') {
        return None;
    }
    let before = context::code_end_before(source, at);
    if source[..before].ends_with(',') {
        return None;
    }
    if let Some(finding) = step_in_brackets(span, at, token, source) {
        return Some(finding);
    }
    if let Some(finding) = state_in_brackets(span, before, open, source) {
        return Some(finding);
    }
    let close = if open == '(' { ')' } else { ']' };
    // After a comment, the blamed place may contain none of its own text.
    let own = source.get(span.start as usize..before).unwrap_or_default();
    let start = own.rfind(open).map(|start| span.start as usize + start);
    if start.is_some_and(|start| source[start + open.len_utf8()..before].trim().is_empty()) {
        return None;
    }
    let end = rest.find(['\n', close]).filter(|end| rest[*end..].starts_with(close));
    let written = start.zip(end).map(|(start, end)| (&source[start..before], &rest[..=end]));
    let help = match written.filter(|(first, second)| !first.contains('\n') && !second.contains(['(', '['])) {
        Some((first, second)) => format!("write `{}`", quote(&format!("{first}, {second}"))),
        None => "separate the values in brackets with commas, as in `(4 um, 2 um)`".to_owned(),
    };
    Some(
        Diagnostic::new(Code::E0101, format!("a comma is missing before `{}`", quote(token)))
            .label(part(span, at, at + token.len()), "the value before this is complete")
            .help(help)
            .with_fix(part(span, before, before), ","),
    )
}

/// `state [1 1 0]`: the arms of a control state written as a vector.
fn state_in_brackets(span: Span, before: usize, open: char, source: &str) -> Option<Diagnostic> {
    let start = before - context::before(source, before).len();
    let begun = start + source[start..before].rfind(open)?;
    let line = source[begun..].lines().next()?;
    let digits = &line[open.len_utf8()..line.find([']', ')'])?];
    let arms: String = digits.split_whitespace().collect();
    let is_state =
        source[..begun].trim_end().ends_with("state") && arms.bytes().all(|digit| matches!(digit, b'0' | b'1'));
    if !is_state {
        return None;
    }
    let whole = part(span, begun, begun + digits.len() + 2);
    Some(
        Diagnostic::new(Code::E0101, "a state in brackets")
            .label(whole, "the arms of a state are digits of one number")
            .help(format!("write `0b{arms}`, or the number of the state"))
            .with_fix(whole, format!("0b{arms}")),
    )
}

/// `move(to (1, 1))`, where parsing stopped at the preposition.
fn step_in_brackets(span: Span, at: usize, token: &str, source: &str) -> Option<Diagnostic> {
    PREPOSITIONS.contains(&token).then_some(())?;
    let seen = context::before(source, at);
    let begin = at - seen.len() + seen.rfind('\n').map_or(0, |end| end + 1);
    let line = context::after(source, begin).lines().next()?.split("//").next()?;
    let step = line.trim();
    let (verb, inner) = step.split_once('(')?;
    let inner = inner.strip_suffix(')').filter(|_| !verb.is_empty() && verb.chars().all(is_word))?;
    let fixed = format!("{verb} {inner}");
    let begin = begin + (line.len() - line.trim_start().len());
    Some(
        Diagnostic::new(Code::E0101, "a step takes no brackets")
            .label(
                part(span, begin + verb.len(), begin + verb.len() + 1),
                "what the step does follows its verb directly",
            )
            .help(format!("write `{}`", quote(&fixed)))
            .with_fix(part(span, begin, begin + step.len()), fixed),
    )
}

/// `device bot { … }`.
pub(super) fn device_without_kind(span: Span, text: &str) -> Option<Diagnostic> {
    let name = text.strip_prefix("device")?.trim_start();
    let length = end_of_word(name, 0);
    let at = span.start as usize + (text.len() - name.len());
    (length > 0 && name[length..].trim_start().starts_with('{')).then(|| {
        let word = &name[..length];
        Diagnostic::new(Code::E0124, format!("device `{word}` has no kind"))
            .label(part(span, at, at + length), "expected `:` and a kind or another device after this")
            .help(format!("write `device {word} : dimibot {{ … }}`; `tweeze devices` lists the kinds"))
    })
}

/// `/ …` or `-- …` at the beginning of a line.
pub(super) fn comment(span: Span, text: &str) -> Option<Diagnostic> {
    let mark = ["--", "/"].into_iter().find(|mark| text.starts_with(mark))?;
    let words = text.trim_start_matches(['-', '/']).trim();
    Some(comment_behind(span, span.start as usize, mark, words.lines().next().unwrap_or_default()))
}

/// `bot.left = 6` at the top of a file.
pub(super) fn field_outside(span: Span, text: &str) -> Option<Diagnostic> {
    let (path, value) = text.split_once('=')?;
    let (device, field) = path.trim_end().split_once('.')?;
    let is_path = [device, field].iter().all(|word| !word.is_empty() && word.chars().all(is_word));
    is_path.then(|| {
        let value = value.lines().next().unwrap_or_default().trim();
        Diagnostic::new(Code::E0111, format!("a field of `{device}` outside of its declaration"))
            .label(part(span, span.start as usize, span.start as usize + path.trim_end().len()), "given here")
            .help(format!(
                "give it where the device is declared: `device {device} : … {{ {field}: {} }}`",
                quote(value)
            ))
    })
}

/// A head whose block has a `}` but no `{`.
pub(super) fn missing_brace(mark: Span, head: &str) -> Diagnostic {
    let finding = Diagnostic::new(Code::E0124, "`{` is missing").label(mark, "expected a block after this");
    if head.ends_with('{') {
        return finding.help("the `{` here belongs to a string or a comment");
    }
    finding.help(format!("write `{} {{`", quote(head))).with_fix(mark.after(), " {")
}

/// `0,8` with a comma in place of the decimal point.
pub(super) fn decimal_comma(span: Span, written: &str) -> Diagnostic {
    Diagnostic::new(Code::E0116, format!("a decimal comma in `{}`", quote(written)))
        .label(span, "numbers use a decimal point")
        .help(format!("write `{}`", quote(&written.replacen(',', ".", 1))))
        .with_fix_here(written.replacen(',', ".", 1))
}

/// The decimal commas in a place such as `(3,2 um, 5,9 um)`: each follows a whole number without a unit, has no space
/// around it, and precedes digits with a unit.
pub(super) fn decimal_commas(values: &[Expr], source: &str) -> Vec<Span> {
    let is_whole =
        |value: &Expr| matches!(&value.kind, ExprKind::Number(digits) if digits.bytes().all(|b| b.is_ascii_digit()));
    let has_unit = |value: &Expr| matches!(&value.kind, ExprKind::Quantity { .. });
    let pairs = values.windows(2).filter(|pair| is_whole(&pair[0]) && has_unit(&pair[1]));
    let between = pairs.map(|pair| part(pair[0].span, pair[0].span.end as usize, pair[1].span.start as usize));
    let commas: Vec<Span> = between.filter(|between| source[between.range()] == *",").collect();
    if (2..=3).contains(&(values.len() - commas.len())) { commas } else { Vec::new() }
}

/// A place with decimal commas.
pub(super) fn comma_coordinates(place: Span, commas: &[Span], source: &str) -> Diagnostic {
    let mut fixed = source[place.range()].to_owned();
    for comma in commas {
        let at = (comma.start - place.start) as usize;
        fixed.replace_range(at..=at, ".");
    }
    let finding = Diagnostic::new(Code::E0116, "decimal commas in a place").label(place, "numbers use a decimal point");
    let finding = finding.help(format!("write `{}`", quote(&fixed)));
    commas.iter().fold(finding, |finding, comma| finding.with_fix(*comma, "."))
}

/// `1,000`, which may mean a thousand or one.
pub(super) fn thousands_comma(span: Span, written: &str) -> Diagnostic {
    let [thousand, one] = ["", "."].map(|sign| written.replacen(',', sign, 1));
    Diagnostic::new(Code::E0116, format!("a comma in the number `{}`", quote(written)))
        .label(span, "a thousands separator or a decimal comma?")
        .help(format!("write `{}` or `{}`", quote(&thousand), quote(&one)))
}

/// `task fetch on bot:`, with a block that is indented or closed by `}`; `mark` is the colon, `head` the line.
pub(super) fn colon_for_brace(mark: Span, head: &str) -> Diagnostic {
    let head = head.trim_end_matches(':').trim_end();
    Diagnostic::new(Code::E0124, "`:` where `{` belongs")
        .label(mark, "a block is enclosed in braces, whatever its indentation")
        .help(format!("write `{} {{`, and `}}` where the block ends", quote(head)))
}

/// A file whose lines end in CR only.
pub(super) fn carriage_returns(first: Span) -> Diagnostic {
    Diagnostic::new(Code::E0118, "the lines of this file end in a carriage return alone")
        .label(first, "the whole file reads as one line")
        .help("save it with LF or CRLF line endings")
}

/// A file that contains no Tweeze at all.
pub(super) fn not_a_program(first: Span) -> Diagnostic {
    Diagnostic::new(Code::E0101, "this does not look like a Tweeze program")
        .label(first, "no line begins a declaration")
        .help("choose another file; a program has lines such as `use std.dimibot` and `task fetch on bot { … }`")
}
