//! Renders diagnostics as text; the only module that uses miette.

use super::excerpt::{CONTEXT_LINES, Excerpt};
use super::plain::{plain, plain_lines};
use super::{Diagnostic, Label, Severity, Sink};
use crate::quantity::count;
use crate::source::{FileId, Sources};
use console::Style;
use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, ThemeCharacters, ThemeStyles};
use std::fmt;

/// Appearance of a report.
#[derive(Debug, Clone, Copy)]
pub struct Look {
    pub colour: Colour,
    pub characters: Characters,
    /// Columns of the terminal.
    pub width: usize,
}

/// Whether a report is coloured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Colour {
    Plain,
    Ansi,
}

/// Characters that a report is drawn with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Characters {
    Ascii,
    Unicode,
}

/// Least number of columns of a report, however narrow the terminal.
pub const MIN_WIDTH: usize = 40;

/// One diagnostic for people: severity, code and title on one line, the source with every place labelled, and the help.
pub fn human(diagnostic: &Diagnostic, sources: &Sources, look: Look) -> String {
    let mut text = title(diagnostic, look.colour);
    let handler = handler(look);
    for part in parts(diagnostic, sources) {
        let mut drawn = String::new();
        if handler.render_report(&mut drawn, &part).is_ok() {
            // miette's first line is for the title, which is empty here.
            text.push_str(drawn.split_once('\n').map_or("", |(_, body)| body));
        }
    }
    text
}

/// The title with its code, on one line of any length; the terminal wraps it.
fn title(diagnostic: &Diagnostic, colour: Colour) -> String {
    let bold = Style::new().bold().force_styling(colour == Colour::Ansi);
    let (word, style) = match diagnostic.code.severity() {
        Severity::Error => ("error", bold.clone().red()),
        Severity::Warning => ("warning", bold.clone().yellow()),
    };
    let head = style.apply_to(format!("{word}[{}]", diagnostic.code.name()));
    format!("{head}{}\n", bold.apply_to(format!(": {}", plain(&diagnostic.title))))
}

/// Counts of a sink: `2 errors, 1 warning`; `None` if it is empty.
pub fn counted(sink: &Sink) -> Option<String> {
    let warnings = sink.sorted().iter().filter(|diagnostic| !diagnostic.is_error()).count();
    let counts = [(sink.errors(), "error"), (warnings, "warning")].into_iter().filter(|one| one.0 > 0);
    let counts: Vec<String> = counts.map(|(number, noun)| count(number, noun)).collect();
    (!counts.is_empty()).then(|| counts.join(", "))
}

fn handler(look: Look) -> GraphicalReportHandler {
    let characters = match look.characters {
        Characters::Unicode => ThemeCharacters::unicode(),
        Characters::Ascii => ThemeCharacters::ascii(),
    };
    let styles = match look.colour {
        Colour::Ansi => ThemeStyles::ansi(),
        Colour::Plain => ThemeStyles::none(),
    };
    GraphicalReportHandler::new_themed(GraphicalTheme { characters, styles })
        .with_width(look.width.max(MIN_WIDTH))
        .with_links(false)
        .with_context_lines(CONTEXT_LINES)
}

/// A part of a diagnostic in miette's form: the labels of one file, or only the help.
struct MietteReport {
    severity: Severity,
    help: Option<String>,
    source: Option<Excerpt>,
    labels: Vec<LabeledSpan>,
}

/// One part for each labelled file; the help is in the last part.
fn parts(diagnostic: &Diagnostic, sources: &Sources) -> Vec<MietteReport> {
    let severity = diagnostic.code.severity();
    let mut files: Vec<FileId> = Vec::new();
    for label in &diagnostic.labels {
        if !files.contains(&label.span.file) {
            files.push(label.span.file);
        }
    }
    let part = |file: FileId| {
        let labels: Vec<&Label> = diagnostic.labels.iter().filter(|label| label.span.file == file).collect();
        let (source, labels) = Excerpt::of(sources.file(file), &labels);
        MietteReport { severity, help: None, source: Some(source), labels }
    };
    let mut parts: Vec<MietteReport> = files.into_iter().map(part).collect();
    if let Some(help) = diagnostic.help.as_deref().map(plain_lines) {
        if parts.is_empty() {
            parts.push(MietteReport { severity, help: None, source: None, labels: Vec::new() });
        }
        parts.last_mut().into_iter().for_each(|last| last.help = Some(help.clone()));
    }
    parts
}

impl fmt::Display for MietteReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The title is printed above all parts.
        f.write_str("")
    }
}

impl fmt::Debug for MietteReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl std::error::Error for MietteReport {}

impl miette::Diagnostic for MietteReport {
    fn severity(&self) -> Option<miette::Severity> {
        Some(match self.severity {
            Severity::Error => miette::Severity::Error,
            Severity::Warning => miette::Severity::Warning,
        })
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|help| Box::new(help) as Box<dyn fmt::Display>)
    }

    fn source_code(&self) -> Option<&dyn miette::SourceCode> {
        self.source.as_ref().map(|source| source as &dyn miette::SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        (!self.labels.is_empty())
            .then(|| Box::new(self.labels.iter().cloned()) as Box<dyn Iterator<Item = LabeledSpan>>)
    }
}
