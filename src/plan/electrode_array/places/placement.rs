//! Chooses places for operations by a relaxed schedule, which ignores conflicts on the way.
//!
//! List scheduling with left-edge placement: among the operations whose parts are free, the one that can begin first,
//! or the most urgent one, is scheduled next, at the place where it can begin first; ties go to the nearest. A part
//! keeps its place until it leaves for another one, and a reservoir dispenses as late as possible. Each path takes as
//! long as it does alone; the planner has to resolve conflicts later. Method: at first the urgency of an operation is
//! the time of everything after it; then local search changes the urgency of one part at a time at random, and keeps
//! the change if the schedule is no longer than before.

use super::critical_path::{BoardWays, TimedOperation};
use crate::claims::electrode_array::AssayOperation;
use crate::plan::electrode_array::board::CellIndex;
use crate::plan::electrode_array::stage;
use crate::random::SplitMix64;
use std::collections::BTreeMap;

/// Most operations considered for the next turn: the most urgent ones.
const MAX_NEXT: usize = 200;

/// Approximate limit on place searches for operations, in all draws of one schedule together.
const MAX_PLACE_SEARCHES: usize = 400_000;

/// Most consecutive draws without a shorter schedule.
const MAX_IDLE_DRAWS: usize = 200;

/// A relaxed schedule: it ignores conflicts on the way.
#[derive(Debug, Clone)]
pub(super) struct RelaxedSchedule {
    /// By operation: its chosen cell, if it has several places.
    pub cells: Vec<Option<CellIndex>>,
    /// By operation: the instant at which it begins.
    pub begins: Vec<u64>,
    /// The end of the last operation.
    pub end: u64,
    /// Number of place searches.
    searches: usize,
}

impl RelaxedSchedule {
    /// By agent and errand: the instant at which its operation begins; 0 if it has none.
    pub fn of(&self, operations: &[Vec<Option<usize>>]) -> Vec<Vec<u32>> {
        let begin = |nth: &Option<usize>| nth.map_or(0, |nth| u32::try_from(self.begins[nth]).unwrap_or(u32::MAX));
        operations.iter().map(|own| own.iter().map(begin).collect()).collect()
    }
}

/// Rule for the next operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PriorityRule {
    /// The one that can begin first.
    EarliestBegin,
    /// The most urgent one among those that can begin before the first of their places would be free again.
    MostUrgent,
}

/// Where a dispensed droplet waits until it is needed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum DropletWait {
    /// At the outlet, which blocks the next droplets.
    AtOutlet,
    /// Anywhere on the board, which is assumed to have room for all.
    OnBoard,
}

/// Terms of a relaxed schedule.
#[derive(Debug, Clone, Copy)]
pub(super) struct RelaxedTerms {
    pub seed: u64,
    /// Lower bound on its end; a schedule that meets it ends the search.
    pub least: u64,
    pub wait: DropletWait,
}

/// Schedules all operations, with random changes from a seed.
pub(super) fn schedule(
    operations: &[AssayOperation],
    timed: &[TimedOperation],
    ways: &mut BoardWays,
    RelaxedTerms { seed, least, wait }: RelaxedTerms,
) -> RelaxedSchedule {
    let mut urgency: Vec<u64> = timed.iter().map(|one| one.tail() + one.stay).collect();
    let occupied = occupied(timed);
    let mut draw =
        |urgency: &[u64], rule| RelaxedScheduler::new(operations, timed, ways, urgency, &occupied, wait).drawn(rule);
    let mut rule = PriorityRule::EarliestBegin;
    let mut best = draw(&urgency, rule);
    let other = draw(&urgency, PriorityRule::MostUrgent);
    let mut searches = best.searches + other.searches;
    if other.end < best.end {
        (best, rule) = (other, PriorityRule::MostUrgent);
    }
    let most = urgency.iter().max().copied().unwrap_or(0);
    let mut random = SplitMix64::new(seed);
    let mut idle = 0;
    while best.end > least && searches < MAX_PLACE_SEARCHES && idle < MAX_IDLE_DRAWS {
        let (part, now) = (operations[random.below(operations.len())].part, random.below(most as usize + 1) as u64);
        let mut changed = urgency.clone();
        for (own, _) in changed.iter_mut().zip(operations).filter(|(_, operation)| operation.part == part) {
            *own = now;
        }
        let rules = [rule, PriorityRule::MostUrgent, PriorityRule::EarliestBegin];
        let rule_now = rules[random.below(rules.len())];
        let found = draw(&changed, rule_now);
        searches += found.searches;
        idle = if found.end < best.end { 0 } else { idle + 1 };
        if found.end <= best.end {
            (best, urgency, rule) = (found, changed, rule_now);
        }
    }
    best
}

/// For each operation, the steps for which it and its successors at the same place keep that place.
fn occupied(timed: &[TimedOperation]) -> Vec<u64> {
    let mut occupied: Vec<u64> = timed.iter().map(|one| one.stay).collect();
    for (nth, one) in timed.iter().enumerate().rev() {
        let before = one.before.first().filter(|before| one.stops.is_empty() && before.at.is_none());
        if let Some(earlier) = before.and_then(|before| before.operation) {
            occupied[earlier] += occupied[nth];
        }
    }
    occupied
}

/// A part, with its cell from an instant on.
#[derive(Debug, Clone, Copy)]
struct ScheduledPart {
    at: CellIndex,
    since: u64,
    /// The dispensing by which it enters there, if that has not begun.
    enters_by: Option<usize>,
}

/// Use of a place.
#[derive(Debug, Clone, Copy, Default)]
struct PlaceUse {
    /// The part that is there until it leaves.
    by: Option<usize>,
    /// The instant from which the next part can be there, once the place is free.
    free: u64,
}

/// Place and instant at which an operation can begin.
#[derive(Debug, Clone, Copy)]
struct OperationBegin {
    cell: CellIndex,
    begin: u64,
    /// Travel steps of its parts, in total.
    way: u64,
    /// Whether another part is there that must leave first.
    is_taken: bool,
}

struct RelaxedScheduler<'a, 'w, 'm> {
    operations: &'a [AssayOperation],
    timed: &'a [TimedOperation],
    urgency: &'a [u64],
    /// By operation: the steps for which it and its successors at the same place keep that place.
    occupied: &'a [u64],
    ways: &'a mut BoardWays<'w, 'm>,
    /// By operation: number of operations that it waits for, and the operations that wait for it.
    waits: Vec<usize>,
    followers: Vec<Vec<usize>>,
    /// Operations that wait for none, the most urgent first.
    due: Vec<usize>,
    parts: Vec<Option<ScheduledPart>>,
    places: BTreeMap<CellIndex, PlaceUse>,
    ends: Vec<Option<u64>>,
    cells: Vec<Option<CellIndex>>,
    wait: DropletWait,
    /// If droplets wait on the board: by outlet, the instants `from..to` from the start of a dispensing until the
    /// outlet is clear.
    dispensing: BTreeMap<CellIndex, Vec<(u64, u64)>>,
    /// Changeover: steps between two droplets at a place.
    change: u64,
}

impl<'a, 'w, 'm> RelaxedScheduler<'a, 'w, 'm> {
    fn new(
        operations: &'a [AssayOperation],
        timed: &'a [TimedOperation],
        ways: &'a mut BoardWays<'w, 'm>,
        urgency: &'a [u64],
        occupied: &'a [u64],
        wait: DropletWait,
    ) -> RelaxedScheduler<'a, 'w, 'm> {
        let (order, count) = (ways.site.order, operations.len());
        let (mut waits, mut followers) = (vec![0; count], vec![Vec::new(); count]);
        for (nth, (operation, one)) in operations.iter().zip(timed).enumerate() {
            let before = one.before.iter().filter_map(|before| before.operation);
            for earlier in before.chain(operation.after.iter().copied()) {
                waits[nth] += 1;
                followers[earlier].push(nth);
            }
        }
        let flat = |cell| stage::flat(order, cell);
        let part = |cell| ScheduledPart { at: flat(cell), since: 0, enters_by: None };
        let parts: Vec<Option<ScheduledPart>> = ways.site.cells.iter().map(|cell| cell.map(part)).collect();
        let there = |(nth, part): (usize, &Option<ScheduledPart>)| {
            Some((part.as_ref()?.at, PlaceUse { by: Some(nth), free: 0 }))
        };
        let places = parts.iter().enumerate().filter_map(there).collect();
        let change = u64::from(order.facts.separation.apart()) + 1;
        let (due, ends, cells) = (Vec::new(), vec![None; count], vec![None; count]);
        let mut scheduler = RelaxedScheduler {
            operations,
            timed,
            urgency,
            occupied,
            ways,
            waits,
            followers,
            due,
            parts,
            places,
            ends,
            cells,
            wait,
            dispensing: BTreeMap::new(),
            change,
        };
        (0..count)
            .filter(|nth| scheduler.waits[*nth] == 0)
            .collect::<Vec<usize>>()
            .into_iter()
            .for_each(|nth| scheduler.ready(nth));
        scheduler
    }

    /// Draws the whole schedule.
    fn drawn(mut self, rule: PriorityRule) -> RelaxedSchedule {
        let mut searches = 0;
        loop {
            searches += self.due.len().clamp(1, MAX_NEXT);
            match self.next(rule) {
                Some((nth, place)) => self.take(nth, place),
                None if self.dispense() => {}
                None => break,
            }
        }
        let begin = |(end, one): (&Option<u64>, &TimedOperation)| end.unwrap_or(0).saturating_sub(one.stay);
        let begins = self.ends.iter().zip(self.timed).map(begin).collect();
        let end = self.ends.iter().flatten().copied().max().unwrap_or(0);
        RelaxedSchedule { cells: self.cells, begins, end, searches }
    }

    /// Handles an operation that waits for no other. A dispensing is postponed until its droplet is needed.
    fn ready(&mut self, nth: usize) {
        let operation = &self.operations[nth];
        let next = self.followers[nth]
            .iter()
            .position(|next| self.operations[*next].parts().any(|part| part == operation.part));
        if let (true, Some(stop), Some(next)) = (operation.comes, operation.stops.first(), next) {
            let at = stage::flat(self.ways.site.order, stop.cell);
            self.parts[operation.part] = Some(ScheduledPart { at, since: 0, enters_by: Some(nth) });
            let next = self.followers[nth].swap_remove(next);
            self.is_done_for(next);
            return;
        }
        let to = self.due.partition_point(|other| self.urgency[*other] >= self.urgency[nth]);
        self.due.insert(to, nth);
    }

    /// Records that a predecessor of an operation is done.
    fn is_done_for(&mut self, nth: usize) {
        self.waits[nth] -= 1;
        if self.waits[nth] == 0 {
            self.ready(nth);
        }
    }

    /// The operation scheduled next, with its place; `None` when none is left.
    fn next(&mut self, rule: PriorityRule) -> Option<(usize, OperationBegin)> {
        let due: Vec<usize> = self.due.iter().take(MAX_NEXT).copied().collect();
        let mut begins: Vec<(usize, OperationBegin)> =
            due.into_iter().filter_map(|nth| Some((nth, self.begin(nth)?))).collect();
        if begins.iter().any(|(_, begin)| !begin.is_taken) {
            begins.retain(|(_, begin)| !begin.is_taken);
        }
        let before = begins.iter().map(|(nth, begin)| begin.begin + self.occupied[*nth]).min()?;
        match rule {
            PriorityRule::EarliestBegin => begins.into_iter().min_by_key(|(_, begin)| begin.begin),
            PriorityRule::MostUrgent => begins.into_iter().find(|(_, begin)| begin.begin <= before),
        }
    }

    /// The first instant at which an operation can begin, and its place.
    fn begin(&mut self, nth: usize) -> Option<OperationBegin> {
        let (operation, one) = (&self.operations[nth], &self.timed[nth]);
        let after = self.after(nth);
        let mut best: Option<OperationBegin> = None;
        let from: Vec<ScheduledPart> = operation.parts().filter_map(|part| self.there(part)).collect();
        let outlet = operation
            .stops
            .first()
            .filter(|_| operation.comes)
            .map(|stop| stage::flat(self.ways.site.order, stop.cell));
        let arrivals: Vec<(u64, Vec<(CellIndex, u64)>)> =
            from.iter().map(|part| (part.since, self.ways.through(&[(part.at, 0)], &one.stops))).collect();
        let cells: Vec<CellIndex> = match arrivals.first() {
            Some((_, reached)) => reached.iter().map(|(cell, _)| *cell).collect(),
            None => outlet.into_iter().collect(),
        };
        for cell in cells {
            let (mut begin, mut way) = (after, 0);
            for (since, reached) in &arrivals {
                let Some((_, steps)) = reached.iter().find(|(at, _)| *at == cell) else { continue };
                begin = begin.max(since + steps);
                way += steps;
            }
            let place = self.places.get(&cell).copied().unwrap_or_default();
            let is_taken = place.by.is_some_and(|by| !operation.parts().any(|part| part == by));
            if place.by.is_none() || is_taken {
                begin = begin.max(place.free);
            }
            let own = OperationBegin { cell, begin, way, is_taken };
            let key = |one: &OperationBegin| (one.is_taken, one.begin, one.way);
            if best.is_none_or(|best| key(&own) < key(&best)) {
                best = Some(own);
            }
        }
        best
    }

    /// The instant at which all predecessors of an operation are over.
    fn after(&self, nth: usize) -> u64 {
        self.operations[nth].after.iter().filter_map(|earlier| self.ends[*earlier]).max().unwrap_or(0)
    }

    /// Cell and instant from which a part can leave for an operation; a part that is still to be dispensed can do so
    /// once it is.
    fn there(&self, part: usize) -> Option<ScheduledPart> {
        let own = self.parts[part]?;
        let Some(dispensing) = own.enters_by else { return Some(own) };
        let since = match self.wait {
            DropletWait::AtOutlet => {
                let free = self.places.get(&own.at).map_or(0, |place| place.free);
                free.max(self.after(dispensing)) + self.timed[dispensing].stay
            }
            DropletWait::OnBoard => self.dispensed(own.at, dispensing, 0),
        };
        Some(ScheduledPart { since, ..own })
    }

    /// The last instant, no later than `latest`, at which a reservoir can have dispensed the droplet of an operation;
    /// if there is none, the first possible one.
    fn dispensed(&self, outlet: CellIndex, dispensing: usize, latest: u64) -> u64 {
        let booked = self.dispensing.get(&outlet).map_or([].as_slice(), Vec::as_slice);
        let (mut free, mut found) = (self.after(dispensing), None);
        for (from, to) in booked.iter().copied().chain([(u64::MAX, u64::MAX)]) {
            let first = free + self.timed[dispensing].stay;
            if first + self.change <= from {
                if found.is_some() && first > latest {
                    break;
                }
                found = Some(latest.min(from - self.change).max(first));
            }
            free = free.max(to);
        }
        found.unwrap_or(free)
    }

    /// Records the dispensing of a droplet that leaves the outlet at `left`, or as soon as possible after it.
    fn dispense_by(&mut self, outlet: CellIndex, dispensing: usize, left: u64) {
        match self.wait {
            DropletWait::AtOutlet => {
                self.places.insert(outlet, PlaceUse { by: None, free: left + self.change });
                self.done(dispensing, left);
            }
            DropletWait::OnBoard => {
                let end = self.dispensed(outlet, dispensing, left);
                let (from, to) = (end - self.timed[dispensing].stay, end + self.change);
                let booked = self.dispensing.entry(outlet).or_default();
                booked.insert(booked.partition_point(|other| other.0 < from), (from, to));
                self.done(dispensing, end);
            }
        }
    }

    /// Dispenses the first droplet whose dispensing was postponed, when nothing needs the droplet but others wait for
    /// the dispensing. Returns whether there was one.
    fn dispense(&mut self) -> bool {
        let Some(part) = self.parts.iter().position(|part| part.is_some_and(|part| part.enters_by.is_some())) else {
            return false;
        };
        let Some(own) = self.there(part) else { return false };
        self.put(part, own.at, own.since);
        own.enters_by.into_iter().for_each(|dispensing| self.done(dispensing, own.since));
        true
    }

    /// Schedules an operation at a place.
    fn take(&mut self, nth: usize, place: OperationBegin) {
        let (operation, stay) = (&self.operations[nth], self.timed[nth].stay);
        self.due.retain(|other| *other != nth);
        let end = place.begin + stay;
        for part in operation.parts() {
            let Some(own) = self.parts[part].take() else { continue };
            let to = self.ways.through(&[(own.at, 0)], &self.timed[nth].stops);
            let steps = to.iter().find(|(cell, _)| *cell == place.cell).map_or(0, |(_, steps)| *steps);
            let left = place.begin.saturating_sub(steps);
            match own.enters_by {
                Some(dispensing) => self.dispense_by(own.at, dispensing, left),
                None => {
                    self.places.insert(own.at, PlaceUse { by: None, free: left + self.change });
                }
            }
        }
        self.cells[nth] = (!operation.among.is_empty()).then_some(place.cell);
        if operation.leaves {
            self.places.insert(place.cell, PlaceUse { by: None, free: end + self.change });
        } else {
            self.put(operation.part, place.cell, end);
        }
        if let Some(half) = operation.splits {
            self.put(half.part, stage::flat(self.ways.site.order, half.cell), end);
        }
        self.done(nth, end);
    }

    fn put(&mut self, part: usize, at: CellIndex, since: u64) {
        self.parts[part] = Some(ScheduledPart { at, since, enters_by: None });
        self.places.insert(at, PlaceUse { by: Some(part), free: since + self.change });
    }

    fn done(&mut self, nth: usize, end: u64) {
        self.ends[nth] = Some(end);
        for next in std::mem::take(&mut self.followers[nth]) {
            self.is_done_for(next);
        }
    }
}
