//! Planned motion of the parts of a board.

use super::errands::PartCourse;
use crate::claims::electrode_array::AssayOperation;
use crate::device::electrode_array::ElectrodeCell;

/// Motion of the parts of a board.
#[derive(Debug, Clone, PartialEq)]
pub struct ElectrodeArrayMotion {
    /// Start cell of each part of the order; `None` for a part that has already merged into another or has not entered
    /// yet.
    pub start: Vec<Option<ElectrodeCell>>,
    /// One for each step of the order.
    pub steps: Vec<ElectrodeArrayStepMotion>,
}

/// Motion of the parts in one step of the task.
#[derive(Debug, Clone, PartialEq)]
pub enum ElectrodeArrayStepMotion {
    /// For each part its cells at instants 0, 1, … of the step, until it stays; empty for a part that has already
    /// merged.
    Paths(Vec<Vec<ElectrodeCell>>),
    /// Operations, with the places that the plan has chosen for them.
    Assay {
        operations: Vec<AssayOperation>,
        /// One for each part.
        courses: Vec<PartCourse>,
    },
    /// In nanoseconds.
    Wait(u64),
}

impl ElectrodeArrayStepMotion {
    /// Steps, sum of costs and moves.
    pub fn figures(&self) -> [usize; 3] {
        let moves = |cells: &[ElectrodeCell]| cells.windows(2).filter(|pair| pair[0] != pair[1]).count();
        match self {
            ElectrodeArrayStepMotion::Paths(paths) => {
                let arrivals = paths.iter().map(|path| path.len().saturating_sub(1));
                let moves = paths.iter().map(|path| moves(path)).sum();
                [arrivals.clone().max().unwrap_or(0), arrivals.sum(), moves]
            }
            ElectrodeArrayStepMotion::Assay { courses, .. } => {
                let ends = courses.iter().map(|course| course.until().saturating_sub(1));
                let moves = courses.iter().map(|course| moves(&course.cells)).sum();
                [ends.max().unwrap_or(0), courses.iter().map(PartCourse::last_arrival).sum(), moves]
            }
            ElectrodeArrayStepMotion::Wait(_) => [0; 3],
        }
    }
}
