//! Compatibility of two agents with paths of given costs: the pairs of places from which both can still arrive.

use super::mdd::MultiValueDecisionDiagram;
use super::tables::{CellPlace, ExactTables};
use crate::plan::search::Meter;
use fixedbitset::FixedBitSet;

/// Tables with more pairs of nodes than this are not built.
const MOST_PAIRS: u64 = 1 << 22;

/// Pairs of nodes per step of the budget.
const PAIRS_A_STEP: u64 = 4;

/// One of the two agents.
#[derive(Clone, Copy)]
pub struct PairSide<'a> {
    pub agent: usize,
    pub mdd: &'a MultiValueDecisionDiagram,
}

/// For each instant, the pairs of nodes of two layers that keep the rule and from which both can still reach the end together.
pub struct CompatiblePairs {
    /// By instant, then by the place of the first agent; `None` where nothing is forbidden, and past the end.
    alive: Vec<Option<Vec<FixedBitSet>>>,
    /// Words of all bit sets in total.
    words: usize,
}

impl CompatiblePairs {
    /// The table of two agents; one that forbids nothing if it would be too large or the budget is spent.
    pub fn new(tables: &ExactTables, one: PairSide, other: PairSide, meter: &mut Meter) -> CompatiblePairs {
        let gaps = PairGaps::new(tables, one, other, meter);
        gaps.alive(one, other)
    }

    /// The same, restricted to pairs that are reachable from the start.
    pub fn swept(tables: &ExactTables, one: PairSide, other: PairSide, meter: &mut Meter) -> CompatiblePairs {
        let gaps = PairGaps::new(tables, one, other, meter);
        let mut table = gaps.alive(one, other);
        for instant in 1..table.alive.len() {
            let (earlier, now) = table.alive.split_at_mut(instant);
            if let (Some(Some(reached)), Some(Some(alive))) = (earlier.last(), now.first_mut()) {
                *alive = gaps.reached(one, other, instant as u32 - 1, reached, alive);
            }
        }
        table
    }

    /// The table that forbids nothing.
    pub fn open() -> CompatiblePairs {
        CompatiblePairs { alive: vec![], words: 0 }
    }

    /// Whether the two have compatible paths from the start.
    pub fn allows_start(&self) -> bool {
        self.allows(0, 0, 0)
    }

    /// Whether they have compatible paths from two places of an instant on.
    #[inline]
    pub fn allows(&self, instant: u32, place: usize, other_place: usize) -> bool {
        match self.alive.get(instant as usize) {
            Some(Some(rows)) => rows[place].contains(other_place),
            Some(None) | None => true,
        }
    }

    /// Whether the first agent may be at a place of an instant, for some place of the second.
    pub fn allows_first(&self, instant: u32, place: usize) -> bool {
        match self.alive.get(instant as usize) {
            Some(Some(rows)) => !rows[place].is_clear(),
            Some(None) | None => true,
        }
    }

    /// Whether the second agent may be at a place of an instant, for some place of the first.
    pub fn allows_second(&self, instant: u32, place: usize) -> bool {
        match self.alive.get(instant as usize) {
            Some(Some(rows)) => rows.iter().any(|row| row.contains(place)),
            Some(None) | None => true,
        }
    }

    /// Its size in words of 8 bytes.
    pub fn words(&self) -> usize {
        self.words
    }
}

/// Compatible nodes of two agents between an instant and the next.
struct PairGap {
    /// Rows by node of the first agent; set bits are the nodes of the second agent that are not too near. Both nodes
    /// are at the instant (`now`); the second is at the next (`now_later`); the first is at the next (`later_now`);
    /// both are at the next (`later`).
    now: Vec<FixedBitSet>,
    now_later: Vec<FixedBitSet>,
    later_now: Vec<FixedBitSet>,
    later: Vec<FixedBitSet>,
}

/// The gaps up to the last instant at which the two can be near; `None` for a gap in which they cannot.
struct PairGaps {
    gaps: Vec<Option<PairGap>>,
}

impl PairGaps {
    fn new(tables: &ExactTables, one: PairSide, other: PairSide, meter: &mut Meter) -> PairGaps {
        let end = one.mdd.cost().max(other.mdd.cost());
        let is_near: Vec<bool> = (0..end).map(|instant| !is_apart(tables, one, other, instant)).collect();
        let Some(last_near) = is_near.iter().rposition(|near| *near) else { return PairGaps { gaps: vec![] } };
        let pairs = |instant: u32| one.mdd.at(instant).len() as u64 * other.mdd.at(instant).len() as u64;
        let work: u64 = (0..=last_near as u32).map(pairs).sum();
        if work > MOST_PAIRS || meter.left().steps == 0 {
            return PairGaps { gaps: vec![] };
        }
        meter.charge(work / PAIRS_A_STEP + u64::from(end));
        let gap = |instant: u32| {
            let clear = |at: u32, other_at: u32| clear_rows(tables, one, at, other, other_at);
            let next = instant + 1;
            PairGap {
                now: clear(instant, instant),
                now_later: clear(instant, next),
                later_now: clear(next, instant),
                later: clear(next, next),
            }
        };
        let near_ones = is_near[..=last_near].iter().zip(0..);
        PairGaps { gaps: near_ones.map(|(near, instant)| near.then(|| gap(instant))).collect() }
    }

    /// The pairs from which the end is reachable.
    fn alive(&self, one: PairSide, other: PairSide) -> CompatiblePairs {
        let mut table = CompatiblePairs { alive: vec![None; self.gaps.len()], words: 0 };
        for instant in (0..self.gaps.len()).rev() {
            let later = table.alive.get(instant + 1).and_then(Option::as_deref);
            let now = match (&self.gaps[instant], later) {
                (None, None) => continue,
                (Some(gap), None) => before_near(one, other, instant as u32, gap, &gap.later),
                (Some(gap), Some(later)) => before_near(one, other, instant as u32, gap, later),
                (None, Some(later)) => before_apart(one, other, instant as u32, later),
            };
            if !now.iter().all(FixedBitSet::is_full) {
                table.words += now.iter().map(|bits| bits.len().div_ceil(64)).sum::<usize>();
                table.alive[instant] = Some(now);
            }
        }
        table
    }

    /// The live pairs after an instant that are reachable from pairs at the instant.
    fn reached(
        &self,
        one: PairSide,
        other: PairSide,
        instant: u32,
        from: &[FixedBitSet],
        alive: &[FixedBitSet],
    ) -> Vec<FixedBitSet> {
        let gap = self.gaps[instant as usize].as_ref();
        let mut reached: Vec<FixedBitSet> = alive.iter().map(|bits| FixedBitSet::with_capacity(bits.len())).collect();
        for (place, row) in from.iter().enumerate().filter(|(_, row)| !row.is_clear()) {
            for to in one.mdd.edges(instant, place).iter().map(|to| *to as usize) {
                let mut found = FixedBitSet::with_capacity(alive[to].len());
                let starts = gap.map_or_else(|| row.clone(), |gap| row & &gap.later_now[to]);
                for other_place in starts.ones() {
                    other.mdd.edges(instant, other_place).iter().for_each(|other_to| found.insert(*other_to as usize));
                }
                found.intersect_with(&alive[to]);
                if let Some(gap) = gap {
                    found.intersect_with(&gap.now_later[place]);
                }
                reached[to].union_with(&found);
            }
        }
        reached
    }
}

/// The pairs of an instant from which one of `later` is reachable.
fn before_near(one: PairSide, other: PairSide, instant: u32, gap: &PairGap, later: &[FixedBitSet]) -> Vec<FixedBitSet> {
    let mut alive: Vec<FixedBitSet> = gap.now.iter().map(|bits| FixedBitSet::with_capacity(bits.len())).collect();
    for (place, row) in alive.iter_mut().enumerate() {
        for to in one.mdd.edges(instant, place).iter().map(|to| *to as usize) {
            let targets = &later[to] & &gap.now_later[place];
            let open = &gap.now[place] & &gap.later_now[to];
            add_leading(other, instant, row, open.ones(), &targets);
        }
    }
    alive
}

/// The same for layers in which no two nodes are too near.
fn before_apart(one: PairSide, other: PairSide, instant: u32, later: &[FixedBitSet]) -> Vec<FixedBitSet> {
    let width = other.mdd.at(instant).len();
    let mut alive = vec![FixedBitSet::with_capacity(width); one.mdd.at(instant).len()];
    for (place, row) in alive.iter_mut().enumerate() {
        for to in one.mdd.edges(instant, place) {
            add_leading(other, instant, row, 0..width, &later[*to as usize]);
        }
    }
    alive
}

/// Adds the places of an instant that lead to one of the targets.
fn add_leading(
    side: PairSide,
    instant: u32,
    row: &mut FixedBitSet,
    places: impl Iterator<Item = usize>,
    targets: &FixedBitSet,
) {
    for place in places {
        if !row.contains(place) && side.mdd.edges(instant, place).iter().any(|to| targets.contains(*to as usize)) {
            row.insert(place);
        }
    }
}

/// Whether no nodes in the layers of an instant and the next are too near.
fn is_apart(tables: &ExactTables, one: PairSide, other: PairSide, instant: u32) -> bool {
    let extent = |side: PairSide| side.mdd.extent(instant).join(side.mdd.extent(instant + 1));
    extent(one).is_apart(&extent(other), tables.instance.separation as i32)
}

/// For each node of `one` at an instant, the nodes of `other` at an instant that keep the separation.
fn clear_rows(tables: &ExactTables, one: PairSide, at: u32, other: PairSide, other_at: u32) -> Vec<FixedBitSet> {
    let separation = tables.instance.separation as i32;
    let merged = tables.is_merged(one.agent, other.agent);
    let goal = tables.place(tables.cell(tables.goal(one.agent)));
    let (nodes, others) = (one.mdd.places(at), other.mdd.places(other_at));
    let row = |place: CellPlace| {
        let mut bits = FixedBitSet::with_capacity(others.len());
        for (word, chunk) in bits.as_mut_slice().iter_mut().zip(others.chunks(usize::BITS as usize)) {
            for (bit, other) in chunk.iter().enumerate() {
                let is_clear = (place.column - other.column).abs().max((place.row - other.row).abs()) >= separation;
                *word |= usize::from(is_clear) << bit;
            }
        }
        if merged {
            let exempt = |other: &CellPlace| place == goal || *other == goal;
            others
                .iter()
                .enumerate()
                .filter(|(_, other)| exempt(other))
                .for_each(|(other_place, _)| bits.insert(other_place));
        }
        bits
    };
    nodes.iter().map(|place| row(*place)).collect()
}
