//! Progress of the operations in an assay.
//!
//! A part performs its operations in order; each counts as done at the first beat at which it can. The part has passed
//! a stop once it is there; it has completed a stay once it has not left its cell for all beats of the stay; it has
//! merged with another once both are there and have completed everything before. A part that leaves the board is gone
//! as soon as it is at its exit; a droplet that is dispensed stays at the outlet from the beat in which it appears. A
//! droplet is mixed while it goes anticlockwise round its loop, one cell per beat, from the corner to the corner. It
//! is split in the beat in which the electrodes on both sides of it pull. An operation that comes after others begins
//! once those are done.

use super::mixing::{Loop, Mixing};
use super::parts::PartsOnBoard;
use super::stage::StepGoals;
use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayStop};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
use std::collections::{BTreeMap, BTreeSet};

/// A part's next task: a stop, with its work there.
#[derive(Debug)]
struct DueStop<'o> {
    cell: ElectrodeCell,
    /// The stop in the program, if it has one.
    stop: Option<&'o ElectrodeArrayStop>,
    beats: u64,
    with: Option<usize>,
    operation: &'o AssayOperation,
    /// Index of the operation in the assay, if this is its last stop.
    ends: Option<usize>,
    work: DueWork,
}

/// The work of a part at a stop.
#[derive(Debug, Clone, Copy)]
enum DueWork {
    /// Stays, or merges.
    Rest,
    Mix(Loop),
    /// Comes here as the other half goes to the opposite side.
    Split,
}

/// A droplet that is split in a beat.
#[derive(Debug, Clone, Copy)]
pub(super) struct JudgedSplit {
    pub part: usize,
    pub at: ElectrodeCell,
    /// Cell where it goes.
    pub to: ElectrodeCell,
    /// The new droplet, and the cell where that goes.
    pub half: usize,
    pub comes: ElectrodeCell,
}

/// Times of an operation, in beats: when the first of its parts was free for it, when all were where it takes place,
/// and when it was done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct OperationBeats {
    pub free: u64,
    pub arrival: u64,
    pub done: u64,
}

/// Progress of one part.
#[derive(Debug)]
struct PartTurn<'o> {
    due: Vec<DueStop<'o>>,
    done: usize,
    /// The beat since which it has been at its next stop.
    since: Option<u64>,
    /// The beats, from 1, of its last move, of its last act, and of the end of its last operation.
    moved: u64,
    acted: u64,
    free: u64,
    /// Its progress round the loop.
    mixing: Mixing,
    /// Whether it left an outlet before it was dispensed, or was on the board before that.
    is_spoilt: bool,
}

impl<'o> PartTurn<'o> {
    fn new(is_spoilt: bool) -> PartTurn<'o> {
        let mixing = Mixing::default();
        PartTurn { due: Vec::new(), done: 0, since: None, moved: 0, acted: 0, free: 0, mixing, is_spoilt }
    }

    fn next(&self) -> Option<&DueStop<'o>> {
        self.due.get(self.done)
    }
}

/// An operation that was not done, or a part that does not end where it should.
pub(super) struct MissedOperation<'o> {
    pub part: usize,
    pub operation: &'o AssayOperation,
    pub stop: Option<&'o ElectrodeArrayStop>,
    pub cell: ElectrodeCell,
    /// The beats that it must stay there.
    pub beats: u64,
    pub with: Option<usize>,
    /// Whether it is the split itself that is missed.
    pub is_split: bool,
}

/// An assay in progress.
#[derive(Debug)]
pub(super) struct JudgedAssay<'o> {
    pub goals: StepGoals,
    turns: BTreeMap<usize, PartTurn<'o>>,
    /// By outlet: the droplets that are not dispensed yet.
    outlets: BTreeMap<ElectrodeCell, BTreeSet<usize>>,
    /// Times of each operation, by its index; `None` until it is done.
    pub beats: Vec<Option<OperationBeats>>,
    /// Original cells of the parts without an operation that have moved, and the beat of their last move.
    pub homes: BTreeMap<usize, (ElectrodeCell, u64)>,
}

impl<'o> JudgedAssay<'o> {
    /// The assay before its first beat.
    pub fn new(operations: &'o [AssayOperation], facts: &ElectrodeArrayFacts, cells: &PartsOnBoard) -> JudgedAssay<'o> {
        let mut turns: BTreeMap<usize, PartTurn> = BTreeMap::new();
        for (place, operation) in operations.iter().enumerate() {
            for part in operation.parts() {
                let outlet = operation.stops.first().filter(|_| operation.comes).map(|stop| stop.cell);
                let start = cells[part].or(outlet);
                if start.is_none() && !turns.contains_key(&part) {
                    continue;
                }
                let is_there = operation.comes && cells[part].is_some();
                let turn = turns.entry(part).or_insert_with(|| PartTurn::new(is_there));
                let last = operation.stops.len().saturating_sub(1);
                let beats = operation.stay_ns.div_ceil(facts.step_ns);
                let with = operation.parts().find(|other| *other != part);
                let work = |corner: ElectrodeCell| match operation.mixes {
                    true => DueWork::Mix(Loop::new(corner, facts.mixer)),
                    false if operation.splits.is_some() => DueWork::Split,
                    false => DueWork::Rest,
                };
                for (nth, stop) in operation.stops.iter().enumerate() {
                    let cell = stop.cell;
                    let passed = DueStop {
                        cell,
                        stop: Some(stop),
                        beats: 0,
                        with: None,
                        operation,
                        ends: None,
                        work: DueWork::Rest,
                    };
                    turn.due.push(match nth == last {
                        true => DueStop { beats, with, ends: Some(place), work: work(cell), ..passed },
                        false => passed,
                    });
                }
                let here = turn.due.last().map(|due| due.cell).or(start);
                if let Some(cell) = here.filter(|_| operation.stops.is_empty()) {
                    let (stop, ends, work) = (None, Some(place), work(cell));
                    turn.due.push(DueStop { cell, stop, beats, with, operation, ends, work });
                }
            }
            if let Some(half) = operation.splits {
                let turn = turns.entry(half.part).or_insert_with(|| PartTurn::new(cells[half.part].is_some()));
                let (cell, work) = (half.cell, DueWork::Rest);
                turn.due.push(DueStop { cell, stop: None, beats: 0, with: None, operation, ends: None, work });
            }
        }
        let goals = StepGoals::new(operations.iter().flat_map(AssayOperation::all_parts));
        let mut outlets: BTreeMap<ElectrodeCell, BTreeSet<usize>> = BTreeMap::new();
        for operation in operations.iter().filter(|operation| operation.comes) {
            if let Some(outlet) = operation.stops.first() {
                outlets.entry(outlet.cell).or_default().insert(operation.part);
            }
        }
        JudgedAssay { goals, turns, outlets, beats: vec![None; operations.len()], homes: BTreeMap::new() }
    }

    /// The parts that are due to be dispensed at open outlets, by the cell of the outlet.
    pub fn due_from_outlets(
        &self,
        cells: &PartsOnBoard,
        is_open: impl Fn(ElectrodeCell) -> bool,
    ) -> BTreeMap<ElectrodeCell, Vec<usize>> {
        let is_due = |part: &usize, outlet: ElectrodeCell| {
            let next = self.turns.get(part).and_then(PartTurn::next);
            let next = next.filter(|next| next.operation.comes && cells[*part].is_none() && next.cell == outlet);
            next.is_some_and(|next| self.begins(next).is_some())
        };
        let open = self.outlets.iter().filter(|(outlet, _)| is_open(**outlet));
        let due = open.map(|(outlet, parts)| {
            let due = parts.iter().copied().filter(|part| is_due(part, *outlet));
            (*outlet, due.collect::<Vec<usize>>())
        });
        due.filter(|(_, parts)| !parts.is_empty()).collect()
    }

    /// Notes that a part is dispensed in the beat after `beats` beats.
    pub fn come(&mut self, part: usize, beats: u64) {
        self.turns.entry(part).and_modify(|turn| (turn.since, turn.free) = (Some(beats), beats));
        self.outlets.values_mut().for_each(|waiting| {
            waiting.remove(&part);
        });
    }

    /// The droplets that are due to split and are at their cell of splitting.
    pub fn due_to_split(&self, cells: &PartsOnBoard) -> Vec<JudgedSplit> {
        let due = |(part, turn): (usize, &PartTurn)| {
            let next = turn.next().filter(|next| matches!(next.work, DueWork::Split) && self.begins(next).is_some())?;
            let (half, at) = (next.operation.splits?, next.operation.stops.first()?.cell);
            let is_due = cells[part] == Some(at) && cells[half.part].is_none() && !turn.is_spoilt;
            is_due.then_some(JudgedSplit { part, at, to: next.cell, half: half.part, comes: half.cell })
        };
        self.there(cells).filter_map(due).collect()
    }

    /// Notes that a droplet was split in the beat before this one.
    pub fn split(&mut self, split: &JudgedSplit, beat: u64) {
        let Some(turn) = self.turns.get_mut(&split.part) else { return };
        if let Some(place) = turn.next().and_then(|due| due.ends) {
            let arrival = turn.moved.max(turn.free);
            self.beats[place] = Some(OperationBeats { free: turn.free, arrival, done: beat });
        }
        (turn.done, turn.acted, turn.free, turn.since) = (turn.done + 1, beat, beat, None);
        self.turns.entry(split.half).and_modify(|turn| (turn.acted, turn.free) = (beat, beat));
    }

    /// Notes that a part has moved in the beat before this one.
    pub fn arrive(&mut self, part: usize, from: ElectrodeCell, beat: u64) {
        match self.turns.get_mut(&part) {
            Some(turn) => {
                turn.moved = beat;
                turn.mixing.come_from(from, beat);
            }
            None => self.homes.entry(part).or_insert((from, beat)).1 = beat,
        }
    }

    /// Progress of the parts that are on the board; only these can act.
    fn there(&self, cells: &PartsOnBoard) -> impl Iterator<Item = (usize, &PartTurn<'o>)> {
        cells.iter().filter_map(|(part, _)| Some((part, self.turns.get(&part)?)))
    }

    /// Completes everything that is done after `beat` beats, with the parts at these cells. Parts that have merged or
    /// left are removed from `cells`.
    pub fn settle(&mut self, beat: u64, cells: &mut PartsOnBoard) {
        let parts: Vec<usize> = self.there(cells).map(|(part, _)| part).collect();
        let done = |assay: &JudgedAssay| -> usize {
            parts.iter().filter_map(|part| assay.turns.get(part)).map(|turn| turn.done).sum()
        };
        loop {
            let before = done(self);
            for part in &parts {
                self.settle_one(*part, beat, cells);
            }
            if done(self) == before {
                break;
            }
        }
        let pairs = self.there(cells).filter_map(|(part, turn)| {
            let due = turn.next().filter(|due| self.begins(due).is_some())?;
            self.is_next(due.with?, due).then_some((part, (due.with?, due.cell)))
        });
        let pairs = pairs.collect();
        self.goals.pairs = pairs;
    }

    /// The beat after which all operations before this one were done; `None` until they are.
    fn begins(&self, due: &DueStop) -> Option<u64> {
        // Intermediate stops wait for nothing.
        let before = due.operation.after.iter().filter(|_| due.ends.is_some());
        before.map(|earlier| Some((*self.beats.get(*earlier)?)?.done)).try_fold(0, |last, done| Some(last.max(done?)))
    }

    /// Whether the next task of a part is this same merge.
    fn is_next(&self, part: usize, due: &DueStop) -> bool {
        let next = self.turns.get(&part).and_then(PartTurn::next);
        next.is_some_and(|next| std::ptr::eq(next.operation, due.operation) && next.with.is_some())
    }

    fn settle_one(&mut self, part: usize, beat: u64, cells: &mut PartsOnBoard) {
        let Some(turn) = self.turns.get(&part) else { return };
        let Some(due) = turn.next() else { return };
        let begins = self.begins(due);
        match due.work {
            DueWork::Mix(around) if !turn.is_spoilt => {
                if let Some(begins) = begins {
                    self.mix(part, around, begins, beat, cells[part]);
                }
                return;
            }
            DueWork::Split => return,
            DueWork::Rest | DueWork::Mix(_) => (),
        }
        if cells[part] != Some(due.cell) || turn.is_spoilt {
            let is_spoilt = turn.is_spoilt || (due.operation.comes && cells[part].is_some());
            self.turns.entry(part).and_modify(|turn| (turn.since, turn.is_spoilt) = (None, is_spoilt));
            return;
        }
        if begins.is_none() {
            return;
        }
        let since = turn.since.unwrap_or(beat);
        let (beats, with, ends) = (due.beats, due.with, due.ends);
        let leaves = due.operation.leaves && ends.is_some();
        let gone = due.operation.with.filter(|_| with.is_some()).or(leaves.then_some(part));
        let is_together = with.is_none_or(|other| cells[other] == Some(due.cell) && self.is_next(other, due));
        let is_done = beat - since >= beats && is_together;
        if let Some(place) = ends.filter(|_| is_done) {
            let free = std::iter::once(part).chain(with).filter_map(|own| self.turns.get(&own)).map(|turn| turn.free);
            let arrival = if with.is_some() { beat } else { since };
            self.beats[place] = Some(OperationBeats { free: free.min().unwrap_or(beat), arrival, done: beat });
        }
        for own in std::iter::once(part).chain(with.filter(|_| is_done)) {
            self.turns.entry(own).and_modify(|turn| {
                turn.since = Some(since).filter(|_| !is_done);
                if is_done {
                    (turn.done, turn.acted) = (turn.done + 1, beat);
                    turn.free = if ends.is_some() { beat } else { turn.free };
                }
            });
        }
        if let Some(gone) = gone.filter(|_| is_done) {
            cells.remove(gone);
        }
    }

    /// As [`Self::settle_one`], for a part that is due to be mixed.
    fn mix(&mut self, part: usize, around: Loop, begins: u64, beat: u64, cell: Option<ElectrodeCell>) {
        let Some(turn) = self.turns.get_mut(&part) else { return };
        let acted = turn.acted.max(begins);
        let Some(due) = turn.due.get(turn.done) else { return };
        let (beats, ends) = (due.beats, due.ends);
        let Some(cell) = cell else { return };
        let Some(since) = turn.mixing.since(around, cell, acted, beat) else { return };
        if beat - since < beats || cell != around.corner {
            return;
        }
        let free = turn.free;
        (turn.done, turn.acted, turn.free, turn.since) = (turn.done + 1, beat, beat, None);
        turn.mixing = Mixing::default();
        if let Some(place) = ends {
            self.beats[place] = Some(OperationBeats { free, arrival: since, done: beat });
        }
    }

    /// The operations that began too many beats after the operations of their `within`, each with the end of the last
    /// of those and its own beginning, in beats.
    pub fn late(&self, operations: &'o [AssayOperation], beat_ns: u64) -> Vec<(&'o AssayOperation, [u64; 2])> {
        let begun = |(operation, beats): (&AssayOperation, &Option<OperationBeats>)| {
            let beats = (*beats)?;
            // A split begins with the beat in which the droplet is pulled apart.
            Some(if operation.splits.is_some() { beats.done.saturating_sub(1) } else { beats.arrival })
        };
        let late = |(operation, beats): (&'o AssayOperation, &Option<OperationBeats>)| {
            let within = operation.within.as_ref()?;
            let ends: Option<Vec<u64>> = within.of.iter().map(|of| Some((*self.beats.get(*of)?)?.done)).collect();
            let (last, begins) = (ends?.into_iter().max()?, begun((operation, beats))?);
            let is_late = begins.saturating_sub(last).saturating_mul(beat_ns) > within.most_ns;
            is_late.then_some((operation, [last, begins]))
        };
        operations.iter().zip(&self.beats).filter_map(late).collect()
    }

    /// Sum over the parts of the beats until their last arrival.
    pub fn cost(&self) -> u64 {
        let moved = self.turns.values().map(|turn| turn.moved).chain(self.homes.values().map(|(_, beat)| *beat));
        moved.fold(0, u64::saturating_add)
    }

    /// The beats until the last operation was done and the last part had returned home.
    pub fn end(&self) -> u64 {
        let turns = self.turns.values().map(|turn| turn.acted.max(turn.moved));
        turns.chain(self.homes.values().map(|(_, beat)| *beat)).max().unwrap_or(0)
    }

    /// For each part the first operation that was not done, or its last stop if it ends elsewhere.
    pub fn missed(&self, cells: &PartsOnBoard) -> Vec<MissedOperation<'o>> {
        let missed = |(part, turn): (&usize, &PartTurn<'o>)| {
            let strays = || turn.due.last().filter(|last| cells[*part].is_some_and(|cell| cell != last.cell));
            let due = turn.next().or_else(strays)?;
            // Of the two parts of a split, the one that should be split is reported.
            if due.operation.splits.is_some_and(|half| half.part == *part) && cells[*part].is_none() {
                return None;
            }
            let DueStop { cell, stop, beats, with, operation, work, .. } = *due;
            let is_split = matches!(work, DueWork::Split);
            Some(MissedOperation { part: *part, operation, stop, cell, beats, with, is_split })
        };
        self.turns.iter().filter_map(missed).collect()
    }
}
