//! Neighbours: the robots of a program that must keep apart.
//!
//! Promise: a device has one place in all scenes of a program, so that the relative place of any two with a place in
//! the same scene is known.

use super::frames::DeviceFrame;
use super::scenes::CheckedScene;
use super::scope::DeclarationPlace;
use super::{Checker, checks, errors};
use crate::claims::{Job, SharedScene, Timeline};
use crate::device::Kind;
use crate::source::Span;
use std::collections::{BTreeMap, BTreeSet};
use std::rc::Rc;

/// One run of a task in a program: its device and scene, and where it is written.
#[derive(Debug, Clone, Copy)]
pub struct RunSite {
    pub device: DeclarationPlace,
    pub scene: Option<DeclarationPlace>,
    pub span: Span,
}

/// The devices of a program that scenes place.
pub struct PlacedDevices<'a> {
    pub scenes: &'a BTreeMap<DeclarationPlace, Rc<CheckedScene>>,
    /// The devices that some task of the program runs on.
    pub running: &'a BTreeSet<DeclarationPlace>,
    /// One for each job of the program.
    pub sites: &'a [RunSite],
}

/// Neighbourhood of a program's robots.
#[derive(Default)]
pub struct Neighbours {
    pub shared: Vec<SharedScene>,
    pub not_held: Vec<[String; 2]>,
}

impl Checker<'_> {
    /// Neighbourhood of the robots of a program; those that never run remain at home, in the way of the others.
    pub fn neighbours(&mut self, timeline: &Timeline, sites: &[RunSite], jobs: &mut [Job]) -> Neighbours {
        let scenes: BTreeMap<DeclarationPlace, Rc<CheckedScene>> = {
            let places: BTreeSet<DeclarationPlace> = sites.iter().filter_map(|site| site.scene).collect();
            places.into_iter().filter_map(|place| Some((place, self.scene(place)?))).collect()
        };
        let running: BTreeSet<DeclarationPlace> = sites.iter().map(|site| site.device).collect();
        self.one_place_each(&scenes, &running);
        let shared = self.shared(&scenes, &running);
        let placed = PlacedDevices { scenes: &scenes, running: &running, sites };
        Kind::ALL.iter().for_each(|kind| checks(*kind).add_idle_obstacles(self, &placed, jobs));
        let not_held = self.not_held(timeline, sites, &shared);
        Neighbours { shared, not_held }
    }

    /// Reports running devices whose poses differ between scenes of a program.
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

    /// Pairs of devices that run together in one scene without a frame for each; warns of every pair.
    fn not_held(&mut self, timeline: &Timeline, sites: &[RunSite], shared: &[SharedScene]) -> Vec<[String; 2]> {
        let mut pairs: BTreeMap<[DeclarationPlace; 2], [Span; 2]> = BTreeMap::new();
        concurrent(timeline, sites, &mut |one, other| {
            let (one, other) = (sites[one], sites[other]);
            if one.scene.is_some() && one.scene == other.scene && one.device != other.device {
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

/// One run of each device in each scene, as an index of the sites.
type Firsts = BTreeMap<(DeclarationPlace, Option<DeclarationPlace>), usize>;

/// Calls `each` with pairs of runs in different branches of one `together`, one run for each device and scene. Returns
/// such runs of the whole part.
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
