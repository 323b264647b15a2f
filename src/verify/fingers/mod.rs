//! Replays the run of a hand from the positions of its stages alone.
//!
//! Input: a run whose steps and channels are sound. Output: its states and the outcomes. `track` assembles the axes;
//! `body` gives distances to the part's outlines; `grip` solves for the pose in which all holding tips touch and roll;
//! `hand` follows stretch by stretch which tips hold, come and leave; `statics` decides by linear programs whether
//! they hold the part; `clearance` checks distances of tips, and `speed` their speeds; `goals` checks each step against
//! the task, and `states` the changes against the record. Promise: the record is read only for comparison; the first
//! motion that does not roll ends the replay of its device. Equilibrium is checked after each finger that comes or
//! leaves. While tips roll, it is checked at both ends and the middle of each stretch, and between them often enough
//! that no tip moves more than a quarter of its radius from one sample to the next. Cost: for each sample a few
//! distances to the outline and one linear program.

mod body;
mod claims;
mod clearance;
mod goals;
mod grip;
mod hand;
mod messages;
mod roll;
mod speed;
mod states;
mod statics;
mod track;

use super::clock::JudgedRun;
use super::geometry::contour::Foot;
use super::rule::Findings;
use super::{InvalidClaims, Judge, JudgedState, LastStates, RecordTerms, Replay, ReplayStop};
use crate::claims::fingers::FingersOrder;
use crate::claims::{Claims, Order};
use crate::device::fingers::{FingersObjective, FingersOutcome, finger_axis};
use crate::quantity::digits;
use crate::schedule::fingers::FingersState;
use crate::schedule::{ChannelUnit, State};
use body::{ObjectPose, PartOutlines};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use statics::{ContactPoint, Statics};

/// A position or a direction in the hand's frame.
type Point = Vector3<f64>;

/// Tolerance of a recorded position.
const PLACE_TOLERANCE_UM: f64 = 1e-3;

/// Tolerance of a recorded orientation.
const TURN_TOLERANCE_RAD: f64 = 1e-4;

/// Normal force per finger in pictures, as a fraction of the greatest force of a finger.
const SHOWN_FORCE: f64 = 0.1;

impl Judge for FingersOrder {
    fn unit(&self, channel: &str) -> Option<ChannelUnit> {
        let (finger, _) = finger_axis(channel)?;
        (finger < self.facts.fingers as usize).then_some(ChannelUnit::Micrometre)
    }

    fn premise(&self) -> Result<(), InvalidClaims> {
        claims::check_claims(self)
    }

    fn has_facts_of(&self, other: &Order) -> bool {
        FingersOrder::of(other).is_some_and(|other| other.facts == self.facts)
    }

    fn has_parts_of(&self, other: &Order) -> bool {
        FingersOrder::of(other).is_some_and(|other| other.part == self.part)
    }

    fn forces(&self, state: &State) -> Option<Vec<Option<[f64; 3]>>> {
        forces(self, state)
    }

    fn terms(&self) -> RecordTerms {
        RecordTerms {
            planner: self.planner.name(),
            objective: FingersObjective::Effort.name(),
            outcome: Some(FingersOutcome::Effort.name()),
            unit: "deg",
            scale: 180.0 / std::f64::consts::PI,
        }
    }

    fn minimized_as(&self, outcome: &str) -> Option<&'static str> {
        (outcome == FingersOutcome::Effort.name()).then_some(FingersObjective::Effort.name())
    }

    fn replay<'a>(
        &self,
        run: &JudgedRun<'a>,
        _claims: &Claims,
        last_states: &mut LastStates<'a>,
        findings: &mut Findings,
    ) -> Result<Replay<'a>, ReplayStop> {
        let left = last_states.get(run.job.device.as_str());
        let tracks = track::Tracks::of(run, self)?;
        let mut hand = hand::JudgedHand::new(run, self, &tracks, left)?;
        hand.begin(findings);
        let mut next = 0;
        for nth in 0..self.steps.len() {
            let step = run.step(nth);
            let step_end_ns = step.end_ns();
            hand.begin_step(nth);
            while next < tracks.len() && tracks.start_ns(next) < step_end_ns {
                hand.follow(nth, &tracks.stretch(next), findings)?;
                next += 1;
            }
            hand.finish_step(nth, findings);
        }
        hand.finish(findings);
        last_states.insert(&run.job.device, hand.left());
        let outcomes = hand.outcomes();
        Ok(Replay { states: hand.into_states(), outcomes, operations: std::collections::BTreeMap::new() })
    }
}

impl JudgedState for FingersState {
    fn agrees(&self, replayed: &State) -> bool {
        matches!(replayed, State::Fingers(replayed) if near(self, replayed))
    }

    fn shown(&self) -> String {
        let contacts: Vec<String> = self.grasp.iter().map(u32::to_string).collect();
        let [x, y, z] = self.position_um.map(digits);
        let turned =
            orientation_of(&self.orientation).map_or("with an invalid orientation".to_owned(), |orientation| {
                let [x, y, z] =
                    <[f64; 3]>::from(orientation.scaled_axis()).map(|turn_rad| digits(turn_rad.to_degrees()));
                format!("turned by ({x}, {y}, {z}) deg")
            });
        let (contacts, plane, index) = (contacts.join(", "), self.plane.name(), self.angle_index);
        format!("grasp ({contacts}) in {plane} at angle {index}, the part at ({x}, {y}, {z}) um, {turned}")
    }
}

/// Whether a recorded state equals the replayed one, up to rounding.
fn near(recorded: &FingersState, replayed: &FingersState) -> bool {
    let are_near = |one: &[f64; 3], other: &[f64; 3]| {
        one.iter().zip(other).all(|(one, other)| (one - other).abs() <= PLACE_TOLERANCE_UM)
    };
    let tips = || recorded.tips_um.iter().zip(&replayed.tips_um);
    let turns = [recorded, replayed].map(|state| orientation_of(&state.orientation));
    recorded.grasp == replayed.grasp
        && (recorded.angle_index, recorded.plane) == (replayed.angle_index, replayed.plane)
        && recorded.tips_um.len() == replayed.tips_um.len()
        && tips().all(|pair| match pair {
            (Some(one), Some(other)) => are_near(one, other),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        })
        && are_near(&recorded.position_um, &replayed.position_um)
        && matches!(turns, [Some(one), Some(other)] if one.angle_to(&other) <= TURN_TOLERANCE_RAD)
}

/// The orientation of a quaternion (w, x, y, z); `None` if it is not of unit length or has a negative w.
fn orientation_of([w, x, y, z]: &[f64; 4]) -> Option<UnitQuaternion<f64>> {
    let quaternion = Quaternion::new(*w, *x, *y, *z);
    let is_unit = (quaternion.norm_squared() - 1.0).abs() <= TURN_TOLERANCE_RAD;
    (is_unit && *w >= -TURN_TOLERANCE_RAD).then(|| UnitQuaternion::from_quaternion(quaternion))
}

/// The force of each finger on the part in a held state, in the hand's frame, in micronewtons; `None` for a free
/// finger.
///
/// Many force distributions balance a grasp. Of those whose normal parts sum to a tenth of the fingers' capacity, or
/// as nearly as possible, these forces are the deepest inside the friction cones. `None` if the state is not one of
/// the order's, or no forces balance.
pub fn forces(order: &FingersOrder, state: &State) -> Option<Vec<Option<[f64; 3]>>> {
    let State::Fingers(recorded) = state else { return None };
    let body = PartOutlines::of(&order.part, order.facts.tip_radius_um)?;
    let surface = body.surface(recorded.plane)?;
    let pose = ObjectPose {
        position_um: Point::from(recorded.position_um),
        orientation: orientation_of(&recorded.orientation)?,
    };
    let holding = recorded.grasp.iter().filter(|contact| **contact > 0);
    let feet: Option<Vec<Foot>> = holding.map(|contact| surface.contact_place(*contact)).collect();
    let touches: Vec<ContactPoint> = feet?.iter().map(ContactPoint::at).collect();
    let sum_un = SHOWN_FORCE * order.facts.max_force_un * touches.len() as f64;
    let statics = Statics::of(order, recorded.plane, &pose, body.reach_um);
    let mut forces_un = statics.forces_un(&touches, sum_un)?.into_iter();
    let [first, second, normal] = pose.axes(recorded.plane);
    let force = |contact: &u32| {
        let [x_un, y_un, across_un] = if *contact > 0 { forces_un.next()? } else { return None };
        Some((first * x_un + second * y_un + normal * across_un).into())
    };
    Some(recorded.grasp.iter().map(force).collect())
}
