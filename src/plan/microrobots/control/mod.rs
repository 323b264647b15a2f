//! Controller: from measured poses to the next segment of the drive.
//!
//! Input: an order, its motion and, at each measurement, the measured poses of all robots. Output: a [`Command`], which
//! states what to drive until the next measurement. It runs the strategy of
//! [`strategy`](crate::plan::microrobots::strategy) as a state machine with one state for each stage of the plan:
//! initial and other legs as written, drives, pairs and single robots, each in gross motion, fine motion, contact and
//! its judgement. It knows measurements only: a robot counts as docked once it was pushed against its structure and is
//! measured in its place.
//!
//! A measurement that cannot be true is not acted upon: the bed holds still for an interval, and the next one decides.
//! After too many of these, or if no measurement comes for the time that the device states, the controller stops: at 0
//! V all arms go up and nothing moves. It also stops if a robot is measured too many times in a row where its commands
//! cannot have brought it, because the robot does not move or the picture does not change. No command is given that
//! brings a robot into an obstacle or into another robot that it is not to meet, as far as their poses are known: a
//! correction that the plan does not have may need more room.
//!
//! Everything is allocated before the first measurement. Without errors (all bounds 0) the legs of the plan are carried
//! out as written.

mod ahead;
mod belief;
mod follow;
mod stages;

pub use crate::device::microrobots::control::{ControlPhase, StopReason};
pub use ahead::InTheWay;

use crate::claims::microrobots::MicrorobotsOrder;
use crate::geometry::Pose;
use crate::plan::microrobots::MicrorobotsMotion;
pub use belief::MAX_ASTRAY;
use belief::{Belief, Sighting};
use stages::{Progress, StepStage};

/// Most consecutive measurements that may be unusable.
pub const MAX_UNUSABLE: u32 = 5;

/// Strokes in a control state.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StrokeSegment {
    /// Index into the order's states.
    pub state: usize,
    /// At least 1.
    pub strokes: u64,
    /// Whether the control cycle of the state comes first; otherwise the arms are in that state already.
    pub sets_arms: bool,
}

/// Action until the next measurement.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command<'c> {
    /// These segments one after the other, then the relax level, which moves nothing and keeps the arms, until the next
    /// command. The next measurement is due at `until_ns`.
    Drive { segments: &'c [StrokeSegment], until_ns: u64 },
    /// 0 V: all arms up, nothing moves.
    Rest { until_ns: u64 },
    /// The last command is not over yet; nothing changes.
    Continue { until_ns: u64 },
    /// 0 V: the task is done.
    Finished,
    /// 0 V: the task was given up.
    Stop(Stop),
}

/// Reason why a task was given up, and where.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Stop {
    pub reason: StopReason,
    /// Index into the order's robots, if one is to blame.
    pub robot: Option<usize>,
    /// Thing that this robot would have run into.
    pub in_the_way: Option<InTheWay>,
    /// Index into the order's steps.
    pub step: usize,
    pub phase: ControlPhase,
}

/// Closed-loop control of one task.
#[derive(Debug, Clone)]
pub struct Controller<'a> {
    belief: Belief<'a>,
    stages: Vec<StepStage<'a>>,
    /// Index of the current stage.
    at: usize,
    command: CommandSegments,
    /// Instant at which the last command ends.
    until_ns: u64,
    last_ns: Option<u64>,
    unusable: u32,
    /// Robots that the last command drives against others.
    may_touch: [Option<usize>; 2],
    last: LastCommand,
}

/// The kind of the last command.
#[derive(Debug, Clone, Copy, PartialEq)]
enum LastCommand {
    Drive,
    Rest,
    Continue,
    Finished,
    Stop(Stop),
}

/// Source of commands in answer to measurements: a [`Controller`], here or in another process.
pub trait Pilot {
    /// See [`Controller::observe`].
    fn observe(&mut self, measured: &[Option<Pose>], now_ns: u64) -> Command<'_>;

    /// Index of the order's step in progress.
    fn step(&self) -> usize;

    /// Phase in progress.
    fn phase(&self) -> ControlPhase;
}

impl Pilot for Controller<'_> {
    fn observe(&mut self, measured: &[Option<Pose>], now_ns: u64) -> Command<'_> {
        Controller::observe(self, measured, now_ns)
    }

    fn step(&self) -> usize {
        Controller::step(self)
    }

    fn phase(&self) -> ControlPhase {
        Controller::phase(self)
    }
}

/// Segments of a command under construction.
#[derive(Debug, Clone)]
pub struct CommandSegments {
    segments: Vec<StrokeSegment>,
    /// Control state that the arms are in; `None` while they are up without voltage, or unknown.
    held: Option<usize>,
}

impl CommandSegments {
    /// Adds this many strokes in a state.
    pub fn add(&mut self, state: usize, strokes: u64) {
        if strokes == 0 {
            return;
        }
        match self.segments.last_mut() {
            Some(last) if last.state == state => last.strokes += strokes,
            Some(_) | None => {
                self.segments.push(StrokeSegment { state, strokes, sets_arms: self.held != Some(state) });
                self.held = Some(state);
            }
        }
    }
}

impl<'a> Controller<'a> {
    /// `None` if the device does not state its errors: how far to trust a measurement is then unknown.
    pub fn new(order: &'a MicrorobotsOrder, motion: &'a MicrorobotsMotion) -> Option<Self> {
        let errors = order.facts.errors?;
        let belief = Belief::new(order, errors, &motion.start.poses, &motion.start.docked);
        let stages = stages::stages(order, motion);
        let capacity = stages.iter().map(|stage| stage.stage.most_segments(order)).max().unwrap_or(0);
        let command = CommandSegments { segments: Vec::with_capacity(capacity), held: None };
        Some(Controller {
            belief,
            stages,
            at: 0,
            command,
            until_ns: 0,
            last_ns: None,
            unusable: 0,
            may_touch: [None; 2],
            last: LastCommand::Rest,
        })
    }

    /// Distance from the goals of its drives, in micrometres and radians, that counts as arrived in excess of the
    /// task's precision and one error of measurement; `None` if there is no excess.
    pub fn beyond_precision(&self) -> Option<[f64; 2]> {
        let accepted = stages::drives_end_within(&self.stages)?;
        let (precision, errors) = (self.belief.order.precision, self.belief.errors);
        let place_um = accepted.radius_um - precision.place_um - errors.place_um;
        let heading_rad = accepted.heading_rad - precision.heading_rad - errors.heading_rad;
        (place_um > 0.0 || heading_rad > 0.0).then(|| [place_um.max(0.0), heading_rad.max(0.0)])
    }

    /// Returns the next command after a measurement: one pose for each robot of the order, in its order, `None` for
    /// those that were not seen. `now_ns` is the time of the measurement on any clock that never goes back.
    pub fn observe(&mut self, measured: &[Option<Pose>], now_ns: u64) -> Command<'_> {
        self.take(measured, now_ns);
        self.last()
    }

    /// Returns the last command again; before the first measurement the bed rests.
    pub fn last(&self) -> Command<'_> {
        let until_ns = self.until_ns;
        match self.last {
            LastCommand::Drive => Command::Drive { segments: &self.command.segments, until_ns },
            LastCommand::Rest => Command::Rest { until_ns },
            LastCommand::Continue => Command::Continue { until_ns },
            LastCommand::Finished => Command::Finished,
            LastCommand::Stop(stop) => Command::Stop(stop),
        }
    }

    fn take(&mut self, measured: &[Option<Pose>], now_ns: u64) {
        if matches!(self.last, LastCommand::Finished | LastCommand::Stop(_)) {
            return;
        }
        if let Some(last_ns) = self.last_ns {
            if now_ns < last_ns {
                return self.stop(StopReason::Clock, None);
            }
            let latest_ns = self.until_ns.max(last_ns).saturating_add(self.belief.order.facts.watchdog_ns());
            if now_ns > latest_ns {
                return self.stop(StopReason::Silence, None);
            }
            if now_ns < self.until_ns {
                (self.last, self.last_ns) = (LastCommand::Continue, Some(now_ns));
                return;
            }
        }
        self.last_ns = Some(now_ns);
        let sighting = self.belief.see(measured, &self.command.segments, self.may_touch);
        self.command.segments.clear();
        let (reason, robot) = match sighting {
            Sighting::Usable => {
                self.unusable = 0;
                return self.decide(now_ns);
            }
            Sighting::Unseen(robot) => (StopReason::Unseen, robot),
            Sighting::Doubtful(robot) => (StopReason::Doubtful, robot),
            Sighting::Astray(robot) => return self.stop(StopReason::Astray, Some(robot)),
            Sighting::Moved(robot) => return self.stop(StopReason::Moved, Some(robot)),
        };
        self.unusable += 1;
        if self.unusable > MAX_UNUSABLE {
            return self.stop(reason, Some(robot));
        }
        (self.last, self.until_ns) = (LastCommand::Drive, now_ns.saturating_add(self.belief.errors.replan_ns));
    }

    fn decide(&mut self, now_ns: u64) {
        // At most one new path is searched for if a command leads into something: an answer must not be late.
        let mut has_searched = false;
        while let Some(stage) = self.stages.get_mut(self.at) {
            let held = self.command.held;
            match stage.stage.proceed(&mut self.belief, &mut self.command, now_ns) {
                Progress::Driving => {
                    self.may_touch = stage.stage.may_touch();
                    if let Some(ahead) = self.belief.collision_ahead(&self.command.segments, self.may_touch) {
                        self.command.segments.clear();
                        self.command.held = held;
                        if !std::mem::replace(&mut has_searched, true) && stage.stage.find_new_path(&self.belief) {
                            continue;
                        }
                        return self.stop_before(StopReason::Blocked, Some(ahead.robot), Some(ahead.with));
                    }
                    (self.last, self.until_ns) = (LastCommand::Drive, now_ns.saturating_add(self.duration_ns()));
                    return;
                }
                Progress::Resting(until_ns) => {
                    (self.command.held, self.last, self.until_ns) = (None, LastCommand::Rest, until_ns);
                    return;
                }
                Progress::Done => self.at += 1,
                Progress::Failed(reason, robot) => return self.stop(reason, Some(robot)),
            }
        }
        self.last = LastCommand::Finished;
    }

    /// Gives the task up, unless it is already over.
    pub fn stop(&mut self, reason: StopReason, robot: Option<usize>) {
        self.stop_before(reason, robot, None);
    }

    fn stop_before(&mut self, reason: StopReason, robot: Option<usize>, in_the_way: Option<InTheWay>) {
        if !matches!(self.last, LastCommand::Finished | LastCommand::Stop(_)) {
            self.last = LastCommand::Stop(Stop { reason, robot, in_the_way, step: self.step(), phase: self.phase() });
        }
    }

    /// Duration of the segments, at least the interval between measurements.
    fn duration_ns(&self) -> u64 {
        let order = self.belief.order;
        let of = |segment: &StrokeSegment| {
            let levels = if segment.sets_arms { order.states[segment.state].levels_v.len() as u64 } else { 0 };
            levels * order.facts.dwell_ns + segment.strokes.saturating_mul(order.facts.period_ns)
        };
        let whole_ns = self.command.segments.iter().map(of).fold(0, u64::saturating_add);
        whole_ns.max(self.belief.errors.replan_ns)
    }

    /// Index of the order's step in progress.
    pub fn step(&self) -> usize {
        let stage = self.stages.get(self.at).or(self.stages.last());
        stage.map_or(0, |stage| stage.step)
    }

    /// Phase in progress.
    pub fn phase(&self) -> ControlPhase {
        self.stages.get(self.at).map_or(ControlPhase::Over, |stage| stage.stage.phase())
    }

    /// Robots that are driven on purpose at the moment, at most two.
    pub fn driven(&self) -> [Option<usize>; 2] {
        self.stages.get(self.at).map_or([None; 2], |stage| stage.stage.driven())
    }

    /// Whether a robot counts as docked.
    pub fn is_docked(&self, robot: usize) -> bool {
        self.belief.docked.get(robot).copied().unwrap_or(false)
    }
}

#[cfg(test)]
mod tests;
