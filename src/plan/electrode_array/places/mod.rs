//! Places of the operations of an assay, where the program leaves them open.
//!
//! Reading order: `arranged` (an assay for each choice of places, and the best of them), `critical_path` (the earliest
//! instant of each operation, and the least time after it), `placement` (one choice, by a relaxed schedule),
//! `place_tree` (choices in the order of their bounds), `lower_bounds` and `place_queue` (lower bounds for any choice
//! of places).

pub mod arranged;
mod critical_path;
mod lower_bounds;
mod place_queue;
mod place_tree;
mod placement;
