//! Whether a moving body ever comes too near another: by bisecting its path.
//!
//! Input: a distance as a function of the share of the path, and the greatest rate of its change. Output: a place where it is too small, if
//! any. The distance in the middle of a stretch, less the greatest change on half of the stretch, bounds all of it from below; where that
//! is not enough, both halves are examined, down to stretches on which less than [`RESOLUTION_UM`] can be lost. Promise: a body that keeps
//! its distance is never refused; one that comes nearer by more than [`RESOLUTION_UM`] always is. Cost: logarithmic in the path length
//! where the distance is ample; of the order of path length over resolution where a body slides along at the very limit.

/// Approach below the clearance that may remain undetected.
const RESOLUTION_UM: f64 = 5e-4;

/// Rounding that is no breach.
pub(super) const ROUNDING_UM: f64 = 1e-6;

/// Greatest number of evaluations in one run before the verifier gives up on it.
const MAX_LOOKS: u64 = 1 << 24;

/// The evaluations left.
#[derive(Debug)]
pub(super) struct Looks(u64);

impl Default for Looks {
    fn default() -> Looks {
        Looks(MAX_LOOKS)
    }
}

/// The run is such that it cannot be judged in a reasonable time.
#[derive(Debug)]
pub(super) struct Endless;

/// A place where the distance is too small, as a share of the path, and the distance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SweptTouch {
    pub share: f64,
    pub gap_um: f64,
}

/// A distance that changes along a path.
pub(super) struct SweptGap<G, F> {
    /// Its value at a share of the path.
    pub at: G,
    /// Something that it never falls below between two shares, and that is cheaper to know.
    pub floor: F,
    /// Greatest change of the distance on the whole path.
    pub travel_um: f64,
}

impl<G: Fn(f64) -> f64, F: Fn([f64; 2]) -> f64> SweptGap<G, F> {
    /// A place between two shares of the path where it is less than needed.
    ///
    /// # Errors
    /// If all evaluations are used up, or the path is so long that bisection is below the resolution of a double.
    pub fn below(&self, span: [f64; 2], needed_um: f64, looks: &mut Looks) -> Result<Option<SweptTouch>, Endless> {
        let mut open = vec![span];
        while let Some([from, to]) = open.pop() {
            looks.0 = looks.0.checked_sub(1).ok_or(Endless)?;
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
                    return Err(Endless);
                }
                open.extend([[share, to], [from, share]]);
            }
        }
        Ok(None)
    }
}
