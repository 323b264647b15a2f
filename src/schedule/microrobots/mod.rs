//! States of a bed of microrobots, and the poses that its steps reach.

pub mod control;

use super::cost::{Costed, count, figure_of, proof, rounded};
use super::reached::{Reached, Reaching};
use super::{KindState, PlanRecord, State};
use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder};
use crate::device::microrobots::{MicrorobotsObjective, MicrorobotsOutcome};
use crate::geometry::Pose;
use crate::real::Real;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// Where the robots of a bed stand as a leg begins.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MicrorobotsState {
    /// Index of the control state of the leg that begins here.
    pub control: usize,
    /// Of that leg, in the order of the table: 1 for an arm that is down.
    pub arms: Vec<u8>,
    /// The robots that stick in a structure and move no more, by name in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub docked: Vec<String>,
    /// Place in micrometres and heading in radians, as in `pose(…)`, of each robot on the bed, by its name.
    pub poses: BTreeMap<String, [f64; 3]>,
}

impl KindState for MicrorobotsState {
    fn floats(&self) -> Vec<f64> {
        self.poses.values().flatten().copied().collect()
    }
}

impl Reaching for MicrorobotsOrder {
    fn reached(&self, nth: usize, end: &State) -> Vec<Reached> {
        let goals: Vec<(usize, &Pose)> = match self.steps.get(nth).map(|step| &step.action) {
            Some(MicrorobotsAction::Drive { robot, stops }) => {
                stops.last().map(|stop| (*robot, &stop.pose)).into_iter().collect()
            }
            Some(MicrorobotsAction::Assemble(docks)) => {
                docks.iter().map(|dock| (dock.robot, &dock.goal.pose)).collect()
            }
            Some(MicrorobotsAction::Apply { .. } | MicrorobotsAction::Wait(_)) | None => Vec::new(),
        };
        let State::Microrobots(MicrorobotsState { poses, .. }) = end else { return Vec::new() };
        let pose = |(robot, goal): (usize, &Pose)| {
            let robot = self.robot(robot).name.clone();
            let [x_um, y_um, heading_rad] = *poses.get(&robot)?;
            let off_rad = (heading_rad - goal.heading_rad + PI).rem_euclid(TAU) - PI;
            Some(Reached::Pose {
                robot,
                asked_um: [goal.x_um, goal.y_um],
                reached_um: [x_um, y_um],
                off_um: (x_um - goal.x_um).hypotenuse(y_um - goal.y_um),
                asked_deg: goal.heading_rad.to_degrees(),
                // The turn of the goal, lest 359 deg look far from 1 deg.
                reached_deg: (goal.heading_rad + off_rad).to_degrees(),
                off_deg: off_rad.to_degrees(),
            })
        };
        goals.into_iter().filter_map(pose).collect()
    }
}

impl Costed for MicrorobotsOrder {
    /// `12.3 s in 9 switches, optimal (bound 12.3 s)`.
    fn cost(&self, plan: &PlanRecord) -> String {
        let seconds = |seconds: f64| format!("{} s", rounded(seconds));
        let switches = |number: f64| count(number as usize, "switch");
        let time = seconds(figure_of(plan, MicrorobotsOutcome::Time.name()));
        let switched = switches(figure_of(plan, MicrorobotsOutcome::Switches.name()));
        match self.objective {
            MicrorobotsObjective::Time => format!("{time} in {switched}, {}", proof(plan, seconds)),
            MicrorobotsObjective::Switches => format!("{switched} in {time}, {}", proof(plan, switches)),
            MicrorobotsObjective::Failures => {
                let share = rounded(plan.cost * 100.0);
                format!("{share} % of simulated trials fail, {time} in {switched}, not proven optimal")
            }
        }
    }
}
