//! Values reached by a step, compared with its goals.
//!
//! Turns are whole steps, places are cells, robots stop after whole strokes: goals are seldom reached exactly.
//! Input: an order, the index of a step, the state at its end. Output: one [`Reached`] for each goal of the step that is given by
//! numbers and need not be met exactly. Cells, electrodes and contacts are met or not, and have none.

use super::State;
use crate::claims::Order;
use crate::claims::dimibot::{self, Asked, DimibotOrder};
use crate::claims::fingers::{self, FingersOrder};
use crate::claims::microrobots::{self, MicrorobotsOrder};
use crate::device::fingers::Plane;
use crate::geometry::Pose;
use crate::quantity::digits;
use crate::real::Real;
use nalgebra::{Quaternion, UnitQuaternion};
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// A numeric goal, and the value reached. The difference is reached less asked, where it is one number, and
/// otherwise a distance or an angle, never negative.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "of", rename_all = "snake_case")]
pub enum Reached {
    /// A turn of a hand's part about one of its own axes.
    Turn { axis: String, asked_deg: f64, reached_deg: f64, off_deg: f64 },
    /// An orientation of a hand's part in the hand's frame, as unit quaternions w, x, y, z; for a turn about x that which it leads to.
    Orientation { asked: [f64; 4], reached: [f64; 4], off_deg: f64 },
    /// A place of a DiMiBot's end-effector, and the nominal place of the cell that was taken for it; both in the scene's coordinates.
    Place { asked_um: [f64; 2], reached_um: [f64; 2], off_um: f64 },
    /// A pose of a microrobot by the nominal motion, at the end of the step.
    Pose {
        robot: String,
        asked_um: [f64; 2],
        reached_um: [f64; 2],
        off_um: f64,
        asked_deg: f64,
        reached_deg: f64,
        off_deg: f64,
    },
}

impl Reached {
    /// All numbers in it.
    pub fn floats(&self) -> Vec<f64> {
        match self {
            Reached::Turn { asked_deg, reached_deg, off_deg, .. } => vec![*asked_deg, *reached_deg, *off_deg],
            Reached::Orientation { asked, reached, off_deg } => {
                asked.iter().chain(reached).chain([off_deg]).copied().collect()
            }
            Reached::Place { asked_um, reached_um, off_um } => {
                asked_um.iter().chain(reached_um).chain([off_um]).copied().collect()
            }
            Reached::Pose { asked_um, reached_um, off_um, asked_deg, reached_deg, off_deg, .. } => {
                let headings = [off_um, asked_deg, reached_deg, off_deg];
                asked_um.iter().chain(reached_um).chain(headings).copied().collect()
            }
        }
    }

    /// Whether the value reached differs from the goal by more than rounding.
    pub fn is_off(&self) -> bool {
        const ROUNDING: f64 = 5e-5;
        match self {
            Reached::Turn { off_deg, .. } | Reached::Orientation { off_deg, .. } => off_deg.abs() > ROUNDING,
            Reached::Place { off_um, .. } => *off_um > ROUNDING,
            Reached::Pose { off_um, off_deg, .. } => off_um.max(off_deg.abs()) > ROUNDING,
        }
    }

    /// Whether two are about the same goal with the same values, within a tolerance of each number.
    pub fn is_near(&self, other: &Reached, within: f64) -> bool {
        let named = |reached: &Reached| match reached {
            Reached::Turn { axis, .. } => format!("turn {axis}"),
            Reached::Orientation { .. } => "orientation".to_owned(),
            Reached::Place { .. } => "place".to_owned(),
            Reached::Pose { robot, .. } => format!("pose {robot}"),
        };
        let (own, others) = (self.floats(), other.floats());
        named(self) == named(other) && own.iter().zip(&others).all(|(one, other)| (one - other).abs() <= within)
    }
}

impl std::fmt::Display for Reached {
    /// `90 deg about z reaches 99.99 deg, 9.99 deg off`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let rounded = |value: f64| digits((value * 1e4).round() / 1e4);
        let place = |um: &[f64; 2]| format!("({} um, {} um)", rounded(um[0]), rounded(um[1]));
        match self {
            Reached::Turn { axis, asked_deg, reached_deg, off_deg } => {
                let [asked, reached, off] = [*asked_deg, *reached_deg, off_deg.abs()].map(rounded);
                write!(f, "{asked} deg about {axis} reaches {reached} deg, {off} deg off")
            }
            Reached::Orientation { off_deg, .. } => {
                write!(f, "an orientation is reached to {} deg", rounded(*off_deg))
            }
            Reached::Place { asked_um, reached_um, off_um } => {
                write!(f, "{} reaches {}, {} um off", place(asked_um), place(reached_um), rounded(*off_um))
            }
            Reached::Pose { robot, asked_um, reached_um, off_um, asked_deg, reached_deg, off_deg } => {
                let [asked, reached, off] = [*asked_deg, *reached_deg, off_deg.abs()].map(rounded);
                let [from, to, off_um] = [place(asked_um), place(reached_um), rounded(*off_um)];
                write!(f, "{robot} at {from}, {asked} deg reaches {to}, {reached} deg, {off_um} um and {off} deg off")
            }
        }
    }
}

/// Values reached by a step of an order that ends in a state.
pub fn reached(order: &Order, nth: usize, end: &State) -> Vec<Reached> {
    match order {
        Order::Dimibot(order) => places(order, nth),
        Order::ElectrodeArray(_) => Vec::new(),
        Order::Microrobots(order) => poses(order, nth, end),
        Order::Fingers(order) => turns(order, nth, end),
    }
}

fn places(order: &DimibotOrder, nth: usize) -> Vec<Reached> {
    let stops = match order.steps.get(nth).map(|step| &step.action) {
        Some(dimibot::DimibotAction::Move(stops) | dimibot::DimibotAction::Visit(stops)) => stops.as_slice(),
        Some(dimibot::DimibotAction::Wait(_)) | None => &[],
    };
    let place = |stop: &dimibot::DimibotStop| {
        let Asked::Place(asked_um) = stop.asked else { return None };
        let reached_um = order.in_scene_um(order.facts.place_um(stop.cell));
        let off_um = (reached_um[0] - asked_um[0]).hypotenuse(reached_um[1] - asked_um[1]);
        Some(Reached::Place { asked_um, reached_um, off_um })
    };
    stops.iter().filter_map(place).collect()
}

fn poses(order: &MicrorobotsOrder, nth: usize, end: &State) -> Vec<Reached> {
    let goals: Vec<(usize, &Pose)> = match order.steps.get(nth).map(|step| &step.action) {
        Some(microrobots::MicrorobotsAction::Drive { robot, stops }) => {
            stops.last().map(|stop| (*robot, &stop.pose)).into_iter().collect()
        }
        Some(microrobots::MicrorobotsAction::Assemble(docks)) => {
            docks.iter().map(|dock| (dock.robot, &dock.goal.pose)).collect()
        }
        Some(microrobots::MicrorobotsAction::Apply { .. } | microrobots::MicrorobotsAction::Wait(_)) | None => {
            Vec::new()
        }
    };
    let State::Microrobots { poses, .. } = end else { return Vec::new() };
    let pose = |(robot, goal): (usize, &Pose)| {
        let robot = order.robot(robot).name.clone();
        let [x_um, y_um, heading_rad] = *poses.get(&robot)?;
        let off_rad = (heading_rad - goal.heading_rad + PI).rem_euclid(TAU) - PI;
        Some(Reached::Pose {
            robot,
            asked_um: [goal.x_um, goal.y_um],
            reached_um: [x_um, y_um],
            off_um: (x_um - goal.x_um).hypotenuse(y_um - goal.y_um),
            asked_deg: goal.heading_rad.to_degrees(),
            // Relative to the goal, so that 359 deg are not far from 1 deg.
            reached_deg: (goal.heading_rad + off_rad).to_degrees(),
            off_deg: off_rad.to_degrees(),
        })
    };
    goals.into_iter().filter_map(pose).collect()
}

fn turns(order: &FingersOrder, nth: usize, end: &State) -> Vec<Reached> {
    match order.steps.get(nth).map(|step| &step.action) {
        Some(fingers::FingersAction::Rotate { plane, steps, angle_rad }) => {
            let Some(section) = order.part.section(*plane) else { return Vec::new() };
            let reached_rad = f64::from(*steps) * section.step_rad;
            let axis = match plane {
                Plane::Xy => "z",
                Plane::Xz => "y",
            };
            let [asked_deg, reached_deg] = [*angle_rad, reached_rad].map(f64::to_degrees);
            let off_deg = reached_deg - asked_deg;
            vec![Reached::Turn { axis: axis.to_owned(), asked_deg, reached_deg, off_deg }]
        }
        Some(fingers::FingersAction::Orient { goal, .. }) => {
            let State::Fingers { orientation, .. } = end else { return Vec::new() };
            let [asked, reached] = [goal, orientation]
                .map(|[w, x, y, z]| UnitQuaternion::from_quaternion(Quaternion::new(*w, *x, *y, *z)));
            let off_deg = asked.angle_to(&reached).to_degrees();
            vec![Reached::Orientation { asked: *goal, reached: *orientation, off_deg }]
        }
        Some(
            fingers::FingersAction::Grasp(_)
            | fingers::FingersAction::Translate(_)
            | fingers::FingersAction::Release
            | fingers::FingersAction::Wait(_),
        )
        | None => Vec::new(),
    }
}
