//! Whether two agents can each take one of their ways of a given cost together.

use super::field::Field;
use super::layers::Layers;
use crate::plan::search::Meter;

/// Pairs of nodes beyond which a test is not made.
const MOST_PAIRS: u64 = 1 << 22;

/// How many of such pairs are one step of the budget.
const PAIRS_A_STEP: u64 = 16;

/// One of the two agents.
#[derive(Clone, Copy)]
pub struct Side<'a> {
    pub agent: usize,
    pub layers: &'a Layers,
}

/// False if the two have no ways in these layers that go together; true if they have, or if the test would be too large or the
/// budget is used up. The pairs of nodes that both can have reached go from instant to instant as bit sets.
pub fn may_go_together(field: &Field, one: Side, other: Side, meter: &mut Meter) -> bool {
    let end = one.layers.cost().max(other.layers.cost());
    let is_near: Vec<bool> = (0..end).map(|instant| !is_apart(field, one, other, instant)).collect();
    let pairs = |instant: &u32| one.layers.at(*instant).len() as u64 * other.layers.at(*instant).len() as u64;
    let work: u64 = (0..end).filter(|instant| is_near[*instant as usize]).map(|instant| pairs(&instant)).sum();
    if work > MOST_PAIRS || meter.left().steps == 0 {
        return true;
    }
    meter.charge(work / PAIRS_A_STEP + u64::from(end));
    let Some(last_near) = is_near.iter().rposition(|near| *near) else { return true };
    let mut reached: Option<Vec<Bits>> = None;
    for instant in 0..=last_near as u32 {
        if !is_near[instant as usize] && reached.is_none() {
            continue;
        }
        let rows =
            reached.unwrap_or_else(|| vec![Bits::full(other.layers.at(instant).len()); one.layers.at(instant).len()]);
        let next = step(field, one, other, instant, &rows);
        if next.iter().all(Bits::is_empty) {
            return false;
        }
        let is_full = next.iter().all(Bits::is_full);
        reached = (!is_full).then_some(next);
    }
    true
}

/// Whether nothing in the layers of an instant and of the next comes too near.
fn is_apart(field: &Field, one: Side, other: Side, instant: u32) -> bool {
    let extent = |side: Side| side.layers.extent(instant).join(side.layers.extent(instant + 1));
    extent(one).is_apart(&extent(other), field.instance.separation as i32)
}

/// The pairs that can be reached one instant later.
fn step(field: &Field, one: Side, other: Side, instant: u32, rows: &[Bits]) -> Vec<Bits> {
    let clear = |at: u32, other_at: u32| -> Vec<Bits> { clear_rows(field, one, at, other, other_at) };
    let (later_now, now_later, later_later) =
        (clear(instant + 1, instant), clear(instant, instant + 1), clear(instant + 1, instant + 1));
    let width = other.layers.at(instant + 1).len();
    let mut next = vec![Bits::empty(width); one.layers.at(instant + 1).len()];
    for (place, row) in rows.iter().enumerate().filter(|(_, row)| !row.is_empty()) {
        for to in one.layers.edges(instant, place).iter().map(|to| *to as usize) {
            let mut found = Bits::empty(width);
            for other_place in row.common(&later_now[to]) {
                other.layers.edges(instant, other_place).iter().for_each(|other_to| found.set(*other_to as usize));
            }
            next[to].add(&found, &now_later[place], &later_later[to]);
        }
    }
    next
}

/// For each node of `one` at an instant, the nodes of `other` at an instant that are not too near.
fn clear_rows(field: &Field, one: Side, at: u32, other: Side, other_at: u32) -> Vec<Bits> {
    let others = other.layers.at(other_at);
    let row = |cell: u32| {
        let mut bits = Bits::empty(others.len());
        for (place, node) in others.iter().enumerate() {
            if !field.too_near(one.agent, cell, other.agent, field.cell(*node)) {
                bits.set(place);
            }
        }
        bits
    };
    one.layers.at(at).iter().map(|node| row(field.cell(*node))).collect()
}

/// A set of places of a layer.
#[derive(Clone)]
struct Bits {
    words: Vec<u64>,
    width: usize,
}

impl Bits {
    fn empty(width: usize) -> Bits {
        Bits { words: vec![0; width.div_ceil(64)], width }
    }

    fn full(width: usize) -> Bits {
        let mut bits = Bits { words: vec![u64::MAX; width.div_ceil(64)], width };
        if let (Some(last), rest @ 1..) = (bits.words.last_mut(), width % 64) {
            *last = (1 << rest) - 1;
        }
        bits
    }

    fn set(&mut self, place: usize) {
        self.words[place / 64] |= 1 << (place % 64);
    }

    fn is_empty(&self) -> bool {
        self.words.iter().all(|word| *word == 0)
    }

    fn is_full(&self) -> bool {
        self.words.iter().map(|word| word.count_ones() as usize).sum::<usize>() == self.width
    }

    /// The places in both.
    fn common<'a>(&'a self, other: &'a Bits) -> impl Iterator<Item = usize> + 'a {
        self.words.iter().zip(&other.words).enumerate().flat_map(|(index, (one, other))| {
            let mut word = one & other;
            std::iter::from_fn(move || {
                (word != 0).then(|| {
                    let bit = word.trailing_zeros() as usize;
                    word &= word - 1;
                    index * 64 + bit
                })
            })
        })
    }

    /// Adds what is in all three.
    fn add(&mut self, found: &Bits, one: &Bits, other: &Bits) {
        for (word, ((a, b), c)) in self.words.iter_mut().zip(found.words.iter().zip(&one.words).zip(&other.words)) {
            *word |= a & b & c;
        }
    }
}
