//! Replays the run of microrobots from the voltage of the bed alone: levels become arm positions, strokes paths, and
//! paths swept areas.
//!
//! Input: a run whose steps and channels are sound, and the poses of the robots. Output: their states and the
//! outcomes. `voltage` turns the actuations into legs, this file follows them and checks stops and dockings against
//! the steps, and `clearance` checks the distances of bodies and orbits. Promise: the record is read only for
//! comparison; the first leg whose arms or poses are not certain ends the replay of its device. Cost: for each leg the
//! levels times the table's rows, the pairs of robots, and the obstacles near each robot.

mod bodies;
mod claims;
mod clearance;
mod motion;
mod nearest;
pub mod recorded;
mod relay;
mod sweep;
mod voltage;

use super::clock::JudgedRun;
use super::record;
use super::rule::{Findings, Rule, Violation, ms};
use super::{InvalidClaims, Judge, JudgedState, LastStates, RecordTerms, Replay, ReplayStop, ReplayedState};
use crate::claims::microrobots::{Dock, MicrorobotsAction, MicrorobotsOrder, MicrorobotsStop};
use crate::claims::{Claims, Order};
use crate::device::microrobots::{
    Arm, CHANNEL, MicrorobotsObjective, MicrorobotsOutcome, MicrorobotsPlanner, Robot, Turning,
};
use crate::geometry::Pose;
use crate::quantity::digits;
use crate::real::Real;
use crate::schedule::microrobots::{MicrorobotsState, RecordedPose};
use crate::schedule::{ChannelUnit, State, TimedState};
use motion::{RobotPlace, TrainMotion, turn_between};
use std::collections::BTreeMap;
use sweep::ROUNDING_UM;
use voltage::VoltageLeg;

/// Tolerance of a recorded position: above the rounding on the longest path of one `apply`, 100 m.
const PLACE_TOLERANCE_UM: f64 = 1e-4;

/// Tolerance of a recorded heading.
const HEADING_TOLERANCE_RAD: f64 = 1e-6;

/// Rounding of a heading that does not count as a violation of a precision.
const ROUNDING_RAD: f64 = 1e-9;

/// Greatest number of robots named in a description of a state.
const SHOWN: usize = 4;

impl Judge for MicrorobotsOrder {
    fn unit(&self, channel: &str) -> Option<ChannelUnit> {
        (channel == CHANNEL).then_some(ChannelUnit::Volt)
    }

    fn swings(&self) -> bool {
        true
    }

    fn premise(&self) -> Result<(), InvalidClaims> {
        claims::check_claims(self)
    }

    fn has_facts_of(&self, other: &Order) -> bool {
        MicrorobotsOrder::of(other).is_some_and(|other| {
            std::sync::Arc::ptr_eq(&self.facts, &other.facts)
                || (self.facts == other.facts && self.states == other.states)
        })
    }

    fn has_parts_of(&self, other: &Order) -> bool {
        let rows = |order: &MicrorobotsOrder| order.robots.iter().map(|robot| robot.row).collect::<Vec<_>>();
        MicrorobotsOrder::of(other).is_some_and(|other| rows(self) == rows(other))
    }

    fn terms(&self) -> RecordTerms {
        RecordTerms {
            planner: MicrorobotsPlanner::OneWayDubins.name(),
            objective: self.objective.name(),
            outcome: self.objective.outcome().map(MicrorobotsOutcome::name),
            unit: self.objective.unit(),
            scale: 1.0,
        }
    }

    fn minimized_as(&self, outcome: &str) -> Option<&'static str> {
        MicrorobotsObjective::ALL
            .iter()
            .find(|one| one.outcome().map(MicrorobotsOutcome::name) == Some(outcome))
            .map(|one| one.name())
    }

    fn replay<'a>(
        &self,
        run: &JudgedRun<'a>,
        _claims: &Claims,
        last_states: &mut LastStates<'a>,
        findings: &mut Findings,
    ) -> Result<Replay<'a>, ReplayStop> {
        let legs = voltage::legs(run, self, findings)?;
        let mut bed = JudgedBed::new(run, self, last_states);
        bed.due_states = due_states(self, &legs);
        for (nth, step) in self.steps.iter().enumerate() {
            let ends_from = bed.trains.len();
            match &step.action {
                MicrorobotsAction::Wait(duration_ns) => bed.wait(run.step(nth).start_ns, *duration_ns)?,
                MicrorobotsAction::Apply { state, duration_ns } => {
                    bed.follow(nth, &legs[nth], &[], findings)?;
                    bed.applied(nth, &legs[nth], *state, *duration_ns, findings);
                }
                MicrorobotsAction::Drive { robot, stops } => {
                    bed.follow(nth, &legs[nth], &[], findings)?;
                    bed.stops(nth, ends_from, *robot, stops, findings);
                }
                MicrorobotsAction::Assemble(docks) => {
                    bed.follow(nth, &legs[nth], docks, findings)?;
                    bed.assembled(nth, docks, findings);
                }
            }
        }
        bed.record_rest(run.end_ns())?;
        let before = findings.len();
        clearance::check(&bed, findings)?;
        if findings.len() == before {
            nearest::note(&bed, findings);
        }
        last_states.insert(&run.job.device, bed.state(bed.rest));
        let outcomes = bed.outcomes();
        Ok(Replay { states: bed.states, outcomes, operations: BTreeMap::new() })
    }
}

impl JudgedState for MicrorobotsState {
    fn agrees(&self, replayed: &State) -> bool {
        let State::Microrobots(MicrorobotsState { control, arms, docked, poses }) = replayed else { return false };
        self.control == *control
            && self.arms == *arms
            && self.docked == *docked
            && self.poses.len() == poses.len()
            && self
                .poses
                .iter()
                .zip(poses)
                .all(|((name, pose), (true_name, true_pose))| name == true_name && near(pose, true_pose))
    }

    fn shown(&self) -> String {
        let MicrorobotsState { control, docked, poses, .. } = self;
        let pose = |(name, pose): (&String, &RecordedPose)| {
            let (x, y, heading) = (digits(pose.x_um), digits(pose.y_um), digits(pose.heading_deg));
            let stuck = if docked.contains(name) { ", docked" } else { "" };
            format!("`{name}` at ({x} um, {y} um, {heading} deg{stuck})")
        };
        let more = match poses.len().saturating_sub(SHOWN) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        let poses: Vec<String> = poses.iter().take(SHOWN).map(pose).collect();
        format!("control state {control} with {}{more}", poses.join(", "))
    }
}

/// Whether a recorded pose equals the replayed one, up to rounding.
fn near(recorded: &RecordedPose, replayed: &RecordedPose) -> bool {
    let off_um = (recorded.x_um - replayed.x_um).hypotenuse(recorded.y_um - replayed.y_um);
    let off_rad = turn_between(recorded.heading_rad(), replayed.heading_rad());
    off_um <= PLACE_TOLERANCE_UM && off_rad.abs() <= HEADING_TOLERANCE_RAD
}

/// The strokes of a leg, with the motion of every robot.
#[derive(Debug)]
struct JudgedTrain {
    nth: usize,
    leg: VoltageLeg,
    /// One for each robot of the order.
    motions: Vec<TrainMotion>,
    /// Number of waits before it. An arm that goes up during a wait begins a new turn.
    waits: usize,
    /// Strokes of the run before this train.
    strokes_before: u64,
}

/// A bed during the replay of a run.
struct JudgedBed<'r, 'a> {
    run: &'r JudgedRun<'a>,
    order: &'r MicrorobotsOrder,
    /// The control state with all arms up.
    rest: usize,
    /// One for each robot of the order, like `docked`.
    places: Vec<RobotPlace>,
    /// Number of trains of the run after which the robot docks, 0 if it is docked from the start; `None` if it is not
    /// docked.
    docked: Vec<Option<usize>>,
    trains: Vec<JudgedTrain>,
    waits: usize,
    strokes: u64,
    states: Vec<ReplayedState<'a>>,
    /// Number of states that the record must have.
    due_states: u64,
}

impl<'r, 'a> JudgedBed<'r, 'a> {
    /// The bed at the start of a run: robots are where the device's last run left them, or where the scene has them.
    fn new(run: &'r JudgedRun<'a>, order: &'r MicrorobotsOrder, last_states: &LastStates) -> Self {
        let left = match last_states.get(run.job.device.as_str()) {
            Some(State::Microrobots(MicrorobotsState { poses, docked, .. })) => Some((poses, docked)),
            Some(State::Dimibot(_) | State::ElectrodeArray(_) | State::Fingers(_)) | None => None,
        };
        let names = || (0..order.robots.len()).map(|robot| &order.robot(robot).name);
        let stands =
            |name: &String| left.and_then(|(poses, _)| poses.get(name)).map(|pose| RobotPlace::of(&pose.pose()));
        let sticks = |name: &String| left.is_some_and(|(_, docked)| docked.contains(name)).then_some(0);
        let places = names().zip(order.robots.iter());
        JudgedBed {
            run,
            order,
            rest: claims::rest(order).unwrap_or(0),
            places: places.map(|(name, placed)| stands(name).unwrap_or(RobotPlace::of(&placed.pose))).collect(),
            docked: names().map(sticks).collect(),
            trains: Vec::new(),
            waits: 0,
            strokes: 0,
            states: Vec::new(),
            due_states: 0,
        }
    }

    fn name(&self, robot: usize) -> &str {
        &self.order.robot(robot).name
    }

    /// The end of a step.
    fn end_ns(&self, nth: usize) -> u64 {
        self.run.step(nth).end_ns()
    }

    fn wait(&mut self, start_ns: u64, duration_ns: u64) -> Result<(), ReplayStop> {
        self.record_rest(start_ns)?;
        self.waits += usize::from(duration_ns > 0);
        Ok(())
    }

    /// Drives the strokes of some legs. After each leg, the robots of `docks` may dock.
    fn follow(
        &mut self,
        nth: usize,
        legs: &[VoltageLeg],
        docks: &[Dock],
        findings: &mut Findings,
    ) -> Result<(), ReplayStop> {
        for leg in legs {
            self.record(leg.start_ns, leg.control)?;
            findings.count_checks(Rule::Twist, self.docked.iter().flatten().count());
            self.twist(nth, leg).into_iter().for_each(|violation| findings.push(violation));
            let motions: Vec<TrainMotion> = (0..self.places.len()).map(|robot| self.train_motion(robot, leg)).collect();
            for (place, motion) in self.places.iter_mut().zip(&motions).filter(|(_, motion)| motion.path_um > 0.0) {
                *place = place.driven(motion.curve_um, motion.path_um);
            }
            let strokes_before = self.strokes;
            self.strokes = self.strokes.saturating_add(leg.strokes);
            self.trains.push(JudgedTrain { nth, leg: *leg, motions, waits: self.waits, strokes_before });
            self.dock(docks);
        }
        Ok(())
    }

    /// The violation of strokes that are driven while the arm of a docked robot is down: the arm's friction would turn
    /// the structure about it.
    fn twist(&self, nth: usize, leg: &VoltageLeg) -> Option<Violation> {
        let arm = |robot: usize| self.order.states[leg.control].arms[self.order.robots[robot].row];
        let robot = (0..self.places.len()).find(|robot| self.docked[*robot].is_some() && arm(*robot) == Arm::Down)?;
        let title = format!(
            "strokes at {} are driven while the arm of docked robot `{}` is down",
            ms(leg.train_ns),
            self.name(robot)
        );
        Some(self.run.violation(Rule::Twist, nth, leg.train_ns, title))
    }

    fn train_motion(&self, robot: usize, leg: &VoltageLeg) -> TrainMotion {
        let facts = self.order.robot(robot);
        let is_docked = self.docked[robot].is_some();
        TrainMotion {
            start: self.places[robot],
            curve_um: match self.order.states[leg.control].arms[self.order.robots[robot].row] {
                Arm::Up => None,
                Arm::Down => Some(curve_um(facts)),
            },
            path_um: if is_docked { 0.0 } else { leg.strokes as f64 * facts.step_um },
            half_um: [facts.length_um / 2.0, facts.width_um / 2.0],
        }
    }

    /// Whether a robot is at a pose within the precision of the task.
    fn is_at(&self, place: RobotPlace, pose: &Pose) -> bool {
        let [off_um, off_rad] = place.off(pose);
        let precision = self.order.precision;
        off_um <= precision.place_um + ROUNDING_UM && off_rad <= precision.heading_rad + ROUNDING_RAD
    }

    /// Docks the robots that are at their goals and touch a docked robot or one another.
    fn dock(&mut self, docks: &[Dock]) {
        let body = |robot: usize| {
            let facts = self.order.robot(robot);
            let half_um = [facts.length_um / 2.0, facts.width_um / 2.0];
            TrainMotion { start: self.places[robot], curve_um: None, path_um: 0.0, half_um }.body(0.0)
        };
        let arrives =
            |dock: &&Dock| self.docked[dock.robot].is_none() && self.is_at(self.places[dock.robot], &dock.goal.pose);
        let arrived: Vec<usize> = docks.iter().filter(arrives).map(|dock| dock.robot).collect();
        let holds = |robot: usize| self.docked[robot].is_some() || arrived.contains(&robot);
        let tolerance_um = self.order.facts.docking.tolerance_um + ROUNDING_UM;
        let touches = |robot: &usize| {
            let others = (0..self.places.len()).filter(|other| other != robot && holds(*other));
            others.into_iter().any(|other| body(*robot).gap_um(&body(other)) <= tolerance_um)
        };
        let docking: Vec<usize> = arrived.iter().copied().filter(touches).collect();
        docking.into_iter().for_each(|robot| self.docked[robot] = Some(self.trains.len()));
    }

    /// An `apply` is one leg in its control state, with as many strokes as its duration takes.
    fn applied(&self, nth: usize, legs: &[VoltageLeg], state: usize, duration_ns: u64, findings: &mut Findings) {
        findings.count_checks(Rule::Apply, 1);
        let step = self.run.step(nth);
        let strokes = duration_ns.div_ceil(self.order.facts.period_ns);
        let title = match legs {
            [leg] if leg.control != state => {
                format!("control state {} is applied, but the program applies {state}", leg.control)
            }
            [leg] if leg.strokes != strokes => {
                let (driven, due) = (leg.strokes, ms(duration_ns));
                format!("{driven} strokes are driven in `apply`; {strokes} are needed for {due}")
            }
            [_] => return,
            [] | [_, ..] => format!("`apply` has {} legs; it must have 1", legs.len()),
        };
        findings.push(self.run.violation(Rule::Apply, nth, step.start_ns, title));
    }

    /// A robot passes its stops in order, each at the end of a leg, and ends at the last one.
    fn stops(&self, nth: usize, from: usize, robot: usize, stops: &[MicrorobotsStop], findings: &mut Findings) {
        findings.count_checks(Rule::Goal, stops.len());
        let starts = self.trains[from..].iter().map(|train| train.motions[robot].start);
        let instants = starts.chain([self.places[robot]]);
        let Some((goal, mut left)) = stops.split_last() else { return };
        for place in instants {
            let reached = left.iter().take_while(|stop| self.is_at(place, &stop.pose)).count();
            left = &left[reached..];
        }
        let (name, end_ns) = (self.name(robot), self.end_ns(nth));
        let (missed, title) = match left.first() {
            Some(stop) => {
                (stop, format!("`{name}` does not reach a stop in its turn: {}", self.off(robot, &stop.pose)))
            }
            None if self.is_at(self.places[robot], &goal.pose) => return,
            None => (goal, format!("`{name}` misses its goal: {}", self.off(robot, &goal.pose))),
        };
        findings.push(self.run.violation(Rule::Goal, nth, end_ns, title).label(missed.span, "this stop"));
    }

    /// Distance of a robot from its goal, in words.
    fn off(&self, robot: usize, pose: &Pose) -> String {
        let [off_um, off_rad] = self.places[robot].off(pose);
        let precision = self.order.precision;
        format!(
            "it ends {} um and {} deg from there; at most {} um and {} deg are allowed",
            digits(off_um),
            digits(off_rad.to_degrees()),
            digits(precision.place_um),
            digits(precision.heading_rad.to_degrees())
        )
    }

    /// The robots of an assembly end docked, at their goals.
    fn assembled(&self, nth: usize, docks: &[Dock], findings: &mut Findings) {
        findings.count_checks(Rule::Dock, docks.len());
        for Dock { robot, goal } in docks {
            let (name, is_there) = (self.name(*robot), self.is_at(self.places[*robot], &goal.pose));
            let title = match (self.docked[*robot], is_there) {
                (Some(_), true) => continue,
                (Some(_) | None, false) => {
                    format!("`{name}` misses its docking goal: {}", self.off(*robot, &goal.pose))
                }
                (None, true) => {
                    let tolerance = digits(self.order.facts.docking.tolerance_um);
                    format!("`{name}` must dock, but is more than {tolerance} um from every docked robot")
                }
            };
            let violation = self.run.violation(Rule::Dock, nth, self.end_ns(nth), title);
            findings.push(violation.label(goal.span, "this goal"));
        }
    }

    fn state(&self, control: usize) -> State {
        let arms = self.order.states[control].arms.iter().map(|arm| arm.digit()).collect();
        let robots = 0..self.places.len();
        let mut docked: Vec<String> =
            robots.clone().filter(|r| self.docked[*r].is_some()).map(|r| self.name(r).to_owned()).collect();
        docked.sort_unstable();
        let poses = robots.map(|robot| (self.name(robot).to_owned(), self.places[robot].recorded())).collect();
        State::Microrobots(MicrorobotsState { control, arms, docked, poses })
    }

    /// Compares the state at an instant with the record's next one.
    fn record(&mut self, t_ns: u64, control: usize) -> Result<(), ReplayStop> {
        let replayed = TimedState { t_ns, state: self.state(control) };
        match self.run.plan.states.get(self.states.len()) {
            None => return Err(record::miscounted(self.run, self.due_states).into()),
            Some(recorded) if record::agrees(recorded, &replayed) => {
                self.states.push(ReplayedState::Recorded(recorded))
            }
            Some(_) => self.states.push(ReplayedState::Own(Box::new(replayed))),
        }
        match self.states.last() {
            Some(ReplayedState::Own(_)) => record::difference(self.run, &self.states).map_or(Ok(()), |v| Err(v.into())),
            Some(ReplayedState::Recorded(_)) | None => Ok(()),
        }
    }

    /// Records the state of a bed without voltage, with all arms up.
    fn record_rest(&mut self, t_ns: u64) -> Result<(), ReplayStop> {
        self.record(t_ns, self.rest)
    }

    fn outcomes(&self) -> BTreeMap<&'static str, f64> {
        BTreeMap::from([
            (MicrorobotsOutcome::Time.name(), self.run.plan.duration_ns as f64 / 1e9),
            (MicrorobotsOutcome::Switches.name(), self.trains.len() as f64),
            (MicrorobotsOutcome::Strokes.name(), self.strokes as f64),
        ])
    }
}

/// Number of states that the record must have: one for each leg, one for each wait, and one for the end.
fn due_states(order: &MicrorobotsOrder, legs: &[Vec<VoltageLeg>]) -> u64 {
    let waits = order.steps.iter().filter(|step| matches!(step.action, MicrorobotsAction::Wait(_))).count();
    (waits + 1 + legs.iter().map(Vec::len).sum::<usize>()) as u64
}

/// The turning radius of a robot, positive for a turn to the right.
fn curve_um(robot: &Robot) -> f64 {
    match robot.turning {
        Turning::Clockwise => robot.turning_radius_um,
        Turning::Counterclockwise => -robot.turning_radius_um,
    }
}

#[cfg(test)]
mod tests;
