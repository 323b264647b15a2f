//! The planner of hands: grasps are nodes, rolling and finger gaiting are edges, and all turns of a task are one problem.

mod course;
pub mod graph;
mod job;
mod limited;
pub mod looks;
pub mod mechanics;
pub mod routes;
mod sections;
pub mod tables;
pub mod ways;
mod why;

pub use job::{HandStandings as Standings, plan};

use crate::device::fingers::Plane;

/// What the hand does.
#[derive(Debug, Clone, PartialEq)]
pub struct FingersMotion {
    /// Where everything is at first.
    pub start: Stance,
    /// One for each step of the order.
    pub steps: Vec<Vec<TipsMove>>,
}

/// All tips move on straight lines from where they are, from the same instant to the same instant.
#[derive(Debug, Clone, PartialEq)]
pub struct TipsMove {
    /// Above 0.
    pub duration_ns: u64,
    /// Where the centre of each tip is at its end, in the hand's frame.
    pub tips_um: Vec<[f64; 3]>,
    /// The state at its end where one is recorded: after every grasp of the plan (node of the grasp graph).
    pub state: Option<HeldGrasp>,
}

/// Where everything is.
#[derive(Debug, Clone, PartialEq)]
pub struct Stance {
    /// The centre of each tip, in the hand's frame.
    pub tips_um: Vec<[f64; 3]>,
    pub hold: HeldGrasp,
}

/// A grasp, and where it has the object.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldGrasp {
    /// The contact of each finger in the plane's section, from 1; 0 for a free finger.
    pub grasp: Vec<u32>,
    pub plane: Plane,
    /// The angle of the turn that goes on, as steps from its beginning, from 1.
    pub angle_index: i64,
    /// Where the part's origin is in the hand's frame.
    pub position_um: [f64; 3],
    /// A unit quaternion w, x, y, z that carries the part's axes into the hand's frame, w not negative.
    pub orientation: [f64; 4],
}
