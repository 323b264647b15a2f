//! Choice of the control state for each stroke train of one robot.

use super::{DriveRequest, StuckReason};
use crate::device::microrobots::Arm;
use crate::plan::microrobots::Leg;
use crate::plan::microrobots::strokes::StrokeTrain;
use crate::plan::microrobots::world::FirstCollision;
use crate::plan::search::Meter;

/// Most choices examined for one path.
const MAX_CHOICES: u32 = 2_000;

/// A depth-first search over the control states of consecutive trains.
pub(super) struct TrainChoice<'a> {
    request: &'a DriveRequest<'a>,
    trains: &'a [StrokeTrain],
    /// Number of legs that existed before.
    before: usize,
    legs: Vec<Leg>,
    /// Candidate states with the robot's arm down, and with it up; those first in which the fewest other robots run.
    down: Vec<usize>,
    up: Vec<usize>,
    left: u32,
    /// The latest collision found.
    latest: Option<FirstCollision>,
}

impl<'a> TrainChoice<'a> {
    /// Control states for trains that follow legs.
    pub(super) fn new(request: &'a DriveRequest<'a>, legs: &[Leg], trains: &'a [StrokeTrain]) -> Self {
        let world = request.world;
        let with = |arm: Arm| {
            let mut states: Vec<usize> =
                request.states().filter(|state| world.arm(*state, request.robot) == arm).collect();
            states.sort_by_key(|state| (running(request, *state), request.order.states[*state].levels_v.len()));
            states
        };
        TrainChoice {
            request,
            trains,
            before: legs.len(),
            legs: legs.to_vec(),
            down: with(Arm::Down),
            up: with(Arm::Up),
            left: MAX_CHOICES,
            latest: None,
        }
    }

    /// Returns the legs followed by those of the trains, or the collision that happens latest.
    ///
    /// Iterative depth-first search: `tried` holds, for each leg, the index of its next state.
    pub(super) fn run(mut self, meter: &mut Meter) -> Result<Vec<Leg>, StuckReason> {
        let mut tried: Vec<usize> = vec![0];
        while let Some(next) = tried.last_mut() {
            let index = self.legs.len() - self.before;
            let Some(train) = self.trains.get(index) else { return Ok(self.legs) };
            let states = match train.arm {
                Arm::Down => &self.down,
                Arm::Up => &self.up,
            };
            let state = states.get(*next).copied();
            *next += 1;
            let within = self.left > 0 && meter.step().is_some();
            self.left = self.left.saturating_sub(1);
            match state.filter(|_| within) {
                None => {
                    tried.pop();
                    if self.legs.len() > self.before {
                        self.legs.pop();
                    }
                }
                Some(state) => {
                    self.legs.push(Leg { state, strokes: train.strokes });
                    if self.is_free() {
                        tried.push(0);
                    } else {
                        self.legs.pop();
                    }
                }
            }
        }
        let begun = meter.left().steps > 0;
        Err(self.latest.map_or(if begun { StuckReason::TooFine } else { StuckReason::OutOfBudget }, StuckReason::Meets))
    }

    fn is_free(&mut self) -> bool {
        let hit = self.request.bed.first_collision(self.request.world, &self.legs, &[]);
        let later =
            |hit: &FirstCollision| self.latest.is_none_or(|other| (other.leg, other.strokes) < (hit.leg, hit.strokes));
        if let Some(hit) = hit.filter(later) {
            self.latest = Some(hit);
        }
        hit.is_none()
    }
}

/// Number of other robots that run straight in a state.
fn running(request: &DriveRequest, state: usize) -> usize {
    let others = (0..request.world.count()).filter(|other| *other != request.robot && !request.bed.docked[*other]);
    others.filter(|other| request.world.arm(state, *other) == Arm::Up).count()
}
