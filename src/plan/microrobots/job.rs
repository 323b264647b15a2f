//! One job of microrobots: its steps planned one after the other, from the current poses.
//!
//! After each step every robot is where the strokes have carried it, so a step without a plan leaves the later ones without a
//! start: the job ends there. Steps may begin with first legs that move the whole bed (`departure`); the best by the objective is kept.

use super::assembly::{self, Assembled, StuckAssembly};
use super::bound;
use super::departure::{Departure, Departures};
use super::drive::{self, Drive};
use super::guarantee::{Assured, guarantees};
use super::safest;
use super::strategy::{driven, episodes};
use super::why::BedReasons;
use super::world::{BedPoses, FirstMeeting, World};
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
use crate::plan::{KindPlanner, Motion, Optimality, Plan, Planned, Standings};
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

impl KindPlanner for MicrorobotsOrder {
    fn planned<'a>(&'a self, job: &Job, standings: &mut Standings, sink: &mut Sink) -> Option<Plan<Motion<'a>>> {
        let plan = plan(job, self, &mut standings.microrobots, sink)?;
        Some(plan.map(|motion| Motion::Microrobots(Planned { order: self, motion })))
    }
}

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
    let bound_ns = bound::least_ns(order, &start);
    let fastest = carried_out(order, (&start, is_first), FirstLegs::Best, sink)?;
    let BedRoute { motion, end } = match order.objective {
        MicrorobotsObjective::Time | MicrorobotsObjective::Switches => fastest,
        MicrorobotsObjective::Failures => safest::safest(order, (&start, is_first), fastest),
    };
    let mut tally = BedTally::of(order, &motion, bound_ns);
    let are_guaranteed = assure(order, &motion, &mut tally.remarks, sink);
    tally.failing = safest::expected(job, order, &motion, &mut tally.remarks, sink);
    let plan = tally.plan(order.objective, motion);
    let kept = require(job, &plan, &mut |_| KnownLimit::default(), sink);
    Some(((kept == Kept::Yes && are_guaranteed).then_some(plan), end))
}

/// The motion of a whole job, and the state of the robots after it.
pub struct BedRoute {
    pub motion: MicrorobotsMotion,
    pub end: Crew,
}

/// First legs that a step may begin with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FirstLegs {
    /// None, or those with which a step is best by the objective.
    Best,
    /// None for an assembly, the best for other steps.
    None,
    /// An assembly begins with the first ones of this seed, other steps with the best.
    Drawn(u64),
}

/// Plans the steps of a job one after the other; without a plan for one of them its error was pushed.
pub fn carried_out(
    order: &MicrorobotsOrder,
    (start, is_first): (&Crew, bool),
    first_legs: FirstLegs,
    sink: &mut Sink,
) -> Option<BedRoute> {
    let world = World::new(order);
    let mut bed = BedPoses::new(start.poses.clone(), start.docked.clone());
    let mut steps = Vec::with_capacity(order.steps.len());
    let mut is_given = is_first;
    for step in &order.steps {
        let motion = BedStepPlanner { order, world: &world, bed: &bed, step, is_given, first_legs }.done(sink)?;
        is_given &= matches!(step.action, MicrorobotsAction::Wait(_) | MicrorobotsAction::Apply { .. });
        match &motion {
            MicrorobotsStepMotion::Legs { legs, docks, .. } => bed.follow(&world, legs, docks),
            MicrorobotsStepMotion::Wait(_) => bed.rest(),
        }
        steps.push(motion);
    }
    let motion = MicrorobotsMotion { start: start.clone(), steps };
    Some(BedRoute { motion, end: Crew { poses: bed.poses, docked: bed.docked } })
}

/// Remarks for each stage of an assembly whether it is guaranteed; `false` if the task demands a guarantee that does not exist.
///
/// Without errors the plan is executed as written, and the verifier has checked the result. With errors nothing is guaranteed; the
/// first containment that the estimates reject is named.
fn assure(order: &MicrorobotsOrder, motion: &MicrorobotsMotion, remarks: &mut Vec<Remark>, sink: &mut Sink) -> bool {
    let is_exact = order.facts.errors.is_some_and(|errors| errors.are_zero());
    let estimates = if is_exact { Vec::new() } else { guarantees(order, motion).unwrap_or_default() };
    let mut all_hold = true;
    let all = episodes(order, motion);
    for (nth, episode) in all.iter().filter(|episode| !driven(episode.stage).is_empty()).enumerate() {
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

/// Planner of one step, from the current state of the bed.
struct BedStepPlanner<'a> {
    order: &'a MicrorobotsOrder,
    world: &'a World,
    bed: &'a BedPoses,
    step: &'a MicrorobotsStep,
    /// Whether every plan leads to this state of the bed: nothing driven so far left a choice.
    is_given: bool,
    first_legs: FirstLegs,
}

/// Most first legs that are tried for a step.
const MAX_DEPARTURES: usize = 40;

/// Each of them may expand this share of the step's budget.
const DEPARTURE_SHARE: u64 = 16;

/// Seed of the first legs among which the best is chosen.
const BEST_SEED: u64 = 1;

impl<'a> BedStepPlanner<'a> {
    fn done(&self, sink: &mut Sink) -> Option<MicrorobotsStepMotion> {
        match &self.step.action {
            MicrorobotsAction::Wait(duration_ns) => Some(MicrorobotsStepMotion::Wait(*duration_ns)),
            MicrorobotsAction::Apply { state, duration_ns } => self.applied(*state, *duration_ns, sink),
            MicrorobotsAction::Drive { robot, stops } => self.driven(*robot, stops, sink),
            MicrorobotsAction::Assemble(docks) => self.assembled(docks, sink),
        }
    }

    fn why(&self) -> BedReasons<'a> {
        BedReasons { order: self.order, step: self.step, docked: &self.bed.docked, is_given: self.is_given }
    }

    fn applied(&self, state: usize, duration_ns: u64, sink: &mut Sink) -> Option<MicrorobotsStepMotion> {
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
        Some(plain(vec![leg]))
    }

    fn driven(&self, robot: usize, stops: &[MicrorobotsStop], sink: &mut Sink) -> Option<MicrorobotsStepMotion> {
        let poses: Vec<Pose> = stops.iter().map(|stop| stop.pose).collect();
        let request = Drive { order: self.order, world: self.world, bed: self.bed, robot, stops: &poses };
        let direct = drive::drive(&request, SearchBudget::of(self.order.expansions));
        let mut best = match &direct {
            Ok(driven) if driven.direct => return Some(plain(driven.legs.clone())),
            Err(stuck) if stuck.reason.is_proof() => None,
            Ok(driven) => Some(driven.legs.clone()),
            Err(_) => None,
        };
        let is_proof = direct.as_ref().is_err_and(|stuck| stuck.reason.is_proof());
        let departures = if is_proof { 0 } else { MAX_DEPARTURES };
        for Departure { mut legs, bed } in self.departures(poses.iter().copied(), BEST_SEED).take(departures) {
            let after = Drive { bed: &bed, ..request };
            let Ok(driven) = drive::drive(&after, self.departure_budget()) else { continue };
            // A stop is met at the end of a leg of the drive.
            let (Some(first), false) = (driven.legs.first(), driven.met.contains(&0)) else { continue };
            if let Some(last) = legs.last_mut().filter(|last| last.state == first.state) {
                last.strokes += first.strokes;
                legs.extend(&driven.legs[1..]);
            } else {
                legs.extend(&driven.legs);
            }
            let is_better = best.as_ref().is_none_or(|best| self.cost(&legs) < self.cost(best));
            if is_better && self.bed.first_hit(self.world, &legs, &[]).is_none() {
                best = Some(legs);
            }
        }
        if let (None, Err(stuck)) = (&best, &direct) {
            sink.push(self.why().not_driven(robot, stuck, stops));
        }
        best.map(plain)
    }

    /// First legs for a step with these goals.
    fn departures(&self, goals: impl Iterator<Item = Pose>, seed: u64) -> Departures<'_> {
        Departures::new(self.order, (self.world, self.bed), goals, seed)
    }

    fn departure_budget(&self) -> SearchBudget {
        SearchBudget::of((self.order.expansions / DEPARTURE_SHARE).max(1))
    }

    /// What the legs of a step cost: by the objective, then by the other figure.
    fn cost(&self, legs: &[Leg]) -> [u64; 2] {
        let time_ns = legs.iter().map(|leg| leg_ns(self.order, *leg)).fold(0, u64::saturating_add);
        let switches = legs.len() as u64;
        match self.order.objective {
            MicrorobotsObjective::Time | MicrorobotsObjective::Failures => [time_ns, switches],
            MicrorobotsObjective::Switches => [switches, time_ns],
        }
    }

    fn assembled(&self, docks: &[Dock], sink: &mut Sink) -> Option<MicrorobotsStepMotion> {
        let goals = || docks.iter().map(|dock| dock.goal.pose);
        if let FirstLegs::Drawn(seed) = self.first_legs {
            return self.departures(goals(), seed).take(1).find_map(|departure| self.after(departure, docks));
        }
        let budget = SearchBudget::of(self.order.expansions);
        let direct = self.assembly(self.bed, docks, (budget, assembly::MAX_PLANS));
        let mut best = direct.as_ref().ok().cloned();
        // Neither arms nor goals change with the robots' places.
        let is_in_vain =
            matches!(direct, Err(NoAssembly::Stuck(StuckAssembly::Unsteerable { .. } | StuckAssembly::Apart { .. })));
        let departures = if is_in_vain || self.first_legs == FirstLegs::None { 0 } else { MAX_DEPARTURES };
        for departure in self.departures(goals(), BEST_SEED).take(departures) {
            let is_late = best.as_ref().is_some_and(|best| self.cost(legs_of(best)) <= self.cost(&departure.legs));
            let Some(found) = (!is_late).then(|| self.after(departure, docks)).flatten() else { continue };
            if best.as_ref().is_none_or(|best| self.cost(legs_of(&found)) < self.cost(legs_of(best))) {
                best = Some(found);
            }
        }
        if let (None, Err(none)) = (&best, &direct) {
            let goal = |robot: usize| docks.iter().find(|dock| dock.robot == robot).map(|dock| dock.goal.span);
            let span = |robot: usize| goal(robot).unwrap_or(self.step.span);
            sink.push(match none {
                NoAssembly::Stuck(stuck) => self.why().not_assembled(stuck, &span),
                NoAssembly::StillTurning(hit) => self.why().still_turning(hit),
            });
        }
        best
    }

    /// The assembly after first legs; `None` also where its first state is that of the last of them.
    fn after(&self, Departure { mut legs, bed }: Departure, docks: &[Dock]) -> Option<MicrorobotsStepMotion> {
        let effort = (self.departure_budget(), assembly::MAX_MORE_PLANS);
        let MicrorobotsStepMotion::Legs { legs: later, docks: mut docking, mut stages } =
            self.assembly(&bed, docks, effort).ok()?
        else {
            return None;
        };
        if legs.last().map(|leg| leg.state) == later.first().map(|leg| leg.state) {
            return None;
        }
        stages.insert(0, AssemblyStage::Departure { legs: legs.len() });
        docking.iter_mut().for_each(|dock| dock.leg += legs.len());
        legs.extend(later);
        let is_free = self.bed.first_hit(self.world, &legs, &docking).is_none();
        is_free.then_some(MicrorobotsStepMotion::Legs { legs, docks: docking, stages })
    }

    /// An assembly from a state of the bed, of at most so many stages planned.
    fn assembly(
        &self,
        bed: &BedPoses,
        docks: &[Dock],
        (budget, most_stages): (SearchBudget, usize),
    ) -> Result<MicrorobotsStepMotion, NoAssembly> {
        let assembled = assembly::assemble(self.order, (&bed.poses, &bed.docked), docks, budget, most_stages);
        let Assembled { legs, docks, stages, .. } = assembled.map_err(NoAssembly::Stuck)?;
        // The assembly was planned from rest, but a robot may have been turning since the previous step.
        match bed.first_hit(self.world, &legs, &docks) {
            Some(hit) => Err(NoAssembly::StillTurning(hit)),
            None => Ok(MicrorobotsStepMotion::Legs { legs, docks, stages }),
        }
    }
}

/// Why a step brings no robots together.
enum NoAssembly {
    Stuck(StuckAssembly),
    /// A robot has been turning since the previous step, and meets something.
    StillTurning(FirstMeeting),
}

fn legs_of(motion: &MicrorobotsStepMotion) -> &[Leg] {
    match motion {
        MicrorobotsStepMotion::Legs { legs, .. } => legs,
        MicrorobotsStepMotion::Wait(_) => &[],
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
    /// Lower bound on the number of control cycles: one for each state that is applied.
    least_switches: u64,
    switches: u64,
    strokes: u64,
    /// Share of simulated trials that fail, where they can be simulated.
    failing: Option<f64>,
    remarks: Vec<Remark>,
}

impl BedTally {
    fn of(order: &MicrorobotsOrder, motion: &MicrorobotsMotion, bound_ns: u64) -> BedTally {
        let is_applied = |step: &&MicrorobotsStep| matches!(step.action, MicrorobotsAction::Apply { .. });
        let least_switches = order.steps.iter().filter(is_applied).count() as u64;
        let mut tally = BedTally { bound_ns, least_switches, ..BedTally::default() };
        for step in &motion.steps {
            match step {
                MicrorobotsStepMotion::Wait(duration_ns) => tally.time_ns = tally.time_ns.saturating_add(*duration_ns),
                MicrorobotsStepMotion::Legs { legs, .. } => {
                    tally.switches += legs.len() as u64;
                    for leg in legs {
                        tally.time_ns = tally.time_ns.saturating_add(leg_ns(order, *leg));
                        tally.strokes = tally.strokes.saturating_add(leg.strokes);
                    }
                }
            }
        }
        tally
    }

    fn plan(self, objective: MicrorobotsObjective, motion: MicrorobotsMotion) -> Plan<MicrorobotsMotion> {
        let seconds = |ns: u64| ns as f64 / 1e9;
        let outcomes = [
            (MicrorobotsOutcome::Time, seconds(self.time_ns)),
            (MicrorobotsOutcome::Switches, self.switches as f64),
            (MicrorobotsOutcome::Strokes, self.strokes as f64),
        ];
        let time_s = [self.time_ns, self.bound_ns].map(seconds);
        let ([cost, bound], is_exact) = match objective {
            MicrorobotsObjective::Time => (time_s, true),
            MicrorobotsObjective::Switches => ([self.switches, self.least_switches].map(|count| count as f64), true),
            // An estimate, which proves nothing.
            MicrorobotsObjective::Failures => ([self.failing.unwrap_or(0.0), 0.0], false),
        };
        Plan {
            planner: MicrorobotsPlanner::OneWayDubins.name(),
            objective: objective.name(),
            unit: objective.unit(),
            cost,
            bound,
            proof: if is_exact && bound >= cost { Optimality::Proven } else { Optimality::Open },
            bounds: BTreeMap::new(),
            outcomes: outcomes.map(|(word, value)| (word.name().to_owned(), value)).into_iter().collect(),
            remarks: self.remarks,
            motion,
        }
    }
}
