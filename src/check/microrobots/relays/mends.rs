//! The smallest change of one voltage that fixes a fault.
//!
//! The validity of a table changes only where a voltage passes a limit of its row or comes two margins from another one
//! of the same transition. Only these breakpoints are tried, nearest first, each rounded away from the present voltage
//! to the coarsest decimals that do.

use super::cycles::PatternTarget;
use super::faults::{self, Census};
use super::table::{VoltageTable, volts_v};
use super::{AllowedGaps, Mend, Problem, Transition};

/// Rounding steps that are tried, in units of the table: a nanovolt to a tenth of a volt.
const GRAINS: [i64; 5] = [2, 2_000, 2_000_000, 20_000_000, 200_000_000];

/// Improvement by a change; the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum MendQuality {
    /// The table has no fault left.
    All,
    /// The fault is fixed, and the row has fewer in all.
    More,
    /// The fault is fixed.
    Some,
}

/// For each fault, the smallest of the changes that improve the table most.
///
/// `problems` are all faults of the table, or as many as are to be reported.
pub fn mends(table: &VoltageTable, gaps: AllowedGaps, problems: &[Problem]) -> Vec<Option<Mend>> {
    let census = Census::of(table, gaps);
    let ranks = table.ranks();
    let too_long: Vec<usize> = problems.iter().filter_map(|problem| problem.state()).collect();
    let (census, ranks, too_long) = (&census, &ranks[..], &too_long[..]);
    let mend_of = |problem| mend(&MendSearch { table, gaps, census, ranks, too_long, problem });
    problems.iter().map(mend_of).collect()
}

fn mend(search: &MendSearch) -> Option<Mend> {
    let mut places: Vec<VoltageBreakpoint> =
        search.voltages().into_iter().flat_map(|(row, transition)| search.places(row, transition)).collect();
    places.sort_by_key(|place| (place.far(), place.row, place.transition, -place.to, place.way));
    places.dedup();
    let mut best: Option<(MendQuality, i64, Mend)> = None;
    for place in places {
        if best.is_some_and(|(quality, far, _)| far + search.patience(quality) <= place.far()) {
            break;
        }
        let Some((quality, to)) = search.tried(place) else { continue };
        let far = (to - place.from).abs();
        if best.is_none_or(|(other, least, _)| (quality, far) < (other, least)) {
            best = Some((quality, far, Mend { row: place.row, transition: place.transition, to_v: volts_v(to) }));
        }
    }
    best.map(|(_, _, mend)| mend)
}

/// A fault and the table that has it.
struct MendSearch<'a> {
    table: &'a VoltageTable,
    gaps: AllowedGaps,
    census: &'a Census,
    /// Rank of each row in the order of snap-down.
    ranks: &'a [usize],
    /// States that take too many levels.
    too_long: &'a [usize],
    problem: &'a Problem,
}

/// A voltage at which the validity of the table may change.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct VoltageBreakpoint {
    row: usize,
    transition: Transition,
    from: i64,
    to: i64,
    /// 1 upwards, -1 downwards.
    way: i64,
}

impl VoltageBreakpoint {
    fn far(&self) -> i64 {
        (self.to - self.from).abs()
    }

    /// The two nearest multiples of a rounding step that lie at the breakpoint or beyond.
    fn rounded(&self, grain: i64) -> [i64; 2] {
        let steps = (self.to * self.way).div_euclid(grain) + i64::from((self.to * self.way).rem_euclid(grain) != 0);
        [steps * grain * self.way, (steps + 1) * grain * self.way]
    }
}

impl MendSearch<'_> {
    /// Greatest excess over a change with some improvement at which a change with a greater improvement is still
    /// sought, in units of the table.
    fn patience(&self, quality: MendQuality) -> i64 {
        match (quality, self.problem.state()) {
            (MendQuality::All, _) => 0,
            (MendQuality::More | MendQuality::Some, Some(_)) => 4 * self.table.margin,
            (MendQuality::More | MendQuality::Some, None) => self.table.max,
        }
    }

    /// The voltages involved in the fault.
    fn voltages(&self) -> Vec<(usize, Transition)> {
        let both = |row: usize| [(row, Transition::SnapDown), (row, Transition::Release)];
        match *self.problem {
            Problem::Hold { row, .. } | Problem::Floor { row, .. } => vec![(row, Transition::Release)],
            Problem::Drive { row, .. } | Problem::Range { row, .. } => vec![(row, Transition::SnapDown)],
            Problem::Narrow { row, .. } => both(row).to_vec(),
            Problem::Nested { outer: one, inner: other, .. } | Problem::Alike { one, other, .. } => {
                [both(one), both(other)].concat()
            }
            Problem::NoSequence { .. } => (0..self.table.len()).flat_map(both).collect(),
            Problem::Crowd { .. } => Vec::new(),
        }
    }

    fn places(&self, row: usize, transition: Transition) -> Vec<VoltageBreakpoint> {
        let (table, gap) = (self.table, 2 * self.table.margin);
        let from = table.voltage(row, transition);
        let limits = match transition {
            Transition::SnapDown => [table.flex + gap, table.max - table.margin, table.releases[row] + gap],
            Transition::Release => [table.relax - gap, table.margin, table.snap_downs[row] - gap],
        };
        let others = table.voltages(transition).iter().flat_map(|voltage| [voltage - gap, voltage + gap]);
        let place = |to: i64| {
            let ways: &[i64] = if to == from { &[1, -1] } else { &[1, -1][usize::from(to < from)..][..1] };
            ways.iter().map(move |way| VoltageBreakpoint { row, transition, from, to, way: *way })
        };
        limits.into_iter().chain(others).filter(|to| (0..=table.max).contains(to)).flat_map(place).collect()
    }

    /// The coarsest voltage at a breakpoint that improves the table as much as the finest one there.
    fn tried(&self, place: VoltageBreakpoint) -> Option<(MendQuality, i64)> {
        let mut changed = self.table.clone();
        let mut quality_of = |to: i64| {
            changed.set(place.row, place.transition, to);
            self.quality(&changed, place)
        };
        let [finest, ..] = GRAINS;
        let best = place.rounded(finest).into_iter().filter_map(&mut quality_of).min()?;
        let rounded = GRAINS.iter().rev().flat_map(|grain| place.rounded(*grain));
        rounded
            .map(|to| (quality_of(to), to))
            .find_map(|(quality, to)| quality.filter(|quality| *quality <= best).zip(Some(to)))
    }

    /// Improvement of a table by a change in one row.
    fn quality(&self, changed: &VoltageTable, place: VoltageBreakpoint) -> Option<MendQuality> {
        let row = place.row;
        if !keeps_limits(changed, row, place.transition) {
            return None;
        }
        let left = faults::alone(changed, row).count() + faults::shared(changed, self.gaps, row);
        let is_mended = match self.problem.state() {
            Some(state) => left == 0 && self.is_short(changed, row, state),
            None => self.is_mended(changed),
        };
        if !is_mended {
            return None;
        }
        let before = self.census.of_row(row);
        if left == 0 && self.census.total() == before && self.has_short_cycles(changed, row) {
            return Some(MendQuality::All);
        }
        Some(if left < before.max(1) { MendQuality::More } else { MendQuality::Some })
    }

    fn is_mended(&self, changed: &VoltageTable) -> bool {
        match *self.problem {
            Problem::Hold { row, .. } => changed.releases[row] <= changed.relax - 2 * changed.margin,
            Problem::Drive { row, .. } => changed.snap_downs[row] >= changed.flex + 2 * changed.margin,
            Problem::Range { row, .. } => changed.snap_downs[row] <= changed.max - changed.margin,
            Problem::Floor { row, .. } => changed.releases[row] >= changed.margin,
            Problem::Narrow { row, .. } => changed.snap_downs[row] - changed.releases[row] >= 2 * changed.margin,
            Problem::Nested { outer: one, inner: other, .. } | Problem::Alike { one, other, .. } => {
                changed.is_ordered(one, other)
            }
            Problem::NoSequence { .. } | Problem::Crowd { .. } => false,
        }
    }

    /// Whether each state has a cycle that is short enough, after a change in a row that leaves no other faults.
    fn has_short_cycles(&self, changed: &VoltageTable, row: usize) -> bool {
        match self.gaps {
            AllowedGaps::Any => true,
            AllowedGaps::String => {
                self.too_long.iter().copied().chain(0..=changed.len()).all(|state| self.is_short(changed, row, state))
            }
        }
    }

    /// Whether one state has a cycle that is short enough after a change in a row.
    fn is_short(&self, changed: &VoltageTable, row: usize, state: usize) -> bool {
        let is_down: Vec<bool> = (0..changed.len()).map(|other| self.rank(changed, row, other) < state).collect();
        PatternTarget::new(changed, &changed.ranked(), &is_down).length() <= changed.most_levels
    }

    /// Rank of a row in the order after a change in another one or in itself.
    fn rank(&self, changed: &VoltageTable, row: usize, of: usize) -> usize {
        match of == row {
            true => changed.rank(row),
            false => {
                let before = usize::from(self.table.separates(row, of));
                self.ranks[of] + usize::from(changed.separates(row, of)) - before
            }
        }
    }
}

/// Whether the voltage that was changed keeps the limits of its row.
fn keeps_limits(table: &VoltageTable, row: usize, transition: Transition) -> bool {
    let (snap_down, release, gap) = (table.snap_downs[row], table.releases[row], 2 * table.margin);
    snap_down - release >= gap
        && match transition {
            Transition::SnapDown => snap_down >= table.flex + gap && snap_down <= table.max - table.margin,
            Transition::Release => release <= table.relax - gap && release >= table.margin,
        }
}
