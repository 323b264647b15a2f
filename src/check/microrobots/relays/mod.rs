//! Analysis of a relay table: the arm patterns that one voltage can set, and the levels that set them.
//!
//! Input: the voltages of a table and the limits of the source. Output: [`Analysis`], the control states with a
//! shortest control cycle each, or the faults of the table and the smallest change of one voltage that fixes it.
//!
//! Voltages are compared as whole numbers (`table::VoltageTable`), so that a gap of exactly two margins counts as two
//! margins. The patterns that can be set follow from pairs of rows (`table::VoltageTable::separates`); `cycles` proves
//! how, and why no others can.

mod cycles;
mod faults;
mod mends;
mod patterns;
pub(super) mod table;

use crate::device::microrobots::{Arm, ControlState};
use cycles::PatternTarget;
use faults::Census;
use table::VoltageTable;

/// Greatest number of faults reported one by one.
pub const MAX_FAULTS: usize = 16;

/// Greatest number of control states of a table that is not STRING.
pub const MAX_STATES: usize = 4_096;

/// The voltages of one robot.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RelayRow {
    pub snap_down_v: f64,
    pub release_v: f64,
}

/// Limits of the source, and the uncertainty of the transition voltages.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Source {
    /// Each transition voltage is known to plus or minus this.
    pub margin_v: f64,
    pub relax_v: f64,
    pub flex_v: f64,
    pub max_v: f64,
    /// Greatest number of levels in a control cycle.
    pub most_levels: usize,
}

/// Tables that are allowed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AllowedGaps {
    /// Strictly non-nested hysteresis gaps: a chain of n + 1 states.
    String,
    /// Nested gaps and equal rows too.
    Any,
}

/// One of the two voltages of a row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Transition {
    SnapDown,
    Release,
}

/// A change of one voltage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Mend {
    pub row: usize,
    pub transition: Transition,
    pub to_v: f64,
}

/// Fault of a table.
#[derive(Debug, Clone, PartialEq)]
pub struct TableFault {
    pub problem: Problem,
    /// The smallest change of one voltage after which the table has no fault; if there is none, the smallest that fixes
    /// this fault. Rounded so that it still holds when typed in. `None` if no single voltage fixes it.
    pub mend: Option<Mend>,
}

/// Two rows that a state would need to separate by one of their voltages.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowGap {
    /// Its arm must be down.
    pub down: usize,
    /// Its arm must be up.
    pub up: usize,
    /// Voltage of `up` minus that of `down`.
    pub gap_v: f64,
}

/// A fault; rows are indices of the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Problem {
    /// The relax level could release an arm: the release voltage is above `most_v`, relax level - 2 margins.
    Hold { row: usize, most_v: f64 },
    /// The flex level could snap an arm down: the snap-down voltage is below `least_v`, flex level + 2 margins.
    Drive { row: usize, least_v: f64 },
    /// The source could fail to snap an arm down: the snap-down voltage is above `most_v`, maximum - margin.
    Range { row: usize, most_v: f64 },
    /// Even 0 V could fail to release an arm: the release voltage is below `least_v`, the margin.
    Floor { row: usize, least_v: f64 },
    /// Snap-down is less than `least_v`, two margins, above release.
    Narrow { row: usize, gap_v: f64, least_v: f64 },
    /// `outer` snaps down after `inner` and is released after it too, both by `least_v` (two margins) or more.
    Nested { outer: usize, inner: usize, snap_down_gap_v: f64, release_gap_v: f64, least_v: f64 },
    /// Neither the snap-down nor the release voltages are `least_v`, two margins, apart: no level moves one arm without
    /// the other. Gaps are absolute.
    Alike { one: usize, other: usize, snap_down_gap_v: f64, release_gap_v: f64, least_v: f64 },
    /// The state that lowers the first `state` arms takes `levels` levels, more than allowed, because neither gap is
    /// `least_v`.
    NoSequence { state: usize, levels: usize, snap_down: RowGap, release: RowGap, least_v: f64 },
    /// More than [`MAX_STATES`] control states.
    Crowd { most: usize },
}

impl Problem {
    /// The control state that it is about.
    fn state(&self) -> Option<usize> {
        match *self {
            Problem::NoSequence { state, .. } => Some(state),
            Problem::Hold { .. }
            | Problem::Drive { .. }
            | Problem::Range { .. }
            | Problem::Floor { .. }
            | Problem::Narrow { .. }
            | Problem::Nested { .. }
            | Problem::Alike { .. }
            | Problem::Crowd { .. } => None,
        }
    }
}

/// Capabilities of a table.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Analysis {
    /// The row that snaps first, second and so on; empty where the table is not STRING.
    pub order: Vec<usize>,
    /// Empty after a fault. With [`AllowedGaps::String`] state j lowers the first j arms of `order`; with
    /// [`AllowedGaps::Any`] they are sorted by the number of arms that are down, then by their digits.
    pub states: Vec<ControlState>,
    pub faults: Vec<TableFault>,
    /// Faults beyond [`MAX_FAULTS`].
    pub more_faults: usize,
    /// With [`AllowedGaps::Any`]: patterns that only a longer control cycle than allowed would set.
    pub too_long: usize,
}

/// Analyses a table of at most [`crate::device::microrobots::MAX_ROBOTS`] rows.
///
/// Limits are met by equality too: a gap of exactly two margins is enough, with a slack of 0 V.
pub fn analyse(rows: &[RelayRow], source: Source, gaps: AllowedGaps) -> Analysis {
    let table = VoltageTable::new(rows, source);
    let census = Census::of(&table, gaps);
    let order = table.order().unwrap_or_default();
    let problems = faults::problems(&table, gaps, MAX_FAULTS);
    if !problems.is_empty() {
        return refused(&table, gaps, order, &problems, census.total());
    }
    match gaps {
        AllowedGaps::String => string(&table, order),
        AllowedGaps::Any => any(&table, order),
    }
}

fn refused(table: &VoltageTable, gaps: AllowedGaps, order: Vec<usize>, problems: &[Problem], total: usize) -> Analysis {
    let problems = &problems[..problems.len().min(MAX_FAULTS)];
    let mends = mends::mends(table, gaps, problems);
    let faults: Vec<TableFault> =
        problems.iter().zip(mends).map(|(problem, mend)| TableFault { problem: *problem, mend }).collect();
    Analysis { order, more_faults: total - faults.len(), faults, ..Analysis::default() }
}

/// The chain of states of a table whose rows are all separated.
fn string(table: &VoltageTable, order: Vec<usize>) -> Analysis {
    let ranked = table.ranked();
    let mut is_down = vec![false; table.len()];
    let mut states = Vec::with_capacity(table.len() + 1);
    let mut problems = Vec::new();
    for state in 0..=order.len() {
        if let Some(last) = state.checked_sub(1) {
            is_down[order[last]] = true;
        }
        match PatternTarget::new(table, &ranked, &is_down).state(&is_down) {
            Ok(found) => states.push(found),
            Err(levels) => problems.push(faults::no_sequence(table, &is_down, state, levels)),
        }
    }
    match problems.is_empty() {
        true => Analysis { order, states, ..Analysis::default() },
        false => refused(table, AllowedGaps::String, order, &problems, problems.len()),
    }
}

/// All accessible patterns of a table, STRING or not.
fn any(table: &VoltageTable, order: Vec<usize>) -> Analysis {
    let Some(patterns) = patterns::accessible(table, MAX_STATES) else {
        let faults = vec![TableFault { problem: Problem::Crowd { most: MAX_STATES }, mend: None }];
        return Analysis { order, faults, ..Analysis::default() };
    };
    let ranked = table.ranked();
    let found: Vec<ControlState> =
        patterns.iter().filter_map(|is_down| PatternTarget::new(table, &ranked, is_down).state(is_down).ok()).collect();
    Analysis { order, too_long: patterns.len() - found.len(), states: found, ..Analysis::default() }
}

fn arms(is_down: &[bool]) -> Vec<Arm> {
    is_down.iter().map(|is_down| if *is_down { Arm::Down } else { Arm::Up }).collect()
}

#[cfg(test)]
mod tests;
