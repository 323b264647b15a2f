//! Violations of rules, and their messages.

pub use super::catalogue::Rule;
use super::evidence::Tally;
use crate::diagnostic::{Diagnostic, Label};
use crate::source::Span;
use std::rc::Rc;

/// One breach of a rule.
#[derive(Debug, Clone, PartialEq)]
pub struct Violation {
    pub rule: Rule,
    /// When it happens, in nanoseconds from the schedule's beginning.
    pub time_ns: u64,
    pub title: String,
    /// Index into the schedule's steps.
    pub step: Option<u32>,
    /// Places in the source, from the claims; empty where the claims were read without spans.
    pub labels: Vec<Label>,
    /// The fix, if the user can make one.
    pub help: Option<String>,
}

/// Help of a violation that the program cannot have caused.
const NOT_THE_PROGRAM: &str = "a schedule fresh from `tweeze build` never breaks this rule: report it as a bug, \
     with the program attached; a log that breaks it was edited, or made for another device";

impl Violation {
    pub(super) fn new(rule: Rule, time_ns: u64, title: impl Into<String>) -> Self {
        Violation { rule, time_ns, title: title.into(), step: None, labels: Vec::new(), help: None }
    }

    #[must_use]
    pub(super) fn step(mut self, step: usize) -> Self {
        self.step = u32::try_from(step).ok();
        self
    }

    /// Adds a label, unless its place is unknown.
    #[must_use]
    pub(super) fn label(mut self, span: Span, text: impl Into<String>) -> Self {
        if span != Span::default() {
            self.labels.push(Label { span, text: text.into() });
        }
        self
    }

    #[must_use]
    pub(super) fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }
}

impl From<Violation> for Diagnostic {
    fn from(violation: Violation) -> Diagnostic {
        Diagnostic {
            labels: violation.labels,
            help: violation.help.or_else(|| Some(NOT_THE_PROGRAM.to_owned())),
            ..Diagnostic::new(violation.rule.code(), violation.title)
        }
    }
}

/// Greatest number of violations that are kept: one is enough to reject, and a hostile log could have millions.
pub const MAX_VIOLATIONS: usize = 100;

/// Collects violations, the first [`MAX_VIOLATIONS`] of them.
#[derive(Debug, Default)]
pub(super) struct Findings {
    list: Vec<Violation>,
    tally: Rc<Tally>,
}

impl Findings {
    /// Findings that count their checks in a shared tally.
    pub fn counting(tally: &Rc<Tally>) -> Findings {
        Findings { list: Vec::new(), tally: tally.clone() }
    }

    /// Counts checks of a rule; to be called before any of them can fail.
    pub fn count_checks(&self, rule: Rule, times: usize) {
        self.tally.count_checks(rule, times);
    }

    /// Counts of the checks so far.
    pub fn tally(&self) -> &Rc<Tally> {
        &self.tally
    }

    pub fn push(&mut self, violation: Violation) {
        if self.list.len() < MAX_VIOLATIONS {
            self.list.push(violation);
        }
    }

    pub fn len(&self) -> usize {
        self.list.len()
    }

    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The violations by time, then rule, then order of finding.
    pub fn sorted(mut self) -> Vec<Violation> {
        self.list.sort_by_key(|violation| (violation.time_ns, violation.rule));
        self.list
    }
}

/// A time in milliseconds to the last nanosecond: two times that differ never print the same.
pub(super) fn ms(time_ns: u64) -> String {
    let (whole, rest) = (time_ns / 1_000_000, time_ns % 1_000_000);
    match rest {
        0 => format!("{whole} ms"),
        rest => format!("{whole}.{} ms", format!("{rest:06}").trim_end_matches('0')),
    }
}
