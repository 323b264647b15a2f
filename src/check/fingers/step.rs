//! Search for a `step` of the device with which the turns of a task are whole steps.

use super::orientation::{self, Orientation};
use super::part::junction_fault;
use crate::claims::fingers::{HandPart, Section};
use crate::device::fingers::sampling::{contacts, once_round_rad};
use crate::device::fingers::{FingersFacts, MAX_CONTACTS, MAX_GRASPS, MAX_STEPS_PER_TURN, Plane};
use crate::geometry::outline::Curve;
use std::f64::consts::TAU;

/// Fewest steps of one full turn that are tried.
const FEWEST: u32 = 4;

/// Greatest number of values of `step` with which decompositions of an orientation are sought.
const MAX_TRIED: usize = 64;

/// Turns that whole steps are to make.
pub enum WantedTurn<'a> {
    /// These angles in these planes, in radians.
    Turns(&'a [(Plane, f64)]),
    /// An orientation, relative to the present one, and these turns in addition.
    Orientation(&'a Orientation, &'a [(Plane, f64)]),
}

/// Demands on a turn.
pub struct TurnDemand {
    pub precision_rad: f64,
    /// Whether a force acts on the part, so that grasps may differ from angle to angle and are fewer.
    pub is_loaded: bool,
}

/// The `step` nearest to a hand's own, in degrees, with which a part is turned as wanted to within a precision; those
/// of whole degrees come first. `None` where there is none, or none of those that were tried.
pub fn nearest_fitting_step(
    part: &HandPart,
    facts: &FingersFacts,
    wanted: &WantedTurn,
    demand: &TurnDemand,
) -> Option<f64> {
    let TurnDemand { precision_rad, is_loaded } = *demand;
    let curves = [Some(&part.xy), part.xz.as_ref()].map(|section| Curve::of(&section?.outline).ok());
    let now = f64::from(facts.steps_per_turn);
    let mut tried: Vec<u32> = (FEWEST..=MAX_STEPS_PER_TURN).filter(|steps| *steps != facts.steps_per_turn).collect();
    let far = |steps: u32| (360.0 / f64::from(steps) - 360.0 / now).abs();
    tried.sort_by(|one, other| {
        let is_odd = |steps: u32| 360 % steps != 0;
        is_odd(*one).cmp(&is_odd(*other)).then(far(*one).total_cmp(&far(*other)))
    });
    let had_junction = part.xz.is_some() && junction_fault(part, facts).is_none();
    let candidates = tried.into_iter().filter_map(|steps_per_turn| {
        let facts = FingersFacts { steps_per_turn, ..facts.clone() };
        let part = HandPart {
            xy: sampled(&part.xy, curves[0].as_ref()?, &facts)?,
            xz: match (&part.xz, &curves[1]) {
                (Some(section), Some(curve)) => Some(sampled(section, curve, &facts)?),
                (Some(_), None) => return None,
                (None, _) => None,
            },
            ..part.clone()
        };
        Some((part, facts))
    });
    // Where the force lies in no plane of a turn, more steps would be possible, but the plane is known only once the
    // runs are walked.
    let turned: Vec<Plane> = match wanted {
        WantedTurn::Turns(turns) => turns.iter().map(|(plane, _)| *plane).collect(),
        WantedTurn::Orientation(..) => Plane::ALL.to_vec(),
    };
    let candidates = candidates.filter(|(part, facts)| {
        let mut sections = turned.iter().filter_map(|plane| part.section(*plane));
        !is_loaded || sections.all(|section| are_few_grasps(section.contacts, facts.steps_per_turn))
    });
    let keeps_junction =
        |(part, facts): &(HandPart, FingersFacts)| !had_junction || junction_fault(part, facts).is_none();
    let are_whole = |part: &HandPart, turns: &[(Plane, f64)]| {
        turns.iter().all(|(plane, angle_rad)| is_whole(part, *plane, *angle_rad, precision_rad))
    };
    let found = match wanted {
        WantedTurn::Turns(turns) => candidates.filter(|(part, _)| are_whole(part, turns)).find(keeps_junction),
        WantedTurn::Orientation(goal, turns) => candidates
            .filter(|(part, _)| are_whole(part, turns))
            .take(MAX_TRIED)
            .filter(|(part, _)| orientation::decompositions(goal, part).iter().any(|way| way.off_rad <= precision_rad))
            .find(keeps_junction),
    };
    found.map(|(_, facts)| 360.0 / f64::from(facts.steps_per_turn))
}

/// Whether the grasps of a section under a load, which differ from angle to angle, are few enough to be searched.
pub fn are_few_grasps(contacts: u32, steps_per_turn: u32) -> bool {
    (contacts as usize).pow(3) * (steps_per_turn as usize + 1) <= MAX_GRASPS
}

/// A section with the contacts that another device would give it.
fn sampled(section: &Section, curve: &Curve, facts: &FingersFacts) -> Option<Section> {
    let (contacts, opposite) = contacts(curve, facts);
    let step_rad = once_round_rad(curve, facts.tip_radius_um) / contacts;
    (contacts <= f64::from(MAX_CONTACTS)).then(|| Section {
        contacts: contacts as u32,
        opposite,
        step_rad,
        outline: section.outline.clone(),
    })
}

/// Whether a turn is a whole number of steps to within the precision; the number is at most one full turn.
fn is_whole(part: &HandPart, plane: Plane, angle_rad: f64, precision_rad: f64) -> bool {
    part.section(plane).is_some_and(|section| {
        let steps = (angle_rad / section.step_rad).round();
        let most = (TAU / section.step_rad).round();
        (steps.abs().min(most) * section.step_rad - angle_rad.abs()).abs() <= precision_rad
    })
}
