//! Plain method: breadth-first search, by the crate `pathfinding`, over the known states of the arms, with every
//! level that has an effect of its own.

use pathfinding::prelude::bfs_reach;
use std::hash::{Hash, Hasher};
use tweeze::check::microrobots::relays::{RelayRow, Source};

/// The arms whose state is known, and the number of levels that set them.
#[derive(Debug, Clone, Copy)]
struct Known {
    down: u128,
    up: u128,
    levels: usize,
}

impl PartialEq for Known {
    fn eq(&self, other: &Self) -> bool {
        (self.down, self.up) == (other.down, other.up)
    }
}

impl Eq for Known {}

impl Hash for Known {
    fn hash<H: Hasher>(&self, state: &mut H) {
        (self.down, self.up).hash(state);
    }
}

/// Effect of a level on the arms: those that certainly go down or up, and those that may.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Effect {
    down: u128,
    up: u128,
    maybe_down: u128,
    maybe_up: u128,
}

impl Effect {
    fn of(level_v: f64, table: &[RelayRow], margin_v: f64) -> Self {
        let bits = |is_set: &dyn Fn(&RelayRow) -> bool| {
            table.iter().enumerate().filter(|(_, row)| is_set(row)).fold(0, |bits, (at, _)| bits | 1 << at)
        };
        Effect {
            down: bits(&|row| level_v >= row.snap_down_v + margin_v),
            up: bits(&|row| level_v <= row.release_v - margin_v),
            maybe_down: bits(&|row| level_v > row.snap_down_v - margin_v),
            maybe_up: bits(&|row| level_v < row.release_v + margin_v),
        }
    }

    fn on(&self, known: &Known) -> Known {
        Known {
            down: (known.down & !self.maybe_up) | self.down,
            up: (known.up & !self.maybe_down) | self.up,
            levels: known.levels + 1,
        }
    }
}

/// Each pattern that can be set, as bits by row, with its number of levels; and the number of nodes that the search
/// visits.
pub fn patterns(table: &[RelayRow], source: Source) -> (Vec<(u128, usize)>, usize) {
    let margin_v = source.margin_v;
    let breaks = table.iter().flat_map(|row| [row.snap_down_v, row.release_v]);
    let mut breaks_v: Vec<f64> =
        breaks.flat_map(|it| [it - margin_v, it + margin_v]).chain([0.0, source.max_v]).collect();
    breaks_v.sort_by(f64::total_cmp);
    let middles_v: Vec<f64> = breaks_v.windows(2).map(|pair| (pair[0] + pair[1]) / 2.0).collect();
    let levels_v = breaks_v.into_iter().chain(middles_v).filter(|level_v| (0.0..=source.max_v).contains(level_v));
    let mut effects: Vec<Effect> = levels_v.map(|level_v| Effect::of(level_v, table, margin_v)).collect();
    effects.sort_unstable();
    effects.dedup();
    let all = (1_u128 << table.len()) - 1;
    let nothing = Known { down: 0, up: 0, levels: 0 };
    let mut nodes = 0;
    let mut found: Vec<(u128, usize)> = Vec::new();
    for known in bfs_reach(nothing, |known| effects.iter().map(|effect| effect.on(known)).collect::<Vec<_>>()) {
        nodes += 1;
        if known.down | known.up == all {
            found.push((known.down, known.levels));
        }
    }
    found.sort_unstable();
    (found, nodes)
}
