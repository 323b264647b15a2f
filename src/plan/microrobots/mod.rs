//! The planner of STRING microrobots: one voltage drives all robots, so that a plan is one sequence of control states, each
//! with a train of strokes, and every robot moves with every stroke.

pub mod assembly;
pub mod bound;
pub mod drive;
pub mod fine;
pub mod free;
pub mod guarantee;
mod job;
pub mod strategy;
pub mod strokes;
pub mod ways;
mod why;
pub mod world;

pub use job::{BedStandings as Standings, Crew, leg_ns, plan};

use crate::claims::microrobots::MicrorobotsOrder;
use crate::geometry::Pose;

/// What the bed does.
#[derive(Debug, Clone, PartialEq)]
pub struct MicrorobotsMotion {
    /// Where the robots are at first.
    pub start: Crew,
    /// One for each step of the order.
    pub steps: Vec<MicrorobotsStepMotion>,
}

/// What the bed does in one step of the task.
#[derive(Debug, Clone, PartialEq)]
pub enum MicrorobotsStepMotion {
    Legs {
        /// Each begins with the control cycle of its state; neighbours have different states.
        legs: Vec<Leg>,
        /// The robots that dock in this step, in order of time.
        docks: Vec<RobotDocking>,
        /// How robots were brought together, for `simulate`: in order of time; empty but for `assemble`.
        stages: Vec<AssemblyStage>,
    },
    /// In nanoseconds.
    Wait(u64),
}

/// A control state and the strokes that are driven in it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Leg {
    /// Index of the order's states.
    pub state: usize,
    /// At least 1.
    pub strokes: u64,
}

impl Leg {
    /// Where it carries a robot of the order that has not docked.
    pub fn carried(self, order: &MicrorobotsOrder, robot: usize, pose: Pose) -> Pose {
        let facts = order.robot(robot);
        let arm = order.states[self.state].arms[order.robots[robot].row];
        facts.moved(pose, arm, facts.step_um * self.strokes as f64)
    }
}

/// A robot that comes to its goal and stays there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RobotDocking {
    /// Index of the order's robots.
    pub robot: usize,
    /// It moves no more after this leg of the step.
    pub leg: usize,
}

/// A stage of an assembly.
#[derive(Debug, Clone, PartialEq)]
pub enum AssemblyStage {
    /// Before a [`AssemblyStage::Pair`], of its second robot: it is driven to where it orbits while the first one is driven, and `beside`,
    /// the first one, runs straight meanwhile (it may turn while `robot` does).
    Escort {
        robot: usize,
        beside: usize,
        /// As those of the pair: both turn, only `robot` turns, none of the two turns.
        states: [usize; 3],
        /// Where `robot` begins to orbit.
        to: Pose,
    },
    /// The first two robots, of the paper's two stages: `first` is driven while `second` orbits; then `second` is driven while
    /// `first` runs straight; then both come to their goals in a fine motion of three primitives.
    Pair {
        first: usize,
        second: usize,
        /// Indices of the control states in which both turn, only `second` turns, and none of the two turns.
        states: [usize; 3],
        /// Where `first` is when its own driving ends.
        intermediate: Pose,
        /// Where both are when the fine motion begins, `first` before `second`.
        approach: [Pose; 2],
        goals: [Pose; 2],
    },
    /// One robot to the structure, while those that are not docked orbit.
    Single {
        robot: usize,
        /// Indices of the control states in which it turns and runs straight.
        states: [usize; 2],
        /// Where it is when the fine motion begins.
        approach: Pose,
        goal: Pose,
    },
}
