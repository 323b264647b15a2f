//! Turns diagnostics into text: the only place that knows miette.

use super::excerpt::{CONTEXT_LINES, Excerpt};
use super::plain::{plain, plain_lines};
use super::{Diagnostic, Label, Severity};
use crate::source::{FileId, Sources};
use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, ThemeCharacters, ThemeStyles};
use std::fmt;

/// How a report looks.
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

/// Characters with which a report is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Characters {
    Ascii,
    Unicode,
}

/// The columns that a report has at least, however narrow the terminal.
pub const MIN_WIDTH: usize = 40;

/// One diagnostic for a person: code, title, the source with every place labelled, help.
pub fn human(diagnostic: &Diagnostic, sources: &Sources, look: Look) -> String {
    let mut text = String::new();
    let report = report(diagnostic, sources);
    if handler(look).render_report(&mut text, &report).is_err() {
        text = format!("{} {}\n", diagnostic.code, plain(&diagnostic.title));
    }
    text
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

/// A diagnostic as miette sees it: the labels of one file, further files as related reports.
struct MietteReport {
    head: Option<(String, Severity)>,
    title: String,
    help: Option<String>,
    source: Option<Excerpt>,
    labels: Vec<LabeledSpan>,
    related: Vec<MietteReport>,
}

fn report(diagnostic: &Diagnostic, sources: &Sources) -> MietteReport {
    let mut files: Vec<FileId> = Vec::new();
    for label in &diagnostic.labels {
        if !files.contains(&label.span.file) {
            files.push(label.span.file);
        }
    }
    let mut parts = files.into_iter().map(|file| {
        let labels: Vec<&Label> = diagnostic.labels.iter().filter(|label| label.span.file == file).collect();
        Excerpt::of(sources.file(file), &labels)
    });
    let (source, labels) = parts.next().unzip();
    let related = parts.map(|(source, labels)| MietteReport {
        head: None,
        title: format!("see also {}", source.name()),
        help: None,
        source: Some(source),
        labels,
        related: Vec::new(),
    });
    MietteReport {
        head: Some((diagnostic.code.name().to_owned(), diagnostic.code.severity())),
        title: plain(&diagnostic.title).into_owned(),
        help: diagnostic.help.as_deref().map(plain_lines),
        related: related.collect(),
        source,
        labels: labels.unwrap_or_default(),
    }
}

impl fmt::Display for MietteReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.title)
    }
}

impl fmt::Debug for MietteReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.title)
    }
}

impl std::error::Error for MietteReport {}

impl miette::Diagnostic for MietteReport {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.head.as_ref().map(|(code, _)| Box::new(code) as Box<dyn fmt::Display>)
    }

    fn severity(&self) -> Option<miette::Severity> {
        Some(match self.head {
            Some((_, Severity::Error)) => miette::Severity::Error,
            Some((_, Severity::Warning)) => miette::Severity::Warning,
            None => miette::Severity::Advice,
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

    fn related<'a>(&'a self) -> Option<Box<dyn Iterator<Item = &'a dyn miette::Diagnostic> + 'a>> {
        if self.related.is_empty() {
            return None;
        }
        Some(Box::new(self.related.iter().map(|report| report as &dyn miette::Diagnostic)))
    }
}
