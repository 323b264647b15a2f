//! The planner's results for saved programs, in the form that editors show.
//!
//! Planning may take long, so a [`ProgramPlanner`] runs it elsewhere and sends the result as a message. Tickets
//! distinguish results for the current text from results for an earlier one.

use super::text::{ColumnUnit, EditedText};
use crate::quantity::Quantity;
use lsp_types::{
    Diagnostic, DiagnosticRelatedInformation, DiagnosticSeverity, Location, MarkupContent, MarkupKind, NumberOrString,
    Range, Uri,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Method of the notification by which a [`ProgramPlanner`] sends a [`PlanningResult`].
pub const PLANNED: &str = "$/tweeze/planned";

/// Plans saved programs alongside the session; supplied by a caller that may start processes.
pub trait ProgramPlanner {
    /// Starts planning the program of a path as it is on the disk. The result is sent to the session as [`PLANNED`].
    fn start(&mut self, path: &Path, ticket: u64);

    /// Abandons the program of a path.
    fn stop(&mut self, path: &Path);
}

/// Result of planning a program: the output of `tweeze check --plan --format json`.
#[derive(Debug, Serialize, Deserialize)]
pub struct PlanningResult {
    pub path: PathBuf,
    pub ticket: u64,
    /// Standard output: the report of success, or empty.
    pub report: String,
    /// Standard error: one diagnostic per line.
    pub findings: String,
    /// Time limit after which planning was abandoned, in seconds; `None` if it ended.
    pub limit_s: Option<u64>,
}

/// Planning results of an open program.
#[derive(Debug, Default)]
pub struct ProgramPlans {
    /// Cost summary by the name of the task or program.
    summaries: BTreeMap<String, String>,
    /// By line and column in the program's own file.
    steps: BTreeMap<(usize, usize), PlannedStep>,
    findings: Vec<PlannerFinding>,
    /// Time limit after which planning was abandoned, in seconds.
    limit_s: Option<u64>,
}

#[derive(Debug, Deserialize)]
struct PlanningReport {
    schedules: Vec<ReportedSchedule>,
}

#[derive(Debug, Deserialize)]
struct ReportedSchedule {
    name: String,
    duration_ns: u64,
    plans: Vec<ReportedPlan>,
    steps: Vec<ReportedStep>,
}

/// One execution of a step.
#[derive(Debug, Deserialize)]
struct ReportedStep {
    file: String,
    line: usize,
    column: usize,
    duration_ns: u64,
    /// Cost in the kind's own unit, such as `4 switches`.
    takes: Option<String>,
    reached: Vec<ReportedValue>,
}

/// A value that a step reaches and that differs from the one asked for.
#[derive(Debug, Deserialize)]
struct ReportedValue {
    value: String,
    text: String,
}

/// A step of a text with all its runs; there are several in a loop, or if its task is run several times.
#[derive(Debug)]
pub struct PlannedStep {
    /// Line, from 1.
    pub line: usize,
    /// Column in characters, from 1.
    pub column: usize,
    /// Never empty.
    runs: Vec<ReportedStep>,
}

#[derive(Debug, Deserialize)]
struct ReportedPlan {
    task: String,
    duration_ns: u64,
    summary: String,
}

/// A diagnostic of the compiler as its JSON form has it.
#[derive(Debug, Deserialize)]
struct PlannerFinding {
    code: String,
    severity: String,
    title: String,
    help: Option<String>,
    labels: Vec<LabelledPlace>,
}

/// Lines and columns from 1, columns in characters.
#[derive(Debug, Deserialize)]
struct LabelledPlace {
    file: String,
    line: usize,
    column: usize,
    end_line: usize,
    end_column: usize,
    text: String,
}

impl ProgramPlans {
    /// Parses a planning result.
    pub fn of(result: &PlanningResult) -> ProgramPlans {
        let report: Option<PlanningReport> = serde_json::from_str(&result.report).ok();
        let schedules = report.map_or_else(Vec::new, |report| report.schedules);
        let mut summaries: BTreeMap<String, String> =
            schedules.iter().map(|schedule| (schedule.name.clone(), schedule.summary())).collect();
        // A task that a program runs has no schedule of its own.
        for plan in schedules.iter().flat_map(|schedule| &schedule.plans) {
            summaries.entry(plan.task.clone()).or_insert_with(|| plan.summary(&schedules));
        }
        let findings = result.findings.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
        let own = result.path.file_name().unwrap_or_default();
        let mut steps: BTreeMap<(usize, usize), PlannedStep> = BTreeMap::new();
        for step in schedules.into_iter().flat_map(|schedule| schedule.steps).filter(|step| step.file.as_str() == own) {
            let (line, column) = (step.line, step.column);
            let place = steps.entry((line, column)).or_insert(PlannedStep { line, column, runs: Vec::new() });
            place.runs.push(step);
        }
        ProgramPlans { summaries, steps, findings, limit_s: result.limit_s }
    }

    /// Whether there are figures to show in the text.
    pub fn has_hints(&self) -> bool {
        !self.summaries.is_empty() || self.limit_s.is_some()
    }

    /// Whether the planner found anything.
    pub fn has_findings(&self) -> bool {
        !self.findings.is_empty()
    }

    /// Hint for the task or program of a name, with a tooltip.
    pub fn head(&self, name: &str) -> Option<(String, Option<MarkupContent>)> {
        let given_up =
            || self.limit_s.map(|limit_s| format!("no plan within {limit_s} s; `tweeze build` has no limit"));
        let summary = self.summaries.get(name).cloned().or_else(given_up)?;
        Some((first_line(&summary).to_owned(), self.summary(name)))
    }

    /// The planned steps, in text order.
    pub fn steps(&self) -> impl Iterator<Item = &PlannedStep> {
        self.steps.values()
    }

    /// Summary for the task or program of a name.
    pub fn summary(&self, name: &str) -> Option<MarkupContent> {
        self.summaries.get(name).map(|summary| markdown(summary))
    }

    /// The planner's findings in a text, without those that the checker also has.
    pub fn diagnostics(
        &self,
        path: &Path,
        uri: &Uri,
        text: &EditedText,
        unit: ColumnUnit,
        known: &[Diagnostic],
    ) -> Vec<Diagnostic> {
        let own = |place: &LabelledPlace| Path::new(&place.file) == path;
        let range = |place: &LabelledPlace| {
            let [start, end] = [(place.line, place.column), (place.end_line, place.end_column)]
                .map(|(line, column)| text.position(text.offset_of_character(line - 1, column - 1), unit));
            Range { start, end }
        };
        let shown = |finding: &PlannerFinding| {
            let (first, others) = finding.labels.split_first()?;
            let mut message = finding.title.clone();
            if !own(first) {
                message = format!("{}:{}: {message}", first.file, first.line);
            }
            let help = finding.help.iter().map(|help| format!("help: {help}"));
            let lines = Some(first.text.clone()).filter(|text| !text.is_empty()).into_iter().chain(help);
            lines.for_each(|line| message.push_str(&format!("\n{line}")));
            let related = others.iter().filter(|place| own(place)).map(|place| DiagnosticRelatedInformation {
                location: Location { uri: uri.clone(), range: range(place) },
                message: place.text.clone(),
            });
            Some(Diagnostic {
                range: if own(first) { range(first) } else { Range::default() },
                severity: Some(match finding.severity.as_str() {
                    "warning" => DiagnosticSeverity::WARNING,
                    _ => DiagnosticSeverity::ERROR,
                }),
                code: Some(NumberOrString::String(finding.code.clone())),
                source: Some("tweeze".to_owned()),
                message,
                related_information: Some(related.collect()),
                ..Diagnostic::default()
            })
        };
        let is_new = |found: &Diagnostic| !known.iter().any(|one| one.code == found.code && one.range == found.range);
        self.findings.iter().filter_map(shown).filter(is_new).collect()
    }
}

impl ReportedStep {
    /// Duration and cost: `60 ms, 4 switches`.
    fn cost(&self) -> String {
        let takes = self.takes.iter().map(|takes| format!(", {takes}"));
        format!("{}{}", Quantity::time_ns(self.duration_ns), takes.collect::<String>())
    }

    /// Duration and cost, optionally with the values reached.
    fn line(&self, with_reached: bool) -> String {
        let reached =
            self.reached.iter().filter(|_| with_reached).map(|reached| format!(", reaches {}", reached.value));
        self.cost() + &reached.collect::<String>()
    }
}

/// Greatest number of runs of a step that its tooltip lists.
const MAX_RUNS: usize = 20;

impl PlannedStep {
    /// Hint of the step: its cost, optionally with the values reached; the shortest and the longest time if its runs
    /// differ in time.
    pub fn line_text(&self, with_reached: bool) -> String {
        let mut lines: Vec<String> = self.runs.iter().map(|run| run.line(with_reached)).collect();
        lines.dedup();
        let times = || self.runs.iter().map(|run| run.duration_ns);
        match (lines.as_slice(), times().min(), times().max()) {
            ([_, _, ..], Some(least), Some(most)) if least < most => {
                format!("{} to {}", Quantity::time_ns(least), Quantity::time_ns(most))
            }
            ([first, _, ..], ..) => format!("{first} …"),
            (lines, ..) => lines.concat(),
        }
    }

    /// Lists each run that differs from the one before, with the values that it reaches.
    pub fn tooltip(&self) -> MarkupContent {
        let mut lines: Vec<String> = Vec::new();
        for run in &self.runs {
            let reached = run.reached.iter().map(|reached| format!("\n  {}", reached.text));
            lines.push(run.cost() + &reached.collect::<String>());
        }
        lines.dedup();
        if lines.len() > MAX_RUNS {
            let more = lines.len() - MAX_RUNS;
            lines.truncate(MAX_RUNS);
            lines.push(format!("and {more} more"));
        }
        markdown(&lines.join("\n"))
    }
}

impl ReportedSchedule {
    /// Duration of the schedule and the cost of its runs, one line each.
    fn summary(&self) -> String {
        let duration = Quantity::time_ns(self.duration_ns);
        match self.plans.as_slice() {
            [plan] => format!("{duration}, {}", plan.summary),
            plans => {
                let lines = plans.iter().map(|plan| format!("\n{}: {}", plan.task, plan.summary));
                format!("{duration} in {} runs{}", plans.len(), lines.collect::<String>())
            }
        }
    }
}

impl ReportedPlan {
    /// Duration and cost of each run of its task in some schedules, one line each; equal neighbours are listed once.
    fn summary(&self, schedules: &[ReportedSchedule]) -> String {
        let runs = schedules.iter().flat_map(|schedule| &schedule.plans).filter(|plan| plan.task == self.task);
        let mut lines: Vec<String> =
            runs.map(|plan| format!("{}, {}", Quantity::time_ns(plan.duration_ns), plan.summary)).collect();
        lines.dedup();
        lines.join("\n")
    }
}

fn first_line(text: &str) -> &str {
    text.lines().next().unwrap_or_default()
}

/// A preformatted block of lines.
fn markdown(summary: &str) -> MarkupContent {
    MarkupContent { kind: MarkupKind::Markdown, value: format!("Planned and verified:\n```text\n{summary}\n```") }
}
