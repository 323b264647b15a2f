//! Speed limits of the tips.
//!
//! All axes of a hand begin their lines at the same instants, so within a stretch a tip moves at constant velocity.
//! Three limits apply: that of a free tip, the lower one near the contact that it approaches or leaves, and that of a
//! holding tip. Near means within the retraction distance or the clearance, whichever is larger, without a break.
//! Whether a tip was approaching is known only once it touches, so its path is kept until then.

use super::Point;
use super::track::Stretch;
use crate::device::fingers::FingersFacts;
use std::mem::take;

/// Relative excess of speed that is tolerated, since durations are whole nanoseconds.
const TOO_FAST: f64 = 1e-6;

/// Rounding of the distance within which tips must be slow.
const NEAR_UM: f64 = 1e-6;

/// A straight segment of a tip's path; stretches in which it rests are left out.
#[derive(Debug, Clone, Copy)]
struct TipLeg {
    start_ns: u64,
    from_um: Point,
    to_um: Point,
    um_per_s: f64,
}

/// The path of a free finger since it left its last contact.
#[derive(Debug, Clone, Default)]
pub(super) struct TipPath {
    /// The contact that it left; `None` once it is far enough from it.
    left_um: Option<Point>,
    legs: Vec<TipLeg>,
}

/// A tip that is too fast.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SpeedExcess {
    pub time_ns: u64,
    pub um_per_s: f64,
    pub due_um_per_s: f64,
    /// Phase of the tip's motion, for messages.
    pub doing: &'static str,
}

impl TipLeg {
    fn of(stretch: &Stretch, finger: usize) -> TipLeg {
        let (from_um, to_um) = (stretch.from_um[finger], stretch.to_um[finger]);
        let seconds = (stretch.end_ns - stretch.start_ns) as f64 / 1e9;
        TipLeg { start_ns: stretch.start_ns, from_um, to_um, um_per_s: (to_um - from_um).norm() / seconds }
    }

    fn against(&self, due_um_per_s: f64, doing: &'static str) -> Result<(), SpeedExcess> {
        let &TipLeg { start_ns: time_ns, um_per_s, .. } = self;
        match um_per_s <= due_um_per_s * (1.0 + TOO_FAST) {
            true => Ok(()),
            false => Err(SpeedExcess { time_ns, um_per_s, due_um_per_s, doing }),
        }
    }

    /// Least distance of the segment from a point.
    fn off_um(&self, place_um: &Point) -> f64 {
        let (along_um, off_um) = (self.to_um - self.from_um, place_um - self.from_um);
        let square = along_um.norm_squared();
        let share = if square > 0.0 { (off_um.dot(&along_um) / square).clamp(0.0, 1.0) } else { 0.0 };
        (off_um - along_um * share).norm()
    }
}

/// Whether a distance from a contact is small enough for the lower speed limit.
fn is_near(distance_um: f64, facts: &FingersFacts) -> bool {
    distance_um < facts.retract_um.max(facts.clearance_um) - NEAR_UM
}

impl TipPath {
    /// The path of a finger that leaves a contact.
    pub fn from(left_um: Point) -> Self {
        TipPath { left_um: Some(left_um), legs: Vec::new() }
    }

    /// Checks the speed of a holding tip along a stretch.
    pub fn holds(stretch: &Stretch, finger: usize, facts: &FingersFacts) -> Result<(), SpeedExcess> {
        TipLeg::of(stretch, finger).against(facts.rolling_um_per_s, "holds")
    }

    /// Ends the flight of a tip without a contact, because the part moves or the run ends.
    pub fn settle(&mut self, facts: &FingersFacts) -> Result<(), SpeedExcess> {
        let legs = take(self).legs;
        legs.iter().try_for_each(|leg| leg.against(facts.speed_um_per_s, "is free"))
    }

    /// Checks the speed of a free tip along a stretch.
    pub fn follow(&mut self, stretch: &Stretch, finger: usize, facts: &FingersFacts) -> Result<(), SpeedExcess> {
        let leg = TipLeg::of(stretch, finger);
        if let Some(left_um) = self.left_um {
            self.left_um = Some(left_um).filter(|left_um| is_near((leg.to_um - left_um).norm(), facts));
            return leg.against(facts.approach_um_per_s, "leaves its contact");
        }
        self.legs.push(leg);
        leg.against(facts.speed_um_per_s.max(facts.approach_um_per_s), "is free")
    }

    /// Ends the flight at a contact: the tip must have been slow on the last section of its path, and no faster than a
    /// free one before.
    pub fn lands(&mut self, contact_um: &Point, facts: &FingersFacts) -> Result<(), SpeedExcess> {
        self.left_um = None;
        let legs = take(&mut self.legs);
        let outside = |leg: &TipLeg| !is_near((leg.from_um - contact_um).norm(), facts);
        let begin = legs.iter().rposition(outside).unwrap_or(0);
        legs.iter().enumerate().try_for_each(|(at, leg)| match at >= begin && is_near(leg.off_um(contact_um), facts) {
            true => leg.against(facts.approach_um_per_s, "approaches its contact"),
            false => leg.against(facts.speed_um_per_s, "is free"),
        })
    }
}
