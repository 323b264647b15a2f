//! Plans of a stage on a board with shared channels, under the rule of [`self::broadcast`].
//!
//! Reading order: `search` (plans and proofs), `prioritised` (a first plan, one agent after the other), `kept` (whether
//! a plan that ignores channels keeps the rule).

pub mod broadcast;
mod kept;
mod prioritised;
mod search;

pub use kept::are_kept_by_paths;
pub use search::solve;

#[cfg(test)]
mod tests;
