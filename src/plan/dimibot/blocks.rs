//! A coarse picture of a field: at most 64 by 64 blocks of cells, and between which blocks a flip exists.
//!
//! A module with a stroke of a block or more leads from block to block, one with a smaller stroke stays within its block. The picture keeps a flip between two blocks if
//! any of their cells has it. Distances between blocks, plus the weights of the small modules that differ, are therefore a lower bound on the cost
//! between cells, and a consistent one; blocks that are not connected prove that there is no path. For up to 6 modules a side a block is a cell.
//! Built once per field from the free runs of all lines; a block row is finished as soon as all its flips are known to exist.

use super::field::Reader;
use super::lattice::{Flip, Side, Weights, bits};

/// Modules of each side that lead from block to block.
const COARSE_MODULES: u32 = 6;
const BLOCKS: usize = 1 << (2 * COARSE_MODULES);
/// Lines computed for one field; all flips of blocks beyond that are taken to exist.
const MAX_LINES: u64 = 1 << 22;

/// Which flips exist between blocks.
pub(super) struct Blocks {
    /// Modules whose stroke is smaller than a block, by side.
    pub(super) fine: [u32; 2],
    coarse: [u32; 2],
    /// By block (y, x): the coarse modules of each side that may switch somewhere in it.
    flips: Vec<[u8; 2]>,
}

impl Blocks {
    pub(super) fn new(reader: &mut Reader<'_>) -> Self {
        let modules = reader.lattice().modules;
        let fine = modules.map(|n| n.saturating_sub(COARSE_MODULES));
        let coarse = [modules[0] - fine[0], modules[1] - fine[1]];
        let mut blocks = Blocks { fine, coarse, flips: vec![[0; 2]; BLOCKS] };
        let mut lines = MAX_LINES;
        for side in Side::BOTH {
            for across in 0..1 << coarse[side.other().index()] {
                let exist = blocks.along(reader, side, across, &mut lines);
                blocks.note(side, across, &exist);
            }
        }
        blocks
    }

    /// For each coarse module of `side` the set of blocks in the row (or column) `across` of blocks in which it may switch.
    fn along(
        &self,
        reader: &mut Reader<'_>,
        side: Side,
        across: u32,
        lines: &mut u64,
    ) -> [u64; COARSE_MODULES as usize] {
        let (fine, coarse) = (self.fine[side.index()], self.coarse[side.index()]);
        let all = u64::MAX >> (64 - (1_u32 << coarse));
        let mut exist = [0; COARSE_MODULES as usize];
        let width = self.fine[side.other().index()];
        for line in across << width..(across + 1) << width {
            if exist[..coarse as usize].iter().all(|set| *set == all) {
                break;
            }
            if *lines == 0 {
                return [all; COARSE_MODULES as usize];
            }
            *lines -= 1;
            reader.each_free_run(side, line, |[low, high]| {
                for i in 0..coarse {
                    let stroke = 1 << (fine + i);
                    if high - low >= stroke {
                        let from = range(low >> fine, (high - stroke) >> fine) & lower(i);
                        exist[i as usize] |= from | from << (1 << i);
                    }
                }
            });
        }
        exist
    }

    fn note(&mut self, side: Side, across: u32, exist: &[u64; COARSE_MODULES as usize]) {
        for along in 0..1_u32 << self.coarse[side.index()] {
            let mut at = [along; 2];
            at[side.other().index()] = across;
            let mask = (0..COARSE_MODULES as usize).map(|i| ((exist[i] >> along & 1) as u8) << i);
            self.flips[index(at)][side.index()] = mask.sum();
        }
    }

    /// The number of the block of a cell.
    #[inline]
    pub(super) fn block(&self, [x, y]: [u32; 2]) -> usize {
        index([x >> self.fine[0], y >> self.fine[1]])
    }
}

fn index([x, y]: [u32; 2]) -> usize {
    (y << COARSE_MODULES | x) as usize
}

fn range(first: u32, last: u32) -> u64 {
    (u64::MAX << first) & (u64::MAX >> (63 - last))
}

/// Blocks whose bit `i` is 0.
fn lower(i: u32) -> u64 {
    // 0101…, 00110011…, and so on.
    u64::MAX / ((1_u64 << (1 << i)) + 1)
}

/// Distances of blocks from one of them, found as far as they are asked for (Dijkstra's algorithm, with a cursor per distinct weight in place of a
/// heap).
#[derive(Default)]
pub(super) struct BlockDistances {
    distance: Vec<u64>,
    order: Vec<u16>,
    classes: Vec<Class>,
    exhausted: bool,
}

/// Coarse modules of equal weight.
struct Class {
    weight: u64,
    masks: [u8; 2],
    /// The first block of the order whose flips of this weight have not been followed.
    cursor: usize,
}

const UNKNOWN: u64 = u64::MAX;

impl BlockDistances {
    pub(super) fn begin(&mut self, blocks: &Blocks, origin: usize, weights: &Weights) {
        self.distance.clear();
        self.distance.resize(BLOCKS, UNKNOWN);
        self.order.clear();
        self.order.push(origin as u16);
        self.distance[origin] = 0;
        self.exhausted = false;
        self.classes.clear();
        for side in Side::BOTH {
            for i in 0..blocks.coarse[side.index()] {
                self.classify(side, i, weights.of(Flip { side, module: (blocks.fine[side.index()] + i) as u8 }));
            }
        }
    }

    fn classify(&mut self, side: Side, module: u32, weight: u64) {
        let at = match self.classes.iter().position(|class| class.weight == weight) {
            Some(at) => at,
            None => {
                self.classes.push(Class { weight, masks: [0; 2], cursor: 0 });
                self.classes.len() - 1
            }
        };
        self.classes[at].masks[side.index()] |= 1 << module;
    }

    /// Distance of the block from the origin; `None` if it is not connected with it.
    #[inline]
    pub(super) fn of(&mut self, blocks: &Blocks, block: usize) -> Option<u64> {
        while self.distance[block] == UNKNOWN {
            if self.exhausted {
                return None;
            }
            self.advance(blocks);
        }
        Some(self.distance[block])
    }

    fn advance(&mut self, blocks: &Blocks) {
        let head = |class: &Class| Some(self.distance[*self.order.get(class.cursor)? as usize] + class.weight);
        let heads = self.classes.iter().enumerate().filter_map(|(c, class)| Some((head(class)?, c)));
        let Some((distance, c)) = heads.min() else {
            self.exhausted = true;
            return;
        };
        let class = &mut self.classes[c];
        let block = self.order[class.cursor];
        class.cursor += 1;
        let flips = blocks.flips[block as usize];
        for (k, shift) in [(0, 0), (1, COARSE_MODULES)] {
            for bit in bits(u32::from(flips[k] & class.masks[k])) {
                let next = block ^ (bit << shift) as u16;
                if self.distance[next as usize] == UNKNOWN {
                    self.distance[next as usize] = distance;
                    self.order.push(next);
                }
            }
        }
    }
}
