//! Simulation of relays: every arm from both states and with its voltages at every corner of the margin, one bit for
//! each combination.

use super::{AllowedGaps, PatternTarget, RelayRow, Source, VoltageTable, faults};
use rustc_hash::FxHashMap;
use std::collections::{BTreeMap, VecDeque};

/// Corners lie this much inside the margin, which is itself excluded.
const INSIDE_V: f64 = 1e-4;

/// Simulated arms of a row: two first states, three corners for each of its voltages.
const COPIES: usize = 18;

/// Arms that are down, [`COPIES`] bits for each row.
type Arms = u128;

/// A bed of relays.
pub struct Bed {
    rows: Vec<RelayRow>,
    corner_v: f64,
    /// Levels with distinct effects, as the arms that each lowers and raises.
    levels: Vec<(Arms, Arms)>,
}

impl Bed {
    /// Relays whose margin is greater by `slack_v`, and whose source's range is smaller by it at both ends.
    pub fn new(rows: &[RelayRow], source: Source, slack_v: f64) -> Self {
        let reach_v = source.margin_v + slack_v;
        let mut bed = Bed { rows: rows.to_vec(), corner_v: reach_v - INSIDE_V, levels: Vec::new() };
        let of_row = |row: &RelayRow| [row.snap_down_v, row.release_v].map(|it| [it - reach_v, it + reach_v]).concat();
        let mut breaks_v: Vec<f64> = rows.iter().flat_map(of_row).chain([slack_v, source.max_v - slack_v]).collect();
        breaks_v.sort_by(f64::total_cmp);
        let middles_v: Vec<f64> = breaks_v.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0).collect();
        let is_possible = |level_v: &f64| (slack_v..=source.max_v - slack_v).contains(level_v);
        bed.levels = breaks_v.into_iter().chain(middles_v).filter(is_possible).map(|it| bed.effect(it)).collect();
        bed.levels.sort_unstable();
        bed.levels.dedup();
        bed
    }

    /// The arms that a level lowers and raises.
    fn effect(&self, level_v: f64) -> (Arms, Arms) {
        let (mut down, mut up) = (0, 0);
        for (at, row) in self.rows.iter().enumerate() {
            for copy in 0..COPIES {
                let corner_v = |digit: usize| (digit as f64 - 1.0) * self.corner_v;
                let bit = 1 << (at * COPIES + copy);
                if level_v >= row.snap_down_v + corner_v(copy % 3) {
                    down |= bit;
                } else if level_v <= row.release_v + corner_v(copy / 3 % 3) {
                    up |= bit;
                }
            }
        }
        (down, up)
    }

    /// Half of the arms of every row are down.
    fn first(&self) -> Arms {
        let half = (1 << (COPIES / 2)) - 1;
        (0..self.rows.len()).fold(0, |arms, row| arms | half << (row * COPIES))
    }

    /// The pattern of arms, if all copies of each row agree.
    fn pattern(&self, arms: Arms) -> Option<String> {
        let all = (1 << COPIES) - 1;
        let digit = |row: usize| match arms >> (row * COPIES) & all {
            0 => Some('0'),
            agreed if agreed == all => Some('1'),
            _ => None,
        };
        (0..self.rows.len()).map(digit).collect()
    }

    /// The result of levels from every arm state at every corner, if it is always the same.
    pub fn after(&self, levels_v: &[f64]) -> Option<String> {
        let step = |arms: Arms, level_v: &f64| {
            let (down, up) = self.effect(*level_v);
            (arms | down) & !up
        };
        self.pattern(levels_v.iter().fold(self.first(), step))
    }

    /// Every pattern that some levels set from every arm state at every corner, and the least number of levels that do.
    pub fn accessible(&self) -> BTreeMap<String, usize> {
        let mut lengths: FxHashMap<Arms, usize> = FxHashMap::from_iter([(self.first(), 0)]);
        let mut open = VecDeque::from([self.first()]);
        let mut found = BTreeMap::new();
        while let Some(arms) = open.pop_front() {
            let length = lengths[&arms];
            if let Some(pattern) = self.pattern(arms) {
                found.entry(pattern).or_insert(length);
            }
            for (down, up) in &self.levels {
                let next = (arms | down) & !up;
                lengths.entry(next).or_insert_with(|| {
                    open.push_back(next);
                    length + 1
                });
            }
        }
        found
    }
}

/// Whether the relays of each pair of rows alone have three patterns, one after the other.
pub fn are_pairs_chains(rows: &[RelayRow], source: Source) -> bool {
    let is_chain_of = |pair: [RelayRow; 2]| {
        let accessible = Bed::new(&pair, source, 0.0).accessible();
        is_chain(&accessible.into_keys().collect::<Vec<_>>(), 2)
    };
    (0..rows.len()).all(|one| (0..one).all(|other| is_chain_of([rows[one], rows[other]])))
}

/// Whether patterns lower one arm after the other, up to all.
pub fn is_chain(patterns: &[String], robots: usize) -> bool {
    let count = |pattern: &String| pattern.matches('1').count();
    let mut sorted = patterns.to_vec();
    sorted.sort_by_key(count);
    let contains = |pair: &[String]| pair[0].bytes().zip(pair[1].bytes()).all(|(less, more)| less <= more);
    sorted.iter().map(count).eq(0..=robots) && sorted.windows(2).all(contains)
}

/// Step 0 of the validity algorithm in section 1.5 of the design's models, taken literally.
pub fn breaks_limits(row: RelayRow, source: Source) -> bool {
    let gap_v = 2.0 * source.margin_v;
    row.snap_down_v - row.release_v < gap_v
        || row.release_v > source.relax_v - gap_v
        || row.snap_down_v < source.flex_v + gap_v
        || row.snap_down_v + source.margin_v > source.max_v
        || row.release_v - source.margin_v < 0.0
}

/// The smallest change of one voltage by sixteenths of the margin after which a table has no fault.
pub fn least_mend_v(table: &[RelayRow], source: Source) -> Option<f64> {
    let is_sound = |row: usize, snap_down_v: f64, release_v: f64| {
        let mut changed = table.to_vec();
        changed[row] = RelayRow {
            snap_down_v: changed[row].snap_down_v + snap_down_v,
            release_v: changed[row].release_v + release_v,
        };
        let changed = VoltageTable::new(&changed, source);
        faults::problems(&changed, AllowedGaps::String, 1).is_empty() && has_short_cycles(&changed)
    };
    let mut sizes_v = (1..200).map(|step| f64::from(step) * source.margin_v / 16.0);
    sizes_v.find(|size_v| {
        (0..table.len()).any(|row| {
            [*size_v, -size_v].iter().any(|change_v| is_sound(row, *change_v, 0.0) || is_sound(row, 0.0, *change_v))
        })
    })
}

fn has_short_cycles(table: &VoltageTable) -> bool {
    let order = table.order().expect("a table without faults of rows and pairs has an order");
    (0..=order.len()).all(|state| {
        let is_down: Vec<bool> = (0..order.len()).map(|row| order[..state].contains(&row)).collect();
        PatternTarget::new(table, &table.ranked(), &is_down).length() <= table.most_levels
    })
}

/// Xorshift random numbers from a seed.
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, end: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % end
    }

    /// A whole number between the two, both included.
    fn between(&mut self, least: i64, most: i64) -> f64 {
        (least + self.below((most - least + 1) as u64) as i64) as f64
    }

    /// A table of at most `most` robots whose neighbours are about two margins apart, and a source with nearly tight
    /// limits.
    pub fn table(&mut self, most: u64) -> (Vec<RelayRow>, Source) {
        let margin_v = [0.5, 1.0, 2.0, 4.0][self.below(4) as usize];
        let grain_v = margin_v / [1.0, 2.0, 4.0][self.below(3) as usize];
        let steps = (margin_v / grain_v) as i64;
        let back = [4 * steps, steps, steps / 2, steps / 3][self.below(4) as usize];
        let most = if back == 4 * steps { 4 } else { most };
        let mut row = RelayRow { snap_down_v: 150.0, release_v: 60.0 };
        let mut table = vec![row];
        for _ in 0..self.below(most) {
            row.snap_down_v += self.between(-back, 4 * steps) * grain_v;
            row.release_v += self.between(-back, 4 * steps) * grain_v;
            table.push(row);
        }
        for last in (1..table.len()).rev() {
            table.swap(last, self.below(last as u64 + 1) as usize);
        }
        let extreme =
            |of: fn(&RelayRow) -> f64, pick: fn(f64, f64) -> f64| table.iter().map(of).reduce(pick).unwrap_or(0.0);
        let is_tight = self.below(4) == 0;
        let mut room_v = |usual: i64| self.between(if is_tight { -2 } else { 0 }, usual) * grain_v;
        let source = Source {
            margin_v,
            relax_v: extreme(|row| row.release_v, f64::max) + 2.0 * margin_v + room_v(8),
            flex_v: extreme(|row| row.snap_down_v, f64::min) - 2.0 * margin_v - room_v(8),
            max_v: extreme(|row| row.snap_down_v, f64::max) + margin_v + room_v(20),
            most_levels: 64,
        };
        let down_v = extreme(|row| row.release_v, f64::min) - margin_v - room_v(20);
        let most_levels = [1, 2, 2, 3, 64, 64, 64, 64][self.below(8) as usize];
        (lowered(&table, down_v), Source { most_levels, relax_v: source.relax_v - down_v, ..source })
    }
}

/// A table whose release voltages are lower by `by_v`.
fn lowered(table: &[RelayRow], by_v: f64) -> Vec<RelayRow> {
    table.iter().map(|row| RelayRow { release_v: row.release_v - by_v, ..*row }).collect()
}
