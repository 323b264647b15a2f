//! A table of voltages for so many robots: the one whose smallest slack is greatest.

use super::relays::Row;

/// What a suggestion has to keep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Each transition voltage will be known to plus or minus this.
    pub margin_v: f64,
    pub max_v: f64,
    /// The relax and the flex level; where `None`, they are chosen, `swing_v` apart.
    pub drive_v: Option<[f64; 2]>,
    /// By how much the flex level is above the relax level where they are not given.
    pub swing_v: f64,
}

/// A table and what it promises.
#[derive(Debug, Clone, PartialEq)]
pub struct Suggestion {
    /// The largest number of robots that fits, up to [`crate::device::microrobots::MAX_ROBOTS`].
    pub most: usize,
    /// In the order in which arms snap down; `None` where so many do not fit.
    pub table: Option<Vec<Row>>,
    pub relax_v: f64,
    pub flex_v: f64,
    /// The smallest slack of the table's control states, each with at most two levels; 0 without a table.
    pub slack_v: f64,
}

/// The STRING table of so many robots whose smallest slack is greatest.
pub fn suggest(_robots: usize, limits: Limits) -> Suggestion {
    let [relax_v, flex_v] = limits.drive_v.unwrap_or_default();
    Suggestion { most: 0, table: None, relax_v, flex_v, slack_v: 0.0 }
}
