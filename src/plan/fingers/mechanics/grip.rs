//! Force equilibrium: whether two or three fingers can balance a wrench.
//!
//! Input: contacts with their normals, and the wrench that the fingers must exert on the object. Output: yes or no, exact up to
//! [`TOLERANCE`].

use super::pair::{ForceCone, LineForce, are_antipodal};
use super::space::{Lever, SpatialBearing, three_bear};
use super::{Contact, Load, TOLERANCE};
use crate::device::fingers::FingersFacts;

/// A wrench on the object in the plane: force, and moment about the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wrench {
    pub force_un: [f64; 2],
    /// Counter-clockwise.
    pub moment_un_um: f64,
}

impl Wrench {
    /// No force.
    pub const NONE: Wrench = Wrench { force_un: [0.0; 2], moment_un_um: 0.0 };

    /// The wrench of a force that acts at a point.
    pub fn of(force_un: [f64; 2], at_um: [f64; 2]) -> Wrench {
        Wrench { force_un, moment_un_um: at_um[0] * force_un[1] - at_um[1] * force_un[0] }
    }

    /// The wrench that balances both.
    pub fn against(self, other: Wrench) -> Wrench {
        Wrench {
            force_un: [-self.force_un[0] - other.force_un[0], -self.force_un[1] - other.force_un[1]],
            moment_un_um: -self.moment_un_um - other.moment_un_um,
        }
    }
}

/// Condition for a grasp to hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GripDemand {
    /// No load and no adhesion: any equilibrium with forces that are not all zero.
    Squeeze,
    /// The fingers can exert this wrench.
    Exert(Wrench),
}

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
    /// For a hand on a part with the given greatest distance from its origin.
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

    /// The same hand while its fingers roll: reduced by the device's reserve.
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

    /// Whether two or three fingers hold under a load; no other number of fingers does.
    ///
    /// Fingers that only push must also hold without the load: a part that merely rests on them is not held. Room between tips is
    /// not checked here.
    pub fn holds(&self, contacts: &[Contact], load: &Load) -> bool {
        let leans = self.only_leans(load);
        (!leans || self.holds_under(contacts, &Load::NONE)) && self.holds_under(contacts, load)
    }

    /// Whether they are in equilibrium under the load, even if they only carry the part.
    pub(super) fn holds_under(&self, contacts: &[Contact], load: &Load) -> bool {
        let demand = self.demand(load);
        match contacts {
            [a, b] => self.two_hold([a, b], load, &demand),
            [a, b, c] => {
                let pairs = [[a, b], [a, c], [b, c]];
                pairs.into_iter().any(|pair| self.two_hold(pair, load, &demand))
                    || self.three_hold([a, b, c], load, &demand)
            }
            [] | [_] | [_, _, _, _, ..] => false,
        }
    }

    /// Whether two fingers resist the pull of a third that leaves, in addition to the load.
    ///
    /// Whether the two alone hold afterwards is the question of [`GripModel::holds`].
    pub fn resists(&self, stay: [&Contact; 2], leaves: &Contact, load: &Load) -> bool {
        self.two_hold(stay, load, &self.removal(leaves, load))
    }

    /// Torque of a load about the line through two contacts, and the most that the tips can bear; `None` where that is sufficient.
    pub fn torque_left_un_um(&self, [a, b]: [&Contact; 2], load: &Load) -> Option<[f64; 2]> {
        let lever = Lever::of([a, b], &load.across(), 0.0)?;
        let most_un_um = self.torsion_um * (self.max_force_un + self.sticking_un) * lever.leverage();
        (lever.left_over_un_um > most_un_um + self.slack_un(load) * self.arm_um)
            .then_some([lever.left_over_un_um, most_un_um])
    }

    /// Condition under a load.
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

    /// The same up to the greatest force, with part of the pressing and adhesive force reserved for other loads.
    pub(super) fn pressing(&self, contact: &Contact, withheld_un: f64) -> ForceCone {
        ForceCone::of(contact, self.friction, self.sticking_un - withheld_un, self.max_force_un)
    }

    /// Whether two fingers meet a condition and bear the out-of-plane load.
    pub(super) fn two_hold(&self, [a, b]: [&Contact; 2], load: &Load, demand: &GripDemand) -> bool {
        match demand {
            GripDemand::Squeeze => are_antipodal(&self.reach(a, demand), &self.reach(b, demand)),
            GripDemand::Exert(wrench) => self.two([a, b], load).is_some_and(|two| two.bear(self, wrench)),
        }
    }

    /// Two fingers, prepared for queries; `None` for two contacts at the same place.
    pub(super) fn two(&self, [a, b]: [&Contact; 2], load: &Load) -> Option<Two> {
        if load.is_in_plane() {
            let [a, b] = [a, b].map(|contact| self.pressing(contact, 0.0));
            return Some(Two::InPlane(self.line([&a, &b], load)));
        }
        SpatialBearing::of(self, [a, b], &load.across(), self.slack_un(load)).map(Two::InSpace)
    }

    /// Whether three fingers together meet a condition, each with some force.
    pub(super) fn three_hold(&self, [a, b, c]: [&Contact; 3], load: &Load, demand: &GripDemand) -> bool {
        match demand {
            GripDemand::Exert(wrench) if !load.is_in_plane() => {
                three_bear(self, [a, b, c], &load.across(), wrench, self.slack_un(load))
            }
            GripDemand::Squeeze | GripDemand::Exert(_) => {
                let [a, b, c] = [a, b, c].map(|contact| self.reach(contact, demand));
                self.line([&a, &b], load).takes(&c, demand)
            }
        }
    }

    /// The wrenches that two fingers bear together in the plane.
    pub(super) fn line(&self, [a, b]: [&ForceCone; 2], load: &Load) -> LineForce {
        let slack_un = match self.demand(load) {
            GripDemand::Squeeze => TOLERANCE,
            GripDemand::Exert(_) => self.slack_un(load),
        };
        LineForce::between(a, b, self.arm_um, slack_un)
    }

    fn slack_un(&self, load: &Load) -> f64 {
        TOLERANCE * (self.removal_un + self.sticking_un + load.size_un())
    }
}

/// Two fingers, prepared for queries about wrenches in the plane.
#[derive(Debug, Clone, Copy, PartialEq)]
#[expect(clippy::large_enum_variant, reason = "one at a time, on the stack")]
pub(super) enum Two {
    InPlane(LineForce),
    /// Under a load with an out-of-plane component.
    InSpace(SpatialBearing),
}

impl Two {
    /// Whether they can exert a wrench.
    pub fn bear(&self, grip: &GripModel, wrench: &Wrench) -> bool {
        match self {
            Two::InPlane(line) => line.bears(wrench),
            Two::InSpace(bearing) => bearing.bears(grip, wrench),
        }
    }
}
