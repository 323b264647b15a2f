//! Exact search between two cells, in stages from cheap to thorough.
//!
//! Problem: least sum of weights from start to goal. Method: A* on the cells, guided by distances of blocks (see
//! [`super::blocks`], [`super::guided`]): first a short search without them, then with them, and in large lattices with
//! those of much smaller blocks, found by the same search on the abstraction. A flood from the goal runs alongside, so
//! that a goal in a small pocket is proven unreachable without visiting the rest. When the budget runs out, weighted A*
//! finds some path, which is returned with the bound proven so far. Guaranteed: see [`DimibotAnswer`]. One step of the
//! budget is one cell queued.

use super::blocks::{BlockDistances, Blocks};
use super::guided::{BlockGuide, Guide, GuidedSearch, Lists, NoBlocks, SearchEnd, SearchSpace, small_difference};
use super::lattice::{Flip, Side, SwitchWeights, bits};
use super::lines::LineReader;
use super::outcome::{DimibotAnswer, FlipPath, Proof};
use super::seen::Seen;
use crate::plan::search::{Meter, SearchBudget};
use rustc_hash::FxHashMap;

/// Coarse modules of each side in the first abstraction: 64 by 64 blocks.
const COARSE: u32 = 6;
/// Coarse modules of each side in the second abstraction: 1024 by 1024 blocks. Smaller lattices do not need it.
const MIDDLE: u32 = 10;
/// Cells queued before the distances of blocks are computed.
const FIRST_TRY: u64 = 1 << 12;
/// Cells queued before the second abstraction is built.
const SECOND_TRY: u64 = 1 << 16;
/// 1/`KEPT_PART` of the budget is reserved for a path that need not be optimal.
const KEPT_PART: u64 = 4;
/// Cells settled from the start per cell flooded from the goal.
const PACE: u64 = 4;
/// Heuristic weights for a path that need not be optimal, from careful to greedy.
const GREEDS: [i64; 3] = [2, 8, 64];

/// Data kept between searches of one field.
#[derive(Default)]
pub(super) struct Workspace {
    coarse: Option<Blocks>,
    middle: Option<Blocks>,
    to_goal: BlockDistances,
    to_start: BlockDistances,
    lists: Lists,
    flood: GoalFlood,
}

/// The cells reached from the goal so far.
#[derive(Default)]
struct GoalFlood {
    seen: Seen,
    cells: Vec<[u32; 2]>,
    /// Cells whose neighbours have been added.
    spread: usize,
    calls: u64,
}

impl Workspace {
    /// Builds the first abstraction of the field.
    pub(super) fn prepare(&mut self, reader: &mut LineReader<'_>) {
        self.coarse.get_or_insert_with(|| Blocks::new(reader, COARSE));
    }
}

pub(super) struct LatticeJourney<'a, 'f> {
    reader: LineReader<'f>,
    weights: &'a SwitchWeights,
    start: [u32; 2],
    goal: [u32; 2],
    meter: Meter,
    /// The highest lower bound proven so far.
    bound: u64,
}

/// Conclusive result of a stage.
enum Decided {
    Path,
    No(Proof),
}

impl<'a, 'f> LatticeJourney<'a, 'f> {
    /// Both cells must be free and different.
    pub(super) fn new(
        reader: LineReader<'f>,
        weights: &'a SwitchWeights,
        ends: [[u32; 2]; 2],
        budget: SearchBudget,
    ) -> Self {
        let [start, goal] = ends;
        let bound = weights.of_masks([start[0] ^ goal[0], start[1] ^ goal[1]]);
        LatticeJourney { reader, weights, start, goal, meter: Meter::new(budget), bound }
    }

    pub(super) fn run(mut self, space: &mut Workspace) -> DimibotAnswer<FlipPath> {
        let coarse = space.coarse.take().unwrap_or_else(|| Blocks::new(&mut self.reader, COARSE));
        space.flood.begin(self.reader.modules(), self.goal);
        let decided = self.stages(&coarse, space);
        space.coarse = Some(coarse);
        match decided {
            Some(Decided::Path) => self.path(&space.lists, None),
            Some(Decided::No(proof)) => DimibotAnswer::impossible(proof, self.meter.spent()),
            None => self.some_path(space),
        }
    }

    fn stages(&mut self, coarse: &Blocks, space: &mut Workspace) -> Option<Decided> {
        let [start, goal] = [self.start, self.goal].map(|at| coarse.block(at));
        if !coarse.connected(start, goal) {
            return Some(Decided::No(Proof::BlocksApart));
        }
        let guide = NoBlocks { modules: self.reader.modules() };
        let first = self.search(&guide, &mut space.lists, &mut space.flood, FIRST_TRY);
        if first.is_some() {
            return first;
        }
        space.to_goal.find(coarse, goal, self.weights);
        let large = self.reader.modules().into_iter().any(|n| n > MIDDLE);
        let limit = if large { SECOND_TRY } else { self.allowed() };
        if let decided @ Some(_) = self.stage(coarse, space, limit) {
            return decided;
        }
        large.then(|| self.last_stage(coarse, space)).flatten()
    }

    /// Steps that may be spent on proving an optimum.
    fn allowed(&self) -> u64 {
        let left = self.meter.left().steps;
        left - left / KEPT_PART
    }

    fn stage(&mut self, coarse: &Blocks, space: &mut Workspace, limit: u64) -> Option<Decided> {
        let guide = BlockGuide { blocks: coarse, distances: &space.to_goal, shift: [0, 0] };
        self.search(&guide, &mut space.lists, &mut space.flood, limit)
    }

    fn search(&mut self, guide: &impl Guide, lists: &mut Lists, flood: &mut GoalFlood, limit: u64) -> Option<Decided> {
        let limit = limit.min(self.allowed());
        let (start, goal) = (self.start, self.goal);
        let ground = &mut self.reader;
        let mut search = GuidedSearch { ground, guide, lists, weights: self.weights, target: goal, greed: 1 };
        let Some(estimate) = search.estimate(start) else {
            return Some(Decided::No(Proof::BlocksApart));
        };
        let ended = self.meter.share(limit, |meter| search.run(start, meter, |ground| flood.keep_pace(ground)));
        match ended {
            SearchEnd::Found => Some(Decided::Path),
            SearchEnd::Exhausted(cells) => Some(Decided::No(Proof::StartShut { cells })),
            SearchEnd::Stopped => Some(Decided::No(Proof::GoalShut { cells: flood.cells.len() as u64 })),
            SearchEnd::OutOfBudget(excess) => {
                self.bound = self.bound.max(estimate + excess);
                None
            }
        }
    }

    /// Computes distances of much smaller blocks and searches with their guidance.
    fn last_stage(&mut self, coarse: &Blocks, space: &mut Workspace) -> Option<Decided> {
        let middle = space.middle.take().unwrap_or_else(|| Blocks::new(&mut self.reader, MIDDLE));
        let decided = self.with_middle(coarse, &middle, space);
        space.middle = Some(middle);
        decided
    }

    fn with_middle(&mut self, coarse: &Blocks, middle: &Blocks, space: &mut Workspace) -> Option<Decided> {
        if !middle.connected(middle.block(self.start), middle.block(self.goal)) {
            return Some(Decided::No(Proof::BlocksApart));
        }
        space.to_start.find(coarse, coarse.block(self.start), self.weights);
        let to_start = BlockGuide { blocks: coarse, distances: &space.to_start, shift: middle.fine };
        let to_goal = BlockGuide { distances: &space.to_goal, ..to_start };
        let small = |at: [u32; 2]| [at[0] >> middle.fine[0], at[1] >> middle.fine[1]];
        let [start, goal] = [self.start, self.goal].map(small);
        let weights = self.weights.without(middle.fine);
        let limit = self.allowed();
        let mut ground = middle;
        let (lists, guide) = (&mut space.lists, &to_start);
        let mut search = GuidedSearch { ground: &mut ground, guide, lists, weights: &weights, target: start, greed: 1 };
        let estimate = search.estimate(goal)?;
        let ended = self.meter.share(limit, |meter| search.run(goal, meter, |_| true));
        match ended {
            SearchEnd::Found | SearchEnd::OutOfBudget(_) => {}
            SearchEnd::Exhausted(_) | SearchEnd::Stopped => return Some(Decided::No(Proof::BlocksApart)),
        }
        let guide = MiddleGuide::new(middle, [to_start, to_goal], weights, [start, goal], estimate, &space.lists);
        self.search(&guide, &mut space.lists, &mut space.flood, u64::MAX)
    }

    /// A path that need not be optimal, by weighted A*.
    fn some_path(mut self, space: &mut Workspace) -> DimibotAnswer<FlipPath> {
        let Some(coarse) = &space.coarse else {
            return DimibotAnswer::GaveUp(self.meter.gave_up(self.bound));
        };
        let guide = BlockGuide { blocks: coarse, distances: &space.to_goal, shift: [0, 0] };
        let limit = self.meter.left().steps / GREEDS.len() as u64;
        for greed in GREEDS {
            let mut meter = Meter::new(SearchBudget::of(limit));
            let (ground, lists) = (&mut self.reader, &mut space.lists);
            let mut search =
                GuidedSearch { ground, guide: &guide, lists, weights: self.weights, target: self.goal, greed };
            let ended = search.run(self.start, &mut meter, |_| true);
            self.meter.charge_metered(meter.spent());
            if matches!(ended, SearchEnd::Found) {
                return self.path(&space.lists, Some(self.bound));
            }
        }
        DimibotAnswer::GaveUp(self.meter.gave_up(self.bound))
    }

    fn path(&self, lists: &Lists, bound: Option<u64>) -> DimibotAnswer<FlipPath> {
        let flips: Vec<Flip> = lists.path();
        let cost = flips.iter().map(|flip| self.weights.of(*flip)).sum();
        let bound = bound.map_or(cost, |bound| bound.min(cost));
        DimibotAnswer::Found(FlipPath { flips, cost, bound, expanded: self.meter.spent() })
    }
}

/// Distances of the small blocks of the second abstraction to the goal: exact where the search from the goal has settled them;
/// elsewhere bounded by its last layer and by the larger blocks.
struct MiddleGuide<'a> {
    middle: &'a Blocks,
    to_start: BlockGuide<'a>,
    weights: SwitchWeights,
    to_goal: BlockGuide<'a>,
    start: [u32; 2],
    goal: [u32; 2],
    /// Distance to the goal, by block.
    exact: FxHashMap<[u32; 2], u64>,
    /// Lower bound on the sum of the distance to the goal and `to_start`, for every block not in `exact`.
    layer: u64,
}

impl<'a> MiddleGuide<'a> {
    fn new(
        middle: &'a Blocks,
        [to_start, to_goal]: [BlockGuide<'a>; 2],
        weights: SwitchWeights,
        [start, goal]: [[u32; 2]; 2],
        estimate: u64,
        lists: &Lists,
    ) -> Self {
        let layer = estimate + lists.settled().last().map_or(0, |(_, excess)| excess);
        let exact = FxHashMap::default();
        let mut guide = MiddleGuide { middle, to_start, to_goal, weights, start, goal, exact, layer };
        for (at, excess) in lists.settled() {
            if let Some(rest) = guide.to_start(at) {
                guide.exact.insert(at, (estimate + excess).saturating_sub(rest));
            }
        }
        guide
    }

    fn to_start(&self, at: [u32; 2]) -> Option<u64> {
        let small = small_difference(&self.to_start, &self.weights, at, self.start);
        Some(self.to_start.coarse(at)? + small)
    }
}

impl Guide for MiddleGuide<'_> {
    fn fine(&self) -> [u32; 2] {
        self.middle.fine
    }

    fn coarse(&self, at: [u32; 2]) -> Option<u64> {
        let block = [at[0] >> self.middle.fine[0], at[1] >> self.middle.fine[1]];
        match self.exact.get(&block) {
            Some(distance) => Some(*distance),
            None => {
                // Admissible by the definition of `layer`; the larger of two lower bounds is one too.
                let beyond = self.layer.saturating_sub(self.to_start(block)?);
                let small = small_difference(&self.to_goal, &self.weights, block, self.goal);
                Some(beyond.max(self.to_goal.coarse(block)? + small))
            }
        }
    }
}

impl GoalFlood {
    fn begin(&mut self, modules: [u32; 2], goal: [u32; 2]) {
        self.seen.clear(self.cells.drain(..));
        self.seen.begin(modules);
        (self.spread, self.calls) = (0, 0);
        self.seen.insert(goal);
        self.cells.push(goal);
    }

    /// Spreads once every [`PACE`] calls; `false` once the goal's component is exhausted.
    fn keep_pace(&mut self, ground: &mut impl SearchSpace) -> bool {
        self.calls += 1;
        if !self.calls.is_multiple_of(PACE) {
            return true;
        }
        let Some(&at) = self.cells.get(self.spread) else {
            return false;
        };
        self.spread += 1;
        let legal = ground.legal(at);
        for side in Side::BOTH {
            for bit in bits(legal[side.index()]) {
                let mut next = at;
                next[side.index()] ^= bit;
                if self.seen.insert(next) {
                    self.cells.push(next);
                }
            }
        }
        true
    }
}

#[cfg(test)]
mod tests;
