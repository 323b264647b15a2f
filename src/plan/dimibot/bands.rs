//! Index from a line (row or column) to the obstacles that may meet it. Neighbouring lines are grouped into bands of
//! equal size.
//!
//! Input: for each obstacle the first and last line that it may meet. Output: for a line, a slice of candidates in
//! ascending order.
//! Guaranteed: no candidate is missing; memory stays under [`MAX_ENTRIES`] plus two entries per obstacle.

/// Largest number of (band, obstacle) pairs kept before the bands are made coarser.
const MAX_ENTRIES: u64 = 1 << 22;
/// Number of bands aimed for, or twice the number of obstacles if that is larger.
const MIN_BANDS: usize = 1 << 12;

pub(super) struct Bands {
    shift: u32,
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Bands {
    /// `spans[k]` is the inclusive range of lines that obstacle `k` may meet, empty if `first > last`; there are 2^`modules` lines.
    pub(super) fn new(modules: u32, spans: &[[u32; 2]]) -> Self {
        let wanted = spans.len().saturating_mul(2).max(MIN_BANDS);
        let finest = modules.saturating_sub(wanted.ilog2());
        let allowed = MAX_ENTRIES + 2 * spans.len() as u64;
        let entries = |shift: u32| -> u64 {
            let bands = |[first, last]: &[u32; 2]| u64::from((last >> shift) - (first >> shift)) + 1;
            spans.iter().filter(|s| s[0] <= s[1]).map(bands).sum()
        };
        let shift = (finest..modules).find(|&shift| entries(shift) <= allowed).unwrap_or(modules);
        Bands::fill(modules, shift, spans)
    }

    fn fill(modules: u32, shift: u32, spans: &[[u32; 2]]) -> Self {
        let mut starts = vec![0_u32; (1 << (modules - shift)) + 1];
        let covered = |[first, last]: [u32; 2]| (first <= last).then_some(first >> shift..=last >> shift);
        for band in spans.iter().copied().filter_map(covered).flatten() {
            starts[band as usize + 1] += 1;
        }
        for k in 1..starts.len() {
            starts[k] += starts[k - 1];
        }
        let mut next = starts.clone();
        let mut items = vec![0; starts.last().map_or(0, |&n| n as usize)];
        for (k, span) in spans.iter().enumerate() {
            for band in covered(*span).into_iter().flatten() {
                items[next[band as usize] as usize] = k as u32;
                next[band as usize] += 1;
            }
        }
        Bands { shift, starts, items }
    }

    /// Obstacles that may meet `line`.
    pub(super) fn candidates(&self, line: u32) -> &[u32] {
        let band = (line >> self.shift) as usize;
        &self.items[self.starts[band] as usize..self.starts[band + 1] as usize]
    }

    /// The candidates of each band that meets the inclusive range of lines, clipped to the lattice.
    pub(super) fn between(&self, first: u32, last: u32) -> impl Iterator<Item = &[u32]> {
        let bands = (self.starts.len() - 1) as u32;
        let meeting = first >> self.shift..(last >> self.shift).saturating_add(1).min(bands);
        meeting.map(|band| self.candidates(band << self.shift))
    }
}
