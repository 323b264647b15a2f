//! Robots that share a scene: those beside one another, and those that never run.

use crate::check::frames::DeviceFrame;
use crate::check::neighbours::PlacedDevices;
use crate::check::scenes::CheckedScene;
use crate::check::scope::DeclarationPlace;
use crate::check::{Checker, KindFacts};
use crate::claims::dimibot::{DimibotObstacle, DimibotObstacleBody, in_scene_um};
use crate::claims::{Job, Order};
use crate::device::Kind;
use crate::device::dimibot::DimibotFacts;
use crate::geometry::shape::{Pose, Shape};
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

impl Checker<'_> {
    /// The other placed robots of a scene, with their facts; those with errors in them are left out.
    pub fn placed_beside(&mut self, scene: &CheckedScene, device: DeclarationPlace) -> Vec<(Rc<DimibotFacts>, Pose)> {
        let others = scene.frames.values().filter(|frame| frame.device != device);
        let facts = others.map(|frame| (self.facts::<Kind>(frame.device), frame.pose));
        facts.filter_map(|(facts, pose)| Some((robot_facts(facts?)?, pose))).collect()
    }

    /// Adds the robots that never run to the scenes of the others, as obstacles at their homes.
    pub fn put_idle_robots(&mut self, placed: &PlacedDevices, jobs: &mut [Job]) {
        let mut known: BTreeMap<(DeclarationPlace, DeclarationPlace), Arc<Vec<DimibotObstacle>>> = BTreeMap::new();
        for (site, job) in placed.sites.iter().zip(jobs) {
            let (Some(place), Order::Dimibot(order)) = (site.scene, &mut job.order) else { continue };
            let Some(scene) = placed.scenes.get(&place).filter(|scene| scene.frames.contains_key(&site.device)) else {
                continue;
            };
            let obstacles = known.entry((place, site.device)).or_insert_with(|| {
                let idle = scene.frames.values().filter(|frame| !placed.running.contains(&frame.device));
                let idle: Vec<DimibotObstacle> = idle.filter_map(|frame| self.idle_robot(frame)).collect();
                match idle.is_empty() {
                    true => Arc::clone(&order.obstacles),
                    false => Arc::new(order.obstacles.iter().cloned().chain(idle).collect()),
                }
            });
            order.obstacles = Arc::clone(obstacles);
        }
    }

    /// The tip of a robot that stands at home, as an obstacle.
    fn idle_robot(&mut self, frame: &DeviceFrame) -> Option<DimibotObstacle> {
        let facts = robot_facts(self.facts::<Kind>(frame.device)?)?;
        let [x_um, y_um] = in_scene_um(facts.place_um(facts.home), Some(&frame.pose));
        let shape = Shape::Disc { radius_um: facts.growth_um() };
        let body = DimibotObstacleBody::Solid { shape, pose: Pose::at(x_um, y_um) };
        Some(DimibotObstacle { name: self.named(frame.device).0.to_owned(), body, span: frame.span })
    }
}

fn robot_facts(facts: KindFacts) -> Option<Rc<DimibotFacts>> {
    if let KindFacts::Dimibot(facts) = facts { Some(facts) } else { None }
}
