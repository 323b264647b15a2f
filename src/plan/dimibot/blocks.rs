//! Coarse abstraction of a field: blocks of cells, and the flips that exist between blocks.
//!
//! A module whose stroke is at least a block wide (coarse) leads from block to block; one with a smaller stroke (fine)
//! stays within its block. A flip exists between two blocks if it is legal between any of their cells. So a path
//! between cells costs at least the distance between their blocks plus the weights of the fine modules that differ (an
//! admissible heuristic), and there is no path between blocks that are not connected. The abstraction is built once per
//! field from the free runs of all lines; a row of blocks is finished as soon as all its flips are known to exist.

use super::lattice::{Side, SwitchWeights, bits};
use super::lines::LineReader;

/// Coarse modules of each side in the finest abstraction: 1024 by 1024 blocks.
const MAX_COARSE: u32 = 10;
const WORDS: usize = 1 << (MAX_COARSE - 6);
/// Most lines computed for one field; beyond them all flips of blocks are assumed to exist, which keeps the bound
/// admissible.
const MAX_LINES: u64 = 1 << 22;

/// Block abstraction of a field: the flips that exist between blocks.
pub(super) struct Blocks {
    /// Modules whose stroke is smaller than a block, by side.
    pub(super) fine: [u32; 2],
    /// The other modules, by side.
    pub(super) coarse: [u32; 2],
    /// Indexed by block (y in the high bits): the coarse modules of each side that may switch somewhere in it.
    flips: Vec<[u16; 2]>,
    /// Indexed by block: its connected component.
    component: Vec<u32>,
}

/// For each coarse module, the blocks of a row in which it may switch, as a bit set.
type Exist = [[u64; WORDS]; MAX_COARSE as usize];

impl Blocks {
    /// The abstraction with at most 2^`coarse` blocks per side, `coarse` ≤ 10.
    pub(super) fn new(reader: &mut LineReader<'_>, coarse: u32) -> Self {
        let modules = reader.lattice().modules;
        let coarse = modules.map(|n| n.min(coarse));
        let mut blocks = Blocks::without_flips(modules, coarse);
        let mut lines = MAX_LINES;
        for side in Side::BOTH {
            for across in 0..1 << coarse[side.other().index()] {
                let exist = blocks.along(reader, side, across, &mut lines);
                blocks.note(side, across, &exist);
            }
        }
        blocks.label();
        blocks
    }

    fn without_flips(modules: [u32; 2], coarse: [u32; 2]) -> Self {
        let fine = [modules[0] - coarse[0], modules[1] - coarse[1]];
        let flips = vec![[0; 2]; 1 << (coarse[0] + coarse[1])];
        Blocks { fine, coarse, flips, component: Vec::new() }
    }

    /// For each coarse module of `side` the set of blocks in the row (or column) `across` of blocks in which it may switch.
    fn along(&self, reader: &mut LineReader<'_>, side: Side, across: u32, lines: &mut u64) -> Exist {
        let (fine, coarse) = (self.fine[side.index()], self.coarse[side.index()]);
        let count = 1_u32 << coarse;
        let mut all = [0; WORDS];
        fill(&mut all, 0, count - 1);
        let mut exist = [[0; WORDS]; MAX_COARSE as usize];
        let width = self.fine[side.other().index()];
        let mut before = Vec::new();
        let mut runs = Vec::new();
        for line in across << width..(across + 1) << width {
            if exist[..coarse as usize].iter().all(|set| *set == all) {
                break;
            }
            if *lines == 0 {
                return [all; MAX_COARSE as usize];
            }
            *lines -= 1;
            runs.clear();
            reader.each_free_run(side, line, |run| runs.extend(from_blocks(run, fine, coarse)));
            // Neighbouring lines mostly have the same runs of blocks.
            if runs != before {
                runs.iter().for_each(|&(i, from)| add(&mut exist[i as usize], i, from));
                std::mem::swap(&mut runs, &mut before);
            }
        }
        exist
    }

    fn note(&mut self, side: Side, across: u32, exist: &Exist) {
        for along in 0..1_u32 << self.coarse[side.index()] {
            let mut at = [along; 2];
            at[side.other().index()] = across;
            let (word, bit) = ((along / 64) as usize, along % 64);
            let mask = (0..MAX_COARSE as usize).map(|i| ((exist[i][word] >> bit & 1) as u16) << i);
            let at = self.index(at);
            self.flips[at][side.index()] = mask.sum();
        }
    }

    fn label(&mut self) {
        self.component = vec![u32::MAX; self.flips.len()];
        let mut stack = Vec::new();
        for origin in 0..self.flips.len() as u32 {
            if self.component[origin as usize] != u32::MAX {
                continue;
            }
            self.component[origin as usize] = origin;
            stack.push(origin);
            while let Some(block) = stack.pop() {
                for bit in bits(self.all_flips(block)) {
                    let next = block ^ bit;
                    if self.component[next as usize] == u32::MAX {
                        self.component[next as usize] = origin;
                        stack.push(next);
                    }
                }
            }
        }
    }

    #[inline]
    fn index(&self, [x, y]: [u32; 2]) -> usize {
        (y << self.coarse[0] | x) as usize
    }

    /// Index of a cell's block, y in the high bits.
    #[inline]
    pub(super) fn block(&self, [x, y]: [u32; 2]) -> u32 {
        y >> self.fine[1] << self.coarse[0] | x >> self.fine[0]
    }

    /// The flips of both sides as one mask over the block's index.
    #[inline]
    fn all_flips(&self, block: u32) -> u32 {
        let [left, right] = self.flips[block as usize];
        u32::from(left) | u32::from(right) << self.coarse[0]
    }

    /// Whether the two blocks are connected in the abstraction.
    pub(super) fn connected(&self, a: u32, b: u32) -> bool {
        self.component[a as usize] == self.component[b as usize]
    }

    /// The coarse modules of each side that may switch in the block at these block coordinates.
    #[inline]
    pub(super) fn flips_at(&self, at: [u32; 2]) -> [u32; 2] {
        self.flips[self.index(at)].map(u32::from)
    }
}

/// For each coarse module whose stroke fits in the free run, the inclusive range of blocks from which it leads upward;
/// the caller must drop the blocks whose bit of that module is 1.
fn from_blocks([low, high]: [u32; 2], fine: u32, coarse: u32) -> impl Iterator<Item = (u32, [u32; 2])> {
    let strokes = (0..coarse).map(move |i| (i, 1 << (fine + i)));
    strokes
        .take_while(move |(_, stroke)| high - low >= *stroke)
        .map(move |(i, stroke)| (i, [low >> fine, (high - stroke) >> fine]))
}

/// Adds the flips of module `i`, in both directions, between the blocks of the range whose bit `i` is 0 and the blocks
/// above them.
fn add(set: &mut [u64; WORDS], i: u32, [first, last]: [u32; 2]) {
    let mut from = [0; WORDS];
    fill(&mut from, first, last);
    match i.checked_sub(6) {
        None => {
            // Blocks whose bit i is 0: …0101, …00110011 and so on.
            let zero = u64::MAX / ((1_u64 << (1 << i)) + 1);
            for (set, from) in set.iter_mut().zip(from) {
                let from = from & zero;
                *set |= from | from << (1 << i);
            }
        }
        Some(j) => {
            for word in (0..WORDS).filter(|word| word >> j & 1 == 0) {
                set[word] |= from[word];
                set[word | 1 << j] |= from[word];
            }
        }
    }
}

fn fill(set: &mut [u64; WORDS], first: u32, last: u32) {
    for word in first / 64..=last / 64 {
        let low = u64::MAX << if word == first / 64 { first % 64 } else { 0 };
        let high = u64::MAX >> if word == last / 64 { 63 - last % 64 } else { 0 };
        set[word as usize] |= low & high;
    }
}

/// Distances of all blocks to one of them, by Dijkstra's algorithm. Each distinct weight has a cursor into the list of
/// settled blocks, which takes the place of a heap.
#[derive(Default)]
pub(super) struct BlockDistances {
    /// Indexed by block: distance to the origin, or [`UNKNOWN`].
    distance: Vec<u64>,
    settled: Vec<SettledBlock>,
    classes: Vec<Class>,
}

#[derive(Clone, Copy)]
struct SettledBlock {
    block: u32,
    /// The coarse modules that may switch in it, as one mask over the block's index.
    flips: u32,
    distance: u64,
}

/// Coarse modules of equal weight.
struct Class {
    weight: u64,
    /// The modules, as a mask over a block's index.
    mask: u32,
    /// The first settled block whose flips of this weight have not been followed.
    cursor: usize,
}

const UNKNOWN: u64 = u64::MAX;

impl BlockDistances {
    /// Finds all distances to the origin; `weights` are those of the lattice.
    pub(super) fn find(&mut self, blocks: &Blocks, origin: u32, weights: &SwitchWeights) {
        self.distance.clear();
        self.distance.resize(blocks.flips.len(), UNKNOWN);
        self.settled.clear();
        self.classify(blocks, weights);
        self.reach(blocks, origin, 0);
        while let Some((distance, class)) = self.next_layer() {
            self.follow(blocks, distance, class);
        }
    }

    fn classify(&mut self, blocks: &Blocks, weights: &SwitchWeights) {
        self.classes.clear();
        let mut bit = 1;
        for side in Side::BOTH {
            let k = side.index();
            for module in blocks.fine[k]..blocks.fine[k] + blocks.coarse[k] {
                let weight = weights.of[k][module as usize];
                match self.classes.iter_mut().find(|class| class.weight == weight) {
                    Some(class) => class.mask |= bit,
                    None => self.classes.push(Class { weight, mask: bit, cursor: 0 }),
                }
                bit <<= 1;
            }
        }
    }

    fn next_layer(&self) -> Option<(u64, usize)> {
        let head = |class: &Class| Some(self.settled.get(class.cursor)?.distance + class.weight);
        let heads = self.classes.iter().enumerate();
        heads.filter_map(|(c, class)| Some((head(class)?, c))).min()
    }

    /// Settles the blocks at this distance to which flips of one weight lead.
    fn follow(&mut self, blocks: &Blocks, distance: u64, class: usize) {
        let Class { weight, mask, mut cursor } = self.classes[class];
        while let Some(&from) = self.settled.get(cursor).filter(|s| s.distance + weight == distance) {
            for bit in bits(from.flips & mask) {
                self.reach(blocks, from.block ^ bit, distance);
            }
            cursor += 1;
        }
        self.classes[class].cursor = cursor;
    }

    #[inline]
    fn reach(&mut self, blocks: &Blocks, block: u32, distance: u64) {
        if self.distance[block as usize] == UNKNOWN {
            self.distance[block as usize] = distance;
            let flips = blocks.all_flips(block);
            self.settled.push(SettledBlock { block, flips, distance });
        }
    }

    /// Distance to the origin; `None` if the block is not connected to it.
    #[inline]
    pub(super) fn of(&self, block: u32) -> Option<u64> {
        let distance = self.distance[block as usize];
        (distance != UNKNOWN).then_some(distance)
    }
}
