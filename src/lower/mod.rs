//! Lowering: from the plans of a program's jobs to its [`Schedule`](crate::schedule::Schedule), actuations on one clock.
//!
//! Input: the claims and a [`Plan`](crate::plan::Plan) for each job. Output: a schedule. Each kind turns a plan into a [`clock::LoweredRun`]
//! of its own, from its own instant 0; [`clock`] puts the runs where the timeline wants them.

pub mod clock;
mod dimibot;
pub(crate) mod electrode_array;
pub(crate) mod fingers;
pub(crate) mod microrobots;

pub use clock::lower;
