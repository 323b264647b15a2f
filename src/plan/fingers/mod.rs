//! Planner of hands: grasps are nodes, rolling and finger gaiting are edges, and all turns of a task are one problem.
//!
//! **Guaranteed:** a cost called optimal, a bound or a proof of impossibility holds for all plans in which each turn
//! stays within one revolution of its start and its goal, in either direction. **Not:** plans that turn the part
//! farther; in theory they may cost less, since contacts repeat only after (360 deg + perimeter / tip radius) / 360 deg
//! revolutions.

mod course;
pub mod graph;
mod job;
mod limited;
pub mod looks;
pub mod mechanics;
pub mod routes;
mod sections;
mod stretches;
pub mod tables;
pub mod tip_motion;
mod why;

pub use job::{HandStandings as Standings, plan};

use crate::device::fingers::Plane;

/// Motion of the hand.
#[derive(Debug, Clone, PartialEq)]
pub struct FingersMotion {
    /// Initial stance.
    pub start: Stance,
    /// The moves of each step of the order.
    pub steps: Vec<Vec<TipsMove>>,
}

/// All tips move in straight lines from their current positions, over the same time span.
#[derive(Debug, Clone, PartialEq)]
pub struct TipsMove {
    /// Duration; above 0.
    pub duration_ns: u64,
    /// Centre of each tip at the end, in the hand's frame.
    pub tips_um: Vec<[f64; 3]>,
    /// Recorded state at the end, if any: after every grasp of the plan (node of the grasp graph).
    pub state: Option<HeldGrasp>,
}

/// Positions of tips and object.
#[derive(Debug, Clone, PartialEq)]
pub struct Stance {
    /// Centre of each tip, in the hand's frame.
    pub tips_um: Vec<[f64; 3]>,
    pub hold: HeldGrasp,
}

/// A grasp, and the pose of the object.
#[derive(Debug, Clone, PartialEq)]
pub struct HeldGrasp {
    /// Contact of each finger in the plane's section, counted from 1; 0 for a free finger.
    pub grasp: Vec<u32>,
    pub plane: Plane,
    /// Angle of the current turn, in steps from its beginning, which is 1.
    pub angle_index: i64,
    /// Position of the part's origin in the hand's frame.
    pub position_um: [f64; 3],
    /// Unit quaternion w, x, y, z that rotates the part's axes into the hand's frame, w not negative.
    pub orientation: [f64; 4],
}
