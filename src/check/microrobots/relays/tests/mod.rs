//! Known tables, and random ones against a plain simulation of relays.

use super::*;
use oracle::{Bed, Random};

mod oracle;

const SOURCE: Source = Source { margin_v: 2.0, relax_v: 60.0, flex_v: 90.0, max_v: 200.0, most_levels: 64 };

fn rows(voltages: &[(f64, f64)]) -> Vec<RelayRow> {
    voltages
        .iter()
        .map(|(snap_down_v, release_v)| RelayRow { snap_down_v: *snap_down_v, release_v: *release_v })
        .collect()
}

fn only_fault(voltages: &[(f64, f64)], source: Source) -> TableFault {
    let analysis = analyse(&rows(voltages), source, AllowedGaps::String);
    assert_eq!((analysis.faults.len(), analysis.more_faults, analysis.states.len()), (1, 0, 0), "{analysis:?}");
    analysis.faults[0].clone()
}

fn digits(analysis: &Analysis) -> Vec<String> {
    analysis.states.iter().map(ControlState::digits).collect()
}

#[test]
fn the_golden_table() {
    let table = rows(&[(110.0, 20.0), (110.0, 35.0), (130.0, 35.0), (150.0, 50.0)]);
    let found = analyse(&table, SOURCE, AllowedGaps::String);
    assert_eq!(found.order, [0, 1, 2, 3]);
    assert_eq!(digits(&found), ["0000", "1000", "1100", "1110", "1111"]);
    let levels: Vec<&[f64]> = found.states.iter().map(|state| &state.levels_v[..]).collect();
    assert_eq!(levels, [&[9.0][..], &[176.0, 27.5], &[9.0, 120.0], &[9.0, 140.0], &[176.0]]);
    let slacks: Vec<f64> = found.states.iter().map(|state| state.slack_v).collect();
    assert_eq!(slacks, [9.0, 5.5, 8.0, 8.0, 24.0]);
    let any = analyse(&table, SOURCE, AllowedGaps::Any);
    assert_eq!((any.states, any.order), (found.states, found.order));
}

#[test]
fn rows_in_any_order_get_the_same_cycles() {
    let table = rows(&[(150.0, 50.0), (110.0, 35.0), (110.0, 20.0), (130.0, 35.0)]);
    let found = analyse(&table, SOURCE, AllowedGaps::String);
    assert_eq!(found.order, [2, 1, 3, 0]);
    assert_eq!(digits(&found), ["0000", "0010", "0110", "0111", "1111"]);
    assert_eq!(found.states[1].levels_v, [176.0, 27.5]);
}

#[test]
fn a_first_level_stays_near_where_the_reset_level_has_less_slack() {
    let table = rows(&[(110.0, 20.0), (110.0, 35.0), (195.0, 50.0)]);
    let found = analyse(&table, SOURCE, AllowedGaps::String);
    assert_eq!(found.states[3].slack_v, 1.5);
    assert_eq!((found.states[1].slack_v, &found.states[1].levels_v[..]), (5.5, &[156.0, 27.5][..]));
}

#[test]
fn three_levels_where_two_are_not_enough() {
    let table = [(110.0, 33.0), (115.0, 30.0), (114.5, 34.5)];
    let found = analyse(&rows(&table), SOURCE, AllowedGaps::String);
    assert_eq!(found.order, [0, 1, 2]);
    assert_eq!(digits(&found), ["000", "100", "110", "111"]);
    assert_eq!(found.states[2].levels_v[1..], [32.25, 112.25]);
    assert_eq!(found.states[2].slack_v, 0.25);
    let fault = only_fault(&table, Source { most_levels: 2, ..SOURCE });
    let snap_down = RowGap { down: 1, up: 2, gap_v: -0.5 };
    let release = RowGap { down: 0, up: 2, gap_v: 1.5 };
    assert_eq!(fault.problem, Problem::NoSequence { state: 2, levels: 3, snap_down, release, least_v: 4.0 });
    assert_eq!(fault.mend, Some(Mend { row: 0, transition: Transition::Release, to_v: 30.5 }));
}

#[test]
fn pairs_that_no_chain_allows() {
    let alike = only_fault(&[(110.0, 20.0), (110.0, 20.0)], SOURCE);
    let gaps = (0.0, 0.0);
    let (snap_down_gap_v, release_gap_v) = gaps;
    assert_eq!(alike.problem, Problem::Alike { one: 0, other: 1, snap_down_gap_v, release_gap_v, least_v: 4.0 });
    assert_eq!(alike.mend, Some(Mend { row: 0, transition: Transition::SnapDown, to_v: 114.0 }));
    let nested = only_fault(&[(150.0, 20.0), (140.0, 35.0)], SOURCE);
    let (snap_down_gap_v, release_gap_v) = (10.0, 15.0);
    let (outer, inner) = (0, 1);
    assert_eq!(nested.problem, Problem::Nested { outer, inner, snap_down_gap_v, release_gap_v, least_v: 4.0 });
    assert_eq!(nested.mend, Some(Mend { row: 0, transition: Transition::SnapDown, to_v: 143.9 }));
    let just = [(110.0, 20.0), (110.0, 24.0)];
    assert_eq!(analyse(&rows(&just), SOURCE, AllowedGaps::String).faults, []);
    only_fault(&[(110.0, 20.0), (110.0, 23.999)], SOURCE);
}

#[test]
fn limits_of_a_row() {
    let mend = |transition, to_v| Some(Mend { row: 0, transition, to_v });
    let fault = |snap_down_v, release_v| only_fault(&[(snap_down_v, release_v)], SOURCE);
    let hold = fault(120.0, 56.5);
    assert_eq!(hold.problem, Problem::Hold { row: 0, most_v: 56.0 });
    assert_eq!(hold.mend, mend(Transition::Release, 56.0));
    let drive = fault(93.9, 20.0);
    assert_eq!(drive.problem, Problem::Drive { row: 0, least_v: 94.0 });
    assert_eq!(drive.mend, mend(Transition::SnapDown, 94.0));
    let range = fault(198.5, 20.0);
    assert_eq!(range.problem, Problem::Range { row: 0, most_v: 198.0 });
    let floor = fault(120.0, 1.0);
    assert_eq!(floor.problem, Problem::Floor { row: 0, least_v: 2.0 });
    assert_eq!(floor.mend, mend(Transition::Release, 2.0));
    for inside in [(120.0, 56.0), (94.0, 20.0), (198.0, 20.0), (120.0, 2.0)] {
        assert_eq!(analyse(&rows(&[inside]), SOURCE, AllowedGaps::String).states.len(), 2);
    }
    let source = Source { relax_v: 100.0, flex_v: 20.0, ..SOURCE };
    let narrow = only_fault(&[(63.0, 60.0)], source);
    assert_eq!(narrow.problem, Problem::Narrow { row: 0, gap_v: 3.0, least_v: 4.0 });
    assert_eq!(narrow.mend, mend(Transition::SnapDown, 64.0));
}

#[test]
fn gaps_are_exact_in_decimals() {
    let source = Source { margin_v: 0.1, ..SOURCE };
    let table = rows(&[(110.1, 20.0), (110.3, 20.0), (110.5, 20.0)]);
    let found = analyse(&table, source, AllowedGaps::String);
    assert_eq!(found.states.len(), 4);
    assert_eq!((found.states[1].slack_v, found.states[1].levels_v[1]), (0.0, 110.2));
}

#[test]
fn grids_have_as_many_states_as_lattice_paths() {
    for (size, states) in [(1, 2), (2, 6), (3, 20), (4, 70), (5, 252)] {
        let grid: Vec<(f64, f64)> = (0..size * size)
            .map(|at| (110.0 + f64::from(at % size) * 10.0, 10.0 + f64::from(at / size) * 8.0))
            .collect();
        let found = analyse(&rows(&grid), SOURCE, AllowedGaps::Any);
        assert_eq!((found.states.len(), found.too_long, found.faults.len()), (states, 0, 0));
        assert!(found.states.iter().all(|state| state.slack_v >= 2.0 && state.levels_v.len() <= 2 * size as usize));
    }
}

#[test]
fn a_crowd_of_states_is_a_fault() {
    let nested = |robots: i32| -> Vec<(f64, f64)> {
        (0..robots).map(|at| (110.0 + f64::from(at) * 5.0, 54.0 - f64::from(at) * 4.0)).collect()
    };
    assert_eq!(analyse(&rows(&nested(12)), SOURCE, AllowedGaps::Any).states.len(), MAX_STATES);
    let crowd = analyse(&rows(&nested(13)), SOURCE, AllowedGaps::Any);
    assert_eq!(crowd.faults, [TableFault { problem: Problem::Crowd { most: MAX_STATES }, mend: None }]);
    assert_eq!(analyse(&rows(&nested(5)), Source { most_levels: 3, ..SOURCE }, AllowedGaps::Any).too_long, 10);
}

#[test]
fn wild_figures_are_no_panic() {
    for wild in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -1.0, 0.0] {
        let table = rows(&[(wild, 20.0), (110.0, wild), (wild, wild), (130.0, 30.0)]);
        for gaps in [AllowedGaps::String, AllowedGaps::Any] {
            assert_ne!(analyse(&table, SOURCE, gaps).faults, []);
            let source = Source { margin_v: wild, relax_v: wild, flex_v: wild, max_v: wild, most_levels: 0 };
            analyse(&table, source, gaps);
        }
    }
    assert_eq!(analyse(&[], SOURCE, AllowedGaps::String).states.len(), 1);
    let many = analyse(&rows(&[(110.0, 20.0); 128]), SOURCE, AllowedGaps::String);
    assert_eq!((many.faults.len(), many.more_faults), (MAX_FAULTS, 128 * 127 / 2 - MAX_FAULTS));
    assert_eq!(analyse(&rows(&[(110.0, 20.0); 128]), SOURCE, AllowedGaps::Any).states.len(), 2);
}

/// Number of tables with each outcome.
#[derive(Debug, Default)]
struct Tally {
    valid: usize,
    limits: usize,
    nested: usize,
    alike: usize,
    too_long: usize,
    long_cycles: usize,
    longest: usize,
}

#[test]
fn ten_thousand_random_tables_agree_with_simulated_relays() {
    let mut random = Random(4);
    let mut tally = Tally::default();
    for number in 0..10_000 {
        let (table, source) = random.table(if number % 50 == 0 { 6 } else { 5 });
        agree(&table, source, number % 10 == 0, &mut tally);
    }
    let Tally { valid, limits, nested, alike, too_long, long_cycles, longest } = tally;
    assert!([valid, limits, nested, alike].iter().all(|count| *count > 500), "{tally:?}");
    assert!(too_long > 300 && long_cycles > 300 && longest >= 4, "{tally:?}");
}

fn agree(table: &[RelayRow], source: Source, slacks: bool, tally: &mut Tally) {
    let string = analyse(table, source, AllowedGaps::String);
    let any = analyse(table, source, AllowedGaps::Any);
    if table.iter().any(|row| oracle::breaks_limits(*row, source)) {
        tally.limits += 1;
        assert!(string.states.is_empty() && any.states.is_empty());
        assert!(table.iter().enumerate().all(|(row, it)| {
            let is_named = any.faults.iter().any(|fault| fault.problem.rows().contains(&row));
            is_named == oracle::breaks_limits(*it, source)
        }));
        return;
    }
    let bed = Bed::new(table, source, 0.0);
    let accessible = bed.accessible();
    let short = accessible.iter().filter(|(_, levels)| **levels <= source.most_levels);
    let expected: Vec<String> = short.map(|(pattern, _)| pattern.clone()).collect();
    let mut found = digits(&any);
    assert!(found.is_sorted_by_key(|digits| (digits.matches('1').count(), digits.clone())));
    found.sort();
    assert_eq!(found, expected, "{table:?} {source:?}");
    assert_eq!(any.too_long, accessible.len() - expected.len());
    let is_chain = oracle::are_pairs_chains(table, source);
    assert!(!is_chain || oracle::is_chain(&accessible.keys().cloned().collect::<Vec<_>>(), table.len()));
    assert_eq!(string.states.len() == table.len() + 1, is_chain && any.too_long == 0, "{table:?} {string:?}");
    assert_eq!(string.faults.is_empty(), is_chain && any.too_long == 0);
    for state in any.states.iter().chain(&string.states) {
        let levels = state.levels_v.len();
        assert_eq!(levels, accessible[&state.digits()], "{table:?}");
        assert_eq!(bed.after(&state.levels_v), Some(state.digits()), "{table:?} {source:?} {state:?}");
        tally.long_cycles += usize::from(levels > 2);
        tally.longest = tally.longest.max(levels);
        if slacks {
            best_slack(&bed, table, source, state);
        }
    }
    let has = |is: fn(&Problem) -> bool| usize::from(string.faults.iter().any(|fault| is(&fault.problem)));
    tally.valid += usize::from(string.faults.is_empty());
    tally.nested += has(|problem| matches!(problem, Problem::Nested { .. }));
    tally.alike += has(|problem| matches!(problem, Problem::Alike { .. }));
    tally.too_long += has(|problem| matches!(problem, Problem::NoSequence { .. }));
}

/// Checks that each level may be off by the slack, independently of the others, and that no cycle of that length allows
/// more.
fn best_slack(bed: &Bed, table: &[RelayRow], source: Source, state: &ControlState) {
    for signs in 0..1 << state.levels_v.len().min(6) {
        let off =
            |(at, level): (usize, &f64)| level + if signs >> at & 1 == 1 { state.slack_v } else { -state.slack_v };
        let levels: Vec<f64> = state.levels_v.iter().enumerate().map(off).collect();
        assert!(levels.iter().all(|level| (0.0..=source.max_v).contains(level)));
        assert_eq!(bed.after(&levels), Some(state.digits()), "{table:?} {source:?} {state:?}");
    }
    let harder = Bed::new(table, source, state.slack_v + 0.01).accessible();
    assert!(harder.get(&state.digits()).is_none_or(|levels| *levels > state.levels_v.len()), "{table:?} {state:?}");
}

impl Problem {
    fn rows(&self) -> Vec<usize> {
        match *self {
            Problem::Hold { row, .. }
            | Problem::Drive { row, .. }
            | Problem::Range { row, .. }
            | Problem::Floor { row, .. }
            | Problem::Narrow { row, .. } => vec![row],
            Problem::Nested { outer, inner, .. } => vec![outer, inner],
            Problem::Alike { one, other, .. } => vec![one, other],
            Problem::NoSequence { .. } | Problem::Crowd { .. } => Vec::new(),
        }
    }
}

#[test]
fn mends_mend_and_are_small() {
    let mut random = Random(5);
    let (mut whole, mut part) = (0, 0);
    for _ in 0..600 {
        let (table, source) = random.table(4);
        for fault in analyse(&table, source, AllowedGaps::String).faults {
            let least_v = oracle::least_mend_v(&table, source);
            let Some(mend) = fault.mend else {
                assert_eq!(least_v, None, "{table:?} {source:?} {fault:?}");
                continue;
            };
            let (mended, change_v) = applied(&table, mend);
            let after = analyse(&mended, source, AllowedGaps::String);
            match after.faults.is_empty() {
                true => whole += 1,
                false => part += 1,
            }
            let rows = fault.problem.rows();
            let is_same = |other: &TableFault| other.problem.rows() == rows && !rows.is_empty();
            assert!(!after.faults.iter().any(|other| is_same(other) && is_alike(other, &fault)), "{table:?} {fault:?}");
            if let Some(least_v) = least_v.filter(|_| concerns_whole(&table, source, &fault)) {
                assert!(after.faults.is_empty(), "{table:?} {source:?} {fault:?}");
                assert!(change_v <= least_v + 0.2, "{table:?} {source:?} {fault:?}: {change_v} V, but {least_v} V");
            }
        }
    }
    assert!(whole > 150 && part > 150, "{whole} {part}");
}

fn is_alike(one: &TableFault, other: &TableFault) -> bool {
    std::mem::discriminant(&one.problem) == std::mem::discriminant(&other.problem)
}

/// Whether a fault is the table's only one, so that fixing it fixes the table.
fn concerns_whole(table: &[RelayRow], source: Source, fault: &TableFault) -> bool {
    let is_pair_or_state = !matches!(
        fault.problem,
        Problem::Hold { .. } | Problem::Drive { .. } | Problem::Range { .. } | Problem::Floor { .. }
    );
    is_pair_or_state && analyse(table, source, AllowedGaps::String).faults.len() == 1
}

fn applied(table: &[RelayRow], mend: Mend) -> (Vec<RelayRow>, f64) {
    let mut table = table.to_vec();
    let voltage_v = match mend.transition {
        Transition::SnapDown => &mut table[mend.row].snap_down_v,
        Transition::Release => &mut table[mend.row].release_v,
    };
    let change_v = (mend.to_v - *voltage_v).abs();
    *voltage_v = mend.to_v;
    (table, change_v)
}
