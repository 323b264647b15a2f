//! Replays the run of a DiMiBot: actuations become pulses, pulses module states, states positions, and moves swept
//! areas.
//!
//! Input: a [`JudgedRun`] whose steps and channels are sound, and the device's last state. Output: its states and
//! outcomes; one function per rule. A pulse is the set of actuations that begin at one instant on the device. It takes
//! the device's pulse duration, followed by the rest, in which nothing is switched. A step of moves is pulse after
//! pulse without idle time and ends with its last rest.

mod scene;
mod shared_scene;

use super::clock::JudgedRun;
use super::evidence::{Clearance, GapUnit};
use super::geometry::convex::{share_of_side, towards};
use super::record::TOLERANCE;
use super::rule::{Findings, Rule, Violation, ms};
use super::{InvalidClaims, Judge, JudgedState, LastStates, RecordTerms, Replay, ReplayStop, ReplayedState};
use crate::claims::dimibot::{DimibotAction, DimibotOrder, DimibotStop};
use crate::claims::{Claims, Order};
use crate::device::dimibot::{DimibotFacts, DimibotOutcome, LatticeCell, Side, Simultaneous, Switch};
use crate::quantity::digits;
use crate::schedule::dimibot::DimibotState;
use crate::schedule::{Actuation, ChannelUnit, State, TimedState};
use scene::{DimibotObstacles, TipTouch, place};
use std::collections::BTreeMap;

/// Actuator of a channel.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Actuator {
    side: Side,
    module: u32,
    switch: Switch,
}

impl Actuator {
    fn state(self, cell: LatticeCell) -> bool {
        let bits = match self.side {
            Side::Left => cell.x,
            Side::Right => cell.y,
        };
        bits >> self.module & 1 == 1
    }

    /// The cell after this actuator has switched its module.
    fn applied(self, cell: LatticeCell) -> LatticeCell {
        let bit = 1 << self.module;
        let bits = |old: u32| match self.switch {
            Switch::Set => old | bit,
            Switch::Reset => old & !bit,
        };
        match self.side {
            Side::Left => LatticeCell { x: bits(cell.x), ..cell },
            Side::Right => LatticeCell { y: bits(cell.y), ..cell },
        }
    }

    /// The cell in which only its module is at 1.
    fn own_cell(self) -> LatticeCell {
        Actuator { switch: Switch::Set, ..self }.applied(LatticeCell { x: 0, y: 0 })
    }

    fn is_opposite(self, other: Actuator) -> bool {
        (self.side, self.module) == (other.side, other.module) && self.switch != other.switch
    }

    fn name(self) -> String {
        DimibotFacts::channel(self.side, self.module, self.switch)
    }
}

/// The actuators of a device by the full names of their channels.
pub(super) fn actuators(device: &str, facts: &DimibotFacts) -> BTreeMap<String, Actuator> {
    let sides = [(Side::Left, facts.left), (Side::Right, facts.right)].into_iter();
    let modules = sides.flat_map(|(side, count)| (0..count).map(move |module| (side, module)));
    let both =
        modules.flat_map(|(side, module)| [Switch::Set, Switch::Reset].map(|switch| Actuator { side, module, switch }));
    both.map(|actuator| (format!("{device}.{}", actuator.name()), actuator)).collect()
}

impl Judge for DimibotOrder {
    fn unit(&self, channel: &str) -> Option<ChannelUnit> {
        actuators("", &self.facts).contains_key(&format!(".{channel}")).then_some(ChannelUnit::Volt)
    }

    fn premise(&self) -> Result<(), InvalidClaims> {
        scene::check_claims(self)
    }

    fn has_facts_of(&self, other: &Order) -> bool {
        DimibotOrder::of(other).is_some_and(|other| other.facts == self.facts)
    }

    fn terms(&self) -> RecordTerms {
        let objective = self.objective;
        RecordTerms {
            planner: self.planner.method.name(),
            objective: objective.name(),
            outcome: Some(objective.outcome().name()),
            unit: objective.unit(),
            scale: objective.units_per_si(),
        }
    }

    fn minimized_as(&self, outcome: &str) -> Option<&'static str> {
        DimibotOutcome::find(outcome).map(|outcome| outcome.objective().name())
    }

    fn replay<'a>(
        &self,
        run: &JudgedRun<'a>,
        claims: &Claims,
        last_states: &mut LastStates<'a>,
        findings: &mut Findings,
    ) -> Result<Replay<'a>, ReplayStop> {
        let scene = DimibotObstacles::new(self)?;
        let start = start(run, self, last_states, findings);
        let task = DimibotRun { run, order: self, start, pulses: pulses(run, self, start) };
        shapes(&task, findings);
        rests(&task, findings);
        // A robot that shares its scene may have to wait for another to pass.
        if !claims.is_shared(&run.job.device) {
            idle(&task, findings);
        }
        waits(&task, findings);
        opposed(&task, findings);
        switches(&task, findings);
        simultaneous(&task, findings);
        standing_clear(&task, &scene, findings);
        clearances(&task, &scene);
        sweeps(&task, &scene, findings);
        mixtures(&task, &scene, findings);
        goals(&task, findings);
        places(&task, findings);
        last_states.insert(&run.job.device, state(&self.facts, task.end()));
        Ok(Replay {
            states: task.states().into_iter().map(|state| ReplayedState::Own(Box::new(state))).collect(),
            outcomes: task.outcomes(),
            operations: BTreeMap::new(),
        })
    }

    fn check_between_devices(&self, runs: &[JudgedRun], order: &[usize], claims: &Claims, findings: &mut Findings) {
        shared_scene::tips_apart(runs, order, claims, findings);
    }
}

impl JudgedState for DimibotState {
    fn agrees(&self, replayed: &State) -> bool {
        let State::Dimibot(DimibotState { word, cell, position_um }) = replayed else { return false };
        let near = |(one, other): (&f64, &f64)| (one - other).abs() <= TOLERANCE * other.abs().max(1.0);
        self.word == *word && self.cell == *cell && self.position_um.iter().zip(position_um).all(near)
    }

    fn shown(&self) -> String {
        let DimibotState { word, cell: [x, y], position_um: [x_um, y_um] } = self;
        format!("cell ({x}, {y}), word {word}, at ({}, {}) um", digits(*x_um), digits(*y_um))
    }
}

/// All actuations that begin at one instant.
#[derive(Debug)]
struct PulseInstant<'a> {
    start_ns: u64,
    /// Index of its step in the run.
    nth: usize,
    /// Index of its step in the schedule.
    step: usize,
    parts: Vec<(&'a Actuation, Actuator)>,
    before: LatticeCell,
    after: LatticeCell,
    /// The actuators that change their module.
    strokes: Vec<Actuator>,
}

impl PulseInstant<'_> {
    /// The lowest and the highest cell that the tip can reach while the modules switch, in any order.
    fn extremes(&self) -> [LatticeCell; 2] {
        let all = |switch| {
            let strokes = self.strokes.iter().filter(|stroke| stroke.switch == switch);
            strokes.fold(self.before, |cell, stroke| stroke.applied(cell))
        };
        [all(Switch::Reset), all(Switch::Set)]
    }
}

/// A run in the terms of a DiMiBot.
struct DimibotRun<'a> {
    run: &'a JudgedRun<'a>,
    order: &'a DimibotOrder,
    /// Cell at the start of the run.
    start: LatticeCell,
    pulses: Vec<PulseInstant<'a>>,
}

fn state(facts: &DimibotFacts, cell: LatticeCell) -> State {
    let position = place(facts, cell);
    State::Dimibot(DimibotState {
        word: facts.word(cell),
        cell: [cell.x, cell.y],
        position_um: [position.x, position.y],
    })
}

/// Start of a run: the device's place; for its first run the task's `start at`, or home.
fn start(run: &JudgedRun, order: &DimibotOrder, last_states: &LastStates, findings: &mut Findings) -> LatticeCell {
    let claimed = order.start.as_ref();
    let Some(State::Dimibot(DimibotState { cell: [x, y], .. })) = last_states.get(run.job.device.as_str()) else {
        return claimed.map_or(order.facts.home, |start| start.value);
    };
    let stands = LatticeCell { x: *x, y: *y };
    if let Some(start) = claimed.filter(|start| start.value != stands) {
        let title = format!(
            "`{}` must start at cell {}, but `{}` is at {stands} by then",
            run.job.task, start.value, run.job.device
        );
        let violation = Violation::new(Rule::Start, run.plan.start_ns, title).label(start.span, "this start");
        findings.push(
            violation
                .label(run.job.run_span, "in this run")
                .help(format!("write `start at {stands}`, or leave it out")),
        );
    }
    stands
}

/// Groups actuations into pulses and follows the module states through them. A module that is set and reset at once
/// keeps its state.
fn pulses<'a>(run: &JudgedRun<'a>, order: &DimibotOrder, start: LatticeCell) -> Vec<PulseInstant<'a>> {
    let actuators = actuators(&run.job.device, &order.facts);
    let nth: BTreeMap<usize, usize> = run.steps.iter().enumerate().map(|(nth, step)| (*step, nth)).collect();
    let mut cell = start;
    let together = run.actuations.chunk_by(|one, other| one.start_ns == other.start_ns);
    let pulse = |parts: &[&'a Actuation]| {
        let (start_ns, step) = (parts[0].start_ns, parts[0].step as usize);
        let actuator = |part: &Actuation| actuators[&run.schedule.channels[part.channel as usize].name];
        let parts: Vec<_> = parts.iter().map(|part| (*part, actuator(part))).collect();
        let (before, strokes) = (cell, strokes(cell, &parts));
        cell = strokes.iter().fold(cell, |cell, stroke| stroke.applied(cell));
        PulseInstant { start_ns, nth: nth[&step], step, parts, before, after: cell, strokes }
    };
    together.map(pulse).collect()
}

/// The actuators of a pulse that change the state of their module.
fn strokes(cell: LatticeCell, parts: &[(&Actuation, Actuator)]) -> Vec<Actuator> {
    let moves = |actuator: &Actuator| {
        actuator.applied(cell) != cell && !parts.iter().any(|(_, other)| other.is_opposite(*actuator))
    };
    parts.iter().map(|(_, actuator)| *actuator).filter(moves).collect()
}

impl DimibotRun<'_> {
    fn facts(&self) -> &DimibotFacts {
        &self.order.facts
    }

    /// Duration of a pulse with its rest.
    fn slot_ns(&self) -> u64 {
        self.facts().pulse_duration_ns + self.facts().rest_ns
    }

    fn end(&self) -> LatticeCell {
        self.pulses.last().map_or(self.start, |pulse| pulse.after)
    }

    /// The cells in which the tip rests during a step, including the one before its first pulse.
    fn rests_at(&self, nth: usize) -> Vec<LatticeCell> {
        let before = self.pulses.partition_point(|pulse| pulse.nth < nth);
        let first = self.pulses[..before].last().map_or(self.start, |pulse| pulse.after);
        std::iter::once(first).chain(self.of_step(nth).map(|pulse| pulse.after)).collect()
    }

    fn of_step(&self, nth: usize) -> impl DoubleEndedIterator<Item = &PulseInstant<'_>> {
        let first = self.pulses.partition_point(|pulse| pulse.nth < nth);
        let end = self.pulses.partition_point(|pulse| pulse.nth <= nth);
        self.pulses[first..end].iter()
    }

    /// A violation at a pulse, with its step.
    fn at(&self, rule: Rule, pulse: &PulseInstant, title: String) -> Violation {
        self.run.violation(rule, pulse.nth, pulse.start_ns, title)
    }

    /// A violation of a step as a whole.
    fn of(&self, rule: Rule, nth: usize, time_ns: u64, title: String) -> Violation {
        let span = self.order.steps[nth].span;
        Violation::new(rule, time_ns, title).step(self.run.steps[nth]).label(span, "this step")
    }

    /// The states over time. A state begins at the end of its pulse, when the module has certainly snapped.
    fn states(&self) -> Vec<TimedState> {
        let facts = self.facts();
        let first = TimedState { t_ns: self.run.plan.start_ns, state: state(facts, self.start) };
        let changes = self.pulses.iter().filter(|pulse| pulse.after != pulse.before);
        let later = changes.map(|pulse| TimedState {
            t_ns: pulse.start_ns.saturating_add(facts.pulse_duration_ns),
            state: state(facts, pulse.after),
        });
        std::iter::once(first).chain(later).collect()
    }

    /// Number of actuations in all pulses.
    fn parts(&self) -> usize {
        self.pulses.iter().map(|pulse| pulse.parts.len()).sum()
    }

    /// Outcomes in SI units. The distance does not depend on the order of snapping: each module that snaps moves the
    /// tip along its own axis by its own column of the matrix.
    fn outcomes(&self) -> BTreeMap<&'static str, f64> {
        let facts = self.facts();
        let strokes = || self.pulses.iter().flat_map(|pulse| &pulse.strokes);
        let way = |stroke: &Actuator| facts.displacement_um(stroke.own_cell()).norm();
        let pulse_j = facts.pulse_voltage_v * facts.pulse_current_a * (facts.pulse_duration_ns as f64 * 1e-9);
        BTreeMap::from([
            (DimibotOutcome::Distance.name(), strokes().map(way).sum::<f64>() * 1e-6),
            (DimibotOutcome::Switches.name(), strokes().count() as f64),
            (DimibotOutcome::Time.name(), self.run.plan.duration_ns as f64 / 1e9),
            (DimibotOutcome::Energy.name(), self.parts() as f64 * pulse_j),
        ])
    }
}

/// Every pulse has the device's voltage and duration.
fn shapes(task: &DimibotRun, findings: &mut Findings) {
    let DimibotFacts { pulse_voltage_v: volts, pulse_duration_ns, .. } = *task.facts();
    findings.count_checks(Rule::Pulse, task.parts());
    for pulse in &task.pulses {
        for (part, actuator) in &pulse.parts {
            let name = actuator.name();
            if part.from != volts || part.to != volts {
                let title =
                    format!("the pulse on `{name}` goes from {} V to {} V; {volts} V is needed", part.from, part.to);
                findings.push(task.at(Rule::Pulse, pulse, title));
            }
            if part.duration_ns != pulse_duration_ns {
                let (lasts, due) = (ms(part.duration_ns), ms(pulse_duration_ns));
                let title = format!("the pulse on `{name}` lasts {lasts}; {due} is needed");
                findings.push(task.at(Rule::Pulse, pulse, title));
            }
        }
    }
}

/// The rest after a pulse is over before the next pulse, and before the run ends.
fn rests(task: &DimibotRun, findings: &mut Findings) {
    findings.count_checks(Rule::Rest, task.pulses.len());
    let next = task.pulses.iter().skip(1).map(|pulse| pulse.start_ns);
    for (pulse, next_ns) in task.pulses.iter().zip(next) {
        let since_ns = next_ns - pulse.start_ns;
        if since_ns < task.slot_ns() {
            let (since, due) = (ms(since_ns), ms(task.slot_ns()));
            let title =
                format!("a pulse begins {since} after the beginning of the one before; pulse and rest need {due}");
            findings.push(task.at(Rule::Rest, pulse, title));
        }
    }
    for nth in 0..task.run.steps.len() {
        let step = task.run.step(nth);
        let Some(pulse) = task.of_step(nth).next_back() else { continue };
        let left_ns = step.end_ns() - pulse.start_ns;
        if left_ns < task.slot_ns() {
            let (left, due) = (ms(left_ns), ms(task.slot_ns()));
            let title =
                format!("the step ends {left} after the beginning of its last pulse; pulse and rest need {due}");
            findings.push(task.at(Rule::Rest, pulse, title));
        }
    }
}

/// A step of moves is pulse after pulse, from its beginning to its end. Not checked for robots that may have to wait
/// for another; their idle time counts as plan time.
fn idle(task: &DimibotRun, findings: &mut Findings) {
    for (nth, claimed) in task.order.steps.iter().enumerate() {
        match claimed.action {
            DimibotAction::Wait(_) => continue,
            DimibotAction::Move(_) | DimibotAction::Visit(_) => (),
        }
        findings.count_checks(Rule::Idle, 1);
        let step = task.run.step(nth);
        let mut due_ns = step.start_ns;
        let ends = task.of_step(nth).map(|pulse| pulse.start_ns).chain([step.end_ns()]);
        for at_ns in ends {
            if at_ns > due_ns {
                let title = format!("nothing happens from {} to {} in a step of moves", ms(due_ns), ms(at_ns));
                findings.push(task.of(Rule::Idle, nth, due_ns, title));
            }
            due_ns = at_ns.saturating_add(task.slot_ns());
        }
    }
}

/// A wait lasts as long as claimed, and nothing is switched in it.
fn waits(task: &DimibotRun, findings: &mut Findings) {
    for (nth, claimed) in task.order.steps.iter().enumerate() {
        let duration_ns = match claimed.action {
            DimibotAction::Wait(duration_ns) => duration_ns,
            DimibotAction::Move(_) | DimibotAction::Visit(_) => continue,
        };
        findings.count_checks(Rule::Wait, 1);
        let step = task.run.step(nth);
        if step.duration_ns != duration_ns {
            let title = format!("the wait lasts {}, but {} in the program", ms(step.duration_ns), ms(duration_ns));
            findings.push(task.of(Rule::Wait, nth, step.start_ns, title));
        }
        for pulse in task.of_step(nth) {
            let title = format!("there is a pulse at {} during a wait", ms(pulse.start_ns));
            findings.push(task.at(Rule::Wait, pulse, title));
        }
    }
}

/// A module is not set and reset in one pulse.
fn opposed(task: &DimibotRun, findings: &mut Findings) {
    findings.count_checks(Rule::Opposed, task.pulses.len());
    for pulse in &task.pulses {
        let set = pulse.parts.iter().filter(|(_, actuator)| actuator.switch == Switch::Set);
        for (_, actuator) in set {
            if pulse.parts.iter().any(|(_, other)| other.is_opposite(*actuator)) {
                let (name, at) = (actuator.name(), ms(pulse.start_ns));
                let title = format!("`{name}` is pulsed at {at} together with the reset of the same module");
                findings.push(task.at(Rule::Opposed, pulse, title));
            }
        }
    }
}

/// A pulse sets a module that is 0 or resets one that is 1.
fn switches(task: &DimibotRun, findings: &mut Findings) {
    findings.count_checks(Rule::Switch, task.parts());
    for pulse in &task.pulses {
        for (_, actuator) in &pulse.parts {
            let twisted = pulse.parts.iter().any(|(_, other)| other.is_opposite(*actuator));
            if !twisted && !pulse.strokes.contains(actuator) {
                let (name, at, bit) = (actuator.name(), ms(pulse.start_ns), u8::from(actuator.state(pulse.before)));
                let title = format!("`{name}` at {at} does nothing: its module is already at {bit}");
                findings.push(task.at(Rule::Switch, pulse, title));
            }
        }
    }
}

/// Several modules are switched in one pulse only where the task allows it.
fn simultaneous(task: &DimibotRun, findings: &mut Findings) {
    match task.order.simultaneous {
        Simultaneous::Safe => return,
        Simultaneous::Never => (),
    }
    findings.count_checks(Rule::Simultaneous, task.pulses.len());
    for pulse in task.pulses.iter().filter(|pulse| pulse.strokes.len() > 1) {
        let (count, at) = (pulse.strokes.len(), ms(pulse.start_ns));
        let title = format!("{count} modules are switched at {at}; only 1 at a time is allowed");
        findings.push(task.at(Rule::Simultaneous, pulse, title));
    }
}

/// The tip is clear of obstacles before the first pulse.
fn standing_clear(task: &DimibotRun, scene: &DimibotObstacles, findings: &mut Findings) {
    findings.count_checks(Rule::Sweep, 1);
    if let Some(touch) = scene.touch(task.start, task.start) {
        let title = format!("the tip starts at cell {}, {}", task.start, touch.describe(task.order));
        let violation = Violation::new(Rule::Sweep, task.run.plan.start_ns, title);
        findings.push(touched(task, violation, &touch).label(task.run.job.run_span, "in this run"));
    }
}

/// The path of the tip is clear where a single module snaps.
fn sweeps(task: &DimibotRun, scene: &DimibotObstacles, findings: &mut Findings) {
    for pulse in &task.pulses {
        let [stroke] = pulse.strokes[..] else { continue };
        findings.count_checks(Rule::Sweep, 1);
        let [low, high] = pulse.extremes();
        if let Some(touch) = scene.touch(low, high) {
            let (name, at, meeting) = (stroke.name(), ms(pulse.start_ns), touch.describe(task.order));
            let title = format!("`{name}` at {at} moves the tip from {} to {}, {meeting}", pulse.before, pulse.after);
            findings.push(touched(task, task.at(Rule::Sweep, pulse, title), &touch));
        }
    }
}

/// The whole area that the tip can reach while several modules switch at once, in any order and at any part of their
/// strokes, is clear.
fn mixtures(task: &DimibotRun, scene: &DimibotObstacles, findings: &mut Findings) {
    for pulse in task.pulses.iter().filter(|pulse| pulse.strokes.len() > 1) {
        findings.count_checks(Rule::Mixture, 1);
        let [low, high] = pulse.extremes();
        if let Some(touch) = scene.touch(low, high) {
            let (count, at, meeting) = (pulse.strokes.len(), ms(pulse.start_ns), touch.describe(task.order));
            let title = format!("{count} modules switched together at {at} may move the tip, {meeting}");
            findings.push(touched(task, task.at(Rule::Mixture, pulse, title), &touch));
        }
    }
}

/// Records the least clearance of the tip from an obstacle, with its instant.
fn clearances(task: &DimibotRun, scene: &DimibotObstacles) {
    let (facts, tally, device) = (task.facts(), &task.run.tally, &task.run.job.device);
    let still = (task.run.plan.start_ns, [task.start; 2], [task.start; 2]);
    let moves = task.pulses.iter().map(|pulse| (pulse.start_ns, pulse.extremes(), [pulse.before, pulse.after]));
    for (start_ns, [low, high], way) in std::iter::once(still).chain(moves) {
        let below_um = tally.least(Rule::Sweep, device) + facts.tip_radius_um;
        let Some(found) = scene.nearest(low, high, below_um) else { continue };
        let share = share_of_side(way.map(|cell| scene.centre(cell)), found.centre);
        let tip = towards(found.centre, found.on_solid, facts.tip_radius_um);
        tally.near(Clearance {
            rule: Rule::Sweep,
            device: device.clone(),
            between: [device.clone(), task.order.obstacles[found.obstacle].name.clone()],
            apart: found.gap_um - facts.tip_radius_um,
            needed: facts.repeatability_um,
            error_bound: 0.0,
            unit: GapUnit::Micrometres,
            t_ns: start_ns.saturating_add((facts.pulse_duration_ns as f64 * share).round() as u64),
            points: [tip, found.on_solid].map(|point| [point.x, point.y, 0.0]),
        });
    }
}

fn touched(task: &DimibotRun, violation: Violation, touch: &TipTouch) -> Violation {
    violation.label(task.order.obstacles[touch.obstacle].span, "this obstacle")
}

/// Stops are reached: those of a move in their order, those of a visit in any order. A move ends at its last stop, a
/// visit at any of its stops.
fn goals(task: &DimibotRun, findings: &mut Findings) {
    findings.count_checks(Rule::Goal, task.order.steps.iter().map(|step| step.stops().len()).sum());
    for (nth, claimed) in task.order.steps.iter().enumerate() {
        let cells = task.rests_at(nth);
        let missed = match &claimed.action {
            DimibotAction::Wait(_) => None,
            DimibotAction::Move(stops) => missed_in_order(stops, &cells),
            DimibotAction::Visit(stops) => missed_of_all(stops, &cells),
        };
        let step = task.run.step(nth);
        let end_ns = step.end_ns();
        if let Some((stop, why)) = missed {
            findings.push(task.of(Rule::Goal, nth, end_ns, why).label(stop.span, "this stop"));
        }
    }
}

fn missed_in_order<'a>(stops: &'a [DimibotStop], cells: &[LatticeCell]) -> Option<(&'a DimibotStop, String)> {
    let mut left = stops;
    for cell in cells {
        while left.first().is_some_and(|stop| stop.cell == *cell) {
            left = &left[1..];
        }
    }
    let (goal, end) = (stops.last()?, cells.last()?);
    if let Some(stop) = left.first() {
        return Some((stop, format!("cell {} is not reached in its turn; the step ends at {end}", stop.cell)));
    }
    (goal.cell != *end).then(|| (goal, format!("the step must end at cell {}, but ends at {end}", goal.cell)))
}

fn missed_of_all<'a>(stops: &'a [DimibotStop], cells: &[LatticeCell]) -> Option<(&'a DimibotStop, String)> {
    let (first, end) = (stops.first()?, cells.last()?);
    if let Some(stop) = stops.iter().find(|stop| !cells.contains(&stop.cell)) {
        return Some((stop, format!("cell {} is not visited; the step ends at {end}", stop.cell)));
    }
    let ends_at_stop = stops.iter().any(|stop| stop.cell == *end);
    (!ends_at_stop).then(|| (first, format!("the visit ends at cell {end}, not at one of its stops")))
}

/// The cell used for a position is the nearest one, within the precision that the task demands.
fn places(task: &DimibotRun, findings: &mut Findings) {
    for (nth, claimed) in task.order.steps.iter().enumerate() {
        let stops = claimed.stops();
        findings.count_checks(Rule::Place, stops.len());
        let start_ns = task.run.step(nth).start_ns;
        for stop in stops {
            if let Some(why) = scene::misplaced(task.order, stop) {
                findings.push(task.of(Rule::Place, nth, start_ns, why).label(stop.span, "this place"));
            }
        }
    }
}
