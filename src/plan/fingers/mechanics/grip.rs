//! Force equilibrium: whether two or three fingers can balance a wrench.
//!
//! Input: contacts with their normals, and the wrench that the fingers must exert on the object. Output: yes or no, exact up to
//! [`TOLERANCE`].

use super::load::{GripDemand, Load, Wrench};
use super::model::GripModel;
use super::pair::{ForceCone, LineForce, are_antipodal};
use super::space::{Lever, SpatialBearing, three_bear};
use super::{Contact, TOLERANCE};

impl GripModel {
    /// Whether two or three fingers hold under a load; no other number of fingers does.
    ///
    /// Fingers that only push must also hold without the load: a part that merely rests on them is not held. Room between tips is
    /// not checked here.
    pub fn holds(&self, contacts: &[Contact], load: &Load) -> bool {
        let leans = self.only_leans(load);
        (!leans || self.holds_under(contacts, &Load::NONE)) && self.holds_under(contacts, load)
    }

    /// Whether fingers are in equilibrium under the load, even if the part merely rests on them.
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
    /// This does not imply that the two hold alone afterwards; see [`GripModel::holds`].
    pub fn resists(&self, stay: [&Contact; 2], leaves: &Contact, load: &Load) -> bool {
        self.two_hold(stay, load, &self.removal(leaves, load))
    }

    /// Torque of a load about the line through two contacts, and the most that the tips can bear; `None` if they can
    /// bear it.
    pub fn torque_left_un_um(&self, [a, b]: [&Contact; 2], load: &Load) -> Option<[f64; 2]> {
        let lever = Lever::of([a, b], &load.across(), 0.0)?;
        let most_un_um = self.torsion_um * (self.max_force_un + self.sticking_un) * lever.leverage();
        (lever.left_over_un_um > most_un_um + self.slack_un(load) * self.arm_um)
            .then_some([lever.left_over_un_um, most_un_um])
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
