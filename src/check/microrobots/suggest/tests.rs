//! Suggested tables against all tables of a small grid.

use super::*;

fn slack_v(rows: &[RelayRow], limits: SuggestLimits, [relax_v, flex_v]: [f64; 2]) -> Option<f64> {
    let source = Source { margin_v: limits.margin_v, relax_v, flex_v, max_v: limits.max_v, most_levels: 2 };
    let states = analyse(rows, source, AllowedGaps::String).states;
    states.iter().map(|state| state.slack_v).reduce(f64::min)
}

fn held(robots: usize, limits: SuggestLimits) -> Suggestion {
    let found = suggest(robots, limits);
    let table = found.table.as_ref().expect("so many fit");
    assert_eq!(table.len(), robots);
    assert_eq!(slack_v(table, limits, [found.relax_v, found.flex_v]), Some(found.slack_v));
    assert!(found.slack_v >= 0.99 * best_slack_v(robots, limits) - 1e-8, "{found:?}");
    let order: Vec<[f64; 2]> = table.iter().map(|row| [row.snap_down_v, row.release_v]).collect();
    assert!(order.windows(2).all(|pair| pair[0][0] <= pair[1][0] && pair[0][1] <= pair[1][1]));
    found
}

/// The greatest slack of a table with voltages in whole volts.
fn best_on_grid_v(robots: usize, limits: SuggestLimits, drive_v: [f64; 2]) -> Option<f64> {
    let volts = |from_v: f64, to_v: f64| (from_v as i64..=to_v as i64).map(|volt| volt as f64);
    let pairs = volts(drive_v[1], limits.max_v)
        .flat_map(|snap_down_v| volts(0.0, drive_v[0]).map(move |release_v| RelayRow { snap_down_v, release_v }));
    let rows: Vec<RelayRow> = pairs.filter(|row| slack_v(&[*row], limits, drive_v).is_some()).collect();
    let mut best_v: Option<f64> = None;
    let mut open: Vec<(usize, Vec<RelayRow>)> = vec![(0, Vec::new())];
    while let Some((next, chosen)) = open.pop() {
        if chosen.len() == robots {
            let found_v = slack_v(&chosen, limits, drive_v);
            best_v = best_v.into_iter().chain(found_v).reduce(f64::max);
            continue;
        }
        for (at, row) in rows.iter().enumerate().skip(next) {
            let more = [&chosen[..], &[*row]].concat();
            let source = Source {
                margin_v: limits.margin_v,
                relax_v: drive_v[0],
                flex_v: drive_v[1],
                max_v: limits.max_v,
                most_levels: 64,
            };
            if !analyse(&more, source, AllowedGaps::String).states.is_empty() {
                open.push((at + 1, more));
            }
        }
    }
    best_v
}

#[test]
fn no_table_of_a_small_grid_is_better_or_larger() {
    for (relax_v, above_v) in [(3.0, 3.0), (5.0, 4.0), (5.0, 7.0), (6.0, 6.0), (7.0, 5.0), (2.0, 9.0), (4.0, 8.0)] {
        let drive_v = [relax_v, 10.0];
        let limits = SuggestLimits { margin_v: 1.0, max_v: 10.0 + above_v, drive_v: Some(drive_v), swing_v: 0.0 };
        let most = suggest(1, limits).most;
        for robots in 1..=most {
            let best_v = best_on_grid_v(robots, limits, drive_v).expect("so many fit");
            let found = held(robots, limits);
            assert!(found.slack_v >= best_v - 0.01 * best_v.max(1e-6), "{found:?}, but {best_v} V");
        }
        assert_eq!(best_on_grid_v(most + 1, limits, drive_v), None, "{limits:?}");
        assert_eq!(suggest(most + 1, limits).table, None);
    }
}

#[test]
fn drive_levels_that_are_chosen_cost_no_slack() {
    for (margin_v, max_v, swing_v) in [(4.0, 200.0, 40.0), (2.0, 200.0, 30.0), (0.3, 20.0, 2.5), (1.0, 16.0, 2.0)] {
        let limits = SuggestLimits { margin_v, max_v, drive_v: None, swing_v };
        let most = suggest(1, limits).most;
        assert_eq!(suggest(most + 1, limits).table, None);
        for robots in 1..=most {
            let found = held(robots, limits);
            assert!((found.flex_v - found.relax_v - swing_v).abs() < 1e-6);
            let step_v = if margin_v < 1.0 { 0.1 } else { 1.0 };
            let others = (0..(max_v / step_v) as usize).map(|step| step as f64 * step_v);
            let others_v = others.map(|relax_v| [relax_v, relax_v + swing_v]);
            let best_v = others_v.map(|it| best_slack_v(robots, SuggestLimits { drive_v: Some(it), ..limits }));
            assert!(best_v.reduce(f64::max).is_none_or(|best_v| best_v <= best_slack_v(robots, limits) + 1e-9));
        }
    }
}

#[test]
fn six_robots_of_the_issue() {
    let limits = SuggestLimits { margin_v: 4.0, max_v: 200.0, drive_v: None, swing_v: 40.0 };
    let found = held(6, limits);
    assert_eq!(found.most, 18);
    assert!((found.slack_v - 96.0 / 14.0).abs() < 0.07, "{found:?}");
}

#[test]
fn nothing_fits() {
    for wild in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e300] {
        let limits = SuggestLimits { margin_v: wild, max_v: wild, drive_v: None, swing_v: wild };
        suggest(3, limits);
        suggest(3, SuggestLimits { drive_v: Some([wild, wild]), ..limits });
        suggest(usize::MAX, SuggestLimits { margin_v: 1.0, ..limits });
    }
    let narrow = SuggestLimits { margin_v: 4.0, max_v: 200.0, drive_v: Some([11.0, 90.0]), swing_v: 0.0 };
    assert_eq!(suggest(1, narrow), Suggestion { most: 0, table: None, relax_v: 11.0, flex_v: 90.0, slack_v: 0.0 });
    assert_eq!(suggest(0, SuggestLimits { max_v: 250.0, ..narrow }).table, None);
    assert_eq!(suggest(1, SuggestLimits { drive_v: Some([12.0, 188.0]), ..narrow }).slack_v, 0.0);
}
