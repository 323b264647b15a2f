//! Exact planning (to be completed).

pub mod field;
