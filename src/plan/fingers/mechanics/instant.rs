//! Grasps that hold at one instant of rolling.

use super::load::GripDemand;
use super::model::GripModel;
use super::pair::{ForceCone, LineForce};
use super::rows::{PairRows, numbers};
use super::{Contact, Load, TOLERANCE};
use crate::plan::fingers::looks::LooksBudget;
use crate::plan::fingers::tables::{ContactBits, Tables};

/// The contacts at an instant, and the capabilities of finger pairs on them.
pub(super) struct PairsInstant<'a> {
    grip: &'a GripModel,
    pub contacts: Vec<Contact>,
    pub load: Load,
    demand: GripDemand,
    /// Pairs of usable contacts with room for both tips.
    pub clear: PairRows,
    /// Pairs that have room and hold, also with any third finger that has room and exerts no force.
    pub pair: PairRows,
    /// In-plane forces of a finger on each contact; empty where every grasp with room holds.
    reaches: Vec<ForceCone>,
    pub looks: &'a LooksBudget,
}

/// Looks per grasp of three with out-of-plane forces.
const LOOKS_IN_SPACE: u64 = 64;

/// Looks per grasp of two with out-of-plane forces.
const PAIR_LOOKS_IN_SPACE: u64 = 4;

impl<'a> PairsInstant<'a> {
    /// Tips keep `apart_um` from each other, centre to centre.
    pub fn of(
        grip: &'a GripModel,
        contacts: Vec<Contact>,
        load: Load,
        apart_um: f64,
        looks: &'a LooksBudget,
    ) -> PairsInstant<'a> {
        looks.take(contacts.len().pow(2) as u64 * if load.is_in_plane() { 1 } else { PAIR_LOOKS_IN_SPACE });
        let clear = room(&contacts, apart_um);
        let demand = grip.demand(&load);
        if grip.holds_anyway(&load) {
            let pair = clear.clone();
            return PairsInstant { grip, contacts, load, demand, clear, pair, reaches: Vec::new(), looks };
        }
        let reaches = contacts.iter().map(|at| grip.reach(at, &demand)).collect();
        let holds = |i: usize, j: usize| grip.two_hold([&contacts[i], &contacts[j]], &load, &demand);
        let pair = PairRows::symmetric(contacts.len(), |i, j| clear.has(i, j) && holds(i, j));
        PairsInstant { grip, contacts, load, demand, clear, pair, reaches, looks }
    }

    /// Writes into a row the contacts that have room beside each of two others.
    pub fn beside(&self, i: usize, j: usize, row: &mut [u64]) {
        for (k, word) in row.iter_mut().enumerate() {
            *word = self.clear.row(i)[k] & self.clear.row(j)[k];
        }
    }

    /// Removes the triples that do not hold, in all orders, from a set of triples with room.
    pub fn remove_unheld(&self, triples: &mut ContactBits, tables: &Tables) {
        if self.reaches.is_empty() {
            return;
        }
        let mut row = vec![0; self.clear.width()];
        for (i, j) in pairs(&self.clear).filter(|&(i, j)| !self.pair.has(i, j)) {
            triples.read_row(tables.three(i, j, 0), tables.contacts, &mut row);
            for (k, word) in row.iter_mut().enumerate() {
                *word &= !(self.pair.row(i)[k] | self.pair.row(j)[k]) & above(j, k);
            }
            let count = row.iter().map(|word| u64::from(word.count_ones())).sum::<u64>();
            self.looks.take(if self.load.is_in_plane() { 2 * count } else { LOOKS_IN_SPACE * count });
            if self.looks.are_spent() {
                return;
            }
            if count == 0 {
                continue;
            }
            let line = self.load.is_in_plane().then(|| self.line(i, j));
            let holds = |k: usize| match &line {
                Some(line) => line.takes(&self.reaches[k], &self.demand),
                None => self.grip.three_hold([i, j, k].map(|at| &self.contacts[at]), &self.load, &self.demand),
            };
            for k in numbers(&row).filter(|&k| !holds(k)) {
                tables.triple([i, j, k]).into_iter().for_each(|bit| triples.take(bit));
            }
        }
    }

    fn line(&self, i: usize, j: usize) -> LineForce {
        self.grip.line([&self.reaches[i], &self.reaches[j]], &self.load)
    }
}

/// The pairs of usable contacts whose tips are at least `apart_um` apart, centre to centre.
pub(super) fn room(contacts: &[Contact], apart_um: f64) -> PairRows {
    let least_um = apart_um * (1.0 - TOLERANCE);
    let has_room = |a: &Contact, b: &Contact| a.usable && b.usable && a.tips_apart_um(b) >= least_um;
    PairRows::symmetric(contacts.len(), |i, j| has_room(&contacts[i], &contacts[j]))
}

/// The pairs of a symmetric set, the lower index first.
pub(super) fn pairs(rows: &PairRows) -> impl Iterator<Item = (usize, usize)> + '_ {
    (0..rows.size()).flat_map(|i| numbers(rows.row(i)).filter(move |&j| j > i).map(move |j| (i, j)))
}

// The bits of word `word` that represent indices above `number`.
fn above(number: usize, word: usize) -> u64 {
    let from = number + 1;
    match word.cmp(&(from / 64)) {
        std::cmp::Ordering::Less => 0,
        std::cmp::Ordering::Equal => u64::MAX << (from % 64),
        std::cmp::Ordering::Greater => u64::MAX,
    }
}
