//! Where the electrodes that are on carry a part.
//!
//! Input: the electrodes that are on in one step of the board, and where a part stands. Output: where it goes, and by which of
//! them; or that they carry it nowhere in particular. An electrode acts on a part if it lies less than two columns and less
//! than two rows from an electrode of the part.

use crate::device::electrode_array::{Cell, Electrodes};
use rustc_hash::FxHashSet;

/// The pairs that move a micropart, from its centre: the step that it takes and the two electrodes (Table 2 of the paper).
const PAIRS: [([i64; 2], [[i64; 2]; 2]); 4] = [
    ([1, 0], [[2, -1], [2, 1]]),
    ([-1, 0], [[-2, -1], [-2, 1]]),
    ([0, -1], [[-1, -2], [1, -2]]),
    ([0, 1], [[-1, 2], [1, 2]]),
];

/// What the electrodes do to one part in one step of the board.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Pull {
    pub from: Cell,
    pub to: Cell,
    /// The electrodes that do it; none for a part that rests by itself.
    pub by: Vec<Cell>,
}

impl Pull {
    fn new(from: Cell, to: Cell, by: &[Cell]) -> Option<Pull> {
        Some(Pull { from, to, by: by.to_vec() })
    }

    /// Whether the part changes its cell.
    pub fn moves(&self) -> bool {
        self.from != self.to
    }
}

/// The farthest column or row, from the centre of a part, of an electrode that acts on it. The squares about the electrodes
/// of a part leave no gap, so all electrodes up to there do.
pub(super) fn range(electrodes: Electrodes) -> i64 {
    let farthest = electrodes.offsets().iter().flatten().map(|offset| offset.abs()).max();
    farthest.unwrap_or(0) + 1
}

/// The electrodes that are on and act on a part at a place, by column, then row.
pub(super) fn acting(on: &FxHashSet<Cell>, electrodes: Electrodes, at: Cell) -> Vec<Cell> {
    let range = range(electrodes);
    let around = (-range..=range).flat_map(|column| (-range..=range).map(move |row| [column, row]));
    around.filter_map(|offset| shifted(at, offset)).filter(|cell| on.contains(cell)).collect()
}

/// The cell so many columns and rows on, if the numbers allow it.
fn shifted(cell: Cell, [columns, rows]: [i64; 2]) -> Option<Cell> {
    let on = |at: u32, by: i64| u32::try_from(i64::from(at) + by).ok();
    Some(Cell::new(on(cell.column, columns)?, on(cell.row, rows)?))
}

/// Where a part goes; `None` if it is pulled to no neighbour, or apart.
pub(super) fn explained(on: &FxHashSet<Cell>, electrodes: Electrodes, at: Cell) -> Option<Pull> {
    let acting = acting(on, electrodes, at);
    match electrodes {
        Electrodes::Single => droplet(at, &acting),
        Electrodes::Quad => micropart(at, &acting),
    }
}

fn micropart(at: Cell, acting: &[Cell]) -> Option<Pull> {
    if acting.is_empty() {
        return Pull::new(at, at, &[]);
    }
    let is_pair = |pair: &[[i64; 2]; 2]| {
        acting.len() == pair.len()
            && pair.iter().all(|offset| shifted(at, *offset).is_some_and(|e| acting.contains(&e)))
    };
    let (step, _) = PAIRS.iter().find(|(_, pair)| is_pair(pair))?;
    Pull::new(at, shifted(at, *step)?, acting)
}

fn droplet(at: Cell, acting: &[Cell]) -> Option<Pull> {
    match acting {
        [] => Pull::new(at, at, &[]),
        [one] if at.steps_to(*one) <= 1 => Pull::new(at, *one, acting),
        _ => None,
    }
}

/// Where a droplet goes that merges with another at a goal. Once there it stays. Before that the electrode of the goal is not
/// held against it, since it is the other one's; where no other electrode acts on it, it goes to the goal if it can.
pub(super) fn merging(on: &FxHashSet<Cell>, at: Cell, goal: Cell) -> Option<Pull> {
    let acting = acting(on, Electrodes::Single, at);
    let called = acting.contains(&goal);
    if at == goal {
        let own: &[Cell] = if called { &[goal] } else { &[] };
        return Pull::new(at, at, own);
    }
    let others: Vec<Cell> = acting.into_iter().filter(|cell| *cell != goal).collect();
    if others.is_empty() && called && at.steps_to(goal) == 1 {
        return Pull::new(at, goal, &[goal]);
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
            let board: FxHashSet<Cell> =
                (1..=20).flat_map(|column| (1..=20).map(move |row| Cell::new(column, row))).collect();
            let near = |electrode: &Cell| {
                let own = electrodes.offsets().iter().filter_map(|offset| shifted(Cell::new(10, 10), *offset));
                own.min_by_key(|own| own.apart(*electrode)).is_some_and(|own| own.apart(*electrode) < 2)
            };
            let found = acting(&board, electrodes, Cell::new(10, 10));
            assert_eq!(found.iter().copied().collect::<FxHashSet<_>>(), board.iter().copied().filter(near).collect());
            assert_eq!(found.len(), count);
        }
    }

    #[test]
    fn no_electrode_is_looked_for_off_the_numbers() {
        let on = FxHashSet::from_iter([Cell::new(0, 0), Cell::new(u32::MAX, u32::MAX)]);
        assert_eq!(acting(&on, Electrodes::Quad, Cell::new(1, 1)), [Cell::new(0, 0)]);
        assert_eq!(acting(&on, Electrodes::Quad, Cell::new(u32::MAX, u32::MAX)).len(), 1);
    }
}
