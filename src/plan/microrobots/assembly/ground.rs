//! Collision rules, applied to a bed during an assembly.

use super::bed::{AssemblyState, StageAddition};
use super::{RobotBlocker, StuckAssembly, recognition};
use crate::claims::microrobots::Dock;
use crate::geometry::Pose;
use crate::plan::microrobots::free::ArmSegment;
use crate::plan::microrobots::paths::{PathFailure, PathRequest};
use crate::plan::microrobots::world::{CollisionWorld, FirstCollision, Fixtures, Obstruction};
use crate::plan::microrobots::{Leg, RobotDocking};
use crate::plan::search::Meter;
use std::f64::consts::TAU;

/// State budget of one path search.
const MAX_STATES: u64 = 2_000;

/// The bed's world, and the poses at the start of the assembly.
pub struct AssemblyGround<'a> {
    pub world: CollisionWorld,
    docks: &'a [Dock],
    start: Vec<Pose>,
    docked: Vec<bool>,
}

impl<'a> AssemblyGround<'a> {
    pub fn new(bed: &AssemblyState, docks: &'a [Dock]) -> Self {
        AssemblyGround {
            world: CollisionWorld::new(bed.order),
            docks,
            start: bed.poses.clone(),
            docked: bed.docked.clone(),
        }
    }

    /// Cuts a stretch where its robots dock.
    pub fn cut_at_docking(&self, bed: &AssemblyState, stretch: StageAddition) -> Result<StageAddition, StuckAssembly> {
        recognition::cut_at_docking(bed, self.docks, stretch)
    }

    /// Everything at rest while some robots are steered: docked bodies, and the orbit discs of all others, which must
    /// have room.
    pub fn fixtures(&self, bed: &AssemblyState, steered: &[usize]) -> Result<Fixtures, StuckAssembly> {
        let rests = (0..bed.poses.len()).filter(|robot| bed.docked[*robot]);
        let bodies = rests.map(|robot| self.world.rectangle(robot, bed.poses[robot])).collect();
        let mut fixtures = Fixtures { discs: Vec::new(), bodies };
        for robot in bed.others(steered) {
            let disc = self.world.disc(robot, bed.poses[robot]);
            if let Some(obstruction) = self.world.obstruction_of_orbit(&disc, &fixtures) {
                let blocker = blocker(bed, steered, obstruction);
                return Err(StuckAssembly::NoOrbit { robot, blocker });
            }
            fixtures.discs.push(disc);
        }
        Ok(fixtures)
    }

    /// A path of a robot around everything at rest while some robots are steered.
    pub fn path(
        &self,
        bed: &AssemblyState,
        steered: &[usize],
        request: &PathRequest,
        meter: &mut Meter,
    ) -> Result<Vec<ArmSegment>, StuckAssembly> {
        match meter.share(MAX_STATES, |meter| request.find(meter)) {
            Ok(found) => Ok(found.segments),
            Err(PathFailure::GaveUp(_)) if meter.left().steps == 0 => Err(StuckAssembly::GaveUp),
            Err(
                PathFailure::Start(by) | PathFailure::Goal(by) | PathFailure::Blocked(by) | PathFailure::GaveUp(by),
            ) => Err(StuckAssembly::NoPath { robot: request.robot, blocker: blocker(bed, steered, by) }),
        }
    }

    /// First collision of one more stretch, followed by one more full orbit of the robots that still wait, since they
    /// will make it. So their discs are kept clear in every stretch, and each stretch can be checked separately. The
    /// leg is counted from the assembly's first.
    pub fn first_collision(&self, bed: &AssemblyState, stretch: &StageAddition) -> Option<FirstCollision> {
        let mut legs = stretch.legs.clone();
        let leg = legs.len() - 1;
        let docks: Vec<RobotDocking> = stretch.docking.iter().map(|&robot| RobotDocking { robot, leg }).collect();
        let circles = bed.others(&stretch.docking).map(|robot| {
            let facts = bed.robot(robot);
            (TAU * facts.turning_radius_um / facts.step_um).ceil() as u64
        });
        if let Some(strokes) = circles.max() {
            legs.push(Leg { strokes: strokes.saturating_add(1), ..legs[leg] });
        }
        let hit = self.world.first_collision(&bed.poses, &bed.docked, &legs, &docks);
        hit.map(|hit| FirstCollision { leg: hit.leg + bed.legs.len(), ..hit })
    }

    /// The first collision of a whole assembly.
    pub fn any_collision(&self, bed: &AssemblyState) -> Option<FirstCollision> {
        self.world.first_collision(&self.start, &self.docked, &bed.legs, &bed.docks)
    }
}

/// The obstruction, by its index in the order.
fn blocker(bed: &AssemblyState, steered: &[usize], obstruction: Obstruction) -> RobotBlocker {
    let waiting = |index| bed.others(steered).nth(index).unwrap_or(usize::MAX);
    let docked = |index| (0..bed.poses.len()).filter(|robot| bed.docked[*robot]).nth(index).unwrap_or(usize::MAX);
    match obstruction {
        Obstruction::Obstacle(index) => RobotBlocker::Obstacle(index),
        Obstruction::Disc(index) => RobotBlocker::Orbit(waiting(index)),
        Obstruction::Body(index) => RobotBlocker::Docked(docked(index)),
    }
}
