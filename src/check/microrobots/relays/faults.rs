//! Faults of a table: single rows, pairs of rows, states.

use super::table::{VoltageTable, volts_v};
use super::{AllowedGaps, Problem, RowGap};

/// Number of faults that each row takes part in.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Census {
    /// Faults of the row alone.
    alone: Vec<usize>,
    /// Faults of pairs with other rows.
    shared: Vec<usize>,
}

impl Census {
    pub fn of(table: &VoltageTable, gaps: AllowedGaps) -> Self {
        let rows = 0..table.len();
        Census {
            alone: rows.clone().map(|row| alone(table, row).count()).collect(),
            shared: rows.map(|row| shared(table, gaps, row)).collect(),
        }
    }

    pub fn total(&self) -> usize {
        self.alone.iter().sum::<usize>() + self.shared.iter().sum::<usize>() / 2
    }

    /// Number of faults that a row takes part in.
    pub fn of_row(&self, row: usize) -> usize {
        self.alone[row] + self.shared[row]
    }
}

/// Number of pairs with others in which a row is at fault.
pub fn shared(table: &VoltageTable, gaps: AllowedGaps, row: usize) -> usize {
    match gaps {
        AllowedGaps::String => (0..table.len()).filter(|other| *other != row && !table.is_ordered(row, *other)).count(),
        AllowedGaps::Any => 0,
    }
}

/// The faults of rows and pairs, rows first; at most `most`.
pub fn problems(table: &VoltageTable, gaps: AllowedGaps, most: usize) -> Vec<Problem> {
    let rows = 0..table.len();
    let alone = rows.clone().flat_map(|row| alone(table, row));
    let pairs = rows.flat_map(|one| (one + 1..table.len()).filter_map(move |other| pair(table, one, other)));
    match gaps {
        AllowedGaps::String => alone.chain(pairs).take(most).collect(),
        AllowedGaps::Any => alone.take(most).collect(),
    }
}

/// The faults of a row alone.
pub fn alone(table: &VoltageTable, row: usize) -> impl Iterator<Item = Problem> {
    let (snap_down, release) = (table.snap_downs[row], table.releases[row]);
    let gap = 2 * table.margin;
    [
        (release > table.relax - gap).then(|| Problem::Hold { row, most_v: volts_v(table.relax - gap) }),
        (snap_down < table.flex + gap).then(|| Problem::Drive { row, least_v: volts_v(table.flex + gap) }),
        (snap_down > table.max - table.margin)
            .then(|| Problem::Range { row, most_v: volts_v(table.max - table.margin) }),
        (release < table.margin).then(|| Problem::Floor { row, least_v: volts_v(table.margin) }),
        (snap_down - release < gap).then(|| Problem::Narrow {
            row,
            gap_v: volts_v(snap_down - release),
            least_v: volts_v(gap),
        }),
    ]
    .into_iter()
    .flatten()
}

/// The fault of two rows of a STRING table.
fn pair(table: &VoltageTable, one: usize, other: usize) -> Option<Problem> {
    let snap_down_gap_v = volts_v((table.snap_downs[one] - table.snap_downs[other]).abs());
    let release_gap_v = volts_v((table.releases[one] - table.releases[other]).abs());
    let least_v = volts_v(2 * table.margin);
    match (table.separates(one, other), table.separates(other, one)) {
        (true, true) => {
            let is_inner = table.snap_downs[one] < table.snap_downs[other];
            let (outer, inner) = if is_inner { (other, one) } else { (one, other) };
            Some(Problem::Nested { outer, inner, snap_down_gap_v, release_gap_v, least_v })
        }
        (false, false) => Some(Problem::Alike { one, other, snap_down_gap_v, release_gap_v, least_v }),
        (true, false) | (false, true) => None,
    }
}

/// The fault of a state that takes too many levels, with the rows for which two are not enough.
pub fn no_sequence(table: &VoltageTable, is_down: &[bool], state: usize, levels: usize) -> Problem {
    let gap = |voltages: &[i64]| {
        let down = (0..voltages.len()).filter(|row| is_down[*row]).max_by_key(|row| voltages[*row]).unwrap_or_default();
        let up = (0..voltages.len()).filter(|row| !is_down[*row]).min_by_key(|row| voltages[*row]).unwrap_or_default();
        RowGap { down, up, gap_v: volts_v(voltages[up] - voltages[down]) }
    };
    Problem::NoSequence {
        state,
        levels,
        snap_down: gap(&table.snap_downs),
        release: gap(&table.releases),
        least_v: volts_v(2 * table.margin),
    }
}
