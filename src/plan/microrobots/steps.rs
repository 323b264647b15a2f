//! The steps of a job of microrobots, planned one after the other from the current poses.
//!
//! After each step every robot is where the strokes have carried it, so a step without a plan leaves the later ones without a
//! start: the job ends there. Steps may begin with first legs that move the whole bed (`departure`); the best by the objective is kept.

use super::assembly::{self, Assembled, StuckAssembly};
use super::departure::{Departure, Departures};
use super::drive::{self, Drive};
use super::why::BedReasons;
use super::world::{BedPoses, FirstMeeting, World};
use super::{AssemblyStage, Crew, Leg, MicrorobotsMotion, MicrorobotsStepMotion, legs_ns};
use crate::claims::microrobots::{Dock, MicrorobotsAction, MicrorobotsOrder, MicrorobotsStep, MicrorobotsStop};
use crate::device::microrobots::{Arm, MicrorobotsObjective};
use crate::diagnostic::Sink;
use crate::geometry::Pose;
use crate::plan::search::SearchBudget;

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
        let (mut best, departures) = match &direct {
            Ok(driven) if driven.direct => return Some(plain(driven.legs.clone())),
            Ok(driven) => (Some(driven.legs.clone()), MAX_DEPARTURES),
            Err(stuck) if stuck.reason.is_proof() => (None, 0),
            Err(_) => (None, MAX_DEPARTURES),
        };
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
        let time_ns = legs_ns(self.order, legs);
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
            let is_late = best.as_ref().is_some_and(|best| self.cost(best.legs()) <= self.cost(&departure.legs));
            let Some(found) = (!is_late).then(|| self.after(departure, docks)).flatten() else { continue };
            if best.as_ref().is_none_or(|best| self.cost(found.legs()) < self.cost(best.legs())) {
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

fn plain(legs: Vec<Leg>) -> MicrorobotsStepMotion {
    MicrorobotsStepMotion::Legs { legs, docks: Vec::new(), stages: Vec::<AssemblyStage>::new() }
}
