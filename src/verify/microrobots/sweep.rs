//! Whether a moving body ever comes too near another one, by bisection of its path.
//!
//! Input: a distance as a function of the fraction of the path, and its greatest change along the whole path. Output:
//! a point of the path where the distance is too small, if any. The distance in the middle of a span, less the
//! greatest change over half of the span, is a lower bound for the whole span. Where that is not enough, both halves
//! are examined, down to spans on which less than [`RESOLUTION_UM`] can be lost. Promise: a body that keeps its
//! distance is never rejected; one that comes nearer by more than [`RESOLUTION_UM`] always is. Cost: logarithmic in
//! the path length where the distance is ample; of the order of path length over resolution where a body slides along
//! exactly at the limit.

/// Approach below the clearance that may remain undetected.
const RESOLUTION_UM: f64 = 5e-4;

/// Rounding error that does not count as a violation.
pub(super) const ROUNDING_UM: f64 = 1e-6;

/// Greatest number of evaluations in one run before the verifier gives up on it.
const MAX_EVALUATIONS: u64 = 1 << 24;

/// The remaining evaluations.
#[derive(Debug)]
pub(super) struct Evaluations(u64);

impl Default for Evaluations {
    fn default() -> Evaluations {
        Evaluations(MAX_EVALUATIONS)
    }
}

/// The run cannot be judged in a reasonable time.
#[derive(Debug)]
pub(super) struct BudgetExceeded;

/// A point of a path, as a fraction of it, where the distance is too small, with that distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SweptTouch {
    pub share: f64,
    pub gap_um: f64,
}

/// A distance that changes along a path.
pub(super) struct SweptGap<G, F> {
    /// The distance at a fraction of the path.
    pub at: G,
    /// A lower bound on the distance between two fractions of the path, cheaper than `at`.
    pub floor: F,
    /// Greatest change of the distance on the whole path.
    pub travel_um: f64,
}

impl<G: Fn(f64) -> f64, F: Fn([f64; 2]) -> f64> SweptGap<G, F> {
    /// A point between two fractions of the path where the distance is less than needed.
    ///
    /// # Errors
    /// If all evaluations are used up, or the path is so long that bisection reaches the resolution of a double.
    pub fn below(
        &self,
        span: [f64; 2],
        needed_um: f64,
        evaluations: &mut Evaluations,
    ) -> Result<Option<SweptTouch>, BudgetExceeded> {
        let mut open = vec![span];
        while let Some([from, to]) = open.pop() {
            evaluations.0 = evaluations.0.checked_sub(1).ok_or(BudgetExceeded)?;
            if (self.floor)([from, to]) >= needed_um {
                continue;
            }
            let share = f64::midpoint(from, to);
            let gap_um = (self.at)(share);
            if gap_um < needed_um - ROUNDING_UM {
                return Ok(Some(SweptTouch { share, gap_um }));
            }
            let lost_um = self.travel_um * (to - from) / 2.0;
            if gap_um - lost_um < needed_um && lost_um > RESOLUTION_UM {
                if share <= from || to <= share {
                    return Err(BudgetExceeded);
                }
                open.extend([[share, to], [from, share]]);
            }
        }
        Ok(None)
    }
}
