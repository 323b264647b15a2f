//! Frames: the places of devices in a scene, and the robots of a program that must keep apart.
//!
//! `frame left at pose(…)` in a scene puts the frame of the device `left` there; a frame with a shape is that of an image
//! ([`super::camera`]). Promise: a device has one place in all scenes of a
//! program, so that the relative place of any two with a place in the same scene is known.

use super::devices::KindFacts;
use super::scenes::CheckedScene;
use super::scope::{DeclarationPlace, DeclarationSort, Scope};
use super::{Checker, errors};
use crate::claims::dimibot::{DimibotObstacle, DimibotObstacleBody, in_scene_um};
use crate::claims::{Job, Order, SharedScene, Timeline};
use crate::device::{Kind, dimibot};
use crate::geometry::shape::{Pose, Shape};
use crate::source::Span;
use crate::syntax::tree::{self, Ident, IndexedName, Path};
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;
use std::sync::Arc;

/// The noun of a scene that places a device. It is the language's own and no kind's.
pub const NOUN: &str = "frame";

/// Where a device stands in a scene.
#[derive(Debug, Clone)]
pub struct DeviceFrame {
    pub device: DeclarationPlace,
    pub pose: Pose,
    /// The name of the device where it is placed.
    pub span: Span,
}

/// One run of a task in a program: its device and scene, and where it is written.
#[derive(Debug, Clone, Copy)]
pub struct RunSite {
    pub device: DeclarationPlace,
    pub scene: Option<DeclarationPlace>,
    pub span: Span,
}

/// Neighbourhood of a program's robots.
#[derive(Default)]
pub struct Neighbours {
    pub shared: Vec<SharedScene>,
    pub not_held: Vec<[String; 2]>,
}

impl Checker<'_> {
    /// The frame of a device in a scene; `None` after an error.
    pub fn frame(&mut self, object: &tree::Object, scope: &Scope) -> Option<DeviceFrame> {
        let name = &object.name;
        let text = self.joined(&name.name.text, &name.indices, scope)?;
        let segment = IndexedName { name: Ident { text, span: name.span }, indices: Vec::new(), span: name.span };
        let path = Path { segments: vec![segment], span: name.span };
        let device = self.resolve(&path, scope, DeclarationSort::Device)?;
        let kind = self.device(device)?.kind;
        if kind != Kind::Dimibot {
            self.sink.push(errors::frame_of_other_kind(name.span, self.named(device).0, kind.name()));
            return None;
        }
        let pose = self.pose_of_frame(object, scope)?;
        Some(DeviceFrame { device, pose, span: name.span })
    }

    fn pose_of_frame(&mut self, object: &tree::Object, scope: &Scope) -> Option<Pose> {
        let Some(at) = &object.at else { return Some(Pose::at(0.0, 0.0)) };
        let value = self.evaluate(at, scope);
        let value = self.in_scene(value, at.span, scope);
        self.frame_pose(&value, at.span)
    }

    /// The other placed robots of a scene, with their facts; those with errors in them are left out.
    pub fn placed_beside(
        &mut self,
        scene: &CheckedScene,
        device: DeclarationPlace,
    ) -> Vec<(Rc<dimibot::DimibotFacts>, Pose)> {
        let others = scene.frames.values().filter(|frame| frame.device != device);
        let facts = others.map(|frame| (self.facts(frame.device), frame.pose));
        facts.filter_map(|(facts, pose)| Some((dimibot_facts(facts?)?, pose))).collect()
    }

    /// Neighbourhood of the robots of a program; those that never run remain at home, in the way of the others.
    pub fn neighbours(&mut self, timeline: &Timeline, sites: &[RunSite], jobs: &mut [Job]) -> Neighbours {
        let scenes: BTreeMap<DeclarationPlace, Rc<CheckedScene>> = {
            let places: BTreeSet<DeclarationPlace> = sites.iter().filter_map(|site| site.scene).collect();
            places.into_iter().filter_map(|place| Some((place, self.scene(place)?))).collect()
        };
        let running: BTreeSet<DeclarationPlace> = sites.iter().map(|site| site.device).collect();
        self.one_place_each(&scenes, &running);
        let shared = self.shared(&scenes, &running);
        self.put_idle_robots(&scenes, &running, sites, jobs);
        let not_held = self.not_held(timeline, sites, &shared);
        Neighbours { shared, not_held }
    }

    /// A device stands at one place in all scenes of a program.
    fn one_place_each(
        &mut self,
        scenes: &BTreeMap<DeclarationPlace, Rc<CheckedScene>>,
        running: &BTreeSet<DeclarationPlace>,
    ) {
        let mut placed: BTreeMap<DeclarationPlace, &DeviceFrame> = BTreeMap::new();
        for frame in scenes.values().flat_map(|scene| scene.frames.values()) {
            let first = *placed.entry(frame.device).or_insert(frame);
            if first.pose != frame.pose && running.contains(&frame.device) {
                let name = self.named(frame.device).0;
                self.sink.push(errors::device_at_two_places(name, frame.span, first.span));
            }
        }
    }

    fn shared(
        &self,
        scenes: &BTreeMap<DeclarationPlace, Rc<CheckedScene>>,
        running: &BTreeSet<DeclarationPlace>,
    ) -> Vec<SharedScene> {
        let frames = |scene: &CheckedScene| {
            let placed = scene.frames.values().filter(|frame| running.contains(&frame.device));
            placed.map(|frame| (self.named(frame.device).0.to_owned(), frame.pose)).collect::<BTreeMap<_, _>>()
        };
        let all = scenes.iter().map(|(place, scene)| (self.named(*place).0.to_owned(), frames(scene)));
        let several = all.filter(|(_, frames)| frames.len() > 1);
        several.map(|(scene, frames)| SharedScene { scene, frames }).collect()
    }

    fn put_idle_robots(
        &mut self,
        scenes: &BTreeMap<DeclarationPlace, Rc<CheckedScene>>,
        running: &BTreeSet<DeclarationPlace>,
        sites: &[RunSite],
        jobs: &mut [Job],
    ) {
        let mut known: BTreeMap<(DeclarationPlace, DeclarationPlace), Arc<Vec<DimibotObstacle>>> = BTreeMap::new();
        for (site, job) in sites.iter().zip(jobs) {
            let (Some(place), Order::Dimibot(order)) = (site.scene, &mut job.order) else { continue };
            let Some(scene) = scenes.get(&place).filter(|scene| scene.frames.contains_key(&site.device)) else {
                continue;
            };
            let obstacles = known.entry((place, site.device)).or_insert_with(|| {
                let idle = scene.frames.values().filter(|frame| !running.contains(&frame.device));
                let idle: Vec<DimibotObstacle> = idle.filter_map(|frame| self.idle_robot(frame)).collect();
                match idle.is_empty() {
                    true => Arc::clone(&order.obstacles),
                    false => Arc::new(order.obstacles.iter().cloned().chain(idle).collect()),
                }
            });
            order.obstacles = Arc::clone(obstacles);
        }
    }

    /// The tip of a robot that stands at home.
    fn idle_robot(&mut self, frame: &DeviceFrame) -> Option<DimibotObstacle> {
        let facts = dimibot_facts(self.facts(frame.device)?)?;
        let [x_um, y_um] = in_scene_um(facts.place_um(facts.home), Some(&frame.pose));
        let shape = Shape::Disc { radius_um: facts.growth_um() };
        let body = DimibotObstacleBody::Solid { shape, pose: Pose::at(x_um, y_um) };
        Some(DimibotObstacle { name: self.named(frame.device).0.to_owned(), body, span: frame.span })
    }

    /// Devices that run together in one scene without a place for each, which is warned of.
    fn not_held(&mut self, timeline: &Timeline, sites: &[RunSite], shared: &[SharedScene]) -> Vec<[String; 2]> {
        let mut pairs: BTreeMap<[DeclarationPlace; 2], [Span; 2]> = BTreeMap::new();
        concurrent(timeline, sites, &mut |one, other| {
            let (one, other) = (sites[one], sites[other]);
            if one.scene.is_some() && one.scene == other.scene {
                let pair = [one.device.min(other.device), one.device.max(other.device)];
                pairs.entry(pair).or_insert([one.span, other.span]);
            }
        });
        let mut not_held = Vec::new();
        for (pair, spans) in pairs {
            let names = pair.map(|device| self.named(device).0);
            if shared.iter().any(|scene| names.iter().all(|name| scene.frames.contains_key(*name))) {
                continue;
            }
            self.sink.push(errors::not_held(names, spans));
            not_held.push(names.map(str::to_owned));
        }
        not_held
    }
}

fn dimibot_facts(facts: KindFacts) -> Option<Rc<dimibot::DimibotFacts>> {
    match facts {
        KindFacts::Dimibot(facts) => Some(facts),
        KindFacts::ElectrodeArray(_) | KindFacts::Microrobots(_) | KindFacts::Fingers(_) => None,
    }
}

/// A run of each device in each scene.
type Firsts = BTreeMap<(DeclarationPlace, Option<DeclarationPlace>), usize>;

/// Calls `each` with runs in two branches of one `together`: one for each device and scene. Returns those of the whole part.
fn concurrent(timeline: &Timeline, sites: &[RunSite], each: &mut impl FnMut(usize, usize)) -> Firsts {
    match timeline {
        Timeline::Run(job) => Firsts::from([((sites[*job].device, sites[*job].scene), *job)]),
        Timeline::Wait(_) => Firsts::new(),
        Timeline::Sequence(parts) => {
            let all = parts.iter().rev().map(|part| concurrent(part, sites, each));
            all.flatten().collect()
        }
        Timeline::Together(parts) => {
            let mut before = Firsts::new();
            for part in parts {
                let jobs = concurrent(part, sites, each);
                for one in before.values() {
                    jobs.values().for_each(|other| each(*one, *other));
                }
                before.extend(jobs);
            }
            before
        }
    }
}
