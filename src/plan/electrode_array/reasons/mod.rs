//! Reasons why a step has no plan: the blockers of a part that is cut off (`why`), a remedy for it (`remedy`), and
//! channels that tear a droplet apart (`torn`).

pub mod remedy;
pub mod torn;
pub mod why;
