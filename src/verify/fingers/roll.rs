//! Motion of holding tips: the part rolls between them or is carried along.
//!
//! The plane of rolling follows from the motion: if all holding tips touch both sections, it is the one that fits
//! better.

use super::super::ReplayStop;
use super::super::rule::{Findings, Rule, ms};
use super::Point;
use super::clearance::Flight;
use super::grip::RollingMisfit;
use super::hand::{JudgedHand, nominal_step_rad};
use super::speed::TipPath;
use super::states::Due;
use super::track::Stretch;
use crate::claims::fingers::FingersAction;
use crate::device::fingers::Plane;
use crate::quantity::digits;

/// The longest path of a tip from one sample of a rolling motion to the next, as a fraction of its radius.
const SAMPLE: f64 = 0.25;

/// Greatest number of samples of one stretch.
const MAX_SAMPLES: f64 = 2048.0;

/// Difference of misfits below which the plane of rolling is undecided.
const SAME_MISFIT_UM: f64 = 1e-9;

/// Greatest deviation of a turn from a whole number of steps, in steps.
const GRID_STEPS: f64 = 1e-3;

impl JudgedHand<'_, '_> {
    /// Moves holding tips along a stretch, and the part with them.
    pub(super) fn carry(&mut self, nth: usize, stretch: &Stretch, findings: &mut Findings) -> Result<(), ReplayStop> {
        let time_ns = stretch.start_ns;
        findings.count_checks(Rule::Slip, 1);
        if self.grip.holds.len() < 2 {
            let finger = self.grip.holds.first().map_or(0, |hold| hold.finger);
            let title = format!("finger {} alone moves along the part at {}", finger + 1, ms(time_ns));
            return Err(self.run.violation(Rule::Slip, nth, time_ns, title).into());
        }
        self.take_load(nth, time_ns, findings);
        self.spans.end(time_ns);
        self.flights.iter_mut().for_each(Flight::forget);
        self.check_carrying_pace(nth, stretch, findings);
        let plane = self.rolling_plane(nth, stretch);
        if plane != self.grip.plane {
            self.change_plane(plane, &stretch.from_um)?;
        }
        let before_rad = self.grip.turn_rad();
        let samples = self.samples(stretch);
        for sample in 1..=samples {
            self.sample(nth, stretch, sample as f64 / samples as f64, findings)?;
        }
        self.since.turns_rad[plane as usize] += self.grip.turn_rad() - before_rad;
        self.carried_ns = stretch.end_ns;
        self.count_steps(stretch.end_ns)
    }

    /// Number of samples of a stretch; even, so that the middle is one of them.
    fn samples(&self, stretch: &Stretch) -> u32 {
        let line_um = |finger: usize| (stretch.to_um[finger] - stretch.from_um[finger]).norm();
        let longest_um = self.grip.holds.iter().map(|hold| line_um(hold.finger)).fold(0.0, f64::max);
        let half = (longest_um / (2.0 * SAMPLE * self.order.facts.tip_radius_um)).ceil();
        2 * half.clamp(1.0, MAX_SAMPLES / 2.0) as u32
    }

    /// The plane in which tips roll: the present one, unless another one in which they touch fits their motion better.
    ///
    /// Tips that all move in parallel carry the part without rolling, in whatever plane they hold it; the plane then
    /// stays as it is.
    fn rolling_plane(&self, nth: usize, stretch: &Stretch) -> Plane {
        let way = |finger: usize| stretch.to_um[finger] - stretch.from_um[finger];
        let mut ways = self.grip.holds.iter().map(|hold| way(hold.finger));
        let first = ways.next();
        if first.is_none_or(|first| ways.all(|way| (way - first).norm() <= SAME_MISFIT_UM)) {
            return self.grip.plane;
        }
        let wanted = match &self.order.steps[nth].action {
            FingersAction::Rotate { plane, .. } => Some(*plane),
            FingersAction::Grasp(_)
            | FingersAction::Orient { .. }
            | FingersAction::Translate(_)
            | FingersAction::Release
            | FingersAction::Wait(_) => None,
        };
        let mut best = (self.grip.plane, f64::INFINITY);
        for plane in [self.grip.plane].into_iter().chain(wanted).chain(self.body.planes()) {
            if !self.holds_in(plane, &stretch.from_um) {
                continue;
            }
            let misfit_um = self.fit_um(plane, stretch).unwrap_or(f64::INFINITY);
            if misfit_um < best.1 - SAME_MISFIT_UM {
                best = (plane, misfit_um);
            }
        }
        best.0
    }

    /// Misfit of a stretch as a rolling motion in a plane; `None` if no such motion is found.
    fn fit_um(&self, plane: Plane, stretch: &Stretch) -> Option<f64> {
        let surface = self.body.surface(plane)?;
        let mut grip = match plane == self.grip.plane {
            true => self.grip.clone(),
            false => self.grip.anew(plane, &self.body, &stretch.from_um)?,
        };
        if self.body.planes().count() < 2 {
            return Some(0.0);
        }
        let samples = self.samples(stretch);
        let mut misfit_um = 0.0;
        for sample in 1..=samples {
            let share = f64::from(sample) / f64::from(samples);
            let (moved, misfit) = grip.follow(surface, &tips_at(stretch, share))?;
            (grip, misfit_um) = (moved, misfit.most_um());
        }
        Some(misfit_um)
    }

    /// Moves the part to a fraction of a stretch and checks all rules there.
    fn sample(&mut self, nth: usize, stretch: &Stretch, share: f64, findings: &mut Findings) -> Result<(), ReplayStop> {
        let (tips_um, time_ns) = (tips_at(stretch, share), stretch.instant_ns(share));
        findings.count_checks(Rule::Gap, self.grip.holds.len());
        findings.count_checks(Rule::Slip, self.grip.holds.len());
        findings.count_checks(Rule::Pierce, tips_um.len());
        let moved = self.grip.follow(self.surface()?, &tips_um);
        let Some((grip, misfit)) = moved else {
            let title = format!("no motion of the part fits the tips of {} at {}", self.holding(), ms(time_ns));
            return Err(self.run.violation(Rule::Gap, nth, time_ns, title).into());
        };
        self.check_misfit(nth, time_ns, &misfit)?;
        self.grip = grip;
        self.check_hold(nth, time_ns, findings);
        let pose = self.grip.pose();
        for finger in 0..tips_um.len() {
            if let Some(hit) = self.strays(finger, &pose, time_ns, &tips_um) {
                return Err(self
                    .run
                    .violation(Rule::Pierce, nth, time_ns, self.near_part_message(finger, &hit))
                    .into());
            }
        }
        Ok(())
    }

    fn check_misfit(&self, nth: usize, time_ns: u64, misfit: &RollingMisfit) -> Result<(), ReplayStop> {
        let tolerance_um = self.order.facts.tolerance_um;
        if misfit.most_um() <= tolerance_um {
            return Ok(());
        }
        let (allowed, when) = (digits(tolerance_um), ms(time_ns));
        let ((gapped, gap_um), (slipped, slip_um)) = (misfit.gap_um, misfit.slip_um);
        let violation = if gap_um.abs() >= slip_um.abs() {
            let way = if gap_um > 0.0 { "off" } else { "into" };
            let (finger, gap) = (gapped + 1, digits(gap_um.abs()));
            let title =
                format!("finger {finger} moves {gap} um {way} the part at {when}; at most {allowed} um is allowed");
            self.run.violation(Rule::Gap, nth, time_ns, title)
        } else {
            let (finger, slip) = (slipped + 1, digits(slip_um.abs()));
            let title = format!("finger {finger} slips by {slip} um at {when}; at most {allowed} um is allowed");
            self.run.violation(Rule::Slip, nth, time_ns, title)
        };
        Err(violation.into())
    }

    /// Counts the steps of a turn once it reaches a whole number of them.
    fn count_steps(&mut self, time_ns: u64) -> Result<(), ReplayStop> {
        let steps = (self.grip.turn_rad() - self.leg_rad) / self.surface()?.contact_step_rad();
        let whole = steps.round();
        if (steps - whole).abs() > GRID_STEPS || whole as i64 == self.leg_steps {
            return Ok(());
        }
        let rolled = (whole as i64).abs_diff(self.leg_steps);
        self.effort_rad += rolled as f64 * self.grip.holds.len() as f64 * nominal_step_rad(&self.order.facts);
        self.leg_steps = whole as i64;
        self.spans.begin(time_ns, Due::Always, self.views());
        Ok(())
    }

    /// Checks the speeds of all tips along a stretch in which holding tips move.
    fn check_carrying_pace(&mut self, nth: usize, stretch: &Stretch, findings: &mut Findings) {
        let facts = &self.order.facts;
        for finger in (0..self.tip_paths.len()).filter(|finger| !stretch.rests(*finger)) {
            let kept = match self.grip.has(finger) {
                true => TipPath::holds(stretch, finger, facts),
                false => self.tip_paths[finger].follow(stretch, finger, facts),
            };
            self.report_speed(nth, finger, kept, findings);
        }
        self.settle_tip_paths(nth, findings);
    }
}

fn tips_at(stretch: &Stretch, share: f64) -> Vec<Point> {
    (0..stretch.from_um.len()).map(|finger| stretch.tip_um(finger, share)).collect()
}
