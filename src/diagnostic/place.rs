//! Places of a scene that diagnostics are about, for drawing them.

use crate::source::Span;

/// A place of a scene as a program writes it.
#[derive(Debug, Clone, PartialEq)]
pub struct WrittenPlace {
    pub span: Span,
    /// The device whose task names the place; `None` for the place of an object in a scene.
    pub device: Option<String>,
    pub unit: PlaceUnit,
    pub at: [f64; 2],
}

/// Unit of a [`WrittenPlace`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PlaceUnit {
    /// Cells of a lattice or electrodes of a board, as the program counts them.
    Cells,
    /// Micrometres in the scene.
    Micrometres,
}

/// How far a search without a plan came: everything that it reached, if that is the proof.
#[derive(Debug, Clone, PartialEq)]
pub struct Reach {
    /// What is stuck: a part, a robot, or the tip of the device.
    pub what: String,
    pub extent: ReachExtent,
}

/// Extent of a `Reach`, in the terms of its kind.
#[derive(Debug, Clone, PartialEq)]
pub enum ReachExtent {
    /// Rows of neighbouring cells, as the program counts them.
    Cells(Vec<CellRun>),
    /// A turn in a plane of the part; positive from its first axis to its second.
    Turn { plane: &'static str, reached_deg: f64, asked_deg: f64 },
    /// End of the last path that was tried: a place in micrometres and the heading in radians.
    Pose([f64; 3]),
}

/// Neighbouring cells of one row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CellRun {
    pub row: u32,
    /// The first and the last column.
    pub columns: [u32; 2],
}

impl CellRun {
    /// Groups cells, each a column and a row, into runs.
    pub fn all(cells: impl IntoIterator<Item = (u32, u32)>) -> Vec<CellRun> {
        let mut cells: Vec<(u32, u32)> = cells.into_iter().map(|(column, row)| (row, column)).collect();
        cells.sort_unstable();
        cells.dedup();
        let joins = |one: &(u32, u32), other: &(u32, u32)| one.0 == other.0 && one.1.checked_add(1) == Some(other.1);
        let ends = |run: &[(u32, u32)]| Some((run.first()?.0, [run.first()?.1, run.last()?.1]));
        cells.chunk_by(joins).filter_map(ends).map(|(row, columns)| CellRun { row, columns }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn neighbours_of_a_row_are_one_run() {
        let runs = CellRun::all([(3, 1), (1, 1), (2, 1), (5, 1), (2, 2), (u32::MAX, 0), (3, 1)]);
        let rows: Vec<(u32, [u32; 2])> = runs.iter().map(|run| (run.row, run.columns)).collect();
        assert_eq!(rows, [(0, [u32::MAX; 2]), (1, [1, 3]), (1, [5, 5]), (2, [2, 2])]);
        assert_eq!(CellRun::all([]), []);
    }
}
