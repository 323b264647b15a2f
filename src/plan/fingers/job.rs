//! One job of a hand: its turns as one problem, then the ways of the fingers.

use crate::check::claims::Job;
use crate::check::claims::fingers::FingersOrder;
use crate::diagnostic::Sink;
use crate::plan::Plan;

/// What the plans of a schedule leave behind for those that follow.
#[derive(Default)]
pub struct Standing {}

/// A plan for a job; without one an error was pushed, for this job or for one of the same hand before it.
pub fn plan(_job: &Job, _order: &FingersOrder, _standing: &mut Standing, _sink: &mut Sink) -> Option<Plan> {
    None
}
