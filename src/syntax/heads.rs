//! Mistakes in the heads of declarations, between the name and the block.

use super::context::{self, part, quote, token_at, token_before};
use super::grammar::Rule;
use super::words::{PARAMETER_SORTS, end_of_word, is_name, is_word};
use super::{foreign_syntax, known_mistakes, unexpected_tokens};
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

/// Bytes at the beginning of a file that are searched for the intended device: a file may be large and have many broken
/// heads.
const SEARCH_WINDOW_BYTES: usize = 1 << 16;

/// The names that the beginning of a file declares with a given word, such as `device `.
fn declared<'s>(source: &'s str, by: &'static str) -> impl Iterator<Item = &'s str> {
    let seen = &source[..source.floor_char_boundary(SEARCH_WINDOW_BYTES)];
    seen.lines().filter_map(move |line| line.strip_prefix(by)).map(|name| token_at(name.trim_start(), 0))
}

/// The devices declared at the beginning of a file.
fn devices(source: &str) -> impl Iterator<Item = &str> {
    declared(source, "device ")
}

/// `use std.dimibot lab`, `use std/dimibot as lab`, `use std::dimibot`.
pub(super) fn of_use(span: Span, text: &str) -> Option<Diagnostic> {
    let line = text.lines().next()?.trim_end();
    let written = line.strip_prefix("use")?.trim_start();
    let (path, behind) = match written.strip_prefix('"') {
        Some(inside) => written.split_at(inside.find('"')? + 2),
        None => written.split_at(written.find([' ', '\t']).unwrap_or(written.len())),
    };
    let words: Vec<&str> = behind.split_whitespace().collect();
    let alias = match words[..] {
        [] => String::new(),
        ["as"] => return Some(without_alias(span, line)),
        [alias] | ["as" | "=" | "->" | "named", alias] if alias.chars().all(is_word) => format!(" as {alias}"),
        _ => return None,
    };
    let path = if path.starts_with('"') { path.to_owned() } else { path.replace("::", ".").replace(['/', '\\'], ".") };
    let is_path = path.starts_with('"') || path.split('.').all(|word| !word.is_empty() && word.chars().all(is_word));
    let fixed = format!("use {path}{alias}");
    (is_path && fixed != line).then(|| {
        let start = span.start as usize + (line.len() - written.len());
        Diagnostic::new(Code::E0124, "a `use` in the style of another language")
            .label(
                part(span, start, span.start as usize + line.len()),
                "expected a file, with `as` before another name for it",
            )
            .help(format!("write `{}`", quote(&fixed)))
            .with_fix_here(&fixed["use ".len()..])
    })
}

/// `use std.dimibot as`.
fn without_alias(span: Span, line: &str) -> Diagnostic {
    let end = span.start as usize + line.len();
    let path = quote(line.trim_end_matches("as").trim_end());
    Diagnostic::new(Code::E0124, "a `use` ends with `as`")
        .label(part(span, end - "as".len(), end), "expected a name after this")
        .help(format!("write `{path} as NAME`, or `{path}` alone"))
}

/// `wiring bot -> card`.
pub(super) fn wire_without_braces(span: Span, text: &str) -> Option<Diagnostic> {
    let line = text.lines().next()?;
    let (wiring, output) = line.split_once("->").filter(|(wiring, _)| wiring.starts_with("wiring "))?;
    let at = span.start as usize + wiring.len();
    let finding = Diagnostic::new(Code::E0124, "a wire without braces around it");
    let finding = finding.label(part(span, at, at + "->".len()), "wires belong in the braces of a wiring");
    Some(finding.help(format!("write `{} {{ all -> {} }}`", quote(wiring.trim_end()), quote(output.trim()))))
}

/// The first word of a declaration, repeated in place of its name.
pub(super) fn word_twice(word: Span, source: &str) -> Diagnostic {
    let text = quote(&source[word.range()]);
    Diagnostic::new(Code::E0101, format!("`{text}` is repeated"))
        .label(word, "expected a name")
        .help(format!("write `{text}` once"))
        .with_fix(part(word, word.start as usize, context::blanks_end(source, word.end as usize)), "")
}

/// Diagnoses a known mistake in the head of a declaration; `rest` is the part that could not be read.
pub(super) fn diagnose(rest: Span, rule: Rule, item: Span, source: &str) -> Option<Diagnostic> {
    let written = &source[rest.range()];
    // The parameters were read, so the mistake is after them.
    let behind = written.trim_start().starts_with('(').then(|| written.find(')')).flatten().map_or(0, |at| at + 1);
    let start = rest.start as usize + (written.len() - written[behind..].trim_start().len());
    let before = quote(source[item.start as usize..start].trim_end());
    let head = BrokenHead { rest, start, text: written[behind..].trim(), before, source };
    if let Some(habit) = foreign_syntax::name(part(rest, start, rest.end as usize), source) {
        return Some(habit);
    }
    if let Some(slip) = device_in_brackets(rest, behind, rule, source) {
        return Some(slip);
    }
    if let Some(slip) = parameter(rest, behind, rule, source) {
        return Some(slip);
    }
    if head.text.starts_with('(') {
        return Some(head.wrong("`(` where `{` belongs", 1, "a block is enclosed in braces", "{"));
    }
    match rule {
        Rule::device_rest if head.text.is_empty() => known_mistakes::device_without_kind(item, &source[item.range()]),
        Rule::device_rest => head.of_base("a device and its kind"),
        Rule::instrument_rest => head.of_base("an instrument and its family"),
        Rule::output_rest => head.of_output(),
        Rule::program_rest => head.of_program(),
        Rule::task_rest => head.of_task(),
        _ => None,
    }
}

/// `task go(bot) { … }`, where `bot` is a device; the brackets end at byte `behind` of the rest.
fn device_in_brackets(rest: Span, behind: usize, rule: Rule, source: &str) -> Option<Diagnostic> {
    let written = source[rest.range()][..behind].trim_start();
    let device = written.strip_prefix('(')?.strip_suffix(')')?.trim();
    let end = rest.start as usize + behind;
    let brackets = part(rest, end - written.len(), end);
    (rule == Rule::task_rest && devices(source).any(|known| known == device)).then(|| {
        Diagnostic::new(Code::E0124, "the device of a task in brackets")
            .label(brackets, format!("`{device}` is a device"))
            .help(format!("write `on {device}`: brackets hold parameters, as in `task go(goal: cell) on {device}`"))
            .with_fix(brackets, format!(" on {device}"))
    })
}

/// `task go(goal) on bot`, `task go(cell goal)`, `task go(goal = (1, 2))`: diagnoses the first invalid parameter.
fn parameter(rest: Span, behind: usize, rule: Rule, source: &str) -> Option<Diagnostic> {
    let written = &source[rest.range()][..behind];
    let open = written.find('(').filter(|_| matches!(rule, Rule::task_rest | Rule::program_rest))? + 1;
    let mut at = rest.start as usize + open;
    for entry in written[open..].strip_suffix(')')?.split(',') {
        let text = entry.trim();
        let start = at + (entry.len() - entry.trim_start().len());
        at += entry.len() + 1;
        let is_sound = text.split_once(':').is_some_and(|(name, sort)| is_name(name.trim()) && is_name(sort.trim()));
        if text.is_empty() || is_sound {
            continue;
        }
        let place = part(rest, start, start + text.len());
        let finding = Diagnostic::new(Code::E0124, format!("`{}` is not a valid parameter", quote(text)));
        let finding = finding.label(place, "expected `NAME: SORT`");
        let words: Vec<&str> = text.split_whitespace().collect();
        let name = &text[..end_of_word(text, 0)];
        return Some(match words[..] {
            [first, second] if is_name(first) && is_name(second) => {
                let (name, sort) = match first {
                    "int" | "float" | "double" | "real" => (second, "number"),
                    _ if PARAMETER_SORTS.contains(&first) => (second, first),
                    _ => (first, second),
                };
                finding.help(format!("write `{name}: {sort}`")).with_fix_here(format!("{name}: {sort}"))
            }
            _ if text.contains('=') && is_name(name) => finding.help(format!(
                "write `{name}: SORT`, with a sort such as `cell` or `time`: a parameter gets its value from `run`"
            )),
            _ => finding.help(format!(
                "write `{}: SORT`, with a sort such as `number`, `time`, `cell` or `pose`",
                if is_name(name) { name } else { "NAME" }
            )),
        });
    }
    None
}

/// Whether a text begins with a field: a name and a colon.
fn field_of(text: &str) -> bool {
    let name = text.trim_start();
    name.split_once(':').is_some_and(|(name, _)| is_name(name.trim_end()))
}

/// A text without the English article before a name; `a` may itself be a name.
fn without_article(text: &str) -> &str {
    let word = token_at(text, 0);
    let rest = text[word.len()..].trim_start();
    if matches!(word, "the" | "an" | "a") && rest.starts_with(is_word) { rest } else { text }
}

/// The unread rest of a head.
struct BrokenHead<'s> {
    rest: Span,
    /// Where `text` begins in the file.
    start: usize,
    /// The rest without the spaces around it.
    text: &'s str,
    /// The declaration up to there, as messages quote it.
    before: String,
    source: &'s str,
}

impl BrokenHead<'_> {
    /// A span within the text.
    fn mark(&self, at: usize, length: usize) -> Span {
        part(self.rest, self.start + at, self.start + at + length)
    }

    /// Diagnoses the first `length` bytes of the text; the help replaces the text with `fix`.
    fn wrong(&self, title: &str, length: usize, note: &str, fix: &str) -> Diagnostic {
        let finding = Diagnostic::new(Code::E0124, title).label(self.mark(0, length), note);
        finding.help(format!("write `{} {fix}`", self.before))
    }

    /// `device bot = dimibot`, `device bot dimibot {`, `device bot : dimibot(left: 5)`,
    /// `device bot : dimibot left: 5 }`; `both` names what stands on either side of the colon.
    fn of_base(&self, both: &str) -> Option<Diagnostic> {
        let note = format!("`:` goes between {both}");
        let word = token_at(self.text, 0);
        let behind = self.text[word.len()..].trim_start();
        if matches!(word, "is" | "as" | "of" | "=") && behind.starts_with(is_word) {
            let base = without_article(behind);
            let length = self.text.len() - behind.len();
            let title = format!("`{word}` where `:` belongs");
            let finding = self.wrong(&title, word.len(), &note, &format!(": {}", quote(base)));
            return Some(match behind.len() - base.len() {
                0 => finding.with_fix_here(":"),
                article => finding.with_fix(self.mark(0, length + article), ": "),
            });
        }
        if self.text.starts_with(is_word) {
            let behind = self.text.trim_start_matches(|c| is_word(c) || c == '.');
            let base = &self.text[..self.text.len() - behind.len()];
            let finding = self.wrong("`:` is missing", word.len(), &note, &format!(": {}", quote(base)));
            return Some(if behind.is_empty() { finding.with_fix(self.mark(0, 0), ": ") } else { finding });
        }
        let base = self.text.strip_prefix(':')?.trim_start();
        if without_article(base).len() < base.len() {
            return Some(self.article(self.text.len() - base.len()));
        }
        let base = &base[..base.len() - base.trim_start_matches(|c| is_word(c) || c == '.').len()];
        let behind_base = self.text.find(base)? + base.len();
        if field_of(&self.text[behind_base..]) {
            let finding = Diagnostic::new(Code::E0124, "`{` is missing");
            let finding =
                finding.label(self.mark(behind_base - base.len(), base.len()), "expected fields in braces after this");
            return Some(
                finding
                    .help(format!("write `{} : {base} {{ {}", self.before, quote(self.text[behind_base..].trim())))
                    .with_fix(self.mark(behind_base, 0), " {"),
            );
        }
        let at = self.text.find('(')?;
        let fields = self.text[at + 1..].trim_end().trim_end_matches(')').trim();
        let finding = Diagnostic::new(Code::E0124, "`(` where `{` belongs");
        let finding = finding.label(self.mark(at, 1), "fields are enclosed in braces");
        let base = self.text[..at].trim_end();
        Some(finding.help(format!("write `{} {base} {{ {} }}`", self.before, quote(fields))))
    }

    /// Diagnoses an article at a byte of the text.
    fn article(&self, at: usize) -> Diagnostic {
        unexpected_tokens::article(self.mark(at, token_at(&self.text[at..], 0).len()), self.source)
    }

    /// `output camera : trigger 5 ms -> "Dev1/pfi0"`.
    fn of_output(&self) -> Option<Diagnostic> {
        let (sort, wire) = self.text.strip_prefix(':')?.split_once("->")?;
        let (sort, figure) = sort.trim().split_once(' ').unwrap_or((sort.trim(), ""));
        let fields = if figure.is_empty() { String::new() } else { format!(" {{ duration: {} }}", figure.trim()) };
        let name = self.before.split_whitespace().nth(1).unwrap_or("NAME");
        let declaration = format!("{} : {}{}", self.before, quote(sort), quote(&fields));
        let wire = quote(wire.trim());
        let finding = Diagnostic::new(Code::E0124, "a wire in the declaration of an output");
        let finding = finding.label(self.mark(self.text.find("->")?, "->".len()), "wires belong in a `wiring`");
        Some(finding.help(format!("write `{declaration}`, and `wiring {name} {{ out -> {wire} }}`")))
    }

    /// `program day on bot`.
    fn of_program(&self) -> Option<Diagnostic> {
        let device = self.text.strip_prefix("on")?.trim_start();
        let length = self.text.len() - device.len() + end_of_word(device, 0);
        let finding =
            self.wrong("a program on a device", length, "a program has no device of its own; its tasks have", "{");
        Some(finding.with_fix(context::with_blanks(self.mark(0, length), self.source), " "))
    }

    /// `task go`, `task go in bench`, `task go with bot`, and mistakes after `on`.
    fn of_task(&self) -> Option<Diagnostic> {
        let word = token_at(self.text, 0);
        if word.is_empty() {
            return Some(self.without_device());
        }
        if word == "in" {
            let (scene, device) = self.text.split_once(" on ").unwrap_or((self.text, "DEVICE"));
            let fix = format!("on {} {} {{", quote(device.trim()), quote(scene));
            let note = "expected `on` and a device before this";
            return Some(self.wrong("a task without its device", word.len(), note, &fix));
        }
        if let Some(finding) = self.lacking(0, "on", devices(self.source)) {
            return Some(finding);
        }
        let device = self.text[word.len()..].trim_start();
        if word == "on" && token_at(device, 0) == "in" {
            let first = devices(self.source).next();
            let fix = format!("on {} {} {{", quote(first.unwrap_or("DEVICE")), quote(device));
            let finding = self.wrong("a task without its device", word.len(), "expected a device after this", &fix);
            return Some(match first {
                Some(first) => finding.with_fix(self.mark(word.len(), 0), format!(" {first}")),
                None => finding,
            });
        }
        if word == "on" && without_article(device).len() < device.len() {
            return Some(self.article(self.text.len() - device.len()));
        }
        if word != "on" {
            let first = token_before(self.source, self.start);
            if token_at(device, 0) == "on" && word.starts_with(is_word) {
                let name = format!("{first}_{word}");
                let end = self.source[..self.start].trim_end().len();
                let finding = Diagnostic::new(Code::E0110, format!("a name of two words, `{first} {word}`"));
                let finding = finding
                    .label(part(self.rest, end - first.len(), self.start + word.len()), "names contain no spaces");
                return Some(finding.help(format!("write `task {name} {}`", quote(device))).with_fix_here(name));
            }
            let title = format!("`{word}` where `on` belongs");
            let fix = format!("on {} {{", quote(device));
            let finding = self.wrong(&title, word.len(), "a task runs `on` a device", &fix);
            return word.starts_with(is_word).then(|| finding.with_fix_here("on"));
        }
        let after = device.trim_start_matches(|c| is_word(c) || c == '.').trim_start();
        self.behind_device(self.text.len() - after.len())
    }

    /// `task go bot`, `task go onbot`: a name declared in the file, without the word that belongs before it.
    fn lacking<'n>(&self, at: usize, before: &str, mut names: impl Iterator<Item = &'n str>) -> Option<Diagnostic> {
        let word = token_at(&self.text[at..], 0);
        let named = word.strip_prefix(before).filter(|name| !name.is_empty()).unwrap_or(word);
        names.find(|name| *name == named || *name == word)?;
        let is_joined = named.len() < word.len();
        let rest = &self.text[at + word.len() - named.len()..];
        let title = format!("`{word}` without `{before}` before it");
        let note = if is_joined {
            format!("expected a space after `{before}`")
        } else {
            format!("expected `{before}` before this")
        };
        let head = quote(&self.text[..at]);
        let finding = Diagnostic::new(Code::E0124, title).label(self.mark(at, word.len()), note).help(format!(
            "write `{} {head}{before} {} {{`",
            self.before,
            quote(rest.trim_end())
        ));
        Some(match is_joined {
            true => finding.with_fix(self.mark(at, word.len()), format!("{before} {named}")),
            false => finding.with_fix(self.mark(at, 0), format!("{before} ")),
        })
    }

    /// `task go { … }`: proposes the first device of the file.
    fn without_device(&self) -> Diagnostic {
        let device = devices(self.source).next();
        let end = self.source[..self.start].trim_end().len();
        let last = token_before(self.source, end).len().max(1);
        let finding = Diagnostic::new(Code::E0124, "a task without its device")
            .label(part(self.rest, end - last, end), "expected `on` and a device after this")
            .help(format!("write `{} on {} {{`", self.before, quote(device.unwrap_or("DEVICE"))));
        match device {
            Some(device) => finding.with_fix(part(self.rest, end, end), format!(" on {device}")),
            None => finding,
        }
    }

    /// Diagnoses what follows the device, from a byte of the text on.
    fn behind_device(&self, at: usize) -> Option<Diagnostic> {
        let after = &self.text[at..];
        let word = token_at(after, 0);
        if let Some(habit) = foreign_syntax::name(part(self.rest, self.start + at, self.rest.end as usize), self.source)
        {
            return Some(habit);
        }
        if word == "," {
            let finding = Diagnostic::new(Code::E0124, "a task on several devices");
            let finding = finding.label(self.mark(at, 1), "a task runs on one device");
            return Some(
                finding.help("write a task for each, and run them with `together { run A, run B }` in a program"),
            );
        }
        let scene = after[word.len()..].trim_start();
        if word == "in" && without_article(scene).len() < scene.len() {
            return Some(self.article(self.text.len() - scene.len()));
        }
        if !word.starts_with(is_word) || word == "in" {
            return None;
        }
        if let Some(finding) = self.lacking(at, "in", declared(self.source, "scene ")) {
            return Some(finding);
        }
        let fix = format!("{} {}in {} {{", self.before, &self.text[..at], quote(scene));
        Some(
            Diagnostic::new(Code::E0124, format!("`{word}` where `in` belongs"))
                .label(self.mark(at, word.len()), "a task runs `in` a scene")
                .help(format!("write `{fix}`"))
                .with_fix_here("in"),
        )
    }
}
