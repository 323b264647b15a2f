//! Obstacles of a lattice: which of them touch a rectangle of cells, and which stretches of a line they block.
//!
//! A line (row or column) is described in slots: cell `k` is slot `2k`, the open gap between the cells `k` and `k+1` is slot `2k+1`,
//! so that an obstacle which lies between two cells and covers neither still blocks the moves across it.

use super::bands::Bands;
use super::lattice::{Lattice, LatticeCell, Side};
use crate::geometry::section::Rectangle;
use crate::geometry::{Pose, Rounded, Shape, ShapeError};

/// Added to every grown shape, so that float rounding cannot make the verifier, which uses the plain growth, reject a plan.
pub const SAFETY_MARGIN_UM: f64 = 1e-9;

/// Something that the end-effector must not touch. It is identified by its index in the list given to
/// [`LatticeField::new`](super::LatticeField::new).
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
        /// Error of the shape.
        error: ShapeError,
    },
    /// More than 2^31 obstacles.
    TooMany,
}

enum FieldBody {
    Cells { from: [u32; 2], to: [u32; 2] },
    Grown(Rounded),
}

/// The obstacles of a lattice, indexed by the lines that they may meet.
pub(super) struct Obstacles {
    pub(super) lattice: Lattice,
    bodies: Vec<FieldBody>,
    /// Rows for the left side, columns for the right side.
    bands: [Bands; 2],
}

impl Obstacles {
    /// Indexes the obstacles of a lattice.
    ///
    /// # Errors
    /// See [`FieldError`].
    pub(super) fn new(lattice: Lattice, obstacles: &[FieldObstacle]) -> Result<Self, FieldError> {
        if obstacles.len() >= 1 << 31 {
            return Err(FieldError::TooMany);
        }
        let bodies: Result<Vec<FieldBody>, FieldError> =
            obstacles.iter().enumerate().map(|(index, obstacle)| body(index, obstacle)).collect();
        let bodies = bodies?;
        let bands = Side::BOTH.map(|side| {
            let spans: Vec<[u32; 2]> = bodies.iter().map(|b| b.lines(&lattice, side)).collect();
            Bands::new(lattice.modules[side.other().index()], &spans)
        });
        Ok(Obstacles { lattice, bodies, bands })
    }

    /// Number of obstacles.
    pub(super) const fn len(&self) -> usize {
        self.bodies.len()
    }

    /// Obstacles that touch the closed rectangle between the cells `(x[0], y[0])` and `(x[1], y[1])`, ascending.
    pub(super) fn touching(&self, x: [u32; 2], y: [u32; 2]) -> Vec<usize> {
        let mut found: Vec<usize> = self.near(x, y).filter(|&k| self.touches(k, x, y)).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Whether no obstacle touches the closed rectangle between the cells `(x[0], y[0])` and `(x[1], y[1])`.
    pub(super) fn rectangle_free(&self, x: [u32; 2], y: [u32; 2]) -> bool {
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

    /// Whether no obstacle can meet a line along a side.
    #[inline]
    pub(super) fn leave_free(&self, side: Side, line: u32) -> bool {
        self.bands[side.index()].candidates(line).is_empty()
    }

    /// Appends the blocked runs of a line, in slots and in no order; `cuts` is scratch space.
    pub(super) fn line_runs(&self, side: Side, line: u32, runs: &mut Vec<[u32; 2]>, cuts: &mut Vec<[f64; 2]>) {
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

fn body(index: usize, obstacle: &FieldObstacle) -> Result<FieldBody, FieldError> {
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
