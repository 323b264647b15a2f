//! One job of microrobots: its steps planned one after the other, from where the robots stand.

use crate::check::claims::Job;
use crate::check::claims::microrobots::MicrorobotsOrder;
use crate::diagnostic::Sink;
use crate::geometry::Pose;
use crate::plan::Plan;
use std::collections::BTreeMap;

/// What the plans of a schedule leave behind for those that follow.
#[derive(Default)]
pub struct Standing {
    beds: BTreeMap<String, Vec<(Pose, bool)>>,
}

/// A plan for a job; without one an error was pushed.
pub fn plan(job: &Job, _order: &MicrorobotsOrder, standing: &mut Standing, _sink: &mut Sink) -> Option<Plan> {
    standing.beds.remove(&job.device);
    None
}
