//! Planner of electrode arrays: many parts at once from their cells to their goals, one step of the platform after the other.
//!
//! Input: a job, and the cells of the parts. Output: a plan, or an error that explains why there is none. Reading order:
//!
//! - the task: `job` (step by step), `standings` (where earlier plans have left the parts), `stage` (one step on flat cell indices, [`board`]);
//! - the default planner of a step: `portfolio` ([`fast`] and `lacam` find plans, [`exact`] and [`joint`] prove them optimal or impossible);
//! - other steps: [`channels`] (an electrode is switched with others), [`teams`] (goals that are not told apart), `greedy` on [`published`] (the
//!   planner of the paper);
//! - assays: `errands` (operations that depend on each other only by their parts), [`assay`] (their plan), [`places`] (where operations
//!   take place, where the program leaves it open), `one_by_one` (the plan of last resort);
//! - `limits` (plans of all steps within the limits of the task), `reasons` (why there is no plan, and what would help).

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
