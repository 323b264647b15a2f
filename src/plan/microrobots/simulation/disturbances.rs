//! Disturbances beyond the bounds of the device: late, lost and wrong measurements, robots that stall or slip.
//!
//! They are drawn from a random stream of their own, so that a trial without them is what it was.

use super::trial::Trial;
use crate::geometry::Pose;
use crate::random::SplitMix64;
use std::f64::consts::PI;

/// Greatest displacement of a wrong measurement along x and along y.
const WRONG_UM: f64 = 500.0;

/// Greatest displacement of a slip along x and along y, and its greatest turn.
const SLIP_UM: f64 = 10.0;
const SLIP_RAD: f64 = 0.05;

/// Separates the random stream of the disturbances from that of the errors.
const OWN_STREAM: u64 = 0x005E_ED0F_D157;

/// Disturbances, each with its size or frequency.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Disturbances {
    /// Delay from a measurement to its command; the bed holds still meanwhile.
    pub delay_ns: u64,
    /// Share of the measured poses of each robot that are lost.
    pub lost: f64,
    /// Share of them that are off by up to 0.5 mm and any angle.
    pub wrong: f64,
    /// Share of the intervals in which a robot does not move.
    pub stalls: f64,
    /// Share of the intervals before which a robot slips by up to 10 um and 3 deg.
    pub slips: f64,
}

/// The bed as a disturbed camera sees it.
#[derive(Debug, Clone)]
pub struct DisturbedView {
    disturbances: Disturbances,
    random: SplitMix64,
}

impl DisturbedView {
    pub fn new(disturbances: Disturbances, seed: u64, index: u64) -> Self {
        DisturbedView { disturbances, random: SplitMix64::stream(seed ^ OWN_STREAM, index) }
    }

    pub fn delay_ns(&self) -> u64 {
        self.disturbances.delay_ns
    }

    /// Draws which robots stall or slip until the next measurement.
    pub fn disturb(&mut self, trial: &mut Trial) {
        for robot in 0..trial.poses.len() {
            trial.stalled[robot] = self.happens(self.disturbances.stalls);
            if self.happens(self.disturbances.slips) && !trial.docked[robot] {
                let pose = &mut trial.poses[robot];
                pose.x_um += SLIP_UM * self.random.signed_unit();
                pose.y_um += SLIP_UM * self.random.signed_unit();
                pose.heading_rad += SLIP_RAD * self.random.signed_unit();
            }
        }
    }

    /// A measured pose after the disturbances; `None` if it is lost.
    pub fn seen(&mut self, pose: Pose) -> Option<Pose> {
        if self.happens(self.disturbances.lost) {
            return None;
        }
        if !self.happens(self.disturbances.wrong) {
            return Some(pose);
        }
        Some(Pose {
            x_um: pose.x_um + WRONG_UM * self.random.signed_unit(),
            y_um: pose.y_um + WRONG_UM * self.random.signed_unit(),
            heading_rad: pose.heading_rad + PI * self.random.signed_unit(),
        })
    }

    /// Whether something of this probability happens; nothing is drawn for what never does.
    fn happens(&mut self, share: f64) -> bool {
        share > 0.0 && self.random.unit() < share
    }
}
