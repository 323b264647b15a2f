//! The shortest path between two cells in layers of equal excess, from both ends.
//!
//! Problem: least sum of weights from start to goal over legal flips. Method: bidirectional Dijkstra search on costs reduced by half the
//! difference of the two XOR distances (Ikeda and others 1994). A module whose state differs between start and goal then costs nothing when
//! switched toward the far end and twice its weight when switched back; any other module costs its weight. So the excess over the XOR distance is a
//! sum of few distinct integers, and no heap is needed: the settled cells lie in one list in order of their excess, and for each distinct
//! cost a cursor runs through that list and generates the flips of that cost when their turn comes. Flips that cost nothing are followed
//! depth first. Guaranteed: optimal cost, or exhaustion of the smaller of the two components as a proof that there is no path. Cost: settled cells
//! times distinct costs; no allocation per cell beyond the growth of three lists.

use super::closed::Closed;
use super::field::Reader;
use super::lattice::{Flip, MAX_MODULES, Side, Weights, bits};
use crate::plan::search::{GaveUp, Meter};

/// Lists kept between searches.
#[derive(Default)]
pub(super) struct Workspace {
    closed: Closed,
    fronts: [Front; 2],
}

/// What the two fronts found.
pub(super) enum Layered {
    /// An optimal path and its excess over the XOR distance, or the best one with a lower bound.
    Path { flips: Vec<Flip>, excess: u64, bound: u64 },
    /// The start's component was visited in full: that many cells.
    StartShut(u64),
    /// The goal's component was visited in full.
    GoalShut(u64),
    /// The budget ran out without a path; the excess is at least `bound` in the report.
    GaveUp(GaveUp),
}

/// Parent of the two origins.
const NONE: u32 = u32::MAX;
/// Settled cells of one front; keeps indices and their tags within 32 bits.
const MAX_ENTRIES: usize = 1 << 30;

#[derive(Clone, Copy)]
struct Entry {
    at: [u32; 2],
    legal: [u32; 2],
    excess: u64,
    parent: u32,
    by: Flip,
}

/// The search from one end.
#[derive(Default)]
struct Front {
    entries: Vec<Entry>,
    /// Entries whose free flips have not been followed.
    stack: Vec<u32>,
    /// For each class of costs, the first entry whose flips of that cost have not been generated.
    cursors: Vec<usize>,
    class: usize,
    layer: u64,
    target: [u32; 2],
}

/// The flips that cost `cost`.
#[derive(Clone, Copy)]
struct Class {
    cost: u64,
    /// Modules equal at both ends, whichever way they switch.
    either: [u32; 2],
    /// Modules that differ, when they already stand as at the far end.
    back: [u32; 2],
}

struct Meeting {
    excess: u64,
    entries: [u32; 2],
    by: Flip,
}

pub(super) struct Search<'a, 'f> {
    reader: Reader<'f>,
    space: &'a mut Workspace,
    classes: Vec<Class>,
    /// Modules that differ between start and goal.
    differing: [u32; 2],
    meeting: Option<Meeting>,
    meter: &'a mut Meter,
}

/// Work done on a front.
enum Turn {
    Done,
    Exhausted,
    OutOfBudget,
}

impl<'a, 'f> Search<'a, 'f> {
    pub(super) fn new(
        reader: Reader<'f>,
        space: &'a mut Workspace,
        weights: &Weights,
        [start, goal]: [[u32; 2]; 2],
        meter: &'a mut Meter,
    ) -> Self {
        let differing = [start[0] ^ goal[0], start[1] ^ goal[1]];
        let classes = classes(weights, differing);
        space.closed.begin(reader.lattice().modules);
        space.fronts[0].begin(goal, classes.len());
        space.fronts[1].begin(start, classes.len());
        Search { reader, space, classes, differing, meeting: None, meter }
    }

    /// Runs to the end. Both cells must be free and different.
    pub(super) fn run(mut self, ends: [[u32; 2]; 2]) -> Layered {
        for (side, end) in ends.into_iter().enumerate() {
            let by = Flip::of_bit(Side::Left, 1);
            let Some(legal) = self.reader.legal(end) else { continue };
            let entry = Entry { at: end, legal, excess: 0, parent: NONE, by };
            self.settle(side, entry);
        }
        let answer = self.alternate();
        let fronts = &self.space.fronts;
        let cells = fronts.iter().flat_map(|f| f.entries.iter().map(|e| e.at));
        self.space.closed.clear(cells);
        answer
    }

    fn alternate(&mut self) -> Layered {
        let mut side = 0;
        while !self.met() {
            match self.turn(side) {
                Turn::Done => side ^= 1,
                Turn::Exhausted if self.meeting.is_some() => break,
                Turn::Exhausted => return self.shut(side),
                Turn::OutOfBudget => return self.stopped(),
            }
        }
        self.check_pending();
        let (flips, excess) = self.path();
        Layered::Path { flips, excess, bound: excess }
    }

    /// No path that is still unseen through an unsettled cell can be better than the one in hand.
    fn met(&self) -> bool {
        let [a, b] = [&self.space.fronts[0], &self.space.fronts[1]];
        self.meeting.as_ref().is_some_and(|m| a.layer + b.layer >= m.excess)
    }

    #[inline]
    fn turn(&mut self, side: usize) -> Turn {
        let front = &mut self.space.fronts[side];
        if let Some(index) = front.stack.pop() {
            let entry = front.entries[index as usize];
            let free = |k: usize| entry.legal[k] & self.differing[k] & (entry.at[k] ^ front.target[k]);
            let flips = [free(0), free(1)];
            return self.generate(side, index, flips, 0);
        }
        let Some((index, class)) = front.next(&self.classes) else {
            return Turn::Exhausted;
        };
        let entry = &front.entries[index as usize];
        let flips = class.flips(entry, front.target);
        self.generate(side, index, flips, class.cost)
    }

    #[inline]
    fn generate(&mut self, side: usize, index: u32, flips: [u32; 2], cost: u64) -> Turn {
        let from = self.space.fronts[side].entries[index as usize];
        let excess = from.excess + cost;
        for which in Side::BOTH {
            for bit in bits(flips[which.index()]) {
                let mut at = from.at;
                at[which.index()] ^= bit;
                let by = Flip::of_bit(which, bit);
                let tag = *self.space.closed.entry(at);
                if tag == 0 {
                    let Some(legal) = self.reader.legal(at) else { continue };
                    if self.meter.step().is_none() || self.space.fronts[side].entries.len() >= MAX_ENTRIES {
                        return Turn::OutOfBudget;
                    }
                    self.settle(side, Entry { at, legal, excess, parent: index, by });
                } else if tag_side(tag) != side {
                    self.meet(side, index, tag, cost, by);
                }
            }
        }
        Turn::Done
    }

    #[inline]
    fn settle(&mut self, side: usize, entry: Entry) {
        let front = &mut self.space.fronts[side];
        let index = front.entries.len() as u32;
        *self.space.closed.entry(entry.at) = tag(side, index);
        self.space.closed.filled();
        front.entries.push(entry);
        front.stack.push(index);
    }

    fn meet(&mut self, side: usize, index: u32, tag: u32, cost: u64, by: Flip) {
        let other = tag_index(tag);
        let fronts = &self.space.fronts;
        let excess =
            fronts[side].entries[index as usize].excess + cost + fronts[side ^ 1].entries[other as usize].excess;
        if self.meeting.as_ref().is_none_or(|m| excess < m.excess) {
            let entries = if side == 0 { [index, other] } else { [other, index] };
            self.meeting = Some(Meeting { excess, entries, by });
        }
    }

    /// Flips between a cell of one front and a cell of the other are seen when their cost's turn comes; those whose turn has come on
    /// neither side are looked at now, from the smaller front.
    fn check_pending(&mut self) {
        let side = usize::from(self.space.fronts[1].entries.len() < self.space.fronts[0].entries.len());
        for c in 0..self.classes.len() {
            let class = self.classes[c];
            let far = self.space.fronts[side ^ 1].pending_excess(c);
            let Some(far) = far else { continue };
            for index in self.space.fronts[side].cursors[c]..self.space.fronts[side].entries.len() {
                let front = &self.space.fronts[side];
                let entry = front.entries[index];
                if self.meeting.as_ref().is_some_and(|m| entry.excess + class.cost + far >= m.excess) {
                    break;
                }
                let flips = class.flips(&entry, front.target);
                self.look(side, index as u32, flips, class.cost);
            }
        }
    }

    fn look(&mut self, side: usize, index: u32, flips: [u32; 2], cost: u64) {
        let from = self.space.fronts[side].entries[index as usize].at;
        for which in Side::BOTH {
            for bit in bits(flips[which.index()]) {
                let mut at = from;
                at[which.index()] ^= bit;
                let tag = self.space.closed.get(at);
                if tag != 0 && tag_side(tag) != side {
                    self.meet(side, index, tag, cost, Flip::of_bit(which, bit));
                }
            }
        }
    }

    fn shut(&self, side: usize) -> Layered {
        let cells = self.space.fronts[side].entries.len() as u64;
        match side {
            0 => Layered::StartShut(cells),
            _ => Layered::GoalShut(cells),
        }
    }

    fn stopped(&mut self) -> Layered {
        self.check_pending();
        let bound = self.bound();
        match self.meeting.is_some() {
            true => {
                let (flips, excess) = self.path();
                Layered::Path { flips, excess, bound: bound.min(excess) }
            }
            false => Layered::GaveUp(self.meter.gave_up(bound)),
        }
    }

    /// A path not yet seen leaves the settled cells of both fronts, or crosses by a flip that is pending on both.
    fn bound(&self) -> u64 {
        let [a, b] = &self.space.fronts;
        let crossing = |c: usize| {
            let [from, to] = [a.pending_excess(c)?, b.pending_excess(c)?];
            Some(from + to + self.classes[c].cost)
        };
        let crossings = (0..self.classes.len()).filter_map(crossing);
        crossings.fold(a.layer + b.layer, u64::min)
    }

    fn path(&self) -> (Vec<Flip>, u64) {
        let Some(meeting) = &self.meeting else {
            return (Vec::new(), 0);
        };
        let [forward, backward] = &self.space.fronts;
        let mut flips = forward.trail(meeting.entries[0]);
        flips.reverse();
        flips.push(meeting.by);
        flips.extend(backward.trail(meeting.entries[1]));
        (flips, meeting.excess)
    }
}

impl Front {
    fn begin(&mut self, target: [u32; 2], classes: usize) {
        self.entries.clear();
        self.stack.clear();
        self.cursors.clear();
        self.cursors.resize(classes, 0);
        (self.class, self.layer, self.target) = (0, 0, target);
    }

    /// The next entry and class in order of the excess that its flips lead to.
    #[inline]
    fn next(&mut self, classes: &[Class]) -> Option<(u32, Class)> {
        if self.pending_excess(self.class).map(|e| e + classes[self.class].cost) != Some(self.layer) {
            let keys = (0..classes.len()).filter_map(|c| Some((self.pending_excess(c)? + classes[c].cost, c)));
            (self.layer, self.class) = keys.min()?;
        }
        let index = self.cursors[self.class];
        self.cursors[self.class] += 1;
        Some((index as u32, classes[self.class]))
    }

    #[inline]
    fn pending_excess(&self, class: usize) -> Option<u64> {
        let index = *self.cursors.get(class)?;
        self.entries.get(index).map(|entry| entry.excess)
    }

    /// Flips from the entry back to the origin.
    fn trail(&self, mut index: u32) -> Vec<Flip> {
        let mut flips = Vec::new();
        while self.entries[index as usize].parent != NONE {
            flips.push(self.entries[index as usize].by);
            index = self.entries[index as usize].parent;
        }
        flips
    }
}

impl Class {
    #[inline]
    fn flips(&self, entry: &Entry, target: [u32; 2]) -> [u32; 2] {
        let of = |k: usize| entry.legal[k] & (self.either[k] | (self.back[k] & !(entry.at[k] ^ target[k])));
        [of(0), of(1)]
    }
}

fn classes(weights: &Weights, differing: [u32; 2]) -> Vec<Class> {
    let mut classes: Vec<Class> = Vec::with_capacity(2 * MAX_MODULES as usize);
    for side in Side::BOTH {
        let k = side.index();
        for i in 0..weights.modules[k] {
            let bit = 1 << i;
            let differs = differing[k] & bit != 0;
            let weight = u64::from(weights.of[k][i as usize]);
            let cost = if differs { 2 * weight } else { weight };
            let at = match classes.binary_search_by_key(&cost, |class| class.cost) {
                Ok(at) => at,
                Err(at) => {
                    classes.insert(at, Class { cost, either: [0; 2], back: [0; 2] });
                    at
                }
            };
            let class = &mut classes[at];
            if differs { class.back[k] |= bit } else { class.either[k] |= bit }
        }
    }
    classes
}

const fn tag(side: usize, index: u32) -> u32 {
    (index << 1 | side as u32) + 1
}

const fn tag_side(tag: u32) -> usize {
    (tag - 1) as usize & 1
}

const fn tag_index(tag: u32) -> u32 {
    (tag - 1) >> 1
}
