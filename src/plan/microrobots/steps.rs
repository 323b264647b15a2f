//! The steps of a job of microrobots, planned one after the other from the current poses.
//!
//! After each step every robot is where the strokes have carried it, so a step without a plan leaves the later ones without a
//! start: the job ends there. Steps may begin with first legs that move the whole bed (`departure`, `gathering`); the best by the objective is
//! kept.

use super::assembly::{self, Assembled, StuckAssembly};
use super::bound::together::{self, RobotArrival};
use super::departure::{Departure, Departures};
use super::doom::{self, DoomedRobot};
use super::drive::{self, Drive};
use super::free;
use super::gathering::Gathering;
use super::why::BedReasons;
use super::world::{BedPoses, FirstMeeting, World};
use super::{AssemblyStage, Crew, Leg, MicrorobotsMotion, MicrorobotsStepMotion, legs_ns};
use crate::claims::microrobots::{Dock, MicrorobotsAction, MicrorobotsOrder, MicrorobotsStep, MicrorobotsStop};
use crate::device::microrobots::{Arm, MicrorobotsObjective};
use crate::diagnostic::Sink;
use crate::geometry::Pose;
use crate::plan::search::{Meter, SearchBudget};
use crate::plan::watch::HeldPlan;
use crate::random::SplitMix64;

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
    /// An assembly begins with those of one descent of this seed, other steps with the best.
    Drawn(u64),
}

/// Plans the steps of a job one after the other; without a plan for one of them its error was pushed. `roomy` is the order with the
/// clearances that an assembly keeps after its first legs, no smaller than the order's own.
pub fn carried_out(
    (order, roomy): (&MicrorobotsOrder, &MicrorobotsOrder),
    (start, is_first): (&Crew, bool),
    first_legs: FirstLegs,
    sink: &mut Sink,
) -> Option<BedRoute> {
    let world = World::new(order);
    let mut bed = BedPoses::new(start.poses.clone(), start.docked.clone());
    let mut steps = Vec::with_capacity(order.steps.len());
    let mut is_given = is_first;
    for step in &order.steps {
        let motion =
            BedStepPlanner { order, roomy, world: &world, bed: &bed, step, is_given, first_legs }.done(sink)?;
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
    roomy: &'a MicrorobotsOrder,
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

/// The same for a drive's first attempt without first legs, and for each with them; more only where these find nothing.
const FIRST_SHARE: u64 = 50;
const DRIVE_SHARE: u64 = 200;

/// Descents to first legs of an assembly, and changes of the best of them that are planned.
const DESCENTS: u64 = 8;
const VARIATIONS: usize = 16;

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
        let direct = drive::drive(&request, self.share(FIRST_SHARE));
        match &direct {
            Ok(driven) if driven.direct => return Some(plain(driven.legs.clone())),
            Err(stuck) if stuck.reason.is_proof() => {
                sink.push(self.why().not_driven(robot, stuck, stops));
                return None;
            }
            Ok(_) => {}
            Err(_) => {
                let goals: Vec<(usize, Pose)> = poses.iter().map(|pose| (robot, *pose)).collect();
                if let Some((doomed, strokes)) = self.doomed(&goals) {
                    sink.push(self.why().doomed(&doomed, strokes));
                    return None;
                }
            }
        }
        let best = direct.ok().map(|driven| driven.legs);
        let best = self.driven_after_legs(&request, best, self.share(DRIVE_SHARE));
        if best.is_some() {
            return best.map(plain);
        }
        match drive::drive(&request, self.share(1)) {
            Ok(driven) => Some(plain(driven.legs)),
            Err(stuck) => {
                let found = self.driven_after_legs(&request, None, self.share(DEPARTURE_SHARE));
                if found.is_none() {
                    sink.push(self.why().not_driven(robot, &stuck, stops));
                }
                found.map(plain)
            }
        }
    }

    /// A robot that meets an obstacle before the step can end, whatever states it is driven in, and the strokes that it would need: up to
    /// its own goals, or, if it has none, until the others are at theirs. `None` if every plan is not known to begin here.
    fn doomed(&self, goals: &[(usize, Pose)]) -> Option<(DoomedRobot, u64)> {
        let BedPoses { poses, docked, .. } = self.bed;
        let arrival = |(robot, goal): &(usize, Pose)| RobotArrival::of(self.order, *robot, poses[*robot], *goal);
        let all = goals.iter().filter(|(robot, _)| !docked[*robot]);
        let least = |of: Vec<RobotArrival>| together::least_strokes(self.order, of);
        let step = match self.step.action {
            MicrorobotsAction::Assemble(_) => least(all.clone().map(arrival).collect()),
            // A robot does not stay at its stops.
            MicrorobotsAction::Drive { .. } | MicrorobotsAction::Apply { .. } | MicrorobotsAction::Wait(_) => {
                all.clone().map(|goal| least(vec![arrival(goal)])).max().unwrap_or(0)
            }
        };
        let needed = |robot: usize| {
            let own = all.clone().filter(|goal| goal.0 == robot).map(|goal| least(vec![arrival(goal)]));
            own.max().unwrap_or(step)
        };
        let moving = (0..self.world.count()).filter(|robot| self.is_given && !docked[*robot]);
        moving.into_iter().find_map(|robot| {
            let strokes = needed(robot);
            let doomed = doom::doomed(self.world, (robot, poses[robot]), self.world.way_um(robot, strokes));
            doomed.map(|doomed| (doomed, strokes))
        })
    }

    /// The best of drives after first legs, and of the given one.
    fn driven_after_legs(&self, request: &Drive, direct: Option<Vec<Leg>>, budget: SearchBudget) -> Option<Vec<Leg>> {
        let (robot, stops) = (request.robot, request.stops);
        let mut best = direct;
        for Departure { mut legs, bed } in self.departures(stops.iter().copied(), BEST_SEED).take(MAX_DEPARTURES) {
            if best.as_ref().is_some_and(|best| self.cannot_beat(best, &legs, (robot, bed.poses[robot]), stops)) {
                continue;
            }
            let after = Drive { bed: &bed, ..*request };
            let Ok(driven) = drive::drive(&after, budget) else { continue };
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
        best
    }

    fn share(&self, parts: u64) -> SearchBudget {
        SearchBudget::of((self.order.expansions / parts).max(1))
    }

    /// Whether no drive from a pose through stops, after first legs, is shorter than the best one so far: the shortest paths without
    /// obstacles take as long.
    fn cannot_beat(&self, best: &[Leg], legs: &[Leg], (robot, from): (usize, Pose), stops: &[Pose]) -> bool {
        let facts = self.order.robot(robot);
        let ways = std::iter::once(&from).chain(stops).zip(stops);
        let way_um: f64 = ways.map(|(from, to)| free::distance_um(facts, *from, *to)).sum();
        let driven: u64 = legs.iter().map(|leg| leg.strokes).sum();
        let strokes = |legs: &[Leg]| legs.iter().map(|leg| leg.strokes).sum::<u64>();
        match self.order.objective {
            MicrorobotsObjective::Time | MicrorobotsObjective::Failures => {
                driven + (way_um / facts.step_um) as u64 >= strokes(best)
            }
            MicrorobotsObjective::Switches => legs.len() >= best.len(),
        }
    }

    /// First legs for a step with these goals.
    fn departures(&self, goals: impl Iterator<Item = Pose>, seed: u64) -> Departures<'_> {
        Departures::new(self.order, (self.world, self.bed), goals, seed)
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

    /// What legs cost, for who watches the search.
    fn summary(&self, legs: &[Leg]) -> String {
        format!("{:.1} s in {} legs", legs_ns(self.order, legs) as f64 / 1e9, legs.len())
    }

    fn assembled(&self, docks: &[Dock], sink: &mut Sink) -> Option<MicrorobotsStepMotion> {
        let gathering = Gathering::new((self.order, self.roomy), (self.world, self.bed), docks);
        if let FirstLegs::Drawn(seed) = self.first_legs {
            let mut meter = Meter::new(self.share(DEPARTURE_SHARE));
            return gathering.and_then(|gathering| self.after(gathering.descend(seed)?, docks, &mut meter));
        }
        let budget = SearchBudget::of(self.order.expansions);
        let direct = self.assembly((self.bed, None), docks, (&mut Meter::new(budget), assembly::MAX_PLANS));
        // Neither arms nor goals change with the robots' places.
        let is_in_vain =
            matches!(direct, Err(NoAssembly::Stuck(StuckAssembly::Unsteerable { .. } | StuckAssembly::Apart { .. })));
        if let (Err(_), false) = (&direct, is_in_vain) {
            let goals: Vec<(usize, Pose)> = docks.iter().map(|dock| (dock.robot, dock.goal.pose)).collect();
            if let Some((doomed, strokes)) = self.doomed(&goals) {
                sink.push(self.why().doomed(&doomed, strokes));
                return None;
            }
        }
        let mut best = direct.as_ref().ok().cloned();
        let _held = best.as_ref().map(|best| HeldPlan::begin(|| self.summary(best.legs())));
        if !is_in_vain && self.first_legs != FirstLegs::None {
            best = self.gathered((gathering.as_ref(), &mut Meter::new(budget)), docks, best);
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

    /// The best of assemblies after first legs, and of the given one.
    fn gathered(
        &self,
        (gathering, meter): (Option<&Gathering>, &mut Meter),
        docks: &[Dock],
        direct: Option<MicrorobotsStepMotion>,
    ) -> Option<MicrorobotsStepMotion> {
        let (mut best, mut best_legs) = (direct, None);
        let mut improve = |departure: Departure,
                           best: &mut Option<MicrorobotsStepMotion>,
                           best_legs: &mut Option<Departure>| {
            let is_late = best.as_ref().is_some_and(|best| self.cost(best.legs()) <= self.cost(&departure.legs));
            let Some(found) = (!is_late).then(|| self.after(departure.clone(), docks, meter)).flatten() else { return };
            if best.as_ref().is_none_or(|best| self.cost(found.legs()) < self.cost(best.legs())) {
                (*best, *best_legs) = (Some(found), Some(departure));
            }
        };
        for seed in 1..=DESCENTS {
            if let Some(departure) = gathering.and_then(|gathering| gathering.descend(seed)) {
                improve(departure, &mut best, &mut best_legs);
            }
        }
        let mut random = SplitMix64::new(BEST_SEED);
        for _ in 0..VARIATIONS {
            let varied =
                gathering.zip(best_legs.as_ref()).and_then(|(gathering, legs)| gathering.varied(legs, &mut random));
            if let Some(departure) = varied {
                improve(departure, &mut best, &mut best_legs);
            }
        }
        if best.is_none() {
            let goals = docks.iter().map(|dock| dock.goal.pose);
            let mut departures = self.departures(goals, BEST_SEED).take(MAX_DEPARTURES);
            best = departures.find_map(|legs| self.after(legs, docks, meter));
        }
        best
    }

    /// The assembly after first legs, on a share of the step's expansions.
    fn after(
        &self,
        Departure { mut legs, bed }: Departure,
        docks: &[Dock],
        meter: &mut Meter,
    ) -> Option<MicrorobotsStepMotion> {
        let from = (&bed, legs.last().map(|leg| leg.state));
        let assembly = meter.share(self.share(DEPARTURE_SHARE).steps, |meter| {
            self.assembly(from, docks, (meter, assembly::MAX_MORE_PLANS))
        });
        let MicrorobotsStepMotion::Legs { legs: later, docks: mut docking, mut stages } = assembly.ok()? else {
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

    /// An assembly from a state of the bed, after a leg in a control state, of at most so many stages planned.
    fn assembly(
        &self,
        (bed, state): (&BedPoses, Option<usize>),
        docks: &[Dock],
        (meter, most_stages): (&mut Meter, usize),
    ) -> Result<MicrorobotsStepMotion, NoAssembly> {
        let assembled = assembly::assemble(self.roomy, (&bed.poses, &bed.docked, state), docks, meter, most_stages);
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
