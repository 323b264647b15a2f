//! Joint states, each stored once: a hash table of indices over flat words.

use rustc_hash::FxHasher;
use std::hash::Hasher;

/// A place of the table that holds no state.
const NONE: u32 = u32::MAX;

/// The states that were made, with the least cost known and the state it came from.
pub struct States {
    width: usize,
    words: Vec<u32>,
    costs: Vec<u32>,
    parents: Vec<u32>,
    closed: Vec<bool>,
    table: Vec<u32>,
}

impl States {
    /// For states of `width` words, at least one.
    pub fn new(width: usize) -> Self {
        States { width, words: vec![], costs: vec![], parents: vec![], closed: vec![], table: vec![NONE; 64] }
    }

    pub fn width(&self) -> usize {
        self.width
    }

    pub fn words(&self, state: u32) -> &[u32] {
        &self.words[state as usize * self.width..][..self.width]
    }

    pub fn cost(&self, state: u32) -> u32 {
        self.costs[state as usize]
    }

    /// The state it came from; `u32::MAX` for a first one.
    pub fn parent(&self, state: u32) -> u32 {
        self.parents[state as usize]
    }

    /// Marks it as dealt with; false if it was.
    pub fn close(&mut self, state: u32) -> bool {
        !std::mem::replace(&mut self.closed[state as usize], true)
    }

    /// The index of a state that is new or cheaper than known; none for one that is not.
    pub fn insert(&mut self, words: &[u32], cost: u32, parent: u32) -> Option<u32> {
        let place = self.find(words);
        let known = self.table[place];
        if known != NONE {
            let state = known as usize;
            if self.closed[state] || self.costs[state] <= cost {
                return None;
            }
            (self.costs[state], self.parents[state]) = (cost, parent);
            return Some(known);
        }
        let state = self.costs.len() as u32;
        self.table[place] = state;
        self.words.extend_from_slice(words);
        self.costs.push(cost);
        self.parents.push(parent);
        self.closed.push(false);
        if self.costs.len() * 2 > self.table.len() {
            self.grow();
        }
        Some(state)
    }

    /// Where a state is in the table, or would be.
    fn find(&self, words: &[u32]) -> usize {
        let mask = self.table.len() - 1;
        let mut hasher = FxHasher::default();
        words.iter().for_each(|word| hasher.write_u32(*word));
        let hash = hasher.finish();
        let mut place = (hash ^ hash >> 32) as usize & mask;
        while self.table[place] != NONE && self.words(self.table[place]) != words {
            place = (place + 1) & mask;
        }
        place
    }

    fn grow(&mut self) {
        self.table = vec![NONE; self.table.len() * 2];
        for state in 0..self.costs.len() as u32 {
            let place = self.find(self.words(state));
            self.table[place] = state;
        }
    }
}
