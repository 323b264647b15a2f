//! A plan as carried out without corrections, and bounds on how far its robots may stray from it.

use super::stray::StrayBound;
use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder, MicrorobotsStep};
use crate::device::microrobots::Errors;
use crate::geometry::Pose;
use crate::plan::microrobots::{Leg, MicrorobotsMotion, MicrorobotsStepMotion};

/// Most legs of a plan that is inspected.
const MAX_LEGS: usize = 20_000;

/// A plan as it is carried out without corrections.
pub struct WrittenPlan<'a> {
    pub order: &'a MicrorobotsOrder,
    /// Legs of all steps in order of time.
    pub legs: Vec<Leg>,
    /// Nominal poses of all robots before each leg, and after the last one.
    pub poses: Vec<Vec<Pose>>,
    /// By robot: the leg after which it stands still, if it docks.
    pub docks: Vec<Option<usize>>,
}

impl<'a> WrittenPlan<'a> {
    /// `None` if robots are driven in closed loop, if any is docked already or begins where an earlier task left it
    /// instead of where the scene has it, or if the plan is too long to be inspected.
    pub fn of(order: &'a MicrorobotsOrder, motion: &MicrorobotsMotion) -> Option<Self> {
        let is_driven = |step: &MicrorobotsStep| matches!(step.action, MicrorobotsAction::Drive { .. });
        let is_at_start = |(robot, pose): (usize, &Pose)| order.robots[robot].pose == *pose;
        let is_measured = motion.start.poses.iter().enumerate().all(is_at_start);
        if order.steps.iter().any(is_driven) || motion.start.docked.contains(&true) || !is_measured {
            return None;
        }
        let mut crew = motion.start.clone();
        let docks = vec![None; crew.poses.len()];
        let poses = vec![crew.poses.clone()];
        let mut plan = WrittenPlan { order, legs: Vec::new(), poses, docks };
        for step in &motion.steps {
            let MicrorobotsStepMotion::Legs { legs, docks, .. } = step else { continue };
            if docks.iter().any(|dock| dock.leg >= legs.len()) || plan.legs.len() + legs.len() > MAX_LEGS {
                return None;
            }
            docks.iter().for_each(|dock| plan.docks[dock.robot] = Some(plan.legs.len() + dock.leg));
            for (index, leg) in legs.iter().enumerate() {
                crew.follow(order, index, leg, docks);
                plan.legs.push(*leg);
                plan.poses.push(crew.poses.clone());
            }
        }
        Some(plan)
    }

    /// Whether a robot moves in a leg.
    pub fn moves(&self, robot: usize, leg: usize) -> bool {
        self.docks[robot].is_none_or(|last| leg <= last)
    }

    /// Bounds on how far errors take each robot from the plan, before each leg and after the last one.
    pub fn strays(&self, errors: &Errors) -> Vec<Vec<StrayBound>> {
        let begin = |robot: usize| StrayBound::measured(self.order.robot(robot), errors);
        let mut now: Vec<StrayBound> = (0..self.docks.len()).map(begin).collect();
        let mut all = vec![now.clone()];
        for (at, leg) in self.legs.iter().enumerate() {
            for (robot, stray) in now.iter_mut().enumerate().filter(|(robot, _)| self.moves(*robot, at)) {
                let (facts, row) = (self.order.robot(robot), self.order.robots[robot].row);
                let arm = self.order.states[leg.state].arms[row];
                *stray = stray.after(facts, arm, facts.step_um * leg.strokes as f64, errors);
            }
            all.push(now.clone());
        }
        all
    }

    /// Whether some robot that docks may be farther from its place at the end of its legs than the controller accepts.
    /// Quick: it measures no distances of bodies.
    pub fn is_hopeless(&self, errors: &Errors) -> bool {
        let most_um = self.order.facts.docking.tolerance_um.max(self.order.precision.place_um);
        let strays = self.strays(errors);
        let off_um = |robot: usize, leg: usize| strays[leg + 1][robot].place_um(self.order.robot(robot));
        (0..self.docks.len()).any(|robot| self.docks[robot].is_some_and(|leg| off_um(robot, leg) > most_um))
    }
}
