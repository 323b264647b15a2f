//! Planner of STRING microrobots. One voltage drives all robots, so a plan is one sequence of control states, each with
//! a train of strokes, and every robot moves with every stroke.

pub mod assembly;
pub mod bound;
pub mod collision_proof;
pub mod confinement;
pub mod control;
#[cfg(test)]
mod disc_oracle;
pub mod drive;
pub mod fine;
pub mod free;
pub mod guarantee;
mod guarantee_trials;
mod initial_leg_changes;
pub mod initial_leg_search;
pub mod initial_leg_tree;
pub mod initial_legs;
mod job;
pub mod paths;
pub mod reliability;
pub mod shooting;
pub mod simulation;
mod steps;
pub mod strategy;
pub mod strokes;
mod why;
pub mod world;

pub use job::{BedStandings as Standings, plan};

use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::MicrorobotsObjective;
use crate::geometry::Pose;

/// Motion of the bed.
#[derive(Debug, Clone, PartialEq)]
pub struct MicrorobotsMotion {
    /// Initial state of the robots.
    pub start: Crew,
    /// One for each step of the order.
    pub steps: Vec<MicrorobotsStepMotion>,
}

/// Motion of the bed in one step of the task.
#[derive(Debug, Clone, PartialEq)]
pub enum MicrorobotsStepMotion {
    Legs {
        /// Each begins with the control cycle of its state; consecutive legs have different states.
        legs: Vec<Leg>,
        /// The robots that dock in this step, in order of time.
        docks: Vec<RobotDocking>,
        /// The stages that brought robots together, in order of time, for `simulate`; empty except for `assemble`.
        stages: Vec<AssemblyStage>,
    },
    /// Duration in nanoseconds.
    Wait(u64),
}

/// Poses of the robots of a bed, one entry per robot of its orders.
#[derive(Debug, Clone, PartialEq)]
pub struct Crew {
    pub poses: Vec<Pose>,
    /// Whether each robot is docked and so no longer moves.
    pub docked: Vec<bool>,
}

impl Crew {
    /// Moves all robots through a leg, given with its index within the step; some may dock at its end.
    pub fn follow(&mut self, order: &MicrorobotsOrder, index: usize, leg: &Leg, docks: &[RobotDocking]) {
        for robot in (0..self.poses.len()).filter(|robot| !self.docked[*robot]) {
            self.poses[robot] = leg.carried(order, robot, self.poses[robot]);
        }
        docks.iter().filter(|dock| dock.leg == index).for_each(|dock| self.docked[dock.robot] = true);
    }
}

/// A control state and the strokes driven in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Leg {
    /// Index into the order's states.
    pub state: usize,
    /// At least 1.
    pub strokes: u64,
}

impl Leg {
    /// Pose to which it carries an undocked robot of the order.
    pub fn carried(self, order: &MicrorobotsOrder, robot: usize, pose: Pose) -> Pose {
        let facts = order.robot(robot);
        let arm = order.states[self.state].arms[order.robots[robot].row];
        facts.moved(pose, arm, facts.step_um * self.strokes as f64)
    }
}

impl MicrorobotsStepMotion {
    /// Its legs; none while it waits.
    pub fn legs(&self) -> &[Leg] {
        match self {
            MicrorobotsStepMotion::Legs { legs, .. } => legs,
            MicrorobotsStepMotion::Wait(_) => &[],
        }
    }

    /// Its stages; none unless it assembles.
    pub fn stages(&self) -> &[AssemblyStage] {
        match self {
            MicrorobotsStepMotion::Legs { stages, .. } => stages,
            MicrorobotsStepMotion::Wait(_) => &[],
        }
    }

    /// Duration in nanoseconds.
    pub fn duration_ns(&self, order: &MicrorobotsOrder) -> u64 {
        match self {
            MicrorobotsStepMotion::Legs { legs, .. } => legs_ns(order, legs),
            MicrorobotsStepMotion::Wait(duration_ns) => *duration_ns,
        }
    }
}

impl MicrorobotsMotion {
    /// Duration of all steps in nanoseconds.
    pub fn duration_ns(&self, order: &MicrorobotsOrder) -> u64 {
        self.steps.iter().map(|step| step.duration_ns(order)).fold(0, u64::saturating_add)
    }

    /// Strokes of all steps.
    pub fn strokes(&self) -> u64 {
        let legs = self.steps.iter().flat_map(MicrorobotsStepMotion::legs);
        legs.map(|leg| leg.strokes).fold(0, u64::saturating_add)
    }
}

/// Duration of legs, including their control cycles.
pub fn legs_ns(order: &MicrorobotsOrder, legs: &[Leg]) -> u64 {
    legs.iter().map(|leg| leg_ns(order, *leg)).fold(0, u64::saturating_add)
}

/// Cost of the legs of a step: the objective's figure, then the other one to break ties. For the failures objective,
/// plans are searched by duration.
pub fn legs_cost(order: &MicrorobotsOrder, legs: &[Leg]) -> [u64; 2] {
    let (time_ns, switches) = (legs_ns(order, legs), legs.len() as u64);
    match order.objective {
        MicrorobotsObjective::Time | MicrorobotsObjective::Failures => [time_ns, switches],
        MicrorobotsObjective::Switches => [switches, time_ns],
    }
}

/// Duration of a leg: its control cycle, then its strokes.
pub fn leg_ns(order: &MicrorobotsOrder, leg: Leg) -> u64 {
    let cycle_ns = order.states[leg.state].levels_v.len() as u64 * order.facts.dwell_ns;
    cycle_ns.saturating_add(leg.strokes.saturating_mul(order.facts.period_ns))
}

/// A robot that reaches its goal and stays there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RobotDocking {
    /// Index into the order's robots.
    pub robot: usize,
    /// Leg of the step after which it no longer moves.
    pub leg: usize,
}

/// A stage of an assembly.
#[derive(Debug, Clone, PartialEq)]
pub enum AssemblyStage {
    /// Before the first robots dock, or between dockings: `legs` legs move the whole bed, so that the robots stand
    /// better.
    BedLegs { legs: usize },
    /// Precedes an [`AssemblyStage::Pair`] and concerns its second robot, `robot`: it is driven to the place where it
    /// will orbit while the first one is driven. The first one, `beside`, meanwhile runs straight; it may turn while
    /// `robot` turns.
    Escort {
        robot: usize,
        beside: usize,
        /// As in the pair: both turn, only `robot` turns, neither turns.
        states: [usize; 3],
        /// Pose at which `robot` begins to orbit.
        to: Pose,
    },
    /// The first two robots, in the paper's two stages: `first` is driven while `second` orbits; then `second` is
    /// driven while `first` runs straight; then both reach their goals in a fine motion of three primitives.
    Pair {
        first: usize,
        second: usize,
        /// Indices of the control states in which both turn, only `second` turns, and neither turns.
        states: [usize; 3],
        /// Pose of `first` at the end of its own drive.
        intermediate: Pose,
        /// Poses at the start of the fine motion, `first` before `second`.
        approach: [Pose; 2],
        goals: [Pose; 2],
        /// Legs from the start of the stage that drive the robots as the closed loop does, which takes its paths from
        /// them; empty if the stage's own legs do.
        steered: Vec<Leg>,
    },
    /// One robot docks with the structure, while those that are not docked orbit.
    Single {
        robot: usize,
        /// Indices of the control states in which it turns and runs straight.
        states: [usize; 2],
        /// Pose at the start of the fine motion.
        approach: Pose,
        goal: Pose,
    },
}
