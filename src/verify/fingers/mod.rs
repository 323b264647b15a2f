//! Replays the run of a hand from the positions of its stages alone.
//!
//! Input: a run whose steps and channels are sound. Output: its states and the outcomes. `track` assembles the axes, `body` gives
//! distances to the part's outlines, `grip` solves for the pose in which all tips that hold touch and roll, `hand` follows
//! stretch by stretch which tips hold, come and leave, `statics` decides by linear programs whether they hold the part,
//! `clearance` checks distances of tips, `pace` their speeds, `goals` each step against the task and `states` the changes against the
//! record. Promise: the record is read only to be compared; the first motion that does not roll ends the replay of its device.
//! Equilibrium is checked after each finger that comes or leaves and, while tips roll, at both ends and the middle of each stretch, and
//! in between so often that no tip moves more than a quarter of its radius from one sample to the next. Cost: for each sample a few
//! distances to the outline and one linear program.

mod body;
mod claims;
mod clearance;
mod goals;
mod grip;
mod hand;
mod pace;
mod roll;
mod states;
mod statics;
mod tell;
mod track;

use super::clock::JudgedRun;
use super::geometry::contour::Foot;
use super::rule::Findings;
use super::{Halt, RecordTerms, Replay, Standing};
use crate::claims::fingers::FingersOrder;
use crate::device::fingers::{FingersObjective, FingersOutcome, Plane, finger_axis};
use crate::quantity::digits;
use crate::schedule::{ChannelUnit, State};
use body::{ObjectPose, PartOutlines};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use statics::{ContactPoint, Statics};

pub(super) use claims::check_claims;

/// A place or a direction in the hand's frame.
type Point = Vector3<f64>;

/// Tolerance of a recorded place.
const PLACE_TOLERANCE_UM: f64 = 1e-3;

/// Tolerance of a recorded orientation.
const TURN_TOLERANCE_RAD: f64 = 1e-4;

/// The share of its greatest force that each finger bears in pictures.
const SHOWN_FORCE: f64 = 0.1;

/// Unit of a channel, if the hand has it.
pub(super) fn unit(channel: &str, order: &FingersOrder) -> Option<ChannelUnit> {
    let (finger, _) = finger_axis(channel)?;
    (finger < order.facts.fingers as usize).then_some(ChannelUnit::Micrometre)
}

/// Terms of a plan's record, from the claims.
pub(super) fn terms(order: &FingersOrder) -> RecordTerms {
    RecordTerms {
        planner: order.planner.name(),
        objective: FingersObjective::Effort.name(),
        outcome: FingersOutcome::Effort.name(),
        unit: "deg",
        scale: 180.0 / std::f64::consts::PI,
    }
}

/// The objective that minimises an outcome.
pub(super) fn minimized_as(outcome: &str) -> Option<&'static str> {
    (outcome == FingersOutcome::Effort.name()).then_some(FingersObjective::Effort.name())
}

/// Whether a recorded state is the replayed one, but for rounding.
pub(super) fn near(recorded: &State, replayed: &State) -> bool {
    let (Some(recorded), Some(replayed)) = (HandState::of(recorded), HandState::of(replayed)) else { return false };
    let are_near = |one: &[f64; 3], other: &[f64; 3]| {
        one.iter().zip(other).all(|(one, other)| (one - other).abs() <= PLACE_TOLERANCE_UM)
    };
    let tips = || recorded.tips_um.iter().zip(replayed.tips_um);
    (recorded.grasp, recorded.angle_index, recorded.plane) == (replayed.grasp, replayed.angle_index, replayed.plane)
        && recorded.tips_um.len() == replayed.tips_um.len()
        && tips().all(|pair| match pair {
            (Some(one), Some(other)) => are_near(one, other),
            (None, None) => true,
            (Some(_), None) | (None, Some(_)) => false,
        })
        && are_near(recorded.position_um, replayed.position_um)
        && recorded.orientation.is_some_and(|recorded| {
            replayed.orientation.is_some_and(|replayed| recorded.angle_to(&replayed) <= TURN_TOLERANCE_RAD)
        })
}

/// A hand's state.
struct HandState<'a> {
    grasp: &'a [u32],
    angle_index: i64,
    plane: Plane,
    tips_um: &'a [Option<[f64; 3]>],
    position_um: &'a [f64; 3],
    /// `None` where it is no unit quaternion, or one with a negative w.
    orientation: Option<UnitQuaternion<f64>>,
}

impl<'a> HandState<'a> {
    fn of(state: &'a State) -> Option<Self> {
        match state {
            State::Fingers { grasp, angle_index, plane, tips_um, position_um, orientation } => Some(HandState {
                grasp,
                angle_index: *angle_index,
                plane: *plane,
                tips_um,
                position_um,
                orientation: orientation_of(orientation),
            }),
            State::Dimibot { .. } | State::ElectrodeArray { .. } | State::Microrobots { .. } => None,
        }
    }
}

fn orientation_of([w, x, y, z]: &[f64; 4]) -> Option<UnitQuaternion<f64>> {
    let quaternion = Quaternion::new(*w, *x, *y, *z);
    let is_unit = (quaternion.norm_squared() - 1.0).abs() <= TURN_TOLERANCE_RAD;
    (is_unit && *w >= -TURN_TOLERANCE_RAD).then(|| UnitQuaternion::from_quaternion(quaternion))
}

/// A state in words.
pub(super) fn shown(state: &State) -> String {
    let Some(told) = HandState::of(state) else { return "a state of another kind".to_owned() };
    let contacts: Vec<String> = told.grasp.iter().map(u32::to_string).collect();
    let [x, y, z] = told.position_um.map(digits);
    let turned = told.orientation.map_or("not turned as can be".to_owned(), |orientation| {
        let [x, y, z] = <[f64; 3]>::from(orientation.scaled_axis()).map(|turn_rad| digits(turn_rad.to_degrees()));
        format!("turned by ({x}, {y}, {z}) deg")
    });
    let (contacts, plane, index) = (contacts.join(", "), told.plane.name(), told.angle_index);
    format!("grasp ({contacts}) in {plane} at angle {index}, the part at ({x}, {y}, {z}) um, {turned}")
}

/// The force of each finger on the part in a held state, in the hand's frame and micronewtons; `None` for a free finger.
///
/// Many forces balance a grasp: these are deepest inside the friction cones while their normal parts sum to a tenth of the fingers'
/// capacity, or as nearly as possible. `None` if the state is none of the order's, or no forces balance.
pub fn forces(order: &FingersOrder, state: &State) -> Option<Vec<Option<[f64; 3]>>> {
    let told = HandState::of(state)?;
    let body = PartOutlines::of(&order.part, order.facts.tip_radius_um)?;
    let surface = body.surface(told.plane)?;
    let pose = ObjectPose { position_um: Point::from(*told.position_um), orientation: told.orientation? };
    let holding = told.grasp.iter().filter(|contact| **contact > 0);
    let feet: Option<Vec<Foot>> = holding.map(|contact| surface.contact_place(*contact)).collect();
    let touches: Vec<ContactPoint> = feet?.iter().map(ContactPoint::at).collect();
    let sum_un = SHOWN_FORCE * order.facts.max_force_un * touches.len() as f64;
    let statics = Statics::of(order, told.plane, &pose, body.reach_um);
    let mut forces_un = statics.forces_un(&touches, sum_un)?.into_iter();
    let [first, second, normal] = pose.axes(told.plane);
    let force = |contact: &u32| {
        let [x_un, y_un, across_un] = if *contact > 0 { forces_un.next()? } else { return None };
        Some((first * x_un + second * y_un + normal * across_un).into())
    };
    Some(told.grasp.iter().map(force).collect())
}

/// Replays a run and checks it against its order.
///
/// # Errors
/// At the first axis without a value, the first tip that slips or loses its contact, or the first grasp that cannot be judged.
pub(super) fn replay<'a>(
    run: &JudgedRun<'a>,
    order: &FingersOrder,
    standing: &mut Standing<'a>,
    findings: &mut Findings,
) -> Result<Replay<'a>, Halt> {
    let left = standing.get(run.job.device.as_str());
    let tracks = track::Tracks::of(run, order)?;
    let mut hand = hand::JudgedHand::new(run, order, &tracks, left)?;
    hand.begin(findings);
    let mut next = 0;
    for nth in 0..order.steps.len() {
        let step = run.step(nth);
        let step_end_ns = step.start_ns + step.duration_ns;
        hand.begin_step(nth);
        while next < tracks.len() && tracks.start_ns(next) < step_end_ns {
            hand.follow(nth, &tracks.stretch(next), findings)?;
            next += 1;
        }
        hand.finish_step(nth, findings);
    }
    hand.finish(findings);
    standing.insert(&run.job.device, hand.left());
    let outcomes = hand.outcomes();
    Ok(Replay { states: hand.into_states(), outcomes })
}
