//! Diagnostics: one form for every stage, collected in a [`Sink`].
//!
//! A stage pushes [`Diagnostic`]s and continues; it never prints. `code` is the table of codes; `render` turns a
//! diagnostic into text for people, `machine` into text for programs.

pub mod code;
mod excerpt;
pub mod machine;
mod place;
pub mod plain;
pub mod render;

pub use code::{Code, Severity};
pub use place::{CellRun, PlaceUnit, Reach, ReachExtent, WrittenPlace};

use crate::source::Span;
use rustc_hash::FxHashSet;
use serde::Serialize;

/// A span of the source with a text.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Label {
    pub span: Span,
    pub text: String,
}

/// One error or warning.
///
/// The title is lower case without a full stop and names the fault, with the number, its unit and the limit. The first
/// label is the place itself; further ones explain the conflict. The help is the fix.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diagnostic {
    pub code: Code,
    pub title: String,
    pub labels: Vec<Label>,
    pub help: Option<String>,
    /// The edits that the help describes, if they are known exactly; they belong together, are in order, do not
    /// overlap, and are all in one file.
    #[serde(skip)]
    pub fix: Vec<SourceEdit>,
    /// The device that has no plan, if the diagnostic is about that.
    #[serde(skip)]
    pub device: Option<String>,
    /// How far the search for a plan came, if that can be shown.
    #[serde(skip)]
    pub reaches: Vec<Reach>,
    /// Replacement for a proof that there is no plan, if the proof does not hold for every start of the task.
    #[serde(skip)]
    pub weaker_form: Option<Box<Diagnostic>>,
}

/// Added to the help for a task that begins at a place that the planner chose for the end of an earlier one.
const FROM_ONE_START: &str = "the plan of an earlier task chose where this one begins, and it may have a plan from another place: name the place in the earlier task, or merge both tasks into one";

/// A result, or the one diagnostic that prevents it; boxed, because a diagnostic is far larger than most results.
pub type Diagnosed<T = ()> = Result<T, Box<Diagnostic>>;

/// A replacement of the text of a span; an empty span is an insertion.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SourceEdit {
    pub span: Span,
    pub text: String,
}

impl Diagnostic {
    /// A diagnostic without labels.
    pub fn new(code: Code, title: impl Into<String>) -> Self {
        Diagnostic {
            code,
            title: title.into(),
            labels: Vec::new(),
            help: None,
            fix: Vec::new(),
            device: None,
            reaches: Vec::new(),
            weaker_form: None,
        }
    }

    /// Sets the diagnostic that replaces this one if it is not a proof.
    #[must_use]
    pub fn with_weaker_form(self, rest: Diagnostic) -> Self {
        Diagnostic { weaker_form: Some(Box::new(rest)), ..self }
    }

    /// The diagnostic for a task whose start is only one of several possible ones: it proves nothing, and the help says
    /// so.
    fn weakened(self) -> Self {
        let weaker = match (self.code, self.weaker_form) {
            (_, Some(rest)) => *rest,
            (Code::E0601, None) => Diagnostic { code: Code::E0602, weaker_form: None, ..self },
            (_, None) => return Diagnostic { weaker_form: None, ..self },
        };
        let help = weaker.help.as_ref().map_or(String::new(), |help| format!("{help}; "));
        let help = format!("{help}{FROM_ONE_START}");
        Diagnostic { help: Some(help), ..weaker }
    }

    /// Adds a label; the diagnostic points at the first one.
    #[must_use]
    pub fn label(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// Adds a label unless its span is already labelled, as may happen in a `for`.
    #[must_use]
    pub fn label_elsewhere(self, span: Span, labelled: Span, text: impl Into<String>) -> Self {
        if span == labelled { self } else { self.label(span, text) }
    }

    /// Sets the help.
    #[must_use]
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }

    /// Adds how far the search for a plan came, if it is known.
    #[must_use]
    pub fn reached(mut self, reaches: impl IntoIterator<Item = Reach>) -> Self {
        self.reaches.extend(reaches);
        self
    }

    /// Sets the help to ask whether a similar word was meant, and the fix to write it at the first label.
    #[must_use]
    pub fn near(self, near: &str) -> Self {
        let edit = self.span().map(|span| SourceEdit { span, text: near.to_owned() });
        Diagnostic { fix: edit.into_iter().collect(), ..self.help(format!("did you mean `{near}`?")) }
    }

    /// Adds an edit to the fix that the help describes.
    #[must_use]
    pub fn with_fix(mut self, span: Span, text: impl Into<String>) -> Self {
        self.fix.push(SourceEdit { span, text: text.into() });
        self
    }

    /// As [`Self::with_fix`], at the first label.
    #[must_use]
    pub fn with_fix_here(self, text: impl Into<String>) -> Self {
        match self.span() {
            Some(span) => self.with_fix(span, text),
            None => self,
        }
    }

    /// As [`Self::near`] for the name of an object, whose written word has no indices: for `sample[i]`, which is
    /// `sample0`, only `sample` is replaced.
    #[must_use]
    pub fn near_object(self, name: &str, word: Span, near: &str) -> Self {
        let index = name.get(word.range().len()..).unwrap_or_default();
        match near.strip_suffix(index) {
            Some(near) => self.help(format!("did you mean `{near}`?")).with_fix(word, near),
            None => self.help(format!("did you mean `{near}`?")),
        }
    }

    /// As [`Self::near`] if there is a similar word; otherwise another help.
    #[must_use]
    pub fn near_or(self, near: Option<&str>, otherwise: impl Into<String>) -> Self {
        match near {
            Some(near) => self.near(near),
            None => self.help(otherwise),
        }
    }

    /// Sets the help if there is one.
    #[must_use]
    pub fn help_if(mut self, text: Option<String>) -> Self {
        self.help = text.or(self.help);
        self
    }

    /// The text of the file with the edits applied; `None` if there are none or they do not fit the text.
    pub fn apply_fix(&self, text: &str) -> Option<String> {
        let mut fixed = String::new();
        let mut at = 0;
        for SourceEdit { span, text: new } in &self.fix {
            fixed.push_str(text.get(at..span.start as usize)?);
            fixed.push_str(new);
            at = span.end as usize;
        }
        fixed.push_str(text.get(at..)?);
        (!self.fix.is_empty()).then_some(fixed)
    }

    /// The span of the first label, if there is one.
    pub fn span(&self) -> Option<Span> {
        self.labels.first().map(|label| label.span)
    }

    /// Whether another diagnostic reports the same at the same places.
    fn repeats(&self, other: &Diagnostic) -> bool {
        let same_places =
            || !self.labels.is_empty() && self.labels.iter().map(|l| l.span).eq(other.labels.iter().map(|l| l.span));
        self.code == other.code && (self == other || same_places())
    }

    /// The diagnostic with texts of readable length: a very long name is shown by its two ends.
    fn shortened(mut self) -> Diagnostic {
        let texts = [&mut self.title].into_iter().chain(self.labels.iter_mut().map(|label| &mut label.text));
        for text in texts.chain(&mut self.help) {
            if text.len() > MAX_TEXT_CHARACTERS {
                *text = plain::shortened(text, MAX_TEXT_CHARACTERS).into_owned();
            }
        }
        self
    }

    /// Whether it stops the build.
    pub fn is_error(&self) -> bool {
        self.code.severity() == Severity::Error
    }
}

/// A line of a report: its topic and its text.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
pub struct Remark {
    pub subject: String,
    pub text: String,
}

/// Greatest number of diagnostics that are kept; a file with more is not a Tweeze file.
pub const MAX_DIAGNOSTICS: usize = 200;

/// Greatest number of characters of a title, a label or a help that are kept, without the note on the number left out.
pub const MAX_TEXT_CHARACTERS: usize = 2000;

/// Collects the findings of the stages.
#[derive(Debug, Default)]
pub struct Sink {
    diagnostics: Vec<Diagnostic>,
    errors: usize,
    dropped: usize,
    /// Codes and places of the diagnostics that were not kept.
    dropped_places: FxHashSet<(Code, Vec<Span>)>,
}

impl Sink {
    /// Adds a diagnostic. Each finding is kept once: repetitions at the same places, by a `for` or a further run,
    /// possibly with other figures, are ignored. Beyond [`MAX_DIAGNOSTICS`] it is only counted.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        let diagnostic = diagnostic.shortened();
        if self.diagnostics.iter().any(|known| known.repeats(&diagnostic)) {
            return;
        }
        let is_error = diagnostic.is_error();
        if self.diagnostics.len() < MAX_DIAGNOSTICS {
            self.diagnostics.push(diagnostic);
        } else {
            let places: Vec<Span> = diagnostic.labels.iter().map(|label| label.span).collect();
            if !places.is_empty() && !self.dropped_places.insert((diagnostic.code, places)) {
                return;
            }
            self.dropped += 1;
        }
        self.errors += usize::from(is_error);
    }

    /// Adds a finding, if there is one; returns `None` if so.
    pub fn push_if_some(&mut self, wrong: Option<Diagnostic>) -> Option<()> {
        match wrong {
            Some(diagnostic) => {
                self.push(diagnostic);
                None
            }
            None => Some(()),
        }
    }

    /// Marks each finding as being about a device that has no plan.
    pub fn about_device(&mut self, device: &str) {
        self.diagnostics.iter_mut().for_each(|diagnostic| diagnostic.device = Some(device.to_owned()));
    }

    /// Weakens all findings, because the task that they are about starts at only one of several possible places: no
    /// finding proves that there is no plan.
    pub fn weaken(&mut self) {
        let findings = std::mem::take(&mut self.diagnostics);
        self.diagnostics = findings.into_iter().map(Diagnostic::weakened).collect();
    }

    /// Adds the findings of another sink, and the number of those that it did not keep.
    pub fn append(&mut self, other: Sink) {
        let kept = other.diagnostics.iter().filter(|diagnostic| diagnostic.is_error()).count();
        self.errors += other.errors - kept;
        self.dropped += other.dropped;
        other.diagnostics.into_iter().for_each(|diagnostic| self.push(diagnostic));
    }

    /// The sink with only the findings that `keeps` accepts.
    #[must_use]
    pub fn retained(mut self, mut keeps: impl FnMut(&Diagnostic) -> bool) -> Sink {
        let errors = &mut self.errors;
        self.diagnostics.retain(|diagnostic| {
            let is_kept = keeps(diagnostic);
            *errors -= usize::from(!is_kept && diagnostic.is_error());
            is_kept
        });
        self
    }

    /// Number of errors pushed so far; a stage that compares it before and after knows whether it failed.
    pub fn errors(&self) -> usize {
        self.errors
    }

    /// Number of diagnostics that were not kept.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// Whether a further diagnostic would only be counted.
    pub fn is_full(&self) -> bool {
        self.diagnostics.len() >= MAX_DIAGNOSTICS
    }

    /// The diagnostics kept, by place: file, then offset, then the order of finding.
    pub fn sorted(&self) -> Vec<&Diagnostic> {
        let mut list: Vec<&Diagnostic> = self.diagnostics.iter().collect();
        list.sort_by_key(|diagnostic| diagnostic.span().map(|span| (span.file, span.start)));
        list
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn findings_beyond_those_that_are_kept_count_once() {
        let mut sink = Sink::default();
        let at = |start: usize| {
            let place = Span { start: start as u32, ..Span::default() };
            Diagnostic::new(Code::E0201, format!("number {start}")).label(place, "here")
        };
        (0..2).for_each(|_| (0..MAX_DIAGNOSTICS + 5).for_each(|start| sink.push(at(start))));
        assert_eq!((sink.errors(), sink.dropped()), (MAX_DIAGNOSTICS + 5, 5));
    }
}
