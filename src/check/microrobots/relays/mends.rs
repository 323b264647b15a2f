//! The smallest change of one voltage that mends a fault.
//!
//! Whether a table is right changes only where a voltage passes a limit of its row or comes two margins from one of the same sort;
//! so just these places are tried, nearest first, each rounded away from the present voltage to the coarsest decimals that do.

use super::cycles::Target;
use super::faults::{self, Census};
use super::table::{Table, volts_v};
use super::{Gaps, Mend, Problem, Transition};

/// Decimals that are tried: tenths of a volt first, the nanovolt last.
const GRAINS: [i64; 5] = [200_000_000, 20_000_000, 2_000_000, 2_000, 2];

/// How much good a change does; the best first.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Good {
    /// The table has no fault any more.
    All,
    /// The fault is mended, and the row has fewer in all.
    More,
    /// The fault is mended.
    Some,
}

/// The smallest change for a fault, of those that do the most good.
pub fn mend(table: &Table, gaps: Gaps, problem: &Problem) -> Option<Mend> {
    let clinic = Clinic { table, gaps, census: Census::of(table, gaps), problem };
    let mut places: Vec<Place> = clinic.voltages().into_iter().flat_map(|voltage| clinic.places(voltage)).collect();
    places.sort_by_key(|place| (place.far(), place.row));
    let mut best: Option<(Good, i64, Mend)> = None;
    for place in places {
        if best.is_some_and(|(good, far, _)| good == Good::All && far <= place.far()) {
            break;
        }
        for (good, to) in clinic.tried(place) {
            let far = (to - place.from).abs();
            if best.is_none_or(|(other, least, _)| (good, far) < (other, least)) {
                best = Some((good, far, Mend { row: place.row, transition: place.transition, to_v: volts_v(to) }));
            }
        }
    }
    best.map(|(_, _, mend)| mend)
}

/// A fault and the table that has it.
struct Clinic<'a> {
    table: &'a Table,
    gaps: Gaps,
    census: Census,
    problem: &'a Problem,
}

/// Where moving a voltage may change something.
#[derive(Debug, Clone, Copy)]
struct Place {
    row: usize,
    transition: Transition,
    from: i64,
    to: i64,
    /// 1 upwards, -1 downwards.
    way: i64,
}

impl Place {
    fn far(&self) -> i64 {
        (self.to - self.from).abs()
    }

    /// The two nearest round voltages that lie at the place or beyond.
    fn rounded(&self, grain: i64) -> [i64; 2] {
        let steps = (self.to * self.way).div_euclid(grain) + i64::from((self.to * self.way).rem_euclid(grain) != 0);
        [steps * grain * self.way, (steps + 1) * grain * self.way]
    }
}

impl Clinic<'_> {
    /// The voltages that have a part in the fault.
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

    fn places(&self, (row, transition): (usize, Transition)) -> Vec<Place> {
        let (table, gap) = (self.table, 2 * self.table.margin);
        let from = table.voltage(row, transition);
        let limits = match transition {
            Transition::SnapDown => [table.flex + gap, table.max - table.margin, table.releases[row] + gap],
            Transition::Release => [table.relax - gap, table.margin, table.snap_downs[row] - gap],
        };
        let others = table.voltages(transition).iter().flat_map(|voltage| [voltage - gap, voltage + gap]);
        let place = |to: i64| {
            let ways: &[i64] = if to == from { &[1, -1] } else { &[1, -1][usize::from(to < from)..][..1] };
            ways.iter().map(move |way| Place { row, transition, from, to, way: *way })
        };
        limits.into_iter().chain(others).filter(|to| (0..=table.max).contains(to)).flat_map(place).collect()
    }

    /// Round voltages at a place that do some good; the coarsest that do all or the most.
    fn tried(&self, place: Place) -> Vec<(Good, i64)> {
        let mut found: Vec<(Good, i64)> = Vec::new();
        let mut changed = self.table.clone();
        for to in GRAINS.iter().flat_map(|grain| place.rounded(*grain)) {
            changed.set(place.row, place.transition, to);
            if let Some(good) = self.good(&changed, place)
                && found.iter().all(|(other, _)| good < *other)
            {
                found.push((good, to));
                if good == Good::All {
                    break;
                }
            }
        }
        found
    }

    /// How much good a table with a change in one row does.
    fn good(&self, changed: &Table, place: Place) -> Option<Good> {
        let row = place.row;
        if !keeps_limits(changed, row, place.transition) || !self.is_mended(changed) {
            return None;
        }
        let alone = faults::alone(changed, row).count();
        let left = alone + faults::shared(changed, self.gaps, row);
        let before = self.census.of_row(row);
        if left == 0 && self.census.total() == before && has_short_cycles(changed, self.gaps) {
            return Some(Good::All);
        }
        let is_better = match self.problem {
            Problem::NoSequence { .. } => left == 0,
            _ => left < before,
        };
        Some(if is_better { Good::More } else { Good::Some })
    }

    fn is_mended(&self, changed: &Table) -> bool {
        match *self.problem {
            Problem::Hold { row, .. } => changed.releases[row] <= changed.relax - 2 * changed.margin,
            Problem::Drive { row, .. } => changed.snap_downs[row] >= changed.flex + 2 * changed.margin,
            Problem::Range { row, .. } => changed.snap_downs[row] <= changed.max - changed.margin,
            Problem::Floor { row, .. } => changed.releases[row] >= changed.margin,
            Problem::Narrow { row, .. } => changed.snap_downs[row] - changed.releases[row] >= 2 * changed.margin,
            Problem::Nested { outer: one, inner: other, .. } | Problem::Alike { one, other, .. } => {
                changed.is_ordered(one, other)
            }
            Problem::NoSequence { state, .. } => changed.order().is_some_and(|order| is_short(changed, &order, state)),
            Problem::Crowd { .. } => false,
        }
    }
}

/// Whether each state of a table without other faults has a cycle that is short enough.
pub fn has_short_cycles(table: &Table, gaps: Gaps) -> bool {
    let all_short = |order: Vec<usize>| (0..=order.len()).all(|state| is_short(table, &order, state));
    match gaps {
        Gaps::Any => true,
        Gaps::String => table.order().is_some_and(all_short),
    }
}

/// Whether the voltage that was changed keeps the limits of its row.
fn keeps_limits(table: &Table, row: usize, transition: Transition) -> bool {
    let (snap_down, release, gap) = (table.snap_downs[row], table.releases[row], 2 * table.margin);
    snap_down - release >= gap
        && match transition {
            Transition::SnapDown => snap_down >= table.flex + gap && snap_down <= table.max - table.margin,
            Transition::Release => release <= table.relax - gap && release >= table.margin,
        }
}

fn is_short(table: &Table, order: &[usize], state: usize) -> bool {
    let mut is_down = vec![false; table.len()];
    order[..state].iter().for_each(|row| is_down[*row] = true);
    Target::new(table, &table.ranked(), &is_down).length() <= table.most_levels
}
