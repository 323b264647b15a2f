//! Lazy evaluation of grasps under a load.
//!
//! Under a load in the plane of a turn, grasps differ from angle to angle. Tables of all of them take seconds, while a
//! search needs few. Input: a hand on the contacts of a section, and the load at the start of a leg. Output: the same
//! answers as those of [`super::tables`], each computed on demand and cached. Guaranteed: every grasp that holds here
//! also holds in the tables without the load, if fingers may leave there wherever they may be placed; so only the
//! entries of those tables need a query.

use super::{Contact, Contacts, GripModel, Load, PARTS_OF_STEP};
use crate::device::fingers::FingersFacts;
use crate::plan::fingers::looks::LooksBudget;
use rustc_hash::FxHashMap;
use std::cell::RefCell;
use std::rc::Rc;

/// Looks per equilibrium, and per that of three contacts with out-of-plane forces.
const LOOKS: u64 = 30;
const LOOKS_IN_SPACE: u64 = 80;

/// Bits of a contact in a key.
const DIGIT: u32 = 10;

/// Cached answers of one leg.
#[derive(Debug)]
pub struct LazyGraspEvaluator {
    grip: GripModel,
    firm: GripModel,
    /// All contacts at each part of a step.
    contacts: [Vec<Contact>; PARTS_OF_STEP],
    step_rad: f64,
    /// Load at angle 0 of the leg.
    load: Load,
    looks: Rc<LooksBudget>,
    /// Answers by angle, query and contacts.
    known: RefCell<FxHashMap<u64, bool>>,
}

/// Query about a grasp.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum GraspQuery {
    Holds,
    Rolls,
    Leaves,
}

impl LazyGraspEvaluator {
    /// Cache for a hand on the contacts of a section, under the load at angle 0.
    pub fn of(facts: &FingersFacts, contacts: &Contacts, load: Load, looks: Rc<LooksBudget>) -> LazyGraspEvaluator {
        let grip = GripModel::of(facts, contacts.reach_um());
        LazyGraspEvaluator {
            grip,
            firm: grip.with_reserve(),
            contacts: std::array::from_fn(|part| contacts.after(part as f64 / PARTS_OF_STEP as f64)),
            step_rad: contacts.step_rad(),
            load,
            looks,
            known: RefCell::default(),
        }
    }

    /// Whether two or three contacts, counted from 0, hold at an angle of the leg.
    pub fn holds(&self, angle: i32, held: &[usize]) -> bool {
        self.answer(GraspQuery::Holds, angle, &sorted(held), || self.balances(angle, 0, held))
    }

    /// Whether two or three contacts keep holding from an angle to the next.
    pub fn rolls(&self, angle: i32, held: &[usize]) -> bool {
        let next = || held.iter().map(|contact| (contact + self.contacts[0].len() - 1) % self.contacts[0].len());
        self.answer(GraspQuery::Rolls, angle, &sorted(held), || {
            self.holds(angle, held)
                && self.holds(angle + 1, &next().collect::<Vec<usize>>())
                && (1..PARTS_OF_STEP).all(|part| self.balances(angle, part, held))
        })
    }

    /// Whether two contacts hold and resist the removal of the finger on a third one.
    pub fn leaves(&self, angle: i32, stay: [usize; 2], leaves: usize) -> bool {
        let [i, j] = [stay[0].min(stay[1]), stay[0].max(stay[1])];
        self.answer(GraspQuery::Leaves, angle, &[i, j, leaves], || {
            self.looks.take(LOOKS);
            let [a, b, c] = [i, j, leaves].map(|contact| &self.contacts[0][contact]);
            self.holds(angle, &[i, j]) && self.grip.resists([a, b], c, &self.at(angle, 0))
        })
    }

    /// Excludes the step of a grasp from an angle to the next.
    pub fn forbid(&self, angle: i32, held: &[usize]) {
        self.known.borrow_mut().insert(key(GraspQuery::Rolls, angle, &sorted(held)), false);
    }

    fn answer(&self, query: GraspQuery, angle: i32, held: &[usize], find: impl FnOnce() -> bool) -> bool {
        let key = key(query, angle, held);
        if let Some(known) = self.known.borrow().get(&key) {
            return *known;
        }
        let found = find();
        self.known.borrow_mut().insert(key, found);
        found
    }

    fn balances(&self, angle: i32, part: usize, held: &[usize]) -> bool {
        let in_space = held.len() > 2 && !self.load.is_in_plane();
        self.looks.take(if in_space { LOOKS_IN_SPACE } else { LOOKS });
        let grip = if part == 0 { &self.grip } else { &self.firm };
        let touched: Vec<Contact> = held.iter().map(|contact| self.contacts[part][*contact]).collect();
        grip.holds_under(&touched, &self.at(angle, part))
    }

    fn at(&self, angle: i32, part: usize) -> Load {
        self.load.after_turn((f64::from(angle) + part as f64 / PARTS_OF_STEP as f64) * self.step_rad)
    }
}

fn sorted(held: &[usize]) -> Vec<usize> {
    let mut sorted = held.to_vec();
    sorted.sort_unstable();
    sorted
}

fn key(query: GraspQuery, angle: i32, held: &[usize]) -> u64 {
    let held = held.iter().fold(0, |key, contact| key << DIGIT | (*contact as u64 + 1));
    // Angles lie between -1024 and 1023: two revolutions of at most 360 steps either way, and the step beyond.
    ((angle + 1024) as u64) << (3 * DIGIT + 2) | (query as u64) << (3 * DIGIT) | held
}
