//! Claims of a task on STRING microrobots.

use super::{KindOrder, Order, ValueOrigin};
use crate::device::Kind;
use crate::device::microrobots::{ControlState, MicrorobotsFacts, MicrorobotsObjective};
use crate::geometry::{Pose, Shape};
use crate::source::Span;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A task of microrobots.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MicrorobotsOrder {
    /// Shared by all tasks of one device; likewise the states.
    pub facts: Arc<MicrorobotsFacts>,
    /// The control states that the bed's voltage can set; `apply state 2` is that of index 2. In a STRING table,
    /// state j lowers the j arms that snap down first.
    pub states: Arc<Vec<ControlState>>,
    /// Shared by all tasks of one device in one scene; likewise the robots.
    pub obstacles: Arc<Vec<MicrorobotsObstacle>>,
    /// The robots of the scene, in the order of the table; rows that the scene leaves out are not on the bed. All
    /// tasks of one device in one schedule have the same robots.
    pub robots: Arc<Vec<Placed>>,
    /// Most paths that the search of one step may expand.
    pub expansions: u64,
    #[serde(default, skip_serializing_if = "is_time")]
    pub objective: MicrorobotsObjective,
    pub precision: Precision,
    pub assurance: Assurance,
    pub steps: Vec<MicrorobotsStep>,
}

fn is_time(objective: &MicrorobotsObjective) -> bool {
    *objective == MicrorobotsObjective::Time
}

impl KindOrder for MicrorobotsOrder {
    fn kind(&self) -> Kind {
        Kind::Microrobots
    }

    fn margin_v(&self) -> Option<f64> {
        Some(self.facts.margin_v)
    }
}

impl MicrorobotsOrder {
    /// A job's order, if it is one of this kind.
    pub fn of(order: &Order) -> Option<&MicrorobotsOrder> {
        if let Order::Microrobots(order) = order { Some(order) } else { None }
    }

    /// The facts of a robot of the scene, by its index in `robots`.
    pub fn robot(&self, index: usize) -> &crate::device::microrobots::Robot {
        &self.facts.robots[self.robots[index].row]
    }
}

/// An obstacle for all robots.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MicrorobotsObstacle {
    /// The name in the scene.
    pub name: String,
    pub shape: Shape,
    pub pose: Pose,
    #[serde(skip)]
    pub span: Span,
}

/// A robot on the bed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Placed {
    /// Index into the facts' robots.
    pub row: usize,
    /// Its pose before the device's first task.
    pub pose: Pose,
    #[serde(skip)]
    pub span: Span,
}

/// Tolerance of a robot's goal.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Precision {
    pub place_um: f64,
    pub heading_rad: f64,
}

/// Treatment of a goal that cannot be guaranteed under the device's error bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Assurance {
    /// It is reported. Logs use an older word for this.
    #[serde(rename = "told")]
    Reported,
    /// It is an error.
    Demanded,
}

/// One step of a task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MicrorobotsStep {
    pub action: MicrorobotsAction,
    #[serde(skip)]
    pub span: Span,
}

/// Action of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MicrorobotsAction {
    /// Runs the drive train in a control state for this time, without its control cycle; rounded up to whole strokes.
    Apply { state: usize, duration_ns: u64 },
    /// Drives one robot through poses in this order; the last one is its goal.
    Drive { robot: usize, stops: Vec<MicrorobotsStop> },
    /// Drives robots to goals where they dock with one another; at least two, each once.
    Assemble(Vec<Dock>),
    /// The bed is at 0 V for this time, in nanoseconds: all arms go up and nothing moves.
    Wait(u64),
}

/// A pose to be reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MicrorobotsStop {
    pub pose: Pose,
    #[serde(skip)]
    pub span: Span,
    /// The definition of the pose, if the step refers to it by name.
    #[serde(skip)]
    pub origin: Option<ValueOrigin>,
}

/// A robot's place in a structure.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Dock {
    /// Index into the order's robots.
    pub robot: usize,
    pub goal: MicrorobotsStop,
}
