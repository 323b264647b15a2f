//! Best-first search between two cells (or blocks), guided by the distances of blocks.
//!
//! Problem: least sum of weights from one cell to another over legal flips. Method: A* with a consistent heuristic: the distance
//! between blocks plus the weights of the fine modules that differ; cells are settled in order of their excess over the first
//! estimate, depth first within equal excess. A greed above one multiplies the heuristic (weighted A*): a path is found sooner but
//! may not be optimal. Guaranteed: with a greed of one the path is optimal; exhaustion proves that there is no path. Cost: settled
//! cells times modules.

use super::blocks::{BlockDistances, Blocks};
use super::lattice::{Flip, Side, SwitchWeights, bits};
use super::lines::LineReader;
use super::queue::RadixQueue;
use super::seen::Seen;
use crate::plan::search::Meter;

/// Parent of the start cell.
const NONE: u32 = u32::MAX;
/// Most cells settled; keeps indices within 32 bits.
const MAX_ENTRIES: usize = 1 << 30;

/// State space of a search: the cells of a lattice, or the blocks of an abstraction.
pub(super) trait SearchSpace {
    /// Number of modules of each side.
    fn modules(&self) -> [u32; 2];
    /// The modules of each side that may switch; none if the cell is covered.
    fn legal(&mut self, at: [u32; 2]) -> [u32; 2];
}

impl SearchSpace for LineReader<'_> {
    fn modules(&self) -> [u32; 2] {
        self.lattice().modules
    }

    #[inline]
    fn legal(&mut self, at: [u32; 2]) -> [u32; 2] {
        LineReader::legal(self, at).unwrap_or([0, 0])
    }
}

/// The blocks of an abstraction as cells of a smaller lattice.
impl SearchSpace for &Blocks {
    fn modules(&self) -> [u32; 2] {
        self.coarse
    }

    #[inline]
    fn legal(&mut self, at: [u32; 2]) -> [u32; 2] {
        self.flips_at(at)
    }
}

/// A consistent lower bound on the cost to the target, not counting the fine modules that differ.
pub(super) trait Guide {
    /// Fine modules of each side, which the bound does not cover.
    fn fine(&self) -> [u32; 2];
    /// The bound; `None` if the target cannot be reached.
    fn coarse(&self, at: [u32; 2]) -> Option<u64>;
}

#[derive(Clone, Copy)]
/// Distances of the blocks of an abstraction, for a search whose lattice leaves out the `shift` lowest modules.
pub(super) struct BlockGuide<'a> {
    pub(super) blocks: &'a Blocks,
    pub(super) distances: &'a BlockDistances,
    pub(super) shift: [u32; 2],
}

impl Guide for BlockGuide<'_> {
    #[inline]
    fn fine(&self) -> [u32; 2] {
        [self.blocks.fine[0] - self.shift[0], self.blocks.fine[1] - self.shift[1]]
    }

    #[inline]
    fn coarse(&self, at: [u32; 2]) -> Option<u64> {
        let block = self.blocks.block([at[0] << self.shift[0], at[1] << self.shift[1]]);
        self.distances.of(block)
    }
}

#[derive(Clone, Copy)]
struct QueueEntry {
    at: [u32; 2],
    parent: u32,
    by: Flip,
}

/// A settled cell and its excess: cost so far plus heuristic, minus the heuristic at the start. With greed it may fall below zero.
#[derive(Clone, Copy)]
struct SettledCell {
    entry: QueueEntry,
    excess: i64,
}

/// Buffers reused by successive searches.
#[derive(Default)]
pub(super) struct Lists {
    queue: RadixQueue<QueueEntry>,
    entries: Vec<SettledCell>,
    settled: Seen,
}

/// Outcome of a search.
pub(super) enum SearchEnd {
    /// The target was reached.
    Found,
    /// All reachable cells were settled; this many.
    Exhausted(u64),
    /// The companion stopped the search: it has proven that there is no path.
    Stopped,
    /// The budget ran out; this was the least excess left.
    OutOfBudget(u64),
}

/// A search; one step of its meter is one cell queued.
pub(super) struct GuidedSearch<'a, G, H> {
    pub(super) ground: &'a mut G,
    pub(super) guide: &'a H,
    pub(super) lists: &'a mut Lists,
    pub(super) weights: &'a SwitchWeights,
    pub(super) target: [u32; 2],
    /// Heuristic weight (weighted A*).
    pub(super) greed: i64,
}

impl<G: SearchSpace, H: Guide> GuidedSearch<'_, G, H> {
    /// Searches a path from `start` to the target. `companion` is called for each settled cell; returning `false` stops
    /// the search.
    pub(super) fn run(
        &mut self,
        start: [u32; 2],
        meter: &mut Meter,
        mut companion: impl FnMut(&mut G) -> bool,
    ) -> SearchEnd {
        self.lists.begin(self.ground.modules());
        self.lists.queue.push(0, QueueEntry { at: start, parent: NONE, by: Flip::of_bit(Side::Left, 1) });
        while let Some(entry) = self.lists.queue.pop() {
            if !self.lists.settled.insert(entry.at) {
                continue;
            }
            let excess = self.excess(&entry);
            self.lists.entries.push(SettledCell { entry, excess });
            if entry.at == self.target {
                return SearchEnd::Found;
            }
            if meter.left().steps == 0 || self.lists.entries.len() >= MAX_ENTRIES {
                return SearchEnd::OutOfBudget(self.lists.queue.last());
            }
            meter.charge(self.expand(entry.at, excess));
            if !companion(self.ground) {
                return SearchEnd::Stopped;
            }
        }
        SearchEnd::Exhausted(self.lists.entries.len() as u64)
    }

    /// Lower bound on the cost from the cell to the target.
    pub(super) fn estimate(&self, at: [u32; 2]) -> Option<u64> {
        Some(self.guide.coarse(at)? + small_difference(self.guide, self.weights, at, self.target))
    }

    #[inline]
    fn excess(&self, entry: &QueueEntry) -> i64 {
        if self.greed == 1 {
            return self.lists.queue.last() as i64;
        }
        let Some(parent) = self.lists.entries.get(entry.parent as usize) else {
            return 0;
        };
        let weight = self.weights.of(entry.by) as i64;
        let estimate = |at| self.estimate(at).map_or(0, |e| e as i64);
        parent.excess + weight + self.greed * (estimate(entry.at) - estimate(parent.entry.at))
    }

    #[inline]
    fn expand(&mut self, at: [u32; 2], excess: i64) -> u64 {
        let legal = self.ground.legal(at);
        let parent = self.lists.entries.len() as u32 - 1;
        let Some(here) = self.guide.coarse(at) else {
            return 1;
        };
        let mut queued = 1;
        for side in Side::BOTH {
            let k = side.index();
            let small = (1 << self.guide.fine()[k]) - 1;
            for bit in bits(legal[k]) {
                let mut next = at;
                next[k] ^= bit;
                if self.lists.settled.contains(next) {
                    continue;
                }
                let weight = self.weights.of[k][bit.trailing_zeros() as usize] as i64;
                let closer = match bit & small {
                    0 => match self.guide.coarse(next) {
                        Some(there) => here as i64 - there as i64,
                        None => continue,
                    },
                    _ if (at[k] ^ self.target[k]) & bit == 0 => -weight,
                    _ => weight,
                };
                let entry = QueueEntry { at: next, parent, by: Flip::of_bit(side, bit) };
                // With greed the excess may fall; the queue is monotone, so the cell joins the current layer.
                let excess = (excess + weight - self.greed * closer).max(self.lists.queue.last() as i64);
                self.lists.queue.push(excess as u64, entry);
                queued += 1;
            }
        }
        queued
    }
}

/// Guide without blocks: all modules are fine.
pub(super) struct NoBlocks {
    pub(super) modules: [u32; 2],
}

impl Guide for NoBlocks {
    #[inline]
    fn fine(&self) -> [u32; 2] {
        self.modules
    }

    #[inline]
    fn coarse(&self, _: [u32; 2]) -> Option<u64> {
        Some(0)
    }
}

/// Weights of the fine modules by which two cells differ.
pub(super) fn small_difference(guide: &impl Guide, weights: &SwitchWeights, a: [u32; 2], b: [u32; 2]) -> u64 {
    let small = |k: usize| (a[k] ^ b[k]) & ((1 << guide.fine()[k]) - 1);
    weights.of_masks([small(0), small(1)])
}

impl Lists {
    fn begin(&mut self, modules: [u32; 2]) {
        self.queue.clear();
        self.settled.clear(self.entries.drain(..).map(|s| s.entry.at));
        self.settled.begin(modules);
    }

    /// Cells settled by the last search with their excess, in ascending order of excess. That search must have had a
    /// greed of one.
    pub(super) fn settled(&self) -> impl Iterator<Item = ([u32; 2], u64)> {
        self.entries.iter().map(|s| (s.entry.at, s.excess as u64))
    }

    /// The flips to the cell settled last.
    pub(super) fn path(&self) -> Vec<Flip> {
        let mut flips = Vec::new();
        let mut at = self.entries.last();
        while let Some(SettledCell { entry, .. }) = at.filter(|s| s.entry.parent != NONE) {
            flips.push(entry.by);
            at = self.entries.get(entry.parent as usize);
        }
        flips.reverse();
        flips
    }
}
