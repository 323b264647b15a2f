//! Tweeze: a declarative language and a verifying compiler for micro-manipulation programs.

pub mod diagnostic;
pub mod quantity;
pub mod source;
pub mod syntax;
