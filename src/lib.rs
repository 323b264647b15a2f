//! Tweeze: a declarative language and a verifying compiler for micro-manipulation programs.

pub mod check;
pub mod cli;
pub mod compile;
pub mod device;
pub mod diagnostic;
pub mod emit;
pub mod geometry;
pub mod plan;
pub mod quantity;
pub mod schedule;
pub mod source;
pub mod stdlib;
pub mod syntax;
pub mod verify;
