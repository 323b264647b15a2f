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
use super::clock::{LoweredRun, RunActuation};
use crate::claims::electrode_array::{ElectrodeArrayAction, ElectrodeArrayOrder};
use crate::device::electrode_array::{
    DispenseFrame, DispenseSequence, ElectrodeArrayFacts, ElectrodeCell, Electrodes, Hold,
};
use crate::plan::Planned;
use crate::plan::electrode_array::{ElectrodeArrayMotion, ElectrodeArrayStepMotion, PartCourse};
use crate::schedule::electrode_array::ElectrodeArrayState;
use crate::schedule::{ChannelUnit, State, TimedState};
use std::collections::{BTreeMap, BTreeSet};

impl Lowered for Planned<'_, ElectrodeArrayOrder, ElectrodeArrayMotion> {
    fn run(&self) -> Option<LoweredRun> {
        let Planned { order, motion } = self;
        let (run, cells, firsts) = (LoweredRun::default(), motion.start.clone(), firsts(&order.facts));
        let mut board = LoweringBoard { order, run, cells, firsts };
        board.record(0);
        for (index, (step, motion)) in order.steps.iter().zip(&motion.steps).enumerate() {
            let start_ns = board.run.duration_ns;
            match motion {
                ElectrodeArrayStepMotion::Wait(duration_ns) => board.wait(*duration_ns, index)?,
                ElectrodeArrayStepMotion::Assay { operations, courses } => {
                    let paths: Vec<&[ElectrodeCell]> = courses.iter().map(|course| course.cells.as_slice()).collect();
                    board.follow(&paths, courses, index)?;
                    if let ElectrodeArrayAction::Assay(asked) = &step.action {
                        let timed = operations::timed(order, index, start_ns, asked, operations, courses);
                        board.run.operations.extend(timed);
                    }
                }
                ElectrodeArrayStepMotion::Paths(paths) => {
                    let paths: Vec<&[ElectrodeCell]> = paths.iter().map(Vec::as_slice).collect();
                    board.follow(&paths, &[], index)?;
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
        let names: BTreeSet<&str> = own.flat_map(|run| &run.actuations).map(|(name, _)| name.as_str()).collect();
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
    /// The cell of each part; `None` for a part that has merged, left, or not yet come.
    cells: Vec<Option<ElectrodeCell>>,
    /// For each electrode that is not the first of its channel, the first one.
    firsts: BTreeMap<ElectrodeCell, ElectrodeCell>,
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

impl LoweringBoard<'_> {
    /// Moves all parts through their cells, step by step of the board; in an assay, the courses determine which parts
    /// come and go.
    fn follow(&mut self, paths: &[&[ElectrodeCell]], courses: &[PartCourse], step: usize) -> Option<()> {
        let facts = &self.order.facts;
        let since = |part: usize| courses.get(part).map_or(0, |course| course.since);
        let until = |(part, path): (usize, &&[ElectrodeCell])| (since(part) + path.len()).saturating_sub(1);
        let instants = paths.iter().enumerate().map(until).max().unwrap_or(0);
        // The switches that are on, with the instant since when.
        let mut on: BTreeMap<BoardSwitch, u64> = BTreeMap::new();
        let gone_after = |cells: &mut [Option<ElectrodeCell>], instant: usize| {
            let done = courses.iter().zip(cells).filter(|(course, _)| course.is_gone && course.until() <= instant + 1);
            done.fold(false, |is_any, (_, cell)| cell.take().is_some() || is_any)
        };
        let is_any_gone = gone_after(&mut self.cells, 0);
        if instants == 0 && is_any_gone {
            // No step of the board follows in which this would be recorded.
            self.record(self.run.duration_ns);
        }
        for instant in 0..instants {
            let start_ns = self.run.duration_ns;
            for (part, course) in courses.iter().enumerate() {
                if self.cells[part].is_some() {
                    continue;
                }
                match course.parent {
                    // A droplet that another one splits off in this step of the board begins where that one is.
                    Some(parent) if course.since == instant + 1 => self.cells[part] = self.cells[parent],
                    None if course.since == instant && course.until() > instant + 1 => {
                        self.cells[part] = course.at(instant);
                    }
                    Some(_) | None => (),
                }
            }
            let next = |(part, path): (usize, &&[ElectrodeCell])| {
                self.cells[part]?;
                path.get((instant + 1).saturating_sub(since(part))).or(path.last()).copied()
            };
            let next: Vec<Option<ElectrodeCell>> = paths.iter().enumerate().map(next).collect();
            let frames = self.frames(instant, courses, step);
            let wanted = self.wanted(&next, &frames);
            self.switch(&mut on, &wanted, start_ns, step);
            self.run.duration_ns = start_ns.checked_add(facts.step_ns)?;
            self.cells = next;
            gone_after(&mut self.cells, instant + 1);
            self.record(self.run.duration_ns);
        }
        self.switch(&mut on, &BTreeSet::new(), self.run.duration_ns, step);
        Some(())
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

    /// The frames of reservoirs at an instant of a step, by the parts that are being dispensed.
    fn frames(&self, instant: usize, courses: &[PartCourse], step: usize) -> BTreeMap<usize, &DispenseFrame> {
        let (Some(reservoirs), Some(ElectrodeArrayAction::Assay(operations))) =
            (&self.order.facts.reservoirs, self.order.steps.get(step).map(|step| &step.action))
        else {
            return BTreeMap::new();
        };
        let frame_steps = (reservoirs.frame_ns / self.order.facts.step_ns).max(1) as usize;
        let frame = |part: usize, sequence: &'_ DispenseSequence| {
            let since = instant.checked_sub(courses.get(part)?.since)?;
            (since / frame_steps < sequence.frames.len()).then_some(since / frame_steps)
        };
        let coming = operations.iter().filter(|operation| operation.comes);
        coming
            .filter_map(|operation| {
                let sequence = reservoirs.at(operation.stops.first()?.cell)?;
                Some((operation.part, &sequence.frames[frame(operation.part, sequence)?]))
            })
            .collect()
    }

    /// The electrodes that move the parts to their next cells and hold resting parts; for a part that is being
    /// dispensed, its frame.
    fn wanted(
        &self,
        next: &[Option<ElectrodeCell>],
        frames: &BTreeMap<usize, &DispenseFrame>,
    ) -> BTreeSet<BoardSwitch> {
        let facts = &self.order.facts;
        let both = self.cells.iter().zip(next).enumerate();
        let both = both.filter_map(|(part, (from, to))| Some((part, (*from)?, (*to)?)));
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
        on.retain(|switch, since_ns| {
            let stays = wanted.contains(switch);
            if !stays {
                let (start_ns, duration_ns) = (*since_ns, now_ns - *since_ns);
                let actuation = RunActuation { start_ns, duration_ns, from: volts, to: volts, swing: None, step };
                self.run.actuations.push((switch.channel(), actuation));
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
            self.cells[part] = None;
            merged = true;
        }
        if merged {
            self.run.states.pop();
            self.record(self.run.duration_ns);
        }
    }

    fn record(&mut self, t_ns: u64) {
        let parts = self.order.parts.iter().zip(&self.cells);
        let parts = parts.filter_map(|(part, cell)| Some((part.name.clone(), (*cell)?.pair()))).collect();
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
