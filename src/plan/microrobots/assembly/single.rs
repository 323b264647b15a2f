//! One robot to the structure, while those that are still to come orbit.

use super::Stuck;
use super::bed::{Bed, Stretch, joined, legs_of_one};
use super::closing::{detours, stretches};
use super::ground::Ground;
use super::track::{Aim, Track, whole};
use crate::check::claims::microrobots::Dock;
use crate::device::microrobots::Arm;
use crate::geometry::Pose;
use crate::plan::microrobots::Stage;
use crate::plan::microrobots::fine::Cycles;
use crate::plan::microrobots::free::length_um;
use crate::plan::search::Meter;

/// Straight stretches at the start and on the goal's axis that are tried.
const FIRST_RUNS: usize = 24;
const LAST_RUNS: usize = 40;

/// The stretch that docks one robot, with the states in which it turns and runs straight.
pub fn plan(
    bed: &Bed,
    (dock, states): (&Dock, [usize; 2]),
    ground: &Ground,
    meter: &mut Meter,
) -> Result<Stretch, Stuck> {
    let (index, goal) = (dock.robot, dock.goal.pose);
    let robot = bed.robot(index);
    let cycles = Cycles::symmetric(&bed.order.facts.fine, &[robot.step_um]);
    let arms = [Arm::Down, Arm::Up];
    let approach = cycles.backward(robot, arms, goal);
    let motion = cycles.forward(robot, arms, Pose::at(0.0, 0.0));
    let aim = Aim { goal, precision: bed.order.precision, motion };
    let mut track = Track::default();
    let [turned, ran] = states.map(|state| bed.last_state() == Some(state));
    if turned {
        track.push(Arm::Up, 1);
    }
    if ran {
        track.push(Arm::Down, 1);
    }
    let from = track.end(robot, bed.poses[index]);
    let fixtures = ground.fixtures(bed, &[index])?;
    let mut stuck = None;
    for way in detours(robot, from, approach, &stretches(robot, FIRST_RUNS), &stretches(robot, LAST_RUNS)) {
        meter.step().ok_or(Stuck::GaveUp)?;
        if let Some((_, obstruction)) = ground.world.obstruction_on(index, from, &way, &fixtures) {
            stuck = stuck.or_else(|| Some(ground.no_way(bed, index, &[index], obstruction)));
            continue;
        }
        let total = (length_um(&way) / robot.step_um).round() as u64;
        let Some(driven) = whole(robot, from, &way, &aim, total) else {
            stuck = Some(Stuck::Coarse { robot: index });
            continue;
        };
        let mut track = track.clone();
        track.extend(&driven);
        let legs = joined(legs_of_one(&track, states).into_iter().chain(cycles.legs(states)));
        let stage = Stage::Single { robot: index, states, approach, goal };
        let stretch = Stretch { legs, docking: vec![index], stage };
        match ground.first_hit(bed, &stretch) {
            None => return Ok(stretch),
            Some(hit) => stuck = Some(Stuck::Blocked { robot: index, partner: None, hit }),
        }
    }
    Err(stuck.unwrap_or(Stuck::GaveUp))
}
