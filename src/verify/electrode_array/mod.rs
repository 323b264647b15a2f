//! Replays the run of an electrode array: electrodes that are on become pulls, pulls moves, and moves swept cells.
//!
//! Input: a [`JudgedRun`] whose steps and channels are sound, and the cells of the parts. Output: their states and the
//! outcomes. A step of parts consists of steps of the board, here called beats, in which no electrode is switched; a
//! wait is one long beat. Promise: a part moves only where electrodes pull it, and the first beat that breaks a rule
//! ends the replay of its device, since the positions of parts are unknown after it. Cost: for each beat the parts and
//! the electrodes that are on; there are no more beats than the record has states.

mod assay;
mod beat;
mod bodies;
mod broadcast;
mod claims;
mod contents;
mod lags;
mod missed;
mod mixing;
mod nearest;
mod parts;
mod placed;
mod pull;
mod reservoirs;
mod stage;
mod switching;
mod traces;
mod zones;

pub(crate) use contents::{DropletAfter, droplets_after};

use super::clock::JudgedRun;
use super::record;
use super::rule::{Findings, Rule, Violation, ms};
use super::{
    InvalidClaims, Judge, JudgedOperation, JudgedState, LastStates, RecordTerms, Replay, ReplayStop, ReplayedState,
};
use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayAction, ElectrodeArrayMove, ElectrodeArrayOrder};
use crate::claims::{Claims, Order};
use crate::device::electrode_array::{ElectrodeArrayOutcome, ElectrodeCell};
use crate::schedule::electrode_array::ElectrodeArrayState;
use crate::schedule::{Actuation, ChannelUnit, PartCells, State, TimedState};
use assay::{JudgedAssay, JudgedSplit, OperationBeats};
use beat::{Pulls, StepBeat};
use bodies::BoardObstacles;
use broadcast::JudgedChannels;
use parts::PartsOnBoard;
use reservoirs::JudgedReservoirs;
use rustc_hash::{FxHashMap, FxHashSet};
use stage::{StepGoals, StepProgress};
use std::collections::{BTreeMap, BTreeSet};
use switching::{SwitchPulse, Switching, pulses};
use traces::JudgedTraces;
use zones::JudgedZones;

impl Judge for ElectrodeArrayOrder {
    fn unit(&self, channel: &str) -> Option<ChannelUnit> {
        let is_own = self.facts.electrode(channel).is_some() || self.facts.pad(channel).is_some();
        is_own.then_some(ChannelUnit::Volt)
    }

    fn premise(&self) -> Result<(), InvalidClaims> {
        claims::check_claims(self)
    }

    fn has_facts_of(&self, other: &Order) -> bool {
        ElectrodeArrayOrder::of(other).is_some_and(|other| other.facts == self.facts)
    }

    fn has_parts_of(&self, other: &Order) -> bool {
        let names = |order: &ElectrodeArrayOrder| -> BTreeSet<String> {
            order.parts.iter().map(|part| part.name.clone()).collect()
        };
        ElectrodeArrayOrder::of(other)
            .is_some_and(|other| std::sync::Arc::ptr_eq(&self.parts, &other.parts) || names(self) == names(other))
    }

    fn terms(&self) -> RecordTerms {
        let (planner, objective) = (self.planner.method.name(), self.objective);
        RecordTerms {
            planner,
            objective: objective.name(),
            outcome: Some(objective.outcome().name()),
            unit: "",
            scale: 1.0,
        }
    }

    fn minimized_as(&self, outcome: &str) -> Option<&'static str> {
        let objective = ElectrodeArrayOutcome::find(outcome)?.objective()?;
        Some(objective.name())
    }

    fn replay<'a>(
        &self,
        run: &JudgedRun<'a>,
        claims: &Claims,
        last_states: &mut LastStates<'a>,
        findings: &mut Findings,
    ) -> Result<Replay<'a>, ReplayStop> {
        let mut board = JudgedBoard::new(run, self, last_states)?;
        board.traces = JudgedTraces::new(self, claims, run.job);
        board.potentials(findings);
        board.disabled(findings);
        board.record(run.plan.start_ns)?;
        board.stands_clear()?;
        for (nth, step) in self.steps.iter().enumerate() {
            if !matches!(step.action, ElectrodeArrayAction::Assay(_)) {
                board.pads_rest(nth)?;
            }
            match &step.action {
                ElectrodeArrayAction::Wait(duration_ns) => board.wait(nth, *duration_ns, findings)?,
                ElectrodeArrayAction::Move(moves) => board.follow(nth, moves, findings)?,
                ElectrodeArrayAction::Assay(operations) => board.operate(nth, operations, findings)?,
            }
        }
        for wrong in contents::broken(claims, run.job, &run.tally) {
            let end_ns = run.plan.end_ns();
            findings.push(Violation::new(Rule::Requirement, end_ns, wrong.title).label(wrong.span, "this droplet"));
        }
        last_states.insert(&run.job.device, board.state());
        let outcomes = board.outcomes();
        Ok(Replay { states: board.states, outcomes, operations: board.operations })
    }
}

impl JudgedState for ElectrodeArrayState {
    fn agrees(&self, replayed: &State) -> bool {
        matches!(replayed, State::ElectrodeArray(replayed) if self == replayed)
    }

    fn shown(&self) -> String {
        let parts: Vec<String> =
            self.parts.iter().map(|(name, [column, row])| format!("{name} ({column}, {row})")).collect();
        parts.join(", ")
    }
}

/// A board during the replay of a run.
struct JudgedBoard<'r, 'a> {
    run: &'r JudgedRun<'a>,
    order: &'r ElectrodeArrayOrder,
    scene: BoardObstacles,
    channels: JudgedChannels,
    /// The actuations of each step of the run: on electrodes, each with the first electrode of its channel, and on
    /// reservoir pads, each with its pad.
    pulses: Vec<Vec<(ElectrodeCell, &'a Actuation)>>,
    pads: Vec<Vec<(u32, &'a Actuation)>>,
    /// Indices of the parts, by name.
    by_name: FxHashMap<&'r str, usize>,
    cells: PartsOnBoard,
    states: Vec<ReplayedState<'a>>,
    /// The operations of each assay, by index of its step in the run.
    operations: BTreeMap<usize, Vec<JudgedOperation>>,
    /// Traces of droplets on electrodes, if the claims avoid them.
    traces: Option<JudgedTraces<'r>>,
    beats: u64,
    sum_of_costs: u64,
    moves: u64,
}

impl<'r, 'a> JudgedBoard<'r, 'a> {
    fn new(run: &'r JudgedRun<'a>, order: &'r ElectrodeArrayOrder, last: &LastStates) -> Result<Self, ReplayStop> {
        let by_name = order.parts.iter().enumerate().map(|(part, own)| (own.name.as_str(), part)).collect();
        let (pulses, pads) = pulses(run, order)?;
        Ok(JudgedBoard {
            run,
            order,
            scene: BoardObstacles::new(order),
            channels: JudgedChannels::new(&order.facts),
            pulses,
            pads,
            by_name,
            cells: start(run, order, last),
            states: Vec::new(),
            operations: BTreeMap::new(),
            traces: None,
            beats: 0,
            sum_of_costs: 0,
            moves: 0,
        })
    }

    /// Every electrode is on at the potential of the device.
    fn potentials(&self, findings: &mut Findings) {
        let volts = self.order.facts.potential_v;
        let mut hold = |nth: usize, name: &dyn Fn() -> String, part: &Actuation| {
            findings.count_checks(Rule::Potential, 1);
            if part.from != volts || part.to != volts {
                let (name, from, to, at) = (name(), part.from, part.to, ms(part.start_ns));
                let title = format!("{name} goes from {from} V to {to} V at {at}; {volts} V is needed");
                findings.push(self.run.violation(Rule::Potential, nth, part.start_ns, title));
            }
        };
        for (nth, (pulses, pads)) in self.pulses.iter().zip(&self.pads).enumerate() {
            pulses.iter().for_each(|(cell, part)| hold(nth, &|| format!("electrode {cell}"), part));
            pads.iter().for_each(|(pad, part)| hold(nth, &|| format!("pad {pad}"), part));
        }
    }

    /// No electrode that does not work is on, nor a channel without a working electrode: it would pull nothing.
    fn disabled(&self, findings: &mut Findings) {
        let Some(map) = &self.order.facts.map else { return };
        findings.count_checks(Rule::Disabled, self.pulses.iter().map(Vec::len).sum());
        for (nth, pulses) in self.pulses.iter().enumerate() {
            let is_dead =
                |cell: &ElectrodeCell| self.channels.switches(*cell).iter().all(|one| map.disabled.contains(one));
            for (cell, part) in pulses.iter().filter(|(cell, _)| is_dead(cell)) {
                let at = ms(part.start_ns);
                let title = format!("electrode {cell} is on at {at}, but does not work");
                findings.push(self.run.violation(Rule::Disabled, nth, part.start_ns, title));
            }
        }
    }

    /// Nothing moves for the claimed duration; holding electrodes stay on.
    fn wait(&mut self, nth: usize, duration_ns: u64, findings: &mut Findings) -> Result<(), ReplayStop> {
        self.run.wait_lasts(nth, duration_ns, findings);
        let step = self.run.step(nth);
        if step.duration_ns == 0 {
            return Ok(());
        }
        let mut switching = self.switching(nth, step.duration_ns)?;
        switching.advance(0);
        let moment = StepBeat {
            nth,
            at_ns: step.start_ns,
            goals: &StepGoals::default(),
            on: &switching.on,
            splits: &[],
            released: &[],
        };
        let pulls = self.pulled(&moment)?;
        if let Some((part, pull)) = pulls.iter().find(|(_, pull)| pull.moves()) {
            let (name, at) = (&self.order.parts[*part].name, ms(step.start_ns));
            let title = format!("`{name}` moves from {} to {} during a wait at {at}", pull.from, pull.to);
            return Err(self.run.violation(Rule::Wait, nth, step.start_ns, title).into());
        }
        Ok(())
    }

    /// Parts move to their goals, beat by beat.
    fn follow(&mut self, nth: usize, moves: &[ElectrodeArrayMove], findings: &mut Findings) -> Result<(), ReplayStop> {
        let step = self.run.step(nth);
        let step_ns = self.order.facts.step_ns;
        let beats = self.whole_beats(nth)?;
        let mut switching = self.switching(nth, step_ns)?;
        let mut stage = StepProgress::new(moves, &self.cells);
        let mut moved = 0;
        for beat in 0..beats {
            let at_ns = step.start_ns + beat * step_ns;
            if beat > 0 {
                self.record(at_ns)?;
            }
            switching.advance(beat);
            let pulls = self.beat(&StepBeat {
                nth,
                at_ns,
                goals: &stage.goals,
                on: &switching.on,
                splits: &[],
                released: &[],
            })?;
            moved = 0;
            for (part, pull) in pulls.iter().filter(|(_, pull)| pull.moves()) {
                self.cells.put(*part, pull.to);
                stage.arrive(*part, pull, beat + 1);
                moved += 1;
            }
            self.moves += moved;
        }
        self.beats = self.beats.saturating_add(beats);
        self.sum_of_costs = self.sum_of_costs.saturating_add(stage.cost());
        findings.count_checks(Rule::Goal, moves.len());
        self.goals(nth, &stage, findings);
        let homes = stage.homes.iter().map(|(part, home)| (*part, *home));
        self.returns(nth, homes, findings);
        stage.gone().for_each(|part| self.cells.remove(part));
        if beats > 0 {
            self.idle(nth, moved, findings);
            self.record(step.end_ns())?;
        }
        Ok(())
    }

    /// Motion of each part in a beat, with all rules checked that hold at every instant.
    fn beat(&self, moment: &StepBeat) -> Result<Pulls, Violation> {
        let pulls = self.pulled(moment)?;
        self.bystanders(moment, &pulls)?;
        self.sweeps(moment, &pulls)?;
        Ok(pulls)
    }

    /// Updates zones and assay after a number of beats. Returns the parts that were on the board until then.
    fn settle(&mut self, beat: u64, assay: &mut JudgedAssay, zones: &mut JudgedZones) -> Vec<(usize, ElectrodeCell)> {
        zones.look(beat, &self.cells);
        let there = self.parts_on_board();
        assay.settle(beat, &mut self.cells);
        zones.count(beat, &self.cells);
        there
    }

    /// Parts perform their operations, beat by beat.
    fn operate(&mut self, nth: usize, asked: &'r [AssayOperation], findings: &mut Findings) -> Result<(), ReplayStop> {
        let placed = self.placed(nth, asked, findings)?;
        let operations = placed.as_ref();
        let step = self.run.step(nth);
        let step_ns = self.order.facts.step_ns;
        let beats = self.whole_beats(nth)?;
        let mut switching = self.switching(nth, step_ns)?;
        let mut assay = JudgedAssay::new(operations, &self.order.facts, &self.cells);
        let mut zones = JudgedZones::new(self.order, operations);
        let mut reservoirs = self.reservoirs(nth)?;
        let before = self.cells.count();
        let mut there = self.settle(0, &mut assay, &mut zones);
        self.check_traces(nth, step.start_ns, operations, &assay, &there, findings);
        if beats == 0 && self.cells.count() < before {
            self.record(step.start_ns)?;
        }
        for beat in 0..beats {
            let at_ns = step.start_ns + beat * step_ns;
            if beat > 0 {
                self.record(at_ns)?;
            }
            switching.advance(beat);
            reservoirs.iter_mut().for_each(|reservoirs| reservoirs.advance(beat));
            for (part, outlet) in self.dispensed(nth, at_ns, &assay, &switching.on, reservoirs.as_ref()) {
                self.cells.put(part, outlet);
                assay.come(part, beat);
                reservoirs.iter_mut().for_each(|reservoirs| reservoirs.begin(part, outlet, beat));
                self.traces.iter_mut().for_each(|traces| traces.dispense(part, asked));
                // A part that leaves the outlet at that instant is there together with the new droplet.
                let leaves = there.iter().copied().filter(|(other, cell)| *other != part && *cell == outlet);
                let both: Vec<_> = std::iter::once((part, outlet)).chain(leaves).collect();
                self.check_traces(nth, at_ns, operations, &assay, &both, findings);
            }
            let splits = self.pulled_apart(&assay, &switching.on);
            for split in &splits {
                self.cells.put(split.half, split.at);
                self.traces.iter_mut().for_each(|traces| traces.split(split.part, split.half));
            }
            let released = self.released_at_outlet(nth, at_ns, beat, reservoirs.as_ref(), &switching.on)?;
            let (goals, on) = (&assay.goals, &switching.on);
            let pulls = self.beat(&StepBeat { nth, at_ns, goals, on, splits: &splits, released: &released })?;
            splits.iter().for_each(|split| assay.split(split, beat + 1));
            for (part, pull) in pulls.iter().filter(|(_, pull)| pull.moves()) {
                self.cells.put(*part, pull.to);
                if !splits.iter().any(|split| split.half == *part) {
                    assay.arrive(*part, pull.from, beat + 1);
                    self.moves += 1;
                }
            }
            there = self.settle(beat + 1, &mut assay, &mut zones);
            self.stays(nth, at_ns + step_ns, operations, &assay, &mut zones, findings);
            self.check_traces(nth, at_ns + step_ns, operations, &assay, &there, findings);
        }
        self.beats = self.beats.saturating_add(beats);
        self.sum_of_costs = self.sum_of_costs.saturating_add(assay.cost());
        findings.count_checks(Rule::Goal, operations.len());
        let missed = assay.missed(&self.cells);
        missed.iter().for_each(|missed| findings.push(self.not_done(nth, missed)));
        self.lags(nth, &assay, operations, findings);
        let on_clock = self.on_clock(nth, operations, &assay.beats);
        self.operations.insert(nth, on_clock);
        let homes = assay.homes.iter().map(|(part, (home, _))| (*part, *home));
        self.returns(nth, homes, findings);
        if beats > 0 {
            findings.count_checks(Rule::Idle, 1);
            if missed.is_empty() && assay.end() < beats {
                findings.push(self.idle_assay(nth, assay.end()));
            }
            self.record(step.end_ns())?;
        }
        Ok(())
    }

    /// The droplets that are split in a beat: those that are due to split and on which the two electrodes act, and no
    /// other one.
    fn pulled_apart(&self, assay: &JudgedAssay, on: &FxHashSet<ElectrodeCell>) -> Vec<JudgedSplit> {
        let mut due = assay.due_to_split(&self.cells);
        due.retain(|split| {
            let acting = pull::acting(on, self.order.facts.layout.electrodes, split.at);
            acting.len() == 2 && [split.to, split.comes].iter().all(|cell| acting.contains(cell))
        });
        due
    }

    /// The droplets that reservoirs begin to dispense in a beat. With pads: the pads of the first frame are on and no
    /// droplet is near. Without pads: the outlet's electrode is on and acts on no droplet. If several parts are due at
    /// an outlet, the choice has no effect on the board; the record names the part, by its next state or, if the part
    /// is gone by then, by its operation.
    fn dispensed(
        &self,
        nth: usize,
        at_ns: u64,
        assay: &JudgedAssay,
        on: &FxHashSet<ElectrodeCell>,
        reservoirs: Option<&JudgedReservoirs>,
    ) -> Vec<(usize, ElectrodeCell)> {
        let range = pull::range(self.order.facts.layout.electrodes) as u32;
        let acts = |outlet: ElectrodeCell| self.cells.iter().any(|(_, cell)| cell.apart(outlet) <= range);
        let begins = |outlet: ElectrodeCell| {
            let by_pads = reservoirs.and_then(|reservoirs| reservoirs.begins_at(outlet));
            by_pads.unwrap_or_else(|| on.contains(&outlet))
        };
        let due = assay.due_from_outlets(&self.cells, |outlet| begins(outlet) && !acts(outlet));
        let next = self.run.plan.states.get(self.states.len()).map(|next| &next.state);
        let is_in_state = |name: &str| matches!(next, Some(State::ElectrodeArray(ElectrodeArrayState { parts })) if parts.contains(name));
        let is_recorded = |name: &str| {
            let operations = &self.run.step(nth).operations;
            operations.iter().any(|own| own.start_ns == at_ns && own.parts == [name] && own.end_ns() > at_ns)
        };
        let named = |parts: &[usize]| {
            let find = |is_named: &dyn Fn(&str) -> bool| {
                parts.iter().find(|part| is_named(&self.order.parts[**part].name)).copied()
            };
            find(&is_in_state).or_else(|| find(&is_recorded)).or(parts.first().copied())
        };
        due.iter().filter_map(|(outlet, parts)| Some((named(parts)?, *outlet))).collect()
    }

    /// The operations of a step with their times in nanoseconds.
    fn on_clock(
        &self,
        nth: usize,
        operations: &[AssayOperation],
        beats: &[Option<OperationBeats>],
    ) -> Vec<JudgedOperation> {
        let at_ns = |beats: u64| self.run.step(nth).start_ns + beats * self.order.facts.step_ns;
        let timed = operations.iter().zip(beats).filter_map(|(operation, beats)| Some((operation, (*beats)?)));
        timed
            .map(|(operation, beats)| JudgedOperation {
                parts: operation.all_parts().map(|part| self.order.parts[part].name.clone()).collect(),
                times_ns: [beats.free, beats.arrival, beats.done].map(at_ns),
                span: operation.span,
            })
            .collect()
    }

    /// A step of parts lasts a whole number of beats.
    fn whole_beats(&self, nth: usize) -> Result<u64, Violation> {
        let (step, step_ns) = (self.run.step(nth), self.order.facts.step_ns);
        self.run.tally.count_checks(Rule::Beat, 1);
        if step.duration_ns.is_multiple_of(step_ns) {
            return Ok(step.duration_ns / step_ns);
        }
        let (lasts, due) = (ms(step.duration_ns), ms(step_ns));
        let title = format!("the step lasts {lasts}, which is not a multiple of the board's step of {due}");
        Err(self.run.violation(Rule::Beat, nth, step.start_ns, title))
    }

    /// The switching of a step's electrodes, or the violation if one is switched within a beat or pulls a stuck part.
    fn switching(&self, nth: usize, beat_ns: u64) -> Result<Switching<ElectrodeCell>, Violation> {
        let mut pulses = Vec::with_capacity(self.pulses[nth].len());
        for (first, part) in &self.pulses[nth] {
            let pulse = self.in_beats(nth, *first, part, beat_ns, || format!("electrode {first}"))?;
            for cell in self.channels.lights(*first) {
                pulses.push(SwitchPulse { switch: cell, ..pulse });
                self.leaves_stuck_parts(nth, cell, part.start_ns)?;
            }
        }
        Ok(Switching::new(pulses))
    }

    /// An actuation as an interval in beats, or the violation if it is switched within a beat.
    fn in_beats<E>(
        &self,
        nth: usize,
        switch: E,
        part: &Actuation,
        beat_ns: u64,
        name: impl Fn() -> String,
    ) -> Result<SwitchPulse<E>, Violation> {
        let step = self.run.step(nth);
        self.run.tally.count_checks(Rule::Beat, 1);
        let after_ns = part.start_ns - step.start_ns;
        if !after_ns.is_multiple_of(beat_ns) || !part.duration_ns.is_multiple_of(beat_ns) {
            let (from, to, beat) = (ms(part.start_ns), ms(part.end_ns()), ms(beat_ns));
            let (name, begins) = (name(), ms(step.start_ns));
            let title =
                format!("{name} is on from {from} to {to}; it must be on for whole steps of {beat} from {begins} on");
            return Err(self.run.violation(Rule::Beat, nth, part.start_ns, title));
        }
        let (from, beats) = (after_ns / beat_ns, part.duration_ns / beat_ns);
        Ok(SwitchPulse { switch, from, to: from + beats })
    }

    /// A step of parts ends with the last arrival.
    fn idle(&self, nth: usize, moved: u64, findings: &mut Findings) {
        let step = self.run.step(nth);
        findings.count_checks(Rule::Idle, 1);
        if moved == 0 {
            let end_ns = step.end_ns();
            let from_ns = end_ns - self.order.facts.step_ns;
            let title = format!("no part moves from {} to the end of the step at {}", ms(from_ns), ms(end_ns));
            findings.push(self.run.violation(Rule::Idle, nth, from_ns, title));
        }
    }

    /// Parts pass their stops in order and end at their goals.
    fn goals(&self, nth: usize, stage: &StepProgress, findings: &mut Findings) {
        let step = self.run.step(nth);
        let end_ns = step.end_ns();
        for (part, stop) in stage.empty(&self.cells) {
            let name = &self.order.parts[part].name;
            let title =
                format!("no part is at {} when the step ends, but it is a goal of the team of `{name}`", stop.cell);
            findings.push(self.run.violation(Rule::Goal, nth, end_ns, title).label(stop.span, "this goal"));
        }
        for (part, stop, is_goal) in stage.missed(&self.cells) {
            let name = &self.order.parts[part].name;
            let title = match (self.cells[part], is_goal) {
                (None, _) => format!("`{name}` must move to {}, but has already merged with another part", stop.cell),
                (Some(end), true) => format!("`{name}` must end at {}, but ends at {end}", stop.cell),
                (Some(end), false) => format!("`{name}` does not reach {} in its turn; it ends at {end}", stop.cell),
            };
            findings.push(self.run.violation(Rule::Goal, nth, end_ns, title).label(stop.span, "this stop"));
        }
    }

    /// Parts that yielded are back at their homes.
    fn returns(&self, nth: usize, homes: impl Iterator<Item = (usize, ElectrodeCell)>, findings: &mut Findings) {
        let step = self.run.step(nth);
        let end_ns = step.end_ns();
        for (part, home) in homes {
            findings.count_checks(Rule::Bystander, 1);
            let Some(end) = self.cells[part].filter(|cell| *cell != home) else { continue };
            let part = &self.order.parts[part];
            let title = format!("`{}` steps aside from {home} and ends at {end}, but must return", part.name);
            findings.push(self.run.violation(Rule::Bystander, nth, end_ns, title).label(part.span, "this part"));
        }
    }

    fn state(&self) -> State {
        let named = |(part, cell): (usize, ElectrodeCell)| (self.order.parts[part].name.as_str().into(), cell.pair());
        State::ElectrodeArray(ElectrodeArrayState { parts: self.cells.iter().map(named).collect() })
    }

    /// Checks the state at an instant against the record's next one.
    fn record(&mut self, t_ns: u64) -> Result<(), ReplayStop> {
        let Some(recorded) = self.run.plan.states.get(self.states.len()) else {
            return Err(record::miscounted(self.run, self.due_states()).into());
        };
        if recorded.t_ns == t_ns && self.is_state(&recorded.state) {
            self.states.push(ReplayedState::Recorded(recorded));
            return Ok(());
        }
        self.states.push(ReplayedState::Own(Box::new(TimedState { t_ns, state: self.state() })));
        match record::difference(self.run, &self.states) {
            Some(violation) => Err(violation.into()),
            None => Ok(()),
        }
    }

    fn is_state(&self, state: &State) -> bool {
        let State::ElectrodeArray(ElectrodeArrayState { parts }) = state else { return false };
        let is_there = |(name, cell): (&str, [u32; 2])| {
            let part = self.by_name.get(name);
            part.and_then(|part| self.cells[*part]).is_some_and(|here| here.pair() == cell)
        };
        parts.len() == self.cells.count() && parts.iter().all(is_there)
    }

    /// Number of states that a record of this run must have: one at the start, one after each beat of its steps, and
    /// one where parts leave in a step without beats.
    fn due_states(&self) -> u64 {
        let of_beats = |nth: usize| self.run.step(nth).duration_ns / self.order.facts.step_ns;
        let beats = self.order.steps.iter().enumerate().map(|(nth, step)| match &step.action {
            ElectrodeArrayAction::Wait(_) => 0,
            ElectrodeArrayAction::Move(_) => of_beats(nth),
            ElectrodeArrayAction::Assay(operations) => {
                let leaves = operations.iter().any(|operation| operation.gone().is_some());
                of_beats(nth).max(u64::from(leaves))
            }
        });
        beats.fold(1, u64::saturating_add)
    }

    fn outcomes(&self) -> BTreeMap<&'static str, f64> {
        BTreeMap::from([
            (ElectrodeArrayOutcome::Steps.name(), self.beats as f64),
            (ElectrodeArrayOutcome::SumOfCosts.name(), self.sum_of_costs as f64),
            (ElectrodeArrayOutcome::Moves.name(), self.moves as f64),
            (ElectrodeArrayOutcome::Time.name(), self.run.plan.duration_ns as f64 / 1e9),
        ])
    }
}

/// Cell of each part at the start of a run: where the device's last run left it, or where the scene has it.
fn start(run: &JudgedRun, order: &ElectrodeArrayOrder, last_states: &LastStates) -> PartsOnBoard {
    let stands = match last_states.get(run.job.device.as_str()) {
        Some(State::ElectrodeArray(ElectrodeArrayState { parts })) => Some(parts),
        Some(State::Dimibot(_) | State::Microrobots(_) | State::Fingers(_)) | None => None,
    };
    let cell = |[column, row]: [u32; 2]| ElectrodeCell::new(column, row);
    let place = |parts: &PartCells, name: &str| parts.get(name).map(cell);
    let cells = order.parts.iter().map(|part| stands.map_or(part.cell, |stands| place(stands, &part.name)));
    PartsOnBoard::new(cells.collect())
}
