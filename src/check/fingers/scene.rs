//! A scene as judged for one hand: its parts.

use super::part::{JudgedPart, PartReader};
use crate::check::Checker;
use crate::check::devices::CheckedDevice;
use crate::check::objects::of_other_kind;
use crate::check::scenes::{CheckedScene, SceneObject};
use crate::check::tasks::TaskSite;
use crate::device::fingers::{FingersFacts, HandNoun, VOCABULARY};
use crate::diagnostic::Sink;
use crate::source::Span;
use std::collections::BTreeMap;
use std::rc::Rc;

/// Greatest number of parts in one scene.
pub const MAX_PARTS: usize = 64;

/// Loop iterations charged for a part, for each hand whose scene has it.
const PART_TURNS: usize = 4_000;

/// A part of a scene.
#[derive(Debug, Clone)]
pub struct ScenePart {
    /// `None` if it has a fault, already reported.
    pub judged: Option<JudgedPart>,
}

/// A scene as a hand uses it.
#[derive(Debug, Clone, Default)]
pub struct HandScene {
    pub parts: BTreeMap<String, ScenePart>,
}

impl Checker<'_> {
    /// The scene of a task for its device, judged once.
    pub fn hand_scene(&mut self, site: &TaskSite, facts: &FingersFacts) -> Rc<HandScene> {
        self.scene_met(site, |checker, scene| {
            let Some(scene) = scene else { return HandScene::default() };
            // Each scene is judged, and charged, again for each hand.
            let is_solid = |one: &&Rc<SceneObject>| one.shape.as_ref().is_some_and(|s| s.value.form.is_spatial());
            let solids: Vec<Span> = scene.objects.iter().filter(is_solid).map(|object| object.span).collect();
            match solids.first() {
                Some(span) if !checker.charge_iterations(solids.len() * PART_TURNS, *span) => broken(scene),
                Some(_) | None => judged(scene, &site.device, facts, checker.sink),
            }
        })
    }
}

/// A scene with a fault that suppresses further findings.
fn broken(scene: &CheckedScene) -> HandScene {
    let broken = scene.objects.iter().map(|object| (object.name.clone(), ScenePart { judged: None }));
    HandScene { parts: broken.collect() }
}

fn judged(scene: &CheckedScene, device: &CheckedDevice, facts: &FingersFacts, sink: &mut Sink) -> HandScene {
    if let Some(crowd) = scene.crowd(&[(HandNoun::Part.name(), MAX_PARTS)]) {
        sink.push(crowd);
        return broken(scene);
    }
    let mut parts = BTreeMap::new();
    for object in &scene.objects {
        match HandNoun::find(&object.noun) {
            Some(HandNoun::Part) => {
                let judged = PartReader { object, device, facts, sink }.part();
                parts.insert(object.name.clone(), ScenePart { judged });
            }
            None => sink.push(of_other_kind(object, &VOCABULARY)),
        }
    }
    HandScene { parts }
}
