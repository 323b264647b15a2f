//! Tables of the grasp graph of one section: the grasps that hold, the fingers that may be placed or removed, and the
//! grasps that may roll.
//!
//! Contacts are counted from 0 here, and from 1 in grasps. The graph itself is never built: these bits decide every edge.

/// A set of small whole numbers, one bit each.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ContactBits {
    words: Vec<u64>,
}

impl ContactBits {
    /// The empty set of numbers below `size`.
    pub fn new(size: usize) -> Self {
        ContactBits { words: vec![0; size.div_ceil(64)] }
    }

    /// Whether it contains a number, which must be below the size.
    #[inline]
    pub fn has(&self, index: usize) -> bool {
        self.words[index / 64] >> (index % 64) & 1 == 1
    }

    /// Inserts a number, which must be below the size.
    #[inline]
    pub fn put(&mut self, index: usize) {
        self.words[index / 64] |= 1 << (index % 64);
    }

    /// Removes a number, which must be below the size.
    #[inline]
    pub fn take(&mut self, index: usize) {
        self.words[index / 64] &= !(1 << (index % 64));
    }

    /// Inserts the numbers given by a row of bits, where bit 0 stands for `start`.
    pub fn put_row(&mut self, start: usize, row: &[u64]) {
        let (word, shift) = (start / 64, start % 64);
        for (k, bits) in row.iter().enumerate().filter(|(_, bits)| **bits != 0) {
            self.words[word + k] |= bits << shift;
            if shift > 0 && bits >> (64 - shift) != 0 {
                self.words[word + k + 1] |= bits >> (64 - shift);
            }
        }
    }

    /// Reads `length` numbers from `start` on into a row of bits, which must have room for them.
    pub fn read_row(&self, start: usize, length: usize, row: &mut [u64]) {
        let (word, shift) = (start / 64, start % 64);
        for (k, bits) in row.iter_mut().enumerate() {
            let low = self.words.get(word + k).map_or(0, |word| word >> shift);
            let high = if shift == 0 { 0 } else { self.words.get(word + k + 1).map_or(0, |word| word << (64 - shift)) };
            *bits = low | high;
        }
        if !length.is_multiple_of(64) {
            row[length / 64] &= (1 << (length % 64)) - 1;
        }
    }

    /// Intersects with another set of the same size.
    pub fn keep(&mut self, other: &ContactBits) {
        self.words.iter_mut().zip(&other.words).for_each(|(word, other)| *word &= other);
    }

    /// The words, 64 numbers each, lowest bit first.
    pub fn words(&self) -> &[u64] {
        &self.words
    }
}

/// The grasps of one section.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Tables {
    /// Number c of contacts. They are 0 to c - 1, in the order in which positive turns pass them: after one step,
    /// contact i becomes i - 1.
    pub contacts: usize,
    /// One layer if all angles are alike; otherwise (under a load) one per angle of the leg, from its lowest on.
    pub layers: Vec<AngleLayer>,
}

impl Tables {
    /// The layer of an angle, counted from the lowest of a leg.
    #[inline]
    pub fn layer(&self, angle: usize) -> &AngleLayer {
        if self.layers.len() == 1 { &self.layers[0] } else { &self.layers[angle] }
    }

    /// The bit index of two contacts.
    #[inline]
    pub fn two(&self, i: usize, j: usize) -> usize {
        i * self.contacts + j
    }

    /// The bit index of three contacts.
    #[inline]
    pub fn three(&self, i: usize, j: usize, k: usize) -> usize {
        (i * self.contacts + j) * self.contacts + k
    }

    /// The bit indices of two contacts, in both orders.
    pub fn pair(&self, [i, j]: [usize; 2]) -> [usize; 2] {
        [self.two(i, j), self.two(j, i)]
    }

    /// The bit indices of three contacts, in all orders.
    pub fn triple(&self, [i, j, k]: [usize; 3]) -> [usize; 6] {
        let orders = [[i, j, k], [i, k, j], [j, i, k], [j, k, i], [k, i, j], [k, j, i]];
        orders.map(|[i, j, k]| self.three(i, j, k))
    }

    /// Removes a grasp of two contacts from all layers, with the placements and removals that need it.
    pub fn remove_pair(&mut self, [i, j]: [usize; 2]) {
        let pair = self.pair([i, j]);
        let ways: Vec<usize> = (0..self.contacts).flat_map(|k| [self.three(i, j, k), self.three(j, i, k)]).collect();
        for layer in &mut self.layers {
            take_all([&mut layer.pair, &mut layer.roll_pair], &pair);
            take_all([&mut layer.place, &mut layer.leave], &ways);
        }
    }

    /// Removes a grasp of three contacts from all layers, with the placements and removals between it and its pairs.
    pub fn remove_triple(&mut self, contacts: [usize; 3]) {
        let triple = self.triple(contacts);
        for layer in &mut self.layers {
            take_all([&mut layer.triple, &mut layer.roll_triple], &triple);
            take_all([&mut layer.place, &mut layer.leave], &triple);
        }
    }
}

/// Removes numbers from sets.
fn take_all(sets: [&mut ContactBits; 2], numbers: &[usize]) {
    sets.into_iter().for_each(|set| numbers.iter().for_each(|number| set.take(*number)));
}

/// Grasps at one angle. Sets of pairs are symmetric. Sets of triples are, too, except for the last contact in `place`
/// and `leave`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct AngleLayer {
    /// Pairs of contacts that hold.
    pub pair: ContactBits,
    /// Triples of contacts that hold.
    pub triple: ContactBits,
    /// Pairs that keep holding while the object turns by a step, from this angle to the next.
    pub roll_pair: ContactBits,
    /// Triples that keep holding while the object turns by a step.
    pub roll_triple: ContactBits,
    /// Triples: while the first two contacts hold, a finger may be placed on the third.
    pub place: ContactBits,
    /// Triples: while the first two contacts hold, the finger on the third may be removed.
    pub leave: ContactBits,
}
