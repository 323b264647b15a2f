//! The contact model of a hand: friction, adhesion and limits of force, and what a grasp must exert.

use super::load::{GripDemand, Load, Wrench};
use super::pair::ForceCone;
use super::{Contact, TOLERANCE};
use crate::device::fingers::FingersFacts;

/// Contact model of a hand: force limits, and the reserve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GripModel {
    pub(super) friction: f64,
    pub(super) sticking_un: f64,
    pub(super) max_force_un: f64,
    /// Torque about the normal that a contact bears, per unit of pressing or adhesive force.
    pub(super) torsion_um: f64,
    /// Pull that the remaining fingers resist when one leaves.
    removal_un: f64,
    /// Fraction of the other figures that is held back while the fingers roll.
    reserve: f64,
    /// Lever arm that converts moments to forces for comparison.
    pub(super) arm_um: f64,
}

impl GripModel {
    /// The model of a hand on a part whose outlines reach at most `reach_um` from its origin.
    pub fn of(facts: &FingersFacts, reach_um: f64) -> GripModel {
        GripModel {
            friction: facts.friction,
            sticking_un: facts.sticking_un(),
            max_force_un: facts.max_force_un,
            torsion_um: facts.torsion_um,
            removal_un: facts.removal_safety * facts.sticking_un(),
            reserve: facts.rolling_reserve,
            arm_um: reach_um,
        }
    }

    /// The model while the fingers roll: reduced by the device's reserve.
    pub fn with_reserve(&self) -> GripModel {
        let kept = 1.0 - self.reserve;
        GripModel {
            friction: self.friction * kept,
            sticking_un: self.sticking_un * kept,
            max_force_un: self.max_force_un * kept,
            torsion_um: self.torsion_um * kept,
            ..*self
        }
    }

    /// Condition for a grasp to hold under a load.
    pub(super) fn demand(&self, load: &Load) -> GripDemand {
        if load.is_none() && self.sticking_un == 0.0 {
            return GripDemand::Squeeze;
        }
        GripDemand::Exert(Wrench::of(load.force_un, load.at_um).against(Wrench::NONE))
    }

    /// Condition on the two remaining fingers while a third is pulled off; without adhesion they only need to hold.
    pub(super) fn removal(&self, leaves: &Contact, load: &Load) -> GripDemand {
        if self.removal_un == 0.0 {
            return self.demand(load);
        }
        let pull_un = leaves.normal.map(|part| part * self.removal_un);
        let pull = Wrench::of(pull_un, leaves.point_um);
        GripDemand::Exert(pull.against(Wrench::of(load.force_un, load.at_um)))
    }

    /// Whether every grasp with room for its tips holds: there is no load, and small forces in every direction are available.
    pub(super) fn holds_anyway(&self, load: &Load) -> bool {
        load.is_none() && self.sticking_un > 0.0
    }

    /// Whether there may be equilibria in which only the load presses the part against the tips.
    pub(super) fn only_leans(&self, load: &Load) -> bool {
        !load.is_none() && self.sticking_un == 0.0
    }

    /// The forces available to a finger in the plane.
    pub(super) fn reach(&self, contact: &Contact, demand: &GripDemand) -> ForceCone {
        match demand {
            GripDemand::Squeeze => ForceCone::of(contact, self.friction, self.sticking_un, f64::INFINITY),
            GripDemand::Exert(_) => self.pressing(contact, 0.0),
        }
    }

    /// The forces available to a finger in the plane up to the greatest force, with part of the pressing and adhesive
    /// force reserved for other loads.
    pub(super) fn pressing(&self, contact: &Contact, withheld_un: f64) -> ForceCone {
        ForceCone::of(contact, self.friction, self.sticking_un - withheld_un, self.max_force_un)
    }

    /// Allowance for rounding in an equilibrium under a load.
    pub(super) fn slack_un(&self, load: &Load) -> f64 {
        TOLERANCE * (self.removal_un + self.sticking_un + load.size_un())
    }
}
