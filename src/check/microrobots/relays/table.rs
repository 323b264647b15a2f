//! Voltages of a table as integers.

use super::{RelayRow, Source, Transition};

/// Units per volt: half nanovolts. Given values are rounded to whole nanovolts, so that the middle of two levels is
/// a whole number too.
pub const UNITS_PER_VOLT: f64 = 2e9;

/// Least margin: a nanovolt.
const LEAST_MARGIN: i64 = 2;

/// Greatest voltage, to which larger ones are clamped: sums of some of them stay within 64 bits.
const MOST_V: f64 = 1e8;

/// The voltages of a table and its source, in units of half a nanovolt.
#[derive(Debug, Clone)]
pub struct VoltageTable {
    pub snap_downs: Vec<i64>,
    pub releases: Vec<i64>,
    /// At least a nanovolt: a level at which an arm moves is not one at which it stays.
    pub margin: i64,
    pub relax: i64,
    pub flex: i64,
    pub max: i64,
    pub most_levels: usize,
}

/// The rows of a table, sorted by voltage.
pub struct Ranked {
    /// The highest snap-down voltage first.
    pub snap_downs: Vec<usize>,
    /// The lowest release voltage first.
    pub releases: Vec<usize>,
}

impl VoltageTable {
    pub fn new(rows: &[RelayRow], source: Source) -> Self {
        VoltageTable {
            snap_downs: rows.iter().map(|row| units(row.snap_down_v)).collect(),
            releases: rows.iter().map(|row| units(row.release_v)).collect(),
            margin: units(source.margin_v).max(LEAST_MARGIN),
            relax: units(source.relax_v),
            flex: units(source.flex_v),
            max: units(source.max_v),
            most_levels: source.most_levels,
        }
    }

    pub fn len(&self) -> usize {
        self.snap_downs.len()
    }

    /// Whether some level moves one of two arms and for certain not the other, so that `down` is down while `up` is up:
    /// it lowers `down` but not `up`, or raises `up` but not `down`.
    pub fn separates(&self, down: usize, up: usize) -> bool {
        let gap = 2 * self.margin;
        self.snap_downs[up] - self.snap_downs[down] >= gap || self.releases[up] - self.releases[down] >= gap
    }

    /// The rows in the order of snap-down: each can be down while a later one is up, and never the reverse; `None` if
    /// there is no such order.
    pub fn order(&self) -> Option<Vec<usize>> {
        let mut order: Vec<Option<usize>> = vec![None; self.len()];
        for (row, rank) in self.ranks().into_iter().enumerate() {
            let is_strict = (0..self.len()).all(|other| other == row || self.is_ordered(row, other));
            if !is_strict || order[rank].replace(row).is_some() {
                return None;
            }
        }
        order.into_iter().collect()
    }

    /// For each row, the number of others that can be down while it is up.
    pub fn ranks(&self) -> Vec<usize> {
        (0..self.len()).map(|row| self.rank(row)).collect()
    }

    /// Number of others that can be down while this row is up: its rank, if the rows have an order.
    pub fn rank(&self, row: usize) -> usize {
        (0..self.len()).filter(|other| *other != row && self.separates(*other, row)).count()
    }

    /// Whether exactly one of two rows can be down while the other is up.
    pub fn is_ordered(&self, one: usize, other: usize) -> bool {
        self.separates(one, other) != self.separates(other, one)
    }

    pub fn ranked(&self) -> Ranked {
        let mut snap_downs: Vec<usize> = (0..self.len()).collect();
        let mut releases = snap_downs.clone();
        snap_downs.sort_by_key(|row| -self.snap_downs[*row]);
        releases.sort_by_key(|row| self.releases[*row]);
        Ranked { snap_downs, releases }
    }

    pub fn voltage(&self, row: usize, transition: Transition) -> i64 {
        match transition {
            Transition::SnapDown => self.snap_downs[row],
            Transition::Release => self.releases[row],
        }
    }

    /// The voltages of all rows for one transition.
    pub fn voltages(&self, transition: Transition) -> &[i64] {
        match transition {
            Transition::SnapDown => &self.snap_downs,
            Transition::Release => &self.releases,
        }
    }

    pub fn set(&mut self, row: usize, transition: Transition, to: i64) {
        match transition {
            Transition::SnapDown => self.snap_downs[row] = to,
            Transition::Release => self.releases[row] = to,
        }
    }
}

/// Volts in units; NaN becomes 0.
pub fn units(volts_v: f64) -> i64 {
    (volts_v.clamp(-MOST_V, MOST_V) * UNITS_PER_VOLT / 2.0).round() as i64 * 2
}

pub fn volts_v(units: i64) -> f64 {
    units as f64 / UNITS_PER_VOLT
}

/// The middle between two voltages.
pub fn middle_v(low: i64, high: i64) -> f64 {
    (low + high) as f64 / (2.0 * UNITS_PER_VOLT)
}
