//! Why a step has no plan: the blockers of a part that is cut off (`why`), what would help it (`remedy`), and channels that tear a
//! droplet (`torn`).

pub mod remedy;
pub mod torn;
pub mod why;
