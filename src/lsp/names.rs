//! Names of open programs: where they are declared, where they are used, and what they may be called instead.
//!
//! Every open program is checked once more for each question, with open texts in place of files, so that uses in programs that use the same
//! file are found as well. Names of the standard library have no place that an editor can open.

use super::findings::Overlay;
use super::text::{self, ColumnUnit, EditedText};
use crate::check::imports::Library;
use crate::check::{Options, ProgramSource, links};
use crate::diagnostic::Sink;
use crate::source::{Origin, Sources, Span};
use crate::syntax::{self, tree::Item};
use lsp_types::{Location, TextEdit, Uri, WorkspaceEdit};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A stretch of bytes of a file.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct FilePlace {
    path: PathBuf,
    start: usize,
    end: usize,
}

/// What the names of some programs stand for.
pub struct ProgramNames {
    /// What the editor calls the open texts.
    uris: BTreeMap<PathBuf, Uri>,
    /// Uses with their declarations; `None` for one of the standard library.
    links: BTreeSet<(FilePlace, Option<FilePlace>)>,
    texts: BTreeMap<PathBuf, String>,
}

/// Whether a word may name something new.
fn is_free_name(name: &str) -> bool {
    let text = format!("let {name} = 1\n");
    let mut sink = Sink::default();
    let tree = syntax::parse(Sources::default().add("", text.as_str()), &text, &mut sink);
    sink.errors() == 0 && matches!(tree.items.as_slice(), [Item::Let(item)] if item.name.text == name)
}

impl ProgramNames {
    /// No names yet; `uris` are what the editor calls the open texts.
    pub fn new(uris: BTreeMap<PathBuf, Uri>) -> ProgramNames {
        ProgramNames { uris, links: BTreeSet::new(), texts: BTreeMap::new() }
    }

    /// Adds the names of the program of a path, which is one of the open texts.
    pub fn add(&mut self, path: &Path, texts: &BTreeMap<PathBuf, &str>, disk: &dyn Library) {
        let Some(text) = texts.get(path) else { return };
        let name = path.file_name().unwrap_or(path.as_os_str()).to_string_lossy();
        let library = Overlay { folder: path.parent().unwrap_or(Path::new("")), texts, disk };
        let mut sources = Sources::default();
        let request = ProgramSource { name: &name, text, library: &library, options: &Options::default() };
        for link in links::links(&request, &mut sources) {
            let place = |span: Span| {
                let file = sources.file(span.file);
                let Range { start, end } = span.range();
                (file.origin == Origin::User).then(|| FilePlace { path: library.path(&file.name), start, end })
            };
            if let Some(used) = place(link.used) {
                self.links.insert((used, place(link.declared)));
            }
        }
        for (_, file) in sources.files().filter(|(_, file)| file.origin == Origin::User) {
            self.texts.insert(library.path(&file.name), file.text.to_string());
        }
    }

    /// The declaration of the name at a place of a file, be it in use there or declared.
    fn declaration(&self, path: &Path, offset: usize) -> Option<&FilePlace> {
        let is_here = |place: &FilePlace| place.path == path && (place.start..=place.end).contains(&offset);
        self.links.iter().find_map(|(used, declared)| {
            let declared = declared.as_ref()?;
            (is_here(used) || is_here(declared)).then_some(declared)
        })
    }

    /// A declaration and all its uses, in order.
    fn all_of<'n>(&'n self, declaration: &'n FilePlace) -> BTreeSet<&'n FilePlace> {
        let uses = self.links.iter().filter(|(_, declared)| declared.as_ref() == Some(declaration));
        uses.map(|(used, _)| used).chain([declaration]).collect()
    }

    fn location(&self, place: &FilePlace, unit: ColumnUnit) -> Option<Location> {
        let shown = EditedText::new(self.texts.get(&place.path)?.clone());
        let uri = self.uris.get(&place.path).cloned().or_else(|| text::uri(&place.path))?;
        Some(Location { uri, range: shown.range(place.start..place.end, unit) })
    }

    /// Where the name at a place is declared.
    pub fn definition(&self, path: &Path, offset: usize, unit: ColumnUnit) -> Option<Location> {
        self.location(self.declaration(path, offset)?, unit)
    }

    /// All places of the name at a place, in order; without its declaration if that is not wanted.
    pub fn references(&self, path: &Path, offset: usize, unit: ColumnUnit, with_declaration: bool) -> Vec<Location> {
        let Some(declaration) = self.declaration(path, offset) else { return Vec::new() };
        let places = self.all_of(declaration).into_iter();
        let wanted = places.filter(|place| with_declaration || *place != declaration);
        wanted.filter_map(|place| self.location(place, unit)).collect()
    }

    /// The edits that give the name at a place another one, in all files.
    ///
    /// # Errors
    /// Why it cannot have that name, or any other.
    // The library's own type of the edits hashes addresses of documents by their text alone.
    #[allow(clippy::mutable_key_type)]
    pub fn renamed(&self, path: &Path, offset: usize, unit: ColumnUnit, name: &str) -> Result<WorkspaceEdit, String> {
        if !is_free_name(name) {
            return Err(format!(
                "`{name}` is no name: write a letter, then letters, digits and `_`, and no word of the language"
            ));
        }
        let declaration =
            self.declaration(path, offset).ok_or("here stands no name that is declared in a file of yours")?;
        let text_at = |place: &FilePlace| self.texts.get(&place.path).and_then(|text| text.get(place.start..place.end));
        let old = text_at(declaration).ok_or("the declaration is not to be found")?;
        let places = self.all_of(declaration);
        if let Some(other) = places.iter().filter_map(|place| text_at(place)).find(|text| *text != old) {
            return Err(format!("`{old}` is used as `{other}`, by an index: write the new name by hand"));
        }
        let files: BTreeSet<&Path> = places.iter().map(|place| place.path.as_path()).collect();
        let known = self.links.iter().flat_map(|(used, declared)| std::iter::once(used).chain(declared));
        let is_taken = |place: &FilePlace| files.contains(place.path.as_path()) && text_at(place) == Some(name);
        if name != old && known.into_iter().any(is_taken) {
            return Err(format!("`{name}` stands for something else there"));
        }
        let mut changes: std::collections::HashMap<Uri, Vec<TextEdit>> = Default::default();
        for place in places {
            let location = self.location(place, unit).ok_or("a file cannot be named to the editor")?;
            let edit = TextEdit { range: location.range, new_text: name.to_owned() };
            changes.entry(location.uri).or_default().push(edit);
        }
        Ok(WorkspaceEdit { changes: Some(changes), ..WorkspaceEdit::default() })
    }
}
