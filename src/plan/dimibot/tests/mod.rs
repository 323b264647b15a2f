//! Golden cases of the paper and random scenes against a brute-force oracle that shares no predicate with the planner.

mod golden;
mod many;
pub(in crate::plan::dimibot) mod oracle;
mod scenes;
