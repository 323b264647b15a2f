//! One job of an electrode array: its steps planned one after the other, from where the parts stand.

use crate::check::claims::Job;
use crate::check::claims::electrode_array::ElectrodeArrayOrder;
use crate::device::electrode_array::Cell;
use crate::diagnostic::Sink;
use crate::plan::Plan;
use std::collections::BTreeMap;

/// What the parts of a board do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Motion {
    /// Where each part of the order stands at first; `None` for one that has merged with another before.
    pub start: Vec<Option<Cell>>,
    /// One for each step of the order.
    pub steps: Vec<StepMotion>,
}

/// What the parts do in one step of the task.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StepMotion {
    /// For each part its cells at the instants 0, 1, … of the step, until it stays; empty for a part that has merged before.
    Paths(Vec<Vec<Cell>>),
    /// In nanoseconds.
    Wait(u64),
}

/// What the plans of a schedule leave behind for those that follow: where the parts of each device stand, by name.
#[derive(Default)]
pub struct Standing {
    cells: BTreeMap<String, BTreeMap<String, Option<Cell>>>,
}

/// A plan for a job; without one an error was pushed.
pub fn plan(job: &Job, order: &ElectrodeArrayOrder, standing: &mut Standing, sink: &mut Sink) -> Option<Plan> {
    let _ = (job, order, &standing.cells, sink);
    None
}
