//! Files of a program: its own, and those that it uses directly or indirectly.

use super::scope::{Import, Module};
use super::{boards, errors, meshes};
use crate::diagnostic::Sink;
use crate::source::{FileId, Origin, Sources, Span};
use crate::stdlib;
use crate::syntax::{self, tree};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Greatest number of files in one program.
pub const MAX_FILES: usize = 256;

/// Reason why a file cannot be used; each text ends a sentence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FileFault {
    /// The file does not exist or cannot be read.
    Unread(String),
    NotText(String),
    /// A mesh file that would be too long as text.
    LongMesh(String),
    /// A mesh file that is not a closed surface.
    NoSurface(String),
}

impl From<String> for FileFault {
    fn from(why: String) -> FileFault {
        FileFault::Unread(why)
    }
}

impl From<&str> for FileFault {
    fn from(why: &str) -> FileFault {
        FileFault::Unread(why.to_owned())
    }
}

/// Source of used files: the disk, a log, a test's memory.
pub trait Library {
    /// Returns the name under which a file is known, and its text. `path` is relative to the file named `from`; two
    /// paths to one file must give one name.
    ///
    /// # Errors
    /// Why it cannot be used.
    fn read(&self, from: &str, path: &str) -> Result<(String, String), FileFault>;

    /// As `read`, for a mesh file; the result is text whatever the format on disk.
    ///
    /// # Errors
    /// Why it cannot be used.
    fn read_mesh(&self, from: &str, path: &str) -> Result<(String, String), FileFault> {
        self.read(from, path)
    }

    /// Name of a file in messages.
    fn shown(&self, name: &str) -> String {
        name.to_owned()
    }
}

/// Library without any file.
pub struct NoFiles;

impl Library for NoFiles {
    fn read(&self, _: &str, path: &str) -> Result<(String, String), FileFault> {
        Err(format!("`{path}` is not there").into())
    }
}

/// Reads a program's own file and every file that it uses, each once. The first module is the program's own.
pub fn load(sources: &mut Sources, name: &str, text: &str, library: &dyn Library, sink: &mut Sink) -> Vec<Module> {
    let (known, texts) = (BTreeMap::new(), BTreeMap::new());
    let mut loader = Loader { sources, library, sink, modules: Vec::new(), known, texts, open: Vec::new() };
    loader.file(name, Span::default(), text, Origin::User);
    loader.modules.into_iter().flatten().collect()
}

struct Loader<'a> {
    sources: &'a mut Sources,
    library: &'a dyn Library,
    sink: &'a mut Sink,
    /// A module is `None` while the files that it uses are being read.
    modules: Vec<Option<Module>>,
    known: BTreeMap<(Origin, String), usize>,
    /// Texts of the mesh and board files, by name.
    texts: BTreeMap<String, Arc<str>>,
    /// The files being read, by name, the outermost first, with the `use` that named each.
    open: Vec<(String, Span)>,
}

impl Loader<'_> {
    fn file(&mut self, name: &str, asked: Span, text: &str, origin: Origin) -> usize {
        let index = self.modules.len();
        self.modules.push(None);
        self.known.insert((origin, name.to_owned()), index);
        self.open.push((name.to_owned(), asked));
        let file = self.sources.add_as(name.to_owned(), self.shown(name, origin), origin, text);
        let tree = syntax::parse(file, text, self.sink);
        let imports = self.imports(&tree);
        let named_files = self.named_files(&tree, name);
        self.open.pop();
        let mut module = Module::new(tree, imports, origin, self.sink);
        module.named_files = named_files;
        self.modules[index] = Some(module);
        index
    }

    /// Name of a file in messages.
    fn shown(&self, name: &str, origin: Origin) -> String {
        match origin {
            Origin::User => self.library.shown(name),
            Origin::Library | Origin::Setting => name.to_owned(),
        }
    }

    /// The mesh and board files that shapes and devices of a file name, by path. They become sources like any other, so
    /// that logs carry them.
    fn named_files(&mut self, tree: &tree::Tree, from: &str) -> BTreeMap<String, Arc<str>> {
        let mut files = BTreeMap::new();
        let boards: Vec<&tree::Text> = boards::named(tree);
        let of_triangles = meshes::named(tree).into_iter().map(|text| (text, true));
        for (text, is_mesh) in of_triangles.chain(boards.into_iter().map(|text| (text, false))) {
            let Some(path) = text.plain().filter(|path| !files.contains_key(path)) else { continue };
            let is_full = self.modules.len() + self.texts.len() >= MAX_FILES;
            let read = match is_mesh {
                true => self.library.read_mesh(from, &path),
                false => self.library.read(from, &path),
            };
            match read {
                Ok((name, _)) if is_full && !self.texts.contains_key(&name) => {
                    self.sink.push(errors::too_many_files(text.span, MAX_FILES));
                }
                Ok((name, text)) => {
                    let known = self.texts.entry(name);
                    let known = known.or_insert_with_key(|name| {
                        let text: Arc<str> = text.into();
                        let shown = self.library.shown(name);
                        self.sources.add_as(name.clone(), shown, Origin::User, Arc::clone(&text));
                        text
                    });
                    files.insert(path, Arc::clone(known));
                }
                Err(fault) => self.sink.push(errors::unusable_file(text.span, &path, &fault, &[])),
            }
        }
        files
    }

    fn imports(&mut self, tree: &tree::Tree) -> BTreeMap<String, Import> {
        let mut imports: BTreeMap<String, Import> = BTreeMap::new();
        for item in &tree.items {
            let tree::Item::Use(item) = item else { continue };
            let Some((alias, span)) = self.name_of(item) else { continue };
            let module = self.import(item, tree.file);
            match imports.get(&alias) {
                Some(earlier) => self.sink.push(errors::declared_twice(&alias, span, earlier.span)),
                None => {
                    imports.insert(alias, Import { module, span });
                }
            }
        }
        imports
    }

    /// The name that a used file has here, and where that name stands; `None` if the path was reported.
    fn name_of(&mut self, item: &tree::Use) -> Option<(String, Span)> {
        if let Some(alias) = &item.alias {
            return Some((self.file_name(&alias.text, alias.span), alias.span));
        }
        match &item.path {
            // A file of the standard library is named after its kind.
            tree::UsePath::Library { words, .. } => words.last().map(|last| (last.text.clone(), last.span)),
            tree::UsePath::File(text) => {
                let Some(path) = text.plain() else {
                    self.sink.push(errors::braces_in_use(text.span));
                    return None;
                };
                let stem = path.rsplit('/').next().unwrap_or(&path).trim_end_matches(".twz").to_owned();
                if let Some(library) = library_named(&path).filter(|_| !is_name(&stem)) {
                    return Some((library.to_owned(), text.span));
                }
                if !is_name(&stem) {
                    self.sink.push(errors::file_without_name(text.span, &path, &stem));
                }
                Some((self.file_name(&stem, text.span), text.span))
            }
        }
    }

    fn file_name(&mut self, name: &str, span: Span) -> String {
        let is_kind = crate::device::Kind::find(name).is_some();
        if let Some(reserved_as) = super::scope::reserved_as(name).filter(|_| !is_kind) {
            self.sink.push(errors::reserved_file_name(span, name, reserved_as));
        }
        name.to_owned()
    }

    /// The module of a `use`; `None` after an error.
    fn import(&mut self, item: &tree::Use, from: FileId) -> Option<usize> {
        match &item.path {
            tree::UsePath::Library { words, span } => self.library_file(words, *span),
            tree::UsePath::File(text) => self.disk_file(&text.plain()?, text.span, from),
        }
    }

    fn library_file(&mut self, words: &[tree::Ident], span: Span) -> Option<usize> {
        let path = words.iter().map(|word| word.text.as_str()).collect::<Vec<_>>().join(".");
        let name = path.strip_prefix("std.").unwrap_or_default();
        let Some(text) = stdlib::file(name) else {
            let known: Vec<String> = stdlib::names().map(|name| format!("std.{name}")).collect();
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            let full = if path.starts_with("std.") { path.clone() } else { format!("std.{path}") };
            let near = super::scope::nearest(&full, known.iter().copied());
            self.sink.push(errors::unknown_library(span, &path, near, &known));
            return None;
        };
        self.module(&format!("std.{name}"), text, Origin::Library, span)
    }

    fn disk_file(&mut self, path: &str, span: Span, from: FileId) -> Option<usize> {
        let from = self.sources.file(from).name.clone();
        match self.library.read(&from, path) {
            Ok((name, text)) => self.module(&name, &text, Origin::User, span),
            Err(fault) => {
                if let Some(name) = library_named(path) {
                    self.sink.push(errors::library_in_quotes(span, name));
                    return None;
                }
                let chain: Vec<String> = self.open.iter().map(|(name, _)| self.library.shown(name)).collect();
                self.sink.push(errors::unusable_file(span, path, &fault, &chain));
                None
            }
        }
    }

    fn module(&mut self, name: &str, text: &str, origin: Origin, span: Span) -> Option<usize> {
        let known = self.known.get(&(origin, name.to_owned())).copied();
        let is_open = |index: &usize| self.modules[*index].is_none();
        if known.as_ref().is_some_and(is_open) {
            let start = self.open.iter().position(|(open, _)| open == name).unwrap_or_default();
            let shown = |(name, at): &(String, Span)| (*at, self.library.shown(name));
            let uses: Vec<(Span, String)> = self.open[start + 1..].iter().map(shown).collect();
            let uses: Vec<(Span, &str)> = uses.iter().map(|(at, name)| (*at, name.as_str())).collect();
            self.sink.push(errors::import_cycle(span, &self.library.shown(name), &uses));
            return None;
        }
        if known.is_some() {
            return known;
        }
        if self.modules.len() >= MAX_FILES {
            self.sink.push(errors::too_many_files(span, MAX_FILES));
            return None;
        }
        Some(self.file(name, span, text, origin))
    }
}

/// The file of the standard library that a path in quotes names: `"std.dimibot"`, `"dimibot.twz"`.
fn library_named(path: &str) -> Option<&str> {
    let name = path.strip_prefix("std").map_or(path, |name| name.trim_start_matches(['.', '/']));
    let name = name.trim_end_matches(".twz");
    stdlib::file(name).is_some().then_some(name)
}

/// Whether a file's stem is a valid name, which can stand before a dot.
fn is_name(stem: &str) -> bool {
    let mut characters = stem.chars();
    let begins = characters.next().is_some_and(|first| first.is_alphabetic() || first == '_');
    begins && characters.all(|c| c.is_alphanumeric() || c == '_') && !syntax::RESERVED.contains(&stem)
}
