//! The errors with which a plan that is carried out as written certainly assembles its robots.
//!
//! Input: an order, and a motion. Output: the factor by which the errors of the device may be multiplied so that every
//! robot still docks, whatever the robots do within them. Guaranteed, since no feedback is relied upon: the bounds hold
//! for errors that change at any instant, and they vanish as the errors go to 0. Not guaranteed: that larger errors
//! make the plan fail; the closed loop tolerates many times as much, but nothing is proven about that. Cost: distances
//! of all bodies every half micrometre where they are near to one another.
//!
//! Method: a robot is followed by the centre of its orbit and by its heading (`stray`). While its arm is down the
//! centre only creeps; while it is up the centre follows the heading. All robots receive the same strokes, so errors
//! never put them out of step. Bodies that keep apart in the plan keep apart as long as their distance (`passages`)
//! exceeds what both may stray. Robots that dock meet their partner a little before the end of their legs, or later,
//! since a robot whose arm is up runs on with the legs that follow (`dockings`). They must then be within the limits of
//! sticking and self-alignment, and the structure is displaced by as much.

use super::dockings::{Docked, PlannedDocking, displaced, dockings};
use super::outline::WrittenPlan;
use super::passages::{FAR_UM, Passage, passages};
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::Errors;
use crate::plan::microrobots::{MicrorobotsMotion, MicrorobotsStepMotion};

/// Largest multiple of the errors that is tried.
const MAX_MULTIPLE: f64 = 1024.0;

/// Halvings of the interval in which the largest multiple lies.
const HALVINGS: usize = 40;

/// A plan with everything that may touch in it.
struct InspectedPlan<'a> {
    plan: WrittenPlan<'a>,
    passages: Vec<Passage>,
    dockings: Vec<PlannedDocking>,
}

impl<'a> InspectedPlan<'a> {
    /// `None` if that is too much to inspect, if a robot docks with nothing that certainly stops it, or if none docks.
    fn of(plan: WrittenPlan<'a>, motion: &MicrorobotsMotion) -> Option<Self> {
        let stages: Vec<_> = motion.steps.iter().flat_map(MicrorobotsStepMotion::stages).collect();
        let dockings = dockings(&plan, &stages)?;
        let are_docking = |robots, leg| dockings.iter().any(|docking| docking.brings_together(robots, leg));
        let passages = passages(&plan, are_docking)?;
        (!dockings.is_empty()).then_some(InspectedPlan { plan, passages, dockings })
    }

    /// Path by which the last robots are pushed on so that they certainly touch, with these errors; `None` if success
    /// is not certain.
    fn pushed_um(&self, errors: &Errors) -> Option<f64> {
        let strays = self.plan.strays(errors);
        let mut standing: Vec<Option<Docked>> = vec![None; self.plan.docks.len()];
        let mut structure = None;
        for docking in &self.dockings {
            displaced(&self.plan, docking, &strays[docking.leg + 1], errors, &mut standing, &mut structure)?;
        }
        let pushed_um = self.last_push_um(&standing)?;
        let strays_um = |robot: usize, leg: usize| {
            let body_um = strays[leg + 1][robot].body_um(self.plan.order.robot(robot));
            match standing[robot] {
                Some(docked) if !self.plan.moves(robot, leg) => docked.body_um,
                // It may be stopped already.
                Some(docked) if leg >= docked.from_leg => body_um + docked.early_um,
                None if leg + 1 == self.plan.legs.len() => body_um + self.swung(robot) * pushed_um,
                Some(_) | None => body_um,
            }
        };
        let is_clear = |passage: &Passage| {
            let other_um = passage.other.map_or(0.0, |other| strays_um(other, passage.leg));
            strays_um(passage.robot, passage.leg) + other_um < passage.least_um
        };
        let is_near = |robot: usize| (0..self.plan.legs.len()).all(|leg| strays_um(robot, leg) < FAR_UM / 2.0);
        let is_sure = (0..self.plan.docks.len()).all(is_near) && self.passages.iter().all(is_clear);
        is_sure.then_some(pushed_um)
    }

    /// Most by which a point of a robot that is not docked moves per micrometre by which others are pushed.
    fn swung(&self, robot: usize) -> f64 {
        let facts = self.plan.order.robot(robot);
        let steps_um = (0..self.plan.docks.len()).map(|other| self.plan.order.robot(other).step_um);
        let faster = facts.step_um / steps_um.fold(f64::INFINITY, f64::min);
        faster * (facts.orbit_reach_um() / facts.turning_radius_um).max(1.0)
    }

    /// The push after the last leg; `None` if late robots might not have come to their places before the next ones do.
    fn last_push_um(&self, standing: &[Option<Docked>]) -> Option<f64> {
        for (at, docking) in self.dockings.iter().enumerate() {
            let docked = standing[docking.robots.first()?.0]?;
            let facts = self.plan.order.robot(docking.robots[0].0);
            let next = self.dockings.get(at + 1);
            if next.is_none() && docking.leg + 1 == self.plan.legs.len() {
                return Some(docked.late_um);
            }
            let last = next.map_or(self.plan.legs.len(), |next| next.leg + 1);
            let early_um = next.and_then(|next| standing[next.robots.first()?.0]).map_or(0.0, |next| next.early_um);
            let strokes: u64 = self.plan.legs[docking.leg + 1..last].iter().map(|leg| leg.strokes).sum();
            if facts.step_um * strokes as f64 - early_um < docked.late_um {
                return None;
            }
        }
        Some(0.0)
    }
}

/// Largest multiple of the device's errors with which the plan as written certainly succeeds: 0 if nothing is known, at
/// most `MAX_MULTIPLE`.
pub fn tolerated_multiple(order: &MicrorobotsOrder, motion: &MicrorobotsMotion) -> f64 {
    let plan = WrittenPlan::of(order, motion).and_then(|plan| InspectedPlan::of(plan, motion));
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

/// Path of the last push if the errors of the device are small enough to carry the plan out as written; `None`
/// otherwise.
pub fn carried_out_as_written(order: &MicrorobotsOrder, motion: &MicrorobotsMotion) -> Option<f64> {
    let errors = order.facts.errors?;
    if errors.are_zero() {
        return Some(0.0);
    }
    let plan = WrittenPlan::of(order, motion)?;
    if plan.is_hopeless(&errors) {
        return None;
    }
    InspectedPlan::of(plan, motion)?.pushed_um(&errors)
}

/// Errors multiplied; the interval between measurements stays.
pub fn scaled(errors: &Errors, multiple: f64) -> Errors {
    Errors {
        speed_ratio: errors.speed_ratio * multiple,
        turning_rad_per_um: errors.turning_rad_per_um * multiple,
        place_um: errors.place_um * multiple,
        heading_rad: errors.heading_rad * multiple,
        replan_ns: errors.replan_ns,
    }
}
