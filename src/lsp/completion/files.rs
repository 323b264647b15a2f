//! Trees of the files of a program, errors included: what each file declares, and which files it uses under which
//! names.

use crate::check::imports::Library;
use crate::check::scope::path_text;
use crate::device::Kind;
use crate::lsp::outline;
use crate::stdlib;
use crate::syntax::tree::{Item, Scene, Tree, Use, UsePath};
use std::collections::BTreeMap;

/// Greatest number of files of a program that are read; this also limits how deeply files use others.
const MAX_FILES: usize = 100;

/// The files of a program; its own file is the first.
pub(super) struct ProgramTrees {
    files: Vec<FileTree>,
}

struct FileTree {
    tree: Tree,
    /// The kind whose published devices the file declares, if it is a library file.
    kind: Option<Kind>,
    /// The files that it uses, by their names in it.
    uses: BTreeMap<String, UsedTree>,
}

/// A file that another one uses.
pub(super) struct UsedTree {
    /// As written in the `use`: `std.dimibot` or `"bench.twz"`.
    pub(super) written: String,
    file: usize,
}

impl ProgramTrees {
    /// Parses the text of a program and the files that it uses, directly or not; files that cannot be read are left
    /// out.
    pub(super) fn read(text: &str, library: &dyn Library) -> ProgramTrees {
        let mut trees = ProgramTrees { files: Vec::new() };
        trees.add("", text, None, library, &mut BTreeMap::new());
        trees
    }

    /// Adds a file by its name and returns its index; `known` are the files so far, with library files kept apart.
    fn add(
        &mut self,
        name: &str,
        text: &str,
        kind: Option<Kind>,
        library: &dyn Library,
        known: &mut BTreeMap<(bool, String), usize>,
    ) -> usize {
        let file = self.files.len();
        let tree = outline::tree(text);
        let uses =
            tree.items.iter().filter_map(|item| if let Item::Use(item) = item { Some(item.clone()) } else { None });
        let uses: Vec<Use> = uses.collect();
        self.files.push(FileTree { tree, kind, uses: BTreeMap::new() });
        for Use { path, alias, .. } in uses {
            let found = match &path {
                UsePath::Library { words, .. } => words.last().and_then(|word| {
                    let text = stdlib::file(&word.text)?.to_owned();
                    Some((word.text.clone(), format!("std.{}", word.text), text, Kind::find(&word.text)))
                }),
                UsePath::File(path) => path.plain().and_then(|path| {
                    let (name, text) = library.read(name, &path).ok()?;
                    Some((name, format!("\"{path}\""), text, None))
                }),
            };
            let Some((name, written, text, kind)) = found else { continue };
            // Without an alias, a file is known by its file name.
            let stem = name.rsplit('/').next().unwrap_or_default().trim_end_matches(".twz");
            let alias = alias.map_or_else(|| stem.to_owned(), |alias| alias.text);
            let is_library = matches!(path, UsePath::Library { .. });
            let used = match known.get(&(is_library, name.clone())) {
                Some(used) => *used,
                None if self.files.len() == MAX_FILES => continue,
                None => {
                    known.insert((is_library, name.clone()), self.files.len());
                    self.add(&name, &text, kind, library, known)
                }
            };
            self.files[file].uses.insert(alias, UsedTree { written, file: used });
        }
        file
    }

    /// The program's own file.
    pub(super) fn own(&self) -> &Tree {
        &self.files[0].tree
    }

    /// The files that the program's own file uses, by their names in it.
    pub(super) fn uses(&self) -> impl Iterator<Item = (&str, &UsedTree)> {
        self.files[0].uses.iter().map(|(alias, used)| (alias.as_str(), used))
    }

    /// The tree of the file that the program's own file uses under a name.
    pub(super) fn used(&self, alias: &str) -> Option<&Tree> {
        self.files[0].uses.get(alias).map(|used| &self.files[used.file].tree)
    }

    /// The file that declares a name used in another file, and the name there.
    fn resolved<'n>(&self, file: usize, name: &'n str) -> Option<(usize, &'n str)> {
        match name.split_once('.') {
            Some((alias, name)) => self.files[file].uses.get(alias).map(|used| (used.file, name)),
            None => Some((file, name)),
        }
    }

    /// The kind of a device by its name in the program's own file; follows the chain of bases.
    pub(super) fn kind(&self, name: &str) -> Option<Kind> {
        let (mut file, mut name) = (0, name.to_owned());
        // Visits each base at most once.
        for _ in 0..self.files.iter().map(|file| file.tree.items.len() + 1).sum() {
            let (within, device) = self.resolved(file, &name)?;
            if self.files[within].kind.is_some() {
                return self.files[within].kind;
            }
            let base = self.files[within].tree.items.iter().find_map(|item| match item {
                Item::Device(item) if item.name.text == device => Some(path_text(&item.base)),
                _ => None,
            });
            match base {
                Some(base) => (file, name) = (within, base),
                None => return Kind::find(device),
            }
        }
        None
    }

    /// A scene by its name in the program's own file, and the scenes that it is based on; all scenes of that file if
    /// the name is unknown.
    pub(super) fn scenes(&self, name: Option<&str>) -> Vec<&Scene> {
        let all = |file: usize| {
            let items = self.files[file].tree.items.iter();
            items.filter_map(|item| if let Item::Scene(scene) = item { Some(scene) } else { None })
        };
        let mut found: Vec<&Scene> = Vec::new();
        let mut next = name.map(|name| (0, name.to_owned()));
        while let Some((file, name)) = next.take() {
            let Some((within, name)) = self.resolved(file, &name) else { break };
            let Some(scene) = all(within).find(|scene| scene.name.text == name) else { break };
            if found.iter().any(|known| std::ptr::eq(*known, scene)) {
                break;
            }
            found.push(scene);
            next = scene.base.as_ref().map(|base| (within, path_text(base)));
        }
        if found.is_empty() { all(0).collect() } else { found }
    }
}
