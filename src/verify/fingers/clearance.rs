//! Distances between tips, and of free tips from the part.
//!
//! Tips move on straight lines within a stretch, so the least distance between two of them is exact. The path of a
//! free tip past a resting part is followed in strides (conservative advancement): the distance shrinks no faster than
//! the tip moves, so a stride as long as the excess over the clearance is safe. A stride need not be shorter than half
//! of the device's tolerance.

use super::Point;
use super::body::{ObjectPose, PartOutlines};
use super::track::Stretch;
use crate::device::fingers::FingersFacts;

/// Greatest number of strides along one stretch; a tip that needs more almost touches.
const MAX_STRIDES: usize = 20_000;

/// Shortest stride, as a fraction of the tolerance: a tip may pass below a clearance by this much undetected.
const STRIDE: f64 = 0.5;

/// The least distance between two tips' centres along a stretch, and the fraction of the stretch at which it occurs.
pub(super) fn least_um(stretch: &Stretch, one: usize, other: usize) -> (f64, f64) {
    let from_um = stretch.from_um[one] - stretch.from_um[other];
    let run_um = stretch.to_um[one] - stretch.to_um[other] - from_um;
    let square = run_um.norm_squared();
    let share = if square > 0.0 { (-from_um.dot(&run_um) / square).clamp(0.0, 1.0) } else { 0.0 };
    ((from_um + run_um * share).norm(), share)
}

/// The nearest two tips of a stretch among the pairs that move, with their distance and the fraction of the stretch at
/// which it occurs.
pub(super) fn nearest(stretch: &Stretch) -> Option<([usize; 2], f64, f64)> {
    let fingers = stretch.from_um.len();
    let pairs = (0..fingers).flat_map(|one| (one + 1..fingers).map(move |other| [one, other]));
    let moving = pairs.filter(|pair| !pair.iter().all(|finger| stretch.rests(*finger)));
    let distances = moving.map(|pair| {
        let (distance_um, share) = least_um(stretch, pair[0], pair[1]);
        (pair, distance_um, share)
    });
    distances.min_by(|one, other| one.1.total_cmp(&other.1))
}

/// Least distance that the centres of two tips must keep.
pub(super) fn apart_um(facts: &FingersFacts) -> f64 {
    2.0 * facts.tip_radius_um + facts.clearance_um
}

/// Least distance that the centre of a free tip must keep from the part.
pub(super) fn clear_um(facts: &FingersFacts) -> f64 {
    facts.tip_radius_um + facts.clearance_um
}

/// The flight of a free finger between two contacts.
#[derive(Debug, Clone, Default)]
pub(super) struct Flight {
    /// Position of the contact that its tip left; `None` if unknown.
    left_um: Option<Point>,
    /// The instant at which the tip came near the part in order to touch it, and its positions since then; `None`
    /// while it is not near.
    pub near: Option<(u64, Vec<Point>)>,
}

/// A tip that is too near to the part.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TipHit {
    pub time_ns: u64,
    pub distance_um: f64,
    pub due_um: f64,
}

impl Flight {
    /// The flight of a finger that leaves a contact.
    pub fn from(left_um: Point) -> Self {
        Flight { left_um: Some(left_um), near: None }
    }

    /// Drops the contact that the tip left, which is no longer meaningful once the part moves.
    pub fn forget(&mut self) {
        self.left_um = None;
    }

    /// Follows the tip along a stretch past a resting part.
    pub fn follow(
        &mut self,
        stretch: &Stretch,
        finger: usize,
        body: &PartOutlines,
        pose: &ObjectPose,
        facts: &FingersFacts,
    ) -> Result<(), TipHit> {
        let length_um = (stretch.to_um[finger] - stretch.from_um[finger]).norm();
        let (clear_um, tolerance_um) = (clear_um(facts), facts.tolerance_um);
        let hard_um = facts.tip_radius_um - tolerance_um;
        let mut path_um = 0.0;
        for _ in 0..MAX_STRIDES {
            let share = if length_um > 0.0 { (path_um / length_um).min(1.0) } else { 1.0 };
            let tip_um = stretch.tip_um(finger, share);
            let time_ns = stretch.instant_ns(share);
            let enough_um = clear_um + length_um;
            let distance_um = body.gap_um(pose, &tip_um, tolerance_um, enough_um);
            let hit = |due_um| TipHit { time_ns, distance_um, due_um };
            if distance_um.is_nan() || distance_um < hard_um {
                return Err(hit(hard_um));
            }
            let spare_um = match self.is_near(&tip_um, distance_um, facts) {
                true => (distance_um - hard_um).min(retreat_um(facts) / 8.0),
                false => distance_um - clear_um,
            };
            self.note(time_ns, tip_um, distance_um, facts).map_err(|()| hit(clear_um))?;
            if share >= 1.0 {
                return Ok(());
            }
            path_um += spare_um.max(STRIDE * tolerance_um);
        }
        let (time_ns, distance_um) = (stretch.start_ns, facts.tip_radius_um);
        Err(TipHit { time_ns, distance_um, due_um: clear_um })
    }

    fn is_near(&self, tip_um: &Point, distance_um: f64, facts: &FingersFacts) -> bool {
        let leaves = self.left_um.is_some_and(|left_um| (tip_um - left_um).norm() <= retreat_um(facts));
        leaves || distance_um < clear_um(facts) - facts.tolerance_um
    }

    /// Records the positions of a tip near the part while it approaches a contact.
    fn note(&mut self, time_ns: u64, tip_um: Point, distance_um: f64, facts: &FingersFacts) -> Result<(), ()> {
        let is_clear = distance_um >= clear_um(facts) - facts.tolerance_um;
        let leaves = self.left_um.is_some_and(|left_um| (tip_um - left_um).norm() <= retreat_um(facts));
        match &mut self.near {
            // It came near and moves away without having touched.
            Some(_) if is_clear => Err(()),
            Some((_, places_um)) => {
                places_um.push(tip_um);
                if places_um.len() <= MAX_STRIDES { Ok(()) } else { Err(()) }
            }
            None if is_clear || leaves => Ok(()),
            None => {
                self.near = Some((time_ns, vec![tip_um]));
                Ok(())
            }
        }
    }

    /// Ends the flight at a contact; the tip may have been near the part only within the last section of its path.
    pub fn lands(&self, contact_um: &Point, facts: &FingersFacts) -> Result<(), TipHit> {
        let Some((time_ns, places_um)) = &self.near else { return Ok(()) };
        let is_far = |place_um: &Point| (place_um - contact_um).norm() > retreat_um(facts);
        match places_um.iter().any(is_far) {
            true => Err(TipHit { time_ns: *time_ns, distance_um: facts.tip_radius_um, due_um: clear_um(facts) }),
            false => Ok(()),
        }
    }
}

/// Distance from its contact within which a tip may be nearer to the part than its clearance.
fn retreat_um(facts: &FingersFacts) -> f64 {
    facts.retract_um.max(facts.clearance_um) + facts.tolerance_um
}
