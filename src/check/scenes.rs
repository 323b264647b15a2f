//! Scenes: their objects, unrolled and inherited. What an object means is for the kind of a task's device to say.

use super::scope::{DeclarationSort, Place, Scope, nearest};
use super::value::{ShapeValue, Value};
use super::{Checker, errors};
use crate::device::Kind;
use crate::source::{Span, Spanned};
use crate::syntax::tree::{self, Item, SceneEntry};
use std::collections::BTreeMap;
use std::rc::Rc;

/// How many scenes may stand on one another as bases.
pub const MAX_BASES: usize = 32;

/// Something that stands in a scene.
#[derive(Debug, Clone)]
pub struct Object {
    pub name: String,
    pub noun: String,
    pub noun_span: Span,
    pub shape: Option<Spanned<ShapeValue>>,
    pub at: Option<Spanned<Value>>,
    /// Its name where it is declared.
    pub span: Span,
}

/// The objects of a scene while it is being made out.
struct Collected {
    objects: Vec<Object>,
    /// Index and origin of each name.
    index: BTreeMap<String, (usize, Layer)>,
    is_whole: bool,
}

/// Where an object of a scene comes from.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Layer {
    Base,
    Own,
}

impl Checker<'_> {
    /// Checks every scene of the user's files.
    pub fn check_scenes(&mut self) {
        for (place, _) in self.own_places(DeclarationSort::Scene) {
            self.scene(place, 0);
        }
    }

    /// The objects of a scene, its bases' first; `None` after an error.
    pub fn scene(&mut self, place: Place, depth: usize) -> Option<Rc<Vec<Object>>> {
        if let Some(known) = self.scenes.get(&place) {
            return known.clone();
        }
        let Item::Scene(item) = self.item(place) else { return None };
        self.scenes.insert(place, None);
        let base = match &item.base {
            Some(path) => self.base_scene(place, item, path, depth),
            None => Some(Rc::new(Vec::new())),
        };
        let mut collected = Collected::on(base.as_deref().map_or(&[], Vec::as_slice));
        let mut scope = self.top(place);
        self.scene_entries(&item.entries, &mut scope, &mut collected);
        let scene = (base.is_some() && collected.is_whole).then(|| Rc::new(collected.objects));
        self.scenes.insert(place, scene.clone());
        scene
    }

    fn base_scene(
        &mut self,
        place: Place,
        item: &tree::Scene,
        path: &tree::Path,
        depth: usize,
    ) -> Option<Rc<Vec<Object>>> {
        let base = self.resolve(path, &self.top(place), DeclarationSort::Scene)?;
        if self.scene_stands_on(base, place) {
            self.sink.push(errors::defined_by_itself(path.span, item.name.span));
            return None;
        }
        if depth >= MAX_BASES {
            self.sink.push(errors::too_deep(path.span, "scenes", MAX_BASES));
            return None;
        }
        self.scene(base, depth + 1)
    }

    fn scene_stands_on(&self, scene: Place, wanted: Place) -> bool {
        let mut at = scene;
        for _ in 0..=self.modules.iter().map(|module| module.names.len()).sum() {
            if at == wanted {
                return true;
            }
            let Item::Scene(item) = self.item(at) else { return false };
            let Some(base) = item.base.as_ref().and_then(|path| self.find(path, &self.top(at))) else { return false };
            at = base.0;
        }
        false
    }

    fn scene_entries(&mut self, entries: &'_ [SceneEntry], scope: &mut Scope, collected: &mut Collected) {
        for entry in entries {
            match entry {
                SceneEntry::Object(object) => match self.object(object, scope) {
                    Some(object) => self.collect(object, collected),
                    None => collected.is_whole = false,
                },
                SceneEntry::For(each) => {
                    self.repeat(each, scope, &mut |checker, scope| {
                        checker.scene_entries(&each.entries, scope, collected)
                    });
                }
                SceneEntry::Error(_) => collected.is_whole = false,
            }
        }
    }

    fn collect(&mut self, object: Object, collected: &mut Collected) {
        match collected.index.get_mut(&object.name) {
            Some((index, layer)) if *layer == Layer::Base => {
                *layer = Layer::Own;
                collected.objects[*index] = object;
            }
            Some((index, _)) => {
                let earlier = collected.objects[*index].span;
                let diagnostic = if earlier == object.span {
                    errors::repeated_object(&object.name, object.span)
                } else {
                    errors::declared_twice(&object.name, object.span, earlier)
                };
                self.sink.push(diagnostic);
            }
            None => {
                collected.index.insert(object.name.clone(), (collected.objects.len(), Layer::Own));
                collected.objects.push(object);
            }
        }
    }

    fn object(&mut self, object: &tree::Object, scope: &Scope) -> Option<Object> {
        let is_known = self.known_noun(&object.noun);
        let name = self.joined(&object.name, scope);
        let shape = match &object.shape {
            Some(expr) => Some(self.shape_expr(expr, scope)),
            None => None,
        };
        let at = object.at.as_ref().map(|expr| self.evaluate_spanned(expr, scope));
        let is_whole = is_known && !at.as_ref().is_some_and(|at| at.value.is_unknown());
        let shape = match shape {
            Some(None) => return None,
            Some(shape) => shape,
            None => None,
        };
        let (noun, noun_span) = (object.noun.text.clone(), object.noun.span);
        is_whole.then_some(Object { name: name?, noun, noun_span, shape, at, span: object.name.span })
    }

    fn shape_expr(&mut self, expr: &tree::Expr, scope: &Scope) -> Option<Spanned<ShapeValue>> {
        match self.evaluate(expr, scope) {
            Value::Shape(shape) => Some(Spanned::new(shape, expr.span)),
            Value::Unknown => None,
            other => {
                self.sink.push(errors::shape_wanted(expr.span, &other));
                None
            }
        }
    }

    fn known_noun(&mut self, noun: &tree::Ident) -> bool {
        let known: Vec<&str> =
            Kind::ALL.iter().flat_map(|kind| kind.vocabulary().nouns).map(|noun| noun.name).collect();
        let is_known = known.contains(&noun.text.as_str());
        if !is_known {
            self.sink.push(errors::unknown_noun(
                noun.span,
                &noun.text,
                nearest(&noun.text, known.iter().copied()),
                &known,
            ));
        }
        is_known
    }

    /// A name with its indices joined: `d[3]` is `d3`, `e[5, 2]` is `e5_2`.
    pub fn joined(&mut self, name: &tree::IndexedName, scope: &Scope) -> Option<String> {
        if let Some(earlier) = self.taken(&name.name.text, scope).filter(|_| name.indices.is_empty()) {
            self.sink.push(errors::declared_twice(&name.name.text, name.name.span, earlier));
            return None;
        }
        let indices: Option<Vec<String>> =
            name.indices.iter().map(|index| self.index(index, scope).map(|number| number.to_string())).collect();
        Some(format!("{}{}", name.name.text, indices?.join("_")))
    }
}

impl Collected {
    fn on(base: &[Object]) -> Collected {
        let index =
            base.iter().enumerate().map(|(index, object)| (object.name.clone(), (index, Layer::Base))).collect();
        Collected { objects: base.to_vec(), index, is_whole: true }
    }
}
