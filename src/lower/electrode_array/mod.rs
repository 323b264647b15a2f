//! Lowers an electrode array's plan to electrodes that are on, on a clock of its own.
//!
//! Each step of the board has the device's step duration, and the electrodes of Table 2 of the paper are on during
//! all of it: two ahead of a moving micropart, the target itself for a droplet. If the device holds its parts, the
//! electrodes that brought a part to its cell stay on while it rests. An electrode that is on in two consecutive
//! steps is not switched between them. A shared channel is one switch with the name of its first electrode, on while
//! a part needs any of its electrodes. While a reservoir dispenses a droplet, its pads and the electrode at its
//! outlet are on according to the frames of the device.

mod operations;

use super::Lowered;
use super::clock::LoweredRun;
use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayAction, ElectrodeArrayOrder};
use crate::device::electrode_array::{
    DispenseFrame, DispenseSequence, ElectrodeArrayFacts, ElectrodeCell, Electrodes, Hold,
};
use crate::plan::Planned;
use crate::plan::electrode_array::{ElectrodeArrayMotion, ElectrodeArrayStepMotion, PartCourse};
use crate::schedule::electrode_array::ElectrodeArrayState;
use crate::schedule::{Actuation, ChannelUnit, PartCells, State, TimedState};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

impl Lowered for Planned<'_, ElectrodeArrayOrder, ElectrodeArrayMotion> {
    fn run(&self) -> Option<LoweredRun> {
        let Planned { order, motion } = self;
        let mut board = LoweringBoard::new(order, &motion.start);
        board.record(0);
        for (index, (step, motion)) in order.steps.iter().zip(&motion.steps).enumerate() {
            let start_ns = board.run.duration_ns;
            match motion {
                ElectrodeArrayStepMotion::Wait(duration_ns) => board.wait(*duration_ns, index)?,
                ElectrodeArrayStepMotion::Assay { operations, courses } => {
                    let paths: Vec<&[ElectrodeCell]> = courses.iter().map(|course| course.cells.as_slice()).collect();
                    board.follow(&board.step(index, paths, courses))?;
                    if let ElectrodeArrayAction::Assay(asked) = &step.action {
                        let timed = operations::timed(order, index, start_ns, asked, operations, courses);
                        board.run.operations.extend(timed);
                    }
                }
                ElectrodeArrayStepMotion::Paths(paths) => {
                    let paths: Vec<&[ElectrodeCell]> = paths.iter().map(Vec::as_slice).collect();
                    board.follow(&board.step(index, paths, &[]))?;
                    if let ElectrodeArrayAction::Move(moves) = &step.action {
                        board.merge(moves.iter().filter_map(|action| action.with));
                    }
                }
            }
            board.run.steps.push((step.span, start_ns, board.run.duration_ns - start_ns));
        }
        Some(board.run)
    }

    fn channels(&self, own: &mut dyn Iterator<Item = &LoweredRun>) -> Vec<(String, ChannelUnit)> {
        let names: BTreeSet<&str> = own.flat_map(|run| &run.channels).map(String::as_str).collect();
        let facts = &self.order.facts;
        let mut cells: Vec<ElectrodeCell> = names.iter().filter_map(|name| facts.electrode(name)).collect();
        cells.sort_by_key(|cell| (cell.row, cell.column));
        let pads: BTreeSet<u32> = names.iter().filter_map(|name| facts.pad(name)).collect();
        let cells = cells.into_iter().map(ElectrodeArrayFacts::channel);
        let all = cells.chain(pads.into_iter().map(ElectrodeArrayFacts::pad_channel));
        all.map(|name| (name, ChannelUnit::Volt)).collect()
    }
}

/// A switched electrode or pad; the order is that of the schedule.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum BoardSwitch {
    Electrode(ElectrodeCell),
    Pad(u32),
}

impl BoardSwitch {
    fn channel(self) -> String {
        match self {
            BoardSwitch::Electrode(cell) => ElectrodeArrayFacts::channel(cell),
            BoardSwitch::Pad(pad) => ElectrodeArrayFacts::pad_channel(pad),
        }
    }
}

/// State of the board while its plan is lowered.
struct LoweringBoard<'a> {
    order: &'a ElectrodeArrayOrder,
    run: LoweredRun,
    /// Cells of the parts on the board. Parts that have merged, left, or not yet come are not listed, since an assay
    /// may have many more parts than its board holds at once.
    cells: BTreeMap<usize, ElectrodeCell>,
    /// For each electrode that is not the first of its channel, the first one.
    firsts: BTreeMap<ElectrodeCell, ElectrodeCell>,
    /// The names of the parts in order, and by part its place there.
    names: Arc<[Arc<str>]>,
    ranks: Vec<u32>,
    /// Indices of the channels used so far.
    channels: BTreeMap<BoardSwitch, u32>,
}

/// A step of parts.
struct LoweredStep<'m> {
    /// Index of the step.
    nth: usize,
    /// By part: its cells.
    paths: Vec<&'m [ElectrodeCell]>,
    /// By part, in an assay: when it is on the board. Empty otherwise.
    courses: &'m [PartCourse],
    /// By part that is dispensed from a reservoir with pads: its sequence.
    dispensed: BTreeMap<usize, &'m DispenseSequence>,
}

impl<'m> LoweredStep<'m> {
    /// The instant at which a part is at its first cell.
    fn since(&self, part: usize) -> usize {
        self.courses.get(part).map_or(0, |course| course.since)
    }

    /// The cell of a part at an instant; the last one after its end.
    fn at(&self, part: usize, instant: usize) -> Option<ElectrodeCell> {
        let path = self.paths.get(part)?;
        path.get(instant.saturating_sub(self.since(part))).or(path.last()).copied()
    }

    /// The parts that come onto the board, from the last to the first, each with the instant before its first step.
    fn coming(&self) -> Vec<(usize, usize)> {
        let comes = |(part, course): (usize, &PartCourse)| match course.parent {
            // A droplet that is split off begins in a step of the board where the other one is.
            Some(_) => Some((course.since.checked_sub(1)?, part)),
            None => (course.until() > course.since + 1).then_some((course.since, part)),
        };
        let mut coming: Vec<(usize, usize)> = self.courses.iter().enumerate().filter_map(comes).collect();
        coming.sort_unstable_by(|one, other| other.cmp(one));
        coming
    }
}

/// For each electrode that is not the first of its channel, the first one.
fn firsts(facts: &ElectrodeArrayFacts) -> BTreeMap<ElectrodeCell, ElectrodeCell> {
    let channels = facts.map.iter().flat_map(|map| map.by_channel().into_values());
    let named = |cells: Vec<ElectrodeCell>| {
        let first = cells.first().copied();
        cells.into_iter().skip(1).filter_map(move |cell| Some((cell, first?)))
    };
    channels.flat_map(named).collect()
}

impl<'a> LoweringBoard<'a> {
    fn new(order: &'a ElectrodeArrayOrder, start: &[Option<ElectrodeCell>]) -> LoweringBoard<'a> {
        let mut by_name: Vec<usize> = (0..order.parts.len()).collect();
        by_name.sort_unstable_by_key(|part| &order.parts[*part].name);
        let names = by_name.iter().map(|part| order.parts[*part].name.as_str().into()).collect();
        let mut ranks = vec![0; by_name.len()];
        (0..).zip(by_name).for_each(|(rank, part)| ranks[part] = rank);
        let cells = start.iter().enumerate().filter_map(|(part, cell)| Some((part, (*cell)?))).collect();
        let (run, firsts, channels) = (LoweredRun::default(), firsts(&order.facts), BTreeMap::new());
        LoweringBoard { order, run, cells, firsts, names, ranks, channels }
    }

    /// Moves all parts through their cells, step by step of the board; in an assay, the courses determine which parts
    /// come and go.
    fn follow(&mut self, step: &LoweredStep) -> Option<()> {
        let until = |(part, path): (usize, &&[ElectrodeCell])| (step.since(part) + path.len()).saturating_sub(1);
        let instants = step.paths.iter().enumerate().map(until).max().unwrap_or(0);
        let mut coming = step.coming();
        // The switches that are on, with the instant since when.
        let mut on: BTreeMap<BoardSwitch, u64> = BTreeMap::new();
        if self.take_gone(step, 0) && instants == 0 {
            // No step of the board follows in which this would be recorded.
            self.record(self.run.duration_ns);
        }
        for instant in 0..instants {
            let start_ns = self.run.duration_ns;
            while let Some((_, part)) = coming.pop_if(|(at, _)| *at <= instant) {
                let parent = step.courses[part].parent;
                let cell = parent.map_or(step.at(part, instant), |parent| self.cells.get(&parent).copied());
                if let Some(cell) = cell {
                    self.cells.entry(part).or_insert(cell);
                }
            }
            let next = |part: &usize| Some((*part, step.at(*part, instant + 1)?));
            let next: BTreeMap<usize, ElectrodeCell> = self.cells.keys().filter_map(next).collect();
            let frames = self.frames(instant, step);
            let wanted = self.wanted(&next, &frames);
            self.switch(&mut on, &wanted, start_ns, step.nth);
            self.run.duration_ns = start_ns.checked_add(self.order.facts.step_ns)?;
            self.cells = next;
            self.take_gone(step, instant + 1);
            self.record(self.run.duration_ns);
        }
        self.switch(&mut on, &BTreeSet::new(), self.run.duration_ns, step.nth);
        Some(())
    }

    /// Takes the parts off the board that are gone after an instant; returns whether there are any.
    fn take_gone(&mut self, step: &LoweredStep, instant: usize) -> bool {
        let before = self.cells.len();
        let is_gone = |course: &PartCourse| course.is_gone && course.until() <= instant + 1;
        self.cells.retain(|part, _| !step.courses.get(*part).is_some_and(is_gone));
        self.cells.len() < before
    }

    /// Nothing moves; held parts stay held.
    fn wait(&mut self, duration_ns: u64, step: usize) -> Option<()> {
        let start_ns = self.run.duration_ns;
        self.run.duration_ns = start_ns.checked_add(duration_ns)?;
        if duration_ns > 0 {
            let mut on = self.wanted(&self.cells, &BTreeMap::new()).into_iter().map(|one| (one, start_ns)).collect();
            self.switch(&mut on, &BTreeSet::new(), self.run.duration_ns, step);
        }
        Some(())
    }

    /// The step of an assay, or of moves without courses.
    fn step<'m>(&self, nth: usize, paths: Vec<&'m [ElectrodeCell]>, courses: &'m [PartCourse]) -> LoweredStep<'m>
    where
        'a: 'm,
    {
        let sequence = |operation: &AssayOperation| {
            let reservoirs = self.order.facts.reservoirs.as_ref().filter(|_| operation.comes)?;
            Some((operation.part, reservoirs.at(operation.stops.first()?.cell)?))
        };
        let dispensed = match self.order.steps.get(nth).map(|step| &step.action) {
            Some(ElectrodeArrayAction::Assay(operations)) => operations.iter().filter_map(sequence).collect(),
            Some(ElectrodeArrayAction::Move(_) | ElectrodeArrayAction::Wait(_)) | None => BTreeMap::new(),
        };
        LoweredStep { nth, paths, courses, dispensed }
    }

    /// The frames of reservoirs at an instant of a step, by the parts that are being dispensed.
    fn frames<'m>(&self, instant: usize, step: &LoweredStep<'m>) -> BTreeMap<usize, &'m DispenseFrame> {
        let facts = &self.order.facts;
        let frame_ns = facts.reservoirs.as_ref().map_or(0, |reservoirs| reservoirs.frame_ns);
        let frame_steps = (frame_ns / facts.step_ns).max(1) as usize;
        let frame = |part: &usize| {
            let since = instant.checked_sub(step.since(*part))?;
            Some((*part, step.dispensed.get(part)?.frames.get(since / frame_steps)?))
        };
        self.cells.keys().filter_map(frame).collect()
    }

    /// The electrodes that move the parts to their next cells and hold resting parts; for a part that is being
    /// dispensed, its frame.
    fn wanted(
        &self,
        next: &BTreeMap<usize, ElectrodeCell>,
        frames: &BTreeMap<usize, &DispenseFrame>,
    ) -> BTreeSet<BoardSwitch> {
        let facts = &self.order.facts;
        let both = self.cells.iter().filter_map(|(part, from)| Some((*part, *from, *next.get(part)?)));
        let is_held = |part: usize| frames.get(&part).is_none_or(|frame| frame.outlet);
        let held = both.filter(|(part, ..)| is_held(*part)).flat_map(|(_, from, to)| electrodes(facts, from, to));
        let pads = frames.values().flat_map(|frame| frame.pads.iter().copied().map(BoardSwitch::Pad));
        let first = |cell: ElectrodeCell| self.firsts.get(&cell).copied().unwrap_or(cell);
        held.map(|cell| BoardSwitch::Electrode(first(cell))).chain(pads).collect()
    }

    /// Ends the actuations of electrodes that are no longer needed, and begins new ones.
    fn switch(
        &mut self,
        on: &mut BTreeMap<BoardSwitch, u64>,
        wanted: &BTreeSet<BoardSwitch>,
        now_ns: u64,
        step: usize,
    ) {
        let volts = self.order.facts.potential_v;
        let LoweredRun { channels: names, actuations, .. } = &mut self.run;
        let channels = &mut self.channels;
        on.retain(|switch, since_ns| {
            let stays = wanted.contains(switch);
            if !stays {
                let (start_ns, duration_ns) = (*since_ns, now_ns - *since_ns);
                let channel = *channels.entry(*switch).or_insert_with(|| {
                    names.push(switch.channel());
                    names.len() as u32 - 1
                });
                let (from, to, step) = (volts, volts, step as u32);
                actuations.push(Actuation { channel, start_ns, duration_ns, from, to, swing: None, step });
            }
            stays
        });
        for switch in wanted {
            on.entry(*switch).or_insert(now_ns);
        }
    }

    /// Removes parts that have merged.
    fn merge(&mut self, gone: impl Iterator<Item = usize>) {
        let mut merged = false;
        for part in gone {
            self.cells.remove(&part);
            merged = true;
        }
        if merged {
            self.run.states.pop();
            self.record(self.run.duration_ns);
        }
    }

    fn record(&mut self, t_ns: u64) {
        let here = self.cells.iter().map(|(part, cell)| (self.ranks[*part], cell.pair()));
        let mut here: Box<[(u32, [u32; 2])]> = here.collect();
        here.sort_unstable();
        let parts = PartCells::in_order(self.names.clone(), here);
        self.run.states.push(TimedState { t_ns, state: State::ElectrodeArray(ElectrodeArrayState { parts }) });
    }
}

/// The electrodes of one part in one step (Table 2 of the paper).
fn electrodes(facts: &ElectrodeArrayFacts, from: ElectrodeCell, to: ElectrodeCell) -> Vec<ElectrodeCell> {
    if from == to && facts.hold == Hold::Off {
        return Vec::new();
    }
    match facts.layout.electrodes {
        Electrodes::Single => vec![to],
        Electrodes::Quad => leading(from, to),
    }
}

/// The two electrodes under the leading electrodes of a micropart at the end of its move; empty if it rests, since it
/// rests without voltage.
fn leading(from: ElectrodeCell, to: ElectrodeCell) -> Vec<ElectrodeCell> {
    let (column, row) = (to.column, to.row);
    let pair = match (to.column.cmp(&from.column), to.row.cmp(&from.row)) {
        (std::cmp::Ordering::Greater, _) => [(column + 1, row - 1), (column + 1, row + 1)],
        (std::cmp::Ordering::Less, _) => [(column - 1, row - 1), (column - 1, row + 1)],
        (_, std::cmp::Ordering::Less) => [(column - 1, row - 1), (column + 1, row - 1)],
        (_, std::cmp::Ordering::Greater) => [(column - 1, row + 1), (column + 1, row + 1)],
        (std::cmp::Ordering::Equal, std::cmp::Ordering::Equal) => return Vec::new(),
    };
    pair.map(|(column, row)| ElectrodeCell::new(column, row)).to_vec()
}

#[cfg(test)]
pub(crate) mod tests;
