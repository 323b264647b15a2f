//! The lattice with its obstacles: free flips of a cell, and free rectangles of cells.
//!
//! A line (row or column) is described in slots: cell `k` is slot `2k`, the open gap between the cells `k` and `k+1` is slot `2k+1`,
//! so that an obstacle which lies between two cells and covers neither still blocks the moves across it. Lines are computed when first asked
//! for; up to [`EAGER_MODULES`] modules they are kept in an array, above in a hash map.

use super::bands::Bands;
use super::journey::Workspace;
use super::lattice::{Flip, Lattice, LatticeCell, Side};
use crate::geometry::section::Rectangle;
use crate::geometry::{Pose, Rounded, Shape, ShapeError};
use rustc_hash::FxHashMap;
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Added to every grown shape, so that float rounding cannot make the verifier, which uses the plain growth, reject a plan.
pub const SAFETY_MARGIN_UM: f64 = 1e-9;

/// Up to this many modules the lines of a side are looked up in an array.
const EAGER_MODULES: u32 = 13;
/// Blocked runs kept by the cache of lines before it is emptied.
const MAX_CACHED_RUNS: usize = 1 << 24;

/// Something the end-effector must not touch. Its index in the list given to [`LatticeField::new`] is its identity.
#[derive(Clone, Debug, PartialEq)]
pub enum FieldObstacle {
    /// All cells with coordinates between `from` and `to`, both included, in either order; cells outside the lattice are ignored.
    Cells {
        /// One corner.
        from: [u32; 2],
        /// The opposite corner.
        to: [u32; 2],
    },
    /// A shape in the plane.
    Physical {
        /// The shape in its own frame.
        shape: Shape,
        /// Pose in the lattice's frame (origin at cell (0, 0), x along the left modules' motion).
        pose: Pose,
        /// Radius of the end-effector's tip plus its repeatability, in µm.
        growth_um: f64,
    },
}

/// Why a field cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldError {
    /// The shape of this obstacle is not acceptable.
    Shape {
        /// Index of the obstacle.
        obstacle: usize,
        /// What is wrong with it.
        error: ShapeError,
    },
    /// More than 2^31 obstacles.
    TooMany,
}

enum FieldBody {
    Cells { from: [u32; 2], to: [u32; 2] },
    Grown(Rounded),
}

/// A lattice with obstacles. Cheap to query and safe to share; searches of one field take turns.
pub struct LatticeField {
    lattice: Lattice,
    bodies: Vec<FieldBody>,
    /// Rows for the left side, columns for the right side.
    bands: [Bands; 2],
    work: Mutex<Work>,
}

/// Caches that searches keep between queries.
pub(super) struct Work {
    lines: [BlockedLines; 2],
    pub(super) search: Workspace,
}

/// View of a field that may compute and cache lines.
pub(super) struct FieldReader<'a> {
    field: &'a LatticeField,
    lines: &'a mut [BlockedLines; 2],
}

impl LatticeField {
    /// Builds the index; lines are computed on demand.
    ///
    /// # Errors
    /// See [`FieldError`].
    pub fn new(lattice: Lattice, obstacles: &[FieldObstacle]) -> Result<Self, FieldError> {
        if obstacles.len() >= 1 << 31 {
            return Err(FieldError::TooMany);
        }
        let bodies: Result<Vec<FieldBody>, FieldError> = obstacles.iter().enumerate().map(body).collect();
        let bodies = bodies?;
        let bands = Side::BOTH.map(|side| {
            let spans: Vec<[u32; 2]> = bodies.iter().map(|b| b.lines(&lattice, side)).collect();
            Bands::new(lattice.modules[side.other().index()], &spans)
        });
        let lines = Side::BOTH.map(|side| BlockedLines::new(lattice.modules[side.other().index()]));
        let search = Workspace::default();
        let work = Mutex::new(Work { lines, search });
        Ok(LatticeField { lattice, bodies, bands, work })
    }

    /// The lattice.
    pub const fn lattice(&self) -> &Lattice {
        &self.lattice
    }

    /// Number of obstacles.
    pub const fn obstacles(&self) -> usize {
        self.bodies.len()
    }

    /// Obstacles that cover the cell, ascending.
    pub fn covering(&self, cell: LatticeCell) -> Vec<usize> {
        self.touching([cell.x; 2], [cell.y; 2])
    }

    /// Obstacles that touch the segment swept by `flip` from `cell`, ascending. Exactly the flips with none are legal.
    pub fn blocking(&self, cell: LatticeCell, flip: Flip) -> Vec<usize> {
        let after = cell.after(flip);
        self.touching([cell.x & after.x, cell.x | after.x], [cell.y & after.y, cell.y | after.y])
    }

    /// Obstacles that touch the closed rectangle between the cells `(x[0], y[0])` and `(x[1], y[1])`, ascending.
    pub fn touching(&self, x: [u32; 2], y: [u32; 2]) -> Vec<usize> {
        let mut found: Vec<usize> = self.near(x, y).filter(|&k| self.touches(k, x, y)).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Whether no obstacle touches the closed rectangle between the cells `(x[0], y[0])` and `(x[1], y[1])`.
    pub fn rectangle_free(&self, x: [u32; 2], y: [u32; 2]) -> bool {
        !self.near(x, y).any(|k| self.touches(k, x, y))
    }

    /// Obstacles that may touch the rectangle, from the index over its shorter side.
    fn near(&self, x: [u32; 2], y: [u32; 2]) -> impl Iterator<Item = usize> {
        let (bands, range) = match y[1].saturating_sub(y[0]) <= x[1].saturating_sub(x[0]) {
            true => (&self.bands[0], y),
            false => (&self.bands[1], x),
        };
        let items = bands.between(range[0], range[1]).flatten();
        items.map(|&k| k as usize)
    }

    fn touches(&self, obstacle: usize, x: [u32; 2], y: [u32; 2]) -> bool {
        match &self.bodies[obstacle] {
            FieldBody::Cells { from, to } => from[0] <= x[1] && x[0] <= to[0] && from[1] <= y[1] && y[0] <= to[1],
            FieldBody::Grown(body) => body.touches(&Rectangle {
                min_um: self.lattice.position_um(LatticeCell::new(x[0], y[0])),
                max_um: self.lattice.position_um(LatticeCell::new(x[1], y[1])),
            }),
        }
    }

    /// Precomputes for the first non-trivial search: the block abstraction and, for up to 13 modules a side, all lines.
    pub fn prepare(&self) {
        let mut work = self.work();
        let (mut reader, space) = work.open(self);
        space.prepare(&mut reader);
    }

    /// The modules of each side that may switch alone in `cell`, as bit masks; `None` if an obstacle covers it or it is not a cell
    /// of the lattice.
    pub fn legal(&self, cell: LatticeCell) -> Option<[u32; 2]> {
        if !self.lattice.contains(cell) {
            return None;
        }
        let mut work = self.work();
        work.open(self).0.legal(cell.pair())
    }

    pub(super) fn work(&self) -> MutexGuard<'_, Work> {
        // A panic elsewhere cannot leave the caches half-written in a way that changes answers: searches reset what they use.
        self.work.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn line_runs(&self, side: Side, line: u32, runs: &mut Vec<[u32; 2]>, cuts: &mut Vec<[f64; 2]>) {
        let (along, across) = (side.index(), side.other().index());
        let last_slot = 2 * self.lattice.last(side);
        for &k in self.bands[along].candidates(line) {
            match &self.bodies[k as usize] {
                FieldBody::Cells { from, to } if (from[across]..=to[across]).contains(&line) => {
                    if 2 * u64::from(from[along]) <= u64::from(last_slot) {
                        runs.push([2 * from[along], (2 * to[along].min(last_slot / 2))]);
                    }
                }
                FieldBody::Cells { .. } => {}
                FieldBody::Grown(body) => {
                    cuts.clear();
                    body.section(side.axis(), f64::from(line) * self.lattice.pitch_um[across], cuts);
                    let pitch = self.lattice.pitch_um[along];
                    runs.extend(cuts.iter().filter_map(|cut| slots(*cut, pitch, last_slot)));
                }
            }
        }
    }
}

fn body((index, obstacle): (usize, &FieldObstacle)) -> Result<FieldBody, FieldError> {
    match obstacle {
        FieldObstacle::Cells { from, to } => Ok(FieldBody::Cells {
            from: [from[0].min(to[0]), from[1].min(to[1])],
            to: [from[0].max(to[0]), from[1].max(to[1])],
        }),
        FieldObstacle::Physical { shape, pose, growth_um } => match shape.grown(pose, *growth_um) {
            Ok(mut grown) => {
                grown.radius_um += SAFETY_MARGIN_UM;
                Ok(FieldBody::Grown(grown))
            }
            Err(error) => Err(FieldError::Shape { obstacle: index, error }),
        },
    }
}

impl FieldBody {
    /// The lines along `side` that the body may meet, as an inclusive range, empty if first > last.
    fn lines(&self, lattice: &Lattice, side: Side) -> [u32; 2] {
        let across = side.other();
        let last = lattice.last(across);
        match self {
            FieldBody::Cells { from, to }
                if from[across.index()] <= last && from[side.index()] <= lattice.last(side) =>
            {
                [from[across.index()], to[across.index()].min(last)]
            }
            FieldBody::Cells { .. } => [1, 0],
            FieldBody::Grown(body) => {
                let (bounds, k) = (body.bounds(), across.index());
                let pitch = lattice.pitch_um[k];
                let (low, high) = (bounds.min_um[k] / pitch - 1.0, bounds.max_um[k] / pitch + 1.0);
                if high < 0.0 || low > f64::from(last) {
                    return [1, 0];
                }
                // `as` clamps to the range of u32.
                [low as u32, (high as u32).min(last)]
            }
        }
    }
}

/// The slots met by the closed interval `cut` (µm), if any lies on the lattice.
fn slots(cut: [f64; 2], pitch_um: f64, last_slot: u32) -> Option<[u32; 2]> {
    let (low, high) = (cut[0] / pitch_um, cut[1] / pitch_um);
    if high < 0.0 || low > f64::from(last_slot / 2) {
        return None;
    }
    let (up, down) = (low.ceil(), high.floor());
    let first = if up == low { 2.0 * up } else { 2.0 * up - 1.0 };
    let last = if down == high { 2.0 * down } else { 2.0 * down + 1.0 };
    // `as` clamps: a negative first slot becomes 0.
    Some([first as u32, (last as u32).min(last_slot)])
}

/// The blocked runs of the lines queried so far, in slots, sorted and disjoint.
struct BlockedLines {
    store: Store,
    runs: Vec<[u32; 2]>,
    fresh: Vec<[u32; 2]>,
    cuts: Vec<[f64; 2]>,
}

enum Store {
    /// Start and length in `runs`, by line; `UNKNOWN` as start if not yet computed.
    Array(Vec<[u32; 2]>),
    Map(FxHashMap<u32, [u32; 2]>),
}

const UNKNOWN: u32 = u32::MAX;

impl BlockedLines {
    fn new(modules: u32) -> Self {
        let store = match modules <= EAGER_MODULES {
            true => Store::Array(Vec::new()),
            false => Store::Map(FxHashMap::default()),
        };
        BlockedLines { store, runs: Vec::new(), fresh: Vec::new(), cuts: Vec::new() }
    }

    fn known(&self, line: u32) -> Option<[u32; 2]> {
        match &self.store {
            Store::Array(at) => at.get(line as usize).copied().filter(|[start, _]| *start != UNKNOWN),
            Store::Map(at) => at.get(&line).copied(),
        }
    }

    fn compute(&mut self, field: &LatticeField, side: Side, line: u32) -> [u32; 2] {
        if self.runs.len() > MAX_CACHED_RUNS {
            self.forget();
        }
        let start = self.runs.len();
        self.append(field, side, line);
        let place = [start as u32, (self.runs.len() - start) as u32];
        match &mut self.store {
            Store::Array(at) => {
                if at.is_empty() {
                    at.resize(field.lattice.last(side.other()) as usize + 1, [UNKNOWN, 0]);
                }
                at[line as usize] = place;
            }
            Store::Map(at) => {
                at.insert(line, place);
            }
        }
        place
    }

    /// Appends the line's runs, sorted and disjoint, to `runs`.
    fn append(&mut self, field: &LatticeField, side: Side, line: u32) {
        self.fresh.clear();
        field.line_runs(side, line, &mut self.fresh, &mut self.cuts);
        self.fresh.sort_unstable();
        let start = self.runs.len();
        for &[first, last] in &self.fresh {
            match self.runs[start..].last_mut() {
                Some(run) if first <= run[1].saturating_add(1) => run[1] = run[1].max(last),
                Some(_) | None => self.runs.push([first, last]),
            }
        }
    }

    fn forget(&mut self) {
        self.runs.clear();
        match &mut self.store {
            Store::Array(at) => at.clear(),
            Store::Map(at) => at.clear(),
        }
    }
}

impl Work {
    pub(super) fn open<'a>(&'a mut self, field: &'a LatticeField) -> (FieldReader<'a>, &'a mut Workspace) {
        let lines = &mut self.lines;
        (FieldReader { field, lines }, &mut self.search)
    }
}

impl FieldReader<'_> {
    pub(super) const fn lattice(&self) -> &Lattice {
        &self.field.lattice
    }

    /// The blocked runs of a line.
    fn runs(&mut self, side: Side, line: u32) -> &[[u32; 2]] {
        if self.field.bands[side.index()].candidates(line).is_empty() {
            return &[];
        }
        let lines = &mut self.lines[side.index()];
        let [start, count] = match lines.known(line) {
            Some(place) => place,
            None => lines.compute(self.field, side, line),
        };
        &lines.runs[start as usize..(start + count) as usize]
    }

    /// Calls `visit` with the first and last cell of each free run of the line. Lines of large lattices are not cached, since a
    /// caller may visit all of them.
    pub(super) fn each_free_run(&mut self, side: Side, line: u32, mut visit: impl FnMut([u32; 2])) {
        let last = self.field.lattice.last(side);
        let mut low = 0;
        let lines = &mut self.lines[side.index()];
        let kept = lines.runs.len();
        let passing = matches!(lines.store, Store::Map(_));
        let runs = match passing {
            true => {
                lines.append(self.field, side, line);
                &lines.runs[kept..]
            }
            false => self.runs(side, line),
        };
        for run in runs {
            if 2 * low < run[0] {
                visit([low, (run[0] - 1) / 2]);
            }
            low = run[1] / 2 + 1;
        }
        if low <= last {
            visit([low, last]);
        }
        if passing {
            self.lines[side.index()].runs.truncate(kept);
        }
    }

    /// First and last cell reachable along `side` from cell `at` of `line` without a gap; `None` if that cell is covered.
    #[inline]
    pub(super) fn free_run(&mut self, side: Side, line: u32, at: u32) -> Option<[u32; 2]> {
        let last = self.field.lattice.last(side);
        let runs = self.runs(side, line);
        let next = runs.partition_point(|run| run[1] < 2 * at);
        let low = match next.checked_sub(1) {
            Some(before) => runs[before][1] / 2 + 1,
            None => 0,
        };
        match runs.get(next) {
            Some(run) if run[0] <= 2 * at => None,
            Some(run) => Some([low, (run[0] - 1) / 2]),
            None => Some([low, last]),
        }
    }

    /// The modules of each side that may switch alone; `None` if an obstacle covers the cell.
    #[inline]
    pub(super) fn legal(&mut self, [x, y]: [u32; 2]) -> Option<[u32; 2]> {
        let row = self.free_run(Side::Left, y, x)?;
        let column = self.free_run(Side::Right, x, y)?;
        Some([stays_within(x, row), stays_within(y, column)])
    }
}

/// Bits whose flip keeps `at` within the run.
#[inline]
fn stays_within(at: u32, [low, high]: [u32; 2]) -> u32 {
    (!at & up_to(high - at)) | (at & up_to(at - low))
}

/// All powers of two that are at most `reach`, as one mask.
#[inline]
fn up_to(reach: u32) -> u32 {
    // The leading bit and everything below it.
    u32::MAX.checked_shr(reach.leading_zeros()).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
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
    fn slots_tell_cells_from_gaps() {
        assert_eq!(slots([2.0, 3.0], 1.0, 14), Some([4, 6]));
        assert_eq!(slots([2.1, 2.9], 1.0, 14), Some([5, 5]));
        assert_eq!(slots([1.9, 3.1], 1.0, 14), Some([3, 7]));
        assert_eq!(slots([-5.0, -0.1], 1.0, 14), None);
        assert_eq!(slots([-5.0, 0.0], 1.0, 14), Some([0, 0]));
        assert_eq!(slots([7.0, 9.0], 1.0, 14), Some([14, 14]));
        assert_eq!(slots([7.1, 9.0], 1.0, 14), None);
    }

    #[test]
    fn flips_stay_within_the_free_run() {
        assert_eq!(up_to(0), 0);
        assert_eq!(up_to(1), 1);
        assert_eq!(up_to(5), 0b111);
        assert_eq!(stays_within(0b0110, [0, 15]), 0b1111);
        assert_eq!(stays_within(0b0110, [5, 9]), 0b0001);
        assert_eq!(stays_within(0b0110, [4, 7]), 0b0011);
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
