//! The errors with which a plan that is carried out as written surely assembles its robots.
//!
//! Input: an order, and a motion. Output: by how much the errors of the device may be multiplied so that every robot still docks,
//! whatever the robots do within them. Guaranteed, since no feedback is relied upon: the bounds hold for errors that change at any
//! instant, and they close as the errors go to 0. Not guaranteed: that larger errors make it fail; the closed loop bears many times
//! as much, of which nothing is proven. Cost: distances of all bodies every half micrometre where they are near to one another.
//!
//! Method. A robot is followed by the centre of its orbit and by its heading (`stray`). While its arm is down the centre only creeps;
//! while it is up the centre follows the heading. All robots receive the same strokes, so errors never put them out of step. Bodies
//! that keep apart in the plan keep apart as long as their distance (`passages`) exceeds what both may stray. Robots that dock meet
//! their partner a little before the end of their legs, or later, since a robot whose arm is up runs on with the legs that follow
//! (`dockings`); then they must be within the limits of sticking and self-alignment, and the structure is displaced by as much.

use super::dockings::{Docked, PlannedDocking, displaced, dockings};
use super::passages::{FAR_UM, Passage, passages};
use super::stray::Stray;
use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder, MicrorobotsStep};
use crate::device::microrobots::Errors;
use crate::geometry::Pose;
use crate::plan::microrobots::{Leg, MicrorobotsMotion, MicrorobotsStepMotion};

/// Largest multiple of the errors that is looked for.
const MAX_MULTIPLE: f64 = 1024.0;

/// Halvings of the interval in which the largest multiple lies.
const HALVINGS: usize = 40;

/// Most legs of a plan that is looked at.
const MAX_LEGS: usize = 20_000;

/// A plan as it is carried out without corrections.
pub struct WrittenPlan<'a> {
    pub order: &'a MicrorobotsOrder,
    /// Legs of all steps in order of time.
    pub legs: Vec<Leg>,
    /// Nominal poses of all robots before each leg, and after the last one.
    pub poses: Vec<Vec<Pose>>,
    /// By robot: the leg after which it stands, if it docks.
    pub docks: Vec<Option<usize>>,
    passages: Vec<Passage>,
    pub dockings: Vec<PlannedDocking>,
}

impl<'a> WrittenPlan<'a> {
    /// Without its passages and dockings. `None` where robots are driven in closed loop, where they do not begin where the scene has
    /// them, but where an earlier task left them, or where the plan is too long to be looked at.
    fn outline(order: &'a MicrorobotsOrder, motion: &MicrorobotsMotion) -> Option<Self> {
        let is_driven = |step: &MicrorobotsStep| matches!(step.action, MicrorobotsAction::Drive { .. });
        let is_at_start = |(robot, pose): (usize, &Pose)| order.robots[robot].pose == *pose;
        let is_measured = motion.start.poses.iter().enumerate().all(is_at_start);
        if order.steps.iter().any(is_driven) || motion.start.docked.contains(&true) || !is_measured {
            return None;
        }
        let mut crew = motion.start.clone();
        let docks = vec![None; crew.poses.len()];
        let poses = vec![crew.poses.clone()];
        let (passages, dockings) = (Vec::new(), Vec::new());
        let mut plan = WrittenPlan { order, legs: Vec::new(), poses, docks, passages, dockings };
        for step in &motion.steps {
            let MicrorobotsStepMotion::Legs { legs, docks, .. } = step else { continue };
            if docks.iter().any(|dock| dock.leg >= legs.len()) || plan.legs.len() + legs.len() > MAX_LEGS {
                return None;
            }
            docks.iter().for_each(|dock| plan.docks[dock.robot] = Some(plan.legs.len() + dock.leg));
            for (index, leg) in legs.iter().enumerate() {
                crew.follow(order, (index, leg), docks);
                plan.legs.push(*leg);
                plan.poses.push(crew.poses.clone());
            }
        }
        Some(plan)
    }

    /// Looks at all that may touch; `None` where that is too much, or where a robot docks with nothing that surely stops it.
    fn looked_at(mut self, motion: &MicrorobotsMotion) -> Option<Self> {
        let stages: Vec<_> = motion.steps.iter().flat_map(MicrorobotsStepMotion::stages).collect();
        self.dockings = dockings(&self, &stages)?;
        self.passages = passages(&self)?;
        (!self.dockings.is_empty()).then_some(self)
    }

    /// Whether a robot moves in a leg.
    pub fn moves(&self, robot: usize, leg: usize) -> bool {
        self.docks[robot].is_none_or(|last| leg <= last)
    }

    /// Bounds on how far each robot is from the plan before each leg, and after the last one, with errors.
    pub fn strays(&self, errors: &Errors) -> Vec<Vec<Stray>> {
        let begin = |robot: usize| Stray::measured(self.order.robot(robot), errors);
        let mut now: Vec<Stray> = (0..self.docks.len()).map(begin).collect();
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

    /// Whether a robot that docks is at the end of its legs farther from its place than the controller accepts, without any look.
    fn is_hopeless(&self, errors: &Errors) -> bool {
        let most_um = self.order.facts.docking.tolerance_um.max(self.order.precision.place_um);
        let strays = self.strays(errors);
        let off_um = |robot: usize, leg: usize| strays[leg + 1][robot].place_um(self.order.robot(robot));
        (0..self.docks.len()).any(|robot| self.docks[robot].is_some_and(|leg| off_um(robot, leg) > most_um))
    }

    /// Path on which the last robots are pushed on, so that they surely touch, with errors; `None` where success is not certain.
    fn pushed_um(&self, errors: &Errors) -> Option<f64> {
        let strays = self.strays(errors);
        let mut standing: Vec<Option<Docked>> = vec![None; self.docks.len()];
        let mut structure = None;
        for docking in &self.dockings {
            displaced(self, docking, (&strays[docking.leg + 1], errors), (&mut standing, &mut structure))?;
        }
        let pushed_um = self.last_push_um(&standing)?;
        let strays_um = |robot: usize, leg: usize| {
            let body_um = strays[leg + 1][robot].body_um(self.order.robot(robot));
            match standing[robot] {
                Some(docked) if !self.moves(robot, leg) => docked.body_um,
                // It may be stopped already.
                Some(docked) if leg >= docked.from_leg => body_um + docked.early_um,
                None if leg + 1 == self.legs.len() => body_um + self.swung(robot) * pushed_um,
                Some(_) | None => body_um,
            }
        };
        let is_clear = |passage: &Passage| {
            let other_um = passage.other.map_or(0.0, |other| strays_um(other, passage.leg));
            strays_um(passage.robot, passage.leg) + other_um < passage.least_um
        };
        let is_near = |robot: usize| (0..self.legs.len()).all(|leg| strays_um(robot, leg) < FAR_UM / 2.0);
        let is_sure = (0..self.docks.len()).all(is_near) && self.passages.iter().all(is_clear);
        is_sure.then_some(pushed_um)
    }

    /// Most by which a point of a robot that is not docked moves for each micrometre on which others are pushed.
    fn swung(&self, robot: usize) -> f64 {
        let facts = self.order.robot(robot);
        let steps_um = (0..self.docks.len()).map(|other| self.order.robot(other).step_um);
        let faster = facts.step_um / steps_um.fold(f64::INFINITY, f64::min);
        faster * (facts.orbit_reach_um() / facts.turning_radius_um).max(1.0)
    }

    /// The push after the last leg; `None` if robots that are late might not have come to their places before the next ones do.
    fn last_push_um(&self, standing: &[Option<Docked>]) -> Option<f64> {
        for (at, docking) in self.dockings.iter().enumerate() {
            let docked = standing[docking.robots.first()?.0]?;
            let facts = self.order.robot(docking.robots[0].0);
            let next = self.dockings.get(at + 1);
            if next.is_none() && docking.leg + 1 == self.legs.len() {
                return Some(docked.late_um);
            }
            let last = next.map_or(self.legs.len(), |next| next.leg + 1);
            let early_um = next.and_then(|next| standing[next.robots.first()?.0]).map_or(0.0, |next| next.early_um);
            let strokes: u64 = self.legs[docking.leg + 1..last].iter().map(|leg| leg.strokes).sum();
            if facts.step_um * strokes as f64 - early_um < docked.late_um {
                return None;
            }
        }
        Some(0.0)
    }
}

/// By how much the errors of the device may be multiplied so that the plan as written surely succeeds: 0 where nothing is known, at
/// most [`MAX_MULTIPLE`].
pub fn borne(order: &MicrorobotsOrder, motion: &MicrorobotsMotion) -> f64 {
    let plan = WrittenPlan::outline(order, motion).and_then(|plan| plan.looked_at(motion));
    let Some((plan, errors)) = plan.zip(order.facts.errors) else { return 0.0 };
    let is_sure = |multiple: f64| plan.pushed_um(&scaled(&errors, multiple)).is_some();
    let (mut low, mut high) = (0.0, 1.0);
    while is_sure(high) {
        if high >= MAX_MULTIPLE {
            return MAX_MULTIPLE;
        }
        (low, high) = (high, 2.0 * high);
    }
    for _ in 0..HALVINGS {
        let middle = f64::midpoint(low, high);
        if is_sure(middle) { low = middle } else { high = middle }
    }
    low
}

/// The path of the last push if the errors of the device are such that the plan is carried out as it is written; `None` if it is not.
pub fn carried_out_as_written(order: &MicrorobotsOrder, motion: &MicrorobotsMotion) -> Option<f64> {
    let errors = order.facts.errors?;
    if errors.are_zero() {
        return Some(0.0);
    }
    let plan = WrittenPlan::outline(order, motion)?;
    if plan.is_hopeless(&errors) {
        return None;
    }
    plan.looked_at(motion)?.pushed_um(&errors)
}

/// Errors multiplied.
pub fn scaled(errors: &Errors, multiple: f64) -> Errors {
    Errors {
        speed_ratio: errors.speed_ratio * multiple,
        turning_rad_per_um: errors.turning_rad_per_um * multiple,
        place_um: errors.place_um * multiple,
        heading_rad: errors.heading_rad * multiple,
        replan_ns: errors.replan_ns,
    }
}
