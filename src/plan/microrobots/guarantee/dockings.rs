//! Dockings of a plan that is carried out as written: when robots touch, and whether they then stick in their places.

use super::outline::WrittenPlan;
use super::passages::{NearStretch, SampleBudget, apart_um};
use super::stray::StrayBound;
use crate::device::microrobots::{Errors, wrapped_rad};
use crate::geometry::Pose;
use crate::plan::microrobots::AssemblyStage;
use crate::plan::microrobots::strategy::{StrategySolid, body, edge_gap_um};
use crate::real::Real;

/// Factor on sums of small distances that covers second-order terms of angles up to [`STEEPEST_RAD`].
const SECOND_ORDER: f64 = 1.2;

/// Greatest angle at which such sums are used.
const STEEPEST_RAD: f64 = 0.3;

/// Two robots that meet, or one that comes to docked ones.
pub struct PlannedDocking {
    /// Each with its goal.
    pub robots: Vec<(usize, Pose)>,
    /// The leg after which they stand still.
    pub leg: usize,
    /// The first leg in which the partners of this docking may touch each other.
    first_leg: usize,
    /// The docked robots that a single one faces; empty for two robots that meet.
    partners: Vec<usize>,
    /// Gap between the robots and their partners at the end of the legs.
    gap_um: f64,
    near: Vec<DockingStretch>,
}

/// A stretch in which robots that dock are near to their partners.
struct DockingStretch {
    leg: usize,
    least_um: f64,
    /// Longest remaining path of any of the robots.
    left_um: f64,
    /// By robot: lateral offset of the middle of its front, and offset of its heading, from the goal's.
    aside_um: [f64; 2],
    tilt_rad: [f64; 2],
}

/// A robot that has docked.
#[derive(Debug, Clone, Copy)]
pub struct Docked {
    /// Bound on the displacement of any point of its body.
    pub body_um: f64,
    /// Bounds on the path by which it is stopped early, and by which it runs on after the end of its legs.
    pub early_um: f64,
    pub late_um: f64,
    /// The first leg in which it may be stopped.
    pub from_leg: usize,
}

/// Bound on the displacement of the structure from its planned place.
#[derive(Debug, Clone, Copy)]
pub struct StructureOffset {
    middle_um: [f64; 2],
    place_um: f64,
    tilt_rad: f64,
}

impl StructureOffset {
    fn of_um(&self, pose: Pose) -> f64 {
        let [x_um, y_um] = self.middle_um;
        self.place_um + self.tilt_rad * (pose.x_um - x_um).hypotenuse(pose.y_um - y_um)
    }
}

impl PlannedDocking {
    /// Whether this docking brings two robots together, and this leg belongs to it.
    pub fn brings_together(&self, robots: [usize; 2], leg: usize) -> bool {
        let docks = |robot: usize| self.robots.iter().any(|(other, _)| *other == robot);
        let is_in = |robot: usize| docks(robot) || self.partners.contains(&robot);
        let is_time = self.first_leg <= leg && leg <= self.leg;
        is_time && robots.into_iter().all(is_in) && robots.into_iter().any(docks)
    }
}

/// The dockings of a plan in order of time; `None` if a robot docks where nothing certainly stops it.
pub fn dockings(plan: &WrittenPlan, stages: &[&AssemblyStage]) -> Option<Vec<PlannedDocking>> {
    let mut budget = SampleBudget::new();
    let mut found = Vec::new();
    for stage in stages {
        let robots = match **stage {
            AssemblyStage::Pair { first, second, goals, .. } => vec![(first, goals[0]), (second, goals[1])],
            AssemblyStage::Single { robot, goal, .. } => vec![(robot, goal)],
            AssemblyStage::BedLegs { .. } | AssemblyStage::Escort { .. } => continue,
        };
        found.push(docking(plan, robots, &mut budget)?);
    }
    Some(found)
}

fn docking(plan: &WrittenPlan, robots: Vec<(usize, Pose)>, budget: &mut SampleBudget) -> Option<PlannedDocking> {
    let leg = plan.docks[robots.first()?.0]?;
    if robots.iter().any(|(robot, _)| plan.docks[*robot] != Some(leg)) {
        return None;
    }
    let partners = if robots.len() == 1 { faced(plan, robots[0].0, leg) } else { Vec::new() };
    let stands = partners.iter().filter_map(|partner| plan.docks[*partner]).max();
    let first_leg = stands.map_or(0, |last| last + 1);
    let others: Vec<usize> = robots.iter().skip(1).map(|(robot, _)| *robot).chain(partners.iter().copied()).collect();
    let end = |robot: usize| body(plan.order.robot(robot), plan.poses[leg + 1][robot], 0.0);
    let gaps_um = others.iter().map(|other| apart_um(&end(robots[0].0), &end(*other)));
    let gap_um = gaps_um.min_by(f64::total_cmp)?.max(0.0);
    let mut found = PlannedDocking { robots, leg, first_leg, partners, gap_um, near: Vec::new() };
    let mut left_strokes = 0.0;
    for at in (first_leg..=leg).rev() {
        let strokes = plan.legs[at].strokes as f64;
        for other in &others {
            for stretch in plan.near(budget, [found.robots[0].0, *other], at)? {
                let stretch = found.stretch(plan, at, stretch, left_strokes + strokes - stretch.strokes[0]);
                found.near.push(stretch);
            }
        }
        left_strokes += strokes;
    }
    let last = NearStretch { strokes: [plan.legs[leg].strokes as f64; 2], least_um: f64::NEG_INFINITY };
    let last = found.stretch(plan, leg, last, 0.0);
    found.near.push(last);
    Some(found)
}

/// The docked robots that a robot faces at the end of its legs.
fn faced(plan: &WrittenPlan, robot: usize, leg: usize) -> Vec<usize> {
    let tolerance_um = plan.order.facts.docking.tolerance_um + 1e-6;
    let poses = &plan.poses[leg + 1];
    let is_faced = |other: &usize| {
        let bodies = [(plan.order.robot(*other), poses[*other])];
        edge_gap_um(plan.order.robot(robot), poses[robot], &bodies, tolerance_um).is_some()
    };
    let docked = (0..poses.len()).filter(|other| plan.docks[*other].is_some_and(|last| last < leg));
    docked.filter(is_faced).collect()
}

impl PlannedDocking {
    fn stretch(&self, plan: &WrittenPlan, leg: usize, near: NearStretch, left_strokes: f64) -> DockingStretch {
        let step_um = self.robots.iter().map(|(robot, _)| plan.order.robot(*robot).step_um).fold(0.0, f64::max);
        let (mut aside_um, mut tilt_rad) = ([0.0_f64; 2], [0.0_f64; 2]);
        for (nth, (robot, goal)) in self.robots.iter().enumerate() {
            for strokes in near.strokes {
                let pose = plan.pose(*robot, leg, strokes);
                let [aside, tilt] = off_goal(plan.order.robot(*robot).length_um, pose, *goal);
                (aside_um[nth], tilt_rad[nth]) = (aside_um[nth].max(aside), tilt_rad[nth].max(tilt));
            }
        }
        DockingStretch { leg, least_um: near.least_um, left_um: step_um * left_strokes, aside_um, tilt_rad }
    }

    /// Stretches in which the robots may touch their partners, if these come nearer than planned by `needs_um`.
    fn touching(&self, needs_um: f64) -> impl Iterator<Item = &DockingStretch> {
        self.near.iter().filter(move |stretch| stretch.least_um <= needs_um)
    }

    /// Whether a robot that runs on certainly meets something, though both may be off by `off_um` together.
    fn is_met(&self, plan: &WrittenPlan, off_um: f64) -> bool {
        let (robot, facts) = (self.robots[0].0, plan.order.robot(self.robots[0].0));
        let end = plan.poses[self.leg + 1][robot];
        let (sin, cos) = end.heading_rad.sine_cosine();
        let on_um = 2.0 * off_um + self.gap_um;
        let ahead = Pose { x_um: end.x_um + on_um * cos, y_um: end.y_um + on_um * sin, ..end };
        let core = body(facts, ahead, off_um);
        let others = self.robots.iter().skip(1).map(|(other, _)| other).chain(&self.partners);
        let standing =
            |other: &usize| StrategySolid::standing(plan.order.robot(*other), plan.poses[self.leg + 1][*other]);
        others.map(standing).any(|solid| solid.is_ahead(facts, end) && solid.distance_um(&core, 0.0) <= 0.0)
    }
}

/// Lateral offset of the middle of a robot's front from its goal's axis, and offset of its heading.
fn off_goal(length_um: f64, pose: Pose, goal: Pose) -> [f64; 2] {
    let (sin, cos) = goal.heading_rad.sine_cosine();
    let tilt_rad = wrapped_rad(pose.heading_rad - goal.heading_rad);
    let aside_um = (pose.y_um - goal.y_um) * cos - (pose.x_um - goal.x_um) * sin + length_um / 2.0 * tilt_rad.sine();
    [aside_um.abs(), tilt_rad.abs()]
}

/// Displacement of the robots of a docking, and of the structure with them, once they touch.
struct DockingContact {
    early_um: f64,
    late_um: f64,
    from_leg: usize,
    /// Bound on the distance of any of their fronts from where it is planned at the same instant.
    nose_um: f64,
    /// By robot: bounds on the offset of its front from its axis and of its heading, relative to the plan.
    aside_um: [f64; 2],
    tilt_rad: [f64; 2],
}

/// Applies a docking of robots that stray: records their displacement, and that of the structure if it begins with
/// them. `None` if they might not stick in their places.
pub fn displaced(
    plan: &WrittenPlan,
    docking: &PlannedDocking,
    strays: &[StrayBound],
    errors: &Errors,
    standing: &mut [Option<Docked>],
    structure: &mut Option<StructureOffset>,
) -> Option<()> {
    let robots: Vec<usize> = docking.robots.iter().map(|(robot, _)| *robot).collect();
    let bodies_um: f64 = robots.iter().map(|robot| strays[*robot].body_um(plan.order.robot(*robot))).sum();
    let mut partners_um = docking.partners.iter().map(|partner| standing[*partner].map(|docked| docked.body_um));
    let partner_um = partners_um.try_fold(0.0_f64, |most_um, body_um| Some(most_um.max(body_um?)))?;
    let contact = contact(plan, docking, strays, errors, bodies_um + partner_um)?;
    let off_um = if robots.len() == 1 {
        single(plan, docking, &contact, (*structure)?, partner_um)?
    } else {
        let begun = pair(plan, docking, &contact)?;
        *structure = Some(begun);
        begun.place_um + begun.tilt_rad * plan.order.robot(robots[0]).length_um
    };
    let docking_facts = plan.order.facts.docking;
    let most_um = docking_facts.tolerance_um.max(plan.order.precision.place_um);
    for robot in robots {
        let (facts, stray) = (plan.order.robot(robot), &strays[robot]);
        // Offset that the controller may measure at the end of the legs.
        if off_um.max(stray.place_um(facts) + plan.order.precision.place_um) > most_um {
            return None;
        }
        standing[robot] = Some(Docked {
            // A late robot runs straight from its place at the end of its legs to where it docks.
            body_um: off_um.max(stray.body_um(facts)) + contact.tilt_rad[0] * facts.width_um,
            early_um: contact.early_um,
            late_um: contact.late_um,
            from_leg: contact.from_leg,
        });
    }
    Some(())
}

fn contact(
    plan: &WrittenPlan,
    docking: &PlannedDocking,
    strays: &[StrayBound],
    errors: &Errors,
    needs_um: f64,
) -> Option<DockingContact> {
    let off_um = SECOND_ORDER * needs_um;
    if !docking.is_met(plan, off_um) {
        return None;
    }
    let late_um = SECOND_ORDER * (3.0 * off_um + docking.gap_um);
    let bent_rad = errors.turning_rad_per_um * late_um * (1.0 + errors.speed_ratio);
    let touching = || docking.touching(needs_um);
    let mut contact = DockingContact {
        early_um: touching().map(|stretch| stretch.left_um).fold(0.0, f64::max),
        late_um,
        from_leg: touching().map(|stretch| stretch.leg).min()?,
        nose_um: 0.0,
        aside_um: [0.0; 2],
        tilt_rad: [0.0; 2],
    };
    for (nth, (robot, _)) in docking.robots.iter().enumerate() {
        let (facts, stray) = (plan.order.robot(*robot), &strays[*robot]);
        let tilt_rad =
            touching().map(|stretch| stretch.tilt_rad[nth]).fold(0.0, f64::max) + stray.heading_rad + bent_rad;
        let aside_um = touching().map(|stretch| stretch.aside_um[nth]).fold(0.0, f64::max);
        contact.tilt_rad[nth] = tilt_rad;
        contact.nose_um = contact.nose_um.max(stray.nose_um(facts) + late_um * bent_rad);
        // A corner that touches first moves the front sideways as the body turns until it lies flat.
        contact.aside_um[nth] =
            aside_um + stray.nose_um(facts) + late_um * tilt_rad + facts.width_um / 4.0 * tilt_rad * tilt_rad;
    }
    contact.tilt_rad.iter().all(|tilt_rad| *tilt_rad <= STEEPEST_RAD).then_some(contact)
}

/// Displacement of one robot that lies flat against its structure.
fn single(
    plan: &WrittenPlan,
    docking: &PlannedDocking,
    contact: &DockingContact,
    structure: StructureOffset,
    partner_um: f64,
) -> Option<f64> {
    let (robot, goal) = docking.robots[0];
    let (facts, limits) = (plan.order.robot(robot), plan.order.facts.docking);
    let half_um = facts.length_um.hypotenuse(facts.width_um) / 2.0;
    let moved_um = structure.of_um(goal) + structure.tilt_rad * half_um;
    let aside_um = contact.aside_um[0] + moved_um;
    let tilt_rad = contact.tilt_rad[0] + structure.tilt_rad;
    let sticks = tilt_rad <= limits.sticking_rad.min(STEEPEST_RAD) && aside_um <= limits.tolerance_um;
    sticks.then_some(aside_um + partner_um + docking.gap_um + structure.tilt_rad * half_um)
}

/// Displacement of the structure that two robots begin; `None` if they might not align themselves.
fn pair(plan: &WrittenPlan, docking: &PlannedDocking, contact: &DockingContact) -> Option<StructureOffset> {
    let limits = plan.order.facts.docking;
    let facts = plan.order.robot(docking.robots[0].0);
    let between_rad = contact.tilt_rad[0] + contact.tilt_rad[1];
    let across_um = contact.aside_um[0] + contact.aside_um[1] + facts.width_um * between_rad;
    if between_rad > limits.self_aligning_rad.min(STEEPEST_RAD) || across_um > limits.self_aligning_um {
        return None;
    }
    let [one, other] = [docking.robots[0].1, docking.robots[1].1];
    // Both run towards each other, so they meet between the planned and the actual places of their fronts: with the
    // signed offsets s and t of these along the axis and the speeds v and w, at (w s - v t) / (v + w).
    let along_um = SECOND_ORDER * contact.nose_um + docking.gap_um + facts.width_um * between_rad;
    Some(StructureOffset {
        middle_um: [f64::midpoint(one.x_um, other.x_um), f64::midpoint(one.y_um, other.y_um)],
        place_um: contact.aside_um[0].max(contact.aside_um[1]).hypotenuse(along_um),
        tilt_rad: between_rad,
    })
}
