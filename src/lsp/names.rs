//! Go to definition, find references and rename, over all open programs.
//!
//! Each request checks every open program once more, with open texts in place of files, so that uses in other programs
//! that use the same file are found as well. Names of the standard library have no place that an editor can open.

use super::findings::Overlay;
use super::outline;
use super::text::{self, ColumnUnit, EditedText};
use crate::check::imports::{Library, NoFiles};
use crate::check::{Options, ProgramSource, check_program, links};
use crate::diagnostic::Sink;
use crate::source::{Origin, Sources, Span};
use crate::syntax::{
    self,
    tree::{Item, SceneEntry},
};
use lsp_types::{Location, TextEdit, Uri, WorkspaceEdit};
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A range of bytes in a file.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
struct FilePlace {
    path: PathBuf,
    start: usize,
    end: usize,
}

/// Names of some programs, with their uses and declarations.
pub struct ProgramNames {
    /// URIs of the open texts.
    uris: BTreeMap<PathBuf, Uri>,
    /// Uses with their declarations, without indices; the declaration is `None` for a name of the standard library.
    links: BTreeSet<(FilePlace, Option<FilePlace>)>,
    /// All declarations, used or not.
    declared: BTreeSet<FilePlace>,
    texts: BTreeMap<PathBuf, String>,
}

/// Whether a word may be declared as a new name.
fn is_free_name(name: &str) -> bool {
    let text = format!("let {name} = 1\n");
    let mut sink = Sink::default();
    let tree = syntax::parse(Sources::default().add("", text.as_str()), &text, &mut sink);
    let is_name = matches!(tree.items.as_slice(), [Item::Let(item)] if item.name.text == name);
    // The names of kinds, shapes and functions are taken.
    let request = ProgramSource { name: "", text: &text, library: &NoFiles, options: &Options::default() };
    check_program(&request, &mut Sources::default(), &mut sink);
    is_name && sink.errors() == 0
}

/// The names that a text declares at top level and in its scenes.
fn declared_in(text: &str) -> Vec<Span> {
    fn objects(entries: &[SceneEntry], found: &mut Vec<Span>) {
        for entry in entries {
            match entry {
                SceneEntry::Object(object) => found.push(object.name.name.span),
                SceneEntry::For(each) => objects(&each.entries, found),
                SceneEntry::Error(_) => {}
            }
        }
    }
    let mut found = Vec::new();
    for item in &outline::tree(text).items {
        match item {
            Item::Let(item) => found.push(item.name.span),
            Item::Device(item) | Item::Instrument(item) | Item::Output(item) => found.push(item.name.span),
            Item::Scene(item) => {
                found.push(item.name.span);
                objects(&item.entries, &mut found);
            }
            Item::Task(_) | Item::Program(_) => found.extend(item.runnable().map(|head| head.name.span)),
            Item::Use(_) | Item::Wiring(_) | Item::Error(_) => {}
        }
    }
    found.retain(|span| !span.range().is_empty());
    found
}

impl ProgramNames {
    /// Without names yet; `uris` are those of the open texts.
    pub fn new(uris: BTreeMap<PathBuf, Uri>) -> ProgramNames {
        ProgramNames { uris, links: BTreeSet::new(), declared: BTreeSet::new(), texts: BTreeMap::new() }
    }

    /// Adds the names of the program of a path, which must be one of the open texts.
    pub fn add(&mut self, path: &Path, texts: &BTreeMap<PathBuf, &str>, disk: &dyn Library) {
        let Some(text) = texts.get(path) else { return };
        let name = text::file_name(path);
        let library = Overlay::around(path, texts, disk);
        let mut sources = Sources::default();
        let request = ProgramSource { name: &name, text, library: &library, options: &Options::default() };
        for link in links::links(&request, &mut sources) {
            let place = |span: Span| {
                let file = sources.file(span.file);
                let Range { start, end } = span.range();
                // `s[i]` and `s[0]` are the same name.
                let word = file.text.get(start..end).map_or(0, |text| text.find('[').unwrap_or(text.len()));
                let end = start + word;
                (file.origin == Origin::User).then(|| FilePlace { path: library.path(&file.name), start, end })
            };
            if let Some(used) = place(link.used) {
                self.links.insert((used, place(link.declared)));
            }
        }
        for (_, file) in sources.files().filter(|(_, file)| file.origin == Origin::User) {
            let path = library.path(&file.name);
            let declared = declared_in(&file.text).into_iter().map(Span::range);
            self.declared.extend(declared.map(|Range { start, end }| FilePlace { path: path.clone(), start, end }));
            self.texts.insert(path, file.text.to_string());
        }
    }

    fn text_at(&self, place: &FilePlace) -> Option<&str> {
        self.texts.get(&place.path).and_then(|text| text.get(place.start..place.end))
    }

    /// Whether a use is the name of a parameter, to which this declaration was passed as an argument.
    fn is_by_parameter(&self, used: &FilePlace, declared: &FilePlace) -> bool {
        let has_name = |declared: &FilePlace| self.text_at(declared) == self.text_at(used);
        let others = || self.links.iter().filter(|(other, _)| other == used).filter_map(|(_, other)| other.as_ref());
        !has_name(declared) && others().any(has_name)
    }

    /// The declaration of the name at a position, which may be a use or the declaration itself.
    fn declaration(&self, path: &Path, offset: usize) -> Option<&FilePlace> {
        let is_here = |place: &FilePlace| place.path == path && (place.start..=place.end).contains(&offset);
        let linked = self.links.iter().find_map(|(used, declared)| {
            let declared = declared.as_ref()?;
            let is_used_here = is_here(used) && !self.is_by_parameter(used, declared);
            (is_used_here || is_here(declared)).then_some(declared)
        });
        linked.or_else(|| self.declared.iter().find(|place| is_here(place)))
    }

    /// A declaration and all its uses, in order.
    fn all_of<'n>(&'n self, declaration: &'n FilePlace) -> BTreeSet<&'n FilePlace> {
        let uses = self.links.iter().filter(|(used, declared)| {
            declared.as_ref() == Some(declaration) && !self.is_by_parameter(used, declaration)
        });
        uses.map(|(used, _)| used).chain([declaration]).collect()
    }

    fn location(&self, place: &FilePlace, unit: ColumnUnit) -> Option<Location> {
        let shown = EditedText::new(self.texts.get(&place.path)?.clone());
        let uri = self.uris.get(&place.path).cloned().or_else(|| text::uri(&place.path))?;
        Some(Location { uri, range: shown.range(place.start..place.end, unit) })
    }

    /// Where the name at a position is declared.
    pub fn definition(&self, path: &Path, offset: usize, unit: ColumnUnit) -> Option<Location> {
        self.location(self.declaration(path, offset)?, unit)
    }

    /// All occurrences of the name at a position, in order; optionally without its declaration.
    pub fn references(&self, path: &Path, offset: usize, unit: ColumnUnit, with_declaration: bool) -> Vec<Location> {
        let Some(declaration) = self.declaration(path, offset) else { return Vec::new() };
        let places = self.all_of(declaration).into_iter();
        let wanted = places.filter(|place| with_declaration || *place != declaration);
        wanted.filter_map(|place| self.location(place, unit)).collect()
    }

    /// All occurrences of the name at a position, in all files, if it can be renamed to `name`.
    fn renamable(&self, path: &Path, offset: usize, name: &str) -> Result<BTreeSet<&FilePlace>, String> {
        if !is_free_name(name) {
            return Err(format!(
                "`{name}` is not a valid name: use a letter followed by letters, digits and `_`, but no word of the language"
            ));
        }
        let declaration = self.declaration(path, offset).ok_or("no name declared in your files is at the cursor")?;
        let old = self.text_at(declaration).ok_or("the declaration was not found")?;
        let places = self.all_of(declaration);
        if let Some(other) = places.iter().filter_map(|place| self.text_at(place)).find(|text| *text != old) {
            return Err(format!("`{old}` is used as `{other}`, with an index: rename by hand"));
        }
        let files: BTreeSet<&Path> = places.iter().map(|place| place.path.as_path()).collect();
        let known = self.links.iter().flat_map(|(used, declared)| std::iter::once(used).chain(declared));
        let is_taken = |place: &FilePlace| files.contains(place.path.as_path()) && self.text_at(place) == Some(name);
        if name != old && known.chain(&self.declared).any(is_taken) {
            return Err(format!("`{name}` already has another meaning there"));
        }
        Ok(places)
    }

    /// The edits that rename the name at a position in all files, and the texts of these files afterwards.
    ///
    /// # Errors
    /// The reason why it cannot have that name, or cannot be renamed at all.
    // `Uri` is the protocol library's type; its hash depends on its text only, so it may be a key.
    #[allow(clippy::mutable_key_type)]
    pub fn renamed(
        &self,
        path: &Path,
        offset: usize,
        unit: ColumnUnit,
        name: &str,
    ) -> Result<(WorkspaceEdit, BTreeMap<PathBuf, String>), String> {
        let places = self.renamable(path, offset, name)?;
        let mut changes: std::collections::HashMap<Uri, Vec<TextEdit>> = Default::default();
        let mut texts: BTreeMap<PathBuf, String> = BTreeMap::new();
        // From the end, so that earlier offsets stay valid.
        for place in places.into_iter().rev() {
            let location = self.location(place, unit).ok_or("a file has no URI for the editor")?;
            let whole = self.texts.get(&place.path).ok_or("a file was not found")?;
            let text = texts.entry(place.path.clone()).or_insert_with(|| whole.clone());
            text.replace_range(place.start..place.end, name);
            let edit = TextEdit { range: location.range, new_text: name.to_owned() };
            changes.entry(location.uri).or_default().push(edit);
        }
        changes.values_mut().for_each(|edits| edits.reverse());
        Ok((WorkspaceEdit { changes: Some(changes), ..WorkspaceEdit::default() }, texts))
    }
}
