//! Distances of robots from obstacles, from one another, and from the discs of orbits.
//!
//! Input: the trains of a run, with the motion of each robot. Output: every approach below the clearance. A robot that
//! keeps its arm down for a whole turn or more, over legs without a wait between them, orbits: it occupies the whole
//! disc about the centre of its circle for that time. Two robots may come nearer than the clearance if one of them is
//! on the last section of its path before it docks, and the other one is docked by then. Promise: that of `sweep`;
//! paths are examined as they are driven, with all robots at the same fraction of the same train. Cost: for each train
//! the pairs of robots and the obstacles near each; few evaluations where there is ample room.

use super::super::ReplayStop;
use super::super::boxes::{Extent, GroupedBoxes};
use super::super::geometry::solid::Solid;
use super::super::rule::{Findings, Rule, Violation, ms};
use super::bodies::JudgedBody;
use super::motion::TrainMotion;
use super::sweep::{BudgetExceeded, Evaluations, ROUNDING_UM, SweptGap, SweptTouch};
use super::{JudgedBed, JudgedTrain};
use crate::quantity::digits;
use nalgebra::Point2;
use rustc_hash::FxHashSet;
use std::f64::consts::TAU;

/// Shortfall of a turn that still counts as a whole turn, for rounding.
const ROUNDING_TURN_RAD: f64 = 1e-9;

/// Margin added to a body when boxes are compared, so that rounding cannot hide a contact.
const BOX_MARGIN_UM: f64 = 1e-3;

/// The disc that an orbiting robot occupies.
#[derive(Debug, Clone, Copy)]
struct TakenDisc {
    centre: Point2<f64>,
    reach_um: f64,
}

/// Key of a violation that is reported at most once in a run: the rule, a robot, and another robot or an obstacle.
type ReportedMeeting = (Rule, usize, usize);

/// Checks all trains of a run.
///
/// # Errors
/// If the run cannot be judged in a reasonable time.
pub(super) fn check(bed: &JudgedBed, findings: &mut Findings) -> Result<(), ReplayStop> {
    let mut checker = ClearanceChecker::new(bed, findings);
    let orbits = orbits(bed);
    for (index, train) in bed.trains.iter().enumerate() {
        let checked = checker.train(index, train, &orbits[index]);
        checked.map_err(|BudgetExceeded| {
            let at_ns = train.leg.train_ns;
            let title = format!(
                "the clearance check ran out of its evaluation budget at {}: bodies stay too close to their limits",
                ms(at_ns)
            );
            bed.run.violation(Rule::Meet, train.nth, at_ns, title)
        })?;
    }
    Ok(())
}

/// For each train, the robots that orbit in it with their discs.
fn orbits(bed: &JudgedBed) -> Vec<Vec<(usize, TakenDisc)>> {
    let mut orbits: Vec<Vec<(usize, TakenDisc)>> = vec![Vec::new(); bed.trains.len()];
    for robot in 0..bed.places.len() {
        let turns = |train: &JudgedTrain| train.motions[robot].curve_um.filter(|_| train.motions[robot].path_um > 0.0);
        let goes_on = |one: &JudgedTrain, other: &JudgedTrain| {
            one.waits == other.waits && turns(one).is_some() && turns(other).is_some()
        };
        let mut first = 0;
        for stretch in bed.trains.chunk_by(goes_on) {
            let trains = first..first + stretch.len();
            first = trains.end;
            let Some(curve_um) = stretch.first().and_then(turns) else { continue };
            let path_um: f64 = stretch.iter().map(|train| train.motions[robot].path_um).sum();
            if path_um / curve_um.abs() >= TAU + ROUNDING_TURN_RAD {
                let motion = &stretch[0].motions[robot];
                let disc =
                    TakenDisc { centre: motion.start.centre(curve_um), reach_um: motion.disc_radius_um(curve_um) };
                trains.for_each(|train| orbits[train].push((robot, disc)));
            }
        }
    }
    orbits
}

/// The clearance checks of a run, train by train.
pub(super) struct ClearanceChecker<'b, 'r, 'a, 'f> {
    bed: &'b JudgedBed<'r, 'a>,
    findings: &'f mut Findings,
    pub solids: Vec<Solid>,
    boxes: GroupedBoxes,
    evaluations: Evaluations,
    reported: FxHashSet<ReportedMeeting>,
}

impl<'b, 'r, 'a, 'f> ClearanceChecker<'b, 'r, 'a, 'f> {
    pub fn new(bed: &'b JudgedBed<'r, 'a>, findings: &'f mut Findings) -> Self {
        let placed = bed.order.obstacles.iter().map(|obstacle| Solid::of(&obstacle.shape, &obstacle.pose));
        let solids: Vec<Solid> = placed.map(|body| body.expect("the premise knows every shape")).collect();
        let boxes = GroupedBoxes::new(solids.iter().map(Solid::extent));
        ClearanceChecker {
            bed,
            findings,
            solids,
            boxes,
            evaluations: Evaluations::default(),
            reported: FxHashSet::default(),
        }
    }

    fn train(
        &mut self,
        index: usize,
        train: &JudgedTrain,
        orbits: &[(usize, TakenDisc)],
    ) -> Result<(), BudgetExceeded> {
        for (robot, motion) in train.motions.iter().enumerate().filter(|(_, motion)| motion.path_um > 0.0) {
            self.obstacles(train, robot, motion)?;
        }
        for one in 0..train.motions.len() {
            for other in one + 1..train.motions.len() {
                self.pair(index, train, [one, other])?;
            }
        }
        for (place, (robot, disc)) in orbits.iter().enumerate() {
            self.obstacles_of_orbit(train, *robot, disc);
            orbits[place + 1..].iter().for_each(|(other, guest)| self.orbits(train, *robot, disc, *other, guest));
            let orbiting = |other: usize| orbits.iter().any(|(orbiting, _)| *orbiting == other);
            for other in (0..train.motions.len()).filter(|other| !orbiting(*other)) {
                self.guest(train, *robot, disc, other)?;
            }
        }
        Ok(())
    }

    /// Indices of the obstacles that may be nearer than a distance to a point.
    pub fn about(&self, centre: Point2<f64>, within_um: f64) -> Vec<usize> {
        self.boxes.meeting(&Extent::of(&[centre]).widened(within_um + BOX_MARGIN_UM))
    }

    /// A moving body keeps its clearance from obstacles.
    fn obstacles(&mut self, train: &JudgedTrain, robot: usize, motion: &TrainMotion) -> Result<(), BudgetExceeded> {
        let needed_um = self.bed.order.facts.clearance_um;
        let (centre, radius_um) = motion.disc([0.0, 1.0]);
        let (round, part) = motion.first_turn();
        self.findings.count_checks(Rule::Graze, self.solids.len());
        for obstacle in self.about(centre, radius_um + needed_um) {
            let meeting = (Rule::Graze, robot, obstacle);
            let solid = &self.solids[obstacle];
            let gap_um = |body: JudgedBody| solid.gap_um(&body.vertices());
            let swept = motion.curve_um.is_none().then(|| motion.body(0.0).stretched(motion.path_um));
            if self.reported.contains(&meeting) || swept.is_some_and(|swept| gap_um(swept) >= needed_um) {
                continue;
            }
            let at = |share| gap_um(round.body(share));
            let gap = SweptGap { at, floor: |_| f64::NEG_INFINITY, travel_um: round.travel_um() };
            if let Some(touch) = gap.below([0.0, 1.0], needed_um, &mut self.evaluations)? {
                let touch = SweptTouch { share: touch.share * part, ..touch };
                let name = &self.bed.order.obstacles[obstacle].name;
                let title = |at: &str| {
                    let (gap, needed) = (digits(touch.gap_um.max(0.0)), digits(needed_um));
                    format!(
                        "`{}` comes within {gap} um of `{name}` at {at}; at least {needed} um is needed",
                        self.bed.name(robot)
                    )
                };
                let violation = self.violation(meeting.0, train, touch.share, title);
                let violation = violation.label(self.bed.order.obstacles[obstacle].span, "this obstacle");
                self.report(meeting, violation);
            }
        }
        Ok(())
    }

    /// Two bodies of which at least one moves keep their clearance, except on the last stretch before docking.
    fn pair(&mut self, index: usize, train: &JudgedTrain, robots: [usize; 2]) -> Result<(), BudgetExceeded> {
        let motions = robots.map(|robot| &train.motions[robot]);
        let meeting = (Rule::Meet, robots[0], robots[1]);
        self.findings.count_checks(Rule::Meet, 1);
        if motions.iter().all(|motion| motion.path_um == 0.0) || self.reported.contains(&meeting) {
            return Ok(());
        }
        let facts = &self.bed.order.facts;
        let docking = self.docking_from(index, train, robots);
        let spans = [([0.0, docking], facts.clearance_um), ([docking, 1.0], -facts.docking.tolerance_um)];
        for (span, needed_um) in spans.into_iter().filter(|([from, to], _)| from < to) {
            if let Some(touch) = pair_gap(motions).below(span, needed_um, &mut self.evaluations)? {
                let [one, other] = robots.map(|robot| self.bed.name(robot));
                let title = |at: &str| match needed_um < 0.0 {
                    true => {
                        let (depth, allowed) = (digits(-touch.gap_um), digits(-needed_um));
                        format!("`{one}` and `{other}` overlap by {depth} um at {at}; docking allows {allowed} um")
                    }
                    false => {
                        let (gap, needed) = (digits(touch.gap_um.max(0.0)), digits(needed_um));
                        format!(
                            "`{one}` and `{other}` come within {gap} um of each other at {at}; at least {needed} um is needed"
                        )
                    }
                };
                let violation = self.violation(meeting.0, train, touch.share, title);
                self.report(meeting, violation);
                return Ok(());
            }
        }
        Ok(())
    }

    /// The fraction of a train from which on two robots may touch; 1 if they may not.
    pub fn docking_from(&self, index: usize, train: &JudgedTrain, [one, other]: [usize; 2]) -> f64 {
        let fine = self.bed.order.facts.fine;
        let from = |robot: usize, other: usize| {
            let (docks, docked) = (self.bed.docked[robot]?, self.bed.docked[other]?);
            if docks <= index || (docked > index && docked != docks) {
                return None;
            }
            let before = self.bed.trains.get(docks).map_or(self.bed.strokes, |later| later.strokes_before);
            let left = before.saturating_sub(train.strokes_before) as f64;
            let stretch_um = fine.length_um + fine.cycle_um + ROUNDING_UM;
            let stretch = stretch_um / self.bed.order.robot(robot).step_um;
            Some(((left - stretch) / train.leg.strokes as f64).clamp(0.0, 1.0))
        };
        [from(one, other), from(other, one)].into_iter().flatten().fold(1.0, f64::min)
    }

    /// Obstacles keep clear of an orbit.
    fn obstacles_of_orbit(&mut self, train: &JudgedTrain, robot: usize, disc: &TakenDisc) {
        let needed_um = self.bed.order.facts.orbit_clearance_um;
        self.findings.count_checks(Rule::Orbit, self.solids.len());
        for obstacle in self.about(disc.centre, disc.reach_um + needed_um) {
            let solid = &self.solids[obstacle];
            let gap_um = solid.gap_um(&[disc.centre]) - disc.reach_um;
            // Indices of obstacles follow those of robots, so that keys do not collide.
            let meeting = (Rule::Orbit, robot, train.motions.len() + obstacle);
            if gap_um < needed_um - ROUNDING_UM && !self.reported.contains(&meeting) {
                let name = format!("`{}`", self.bed.order.obstacles[obstacle].name);
                let violation = self.orbit(train, robot, &name, SweptTouch { share: 0.0, gap_um });
                let violation = violation.label(self.bed.order.obstacles[obstacle].span, "this obstacle");
                self.report(meeting, violation);
            }
        }
    }

    /// Two orbits keep clear of each other.
    fn orbits(&mut self, train: &JudgedTrain, robot: usize, disc: &TakenDisc, other: usize, guest: &TakenDisc) {
        let needed_um = self.bed.order.facts.orbit_clearance_um;
        let gap_um = (disc.centre - guest.centre).norm() - disc.reach_um - guest.reach_um;
        let meeting = (Rule::Orbit, robot, other);
        self.findings.count_checks(Rule::Orbit, 1);
        if gap_um < needed_um - ROUNDING_UM && !self.reported.contains(&meeting) {
            let name = format!("that of `{}`", self.bed.name(other));
            let violation = self.orbit(train, robot, &name, SweptTouch { share: 0.0, gap_um });
            self.report(meeting, violation);
        }
    }

    /// A robot that does not orbit keeps clear of an orbit, whether it moves or not.
    fn guest(
        &mut self,
        train: &JudgedTrain,
        robot: usize,
        disc: &TakenDisc,
        other: usize,
    ) -> Result<(), BudgetExceeded> {
        let meeting = (Rule::Orbit, robot, other);
        self.findings.count_checks(Rule::Orbit, 1);
        if self.reported.contains(&meeting) {
            return Ok(());
        }
        let motion = &train.motions[other];
        let gap = SweptGap {
            at: |share| motion.body(share).point_gap_um(disc.centre) - disc.reach_um,
            floor: |span| {
                let (centre, radius_um) = motion.disc(span);
                (centre - disc.centre).norm() - radius_um - disc.reach_um
            },
            travel_um: motion.travel_um(),
        };
        if let Some(touch) = gap.below([0.0, 1.0], self.bed.order.facts.orbit_clearance_um, &mut self.evaluations)? {
            let name = format!("`{}`", self.bed.name(other));
            let violation = self.orbit(train, robot, &name, touch);
            self.report(meeting, violation);
        }
        Ok(())
    }

    fn orbit(&self, train: &JudgedTrain, robot: usize, name: &str, touch: SweptTouch) -> Violation {
        let needed = digits(self.bed.order.facts.orbit_clearance_um);
        let (owner, gap) = (self.bed.name(robot), digits(touch.gap_um.abs()));
        let how = match touch.gap_um < 0.0 {
            true => format!("overlaps {name} by {gap} um"),
            false => format!("lies {gap} um from {name}"),
        };
        self.violation(Rule::Orbit, train, touch.share, |at| {
            format!("the orbit of `{owner}` {how} at {at}; at least {needed} um is needed")
        })
    }

    /// A violation at a fraction of a train.
    fn violation(&self, rule: Rule, train: &JudgedTrain, share: f64, title: impl FnOnce(&str) -> String) -> Violation {
        let stroke = (share * train.leg.strokes as f64) as u64;
        let after_ns = stroke.saturating_mul(self.bed.order.facts.period_ns);
        let time_ns = train.leg.train_ns.saturating_add(after_ns);
        self.bed.run.violation(rule, train.nth, time_ns, title(&ms(time_ns)))
    }

    fn report(&mut self, meeting: ReportedMeeting, violation: Violation) {
        self.reported.insert(meeting);
        self.findings.push(violation);
    }
}

/// The distance between two bodies during a train.
pub(super) fn pair_gap<'t>(
    [one, other]: [&'t TrainMotion; 2],
) -> SweptGap<impl Fn(f64) -> f64 + 't, impl Fn([f64; 2]) -> f64 + 't> {
    SweptGap {
        at: |share| one.body(share).gap_um(&other.body(share)),
        floor: |span| {
            let ((a, a_um), (b, b_um)) = (one.disc(span), other.disc(span));
            (a - b).norm() - a_um - b_um
        },
        travel_um: match (one.shift(), other.shift()) {
            (Some(shift), Some(other)) => (shift - other).norm(),
            (Some(_) | None, Some(_) | None) => one.travel_um() + other.travel_um(),
        },
    }
}
