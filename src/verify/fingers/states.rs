//! The states of a hand between its changes, and which of them the record must have.
//!
//! A state lasts from the end of one change to the beginning of the next. The record gives an instant within that span
//! and a state that must equal the replayed one. Where a grasp has two descriptions (the angle of a turn that is over,
//! the contacts that two sections share), either is accepted.

use super::super::clock::JudgedRun;
use super::super::record::agrees;
use super::super::{ReplayedState, judged_state};
use crate::schedule::{State, TimedState};

/// Whether a state must be recorded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Due {
    Always,
    /// Optional, such as the states between the fingers of a first grasp.
    Perhaps,
}

/// A state between two changes.
#[derive(Debug)]
pub(super) struct StateSpan {
    pub from_ns: u64,
    /// The beginning of the next change.
    pub until_ns: u64,
    pub due: Due,
    /// The accepted descriptions of the state, the simplest first; at least one.
    pub views: Vec<State>,
}

/// All states of a run in order.
#[derive(Debug, Default)]
pub(super) struct Spans {
    list: Vec<StateSpan>,
}

impl Spans {
    /// Begins a state at the end of a change.
    pub fn begin(&mut self, from_ns: u64, due: Due, views: Vec<State>) {
        self.list.push(StateSpan { from_ns, until_ns: u64::MAX, due, views });
    }

    /// Ends the last state at the beginning of a change.
    pub fn end(&mut self, until_ns: u64) {
        if let Some(last) = self.list.last_mut() {
            last.until_ns = last.until_ns.min(until_ns);
        }
    }

    /// Makes the last state mandatory.
    pub fn settle(&mut self) {
        if let Some(last) = self.list.last_mut() {
            last.due = Due::Always;
        }
    }

    /// The states that the record should have; recorded ones are borrowed where they agree.
    pub fn states<'a>(self, run: &JudgedRun<'a>) -> Vec<ReplayedState<'a>> {
        let mut recorded = run.plan.states.iter().peekable();
        let mut states = Vec::with_capacity(self.list.len());
        for span in self.list {
            let within = |timed: &&TimedState| (span.from_ns..=span.until_ns).contains(&timed.t_ns);
            let found = recorded.next_if(within);
            if found.is_none() && span.due == Due::Perhaps {
                continue;
            }
            let t_ns = found.map_or(span.from_ns, |timed| timed.t_ns);
            let due = TimedState { t_ns, state: chosen(span.views, found.map(|timed| &timed.state)) };
            states.push(match found {
                Some(timed) if agrees(timed, &due) => ReplayedState::Recorded(timed),
                Some(_) | None => ReplayedState::Own(Box::new(due)),
            });
        }
        states
    }
}

/// The view equal to the recorded one, or else the simplest.
pub(super) fn chosen(mut views: Vec<State>, recorded: Option<&State>) -> State {
    let at = recorded.and_then(|recorded| views.iter().position(|view| judged_state(recorded).agrees(view)));
    views.swap_remove(at.unwrap_or(0))
}
