//! Square sets of pairs of contacts, one row of bits per contact.

/// A set of pairs of numbers below a size.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PairRows {
    size: usize,
    width: usize,
    words: Vec<u64>,
}

impl PairRows {
    /// The empty set.
    pub fn new(size: usize) -> PairRows {
        let width = size.div_ceil(64);
        PairRows { size, width, words: vec![0; width * size] }
    }

    /// The pairs of distinct numbers, in both orders, for which `holds` is true.
    pub fn symmetric(size: usize, holds: impl Fn(usize, usize) -> bool) -> PairRows {
        let mut rows = PairRows::new(size);
        for (i, j) in (0..size).flat_map(|i| (i + 1..size).map(move |j| (i, j))).filter(|&(i, j)| holds(i, j)) {
            rows.put(i, j);
            rows.put(j, i);
        }
        rows
    }

    /// Exclusive upper limit of the numbers.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Number of words per row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Whether it contains a pair.
    pub fn has(&self, i: usize, j: usize) -> bool {
        self.words[i * self.width + j / 64] >> (j % 64) & 1 == 1
    }

    /// The second numbers of the pairs that begin with `i`.
    pub fn row(&self, i: usize) -> &[u64] {
        &self.words[i * self.width..(i + 1) * self.width]
    }

    fn put(&mut self, i: usize, j: usize) {
        self.words[i * self.width + j / 64] |= 1 << (j % 64);
    }

    /// The pairs (i, j) for which it contains (i - 1, j - 1), cyclically.
    pub fn stepped(&self) -> PairRows {
        let mut stepped = PairRows::new(self.size);
        for i in 0..self.size {
            let from = (i + self.size - 1) % self.size * self.width;
            let to = i * self.width;
            step(&self.words[from..from + self.width], self.size, &mut stepped.words[to..to + self.width]);
        }
        stepped
    }

    /// Intersects with another set.
    pub fn keep(&mut self, other: &PairRows) {
        for (word, other) in self.words.iter_mut().zip(&other.words) {
            *word &= other;
        }
    }
}

/// The numbers one above those of a row, cyclically modulo `size`.
pub(super) fn step(row: &[u64], size: usize, stepped: &mut [u64]) {
    let mut carried = row[(size - 1) / 64] >> ((size - 1) % 64) & 1;
    for (word, to) in row.iter().zip(stepped.iter_mut()) {
        *to = word << 1 | carried;
        carried = word >> 63;
    }
    if !size.is_multiple_of(64) {
        stepped[size / 64] &= (1 << (size % 64)) - 1;
    }
}

/// The numbers of a row, in order.
pub(super) fn numbers(row: &[u64]) -> impl Iterator<Item = usize> + '_ {
    row.iter().enumerate().flat_map(|(k, word)| {
        let mut left = *word;
        std::iter::from_fn(move || {
            let bit = (left != 0).then(|| left.trailing_zeros() as usize)?;
            left &= left - 1;
            Some(k * 64 + bit)
        })
    })
}

/// Keeps the numbers of a row for which `keeps` is true.
pub(super) fn retain(row: &mut [u64], mut keeps: impl FnMut(usize) -> bool) {
    for (k, word) in row.iter_mut().enumerate() {
        for bit in numbers(&[*word]) {
            *word &= !(u64::from(!keeps(k * 64 + bit)) << bit);
        }
    }
}
