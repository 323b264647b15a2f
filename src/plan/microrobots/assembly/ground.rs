//! The rules of collision, asked for a bed in the course of an assembly.

use super::bed::{Bed, Stretch};
use crate::geometry::Pose;
use crate::plan::microrobots::world::{Hit, World};
use crate::plan::microrobots::{Docking, Leg};
use std::f64::consts::TAU;

/// The bed's world, and where everything stood when the assembly began.
pub struct Ground {
    pub world: World,
    start: Vec<Pose>,
    docked: Vec<bool>,
}

impl Ground {
    pub fn new(bed: &Bed) -> Self {
        Ground { world: World::new(bed.order), start: bed.poses.clone(), docked: bed.docked.clone() }
    }

    /// What a bed's legs and one more stretch bring too near to one another, with the robots that wait orbiting once more
    /// afterwards: they will.
    pub fn first_hit(&self, bed: &Bed, stretch: &Stretch) -> Option<Hit> {
        let mut legs: Vec<Leg> = bed.legs.iter().chain(&stretch.legs).copied().collect();
        let leg = legs.len() - 1;
        let docking = stretch.docking.iter().map(|&robot| Docking { robot, leg });
        let docks: Vec<Docking> = bed.docks.iter().copied().chain(docking).collect();
        let circles = bed.others(&stretch.docking).map(|robot| {
            let facts = bed.robot(robot);
            (TAU * facts.turning_radius_um / facts.step_um).ceil() as u64
        });
        if let Some(strokes) = circles.max() {
            legs.push(Leg { strokes: strokes.saturating_add(1), ..legs[leg] });
        }
        self.world.first_hit(&self.start, &self.docked, &legs, &docks)
    }
}
