//! The bits of [`Tables`] rearranged along chains: one window of bits describes a chain at all its angles.
//!
//! If all angles share one layer, the grasps with the same distances between contacts form one cyclic strand, and a
//! chain is a window of it; if each angle has its own layer, each chain is a strand.

use super::layout::{ahead, wrapped};
use super::weave::columns;
use crate::plan::fingers::tables::{AngleLayer, Tables};

/// One bit per angle.
pub type AngleMask<const N: usize> = [u64; N];

/// Bits of many strands, with the same number of words each.
#[derive(Debug)]
pub struct Strand {
    words: Vec<u64>,
    stride: usize,
}

impl Strand {
    fn new(count: usize, bits: usize) -> Self {
        let stride = bits.div_ceil(64);
        Strand { words: vec![0; count * stride], stride }
    }

    fn put(&mut self, strand: usize, bit: usize) {
        self.words[strand * self.stride + bit / 64] |= 1 << (bit % 64);
    }

    /// Sets the first words of a strand.
    fn set(&mut self, strand: usize, words: impl Iterator<Item = u64>) {
        let from = strand * self.stride;
        self.words[from..from + self.stride].iter_mut().zip(words).for_each(|(word, bits)| *word = bits);
    }

    /// Repeats the first `period` bits up to at least `bits`; the bits after them must be 0. The repeated part doubles
    /// each time.
    fn repeat(&mut self, period: usize, bits: usize) {
        for strand in self.words.chunks_exact_mut(self.stride) {
            let mut filled = period;
            while filled < bits {
                let (words, shift) = (filled / 64, filled % 64);
                // From the last word, so that each is read before it is written.
                for at in (words..strand.len()).rev() {
                    let low = |back: usize| at.checked_sub(words + back).map_or(0, |from| strand[from]);
                    let moved = low(0) << shift | low(1) >> 1 >> (63 - shift);
                    strand[at] |= moved;
                }
                filled *= 2;
            }
        }
    }

    /// A bit of a strand.
    #[inline]
    pub fn has(&self, strand: usize, bit: usize) -> bool {
        self.words[strand * self.stride + bit / 64] >> (bit % 64) & 1 == 1
    }

    /// The bits of a strand from `bit` on; those beyond the leg's angles are meaningless.
    #[inline]
    pub fn window<const N: usize>(&self, strand: usize, bit: usize) -> AngleMask<N> {
        let from = strand * self.stride + bit / 64;
        let shift = bit % 64;
        let mut mask = [0; N];
        for (at, word) in mask.iter_mut().enumerate() {
            let low = self.words.get(from + at).copied().unwrap_or(0);
            let high = self.words.get(from + at + 1).copied().unwrap_or(0);
            *word = low >> shift | high << 1 << (63 - shift);
        }
        mask
    }
}

/// The bits of all chains of one section.
#[derive(Debug)]
pub struct Strands {
    contacts: usize,
    /// Whether all angles share one layer.
    turning: StrandTurning,
    /// Pairs that are nodes.
    pub hold_pair: Strand,
    /// Rolling from an angle to the next, with a node at both ends.
    pub roll_pair: Strand,
    pub roll_triple: Strand,
    /// Placement: from a pair to a triple, both of them nodes.
    pub place: Strand,
    /// Removal: from a triple to a pair, both of them nodes.
    pub leave: Strand,
}

/// Dependence of strands on angles.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum StrandTurning {
    /// One cyclic strand for each distance between contacts.
    Alike,
    /// One strand for each chain.
    Apart,
}

/// Start of the strands of chains with the same first phase.
#[derive(Debug, Clone, Copy)]
pub struct StrandHead {
    /// Row of strands: one for each first phase, or a single one.
    row: usize,
    /// The bit of the lowest angle.
    pub bit: usize,
}

impl Strands {
    /// Looks charged for [`Strands::of`]: if all angles share one layer, words of three tables are woven; otherwise
    /// each triple is set alone.
    pub fn looks(tables: &Tables) -> u64 {
        let contacts = tables.contacts as u64;
        match tables.layers.len() as u64 {
            1 => 8 * contacts * contacts * contacts.div_ceil(64),
            layers => contacts * contacts * contacts * layers / 4,
        }
    }

    /// The strands of tables, for legs of at most `angles` angles.
    pub fn of(tables: &Tables, angles: usize) -> Self {
        let contacts = tables.contacts;
        let turning = if tables.layers.len() == 1 { StrandTurning::Alike } else { StrandTurning::Apart };
        let (rows, bits) = match turning {
            StrandTurning::Alike => (1, contacts + angles),
            StrandTurning::Apart => (contacts, angles),
        };
        let [hold_pair, roll_pair] = std::array::from_fn(|_| Strand::new(rows * contacts, bits));
        let [roll_triple, place, leave] = std::array::from_fn(|_| Strand::new(rows * contacts * contacts, bits));
        let mut strands = Strands { contacts, turning, hold_pair, roll_pair, roll_triple, place, leave };
        match turning {
            StrandTurning::Alike => {
                let here = &tables.layers[0];
                for first in 0..contacts {
                    strands.lay_pairs(tables, [here, here], first, 0, wrapped(contacts - first, contacts));
                }
                (0..contacts).for_each(|one| strands.weave(tables, one));
                strands.repeat(contacts, bits);
            }
            StrandTurning::Apart => {
                for angle in 0..angles {
                    let above = tables.layer((angle + 1).min(tables.layers.len() - 1));
                    for first in 0..contacts {
                        let row = wrapped(first + angle % contacts, contacts);
                        strands.lay_pairs(tables, [tables.layer(angle), above], first, row, angle);
                        strands.lay_triples(tables, [tables.layer(angle), above], first, row, angle);
                    }
                }
            }
        }
        strands
    }

    fn repeat(&mut self, period: usize, bits: usize) {
        for strand in
            [&mut self.hold_pair, &mut self.roll_pair, &mut self.roll_triple, &mut self.place, &mut self.leave]
        {
            strand.repeat(period, bits);
        }
    }

    /// Fills the strands of the triples whose second contact is `one` after the first, from the only layer.
    fn weave(&mut self, tables: &Tables, one: usize) {
        let contacts = self.contacts;
        let width = contacts.div_ceil(64);
        let layer = &tables.layers[0];
        let [mut nodes, mut rolls, mut comes, mut leaves] = std::array::from_fn(|_| vec![0; contacts * width]);
        let holds = |first: usize, second: usize| layer.pair.has(tables.two(first, second));
        columns(&layer.triple, contacts, one, |_, _| true, &mut nodes);
        columns(&layer.roll_triple, contacts, one, |_, _| true, &mut rolls);
        columns(&layer.place, contacts, one, holds, &mut comes);
        columns(&layer.leave, contacts, one, holds, &mut leaves);
        for two in 0..contacts {
            let range = two * width..(two + 1) * width;
            let here = &nodes[range.clone()];
            // The bits of the next angle: all shifted down by one, the first wrapped to the end.
            let last =
                |at: usize| if at + 1 == width { (here[0] & 1) << ((contacts - 1) % 64) } else { here[at + 1] << 63 };
            let next = |at: usize| here[at] >> 1 | last(at);
            let strand = one * contacts + two;
            let of = |bits: &[u64], at: usize| bits[range.start + at] & here[at];
            self.roll_triple.set(strand, (0..width).map(|at| of(&rolls, at) & next(at)));
            self.place.set(strand, (0..width).map(|at| of(&comes, at)));
            self.leave.set(strand, (0..width).map(|at| of(&leaves, at)));
        }
    }

    /// Sets the bits of all pairs with a first contact, whose strands form a row, at one bit position.
    fn lay_pairs(&mut self, tables: &Tables, [here, above]: [&AngleLayer; 2], first: usize, row: usize, bit: usize) {
        let contacts = self.contacts;
        for one in 0..contacts {
            let second = wrapped(first + one, contacts);
            let pair = tables.two(first, second);
            if !here.pair.has(pair) {
                continue;
            }
            self.hold_pair.put(row * contacts + one, bit);
            let next = tables.two(before(first, contacts), before(second, contacts));
            if here.roll_pair.has(pair) && above.pair.has(next) {
                self.roll_pair.put(row * contacts + one, bit);
            }
        }
    }

    /// Sets the bits of all triples with a first contact.
    fn lay_triples(&mut self, tables: &Tables, [here, above]: [&AngleLayer; 2], first: usize, row: usize, bit: usize) {
        let contacts = self.contacts;
        for (one, two) in (0..contacts).flat_map(|one| (0..contacts).map(move |two| (one, two))) {
            let [second, third] = [one, two].map(|apart| wrapped(first + apart, contacts));
            let triple = tables.three(first, second, third);
            if !here.triple.has(triple) {
                continue;
            }
            let strand = (row * contacts + one) * contacts + two;
            let [i, j, k] = [first, second, third].map(|contact| before(contact, contacts));
            if here.roll_triple.has(triple) && above.triple.has(tables.three(i, j, k)) {
                self.roll_triple.put(strand, bit);
            }
            let holds = here.pair.has(tables.two(first, second));
            if holds && here.place.has(triple) {
                self.place.put(strand, bit);
            }
            if holds && here.leave.has(triple) {
                self.leave.put(strand, bit);
            }
        }
    }

    /// Start of the strands of chains with a first phase.
    #[inline]
    pub fn head(&self, phase: u16) -> StrandHead {
        match self.turning {
            StrandTurning::Alike => {
                StrandHead { row: 0, bit: wrapped(self.contacts - usize::from(phase), self.contacts) }
            }
            StrandTurning::Apart => StrandHead { row: usize::from(phase), bit: 0 },
        }
    }

    /// The strand of a pair.
    #[inline]
    pub fn pair(&self, head: StrandHead, phases: [u16; 2]) -> usize {
        head.row * self.contacts + ahead(phases[0], phases[1], self.contacts)
    }

    /// The strand of a triple; the third phase is the finger that is placed or removed.
    #[inline]
    pub fn triple(&self, head: StrandHead, phases: [u16; 3]) -> usize {
        self.pair(head, [phases[0], phases[1]]) * self.contacts + ahead(phases[0], phases[2], self.contacts)
    }
}

/// The contact that a contact becomes after one step.
fn before(contact: usize, contacts: usize) -> usize {
    if contact == 0 { contacts - 1 } else { contact - 1 }
}

/// Keeps the bits below `end`.
#[inline]
pub fn below<const N: usize>(mut mask: AngleMask<N>, end: usize) -> AngleMask<N> {
    for (at, word) in mask.iter_mut().enumerate() {
        let kept = end.saturating_sub(at * 64);
        if kept < 64 {
            *word &= (1 << kept) - 1;
        }
    }
    mask
}

/// Intersection of two masks.
#[inline]
pub fn both<const N: usize>(a: AngleMask<N>, b: AngleMask<N>) -> AngleMask<N> {
    std::array::from_fn(|at| a[at] & b[at])
}

/// Difference of two masks.
#[inline]
pub fn except<const N: usize>(a: AngleMask<N>, b: AngleMask<N>) -> AngleMask<N> {
    std::array::from_fn(|at| a[at] & !b[at])
}

/// Whether a mask has a bit.
#[inline]
pub fn has<const N: usize>(mask: &AngleMask<N>, bit: usize) -> bool {
    mask[bit / 64] >> (bit % 64) & 1 == 1
}

/// The mask of one bit.
#[inline]
pub fn single<const N: usize>(bit: usize) -> AngleMask<N> {
    let mut mask = [0; N];
    mask[bit / 64] = 1 << (bit % 64);
    mask
}

/// All angles to which seeds roll, including the seeds.
///
/// For masks of one word, upward: the addition carries from a seed through the steps above it and stops one past their end.
/// Otherwise the covered distance doubles with each shift.
#[inline]
pub fn spread<const N: usize>(seeds: AngleMask<N>, rolls: AngleMask<N>) -> AngleMask<N> {
    let mut filled = seeds;
    if N == 1 {
        filled[0] |= rolls[0] ^ rolls[0].wrapping_add(seeds[0] & rolls[0]);
    } else {
        let mut open = shifted_up(rolls, 1);
        for power in 0.. {
            let more = both(shifted_up(filled, 1 << power), open);
            (0..N).for_each(|at| filled[at] |= more[at]);
            open = both(open, shifted_up(open, 1 << power));
            if open == [0; N] {
                break;
            }
        }
    }
    let mut open = rolls;
    for power in 0.. {
        let more = both(shifted_down(filled, 1 << power), open);
        (0..N).for_each(|at| filled[at] |= more[at]);
        open = both(open, shifted_down(open, 1 << power));
        if open == [0; N] {
            break;
        }
    }
    filled
}

#[inline]
fn shifted_up<const N: usize>(mask: AngleMask<N>, by: usize) -> AngleMask<N> {
    let (words, bits) = (by / 64, by % 64);
    std::array::from_fn(|at| {
        let low = |back: usize| at.checked_sub(words + back).map_or(0, |from| mask[from]);
        low(0) << bits | low(1) >> 1 >> (63 - bits)
    })
}

#[inline]
fn shifted_down<const N: usize>(mask: AngleMask<N>, by: usize) -> AngleMask<N> {
    let (words, bits) = (by / 64, by % 64);
    std::array::from_fn(|at| {
        let high = |on: usize| mask.get(at + words + on).copied().unwrap_or(0);
        high(0) >> bits | high(1) << 1 << (63 - bits)
    })
}
