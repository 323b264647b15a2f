//! Planner of electrode arrays: many parts at once from their cells to their goals, one step of the platform after the other.
//!
//! Input: a job, and the cells of the parts. Output: a plan, or an error that explains why there is none. Reading order: `job` (a
//! task, step by step), `standings` (where earlier plans have left the parts), `stage` (one step on flat cell indices, [`board`]), `portfolio` (the default planner: [`fast`] finds plans,
//! [`exact`] and [`joint`] prove them optimal or impossible), [`broadcast`] and [`channels`] (boards on which a channel switches several electrodes), `torn` (where such have no plan), `limited` (plans of all steps within limits), [`published`] (the
//! paper's own), [`assay`] and `errands` (operations that depend on each other only by their parts), `arranged`, `place_tree` and `relaxed` (their places, where the program leaves them open), [`teams`], `shared` and `loose` (interchangeable goals), `why` (blocking obstacles), `remedy` (changes that would help).

mod alone;
mod arranged;
pub mod assay;
mod assigned;
pub mod board;
pub mod broadcast;
pub mod channels;
mod critical_path;
mod errands;
pub mod exact;
pub mod fast;
mod greedy;
mod job;
pub mod joint;
pub mod labels;
mod lacam;
mod limited;
mod limits;
mod loose;
mod motion;
mod one_by_one;
mod place_queue;
mod place_tree;
mod placement;
mod portfolio;
pub mod published;
mod relaxed;
mod remedy;
mod shared;
mod stage;
mod standings;
pub mod teams;
mod timing;
mod torn;
mod why;

pub use errands::PartCourse;
pub use job::plan;
pub use motion::{ElectrodeArrayMotion, ElectrodeArrayStepMotion};
pub use portfolio::{first, solve};
pub use standings::BoardStandings as Standings;

#[cfg(test)]
mod tests;
