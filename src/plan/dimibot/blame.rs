//! Obstacles to blame when there is no path.
//!
//! Problem: the smallest set of obstacles whose removal opens a path (minimum constraint removal, NP-hard; Hauser 2014). Method:
//! obstacles that cover an end must be removed in any case; then every single obstacle that borders the smaller component is tested
//! exactly; then a search whose cost is the number of distinct obstacles crossed, one set kept per cell, and a deletion filter on
//! its result. Guaranteed: see [`Opening`]. One step of the budget is one flip examined.

use super::field::LatticeField;
use super::lattice::{Flip, LatticeCell, Side, SwitchWeights, bits};
use super::obstacles::FieldObstacle;
use super::outcome::DimibotAnswer;
use super::shortest::{outside, shortest};
use crate::plan::search::{Meter, SearchBudget};
use rustc_hash::{FxHashMap, FxHashSet};
use std::collections::BTreeSet;

/// Most obstacles of the border named if no opening set was found within the budget.
const MAX_BORDER: usize = 32;
/// Budget in cells of a path search with some obstacles removed.
const TRIAL: SearchBudget = SearchBudget::of(1 << 20);
/// 1/`FLOOD_SHARE` of the budget is spent on flooding from both ends, to find the nearby obstacles.
const FLOOD_SHARE: u64 = 8;
/// Most obstacles of a scene that are all tested singly if the flood does not end within its budget.
const MAX_SUSPECTS: usize = 32;
/// Obstacles rebuilt per step of the budget when a field is built without some of them.
const REBUILT_PER_STEP: u64 = 2;

/// Obstacles merged into a union of two sets per step of the budget.
const MERGED_PER_STEP: u64 = 8;

/// The obstacles to blame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ObstacleBlame {
    /// Indices of the obstacles, ascending; never empty.
    pub obstacles: Vec<usize>,
    /// Known effect of their removal.
    pub opening: Opening,
}

/// Known effect of the removal of a set of obstacles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opening {
    /// It opens a path, and no smaller set does.
    Smallest,
    /// It opens a path, and no proper subset does.
    Irreducible,
    /// It opens a path; a smaller part of the set may suffice.
    Opens,
    /// The obstacles border the cells reachable from one end (or cover it); the budget did not suffice to test whether
    /// their removal is enough.
    Unknown,
}

/// The obstacles to blame for the lack of a path from `start` to `goal`: `None` if there is a path, or if one of the two is not a
/// cell of the lattice.
///
/// `obstacles` must be the list from which `field` was built. The proof that there is no path is repeated only up to
/// about a million cells; beyond that the caller must have proven it, since claims about the smallest set rest on it.
pub fn blame(
    field: &LatticeField,
    obstacles: &[FieldObstacle],
    start: LatticeCell,
    goal: LatticeCell,
    budget: SearchBudget,
) -> Option<ObstacleBlame> {
    if outside(field, start, goal).is_some() {
        return None;
    }
    let scene = BlamedScene { field, obstacles, start, goal };
    let covering: BTreeSet<usize> = field.covering(start).into_iter().chain(field.covering(goal)).collect();
    let mut meter = Meter::new(budget);
    match scene.trial(&covering, &mut meter) {
        BlameTrial::Open if covering.is_empty() => None,
        BlameTrial::Open => Some(ObstacleBlame::of(covering, Opening::Smallest)),
        BlameTrial::Shut | BlameTrial::Unknown => {
            let found = scene.search(covering, &mut meter);
            (!found.obstacles.is_empty()).then_some(found)
        }
    }
}

impl ObstacleBlame {
    fn of(set: BTreeSet<usize>, opening: Opening) -> ObstacleBlame {
        ObstacleBlame { obstacles: set.into_iter().collect(), opening }
    }
}

struct BlamedScene<'a> {
    field: &'a LatticeField,
    obstacles: &'a [FieldObstacle],
    start: LatticeCell,
    goal: LatticeCell,
}

enum BlameTrial {
    Open,
    Shut,
    Unknown,
}

impl BlamedScene<'_> {
    fn search(&self, covering: BTreeSet<usize>, meter: &mut Meter) -> ObstacleBlame {
        let flood = meter.left().steps / FLOOD_SHARE;
        let (border, [from, to]) = meter.share(flood, |meter| self.smaller_border(&covering, meter));
        let few = (self.obstacles.len() <= MAX_SUSPECTS).then(|| (0..self.obstacles.len()).collect());
        let singles = match border.as_ref().or(few.as_ref()) {
            Some(suspects) => self.single(suspects, &covering, meter),
            None => SingleRemovals::NotTried,
        };
        if let SingleRemovals::Opens(set) = singles {
            return ObstacleBlame::of(set, Opening::Smallest);
        }
        // If no single obstacle opens a path, at least two are needed.
        let least = if matches!(singles, SingleRemovals::None) { 2 } else { 1 };
        match ObstacleCrossingSearch::new(self.field, &covering).run(from, to, meter) {
            Some(set) => self.filter(set, &covering, least, meter),
            None => {
                let named = border.unwrap_or_default().into_iter().take(MAX_BORDER);
                ObstacleBlame::of(covering.into_iter().chain(named).collect(), Opening::Unknown)
            }
        }
    }

    /// Obstacles around the smaller of the two components once `removed` is gone, and the two ends, the one in that component
    /// first; the obstacles only if the budget suffices.
    fn smaller_border(
        &self,
        removed: &BTreeSet<usize>,
        meter: &mut Meter,
    ) -> (Option<BTreeSet<usize>>, [LatticeCell; 2]) {
        let mut sides = [self.start, self.goal].map(|end| Component::new(self.field, removed, end));
        loop {
            for (k, side) in sides.iter_mut().enumerate() {
                match side.spread(meter) {
                    BlameSpread::More => {}
                    BlameSpread::Done => {
                        let ends = if k == 0 { [self.start, self.goal] } else { [self.goal, self.start] };
                        return (Some(std::mem::take(&mut side.border)), ends);
                    }
                    BlameSpread::OutOfBudget => return (None, [self.goal, self.start]),
                }
            }
        }
    }

    /// Whether a path exists without these obstacles.
    fn trial(&self, removed: &BTreeSet<usize>, meter: &mut Meter) -> BlameTrial {
        if meter.left().steps == 0 {
            return BlameTrial::Unknown;
        }
        let rest: Vec<FieldObstacle>;
        let built;
        let field = match removed.is_empty() {
            true => self.field,
            false => {
                meter.charge(self.obstacles.len() as u64 / REBUILT_PER_STEP);
                let kept = |(k, _): &(usize, &FieldObstacle)| !removed.contains(k);
                let list = self.obstacles.iter().enumerate().filter(kept);
                rest = list.map(|(_, o)| o.clone()).collect();
                match LatticeField::new(*self.field.lattice(), &rest) {
                    Ok(field) => built = field,
                    Err(_) => return BlameTrial::Unknown,
                }
                &built
            }
        };
        let weights = SwitchWeights::switches(field.lattice());
        let budget = SearchBudget::of(TRIAL.steps.min(meter.left().steps));
        match shortest(field, self.start, self.goal, &weights, budget) {
            DimibotAnswer::Found(path) => {
                meter.charge_metered(path.expanded);
                BlameTrial::Open
            }
            DimibotAnswer::Impossible(proof) => {
                meter.charge_metered(proof.expanded);
                BlameTrial::Shut
            }
            DimibotAnswer::GaveUp(gave_up) => {
                meter.charge_metered(gave_up.spent);
                BlameTrial::Unknown
            }
        }
    }

    /// The first single obstacle whose removal, besides those that cover an end, opens a path.
    fn single(&self, border: &BTreeSet<usize>, covering: &BTreeSet<usize>, meter: &mut Meter) -> SingleRemovals {
        let mut answer = SingleRemovals::None;
        for obstacle in border {
            let mut set = covering.clone();
            set.insert(*obstacle);
            match self.trial(&set, meter) {
                BlameTrial::Open => return SingleRemovals::Opens(set),
                BlameTrial::Shut => {}
                BlameTrial::Unknown => answer = SingleRemovals::NotTried,
            }
        }
        answer
    }

    /// Deletion filter: drops the obstacles whose removal is not needed.
    fn filter(
        &self,
        mut set: BTreeSet<usize>,
        covering: &BTreeSet<usize>,
        least: usize,
        meter: &mut Meter,
    ) -> ObstacleBlame {
        let mut opening = Opening::Irreducible;
        for candidate in set.difference(covering).copied().collect::<Vec<_>>() {
            let mut fewer = set.clone();
            fewer.remove(&candidate);
            match self.trial(&fewer, meter) {
                BlameTrial::Open => set = fewer,
                BlameTrial::Shut => {}
                BlameTrial::Unknown => opening = Opening::Opens,
            }
        }
        if set.len() == covering.len() + least {
            opening = Opening::Smallest;
        }
        ObstacleBlame::of(set, opening)
    }
}

enum SingleRemovals {
    Opens(BTreeSet<usize>),
    None,
    NotTried,
}

/// The known part of the cells reachable from an end, and the obstacles around them.
struct Component<'a> {
    field: &'a LatticeField,
    removed: &'a BTreeSet<usize>,
    border: BTreeSet<usize>,
    seen: FxHashSet<LatticeCell>,
    stack: Vec<LatticeCell>,
}

enum BlameSpread {
    More,
    Done,
    OutOfBudget,
}

impl<'a> Component<'a> {
    fn new(field: &'a LatticeField, removed: &'a BTreeSet<usize>, end: LatticeCell) -> Self {
        let seen = FxHashSet::from_iter([end]);
        let border = BTreeSet::new();
        Component { field, removed, border, seen, stack: vec![end] }
    }

    fn spread(&mut self, meter: &mut Meter) -> BlameSpread {
        let Some(cell) = self.stack.pop() else {
            return BlameSpread::Done;
        };
        let legal = self.field.legal(cell).unwrap_or([0, 0]);
        for flip in flips(self.field) {
            if meter.step().is_none() {
                return BlameSpread::OutOfBudget;
            }
            let next = cell.after(flip);
            if self.seen.contains(&next) {
                continue;
            }
            let mut blocking = match legal[flip.side.index()] >> flip.module & 1 {
                1 => Vec::new(),
                _ => self.field.blocking(cell, flip),
            };
            blocking.retain(|k| !self.removed.contains(k));
            if blocking.is_empty() {
                self.seen.insert(next);
                self.stack.push(next);
            }
            self.border.extend(blocking);
        }
        BlameSpread::More
    }
}

fn flips(field: &LatticeField) -> impl Iterator<Item = Flip> + use<> {
    let of = |side| bits(field.lattice().last(side)).map(move |bit| Flip::of_bit(side, bit));
    of(Side::Left).chain(of(Side::Right)).collect::<Vec<_>>().into_iter()
}

/// A best-first search by the number of distinct obstacles crossed.
struct ObstacleCrossingSearch<'a> {
    field: &'a LatticeField,
    /// Sets of obstacles, ascending; the index is the set's number.
    sets: Vec<Vec<usize>>,
    numbers: FxHashMap<Vec<usize>, usize>,
    settled: FxHashMap<LatticeCell, usize>,
    /// By size of the set: cells with the number of their set.
    queue: Vec<Vec<(LatticeCell, usize)>>,
}

impl<'a> ObstacleCrossingSearch<'a> {
    fn new(field: &'a LatticeField, removed: &BTreeSet<usize>) -> Self {
        let first: Vec<usize> = removed.iter().copied().collect();
        ObstacleCrossingSearch {
            field,
            numbers: FxHashMap::from_iter([(first.clone(), 0)]),
            sets: vec![first],
            settled: FxHashMap::default(),
            queue: Vec::new(),
        }
    }

    /// The obstacles on a path that crosses few of them; `None` if the budget runs out.
    fn run(&mut self, from: LatticeCell, to: LatticeCell, meter: &mut Meter) -> Option<BTreeSet<usize>> {
        self.push(from, 0);
        let mut size = 0;
        while size < self.queue.len() {
            let Some((cell, set)) = self.queue[size].pop() else {
                size += 1;
                continue;
            };
            if cell == to {
                return Some(self.sets[set].iter().copied().collect());
            }
            if self.settled.contains_key(&cell) {
                continue;
            }
            self.settled.insert(cell, set);
            self.spread(cell, set, to, meter)?;
        }
        None
    }

    /// Queues the neighbours. Those toward the goal come last, and of these the longest stroke, since the queue is a
    /// stack.
    fn spread(&mut self, cell: LatticeCell, set: usize, to: LatticeCell, meter: &mut Meter) -> Option<()> {
        let toward = |flip: &Flip| {
            let bit = 1_u32 << flip.module;
            match flip.side {
                Side::Left => (cell.x ^ to.x) & bit,
                Side::Right => (cell.y ^ to.y) & bit,
            }
        };
        let mut flips: Vec<Flip> = flips(self.field).collect();
        flips.sort_by_key(toward);
        for flip in flips {
            meter.step()?;
            let next = cell.after(flip);
            if !self.settled.contains_key(&next) {
                let blocking = self.field.blocking(cell, flip);
                // The cost of a union grows with the length of its sets.
                meter.charge((self.sets[set].len() + blocking.len()) as u64 / MERGED_PER_STEP);
                let union = self.union(set, blocking);
                self.push(next, union);
            }
        }
        Some(())
    }

    fn union(&mut self, set: usize, more: Vec<usize>) -> usize {
        if more.iter().all(|k| self.sets[set].binary_search(k).is_ok()) {
            return set;
        }
        let mut union = self.sets[set].clone();
        union.extend(more);
        union.sort_unstable();
        union.dedup();
        let fresh = self.sets.len();
        let number = *self.numbers.entry(union.clone()).or_insert(fresh);
        if number == fresh {
            self.sets.push(union);
        }
        number
    }

    fn push(&mut self, cell: LatticeCell, set: usize) {
        let size = self.sets[set].len();
        if self.queue.len() <= size {
            self.queue.resize_with(size + 1, Vec::new);
        }
        self.queue[size].push((cell, set));
    }
}
