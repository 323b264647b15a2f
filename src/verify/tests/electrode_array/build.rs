//! Builds claims on a board, and schedules from one word per part, with an independent lowering and independent
//! records.

use crate::claims::electrode_array::{
    AssayOperation, BoardPart, ElectrodeArrayAction, ElectrodeArrayMove, ElectrodeArrayObjective,
    ElectrodeArrayObstacle, ElectrodeArrayObstacleBody, ElectrodeArrayOrder, ElectrodeArrayStep, ElectrodeArrayStop,
    SplitDroplet,
};
use crate::claims::fixture::board_order;
use crate::claims::{Claims, Job, Order};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell, Electrodes, Hold, Layout, fixture};
use crate::schedule::electrode_array::ElectrodeArrayState;
use crate::schedule::{Actuation, Channel, ChannelUnit, PlanRecord, Schedule, State, TimedState};
use crate::source::Span;
use crate::verify::tests::{self, bare, record_of, step_of};
use std::collections::{BTreeMap, BTreeSet};

/// Duration of a beat, in nanoseconds.
pub const BEAT: u64 = 2_200_000;

pub fn cell(column: u32, row: u32) -> ElectrodeCell {
    ElectrodeCell::new(column, row)
}

/// A board of microparts.
pub fn platform(columns: u32, rows: u32) -> ElectrodeArrayFacts {
    ElectrodeArrayFacts { pitch_ratio: 0.5, step_ns: BEAT, ..fixture::microparts(columns, rows) }
}

/// A board of droplets.
pub fn chip(columns: u32, rows: u32) -> ElectrodeArrayFacts {
    ElectrodeArrayFacts {
        pitch_ratio: 0.5,
        step_ns: BEAT,
        layout: Layout { electrodes: Electrodes::Single, half_width_pitches: 0.55 },
        clearance: 2,
        ..fixture::droplets(columns, rows)
    }
}

/// The order without the cells of some parts, which come out of reservoirs.
pub fn without_places(mut order: ElectrodeArrayOrder, parts: &[usize]) -> ElectrodeArrayOrder {
    let all = std::sync::Arc::make_mut(&mut order.parts);
    parts.iter().for_each(|part| all[*part].cell = None);
    order
}

pub fn order(
    facts: ElectrodeArrayFacts,
    parts: &[(&str, u32, u32)],
    actions: Vec<ElectrodeArrayAction>,
) -> ElectrodeArrayOrder {
    let part = |(name, column, row): &(&str, u32, u32)| BoardPart {
        name: (*name).into(),
        cell: Some(cell(*column, *row)),
        span: Span::default(),
    };
    let step = |action| ElectrodeArrayStep { action, span: Span::default() };
    board_order(facts, parts.iter().map(part), actions.into_iter().map(step).collect())
}

pub fn go(part: usize, stops: &[(u32, u32)]) -> ElectrodeArrayMove {
    let stop = |(column, row): &(u32, u32)| ElectrodeArrayStop {
        cell: cell(*column, *row),
        span: Span::default(),
        origin: None,
    };
    ElectrodeArrayMove::alone(part, stops.iter().map(stop).collect(), Span::default())
}

/// One assay on a board of droplets.
pub fn assay(parts: &[(&str, u32, u32)], operations: Vec<AssayOperation>) -> ElectrodeArrayOrder {
    order(chip(14, 14), parts, vec![ElectrodeArrayAction::Assay(operations)])
}

/// A part stays where it is, or at its stop, for some beats.
pub fn incubate(part: usize, stops: &[(u32, u32)], beats: u64) -> AssayOperation {
    AssayOperation { stay_ns: beats * BEAT, ..operation(go(part, stops)) }
}

/// A part is dispensed from a reservoir in some beats.
pub fn dispense(part: usize, outlet: (u32, u32), beats: u64) -> AssayOperation {
    AssayOperation { comes: true, ..incubate(part, &[outlet], beats) }
}

/// A part is mixed where it is, or from its stop on, for some beats.
pub fn mix(part: usize, stops: &[(u32, u32)], beats: u64) -> AssayOperation {
    AssayOperation { mixes: true, ..incubate(part, stops, beats) }
}

/// A part is split off another one at a cell, and goes to the cell beside it.
pub fn split(half: usize, part: usize, at: (u32, u32), to: (u32, u32)) -> AssayOperation {
    let opposite = (2 * at.0 - to.0, 2 * at.1 - to.1);
    let splits = Some(SplitDroplet { part: half, cell: cell(to.0, to.1) });
    AssayOperation { splits, ..operation(go(part, &[at, opposite])) }
}

/// A part leaves the board.
pub fn discard(part: usize, stop: (u32, u32)) -> AssayOperation {
    AssayOperation { leaves: true, ..operation(go(part, &[stop])) }
}

/// A move or a merge in an assay.
pub fn operation(ElectrodeArrayMove { part, with, stops, span, .. }: ElectrodeArrayMove) -> AssayOperation {
    AssayOperation { with, ..AssayOperation::passing(part, stops, span) }
}

pub fn merge(part: usize, with: usize, goal: (u32, u32)) -> ElectrodeArrayMove {
    ElectrodeArrayMove { with: Some(with), ..go(part, &[goal]) }
}

pub fn obstacle(name: &str, body: ElectrodeArrayObstacleBody) -> ElectrodeArrayObstacle {
    ElectrodeArrayObstacle { name: name.into(), body, span: Span::default() }
}

/// Claims of a single task.
pub fn alone(order: ElectrodeArrayOrder) -> Claims {
    in_turn(vec![order])
}

/// Tasks of one device, one after the other.
pub fn in_turn(orders: Vec<ElectrodeArrayOrder>) -> Claims {
    tests::in_turn("board", orders.into_iter().map(Order::ElectrodeArray))
}

pub fn order_of(claims: &mut Claims, job: usize) -> &mut ElectrodeArrayOrder {
    let Order::ElectrodeArray(order) = &mut claims.jobs[job].order else { panic!("an order of a board") };
    order
}

/// For each job, step and part the word that the part follows, one letter per beat: `R`, `L`, `U`, `D`, or `.` to
/// rest. Before an `o` the part is not on the board, with a `_` per beat; from an `x` on it is gone. After the end of
/// its word a part rests.
pub type Words<'a> = &'a [&'a [&'a [&'a str]]];

fn shift(letter: char) -> [i64; 2] {
    match letter {
        'R' => [1, 0],
        'L' => [-1, 0],
        'U' => [0, 1],
        'D' => [0, -1],
        _ => [0, 0],
    }
}

pub fn moved(at: ElectrodeCell, letter: char) -> ElectrodeCell {
    let [columns, rows] = shift(letter);
    let sum = |at: u32, by: i64| u32::try_from(i64::from(at) + by).expect("a cell on the board");
    cell(sum(at.column, columns), sum(at.row, rows))
}

/// The electrodes that are on for one part in one beat.
pub fn electrodes(facts: &ElectrodeArrayFacts, at: ElectrodeCell, letter: char) -> Vec<ElectrodeCell> {
    let [columns, rows] = shift(letter);
    let far = |c: i64, r: i64| cell((i64::from(at.column) + c) as u32, (i64::from(at.row) + r) as u32);
    match (facts.layout.electrodes, letter) {
        (Electrodes::Quad, '.') => Vec::new(),
        (Electrodes::Quad, _) => {
            vec![far(2 * columns + rows, 2 * rows + columns), far(2 * columns - rows, 2 * rows - columns)]
        }
        (Electrodes::Single, '.' | 'o') if facts.hold == Hold::Off => Vec::new(),
        (Electrodes::Single, _) => vec![moved(at, letter)],
    }
}

/// The first electrode with the channel number of another one; it names the channel.
fn first_on_channel(facts: &ElectrodeArrayFacts, own: ElectrodeCell) -> ElectrodeCell {
    let Some(map) = facts.map.as_ref().filter(|map| !map.channels.is_empty()) else { return own };
    let place = |cell: ElectrodeCell| ((cell.row - 1) * facts.columns + cell.column - 1) as usize;
    let number = map.channels[place(own)];
    let first = map.channels.iter().position(|other| *other == number && number.is_some()).unwrap_or(place(own)) as u32;
    cell(first % facts.columns + 1, first / facts.columns + 1)
}

/// A board while its schedule is being written.
struct Writer {
    schedule: Schedule,
    at_ns: u64,
    cells: Vec<Option<ElectrodeCell>>,
    /// Outlets of the parts that are dispensed in the step.
    outlets: BTreeMap<usize, ElectrodeCell>,
    channels: BTreeMap<ElectrodeCell, u32>,
}

/// The schedule of these words, with true records.
pub fn schedule(claims: &Claims, words: Words) -> Schedule {
    let mut writer = Writer {
        schedule: bare(claims),
        at_ns: 0,
        cells: Vec::new(),
        outlets: BTreeMap::new(),
        channels: BTreeMap::new(),
    };
    for (index, job) in claims.jobs.iter().enumerate() {
        let Order::ElectrodeArray(order) = &job.order else { panic!("an order of a board") };
        if index == 0 {
            writer.cells = order.parts.iter().map(|part| part.cell).collect();
        }
        writer.run(index, job, order, words[index]);
    }
    writer.schedule.duration_ns = writer.at_ns;
    writer.schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
    writer.schedule
}

impl Writer {
    fn run(&mut self, index: usize, job: &Job, order: &ElectrodeArrayOrder, words: &[&[&str]]) {
        let start_ns = self.at_ns;
        let mut states = vec![self.state(order)];
        let (mut steps, mut costs, mut moves) = (0, 0, 0);
        for (nth, step) in order.steps.iter().enumerate() {
            let (step_ns, words) = (self.at_ns, words[nth]);
            let beats = words.iter().map(|word| word.trim_end_matches('x').len()).max().unwrap_or(0);
            match &step.action {
                ElectrodeArrayAction::Wait(duration_ns) => self.rest(order, *duration_ns),
                ElectrodeArrayAction::Assay(operations) => {
                    self.outlets = operations.iter().filter_map(AssayOperation::new_part).collect();
                    self.follow(order, words, beats, &mut states);
                }
                ElectrodeArrayAction::Move(goals) => {
                    self.follow(order, words, beats, &mut states);
                    let gone: Vec<usize> = goals.iter().filter_map(|goal| goal.with).collect();
                    gone.iter().for_each(|part| self.cells[*part] = None);
                    if beats > 0 {
                        *states.last_mut().expect("a state") = self.state(order);
                    }
                }
            }
            steps += beats;
            costs += words.iter().map(|word| word.trim_end_matches(['.', 'x', 'o', '_']).len()).sum::<usize>();
            moves += words.iter().map(|word| word.replace(['.', 'x', 'o', '_'], "").len()).sum::<usize>();
            self.schedule.steps.push(step_of(job, index, [step_ns, self.at_ns]));
        }
        let plan = self.plan(job, order, start_ns, states, [steps, costs, moves]);
        self.schedule.plans.push(plan);
    }

    fn plan(
        &self,
        job: &Job,
        order: &ElectrodeArrayOrder,
        start_ns: u64,
        states: Vec<TimedState>,
        [steps, costs, moves]: [usize; 3],
    ) -> PlanRecord {
        let duration_ns = self.at_ns - start_ns;
        let figures = [("steps", steps as f64), ("sum_of_costs", costs as f64), ("moves", moves as f64)];
        let outcomes = figures.into_iter().chain([("time_ns", duration_ns as f64)]);
        let (objective, cost) = match order.objective {
            ElectrodeArrayObjective::Makespan => ("makespan", steps as f64),
            ElectrodeArrayObjective::SumOfCosts => ("sum_of_costs", costs as f64),
        };
        PlanRecord {
            cost,
            bound: cost,
            optimal: true,
            outcomes: outcomes.map(|(name, value)| (name.to_owned(), value)).collect(),
            states,
            ..record_of(job, "portfolio", [objective, ""], [start_ns, self.at_ns])
        }
    }

    fn state(&self, order: &ElectrodeArrayOrder) -> TimedState {
        let here = order.parts.iter().zip(&self.cells);
        let parts = here.filter_map(|(part, cell)| Some((part.name.as_str().into(), (*cell)?.pair()))).collect();
        TimedState { t_ns: self.at_ns, state: State::ElectrodeArray(ElectrodeArrayState { parts }) }
    }

    fn rest(&mut self, order: &ElectrodeArrayOrder, duration_ns: u64) {
        if order.facts.layout.electrodes == Electrodes::Single && order.facts.hold == Hold::On && duration_ns > 0 {
            let held = self.cells.iter().flatten().map(|cell| first_on_channel(&order.facts, *cell));
            let held: BTreeSet<ElectrodeCell> = held.collect();
            held.into_iter().for_each(|cell| self.on(order, cell, self.at_ns, duration_ns));
        }
        self.at_ns += duration_ns;
    }

    fn follow(&mut self, order: &ElectrodeArrayOrder, words: &[&str], beats: usize, states: &mut Vec<TimedState>) {
        // An electrode that is on in consecutive beats has one actuation for all of them.
        let mut since: BTreeMap<ElectrodeCell, u64> = BTreeMap::new();
        for beat in 0..beats {
            let mut wanted = BTreeSet::new();
            for (part, at) in self.cells.iter_mut().enumerate() {
                let letter = words.get(part).and_then(|word| word.chars().nth(beat)).unwrap_or('.');
                let comes = self.outlets.get(&part).copied().filter(|_| letter == 'o');
                let Some(from) = at.or(comes) else { continue };
                let own = electrodes(&order.facts, from, letter).into_iter();
                wanted.extend(own.map(|cell| first_on_channel(&order.facts, cell)));
                let is_gone = words.get(part).and_then(|word| word.chars().nth(beat + 1)) == Some('x');
                *at = Some(moved(from, letter)).filter(|_| !is_gone);
            }
            self.switch(order, &mut since, &wanted);
            self.at_ns += order.facts.step_ns;
            states.push(self.state(order));
        }
        self.switch(order, &mut since, &BTreeSet::new());
    }

    fn switch(
        &mut self,
        order: &ElectrodeArrayOrder,
        since: &mut BTreeMap<ElectrodeCell, u64>,
        wanted: &BTreeSet<ElectrodeCell>,
    ) {
        let ended: Vec<ElectrodeCell> = since.keys().filter(|cell| !wanted.contains(cell)).copied().collect();
        for cell in ended {
            let start_ns = since.remove(&cell).expect("it was on");
            self.on(order, cell, start_ns, self.at_ns - start_ns);
        }
        for cell in wanted {
            since.entry(*cell).or_insert(self.at_ns);
        }
    }

    fn on(&mut self, order: &ElectrodeArrayOrder, cell: ElectrodeCell, start_ns: u64, duration_ns: u64) {
        let volts = order.facts.potential_v;
        let step = self.schedule.steps.len() as u32;
        let channels = &mut self.schedule.channels;
        let channel = *self.channels.entry(cell).or_insert_with(|| {
            channels.push(named(cell));
            channels.len() as u32 - 1
        });
        self.schedule.actuations.push(Actuation {
            channel,
            start_ns,
            duration_ns,
            from: volts,
            to: volts,
            swing: None,
            step,
        });
    }
}

/// The index of an electrode's channel, which is added if it is missing.
pub fn channel(schedule: &mut Schedule, cell: ElectrodeCell) -> u32 {
    let new = named(cell);
    let known = schedule.channels.iter().position(|channel| channel.name == new.name);
    known.unwrap_or_else(|| {
        schedule.channels.push(new);
        schedule.channels.len() - 1
    }) as u32
}

fn named(cell: ElectrodeCell) -> Channel {
    let name = format!("board.e{}_{}", cell.column, cell.row);
    Channel { name, device: "board".into(), unit: ChannelUnit::Volt, wire: None, rest_v: 0.0 }
}

/// Switches an additional electrode on in a step.
pub fn switch_on(schedule: &mut Schedule, column: u32, row: u32, step: usize, from: u64, beats: u64) {
    let channel = channel(schedule, cell(column, row));
    let start_ns = schedule.steps[step].start_ns + from * BEAT;
    let like = Actuation {
        channel,
        start_ns,
        duration_ns: beats * BEAT,
        from: 100.0,
        to: 100.0,
        swing: None,
        step: step as u32,
    };
    schedule.actuations.push(like);
    schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
}
