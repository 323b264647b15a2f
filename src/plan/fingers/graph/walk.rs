//! Resumable A* through one route, which stops at a cost limit.
//!
//! The estimate of a node is h = 2·roll·(remaining steps) + gait·(remaining reconfigurations, by the estimator). It is admissible:
//! at least two fingers roll in each step, each step changes the remaining steps by at most one, and reconfigurations are counted
//! separately. It is consistent if the estimator's count changes by at most one per reconfiguration, and not at all along other
//! edges: both estimators promise that the count of an edge's first end is at most that of its second, plus 1 for a
//! reconfiguration. So no node is expanded at more than its least cost.
//!
//! With a limit on reconfigurations, a node is kept once per number of them (labels of two costs, as in BOA*, Hernández and others
//! 2023): since nodes are expanded in order of cost, one with no fewer than an earlier one is dominated.
//!
//! Placements are expanded partially: those that do not increase the estimated cost are generated at once, the rest when
//! their own estimated cost is the least.

use super::course::PreparedRoute;
use super::flood::TRIPLE_LOOKS;
use super::layout::{GraspChain, NodeSpot, inserted, removed, wrapped};
use crate::plan::search::Meter;
use rustc_hash::FxHashMap;
use std::collections::BTreeMap;

/// No path.
pub const NEVER: u32 = u32::MAX;

/// Looks per placement whose remaining reconfigurations are estimated.
const LOOKS: u64 = 4;

/// Low bits of a search key that count reconfigurations; no path has as many as they can count.
const COUNT: u32 = 20;

/// Edge costs in the combined key of the search: among paths of equal cost fewer reconfigurations rank lower, and their number can
/// be read from the key.
#[derive(Debug, Clone, Copy)]
pub struct RankedEntry {
    roll: u64,
    gait: u64,
}

impl RankedEntry {
    pub fn of(costs: super::GraspCosts) -> RankedEntry {
        RankedEntry { roll: ranked(u64::from(costs.roll)), gait: ranked(u64::from(costs.gait)) + 1 }
    }
}

/// Key of a cost without reconfigurations.
pub fn ranked(cost: u64) -> u64 {
    cost.saturating_mul(1 << COUNT)
}

/// The cost of a key.
pub fn unranked(cost: u64) -> u64 {
    cost >> COUNT
}

/// The reconfigurations of a key.
fn gaits_of(cost: u64) -> u32 {
    (cost & ((1 << COUNT) - 1)) as u32
}

/// Lower bounds on the remaining reconfigurations.
pub trait Estimate {
    /// Lower bound for a node; [`NEVER`] where no goal is reachable. It may only grow, by [`Estimate::deepen`].
    fn gaits(&self, spot: NodeSpot) -> u32;

    /// Whether the bound of a node is final.
    fn is_settled(&self, spot: NodeSpot) -> bool;

    /// Continues the computation, so that bounds that are not settled may grow.
    fn deepen(&mut self);
}

/// Result of advancing a walk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum WalkProgress {
    /// The goal was reached at this cost.
    Found(u64),
    /// Lower bound on the cost of any goal.
    AtLeast(u64),
    /// There is no path.
    Exhausted,
    /// The budget ran out; lower bound on the cost of any goal.
    Spent(u64),
}

/// A generated node.
#[derive(Debug, Clone, Copy)]
struct WalkRecord {
    spot: u64,
    /// Least cost from the start so far.
    cost: u64,
    parent: u32,
}

/// Parent of a root.
const NO_PARENT: u32 = u32::MAX;

/// Queue entry: a record at a cost, and the least increase of the estimated cost by its placements not yet generated.
#[derive(Debug, Clone, Copy)]
struct WalkEntry {
    record: u32,
    cost: u64,
    estimate_increase: u64,
}

/// The starts not yet generated, if any grasp may start.
#[derive(Debug, Clone, Copy)]
struct Starts {
    /// Remaining reconfigurations of the next ones.
    gaits: u32,
    /// Index of the first chain not yet examined for this number.
    from: usize,
    /// Least larger number among the chains examined; [`NEVER`] if none was seen.
    later: u32,
}

/// The search through one route.
#[derive(Debug)]
pub struct RouteWalk<'a, E> {
    course: &'a PreparedRoute,
    costs: RankedEntry,
    pub estimate: E,
    records: Vec<WalkRecord>,
    /// Index of a record by node, and by reconfigurations so far if these are limited.
    known: FxHashMap<(u64, u32), u32>,
    /// Fewest reconfigurations at which a node was expanded, if they are limited; later entries with as many or more are
    /// dominated.
    expanded: FxHashMap<u64, u32>,
    /// Open list, by estimated total cost, then by remaining cost.
    open: BTreeMap<(u64, u64), Vec<WalkEntry>>,
    starts: Option<Starts>,
    /// For each leg, the number of steps of all legs after it.
    behind: Vec<u64>,
    goal: Option<u32>,
}

/// Queue entry that represents the remaining starts.
const STARTS: WalkEntry = WalkEntry { record: u32::MAX, cost: 0, estimate_increase: 0 };

impl<'a, E: Estimate> RouteWalk<'a, E> {
    /// A walk from one node.
    pub fn at(course: &'a PreparedRoute, costs: RankedEntry, estimate: E, start: NodeSpot) -> Self {
        let mut walk = RouteWalk::new(course, costs, estimate);
        walk.meet(start, 0, NO_PARENT);
        walk
    }

    /// A walk from any node at the start angle.
    pub fn anywhere(course: &'a PreparedRoute, costs: RankedEntry, estimate: E) -> Self {
        let mut walk = RouteWalk::new(course, costs, estimate);
        walk.queue_starts(Starts { gaits: 0, from: 0, later: NEVER });
        walk
    }

    fn new(course: &'a PreparedRoute, costs: RankedEntry, estimate: E) -> Self {
        let steps = |leg: usize| course.legs[leg].start.abs_diff(course.legs[leg].end) as u64;
        let behind = (0..course.legs.len()).map(|leg| (leg + 1..course.legs.len()).map(steps).sum()).collect();
        let (known, expanded, open) = (FxHashMap::default(), FxHashMap::default(), BTreeMap::new());
        RouteWalk {
            course,
            costs,
            estimate,
            records: Vec::new(),
            known,
            expanded,
            open,
            starts: None,
            behind,
            goal: None,
        }
    }

    /// Continues while the estimated cost is at most a limit.
    pub fn advance(&mut self, limit: u64, meter: &mut Meter) -> WalkProgress {
        loop {
            let Some((key, entry)) = self.pop(limit) else {
                return self
                    .open
                    .first_key_value()
                    .map_or(WalkProgress::Exhausted, |((cost, _), _)| WalkProgress::AtLeast(*cost));
            };
            if self.course.looks.are_spent() {
                return WalkProgress::Spent(key.0);
            }
            if entry.record == STARTS.record {
                self.begin();
                continue;
            }
            let record = self.records[entry.record as usize];
            if record.cost != entry.cost {
                continue;
            }
            let spot = NodeSpot::unpack(record.spot);
            if entry.estimate_increase == 0 && (self.is_covered(record) || !self.is_due(spot, key.1, entry)) {
                continue;
            }
            if entry.estimate_increase == 0 && self.course.is_goal(spot) {
                self.goal = Some(entry.record);
                return WalkProgress::Found(entry.cost);
            }
            if meter.step().is_none() {
                self.open.entry(key).or_default().push(entry);
                return WalkProgress::Spent(key.0);
            }
            if self.course.most_gaits.is_some() && entry.estimate_increase == 0 {
                self.expanded.insert(record.spot, gaits_of(entry.cost));
            }
            let (estimated, to_go) = key;
            self.expand(spot, entry, estimated, to_go);
        }
    }

    fn pop(&mut self, limit: u64) -> Option<((u64, u64), WalkEntry)> {
        loop {
            let mut first = self.open.first_entry().filter(|first| first.key().0 <= limit)?;
            match first.get_mut().pop() {
                Some(entry) => return Some((*first.key(), entry)),
                None => drop(first.remove()),
            }
        }
    }

    /// Whether a node's estimate is still that of its queue entry, and final; if not, it is queued again.
    fn is_due(&mut self, spot: NodeSpot, queued: u64, entry: WalkEntry) -> bool {
        let to_go = self.to_go(spot, entry.cost);
        if to_go == Some(queued) && self.estimate.is_settled(spot) {
            return true;
        }
        if to_go == Some(queued) {
            self.estimate.deepen();
        }
        if let Some(to_go) = self.to_go(spot, entry.cost) {
            self.open.entry((entry.cost + to_go, to_go)).or_default().push(entry);
        }
        false
    }

    /// Whether, under a limit, a node was expanded with no more reconfigurations, and thus at no more cost.
    fn is_covered(&self, record: WalkRecord) -> bool {
        self.expanded.get(&record.spot).is_some_and(|gaits| *gaits <= gaits_of(record.cost))
    }

    /// h of a node reached at a cost; `None` if no goal is reachable within the limit.
    #[inline]
    fn to_go(&self, spot: NodeSpot, cost: u64) -> Option<u64> {
        let gaits = self.estimate.gaits(spot);
        let steps = self.course.legs[spot.leg].end.abs_diff(spot.angle) as u64 + self.behind[spot.leg];
        let rolling = 2 * self.costs.roll * steps;
        let is_within =
            gaits != NEVER && self.course.most_gaits.is_none_or(|most| gaits.saturating_add(gaits_of(cost)) <= most);
        is_within.then(|| rolling + self.costs.gait * u64::from(gaits))
    }

    /// Queues a node, unless it is known at this cost or less.
    fn meet(&mut self, spot: NodeSpot, cost: u64, parent: u32) {
        let Some(to_go) = self.to_go(spot, cost) else { return };
        let number = spot.pack();
        let next = self.records.len() as u32;
        let counted = self.course.most_gaits.map_or(0, |_| gaits_of(cost));
        let record = *self.known.entry((number, counted)).or_insert(next);
        if record == next {
            self.records.push(WalkRecord { spot: number, cost, parent });
        } else if self.records[record as usize].cost <= cost {
            return;
        } else {
            self.records[record as usize] = WalkRecord { spot: number, cost, parent };
        }
        self.open.entry((cost + to_go, to_go)).or_default().push(WalkEntry { record, cost, estimate_increase: 0 });
    }

    /// Generates the neighbours; of the many placements only those with the entry's increase, and queues the node again for those with
    /// a larger one.
    fn expand(&mut self, spot: NodeSpot, entry: WalkEntry, estimated: u64, to_go: u64) {
        self.course.looks.take(4 * LOOKS);
        if entry.estimate_increase == 0 {
            self.roll(spot, entry);
            if let Some(next) = self.course.next(spot) {
                self.meet(next, entry.cost, entry.record);
            }
        }
        if !self.course.sets.is_pair(spot.chain.set) {
            return self.leave(spot, entry);
        }
        let mut expansion = PlacementExpansion { entry, to_go, next: u64::MAX };
        self.place(spot, &mut expansion);
        if expansion.next != u64::MAX {
            let later = estimated + (expansion.next - entry.estimate_increase);
            self.open.entry((later, to_go)).or_default().push(WalkEntry { estimate_increase: expansion.next, ..entry });
        }
    }

    #[inline]
    fn offer(&mut self, spot: NodeSpot, edge: u64, expansion: &mut PlacementExpansion) {
        let Some(to_go) = self.to_go(spot, expansion.entry.cost + edge) else { return };
        let estimate_increase = (edge + to_go).saturating_sub(expansion.to_go);
        if estimate_increase == expansion.entry.estimate_increase {
            if self.course.legs[spot.leg].lazy.is_some() && !self.course.holds(spot) {
                return;
            }
            self.meet(spot, expansion.entry.cost + edge, expansion.entry.record);
        } else if estimate_increase > expansion.entry.estimate_increase {
            expansion.next = expansion.next.min(estimate_increase);
        }
    }

    fn roll(&mut self, spot: NodeSpot, entry: WalkEntry) {
        let prepared = &self.course.legs[spot.leg];
        let phases = spot.chain.phases;
        let head = prepared.strands.head(phases[0]);
        let (bits, strand, fingers) = if self.course.sets.is_pair(spot.chain.set) {
            (&prepared.strands.roll_pair, prepared.strands.pair(head, [phases[0], phases[1]]), 2)
        } else {
            (&prepared.strands.roll_triple, prepared.strands.triple(head, phases), 3)
        };
        let cost = entry.cost + fingers * self.costs.roll;
        let up = spot.angle + 1 < prepared.angles && bits.has(strand, head.bit + spot.angle);
        let down = spot.angle > 0 && bits.has(strand, head.bit + spot.angle - 1);
        let bears_on = |angle: usize| {
            let (contacts, count) = self.course.held(NodeSpot { angle, ..spot });
            prepared.bears_on(angle, &contacts[..count])
        };
        let [up, down] = [up && bears_on(spot.angle), down && bears_on(spot.angle - 1)];
        if up {
            self.meet(NodeSpot { angle: spot.angle + 1, ..spot }, cost, entry.record);
        }
        if down {
            self.meet(NodeSpot { angle: spot.angle - 1, ..spot }, cost, entry.record);
        }
    }

    fn place(&mut self, spot: NodeSpot, expansion: &mut PlacementExpansion) {
        let course = self.course;
        let prepared = &course.legs[spot.leg];
        let [p, q, _] = spot.chain.phases;
        let head = prepared.strands.head(p);
        let row = prepared.strands.triple(head, [p, q, p]);
        course.looks.take(LOOKS * prepared.contacts as u64);
        for two in 0..prepared.contacts {
            if !prepared.strands.place.has(row + two, head.bit + spot.angle) {
                continue;
            }
            let third = wrapped(usize::from(p) + two, prepared.contacts) as u16;
            for (set, place) in course.sets.wider(spot.chain.set) {
                let chain = GraspChain { set: *set, phases: inserted([p, q], third, *place) };
                self.offer(NodeSpot { chain, ..spot }, self.costs.gait, expansion);
            }
        }
    }

    fn leave(&mut self, spot: NodeSpot, entry: WalkEntry) {
        let course = self.course;
        let strands = &course.legs[spot.leg].strands;
        for place in 0..3 {
            let ([p, q], third) = removed(spot.chain.phases, place);
            let head = strands.head(p);
            let prepared = &course.legs[spot.leg];
            let held = [p, q, third].map(|phase| prepared.contact(spot.angle, phase));
            let may_leave = strands.leave.has(strands.triple(head, [p, q, third]), head.bit + spot.angle);
            if may_leave && prepared.lets_go(spot.angle, held) {
                let chain = GraspChain { set: course.sets.without(spot.chain.set, place), phases: [p, q, 0] };
                self.meet(NodeSpot { chain, ..spot }, entry.cost + self.costs.gait, entry.record);
            }
        }
    }

    fn queue_starts(&mut self, starts: Starts) {
        let rolling = 2 * self.costs.roll * (self.behind[0] + self.first_steps());
        let estimated = rolling + self.costs.gait * u64::from(starts.gaits);
        self.starts = Some(starts);
        // Last among its equals: another start is generated only when all nodes of this cost are expanded.
        self.open.entry((estimated, u64::MAX)).or_default().push(STARTS);
    }

    fn first_steps(&self) -> u64 {
        self.course.legs[0].start.abs_diff(self.course.legs[0].end) as u64
    }

    /// Generates the next start, and queues those after it.
    fn begin(&mut self) {
        let Some(starts) = self.starts.take() else { return };
        let prepared = &self.course.legs[0];
        let chains = self.course.sets.chains(prepared.contacts) as usize;
        let mut later = starts.later;
        for number in starts.from..chains {
            self.course.looks.take(1);
            if self.course.looks.are_spent() {
                // The looks are spent: nothing is known of the starts from here on.
                return self.queue_starts(Starts { from: number, later, ..starts });
            }
            let Some(spot) = self.start(number) else { continue };
            self.course.looks.take(TRIPLE_LOOKS);
            let mut gaits = self.estimate.gaits(spot);
            while gaits == starts.gaits && !self.estimate.is_settled(spot) {
                self.estimate.deepen();
                gaits = self.estimate.gaits(spot);
            }
            if gaits > starts.gaits {
                later = later.min(gaits);
            } else if gaits == starts.gaits && self.course.holds(spot) {
                self.meet(spot, 0, NO_PARENT);
                return self.queue_starts(Starts { from: number + 1, later, ..starts });
            }
        }
        if later != NEVER {
            // Bounds may have grown since; none of these starts has fewer.
            self.queue_starts(Starts { gaits: later, from: 0, later: NEVER });
        }
    }

    /// The start with this index, if it is a node according to the tables.
    fn start(&self, number: usize) -> Option<NodeSpot> {
        let prepared = &self.course.legs[0];
        let chain = self.course.sets.chain(prepared.contacts, number);
        let contacts = chain.phases.map(usize::from);
        let held = &contacts[..self.course.sets.members(chain.set).len()];
        prepared.holds(prepared.start, held).then(|| {
            let phases = contacts.map(|contact| prepared.phase(prepared.start, contact));
            let phases = if self.course.sets.is_pair(chain.set) { [phases[0], phases[1], 0] } else { phases };
            NodeSpot { leg: 0, angle: prepared.start, chain: GraspChain { phases, ..chain } }
        })
    }

    /// The nodes of the path found, from its start.
    pub fn way(&self) -> Vec<NodeSpot> {
        let mut spots = Vec::new();
        let mut at = self.goal;
        while let Some(record) = at {
            let record = self.records[record as usize];
            spots.push(NodeSpot::unpack(record.spot));
            at = Some(record.parent).filter(|parent| *parent != NO_PARENT);
        }
        spots.reverse();
        spots
    }
}

/// State of a node's placements during an expansion.
#[derive(Debug)]
struct PlacementExpansion {
    entry: WalkEntry,
    /// h of the node.
    to_go: u64,
    /// Least increase above the entry's.
    next: u64,
}
