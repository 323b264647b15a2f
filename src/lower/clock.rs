//! Places the plans of a program on one clock.

use super::timeline::{MAX_DURATION_NS, place};
use super::{bench, holds, lowered, outputs};
use crate::claims::{Claims, Job};
use crate::device::Kind;
use crate::diagnostic::{Code, Diagnostic, Sink};
use crate::plan::{Motion, Optimality, Plan};
use crate::quantity::Quantity;
use crate::schedule::reached::{Reached, reached};
use crate::schedule::{
    Actuation, Channel, ChannelUnit, PartCells, PlanRecord, Schedule, ScheduledOperation, ScheduledStep, SourceRef,
    TimedState,
};
use crate::source::{Sources, Span};
use std::collections::BTreeMap;

/// A single job, timed from its own instant 0.
#[derive(Default)]
pub struct LoweredRun {
    pub duration_ns: u64,
    /// Names of the channels used, without the device's name.
    pub channels: Vec<String>,
    /// Their channels are indices into `channels`, their steps indices into `steps`.
    pub actuations: Vec<Actuation>,
    /// Source span, start and duration of each step of the order, in order.
    pub steps: Vec<(Span, u64, u64)>,
    /// The operations of steps in which operations overlap.
    pub operations: Vec<LoweredOperation>,
    pub states: Vec<TimedState>,
}

impl LoweredRun {
    /// The index of a channel, which is added if it is new; meant for few channels.
    pub fn channel(&mut self, name: &str) -> u32 {
        let known = self.channels.iter().position(|known| known == name);
        known.unwrap_or_else(|| {
            self.channels.push(name.to_owned());
            self.channels.len() - 1
        }) as u32
    }
}

/// An operation within a run; `step` is an index into the run's steps, the other fields are those of
/// [`ScheduledOperation`].
pub struct LoweredOperation {
    pub step: usize,
    pub span: Span,
    pub parts: Vec<String>,
    /// The cell that the plan chose for it, if the program names several.
    pub at: Option<[u32; 2]>,
    pub start_ns: u64,
    pub arrival_ns: u64,
    pub end_ns: u64,
}

/// Builds the schedule of a program from a plan for each of its jobs.
///
/// `None` after an error: the schedule would be longer than [`MAX_DURATION_NS`], or its bench cannot play it.
pub fn lower(claims: &Claims, plans: &[Plan<Motion>], sources: &Sources, sink: &mut Sink) -> Option<Schedule> {
    let runs: Option<Vec<LoweredRun>> = plans.iter().map(|plan| lowered(&plan.motion).run()).collect();
    let Some(runs) = runs else { return too_long(claims, sink) };
    let mut placed = Vec::with_capacity(runs.len());
    let lasts: Vec<u64> = runs.iter().map(|run| run.duration_ns).collect();
    let Some(duration_ns) = place(&claims.timeline, 0, &lasts, &mut placed) else { return too_long(claims, sink) };
    let mut starts = vec![0; runs.len()];
    for stretch in &placed {
        stretch.job.into_iter().for_each(|job| starts[job] = stretch.start_ns);
    }
    between_runs(claims, &runs, &starts, sink);
    let mut builder = ScheduleBuilder::new(claims, plans, &runs, sources);
    for (job, (run, start_ns)) in runs.into_iter().zip(starts).enumerate() {
        builder.add(job, &plans[job], run, start_ns);
    }
    let mut schedule = builder.finish(duration_ns);
    outputs::add(&mut schedule, claims, sink)?;
    holds::add(&mut schedule, &placed, claims, sink)?;
    if schedule.duration_ns > MAX_DURATION_NS {
        return too_long(claims, sink);
    }
    bench::check(&schedule, claims, sink).then_some(schedule)
}

/// Warns if a device that holds what it carries only during runs is idle between two of its runs.
fn between_runs(claims: &Claims, runs: &[LoweredRun], starts: &[u64], sink: &mut Sink) {
    let mut by_start: Vec<usize> = (0..runs.len()).collect();
    by_start.sort_by_key(|job| (starts[*job], *job));
    let mut last: BTreeMap<&str, usize> = BTreeMap::new();
    for job in by_start {
        let own = &claims.jobs[job];
        let Some(before) = last.insert(&own.device, job).filter(|_| own.order.as_kind().holds_in_runs_only()) else {
            continue;
        };
        let gap_ns = starts[job].saturating_sub(starts[before] + runs[before].duration_ns);
        let end = runs[before].states.last().and_then(|last| last.state.cells());
        if gap_ns == 0 || end.is_none_or(PartCells::is_empty) {
            continue;
        }
        let gap = Quantity::time_ns(gap_ns);
        let earlier = &claims.jobs[before];
        let title = format!("nothing holds the parts of `{}` for {gap} before this run", own.device);
        let diagnostic = Diagnostic::new(Code::W0512, title)
            .label(own.run_span, "all electrodes are off until this run")
            .label_elsewhere(earlier.run_span, own.run_span, "since the end of this run")
            .help(format!("write the wait as the last step of `{}`: within a task, parts are held", earlier.task));
        sink.push(diagnostic);
    }
}

/// Outcomes of a plan by the keys, and in the units, of schedules.
fn in_their_units(kind: Kind, figures: &BTreeMap<String, f64>) -> BTreeMap<String, f64> {
    let known = kind.vocabulary().outcomes.iter();
    known.filter_map(|outcome| Some((outcome.key(), outcome.unit.of_si(*figures.get(outcome.name)?)))).collect()
}

fn too_long(claims: &Claims, sink: &mut Sink) -> Option<Schedule> {
    let title = format!("the schedule lasts longer than {} h", MAX_DURATION_NS / 3_600_000_000_000);
    let diagnostic = Diagnostic::new(Code::E0604, title).label(claims.span, "the program lasts too long");
    sink.push(diagnostic.help("shorten its waits, or split the program into several"));
    None
}

/// Collects the runs of a program in one schedule.
struct ScheduleBuilder<'a> {
    claims: &'a Claims,
    sources: &'a Sources,
    channels: Vec<Channel>,
    index: BTreeMap<String, u32>,
    actuations: Vec<Actuation>,
    steps: Vec<ScheduledStep>,
    plans: Vec<PlanRecord>,
}

impl<'a> ScheduleBuilder<'a> {
    fn new(claims: &'a Claims, plans: &[Plan<Motion>], runs: &[LoweredRun], sources: &'a Sources) -> Self {
        let mut builder = ScheduleBuilder {
            claims,
            sources,
            channels: Vec::new(),
            index: BTreeMap::new(),
            actuations: Vec::new(),
            steps: Vec::new(),
            plans: Vec::new(),
        };
        for (job, plan) in claims.jobs.iter().zip(plans) {
            let is_own = |(other, _): &(&Job, &LoweredRun)| other.device == job.device;
            let mut own = claims.jobs.iter().zip(runs).filter(is_own).map(|(_, run)| run);
            for (channel, unit) in lowered(&plan.motion).channels(&mut own) {
                builder.channel(&job.device, &channel, unit);
            }
        }
        builder
    }

    fn channel(&mut self, device: &str, channel: &str, unit: ChannelUnit) {
        let name = format!("{device}.{channel}");
        if self.index.contains_key(&name) {
            return;
        }
        self.index.insert(name.clone(), self.channels.len() as u32);
        let wire = self.claims.wires.get(&name).cloned();
        self.channels.push(Channel { name, device: device.to_owned(), unit, wire, rest_v: 0.0 });
    }

    fn add(&mut self, job: usize, plan: &Plan<Motion>, mut run: LoweredRun, start_ns: u64) {
        let task = &self.claims.jobs[job];
        let first_step = self.steps.len() as u32;
        let indices: Vec<u32> =
            run.channels.iter().map(|channel| self.index[&format!("{}.{channel}", task.device)]).collect();
        for actuation in &mut run.actuations {
            actuation.channel = indices[actuation.channel as usize];
            actuation.start_ns += start_ns;
            actuation.step += first_step;
        }
        // There may be millions, which mostly belong to a single run.
        match self.actuations.is_empty() {
            true => self.actuations = std::mem::take(&mut run.actuations),
            false => self.actuations.append(&mut run.actuations),
        }
        for (nth, (span, at_ns, duration_ns)) in run.steps.iter().enumerate() {
            let over = run.states.partition_point(|state| state.t_ns <= at_ns + duration_ns);
            let end = over.checked_sub(1).map(|last| &run.states[last]);
            let reached = end.map_or_else(Vec::new, |end| reached(&task.order, nth, &end.state));
            let own = run.operations.iter().filter(|operation| operation.step == nth);
            let operations = own.map(|operation| self.operation(operation, start_ns)).collect();
            let step = self.step(job, *span, start_ns + at_ns, *duration_ns, reached);
            self.steps.push(ScheduledStep { operations, ..step });
        }
        self.plans.push(self.record(job, plan, run, start_ns));
    }

    fn step(&self, job: usize, span: Span, start_ns: u64, duration_ns: u64, reached: Vec<Reached>) -> ScheduledStep {
        let position = self.sources.position(span);
        ScheduledStep {
            task: self.claims.jobs[job].task.clone(),
            plan: job as u32,
            text: self.text(span),
            file: self.sources.file(span.file).name.clone(),
            line: position.line,
            column: position.column,
            start_ns,
            duration_ns,
            reached,
            operations: Vec::new(),
            span,
        }
    }

    fn operation(&self, operation: &LoweredOperation, run_ns: u64) -> ScheduledOperation {
        let LoweredOperation { span, ref parts, at, start_ns, arrival_ns, end_ns, .. } = *operation;
        let position = self.sources.position(span);
        ScheduledOperation {
            parts: parts.clone(),
            text: self.text(span),
            line: position.line,
            column: position.column,
            at,
            start_ns: run_ns + start_ns,
            arrival_ns: run_ns + arrival_ns,
            duration_ns: end_ns - start_ns,
            span,
        }
    }

    /// A piece of the program's text, on one line.
    fn text(&self, span: Span) -> String {
        self.sources.text(span).split_whitespace().collect::<Vec<_>>().join(" ")
    }

    fn record(&self, job: usize, plan: &Plan<Motion>, run: LoweredRun, start_ns: u64) -> PlanRecord {
        let task = &self.claims.jobs[job];
        let on_clock = |state: TimedState| TimedState { t_ns: start_ns + state.t_ns, ..state };
        PlanRecord {
            task: task.task.clone(),
            device: task.device.clone(),
            kind: task.kind(),
            planner: plan.planner.to_owned(),
            objective: plan.objective.to_owned(),
            unit: plan.unit.to_owned(),
            cost: plan.cost,
            bound: plan.bound,
            optimal: plan.proof == Optimality::Proven,
            outcomes: in_their_units(task.kind(), &plan.outcomes),
            bounds: in_their_units(task.kind(), &plan.bounds),
            start_ns,
            duration_ns: run.duration_ns,
            states: run.states.into_iter().map(on_clock).collect(),
            remarks: plan.remarks.clone(),
        }
    }

    fn finish(mut self, duration_ns: u64) -> Schedule {
        self.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
        Schedule {
            name: self.claims.name.clone(),
            source: SourceRef::of(self.sources),
            duration_ns,
            channels: self.channels,
            actuations: self.actuations,
            steps: self.steps,
            plans: self.plans,
            holds: Vec::new(),
            bench: self.claims.bench.clone(),
        }
    }
}
