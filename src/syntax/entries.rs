//! Content of blocks: fields, objects, steps, wires, and loops over them.

use super::context::{self, token_at};
use super::errors;
use super::foreign_syntax;
use super::functions::is_function;
use super::grammar::{Node, Rule};
use super::known_mistakes;
use super::lexical::is_quote;
use super::reader::Reader;
use super::recover;
use super::tree::{
    Doc, Entry, Expr, ExprKind, Field, For, Ident, Object, Path, Phrase, SceneEntry, Step, TextPart, Wire, WireOutput,
    WiringEntry,
};
use super::unexpected_tokens;
use super::words::is_name;
use crate::diagnostic::{Code, Diagnostic};
use crate::source::Span;

/// Whether the value is a call of a name that is not a function.
fn is_no_function(value: &Expr) -> bool {
    let ExprKind::Call { function, .. } = &value.kind else { return false };
    !matches!(function.segments.as_slice(), [only] if only.indices.is_empty() && is_function(&only.name.text))
}

/// Whether the value is a path with the segment `any`, which takes a list before a name.
fn is_any(value: &Expr) -> bool {
    matches!(&value.kind, ExprKind::Path(Path { segments, .. }) if segments.iter().any(|word| word.name.text == "any"))
}

/// Whether a finding is about a space before a bracket inside a span.
fn is_blank_in(finding: &Diagnostic, span: Span) -> bool {
    finding.code == Code::E0108 && finding.span().is_some_and(|blank| span.contains(blank))
}

impl Reader<'_> {
    /// Reads the entries of a block; `read` gets each entry with its doc comment.
    fn block<E>(&mut self, node: Node, read: impl Fn(&mut Self, Node, Doc) -> Option<E>) -> Vec<E> {
        let mut entries = Vec::new();
        let mut doc = None;
        for child in self.children(node) {
            // Already covered by a finding about the whole step.
            if self.covered_until > 0 && self.span(&child).start < self.covered_until {
                continue;
            }
            if child.as_rule() == Rule::docs {
                doc = Some(child);
                continue;
            }
            // `move to 19, 28`: one mistake that the comma splits into two entries.
            let is_bad = child.as_rule() == Rule::bad_entry;
            if let Some(slip) = is_bad.then(|| known_mistakes::rest_of_place(self.span(&child), self.source)).flatten()
            {
                // An unmatched closing bracket is part of the same mistake.
                self.forget_code(Code::E0112, slip.span().unwrap_or_default());
                self.report(slip);
                entries.pop();
                continue;
            }
            let takes_doc = matches!(child.as_rule(), Rule::field | Rule::object | Rule::bad_entry);
            let doc = doc.take().filter(|_| takes_doc).and_then(|docs| self.doc(docs));
            entries.extend(read(self, child, doc));
        }
        entries
    }

    /// Reads the fields of a device, a shape or a planner.
    pub fn fields(&mut self, node: Node) -> Vec<Field> {
        self.block(node, |reader, child, doc| match child.as_rule() {
            Rule::field => Some(reader.field(child, doc)),
            _ => {
                let kept = reader.field_without_value(&child, doc);
                reader.bad_entry(&child, errors::ListPlace::Fields);
                kept
            }
        })
    }

    /// Reads a field that lacks its colon or its value. It counts as present, so that it is not reported as missing.
    fn field_without_value(&mut self, node: &Node, doc: Doc) -> Option<Field> {
        let span = self.trimmed(node);
        let whole = &self.source[span.range()];
        let (skipped, text) =
            recover::field_without_colon(whole).map(|text| (0, text)).or_else(|| named_entry(whole))?;
        let text = text.to_owned();
        // `pulse voltage: 20 V` is one name with a space in it.
        if known_mistakes::blank_in_name(span, whole).is_some() {
            return None;
        }
        let start = span.start + skipped as u32;
        let name_span = Span { start, end: start + text.len() as u32, ..span };
        let value = Expr { kind: ExprKind::Error, span };
        Some(Field { doc, name: Ident { text, span: name_span }, value, span })
    }

    /// Reads the entries of a scene.
    pub fn scene_entries(&mut self, node: Node) -> Vec<SceneEntry> {
        self.block(node, |reader, child, doc| {
            let span = reader.span(&child);
            if let Some((finding, whole)) = known_mistakes::word_before_name(span, reader.source) {
                reader.forget_within(whole);
                reader.report(finding);
                reader.keep_name_behind(whole);
                reader.covered_until = whole.end;
                return Some(SceneEntry::Error(whole));
            }
            Some(match child.as_rule() {
                Rule::object => reader.object(child, doc).map_or(SceneEntry::Error(span), SceneEntry::Object),
                Rule::scene_loop => SceneEntry::For(reader.each(child, Self::scene_entries)),
                _ => {
                    reader.bad_entry(&child, errors::ListPlace::Scene);
                    SceneEntry::Error(span)
                }
            })
        })
    }

    /// Reads the entries of a task, a program, or a block of one.
    pub fn entries(&mut self, node: Node) -> Vec<Entry> {
        self.block(node, |reader, child, doc| {
            let span = reader.span(&child);
            let is_step = child.as_rule() == Rule::step;
            let misspelt = || foreign_syntax::misspelt_behind(span, reader.source).filter(|_| is_step);
            if let Some((finding, whole)) = foreign_syntax::whole_step(span, reader.source).or_else(misspelt) {
                reader.forget_within(whole);
                reader.report(finding);
                reader.covered_until = whole.end;
                return Some(Entry::Error(whole));
            }
            Some(match child.as_rule() {
                Rule::field => Entry::Field(reader.field(child, doc)),
                Rule::step => reader.step(child).map_or(Entry::Error(span), Entry::Step),
                Rule::loop_ => Entry::For(reader.each(child, Self::entries)),
                _ => {
                    reader.bad_entry(&child, errors::ListPlace::Steps);
                    Entry::Error(span)
                }
            })
        })
    }

    /// Reads the entries of a wiring.
    pub fn wires(&mut self, node: Node) -> Vec<WiringEntry> {
        self.block(node, |reader, child, doc| {
            let span = reader.span(&child);
            Some(match child.as_rule() {
                Rule::wire => reader.wire(child).map_or(WiringEntry::Error(span), WiringEntry::Wire),
                Rule::wire_loop => WiringEntry::For(reader.each(child, Self::wires)),
                Rule::field => {
                    let field = reader.field(child, doc);
                    if let Some(finding) = known_mistakes::equals_in_wire(&field, reader.source) {
                        reader.forget_code(Code::E0119, field.span);
                        reader.report(finding);
                        return Some(WiringEntry::Error(span));
                    }
                    WiringEntry::Field(field)
                }
                _ => {
                    reader.bad_entry(&child, errors::ListPlace::Wires);
                    WiringEntry::Error(span)
                }
            })
        })
    }

    fn each<E>(&mut self, node: Node, read: impl Fn(&mut Self, Node) -> Vec<E>) -> For<E> {
        let span = self.span(&node);
        let mut names = Vec::new();
        let mut over = None;
        let mut entries = Vec::new();
        for part in self.children(node) {
            match part.as_rule() {
                Rule::name => names.push(self.declared(&part)),
                Rule::flat_expr => over = Some(self.expr(part)),
                _ => entries = read(self, part),
            }
        }
        let nowhere = super::tree::Ident { text: String::new(), span };
        let element = names.pop().unwrap_or(nowhere);
        let over = over.unwrap_or(Expr { kind: ExprKind::Error, span });
        For { counter: names.pop(), element, over, entries, span }
    }

    fn object(&mut self, node: Node, doc: Doc) -> Option<Object> {
        let span = self.span(&node);
        let mut parts = self.children(node).into_iter();
        let noun = parts.next().map(|word| self.ident(&word))?;
        let (mut name, mut shape, mut at) = (None, None, None);
        for part in parts {
            match part.as_rule() {
                Rule::indexed => name = Some(self.indexed(part)),
                Rule::no_name => self.report(errors::object_without_name(&noun)),
                Rule::place => at = self.children(part).pop().map(|value| self.value(Some(value), span)),
                _ => shape = Some(self.value(Some(part), span)),
            }
        }
        let name = name?;
        let is_place = |finding: &Diagnostic| is_blank_in(finding, span);
        // The place of `part m1 : ea.droplet (1, 2)` was read as arguments.
        if at.is_none()
            && let Some(blank) = self.findings.iter().position(is_place)
            && let Some(finding) = known_mistakes::object_without_at(span, &self.source[span.range()])
        {
            self.findings.remove(blank);
            self.report(finding);
            self.broken_names.push(name.name);
            return None;
        }
        if super::RESERVED.contains(&name.name.text.as_str()) {
            self.report(errors::reserved_name(&name.name));
        }
        Some(Object { doc, noun, name, shape, at, span })
    }

    fn step(&mut self, node: Node) -> Option<Step> {
        let span = self.span(&node);
        let mut parts = self.children(node).into_iter();
        let head = parts.next().map(|word| self.ident(&word))?;
        if super::foreign_words::help(&head.text).is_some() {
            self.foreign_word(head.text.len(), span);
            return None;
        }
        if head.text == "and" {
            self.forget_code(Code::E0103, head.span);
            let finding = unexpected_tokens::joined_by_and(head.span, self.source);
            self.report(finding);
            return None;
        }
        // Only `set` is examined: other steps may be long.
        if head.text == "set"
            && let Some(finding) = known_mistakes::level_on(span, self.source)
        {
            self.report(finding);
            return None;
        }
        let mut step =
            Step { head, indices: Vec::new(), noun: None, object: None, phrases: Vec::new(), block: None, span };
        for part in parts {
            match part.as_rule() {
                Rule::head_index => step.indices = self.indices(part),
                Rule::noun => {
                    step.noun = part.into_inner().next().map(|word| self.ident(&word));
                    // `set the lamp to high`
                    if let Some(article) = step.noun.take_if(|noun| unexpected_tokens::is_article(&noun.text)) {
                        let finding = unexpected_tokens::article(article.span, self.source);
                        self.report(finding);
                    }
                }
                Rule::step_expr => {
                    let span = self.span(&part);
                    let mut object = self.object_of_step(part, step.noun.as_ref());
                    // `run` is followed by a task with its arguments.
                    if step.head.text != "run" {
                        self.fix_index(&mut object);
                        // `move m1 (8, 9)` lacks a preposition; it has no superfluous space. `move any [a, b]` does not
                        // use `any` as a name.
                        if is_no_function(&object) || is_any(&object) {
                            self.forget_code(Code::E0108, span);
                        }
                    }
                    step.object = Some(object);
                }
                Rule::phrase | Rule::late_phrase => step.phrases.extend(self.phrase(part)),
                _ => step.block = Some(self.entries(part)),
            }
        }
        Some(step)
    }

    /// Reads the object of a step, which may be a place after a misspelt preposition.
    fn object_of_step(&mut self, node: Node, noun: Option<&Ident>) -> Expr {
        let span = self.span(&node);
        match foreign_syntax::misspelt_preposition(span, noun.map(|noun| noun.text.as_str()), self.source) {
            Some(finding) => {
                self.report(finding);
                Expr { kind: ExprKind::Error, span }
            }
            None => self.expr(node),
        }
    }

    /// Reads `drop(2)` as `drop[2]` and reports it.
    fn fix_index(&mut self, value: &mut Expr) {
        let ExprKind::Call { function, arguments } = &mut value.kind else { return };
        let bracket = function.span.end as usize;
        let [argument] = arguments.as_slice() else { return };
        let is_index = matches!(argument.kind, ExprKind::Path(_) | ExprKind::Number(_) | ExprKind::Binary { .. });
        let [.., last] = function.segments.as_mut_slice() else { return };
        let is_name = !is_function(&last.name.text) && last.indices.is_empty();
        if is_index && is_name && self.source[bracket..].starts_with('(') {
            let finding = unexpected_tokens::round_index(value.span, bracket, self.source);
            last.indices = std::mem::take(arguments);
            last.span.end = value.span.end;
            let path = Path { span: value.span, segments: std::mem::take(&mut function.segments) };
            value.kind = ExprKind::Path(path);
            self.report(finding);
        }
    }

    /// Reports the missing preposition of `merge a with b (8, 4)` or the article of `start at the (0, 0)`, in place of
    /// the superfluous space.
    fn part_place(&mut self, value: &Expr) {
        self.forget_code(Code::E0108, value.span);
        let written = &self.source[value.span.range()];
        let name = context::token_at(written, 0);
        let finding = match unexpected_tokens::is_article(name) {
            true => Some(unexpected_tokens::article(context::first_word(value.span, name.len()), self.source)),
            false => written.find('(').and_then(|bracket| {
                let at = value.span.start as usize + bracket;
                let line = context::line_before(self.source, at);
                unexpected_tokens::word_missing(context::part(value.span, at, at + 1), line, self.source)
            }),
        };
        finding.into_iter().for_each(|finding| self.report(finding));
    }

    fn phrase(&mut self, node: Node) -> Option<Phrase> {
        let span = self.span(&node);
        let mut parts = self.children(node).into_iter();
        let Ident { text, span: at } = parts.next().map(|word| self.ident(&word))?;
        // `for at most` is one preposition, whatever the spacing between its words.
        let text =
            if text.contains([' ', '\t']) { text.split_whitespace().collect::<Vec<_>>().join(" ") } else { text };
        let preposition = Ident { text, span: at };
        let mut value = self.value(parts.next(), span);
        self.fix_index(&mut value);
        if is_no_function(&value) && self.findings.iter().any(|finding| is_blank_in(finding, value.span)) {
            self.part_place(&value);
            value.kind = ExprKind::Error;
        }
        Some(Phrase { preposition, value, span })
    }

    fn wire(&mut self, node: Node) -> Option<Wire> {
        let span = self.span(&node);
        let mut parts = self.children(node).into_iter();
        let channel = parts.next().map(|path| self.path(path))?;
        let output = parts.next()?;
        let output = match output.as_rule() {
            Rule::text => {
                let text = self.text(output);
                let broken = |part: &TextPart| matches!(part, TextPart::Hole(Expr { kind: ExprKind::Error, .. }));
                (!text.parts.iter().any(broken)).then_some(WireOutput::Named(text))
            }
            Rule::path => Some(WireOutput::Instrument(self.path(output))),
            Rule::missing => {
                self.missing(&output);
                None
            }
            _ => None,
        };
        let fields = parts.next().map(|fields| self.fields(fields)).unwrap_or_default();
        Some(Wire { channel, output: output?, fields, span })
    }
}

/// The name before the colon of an unreadable field, with the offset at which it begins: `right: 5 5`, `'right': 5`.
fn named_entry(text: &str) -> Option<(usize, &str)> {
    let is_quote_mark = |c: char| c == '"' || is_quote(c);
    let bare = text.trim_start_matches(is_quote_mark);
    let name = token_at(bare, 0);
    let rest = bare[name.len()..].trim_start_matches(is_quote_mark).trim_start();
    (is_name(name) && rest.starts_with([':', '='])).then(|| (text.len() - bare.len(), name))
}
