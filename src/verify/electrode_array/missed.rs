//! Operations that were not done, and assays that continue after the last one.

use super::JudgedBoard;
use super::assay::MissedOperation;
use crate::verify::Violation;
use crate::verify::rule::{Rule, ms};

impl JudgedBoard<'_, '_> {
    /// The violation of an operation that was not done, or of a part that does not end where it should.
    pub(super) fn not_done(&self, nth: usize, missed: &MissedOperation) -> Violation {
        let step = self.run.step(nth);
        let MissedOperation { part, cell, beats, with, .. } = *missed;
        let (name, end_ns) = (&self.order.parts[part].name, step.end_ns());
        let ends = match self.cells[part] {
            Some(end) => format!("it ends at {end}"),
            None if missed.operation.comes || missed.operation.splits.is_some() => "it never appears".to_owned(),
            None => "it is gone by then".to_owned(),
        };
        let title = match with {
            None if missed.operation.comes => {
                let due = ms(beats.saturating_mul(self.order.facts.step_ns));
                format!("`{name}` must be dispensed at {cell} in {due} without a pause, but is not; {ends}")
            }
            Some(other) => {
                let other = &self.order.parts[other].name;
                format!("`{name}` and `{other}` must merge at {cell}, but do not")
            }
            None if missed.operation.mixes => {
                let due = ms(beats.saturating_mul(self.order.facts.step_ns));
                format!("`{name}` must be mixed from {cell} on for {due} in its turn, but is not; {ends}")
            }
            None if missed.is_split => {
                let half = missed.operation.splits.map_or("", |half| self.order.parts[half.part].name.as_str());
                format!("`{half}` must split off `{name}`, which goes to {cell}, but does not; {ends}")
            }
            None if beats > 0 => {
                let due = ms(beats.saturating_mul(self.order.facts.step_ns));
                format!("`{name}` must stay at {cell} for {due} in its turn, but does not; {ends}")
            }
            None => format!("`{name}` must reach {cell} in its turn, but does not; {ends}"),
        };
        let span = missed.stop.map_or(missed.operation.span, |stop| stop.span);
        self.run.violation(Rule::Goal, nth, end_ns, title).label(span, "this operation")
    }

    /// The violation of an assay that does not end with its last operation.
    pub(super) fn idle_assay(&self, nth: usize, beats: u64) -> Violation {
        let step = self.run.step(nth);
        let (done_ns, end_ns) = (step.start_ns + beats * self.order.facts.step_ns, step.end_ns());
        let title = format!("all operations are done at {}, but the step ends at {}", ms(done_ns), ms(end_ns));
        self.run.violation(Rule::Idle, nth, done_ns, title)
    }
}
