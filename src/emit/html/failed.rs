//! Pages of failures. For a program that could not be built, the page shows its errors, at their lines and in the
//! scene; for a refused log, the rules that it breaks, at their instants.

use crate::claims::Claims;
use crate::diagnostic::{CellRun, Code, Diagnostic, Label, PlaceUnit, Reach, ReachExtent, Sink, WrittenPlace, machine};
use crate::schedule::Schedule;
use crate::source::Sources;
use crate::verify::{Verified, Violation};
use serde::Serialize;

/// Ending of the page of a program that could not be built, after the name of its file.
pub const FAILED_ENDING: &str = "failed.html";

/// Most errors and warnings that a page lists.
const MAX_FINDINGS: usize = 50;

/// Reason why a program could not be built, or a log was refused.
#[derive(Serialize)]
pub(super) struct PageFailure<'a> {
    /// Whether it is a log, which is shown as it is although it was refused.
    is_refused: bool,
    findings: Vec<PageFinding<'a>>,
    /// Number of errors and warnings not listed.
    more: usize,
    places: Vec<PagePlace<'a>>,
}

#[derive(Serialize)]
struct PageFinding<'a> {
    code: Code,
    severity: &'static str,
    title: &'a str,
    help: Option<&'a str>,
    /// The instant at which a rule is broken.
    t_ns: Option<u64>,
    labels: Vec<PageLabel<'a>>,
    /// The progress of the search for a plan, where it can be shown.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    reaches: Vec<PageReach<'a>>,
}

#[derive(Serialize)]
struct PageReach<'a> {
    device: &'a str,
    what: &'a str,
    #[serde(flatten)]
    extent: PageExtent,
}

#[derive(Serialize)]
#[serde(untagged)]
enum PageExtent {
    /// Each a row with its first and last column.
    Cells {
        runs: Vec<[u32; 3]>,
    },
    Turn {
        plane: &'static str,
        reached_deg: f64,
        asked_deg: f64,
    },
    /// x and y in micrometres, heading in radians.
    Pose {
        pose: [f64; 3],
    },
}

impl<'a> PageReach<'a> {
    fn of(diagnostic: &'a Diagnostic, reach: &'a Reach) -> PageReach<'a> {
        let run = |CellRun { row, columns: [first, last] }: &CellRun| [*row, *first, *last];
        let extent = match &reach.extent {
            ReachExtent::Cells(runs) => PageExtent::Cells { runs: runs.iter().map(run).collect() },
            &ReachExtent::Turn { plane, reached_deg, asked_deg } => PageExtent::Turn { plane, reached_deg, asked_deg },
            &ReachExtent::Pose(pose) => PageExtent::Pose { pose },
        };
        PageReach { device: diagnostic.device.as_deref().unwrap_or_default(), what: &reach.what, extent }
    }
}

/// Lines and columns from 1, columns in characters; the end is after the last character.
#[derive(Serialize)]
struct PageLabel<'a> {
    file: &'a str,
    line: u32,
    column: u32,
    end_line: u32,
    end_column: u32,
    text: &'a str,
}

#[derive(Serialize)]
struct PagePlace<'a> {
    file: &'a str,
    line: u32,
    device: Option<&'a str>,
    unit: &'static str,
    at: [f64; 2],
}

/// A program that could not be built, to be shown.
pub struct FailedProgram<'a> {
    /// The part of it that could be built, with the claims of the whole program if they could be derived.
    pub part: Option<(&'a Verified, Option<&'a Claims>)>,
    pub errors: &'a Sink,
    /// The places in the scene that the errors are about.
    pub places: &'a [WrittenPlace],
    pub sources: &'a Sources,
}

impl FailedProgram<'_> {
    pub(super) fn failure(&self) -> PageFailure<'_> {
        let sorted = self.errors.sorted();
        PageFailure {
            is_refused: false,
            findings: sorted.iter().take(MAX_FINDINGS).map(|error| finding(error, self.sources, None)).collect(),
            more: sorted.len().saturating_sub(MAX_FINDINGS) + self.errors.dropped(),
            places: self.places.iter().map(|place| self.place(place)).collect(),
        }
    }

    fn place<'a>(&'a self, place: &'a WrittenPlace) -> PagePlace<'a> {
        PagePlace {
            file: &self.sources.file(place.span.file).name,
            line: self.sources.position(place.span).line,
            device: place.device.as_deref(),
            unit: match place.unit {
                PlaceUnit::Cells => "cells",
                PlaceUnit::Micrometres => "um",
            },
            at: place.at,
        }
    }
}

/// A schedule that the verifier refused, to be shown.
pub struct RefusedSchedule<'a> {
    /// `None` if its parts do not fit together, so that nothing of it can be shown.
    schedule: Option<&'a Schedule>,
    claims: &'a Claims,
    /// Violations with their instants; those of the execution come before those of recorded figures, each group in
    /// order of time.
    violations: Vec<(u64, Diagnostic)>,
    sources: &'a Sources,
}

impl<'a> RefusedSchedule<'a> {
    /// The violations of a schedule; `is_whole` says whether the schedule can be shown at all.
    pub fn new(
        schedule: &'a Schedule,
        is_whole: bool,
        claims: &'a Claims,
        violations: Vec<Violation>,
        sources: &'a Sources,
    ) -> RefusedSchedule<'a> {
        let mut violations = violations;
        // A wrong pulse also makes recorded figures wrong, which say little about the cause.
        violations.sort_by_key(|violation| violation.rule.is_of_the_record());
        let violations = violations.into_iter().map(|violation| (violation.time_ns, violation.into())).collect();
        RefusedSchedule { schedule: is_whole.then_some(schedule), claims, violations, sources }
    }

    pub(super) fn shown(&self) -> Option<(&Schedule, &Claims)> {
        Some((self.schedule?, self.claims))
    }

    pub(super) fn failure(&self) -> PageFailure<'_> {
        let listed = self.violations.iter().take(MAX_FINDINGS);
        PageFailure {
            is_refused: true,
            findings: listed.map(|(t_ns, broken)| finding(broken, self.sources, Some(*t_ns))).collect(),
            more: self.violations.len().saturating_sub(MAX_FINDINGS),
            places: Vec::new(),
        }
    }
}

fn finding<'a>(diagnostic: &'a Diagnostic, sources: &'a Sources, t_ns: Option<u64>) -> PageFinding<'a> {
    PageFinding {
        code: diagnostic.code,
        severity: machine::severity(diagnostic.code),
        title: &diagnostic.title,
        help: diagnostic.help.as_deref(),
        t_ns,
        labels: diagnostic.labels.iter().map(|label| written_label(label, sources)).collect(),
        reaches: diagnostic.reaches.iter().map(|reach| PageReach::of(diagnostic, reach)).collect(),
    }
}

fn written_label<'a>(label: &'a Label, sources: &'a Sources) -> PageLabel<'a> {
    let file = sources.file(label.span.file);
    let (start, end) = (file.position(label.span.start), file.position(label.span.end));
    PageLabel {
        file: &file.name,
        line: start.line,
        column: start.column,
        end_line: end.line,
        end_column: end.column,
        text: &label.text,
    }
}
