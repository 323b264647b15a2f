//! The lattice with its obstacles: free flips of a cell, and free rectangles of cells.

use super::journey::Workspace;
use super::lattice::{Flip, Lattice, LatticeCell, Side};
use super::lines::{BlockedLines, LineReader};
use super::obstacles::{FieldError, FieldObstacle, Obstacles};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A lattice with obstacles. Cheap to query and safe to share; searches of one field take turns, since they share its
/// caches.
pub struct LatticeField {
    obstacles: Obstacles,
    work: Mutex<Work>,
}

/// Caches that searches keep between queries.
pub(super) struct Work {
    lines: [BlockedLines; 2],
    search: Workspace,
}

impl LatticeField {
    /// Builds the index; lines are computed on demand.
    ///
    /// # Errors
    /// See [`FieldError`].
    pub fn new(lattice: Lattice, obstacles: &[FieldObstacle]) -> Result<Self, FieldError> {
        let obstacles = Obstacles::new(lattice, obstacles)?;
        let lines = Side::BOTH.map(|side| BlockedLines::new(lattice.modules[side.other().index()]));
        let work = Mutex::new(Work { lines, search: Workspace::default() });
        Ok(LatticeField { obstacles, work })
    }

    /// The lattice.
    pub const fn lattice(&self) -> &Lattice {
        &self.obstacles.lattice
    }

    /// Number of obstacles.
    pub const fn obstacles(&self) -> usize {
        self.obstacles.len()
    }

    /// Obstacles that cover the cell, ascending.
    pub fn covering(&self, cell: LatticeCell) -> Vec<usize> {
        self.touching([cell.x; 2], [cell.y; 2])
    }

    /// Obstacles that touch the segment swept by `flip` from `cell`, ascending. A flip is legal exactly if there are
    /// none.
    pub fn blocking(&self, cell: LatticeCell, flip: Flip) -> Vec<usize> {
        let after = cell.after(flip);
        self.touching([cell.x & after.x, cell.x | after.x], [cell.y & after.y, cell.y | after.y])
    }

    /// Obstacles that touch the closed rectangle between the cells `(x[0], y[0])` and `(x[1], y[1])`, ascending.
    pub fn touching(&self, x: [u32; 2], y: [u32; 2]) -> Vec<usize> {
        self.obstacles.touching(x, y)
    }

    /// Whether no obstacle touches the closed rectangle between the cells `(x[0], y[0])` and `(x[1], y[1])`.
    #[inline]
    pub fn rectangle_free(&self, x: [u32; 2], y: [u32; 2]) -> bool {
        self.obstacles.rectangle_free(x, y)
    }

    /// Precomputes what the first non-trivial search needs: the block abstraction and, for up to 13 modules a side, all
    /// lines.
    pub fn prepare(&self) {
        let mut work = self.work();
        let (mut reader, space) = work.open(self);
        space.prepare(&mut reader);
    }

    /// The modules of each side that may switch alone in `cell`, as bit masks; `None` if an obstacle covers it or it is not a cell
    /// of the lattice.
    pub fn legal(&self, cell: LatticeCell) -> Option<[u32; 2]> {
        if !self.lattice().contains(cell) {
            return None;
        }
        let mut work = self.work();
        work.open(self).0.legal(cell.pair())
    }

    pub(super) fn work(&self) -> MutexGuard<'_, Work> {
        // A panic elsewhere cannot leave the caches half-written in a way that changes answers: searches reset what they use.
        self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Work {
    pub(super) fn open<'a>(&'a mut self, field: &'a LatticeField) -> (LineReader<'a>, &'a mut Workspace) {
        (LineReader { obstacles: &field.obstacles, lines: &mut self.lines }, &mut self.search)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Pose, Shape};
    use crate::plan::dimibot::lattice::bits;

    #[test]
    fn cells_outside_the_lattice_are_answered() {
        let lattice = Lattice::new([3, 3], [1.0, 1.0]).unwrap();
        let obstacle = FieldObstacle::Cells { from: [0, 0], to: [u32::MAX, 7] };
        let field = LatticeField::new(lattice, &[obstacle]).unwrap();
        assert_eq!(field.legal(LatticeCell::new(8, 0)), None);
        assert_eq!(field.legal(LatticeCell::new(0, u32::MAX)), None);
        assert_eq!(field.covering(LatticeCell::new(7, 7)), [0]);
        assert_eq!(field.covering(LatticeCell::new(3, u32::MAX)), [0; 0]);
        assert_eq!(field.touching([9, 1], [7, 2]), [0; 0]);
    }

    #[test]
    fn a_flip_is_legal_exactly_when_nothing_blocks_it() {
        let lattice = Lattice::new([4, 3], [1.0, 2.0]).unwrap();
        let disc =
            FieldObstacle::Physical { shape: Shape::Disc { radius_um: 1.2 }, pose: Pose::at(5.5, 5.0), growth_um: 0.1 };
        let block = FieldObstacle::Cells { from: [12, 3], to: [10, 2] };
        let field = LatticeField::new(lattice, &[disc, block]).unwrap();
        for (x, y) in (0..16).flat_map(|x| (0..8).map(move |y| (x, y))) {
            let cell = LatticeCell::new(x, y);
            assert_eq!(field.legal(cell).is_none(), !field.covering(cell).is_empty());
            let Some(masks) = field.legal(cell) else {
                continue;
            };
            for side in Side::BOTH {
                for bit in bits(lattice.last(side)) {
                    let free = field.blocking(cell, Flip::of_bit(side, bit)).is_empty();
                    assert_eq!(masks[side.index()] & bit != 0, free, "{cell:?} {side:?} {bit}");
                }
            }
        }
    }
}
