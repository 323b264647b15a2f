//! What the planner finds of saved programs, as editors show it.
//!
//! Planning may take long: it goes on elsewhere, by a [`ProgramPlanner`], and what comes of it arrives as a message. Tickets tell apart
//! what belongs to the text as it is from what belongs to one that was changed since.

use super::outline;
use super::text::{ColumnUnit, EditedText};
use crate::quantity::{Dimension, Quantity};
use crate::syntax::tree::{Item, Runnable};
use lsp_types::{
    Diagnostic, DiagnosticRelatedInformation, DiagnosticSeverity, InlayHint, InlayHintLabel, InlayHintTooltip,
    Location, MarkupContent, MarkupKind, NumberOrString, Range, Uri,
};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The notification by which a [`ProgramPlanner`] says what it found, with a [`PlanningResult`].
pub const PLANNED: &str = "$/tweeze/planned";

/// Plans saved programs beside the session; a caller that may start processes gives it.
pub trait ProgramPlanner {
    /// Begins to plan the program of a path as it is on the disk. What comes of it is sent to the session as [`PLANNED`].
    fn start(&mut self, path: &Path, ticket: u64);

    /// Gives up the program of a path.
    fn stop(&mut self, path: &Path);
}

/// What came of planning a program: the output of `tweeze check --plan --format json`.
#[derive(Debug, Serialize, Deserialize)]
pub struct PlanningResult {
    pub path: PathBuf,
    pub ticket: u64,
    /// Standard output: the report of success, if there is one.
    pub report: String,
    /// Standard error: a diagnostic in each line.
    pub findings: String,
    /// The limit after which it was given up, in seconds; `None` if it came to its end.
    pub limit_s: Option<u64>,
}

/// Plans of a program that is open.
#[derive(Debug, Default)]
pub struct ProgramPlans {
    /// By the name of the task or program.
    summaries: BTreeMap<String, String>,
    findings: Vec<PlannerFinding>,
    /// The limit after which the search was given up, in seconds.
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
}

#[derive(Debug, Deserialize)]
struct ReportedPlan {
    task: String,
    duration_ns: u64,
    summary: String,
}

/// A diagnostic of the compiler by its places as other programs read them.
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
    /// Reads what came of planning.
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
        ProgramPlans { summaries, findings, limit_s: result.limit_s }
    }

    /// Whether a finding was made.
    pub fn has_findings(&self) -> bool {
        !self.findings.is_empty()
    }

    /// What there is to say of the tasks and programs of a text, behind the heads of their declarations.
    pub fn hints(&self, text: &EditedText, within: Range, unit: ColumnUnit) -> Vec<InlayHint> {
        let tree = outline::tree(text.as_str());
        let hint = |Runnable { name, .. }: Runnable| {
            let given_up =
                || self.limit_s.map(|limit_s| format!("no plan within {limit_s} s; `tweeze build` has no limit"));
            let summary = &self.summaries.get(&name.text).cloned().or_else(given_up)?;
            let at = name.span.end as usize;
            let line = text.as_str()[at..].lines().next().unwrap_or_default();
            let position = text.position(at + line.trim_end().len(), unit);
            (within.start <= position && position <= within.end).then(|| InlayHint {
                position,
                label: InlayHintLabel::String(first_line(summary).to_owned()),
                kind: None,
                text_edits: None,
                tooltip: self.summary(&name.text).map(InlayHintTooltip::MarkupContent),
                padding_left: Some(true),
                padding_right: None,
                data: None,
            })
        };
        tree.items.iter().filter_map(Item::runnable).filter_map(hint).collect()
    }

    /// What there is to say of the task or program of a name.
    pub fn summary(&self, name: &str) -> Option<MarkupContent> {
        self.summaries.get(name).map(|summary| markdown(summary))
    }

    /// The planner's findings in a text, but for those that the checker has as well.
    pub fn diagnostics(
        &self,
        (path, uri): (&Path, &Uri),
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

impl ReportedSchedule {
    /// Its duration with what its runs cost, a line for each.
    fn summary(&self) -> String {
        let duration = duration(self.duration_ns);
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
    /// What the runs of its task in some schedules take and cost, a line for each that differs.
    fn summary(&self, schedules: &[ReportedSchedule]) -> String {
        let runs = schedules.iter().flat_map(|schedule| &schedule.plans).filter(|plan| plan.task == self.task);
        let mut lines: Vec<String> =
            runs.map(|plan| format!("{}, {}", duration(plan.duration_ns), plan.summary)).collect();
        lines.dedup();
        lines.join("\n")
    }
}

fn duration(duration_ns: u64) -> Quantity {
    Quantity::new(duration_ns as f64 / 1e9, Dimension::TIME)
}

fn first_line(text: &str) -> &str {
    text.lines().next().unwrap_or_default()
}

/// Lines as they are.
fn markdown(summary: &str) -> MarkupContent {
    MarkupContent { kind: MarkupKind::Markdown, value: format!("Planned and verified:\n```text\n{summary}\n```") }
}
