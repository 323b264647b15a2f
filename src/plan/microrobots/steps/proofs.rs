//! Proofs that a step has no plan, from the current poses of the robots.
//!
//! They hold only if every plan has the robots there before the step. The cheap ones are tried first.

use super::super::bound::together::{self, RobotArrival};
use super::super::collision_proof::CollisionQuestion;
use super::super::confinement::{ConfinementQuestion, PathEnd, RESOLUTIONS};
use super::super::free::PoseWithin;
use super::super::world::BedPoses;
use super::BedStepPlanner;
use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsStop};
use crate::diagnostic::Diagnostic;

/// How much a proof may cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ProofEffort {
    /// Some milliseconds.
    Quick,
    /// Up to some seconds.
    Thorough,
}

impl BedStepPlanner<'_> {
    /// The report of a proof that robots do not reach these goals, given in order; `None` if none was found. A thorough
    /// one does not repeat what a quick one tries.
    pub fn no_plan(&self, goals: &[(usize, &MicrorobotsStop)], effort: ProofEffort) -> Option<Diagnostic> {
        let docked = &self.bed.docked;
        let moving: Vec<usize> = (0..self.world.count()).filter(|robot| self.is_given && !docked[*robot]).collect();
        let alone = || moving.iter().find_map(|robot| self.inevitable_collision(&[*robot], goals));
        let confined = || moving.iter().find_map(|robot| self.confined(*robot, goals, effort));
        let together = || (moving.len() > 1).then(|| self.inevitable_collision(&moving, goals)).flatten();
        match effort {
            ProofEffort::Quick => alone().or_else(confined),
            ProofEffort::Thorough => confined().or_else(together),
        }
    }

    /// The report of collisions of these robots one of which happens before the step can end, whatever states are
    /// driven.
    fn inevitable_collision(&self, robots: &[usize], goals: &[(usize, &MicrorobotsStop)]) -> Option<Diagnostic> {
        let strokes = robots.iter().map(|robot| self.least_strokes(*robot, goals)).min()?;
        // In a drive all robots keep apart.
        let keep_apart = !matches!(self.step.action, MicrorobotsAction::Assemble(_));
        let question =
            CollisionQuestion { world: self.world, bed: self.bed, robots, keep_apart, needed: strokes as f64 };
        Some(self.why().inevitable_collision(&question.inevitable()?, strokes))
    }

    /// The report of a robot that obstacles confine to where it is, or whose first goal they shut off.
    fn confined(&self, robot: usize, goals: &[(usize, &MicrorobotsStop)], effort: ProofEffort) -> Option<Diagnostic> {
        let resolutions = match effort {
            ProofEffort::Quick => &RESOLUTIONS[..1],
            ProofEffort::Thorough => &RESOLUTIONS[1..],
        };
        let (world, strokes) = (self.world, self.least_strokes(robot, goals));
        let near = PoseWithin { pose: self.bed.poses[robot], slack: together::EXACT };
        let needed_um = world.way_um(robot, strokes);
        let start = ConfinementQuestion { world, robot, near, end: PathEnd::Start, needed_um };
        let goal = goals.iter().find(|goal| goal.0 == robot);
        let found = start.confinement(resolutions).or_else(|| {
            let goal = goal?;
            let near = PoseWithin { pose: goal.1.pose, slack: self.order.precision };
            let needed_um = world.way_um(robot, self.alone(goal));
            ConfinementQuestion { world, robot, near, end: PathEnd::Goal, needed_um }.confinement(resolutions)
        });
        let goal = goal.map_or(self.step.span, |goal| goal.1.span);
        Some(self.why().confined(&found?, goal, needed_um))
    }

    /// Fewest strokes for which a robot moves: up to its own goals or, without any, until the others are at theirs.
    fn least_strokes(&self, robot: usize, goals: &[(usize, &MicrorobotsStop)]) -> u64 {
        let BedPoses { poses, docked, .. } = self.bed;
        let all = goals.iter().filter(|goal| !docked[goal.0]);
        if let Some(own) = all.clone().filter(|goal| goal.0 == robot).map(|goal| self.alone(goal)).max() {
            return own;
        }
        match self.step.action {
            MicrorobotsAction::Assemble(_) => {
                let arrival =
                    |goal: &(usize, &MicrorobotsStop)| RobotArrival::of(self.order, goal.0, poses[goal.0], goal.1.pose);
                together::least_strokes(self.order, all.map(arrival).collect())
            }
            // A robot does not stay at its stops, so each is bounded alone.
            MicrorobotsAction::Drive { .. } | MicrorobotsAction::Apply { .. } | MicrorobotsAction::Wait(_) => {
                all.map(|goal| self.alone(goal)).max().unwrap_or(0)
            }
        }
    }

    /// Fewest strokes in which a robot alone reaches a goal.
    fn alone(&self, goal: &(usize, &MicrorobotsStop)) -> u64 {
        let arrival = RobotArrival::of(self.order, goal.0, self.bed.poses[goal.0], goal.1.pose);
        together::least_strokes(self.order, vec![arrival])
    }
}
