//! Containments as text.

use super::{Containment, ContainmentCheck};
use crate::claims::microrobots::MicrorobotsOrder;

impl Containment {
    /// The required and the available value, as a clause that begins with the quantity.
    pub fn said(&self, order: &MicrorobotsOrder) -> String {
        let name = &order.robot(self.robot).name;
        let (needs, has) = (self.needs, self.has);
        if !needs.is_finite() {
            return format!("how far {name} may stray is not bounded: an error can add full circles to its way");
        }
        let (needs_deg, has_deg) = (needs.to_degrees(), has.to_degrees());
        match &self.check {
            ContainmentCheck::Cone => format!(
                "the cylinder about the approach of {name} has a radius of {needs:.1} um, the fine motion can correct {:.1} um",
                has.max(0.0)
            ),
            ContainmentCheck::Place => {
                format!("{name} may dock {needs:.1} um beside its place, the docking tolerance is {has:.1} um")
            }
            ContainmentCheck::Angle => format!(
                "{name} may meet its structure at {needs_deg:.1} deg from the normal of its edge, the sticking angle is {has_deg:.1} deg"
            ),
            ContainmentCheck::Axes => format!(
                "{name} and its partner may meet with their axes {needs:.1} um apart, they align themselves up to {has:.1} um"
            ),
            ContainmentCheck::Directions => format!(
                "{name} and its partner may meet at an angle of {needs_deg:.1} deg, they align themselves up to {has_deg:.1} deg"
            ),
            ContainmentCheck::Gross(thing) => {
                format!("{name} may stray {needs:.1} um from its path, which passes {thing} at {:.1} um", has.max(0.0))
            }
            ContainmentCheck::Fine(thing) => format!(
                "{name} may stray {needs:.1} um in its fine motion, which passes {thing} at {:.1} um",
                has.max(0.0)
            ),
            ContainmentCheck::Edge => format!("{name} faces no docked robot at its goal"),
            ContainmentCheck::Turn => format!(
                "a turn of {name} of {has_deg:.1} deg is too short to be sure of; {needs_deg:.1} deg are needed"
            ),
            ContainmentCheck::Meeting => format!(
                "{name} and its partner may miss each other by {needs:.1} um of their ways, {has:.1} um can be made up for"
            ),
        }
    }
}
