//! One job of microrobots: its steps planned one after the other, from the current poses.
//!
//! After each step every robot is where the strokes have carried it, so a step without a plan leaves the later ones without a
//! start: the job ends there.

use super::assembly::{self, Assembled};
use super::bound;
use super::drive::{self, Drive};
use super::guarantee::{Assured, guarantees};
use super::strategy::{driven, episodes};
use super::why::BedReasons;
use super::world::{BedPoses, World};
use super::{AssemblyStage, Leg, MicrorobotsMotion, MicrorobotsStepMotion, RobotDocking};
use crate::claims::Job;
use crate::claims::microrobots::{
    Assurance, Dock, MicrorobotsAction, MicrorobotsOrder, MicrorobotsStep, MicrorobotsStop,
};
use crate::device::microrobots::{Arm, MicrorobotsObjective, MicrorobotsOutcome, MicrorobotsPlanner};
use crate::diagnostic::{Remark, Sink};
use crate::geometry::Pose;
use crate::plan::requirements::{Kept, KnownLimit, require};
use crate::plan::search::SearchBudget;
use crate::plan::{KindPlanner, Optimality, Plan};
use std::collections::BTreeMap;

/// Poses of the robots of a bed, one entry per robot of its orders.
#[derive(Debug, Clone, PartialEq)]
pub struct Crew {
    pub poses: Vec<Pose>,
    /// Whether it is docked, and so no longer moves.
    pub docked: Vec<bool>,
}

impl Crew {
    /// Moves all robots through a leg, given with its index within the step; some may dock at its end.
    pub fn follow(&mut self, order: &MicrorobotsOrder, (index, leg): (usize, &Leg), docks: &[RobotDocking]) {
        for robot in (0..self.poses.len()).filter(|robot| !self.docked[*robot]) {
            self.poses[robot] = leg.carried(order, robot, self.poses[robot]);
        }
        docks.iter().filter(|dock| dock.leg == index).for_each(|dock| self.docked[dock.robot] = true);
    }
}

/// State that the plans of a schedule hand on to later jobs.
#[derive(Default)]
pub struct BedStandings {
    /// By device; `None` after a missing plan, since the poses of its robots are then unknown.
    crews: BTreeMap<String, Option<Crew>>,
}

impl BedStandings {
    /// State of the robots of an order before its job, if known.
    fn of(&self, job: &Job, order: &MicrorobotsOrder) -> Option<Crew> {
        let scene = || Crew {
            poses: order.robots.iter().map(|robot| robot.pose).collect(),
            docked: vec![false; order.robots.len()],
        };
        self.crews.get(&job.device).cloned().unwrap_or_else(|| Some(scene()))
    }
}

impl KindPlanner for MicrorobotsOrder {}

/// A plan for a job; without one an error was pushed, for this job or an earlier one of the same bed.
pub fn plan(
    job: &Job,
    order: &MicrorobotsOrder,
    standing: &mut BedStandings,
    sink: &mut Sink,
) -> Option<Plan<MicrorobotsMotion>> {
    let is_first = !standing.crews.contains_key(&job.device);
    let planned = standing.of(job, order).and_then(|crew| planned(job, order, (crew, is_first), sink));
    let (plan, crew) = planned.map_or((None, None), |(plan, crew)| (plan, Some(crew)));
    standing.crews.insert(job.device.clone(), crew);
    plan
}

/// A plan, and the state of the robots after it. They start in the scene's poses if it is the device's first job.
fn planned(
    job: &Job,
    order: &MicrorobotsOrder,
    (start, is_first): (Crew, bool),
    sink: &mut Sink,
) -> Option<(Option<Plan<MicrorobotsMotion>>, Crew)> {
    let world = World::new(order);
    let mut bed = BedPoses::new(start.poses.clone(), start.docked.clone());
    let mut tally = BedTally { bound_ns: bound::least_ns(order, &start), ..BedTally::default() };
    let mut steps = Vec::with_capacity(order.steps.len());
    let mut is_given = is_first;
    for step in &order.steps {
        let done = BedStepPlanner { order, world: &world, bed: &bed, step, is_given }.done(sink)?;
        is_given &= matches!(step.action, MicrorobotsAction::Wait(_) | MicrorobotsAction::Apply { .. });
        match &done.motion {
            MicrorobotsStepMotion::Legs { legs, docks, .. } => bed.follow(&world, legs, docks),
            MicrorobotsStepMotion::Wait(_) => bed.rest(),
        }
        tally.add(order, &done);
        steps.push(done.motion);
    }
    let motion = MicrorobotsMotion { start, steps };
    let are_guaranteed = assure(order, &motion, &mut tally.remarks, sink);
    let plan = tally.plan(motion);
    let crew = Crew { poses: bed.poses, docked: bed.docked };
    let kept = require(job, &plan, &mut |_| KnownLimit::default(), sink);
    Some(((kept == Kept::Yes && are_guaranteed).then_some(plan), crew))
}

/// Remarks for each stage of an assembly whether it is guaranteed; `false` if the task demands a guarantee that does not exist.
///
/// Without errors the plan is executed as written, and the verifier has checked the result. With errors nothing is guaranteed; the
/// first containment that the estimates reject is named.
fn assure(order: &MicrorobotsOrder, motion: &MicrorobotsMotion, remarks: &mut Vec<Remark>, sink: &mut Sink) -> bool {
    let is_exact = order.facts.errors.is_some_and(|errors| errors.are_zero());
    let estimates = if is_exact { Vec::new() } else { guarantees(order, motion).unwrap_or_default() };
    let mut all_hold = true;
    for (nth, episode) in episodes(order, motion).iter().enumerate() {
        let names = driven(episode.stage).into_iter().map(|(robot, _)| order.robot(robot).name.as_str());
        let subject = names.collect::<Vec<_>>().join(" and ");
        let why = match (order.facts.errors, estimates.get(nth).and_then(Assured::violated)) {
            (Some(_), None) if is_exact => {
                let text = "guaranteed: without errors the plan is carried out as it is written".to_owned();
                remarks.push(Remark { subject, text });
                continue;
            }
            (Some(_), Some(violated)) => violated.said(order),
            (Some(_), None) => "no sound bound is known for robots with errors".to_owned(),
            (None, _) => "the device does not say how far robots and measurements may be off".to_owned(),
        };
        if order.assurance == Assurance::Demanded {
            all_hold = false;
            let step = &order.steps[episode.step];
            let says = BedReasons { order, step, docked: &motion.start.docked, is_given: false };
            sink.push(says.not_guaranteed(&subject, &why));
        }
        if order.facts.errors.is_some() {
            remarks.push(Remark { subject, text: format!("not guaranteed: {why}") });
        }
    }
    all_hold
}

/// A step with its plan.
struct PlannedStep {
    motion: MicrorobotsStepMotion,
    remarks: Vec<Remark>,
}

/// Planner of one step, from the current state of the bed.
struct BedStepPlanner<'a> {
    order: &'a MicrorobotsOrder,
    world: &'a World,
    bed: &'a BedPoses,
    step: &'a MicrorobotsStep,
    /// Whether every plan leads to this state of the bed: nothing driven so far left a choice.
    is_given: bool,
}

impl<'a> BedStepPlanner<'a> {
    fn done(&self, sink: &mut Sink) -> Option<PlannedStep> {
        match &self.step.action {
            MicrorobotsAction::Wait(duration_ns) => {
                Some(PlannedStep { motion: MicrorobotsStepMotion::Wait(*duration_ns), remarks: Vec::new() })
            }
            MicrorobotsAction::Apply { state, duration_ns } => self.applied(*state, *duration_ns, sink),
            MicrorobotsAction::Drive { robot, stops } => self.driven(*robot, stops, sink),
            MicrorobotsAction::Assemble(docks) => self.assembled(docks, sink),
        }
    }

    fn why(&self) -> BedReasons<'a> {
        BedReasons { order: self.order, step: self.step, docked: &self.bed.docked, is_given: self.is_given }
    }

    fn applied(&self, state: usize, duration_ns: u64, sink: &mut Sink) -> Option<PlannedStep> {
        let leg = Leg { state, strokes: duration_ns.div_ceil(self.order.facts.period_ns) };
        let lowers = |robot: &usize| self.bed.docked[*robot] && self.world.arm(state, *robot) == Arm::Down;
        if let Some(robot) = (0..self.world.count()).find(lowers) {
            sink.push(self.why().lowers_docked(state, robot));
            return None;
        }
        if let Some(hit) = self.bed.first_hit(self.world, &[leg], &[]) {
            sink.push(self.why().applied_into(&hit));
            return None;
        }
        Some(PlannedStep { motion: plain(vec![leg]), remarks: Vec::new() })
    }

    fn driven(&self, robot: usize, stops: &[MicrorobotsStop], sink: &mut Sink) -> Option<PlannedStep> {
        let poses: Vec<Pose> = stops.iter().map(|stop| stop.pose).collect();
        let request = Drive { order: self.order, world: self.world, bed: self.bed, robot, stops: &poses };
        match drive::drive(&request, SearchBudget::of(self.order.expansions)) {
            Ok(driven) => Some(PlannedStep { motion: plain(driven.legs), remarks: Vec::new() }),
            Err(stuck) => {
                sink.push(self.why().not_driven(robot, &stuck, stops));
                None
            }
        }
    }

    fn assembled(&self, docks: &[Dock], sink: &mut Sink) -> Option<PlannedStep> {
        let (poses, docked) = (&self.bed.poses, &self.bed.docked);
        let budget = SearchBudget::of(self.order.expansions);
        let goal = |robot: usize| docks.iter().find(|dock| dock.robot == robot).map(|dock| dock.goal.span);
        let span = |robot: usize| goal(robot).unwrap_or(self.step.span);
        let assembled = match assembly::assemble(self.order, poses, docked, docks, budget) {
            Ok(assembled) => assembled,
            Err(stuck) => {
                sink.push(self.why().not_assembled(&stuck, &span));
                return None;
            }
        };
        let Assembled { legs, docks, stages, .. } = assembled;
        // The assembly was planned from rest, but a robot may have been turning since the previous step.
        if let Some(hit) = self.bed.first_hit(self.world, &legs, &docks) {
            sink.push(self.why().still_turning(&hit));
            return None;
        }
        Some(PlannedStep { motion: MicrorobotsStepMotion::Legs { legs, docks, stages }, remarks: Vec::new() })
    }
}

fn plain(legs: Vec<Leg>) -> MicrorobotsStepMotion {
    MicrorobotsStepMotion::Legs { legs, docks: Vec::new(), stages: Vec::<AssemblyStage>::new() }
}

/// Duration of a leg: its control cycle, then its strokes.
pub fn leg_ns(order: &MicrorobotsOrder, leg: Leg) -> u64 {
    let cycle_ns = order.states[leg.state].levels_v.len() as u64 * order.facts.dwell_ns;
    cycle_ns.saturating_add(leg.strokes.saturating_mul(order.facts.period_ns))
}

/// Sums over the steps of a job.
#[derive(Default)]
struct BedTally {
    time_ns: u64,
    /// Lower bound on the duration of the job.
    bound_ns: u64,
    switches: u64,
    strokes: u64,
    remarks: Vec<Remark>,
}

impl BedTally {
    fn add(&mut self, order: &MicrorobotsOrder, done: &PlannedStep) {
        self.remarks.extend(done.remarks.iter().cloned());
        match &done.motion {
            MicrorobotsStepMotion::Wait(duration_ns) => self.time_ns = self.time_ns.saturating_add(*duration_ns),
            MicrorobotsStepMotion::Legs { legs, .. } => {
                self.switches += legs.len() as u64;
                for leg in legs {
                    self.time_ns = self.time_ns.saturating_add(leg_ns(order, *leg));
                    self.strokes = self.strokes.saturating_add(leg.strokes);
                }
            }
        }
    }

    fn plan(self, motion: MicrorobotsMotion) -> Plan<MicrorobotsMotion> {
        let seconds = |ns: u64| ns as f64 / 1e9;
        let outcomes = [
            (MicrorobotsOutcome::Time, seconds(self.time_ns)),
            (MicrorobotsOutcome::Switches, self.switches as f64),
            (MicrorobotsOutcome::Strokes, self.strokes as f64),
        ];
        Plan {
            planner: MicrorobotsPlanner::OneWayDubins.name(),
            objective: MicrorobotsObjective::Time.name(),
            unit: "s",
            cost: seconds(self.time_ns),
            bound: seconds(self.bound_ns),
            proof: if self.bound_ns >= self.time_ns { Optimality::Proven } else { Optimality::Open },
            bounds: BTreeMap::new(),
            outcomes: outcomes.map(|(word, value)| (word.name().to_owned(), value)).into_iter().collect(),
            remarks: self.remarks,
            motion,
        }
    }
}
