//! Objects of scenes as tasks meet them: each scene judged once for each device, and the objects that steps name.

use super::lets::Argument;
use super::scenes::{CheckedScene, SceneObject};
use super::scope::{DeclarationPlace, nearest};
use super::tasks::TaskSite;
use super::value::Value;
use super::{Checker, errors};
use crate::device::Vocabulary;
use crate::diagnostic::{Diagnostic, Sink};
use crate::source::Span;
use std::any::Any;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// Judged scenes by (scene, device), each in the type of the device's kind.
pub type JudgedScenes = BTreeMap<(DeclarationPlace, DeclarationPlace), Rc<dyn Any>>;

impl Checker<'_> {
    /// The scene of a task as its device meets it, judged once with each device; `judge` gets `None` where the task has
    /// no scene.
    pub fn scene_met<S: 'static>(
        &mut self,
        site: &TaskSite,
        judge: impl FnOnce(&mut Self, Option<&CheckedScene>) -> S,
    ) -> Rc<S> {
        let Some((place, scene)) = &site.scene else { return Rc::new(judge(self, None)) };
        let key = (*place, site.place);
        // A device is of one kind, and each kind judges its scenes in one type.
        if let Some(Ok(known)) = self.judged.get(&key).map(|known| Rc::clone(known).downcast::<S>()) {
            return known;
        }
        let met = Rc::new(judge(self, Some(scene)));
        self.judged.insert(key, met.clone());
        met
    }
}

/// Diagnostic for an object whose noun the kind lacks.
pub fn of_other_kind(object: &SceneObject, vocabulary: &Vocabulary) -> Diagnostic {
    let known: Vec<&str> = vocabulary.nouns.iter().map(|noun| noun.name).collect();
    errors::noun_of_other_kind(object.noun_span, &object.noun, vocabulary.name, &known)
}

/// The parts or robots of a scene, by the names that steps use.
#[derive(Debug, Clone, Default)]
pub struct ObjectNames {
    /// Indices by name; `None` for a faulty object.
    indices: BTreeMap<String, Option<usize>>,
    /// Objects of other nouns, which no step can name here, each with its noun and its span.
    others: BTreeMap<String, (&'static str, Span)>,
    /// Names that the device knows, of objects that the scene may lack.
    known: BTreeSet<String>,
    /// Whether the task's lack of a scene was reported, which is one mistake however many names it has.
    lacks_scene: Cell<bool>,
}

impl ObjectNames {
    /// Enters names that the device knows: where the scene lacks such an object, no similar name is suggested.
    pub fn know<'n>(&mut self, names: impl IntoIterator<Item = &'n str>) {
        self.known.extend(names.into_iter().map(str::to_owned));
    }

    /// Enters a part or a robot.
    pub fn insert(&mut self, name: &str, index: Option<usize>) {
        self.indices.insert(name.to_owned(), index);
    }

    /// Enters an object of another noun, which no step can name here.
    pub fn insert_other(&mut self, name: &str, noun: &'static str, span: Span) {
        self.others.insert(name.to_owned(), (noun, span));
    }

    /// Whether an object of this name is declared but faulty, which was reported.
    pub fn is_faulty(&self, name: &str) -> bool {
        matches!(self.indices.get(name), Some(None))
    }

    /// Whether one of the objects is faulty, which was reported.
    pub fn has_faulty(&self) -> bool {
        self.indices.values().any(Option::is_none)
    }

    /// The index of the object that an argument names; `None` after an error in the argument or the object.
    ///
    /// `scene` is where the task's scene is declared. `is_whole` is false for a scene that was cut for its size: none
    /// of its names is known, and only the cut is reported.
    pub fn index(&self, argument: &Argument, scene: Option<Span>, is_whole: bool, sink: &mut Sink) -> Option<usize> {
        let Value::Object(object) = &argument.value else { return None };
        if let Some(known) = self.indices.get(&object.name) {
            return *known;
        }
        let is_cut = scene.is_some() && !is_whole && self.indices.is_empty();
        let wrong = match self.others.get(&object.name) {
            Some(found) => Some(errors::object_of_other_noun(argument.span, &object.name, object.noun, *found)),
            None if is_cut || (scene.is_none() && self.lacks_scene.replace(true)) => None,
            None => {
                let is_known = self.known.contains(&object.name);
                let near = nearest(&object.name, self.indices.keys().map(String::as_str)).filter(|_| !is_known);
                Some(errors::unknown_object(argument.span, object, near, scene))
            }
        };
        argument.unless(wrong, sink)?;
        None
    }
}
