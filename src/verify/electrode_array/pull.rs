//! Motion of a part by the electrodes that are on.
//!
//! Input: the electrodes that are on in one beat, and the cell of a part. Output: where it goes and which electrodes
//! carry it there, or `None` if they carry it to no definite cell. An electrode acts on a part if it is less than two
//! columns and less than two rows from an electrode of the part.

use crate::device::electrode_array::{ElectrodeCell, Electrodes, Hold};
use rustc_hash::FxHashSet;

/// The electrode pairs that move a micropart: its step, and the offsets of the two electrodes from its centre (Table 2
/// of the paper).
const PAIRS: [([i64; 2], [[i64; 2]; 2]); 4] = [
    ([1, 0], [[2, -1], [2, 1]]),
    ([-1, 0], [[-2, -1], [-2, 1]]),
    ([0, -1], [[-1, -2], [1, -2]]),
    ([0, 1], [[-1, 2], [1, 2]]),
];

/// Motion of one part in one beat, with the electrodes that cause it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PartPull {
    pub from: ElectrodeCell,
    pub to: ElectrodeCell,
    /// The electrodes that cause it; empty for a part that rests without voltage.
    pub by: Vec<ElectrodeCell>,
}

impl PartPull {
    fn new(from: ElectrodeCell, to: ElectrodeCell, by: &[ElectrodeCell]) -> Option<PartPull> {
        Some(PartPull { from, to, by: by.to_vec() })
    }

    /// Whether the part changes its cell.
    pub fn moves(&self) -> bool {
        self.from != self.to
    }
}

/// Greatest column or row offset, from the centre of a part, of an electrode that acts on it. The squares of reach
/// around the electrodes of a part leave no gap, so all electrodes within this range act.
pub(super) fn range(electrodes: Electrodes) -> i64 {
    let farthest = electrodes.offsets().iter().flatten().map(|offset| offset.abs()).max();
    farthest.unwrap_or(0) + 1
}

/// The electrodes that are on and act on a part at a cell, by column, then row.
pub(super) fn acting(on: &FxHashSet<ElectrodeCell>, electrodes: Electrodes, at: ElectrodeCell) -> Vec<ElectrodeCell> {
    let range = range(electrodes);
    let around = (-range..=range).flat_map(|column| (-range..=range).map(move |row| [column, row]));
    around.filter_map(|offset| shifted(at, offset)).filter(|cell| on.contains(cell)).collect()
}

/// The cell shifted by some columns and rows; `None` on overflow.
fn shifted(cell: ElectrodeCell, [columns, rows]: [i64; 2]) -> Option<ElectrodeCell> {
    let on = |at: u32, by: i64| u32::try_from(i64::from(at) + by).ok();
    Some(ElectrodeCell::new(on(cell.column, columns)?, on(cell.row, rows)?))
}

/// Motion of a part; `None` if it is pulled to no neighbour, or in several directions.
pub(super) fn pull_of(on: &FxHashSet<ElectrodeCell>, electrodes: Electrodes, at: ElectrodeCell) -> Option<PartPull> {
    let acting = acting(on, electrodes, at);
    match electrodes {
        Electrodes::Single => droplet(at, &acting),
        Electrodes::Quad => micropart(at, &acting),
    }
}

fn micropart(at: ElectrodeCell, acting: &[ElectrodeCell]) -> Option<PartPull> {
    if acting.is_empty() {
        return PartPull::new(at, at, &[]);
    }
    let is_pair = |pair: &[[i64; 2]; 2]| {
        acting.len() == pair.len()
            && pair.iter().all(|offset| shifted(at, *offset).is_some_and(|e| acting.contains(&e)))
    };
    let (step, _) = PAIRS.iter().find(|(_, pair)| is_pair(pair))?;
    PartPull::new(at, shifted(at, *step)?, acting)
}

fn droplet(at: ElectrodeCell, acting: &[ElectrodeCell]) -> Option<PartPull> {
    match acting {
        [] => PartPull::new(at, at, &[]),
        [one] if at.steps_to(*one) <= 1 => PartPull::new(at, *one, acting),
        _ => None,
    }
}

/// Motion of a droplet that merges with another at a goal. At the goal it stays as long as that electrode is on, or if
/// it needs none to rest, whatever pulls the other droplet beside it. Elsewhere the electrode of the goal is ignored,
/// since it belongs to the other droplet; if no other electrode acts on this droplet, it goes to the goal if that is
/// adjacent.
pub(super) fn merging(
    on: &FxHashSet<ElectrodeCell>,
    hold: Hold,
    at: ElectrodeCell,
    goal: ElectrodeCell,
) -> Option<PartPull> {
    let acting = acting(on, Electrodes::Single, at);
    let called = acting.contains(&goal);
    if at == goal {
        return match (called, hold) {
            (true, _) => PartPull::new(at, at, &[goal]),
            (false, Hold::Off) => PartPull::new(at, at, &[]),
            (false, Hold::On) => droplet(at, &acting),
        };
    }
    let others: Vec<ElectrodeCell> = acting.into_iter().filter(|cell| *cell != goal).collect();
    if others.is_empty() && called && at.steps_to(goal) == 1 {
        return PartPull::new(at, goal, &[goal]);
    }
    droplet(at, &others)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By the definition: nearer than two columns and rows to one of the part's own electrodes.
    #[test]
    fn what_acts_on_a_part_is_near_one_of_its_electrodes() {
        for (electrodes, count) in [(Electrodes::Single, 9), (Electrodes::Quad, 25)] {
            let board: FxHashSet<ElectrodeCell> =
                (1..=20).flat_map(|column| (1..=20).map(move |row| ElectrodeCell::new(column, row))).collect();
            let near = |electrode: &ElectrodeCell| {
                let own = electrodes.offsets().iter().filter_map(|offset| shifted(ElectrodeCell::new(10, 10), *offset));
                own.min_by_key(|own| own.apart(*electrode)).is_some_and(|own| own.apart(*electrode) < 2)
            };
            let found = acting(&board, electrodes, ElectrodeCell::new(10, 10));
            assert_eq!(found.iter().copied().collect::<FxHashSet<_>>(), board.iter().copied().filter(near).collect());
            assert_eq!(found.len(), count);
        }
    }

    /// One electrode pulls a droplet to the four cells beside it, and to none across a corner.
    #[test]
    fn a_droplet_goes_to_a_cell_beside_it_and_no_farther() {
        let at = ElectrodeCell::new(10, 10);
        let goes_to = |column: u32, row: u32| {
            let on = FxHashSet::from_iter([ElectrodeCell::new(column, row)]);
            pull_of(&on, Electrodes::Single, at).map(|pull| (pull.to.column, pull.to.row))
        };
        assert_eq!([goes_to(11, 10), goes_to(10, 9), goes_to(10, 10)], [Some((11, 10)), Some((10, 9)), Some((10, 10))]);
        assert_eq!([goes_to(11, 11), goes_to(9, 11), goes_to(9, 9)], [None; 3]);
        assert_eq!(goes_to(12, 10), Some((10, 10)), "what is two cells off does not act on it");
    }

    #[test]
    fn no_electrode_is_looked_for_off_the_numbers() {
        let on = FxHashSet::from_iter([ElectrodeCell::new(0, 0), ElectrodeCell::new(u32::MAX, u32::MAX)]);
        assert_eq!(acting(&on, Electrodes::Quad, ElectrodeCell::new(1, 1)), [ElectrodeCell::new(0, 0)]);
        assert_eq!(acting(&on, Electrodes::Quad, ElectrodeCell::new(u32::MAX, u32::MAX)).len(), 1);
    }
}
