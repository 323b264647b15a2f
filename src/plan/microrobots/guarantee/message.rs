//! Containments, and errors that a plan certainly tolerates, as text.

use super::written::scaled;
use super::{Containment, ContainmentCheck};
use crate::claims::microrobots::MicrorobotsOrder;
use crate::device::microrobots::Errors;
use crate::quantity::digits;

/// Multiples of errors as the fields of a device, rounded down.
pub fn fields(errors: &Errors, multiple: f64) -> String {
    let Errors { speed_ratio, turning_rad_per_um, place_um, heading_rad, .. } = scaled(errors, multiple);
    let [speed, turning, place, heading] =
        [100.0 * speed_ratio, 1e3 * turning_rad_per_um.to_degrees(), place_um, heading_rad.to_degrees()]
            .map(|value| digits(lowered(value)));
    format!(
        "`speed_error: {speed} %`, `turning_error: {turning} deg/mm`, `place_error: {place} um`, `heading_error: {heading} deg`"
    )
}

/// Share of the device's errors that a plan tolerates, as a clause that begins with the limit.
pub fn limit(errors: &Errors, multiple: f64) -> String {
    let turning = digits(lowered(multiple * 1e3 * errors.turning_rad_per_um.to_degrees()));
    let share = digits(lowered(100.0 * multiple));
    format!("up to {turning} deg/mm of turning error and {share} % of all errors of the device")
}

/// A positive number cut after its first two digits.
fn lowered(value: f64) -> f64 {
    // Cuts the digits of the shortest decimal that is this number, not those of the binary fraction.
    let text = format!("{value:e}");
    let Some((digits, exponent)) = text.split_once('e') else { return 0.0 };
    format!("{}e{exponent}", digits.get(..3).unwrap_or(digits)).parse().unwrap_or(0.0)
}

/// An available value and a larger required one, to a tenth; if these look the same, to a hundredth, the first rounded
/// down and the second up.
fn distinguishable(has: f64, needs: f64) -> (String, String) {
    let (short, long) = (format!("{has:.1}"), format!("{needs:.1}"));
    if short != long {
        return (short, long);
    }
    (format!("{:.2}", (has * 100.0).floor() / 100.0), format!("{:.2}", (needs * 100.0).ceil() / 100.0))
}

impl Containment {
    /// The required and the available value, as a clause that begins with the quantity.
    pub fn message(&self, order: &MicrorobotsOrder) -> String {
        let name = &order.robot(self.robot).name;
        let (needs, has) = (self.needs, self.has);
        if !needs.is_finite() {
            return format!("the deviation of {name} is not bounded: an error can add full circles to its path");
        }
        let (needs_deg, has_deg) = (needs.to_degrees(), has.to_degrees());
        match &self.check {
            ContainmentCheck::Cone => format!(
                "the cylinder about the approach of {name} has a radius of {needs:.1} um, but the fine motion can correct only {:.1} um",
                has.max(0.0)
            ),
            ContainmentCheck::Place => {
                format!("{name} may dock {needs:.1} um beside its place; the docking tolerance is {has:.1} um")
            }
            ContainmentCheck::Angle => format!(
                "{name} may meet its structure at {needs_deg:.1} deg from the normal of its edge; the sticking angle is {has_deg:.1} deg"
            ),
            ContainmentCheck::Axes => format!(
                "{name} and its partner may meet with their axes {needs:.1} um apart; they align themselves up to {has:.1} um"
            ),
            ContainmentCheck::Directions => format!(
                "{name} and its partner may meet at an angle of {needs_deg:.1} deg; they align themselves up to {has_deg:.1} deg"
            ),
            ContainmentCheck::Gross(thing) => {
                format!("{name} may stray {needs:.1} um from its path, which passes {thing} at {:.1} um", has.max(0.0))
            }
            ContainmentCheck::Fine(thing) => format!(
                "{name} may stray {needs:.1} um in its fine motion, which passes {thing} at {:.1} um",
                has.max(0.0)
            ),
            ContainmentCheck::Edge => format!("{name} faces no docked robot at its goal"),
            ContainmentCheck::Turn => {
                let (has, needs) = distinguishable(has_deg, needs_deg);
                format!("a turn of {name} by {has} deg is too short to be certain; at least {needs} deg is needed")
            }
            ContainmentCheck::Meeting => format!(
                "{name} and its partner may miss each other by {needs:.1} um along their paths; {has:.1} um can be corrected"
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_that_is_too_short_looks_shorter_than_what_is_needed() {
        let apart = |has: f64, needs: f64| {
            let (has, needs) = distinguishable(has, needs);
            format!("{has} {needs}")
        };
        assert_eq!(apart(0.54, 0.82), "0.5 0.8");
        assert_eq!(apart(0.801, 0.803), "0.80 0.81");
        assert_eq!(apart(0.761, 0.842), "0.76 0.85");
    }

    #[test]
    fn limits_are_rounded_down() {
        for (value, text) in [(0.004_199, "0.0041"), (0.0042, "0.0042"), (9.99, "9.9"), (123.4, "120"), (0.0, "0")] {
            assert_eq!(digits(lowered(value)), text);
            assert!(lowered(value) <= value);
        }
    }
}
