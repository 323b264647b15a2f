//! Follows, stretch by stretch, which tips hold, come and leave.
//!
//! A free tip is placed at the instant at which a stretch ends with its centre one radius from an outline of the
//! resting part. A holding tip is removed when it moves off while others stay. Holding tips that move carry the part
//! along.

use super::super::clock::JudgedRun;
use super::super::evidence::{Clearance, GapUnit};
use super::super::rule::{Findings, Rule, Violation, ms};
use super::super::{InvalidClaims, ReplayStop, ReplayedState};
use super::body::{ObjectPose, PartOutlines, Surface};
use super::clearance::{self, Flight, TipHit};
use super::grip::JudgedGrip;
use super::speed::TipPath;
use super::states::{Due, Spans, chosen};
use super::statics::{ContactPoint, Statics, pull_off_un};
use super::track::{Stretch, Tracks};
use super::{Point, orientation_of};
use crate::claims::fingers::{FingersAction, FingersOrder, FingersTurn};
use crate::device::fingers::{FingersFacts, FingersOutcome, MAX_HOLDING, Plane};
use crate::quantity::digits;
use crate::schedule::State;
use crate::schedule::fingers::FingersState;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

/// How the part is held.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Held {
    /// By its support, and possibly by fingers that already touch.
    Supported,
    ByFingers,
}

/// The findings already reported for the current grip, so that each is reported once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ReportedGrip {
    Nothing,
    Weak,
}

/// Pose of the part at the beginning of a step, and its turns since then, by plane.
#[derive(Debug, Clone, Copy)]
pub(super) struct Since {
    pub pose: ObjectPose,
    pub turns_rad: [f64; 2],
}

impl Since {
    pub fn turn_rad(&self, plane: Plane) -> f64 {
        self.turns_rad[plane as usize]
    }
}

/// A hand during the replay of a run.
pub(super) struct JudgedHand<'r, 'a> {
    pub(super) run: &'r JudgedRun<'a>,
    pub(super) order: &'r FingersOrder,
    pub(super) body: PartOutlines,
    pub(super) grip: JudgedGrip,
    pub(super) since: Since,
    pub(super) tips_um: Vec<Point>,
    pub(super) flights: Vec<Flight>,
    pub(super) tip_paths: Vec<TipPath>,
    /// The last step for which a tip was reported as too fast.
    pub(super) last_speed_violation: Option<usize>,
    held: Held,
    reported: ReportedGrip,
    /// Turn of the grip at the start of the step or at the last change of plane, and the contact steps turned since.
    pub(super) leg_rad: f64,
    pub(super) leg_steps: i64,
    /// Contact steps of an earlier turn that the present one may continue.
    pub(super) before_steps: i64,
    /// End of the part's last motion in this step, or else the start of the step.
    pub(super) carried_ns: u64,
    pub(super) spans: Spans,
    pub(super) effort_rad: f64,
    reconfigurations: u64,
}

impl<'r, 'a> JudgedHand<'r, 'a> {
    /// The hand at the start of a run: as the device's last run left it, or with the part where the scene has it.
    pub fn new(
        run: &'r JudgedRun<'a>,
        order: &'r FingersOrder,
        tracks: &Tracks,
        left: Option<&State>,
    ) -> Result<Self, ReplayStop> {
        let facts = &order.facts;
        let body = PartOutlines::of(&order.part, facts.tip_radius_um);
        let body =
            body.ok_or_else(|| InvalidClaims("the claims have an outline that cannot be followed".to_owned()))?;
        let tips_um = tracks.start_um();
        let start = ObjectPose { position_um: Point::from(order.part.position_um), orientation: Default::default() };
        let plane = planes_after(order, 0).first().copied().unwrap_or(Plane::Xy);
        let mut grip = JudgedGrip::empty(plane, start, &body, facts.tip_radius_um);
        let mut before_steps = 0;
        if let Some(State::Fingers(FingersState { grasp, plane, position_um, orientation, angle_index, .. })) = left {
            let orientation = orientation_of(orientation).unwrap_or_default();
            let pose = ObjectPose { position_um: Point::from(*position_um), orientation };
            grip = JudgedGrip::empty(*plane, pose, &body, facts.tip_radius_um);
            let holding = grasp.iter().enumerate().filter(|(finger, contact)| **contact > 0 && *finger < tips_um.len());
            for (finger, _) in holding {
                grip.add(surface_of(&body, *plane)?, finger, &tips_um[finger]);
            }
            before_steps = angle_index.saturating_sub(1);
        }
        let held = if grip.holds.len() < 2 { Held::Supported } else { Held::ByFingers };
        Ok(JudgedHand {
            run,
            order,
            since: Since { pose: grip.pose(), turns_rad: [0.0; 2] },
            leg_rad: 0.0,
            body,
            grip,
            flights: vec![Flight::default(); tips_um.len()],
            tip_paths: vec![TipPath::default(); tips_um.len()],
            last_speed_violation: None,
            tips_um,
            held,
            reported: ReportedGrip::Nothing,
            leg_steps: 0,
            before_steps,
            carried_ns: run.plan.start_ns,
            spans: Spans::default(),
            effort_rad: 0.0,
            reconfigurations: 0,
        })
    }

    /// The end of a step.
    pub(super) fn end_ns(&self, nth: usize) -> u64 {
        self.run.step(nth).end_ns()
    }

    pub(super) fn is_release(&self, nth: usize) -> bool {
        matches!(self.order.steps[nth].action, FingersAction::Release)
    }

    pub(super) fn surface(&self) -> Result<&Surface, ReplayStop> {
        surface_of(&self.body, self.grip.plane)
    }

    /// Records the first state and reports every tip that is misplaced in it.
    pub fn begin(&mut self, findings: &mut Findings) {
        let start_ns = self.run.plan.start_ns;
        self.spans.begin(start_ns, Due::Always, self.views());
        self.spans.end(start_ns);
        // The load of this run may differ from that of the run before.
        if self.held == Held::ByFingers && !self.order.steps.is_empty() && !self.is_release(0) {
            self.check_hold(0, start_ns, findings);
        }
        if self.run.plan.duration_ns == 0 {
            return;
        }
        let pose = self.grip.pose();
        findings.count_checks(Rule::Pierce, self.tips_um.len());
        for finger in 0..self.tips_um.len() {
            if let Some(hit) = self.strays(finger, &pose, start_ns, &self.tips_um) {
                let title = self.near_part_message(finger, &hit);
                findings
                    .push(Violation::new(Rule::Pierce, start_ns, title).label(self.run.job.run_span, "in this run"));
            }
        }
        let (from_um, to_um) = (self.tips_um.clone(), self.tips_um.clone());
        let still = Stretch { start_ns, end_ns: start_ns, from_um, to_um };
        let due_um = clearance::apart_um(&self.order.facts) - self.order.facts.tolerance_um;
        for one in 0..self.tips_um.len() {
            for other in one + 1..self.tips_um.len() {
                let (apart_um, _) = clearance::least_um(&still, one, other);
                self.note_apart(&still, [one, other], apart_um, 0.0);
                if apart_um < due_um {
                    findings.push(Violation::new(
                        Rule::Apart,
                        start_ns,
                        self.near_tips_message([one, other], apart_um, start_ns),
                    ));
                }
            }
        }
    }

    /// Begins a step of the task.
    pub fn begin_step(&mut self, nth: usize) {
        self.since = Since { pose: self.grip.pose(), turns_rad: [0.0; 2] };
        self.carried_ns = self.run.step(nth).start_ns;
        // A step that does not turn keeps the angle of the last one that did.
        if self.leg_steps != 0 {
            self.before_steps = self.leg_steps;
        }
        (self.leg_rad, self.leg_steps) = (self.grip.turn_rad(), 0);
    }

    /// Ends a step of the task and checks its goal.
    pub fn finish_step(&mut self, nth: usize, findings: &mut Findings) {
        let end_ns = self.end_ns(nth);
        if self.grip.holds.len() >= 2 && !self.is_release(nth) {
            self.take_load(nth, end_ns, findings);
        }
        if matches!(self.order.steps[nth].action, FingersAction::Translate(_)) {
            self.spans.end(self.carried_ns);
            self.spans.begin(self.carried_ns, Due::Always, self.views());
        }
        for finger in 0..self.flights.len() {
            if let Some((time_ns, _)) = self.flights[finger].near.take() {
                let due_um = clearance::clear_um(&self.order.facts);
                let hit = TipHit { time_ns, distance_um: self.order.facts.tip_radius_um, due_um };
                let title = self.near_part_message(finger, &hit);
                findings.push(self.run.violation(Rule::Pierce, nth, time_ns, title));
            }
        }
        self.check_goal(nth, findings);
    }

    /// Ends the run.
    pub fn finish(&mut self, findings: &mut Findings) {
        if let Some(last) = self.order.steps.len().checked_sub(1) {
            self.settle_tip_paths(last, findings);
        }
    }

    /// Replays one stretch.
    pub fn follow(&mut self, nth: usize, stretch: &Stretch, findings: &mut Findings) -> Result<(), ReplayStop> {
        let due_um = clearance::apart_um(&self.order.facts) - self.order.facts.tolerance_um;
        let nearest = clearance::nearest(stretch)
            .inspect(|(pair, apart_um, share)| self.note_apart(stretch, *pair, *apart_um, *share));
        if let Some((pair, apart_um, share)) = nearest.filter(|near| near.1 < due_um) {
            let time_ns = stretch.instant_ns(share);
            findings.push(self.run.violation(
                Rule::Apart,
                nth,
                time_ns,
                self.near_tips_message(pair, apart_um, time_ns),
            ));
        }
        if matches!(self.order.steps[nth].action, FingersAction::Wait(_)) {
            self.check_still(nth, stretch)?;
        }
        for finger in self.leaving(nth, stretch) {
            self.remove(nth, finger, stretch, findings)?;
        }
        self.tips_um.clone_from(&stretch.to_um);
        match self.grip.holds.iter().all(|hold| stretch.rests(hold.finger)) {
            true => self.rest(nth, stretch, findings),
            false => self.carry(nth, stretch, findings),
        }
    }

    /// Records the distance between two tips if it is less than all before.
    fn note_apart(&self, stretch: &Stretch, pair: [usize; 2], apart_um: f64, share: f64) {
        let JudgedHand { run, order, .. } = self;
        run.tally.count_checks(Rule::Apart, 1);
        let radius_um = order.facts.tip_radius_um;
        let [one, other] = pair.map(|finger| stretch.tip_um(finger, share));
        let way = (other - one).try_normalize(0.0).unwrap_or_default() * radius_um;
        run.tally.near(Clearance {
            rule: Rule::Apart,
            device: run.job.device.clone(),
            between: pair.map(|finger| format!("finger {}", finger + 1)),
            apart: apart_um - 2.0 * radius_um,
            needed: order.facts.clearance_um,
            error_bound: 0.0,
            unit: GapUnit::Micrometres,
            t_ns: stretch.instant_ns(share),
            points: [(one + way).into(), (other - way).into()],
        });
    }

    fn check_still(&self, nth: usize, stretch: &Stretch) -> Result<(), ReplayStop> {
        self.run.tally.count_checks(Rule::Wait, 1);
        let Some(finger) = (0..stretch.from_um.len()).find(|finger| !stretch.rests(*finger)) else { return Ok(()) };
        let title = format!("finger {} moves during a wait, at {}", finger + 1, ms(stretch.start_ns));
        Err(self.run.violation(Rule::Wait, nth, stretch.start_ns, title).into())
    }

    /// The holding fingers that leave in this stretch: those that move off while others stay.
    fn leaving(&self, nth: usize, stretch: &Stretch) -> Vec<usize> {
        let tolerance_um = self.order.facts.tolerance_um;
        let (pose, plane) = (self.grip.pose(), self.grip.plane);
        let goes_off = |finger: &usize| {
            let foot = self.body.foot(&pose, plane, &stretch.to_um[*finger], tolerance_um);
            foot.is_none_or(|foot| foot.distance_um > self.order.facts.tip_radius_um + tolerance_um)
        };
        let holding = self.grip.holds.iter().map(|hold| hold.finger);
        let moving: Vec<usize> = holding.filter(|finger| !stretch.rests(*finger)).collect();
        let off: Vec<usize> = moving.iter().copied().filter(goes_off).collect();
        let all_move = moving.len() == self.grip.holds.len() && moving.len() > 1;
        if all_move && !self.is_release(nth) { Vec::new() } else { off }
    }

    /// The fingers alone hold the part from now on.
    pub(super) fn take_load(&mut self, nth: usize, time_ns: u64, findings: &mut Findings) {
        if self.held == Held::Supported {
            self.held = Held::ByFingers;
            self.spans.settle();
            self.check_hold(nth, time_ns, findings);
        }
    }

    pub(super) fn statics(&self) -> Statics<'r> {
        Statics::of(self.order, self.grip.plane, &self.grip.pose(), self.body.reach_um)
    }

    pub(super) fn touches(&self) -> Vec<(usize, ContactPoint)> {
        self.grip.holds.iter().map(|hold| (hold.finger, ContactPoint::at(&hold.foot))).collect()
    }

    /// The holding fingers are in equilibrium.
    pub(super) fn check_hold(&mut self, nth: usize, time_ns: u64, findings: &mut Findings) {
        findings.count_checks(Rule::Equilibrium, 1);
        let touches: Vec<ContactPoint> = self.touches().into_iter().map(|(_, touch)| touch).collect();
        if self.reported == ReportedGrip::Weak || self.statics().holds(&touches) {
            return;
        }
        self.reported = ReportedGrip::Weak;
        let title = format!("{} are not in equilibrium at {}", self.holding(), ms(time_ns));
        findings.push(self.run.violation(Rule::Equilibrium, nth, time_ns, title));
    }

    fn remove(
        &mut self,
        nth: usize,
        finger: usize,
        stretch: &Stretch,
        findings: &mut Findings,
    ) -> Result<(), ReplayStop> {
        let time_ns = stretch.start_ns;
        if !self.is_release(nth) && self.grip.holds.len() >= 2 {
            self.take_load(nth, time_ns, findings);
        }
        self.spans.end(time_ns);
        let leaving = self.touches().into_iter().find(|touch| touch.0 == finger);
        self.check_contacts(nth, time_ns, findings);
        self.grip.remove(finger);
        self.flights[finger] = Flight::from(stretch.from_um[finger]);
        self.tip_paths[finger] = TipPath::from(stretch.from_um[finger]);
        self.reported = ReportedGrip::Nothing;
        if self.is_release(nth) || self.held == Held::Supported {
            return self.let_go(nth, stretch, findings);
        }
        findings.count_checks(Rule::Contact, 1);
        if self.grip.holds.len() < 2 {
            let title = format!("finger {} leaves the part to one finger at {}", finger + 1, ms(time_ns));
            return Err(self.run.violation(Rule::Contact, nth, time_ns, title).into());
        }
        self.check_hold(nth, time_ns, findings);
        if let Some((_, leaving)) = leaving.filter(|_| self.reported == ReportedGrip::Nothing) {
            self.check_removal(nth, finger, &leaving, time_ns, findings);
        }
        self.count_change();
        self.spans.begin(stretch.end_ns, Due::Always, self.views());
        Ok(())
    }

    fn count_change(&mut self) {
        self.reconfigurations += 1;
        self.effort_rad += self.order.facts.gaiting_cost_deg.to_radians();
    }

    fn check_removal(&self, nth: usize, finger: usize, leaving: &ContactPoint, time_ns: u64, findings: &mut Findings) {
        findings.count_checks(Rule::Removal, 1);
        let touches: Vec<ContactPoint> = self.touches().into_iter().map(|(_, touch)| touch).collect();
        if !self.statics().resists(&touches, leaving) {
            let facts = &self.order.facts;
            let (pull, safety) = (digits(pull_off_un(facts)), digits(facts.removal_safety));
            let title = format!(
                "{} do not resist {safety} times {pull} uN as finger {} leaves at {}",
                self.holding(),
                finger + 1,
                ms(time_ns)
            );
            findings.push(self.run.violation(Rule::Removal, nth, time_ns, title));
        }
    }

    /// A finger leaves a part that rests on its support.
    fn let_go(&mut self, nth: usize, stretch: &Stretch, findings: &mut Findings) -> Result<(), ReplayStop> {
        let facts = &self.order.facts;
        let pull_un = pull_off_un(facts) * facts.removal_safety;
        findings.count_checks(Rule::Support, 1);
        let is_enough = pull_un <= facts.support_un * (1.0 + super::statics::TOLERANCE);
        if !is_enough && self.reported == ReportedGrip::Nothing {
            self.reported = ReportedGrip::Weak;
            let (pull, support) = (digits(pull_un), digits(facts.support_un));
            let title =
                format!("the last fingers pull with {pull} uN, but the support holds the part with {support} uN");
            findings.push(self.run.violation(Rule::Support, nth, stretch.start_ns, title));
        }
        self.held = Held::Supported;
        let due = if self.grip.holds.is_empty() { Due::Always } else { Due::Perhaps };
        self.spans.begin(stretch.end_ns, due, self.views());
        Ok(())
    }

    /// Free fingers move past a resting part and may touch it at the end of the stretch.
    fn rest(&mut self, nth: usize, stretch: &Stretch, findings: &mut Findings) -> Result<(), ReplayStop> {
        let (pose, order) = (self.grip.pose(), self.order);
        for finger in 0..self.flights.len() {
            if self.grip.has(finger) || stretch.rests(finger) {
                continue;
            }
            findings.count_checks(Rule::Pierce, 1);
            let followed = self.flights[finger].follow(stretch, finger, &self.body, &pose, &order.facts);
            let kept = self.tip_paths[finger].follow(stretch, finger, &order.facts);
            self.report_speed(nth, finger, kept, findings);
            let touched = self.touched(nth, &stretch.to_um[finger], &stretch.to_um);
            if let Err(hit) = followed {
                self.flights[finger] = Flight::default();
                findings.push(self.run.violation(Rule::Pierce, nth, hit.time_ns, self.near_part_message(finger, &hit)));
            }
            if let Some(plane) = touched {
                self.place(nth, finger, plane, stretch, findings)?;
            }
        }
        Ok(())
    }

    /// The plane in which a tip touches the part together with the holding fingers.
    fn touched(&self, nth: usize, tip_um: &Point, tips_um: &[Point]) -> Option<Plane> {
        let wanted = if self.grip.holds.is_empty() { planes_after(self.order, nth) } else { Vec::new() };
        let planes = wanted.into_iter().chain([self.grip.plane]).chain(self.body.planes());
        let mut touched = planes.filter(|plane| self.touches_in(*plane, tip_um));
        touched.find(|plane| self.holds_in(*plane, tips_um))
    }

    pub(super) fn touches_in(&self, plane: Plane, tip_um: &Point) -> bool {
        let tolerance_um = self.order.facts.tolerance_um;
        let foot = self.body.foot(&self.grip.pose(), plane, tip_um, tolerance_um);
        foot.is_some_and(|foot| (foot.distance_um - self.order.facts.tip_radius_um).abs() <= tolerance_um)
    }

    /// Whether all holding fingers also touch the part's outline in a plane.
    pub(super) fn holds_in(&self, plane: Plane, tips_um: &[Point]) -> bool {
        plane == self.grip.plane || self.grip.holds.iter().all(|hold| self.touches_in(plane, &tips_um[hold.finger]))
    }

    fn place(
        &mut self,
        nth: usize,
        finger: usize,
        plane: Plane,
        stretch: &Stretch,
        findings: &mut Findings,
    ) -> Result<(), ReplayStop> {
        let time_ns = stretch.end_ns;
        findings.count_checks(Rule::Contact, 1);
        if self.grip.holds.len() == MAX_HOLDING {
            let title =
                format!("finger {} touches the part at {} while {MAX_HOLDING} others hold it", finger + 1, ms(time_ns));
            return Err(self.run.violation(Rule::Contact, nth, time_ns, title).into());
        }
        self.spans.end(time_ns.saturating_sub(1));
        if plane != self.grip.plane {
            self.change_plane(plane, &stretch.to_um)?;
        }
        let tip_um = stretch.to_um[finger];
        if let Err(hit) = self.flights[finger].lands(&tip_um, &self.order.facts) {
            findings.push(self.run.violation(Rule::Pierce, nth, hit.time_ns, self.near_part_message(finger, &hit)));
        }
        self.flights[finger] = Flight::default();
        let kept = self.tip_paths[finger].lands(&tip_um, &self.order.facts);
        self.report_speed(nth, finger, kept, findings);
        let surface = surface_of(&self.body, plane)?;
        self.grip.add(surface, finger, &tip_um);
        self.check_contacts(nth, time_ns, findings);
        self.reported = ReportedGrip::Nothing;
        let due = match self.held {
            Held::Supported => Due::Perhaps,
            Held::ByFingers => {
                self.check_hold(nth, time_ns, findings);
                self.count_change();
                Due::Always
            }
        };
        self.spans.begin(time_ns, due, self.views());
        Ok(())
    }

    /// Switches the grip to another plane with the same fingers; a new turn begins.
    pub(super) fn change_plane(&mut self, plane: Plane, tips_um: &[Point]) -> Result<(), ReplayStop> {
        let grip = self.grip.anew(plane, &self.body, tips_um);
        self.grip = grip.ok_or_else(|| InvalidClaims("the claims have no outline in a plane of a turn".to_owned()))?;
        (self.leg_rad, self.leg_steps, self.before_steps) = (0.0, 0, 0);
        Ok(())
    }

    /// Fingers come and leave only while all holding fingers are on numbered contacts.
    fn check_contacts(&self, nth: usize, time_ns: u64, findings: &mut Findings) {
        findings.count_checks(Rule::Contact, self.grip.holds.len());
        let Some(surface) = self.body.surface(self.grip.plane) else { return };
        for hold in &self.grip.holds {
            let (contact, off_um) = surface.contact(&hold.foot);
            if off_um > self.order.facts.tolerance_um {
                let title = format!(
                    "finger {} is {} um off contact {contact} as a finger arrives or leaves at {}",
                    hold.finger + 1,
                    digits(off_um),
                    ms(time_ns)
                );
                findings.push(self.run.violation(Rule::Contact, nth, time_ns, title));
                return;
            }
        }
    }

    /// A tip that is nearer to the part than permitted, if it is. For a holding tip the whole outline counts, not only
    /// its contact.
    pub(super) fn strays(&self, finger: usize, pose: &ObjectPose, time_ns: u64, tips_um: &[Point]) -> Option<TipHit> {
        let facts = &self.order.facts;
        let tip_um = &tips_um[finger];
        let (distance_um, due_um) = match self.grip.has(finger) {
            true => {
                let foot = self.body.foot(pose, self.grip.plane, tip_um, 3.0 * facts.tolerance_um)?;
                (foot.distance_um, facts.tip_radius_um)
            }
            false => {
                let due_um = clearance::clear_um(facts);
                (self.body.gap_um(pose, tip_um, facts.tolerance_um, due_um), due_um)
            }
        };
        (distance_um < due_um - facts.tolerance_um).then_some(TipHit { time_ns, distance_um, due_um })
    }

    /// The state at the end of the run, in the record's description.
    pub fn left(&self) -> State {
        let recorded = self.run.plan.states.last().map(|timed| &timed.state);
        chosen(self.views(), recorded)
    }

    pub fn outcomes(&self) -> BTreeMap<&'static str, f64> {
        BTreeMap::from([
            (FingersOutcome::Effort.name(), self.effort_rad),
            (FingersOutcome::Reconfigurations.name(), self.reconfigurations as f64),
            (FingersOutcome::Time.name(), self.run.plan.duration_ns as f64 / 1e9),
        ])
    }

    /// The states that the record should have.
    pub fn into_states(self) -> Vec<ReplayedState<'a>> {
        self.spans.states(self.run)
    }
}

/// The device's nominal step of rotation.
pub(super) fn nominal_step_rad(facts: &FingersFacts) -> f64 {
    TAU / f64::from(facts.steps_per_turn)
}

fn surface_of(body: &PartOutlines, plane: Plane) -> Result<&Surface, ReplayStop> {
    let surface = body.surface(plane);
    surface.ok_or_else(|| InvalidClaims("the claims have no outline in a plane of a turn".to_owned()).into())
}

/// The planes in which the contacts of a grasp may be numbered: those of the next turn, or of the last one if none
/// follows.
pub(super) fn planes_after(order: &FingersOrder, nth: usize) -> Vec<Plane> {
    let first = |action: &FingersAction| match action {
        FingersAction::Rotate { plane, .. } => vec![*plane],
        FingersAction::Orient { turns, .. } => ends(turns, |turns| turns.first()),
        FingersAction::Grasp(_) | FingersAction::Translate(_) | FingersAction::Release | FingersAction::Wait(_) => {
            Vec::new()
        }
    };
    let last = |action: &FingersAction| match action {
        FingersAction::Rotate { plane, .. } => vec![*plane],
        FingersAction::Orient { turns, .. } => ends(turns, |turns| turns.last()),
        FingersAction::Grasp(_) | FingersAction::Translate(_) | FingersAction::Release | FingersAction::Wait(_) => {
            Vec::new()
        }
    };
    let (before, after) = order.steps.split_at(nth.min(order.steps.len()));
    let next = after.iter().map(|step| first(&step.action)).find(|planes| !planes.is_empty());
    let mut last = before.iter().rev().map(|step| last(&step.action)).filter(|planes| !planes.is_empty());
    next.or_else(|| last.next()).unwrap_or_else(|| vec![Plane::Xy])
}

fn ends(turns: &[Vec<FingersTurn>], end: fn(&[FingersTurn]) -> Option<&FingersTurn>) -> Vec<Plane> {
    let mut planes: Vec<Plane> = turns.iter().filter_map(|turns| end(turns)).map(|turn| turn.plane).collect();
    planes.sort_unstable();
    planes.dedup();
    planes
}
