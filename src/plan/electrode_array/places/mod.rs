//! Places of the operations of an assay, where the program leaves them open.
//!
//! Reading order: `arranged` (an assay for each choice of places, and the best of them), `critical_path` (how early each operation can be, and
//! how long all after it takes), `placement` (one choice, by a schedule on paper), `place_tree` (choices in the order of their bounds),
//! `relaxed` and `place_queue` (bounds that hold wherever the operations are).

pub mod arranged;
mod critical_path;
mod place_queue;
mod place_tree;
mod placement;
mod relaxed;
