//! Voltage tables: whether one is STRING, and which arm patterns can be set.

use crate::clock::timed;
use crate::rival;
use std::time::Duration;
use tweeze::check::microrobots::relays::{AllowedGaps, Analysis, RelayRow, Source, analyse};
use tweeze::device::microrobots::ControlState;
use tweeze::random::SplitMix64;

const SOURCE: Source = Source { margin_v: 0.5, relax_v: 250.0, flex_v: 290.0, max_v: 600.0, most_levels: 64 };

/// Checks tables of 100 robots, correct and faulty.
pub fn check() {
    println!("\ncheck: whether a table of 100 robots is STRING, with a control cycle for each state or the faults");
    println!("table                     states faults longest cycle      ms");
    check_row("even steps", &even(100), SOURCE);
    check_row("random steps", &random(100, 7), SOURCE);
    check_row("cycles of three levels", &interleaved(100), SOURCE);
    check_row("only two levels allowed", &interleaved(100), Source { most_levels: 2, ..SOURCE });
    check_row("all rows alike", &[RelayRow { snap_down_v: 400.0, release_v: 100.0 }; 100], SOURCE);
    check_row("all rows nested", &nested(100), SOURCE);
}

fn check_row(name: &str, table: &[RelayRow], source: Source) {
    let (time, analysis) = timed(|| analyse(table, source, AllowedGaps::String));
    let faults = analysis.faults.len() + analysis.more_faults;
    let longest = analysis.states.iter().map(|state| state.levels_v.len()).max().unwrap_or(0);
    println!("{name:23} {:8} {faults:6} {longest:13} {:9.3}", analysis.states.len(), milliseconds(time));
}

/// All control states, each with a shortest cycle, against breadth-first search over levels.
pub fn states() {
    println!("\nstates: all arm patterns that can be set, and the shortest cycle of each");
    println!("table         robots states   tweeze ms   breadth-first ms     nodes   ratio");
    for robots in [8, 12] {
        states_row("even steps", &even(robots));
        states_row("random steps", &random(robots, 7));
        states_row("three levels", &interleaved(robots));
        states_row("grid", &grid(robots / 4, 4));
        states_row("nested", &nested(robots));
    }
    states_row("grid", &grid(6, 6));
}

fn states_row(name: &str, table: &[RelayRow]) {
    let (time, analysis) = timed(|| analyse(table, SOURCE, AllowedGaps::Any));
    let (plain, (found, nodes)) = timed(|| rival::patterns(table, SOURCE));
    assert_eq!(lengths(&analysis), found, "both find the same patterns, by as many levels");
    let times = [time, plain].map(milliseconds);
    print!("{name:13} {:6} {:6} {:11.4} {:18.4}", table.len(), analysis.states.len(), times[0], times[1]);
    println!(" {nodes:9} {:7.0}", times[1] / times[0]);
}

/// Each pattern, as bits by row, with the number of levels that set it.
fn lengths(analysis: &Analysis) -> Vec<(u128, usize)> {
    let bits = |state: &ControlState| state.arms.iter().rev().fold(0, |bits, arm| bits << 1 | u128::from(arm.digit()));
    let mut found: Vec<(u128, usize)> = analysis.states.iter().map(|it| (bits(it), it.levels_v.len())).collect();
    found.sort_unstable();
    found
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}

/// Snap-down and release voltages increase alternately.
fn even(robots: usize) -> Vec<RelayRow> {
    let row = |at: usize| RelayRow {
        snap_down_v: 300.0 + at.div_ceil(2) as f64 * 2.0,
        release_v: 10.0 + (at / 2) as f64 * 2.0,
    };
    (0..robots).map(row).collect()
}

/// From row to row one of the voltages increases by two margins or more, the other by less or more; shuffled.
fn random(robots: usize, seed: u64) -> Vec<RelayRow> {
    let mut random = SplitMix64::new(seed);
    let (mut snap_down_v, mut release_v) = (300.0, 10.0);
    let mut table: Vec<RelayRow> = Vec::new();
    for _ in 0..robots {
        table.push(RelayRow { snap_down_v, release_v });
        let (large_v, small_v) = (1.0 + random.unit(), random.unit());
        let is_snap_down = random.unit() < 0.5;
        snap_down_v += if is_snap_down { large_v } else { small_v };
        release_v += if is_snap_down { small_v } else { large_v };
    }
    random.shuffle(&mut table);
    table
}

/// Groups of three rows that two levels cannot distinguish: the example of the model, repeated.
fn interleaved(robots: usize) -> Vec<RelayRow> {
    let three = [(0.0, 0.75), (1.25, 0.0), (1.125, 1.125)];
    let row = |at: usize| {
        let (snap_down_v, release_v) = three[at % 3];
        let base_v = (at / 3) as f64 * 4.0;
        RelayRow { snap_down_v: 300.0 + base_v + snap_down_v, release_v: 10.0 + base_v + release_v }
    };
    (0..robots).map(row).collect()
}

/// Every pair of `snap_downs` snap-down voltages and `releases` release voltages.
fn grid(snap_downs: usize, releases: usize) -> Vec<RelayRow> {
    let row = |at: usize| RelayRow {
        snap_down_v: 300.0 + (at % snap_downs) as f64 * 5.0,
        release_v: 10.0 + (at / snap_downs) as f64 * 5.0,
    };
    (0..snap_downs * releases).map(row).collect()
}

/// Nested hysteresis intervals, so every pattern can be set.
fn nested(robots: usize) -> Vec<RelayRow> {
    let row = |at: usize| RelayRow { snap_down_v: 300.0 + at as f64 * 2.0, release_v: 240.0 - at as f64 * 2.0 };
    (0..robots).map(row).collect()
}
