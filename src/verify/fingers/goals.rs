//! Checks the result of each step of a hand against its goal.

use super::super::rule::{Findings, Rule};
use super::Point;
use super::hand::{JudgedHand, nominal_step_rad, planes_after};
use crate::claims::fingers::FingersAction;
use crate::device::fingers::Plane;
use crate::quantity::{count, digits};
use crate::schedule::Reached;
use nalgebra::{Quaternion, UnitQuaternion};

/// Rounding tolerance of positions (um) and turns (rad).
const ROUNDING: f64 = 1e-6;

/// Tolerance between a recorded turn and the turn in the replay, in degrees.
const REPORTED_TURN_DEG: f64 = 0.01;

/// Greatest turn of a part that should not turn, as a fraction of a step of rotation.
const STEADY: f64 = 1e-3;

impl JudgedHand<'_, '_> {
    /// Checks a finished step against its goal in the task.
    pub(super) fn check_goal(&self, nth: usize, findings: &mut Findings) {
        let fault = match &self.order.steps[nth].action {
            FingersAction::Grasp(contacts) => {
                self.grasp_fault(nth, contacts.as_deref()).or_else(|| self.turn_fault(None))
            }
            FingersAction::Rotate { plane, angle_rad, .. } => self.turn_fault(Some((*plane, *angle_rad))),
            FingersAction::Orient { goal, .. } => self.orientation_fault(*goal),
            FingersAction::Translate(by_um) => self.place_fault(Point::from(*by_um)).or_else(|| self.turn_fault(None)),
            FingersAction::Release => self.release_fault(),
            FingersAction::Wait(duration_ns) => return self.run.wait_lasts(nth, *duration_ns, findings),
        };
        let by_um = match &self.order.steps[nth].action {
            FingersAction::Translate(_) => return self.report(fault, nth, findings),
            FingersAction::Grasp(_)
            | FingersAction::Rotate { .. }
            | FingersAction::Orient { .. }
            | FingersAction::Release
            | FingersAction::Wait(_) => Point::zeros(),
        };
        self.report(fault.or_else(|| self.place_fault(by_um)), nth, findings);
        self.check_reported_turn(nth, findings);
    }

    /// A recorded turn equals the replayed one.
    fn check_reported_turn(&self, nth: usize, findings: &mut Findings) {
        let FingersAction::Rotate { plane, .. } = &self.order.steps[nth].action else { return };
        let turned_deg = self.since.turn_rad(*plane).to_degrees();
        for reached in &self.run.step(nth).reached {
            let Reached::Turn { reached_deg, .. } = reached else { continue };
            findings.count_checks(Rule::Figure, 1);
            if (reached_deg - turned_deg).abs() > REPORTED_TURN_DEG {
                let title =
                    format!("a turn is recorded as {reached_deg} deg, but the tips turn the part by {turned_deg} deg");
                findings.push(self.run.violation(Rule::Figure, nth, self.end_ns(nth), title));
            }
        }
    }

    fn report(&self, fault: Option<String>, nth: usize, findings: &mut Findings) {
        findings.count_checks(Rule::Goal, 1);
        if let Some(title) = fault {
            findings.push(self.run.violation(Rule::Goal, nth, self.end_ns(nth), title));
        }
    }

    fn grasp_fault(&self, nth: usize, contacts: Option<&[u32]>) -> Option<String> {
        let holding = self.grip.holds.len();
        if holding < 2 {
            return Some(format!("a grasp ends with {} on the part; 2 or 3 are needed", count(holding, "finger")));
        }
        let contacts = contacts?;
        let planes = planes_after(self.order, nth);
        let found: Vec<Vec<u32>> = planes.into_iter().filter_map(|plane| self.contacts(plane)).collect();
        if found.iter().any(|found| found == contacts) {
            return None;
        }
        let listed = |contacts: &[u32]| contacts.iter().map(u32::to_string).collect::<Vec<_>>().join(", ");
        let found = found
            .first()
            .map_or("no contacts of the plane".to_owned(), |found| format!("the contacts ({})", listed(found)));
        Some(format!("a grasp ends on {found}; the program asks for ({})", listed(contacts)))
    }

    /// The part has turned by the requested angle, and about no other axis.
    fn turn_fault(&self, asked: Option<(Plane, f64)>) -> Option<String> {
        for plane in self.body.planes() {
            let turn_rad = self.since.turn_rad(plane);
            let steady_rad = STEADY * nominal_step_rad(&self.order.facts);
            let (goal_rad, within_rad) = match asked {
                Some((asked, goal_rad)) if asked == plane => (goal_rad, self.order.precision_rad + ROUNDING),
                Some(_) | None => (0.0, steady_rad),
            };
            if (turn_rad - goal_rad).abs() > within_rad {
                let [turn, goal, within] =
                    [turn_rad, goal_rad, within_rad].map(|angle_rad| digits(angle_rad.to_degrees()));
                let name = plane.name();
                return Some(format!(
                    "the part turns by {turn} deg in {name}; it must turn by {goal} deg, within {within} deg"
                ));
            }
        }
        None
    }

    fn orientation_fault(&self, [w, x, y, z]: [f64; 4]) -> Option<String> {
        let goal = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
        let off_rad = self.grip.pose().orientation.angle_to(&goal);
        let within_rad = self.order.precision_rad;
        let [off, within] = [off_rad, within_rad].map(|angle_rad| digits(angle_rad.to_degrees()));
        (off_rad > within_rad + ROUNDING)
            .then(|| format!("the part ends {off} deg from its goal orientation; at most {within} deg is allowed"))
    }

    /// The part's origin has moved as requested.
    fn place_fault(&self, by_um: Point) -> Option<String> {
        let off_um = (self.grip.pose().position_um - self.since.pose.position_um - by_um).norm();
        let within_um = self.order.facts.tolerance_um;
        (off_um > within_um + ROUNDING).then(|| {
            format!(
                "the part ends {} um from where it must be; at most {} um is allowed",
                digits(off_um),
                digits(within_um)
            )
        })
    }

    fn release_fault(&self) -> Option<String> {
        let holding = self.grip.holds.len();
        (holding > 0).then(|| format!("the part is held by {} after a release", count(holding, "finger")))
    }
}
