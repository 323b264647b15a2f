//! Planner of electrode arrays: moves many parts at once from their cells to their goals, step by step of the task.
//!
//! Input: a job and the current cells of its parts. Output: a plan, or an error that explains why there is none.
//! Reading order:
//!
//! - the task: `job` (steps in sequence), `standings` (where earlier plans left the parts), `stage` (one step on flat
//!   cell indices, [`board`]);
//! - the default planner of a step: `portfolio` ([`fast`] and `lacam` find plans, [`exact`] and [`joint`] prove them
//!   optimal or impossible);
//! - other steps: [`channels`] (electrodes that share a channel switch together), [`teams`] (goals shared by
//!   interchangeable parts), `greedy` on [`published`] (the planner of the paper);
//! - assays: `errands` (operations that depend on each other only through their parts), [`assay`] (their plan),
//!   [`places`] (choice of the places that the program leaves open), `one_by_one` (fallback planner);
//! - `limits` (plans of all steps within the limits of the task), `reasons` (why there is no plan, and what would
//!   help).

pub mod assay;
pub mod board;
pub mod channels;
mod errands;
pub mod exact;
pub mod fast;
mod greedy;
mod job;
pub mod joint;
mod lacam;
mod limits;
mod motion;
mod one_by_one;
pub mod places;
mod portfolio;
pub mod published;
mod reasons;
mod stage;
mod standings;
pub mod teams;

pub use errands::PartCourse;
pub use job::plan;
pub use motion::{ElectrodeArrayMotion, ElectrodeArrayStepMotion};
pub use portfolio::{first, solve};
pub use standings::BoardStandings as Standings;

#[cfg(test)]
mod tests;
