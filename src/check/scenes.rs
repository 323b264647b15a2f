//! Scenes: their objects, unrolled and inherited. The kind of a task's device decides what an object means.

use super::camera::{Camera, View};
use super::frames::{self, DeviceFrame};
use super::lineage::Base;
use super::scope::{DeclarationPlace, DeclarationSort, Scope, nearest, reserved_as};
use super::value::{ShapeValue, Value};
use super::{Checker, errors};
use crate::claims::ValueOrigin;
use crate::device::Kind;
use crate::diagnostic::Diagnostic;
use crate::source::{Span, Spanned};
use crate::syntax::tree::{self, Item, SceneEntry};
use std::collections::BTreeMap;
use std::rc::Rc;

/// Longest chain of bases of a scene.
pub const MAX_BASES: usize = 32;

/// Object of a scene.
#[derive(Debug, Clone)]
pub struct SceneObject {
    pub name: String,
    pub noun: String,
    pub noun_span: Span,
    pub shape: Option<Spanned<ShapeValue>>,
    pub at: Option<Spanned<Value>>,
    /// Origin of the value of `at`, if a name stands there.
    pub origin: Option<ValueOrigin>,
    /// Span of its name in its declaration.
    pub span: Span,
}

/// The objects of a scene, its bases' first.
#[derive(Debug, Clone, Default)]
pub struct CheckedScene {
    pub objects: Vec<Rc<SceneObject>>,
    /// Placements of devices, by device.
    pub frames: BTreeMap<DeclarationPlace, DeviceFrame>,
    /// Placement of the image for places in pixels, if there is one.
    pub camera: Option<Camera>,
    /// Number of bases below it.
    depth: usize,
}

impl CheckedScene {
    /// Its image, as far as known.
    pub fn view(&self) -> View {
        self.camera.map_or(View::None, View::Image)
    }

    /// Diagnostic for a scene with more objects of a noun than its device allows; `most` are the nouns with their limits.
    pub fn crowd(&self, most: &[(&str, usize)]) -> Option<Diagnostic> {
        most.iter().find_map(|&(noun, most)| self.crowd_of(noun, most, |object| object.noun == noun))
    }

    /// An error if it has too many of some objects, named by a noun in the singular.
    pub fn crowd_of(&self, noun: &str, most: usize, is_one: impl Fn(&SceneObject) -> bool) -> Option<Diagnostic> {
        let mut alike = self.objects.iter().filter(|object| is_one(object));
        let first = alike.nth(most)?;
        Some(errors::too_many_objects(first.span, noun, most + 1 + alike.count(), most))
    }
}

/// The objects of a scene while it is being evaluated.
struct Collected {
    objects: Vec<Rc<SceneObject>>,
    /// Index and origin of each name.
    index: BTreeMap<String, (usize, SceneLayer)>,
    frames: BTreeMap<DeclarationPlace, (DeviceFrame, SceneLayer)>,
    is_whole: bool,
}

/// Layer that an object of a scene comes from.
#[derive(Clone, Copy, PartialEq, Eq)]
enum SceneLayer {
    Base,
    Own,
}

impl Checker<'_> {
    /// Checks every scene of the user's files.
    pub fn check_scenes(&mut self) {
        for (place, _) in self.own_places(DeclarationSort::Scene) {
            self.scene(place);
        }
    }

    /// The objects of a scene, its bases' first; `None` after an error.
    pub fn scene(&mut self, place: DeclarationPlace) -> Option<Rc<CheckedScene>> {
        let chain = self.lineage(place, &|checker, at| checker.scenes.contains_key(&at), &Checker::base_scene);
        for (at, base) in chain.into_iter().rev() {
            let base = match base {
                Base::Root(()) => Some(Rc::default()),
                Base::Of(base) => self.scenes.get(&base).cloned().flatten(),
                Base::Broken => None,
            };
            let scene = self.add_own_objects(at, base).map(Rc::new);
            self.scenes.insert(at, scene);
        }
        self.scenes.get(&place).cloned().flatten()
    }

    /// The view that a task has of its scene; `None` for a task without one, `Some(None)` for a scene that was not
    /// found.
    pub fn view_of(&mut self, scene: Option<Option<DeclarationPlace>>) -> View {
        match scene {
            None => View::None,
            Some(None) => View::Unknown,
            Some(Some(place)) => self.scene(place).map_or(View::Unknown, |scene| scene.view()),
        }
    }

    fn base_scene(&mut self, place: DeclarationPlace) -> Base<()> {
        let Item::Scene(item) = self.item(place) else { return Base::Broken };
        match &item.base {
            None => Base::Root(()),
            Some(path) => self.resolve(path, &self.top(place), DeclarationSort::Scene).map_or(Base::Broken, Base::Of),
        }
    }

    /// Adds a scene's own objects to those of its base; `None` after an error.
    fn add_own_objects(&mut self, place: DeclarationPlace, base: Option<Rc<CheckedScene>>) -> Option<CheckedScene> {
        let Item::Scene(item) = self.item(place) else { return None };
        let depth = item.base.as_ref().and(base.as_ref()).map_or(0, |base| base.depth + 1);
        let is_too_deep = depth > MAX_BASES;
        if let Some(path) = item.base.as_ref().filter(|_| is_too_deep) {
            self.sink.push(errors::too_deep(path.span, "scenes", MAX_BASES));
        }
        let mut collected = base.as_deref().map(Collected::on).unwrap_or_default();
        let mut scope = self.top(place);
        let image = self.image(&item.entries, &scope);
        let camera = image.map(|own| own.or(base.as_ref().and_then(|base| base.camera)));
        scope.view = match (camera, &base) {
            (Ok(Some(camera)), _) => View::Image(camera),
            (Ok(None), Some(_)) => View::None,
            (Err(()), _) | (Ok(None), None) => View::Unknown,
        };
        self.scene_entries(&item.entries, &mut scope, &mut collected);
        self.variables_apart(&item.entries, &collected);
        let is_whole = base.is_some() && collected.is_whole && !is_too_deep && camera.is_ok();
        let frames = collected.frames.into_iter().map(|(device, (frame, _))| (device, frame)).collect();
        is_whole.then_some(CheckedScene { objects: collected.objects, frames, camera: camera.ok().flatten(), depth })
    }

    /// Reports loop variables of a scene with the name of one of its objects: an object's name holds in the whole
    /// scene.
    fn variables_apart(&mut self, entries: &[SceneEntry], collected: &Collected) {
        for entry in entries {
            let SceneEntry::For(each) = entry else { continue };
            for name in each.counter.iter().chain([&each.element]) {
                if let Some((index, _)) = collected.index.get(&name.text) {
                    let object = collected.objects[*index].span;
                    self.sink.push(errors::declared_twice(&name.text, name.span, object));
                }
            }
            self.variables_apart(&each.entries, collected);
        }
    }

    fn scene_entries(&mut self, entries: &'_ [SceneEntry], scope: &mut Scope, collected: &mut Collected) {
        for entry in entries {
            match entry {
                SceneEntry::Object(object) if is_image(object) => {
                    if !scope.is_top() {
                        self.sink.push(errors::image_in_loop(object.name.span));
                        collected.is_whole = false;
                    }
                }
                SceneEntry::Object(object) if object.noun.text == frames::NOUN => match self.frame(object, scope) {
                    Some(frame) => self.collect_frame(frame, collected),
                    None => collected.is_whole = false,
                },
                SceneEntry::Object(object) => match self.object(object, scope) {
                    Some(object) => self.collect(Rc::new(object), collected),
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

    fn collect(&mut self, object: Rc<SceneObject>, collected: &mut Collected) {
        match collected.index.get_mut(&object.name) {
            Some((index, layer)) if *layer == SceneLayer::Base => {
                *layer = SceneLayer::Own;
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
                collected.index.insert(object.name.clone(), (collected.objects.len(), SceneLayer::Own));
                collected.objects.push(object);
            }
        }
    }

    fn collect_frame(&mut self, frame: DeviceFrame, collected: &mut Collected) {
        let earlier = collected.frames.get(&frame.device).filter(|(_, layer)| *layer == SceneLayer::Own);
        if let Some((earlier, _)) = earlier {
            let name = self.named(frame.device).0;
            let diagnostic = match earlier.span == frame.span {
                true => errors::repeated_object(name, frame.span),
                false => errors::declared_twice(name, frame.span, earlier.span),
            };
            self.sink.push(diagnostic);
            return;
        }
        collected.frames.insert(frame.device, (frame, SceneLayer::Own));
    }

    fn object(&mut self, object: &tree::Object, scope: &Scope) -> Option<SceneObject> {
        let is_known = self.known_noun(&object.noun);
        let name = self.object_name(&object.name, scope);
        let shape = object.shape.as_ref().map(|expr| match &object.at {
            Some(_) => self.shape_expr(expr, &scope.seeing(View::Shifted)),
            None => self.shape_expr(expr, scope),
        });
        let at = object.at.as_ref().map(|expr| {
            let at = self.evaluate(expr, scope);
            Spanned::new(self.in_scene(at, expr.span, scope), expr.span)
        });
        let origin = object.at.as_ref().and_then(|expr| self.origin(expr, scope));
        let is_whole = is_known && !at.as_ref().is_some_and(|at| at.value.is_unknown());
        let shape = match shape {
            Some(None) => return None,
            Some(shape) => shape,
            None => None,
        };
        let (noun, noun_span) = (object.noun.text.clone(), object.noun.span);
        is_whole.then_some(SceneObject { name: name?, noun, noun_span, shape, at, origin, span: object.name.span })
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
        let nouns = Kind::ALL.iter().flat_map(|kind| kind.vocabulary().nouns).map(|noun| noun.name);
        let known: Vec<&str> = nouns.chain([frames::NOUN]).collect();
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

    /// The name of an object, its indices joined: `d[3]` is `d3`, `e[5, 2]` is `e5_2`.
    pub fn object_name(&mut self, name: &tree::IndexedName, scope: &Scope) -> Option<String> {
        let joined = self.joined(&name.name.text, &name.indices, scope)?;
        if let Some(earlier) = self.taken(&joined, scope) {
            self.sink.push(errors::declared_twice(&joined, name.span, earlier));
            return None;
        }
        if let Some(reserved_as) = reserved_as(&joined) {
            self.sink.push(errors::reserved_name(&tree::Ident { text: joined, span: name.span }, reserved_as));
            return None;
        }
        Some(joined)
    }
}

/// Whether an entry places a camera image, which is read before all other entries.
fn is_image(object: &tree::Object) -> bool {
    object.noun.text == frames::NOUN && object.shape.is_some()
}

impl Collected {
    fn on(base: &CheckedScene) -> Collected {
        let objects = base.objects.iter().enumerate();
        let index = objects.map(|(index, object)| (object.name.clone(), (index, SceneLayer::Base))).collect();
        let frames = base.frames.iter().map(|(device, frame)| (*device, (frame.clone(), SceneLayer::Base))).collect();
        Collected { objects: base.objects.clone(), index, frames, is_whole: true }
    }
}

impl Default for Collected {
    fn default() -> Collected {
        Collected::on(&CheckedScene::default())
    }
}
