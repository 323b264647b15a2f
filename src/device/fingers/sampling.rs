//! Contact sampling of an outline: a number of contacts around it, equally spaced in rolled angle.

use super::FingersFacts;
use crate::geometry::outline::Curve;

/// Greatest distance of the point J from a contact, in rotation steps.
const OPPOSITE_SLACK: f64 = 0.02;

/// Numbers of contacts tried on either side of the nearest one, to get a contact at J.
const CONTACTS_TRIED: i32 = 2;

/// Share of the device's tolerance that may be lost where a finger holds the part in one plane and then continues in
/// the other.
pub const JUNCTION_SHARE: f64 = 0.25;

/// Rotation of the part while a tip rolls once around it: the paper's U.
pub fn once_round_rad(curve: &Curve, tip_radius_um: f64) -> f64 {
    curve.rolled_rad(curve.perimeter_um(), tip_radius_um) - curve.rolled_rad(0.0, tip_radius_um)
}

/// The number of contacts c, and the number of the contact at J if there is one. Takes the c that is nearest to the
/// nominal step among those with a contact at J, or the nearest of all if none has one.
pub fn contacts(curve: &Curve, facts: &FingersFacts) -> (f64, Option<u32>) {
    let once = once_round_rad(curve, facts.tip_radius_um);
    let exact = once / facts.step_rad();
    let share = curve.rolled_rad(curve.opposite_um(), facts.tip_radius_um) / once;
    let mut tried: Vec<f64> = (-CONTACTS_TRIED..=CONTACTS_TRIED).map(|off| exact.round() + f64::from(off)).collect();
    tried.sort_by(|one, other| (one - exact).abs().total_cmp(&(other - exact).abs()));
    for contacts in tried {
        let steps = share * contacts;
        let off_um = (steps - steps.round()).abs() * facts.step_rad() * facts.tip_radius_um;
        let is_near = (steps - steps.round()).abs() <= OPPOSITE_SLACK;
        if is_near && off_um <= JUNCTION_SHARE * facts.tolerance_um && steps.round() < contacts {
            return (contacts, Some(steps.round() as u32 + 1));
        }
    }
    (exact.round(), None)
}
