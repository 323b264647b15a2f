//! Name resolution: the files of a program, their declarations, and the local names of a block.

use super::camera::View;
use super::errors;
use super::value::Value;
use crate::device::{Kind, shape::ShapeForm};
use crate::diagnostic::Sink;
use crate::source::{Origin, Span, Spanned};
use crate::syntax::functions::is_function;
use crate::syntax::tree::{self, Ident, Item, SceneEntry, Tree};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Words that may begin a step in place of a verb, for all kinds.
pub const STEP_WORDS: [&str; 10] =
    ["wait", "prompt", "pulse", "set", "together", "assay", "minimize", "using", "require", "start"];

/// The name of the angle in the expression of a curve.
pub const ANGLE_NAME: &str = "t";

/// A file with its declarations and the files that it uses.
#[derive(Debug)]
pub struct Module {
    pub tree: Tree,
    /// Used files by alias, such as `dimibot` and `lab`.
    pub imports: BTreeMap<String, Import>,
    pub names: BTreeMap<String, Declaration>,
    /// Texts of the mesh and board files that its shapes and devices name, by the path written there.
    pub named_files: BTreeMap<String, Arc<str>>,
    origin: Origin,
}

/// A used file.
#[derive(Debug, Clone, Copy)]
pub struct Import {
    /// `None` if the file could not be used, already reported.
    pub module: Option<usize>,
    pub span: Span,
}

/// A name at the top of a file.
#[derive(Debug, Clone, Copy)]
pub struct Declaration {
    pub sort: DeclarationSort,
    /// Index among the file's items.
    pub item: usize,
    /// Span of the name in its declaration.
    pub span: Span,
}

/// Sort of a top-level name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum DeclarationSort {
    Let,
    Device,
    Instrument,
    Output,
    Scene,
    Task,
    Program,
}

impl DeclarationSort {
    /// Noun without an article.
    pub fn name(self) -> &'static str {
        match self {
            DeclarationSort::Let => "value",
            DeclarationSort::Device => "device",
            DeclarationSort::Instrument => "instrument",
            DeclarationSort::Output => "output",
            DeclarationSort::Scene => "scene",
            DeclarationSort::Task => "task",
            DeclarationSort::Program => "program",
        }
    }

    /// Noun with its article.
    pub fn describe(self) -> &'static str {
        match self {
            DeclarationSort::Let => "a value",
            DeclarationSort::Device => "a device",
            DeclarationSort::Instrument => "an instrument",
            DeclarationSort::Output => "an output",
            DeclarationSort::Scene => "a scene",
            DeclarationSort::Task => "a task",
            DeclarationSort::Program => "a program",
        }
    }
}

/// Key of a declaration: its file and its index among the file's items.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct DeclarationPlace {
    pub module: usize,
    pub item: usize,
}

impl Module {
    /// Collects the declarations of a file; duplicate and reserved names are reported.
    pub fn new(tree: Tree, imports: BTreeMap<String, Import>, origin: Origin, sink: &mut Sink) -> Module {
        let mut names: BTreeMap<String, Declaration> = BTreeMap::new();
        let declared = tree.items.iter().enumerate().filter_map(|(index, item)| Some((index, declared(item)?)));
        for (item, (name, sort)) in declared {
            if let Some(reserved_as) = reserved_as(&name.text) {
                sink.push(errors::reserved_name(name, reserved_as));
            }
            let earlier = names.get(&name.text).map(|d| d.span).or(imports.get(&name.text).map(|i| i.span));
            match earlier {
                Some(earlier) => sink.push(errors::declared_twice(&name.text, name.span, earlier)),
                None => {
                    names.insert(name.text.clone(), Declaration { sort, item, span: name.span });
                }
            }
        }
        Module { tree, imports, names, named_files: BTreeMap::new(), origin }
    }

    /// Whether a part that could not be read may declare a name here: reporting it as missing would repeat one mistake.
    pub fn is_broken(&self, name: &str) -> bool {
        self.tree.broken_names.iter().any(|broken| broken.text == name)
    }

    /// Whether a declaration could not be read, so that it may contain a name that seems missing.
    pub fn has_broken_parts(&self) -> bool {
        self.tree.items.iter().any(|item| matches!(item, Item::Error(_)))
    }

    /// Whether a file that could not be used, or a `use` that could not be read, may have declared an alias that seems
    /// missing.
    pub fn has_broken_use(&self, name: &str) -> bool {
        let is_library = crate::stdlib::file(name).is_some();
        // The alias of a `use` that breaks off at `as` is unknown.
        let may_be_read = is_library || self.is_broken(name) || self.is_broken("as");
        self.imports.values().any(|import| import.module.is_none()) || (may_be_read && self.has_broken_parts())
    }

    /// The object of this name in one of its scenes, whatever its index.
    pub fn object_of_scenes(&self, name: &str) -> Option<&tree::Object> {
        fn find<'t>(entries: &'t [SceneEntry], name: &str) -> Option<&'t tree::Object> {
            entries.iter().find_map(|entry| match entry {
                SceneEntry::Object(object) => (object.name.name.text == name).then_some(object),
                SceneEntry::For(each) => find(&each.entries, name),
                SceneEntry::Error(_) => None,
            })
        }
        self.tree.items.iter().find_map(|item| {
            let Item::Scene(scene) = item else { return None };
            find(&scene.entries, name)
        })
    }

    /// The alias that `as` gives to a file of the standard library, and where.
    pub fn used_as(&self, name: &str) -> Option<(&str, Span)> {
        self.tree.items.iter().find_map(|item| {
            let Item::Use(tree::Use { path: tree::UsePath::Library { words, .. }, alias: Some(alias), .. }) = item
            else {
                return None;
            };
            (words.last()?.text == name).then_some((alias.text.as_str(), alias.span))
        })
    }

    /// Whether it belongs to the standard library.
    pub fn is_library(&self) -> bool {
        self.origin == Origin::Library
    }
}

/// The name that an item declares, and its sort.
pub fn declared(item: &Item) -> Option<(&Ident, DeclarationSort)> {
    match item {
        Item::Let(item) => Some((&item.name, DeclarationSort::Let)),
        Item::Device(item) => Some((&item.name, DeclarationSort::Device)),
        Item::Instrument(item) => Some((&item.name, DeclarationSort::Instrument)),
        Item::Output(item) => Some((&item.name, DeclarationSort::Output)),
        Item::Scene(item) => Some((&item.name, DeclarationSort::Scene)),
        Item::Task(item) => Some((&item.name, DeclarationSort::Task)),
        Item::Program(item) => Some((&item.name, DeclarationSort::Program)),
        Item::Use(_) | Item::Wiring(_) | Item::Error(_) => None,
    }
}

/// What the language reserves a name for, if it does.
pub fn reserved_as(name: &str) -> Option<&'static str> {
    if Kind::find(name).is_some() {
        return Some("a device kind");
    }
    if ShapeForm::find(name).is_some() {
        return Some("a shape");
    }
    if is_function(name) {
        return Some("a function");
    }
    let outcome = Kind::ALL.iter().flat_map(|kind| kind.vocabulary().outcomes).any(|outcome| outcome.name == name);
    outcome.then_some("an outcome that `require` compares")
}

/// Scope of an expression: its module and the local names of its block.
#[derive(Debug, Clone)]
pub struct Scope {
    pub module: usize,
    /// The image that places in pixels refer to here.
    pub view: View,
    locals: Vec<Local>,
}

/// A loop variable or a parameter.
#[derive(Debug, Clone)]
pub struct Local {
    pub name: String,
    pub value: Value,
    pub span: Span,
    /// Where the value was given: the argument of a run, the element of a list.
    pub given: Span,
}

impl Scope {
    /// The top of a file.
    pub fn top(module: usize) -> Scope {
        Scope { module, view: View::None, locals: Vec::new() }
    }

    /// The scope with another view.
    pub fn seeing(&self, view: View) -> Scope {
        Scope { view, ..self.clone() }
    }

    /// Whether it has no loop variables and no parameters.
    pub fn is_top(&self) -> bool {
        self.locals.is_empty()
    }

    /// The local of a name.
    pub fn local(&self, name: &str) -> Option<&Local> {
        self.locals.iter().find(|local| local.name == name)
    }

    /// The names of the block.
    pub fn local_names(&self) -> impl Iterator<Item = &str> {
        self.locals.iter().map(|local| local.name.as_str())
    }

    /// Runs `inside` with one more local, which is removed afterwards.
    pub fn with<T>(&mut self, name: &Ident, value: Spanned<Value>, inside: impl FnOnce(&mut Scope) -> T) -> T {
        self.push(name, value);
        let result = inside(self);
        self.locals.pop();
        result
    }

    /// Adds a local permanently.
    pub fn push(&mut self, name: &Ident, value: Spanned<Value>) {
        let Spanned { value, span: given } = value;
        self.locals.push(Local { name: name.text.clone(), value, span: name.span, given });
    }
}

/// The only known qualified name that ends with a name, as `dimibot.femto_st` with `femto_st`; `None` if there are
/// several.
pub fn in_a_used_file<'a>(name: &str, known: &'a [String]) -> Option<&'a str> {
    let mut ends = known.iter().filter(|known| known.rsplit_once('.').is_some_and(|(_, last)| last == name));
    ends.next().filter(|_| ends.next().is_none()).map(String::as_str)
}

/// Greatest length of a name for which a near one is searched: a longer one is no typing slip, and the cost of
/// comparing is quadratic in its length.
const MAX_NEAR_CHARACTERS: usize = 60;

/// Greatest number of candidates that are compared.
const MAX_NEAR_NAMES: usize = 2_000;

/// The known name nearest to a misspelt one, if it is near enough to be meant. Of very many names the first
/// `MAX_NEAR_NAMES` of a similar length are compared.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let characters = name.chars().take(MAX_NEAR_CHARACTERS + 1).count();
    if characters > MAX_NEAR_CHARACTERS {
        return None;
    }
    let allowed = (characters / 3).max(1);
    let lower = name.to_lowercase();
    let distance = |candidate: &str| strsim::osa_distance(&lower, &candidate.to_lowercase());
    let is_begun = |candidate: &str| candidate.strip_prefix(name).is_some_and(|rest| rest.starts_with('_'));
    let is_long = |candidate: &str| candidate.chars().nth(characters + allowed).is_some();
    let near = known.into_iter().filter(|candidate| !is_long(candidate) || is_begun(candidate)).take(MAX_NEAR_NAMES);
    // Candidates that begin with the name differ by their remaining characters.
    let far = |candidate: &str| candidate.chars().count() - characters;
    near.map(|candidate| (if is_long(candidate) { far(candidate) } else { distance(candidate) }, candidate))
        .filter(|(distance, candidate)| {
            *distance <= allowed && *distance < candidate.chars().count() || is_begun(candidate)
        })
        .min()
        .map(|(_, candidate)| candidate)
}

/// The words of a path, joined by dots, for messages.
pub fn path_text(path: &tree::Path) -> String {
    let words: Vec<&str> = path.segments.iter().map(|segment| segment.name.text.as_str()).collect();
    words.join(".")
}
