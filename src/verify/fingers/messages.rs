//! Descriptions of a hand's state and of its faults, for records and messages.

use super::super::rule::{Findings, Rule, ms};
use super::clearance::{self, TipHit};
use super::hand::JudgedHand;
use super::speed::SpeedExcess;
use crate::device::fingers::Plane;
use crate::quantity::digits;
use crate::schedule::State;
use crate::schedule::fingers::FingersState;

impl JudgedHand<'_, '_> {
    /// The holding fingers in words.
    pub(super) fn holding(&self) -> String {
        let contacts = self.contacts(self.grip.plane).unwrap_or_default();
        let contacts: Vec<String> = contacts.iter().map(u32::to_string).collect();
        format!("fingers on the contacts ({}) in {}", contacts.join(", "), self.grip.plane.name())
    }

    pub(super) fn near_part_message(&self, finger: usize, hit: &TipHit) -> String {
        let (distance, due) = (digits(hit.distance_um), digits(hit.due_um));
        let (finger, when) = (finger + 1, ms(hit.time_ns));
        format!("the tip of finger {finger} is {distance} um from the part at {when}; at least {due} um is needed")
    }

    pub(super) fn near_tips_message(&self, pair: [usize; 2], apart_um: f64, time_ns: u64) -> String {
        let due = digits(clearance::apart_um(&self.order.facts));
        let [one, other] = pair.map(|finger| finger + 1);
        let (apart, when) = (digits(apart_um), ms(time_ns));
        format!("the tips of fingers {one} and {other} are {apart} um apart at {when}; at least {due} um is needed")
    }

    /// Ends the flights of all free tips.
    pub(super) fn settle_tip_paths(&mut self, nth: usize, findings: &mut Findings) {
        for finger in 0..self.tip_paths.len() {
            let kept = self.tip_paths[finger].settle(&self.order.facts);
            self.report_speed(nth, finger, kept, findings);
        }
    }

    /// Reports the first tip of a step that is too fast.
    pub(super) fn report_speed(
        &mut self,
        nth: usize,
        finger: usize,
        kept: Result<(), SpeedExcess>,
        findings: &mut Findings,
    ) {
        findings.count_checks(Rule::Speed, 1);
        let Err(fast) = kept else { return };
        if self.last_speed_violation != Some(nth) {
            self.last_speed_violation = Some(nth);
            let [found, due] = [fast.um_per_s, fast.due_um_per_s].map(digits);
            let (finger, doing, when) = (finger + 1, fast.doing, ms(fast.time_ns));
            let title =
                format!("finger {finger} {doing} at {when} and moves at {found} um/s; at most {due} um/s is allowed");
            findings.push(self.run.violation(Rule::Speed, nth, fast.time_ns, title));
        }
    }

    /// The contact number of each finger in a plane, 0 for a free one; `None` unless all holding fingers touch the
    /// outline there.
    pub(super) fn contacts(&self, plane: Plane) -> Option<Vec<u32>> {
        let surface = self.body.surface(plane)?;
        if !self.holds_in(plane, &self.tips_um) {
            return None;
        }
        let mut contacts = vec![0; self.flights.len()];
        for hold in &self.grip.holds {
            let foot = match plane == self.grip.plane {
                true => hold.foot,
                false => {
                    let (place_um, _) = self.grip.pose().section_um(plane, &self.tips_um[hold.finger]);
                    surface.contour.foot(place_um)?
                }
            };
            contacts[hold.finger] = surface.contact(&foot).0;
        }
        Some(contacts)
    }

    /// All accepted descriptions of the present state. A turn may continue a finished one or be a new one, and grasps
    /// on the contacts that two sections share, or on none, have a description in both.
    pub(super) fn views(&self) -> Vec<State> {
        let angle_index = self.leg_steps.saturating_add(1);
        let going_on = angle_index.saturating_add(self.before_steps);
        let others = self.body.planes().filter(|plane| *plane != self.grip.plane);
        let elsewhere = others.flat_map(|plane| [(plane, 1), (plane, going_on)]);
        let own = [(self.grip.plane, angle_index), (self.grip.plane, going_on)];
        own.into_iter().chain(elsewhere).filter_map(|(plane, angle_index)| self.view(plane, angle_index)).collect()
    }

    fn view(&self, plane: Plane, angle_index: i64) -> Option<State> {
        let pose = self.grip.pose();
        let orientation = pose.orientation.into_inner();
        let sign = if orientation.w < 0.0 { -1.0 } else { 1.0 };
        let tip = |finger: usize| self.grip.has(finger).then(|| self.tips_um[finger].into());
        Some(State::Fingers(FingersState {
            grasp: self.contacts(plane)?,
            angle_index,
            plane,
            tips_um: (0..self.flights.len()).map(tip).collect(),
            position_um: pose.position_um.into(),
            orientation: [orientation.w, orientation.i, orientation.j, orientation.k].map(|value| value * sign),
        }))
    }
}
