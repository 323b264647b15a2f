//! Errors that a plan certainly tolerates (`written`), and estimates of what may keep the closed-loop strategy from
//! bringing robots to their goals, with the errors at their bounds.
//!
//! Input of the estimates: an order whose device states its errors, and a plan. Output: for each stage of an assembly
//! the containments on which success rests, each with the required and the available value. No promise: these are
//! estimates. Of 76 tasks in which all containments held, trials of `simulate` failed in 14 (up to 4.5 % of the
//! trials), so a stage is never called guaranteed because of them; they show what to examine first. A stage in which
//! one does not hold may well succeed nearly always.
//!
//! Method: the forward projection of the gross motion is the cylinder about the approach ([`SteeringModel::cylinder`]);
//! it must lie in the preimage of the goal under the fine motion (`fine`), that is, within the reach of its curvatures
//! on both sides, less the share that the errors of all intervals may consume. The error at contact is that of the last
//! measurement and of the path after it. The goal region is enlarged by compliance: any angle within the docking limits
//! is accepted. The paths themselves, with all possible deviations of the robots, must stay clear of everything
//! (`room`); this test replaces the paper's C_O. Source: the paper's section 3.4, with the ranges of the three
//! primitives assigned to the correct robots.

mod dockings;
mod fine;
pub mod message;
mod outline;
mod pair;
mod passages;
mod room;
mod stray;
mod written;

pub use written::{carried_out_as_written, scaled, tolerated_multiple};

use super::strategy::{Episode, GoalFrame, SteeringModel, StrategySolid, edge_gap_um, episodes, obstacles};
use super::{AssemblyStage, MicrorobotsMotion};
use crate::claims::microrobots::MicrorobotsOrder;
use crate::geometry::Pose;
use crate::real::Real;
use room::{GrossMotion, Surroundings};

/// The kind of a containment.
#[derive(Debug, Clone, PartialEq)]
pub enum ContainmentCheck {
    /// The cylinder about the approach in the preimage of the fine motion: its radius, and the correctable radius; in
    /// micrometres.
    Cone,
    /// Lateral offset at which the robot may come to rest, and the docking tolerance; in micrometres.
    Place,
    /// Angle between heading and the normal of the edge at contact, and its limit; in radians.
    Angle,
    /// Offset between the axes of two robots that meet, and the limit of self-alignment; in micrometres.
    Axes,
    /// Angle between the directions of two robots that meet, and the limit of self-alignment; in radians.
    Directions,
    /// Deviation of the robot in gross motion, and the room to the thing of this name; in micrometres.
    Gross(String),
    /// The same in fine motion.
    Fine(String),
    /// An edge must lie ahead of the robot at its goal: 1 is required, and this many exist.
    Edge,
    /// Angle that a turn of a robot needs so that no circle is driven, and its actual angle; in radians.
    Turn,
    /// Timing error between two robots, as a distance, and its limit; in micrometres.
    Meeting,
}

/// A containment: it holds if the required value is at most the available one.
#[derive(Debug, Clone, PartialEq)]
pub struct Containment {
    /// Index into the order's robots.
    pub robot: usize,
    pub check: ContainmentCheck,
    pub needs: f64,
    pub has: f64,
}

/// The containments of a stage.
#[derive(Debug, Clone, PartialEq)]
pub struct StageContainments {
    /// Index into the order's steps.
    pub step: usize,
    /// Indices of the driven robots, into the order's robots.
    pub robots: Vec<usize>,
    pub containments: Vec<Containment>,
}

impl Containment {
    /// Available minus required, in micrometres or radians; negative if it does not hold.
    pub fn margin(&self) -> f64 {
        self.has - self.needs
    }
}

impl StageContainments {
    /// The first containment that does not hold. If there is none, the stage is still not guaranteed: these are
    /// estimates.
    pub fn violated(&self) -> Option<&Containment> {
        // A margin of NaN does not hold.
        self.containments.iter().find(|containment| containment.margin().is_nan() || containment.margin() < 0.0)
    }
}

/// Estimates for the stages of a plan in order of time; `None` if the device does not state its errors.
pub fn estimated_containments(order: &MicrorobotsOrder, motion: &MicrorobotsMotion) -> Option<Vec<StageContainments>> {
    order.facts.errors?;
    let solids = obstacles(order);
    let mut structure = Displaced::default();
    let mut found = Vec::new();
    let mut last_step = None;
    for episode in &episodes(order, motion) {
        let is_first = last_step.replace(episode.step) != Some(episode.step);
        let bed = StageContext { order, episode, obstacles: &solids, is_first, structure };
        let containments = match episode.stage {
            AssemblyStage::Pair { .. } => pair::containments(&bed, &mut structure),
            AssemblyStage::Escort { .. } | AssemblyStage::BedLegs { .. } => continue,
            AssemblyStage::Single { robot, approach, goal, .. } => single(&bed, *robot, *approach, *goal),
        };
        let robots = super::strategy::driven(episode.stage).into_iter().map(|(robot, _)| robot).collect();
        found.push(StageContainments { step: episode.step, robots, containments: containments.unwrap_or_default() });
    }
    Some(found)
}

/// Possible displacement of the structure from its nominal pose.
#[derive(Debug, Clone, Copy, Default)]
struct Displaced {
    middle_um: [f64; 2],
    place_um: f64,
    heading_rad: f64,
}

impl Displaced {
    /// Possible displacement of a point that moves with the structure.
    fn of_um(&self, pose: Pose) -> f64 {
        let arm_um = (pose.x_um - self.middle_um[0]).hypotenuse(pose.y_um - self.middle_um[1]);
        self.place_um + self.heading_rad * arm_um
    }
}

/// A stage with its context.
struct StageContext<'a> {
    order: &'a MicrorobotsOrder,
    episode: &'a Episode<'a>,
    obstacles: &'a [StrategySolid],
    /// Whether it is the first stage of its step, so that the robots' poses on their orbits are known.
    is_first: bool,
    structure: Displaced,
}

impl StageContext<'_> {
    /// Surroundings of the driven robots: docked robots, and the discs of those that orbit.
    fn surroundings(&self, driven: &[usize]) -> Surroundings {
        let order = self.order;
        let mut around = Surroundings { free: self.obstacles.to_vec(), docked: Vec::new() };
        for (robot, &pose) in self.episode.poses.iter().enumerate().filter(|(robot, _)| !driven.contains(robot)) {
            let facts = order.robot(robot);
            if self.episode.docked[robot] {
                let stray_um = self.structure.of_um(pose)
                    + self.structure.heading_rad * facts.length_um.hypotenuse(facts.width_um) / 2.0
                    + order.facts.docking.tolerance_um;
                around.docked.push((StrategySolid::standing(facts, pose), stray_um));
            } else if let Some(model) = SteeringModel::new(order, robot) {
                around.free.push(StrategySolid::orbit(facts, pose, model.orbit_error_um()));
            }
        }
        around
    }

    fn gap_um(&self, robot: usize, goal: Pose) -> Option<f64> {
        let docked = (0..self.episode.poses.len()).filter(|other| self.episode.docked[*other]);
        let bodies: Vec<_> = docked.map(|other| (self.order.robot(other), self.episode.poses[other])).collect();
        edge_gap_um(self.order.robot(robot), goal, &bodies, self.order.facts.docking.tolerance_um + 1e-6)
    }
}

fn single(bed: &StageContext, robot: usize, approach: Pose, goal: Pose) -> Option<Vec<Containment>> {
    let model = SteeringModel::new(bed.order, robot)?;
    let cylinder = model.cylinder();
    let docking = bed.order.facts.docking;
    let held = |check: ContainmentCheck, needs: f64, has: f64| Containment { robot, check, needs, has };
    let gap_um = bed.gap_um(robot, goal);
    let mut found = vec![held(ContainmentCheck::Edge, 1.0, f64::from(u8::from(gap_um.is_some())))];
    let frame = GoalFrame::new(model.robot, goal, gap_um.unwrap_or(0.0));
    let region = fine::Region { cylinder, along_um: cylinder.radius_um };
    let bounds = fine::FineMotionBounds::new(&model, &frame, approach, region, [0.0, 1.0]);
    found.push(held(ContainmentCheck::Cone, cylinder.radius_um, bounds.reach_um));
    found.push(held(ContainmentCheck::Angle, bounds.incidence_rad, docking.sticking_rad));
    found.push(held(ContainmentCheck::Place, bounds.across_um, docking.tolerance_um));
    let around = bed.surroundings(&[robot]);
    let way = GrossMotion::new(bed, &model, robot, &bed.episode.via_um[0], approach);
    found.extend(way.tightest(&around).map(|(name, needs, has)| held(ContainmentCheck::Gross(name), needs, has)));
    let stretch = room::FineMotion { model: &model, frame: &frame, bounds: &bounds, approach, shift_um: way.shift_um };
    found.extend(stretch.tightest(&around).map(|(name, needs, has)| held(ContainmentCheck::Fine(name), needs, has)));
    Some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A containment with a margin below 0, or of NaN, does not hold; one with a margin of 0 does.
    #[test]
    fn a_containment_without_its_margin_is_violated() {
        let violated = |needs: f64, has: f64| {
            let holds = Containment { robot: 0, check: ContainmentCheck::Cone, needs: 1.0, has: 2.0 };
            let other = Containment { robot: 1, check: ContainmentCheck::Angle, needs, has };
            let stage = StageContainments { step: 0, robots: vec![0, 1], containments: vec![holds, other] };
            stage.violated().map(|containment| containment.robot)
        };
        assert_eq!(violated(1.0, 1.0), None);
        assert_eq!(violated(1.0, 1.0 - 1e-9), Some(1));
        assert_eq!(violated(f64::NAN, 1.0), Some(1));
    }
}
