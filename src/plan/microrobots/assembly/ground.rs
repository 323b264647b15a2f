//! Collision rules, applied to a bed during an assembly.

use super::bed::{AssemblyState, StageAddition};
use super::{RobotBlocker, StuckAssembly, recognition};
use crate::claims::microrobots::Dock;
use crate::geometry::Pose;
use crate::plan::microrobots::free::ArmSegment;
use crate::plan::microrobots::ways::{DriveTask, NoWay};
use crate::plan::microrobots::world::{FirstMeeting, Fixtures, Obstruction, World};
use crate::plan::microrobots::{Leg, RobotDocking};
use crate::plan::search::Meter;
use std::f64::consts::TAU;

/// State budget of one path search.
const MAX_STATES: u64 = 2_000;

/// The bed's world, and the poses at the start of the assembly.
pub struct AssemblyGround<'a> {
    pub world: World,
    docks: &'a [Dock],
    start: Vec<Pose>,
    docked: Vec<bool>,
}

impl<'a> AssemblyGround<'a> {
    pub fn new(bed: &AssemblyState, docks: &'a [Dock]) -> Self {
        AssemblyGround { world: World::new(bed.order), docks, start: bed.poses.clone(), docked: bed.docked.clone() }
    }

    /// Cuts a stretch where its robots dock.
    pub fn settled(&self, bed: &AssemblyState, stretch: StageAddition) -> Result<StageAddition, StuckAssembly> {
        recognition::settled(bed, self.docks, stretch)
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
    pub fn way(
        &self,
        bed: &AssemblyState,
        steered: &[usize],
        task: &DriveTask,
        meter: &mut Meter,
    ) -> Result<Vec<ArmSegment>, StuckAssembly> {
        match meter.share(MAX_STATES, |meter| task.find(meter)) {
            Ok(found) => Ok(found.way),
            Err(NoWay::GaveUp(_)) if meter.left().steps == 0 => Err(StuckAssembly::GaveUp),
            Err(NoWay::Start(by) | NoWay::Goal(by) | NoWay::Blocked(by) | NoWay::GaveUp(by)) => {
                Err(StuckAssembly::NoWay { robot: task.robot, blocker: blocker(bed, steered, by) })
            }
        }
    }

    /// First collision of one more stretch, followed by one more full orbit of the robots that still wait, since they
    /// will make it. So their discs are kept clear in every stretch, and each stretch can be checked separately. The
    /// leg is counted from the assembly's first.
    pub fn first_hit(&self, bed: &AssemblyState, stretch: &StageAddition) -> Option<FirstMeeting> {
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
        let hit = self.world.first_hit(&bed.poses, &bed.docked, &legs, &docks);
        hit.map(|hit| FirstMeeting { leg: hit.leg + bed.legs.len(), ..hit })
    }

    /// The first collision of a whole assembly.
    pub fn any_hit(&self, bed: &AssemblyState) -> Option<FirstMeeting> {
        self.world.first_hit(&self.start, &self.docked, &bed.legs, &bed.docks)
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
