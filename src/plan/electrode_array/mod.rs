//! The planner of electrode arrays: many parts at once from their cells to their goals, one step of the platform after the other.
//!
//! Input: a job, and where the parts stand. Output: a plan, or an error that says why there is none. The order of reading: `job`
//! (a task, step by step), `stage` (one step as a problem in flat numbers, [`board`]), `portfolio` (the default planner: [`fast`]
//! finds plans, [`exact`] and [`joint`] prove them best or impossible), `limited` (plans of all steps within limits), [`published`] (the paper's own), `why` (what stands in the way), `remedy` (what would mend it).

mod alone;
pub mod board;
pub mod exact;
pub mod fast;
mod job;
pub mod joint;
pub mod labels;
mod lacam;
mod limited;
mod limits;
mod portfolio;
pub mod published;
mod remedy;
mod stage;
mod timing;
mod why;

pub use job::{BoardStandings as Standings, ElectrodeArrayMotion, ElectrodeArrayStepMotion, plan};
pub use portfolio::solve;

#[cfg(test)]
mod tests;
