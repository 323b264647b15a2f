//! Completion: the words that the language and the kind allow at the cursor, and the names that fit there.
//!
//! The context comes from what is open before the cursor; names, devices and scenes come from the declarations of the
//! whole text and of the files that it uses. If the kind of a device is unknown, the words of all kinds that the text
//! uses are offered.

mod files;
mod names;
mod steps;

use super::cursor::CursorPlace;
use super::words::{COMMON_STEPS, DECLARATIONS};
use crate::check::frames;
use crate::check::imports::Library;
use crate::check::programs::parameter_sorts;
use crate::check::scope::ANGLE_NAME;
use crate::device::instrument::{AuxiliarySort, Family, LinkSort};
use crate::device::shape::ShapeForm;
use crate::device::{Frames, Kind, Sort, VocabularyField, WordChoice};
use crate::quantity::Dimension;
use crate::stdlib;
use crate::syntax::functions::{FUNCTIONS, function_form};
use files::ProgramTrees;
use lsp_types::{CompletionItem, CompletionItemKind, Documentation};
use std::collections::BTreeMap;

/// The completions at a byte of a text, in alphabetical order; none in comments, strings and numbers. Used files are
/// read from `library`.
pub fn completions(text: &str, at: usize, library: &dyn Library) -> Vec<CompletionItem> {
    let Some(cursor) = CursorPlace::behind(&text[..at]) else { return Vec::new() };
    let files = ProgramTrees::read(text, library);
    let mut shown = Suggestions { files: &files, cursor: &cursor, items: BTreeMap::new() };
    shown.collect();
    shown.items.into_values().collect()
}

/// Sorts of names that a text declares.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum DeclaredName {
    Value,
    Device,
    Instrument,
    Output,
    Scene,
    Runnable,
}

struct Suggestions<'t> {
    files: &'t ProgramTrees,
    cursor: &'t CursorPlace<'t>,
    /// By label.
    items: BTreeMap<String, CompletionItem>,
}

impl<'t> Suggestions<'t> {
    fn collect(&mut self) {
        let cursor = self.cursor;
        let Some((outer, inner)) = cursor.heads.split_first() else { return self.declaration() };
        match outer.first().copied() {
            Some("device") => match inner.last() {
                None => self.fields(self.kinds_behind(":", outer).into_iter().flat_map(|kind| kind.fields).collect()),
                Some(head) => {
                    let fields = self.kinds_behind(":", outer).into_iter().flat_map(|kind| kind.fields);
                    let field = head.first().and_then(|name| fields.into_iter().find(|field| field.name == *name));
                    match field.map(|field| &field.sort) {
                        Some(Sort::Table(columns)) => self.table(columns),
                        _ => self.braces_of_value(head),
                    }
                }
            },
            Some("instrument") => self.fields(Family::ALL.iter().flat_map(|family| family.fields()).collect()),
            Some("output") => {
                let sort = AuxiliarySort::ALL.iter().find(|sort| outer.last() == Some(&sort.name()));
                let sorts = sort.map_or(AuxiliarySort::ALL, std::slice::from_ref);
                self.fields(sorts.iter().flat_map(|sort| sort.fields()).collect());
            }
            Some("scene") => self.scene(inner),
            Some("task") => self.task(outer, inner),
            Some("program") => self.program(),
            Some("wiring") => self.wiring(inner),
            // The value of a `let`, such as a shape with fields.
            _ => self.braces_of_value(cursor.heads.last().map_or(&[], Vec::as_slice)),
        }
    }

    /// The tokens of the current entry before the cursor.
    fn entry(&self) -> &'t [&'t str] {
        &self.cursor.entry
    }

    fn add(&mut self, word: &str, form: &str, meaning: &str, kind: CompletionItemKind) {
        let documentation = (!meaning.is_empty()).then(|| Documentation::String(meaning.to_owned()));
        let item = CompletionItem {
            label: word.to_owned(),
            detail: Some(form.to_owned()),
            documentation,
            kind: Some(kind),
            ..CompletionItem::default()
        };
        self.items.entry(word.to_owned()).or_insert(item);
    }

    /// Adds a word of the language, unless a name and a dot precede the cursor.
    fn word(&mut self, word: &str, form: &str, meaning: &str, kind: CompletionItemKind) {
        if self.cursor.path.is_empty() {
            self.add(word, form, meaning, kind);
        }
    }

    fn keywords(&mut self, words: &[&str]) {
        words.iter().for_each(|word| self.word(word, word, "", CompletionItemKind::KEYWORD));
    }

    fn choices(&mut self, choices: &[WordChoice]) {
        choices.iter().for_each(|word| self.word(word.name, word.name, word.doc, CompletionItemKind::ENUM_MEMBER));
    }

    /// Completes outside all braces.
    fn declaration(&mut self) {
        use DeclaredName::{Device, Instrument, Output, Scene};
        let entry = self.entry();
        match entry {
            [] => {
                for (word, form) in DECLARATIONS {
                    self.word(word, form, "", CompletionItemKind::KEYWORD);
                }
            }
            ["use"] if self.cursor.path == ["std"] => {
                stdlib::names()
                    .for_each(|name| self.add(name, &format!("use std.{name}"), "", CompletionItemKind::MODULE));
            }
            ["use"] => {
                self.word("std", "use std.dimibot", "the standard library of Tweeze", CompletionItemKind::MODULE)
            }
            ["use", _] => self.keywords(&["as"]),
            ["let", _, "="] => {
                self.shapes(ShapeForm::ALL);
                self.value(None, &[]);
            }
            ["let", _, "=", value @ ..] => self.value(None, value),
            ["device", _, ":"] => {
                self.names(&[Device]);
                Kind::ALL.iter().for_each(|kind| {
                    self.word(kind.name(), kind.name(), kind.vocabulary().summary, CompletionItemKind::CLASS);
                });
            }
            ["instrument", _, ":"] => {
                self.names(&[Instrument]);
                self.choices(Family::CHOICES);
            }
            ["output", _, ":"] => {
                self.choices(AuxiliarySort::CHOICES);
            }
            ["scene", _, ":"] | ["task", .., "in"] => self.names(&[Scene]),
            ["task", .., "on"] => self.names(&[Device]),
            ["task" | "program", _]
                if self.cursor.in_brackets.as_deref().is_some_and(|inside| inside.last() == Some(&":")) =>
            {
                parameter_sorts().for_each(|sort| self.keywords(&[sort]));
            }
            ["task", .., "on", _] => self.keywords(&["in"]),
            ["task", _] | ["task", _, _] => self.keywords(&["on"]),
            ["wiring"] => self.names(&[Device, Output]),
            _ => {}
        }
    }

    /// Completes fields and their values.
    fn fields(&mut self, fields: Vec<&'static VocabularyField>) {
        match self.entry() {
            [] => fields.iter().for_each(|field| {
                self.word(field.name, &field.term(), &field.meaning(), CompletionItemKind::FIELD);
            }),
            [name, tail @ ..] if tail.first() == Some(&":") => {
                let field = fields.iter().find(|field| field.name == *name);
                self.value(field.map(|field| &field.sort), tail);
            }
            _ => {}
        }
    }

    /// Completes the columns of a table, and the words that may stand in them.
    fn table(&mut self, columns: &[VocabularyField]) {
        for column in columns {
            self.word(column.name, &column.term(), &column.meaning(), CompletionItemKind::FIELD);
            if let Sort::Word(choices) = column.sort {
                self.choices(choices);
            }
        }
    }

    /// Completes the fields of a shape, or of a device or wire if nothing more is known of the braces.
    fn braces_of_value(&mut self, head: &[&str]) {
        let form = head.iter().rev().find_map(|word| ShapeForm::ALL.iter().find(|form| form.name() == *word));
        self.fields(form.map_or(Vec::new(), |form| form.fields().iter().collect()));
    }

    /// Completes a value of a sort, after these tokens of the expression; at its beginning they are only `:` or `to`.
    fn value(&mut self, sort: Option<&Sort>, before: &[&str]) {
        let before = self.cursor.in_brackets.as_deref().unwrap_or(before);
        if let Some(last) = before.last().filter(|last| is_complete(last)) {
            if last.starts_with(|first: char| first.is_ascii_digit()) {
                self.units(sort);
            }
            return;
        }
        if let Some(Sort::Word(choices) | Sort::CountOrWord { words: choices, .. }) = sort {
            return self.choices(choices);
        }
        if let Some(Sort::Flag) = sort {
            return self.keywords(&["true", "false"]);
        }
        if let Some(Sort::Table(_)) = sort {
            self.keywords(&["table"]);
        }
        if let Some(Sort::Shape(form)) = sort {
            self.shapes(&[*form]);
        }
        if let Some(Sort::Curve) = sort {
            self.word(ANGLE_NAME, "the angle, which makes one full turn", "", CompletionItemKind::VARIABLE);
        }
        if let Some(Sort::Object(noun) | Sort::Site(noun) | Sort::Sites(noun)) = sort {
            self.objects(noun);
        }
        self.names(&[DeclaredName::Value]);
        for function in FUNCTIONS {
            let form = function_form(function.name).unwrap_or_default();
            self.word(function.name, &form, function.doc, CompletionItemKind::FUNCTION);
        }
        for name in self.bound_names() {
            self.word(name, "name declared in this block", "", CompletionItemKind::VARIABLE);
        }
    }

    /// Completes the unit after a number.
    fn units(&mut self, sort: Option<&Sort>) {
        let mut units = sort.and_then(Sort::dimension).map_or(Vec::new(), Dimension::usual_units);
        if matches!(sort, Some(Sort::Target | Sort::Pose)) {
            units.extend(Dimension::ANGLE.usual_units());
        }
        units.iter().for_each(|unit| self.word(unit, unit, "", CompletionItemKind::UNIT));
    }

    fn shapes(&mut self, forms: &[ShapeForm]) {
        for form in forms {
            self.word(form.name(), form.name(), "", CompletionItemKind::CLASS);
        }
        self.names(&[DeclaredName::Value]);
    }

    fn scene(&mut self, inner: &[Vec<&str>]) {
        let inner: Vec<&[&str]> = inner.iter().map(Vec::as_slice).filter(|head| head.first() != Some(&"for")).collect();
        if let Some(head) = inner.last() {
            return self.braces_of_value(head);
        }
        let kinds = self.kinds_in_use();
        let nouns = || kinds.iter().flat_map(|kind| kind.nouns);
        match self.entry() {
            [] => {
                nouns().for_each(|noun| self.word(noun.name, noun.name, noun.doc, CompletionItemKind::CLASS));
                self.keywords(&["for"]);
                if kinds.iter().any(|kind| kind.frames == Frames::Yes) {
                    self.word(
                        frames::NOUN,
                        "frame DEVICE at PLACE",
                        "where a device is in the scene",
                        CompletionItemKind::CLASS,
                    );
                }
            }
            [noun] if *noun == frames::NOUN => self.names(&[DeclaredName::Device]),
            ["for", ..] => self.loop_head(),
            [noun, .., ":"] if *noun == frames::NOUN => self.shapes(&[ShapeForm::Image]),
            entry if entry.contains(&"at") => {
                let place = entry.split(|token| *token == "at").next_back().unwrap_or_default();
                self.value(Some(&Sort::Target), place);
            }
            [noun, .., ":"] => {
                let forms = nouns().filter(|known| known.name == *noun).flat_map(|noun| noun.shapes);
                self.shapes(&forms.copied().collect::<Vec<_>>());
            }
            entry => {
                if entry.len() > 1 {
                    self.keywords(&["at"]);
                }
            }
        }
    }

    fn program(&mut self) {
        match self.entry() {
            [] => {
                self.word("run", "run TASK", "runs a task or a program", CompletionItemKind::KEYWORD);
                let own = ["wait", "prompt", "pulse", "set", "for", "together"];
                for (word, form) in COMMON_STEPS.iter().filter(|step| own.contains(&step.0)) {
                    self.word(word, form, "", CompletionItemKind::KEYWORD);
                }
            }
            ["run"] => self.names(&[DeclaredName::Runnable]),
            ["for", ..] => self.loop_head(),
            ["run", ..] if self.cursor.in_brackets.is_some() => {
                self.value(None, &[]);
                self.objects("part");
            }
            _ => {
                self.common_step();
            }
        }
    }

    fn wiring(&mut self, inner: &[Vec<&str>]) {
        let fields = || LinkSort::ALL.iter().flat_map(|link| link.fields()).collect();
        match (inner.last().filter(|head| head.first() != Some(&"for")), self.entry()) {
            (Some(_), _) => self.fields(fields()),
            (None, []) => {
                self.fields(fields());
                self.keywords(&["all", "for", AuxiliarySort::CHANNEL]);
            }
            (None, [.., "->"]) => self.names(&[DeclaredName::Instrument]),
            (None, ["for", ..]) => self.loop_head(),
            (None, [_, ":", ..]) => self.fields(fields()),
            (None, _) => {}
        }
    }

    /// Completes the head of a loop, after `for`.
    fn loop_head(&mut self) {
        let entry = self.entry();
        match entry.iter().position(|token| *token == "in") {
            Some(at) => self.value(None, if at + 1 == entry.len() { &[] } else { entry }),
            None if entry.len() > 1 => self.keywords(&["in"]),
            None => {}
        }
    }
}

/// Whether a token is a value or ends one, as opposed to an operator or a word that needs a value after it.
fn is_complete(token: &str) -> bool {
    token.ends_with(|c: char| c.is_alphanumeric() || matches!(c, '_' | ')' | ']' | '}' | '"' | '%'))
}

#[cfg(test)]
mod tests;
