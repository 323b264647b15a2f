//! What the page of a program shows that could not be built: its errors, at their lines and in the scene.

use crate::claims::Claims;
use crate::diagnostic::{Code, Diagnostic, Label, PlaceUnit, Sink, WrittenPlace, machine};
use crate::source::Sources;
use crate::verify::Verified;
use serde::Serialize;

/// Ending of the page of a program that could not be built, after the name of its file.
pub const FAILED_ENDING: &str = "failed.html";

/// Errors and warnings that such a page lists.
const MAX_FINDINGS: usize = 50;

/// Why a program could not be built.
#[derive(Serialize)]
pub(super) struct PageFailure<'a> {
    findings: Vec<PageFinding<'a>>,
    /// Errors and warnings that are not listed.
    more: usize,
    places: Vec<PagePlace<'a>>,
}

#[derive(Serialize)]
struct PageFinding<'a> {
    code: Code,
    severity: &'static str,
    title: &'a str,
    help: Option<&'a str>,
    labels: Vec<PageLabel<'a>>,
}

/// Lines and columns as people count them, columns in characters; the end is the place after the last character.
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
    /// The part of it that could be built, with the claims of the whole where they could be made.
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
            findings: sorted.iter().take(MAX_FINDINGS).map(|diagnostic| self.finding(diagnostic)).collect(),
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

    fn finding<'a>(&'a self, diagnostic: &'a Diagnostic) -> PageFinding<'a> {
        PageFinding {
            code: diagnostic.code,
            severity: machine::severity(diagnostic.code),
            title: &diagnostic.title,
            help: diagnostic.help.as_deref(),
            labels: diagnostic.labels.iter().map(|label| self.label(label)).collect(),
        }
    }

    fn label<'a>(&'a self, label: &'a Label) -> PageLabel<'a> {
        let file = self.sources.file(label.span.file);
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
}
