//! Links from names to their declarations, for editors.
//!
//! When links are kept, the checker records every name as it resolves it: declarations of this file and of used ones,
//! parameters and names of loops, objects of a task's scene. Names that are not checked because of an error have no
//! link.

use super::scenes::CheckedScene;
use super::tasks::{VocabularyAction, VocabularyStep, may_repeat};
use super::value::Value;
use super::{Checker, Options, ProgramSource, imports};
use crate::check::lets::{Argument, paths};
use crate::device::Vocabulary;
use crate::diagnostic::Sink;
use crate::source::{Sources, Span};
use crate::syntax::tree::{Entry, IndexedName, Path};
use rustc_hash::FxHashSet;

/// A name in use, and its declaration.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct NameLink {
    pub used: Span,
    /// The name in its declaration.
    pub declared: Span,
}

/// The known links of a program, sorted and without duplicates. Reports nothing.
pub fn links(program: &ProgramSource, sources: &mut Sources) -> Vec<NameLink> {
    let mut sink = Sink::default();
    let modules = imports::load(sources, program.name, program.text, program.library, &mut sink);
    let mut checker = Checker::new(&modules, &mut sink);
    checker.links = Some(FxHashSet::default());
    checker.check_all(sources, &Options::default());
    let mut links: Vec<NameLink> = checker.links.into_iter().flatten().collect();
    links.sort_unstable();
    links
}

impl Checker<'_> {
    /// Records the declaration of a name, if links are kept. The angle of a curve is not declared: its place is the
    /// whole expression.
    pub fn note_use(&mut self, used: Span, declared: Span) {
        let is_within = declared.file == used.file && declared.range().contains(&(used.start as usize));
        if let Some(links) = self.links.as_mut().filter(|_| !is_within) {
            links.insert(NameLink { used, declared });
        }
    }

    /// Records the objects of a scene that the steps of a task name.
    pub fn link_objects(&mut self, steps: &[VocabularyStep], scene: Option<&CheckedScene>) {
        let (Some(_), Some(scene)) = (&self.links, scene) else { return };
        let calls = steps.iter().flat_map(|step| match &step.action {
            VocabularyAction::Verb(call) => std::slice::from_ref(call),
            VocabularyAction::Together(calls) | VocabularyAction::Assay(calls) => calls,
            VocabularyAction::Wait(_) => &[],
        });
        let arguments = calls.flat_map(|call| {
            let entered = call.entries.iter().flat_map(|entry| {
                std::iter::once(&entry.object).chain(entry.phrases.iter().map(|(_, argument)| argument))
            });
            call.object.iter().chain(call.phrases.iter().map(|(_, argument)| argument)).chain(entered)
        });
        let declared = |argument: &Argument| {
            let Value::Object(named) = &argument.value else { return None };
            let object = scene.objects.iter().find(|object| object.name == named.name)?;
            Some((argument.span, object.span))
        };
        let found: Vec<(Span, Span)> = arguments.filter_map(declared).collect();
        found.into_iter().for_each(|(used, declared)| self.note_use(used, declared));
    }

    /// Records the objects of a scene that the conditions of a task name: `avoid blood in serum`, `require half.dye ==
    /// 1 / 8`.
    pub fn link_conditions(&mut self, entries: &[Entry], vocabulary: &Vocabulary, scene: Option<&CheckedScene>) {
        let (Some(_), Some(scene)) = (&self.links, scene) else { return };
        let mut named = Vec::new();
        conditions(entries, vocabulary, &mut named);
        let words = named.iter().flat_map(|path| &path.segments).filter(|word| word.indices.is_empty());
        let declared = |word: &IndexedName| scene.objects.iter().find(|object| object.name == word.name.text);
        let found: Vec<(Span, Span)> = words.filter_map(|word| Some((word.name.span, declared(word)?.span))).collect();
        found.into_iter().for_each(|(used, declared)| self.note_use(used, declared));
    }
}

/// The names in the conditions of some entries, in the order of writing.
fn conditions<'e>(entries: &'e [Entry], vocabulary: &Vocabulary, named: &mut Vec<&'e Path>) {
    for entry in entries {
        match entry {
            Entry::Step(step) if may_repeat(&step.head, vocabulary) => {
                let phrases = step.phrases.iter().map(|phrase| &phrase.value);
                step.object.iter().chain(phrases).for_each(|expr| paths(expr, named));
            }
            Entry::For(each) => conditions(&each.entries, vocabulary, named),
            Entry::Step(_) | Entry::Field(_) | Entry::Error(_) => {}
        }
    }
}
