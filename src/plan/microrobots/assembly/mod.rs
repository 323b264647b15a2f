//! Assembly: robots move to goals where they dock with one another, while waiting robots orbit.
//!
//! Problem: every robot moves with every stroke until it docks, and it docks only at a body that is docked or docks at
//! the same time. Method (the paper's sections 2 and 3): two robots meet first (`pair`); then one robot after the other
//! joins the structure (`single`); the remaining robots orbit all the while. Which robots go first, in which role and
//! in which order, is searched depth first over what the control states allow, with branch and bound. Each stage ends
//! with the paper's fine motion or, if the caller prefers fast plans or plans with few legs, without one
//! ([`PlannedFineMotions`]). Guaranteed: the result satisfies the collision rules ([`super::world`]), and every robot
//! ends within precision. Not guaranteed: the fastest assembly, or any where one exists. No [`StuckAssembly`] is a
//! proof: the search covers only assemblies in which robots that are neither docked nor steered orbit in place, whereas
//! robots might move away first, or run along. Cost: one plan per stage if the control table leaves one order, as
//! STRING tables do; at most [`MAX_PLANS`].

mod bed;
mod closing;
mod ground;
mod orders;
mod pair;
mod recognition;
mod roundabout;
mod single;
mod track;

use super::bound::together::{self, RobotArrival};
use super::world::{BedPoses, FirstCollision};
use super::{AssemblyStage, Leg, RobotDocking, legs_cost};
use crate::claims::microrobots::{Dock, MicrorobotsOrder};
use crate::device::microrobots::MicrorobotsObjective;
use crate::geometry::Pose;
use crate::plan::search::Meter;
use bed::{AssemblyState, StageAddition};
use ground::AssemblyGround;
use orders::Orders;

pub use orders::AssemblyMove;
pub use pair::Roles;
pub use track::miss;

/// Most stages planned in total, over all orders tried.
pub const MAX_PLANS: usize = 400;

/// Most stages planned after the first assembly was found, in search of a faster one.
pub const MAX_MORE_PLANS: usize = 24;

/// Fine motion with which a stage is planned to end. The controller makes its own from the measured poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlannedFineMotion {
    /// Cycles over 1/N of the device's length.
    OneIn(u64),
    /// None: the paths of two robots lead to their goals, that of a single one to a straight run over half of the
    /// device's length.
    LeftOut,
}

/// A single robot without a fine motion runs straight over 1/`STRAIGHT_PART` of the device's length of fine motion, so
/// that its path ends before the structure.
const STRAIGHT_PART: u64 = 2;

/// Fine motions of the stages of an assembly, preferred first.
#[derive(Debug, Clone, Copy)]
pub struct PlannedFineMotions {
    pub pair: &'static [PlannedFineMotion],
    pub single: &'static [PlannedFineMotion],
}

/// The whole fine motion, and shorter ones if that has no room.
const WITH: [PlannedFineMotion; 3] =
    [PlannedFineMotion::OneIn(1), PlannedFineMotion::OneIn(2), PlannedFineMotion::OneIn(4)];

/// No fine motion if that has room, since most legs and some of the path are those of the fine motion; otherwise as
/// `WITH`.
const WITHOUT: [PlannedFineMotion; 4] =
    [PlannedFineMotion::LeftOut, PlannedFineMotion::OneIn(1), PlannedFineMotion::OneIn(2), PlannedFineMotion::OneIn(4)];

/// Fine motions wherever robots dock.
pub const CYCLES: PlannedFineMotions = PlannedFineMotions { pair: &WITH, single: &WITH };

/// No fine motion where the first two robots meet, so that they may move at once.
pub const DIRECT_PAIR: PlannedFineMotions = PlannedFineMotions { pair: &WITHOUT, single: &WITH };

/// No fine motions at all.
pub const DIRECT: PlannedFineMotions = PlannedFineMotions { pair: &WITHOUT, single: &WITHOUT };

/// Terms of the search for an assembly.
#[derive(Debug, Clone, Copy)]
pub struct AssemblyTerms {
    pub fine: PlannedFineMotions,
    /// Most stages planned in total.
    pub most_stages: usize,
}

/// A planned assembly.
#[derive(Debug, Clone, PartialEq)]
pub struct Assembled {
    /// Consecutive legs have different states.
    pub legs: Vec<Leg>,
    pub docks: Vec<RobotDocking>,
    pub stages: Vec<AssemblyStage>,
    /// The objective's figure, then the other one.
    pub cost: [u64; 2],
}

/// Why no assembly was found. Robots are indices into the order's robots.
#[derive(Debug, Clone, PartialEq)]
pub enum StuckAssembly {
    /// No control states steer these robots (one, or the first two) while `orbiting` orbits; if that is `None`: while
    /// all others that are not docked orbit, and docked ones keep their arms up.
    Unsteerable { robots: Vec<usize>, orbiting: Option<usize> },
    /// This robot docks while the other one orbits, for at least a full turn by then, and its goal is too near to the
    /// orbit disc of the other; the gap is negative if it lies inside.
    GoalInOrbit { robot: usize, orbiting: usize, gap_um: f64 },
    /// At its goal the robot touches neither a docked body nor a reachable goal of another robot.
    Apart { robot: usize },
    /// All paths tried cause a collision; this is that of the last one.
    Blocked { robot: usize, partner: Option<usize>, hit: FirstCollision },
    /// No two paths tried bring both to their goals at the same time, with whole strokes within precision.
    Untimely { first: usize, second: usize },
    /// No path was found around obstacles, docked bodies and orbit discs; the shortest one is blocked by this.
    NoPath { robot: usize, blocker: RobotBlocker },
    /// The robot must orbit while others are driven, and has no room for it.
    NoOrbit { robot: usize, blocker: RobotBlocker },
    /// Whole strokes cannot bring the robot to its goal within precision.
    Coarse { robot: usize },
    /// The robot ends within the precision of its goal, but with a gap to its docking partner above the docking
    /// tolerance.
    Loose { robot: usize, gap_um: f64 },
    /// The budget is spent.
    GaveUp,
}

/// Obstruction of a robot's path or of its orbit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RobotBlocker {
    /// Index into the order's obstacles.
    Obstacle(usize),
    /// The orbit disc of this robot.
    Orbit(usize),
    /// The body of this docked robot.
    Docked(usize),
}

/// Plans an assembly. `poses` and `docked` describe its start, one entry per robot of the order, after a leg in control
/// state `state`, if any; the first leg has a different state. `docks` are of robots that are not docked. A step of the
/// meter is a candidate checked against the collision rules, or a path search. Stages are counted over all orders; each
/// ends with the first of the fine motions that has room.
pub fn assemble(
    order: &MicrorobotsOrder,
    poses: &[Pose],
    docked: &[bool],
    state: Option<usize>,
    docks: &[Dock],
    meter: &mut Meter,
    terms: AssemblyTerms,
) -> Result<Assembled, StuckAssembly> {
    let bed = AssemblyState::new(order, poses, docked, state);
    let orders = Orders { docks, others_orbit: true };
    if let Some(stuck) = orders.dead_end(&bed) {
        return Err(stuck);
    }
    let mut search = AssemblySearch {
        orders,
        ground: AssemblyGround::new(&bed, docks),
        meter,
        fine: terms.fine,
        best: None,
        stuck: None,
        plans: terms.most_stages,
    };
    search.descend(&bed);
    match (search.best, search.stuck) {
        (Some((cost, bed)), _) => Ok(Assembled { legs: bed.legs, docks: bed.docks, stages: bed.stages, cost }),
        (None, Some((_, stuck))) => Err(stuck),
        (None, None) => Err(StuckAssembly::GaveUp),
    }
}

/// The first order of dockings that leads to the end, by the control states and the contacts of goals.
pub fn docking_order(order: &MicrorobotsOrder, start: &BedPoses, docks: &[Dock]) -> Option<Vec<AssemblyMove>> {
    let orders = Orders { docks, others_orbit: false };
    let mut bed = AssemblyState::new(order, &start.poses, &start.docked, None);
    let mut found = Vec::new();
    while orders.open(&bed).next().is_some() {
        let step = orders.moves(&bed).into_iter().find(|step| orders.leads_on(&bed, step))?;
        orders.carry_out(&mut bed, &step);
        found.push(step);
    }
    Some(found)
}

/// Poses of the robots after the dockings of an assembly that starts from `start`; `None` if they do not dock after
/// these legs, or one of them earlier.
pub fn docked_poses(
    order: &MicrorobotsOrder,
    start: &BedPoses,
    docks: &[Dock],
    legs: &[Leg],
    planned: &[RobotDocking],
) -> Option<Vec<Pose>> {
    let mut bed = AssemblyState::new(order, &start.poses, &start.docked, None);
    for docking in planned.chunk_by(|one, other| one.leg == other.leg) {
        let end = docking[0].leg + 1;
        let stretch = StageAddition {
            legs: legs[bed.legs.len()..end].to_vec(),
            docking: docking.iter().map(|dock| dock.robot).collect(),
            stages: Vec::new(),
        };
        bed = bed.after(recognition::cut_at_docking(&bed, docks, stretch).ok()?);
        if bed.legs.len() < end {
            return None;
        }
    }
    Some(bed.poses)
}

/// Lower bound on the duration of an assembly of these robots: all their paths at once, without obstacles.
fn least_ns(bed: &AssemblyState, docks: &[Dock]) -> u64 {
    let facts = &bed.order.facts;
    let open = docks.iter().filter(|dock| !bed.docked[dock.robot]);
    let arrivals: Vec<RobotArrival> =
        open.map(|dock| RobotArrival::of(bed.order, dock.robot, bed.poses[dock.robot], dock.goal.pose)).collect();
    if arrivals.is_empty() {
        return 0;
    }
    let strokes = together::least_strokes(bed.order, arrivals);
    facts.period_ns.saturating_mul(strokes).saturating_add(facts.dwell_ns)
}

/// Search over docking orders.
struct AssemblySearch<'a, 'm> {
    orders: Orders<'a>,
    ground: AssemblyGround<'a>,
    meter: &'m mut Meter,
    /// Fine motions of a stage, preferred first.
    fine: PlannedFineMotions,
    /// The best assembly so far, and its cost.
    best: Option<([u64; 2], AssemblyState<'a>)>,
    /// Among the failures, the first one with the most robots docked.
    stuck: Option<(usize, StuckAssembly)>,
    /// Remaining number of stages that may be planned.
    plans: usize,
}

impl<'a> AssemblySearch<'a, '_> {
    /// Tries all orders from here on. The recursion is as deep as the number of robots to dock.
    fn descend(&mut self, bed: &AssemblyState<'a>) {
        let is_over = self.orders.open(bed).next().is_none();
        let cost = legs_cost(bed.order, &bed.legs);
        let least = match bed.order.objective {
            MicrorobotsObjective::Time | MicrorobotsObjective::Failures => least_ns(bed, self.orders.docks),
            MicrorobotsObjective::Switches => u64::from(!is_over),
        };
        if self.best.as_ref().is_some_and(|best| best.0 <= [cost[0].saturating_add(least), cost[1]]) {
            return;
        }
        if is_over {
            if let (Some(hit), Some(dock)) = (self.ground.any_collision(bed), bed.docks.last()) {
                return self.note(bed.docks.len(), StuckAssembly::Blocked { robot: dock.robot, partner: None, hit });
            }
            self.best = Some((cost, bed.clone()));
            self.plans = self.plans.min(MAX_MORE_PLANS);
            return;
        }
        let moves = self.orders.moves(bed).into_iter().filter(|step| self.orders.leads_on(bed, step));
        for step in moves.collect::<Vec<_>>() {
            if self.plans == 0 {
                return;
            }
            self.plans -= 1;
            match self.plan(bed, &step) {
                Ok(stretch) => self.descend(&bed.after(stretch)),
                Err(stuck) => self.note(bed.docks.len(), stuck),
            }
        }
    }

    fn plan(&mut self, bed: &AssemblyState<'a>, step: &AssemblyMove) -> Result<StageAddition, StuckAssembly> {
        match step {
            AssemblyMove::Pair(roles) => {
                let docks = [self.orders.dock(roles.first), self.orders.dock(roles.second)];
                pair::plan(bed, *roles, docks, self.fine.pair, &self.ground, self.meter)
            }
            AssemblyMove::Single { robot, states } => {
                single::plan(bed, self.orders.dock(*robot), *states, self.fine.single, &self.ground, self.meter)
            }
        }
    }

    fn note(&mut self, docked: usize, stuck: StuckAssembly) {
        if self.stuck.as_ref().is_none_or(|worst| worst.0 < docked) {
            self.stuck = Some((docked, stuck));
        }
    }
}

#[cfg(test)]
mod tests;
