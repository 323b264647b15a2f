//! Values reached by a step, compared with its goals.
//!
//! Turns are whole steps, positions are cells, robots stop after whole strokes: goals are seldom reached exactly.
//! Input: an order, the index of a step, the state at its end. Output: one [`Reached`] for each goal of the step that
//! is given by numbers and need not be met exactly. Cells, electrodes and contacts are met exactly or not at all, and
//! have none.

use super::State;
use crate::claims::Order;
use crate::device::each_kind;
use crate::quantity::{digits, to_decimals};
use serde::{Deserialize, Serialize};

/// A numeric goal, and the value reached. The difference is the reached value minus the goal if it is one number,
/// otherwise a distance or an angle, never negative.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "of", rename_all = "snake_case")]
pub enum Reached {
    /// A turn of a hand's part about one of its own axes.
    Turn { axis: String, asked_deg: f64, reached_deg: f64, off_deg: f64 },
    /// An orientation of a hand's part in the hand's frame, as unit quaternions w, x, y, z; for a turn about x, the
    /// orientation that it leads to.
    Orientation { asked: [f64; 4], reached: [f64; 4], off_deg: f64 },
    /// A position of a DiMiBot's end-effector, and the nominal position of the cell chosen for it; both in the
    /// scene's coordinates.
    Place { asked_um: [f64; 2], reached_um: [f64; 2], off_um: f64 },
    /// The pose of a microrobot at the end of the step, by the nominal motion.
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

    /// Whether the value differs from the goal by more than rounding.
    pub fn is_off(&self) -> bool {
        const ROUNDING: f64 = 5e-5;
        match self {
            Reached::Turn { off_deg, .. } | Reached::Orientation { off_deg, .. } => off_deg.abs() > ROUNDING,
            Reached::Place { off_um, .. } => *off_um > ROUNDING,
            Reached::Pose { off_um, off_deg, .. } => off_um.max(off_deg.abs()) > ROUNDING,
        }
    }

    /// Whether two have the same goal and the same values, within a tolerance for each number.
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

impl Reached {
    /// The value reached, in short: `99.99 deg`, `(2.9884 um, 5.9768 um)`; for an orientation the deviation.
    pub fn value(&self) -> String {
        match self {
            Reached::Turn { reached_deg, .. } => format!("{} deg", rounded(*reached_deg)),
            Reached::Orientation { off_deg, .. } => format!("{} deg off", rounded(*off_deg)),
            Reached::Place { reached_um, .. } => place(reached_um),
            Reached::Pose { reached_um, reached_deg, .. } => {
                format!("{}, {} deg", place(reached_um), rounded(*reached_deg))
            }
        }
    }
}

fn rounded(value: f64) -> String {
    digits(to_decimals(value, 4))
}

fn place(um: &[f64; 2]) -> String {
    format!("({} um, {} um)", rounded(um[0]), rounded(um[1]))
}

impl std::fmt::Display for Reached {
    /// `90 deg about z reaches 99.99 deg, 9.99 deg off`.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
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

/// Reached values of a kind's steps.
pub(super) trait Reaching {
    /// The values reached by a step that ends in the state `end`; empty if its goals are met exactly or not at all.
    fn reached(&self, nth: usize, end: &State) -> Vec<Reached>;
}

/// The values reached by a step of an order that ends in the state `end`.
pub fn reached(order: &Order, nth: usize, end: &State) -> Vec<Reached> {
    each_kind!(Order, order, order => order.reached(nth, end))
}
