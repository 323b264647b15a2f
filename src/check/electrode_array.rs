//! Is this electrode array possible, is this scene possible for it, are these goals?

mod board;
mod cover;
mod forces;
mod goals;
mod motion;
mod physics;
mod places;
mod tray;

pub use board::facts;
pub use places::{Origins, places_agree};
pub use tray::Judged;

/// States that the search of one step may expand where the task does not say.
pub const DEFAULT_EXPANSIONS: u64 = 16_000_000;

#[cfg(test)]
mod tests;
