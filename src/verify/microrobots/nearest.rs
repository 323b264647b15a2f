//! Least distances of robots from obstacles and from one another, for the evidence.
//!
//! Paths are followed as in [`super::clearance`], whose rules hold before this module is called. A path that cannot be
//! bounded at once is bisected, until no part of it can be nearer than the least known distance by more than a
//! tolerance. A run that needs very many evaluations is measured more coarsely, and the evidence states the error
//! bound.

use super::JudgedBed;
use super::JudgedTrain;
use super::bodies::JudgedBody;
use super::clearance::{ClearanceChecker, pair_gap};
use super::motion::TrainMotion;
use super::sweep::SweptGap;
use crate::verify::evidence::{Clearance, GapUnit};
use crate::verify::geometry::convex::nearest_points;
use crate::verify::rule::{Findings, Rule};
use nalgebra::Point2;

/// Initial tolerance of a distance, and the factor by which it grows each time that the evaluations run out.
const TOLERANCE_UM: f64 = 0.01;
const COARSER: f64 = 10.0;

/// Evaluations per tolerance in a run.
const EVALUATIONS: u64 = 1 << 17;

/// The search for the least distances of a run.
struct Nearest<'w, 'b, 'r, 'a, 'f> {
    checker: &'w ClearanceChecker<'b, 'r, 'a, 'f>,
    bed: &'b JudgedBed<'r, 'a>,
    tolerance_um: f64,
    evaluations: u64,
}

/// Records the least distances of a run without clearance violations.
pub(super) fn note(bed: &JudgedBed, findings: &mut Findings) {
    let checker = ClearanceChecker::new(bed, findings);
    let mut nearest = Nearest { checker: &checker, bed, tolerance_um: TOLERANCE_UM, evaluations: EVALUATIONS };
    for (index, train) in nearest.bed.trains.iter().enumerate() {
        for (robot, motion) in train.motions.iter().enumerate().filter(|(_, motion)| motion.path_um > 0.0) {
            nearest.obstacles(train, robot, motion);
        }
        for one in 0..train.motions.len() {
            for other in one + 1..train.motions.len() {
                nearest.pair(index, train, [one, other]);
            }
        }
    }
    // Parts of paths that were pruned may be nearer by as much as the coarsest tolerance.
    let (tally, device) = (&nearest.bed.run.tally, &nearest.bed.run.job.device);
    for rule in [Rule::Graze, Rule::Meet] {
        tally.widen_error(rule, device, nearest.tolerance_um);
    }
}

impl Nearest<'_, '_, '_, '_, '_> {
    fn least_um(&self, rule: Rule) -> f64 {
        self.bed.run.tally.least(rule, &self.bed.run.job.device)
    }

    fn obstacles(&mut self, train: &JudgedTrain, robot: usize, motion: &TrainMotion) {
        let (centre, radius_um) = motion.disc([0.0, 1.0]);
        let (round, part) = motion.first_turn();
        for obstacle in self.checker.about(centre, radius_um + self.least_um(Rule::Graze)) {
            let solid = &self.checker.solids[obstacle];
            let gap_um = |body: JudgedBody| solid.gap_um(&body.vertices());
            let below_um = self.least_um(Rule::Graze);
            if motion.curve_um.is_none() && gap_um(motion.body(0.0).stretched(motion.path_um)) >= below_um {
                continue;
            }
            let gap = SweptGap {
                at: |share| gap_um(round.body(share)),
                floor: |_| f64::NEG_INFINITY,
                travel_um: round.travel_um(),
            };
            let Some((share, least_um)) = self.least(&gap, [0.0, 1.0], below_um) else { continue };
            let body = round.body(share).vertices();
            let Some([on_solid, on_body]) = solid.nearest_points(&body) else { continue };
            let between = [self.bed.name(robot), &self.bed.order.obstacles[obstacle].name].map(str::to_owned);
            self.keep(Rule::Graze, between, train, share * part, least_um, [on_body, on_solid]);
        }
    }

    fn pair(&mut self, index: usize, train: &JudgedTrain, robots: [usize; 2]) {
        let motions = robots.map(|robot| &train.motions[robot]);
        let until = self.checker.docking_from(index, train, robots);
        if motions.iter().all(|motion| motion.path_um == 0.0) || until <= 0.0 {
            return;
        }
        let Some((share, least_um)) = self.least(&pair_gap(motions), [0.0, until], self.least_um(Rule::Meet)) else {
            return;
        };
        let [one, other] = motions.map(|motion| motion.body(share).vertices());
        let Some(points) = nearest_points(&one, &other) else { return };
        self.keep(Rule::Meet, robots.map(|robot| self.bed.name(robot).to_owned()), train, share, least_um, points);
    }

    /// The least distance within a span of a path, and the fraction at which it occurs, as (fraction, distance);
    /// `None` if it is not below a limit.
    fn least<G, F>(&mut self, gap: &SweptGap<G, F>, span: [f64; 2], below_um: f64) -> Option<(f64, f64)>
    where
        G: Fn(f64) -> f64,
        F: Fn([f64; 2]) -> f64,
    {
        let mut least = None;
        let mut below_um = below_um;
        if (gap.floor)(span) >= below_um - self.tolerance_um {
            return None;
        }
        let mut open = vec![span];
        // The ends are evaluated as well, because the least distance is often there.
        for share in span {
            let gap_um = (gap.at)(share);
            if gap_um < below_um {
                (below_um, least) = (gap_um, Some((share, gap_um)));
            }
        }
        while let Some([from, to]) = open.pop() {
            if (gap.floor)([from, to]) >= below_um - self.tolerance_um {
                continue;
            }
            self.look();
            let share = f64::midpoint(from, to);
            let gap_um = (gap.at)(share);
            if gap_um < below_um {
                (below_um, least) = (gap_um, Some((share, gap_um)));
            }
            let lost_um = gap.travel_um * (to - from) / 2.0;
            let is_whole = share <= from || to <= share;
            if !is_whole && gap_um - lost_um < below_um - self.tolerance_um {
                open.extend([[share, to], [from, share]]);
            }
        }
        least
    }

    /// Counts an evaluation. When all are used, the rest of the run is measured more coarsely.
    fn look(&mut self) {
        match self.evaluations.checked_sub(1) {
            Some(left) => self.evaluations = left,
            None => (self.tolerance_um, self.evaluations) = (self.tolerance_um * COARSER, EVALUATIONS),
        }
    }

    fn keep(
        &self,
        rule: Rule,
        between: [String; 2],
        train: &JudgedTrain,
        share: f64,
        gap_um: f64,
        points: [Point2<f64>; 2],
    ) {
        let facts = &self.bed.order.facts;
        let train_ns = (train.leg.strokes as f64 * facts.period_ns as f64 * share).round() as u64;
        self.bed.run.tally.near(Clearance {
            rule,
            device: self.bed.run.job.device.clone(),
            between,
            apart: gap_um,
            needed: facts.clearance_um,
            error_bound: self.tolerance_um,
            unit: GapUnit::Micrometres,
            t_ns: train.leg.train_ns.saturating_add(train_ns),
            points: points.map(|point| [point.x, point.y, 0.0]),
        });
    }
}
