//! Fragments that no rule could read: their diagnostics, and the parts that can be recovered.

use super::context;
use super::errors::{self, ListPlace};
use super::foreign_syntax;
use super::foreign_words;
use super::grammar::{Grammar, Node, Rule};
use super::heads;
use super::known_mistakes;
use super::loops;
use super::reader::Reader;
use super::tree::{Doc, Expr, Ident, Item};
use super::unexpected_tokens;
use super::words::PREPOSITIONS;
use super::words::{is_word, takes_block};
use crate::diagnostic::{Code, Diagnostic, SourceEdit};
use crate::source::Span;
use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};

/// The words that begin a declaration, with the rule for what follows each.
const ITEMS: [(&str, Rule); 9] = [
    ("use", Rule::use_rest),
    ("let", Rule::let_rest),
    ("device", Rule::device_rest),
    ("instrument", Rule::instrument_rest),
    ("output", Rule::output_rest),
    ("scene", Rule::scene_rest),
    ("task", Rule::task_rest),
    ("program", Rule::program_rest),
    ("wiring", Rule::wiring_rest),
];

/// Steps that every kind of device has: a second one on a line begins a second step.
const COMMON_HEADS: [&str; 10] =
    ["run", "wait", "pulse", "set", "together", "assay", "minimize", "require", "using", "start"];

/// Words that import a file, here and in other languages.
const USES: [&str; 4] = ["use", "import", "include", "from"];

/// Greatest number of wrong letters in a misspelt word.
const MISSPELT: usize = 2;

/// The declaration word that was probably meant.
fn intended_declaration(word: &str) -> Option<(&'static str, Rule)> {
    let word = word.to_lowercase();
    let distance = |item: &(&str, Rule)| strsim::osa_distance(&word, item.0);
    let near = ITEMS.into_iter().min_by_key(distance)?;
    let limit = MISSPELT.min(near.0.len() / 2);
    (distance(&near) <= limit).then_some(near)
}

impl Reader<'_> {
    /// Reports an entry of a block that could not be read.
    pub fn bad_entry(&mut self, node: &Node, place: ListPlace) {
        let span = self.trimmed(node);
        let text = &self.source[span.range()];
        let word = context::token_at(text, 0);
        if ITEMS.iter().any(|item| item.0 == word) {
            self.keep_name(span);
        }
        if foreign_words::help(word).is_some() {
            return self.foreign_word(word.len(), span);
        }
        if Self::has_hole(node) {
            return;
        }
        let finding = match word {
            "for" if place != ListPlace::Fields => {
                // Uses of the loop's counter in its body must not be reported as well.
                self.keep_name(span);
                let closes = self.rest_of_loop(span);
                loops::diagnose(span, closes, self.source)
            }
            "let" => errors::let_in_block(span, text),
            _ if ITEMS.iter().any(|item| item.0 == word) => errors::item_in_block(span, word),
            _ if PREPOSITIONS.contains(&word) => errors::lonely_preposition(span, word),
            _ if word.starts_with(['+', '-', '*', '/', '^', '<', '>', '=']) => errors::lonely_operator(span, word),
            _ if wants_more(text) => errors::missing_value(span.after(), self.source),
            _ => self.diagnose(span, place),
        };
        self.report(finding);
    }

    /// Skips the rest of the line of an unreadable loop, and the `}` of a block that it did not open; returns whether
    /// there is such a `}`.
    fn rest_of_loop(&mut self, span: Span) -> bool {
        let line = &self.source[span.start as usize..];
        let line = line.lines().next().unwrap_or_default();
        let end = (span.start as usize + line.len()).max(span.end as usize);
        self.forget_within(context::part(span, span.start as usize, end));
        self.covered_until = end as u32;
        !self.source[span.range()].contains('{') && !line.contains('{') && self.forget_stray_brace(span.end)
    }

    /// Drops the finding about the first `}` after a position where the matching `{` is missing; returns whether there
    /// was one.
    pub fn forget_stray_brace(&mut self, behind: u32) -> bool {
        let is_stray = |finding: &Diagnostic| {
            finding.code == Code::E0112
                && finding.span().is_some_and(|at| at.start >= behind && self.source[at.range()] == *"}")
        };
        self.findings.iter().position(is_stray).map(|stray| self.findings.remove(stray)).is_some()
    }

    /// Reports words that begin no declaration; a declaration whose first word is misspelt is still read.
    pub fn bad_item(&mut self, node: &Node, doc: Doc) -> Option<Item> {
        let span = self.trimmed(node);
        let text = &self.source[span.range()];
        let word = context::token_at(text, 0);
        let known = ITEMS.iter().find(|item| item.0 == word);
        if known.is_some() || Self::has_hole(node) {
            self.keep_name(span);
        }
        if foreign_words::help(word).is_some() {
            if USES.contains(&word) {
                self.keep_name(span);
            }
            self.foreign_word(word.len(), span);
            return None;
        }
        if Self::has_hole(node) {
            return None;
        }
        if let Some((_, rule)) = known {
            let line = text.lines().next().unwrap_or_default().trim_end();
            if line.ends_with(':') && takes_block(line) {
                let at = span.start as usize + line.len();
                self.report(known_mistakes::colon_for_brace(context::part(span, at - 1, at), line));
                return None;
            }
            if wants_more(text) {
                self.report(errors::missing_value(span.after(), self.source));
                return None;
            }
            let place = self.stop(Rule::one_item, span).map_or(span.start as usize, |(at, _)| at);
            let token = context::token_at(&self.source[..span.end as usize], place);
            let rest = context::part(span, place, place + token.len());
            if let Some(slip) =
                known_mistakes::device_without_kind(span, text).or_else(|| heads::wire_without_braces(span, text))
            {
                self.report(slip);
                return None;
            }
            let finding = match rule {
                Rule::use_rest => {
                    heads::of_use(span, text).unwrap_or_else(|| errors::bad_short_item(rest, *rule, self.source))
                }
                Rule::let_rest => match foreign_syntax::list(span, place, self.source) {
                    Some(habit) => {
                        self.forget_within(span);
                        habit
                    }
                    None => known_mistakes::foreign_comment(span, text)
                        .or_else(|| known_mistakes::sort_of_let(span, text))
                        .unwrap_or_else(|| errors::bad_short_item(rest, *rule, self.source)),
                },
                _ => foreign_syntax::name(context::part(span, place, span.end as usize), self.source)
                    .unwrap_or_else(|| errors::bad_head(rest, *rule, span, self.source)),
            };
            self.keep_mended_name(&finding);
            self.report(finding);
            return None;
        }
        match intended_declaration(word) {
            Some((right, rule)) if text[word.len()..].starts_with([' ', '\t']) => {
                let finding = errors::misspelt_item(span, text, right);
                self.report(finding);
                self.read_rest(rule, span, word.len(), doc)
            }
            _ => {
                self.unknown_item(span);
                None
            }
        }
    }

    fn unknown_item(&mut self, span: Span) {
        let text = &self.source[span.range()];
        let mut words = text.split([' ', '\t']).filter(|word| !word.is_empty()).skip(1);
        let slip = known_mistakes::comment(span, text).or_else(|| known_mistakes::field_outside(span, text));
        if let Some(slip) = slip.or_else(|| foreign_syntax::import(span, text)) {
            if USES.contains(&context::token_at(text, 0)) {
                self.keep_name(span);
            }
            return self.report(slip);
        }
        let finding = match words.next() {
            Some("=" | ":=") if text.starts_with(is_word) => errors::value_without_let(span, text),
            Some(second) if text.contains('{') && second.starts_with(is_word) => errors::unknown_item(span, text),
            _ => errors::not_an_item(span, text),
        };
        if matches!(finding.code, Code::E0111) {
            self.keep_name(span);
        }
        self.report(finding);
    }

    /// Reads what follows a misspelt first word, if it is a whole declaration.
    fn read_rest(&mut self, rule: Rule, span: Span, skip: usize, doc: Doc) -> Option<Item> {
        let start = span.start as usize + skip;
        let rest = &self.text[start..span.end as usize];
        let node = Grammar::parse(rule, rest).ok().and_then(|mut nodes| nodes.next());
        let Some(node) = node.filter(|node| node.as_span().end() == rest.len()) else {
            self.keep_name(span);
            return None;
        };
        let outer = std::mem::replace(&mut self.origin.base, start);
        let item = self.declaration(node, doc, span);
        self.origin.base = outer;
        item
    }

    /// Keeps the corrected name of a declaration whose written name is invalid.
    pub fn keep_mended_name(&mut self, finding: &Diagnostic) {
        if let (Code::E0110, [SourceEdit { span, text }]) = (finding.code, finding.fix.as_slice()) {
            self.broken_names.push(Ident { text: text.clone(), span: *span });
        }
    }

    /// Keeps the name that a broken declaration would have declared: its second word, the word before a `=`, or the
    /// last word of a `use`.
    fn keep_name(&mut self, span: Span) {
        let text = &self.source[span.range()];
        let first = context::token_at(text, 0);
        if USES.contains(&first) {
            let line = text.lines().next().unwrap_or_default().trim_end();
            let name = &line[line.trim_end_matches(is_word).len()..];
            let end = span.start as usize + line.len();
            let place = context::part(span, end - name.len(), end);
            return self.broken_names.push(Ident { text: name.to_owned(), span: place });
        }
        let second =
            first.len() + (text[first.len()..].len() - text[first.len()..].trim_start_matches([' ', '\t']).len());
        let word = context::token_at(text, second);
        let (at, name) = if word.starts_with(is_word) { (second, word) } else { (0, first) };
        if name.starts_with(is_word) {
            let start = span.start as usize + at;
            let place = context::part(span, start, start + name.len());
            self.broken_names.push(Ident { text: name.to_owned(), span: place });
        }
    }

    /// Keeps the name of an object that has a superfluous word before it.
    pub fn keep_name_behind(&mut self, object: Span) {
        let text = &self.source[object.range()];
        let Some(word) = text.split([' ', '\t']).filter(|word| !word.is_empty()).nth(2) else { return };
        let at = object.start as usize + (word.as_ptr() as usize - text.as_ptr() as usize);
        let name = &word[..super::words::end_of_word(word, 0)];
        self.broken_names.push(Ident { text: name.to_owned(), span: context::part(object, at, at + name.len()) });
    }

    /// Reports a construct of another language as one mistake and drops the findings inside it.
    pub fn foreign_word(&mut self, length: usize, span: Span) {
        self.forget_within(span);
        let word = &self.source[span.range()][..length];
        let follows_if = self.findings.iter().any(|finding| finding.code == Code::E0122);
        if matches!(word, "else" | "elif" | "elseif" | "end" | "endfor" | "done") && follows_if {
            return;
        }
        let start = span.start as usize;
        let word = context::part(span, start, start + length);
        let finding = errors::foreign_word(word, self.source);
        self.report(finding);
    }

    /// Drops the findings inside a span and those about a `;` after it.
    pub fn forget_within(&mut self, span: Span) {
        let rest = &self.source[span.end as usize..];
        let behind = rest.len() - rest.trim_start_matches([' ', '\t', ';']).len();
        let span = context::part(span, span.start as usize, span.end as usize + behind);
        self.findings.retain(|finding| !finding.span().is_some_and(|place| span.contains(place)));
    }

    /// Drops the findings of one code inside a span.
    pub fn forget_code(&mut self, code: Code, span: Span) {
        self.findings.retain(|finding| finding.code != code || finding.span().is_none_or(|at| !span.contains(at)));
    }

    /// General finding for an unreadable fragment: where parsing stopped and what was expected there.
    fn diagnose(&mut self, span: Span, place: ListPlace) -> Diagnostic {
        let text = &self.source[span.range()];
        if let Some(slip) = known_mistakes::entry(span, place, self.source) {
            return slip;
        }
        if place == ListPlace::Steps
            && let Some(at) = second_step(text)
        {
            let mark = context::part(span, span.start as usize + at, span.start as usize + at);
            return errors::joined(mark, self.source);
        }
        if place == ListPlace::Fields
            && let Some(name) = field_without_colon(text)
        {
            return known_mistakes::blank_in_name(span, text)
                .unwrap_or_else(|| errors::missing_colon(span, name, text));
        }
        if let Some((at, inner)) = value_without_colon(text) {
            let start = span.start as usize + at;
            return errors::missing_colon(
                context::part(span, start, start + inner.len()),
                context::token_at(inner, 0),
                inner,
            );
        }
        let rule = match place {
            ListPlace::Fields => Rule::one_field,
            ListPlace::Scene => Rule::one_object,
            ListPlace::Steps => Rule::one_step,
            ListPlace::Wires => Rule::one_wire,
        };
        match self.stop(rule, span) {
            Some((at, wants_value)) if at > span.start as usize => {
                let open = open_bracket(&self.text[span.start as usize..at]);
                known_mistakes::in_value(span, at, open, self.source)
                    .unwrap_or_else(|| unexpected_tokens::stopped(span, at, wants_value, open, self.source))
            }
            _ => errors::not_an_entry(span, place, self.source),
        }
    }

    /// Where parsing of a fragment stops, and whether a value was expected there.
    fn stop(&self, rule: Rule, span: Span) -> Option<(usize, bool)> {
        let text = &self.text[span.range()];
        let error = Grammar::parse(rule, text).err()?;
        let at = match error.location {
            InputLocation::Pos(at) | InputLocation::Span((at, _)) => at,
        };
        let wants_value = match &error.variant {
            ErrorVariant::ParsingError { positives, .. } => {
                positives.iter().any(|rule| matches!(rule, Rule::quantity | Rule::number | Rule::tuple | Rule::expr))
            }
            ErrorVariant::CustomError { .. } => false,
        };
        let at = at + (text[at..].len() - text[at..].trim_start().len());
        Some((self.source.floor_char_boundary(span.start as usize + at), wants_value))
    }

    pub(super) fn trimmed(&self, node: &Node) -> Span {
        let span = self.span(node);
        let text = &self.text[span.range()];
        let start = span.start as usize + (text.len() - text.trim_start().len());
        let code = context::code_end_before(self.text, span.end as usize);
        context::part(span, self.source.floor_char_boundary(start), self.source.ceil_char_boundary(code.max(start)))
    }

    /// Result for a text that pest gave up on.
    pub fn unreadable(&mut self) -> (Doc, Vec<Item>) {
        let whole = Span::new(self.file, 0, self.text.len());
        if self.findings.is_empty() {
            self.report(errors::unreadable(whole));
        }
        (None, vec![Item::Error(whole)])
    }

    /// Result for a text that is not a value.
    pub fn no_value(&mut self) -> Option<Expr> {
        if self.findings.is_empty() {
            let whole = Span::new(self.file, 0, self.text.len());
            self.report(errors::not_a_value(whole, self.source));
        }
        None
    }
}

/// Whether a text ends with a sign that must be followed by a value.
fn wants_more(text: &str) -> bool {
    text.ends_with(['+', '-', '*', '/', '^', '<', '>', '=', ':'])
}

/// Where a second step begins on a line: at the word that began the first, or at one that begins a step on every
/// device.
fn second_step(text: &str) -> Option<usize> {
    let head = context::token_at(text, 0);
    let line = text.lines().next().unwrap_or("");
    let mut depth = 0_i32;
    let mut at = head.len();
    while at < line.len() {
        let token = context::token_at(line, at);
        match token {
            "(" | "[" | "{" => depth += 1,
            ")" | "]" | "}" => depth -= 1,
            _ if depth == 0 && (token == head || COMMON_HEADS.contains(&token)) && line[..at].ends_with(' ') => {
                return Some(at);
            }
            _ => {}
        }
        at += token.len();
    }
    None
}

/// The name of a field whose colon is missing: a word, spaces, and a value.
pub(super) fn field_without_colon(text: &str) -> Option<&str> {
    let name = context::token_at(text, 0);
    let rest = &text[name.len()..];
    let value = rest.trim_start_matches([' ', '\t']);
    let is_value = value.starts_with(|c: char| is_word(c) || matches!(c, '(' | '[' | '"' | '-'));
    (name.starts_with(is_word) && value.len() < rest.len() && is_value).then_some(name)
}

/// The first field inside a value such as `disc { radius 1 um }` that lacks its colon, with the offset at which it
/// begins.
fn value_without_colon(text: &str) -> Option<(usize, &str)> {
    text.match_indices('{').find_map(|(brace, _)| {
        let before = text[..brace].trim_end();
        let head = before.trim_end_matches(|c| is_word(c) || c == '.');
        // After `a : disc {` a brace holds fields; elsewhere it holds steps, objects or rows.
        let has_fields = head.len() < before.len()
            && head.trim_end().ends_with([':', '='])
            && !matches!(&before[head.len()..], "table");
        let inner = text[brace + 1..].trim_start();
        let end = inner.find(['}', ',', '\n']).unwrap_or(inner.len());
        let field = inner[..end].trim_end();
        (has_fields && field_without_colon(field).is_some()).then(|| (text.len() - inner.len(), field))
    })
}

/// The innermost bracket that is open at the end of a text.
fn open_bracket(text: &str) -> Option<char> {
    let mut open = Vec::new();
    for c in text.chars() {
        match c {
            '(' | '[' | '{' => open.push(c),
            ')' | ']' | '}' => drop(open.pop()),
            _ => {}
        }
    }
    open.pop()
}
