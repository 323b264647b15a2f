//! Square sets of pairs of contacts, a row of bits for each contact.

/// Pairs of numbers below a size.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PairRows {
    size: usize,
    width: usize,
    words: Vec<u64>,
}

impl PairRows {
    /// No pair.
    pub fn new(size: usize) -> PairRows {
        let width = size.div_ceil(64);
        PairRows { size, width, words: vec![0; width * size] }
    }

    /// The pairs of different numbers, in both orders, that `holds` says yes to.
    pub fn symmetric(size: usize, holds: impl Fn(usize, usize) -> bool) -> PairRows {
        let mut rows = PairRows::new(size);
        for (i, j) in (0..size).flat_map(|i| (i + 1..size).map(move |j| (i, j))).filter(|&(i, j)| holds(i, j)) {
            rows.put(i, j);
            rows.put(j, i);
        }
        rows
    }

    /// The numbers are below this.
    pub fn size(&self) -> usize {
        self.size
    }

    /// How many words a row has.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Whether a pair is in it.
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

    /// The pairs (i, j) of which the pair one lower, round the circle, is in it.
    pub fn stepped(&self) -> PairRows {
        let mut stepped = PairRows::new(self.size);
        for i in 0..self.size {
            let from = (i + self.size - 1) % self.size * self.width;
            let to = i * self.width;
            step(&self.words[from..from + self.width], self.size, &mut stepped.words[to..to + self.width]);
        }
        stepped
    }

    /// Keeps the pairs that are in the other too.
    pub fn keep(&mut self, other: &PairRows) {
        for (word, other) in self.words.iter_mut().zip(&other.words) {
            *word &= other;
        }
    }
}

/// The numbers one above those of a row, round the circle of `size`.
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

/// Keeps the numbers of a row that `keeps` says yes to.
pub(super) fn retain(row: &mut [u64], mut keeps: impl FnMut(usize) -> bool) {
    for (k, word) in row.iter_mut().enumerate() {
        for bit in numbers(&[*word]) {
            *word &= !(u64::from(!keeps(k * 64 + bit)) << bit);
        }
    }
}
