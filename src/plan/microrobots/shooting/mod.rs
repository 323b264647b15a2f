//! Assemblies in which all robots move towards their goals at the same time (direct single shooting).
//!
//! Problem: an assembly that steers one robot after the other lets those that wait drive full circles. Method: a
//! sequence of control states is given, with the leg after which each robot docks; what is unknown are the lengths of
//! the legs. The goals are three equations for each robot, and more legs than equations leave a choice, of which the
//! shortest is taken (`lengths`). Sequences are drawn at random or taken from a known plan, and changed at random
//! (`sequence`); a change is kept if it does not worsen the duration by more than a shrinking random threshold
//! (threshold accepting). Sequences that meet something are kept, too, at a price for each leg that does, so that a
//! descent may begin in the midst of collisions. Descents that do badly end early (successive halving).
//! Guaranteed: a plan keeps the collision rules, every robot docks where it should, and the same request gives the same
//! plan. Not guaranteed: that one is found, or that it is the fastest. The closed loop cannot carry such a plan out:
//! it is for devices without errors. Cost: for each round a solution (hundreds of microseconds) and, unless it is too
//! long, one check of its legs.

mod lengths;
mod sequence;

use super::assembly::{self, AssemblyMove};
use super::strategy::poses_of;
use super::world::{BedPoses, CollisionWorld};
use super::{AssemblyStage, Leg, MicrorobotsStepMotion, RobotDocking, legs_ns};
use crate::claims::microrobots::{Dock, MicrorobotsOrder};
use crate::geometry::Pose;
use crate::plan::parallel;
use crate::plan::search::{Meter, SearchBudget};
use crate::random::SplitMix64;
use lengths::SolverTerms;
use sequence::{LegSequence, ShotSegment};
use std::f64::consts::TAU;

/// A part of the search.
#[derive(Debug, Clone, Copy)]
struct ShootingStage {
    /// Number of descents that are continued: those that did best.
    descents: usize,
    /// Rounds of each of them.
    rounds: usize,
    /// Price of each leg that meets something.
    collision_ns: f64,
}

const STAGES: [ShootingStage; 3] = [
    ShootingStage { descents: 16, rounds: 500, collision_ns: 1.5e9 },
    ShootingStage { descents: 4, rounds: 1_500, collision_ns: 4e9 },
    ShootingStage { descents: 2, rounds: 3_000, collision_ns: 10e9 },
];

/// A round costs an expansion for this many legs × robots², the effort of its solution.
const EFFORT_OF_EXPANSION: usize = 200;

/// Sequences drawn at the beginning of a descent; the best of them is changed.
const DRAWS: usize = 20;

/// Greatest duration by which a change may worsen a plan, at the beginning of a stage.
const HEAT_NS: f64 = 4e9;

/// First rough solution, and the greatest miss with which it is worth going on.
const ROUGH: SolverTerms = SolverTerms { weight: 0.1, steps: 25, least_gain: 1e-2 };
const ROUGH_MISS_UM: f64 = 100.0;

/// A rough solution that is longer than allowed by this factor does not become short enough.
const ROUGH_EXCESS: f64 = 1.02;

/// Short solution, and the exact one beside it.
const SHORT: SolverTerms = SolverTerms { weight: 0.01, steps: 40, least_gain: 1e-3 };
const EXACT: SolverTerms = SolverTerms { weight: 0.0, steps: 12, least_gain: 1e-6 };

/// Greatest miss of an exact solution: the goals are solved for, and the precision is left to whole strokes.
const EXACT_MISS_UM: f64 = 0.05;

/// Share of the precision within which robots end. Errors of robots that dock at one another add up.
const NEAR_SHARE: f64 = 0.4;

/// What is asked for.
struct ShootingRequest<'a> {
    order: &'a MicrorobotsOrder,
    world: &'a CollisionWorld,
    bed: &'a BedPoses,
    docks: &'a [Dock],
    /// Goal of each robot of the order that has one and is not docked.
    goals: Vec<Option<Pose>>,
    /// Path of a stroke of the fastest robot.
    step_um: f64,
    /// Length of the longest full circle, measured as the lengths of legs are.
    circle_um: f64,
}

impl<'a> ShootingRequest<'a> {
    fn new(order: &'a MicrorobotsOrder, world: &'a CollisionWorld, bed: &'a BedPoses, docks: &'a [Dock]) -> Self {
        let goal = |robot: usize| docks.iter().find(|dock| dock.robot == robot && !bed.docked[robot]);
        let goals: Vec<Option<Pose>> = (0..world.count()).map(|robot| goal(robot).map(|dock| dock.goal.pose)).collect();
        let step_um = world.fastest_step_um(&bed.docked);
        let circles = (0..world.count()).filter(|robot| goals[*robot].is_some()).map(|robot| {
            let facts = order.robot(robot);
            TAU * facts.turning_radius_um * step_um / facts.step_um
        });
        let circle_um = circles.fold(0.0, f64::max);
        ShootingRequest { order, world, bed, docks, goals, step_um, circle_um }
    }

    /// Number of robots that have goals.
    fn robots(&self) -> usize {
        self.goals.iter().flatten().count()
    }
}

/// Search for an assembly in which all robots move at the same time.
pub struct ShootingSearch<'a> {
    request: ShootingRequest<'a>,
    dockings: Vec<AssemblyMove>,
    segments: Vec<ShotSegment>,
    known: Option<LegSequence>,
}

/// Legs with which every robot docks where it should.
#[derive(Debug, Clone)]
struct ShotPlan {
    sequence: LegSequence,
    legs: Vec<Leg>,
    docks: Vec<RobotDocking>,
    time_ns: f64,
    /// Number of legs that meet something.
    collisions: usize,
}

impl ShotPlan {
    /// Duration, and the price of its collisions.
    fn cost_ns(&self, collision_ns: f64) -> f64 {
        self.time_ns + collision_ns * self.collisions as f64
    }
}

/// A descent from one beginning.
#[derive(Debug, Clone)]
struct ShootingDescent {
    random: SplitMix64,
    now: Option<ShotPlan>,
    /// The best plan without collisions.
    best: Option<ShotPlan>,
}

impl<'a> ShootingSearch<'a> {
    /// Search for the assembly of robots with these goals; every second descent begins with a known plan, if there is
    /// one. `None` if no order of dockings leads to the end, or there is nothing to dock.
    pub fn new(
        order: &'a MicrorobotsOrder,
        world: &'a CollisionWorld,
        bed: &'a BedPoses,
        docks: &'a [Dock],
        known: Option<&MicrorobotsStepMotion>,
    ) -> Option<ShootingSearch<'a>> {
        let request = ShootingRequest::new(order, world, bed, docks);
        let dockings = match known {
            Some(known) => known.stages().iter().filter_map(docking_of).collect(),
            None => assembly::docking_order(order, bed, docks)?,
        };
        let robots: Vec<Vec<usize>> = dockings.iter().map(AssemblyMove::robots).collect();
        let segments = ShotSegment::all(world, &bed.docked, &robots)?;
        let known = match known {
            Some(MicrorobotsStepMotion::Legs { legs, docks, .. }) => {
                Some(LegSequence::of_plan(legs, docks, request.step_um))
                    .filter(|known| known.ends.len() == segments.len())
            }
            Some(MicrorobotsStepMotion::Wait(_)) | None => None,
        };
        (!segments.is_empty()).then_some(ShootingSearch { request, dockings, segments, known })
    }

    /// The fastest plan found.
    pub fn fastest(&self) -> Option<MicrorobotsStepMotion> {
        let known = self.known.as_ref().and_then(|known| self.judged(known.clone(), f64::INFINITY, 0.0));
        let beginning = |seed: usize| ShootingDescent {
            random: SplitMix64::stream(seed as u64, self.segments.len() as u64),
            now: known.clone().filter(|_| seed.is_multiple_of(2)),
            best: known.clone().filter(|known| seed.is_multiple_of(2) && known.collisions == 0),
        };
        let mut descents: Vec<ShootingDescent> = (0..STAGES[0].descents).map(beginning).collect();
        for stage in STAGES {
            let cost_ns = |descent: &ShootingDescent| descent.cost_ns(stage.collision_ns);
            descents.sort_by(|one, other| cost_ns(one).total_cmp(&cost_ns(other)));
            descents.truncate(stage.descents);
            let go_on = |descent: usize| self.continued(descents[descent].clone(), stage);
            descents = parallel::in_order(descents.len(), parallel::processors(), go_on);
        }
        let plans = descents.into_iter().filter_map(|descent| descent.best);
        plans.min_by(|one, other| one.time_ns.total_cmp(&other.time_ns)).map(|plan| self.motion(plan))
    }

    /// A descent after a stage.
    fn continued(&self, mut descent: ShootingDescent, stage: ShootingStage) -> ShootingDescent {
        let ShootingStage { descents, rounds, collision_ns } = stage;
        let expansions = self.request.order.expansions / (STAGES.len() * descents) as u64;
        let mut meter = Meter::new(SearchBudget::of(expansions));
        let mut draws = if descent.now.is_some() { 0 } else { DRAWS };
        for round in 0..rounds {
            if meter.step().is_none() {
                break;
            }
            let random = &mut descent.random;
            let sequence = match &descent.now {
                Some(now) if draws == 0 => now.sequence.varied(&self.segments, self.request.circle_um, random),
                Some(_) | None => LegSequence::drawn(&self.segments, random),
            };
            meter.charge((sequence.legs.len() * self.request.robots().pow(2) / EFFORT_OF_EXPANSION) as u64);
            draws = draws.saturating_sub(1);
            let cooled = 1.0 - round as f64 / rounds as f64;
            let allowed_ns = HEAT_NS * cooled * cooled * random.unit();
            let limit_ns = descent.now.as_ref().map_or(f64::INFINITY, |now| now.cost_ns(collision_ns) + allowed_ns);
            let Some(plan) = self.solved(sequence, limit_ns, collision_ns) else { continue };
            let is_best = || descent.best.as_ref().is_none_or(|best| plan.time_ns < best.time_ns);
            if plan.collisions == 0 && is_best() {
                descent.best = Some(plan.clone());
            }
            descent.now = Some(plan);
        }
        descent
    }

    /// The plan with the control states of a sequence and the lengths that solve it; `None` if it costs `limit_ns` or
    /// more, or there is none.
    fn solved(&self, mut sequence: LegSequence, limit_ns: f64, collision_ns: f64) -> Option<ShotPlan> {
        sequence.tidy(&self.segments);
        let lengths = sequence.lengths(&self.request, &self.segments);
        let mut roots = sequence.roots();
        if lengths.solve(&mut roots, ROUGH) > ROUGH_MISS_UM {
            return None;
        }
        sequence.set_roots(&roots);
        let strokes = sequence.length_um() / self.request.step_um;
        if strokes * self.request.order.facts.period_ns as f64 > limit_ns * ROUGH_EXCESS {
            return None;
        }
        lengths.solve(&mut roots, SHORT);
        if lengths.solve(&mut roots, EXACT) > EXACT_MISS_UM {
            return None;
        }
        sequence.set_roots(&roots);
        self.judged(sequence, limit_ns, collision_ns)
    }

    /// The plan of a sequence in whole strokes; `None` if it costs `limit_ns` or more, or does not dock as it should.
    fn judged(&self, sequence: LegSequence, limit_ns: f64, collision_ns: f64) -> Option<ShotPlan> {
        let ShootingRequest { order, world, bed, docks: goals, step_um, .. } = self.request;
        let (legs, docks) = sequence.in_strokes(&self.segments, step_um)?;
        let time_ns = legs_ns(order, &legs) as f64;
        if time_ns >= limit_ns {
            return None;
        }
        let ends = assembly::docked_poses(order, bed, goals, &legs, &docks)?;
        let miss = |dock: &Dock| assembly::miss(order.precision, ends[dock.robot], dock.goal.pose);
        if goals.iter().any(|dock| !bed.docked[dock.robot] && miss(dock) > NEAR_SHARE) {
            return None;
        }
        let collisions = bed.colliding_legs(world, &legs, &docks);
        let plan = ShotPlan { sequence, legs, docks, time_ns, collisions };
        (plan.cost_ns(collision_ns) < limit_ns).then_some(plan)
    }

    fn motion(&self, plan: ShotPlan) -> MicrorobotsStepMotion {
        let ShotPlan { legs, docks, .. } = plan;
        let stage = |docking: &AssemblyMove| {
            let goal = |robot: usize| self.request.goals[robot].unwrap_or(self.request.bed.poses[robot]);
            // The straight leg before the docking begins here.
            let approach = |robot: usize| {
                let last = docks.iter().find(|dock| dock.robot == robot).map_or(0, |dock| dock.leg);
                let way = poses_of(self.request.order, robot, self.request.bed.poses[robot], &legs[..last]);
                way.last().copied().unwrap_or(self.request.bed.poses[robot])
            };
            match *docking {
                AssemblyMove::Pair(assembly::Roles { first, second, states }) => AssemblyStage::Pair {
                    first,
                    second,
                    states,
                    intermediate: approach(first),
                    approach: [approach(first), approach(second)],
                    goals: [goal(first), goal(second)],
                    steered: Vec::new(),
                },
                AssemblyMove::Single { robot, states } => {
                    AssemblyStage::Single { robot, states, approach: approach(robot), goal: goal(robot) }
                }
            }
        };
        let stages = self.dockings.iter().map(stage).collect();
        MicrorobotsStepMotion::Legs { legs, docks, stages }
    }
}

impl ShootingDescent {
    /// Cost by which descents are compared.
    fn cost_ns(&self, collision_ns: f64) -> f64 {
        let plans = self.best.iter().chain(&self.now);
        plans.map(|plan| plan.cost_ns(collision_ns)).fold(f64::INFINITY, f64::min)
    }
}

/// The docking at the end of a stage.
fn docking_of(stage: &AssemblyStage) -> Option<AssemblyMove> {
    match *stage {
        AssemblyStage::Pair { first, second, states, .. } => {
            Some(AssemblyMove::Pair(assembly::Roles { first, second, states }))
        }
        AssemblyStage::Single { robot, states, .. } => Some(AssemblyMove::Single { robot, states }),
        AssemblyStage::Escort { .. } | AssemblyStage::BedLegs { .. } => None,
    }
}

#[cfg(test)]
mod tests;
