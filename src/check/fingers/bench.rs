//! A scene as one hand meets it: its parts.

use super::part::{JudgedPart, PartReader};
use crate::check::devices::CheckedDevice;
use crate::check::scenes::CheckedScene;
use crate::check::tasks::TaskSite;
use crate::check::{Checker, errors};
use crate::device::fingers::{FingersFacts, VOCABULARY};
use crate::diagnostic::Sink;
use crate::source::Span;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

/// Greatest number of parts in one scene.
pub const MAX_PARTS: usize = 64;

/// Iterations of a loop charged for a part, for each hand that meets it.
const PART_TURNS: usize = 4_000;

/// A part of a scene.
#[derive(Debug, Clone)]
pub struct Lying {
    /// `None` if it has a fault, already reported.
    pub judged: Option<(Arc<crate::claims::fingers::HandPart>, f64)>,
    pub span: Span,
}

/// A scene as a hand uses it.
#[derive(Debug, Clone, Default)]
pub struct HandScene {
    pub parts: Rc<BTreeMap<String, Lying>>,
}

impl Checker<'_> {
    /// The scene of a task for its device, judged once.
    pub fn bench(&mut self, site: &TaskSite, facts: &FingersFacts) -> HandScene {
        let Some((place, scene)) = &site.scene else { return HandScene::default() };
        let key = (*place, site.place);
        if let Some(known) = self.benches.get(&key) {
            return known.clone();
        }
        // Each scene is worked out again for each hand.
        let solids = scene.objects.iter().filter(|one| one.shape.as_ref().is_some_and(|s| s.value.form.is_of_space()));
        let solids: Vec<Span> = solids.map(|object| object.span).collect();
        let is_too_much = solids.first().is_some_and(|span| !self.counts_as_outline(solids.len() * PART_TURNS, *span));
        let bench = match is_too_much {
            true => broken(scene),
            false => judged(scene, &site.device, facts, self.sink),
        };
        self.benches.insert(key, bench.clone());
        bench
    }
}

/// A scene with a fault that suppresses further findings.
fn broken(scene: &CheckedScene) -> HandScene {
    let broken = scene.objects.iter().map(|object| (object.name.clone(), Lying { judged: None, span: object.span }));
    HandScene { parts: Rc::new(broken.collect()) }
}

fn judged(scene: &CheckedScene, device: &CheckedDevice, facts: &FingersFacts, sink: &mut Sink) -> HandScene {
    if let Some(crowd) = scene.crowd(&[("part", MAX_PARTS)]) {
        sink.push(crowd);
        return broken(scene);
    }
    let mut parts = BTreeMap::new();
    for object in &scene.objects {
        if object.noun != "part" {
            let known: Vec<&str> = VOCABULARY.nouns.iter().map(|noun| noun.name).collect();
            sink.push(errors::noun_of_other_kind(object.noun_span, &object.noun, VOCABULARY.name, &known));
            continue;
        }
        let judged = PartReader { object, device, facts, sink }.part();
        let judged = judged.map(|JudgedPart { part, weight_un }| (Arc::new(part), weight_un));
        parts.insert(object.name.clone(), Lying { judged, span: object.span });
    }
    HandScene { parts: Rc::new(parts) }
}
