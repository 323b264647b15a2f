//! Joint states, each stored once: a hash table of indices over flat words.

/// An empty slot of the table.
const NONE: (u32, u32) = (u32::MAX, 0);

/// Most words of all states together; 4 bytes each.
const MOST_WORDS: usize = 1 << 25;

/// Most states.
const MOST_STATES: usize = 1 << 23;

/// An odd number near 2^64 divided by the golden ratio: products spread over all bits (Knuth, The Art of Computer Programming 3, 6.4).
const SPREAD: u64 = 0x9E37_79B9_7F4A_7C15;

/// The stored states, each with its least known cost and its parent.
pub struct States {
    width: usize,
    words: Vec<u32>,
    costs: Vec<u32>,
    parents: Vec<u32>,
    closed: Vec<bool>,
    /// Index and hash of each state.
    table: Vec<(u32, u32)>,
}

impl States {
    /// For states of `width` words; `width` is at least 1.
    pub fn new(width: usize) -> Self {
        States { width, words: vec![], costs: vec![], parents: vec![], closed: vec![], table: vec![NONE; 64] }
    }

    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of stored states; their indices are below it.
    pub fn count(&self) -> u32 {
        self.costs.len() as u32
    }

    pub fn words(&self, state: u32) -> &[u32] {
        &self.words[state as usize * self.width..][..self.width]
    }

    pub fn cost(&self, state: u32) -> u32 {
        self.costs[state as usize]
    }

    /// The parent of a state; `u32::MAX` for a root.
    pub fn parent(&self, state: u32) -> u32 {
        self.parents[state as usize]
    }

    /// Marks a state as closed; `false` if it was already.
    pub fn close(&mut self, state: u32) -> bool {
        !std::mem::replace(&mut self.closed[state as usize], true)
    }

    /// Whether the limits on memory are reached.
    pub fn is_full(&self) -> bool {
        self.words.len() >= MOST_WORDS || self.costs.len() >= MOST_STATES
    }

    /// Inserts a state and returns its index if it is new or cheaper than known; otherwise `None`.
    pub fn insert(&mut self, words: &[u32], cost: u32, parent: u32) -> Option<u32> {
        let hash = hash(words);
        let place = self.find(words, hash);
        let known = self.table[place];
        if known != NONE {
            let state = known.0 as usize;
            if self.closed[state] || self.costs[state] <= cost {
                return None;
            }
            (self.costs[state], self.parents[state]) = (cost, parent);
            return Some(known.0);
        }
        let state = self.costs.len() as u32;
        self.table[place] = (state, hash);
        self.words.extend_from_slice(words);
        self.costs.push(cost);
        self.parents.push(parent);
        self.closed.push(false);
        if self.costs.len() * 2 > self.table.len() {
            self.grow();
        }
        Some(state)
    }

    /// The index of a stored state.
    pub fn find_known(&self, words: &[u32]) -> Option<u32> {
        let (state, _) = self.table[self.find(words, hash(words))];
        (state != NONE.0).then_some(state)
    }

    /// Slot of a state in the table, or the slot for its insertion.
    fn find(&self, words: &[u32], hash: u32) -> usize {
        let mask = self.table.len() - 1;
        let mut place = hash as usize & mask;
        while self.table[place] != NONE && (self.table[place].1 != hash || self.words(self.table[place].0) != words) {
            place = (place + 1) & mask;
        }
        place
    }

    fn grow(&mut self) {
        let mask = self.table.len() * 2 - 1;
        let mut table = vec![NONE; mask + 1];
        for entry in self.table.iter().filter(|entry| **entry != NONE) {
            let mut place = entry.1 as usize & mask;
            while table[place] != NONE {
                place = (place + 1) & mask;
            }
            table[place] = *entry;
        }
        self.table = table;
    }
}

fn hash(words: &[u32]) -> u32 {
    let mixed = words.iter().fold(0u64, |hash, word| {
        let hash = (hash ^ u64::from(*word)).wrapping_mul(SPREAD);
        hash ^ hash >> 32
    });
    (mixed.wrapping_mul(SPREAD) >> 32) as u32
}
