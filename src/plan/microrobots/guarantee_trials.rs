//! Checks guarantees against trials: what is called guaranteed must not fail in `simulate`.
//!
//! A guarantee follows the bodies of the plan; a trial follows where robots touch. The two see contact differently
//! where a goal lies at an angle to its edge, beside it, or inside its partner's body. So nothing is guaranteed that a
//! trial within the same errors contradicts.

use super::MicrorobotsMotion;
use super::guarantee::scaled;
use super::reliability::{MAX_WORK, simulated};
use super::simulation::Failures;
use crate::claims::microrobots::MicrorobotsOrder;
use std::sync::Arc;

/// Shares of the errors that a plan is claimed to tolerate, each with the number of trials run with them. Contact
/// without errors is a case of its own, and so is contact with the smallest errors.
const TRIALS: [(f64, u64); 4] = [(0.0, 1), (1e-3, 16), (0.5, 16), (1.0, 32)];

/// Seed of these trials.
const SEED: u64 = 2;

/// Reason, in words, why a plan fails in a trial with errors of at most `multiple` times those of the device. `None` if
/// it succeeds in all trials that are run; a plan too long to be simulated gets none.
pub fn failing_trial(order: &MicrorobotsOrder, motion: &MicrorobotsMotion, multiple: f64) -> Option<String> {
    let errors = order.facts.errors?;
    // Without errors all trials are the same.
    let checked = TRIALS.iter().take(if errors.are_zero() { 1 } else { TRIALS.len() });
    checked.copied().find_map(|(share, trials)| {
        let mut within = order.clone();
        Arc::make_mut(&mut within.facts).errors = Some(scaled(&errors, multiple * share));
        let report = simulated(&within, motion, 1..=trials, SEED, MAX_WORK)?;
        let Failures { robot, reason, .. } = report.failures.first()?;
        let within = if share == 0.0 { "without errors" } else { "with errors that it was to bear" };
        Some(format!("{within} {} fails in a trial of the plan as written: {}", report.names[*robot], reason.clause()))
    })
}
