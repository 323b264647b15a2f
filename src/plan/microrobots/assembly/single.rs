//! One robot to the structure, while those that are still to come orbit.

use super::bed::{Bed, Stretch, joined, legs_of_one};
use super::ground::Ground;
use super::Stuck;
use super::track::{Aim, Track, whole};
use crate::check::claims::microrobots::Dock;
use crate::device::microrobots::Arm;
use crate::geometry::Pose;
use crate::plan::microrobots::fine::Cycles;
use crate::plan::microrobots::free::{length_um, shortest};
use crate::plan::microrobots::Stage;
use crate::plan::search::Meter;

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
    meter.step().ok_or(Stuck::GaveUp)?;
    let way = shortest(robot, from, approach);
    let total = (length_um(&way) / robot.step_um).round() as u64;
    track.extend(&whole(robot, from, &way, &aim, total).ok_or(Stuck::Coarse { robot: index })?);
    let legs = joined(legs_of_one(&track, states).into_iter().chain(cycles.legs(states)));
    let stage = Stage::Single { robot: index, states, approach, goal };
    let stretch = Stretch { legs, docking: vec![index], stage };
    match ground.first_hit(bed, &stretch) {
        None => Ok(stretch),
        Some(hit) => Err(Stuck::Blocked { robot: index, partner: None, hit }),
    }
}
