//! Assumptions of the replay about the claims of a hand.
//!
//! Input: an order. Output: nothing, or the reason why no run can be checked against it. Claims of the checker always
//! pass.

use super::super::InvalidClaims;
use super::body::Surface;
use super::hand::nominal_step_rad;
use crate::claims::fingers::{FingersAction, FingersOrder, FingersTurn, Section};
use crate::device::fingers::{
    FingersFacts, MAX_CONTACTS, MAX_FINGERS, MAX_HOLDING, MAX_RESERVE, MAX_STEPS_PER_TURN, MIN_FINGERS, Plane,
};

/// The largest length, force, speed or other number of the facts, in their own units.
const MAX_NUMBER: f64 = 1e9;

/// The smallest number accepted where one above zero is required.
const MIN_NUMBER: f64 = 1e-9;

/// Relative tolerance between a section's step and the one derived from its perimeter.
const STEP_TOLERANCE: f64 = 1e-6;

/// Greatest difference between a section's number of contacts and the nominal one: the checker tries two more and two
/// fewer to find an opposite contact.
const CONTACTS_BESIDE: f64 = 2.5;

/// Greatest distance from the opposite contact to the x axis, as a fraction of the tolerance: the checker allows a
/// quarter, by the nominal step.
const AXIS_TOLERANCE: f64 = 0.5;

/// Rounding of that distance.
const AXIS_ROUNDING_UM: f64 = 1e-6;

/// The fewest distinguishable contacts.
const MIN_CONTACTS: u32 = 3;

/// Checks the assumptions of all rules.
///
/// # Errors
/// If no schedule can be checked against the claims.
pub(super) fn check_claims(order: &FingersOrder) -> Result<(), InvalidClaims> {
    facts(&order.facts)?;
    let part = &order.part;
    let places = [part.centre_um, part.position_um, order.load_un];
    demand(places.iter().flatten().all(|value| is_number(*value)), "have a place or a load out of range")?;
    demand(is_number(order.precision_rad) && order.precision_rad >= 0.0, "have a precision out of range")?;
    section(&part.xy, &order.facts)?;
    part.xz.iter().try_for_each(|xz| section(xz, &order.facts))?;
    order.steps.iter().try_for_each(|step| action(order, &step.action))
}

fn demand(holds: bool, why: &str) -> Result<(), InvalidClaims> {
    if holds { Ok(()) } else { Err(InvalidClaims(format!("the claims of a hand {why}"))) }
}

fn is_number(value: f64) -> bool {
    value.abs() <= MAX_NUMBER
}

fn facts(facts: &FingersFacts) -> Result<(), InvalidClaims> {
    demand((MIN_FINGERS..=MAX_FINGERS).contains(&facts.fingers), "have too few or too many fingers")?;
    demand((1..=MAX_STEPS_PER_TURN).contains(&facts.steps_per_turn), "have too few or too many steps per turn")?;
    let [x_um, y_um, z_um] = facts.range_um;
    let above = [
        [facts.tip_radius_um, facts.max_force_un, facts.friction, facts.retract_um, facts.tolerance_um],
        [facts.speed_um_per_s, facts.approach_um_per_s, facts.rolling_um_per_s, x_um, y_um],
    ];
    let is_above = |value: f64| is_number(value) && value >= MIN_NUMBER;
    demand(above.into_iter().flatten().chain([z_um]).all(is_above), "have a field that is not above 0, or too large")?;
    let others = [
        [facts.pull_off_un, facts.removal_safety, facts.gaiting_cost_deg],
        [facts.clearance_um, facts.support_un, facts.torsion_um],
    ];
    demand(others.into_iter().flatten().all(|value| is_number(value) && value >= 0.0), "have a field out of range")?;
    demand((0.0..=MAX_RESERVE).contains(&facts.rolling_reserve), "have a reserve out of range")
}

fn section(section: &Section, facts: &FingersFacts) -> Result<(), InvalidClaims> {
    let contacts = section.contacts;
    demand((MIN_CONTACTS..=MAX_CONTACTS).contains(&contacts), "have too few or too many contacts")?;
    let step_rad = section.step_rad;
    demand(is_number(step_rad) && step_rad >= MIN_NUMBER, "have a step between contacts out of range")?;
    let surface = Surface::of(section, facts.tip_radius_um);
    let Some(surface) = surface else { return demand(false, "have an outline that cannot be followed") };
    let round_rad = surface.round_rad();
    let off_rad = (f64::from(contacts) * step_rad - round_rad).abs();
    demand(
        off_rad <= STEP_TOLERANCE * round_rad,
        "have contact steps that do not add up to one turn round an outline",
    )?;
    let beside = (round_rad / nominal_step_rad(facts) - f64::from(contacts)).abs();
    demand(beside <= CONTACTS_BESIDE + STEP_TOLERANCE, "have contacts that are not the device's step apart")?;
    let Some(opposite) = section.opposite else { return Ok(()) };
    demand((1..=contacts).contains(&opposite), "have an opposite contact that does not exist")?;
    let exact_rad = surface.contour.opposite().map(|foot| surface.turned_rad(&foot));
    let off_um = |exact_rad: f64| (f64::from(opposite - 1) * step_rad - exact_rad).abs() * facts.tip_radius_um;
    let most_um = AXIS_TOLERANCE * facts.tolerance_um + AXIS_ROUNDING_UM;
    demand(exact_rad.is_some_and(|rad| off_um(rad) <= most_um), "have an opposite contact off the x axis")
}

fn action(order: &FingersOrder, action: &FingersAction) -> Result<(), InvalidClaims> {
    match action {
        FingersAction::Grasp(None) | FingersAction::Release | FingersAction::Wait(_) => Ok(()),
        FingersAction::Grasp(Some(contacts)) => grasp(order, contacts),
        FingersAction::Rotate { plane, angle_rad, .. } => {
            has_plane(order, *plane)?;
            demand(is_number(*angle_rad), "turn by an angle out of range")
        }
        FingersAction::Orient { goal, turns, .. } => {
            let norm = goal.iter().map(|value| value * value).sum::<f64>();
            demand((norm - 1.0).abs() <= 1e-6, "orient to a goal that is not an orientation")?;
            turns.iter().flatten().try_for_each(|FingersTurn { plane, .. }| has_plane(order, *plane))
        }
        FingersAction::Translate(by_um) => {
            demand(by_um.iter().all(|value| is_number(*value)), "carry a part by a distance out of range")
        }
    }
}

fn has_plane(order: &FingersOrder, plane: Plane) -> Result<(), InvalidClaims> {
    demand(order.part.section(plane).is_some(), "turn in a plane where the part has no outline")
}

fn grasp(order: &FingersOrder, contacts: &[u32]) -> Result<(), InvalidClaims> {
    demand(
        contacts.len() == order.facts.fingers as usize,
        "list the contacts of a grasp for another number of fingers",
    )?;
    let holding = contacts.iter().filter(|contact| **contact > 0).count();
    demand((2..=MAX_HOLDING).contains(&holding), "grasp with too few or too many fingers")?;
    let most =
        [Some(&order.part.xy), order.part.xz.as_ref()].into_iter().flatten().map(|section| section.contacts).max();
    demand(contacts.iter().all(|contact| Some(*contact) <= most), "grasp at a contact that does not exist")
}
