//! Report of a build: one line for each thing checked, planned, verified and written. [`LiveReport`] prints them as the
//! build proceeds.
//!
//! The text of a plan's line depends on the kind; it is in a file with the kind's name.

mod dimibot;
mod electrode_array;
mod fingers;
pub mod json;
mod live;
mod microrobots;

pub use live::{LiveReport, ReportedBuild, Totals};
pub use microrobots::suggest;

use super::terminal;
use crate::check::{DeclarationTally, KindFacts};
use crate::claims::{Claims, Job, Order};
use crate::device::each_kind;
use crate::diagnostic::Remark;
use crate::emit::Format;
use crate::plan::ENDED_EARLY;
use crate::quantity::{Dimension, Quantity, count};
use crate::schedule::cost::cost;
use crate::schedule::{PlanRecord, Schedule, ScheduledStep};
use std::collections::BTreeSet;
use std::path::PathBuf;

/// Greatest number of runs of a schedule, and of notes of one sort, that the report shows; the rest are counted.
const MAX_PLAN_LINES: usize = 20;

/// How much of a build is reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Detail {
    /// At most [`MAX_PLAN_LINES`] lines of a sort.
    Usual,
    /// Every line, and the search effort.
    Full,
}

impl Detail {
    fn most_lines(self) -> usize {
        match self {
            Detail::Usual => MAX_PLAN_LINES,
            Detail::Full => usize::MAX,
        }
    }
}

/// One run of a schedule.
struct ReportedRun<'a> {
    job: &'a Job,
    plan: &'a PlanRecord,
    /// The steps in the order of the task.
    steps: Vec<&'a ScheduledStep>,
}

impl<'a> ReportedRun<'a> {
    /// The planner's remarks on the plan itself, as opposed to its search.
    fn remarks(&self) -> impl Iterator<Item = &'a Remark> + use<'a> {
        self.plan.remarks.iter().filter(|remark| remark.subject != ENDED_EARLY)
    }
}

/// A further note on a run: its topic and its line.
type Note = (ReportTopic, String);

/// Topic of a note, in the order of the report.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum ReportTopic {
    Search,
    Visits,
    Nearest,
    Crosses,
    Waits,
    Guaranteed,
    Expected,
    Contacts,
    Remarked,
    Absent,
    Idle,
    Unwired,
}

impl ReportTopic {
    const ALL: [ReportTopic; 12] = [
        ReportTopic::Search,
        ReportTopic::Visits,
        ReportTopic::Nearest,
        ReportTopic::Crosses,
        ReportTopic::Waits,
        ReportTopic::Guaranteed,
        ReportTopic::Expected,
        ReportTopic::Contacts,
        ReportTopic::Remarked,
        ReportTopic::Absent,
        ReportTopic::Idle,
        ReportTopic::Unwired,
    ];

    fn label(self) -> &'static str {
        match self {
            ReportTopic::Search => "Search",
            ReportTopic::Visits => "Visits",
            ReportTopic::Nearest => "Nearest",
            ReportTopic::Crosses => "Crosses",
            ReportTopic::Waits => "Waits",
            ReportTopic::Guaranteed => "Assured",
            ReportTopic::Expected => "Expected",
            ReportTopic::Contacts => "Contacts",
            ReportTopic::Remarked => "Chosen",
            ReportTopic::Absent => "Absent",
            ReportTopic::Idle => "Idle",
            ReportTopic::Unwired => "Unwired",
        }
    }
}

/// Report of a plan by its kind; implemented by orders.
trait ReportedOrder {
    /// Notes on a run besides its cost.
    fn notes(&self, _run: &ReportedRun) -> Vec<Note> {
        Vec::new()
    }
}

/// Report of a device by its kind; implemented by the device's facts.
trait ReportedDevice {
    /// The device's lines, with everything that follows from its figures and the tasks that use it.
    fn describe(&self, name: &str, claims: &[Claims]) -> String;
}

fn reported(order: &Order) -> &dyn ReportedOrder {
    each_kind!(Order, order, order => order)
}

/// The lines of a device of a checked program.
pub fn device(name: &str, facts: &KindFacts, claims: &[Claims]) -> String {
    each_kind!(KindFacts, facts, facts => facts.describe(name, claims))
}

/// Result of writing a schedule to the disk.
pub struct WrittenSchedule {
    /// Paths of its files.
    pub paths: Vec<PathBuf>,
    /// The formats that cannot represent it, and why.
    pub left_out: Vec<(Format, String)>,
}

impl WrittenSchedule {
    fn names(&self) -> impl Iterator<Item = String> + '_ {
        self.paths.iter().map(|path| path.to_string_lossy().into_owned())
    }
}

/// Lines for a program without errors, and for the settings in force.
fn checked(file: &str, declared: DeclarationTally, settings_in_force: &[String], width: usize) -> String {
    terminal::line("Checked", file, width, &tally(declared)) + &settings(settings_in_force, width)
}

/// Line for a schedule that the verifier accepted.
fn verified(schedule: &Schedule, width: usize) -> String {
    let replayed = format!("{} replayed, 0 violations", count(schedule.actuations.len(), "actuation"));
    terminal::line("Verified", &schedule.name, width, &replayed)
}

/// Lines for the files of a schedule, and for the formats that have none.
fn wrote(schedule: &Schedule, written: &WrittenSchedule, width: usize) -> String {
    let (mut text, mut figures) = (String::new(), figures(schedule));
    for path in written.names() {
        text.push_str(&terminal::line("Wrote", &path, width, &figures));
        figures.clear();
    }
    for (format, why) in &written.left_out {
        text.push_str(&terminal::line("Left out", format.name(), width, why));
    }
    text
}

/// Width of the column of names, in characters.
pub fn width(names: impl Iterator<Item = String>) -> usize {
    names.map(|name| terminal::name(&name).chars().count()).max().unwrap_or(0)
}

/// A line for each setting in force: with it, the program differs from its text.
pub fn settings(settings: &[String], width: usize) -> String {
    let line =
        |setting: &String| terminal::line("With", &format!("--set {setting}"), width, "instead of its own value");
    settings.iter().map(line).collect()
}

/// Subjects of the lines of a schedule: the names of its runs, prefixed with the schedule's name if it differs.
fn subjects(claims: &Claims) -> impl Iterator<Item = String> + '_ {
    let subject = |job: &Job| match job.task == claims.name {
        true => job.task.clone(),
        false => format!("{}: {}", claims.name, job.task),
    };
    claims.jobs.iter().map(subject)
}

/// Cost of each run of a schedule, with further notes.
fn planned(schedule: &Schedule, claims: &Claims, width: usize, detail: Detail) -> String {
    let mut text = String::new();
    let runs = runs(schedule, claims);
    for (run, subject) in runs.iter().zip(subjects(claims)).take(detail.most_lines()) {
        text.push_str(&terminal::line("Planned", &subject, width, &cost(&run.job.order, run.plan)));
    }
    let more = runs.len().saturating_sub(detail.most_lines());
    if more > 0 {
        text.push_str(&terminal::line("", "", width, &format!("and {} more", count(more, "run"))));
    }
    let notes: Vec<Note> = runs
        .iter()
        .flat_map(|run| reported(&run.job.order).notes(run).into_iter().chain(ended(run)))
        .chain(idle(schedule))
        .chain(unwired(schedule))
        .collect();
    for topic in ReportTopic::ALL {
        let mut lines: Vec<&str> = Vec::new();
        for (_, line) in notes.iter().filter(|(other, _)| *other == topic) {
            if topic == ReportTopic::Visits || !lines.contains(&line.as_str()) {
                lines.push(line);
            }
        }
        for line in lines.iter().take(detail.most_lines()) {
            text.push_str(&terminal::line(topic.label(), "", width, line));
        }
        let more = lines.len().saturating_sub(detail.most_lines());
        if more > 0 {
            let more = count(more, "line");
            text.push_str(&terminal::line("", "", width, &format!("and {more} more; all are in the JSON schedule")));
        }
    }
    for [one, other] in &claims.not_held {
        let line = format!("`{one}` and `{other}` are not checked against each other: no scene places both");
        text.push_str(&terminal::line("Apart", "", width, &line));
    }
    text
}

fn runs<'a>(schedule: &'a Schedule, claims: &'a Claims) -> Vec<ReportedRun<'a>> {
    let run = |(plan, job)| ReportedRun { job, plan, steps: Vec::new() };
    let mut runs: Vec<ReportedRun> = schedule.plans.iter().zip(&claims.jobs).map(run).collect();
    for step in &schedule.steps {
        runs[step.plan as usize].steps.push(step);
    }
    runs
}

/// Notes on runs in which nothing is switched and nothing moves.
fn idle(schedule: &Schedule) -> Vec<Note> {
    let busy: BTreeSet<u32> =
        schedule.actuations.iter().map(|actuation| schedule.steps[actuation.step as usize].plan).collect();
    let is_idle = |(index, _): &(u32, &PlanRecord)| !busy.contains(index);
    let line = |(_, plan): (u32, &PlanRecord)| {
        (ReportTopic::Idle, format!("{}: 0 actuations; nothing is switched or moved", plan.task))
    };
    (0..).zip(&schedule.plans).filter(is_idle).map(line).collect()
}

/// Note on active channels without a wire on a bench whose instruments play the other channels.
fn unwired(schedule: &Schedule) -> Option<Note> {
    let acting: BTreeSet<u32> = schedule.actuations.iter().map(|actuation| actuation.channel).collect();
    let channels =
        (0..).zip(&schedule.channels).filter(|(index, channel)| channel.wire.is_none() && acting.contains(index));
    let names: Vec<&str> = channels.map(|(_, channel)| channel.name.as_str()).collect();
    let first = names.first().filter(|_| !schedule.bench.is_empty())?;
    let (all, verb, them) = match names.len() - 1 {
        0 => (first.to_string(), "has", "it"),
        more => (format!("{first} and {}", count(more, "other channel")), "have", "them"),
    };
    Some((ReportTopic::Unwired, format!("{all} {verb} no wire, so no instrument plays {them}")))
}

/// Note that the search for a plan was ended early.
fn ended(run: &ReportedRun) -> Option<Note> {
    let remark = run.plan.remarks.iter().find(|remark| remark.subject == ENDED_EARLY)?;
    Some((ReportTopic::Search, format!("{}: {}", run.job.task, remark.text)))
}

/// Notes on values that steps reach, if they differ from the goals.
fn reached<'a>(run: &'a ReportedRun) -> impl Iterator<Item = Note> + 'a {
    let all = run.steps.iter().flat_map(|step| &step.reached);
    all.filter(|reached| reached.is_off()).map(|reached| (ReportTopic::Nearest, reached.to_string()))
}

/// Figures of a schedule: `20 channels, 9 actuations, 135 ms, 270 mJ`; the energy only for kinds that count it.
fn figures(schedule: &Schedule) -> String {
    let energies: Vec<f64> = schedule.plans.iter().filter_map(|plan| plan.outcomes.get("energy_j")).copied().collect();
    let mut figures = format!(
        "{}, {}, {}",
        count(schedule.channels.len(), "channel"),
        count(schedule.actuations.len(), "actuation"),
        Quantity::time_ns(schedule.duration_ns),
    );
    if !energies.is_empty() {
        figures.push_str(&format!(", {}", Quantity::new(energies.iter().sum(), Dimension::ENERGY)));
    }
    figures
}

/// A length with its unit.
fn length(um: f64) -> String {
    Quantity::length_um(um).to_string()
}

/// `1 device, 1 scene, 2 tasks`.
pub fn tally(tally: DeclarationTally) -> String {
    let parts =
        [(tally.devices, "device"), (tally.scenes, "scene"), (tally.tasks, "task"), (tally.programs, "program")];
    let parts: Vec<String> = parts.into_iter().filter(|part| part.0 > 0).map(|(n, noun)| count(n, noun)).collect();
    if parts.is_empty() { "nothing declared".to_owned() } else { parts.join(", ") }
}
