//! Planner of the digital microrobot (DiMiBot): moves the tip between cells of the lattice by switching bistable
//! modules, one at a time or several in one pulse.
//!
//! Input: a [`LatticeField`] (lattice and obstacles), cells, [`SwitchWeights`] and a budget. Output: a
//! [`DimibotAnswer`].
//! Guaranteed: a plan never touches an obstacle enlarged by its growth and [`SAFETY_MARGIN_UM`]; `Impossible` is a
//! proof; costs are optimal where `cost == bound`.

mod bands;
mod blame;
mod blocks;
mod collision_avoidance;
mod field;
mod guided;
mod job;
mod journey;
mod labels;
mod lattice;
mod legs;
mod lines;
mod obstacles;
mod outcome;
mod programme;
pub mod published;
mod pulses;
mod queue;
mod reach;
mod route;
mod seen;
mod shortest;
mod tally;
mod tour;

pub use blame::{ObstacleBlame, Opening, blame};
pub use collision_avoidance::avoid_collisions;
pub use field::LatticeField;
pub use job::{DimibotMotion, DimibotStandings, DimibotStandings as Standings, DimibotStepMotion, plan};
pub use lattice::{Flip, Lattice, LatticeCell, LatticeError, MAX_MODULES, ModulePulse, Side, SwitchWeights};
pub use legs::NoLeg;
pub use obstacles::{FieldError, FieldObstacle, SAFETY_MARGIN_UM};
pub use outcome::{DimibotAnswer, FlipPath, Impossible, Proof};
pub use programme::{EXACT_PLACES, MissingLeg, RouteStage};
pub use pulses::{PulseTrain, pulse_is_safe, pulses};
pub use route::{Route, RouteRequest, RouteWithin, Router};
pub use shortest::shortest;
pub use tally::MotionTally;

#[cfg(test)]
pub(super) mod tests;
