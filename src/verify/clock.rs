//! Second round: the runs and steps of the schedule are those of the claims, and keep the timeline of the claims.
//!
//! Input: a schedule in which `form` found nothing. Output: a [`JudgedRun`] for each job, and the jobs in the order in
//! which devices execute them. Promise: if [`runs`] finds nothing, the steps of a run are those of its task, follow
//! each other without a gap from the run's start to its end, and contain all their actuations.

use super::evidence::Tally;
use super::form::is_auxiliary;
use super::rule::{Findings, Rule, Violation, ms};
use crate::claims::{Claims, Job, Timeline};
use crate::schedule::{Actuation, PlanRecord, Schedule, ScheduledStep};
use crate::source::Span;
use std::collections::BTreeMap;
use std::rc::Rc;

/// A job with its plan, steps and actuations in the schedule.
#[derive(Debug)]
pub(super) struct JudgedRun<'a> {
    pub schedule: &'a Schedule,
    pub job: &'a Job,
    pub plan: &'a PlanRecord,
    /// Indices into the schedule's steps, in order.
    pub steps: Vec<usize>,
    /// Place of each of the job's steps in the source.
    pub spans: Vec<Span>,
    /// By start, then channel.
    pub actuations: Vec<&'a Actuation>,
    pub tally: Rc<Tally>,
}

impl<'a> JudgedRun<'a> {
    /// The run's `nth` step, from 0.
    pub fn step(&self, nth: usize) -> &'a ScheduledStep {
        &self.schedule.steps[self.steps[nth]]
    }

    /// The first instant after the run.
    pub fn end_ns(&self) -> u64 {
        self.plan.end_ns()
    }

    /// A violation in a step of the run.
    pub fn violation(&self, rule: Rule, nth: usize, time_ns: u64, title: String) -> Violation {
        Violation::new(rule, time_ns, title).step(self.steps[nth]).label(self.spans[nth], "in this step")
    }

    /// A wait lasts as long as claimed.
    pub fn wait_lasts(&self, nth: usize, duration_ns: u64, findings: &mut Findings) {
        findings.count_checks(Rule::Wait, 1);
        let step = self.step(nth);
        if step.duration_ns != duration_ns {
            let title = format!("the wait lasts {}, but {} in the program", ms(step.duration_ns), ms(duration_ns));
            findings.push(self.violation(Rule::Wait, nth, step.start_ns, title));
        }
    }
}

/// Pairs jobs with plans, steps and actuations.
pub(super) fn runs<'a>(schedule: &'a Schedule, claims: &'a Claims, findings: &mut Findings) -> Vec<JudgedRun<'a>> {
    plans(schedule, claims, findings);
    if !findings.is_empty() {
        return Vec::new();
    }
    let runs = paired(schedule, claims, findings.tally());
    for run in &runs {
        steps(run, findings);
    }
    intervals(schedule, claims, findings);
    devices(schedule, claims, findings);
    runs
}

fn plans(schedule: &Schedule, claims: &Claims, findings: &mut Findings) {
    findings.count_checks(Rule::Plan, claims.jobs.len().max(1));
    let mut find = |time_ns, title| findings.push(Violation::new(Rule::Plan, time_ns, title));
    if schedule.name != claims.name {
        find(0, format!("the schedule is for `{}`, not for `{}`", schedule.name, claims.name));
    }
    if schedule.plans.len() != claims.jobs.len() {
        let (plans, jobs) = (schedule.plans.len(), claims.jobs.len());
        find(0, format!("the schedule has {plans} plans, but the program runs {jobs} tasks"));
    }
    for (index, (plan, job)) in schedule.plans.iter().zip(&claims.jobs).enumerate() {
        let (kind, claimed) = (plan.kind.name(), job.kind().name());
        let pairs = [("task", &*plan.task, &*job.task), ("device", &plan.device, &job.device), ("kind", kind, claimed)];
        for (what, recorded, claimed) in pairs.into_iter().filter(|(_, recorded, claimed)| recorded != claimed) {
            find(plan.start_ns, format!("plan {index} has the {what} `{recorded}`, but the program has `{claimed}`"));
        }
    }
}

fn paired<'a>(schedule: &'a Schedule, claims: &'a Claims, tally: &Rc<Tally>) -> Vec<JudgedRun<'a>> {
    let pair = |(plan, job)| {
        let (steps, spans, actuations) = (Vec::new(), Job::step_spans(job), Vec::new());
        JudgedRun { schedule, job, plan, steps, spans, actuations, tally: tally.clone() }
    };
    let mut runs: Vec<JudgedRun> = schedule.plans.iter().zip(&claims.jobs).map(pair).collect();
    for (index, step) in schedule.steps.iter().enumerate() {
        runs[step.plan as usize].steps.push(index);
    }
    for actuation in of_devices(schedule, claims).map(|(_, actuation)| actuation) {
        let step = &schedule.steps[actuation.step as usize];
        runs[step.plan as usize].actuations.push(actuation);
    }
    runs
}

/// The actuations on channels of devices, each with its index; auxiliary outputs have rules of their own.
fn of_devices<'a>(schedule: &'a Schedule, claims: &Claims) -> impl Iterator<Item = (usize, &'a Actuation)> {
    let is_device: Vec<bool> = schedule.channels.iter().map(|channel| !is_auxiliary(channel, claims)).collect();
    schedule.actuations.iter().enumerate().filter(move |(_, actuation)| is_device[actuation.channel as usize])
}

fn steps(run: &JudgedRun, findings: &mut Findings) {
    let (recorded, claimed) = (run.steps.len(), run.job.steps());
    findings.count_checks(Rule::Step, claimed.max(1));
    if recorded != claimed {
        let title = format!("the run of `{}` has {recorded} steps, but the task has {claimed}", run.job.task);
        findings.push(Violation::new(Rule::Step, run.plan.start_ns, title).label(run.job.span, "this task"));
        return;
    }
    let mut due_ns = run.plan.start_ns;
    for index in &run.steps {
        let step = &run.schedule.steps[*index];
        if step.task != run.job.task {
            let title =
                format!("step {index} belongs to the task `{}`, but is in a run of `{}`", step.task, run.job.task);
            findings.push(Violation::new(Rule::Step, step.start_ns, title).step(*index));
        }
        if step.start_ns != due_ns {
            let title = format!("step {index} starts at {}, but is due at {}", ms(step.start_ns), ms(due_ns));
            findings.push(Violation::new(Rule::Step, step.start_ns, title).step(*index));
        }
        due_ns = step.end_ns();
    }
    if due_ns != run.end_ns() {
        let title =
            format!("the run of `{}` ends at {}, but its steps end at {}", run.job.task, ms(run.end_ns()), ms(due_ns));
        findings.push(Violation::new(Rule::Step, run.end_ns(), title).label(run.job.run_span, "this run"));
    }
}

fn intervals(schedule: &Schedule, claims: &Claims, findings: &mut Findings) {
    findings.count_checks(Rule::Interval, of_devices(schedule, claims).count());
    for (index, actuation) in of_devices(schedule, claims) {
        let step = &schedule.steps[actuation.step as usize];
        let end_ns = step.end_ns();
        if actuation.start_ns < step.start_ns || actuation.end_ns() > end_ns {
            let title = format!(
                "actuation {index} lasts from {} to {}, outside its step from {} to {}",
                ms(actuation.start_ns),
                ms(actuation.end_ns()),
                ms(step.start_ns),
                ms(end_ns)
            );
            let violation = Violation::new(Rule::Interval, actuation.start_ns, title);
            findings.push(violation.step(actuation.step as usize));
        }
    }
}

fn devices(schedule: &Schedule, claims: &Claims, findings: &mut Findings) {
    for (index, actuation) in of_devices(schedule, claims) {
        let channel = &schedule.channels[actuation.channel as usize];
        let plan = &schedule.plans[schedule.steps[actuation.step as usize].plan as usize];
        if channel.device != plan.device {
            let title = format!(
                "actuation {index} is on `{}` of the device `{}`, but its run is on `{}`",
                channel.name, channel.device, plan.device
            );
            let violation = Violation::new(Rule::Interval, actuation.start_ns, title);
            findings.push(violation.step(actuation.step as usize));
        }
    }
}

/// The instant at which the last pulse of the program ends; 0 if there is none.
fn last_pulse_ns(runs: &[JudgedRun], claims: &Claims) -> u64 {
    let ends = runs.iter().flat_map(|run| {
        let pulses =
            run.job.events.iter().filter_map(|event| Some((event, claims.outputs.get(&event.output)?.pulse_ns?)));
        pulses.map(|(event, pulse_ns)| run.step(event.step).start_ns.saturating_add(pulse_ns))
    });
    ends.max().unwrap_or(0)
}

/// A run or a wait of the program, at the times that the timeline demands; a wait has no job.
pub(super) struct DueStretch {
    pub start_ns: u64,
    pub end_ns: u64,
    pub job: Option<usize>,
}

/// Checks when runs begin and end. Returns all runs and waits, those of one device in the order in which it executes
/// them.
pub(super) fn timeline(
    schedule: &Schedule,
    runs: &[JudgedRun],
    claims: &Claims,
    findings: &mut Findings,
) -> Vec<DueStretch> {
    let mut due = Vec::with_capacity(claims.jobs.len());
    let run_ns = walk(&claims.timeline, 0, schedule, claims, &mut due, findings);
    let end_ns = run_ns.max(last_pulse_ns(runs, claims));
    findings.count_checks(Rule::Timeline, claims.jobs.len() + 1);
    if schedule.duration_ns != end_ns {
        let last = if end_ns > run_ns { "last pulse" } else { "last run" };
        let title = format!("the schedule lasts {}, but its {last} ends at {}", ms(schedule.duration_ns), ms(end_ns));
        findings.push(Violation::new(Rule::Timeline, end_ns, title).label(claims.span, "this program"));
    }
    busy(schedule, claims, findings);
    due
}

/// The end of a part of the timeline that starts at `start_ns`; appends the part's runs and waits to `due`. Saturates
/// at the end of the clock, which no schedule can reach.
fn walk(
    part: &Timeline,
    start_ns: u64,
    schedule: &Schedule,
    claims: &Claims,
    due: &mut Vec<DueStretch>,
    findings: &mut Findings,
) -> u64 {
    match part {
        Timeline::Wait(duration_ns) => {
            let end_ns = start_ns.saturating_add(*duration_ns);
            due.push(DueStretch { start_ns, end_ns, job: None });
            end_ns
        }
        Timeline::Sequence(parts) => {
            parts.iter().fold(start_ns, |at_ns, part| walk(part, at_ns, schedule, claims, due, findings))
        }
        Timeline::Together(parts) => parts
            .iter()
            .fold(start_ns, |end_ns, part| end_ns.max(walk(part, start_ns, schedule, claims, due, findings))),
        Timeline::Run(job) => {
            let end_ns = start_ns.saturating_add(schedule.plans[*job].duration_ns);
            due.push(DueStretch { start_ns, end_ns, job: Some(*job) });
            let (plan, job) = (&schedule.plans[*job], &claims.jobs[*job]);
            if plan.start_ns != start_ns {
                let title = format!(
                    "the run of `{}` starts at {}, but is due at {}",
                    job.task,
                    ms(plan.start_ns),
                    ms(start_ns)
                );
                findings.push(Violation::new(Rule::Timeline, plan.start_ns, title).label(job.run_span, "this run"));
            }
            end_ns
        }
    }
}

fn busy(schedule: &Schedule, claims: &Claims, findings: &mut Findings) {
    let mut by_device: BTreeMap<&str, Vec<(&PlanRecord, &Job)>> = BTreeMap::new();
    for (plan, job) in schedule.plans.iter().zip(&claims.jobs).filter(|(plan, _)| plan.duration_ns > 0) {
        by_device.entry(&job.device).or_default().push((plan, job));
    }
    for (device, mut runs) in by_device {
        runs.sort_by_key(|(plan, _)| plan.start_ns);
        findings.count_checks(Rule::Busy, runs.len());
        for pair in runs.windows(2) {
            let ((first, one), (second, other)) = (pair[0], pair[1]);
            let end_ns = first.end_ns();
            if second.start_ns < end_ns {
                let title = format!(
                    "`{device}` begins `{}` at {}, but runs `{}` until {}",
                    other.task,
                    ms(second.start_ns),
                    one.task,
                    ms(end_ns)
                );
                let violation = Violation::new(Rule::Busy, second.start_ns, title);
                findings.push(violation.label(other.run_span, "this run").label(one.run_span, "overlaps this one"));
            }
        }
    }
}
