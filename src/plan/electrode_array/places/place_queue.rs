//! Operations that take turns at a number of equal places: lower bounds of the time until all that comes after them is done.
//!
//! Parallel machines with heads and tails (Carlier 1987): each place has a first operation and a last one. So the time of all places
//! together is at least that of the earliest heads, one for each place, all stays, and the shortest tails, and the longest is at least their
//! mean. Droplets that take turns at a place move out of each other's way in between; and those that come out of one reservoir come
//! one after the other, so that the heads of later ones are later.

use crate::plan::electrode_array::board::CellIndex;
use std::collections::{BTreeMap, BTreeSet};

/// Most operations of which each set that begins late has a bound of its own: the cost is the square of their number.
const MAX_SETS: usize = 1_000;

/// An operation that has one of the places to itself.
#[derive(Debug, Clone, Copy)]
pub(super) struct ServedOperation {
    /// The earliest instant at which it can begin,
    pub head: u64,
    /// steps for which it stays,
    pub stay: u64,
    /// and least steps from its end to the end of all that must come after it.
    pub tail: u64,
    /// The same number for droplets that may follow each other as one: that merge or come out of one another.
    pub family: usize,
    /// The same number for operations at one place, whichever that is.
    pub block: usize,
    pub source: Option<DropletSource>,
}

/// The reservoir from which a droplet comes.
#[derive(Debug, Clone, Copy)]
pub(super) struct DropletSource {
    pub outlet: CellIndex,
    pub droplet: usize,
    /// Least steps from the instant at which it comes to the one at which the operation begins.
    pub steps: u64,
}

/// Operations at the same places.
pub(super) struct PlaceQueue {
    places: u64,
    /// Steps between the stays of two droplets at a place.
    change: u64,
    /// By outlet: steps from the coming of one droplet to that of the next.
    turns: BTreeMap<CellIndex, u64>,
    pub served: Vec<ServedOperation>,
}

/// The operations of one block that count.
#[derive(Debug, Clone, Copy)]
struct ServedBlock {
    head: u64,
    tail: u64,
    source: Option<DropletSource>,
}

impl PlaceQueue {
    pub fn new(places: u64, change: u64, turns: BTreeMap<CellIndex, u64>) -> PlaceQueue {
        PlaceQueue { places, change, turns, served: Vec::new() }
    }

    /// The earliest end of all of them with all that comes after them.
    pub fn end(&self) -> u64 {
        let mut by_head: Vec<&ServedOperation> = self.served.iter().collect();
        by_head.sort_by_key(|one| one.head);
        let whole = self.end_of(&by_head);
        if by_head.len() > MAX_SETS {
            return whole;
        }
        let late = |first: usize| first > 0 && by_head[first - 1].head < by_head[first].head;
        let sets = (0..by_head.len()).filter(|first| late(*first)).map(|first| self.end_of(&by_head[first..]));
        sets.max().unwrap_or(0).max(whole)
    }

    /// As [`PlaceQueue::end`], if only these had to be done.
    fn end_of(&self, served: &[&ServedOperation]) -> u64 {
        let mut blocks: BTreeMap<usize, ServedBlock> = BTreeMap::new();
        for one in served {
            let own = ServedBlock { head: one.head, tail: one.tail, source: one.source };
            let all = blocks.entry(one.block).or_insert(own);
            *all = ServedBlock {
                head: all.head.min(one.head),
                tail: all.tail.min(one.tail),
                source: earliest(all.source, one.source),
            };
        }
        let blocks: Vec<ServedBlock> = blocks.into_values().collect();
        let used = self.places.min(blocks.len() as u64).max(1);
        let families = served.iter().map(|one| one.family).collect::<BTreeSet<usize>>().len() as u64;
        let work: u64 = served.iter().map(|one| one.stay).sum();
        let work = work + self.change * families.saturating_sub(used);
        let heads = least(blocks.iter().map(|block| block.head), used).max(self.heads_by_outlets(&blocks, used));
        (heads + work + least(blocks.iter().map(|block| block.tail), used)).div_ceil(used)
    }

    /// The sum of the earliest heads, since droplets come one after the other. How they do is open: those with most blocks first.
    fn heads_by_outlets(&self, blocks: &[ServedBlock], used: u64) -> u64 {
        let mut outlets: BTreeMap<CellIndex, CommonOutlet> = BTreeMap::new();
        for block in blocks {
            let Some(source) = block.source else { return 0 };
            let outlet = outlets.entry(source.outlet).or_insert(CommonOutlet {
                head: block.head,
                steps: source.steps,
                blocks: BTreeMap::new(),
            });
            (outlet.head, outlet.steps) = (outlet.head.min(block.head), outlet.steps.min(source.steps));
            *outlet.blocks.entry(source.droplet).or_default() += 1;
        }
        let mut heads: Vec<u64> = Vec::new();
        for (cell, outlet) in outlets {
            let turn = self.turns.get(&cell).copied().unwrap_or(0);
            let mut counts: Vec<usize> = outlet.blocks.into_values().collect();
            counts.sort_unstable_by_key(|count| std::cmp::Reverse(*count));
            for (nth, count) in (0..).zip(counts) {
                heads.extend(std::iter::repeat_n(outlet.head.max(turn * nth + outlet.steps), count));
            }
        }
        least(heads.into_iter(), used)
    }
}

/// What comes out of one reservoir.
struct CommonOutlet {
    head: u64,
    steps: u64,
    /// By droplet: its blocks.
    blocks: BTreeMap<usize, usize>,
}

/// How the droplet of a block came, with the fewer steps; none where that is not known, or several droplets are in question.
fn earliest(one: Option<DropletSource>, other: Option<DropletSource>) -> Option<DropletSource> {
    let (one, other) = (one?, other?);
    let is_same = (one.outlet, one.droplet) == (other.outlet, other.droplet);
    is_same.then_some(DropletSource { steps: one.steps.min(other.steps), ..one })
}

/// The sum of the least of some numbers.
fn least(numbers: impl Iterator<Item = u64>, count: u64) -> u64 {
    let mut numbers: Vec<u64> = numbers.collect();
    numbers.sort_unstable();
    numbers.iter().take(count as usize).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;

    /// When all is done: each order of the droplets of each outlet, each place of each block, each order of the operations.
    fn shortest(queue: &PlaceQueue) -> u64 {
        let droplets: BTreeSet<(CellIndex, usize)> =
            queue.served.iter().filter_map(|one| one.source).map(|source| (source.outlet, source.droplet)).collect();
        let droplets: Vec<(CellIndex, usize)> = droplets.into_iter().collect();
        let mut best = u64::MAX;
        for coming in orders(droplets.len()) {
            let comes = |source: DropletSource| {
                let nth = |nth: &usize| droplets[*nth].0 == source.outlet;
                let own = coming.iter().copied().filter(nth).position(|nth| droplets[nth].1 == source.droplet);
                own.unwrap_or(0) as u64 * queue.turns[&source.outlet] + source.steps
            };
            let heads: Vec<u64> = queue
                .served
                .iter()
                .map(|one| one.source.map_or(one.head, |source| comes(source).max(one.head)))
                .collect();
            for order in orders(queue.served.len()) {
                let blocks: BTreeSet<usize> = queue.served.iter().map(|one| one.block).collect();
                let blocks: Vec<usize> = blocks.into_iter().collect();
                for choice in 0..queue.places.pow(blocks.len() as u32) {
                    let place = |block: usize| {
                        let nth = blocks.iter().position(|own| *own == block).unwrap_or(0);
                        (choice / queue.places.pow(nth as u32) % queue.places) as usize
                    };
                    best = best.min(end(queue, &heads, &order, place));
                }
            }
        }
        best
    }

    fn end(queue: &PlaceQueue, heads: &[u64], order: &[usize], place: impl Fn(usize) -> usize) -> u64 {
        let mut free: Vec<Option<(u64, usize)>> = vec![None; queue.places as usize];
        let mut last = 0;
        for nth in order {
            let one = queue.served[*nth];
            let own = &mut free[place(one.block)];
            let since = own.map_or(0, |(since, family)| since + if family == one.family { 0 } else { queue.change });
            let end = since.max(heads[*nth]) + one.stay;
            *own = Some((end, one.family));
            last = last.max(end + one.tail);
        }
        last
    }

    fn orders(count: usize) -> Vec<Vec<usize>> {
        let mut all = vec![Vec::new()];
        for nth in 0..count {
            let longer = |order: Vec<usize>| {
                (0..=order.len()).map(move |at| {
                    let mut longer = order.clone();
                    longer.insert(at, nth);
                    longer
                })
            };
            all = all.into_iter().flat_map(longer).collect();
        }
        all
    }

    #[test]
    fn no_schedule_ends_before_the_bound() {
        let mut random = SplitMix64::new(5);
        let (mut cases, mut met) = (0, 0);
        for _ in 0..400 {
            let turns = BTreeMap::from([(0, 1 + random.below(5) as u64), (1, 1 + random.below(5) as u64)]);
            let mut queue = PlaceQueue::new(1 + random.below(3) as u64, random.below(4) as u64, turns);
            let comes = random.below(2) == 0;
            for nth in 0..1 + random.below(4) {
                let mut number = |count: usize| random.below(count);
                let source =
                    DropletSource { outlet: number(2) as CellIndex, droplet: number(3), steps: number(4) as u64 };
                queue.served.push(ServedOperation {
                    head: number(8) as u64,
                    stay: 1 + number(6) as u64,
                    tail: number(8) as u64,
                    family: number(3),
                    block: if number(3) == 0 { number(nth + 1) } else { nth },
                    source: comes.then_some(source),
                });
            }
            let shortest = shortest(&queue);
            assert!(queue.end() <= shortest, "{} of {shortest}: {:?}", queue.end(), queue.served);
            cases += 1;
            met += usize::from(queue.end() == shortest);
        }
        assert!(met * 2 > cases, "{met} of {cases} bounds are met");
    }
}
