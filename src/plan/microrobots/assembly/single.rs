//! Docking of one robot with the structure, while the remaining ones orbit.

use super::bed::{AssemblyState, StageAddition, joined, legs_of_one};
use super::closing::{detours, stretches};
use super::ground::AssemblyGround;
use super::track::{ArmTrack, TrackAim, whole};
use super::{PlannedFineMotion, STRAIGHT_PART, StuckAssembly};
use crate::claims::microrobots::{Dock, Precision};
use crate::device::microrobots::Arm;
use crate::geometry::Pose;
use crate::plan::microrobots::AssemblyStage;
use crate::plan::microrobots::fine::Cycles;
use crate::plan::microrobots::free::{ArmSegment, distance_um, length_um};
use crate::plan::microrobots::paths::PathRequest;
use crate::plan::microrobots::world::Fixtures;
use crate::plan::search::Meter;
use std::f64::consts::TAU;

/// Arms in the two control states.
const ARMS: [Arm; 2] = [Arm::Down, Arm::Up];

/// Numbers of straight segments tried at the start and on the goal's axis.
const FIRST_RUNS: usize = 24;
const LAST_RUNS: usize = 40;

/// Plans the stretch that docks one robot, given the control states in which it turns and runs straight, with the first
/// of these fine motions that has room.
pub fn plan(
    bed: &AssemblyState,
    dock: &Dock,
    states: [usize; 2],
    fine: &[PlannedFineMotion],
    ground: &AssemblyGround,
    meter: &mut Meter,
) -> Result<StageAddition, StuckAssembly> {
    let fixtures = ground.fixtures(bed, &[dock.robot])?;
    let mut stuck = None;
    for fine in fine {
        match SingleDocking::new(bed, dock, states, *fine).stretch(ground, &fixtures, meter) {
            Ok(stretch) => return Ok(stretch),
            Err(StuckAssembly::GaveUp) => return Err(StuckAssembly::GaveUp),
            Err(other) => stuck = stuck.or(Some(other)),
        }
    }
    Err(stuck.unwrap_or(StuckAssembly::GaveUp))
}

/// Docking of one robot with the structure.
struct SingleDocking<'a> {
    bed: &'a AssemblyState<'a>,
    index: usize,
    states: [usize; 2],
    goal: Pose,
    /// Poses at which its fine motion begins: as planned, and as the controller makes it.
    approach: Pose,
    gross_end: Pose,
    aim: TrackAim,
    cycles: Cycles<2>,
    /// A first stroke, if needed so that consecutive legs differ in their states.
    before: ArmTrack,
}

impl<'a> SingleDocking<'a> {
    fn new(bed: &'a AssemblyState<'a>, dock: &Dock, states: [usize; 2], fine: PlannedFineMotion) -> Self {
        let (index, goal) = (dock.robot, dock.goal.pose);
        let robot = bed.robot(index);
        let whole = Cycles::symmetric(&bed.order.facts.fine, &[robot.step_um]);
        let cycles = match fine {
            PlannedFineMotion::OneIn(share) => Cycles { count: whole.count.div_ceil(share), ..whole },
            PlannedFineMotion::LeftOut => Cycles { strokes: [0, whole.total().div_ceil(STRAIGHT_PART)], count: 1 },
        };
        let approach = cycles.backward(robot, ARMS, goal);
        let gross_end = match fine {
            PlannedFineMotion::OneIn(_) => approach,
            PlannedFineMotion::LeftOut => whole.backward(robot, ARMS, goal),
        };
        let motion = cycles.forward(robot, ARMS, Pose::at(0.0, 0.0));
        // A robot that ends within a wide precision, but outside the docking tolerances, sticks in no trial.
        let (docking, wide) = (bed.order.facts.docking, bed.order.precision);
        let precision = Precision {
            place_um: wide.place_um.min(docking.tolerance_um),
            heading_rad: wide.heading_rad.min(docking.sticking_rad),
        };
        let aim = TrackAim { goal, precision, motion };
        let mut before = ArmTrack::default();
        let others = [Arm::Up, Arm::Down].into_iter().zip(states);
        others.filter(|(_, state)| bed.last_state() == Some(*state)).for_each(|(other, _)| before.push(other, 1));
        SingleDocking { bed, index, states, goal, approach, gross_end, aim, cycles, before }
    }

    fn stretch(
        &self,
        ground: &AssemblyGround,
        fixtures: &Fixtures,
        meter: &mut Meter,
    ) -> Result<StageAddition, StuckAssembly> {
        let robot = self.bed.robot(self.index);
        let from = self.before.end(robot, self.bed.poses[self.index]);
        let request = PathRequest { world: &ground.world, robot: self.index, from, to: self.approach, fixtures };
        let most_um = distance_um(robot, from, self.approach) + TAU * robot.turning_radius_um;
        let clear = |way: &Vec<ArmSegment>| ground.world.obstruction_on(self.index, from, way, fixtures).is_none();
        let detours = detours(robot, from, self.approach, &stretches(robot, FIRST_RUNS), &stretches(robot, LAST_RUNS));
        let (near, far): (Vec<_>, Vec<_>) = detours.into_iter().partition(|way| length_um(way) <= most_um);
        let near = request.direct().map(|found| found.segments).into_iter().chain(near.into_iter().filter(clear));
        let mut stuck = None;
        if let Some(stretch) = self.first_free(near, ground, meter, &mut stuck)? {
            return Ok(stretch);
        }
        let found = ground.path(self.bed, &[self.index], &request, meter);
        if found == Err(StuckAssembly::GaveUp) {
            return Err(StuckAssembly::GaveUp);
        }
        let far = found.iter().cloned().chain(far.into_iter().filter(clear));
        match self.first_free(far, ground, meter, &mut stuck)? {
            Some(stretch) => Ok(stretch),
            None => Err(stuck.or(found.err()).unwrap_or(StuckAssembly::GaveUp)),
        }
    }

    /// Stretch with the first of these paths that the collision rules allow; if none, the last one's collision is
    /// recorded.
    fn first_free(
        &self,
        ways: impl Iterator<Item = Vec<ArmSegment>>,
        ground: &AssemblyGround,
        meter: &mut Meter,
        stuck: &mut Option<StuckAssembly>,
    ) -> Result<Option<StageAddition>, StuckAssembly> {
        for way in ways {
            meter.step().ok_or(StuckAssembly::GaveUp)?;
            match self.along(&way, ground) {
                Ok(stretch) => return Ok(Some(stretch)),
                Err(other) => *stuck = Some(other),
            }
        }
        Ok(None)
    }

    /// The stretch with this path to the approach.
    fn along(&self, way: &[ArmSegment], ground: &AssemblyGround) -> Result<StageAddition, StuckAssembly> {
        let robot = self.bed.robot(self.index);
        let from = self.before.end(robot, self.bed.poses[self.index]);
        let total = (length_um(way) / robot.step_um).round() as u64;
        let driven = whole(robot, from, way, &self.aim, total).ok_or(StuckAssembly::Coarse { robot: self.index })?;
        let mut track = self.before.clone();
        track.extend(&driven);
        let legs = legs_of_one(&track, self.states).into_iter().chain(self.cycles.legs(self.states));
        let SingleDocking { index: robot, states, gross_end: approach, goal, .. } = *self;
        let stage = AssemblyStage::Single { robot, states, approach, goal };
        let stretch = StageAddition { legs: joined(legs), docking: vec![robot], stages: vec![stage] };
        let stretch = ground.cut_at_docking(self.bed, stretch)?;
        match ground.first_collision(self.bed, &stretch) {
            None => Ok(stretch),
            Some(hit) => Err(StuckAssembly::Blocked { robot, partner: None, hit }),
        }
    }
}
