//! Completion of declared names, and what declarations say of a device's kind and a task's scene.

use super::{DeclaredName, Suggestions};
use crate::device::Vocabulary;
use crate::lsp::words;
use crate::syntax::tree::{Item, SceneEntry, Tree};
use lsp_types::CompletionItemKind;

impl<'t> Suggestions<'t> {
    /// Adds the names of some sorts, of this text or of the file before the dot; without a dot, also the names of the
    /// used files.
    pub(super) fn names(&mut self, sorts: &[DeclaredName]) {
        let files = self.files;
        match self.cursor.path.as_slice() {
            [] => {
                self.declared(files.own(), sorts);
                for (alias, used) in files.uses() {
                    self.add(alias, &format!("use {}", used.written), "", CompletionItemKind::MODULE);
                }
            }
            [alias] => {
                if let Some(tree) = files.used(alias) {
                    self.declared(tree, sorts);
                }
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

    /// The loop names around the cursor, and the parameters of its task or program.
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

    /// Adds the objects of the scenes that have this noun; all objects if no scene has it.
    pub(super) fn objects(&mut self, noun: &str) {
        let mut found = Vec::new();
        for scene in self.files.scenes(self.scene_of_task()) {
            objects_of(&scene.entries, &mut found);
        }
        let is_known = found.iter().any(|object| object.1 == noun);
        for (name, of) in found {
            if !is_known || of == noun {
                self.word(name, of, "", CompletionItemKind::VARIABLE);
            }
        }
    }

    fn scene_of_task(&self) -> Option<&'t str> {
        match self.cursor.heads.first().map(Vec::as_slice) {
            Some(["task", .., "in", scene]) => Some(*scene),
            _ => None,
        }
    }

    /// The vocabulary of the device that follows a word in a head: after `:` in the head of a device, after `on` in
    /// that of a task.
    pub(super) fn kinds_behind(&self, word: &str, head: &[&str]) -> Vec<&'static Vocabulary> {
        let device = head.iter().skip_while(|token| **token != word).nth(1);
        device
            .and_then(|device| self.files.kind(device))
            .map_or_else(|| self.kinds_in_use(), |kind| vec![kind.vocabulary()])
    }

    pub(super) fn kinds_in_use(&self) -> Vec<&'static Vocabulary> {
        words::kinds(self.files.own())
    }
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
