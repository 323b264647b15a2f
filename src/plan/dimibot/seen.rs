//! A set of cells that is quick to empty: a bit per cell for small lattices, open addressing for large ones.

use fixedbitset::FixedBitSet;

/// Most modules (left and right together) for which a bit per cell is used: 2^26 bits, 8 MB.
const BIT_MODULES: u32 = 26;
const FIRST_SLOTS: usize = 1 << 10;
/// A table larger than this is dropped rather than wiped.
const KEPT_SLOTS: usize = 1 << 14;

#[derive(Default)]
pub(super) struct Seen {
    /// Modules of the left side, or `None` when hashing.
    shift: Option<u32>,
    bits: FixedBitSet,
    /// Keys plus one; 0 is an empty slot.
    slots: Vec<u64>,
    count: usize,
}

impl Seen {
    /// Prepares for a lattice. The set must be empty: the caller clears it after each use.
    pub(super) fn begin(&mut self, modules: [u32; 2]) {
        let all = modules[0] + modules[1];
        self.shift = (all <= BIT_MODULES).then_some(modules[0]);
        match self.shift {
            Some(_) => self.bits.grow(1_usize << all),
            None if self.slots.is_empty() => self.slots = vec![0; FIRST_SLOTS],
            None => {}
        }
    }

    /// Empties the set, given all cells in it.
    pub(super) fn clear(&mut self, cells: impl Iterator<Item = [u32; 2]>) {
        match self.shift {
            Some(shift) => cells.for_each(|[x, y]| self.bits.set((y << shift | x) as usize, false)),
            None if self.slots.len() > KEPT_SLOTS => self.slots = Vec::new(),
            None => self.slots.fill(0),
        }
        self.count = 0;
    }

    #[inline]
    pub(super) fn contains(&self, [x, y]: [u32; 2]) -> bool {
        match self.shift {
            Some(shift) => self.bits.contains((y << shift | x) as usize),
            None => self.slots[self.slot(key([x, y]))] != 0,
        }
    }

    /// Adds the cell; `false` if it was present.
    #[inline]
    pub(super) fn insert(&mut self, [x, y]: [u32; 2]) -> bool {
        if let Some(shift) = self.shift {
            return !self.bits.put((y << shift | x) as usize);
        }
        if 2 * self.count >= self.slots.len() {
            self.grow();
        }
        let at = self.slot(key([x, y]));
        let fresh = self.slots[at] == 0;
        self.slots[at] = key([x, y]);
        self.count += usize::from(fresh);
        fresh
    }

    #[inline]
    fn slot(&self, key: u64) -> usize {
        let mask = self.slots.len() - 1;
        let mut at = (key.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 24) as usize & mask;
        while self.slots[at] != 0 && self.slots[at] != key {
            at = (at + 1) & mask;
        }
        at
    }

    fn grow(&mut self) {
        let old = std::mem::take(&mut self.slots);
        self.slots = vec![0; (2 * old.len()).max(FIRST_SLOTS)];
        for key in old.into_iter().filter(|key| *key != 0) {
            let at = self.slot(key);
            self.slots[at] = key;
        }
    }
}

fn key([x, y]: [u32; 2]) -> u64 {
    (u64::from(y) << 32 | u64::from(x)) + 1
}
