//! A step that assembles: the best of the assemblies with and without initial legs, improved after each docking
//! (`regrouped`) and, without errors, by moving all robots at the same time (`shooting`).
//!
//! If time or control cycles are minimised, assemblies are planned without fine motions, and the two robots that meet
//! first move at once: such legs are the best that the script of a generator can play. The closed loop, which carries a
//! task out if the device states errors, needs fine motions and drives the two one after the other. So a plan is
//! preferred if another one with fine motions is found beside it: the closed loop takes the paths of the two robots
//! from that.

use super::super::assembly::{
    self, Assembled, AssemblyTerms, CYCLES, DIRECT, DIRECT_PAIR, PlannedFineMotions, StuckAssembly,
};
use super::super::initial_leg_search::InitialLegSearch;
use super::super::initial_legs::{InitialLegs, RandomInitialLegs};
use super::super::shooting::ShootingSearch;
use super::super::world::{BedPoses, FirstCollision};
use super::super::{AssemblyStage, Leg, MicrorobotsStepMotion};
use super::proofs::ProofEffort;
use super::{BEST_SEED, BedStepPlanner, INITIAL_LEGS_SHARE, InitialLegChoice, MAX_INITIAL_DRAWS};
use crate::claims::microrobots::{Dock, MicrorobotsStop};
use crate::device::microrobots::MicrorobotsObjective;
use crate::diagnostic::Sink;
use crate::plan::search::{Meter, SearchBudget};
use crate::plan::watch::IncumbentPlan;
use crate::random::SplitMix64;

/// Descents to initial legs of an assembly, and variations of the best of them that are planned.
const DESCENTS: usize = 8;
const VARIATIONS: usize = 16;

/// Reason why a step brings no robots together.
enum NoAssembly {
    Stuck(StuckAssembly),
    /// A robot has been turning since the previous step, and meets something.
    StillTurning(FirstCollision),
}

/// A plan of the step.
struct AssemblyCandidate {
    motion: MicrorobotsStepMotion,
    /// Whether the closed loop is known to have room.
    is_steered: bool,
    /// The initial legs, if there are any.
    initial: Option<InitialLegs>,
}

impl BedStepPlanner<'_> {
    /// Returns the best assembly found; `None` after its error was pushed (drawn initial legs push none).
    pub fn assembled(&self, docks: &[Dock], sink: &mut Sink) -> Option<MicrorobotsStepMotion> {
        let search = InitialLegSearch::new(self.order, self.roomy, self.world, self.bed, docks, None);
        if let InitialLegChoice::Drawn(seed) = self.initial_legs {
            let mut meter = Meter::new(self.share(INITIAL_LEGS_SHARE));
            return search.and_then(|search| {
                self.after(self.bed, search.descend(seed)?, docks, &mut meter, self.fine_motions())
            });
        }
        let budget = SearchBudget::of(self.order.expansions);
        let terms = AssemblyTerms { fine: self.fine_motions(), most_stages: assembly::MAX_PLANS };
        let direct = self.assembly(self.bed, None, docks, &mut Meter::new(budget), terms);
        // These failures depend on arms and goals alone; no initial legs change that.
        let is_in_vain =
            matches!(direct, Err(NoAssembly::Stuck(StuckAssembly::Unsteerable { .. } | StuckAssembly::Apart { .. })));
        let goals: Vec<(usize, &MicrorobotsStop)> = docks.iter().map(|dock| (dock.robot, &dock.goal)).collect();
        let may_prove = direct.is_err() && !is_in_vain;
        let proof = |effort: ProofEffort| may_prove.then(|| self.no_plan(&goals, effort)).flatten();
        if let Some(proof) = proof(ProofEffort::Quick) {
            sink.push(proof);
            return None;
        }
        let meter = &mut Meter::new(budget);
        let mut best = direct.as_ref().ok().map(|motion| self.steered(motion.clone(), None, docks, meter));
        let _held = best.as_ref().map(|best| IncumbentPlan::begin(|| self.summary(best.motion.legs())));
        if !is_in_vain && self.initial_legs != InitialLegChoice::None {
            self.try_initial_legs(search.as_ref(), meter, docks, &mut best);
            // The closed loop cannot correct legs of the whole bed, so with errors they cost more success than time.
            if !self.has_errors() {
                if let Some(best) = best.as_mut() {
                    self.regroup(&mut best.motion, docks, meter);
                }
                self.shoot(docks, &mut best);
            }
        }
        if let (None, Err(none)) = (&best, &direct) {
            let goal = |robot: usize| docks.iter().find(|dock| dock.robot == robot).map(|dock| dock.goal.span);
            let span = |robot: usize| goal(robot).unwrap_or(self.step.span);
            sink.push(proof(ProofEffort::Thorough).unwrap_or_else(|| match none {
                NoAssembly::Stuck(stuck) => self.why().not_assembled(stuck, &span),
                NoAssembly::StillTurning(hit) => self.why().still_turning(hit),
            }));
        }
        best.map(|best| best.motion)
    }

    /// Whether the closed loop carries the task out; it drives the stages in its own way.
    fn has_errors(&self) -> bool {
        self.order.facts.errors.is_some_and(|errors| !errors.are_zero())
    }

    /// Fine motions of an assembly. If failures are minimised the plan has them, since it is chosen by how the
    /// controller carries it out. Those of single robots take hardly any time, but the closed loop is known to have
    /// room only on paths that were planned with them.
    pub fn fine_motions(&self) -> PlannedFineMotions {
        match self.order.objective {
            MicrorobotsObjective::Time if self.has_errors() => DIRECT_PAIR,
            MicrorobotsObjective::Time | MicrorobotsObjective::Switches => DIRECT,
            MicrorobotsObjective::Failures => CYCLES,
        }
    }

    /// Replaces the best assembly by one in which all robots move at the same time, if that is faster.
    fn shoot(&self, docks: &[Dock], best: &mut Option<AssemblyCandidate>) {
        match self.order.objective {
            MicrorobotsObjective::Time | MicrorobotsObjective::Failures => {}
            MicrorobotsObjective::Switches => return,
        }
        let known = best.as_ref().map(|best| &best.motion);
        let search = ShootingSearch::new(self.order, self.world, self.bed, docks, known);
        let Some(motion) = search.and_then(|search| search.fastest()) else { return };
        if best.as_ref().is_none_or(|best| self.cost(motion.legs()) < self.cost(best.motion.legs())) {
            *best = Some(AssemblyCandidate { motion, is_steered: true, initial: None });
        }
    }

    /// Replaces the given assembly by the best one after initial legs, if that is better.
    fn try_initial_legs(
        &self,
        search: Option<&InitialLegSearch>,
        meter: &mut Meter,
        docks: &[Dock],
        best: &mut Option<AssemblyCandidate>,
    ) {
        for initial in search.map(|search| search.descents(DESCENTS)).unwrap_or_default() {
            self.improve(initial, docks, meter, best);
        }
        let mut random = SplitMix64::new(BEST_SEED);
        for _ in 0..VARIATIONS {
            let legs = best.as_ref().and_then(|best| best.initial.as_ref());
            let varied = search.zip(legs).and_then(|(search, legs)| search.varied(legs, &mut random));
            if let Some(initial) = varied {
                self.improve(initial, docks, meter, best);
            }
        }
        if best.is_none() {
            let goals = docks.iter().map(|dock| dock.goal.pose);
            for initial in RandomInitialLegs::new(self.world, self.bed, goals, BEST_SEED).take(MAX_INITIAL_DRAWS) {
                self.improve(initial, docks, meter, best);
                if best.is_some() {
                    return;
                }
            }
        }
    }

    /// Replaces the best assembly by the one after these initial legs, if that is better.
    fn improve(&self, initial: InitialLegs, docks: &[Dock], meter: &mut Meter, best: &mut Option<AssemblyCandidate>) {
        let is_late = |legs: &[Leg]| {
            best.as_ref().is_some_and(|best| best.is_steered && self.cost(best.motion.legs()) <= self.cost(legs))
        };
        if is_late(&initial.legs) {
            return;
        }
        let Some(found) = self.after(self.bed, initial.clone(), docks, meter, self.fine_motions()) else { return };
        if is_late(found.legs()) {
            return;
        }
        let found = self.steered(found, Some(initial), docks, meter);
        let rank = |one: &AssemblyCandidate| (!one.is_steered, self.cost(one.motion.legs()));
        if best.as_ref().is_none_or(|best| rank(&found) < rank(best)) {
            *best = Some(found);
        }
    }

    /// Plans an assembly from a state of the bed after initial legs, on a share of the step's expansions.
    pub fn after(
        &self,
        from: &BedPoses,
        InitialLegs { mut legs, bed }: InitialLegs,
        docks: &[Dock],
        meter: &mut Meter,
        fine: PlannedFineMotions,
    ) -> Option<MicrorobotsStepMotion> {
        let state = legs.last().map(|leg| leg.state);
        let terms = AssemblyTerms { fine, most_stages: assembly::MAX_MORE_PLANS };
        let share = self.share(INITIAL_LEGS_SHARE).steps;
        let assembly = meter.share(share, |meter| self.assembly(&bed, state, docks, meter, terms));
        let MicrorobotsStepMotion::Legs { legs: later, docks: mut docking, mut stages } = assembly.ok()? else {
            return None;
        };
        if legs.last().map(|leg| leg.state) == later.first().map(|leg| leg.state) {
            return None;
        }
        stages.insert(0, AssemblyStage::BedLegs { legs: legs.len() });
        docking.iter_mut().for_each(|dock| dock.leg += legs.len());
        legs.extend(later);
        let is_free = from.first_collision(self.world, &legs, &docking).is_none();
        is_free.then_some(MicrorobotsStepMotion::Legs { legs, docks: docking, stages })
    }

    /// Completes a plan, after the given initial legs if any, with what the closed loop needs where the device states
    /// errors; or returns a plan with fine motions, if that is no worse.
    fn steered(
        &self,
        motion: MicrorobotsStepMotion,
        initial: Option<InitialLegs>,
        docks: &[Dock],
        meter: &mut Meter,
    ) -> AssemblyCandidate {
        if !self.has_errors() || self.order.objective == MicrorobotsObjective::Failures {
            return AssemblyCandidate { motion, is_steered: true, initial };
        }
        let terms = AssemblyTerms { fine: CYCLES, most_stages: assembly::MAX_MORE_PLANS };
        let with_cycles = match &initial {
            Some(initial) => self.after(self.bed, initial.clone(), docks, meter, CYCLES),
            None => meter.share(self.share(INITIAL_LEGS_SHARE).steps, |meter| {
                self.assembly(self.bed, None, docks, meter, terms).ok()
            }),
        };
        match with_cycles {
            None => AssemblyCandidate { motion, is_steered: false, initial },
            Some(other) if self.cost(other.legs()) <= self.cost(motion.legs()) => {
                AssemblyCandidate { motion: other, is_steered: true, initial }
            }
            Some(other) => {
                let (motion, is_steered) = with_paths_of(motion, &other);
                AssemblyCandidate { motion, is_steered, initial }
            }
        }
    }

    /// Plans an assembly from a state of the bed, after a leg in control state `state`.
    fn assembly(
        &self,
        bed: &BedPoses,
        state: Option<usize>,
        docks: &[Dock],
        meter: &mut Meter,
        terms: AssemblyTerms,
    ) -> Result<MicrorobotsStepMotion, NoAssembly> {
        let assembled = assembly::assemble(self.roomy, &bed.poses, &bed.docked, state, docks, meter, terms);
        let Assembled { legs, docks, stages, .. } = assembled.map_err(NoAssembly::Stuck)?;
        // The assembly was planned from rest, but a robot may have been turning since the previous step.
        match bed.first_collision(self.world, &legs, &docks) {
            Some(hit) => Err(NoAssembly::StillTurning(hit)),
            None => Ok(MicrorobotsStepMotion::Legs { legs, docks, stages }),
        }
    }
}

/// Lets the closed loop drive the first two robots of a plan on the paths of another plan from the same poses. Also
/// returns whether both begin alike: with the same two robots, or with a single one.
fn with_paths_of(motion: MicrorobotsStepMotion, other: &MicrorobotsStepMotion) -> (MicrorobotsStepMotion, bool) {
    let (first_of, initial) = (first_stage(motion.stages()), initial_legs(motion.stages()));
    let MicrorobotsStepMotion::Legs { legs, docks, mut stages } = motion else { return (motion, false) };
    let MicrorobotsStepMotion::Legs { legs: ways, docks: docking, stages: theirs } = other else {
        return (MicrorobotsStepMotion::Legs { legs, docks, stages }, false);
    };
    let is_alike = match (first_of.map(|at| &stages[at]), first_stage(theirs).map(|at| &theirs[at])) {
        (Some(AssemblyStage::Single { .. }), Some(AssemblyStage::Single { .. })) => true,
        (
            Some(AssemblyStage::Pair { first, second, .. }),
            Some(AssemblyStage::Pair { first: other, second: beside, .. }),
        ) if (first, second) == (other, beside) => {
            let end = docking.iter().filter(|dock| dock.robot == *first).map(|dock| dock.leg + 1).max();
            let ways = ways.get(initial..end.unwrap_or(initial)).unwrap_or_default();
            let begin = |stages: &[AssemblyStage]| stages.iter().position(is_of_pair).unwrap_or_default();
            let last = first_stage(theirs).unwrap_or_default();
            let mut pair = theirs[begin(theirs)..=last].to_vec();
            if let Some(AssemblyStage::Pair { steered, .. }) = pair.last_mut() {
                *steered = ways.to_vec();
            }
            stages.splice(begin(&stages)..=first_of.unwrap_or_default(), pair);
            true
        }
        (_, _) => false,
    };
    (MicrorobotsStepMotion::Legs { legs, docks, stages }, is_alike)
}

/// Number of legs before the assembly proper.
fn initial_legs(stages: &[AssemblyStage]) -> usize {
    match stages.first() {
        Some(AssemblyStage::BedLegs { legs }) => *legs,
        Some(AssemblyStage::Escort { .. } | AssemblyStage::Pair { .. } | AssemblyStage::Single { .. }) | None => 0,
    }
}

/// Index of the first stage in which robots dock.
fn first_stage(stages: &[AssemblyStage]) -> Option<usize> {
    stages.iter().position(|stage| matches!(stage, AssemblyStage::Pair { .. } | AssemblyStage::Single { .. }))
}

fn is_of_pair(stage: &AssemblyStage) -> bool {
    matches!(stage, AssemblyStage::Pair { .. } | AssemblyStage::Escort { .. })
}
