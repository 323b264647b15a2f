//! The set of cells that a search has settled, each with a number.
//!
//! Small lattices use an array over all cells, cleared by walking the entries that were set; larger ones an open-addressing hash table.

/// Up to this many modules (left and right together) an array over all cells is used: 2^20 numbers, 4 MB.
const ARRAY_MODULES: u32 = 20;
const FIRST_SLOTS: usize = 1 << 12;

/// Numbers by cell; 0 means absent.
#[derive(Default)]
pub(super) struct Closed {
    /// Modules of the left side, or `None` when hashing.
    shift: Option<u32>,
    array: Vec<u32>,
    keys: Vec<u64>,
    values: Vec<u32>,
    count: usize,
}

impl Closed {
    /// Prepares an empty set for a lattice; the caller has cleared what it set before with [`Closed::clear`].
    pub(super) fn begin(&mut self, modules: [u32; 2]) {
        self.shift = (modules[0] + modules[1] <= ARRAY_MODULES).then_some(modules[0]);
        match self.shift {
            Some(_) => self.array.resize(1 << (modules[0] + modules[1]), 0),
            None if self.keys.is_empty() => self.grow_to(FIRST_SLOTS),
            None => {}
        }
    }

    /// Empties the set, given all cells that were put in.
    pub(super) fn clear(&mut self, cells: impl Iterator<Item = [u32; 2]>) {
        if let Some(shift) = self.shift {
            cells.for_each(|[x, y]| self.array[(y << shift | x) as usize] = 0);
            return;
        }
        // A large table is not worth keeping: wiping it would cost more than most searches.
        if self.values.len() > FIRST_SLOTS * 16 {
            (self.keys, self.values) = (Vec::new(), Vec::new());
        } else {
            self.values.fill(0);
        }
        self.count = 0;
    }

    /// The number stored for the cell, or a place to put one.
    #[inline]
    pub(super) fn entry(&mut self, [x, y]: [u32; 2]) -> &mut u32 {
        match self.shift {
            Some(shift) => &mut self.array[(y << shift | x) as usize],
            None => self.hashed(u64::from(y) << 32 | u64::from(x)),
        }
    }

    fn hashed(&mut self, key: u64) -> &mut u32 {
        // Counting every look-up of an absent key as an insertion keeps the table sparse enough; callers insert nearly always.
        if 2 * self.count >= self.values.len() {
            self.grow_to(self.values.len() * 2);
        }
        let at = self.slot(key);
        if self.values[at] == 0 {
            self.keys[at] = key;
        }
        &mut self.values[at]
    }

    /// Tells the table that the last absent entry was filled.
    #[inline]
    pub(super) fn filled(&mut self) {
        self.count += 1;
    }

    /// The number stored for the cell, 0 if absent.
    #[inline]
    pub(super) fn get(&self, [x, y]: [u32; 2]) -> u32 {
        match self.shift {
            Some(shift) => self.array[(y << shift | x) as usize],
            None => self.values[self.slot(u64::from(y) << 32 | u64::from(x))],
        }
    }

    #[inline]
    fn slot(&self, key: u64) -> usize {
        let mask = self.values.len() - 1;
        let mut at = (key.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 20) as usize & mask;
        while self.values[at] != 0 && self.keys[at] != key {
            at = (at + 1) & mask;
        }
        at
    }

    fn grow_to(&mut self, slots: usize) {
        let old_keys = std::mem::replace(&mut self.keys, vec![0; slots]);
        let old_values = std::mem::replace(&mut self.values, vec![0; slots]);
        for (key, value) in old_keys.into_iter().zip(old_values).filter(|(_, v)| *v != 0) {
            let at = self.slot(key);
            (self.keys[at], self.values[at]) = (key, value);
        }
    }
}
