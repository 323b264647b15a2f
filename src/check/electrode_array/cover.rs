//! Obstacles that keep centres from cells, and places that lie too near to each other.
//!
//! Obstacles are painted onto the board once, each grown by the distance that centres keep. Painted cells are skipped
//! from then on, so many large obstacles cost no more than the board and their rows. Places are hashed into squares as
//! wide as the distance that they keep, so a query examines nine squares.

use crate::claims::electrode_array::{ElectrodeArrayObstacle, ElectrodeArrayObstacleBody};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
use rustc_hash::FxHashMap;

/// Number of rings of cells around a place that are searched for a better one.
const MAX_RINGS: u32 = 64;

/// For each cell, the obstacle that keeps centres from it.
pub struct ObstacleCells {
    columns: u32,
    /// Index of the obstacle plus 1, row by row; 0 for a free cell.
    painted: Vec<u32>,
}

impl ObstacleCells {
    /// Paints the obstacles of a board; earlier ones take precedence.
    pub fn of(obstacles: &[ElectrodeArrayObstacle], facts: &ElectrodeArrayFacts) -> ObstacleCells {
        let cells = facts.columns as usize * facts.rows as usize;
        let mut cover = ObstacleCells { columns: facts.columns, painted: vec![0; cells] };
        let width = facts.columns as usize + 1;
        // Union-find links: the next possibly unpainted column of each row; the last entry of a row stands for none.
        let mut next: Vec<u32> = (0..facts.rows).flat_map(|_| 0..=facts.columns).collect();
        for (index, obstacle) in obstacles.iter().enumerate() {
            let [low, high] = grown(&obstacle.body, facts);
            for row in low.row..=high.row {
                let of_row = &mut next[(row as usize - 1) * width..][..width];
                let mut column = free_from(of_row, low.column - 1);
                while column < high.column {
                    cover.painted[row as usize * cover.columns as usize - cover.columns as usize + column as usize] =
                        index as u32 + 1;
                    of_row[column as usize] = column + 1;
                    column = free_from(of_row, column + 1);
                }
            }
        }
        cover
    }

    /// The first obstacle that keeps centres from a cell of the board.
    pub fn covering(&self, cell: ElectrodeCell) -> Option<usize> {
        let at = (cell.row as usize - 1) * self.columns as usize + cell.column as usize - 1;
        self.painted.get(at).and_then(|index| (*index as usize).checked_sub(1))
    }
}

/// The first unpainted column at or after a given one, counted from 0; links on the way are shortened.
fn free_from(next: &mut [u32], from: u32) -> u32 {
    let mut at = from;
    while next[at as usize] != at {
        let further = next[next[at as usize] as usize];
        next[at as usize] = further;
        at = further;
    }
    at
}

/// The lowest and the highest cell of the board that a body keeps centres from.
fn grown(body: &ElectrodeArrayObstacleBody, facts: &ElectrodeArrayFacts) -> [ElectrodeCell; 2] {
    let (from, to, apart) = match body {
        ElectrodeArrayObstacleBody::Electrodes { from, to } => (*from, *to, facts.clearance),
        ElectrodeArrayObstacleBody::Fixed(cell) => (*cell, *cell, facts.separation.apart()),
    };
    let reach = apart.saturating_sub(1);
    let low = ElectrodeCell::new(from.column.saturating_sub(reach).max(1), from.row.saturating_sub(reach).max(1));
    let high = ElectrodeCell::new((to.column + reach).min(facts.columns), (to.row + reach).min(facts.rows));
    [low, high]
}

/// Places that keep a distance from each other, each with a value.
pub struct SpacedPlaces<T> {
    apart: u32,
    squares: FxHashMap<(u32, u32), Vec<(ElectrodeCell, T)>>,
}

impl<T: Copy> SpacedPlaces<T> {
    /// An empty set; `apart` is the required Chebyshev distance, at least 1.
    pub fn new(apart: u32) -> SpacedPlaces<T> {
        SpacedPlaces { apart, squares: FxHashMap::default() }
    }

    fn square(&self, cell: ElectrodeCell) -> (u32, u32) {
        // Offset by one, so that each square has neighbours on all sides.
        (cell.column / self.apart + 1, cell.row / self.apart + 1)
    }

    /// Adds a value at a cell, without a check of the distance.
    pub fn put(&mut self, cell: ElectrodeCell, what: T) {
        self.squares.entry(self.square(cell)).or_default().push((cell, what));
    }

    /// Removes a value at a cell if `is_meant` accepts it.
    pub fn take(&mut self, cell: ElectrodeCell, is_meant: impl Fn(T) -> bool) {
        let square = self.square(cell);
        if let Some(there) = self.squares.get_mut(&square) {
            there.retain(|(at, what)| *at != cell || !is_meant(*what));
        }
    }

    /// The value too near to a cell: the nearest, and of equally near ones the one added first.
    pub fn near(&self, cell: ElectrodeCell) -> Option<(ElectrodeCell, T)> {
        let (column, row) = self.square(cell);
        let squares = (row - 1..=row + 1).flat_map(|row| (column - 1..=column + 1).map(move |column| (column, row)));
        let there = squares.filter_map(|square| self.squares.get(&square)).flatten();
        there.filter(|(at, _)| at.apart(cell) < self.apart).min_by_key(|(at, _)| at.apart(cell)).copied()
    }
}

/// The nearest cell that a centre can take and that passes a test; of equally near ones the first by row.
pub fn nearest_cell(
    cell: ElectrodeCell,
    facts: &ElectrodeArrayFacts,
    test: impl Fn(ElectrodeCell) -> bool,
) -> Option<ElectrodeCell> {
    let [first, last] = facts.reach()?;
    let near = ElectrodeCell::new(cell.column.clamp(first.column, last.column), cell.row.clamp(first.row, last.row));
    (0..=MAX_RINGS).find_map(|ring| {
        let cells = ring_of(near, ring).filter(|cell| facts.reaches(*cell) && test(*cell));
        cells.min_by_key(|found| (found.steps_to(near), found.row, found.column))
    })
}

/// The cells at a Chebyshev distance, without those below 1.
fn ring_of(cell: ElectrodeCell, ring: u32) -> impl Iterator<Item = ElectrodeCell> {
    let (column, row, ring) = (i64::from(cell.column), i64::from(cell.row), i64::from(ring));
    let cells = (-ring..=ring).flat_map(move |up| {
        let stride = if up.abs() == ring { 1 } else { 2 * ring };
        (-ring..=ring).step_by(stride as usize).map(move |right| (column + right, row + up))
    });
    cells
        .filter(|(column, row)| *column >= 1 && *row >= 1)
        .map(|(column, row)| ElectrodeCell::new(column as u32, row as u32))
}
