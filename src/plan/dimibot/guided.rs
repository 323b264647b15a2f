//! The shortest path between two cells, guided by the distances of blocks.
//!
//! Problem: least sum of weights from start to goal over legal flips. Method: A* whose estimate is the distance of the blocks (see [`super::blocks`]) plus the
//! weights of the differing small modules; it is consistent, so cells are settled in order of their excess over the start's estimate, depth first
//! within equal excess, from a radix queue. A flood from the goal runs beside it at a fraction of its pace, so that a goal in a small pocket is found to be
//! shut without visiting the rest. Guaranteed: optimal cost, or a component visited in full, or blocks without connection, as a proof that there
//! is no path. Cost: settled cells times modules.

use super::blocks::{BlockDistances, Blocks};
use super::field::Reader;
use super::lattice::{Flip, Side, Weights, bits};
use super::queue::RadixQueue;
use super::seen::Seen;
use crate::plan::search::{GaveUp, Meter};

/// Cells settled from the start for each cell flooded from the goal.
const PACE: u64 = 4;
/// Parent of the start.
const NONE: u32 = u32::MAX;
/// Cells settled; keeps indices within 32 bits.
const MAX_ENTRIES: usize = 1 << 30;

/// Lists kept between searches.
#[derive(Default)]
pub(super) struct Workspace {
    pub(super) blocks: Option<Blocks>,
    distances: BlockDistances,
    queue: RadixQueue<Entry>,
    entries: Vec<Entry>,
    settled: Seen,
    flooded: Seen,
    flood: Vec<[u32; 2]>,
}

#[derive(Clone, Copy)]
struct Entry {
    at: [u32; 2],
    parent: u32,
    by: Flip,
}

/// How a guided search ends.
pub(super) enum Guided {
    /// An optimal path.
    Path(Vec<Flip>),
    /// The start's component was visited in full, or its part in the blocks that are connected with the goal's: that many cells.
    StartShut(u64),
    /// The goal's component was visited in full.
    GoalShut(u64),
    /// The budget ran out.
    GaveUp(GaveUp),
}

pub(super) struct Search<'a, 'f> {
    reader: Reader<'f>,
    blocks: &'a Blocks,
    distances: &'a mut BlockDistances,
    queue: &'a mut RadixQueue<Entry>,
    entries: &'a mut Vec<Entry>,
    settled: &'a mut Seen,
    flooded: &'a mut Seen,
    flood: &'a mut Vec<[u32; 2]>,
    /// Cells of `flood` whose neighbours have been added.
    spread: usize,
    weights: &'a Weights,
    goal: [u32; 2],
}

impl Workspace {
    /// Searches from the first cell to the second; both must be free and different.
    pub(super) fn search(
        &mut self,
        mut reader: Reader<'_>,
        weights: &Weights,
        ends: [[u32; 2]; 2],
        meter: &mut Meter,
    ) -> Guided {
        let modules = reader.lattice().modules;
        let blocks = self.blocks.get_or_insert_with(|| Blocks::new(&mut reader));
        self.distances.begin(blocks, blocks.block(ends[1]), weights);
        self.settled.begin(modules);
        self.flooded.begin(modules);
        let mut search = Search {
            reader,
            blocks,
            distances: &mut self.distances,
            queue: &mut self.queue,
            entries: &mut self.entries,
            settled: &mut self.settled,
            flooded: &mut self.flooded,
            flood: &mut self.flood,
            spread: 0,
            weights,
            goal: ends[1],
        };
        let answer = search.run(ends[0], meter);
        self.queue.clear();
        self.settled.clear(self.entries.drain(..).map(|entry| entry.at));
        self.flooded.clear(self.flood.drain(..));
        answer
    }
}

impl Search<'_, '_> {
    fn run(&mut self, start: [u32; 2], meter: &mut Meter) -> Guided {
        let Some(base) = self.estimate(start) else {
            return Guided::StartShut(0);
        };
        self.queue.push(0, Entry { at: start, parent: NONE, by: Flip::of_bit(Side::Left, 1) });
        self.flooded.insert(self.goal);
        self.flood.push(self.goal);
        while let Some(entry) = self.queue.pop() {
            if !self.settled.insert(entry.at) {
                continue;
            }
            if entry.at == self.goal {
                self.entries.push(entry);
                return Guided::Path(self.path());
            }
            if meter.step().is_none() || self.entries.len() >= MAX_ENTRIES {
                self.settled_but_not_kept(entry.at);
                return Guided::GaveUp(meter.gave_up(base + self.queue.last()));
            }
            self.entries.push(entry);
            self.expand(entry.at);
            if meter.spent() % PACE == 0 && !self.flood_one() {
                return Guided::GoalShut(self.flood.len() as u64);
            }
        }
        Guided::StartShut(self.entries.len() as u64)
    }

    // The set is cleared by walking the entries, so that this cell must be among them.
    fn settled_but_not_kept(&mut self, at: [u32; 2]) {
        self.entries.push(Entry { at, parent: NONE, by: Flip::of_bit(Side::Left, 1) });
    }

    /// Lower bound on the cost to the goal; `None` if the blocks are not connected.
    fn estimate(&mut self, at: [u32; 2]) -> Option<u64> {
        let block = self.blocks.block(at);
        let coarse = self.distances.of(self.blocks, block)?;
        let small = |k: usize| (at[k] ^ self.goal[k]) & ((1 << self.blocks.fine[k]) - 1);
        Some(coarse + self.weights.of_masks([small(0), small(1)]))
    }

    #[inline]
    fn expand(&mut self, at: [u32; 2]) {
        let Some(legal) = self.reader.legal(at) else { return };
        let parent = self.entries.len() as u32 - 1;
        let excess = self.queue.last();
        let here = self.distances.of(self.blocks, self.blocks.block(at)).unwrap_or(0);
        for side in Side::BOTH {
            let k = side.index();
            let small = (1 << self.blocks.fine[k]) - 1;
            for bit in bits(legal[k] & small) {
                let weight = u64::from(self.weights.of[k][bit.trailing_zeros() as usize]);
                let away = if (at[k] ^ self.goal[k]) & bit == 0 { 2 * weight } else { 0 };
                self.offer(at, side, bit, parent, excess + away);
            }
            for bit in bits(legal[k] & !small) {
                let mut next = at;
                next[k] ^= bit;
                let weight = u64::from(self.weights.of[k][bit.trailing_zeros() as usize]);
                if let Some(there) = self.distances.of(self.blocks, self.blocks.block(next)) {
                    self.offer(at, side, bit, parent, excess + weight + there - here);
                }
            }
        }
    }

    #[inline]
    fn offer(&mut self, mut at: [u32; 2], side: Side, bit: u32, parent: u32, excess: u64) {
        at[side.index()] ^= bit;
        if !self.settled.contains(at) {
            self.queue.push(excess, Entry { at, parent, by: Flip::of_bit(side, bit) });
        }
    }

    /// Adds the neighbours of one more cell to the flood; `false` if there is none, so that the goal's component is known.
    fn flood_one(&mut self) -> bool {
        let Some(&at) = self.flood.get(self.spread) else {
            return false;
        };
        self.spread += 1;
        let legal = self.reader.legal(at).unwrap_or([0, 0]);
        for side in Side::BOTH {
            for bit in bits(legal[side.index()]) {
                let mut next = at;
                next[side.index()] ^= bit;
                if self.flooded.insert(next) {
                    self.flood.push(next);
                }
            }
        }
        true
    }

    fn path(&self) -> Vec<Flip> {
        let mut flips = Vec::new();
        let mut index = self.entries.len() - 1;
        while self.entries[index].parent != NONE {
            flips.push(self.entries[index].by);
            index = self.entries[index].parent as usize;
        }
        flips.reverse();
        flips
    }
}
