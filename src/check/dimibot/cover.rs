//! Obstacles that cover a cell, looked up in a hierarchical grid of bounding boxes, so that a query among tens of
//! thousands of obstacles takes a few steps.
//!
//! An obstacle is entered under its bounding box at the level whose squares are at least as wide as the box, in four
//! squares at most; a cell is looked up once in each level. The answer is exact, because boxes only select the
//! candidates.

use super::{DimibotObstacle, bounds_um, clearance_um};
use crate::claims::dimibot::DimibotObstacleBody;
use crate::device::dimibot::{DimibotFacts, LatticeCell, MAX_MODULES};
use crate::geometry::shape::Pose;
use rustc_hash::FxHashMap;
use std::borrow::Cow;
use std::sync::Arc;

/// The obstacles of a scene as judged for one device, indexed for queries.
#[derive(Debug, Clone)]
pub struct SceneCover {
    /// Pose of the robot's frame in the scene, if the scene has one.
    pub frame: Option<Pose>,
    /// In the scene's coordinates.
    pub obstacles: Arc<Vec<DimibotObstacle>>,
    /// Indices of the obstacles whose box touches a square, ascending; squares of level l are 2^l cells wide.
    squares: Arc<FxHashMap<(u32, u32, u32), Vec<u32>>>,
}

impl SceneCover {
    /// Indexes the obstacles, which must be those of this device.
    pub fn of(obstacles: Vec<DimibotObstacle>, facts: &DimibotFacts, frame: Option<Pose>) -> SceneCover {
        let mut squares: FxHashMap<(u32, u32, u32), Vec<u32>> = FxHashMap::default();
        for (index, obstacle) in obstacles.iter().enumerate() {
            let Some([low, high]) = box_of(&obstacle.body.seen_from(frame.as_ref()), facts) else { continue };
            let widest = (high.x - low.x).max(high.y - low.y) + 1;
            let level = widest.next_power_of_two().trailing_zeros();
            for x in low.x >> level..=high.x >> level {
                for y in low.y >> level..=high.y >> level {
                    squares.entry((level, x, y)).or_default().push(index as u32);
                }
            }
        }
        SceneCover { frame, obstacles: Arc::new(obstacles), squares: Arc::new(squares) }
    }

    /// The first obstacle, in the order of the scene, that covers a cell.
    pub fn covering(&self, cell: LatticeCell, facts: &DimibotFacts) -> Option<usize> {
        let squares =
            (0..=MAX_MODULES).filter_map(|level| self.squares.get(&(level, cell.x >> level, cell.y >> level)));
        let is_under = |index: &usize| covers(&self.body(*index), cell, facts);
        let first = |square: &Vec<u32>| square.iter().map(|index| *index as usize).find(is_under);
        squares.filter_map(first).min()
    }

    /// An obstacle's body in the robot's own coordinates.
    pub fn body(&self, index: usize) -> Cow<'_, DimibotObstacleBody> {
        self.obstacles[index].body.seen_from(self.frame.as_ref())
    }
}

/// Whether an obstacle in the robot's own coordinates leaves its tip no room at a cell.
pub fn covers(body: &DimibotObstacleBody, cell: LatticeCell, facts: &DimibotFacts) -> bool {
    match body {
        DimibotObstacleBody::Cells { from, to } => {
            (from.x..=to.x).contains(&cell.x) && (from.y..=to.y).contains(&cell.y)
        }
        DimibotObstacleBody::Solid { shape, pose } => clearance_um(shape, pose, cell, facts) <= facts.growth_um(),
    }
}

/// The lowest and the highest cell that a body can cover, with a margin of one cell on each side for rounding; `None`
/// outside the lattice.
fn box_of(body: &DimibotObstacleBody, facts: &DimibotFacts) -> Option<[LatticeCell; 2]> {
    match body {
        DimibotObstacleBody::Cells { from, to } => (from.x <= to.x && from.y <= to.y).then_some([*from, *to]),
        DimibotObstacleBody::Solid { shape, pose } => {
            let [low_um, high_um] = bounds_um(shape, pose, facts.growth_um())?;
            let ([low_x, low_y], [high_x, high_y]) = (facts.nearest_indices(low_um), facts.nearest_indices(high_um));
            let around = |[x, y]: [f64; 2], step: f64| facts.clamped_cell_of([x + step, y + step]);
            Some([around([low_x, low_y], -1.0), around([high_x, high_y], 1.0)])
        }
    }
}
