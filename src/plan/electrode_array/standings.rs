//! The cells where the plans of earlier jobs leave the parts of each board.

use super::stage::BoardGround;
use crate::claims::Job;
use crate::claims::electrode_array::ElectrodeArrayOrder;
use crate::device::electrode_array::ElectrodeCell;
use crate::diagnostic::{Code, Diagnostic};
use std::collections::BTreeMap;

/// The cell of each part of each device, by names of device and part.
#[derive(Default)]
pub struct BoardStandings {
    cells: BTreeMap<String, BTreeMap<String, Option<ElectrodeCell>>>,
}

impl BoardStandings {
    /// Cells of the parts of an order before its job.
    pub fn before(&self, job: &Job, order: &ElectrodeArrayOrder) -> Vec<Option<ElectrodeCell>> {
        let known = self.cells.get(&job.device);
        let stands = |name: &String| known.and_then(|cells| cells.get(name)).copied();
        order.parts.iter().map(|part| stands(&part.name).unwrap_or(part.cell)).collect()
    }

    /// Records the cells of the parts of an order after its job.
    pub fn leave(&mut self, job: &Job, order: &ElectrodeArrayOrder, cells: Vec<Option<ElectrodeCell>>) {
        let names = order.parts.iter().map(|part| part.name.clone());
        self.cells.entry(job.device.clone()).or_default().extend(names.zip(cells));
    }
}

/// Reports a part that an earlier plan left on an obstacle of this job's scene, or too near to one. Where the program
/// names the cell, the check of the program finds this; here the plan has chosen the cell.
pub fn on_obstacle(job: &Job, order: &ElectrodeArrayOrder, start: &[Option<ElectrodeCell>]) -> Option<Diagnostic> {
    let moved = order.parts.iter().zip(start).filter(|(part, cell)| part.cell != **cell);
    let mut moved = moved.filter_map(|(part, cell)| Some((part, (*cell)?))).peekable();
    moved.peek()?;
    let ground = BoardGround::new(order);
    let board = ground.board();
    moved.find_map(|(part, cell)| {
        let index = board.cell(cell.column - 1, cell.row - 1);
        let obstacle = ground.obstacles().iter().find(|obstacle| obstacle.covers(index, board))?;
        let (part, obstacle, at) = (&part.name, obstacle.name(), obstacle.span);
        let title =
            format!("`{part}` is then at {cell}, on obstacle `{obstacle}` of this run's scene or too near to it");
        let diagnostic = Diagnostic::new(Code::E0530, title)
            .label(job.run_span, "this run has another scene than the previous one, whose plan chose that cell")
            .label(at, "the obstacle")
            .help(format!(
                "remove the places at this obstacle from those of `{part}`, or give the tasks of the device one scene"
            ));
        Some(diagnostic)
    })
}
