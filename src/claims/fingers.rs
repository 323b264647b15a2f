//! Claims of a task on a hand.

use super::{KindOrder, Order};
use crate::device::Kind;
pub use crate::device::fingers::FingersPlanner;
use crate::device::fingers::{FingersFacts, Plane};
use crate::geometry::outline::Outline;
use crate::source::Span;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A task of a hand.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FingersOrder {
    /// Shared by all tasks of one device; likewise the part, by all tasks of one scene.
    pub facts: Arc<FingersFacts>,
    /// The part that the task turns. All tasks of one device in one schedule turn the same part.
    pub part: Arc<HandPart>,
    /// Tolerance of the angle at the end of each turn.
    pub precision_rad: f64,
    /// Force on the part in the hand's frame, weight included, in micronewtons; it acts at the part's centre of mass.
    pub load_un: [f64; 3],
    pub planner: FingersPlanner,
    /// Most grasps that the search may expand.
    pub expansions: u64,
    /// Most grasp evaluations of all its searches together; `None` for the planner's default.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub looks: Option<u64>,
    pub steps: Vec<FingersStep>,
}

impl KindOrder for FingersOrder {
    fn kind(&self) -> Kind {
        Kind::Fingers
    }

    fn tolerance_um(&self) -> Option<f64> {
        Some(self.facts.tolerance_um)
    }
}

impl FingersOrder {
    /// A job's order, if it is one of this kind.
    pub fn of(order: &Order) -> Option<&FingersOrder> {
        if let Order::Fingers(order) = order { Some(order) } else { None }
    }
}

/// The object between the fingers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct HandPart {
    /// The name in the scene.
    pub name: String,
    /// Its outline in the plane xy.
    pub xy: Section,
    /// Its outline in the plane xz; `None` for a flat part.
    pub xz: Option<Section>,
    /// Its centre of mass in its own frame; matters only if there is a load.
    pub centre_um: [f64; 3],
    /// Position of its origin in the hand's frame before the device's first task; its axes are then parallel to the
    /// hand's.
    pub position_um: [f64; 3],
    #[serde(skip)]
    pub span: Span,
}

impl HandPart {
    /// Its outline in a plane, if it has one.
    pub fn section(&self, plane: Plane) -> Option<&Section> {
        match plane {
            Plane::Xy => Some(&self.xy),
            Plane::Xz => self.xz.as_ref(),
        }
    }
}

/// An outline with its contacts, evenly spaced in rolled angle: from each contact to the next the object turns by the
/// same angle.
///
/// On a curve with signed curvature κ the contacts are where the integral of κ + 1/l2 along the outline, from the
/// point where the x axis leaves it, is a multiple of (2π + P/l2)/c; so c steps go around a section of perimeter P
/// (equation 8 of the paper with the sign of κ, which it drops).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Section {
    /// In the coordinates of [`Plane::axes`], counter-clockwise.
    pub outline: Outline,
    /// c: number of contacts, numbered from 1.
    pub contacts: u32,
    /// The number of the contact where the x axis enters, the paper's J; contact 1 is its I. `None` if there is no
    /// contact there.
    pub opposite: Option<u32>,
    /// Rotation of the object while it rolls from one contact to the next: nearly the device's step.
    pub step_rad: f64,
}

/// One step of a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FingersStep {
    pub action: FingersAction,
    #[serde(skip)]
    pub span: Span,
}

/// Action of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FingersAction {
    /// The fingers hold these contacts at the end, one number for each finger, 0 for a free one; `None` for any
    /// grasp.
    ///
    /// The plane is that of the next turn of the task, or of the last one if no turn follows.
    Grasp(Option<Vec<u32>>),
    /// A turn in a plane by `steps` steps of its section, in the direction of their sign; never the shorter way
    /// around instead.
    Rotate {
        plane: Plane,
        steps: i32,
        /// The angle as written in the program.
        angle_rad: f64,
    },
    /// Turns to an orientation, a unit quaternion w, x, y, z that carries the part's axes into the hand's frame, by
    /// any sequence of turns.
    ///
    /// `turns` are the decompositions that reach it within the precision, each a sequence of turns; at least one. An
    /// empty sequence means that the part already has the orientation.
    Orient {
        goal: [f64; 4],
        turns: Vec<Vec<FingersTurn>>,
        /// Least number of steps among the decompositions that were dropped because there were too many; `None` if
        /// none were.
        left_out_steps: Option<u32>,
    },
    /// A translation with all fingers together, in the hand's frame.
    Translate([f64; 3]),
    /// All fingers release the part.
    Release,
    /// Nothing moves for this time, in nanoseconds.
    Wait(u64),
}

/// A turn by whole steps in a plane.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct FingersTurn {
    pub plane: Plane,
    /// Not 0.
    pub steps: i32,
}
