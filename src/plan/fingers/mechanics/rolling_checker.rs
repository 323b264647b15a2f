//! Checks of rolling at more instants than the tables use.
//!
//! Input: a hand, the contacts of a section, and the load. Output: whether a grasp holds throughout a rolling step, and
//! tables without the steps in which a grasp lapses. Guaranteed: a grasp that passes holds with the device's reserve at
//! [`INSTANTS`] - 1 evenly spaced instants within the step, which include those of the tables.

use super::{Contact, Contacts, GripModel, Load};
use crate::device::fingers::FingersFacts;
use crate::plan::fingers::looks::LooksBudget;
use crate::plan::fingers::tables::{AngleLayer, Tables};

/// Number of parts into which a rolling step is divided.
pub const INSTANTS: u32 = 64;

/// Looks charged for two fingers at one instant: two friction cones, and the half-spaces of their forces.
const PAIR_LOOKS: u64 = 4;

/// Looks charged for three fingers at one instant: three pairs, and a third finger that supplies the rest.
const TRIPLE_LOOKS: u64 = 16;

/// Factor on these looks with out-of-plane forces.
const IN_SPACE: u64 = 4;

/// A hand on a section.
#[derive(Debug, Clone, Copy)]
pub struct RollingChecker<'a> {
    contacts: Contacts<'a>,
    grip: GripModel,
    /// Load at angle 0 of the leg.
    load: Load,
}

/// All contacts, and the load, at an instant.
type ContactInstant = (Vec<Contact>, Load);

impl<'a> RollingChecker<'a> {
    /// Checker for a hand on the contacts of a section, under the load at angle 0.
    pub fn of(facts: &FingersFacts, contacts: Contacts<'a>, load: Load) -> Self {
        RollingChecker { contacts, grip: GripModel::of(facts, contacts.reach_um()).with_reserve(), load }
    }

    fn parts() -> impl Iterator<Item = f64> {
        (1..INSTANTS).map(|instant| f64::from(instant) / f64::from(INSTANTS))
    }

    fn load(&self, angle: i32, part_of_step: f64) -> Load {
        self.load.after_turn((f64::from(angle) + part_of_step) * self.contacts.step_rad())
    }

    /// Whether fingers on contacts, counted from 0, hold throughout the step from an angle to the next.
    pub fn lasts(&self, angle: i32, held: &[usize]) -> bool {
        Self::parts().all(|part| {
            let touched: Vec<Contact> = held.iter().map(|contact| self.contacts.one(*contact, part)).collect();
            self.grip.holds(&touched, &self.load(angle, part))
        })
    }

    /// Removes from the layer of an angle the steps in which a grasp lapses: all of them, or as many as the looks
    /// allow.
    pub fn forbid_lapses(&self, tables: &mut Tables, layer: usize, angle: i32, looks: &LooksBudget) {
        let instants: Vec<ContactInstant> =
            Self::parts().map(|part| (self.contacts.after(part), self.load(angle, part))).collect();
        let lasts = |held: &[usize]| {
            let grasp = if held.len() == 2 { PAIR_LOOKS } else { TRIPLE_LOOKS };
            let cost = if self.load.is_in_plane() { grasp } else { IN_SPACE * grasp };
            instants.iter().all(|(contacts, load)| {
                looks.take(cost);
                looks.are_spent() || self.holds(contacts, load, held)
            })
        };
        let size = tables.contacts;
        let has_pair = |layer: &AngleLayer, i: usize, j: usize| layer.roll_pair.has(i * size + j);
        for (i, j) in (0..size).flat_map(|i| (i + 1..size).map(move |j| (i, j))) {
            if has_pair(&tables.layers[layer], i, j) && !lasts(&[i, j]) {
                forbid(tables, layer, &[i, j]);
            }
        }
        // Three fingers hold where two of them hold throughout.
        for (i, j) in (0..size).flat_map(|i| (i + 1..size).map(move |j| (i, j))) {
            if looks.are_spent() {
                return;
            }
            for k in j + 1..size {
                let now = &tables.layers[layer];
                let by_two = || [[i, j], [i, k], [j, k]].iter().any(|[a, b]| has_pair(now, *a, *b));
                if now.roll_triple.has(tables.three(i, j, k)) && !by_two() && !lasts(&[i, j, k]) {
                    forbid(tables, layer, &[i, j, k]);
                }
            }
        }
    }

    fn holds(&self, contacts: &[Contact], load: &Load, held: &[usize]) -> bool {
        let touched: Vec<Contact> = held.iter().map(|contact| contacts[*contact]).collect();
        self.grip.holds(&touched, load)
    }
}

/// Removes the step of a grasp from a layer, whichever fingers hold it; contacts count from 0.
pub fn forbid(tables: &mut Tables, layer: usize, contacts: &[usize]) {
    match *contacts {
        [i, j] => tables.pair([i, j]).into_iter().for_each(|bit| tables.layers[layer].roll_pair.take(bit)),
        [i, j, k] => tables.triple([i, j, k]).into_iter().for_each(|bit| tables.layers[layer].roll_triple.take(bit)),
        _ => {}
    }
}
