//! Whether something that moves ever comes too near something else: by halving its way.
//!
//! Input: a distance as a function of the share of the way, and how fast it can change. Output: where it is too small, if anywhere. The
//! distance in the middle of a stretch, less what can be lost on half of the stretch, holds for all of it; where that is not enough, both
//! halves are looked at, down to stretches on which less than [`RESOLUTION_UM`] can be lost. Promise: what keeps its distance is never refused; what
//! comes nearer by more than [`RESOLUTION_UM`] always is. Cost: logarithmic in the way where the distance is ample; of the order of
//! the way over the resolution where something slides along at the very limit.

/// How far something may come too near without being found.
const RESOLUTION_UM: f64 = 5e-4;

/// Rounding that is no breach.
pub(super) const ROUNDING_UM: f64 = 1e-6;

/// How often one run may be looked at before the verifier gives up on it.
const MAX_LOOKS: u64 = 1 << 24;

/// What is left of the looks.
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

/// Where something is too near, as a share of the way, and how near.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SweptTouch {
    pub share: f64,
    pub gap_um: f64,
}

/// A distance that changes along a way.
pub(super) struct SweptGap<G, F> {
    /// At a share of the way.
    pub at: G,
    /// Something that it never falls below between two shares, and that is cheaper to know.
    pub floor: F,
    /// How much it can change on the whole way.
    pub travel_um: f64,
}

impl<G: Fn(f64) -> f64, F: Fn([f64; 2]) -> f64> SweptGap<G, F> {
    /// A place between two shares of the way where it is less than needed.
    ///
    /// # Errors
    /// When all looks are used up, or the way is so long that its halves are none.
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
