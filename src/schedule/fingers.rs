//! States of a hand, and the turns and orientations that its steps reach.

use super::cost::{Costed, count_of, proof, rounded};
use super::reached::{Reached, Reaching};
use super::{KindState, PlanRecord, State};
use crate::claims::fingers::{FingersAction, FingersOrder};
use crate::device::fingers::{FingersOutcome, Plane};
use crate::quantity::count;
use nalgebra::{Quaternion, UnitQuaternion};
use serde::{Deserialize, Serialize};

/// Grasp of a hand, and the pose of its part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FingersState {
    /// The contact that each finger holds, from 1; 0 for a free finger.
    pub grasp: Vec<u32>,
    /// Angle of the current turn in steps, from 1 at its beginning as in the paper; below 1 where the part is turned
    /// back.
    pub angle_index: i64,
    /// The plane in which the fingers hold.
    pub plane: Plane,
    /// The centre of each holding tip, in the hand's frame.
    pub tips_um: Vec<Option<[f64; 3]>>,
    /// Position of the part's origin in the hand's frame.
    pub position_um: [f64; 3],
    /// The part's orientation in the hand's frame as a unit quaternion w, x, y, z, with w not negative.
    pub orientation: [f64; 4],
}

impl KindState for FingersState {
    fn floats(&self) -> Vec<f64> {
        let tips = self.tips_um.iter().flatten().flatten();
        tips.chain(&self.position_um).chain(&self.orientation).copied().collect()
    }
}

impl Reaching for FingersOrder {
    fn reached(&self, nth: usize, end: &State) -> Vec<Reached> {
        match self.steps.get(nth).map(|step| &step.action) {
            Some(FingersAction::Rotate { plane, steps, angle_rad }) => {
                let Some(section) = self.part.section(*plane) else { return Vec::new() };
                let reached_rad = f64::from(*steps) * section.step_rad;
                let axis = match plane {
                    Plane::Xy => "z",
                    Plane::Xz => "y",
                };
                let [asked_deg, reached_deg] = [*angle_rad, reached_rad].map(f64::to_degrees);
                let off_deg = reached_deg - asked_deg;
                vec![Reached::Turn { axis: axis.to_owned(), asked_deg, reached_deg, off_deg }]
            }
            Some(FingersAction::Orient { goal, .. }) => {
                let State::Fingers(FingersState { orientation, .. }) = end else { return Vec::new() };
                let [asked, reached] = [goal, orientation]
                    .map(|[w, x, y, z]| UnitQuaternion::from_quaternion(Quaternion::new(*w, *x, *y, *z)));
                let off_deg = asked.angle_to(&reached).to_degrees();
                vec![Reached::Orientation { asked: *goal, reached: *orientation, off_deg }]
            }
            Some(
                FingersAction::Grasp(_) | FingersAction::Translate(_) | FingersAction::Release | FingersAction::Wait(_),
            )
            | None => Vec::new(),
        }
    }
}

impl Costed for FingersOrder {
    /// `2300 deg in 8 reconfigurations, optimal (bound 2300 deg)`.
    fn cost(&self, plan: &PlanRecord) -> String {
        let figure = |degrees: f64| format!("{} deg", rounded(degrees));
        let reconfigurations = count_of(plan, FingersOutcome::Reconfigurations.name()) as usize;
        format!("{} in {}, {}", figure(plan.cost), count(reconfigurations, "reconfiguration"), proof(plan, figure))
    }
}
