//! Is this electrode array possible, is this scene possible for it, are these goals?

mod board;
mod cover;
mod forces;
mod goals;
mod motion;
mod physics;
mod places;
mod tray;

use crate::device::electrode_array::ElectrodeArrayFacts;
pub use board::facts;
pub use places::places_agree;

/// Greatest default of the limit of expanded states.
const MOST_BY_DEFAULT: u64 = 64_000_000;

/// Default limit of expanded states in the search of one step: 16 million, and 2 more for each part and cell, at
/// most 64 million.
pub fn default_expansions(facts: &ElectrodeArrayFacts, parts: usize) -> u64 {
    let cells = u64::from(facts.columns) * u64::from(facts.rows);
    let more = cells.saturating_mul(2 * parts as u64);
    (16_000_000 + more).min(MOST_BY_DEFAULT)
}

#[cfg(test)]
mod tests;
