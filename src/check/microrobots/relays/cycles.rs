//! Shortest control cycle that sets an arm pattern, from any previous positions and with every transition voltage off
//! by less than the margin; of the shortest cycles, one with the greatest tolerance of its levels.
//!
//! Method. The cycle is built backwards from its last level. Let D be the set of arms that must end down, U the set of
//! those that must end up. Of the levels from the last back to any other, only the highest `b` and the lowest `a`
//! matter. An arm of D is *settled* by them if its snap-down voltage + margin is at most `b`; then no earlier level
//! matters to it. Until it is settled, no level may release it: levels are at least L(b), the highest release voltage +
//! margin of the unsettled arms of D. Likewise an arm of U is settled if its release voltage - margin is at least `a`,
//! and levels are at most H(a), the lowest snap-down voltage - margin of the unsettled arms of U. A cycle is correct if
//! and only if all its levels keep to L and H, and all arms are settled in the end.
//!
//! Shortest. A level between `a` and `b` settles nothing and can be left out. Of two neighbours that both raise `b`,
//! the later in time can be left out, as H(a) does not change between them. So, read backwards, a shortest cycle
//! alternates between levels that lower `a` and levels that raise `b`. L falls (weakly) as `b` rises, and H rises as
//! `a` falls. By induction, the cycle that always takes L(b) where it lowers and H(a) where it raises has, level for
//! level, an `a` as low and a `b` as high as any other. The last level both lowers and raises; if the one before it is
//! higher, only how low it is matters, and it is L of all of D; otherwise it is H of all of U. Both beginnings are
//! followed, and the shorter chain is a shortest cycle. With n arms a level costs O(log n), and there are at most n + 1
//! levels, as each but the last settles an arm.
//!
//! Existence. If each arm of D is separated from each of U
//! ([`VoltageTable::separates`](super::table::VoltageTable::separates)), a chain never gets stuck: among the unsettled
//! arms let u be that of U with the lowest snap-down voltage and d that of D with the highest release voltage. If they
//! are separated by snap-down, raising to H settles d; if by release, lowering to L settles u. If some d is not
//! separated from some u, no cycle sets the pattern, because a level that settles the one would disturb the other. So
//! pairs of rows decide which patterns can be set.
//!
//! Slack. A cycle whose levels may each be off by s is one that is correct with the margin greater by s and the ends of
//! the source's range moved inwards by s. So the greatest slack is the greatest s for which a chain of the least length
//! is still found. The chain for some s yields intervals for its levels; half of their least width is at least s, and
//! is the answer if no chain is found for a greater s.

use super::arms;
use super::table::{Ranked, VoltageTable, middle_v, volts_v};
use crate::device::microrobots::ControlState;

/// Side of the level before the last one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum LevelSide {
    Above,
    Below,
}

impl LevelSide {
    fn other(self) -> LevelSide {
        match self {
            LevelSide::Above => LevelSide::Below,
            LevelSide::Below => LevelSide::Above,
        }
    }
}

/// The levels that are allowed at one place of a cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Interval {
    low: i64,
    high: i64,
}

/// Unsettled arms of one set, sorted by the voltage that settles them, with their bounds on levels.
struct UnsettledArms {
    /// Settling voltages, the hardest first.
    settling: Vec<i64>,
    /// For each prefix of the arms, their hardest demand on levels.
    demands: Vec<i64>,
}

/// A pattern to be set.
pub struct PatternTarget<'a> {
    table: &'a VoltageTable,
    /// Arms that must be down: settled by snap-down voltages, they bound levels by release voltages.
    downs: UnsettledArms,
    /// Arms that must be up: settled by release voltages, they bound levels by snap-down voltages.
    ups: UnsettledArms,
}

/// A cycle in reverse order.
struct ReversedCycle {
    /// The last level in time first.
    intervals: Vec<Interval>,
    /// Half of the least width of the intervals.
    slack: i64,
    /// The end of the range towards which the first level in time lies.
    first: LevelSide,
}

impl<'a> PatternTarget<'a> {
    pub fn new(table: &'a VoltageTable, ranked: &Ranked, is_down: &[bool]) -> Self {
        let downs = ranked.snap_downs.iter().filter(|row| is_down[**row]);
        let ups = ranked.releases.iter().filter(|row| !is_down[**row]);
        PatternTarget {
            table,
            downs: UnsettledArms::new(downs.map(|row| (table.snap_downs[*row], table.releases[*row])), i64::max),
            ups: UnsettledArms::new(ups.map(|row| (table.releases[*row], table.snap_downs[*row])), i64::min),
        }
    }

    /// The pattern with its best cycle, or its number of levels if these are too many.
    pub fn state(&self, is_down: &[bool]) -> Result<ControlState, usize> {
        let length = self.length();
        if length > self.table.most_levels {
            return Err(length);
        }
        let above = self.best(LevelSide::Above, length);
        let below = self.best(LevelSide::Below, length);
        let best = match (above, below) {
            (Some(above), Some(below)) if below.slack > above.slack => below,
            (Some(above), _) => above,
            (None, Some(below)) => below,
            (None, None) => return Err(usize::MAX),
        };
        Ok(ControlState { arms: arms(is_down), levels_v: self.levels_v(&best), slack_v: volts_v(best.slack) })
    }

    /// Number of levels; `usize::MAX` if the pattern cannot be set.
    pub fn length(&self) -> usize {
        let length = |side| self.chain(side, 0, usize::MAX).map_or(usize::MAX, |chain| chain.intervals.len());
        length(LevelSide::Above).min(length(LevelSide::Below))
    }

    /// The chain of a length and a side with the greatest slack.
    fn best(&self, side: LevelSide, length: usize) -> Option<ReversedCycle> {
        let mut best = self.chain(side, 0, length)?;
        while let Some(better) = self.chain(side, best.slack + 1, length) {
            best = better;
        }
        Some(best)
    }

    /// The chain whose levels may all be off by `slack`, if it has at most `most` levels; `side` is where the level
    /// before the last one lies.
    fn chain(&self, side: LevelSide, slack: i64, most: usize) -> Option<ReversedCycle> {
        let (least, highest) = (slack, self.table.max - slack);
        let reach = self.table.margin + slack;
        let (mut downs, mut ups) = (self.downs.all(), self.ups.all());
        let mut intervals = Vec::new();
        let mut next = side.other();
        while intervals.len() < most {
            let low = self.downs.demand(downs).map_or(least, |demand| demand + reach).max(least);
            let high = self.ups.demand(ups).map_or(highest, |demand| demand - reach).min(highest);
            if low > high {
                return None;
            }
            let level = if next == LevelSide::Above { high } else { low };
            let downs_left = self.downs.left(downs, |voltage| voltage + reach > level);
            let ups_left = self.ups.left(ups, |voltage| voltage - reach < level);
            if !intervals.is_empty() && (downs_left, ups_left) == (downs, ups) {
                return None;
            }
            intervals.push(self.interval([downs, downs_left], [ups, ups_left]));
            (downs, ups) = (downs_left, ups_left);
            if downs == 0 && ups == 0 {
                let half = |interval: &Interval| (interval.high - interval.low) / 2;
                let slack = intervals.iter().map(half).min().unwrap_or_default();
                return Some(ReversedCycle { intervals, slack, first: next });
            }
            next = next.other();
        }
        None
    }

    /// The levels that keep to the bounds of the unsettled arms and settle those that are not left.
    fn interval(&self, [downs, downs_left]: [usize; 2], [ups, ups_left]: [usize; 2]) -> Interval {
        let margin = self.table.margin;
        let kept = self.downs.demand(downs).map_or(0, |voltage| voltage + margin);
        let snapped = (downs_left < downs).then(|| self.downs.settling[downs_left] + margin);
        let released = (ups_left < ups).then(|| self.ups.settling[ups_left] - margin);
        let unsnapped = self.ups.demand(ups).map_or(self.table.max, |voltage| voltage - margin);
        Interval {
            low: kept.max(snapped.unwrap_or(0)).max(0),
            high: unsnapped.min(released.unwrap_or(self.table.max)).min(self.table.max),
        }
    }

    /// The middles of the intervals in order of time.
    ///
    /// The first level only needs to be far enough out. If that costs no slack, it is the one that moves all arms of
    /// the table, so that the cycles of a table have few different levels in all.
    fn levels_v(&self, chain: &ReversedCycle) -> Vec<f64> {
        let mut intervals = chain.intervals.clone();
        intervals.reverse();
        if let Some(first) = intervals.first_mut() {
            let table = self.table;
            let all = match chain.first {
                LevelSide::Above => Interval {
                    low: table.snap_downs.iter().max().map_or(0, |voltage| voltage + table.margin),
                    high: table.max,
                },
                LevelSide::Below => Interval {
                    low: 0,
                    high: table.releases.iter().min().map_or(table.max, |voltage| voltage - table.margin),
                },
            };
            let is_inside = first.low <= all.low && all.high <= first.high;
            if is_inside && all.high - all.low >= 2 * chain.slack {
                *first = all;
            }
        }
        intervals.iter().map(|interval| middle_v(interval.low, interval.high)).collect()
    }
}

impl UnsettledArms {
    /// From pairs of the voltage that settles an arm, hardest first, and the one by which it bounds levels.
    fn new(arms: impl Iterator<Item = (i64, i64)>, harder: fn(i64, i64) -> i64) -> Self {
        let (settling, mut demands): (Vec<i64>, Vec<i64>) = arms.unzip();
        for at in 1..demands.len() {
            demands[at] = harder(demands[at - 1], demands[at]);
        }
        UnsettledArms { settling, demands }
    }

    fn all(&self) -> usize {
        self.settling.len()
    }

    /// Common bound of the first `count` arms.
    fn demand(&self, count: usize) -> Option<i64> {
        count.checked_sub(1).map(|last| self.demands[last])
    }

    /// Number of the first `count` arms that a level leaves unsettled.
    fn left(&self, count: usize, is_left: impl Fn(i64) -> bool) -> usize {
        self.settling[..count].partition_point(|voltage| is_left(*voltage))
    }
}
