//! Sets of turning centres as intervals in columns, and how straight runs carry them across a column.

use crate::real::Real;

/// Turning centres in one column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct ColumnInterval {
    /// Index of the column along x.
    pub column: i64,
    /// Least and greatest y.
    pub range_um: [f64; 2],
}

/// Turning centres that runs in one slice reach.
pub(super) struct SliceRuns {
    /// Least and greatest y of centres that are not far.
    near_um: [f64; 2],
    /// In the columns so far.
    pub reached: Vec<ColumnInterval>,
    /// At the near side of the next column.
    pub next: Vec<ColumnInterval>,
    /// Whether a run leaves `near_um`.
    pub is_far: bool,
}

impl SliceRuns {
    /// No runs yet.
    pub fn new(near_um: [f64; 2]) -> SliceRuns {
        SliceRuns { near_um, reached: Vec::new(), next: Vec::new(), is_far: false }
    }
}

/// The directions of a slice of headings.
pub(super) struct SliceDirections {
    pub middle_rad: f64,
    /// 1 if robots run to greater x, otherwise -1.
    pub forward: i64,
    side_um: f64,
    /// Least and greatest change of y in a run across a column.
    shifts_um: [f64; 2],
}

/// Cosine below which a direction is along a column.
const VERTICAL: f64 = 1e-9;

impl SliceDirections {
    /// The slice of this index, for slices and columns of these widths.
    pub fn new(slice: i64, slice_rad: f64, side_um: f64) -> SliceDirections {
        let middle_rad = (slice as f64 + 0.5) * slice_rad;
        let (_, cos) = middle_rad.sine_cosine();
        let edges = [slice, slice + 1].map(|edge| (edge as f64 * slice_rad).sine_cosine());
        let [one, other] = edges.map(|(sin, cos)| match cos.abs() < VERTICAL {
            true => sin.signum() * f64::INFINITY,
            false => side_um * sin / cos.abs(),
        });
        let shifts_um = [one.min(other), one.max(other)];
        SliceDirections { middle_rad, forward: if cos > 0.0 { 1 } else { -1 }, side_um, shifts_um }
    }

    /// Carries an interval across its column, in whose open cells a run stays. A run begins anywhere in the column if
    /// `is_source`, otherwise at its near side.
    pub fn cross(
        &self,
        interval: &ColumnInterval,
        is_source: bool,
        is_closed: &mut impl FnMut(i64) -> bool,
        runs: &mut SliceRuns,
    ) {
        let [down_um, up_um] = [self.shifts_um[0].min(0.0), self.shifts_um[1].max(0.0)];
        let [low_um, high_um] = interval.range_um;
        let [mut begin, last] = interval.range_um.map(|y_um| (y_um / self.side_um).floor() as i64);
        while begin <= last {
            if is_closed(begin) {
                begin += 1;
                continue;
            }
            let end = (begin..=last).take_while(|row| !is_closed(*row)).last().unwrap_or(begin);
            let part = [low_um.max(self.low_um(begin)), high_um.min(self.low_um(end + 1))];
            let reach_um = [part[0] + down_um, part[1] + up_um];
            let open_um = self.open_um([begin, end], reach_um, runs.near_um, is_closed);
            let within = |range_um: [f64; 2]| [range_um[0].max(open_um[0]), range_um[1].min(open_um[1])];
            let touched_um = within(reach_um);
            runs.is_far |= touched_um[0] <= runs.near_um[0] || touched_um[1] >= runs.near_um[1];
            let left_um = match is_source {
                true => touched_um,
                false => within([part[0] + self.shifts_um[0], part[1] + self.shifts_um[1]]),
            };
            runs.reached.push(ColumnInterval { column: interval.column, range_um: touched_um });
            if left_um[0] <= left_um[1] {
                runs.next.push(ColumnInterval { column: interval.column + self.forward, range_um: left_um });
            }
            begin = end + 1;
        }
    }

    /// Least y of a row of cells.
    fn low_um(&self, row: i64) -> f64 {
        row as f64 * self.side_um
    }

    /// Range of the open cells about some rows of them, as far as runs reach and centres are near.
    fn open_um(
        &self,
        rows: [i64; 2],
        reach_um: [f64; 2],
        near_um: [f64; 2],
        is_closed: &mut impl FnMut(i64) -> bool,
    ) -> [f64; 2] {
        let [mut lowest, mut highest] = rows;
        while self.low_um(lowest) > reach_um[0].max(near_um[0]) && !is_closed(lowest - 1) {
            lowest -= 1;
        }
        while self.low_um(highest + 1) < reach_um[1].min(near_um[1]) && !is_closed(highest + 1) {
            highest += 1;
        }
        [self.low_um(lowest), self.low_um(highest + 1)]
    }
}

/// The same centres with overlapping intervals united, by column and y.
pub(super) fn merged(mut intervals: Vec<ColumnInterval>) -> Vec<ColumnInterval> {
    intervals.sort_by(|one, other| one.column.cmp(&other.column).then(one.range_um[0].total_cmp(&other.range_um[0])));
    intervals.dedup_by(|later, earlier| {
        let is_joined = later.column == earlier.column && later.range_um[0] <= earlier.range_um[1];
        if is_joined {
            earlier.range_um[1] = earlier.range_um[1].max(later.range_um[1]);
        }
        is_joined
    });
    intervals
}
