//! Free and blocked runs of the lines of a lattice, computed on first use.
//!
//! Up to [`EAGER_MODULES`] modules the lines are kept in an array, above that in a hash map.

use super::lattice::{Lattice, Side};
use super::obstacles::Obstacles;
use rustc_hash::FxHashMap;

/// Most modules of a side for which the lines of the other side are kept in an array.
const EAGER_MODULES: u32 = 13;
/// Blocked runs kept by the cache of lines before it is emptied.
const MAX_CACHED_RUNS: usize = 1 << 24;

/// View of the obstacles that may compute and cache lines.
pub(super) struct LineReader<'a> {
    pub(super) obstacles: &'a Obstacles,
    pub(super) lines: &'a mut [BlockedLines; 2],
}

/// The blocked runs of the lines queried so far, in slots (cells and gaps), sorted and disjoint.
pub(super) struct BlockedLines {
    store: Store,
    runs: Vec<[u32; 2]>,
    fresh: Vec<[u32; 2]>,
    cuts: Vec<[f64; 2]>,
}

enum Store {
    /// Start and length in `runs`, by line; `UNKNOWN` as start if not yet computed.
    Array(Vec<[u32; 2]>),
    Map(FxHashMap<u32, [u32; 2]>),
}

const UNKNOWN: u32 = u32::MAX;

impl BlockedLines {
    /// Empty cache for the lines of one side; `modules` is the number of modules of the other side.
    pub(super) fn new(modules: u32) -> Self {
        let store = match modules <= EAGER_MODULES {
            true => Store::Array(Vec::new()),
            false => Store::Map(FxHashMap::default()),
        };
        BlockedLines { store, runs: Vec::new(), fresh: Vec::new(), cuts: Vec::new() }
    }

    fn known(&self, line: u32) -> Option<[u32; 2]> {
        match &self.store {
            Store::Array(at) => at.get(line as usize).copied().filter(|[start, _]| *start != UNKNOWN),
            Store::Map(at) => at.get(&line).copied(),
        }
    }

    fn compute(&mut self, obstacles: &Obstacles, side: Side, line: u32) -> [u32; 2] {
        if self.runs.len() > MAX_CACHED_RUNS {
            self.forget();
        }
        let start = self.runs.len();
        self.append(obstacles, side, line);
        let place = [start as u32, (self.runs.len() - start) as u32];
        match &mut self.store {
            Store::Array(at) => {
                if at.is_empty() {
                    at.resize(obstacles.lattice.last(side.other()) as usize + 1, [UNKNOWN, 0]);
                }
                at[line as usize] = place;
            }
            Store::Map(at) => {
                at.insert(line, place);
            }
        }
        place
    }

    /// Appends the line's runs, sorted and disjoint, to `runs`.
    fn append(&mut self, obstacles: &Obstacles, side: Side, line: u32) {
        self.fresh.clear();
        obstacles.line_runs(side, line, &mut self.fresh, &mut self.cuts);
        self.fresh.sort_unstable();
        let start = self.runs.len();
        for &[first, last] in &self.fresh {
            match self.runs[start..].last_mut() {
                Some(run) if first <= run[1].saturating_add(1) => run[1] = run[1].max(last),
                Some(_) | None => self.runs.push([first, last]),
            }
        }
    }

    fn forget(&mut self) {
        self.runs.clear();
        match &mut self.store {
            Store::Array(at) => at.clear(),
            Store::Map(at) => at.clear(),
        }
    }
}

impl LineReader<'_> {
    pub(super) const fn lattice(&self) -> &Lattice {
        &self.obstacles.lattice
    }

    /// The blocked runs of a line.
    fn runs(&mut self, side: Side, line: u32) -> &[[u32; 2]] {
        if self.obstacles.leave_free(side, line) {
            return &[];
        }
        let lines = &mut self.lines[side.index()];
        let [start, count] = match lines.known(line) {
            Some(place) => place,
            None => lines.compute(self.obstacles, side, line),
        };
        &lines.runs[start as usize..(start + count) as usize]
    }

    /// Calls `visit` with the first and last cell of each free run of the line. Lines of large lattices are not cached, since a
    /// caller may visit all of them.
    pub(super) fn each_free_run(&mut self, side: Side, line: u32, mut visit: impl FnMut([u32; 2])) {
        let last = self.obstacles.lattice.last(side);
        let mut low = 0;
        let lines = &mut self.lines[side.index()];
        let kept = lines.runs.len();
        let passing = matches!(lines.store, Store::Map(_));
        let runs = match passing {
            true => {
                lines.append(self.obstacles, side, line);
                &lines.runs[kept..]
            }
            false => self.runs(side, line),
        };
        for run in runs {
            if 2 * low < run[0] {
                visit([low, (run[0] - 1) / 2]);
            }
            low = run[1] / 2 + 1;
        }
        if low <= last {
            visit([low, last]);
        }
        if passing {
            self.lines[side.index()].runs.truncate(kept);
        }
    }

    /// First and last cell reachable along `side` from cell `at` of `line` without a gap; `None` if that cell is covered.
    #[inline]
    pub(super) fn free_run(&mut self, side: Side, line: u32, at: u32) -> Option<[u32; 2]> {
        let last = self.obstacles.lattice.last(side);
        let runs = self.runs(side, line);
        let next = runs.partition_point(|run| run[1] < 2 * at);
        let low = match next.checked_sub(1) {
            Some(before) => runs[before][1] / 2 + 1,
            None => 0,
        };
        match runs.get(next) {
            Some(run) if run[0] <= 2 * at => None,
            Some(run) => Some([low, (run[0] - 1) / 2]),
            None => Some([low, last]),
        }
    }

    /// The modules of each side that may switch alone; `None` if an obstacle covers the cell.
    #[inline]
    pub(super) fn legal(&mut self, [x, y]: [u32; 2]) -> Option<[u32; 2]> {
        let row = self.free_run(Side::Left, y, x)?;
        let column = self.free_run(Side::Right, x, y)?;
        Some([stays_within(x, row), stays_within(y, column)])
    }
}

/// Bits whose flip keeps `at` within the run.
#[inline]
fn stays_within(at: u32, [low, high]: [u32; 2]) -> u32 {
    (!at & up_to(high - at)) | (at & up_to(at - low))
}

/// All powers of two that are at most `reach`, as one mask.
#[inline]
fn up_to(reach: u32) -> u32 {
    // The leading bit and everything below it.
    u32::MAX.checked_shr(reach.leading_zeros()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn flips_stay_within_the_free_run() {
        assert_eq!(up_to(0), 0);
        assert_eq!(up_to(1), 1);
        assert_eq!(up_to(5), 0b111);
        assert_eq!(stays_within(0b0110, [0, 15]), 0b1111);
        assert_eq!(stays_within(0b0110, [5, 9]), 0b0001);
        assert_eq!(stays_within(0b0110, [4, 7]), 0b0011);
    }
}
