//! The steps of a job of microrobots, planned one after the other from the current poses.
//!
//! After each step every robot is where the strokes have carried it, so a step without a plan leaves the later ones
//! without a start: the job ends there. A step may begin with initial legs that move the whole bed (`initial_leg_tree` for
//! drives, `initial_leg_search` and `initial_legs` for assemblies); the best plan by the objective is kept.

mod assembled;
mod driven;
mod proofs;
mod regrouped;

use super::why::BedReasons;
use super::world::{BedPoses, CollisionWorld};
use super::{AssemblyStage, Crew, Leg, MicrorobotsMotion, MicrorobotsStepMotion, legs_cost, legs_ns};
use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder, MicrorobotsStep};
use crate::device::microrobots::Arm;
use crate::diagnostic::Sink;
use crate::plan::search::SearchBudget;

/// The motion of a whole job, and the state of the robots after it.
pub struct BedRoute {
    pub motion: MicrorobotsMotion,
    pub end: Crew,
}

/// Initial legs that a step may begin with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InitialLegChoice {
    /// None, or those with which a step is best by the objective.
    Best,
    /// None for an assembly, the best ones for other steps.
    None,
    /// For an assembly those of one descent with this seed, for other steps the best ones.
    Drawn(u64),
}

/// Plans the steps of a job one after the other; `None` after an error was pushed for one of them. `roomy` is the order
/// with the clearances that an assembly keeps after its initial legs, no smaller than the order's own.
pub fn plan_steps(
    order: &MicrorobotsOrder,
    roomy: &MicrorobotsOrder,
    start: &Crew,
    is_first: bool,
    initial_legs: InitialLegChoice,
    sink: &mut Sink,
) -> Option<BedRoute> {
    let world = CollisionWorld::new(order);
    let mut bed = BedPoses::new(start.poses.clone(), start.docked.clone());
    let mut steps = Vec::with_capacity(order.steps.len());
    let mut is_given = is_first;
    for step in &order.steps {
        let motion =
            BedStepPlanner { order, roomy, world: &world, bed: &bed, step, is_given, initial_legs }.planned(sink)?;
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
    world: &'a CollisionWorld,
    bed: &'a BedPoses,
    step: &'a MicrorobotsStep,
    /// Whether every plan leads to this state of the bed: no drive so far left a choice.
    is_given: bool,
    initial_legs: InitialLegChoice,
}

/// Most draws of initial legs that are tried for a step.
const MAX_INITIAL_DRAWS: usize = 40;

/// Each of them may expand 1/`INITIAL_LEGS_SHARE` of the step's budget.
const INITIAL_LEGS_SHARE: u64 = 16;

/// Seed of the draws.
const BEST_SEED: u64 = 1;

impl<'a> BedStepPlanner<'a> {
    fn planned(&self, sink: &mut Sink) -> Option<MicrorobotsStepMotion> {
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
        if let Some(hit) = self.bed.first_collision(self.world, &[leg], &[]) {
            sink.push(self.why().applied_into(&hit));
            return None;
        }
        Some(plain(vec![leg]))
    }

    fn share(&self, parts: u64) -> SearchBudget {
        SearchBudget::of((self.order.expansions / parts).max(1))
    }

    /// Cost of a step's legs: the objective's figure, then the other one to break ties.
    fn cost(&self, legs: &[Leg]) -> [u64; 2] {
        legs_cost(self.order, legs)
    }

    /// Cost of legs as text, for the watch on the search.
    fn summary(&self, legs: &[Leg]) -> String {
        format!("{:.1} s in {} legs", legs_ns(self.order, legs) as f64 / 1e9, legs.len())
    }
}

fn plain(legs: Vec<Leg>) -> MicrorobotsStepMotion {
    MicrorobotsStepMotion::Legs { legs, docks: Vec::new(), stages: Vec::<AssemblyStage>::new() }
}
