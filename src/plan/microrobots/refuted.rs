//! Guarantees held against trials: what is called guaranteed must not fail in `simulate`.
//!
//! A guarantee follows the bodies of the plan, and a trial where robots touch: the two see contact differently where a goal lies at an angle to
//! its edge, or beside it, or in its partner's body. So nothing is guaranteed that a trial within the same errors contradicts.

use super::MicrorobotsMotion;
use super::guarantee::scaled;
use super::safest::{MAX_WORK, simulated};
use super::simulation::Failures;
use crate::claims::microrobots::MicrorobotsOrder;
use std::sync::Arc;

/// Multiples of the errors that a plan is said to bear, each with the trials that are run with them. Contact without errors is a case of its
/// own, and so it is with the smallest ones.
const LOOKS: [(f64, u64); 4] = [(0.0, 1), (1e-3, 16), (0.5, 16), (1.0, 32)];

/// Seed of these trials.
const SEED: u64 = 2;

/// Why a plan fails in a trial with errors of at most so many times those of the device, in words; `None` if it succeeds in
/// all that are run: none of a plan that is too long to be simulated.
pub fn by_trial(order: &MicrorobotsOrder, motion: &MicrorobotsMotion, multiple: f64) -> Option<String> {
    let errors = order.facts.errors?;
    // Without errors all trials are one.
    let looks = LOOKS.iter().take(if errors.are_zero() { 1 } else { LOOKS.len() });
    looks.copied().find_map(|(share, trials)| {
        let mut within = order.clone();
        Arc::make_mut(&mut within.facts).errors = Some(scaled(&errors, multiple * share));
        let report = simulated(&within, motion, 1..=trials, SEED, MAX_WORK)?;
        let Failures { robot, reason, .. } = report.failures.first()?;
        let within = if share == 0.0 { "without errors" } else { "with errors that it was to bear" };
        Some(format!("{within} {} fails in a trial of the plan as written: {}", report.names[*robot], reason.clause()))
    })
}
