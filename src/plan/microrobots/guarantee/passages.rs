//! Passages: where bodies come near to one another in a plan that is carried out as written.
//!
//! Method: conservative advancement. Between two samples no body moves farther than the distance deducted at the first
//! one.

use super::outline::WrittenPlan;
use crate::device::microrobots::Arm;
use crate::geometry::distance::quadrilateral_core;
use crate::geometry::{Core, Pose};
use crate::plan::microrobots::strategy::{BodyCorners, body, obstacles};

/// Bodies farther apart than this are not examined closely.
pub const FAR_UM: f64 = 50.0;

/// Least motion between two samples, and its share of the distance of near bodies.
const SAMPLE_STEP_UM: f64 = 0.5;
const SAMPLE_STEP_SHARE: f64 = 0.05;

/// Most samples of one plan.
const MAX_SAMPLES: u32 = 3_000_000;

/// A robot near to an obstacle or to another robot in a leg.
pub struct Passage {
    pub leg: usize,
    pub robot: usize,
    /// The other robot; `None` for an obstacle.
    pub other: Option<usize>,
    /// Lower bound on their distance in the leg.
    pub least_um: f64,
}

/// A stretch of a leg in which two bodies are near to one another.
#[derive(Clone, Copy)]
pub struct NearStretch {
    /// Strokes of the leg at its beginning and end.
    pub strokes: [f64; 2],
    /// Lower bound on the distance of the bodies.
    pub least_um: f64,
}

/// Budget of distance samples.
pub struct SampleBudget(u32);

impl SampleBudget {
    pub fn new() -> Self {
        SampleBudget(MAX_SAMPLES)
    }

    /// The stretches of a leg in which two bodies are nearer than [`FAR_UM`]; `None` if the budget runs out.
    /// `distance_um` takes the strokes since the leg began; no point of a body moves faster against the other body than
    /// `rate_um` per stroke.
    pub fn stretches(
        &mut self,
        strokes: u64,
        rate_um: f64,
        distance_um: impl Fn(f64) -> f64,
    ) -> Option<Vec<NearStretch>> {
        let (all, mut at, mut found) = (strokes as f64, 0.0, Vec::new());
        while at < all {
            self.0 = self.0.checked_sub(1)?;
            let has_um = distance_um(at);
            let moved_um = (has_um - FAR_UM).max(SAMPLE_STEP_SHARE * has_um).max(SAMPLE_STEP_UM);
            let next = (at + moved_um / rate_um).min(all);
            let least_um = has_um - moved_um;
            if least_um < FAR_UM && has_um < FAR_UM + SAMPLE_STEP_UM {
                found.push(NearStretch { strokes: [at, next], least_um });
            }
            at = next;
        }
        Some(found)
    }
}

impl WrittenPlan<'_> {
    fn arm(&self, robot: usize, leg: usize) -> Arm {
        self.order.states[self.legs[leg].state].arms[self.order.robots[robot].row]
    }

    /// Pose of a robot after some strokes of a leg.
    pub fn pose(&self, robot: usize, leg: usize, strokes: f64) -> Pose {
        let before = self.poses[leg][robot];
        if !self.moves(robot, leg) {
            return before;
        }
        let facts = self.order.robot(robot);
        facts.moved(before, self.arm(robot, leg), facts.step_um * strokes)
    }

    /// Bound on the path of any point of a robot's body per stroke of a leg.
    fn rate_um(&self, robot: usize, leg: usize) -> f64 {
        let facts = self.order.robot(robot);
        match self.arm(robot, leg) {
            Arm::Up if self.moves(robot, leg) => facts.step_um,
            Arm::Down if self.moves(robot, leg) => {
                facts.step_um * (facts.orbit_reach_um() / facts.turning_radius_um).max(1.0)
            }
            Arm::Up | Arm::Down => 0.0,
        }
    }

    fn body(&self, robot: usize, leg: usize, strokes: f64) -> BodyCorners {
        body(self.order.robot(robot), self.pose(robot, leg, strokes), 0.0)
    }

    /// The stretches of a leg in which two robots are near to one another.
    pub fn near(&self, budget: &mut SampleBudget, [robot, other]: [usize; 2], leg: usize) -> Option<Vec<NearStretch>> {
        let rate_um = self.rate_um(robot, leg) + self.rate_um(other, leg);
        budget.stretches(self.legs[leg].strokes, rate_um, |strokes| {
            apart_um(&self.body(robot, leg, strokes), &self.body(other, leg, strokes))
        })
    }
}

/// Distance of two bodies; where they are far apart, a lower bound beyond [`FAR_UM`].
pub fn apart_um(one: &BodyCorners, other: &BodyCorners) -> f64 {
    let [middle, other_middle] = [one, other].map(|body| nalgebra::center(&body[0], &body[2]));
    let reach_um = [one, other].map(|body| (body[2] - body[0]).norm() / 2.0).iter().sum::<f64>();
    let least_um = (middle - other_middle).norm() - reach_um;
    if least_um > FAR_UM { least_um } else { quadrilateral_core(*one, &Core::Polygon(other.to_vec())) }
}

/// All passages of a plan, apart from those of robots and the partners with which they dock; `None` if the budget runs
/// out.
pub fn passages(plan: &WrittenPlan, are_docking: impl Fn([usize; 2], usize) -> bool) -> Option<Vec<Passage>> {
    let (solids, mut budget, mut found) = (obstacles(plan.order), SampleBudget::new(), Vec::new());
    let least_um =
        |stretches: Vec<NearStretch>| stretches.iter().map(|stretch| stretch.least_um).min_by(f64::total_cmp);
    for leg in 0..plan.legs.len() {
        for robot in 0..plan.docks.len() {
            for other in (0..robot).filter(|other| plan.moves(robot, leg) || plan.moves(*other, leg)) {
                if are_docking([robot, other], leg) {
                    continue;
                }
                let near = least_um(plan.near(&mut budget, [robot, other], leg)?);
                found.extend(near.map(|least_um| Passage { leg, robot, other: Some(other), least_um }));
            }
            for solid in solids.iter().filter(|_| plan.moves(robot, leg)) {
                let distance_um = |strokes: f64| solid.distance_um(&plan.body(robot, leg, strokes), FAR_UM);
                let near = budget.stretches(plan.legs[leg].strokes, plan.rate_um(robot, leg), distance_um)?;
                found.extend(least_um(near).map(|least_um| Passage { leg, robot, other: None, least_um }));
            }
        }
    }
    Some(found)
}
