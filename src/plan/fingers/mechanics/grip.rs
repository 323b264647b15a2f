//! Whether forces of two or three fingers balance a wrench.
//!
//! Input: contacts with their normals, and the wrench that the fingers have to exert on the object. Output: yes or no, exact up to
//! [`TOLERANCE`].

use super::pair::{Line, Reach, are_antipodal};
use super::{Contact, Load, TOLERANCE};
use crate::device::fingers::Facts;

/// The share of friction, pull-off and greatest force that a grasp must do without while it rolls: from one instant that is looked
/// at to the next a balance changes by less than this, and where tips roll on chords of their curves too.
pub const RESERVE: f64 = 0.02;

/// A force in the plane on the object, and its moment about the origin.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wrench {
    pub force_un: [f64; 2],
    /// Counter-clockwise.
    pub moment_un_um: f64,
}

impl Wrench {
    /// No force.
    pub const NONE: Wrench = Wrench { force_un: [0.0; 2], moment_un_um: 0.0 };

    /// The one of a force that acts at a point.
    pub fn of(force_un: [f64; 2], at_um: [f64; 2]) -> Wrench {
        Wrench { force_un, moment_un_um: at_um[0] * force_un[1] - at_um[1] * force_un[0] }
    }

    /// The one that balances both.
    pub fn against(self, other: Wrench) -> Wrench {
        Wrench {
            force_un: [-self.force_un[0] - other.force_un[0], -self.force_un[1] - other.force_un[1]],
            moment_un_um: -self.moment_un_um - other.moment_un_um,
        }
    }
}

/// What fingers have to do so that a grasp holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Demand {
    /// Nothing acts and nothing sticks: any balance of forces that are not all zero.
    Squeeze,
    /// Exert this wrench.
    Exert(Wrench),
}

/// What the hand can do at a contact, and how exactly it is looked at.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grip {
    friction: f64,
    sticking_un: f64,
    max_force_un: f64,
    /// What the fingers that stay resist when one leaves.
    removal_un: f64,
    /// Moments are compared as forces at this distance.
    arm_um: f64,
}

impl Grip {
    /// Of a hand on a part that reaches so far from its origin.
    pub fn of(facts: &Facts, reach_um: f64) -> Grip {
        Grip {
            friction: facts.friction,
            sticking_un: facts.sticking_un(),
            max_force_un: facts.max_force_un,
            removal_un: facts.removal_safety * facts.sticking_un(),
            arm_um: reach_um,
        }
    }

    /// The same hand with [`RESERVE`] kept back.
    pub fn with_reserve(&self) -> Grip {
        let kept = 1.0 - RESERVE;
        Grip {
            friction: self.friction * kept,
            sticking_un: self.sticking_un * kept,
            max_force_un: self.max_force_un * kept,
            ..*self
        }
    }

    /// Whether two or three fingers hold under a load; no other number of fingers does.
    ///
    /// Tips that only push must also be able to hold without the load: a part that merely rests on them is not held. Whether their tips
    /// have room is not asked here.
    pub fn holds(&self, contacts: &[Contact], load: &Load) -> bool {
        if self.only_leans(load) && !self.holds(contacts, &Load::NONE) {
            return false;
        }
        let demand = self.demand(load);
        let reach = |contact: &Contact| self.reach(contact, load, contacts.len());
        match contacts {
            [a, b] => self.two_hold([&reach(a), &reach(b)], load, &demand),
            [a, b, c] => {
                let reaches = [reach(a), reach(b), reach(c)];
                let [a, b, c] = &reaches;
                let idle = self.may_idle(load);
                let pair_holds = [[a, b], [a, c], [b, c]].into_iter().any(|pair| self.two_hold(pair, load, &demand));
                idle && pair_holds || self.line([a, b], load).takes(c, &demand)
            }
            [] | [_] | [_, _, _, _, ..] => false,
        }
    }

    /// Whether two fingers resist the pull of a third that leaves, besides the load.
    ///
    /// That they hold by themselves afterwards is [`Grip::holds`].
    pub fn resists(&self, stay: [&Contact; 2], leaves: &Contact, load: &Load) -> bool {
        let demand = self.removal(leaves, load);
        let [a, b] = stay.map(|contact| self.reach(contact, load, 2));
        self.two_hold([&a, &b], load, &demand)
    }

    /// What the fingers have to do under a load.
    pub(super) fn demand(&self, load: &Load) -> Demand {
        if load.is_none() && self.sticking_un == 0.0 {
            return Demand::Squeeze;
        }
        Demand::Exert(Wrench::of(load.force_un, load.at_um).against(Wrench::NONE))
    }

    /// What the two that stay have to do while a third is pulled off; without adhesion they just hold.
    pub(super) fn removal(&self, leaves: &Contact, load: &Load) -> Demand {
        if self.removal_un == 0.0 {
            return self.demand(load);
        }
        let pull_un = leaves.normal.map(|part| part * self.removal_un);
        let pull = Wrench::of(pull_un, leaves.point_um);
        Demand::Exert(pull.against(Wrench::of(load.force_un, load.at_um)))
    }

    /// Whether every grasp holds in which tips have room: the load is none, and forces near zero of every direction are to be had.
    pub(super) fn holds_anyway(&self, load: &Load) -> bool {
        load.is_none() && self.sticking_un > 0.0
    }

    /// Whether there are balances in which nothing but the load presses the part against the tips.
    pub(super) fn only_leans(&self, load: &Load) -> bool {
        !load.is_none() && self.sticking_un == 0.0
    }

    /// Whether a finger of three may exert no force in the plane.
    pub(super) fn may_idle(&self, load: &Load) -> bool {
        load.across_un / 3.0 <= self.friction * self.sticking_un * (1.0 + TOLERANCE)
    }

    /// The forces of one of so many fingers that hold.
    pub(super) fn reach(&self, contact: &Contact, load: &Load, fingers: usize) -> Reach {
        let share_un = load.across_un / fingers as f64;
        let apex_un = self.sticking_un - share_un / self.friction;
        let most_un = match self.demand(load) {
            Demand::Squeeze => f64::INFINITY,
            Demand::Exert(_) => self.max_force_un,
        };
        Reach::of(contact, self.friction, apex_un, most_un)
    }

    /// Whether two fingers do what is asked.
    pub(super) fn two_hold(&self, [a, b]: [&Reach; 2], load: &Load, demand: &Demand) -> bool {
        match demand {
            Demand::Squeeze => are_antipodal(a, b),
            Demand::Exert(wrench) => self.line([a, b], load).bears(wrench),
        }
    }

    /// What two of them bear together.
    pub(super) fn line(&self, [a, b]: [&Reach; 2], load: &Load) -> Line {
        let slack_un = match self.demand(load) {
            Demand::Squeeze => TOLERANCE,
            Demand::Exert(_) => TOLERANCE * (self.removal_un + self.sticking_un + load.size_un()),
        };
        Line::between(a, b, self.arm_um, slack_un)
    }
}
