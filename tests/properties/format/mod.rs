//! The canonical form: its invariants, and the command that produces it.

mod command;
#[path = "../../fuzz/generate.rs"]
mod generate;
mod laws;
mod mangle;
#[path = "../../fuzz/mutate.rs"]
mod mutate;
#[path = "../../fuzz/numbers.rs"]
mod numbers;
mod rules;
#[path = "../../fuzz/seeds.rs"]
#[allow(dead_code, reason = "other attacks begin with other texts")]
mod seeds;

use crate::scene::random;
