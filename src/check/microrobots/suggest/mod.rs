//! Suggests a table of voltages for a number of robots: the one whose smallest slack is greatest.
//!
//! Input: margin, range and drive levels of a source. Output: [`Suggestion`]. Promise: no table has a greater slack,
//! and no table has more robots than `most`, among STRING tables whose control cycles have at most two levels. (Longer
//! cycles set the states of somewhat larger tables, which are not searched here.)
//!
//! With two levels each of the n - 1 states between the first and the last needs a gap of 2 (margin + s) between the
//! arms that are down and those that are up, in snap-down or in release, if its slack is to be s. Let p of them be gaps
//! in snap-down and q = n - 1 - p in release. The first and the last state need 2 s between the least release voltage -
//! margin and 0 V, and between the greatest snap-down voltage + margin and the maximum. So s is at most (m - f - 3 d -
//! 2 d p) / (2 p + 2) and at most (r - 3 d - 2 d q) / (2 q + 2), where d is the margin, m the maximum, f the flex level
//! and r the relax level. Equal steps reach the smaller of the two, and the best p is found by trying all. Where f - r
//! alone is given, both bounds together allow s = (m - (f - r) - 6 d - 2 d (n - 1)) / (2 n + 2), whatever p.

use super::relays::table::units;
use super::relays::{AllowedGaps, RelayRow, Source, analyse};
use crate::device::microrobots::MAX_ROBOTS;

/// Decimals of the voltages: the coarsest that cost little slack are taken. The last is the resolution of comparisons.
const GRAINS_V: [f64; 5] = [1e-1, 1e-2, 1e-3, 1e-6, 1e-9];

/// Share of the greatest slack that rounded voltages must keep.
const KEPT: f64 = 0.99;

/// Limits of a suggestion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SuggestLimits {
    /// Each transition voltage will be known to plus or minus this.
    pub margin_v: f64,
    pub max_v: f64,
    /// The relax and the flex level; where `None`, they are chosen, `swing_v` apart.
    pub drive_v: Option<[f64; 2]>,
    /// Difference of flex and relax level where they are not given.
    pub swing_v: f64,
}

/// Suggested table, with its slack.
#[derive(Debug, Clone, PartialEq)]
pub struct Suggestion {
    /// The largest number of robots that fits, up to [`crate::device::microrobots::MAX_ROBOTS`].
    pub most: usize,
    /// In the order in which arms snap down; `None` if the robots do not fit, or none are asked for.
    pub table: Option<Vec<RelayRow>>,
    /// As given, or chosen: for the largest table if the robots do not fit, and without meaning if none does.
    pub relax_v: f64,
    pub flex_v: f64,
    /// The smallest slack of the table's control states, each with at most two levels; 0 without a table.
    pub slack_v: f64,
}

/// The STRING table of `robots` robots whose smallest slack is greatest, in rounded voltages.
pub fn suggest(robots: usize, limits: SuggestLimits) -> Suggestion {
    let most = most(limits);
    let best_v = best_slack_v(robots, limits);
    let fits = (1..=most).contains(&robots);
    let rounded = GRAINS_V.iter().filter(|_| fits).map(|grain_v| fitted(robots, limits, *grain_v));
    let [relax_v, flex_v] = limits.drive_v.unwrap_or_else(|| chosen_v(most, limits, GRAINS_V[0]));
    let mut best = Suggestion { most, table: None, relax_v, flex_v, slack_v: 0.0 };
    for found in rounded.filter(|found| found.table.is_some()) {
        if best.table.is_none() || found.slack_v > best.slack_v {
            best = Suggestion { most, ..found };
        }
        if best.slack_v >= best_v * KEPT {
            break;
        }
    }
    best
}

/// The largest number of robots that fits.
fn most(limits: SuggestLimits) -> usize {
    let margin = units(limits.margin_v).max(units(1e-9));
    let steps = |room: i64| if room < 0 { None } else { Some(room / (2 * margin)) };
    let most = match limits.drive_v {
        Some([relax_v, flex_v]) => {
            let above = steps(units(limits.max_v) - units(flex_v) - 3 * margin);
            let below = steps(units(relax_v) - 3 * margin);
            above.zip(below).map_or(0, |(above, below)| above + below + 1)
        }
        None => steps(units(limits.max_v) - units(limits.swing_v) - 6 * margin).map_or(0, |steps| steps + 1),
    };
    usize::try_from(most).unwrap_or_default().min(MAX_ROBOTS)
}

/// The greatest slack of any table; negative if there is none.
fn best_slack_v(robots: usize, limits: SuggestLimits) -> f64 {
    match limits.drive_v {
        Some(drive_v) => split(robots, limits, drive_v).1,
        None => free_slack_v(robots, limits),
    }
}

/// The greatest slack where the drive levels can be chosen.
fn free_slack_v(robots: usize, limits: SuggestLimits) -> f64 {
    let steps = robots.saturating_sub(1) as f64;
    let room_v = limits.max_v - limits.swing_v - 6.0 * limits.margin_v - 2.0 * limits.margin_v * steps;
    room_v / (2.0 * steps + 4.0)
}

/// The best number of steps between robots made in snap-down, and the slack then.
fn split(robots: usize, limits: SuggestLimits, drive_v: [f64; 2]) -> (usize, f64) {
    let steps = robots.saturating_sub(1).min(MAX_ROBOTS);
    let slack_v = |above: usize| {
        let [below_v, above_v] = rooms_v(limits, drive_v);
        step_slack_v(above_v, above, limits).min(step_slack_v(below_v, steps - above, limits))
    };
    let better = |best: (usize, f64), other: (usize, f64)| if other.1 > best.1 { other } else { best };
    (1..=steps).map(|above| (above, slack_v(above))).fold((0, slack_v(0)), better)
}

/// The ranges that the limits leave to release and to snap-down voltages.
fn rooms_v(limits: SuggestLimits, [relax_v, flex_v]: [f64; 2]) -> [f64; 2] {
    [relax_v - 3.0 * limits.margin_v, limits.max_v - flex_v - 3.0 * limits.margin_v]
}

/// The slack of `steps` equal steps in a range.
fn step_slack_v(room_v: f64, steps: usize, limits: SuggestLimits) -> f64 {
    (room_v - 2.0 * limits.margin_v * steps as f64) / (2.0 * steps as f64 + 2.0)
}

/// The best table with voltages rounded to a grain; without a table if rounding makes it invalid.
fn fitted(robots: usize, limits: SuggestLimits, grain_v: f64) -> Suggestion {
    let drive_v = limits.drive_v.unwrap_or_else(|| chosen_v(robots, limits, grain_v));
    let rows = rows(robots, limits, drive_v, grain_v);
    let [relax_v, flex_v] = drive_v;
    let source = Source { margin_v: limits.margin_v, relax_v, flex_v, max_v: limits.max_v, most_levels: 2 };
    let states = analyse(&rows, source, AllowedGaps::String).states;
    let slack_v = states.iter().map(|state| state.slack_v).reduce(f64::min);
    Suggestion { most: 0, table: slack_v.map(|_| rows), relax_v, flex_v, slack_v: slack_v.unwrap_or(0.0) }
}

/// Drive levels that leave half of the steps to snap-down.
fn chosen_v(robots: usize, limits: SuggestLimits, grain_v: f64) -> [f64; 2] {
    let above = (robots / 2) as f64;
    let slack_v = free_slack_v(robots, limits).max(0.0);
    let room_v = limits.margin_v * (3.0 + 2.0 * above) + slack_v * (2.0 + 2.0 * above);
    let flex_v = rounded_v(limits.max_v - room_v, grain_v);
    [rounded_v(flex_v - limits.swing_v, GRAINS_V[4]), flex_v]
}

/// A chain through a grid: from row to row one of the voltages takes a step.
fn rows(robots: usize, limits: SuggestLimits, drive_v: [f64; 2], grain_v: f64) -> Vec<RelayRow> {
    let [relax_v, flex_v] = drive_v;
    let (above, _) = split(robots, limits, drive_v);
    let steps = robots.saturating_sub(1);
    let [below_v, above_v] = rooms_v(limits, drive_v);
    let stride_v = |room_v: f64, count: usize| 2.0 * (limits.margin_v + step_slack_v(room_v, count, limits).max(0.0));
    let (snap_down_v, release_v) = (stride_v(above_v, above), stride_v(below_v, steps - above));
    let (lowest_v, highest_v) = (flex_v + 2.0 * limits.margin_v, relax_v - 2.0 * limits.margin_v);
    let row = |at: usize| {
        let taken = (at * above).div_ceil(steps.max(1));
        let left = steps - above - (at - taken);
        RelayRow {
            snap_down_v: rounded_v(lowest_v + taken as f64 * snap_down_v, grain_v),
            release_v: rounded_v(highest_v - left as f64 * release_v, grain_v),
        }
    };
    (0..robots).map(row).collect()
}

fn rounded_v(voltage_v: f64, grain_v: f64) -> f64 {
    let grains_per_v = (1.0 / grain_v).round();
    (voltage_v * grains_per_v).round() / grains_per_v
}

#[cfg(test)]
mod tests;
