//! States of a bed of microrobots, and the poses that its steps reach.

pub mod control;

use super::cost::{Costed, count_of, proof, rounded};
use super::reached::{Reached, Reaching};
use super::{KindState, PlanRecord, State};
use crate::claims::microrobots::{MicrorobotsAction, MicrorobotsOrder};
use crate::device::microrobots::{MicrorobotsObjective, MicrorobotsOutcome};
use crate::geometry::Pose;
use crate::quantity::count;
use crate::real::Real;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// State of a bed when a leg begins.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MicrorobotsState {
    /// Index of the control state of the leg.
    pub control: usize,
    /// Arms during the leg, in the order of the table: 1 for an arm that is down.
    pub arms: Vec<u8>,
    /// The robots that are docked in a structure and no longer move, sorted by name.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub docked: Vec<String>,
    /// The pose of each robot on the bed, by its name.
    pub poses: BTreeMap<String, RecordedPose>,
}

/// A measured or planned pose of the centre of a robot's body, in the coordinates of the scene.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "an object with `x_um`, `y_um` and `heading_deg`, or null")]
pub struct RecordedPose {
    pub x_um: f64,
    pub y_um: f64,
    /// From +x, counter-clockwise, as in `pose(…)`.
    pub heading_deg: f64,
}

impl RecordedPose {
    pub fn heading_rad(&self) -> f64 {
        self.heading_deg.to_radians()
    }

    pub fn pose(&self) -> Pose {
        Pose { x_um: self.x_um, y_um: self.y_um, heading_rad: self.heading_rad() }
    }
}

impl From<Pose> for RecordedPose {
    fn from(Pose { x_um, y_um, heading_rad }: Pose) -> RecordedPose {
        RecordedPose { x_um, y_um, heading_deg: heading_rad.to_degrees() }
    }
}

impl KindState for MicrorobotsState {
    fn floats(&self) -> Vec<f64> {
        self.poses.values().flat_map(|pose| [pose.x_um, pose.y_um, pose.heading_deg]).collect()
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
            let Pose { x_um, y_um, heading_rad } = poses.get(&robot)?.pose();
            let off_rad = (heading_rad - goal.heading_rad + PI).rem_euclid(TAU) - PI;
            Some(Reached::Pose {
                robot,
                asked_um: [goal.x_um, goal.y_um],
                reached_um: [x_um, y_um],
                off_um: (x_um - goal.x_um).hypotenuse(y_um - goal.y_um),
                asked_deg: goal.heading_rad.to_degrees(),
                // The heading in the same turn as the goal's, lest 359 deg look far from 1 deg.
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
        let time = seconds(plan.duration_ns as f64 / 1e9);
        let switched = switches(count_of(plan, MicrorobotsOutcome::Switches.name()));
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
