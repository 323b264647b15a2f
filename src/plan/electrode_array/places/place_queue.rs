//! Lower bound for operations that take turns at a number of equivalent places: the time until everything after them is
//! done.
//!
//! Parallel machines with heads and tails (Carlier 1987): each place has a first and a last operation. So the total
//! time of all places is at least the sum of the earliest heads, one for each place, all stays, and the shortest tails;
//! the longest time of a place is at least the mean. In addition, droplets that take turns at a place must make room in
//! between, and droplets from one reservoir are dispensed one after the other, so that later ones have later heads.
//!
//! In addition, a place takes whole operations: until the end, the loads of all places are sums of stays (as in bin
//! packing), and all of them together take all operations.

use crate::plan::electrode_array::board::CellIndex;
use std::collections::{BTreeMap, BTreeSet};

/// Most operations for which each subset with late heads gets a bound of its own; the cost is quadratic in their
/// number.
const MAX_SETS: usize = 1_000;

/// Most families, and most steps of work, for which the loads of places are computed.
const MAX_LOAD_FAMILIES: u64 = 64;
const MAX_LOAD_STEPS: u64 = 1 << 16;

/// An operation that needs one of the places alone.
#[derive(Debug, Clone, Copy)]
pub(super) struct ServedOperation {
    /// The earliest instant at which it can begin.
    pub head: u64,
    /// Steps for which it stays.
    pub stay: u64,
    /// Least steps from its end to the end of everything that must follow.
    pub tail: u64,
    /// Equal for droplets that may follow each other without a changeover: those that merge or split.
    pub family: usize,
    /// Equal for operations at the same place, whichever that is.
    pub block: usize,
    pub source: Option<DropletSource>,
}

/// The dispensing of a droplet.
#[derive(Debug, Clone, Copy)]
pub(super) struct DropletSource {
    pub outlet: CellIndex,
    pub droplet: usize,
    /// Least steps from the instant at which it is on the board to the beginning of the operation.
    pub steps: u64,
}

/// Operations that share the same places.
pub(super) struct PlaceQueue {
    places: u64,
    /// Changeover: steps between the stays of two droplets at a place.
    change: u64,
    /// By outlet: least steps between the appearance of one droplet and that of the next.
    turns: BTreeMap<CellIndex, u64>,
    pub served: Vec<ServedOperation>,
}

/// A block of operations at one place: their least head and tail.
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

    /// Lower bound on the end of all operations and everything that follows them.
    pub fn end(&self) -> u64 {
        let all: Vec<&ServedOperation> = self.served.iter().collect();
        self.end_by_means().max(self.end_by_loads(&all))
    }

    /// As [`PlaceQueue::end`], from the mean times of places, for all operations and for those with late heads.
    fn end_by_means(&self) -> u64 {
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

    /// As [`PlaceQueue::end_by_means`], for a subset of the operations.
    fn end_of(&self, served: &[&ServedOperation]) -> u64 {
        let blocks = blocks(served);
        let used = self.places.min(blocks.len() as u64).max(1);
        let work: u64 = served.iter().map(|one| one.stay).sum();
        let work = work + self.change * families(served).saturating_sub(used);
        let heads: u64 = self.first_heads(&blocks, used).iter().sum();
        let tails: u64 = least(blocks.iter().map(|block| block.tail), used).iter().sum();
        (heads + work + tails).div_ceil(used)
    }

    /// As [`PlaceQueue::end`], from what each place can take until the end: it does not take parts of a block. 0 where
    /// that says no more than the mean, or is too much to compute.
    fn end_by_loads(&self, served: &[&ServedOperation]) -> u64 {
        let blocks = blocks(served);
        let used = self.places.min(blocks.len() as u64);
        let families = families(served);
        // With a changeover for each family. A family split among places needs more of them.
        let work = served.iter().map(|one| one.stay).sum::<u64>() + self.change * families;
        if used < 2 || families > MAX_LOAD_FAMILIES || work > MAX_LOAD_STEPS {
            return 0;
        }
        let (heads, loads) = (self.first_heads(&blocks, used), self.loads(served, work));
        let tail = blocks.iter().map(|block| block.tail).min().unwrap_or(0);
        let load = |head: &u64, end: u64| match end.saturating_sub(head + tail) {
            0 => 0,
            window => loads[(window + self.change).min(work) as usize],
        };
        let takes_all = |end: u64| heads.iter().map(|head| load(head, end)).sum::<u64>() >= work;
        let (mut short, mut enough) = (0, heads[0] + tail + work);
        while short + 1 < enough {
            let end = u64::midpoint(short, enough);
            if takes_all(end) {
                enough = end;
            } else {
                short = end;
            }
        }
        enough
    }

    /// By number of steps up to `work`: most steps, no more than these, that some blocks take with a changeover for each
    /// of their families.
    fn loads(&self, served: &[&ServedOperation], work: u64) -> Vec<u64> {
        let mut stays: BTreeMap<(usize, usize), u64> = BTreeMap::new();
        for one in served {
            *stays.entry((one.family, one.block)).or_default() += one.stay;
        }
        let mut families: BTreeMap<usize, Vec<u64>> = BTreeMap::new();
        stays.into_iter().for_each(|((family, _), stay)| families.entry(family).or_default().push(stay));
        let mut taken = vec![false; work as usize + 1];
        taken[0] = true;
        for own in families.values() {
            // With no operation of this family yet, and with at least one.
            let without = taken.clone();
            let mut with = vec![false; taken.len()];
            for stay in own {
                for steps in (0..taken.len()).rev() {
                    let joined = steps.checked_sub(*stay as usize).is_some_and(|before| with[before]);
                    let first = steps.checked_sub((*stay + self.change) as usize).is_some_and(|before| without[before]);
                    with[steps] |= joined || first;
                }
            }
            taken.iter_mut().zip(with).for_each(|(taken, with)| *taken |= with);
        }
        let mut most = 0;
        let most_up_to = |(steps, is_taken)| {
            most = if is_taken { steps } else { most };
            most
        };
        (0..).zip(taken).map(most_up_to).collect()
    }

    /// Lower bounds on the heads of the first blocks of the places, in order.
    fn first_heads(&self, blocks: &[ServedBlock], used: u64) -> Vec<u64> {
        let heads = least(blocks.iter().map(|block| block.head), used);
        match self.heads_by_outlets(blocks, used) {
            Some(dispensed) => heads.into_iter().zip(dispensed).map(|(head, dispensed)| head.max(dispensed)).collect(),
            None => heads,
        }
    }

    /// As [`PlaceQueue::first_heads`], given that droplets are dispensed one after the other; `None` if not all come
    /// from outlets. Their order is open: assuming that droplets with most blocks come first is a relaxation.
    fn heads_by_outlets(&self, blocks: &[ServedBlock], used: u64) -> Option<Vec<u64>> {
        let mut outlets: BTreeMap<CellIndex, CommonOutlet> = BTreeMap::new();
        for block in blocks {
            let source = block.source?;
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
        Some(least(heads.into_iter(), used))
    }
}

/// The blocks of some operations.
fn blocks(served: &[&ServedOperation]) -> Vec<ServedBlock> {
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
    blocks.into_values().collect()
}

/// Number of families of some operations.
fn families(served: &[&ServedOperation]) -> u64 {
    served.iter().map(|one| one.family).collect::<BTreeSet<usize>>().len() as u64
}

/// Droplets from one reservoir.
struct CommonOutlet {
    head: u64,
    steps: u64,
    /// By droplet: number of its blocks.
    blocks: BTreeMap<usize, usize>,
}

/// The common source of two operations, with the fewer steps; `None` if one is unknown or they come from different
/// droplets.
fn earliest(one: Option<DropletSource>, other: Option<DropletSource>) -> Option<DropletSource> {
    let (one, other) = (one?, other?);
    let is_same = (one.outlet, one.droplet) == (other.outlet, other.droplet);
    is_same.then_some(DropletSource { steps: one.steps.min(other.steps), ..one })
}

/// The `count` least numbers, in order.
fn least(numbers: impl Iterator<Item = u64>, count: u64) -> Vec<u64> {
    let mut numbers: Vec<u64> = numbers.collect();
    numbers.sort_unstable();
    numbers.truncate(count as usize);
    numbers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::SplitMix64;

    /// The least end by exhaustive search: each dispensing order, each place of each block, each order of the
    /// operations.
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

    /// Checks the bounds of random queues; returns how many there are, how many are met, and how many follow from the
    /// loads of places.
    fn checked(queues: impl Iterator<Item = PlaceQueue>) -> [usize; 3] {
        let (mut cases, mut met, mut raised) = (0, 0, 0);
        for queue in queues {
            let (bound, shortest) = (queue.end(), shortest(&queue));
            assert!(bound <= shortest, "{bound} of {shortest}: {:?}", queue.served);
            cases += 1;
            met += usize::from(bound == shortest);
            raised += usize::from(bound > queue.end_by_means());
        }
        [cases, met, raised]
    }

    #[test]
    fn no_schedule_ends_before_the_bound() {
        let mut random = SplitMix64::new(5);
        let [cases, met, _] = checked((0..400).map(|_| {
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
            queue
        }));
        assert!(met * 2 > cases, "{met} of {cases} bounds are met");
    }

    /// More and longer operations, of which each place can take only some.
    #[test]
    fn no_schedule_ends_before_the_bound_of_loads() {
        let mut random = SplitMix64::new(6);
        let [cases, met, raised] = checked((0..400).map(|_| {
            let mut number = |count: usize| random.below(count);
            let (places, change, families) = (2 + number(2), number(3), 2 + number(5));
            let mut queue = PlaceQueue::new(places as u64, change as u64, BTreeMap::new());
            for nth in 0..7 - places {
                queue.served.push(ServedOperation {
                    head: number(3) as u64,
                    stay: 4 + number(9) as u64,
                    tail: number(3) as u64,
                    family: number(families),
                    block: if number(6) == 0 { number(nth + 1) } else { nth },
                    source: None,
                });
            }
            queue
        }));
        assert!(met * 4 > cases, "{met} of {cases} bounds are met");
        assert!(raised * 4 > cases, "{raised} of {cases} bounds are those of loads");
    }
}
