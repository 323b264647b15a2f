//! Checks paths that ignore shared channels against their rule.

use super::broadcast::{AgentStep, PulledStep};
use crate::plan::electrode_array::board::{CellIndex, Instance, Paths, position};

/// Whether the paths of a stage keep the rule until the last arrival.
pub fn are_kept_by_paths(instance: &Instance, paths: &Paths) -> bool {
    let Some(channels) = instance.board.channels() else { return true };
    let end = paths.iter().map(Vec::len).max().unwrap_or(1) - 1;
    (0..end).all(|instant| {
        let step = |path: &Vec<CellIndex>| PulledStep {
            step: AgentStep { from: position(path, instant), to: position(path, instant + 1) },
            split_electrode: None,
        };
        channels.go_together(&paths.iter().map(step).collect::<Vec<_>>())
    })
}
