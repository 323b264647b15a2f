//! Names that a text declares, and what its declarations say of a device's kind and a task's scene.

use super::{DeclaredName, Suggestions};
use crate::device::{Kind, Vocabulary};
use crate::lsp::{outline, words};
use crate::stdlib;
use crate::syntax::tree::{self, Item, Path, Scene, SceneEntry, Tree, UsePath};
use lsp_types::CompletionItemKind;

impl<'t> Suggestions<'t> {
    /// The names of some sorts, of this text or of the library before the dot; where none stands before it, the libraries as well.
    pub(super) fn names(&mut self, sorts: &[DeclaredName]) {
        let tree = self.tree;
        let libraries = || tree.items.iter().filter_map(library);
        let files = tree.items.iter().filter_map(|item| match item {
            Item::Use(tree::Use { path: UsePath::File(_), alias: Some(alias), .. }) => Some(alias.text.as_str()),
            _ => None,
        });
        match self.cursor.path.as_slice() {
            [] => {
                self.declared(tree, sorts);
                files.for_each(|alias| self.add(alias, "a file", "", CompletionItemKind::MODULE));
                for (alias, file) in libraries() {
                    self.add(alias, &format!("use std.{file}"), "", CompletionItemKind::MODULE);
                }
            }
            [alias] => {
                let text = libraries().find(|library| library.0 == *alias).and_then(|(_, file)| stdlib::file(file));
                text.into_iter().for_each(|text| self.declared(&outline::tree(text), sorts));
            }
            _ => {}
        }
    }

    fn declared(&mut self, tree: &Tree, sorts: &[DeclaredName]) {
        for item in &tree.items {
            let (name, doc, form, sort) = match item {
                Item::Let(item) => (&item.name, &item.doc, "let", DeclaredName::Value),
                Item::Device(item) => (&item.name, &item.doc, "device", DeclaredName::Device),
                Item::Instrument(item) => (&item.name, &item.doc, "instrument", DeclaredName::Instrument),
                Item::Output(item) => (&item.name, &item.doc, "output", DeclaredName::Output),
                Item::Scene(item) => (&item.name, &item.doc, "scene", DeclaredName::Scene),
                Item::Task(item) => (&item.name, &item.doc, "task", DeclaredName::Runnable),
                Item::Program(item) => (&item.name, &item.doc, "program", DeclaredName::Runnable),
                Item::Use(_) | Item::Wiring(_) | Item::Error(_) => continue,
            };
            if sorts.contains(&sort) && !name.text.is_empty() {
                self.add(&name.text, form, doc.as_deref().unwrap_or_default(), CompletionItemKind::VARIABLE);
            }
        }
    }

    /// The names of loops round the cursor, and the parameters of its task or program.
    pub(super) fn bound_names(&self) -> Vec<&'t str> {
        let mut names: Vec<&str> = Vec::new();
        for head in &self.cursor.heads {
            match head.as_slice() {
                ["for", bound, "in", ..] => names.push(*bound),
                ["for", counter, ",", element, "in", ..] => names.extend([*counter, *element]),
                ["task" | "program", _, parameters, ..] if parameters.starts_with('(') => {
                    let parts = parameters.trim_matches(['(', ')']).split(',');
                    names.extend(parts.filter_map(|part| Some(part.split_once(':')?.0.trim())));
                }
                _ => {}
            }
        }
        names
    }

    /// Things of the scenes by their noun; all of them by a noun that no scene has.
    pub(super) fn objects(&mut self, noun: &str) {
        let mut found = Vec::new();
        for scene in self.scenes() {
            objects_of(&scene.entries, &mut found);
        }
        let is_known = found.iter().any(|object| object.1 == noun);
        for (name, of) in found {
            if !is_known || of == noun {
                self.word(name, of, "", CompletionItemKind::VARIABLE);
            }
        }
    }

    /// The scene of the task round the cursor and those that it is based on; all where none of them is known.
    fn scenes(&self) -> Vec<&'t Scene> {
        let all =
            || self.tree.items.iter().filter_map(|item| if let Item::Scene(scene) = item { Some(scene) } else { None });
        let named = match self.cursor.heads.first().map(Vec::as_slice) {
            Some(["task", .., "in", scene]) => Some(*scene),
            _ => None,
        };
        let mut found: Vec<&Scene> = Vec::new();
        let mut next = named.map(str::to_owned);
        while let Some(scene) = next.take().and_then(|name| all().find(|scene| scene.name.text == name)) {
            if found.iter().any(|known| std::ptr::eq(*known, scene)) {
                break;
            }
            found.push(scene);
            next = scene.base.as_ref().map(dotted);
        }
        if found.is_empty() { all().collect() } else { found }
    }

    /// The words of a device's kind, by the head of its declaration.
    pub(super) fn kinds_of_base(&self, head: &[&str]) -> Vec<&'static Vocabulary> {
        let base = head.iter().skip_while(|word| **word != ":").nth(1);
        base.and_then(|base| self.kind(base)).map_or_else(|| self.kinds_in_use(), |kind| vec![kind.vocabulary()])
    }

    /// The words of a task's kind, by its head.
    pub(super) fn kinds_of_task(&self, head: &[&str]) -> Vec<&'static Vocabulary> {
        let device = head.iter().skip_while(|word| **word != "on").nth(1);
        device.and_then(|device| self.kind(device)).map_or_else(|| self.kinds_in_use(), |kind| vec![kind.vocabulary()])
    }

    pub(super) fn kinds_in_use(&self) -> Vec<&'static Vocabulary> {
        words::kinds(self.tree)
    }

    /// The kind of a device by its name, or by that of its base.
    fn kind(&self, name: &str) -> Option<Kind> {
        let mut name = name.to_owned();
        // A base of a base, and so on: each at most once.
        for _ in 0..=self.tree.items.len() {
            if let Some((alias, _)) = name.split_once('.') {
                let file = self.tree.items.iter().filter_map(library).find(|library| library.0 == alias)?.1;
                return Kind::find(file);
            }
            let declared = self.tree.items.iter().find_map(|item| match item {
                Item::Device(device) if device.name.text == name => Some(dotted(&device.base)),
                _ => None,
            });
            match declared {
                Some(base) => name = base,
                None => return Kind::find(&name),
            }
        }
        None
    }
}

/// The name and the file of a `use` of the library.
fn library(item: &Item) -> Option<(&str, &str)> {
    let Item::Use(item) = item else { return None };
    let UsePath::Library { words, .. } = &item.path else { return None };
    let file = words.last()?;
    Some((item.alias.as_ref().map_or(&file.text, |alias| &alias.text), &file.text))
}

fn dotted(path: &Path) -> String {
    let words: Vec<&str> = path.segments.iter().map(|segment| segment.name.text.as_str()).collect();
    words.join(".")
}

fn objects_of<'t>(entries: &'t [SceneEntry], found: &mut Vec<(&'t str, &'t str)>) {
    for entry in entries {
        match entry {
            SceneEntry::Object(object) => found.push((&object.name.name.text, &object.noun.text)),
            SceneEntry::For(inner) => objects_of(&inner.entries, found),
            SceneEntry::Error(_) => {}
        }
    }
}
