//! Position of a DiMiBot's tip, and its contacts with obstacles.
//!
//! Input: cells and the order's obstacles. Positions come from the kinematic matrix, never from the lattice formula.
//! Promise: a body is touched exactly if its distance from the area swept by the tip's centre is at most tip radius
//! plus repeatability, up to the rounding of [`super::super::geometry`]. Lattice cells are touched only if the centre
//! enters them.

use super::super::InvalidClaims;
use super::super::boxes::{Extent, GroupedBoxes};
use super::super::geometry::solid::Solid;
use super::super::premise::is_frame;
use crate::claims::dimibot::{Asked, DimibotObstacleBody, DimibotOrder, DimibotStep, DimibotStop};
use crate::device::dimibot::{DimibotFacts, LatticeCell, MAX_MODULES};
use crate::geometry::shape::{MAX_EXTENT_UM, Pose};
use crate::quantity::digits;
use crate::real::Real;
use nalgebra::{Point2, Vector2};

/// Margin added to a body when boxes are compared, so that rounding cannot hide a contact.
const BOX_MARGIN_UM: f64 = 1e-6;

/// Relative tolerance of a position at its limit, for the rounding of the checker.
const TOLERANCE: f64 = 1e-9;

/// Checks the replay's assumptions about claims.
pub(super) fn check_claims(order: &DimibotOrder) -> Result<(), InvalidClaims> {
    let facts = &order.facts;
    let invalid = |why: &str| Err(InvalidClaims(format!("the claims of a dimibot {why}")));
    if ![facts.left, facts.right].iter().all(|modules| (1..=MAX_MODULES).contains(modules)) {
        return invalid("have no module on a side, or too many");
    }
    let positive = [facts.stroke_um, facts.gain, facts.pulse_voltage_v, facts.pulse_current_a];
    let others = [facts.repeatability_um, facts.tip_radius_um];
    if !positive.iter().all(|value| value.is_finite() && *value > 0.0)
        || !others.iter().all(|value| value.is_finite() && *value >= 0.0)
        || facts.gain * facts.stroke_um > MAX_EXTENT_UM
        || !(facts.pulse_voltage_v * facts.pulse_current_a).is_finite()
    {
        return invalid("have a field out of range");
    }
    if order.frame.is_some_and(|frame| !is_frame(&frame)) {
        return invalid("place it out of range");
    }
    if facts.pulse_duration_ns == 0 || facts.pulse_duration_ns.checked_add(facts.rest_ns).is_none() {
        return invalid("have a pulse of zero duration, or a rest beyond the end of the clock");
    }
    let stops = order.steps.iter().flat_map(DimibotStep::stops);
    let start = order.start.as_ref().map(|start| start.value);
    if !stops.map(|stop| stop.cell).chain(start).chain([facts.home]).all(|cell| exists(facts, cell)) {
        return invalid("name a cell that it does not have");
    }
    Ok(())
}

/// Whether a cell uses only modules that the robot has.
fn exists(facts: &DimibotFacts, cell: LatticeCell) -> bool {
    cell.x >> facts.left == 0 && cell.y >> facts.right == 0
}

/// Nominal position of the end-effector in the frame R1.
pub(super) fn place(facts: &DimibotFacts, cell: LatticeCell) -> Point2<f64> {
    Point2::from(DimibotFacts::workspace_frame() * facts.displacement_um(cell))
}

/// Pose of a robot's frame in its scene, as a rotation and a translation; the identity without a frame.
#[derive(Clone, Copy)]
pub(super) struct FrameTransform {
    /// Sine and cosine of the heading, and the position.
    turn: Option<([f64; 2], [f64; 2])>,
}

impl FrameTransform {
    pub fn of(frame: Option<&Pose>) -> FrameTransform {
        FrameTransform { turn: frame.map(|frame| (frame.heading_rad.sine_cosine().into(), [frame.x_um, frame.y_um])) }
    }

    /// Scene coordinates of a point in the robot's frame.
    pub fn in_scene(&self, own: Point2<f64>) -> Point2<f64> {
        let Some(([sin, cos], [x, y])) = self.turn else { return own };
        Point2::new(cos * own.x - sin * own.y + x, sin * own.x + cos * own.y + y)
    }

    /// A scene vector in the axes of the robot.
    fn along_own_axes(&self, way: Vector2<f64>) -> Vector2<f64> {
        let Some(([sin, cos], _)) = self.turn else { return way };
        Vector2::new(cos * way.x + sin * way.y, cos * way.y - sin * way.x)
    }
}

/// Corners, in order round it, of the area that the tip's centre may sweep between two cells, in scene coordinates: a
/// rectangle, a segment where a single module moves, or a point. `low` is the lower cell in both axes.
pub(super) fn swept(facts: &DimibotFacts, stand: &FrameTransform, [low, high]: [LatticeCell; 2]) -> Vec<Point2<f64>> {
    let cells = match (low.x == high.x, low.y == high.y) {
        (true, true) => vec![low],
        (true, false) | (false, true) => vec![low, high],
        (false, false) => vec![low, LatticeCell { x: high.x, ..low }, high, LatticeCell { y: high.y, ..low }],
    };
    cells.into_iter().map(|cell| stand.in_scene(place(facts, cell))).collect()
}

/// The obstacles of an order, prepared for queries.
pub(super) struct DimibotObstacles<'a> {
    facts: &'a DimibotFacts,
    stand: FrameTransform,
    solids: Vec<(usize, Solid)>,
    solid_boxes: GroupedBoxes,
    blocks: Vec<(usize, [LatticeCell; 2])>,
    block_boxes: GroupedBoxes,
}

/// Obstacles that the tip touches.
pub(super) struct TipTouch {
    /// Index of the first touched obstacle among the order's obstacles.
    pub obstacle: usize,
    /// Number of further obstacles touched.
    others: usize,
    /// Distance of the tip's centre from the first one's surface, at least 0; `None` for cells.
    gap_um: Option<f64>,
}

/// The solid nearest to the path of the tip.
pub(super) struct NearestSolid {
    /// Index among the order's obstacles.
    pub obstacle: usize,
    /// Distance of the tip's centre from the surface.
    pub gap_um: f64,
    pub on_solid: Point2<f64>,
    pub centre: Point2<f64>,
}

impl TipTouch {
    /// End of a violation's title.
    pub fn describe(&self, order: &DimibotOrder) -> String {
        let name = &order.obstacles[self.obstacle].name;
        let others = match self.others {
            0 => String::new(),
            others => format!(" and {others} more"),
        };
        match self.gap_um {
            None => format!("which touches the cells of `{name}`{others}"),
            Some(gap_um) => {
                let (gap, room) = (digits(gap_um), digits(contact_distance_um(&order.facts)));
                format!("with a gap of {gap} um to `{name}`{others}; more than {room} um is needed")
            }
        }
    }
}

impl<'a> DimibotObstacles<'a> {
    /// Places the obstacles of an order.
    ///
    /// # Errors
    /// If the shape or the pose of a solid obstacle is invalid.
    pub fn new(order: &'a DimibotOrder) -> Result<DimibotObstacles<'a>, InvalidClaims> {
        let (mut solids, mut blocks) = (Vec::new(), Vec::new());
        for (index, obstacle) in order.obstacles.iter().enumerate() {
            match &obstacle.body {
                DimibotObstacleBody::Cells { from, to } => blocks.push((index, [*from, *to])),
                DimibotObstacleBody::Solid { shape, pose } => {
                    let invalid = || InvalidClaims(format!("the claims' obstacle `{}` has no shape", obstacle.name));
                    solids.push((index, Solid::of(shape, pose).ok_or_else(invalid)?));
                }
            }
        }
        let solid_boxes = GroupedBoxes::new(solids.iter().map(|(_, body)| body.extent()));
        let block_boxes = GroupedBoxes::new(blocks.iter().map(|(_, corners)| Extent::of(&corners.map(lattice_point))));
        let stand = FrameTransform::of(order.frame.as_ref());
        Ok(DimibotObstacles { facts: &order.facts, stand, solids, solid_boxes, blocks, block_boxes })
    }

    /// Obstacles touched by the tip in the rectangle between two cells, `low` the lower one in both axes. A rectangle
    /// without width is the path of a single module, one without extent a position.
    pub fn touch(&self, low: LatticeCell, high: LatticeCell) -> Option<TipTouch> {
        let solids = self.touched_solids(low, high);
        let blocks = self.touched_blocks(low, high);
        let others = (solids.len() + blocks.len()).checked_sub(1)?;
        let first = solids.iter().copied().chain(blocks.iter().map(|index| (*index, None)));
        let (obstacle, gap_um) = first.min_by_key(|(index, _)| *index)?;
        Some(TipTouch { obstacle, others, gap_um })
    }

    /// The solid nearest to the area that the tip's centre may sweep between two cells, if it is nearer than
    /// `below_um`.
    pub fn nearest(&self, low: LatticeCell, high: LatticeCell, below_um: f64) -> Option<NearestSolid> {
        let swept = swept(self.facts, &self.stand, [low, high]);
        let area = Extent::of(&swept).widened(below_um + BOX_MARGIN_UM);
        let near = self.solid_boxes.meeting(&area).into_iter().map(|at| &self.solids[at]);
        let measured = near.map(|(obstacle, body)| (*obstacle, body.gap_um(&swept), body));
        let nearest = measured.filter(|(_, gap_um, _)| *gap_um < below_um).min_by(|a, b| a.1.total_cmp(&b.1));
        let (obstacle, gap_um, body) = nearest?;
        let [on_solid, centre] = body.nearest_points(&swept)?;
        Some(NearestSolid { obstacle, gap_um, on_solid, centre })
    }

    /// Position of the tip's centre at a cell, in the scene.
    pub fn centre(&self, cell: LatticeCell) -> Point2<f64> {
        self.stand.in_scene(place(self.facts, cell))
    }

    fn touched_solids(&self, low: LatticeCell, high: LatticeCell) -> Vec<(usize, Option<f64>)> {
        let swept = swept(self.facts, &self.stand, [low, high]);
        let contact_distance_um = contact_distance_um(self.facts);
        let area = Extent::of(&swept).widened(contact_distance_um + BOX_MARGIN_UM);
        let near = self.solid_boxes.meeting(&area).into_iter().map(|at| &self.solids[at]);
        let measured = near.map(|(index, body)| (*index, body.gap_um(&swept)));
        let touched = measured.filter(|(_, gap_um)| *gap_um <= contact_distance_um);
        touched.map(|(index, gap_um)| (index, Some(gap_um.max(0.0)))).collect()
    }

    /// The paper's rule: a row or column of cells is touched if one of its cells is, both ends included.
    fn touched_blocks(&self, low: LatticeCell, high: LatticeCell) -> Vec<usize> {
        let area = Extent::of(&[low, high].map(lattice_point));
        let near = self.block_boxes.meeting(&area).into_iter().map(|at| &self.blocks[at]);
        let meets =
            |[from, to]: &[LatticeCell; 2]| from.x <= high.x && low.x <= to.x && from.y <= high.y && low.y <= to.y;
        near.filter(|(_, corners)| meets(corners)).map(|(index, _)| *index).collect()
    }
}

fn lattice_point(cell: LatticeCell) -> Point2<f64> {
    Point2::new(f64::from(cell.x), f64::from(cell.y))
}

/// Greatest distance from the nominal place at which a body may touch the tip: tip radius plus repeatability.
pub(super) fn contact_distance_um(facts: &DimibotFacts) -> f64 {
    facts.tip_radius_um + facts.repeatability_um
}

/// The reason why a cell is wrong for a position, if it is: the position is more than half a pitch away along an axis,
/// or farther than the precision.
pub(super) fn misplaced(order: &DimibotOrder, stop: &DimibotStop) -> Option<String> {
    let Asked::Place([x_um, y_um]) = stop.asked else { return None };
    let (facts, cell) = (&order.facts, stop.cell);
    let origin = place(facts, LatticeCell { x: 0, y: 0 });
    let pitch_um = Vector2::new(
        (place(facts, LatticeCell { x: 1, y: 0 }) - origin).norm(),
        (place(facts, LatticeCell { x: 0, y: 1 }) - origin).norm(),
    );
    let stand = FrameTransform::of(order.frame.as_ref());
    let off_um = Point2::new(x_um, y_um) - stand.in_scene(place(facts, cell));
    let far_um = order.frame.map_or(0.0, |frame| frame.x_um.abs() + frame.y_um.abs());
    let half = |axis: usize| pitch_um[axis] / 2.0 + TOLERANCE * (1.0 + facts.gain * facts.stroke_um + far_um);
    let own_um = stand.along_own_axes(off_um);
    let near = (0..2).all(|axis| own_um[axis].abs() <= half(axis));
    let (x, y, off) = (digits(x_um), digits(y_um), digits(off_um.norm()));
    if !near {
        return Some(format!("cell {cell} is used for ({x}, {y}) um, {off} um away, but is not the nearest cell"));
    }
    let limit_um = order.precision_um?;
    let precise = off_um.norm() <= limit_um * (1.0 + TOLERANCE);
    (!precise).then(|| {
        let limit = digits(limit_um);
        format!("cell {cell} is {off} um off the place ({x}, {y}) um; at most {limit} um is allowed")
    })
}
