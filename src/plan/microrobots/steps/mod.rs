//! The steps of a job of microrobots, planned one after the other from the current poses.
//!
//! After each step every robot is where the strokes have carried it, so a step without a plan leaves the later ones
//! without a start: the job ends there. A step may begin with initial legs that move the whole bed (`initial_legs`,
//! `initial_leg_search`); the best plan by the objective is kept.

mod assembled;

use super::bound::together::{self, RobotArrival};
use super::collision_proof::{self, InevitableCollision};
use super::drive::{self, DriveRequest};
use super::free;
use super::initial_legs::{InitialLegs, RandomInitialLegs};
use super::why::BedReasons;
use super::world::{BedPoses, CollisionWorld};
use super::{AssemblyStage, Crew, Leg, MicrorobotsMotion, MicrorobotsStepMotion, legs_cost, legs_ns};
use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder, MicrorobotsStep, MicrorobotsStop};
use crate::device::microrobots::{Arm, MicrorobotsObjective};
use crate::diagnostic::Sink;
use crate::geometry::Pose;
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

/// The same for a drive: its first attempt without initial legs, and each attempt with some; they get more only if
/// these find nothing.
const FIRST_SHARE: u64 = 50;
const DRIVE_SHARE: u64 = 200;

/// Draws of initial legs for a drive without a plan so far, and the small share for each: the few that help mostly
/// leave a clear path.
const MANY_INITIAL_DRAWS: usize = 1_000;
const SMALL_SHARE: u64 = 2_000;

/// Seed of the draws among which the best is chosen, and of the many.
const BEST_SEED: u64 = 1;
const MANY_SEED: u64 = 2;

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

    fn driven(&self, robot: usize, stops: &[MicrorobotsStop], sink: &mut Sink) -> Option<MicrorobotsStepMotion> {
        let poses: Vec<Pose> = stops.iter().map(|stop| stop.pose).collect();
        let request = DriveRequest { order: self.order, world: self.world, bed: self.bed, robot, stops: &poses };
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
                if let Some((collision, strokes)) = self.inevitable_collision(&goals) {
                    sink.push(self.why().inevitable_collision(&collision, strokes));
                    return None;
                }
            }
        }
        let best = direct.ok().map(|driven| driven.legs);
        let few = || self.random_initial_legs(poses.iter().copied(), BEST_SEED).take(MAX_INITIAL_DRAWS);
        let many = || self.random_initial_legs(poses.iter().copied(), MANY_SEED).take(MANY_INITIAL_DRAWS);
        let best = self.driven_after_legs(&request, best, few(), self.share(DRIVE_SHARE));
        let best = best.or_else(|| self.driven_after_legs(&request, None, many(), self.share(SMALL_SHARE)));
        if best.is_some() {
            return best.map(plain);
        }
        match drive::drive(&request, self.share(1)) {
            Ok(driven) => Some(plain(driven.legs)),
            Err(stuck) => {
                let found = self.driven_after_legs(&request, None, few(), self.share(INITIAL_LEGS_SHARE));
                if found.is_none() {
                    sink.push(self.why().not_driven(robot, &stuck, stops));
                }
                found.map(plain)
            }
        }
    }

    /// A robot that meets an obstacle before the step can end, whatever states are driven, and the strokes that it
    /// would need: up to its own goals or, if it has none, until the others are at theirs. `None` also if some plan may
    /// begin the step elsewhere.
    fn inevitable_collision(&self, goals: &[(usize, Pose)]) -> Option<(InevitableCollision, u64)> {
        let BedPoses { poses, docked, .. } = self.bed;
        let arrival = |(robot, goal): &(usize, Pose)| RobotArrival::of(self.order, *robot, poses[*robot], *goal);
        let all = goals.iter().filter(|(robot, _)| !docked[*robot]);
        let least = |of: Vec<RobotArrival>| together::least_strokes(self.order, of);
        let step = match self.step.action {
            MicrorobotsAction::Assemble(_) => least(all.clone().map(arrival).collect()),
            // A robot does not stay at its stops, so each is bounded alone.
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
            let collision = collision_proof::inevitable_collision(
                self.world,
                robot,
                poses[robot],
                self.world.way_um(robot, strokes),
            );
            collision.map(|collision| (collision, strokes))
        })
    }

    /// Returns the best of the drives after initial legs and of the given one.
    fn driven_after_legs(
        &self,
        request: &DriveRequest,
        direct: Option<Vec<Leg>>,
        draws: impl Iterator<Item = InitialLegs>,
        budget: SearchBudget,
    ) -> Option<Vec<Leg>> {
        let (robot, stops) = (request.robot, request.stops);
        let mut best = direct;
        for InitialLegs { mut legs, bed } in draws {
            if best.as_ref().is_some_and(|best| self.cannot_beat(best, &legs, robot, bed.poses[robot], stops)) {
                continue;
            }
            let after = DriveRequest { bed: &bed, ..*request };
            let Ok(driven) = drive::drive(&after, budget) else { continue };
            // A stop must be met at the end of a leg of the drive, not before its first leg.
            let (Some(first), false) = (driven.legs.first(), driven.met.contains(&0)) else { continue };
            if let Some(last) = legs.last_mut().filter(|last| last.state == first.state) {
                last.strokes += first.strokes;
                legs.extend(&driven.legs[1..]);
            } else {
                legs.extend(&driven.legs);
            }
            let is_better = best.as_ref().is_none_or(|best| self.cost(&legs) < self.cost(best));
            if is_better && self.bed.first_collision(self.world, &legs, &[]).is_none() {
                best = Some(legs);
            }
        }
        best
    }

    fn share(&self, parts: u64) -> SearchBudget {
        SearchBudget::of((self.order.expansions / parts).max(1))
    }

    /// Whether no drive through the stops, from a pose after initial legs, beats the best one so far: even without
    /// obstacles, the shortest paths take as long.
    fn cannot_beat(&self, best: &[Leg], legs: &[Leg], robot: usize, from: Pose, stops: &[Pose]) -> bool {
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

    /// Initial legs for a step with these goals.
    fn random_initial_legs(&self, goals: impl Iterator<Item = Pose>, seed: u64) -> RandomInitialLegs<'_> {
        RandomInitialLegs::new(self.order, self.world, self.bed, goals, seed)
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
