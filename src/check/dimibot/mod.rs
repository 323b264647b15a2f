//! Checks of DiMiBots: whether a robot is possible, whether a scene is possible for it, and whether goals are.

use super::devices::CheckedDevice;
use super::figures::Figures;
use super::frames::DeviceFrame;
use super::lets::Argument;
use super::neighbours::PlacedDevices;
use super::objects::of_other_kind;
use super::scenes::{CheckedScene, SceneObject};
use super::tasks::{self, Parts, TaskSite};
use super::value::Accepted;
use super::value::{ModuleWord, Value, whole};
use super::{CheckedFacts, Checker, KindChecks, KindFacts, errors, shapes};
use crate::claims::dimibot::{
    Asked, DimibotAction, DimibotMethod, DimibotObjective, DimibotObstacle, DimibotObstacleBody, DimibotOrder,
    DimibotPlanner, DimibotStep, DimibotStop, InitialCell,
};
use crate::claims::{Job, Order};
use crate::device::dimibot::{self, DimibotFacts, DimibotVerb, LatticeCell, Side, Simultaneous};
use crate::device::shape::ShapeForm;
use crate::diagnostic::{Diagnostic, Sink};
use crate::geometry::distance;
use crate::geometry::shape::{MAX_EXTENT_UM, Pose, Shape};
use crate::quantity::Quantity;
use crate::source::{Span, Spanned};
use nalgebra::Point2;
use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

mod cover;
mod frames;
mod stops;

pub use cover::SceneCover;

impl CheckedFacts for Rc<DimibotFacts> {
    fn channel_examples(&self) -> Vec<String> {
        self.channels()
    }

    fn pitch(&self) -> Option<String> {
        let [left, right] = Side::BOTH.map(|side| length(self.pitch_um(side)));
        Some(if left == right { format!("cells of {left}") } else { format!("cells of {left} by {right}") })
    }

    fn order(&self, checker: &mut Checker, site: &TaskSite, parts: Parts) -> Option<Order> {
        checker.dimibot_order(site, self, parts).map(Order::Dimibot)
    }
}

/// The checks of the kind.
pub struct DimibotChecks;

pub const CHECKS: DimibotChecks = DimibotChecks;

impl KindChecks for DimibotChecks {
    fn facts(&self, device: &CheckedDevice, sink: &mut Sink) -> Option<KindFacts> {
        facts(device, sink).map(|facts| KindFacts::Dimibot(Rc::new(facts)))
    }

    fn check_continuity(&self, jobs: &mut [Job], sink: &mut Sink) {
        check_starts(jobs, sink);
    }

    fn add_idle_obstacles(&self, checker: &mut Checker, placed: &PlacedDevices, jobs: &mut [Job]) {
        checker.put_idle_robots(placed, jobs);
    }
}

/// The facts of a complete device.
fn facts(device: &CheckedDevice, sink: &mut Sink) -> Option<DimibotFacts> {
    let fields = &device.fields;
    let mut facts = DimibotFacts {
        left: fields.count("left")?,
        right: fields.count("right")?,
        stroke_um: fields.length_um("stroke")?,
        gain: fields.si("gain")?,
        pulse_voltage_v: fields.si("pulse_voltage")?,
        pulse_current_a: fields.si("pulse_current")?,
        pulse_duration_ns: fields.clock_ns("pulse_duration", sink)?,
        rest_ns: fields.clock_ns("rest", sink)?,
        repeatability_um: fields.length_um("repeatability")?,
        tip_radius_um: fields.length_um("tip_radius")?,
        home: LatticeCell::default(),
        simultaneous: simultaneous(fields).unwrap_or_default(),
    };
    if !fits(&facts, device, sink) {
        return None;
    }
    if let Some(home) = fields.get("home") {
        facts.home = stops::state(&Argument::plain(home), &facts, &device.name, sink)?;
    }
    warn_of_coarseness(&facts, device, sink);
    Some(facts)
}

/// Whether modules may be switched together, if the fields set it.
fn simultaneous(fields: &Accepted) -> Option<Simultaneous> {
    fields.word("simultaneous").and_then(Simultaneous::find)
}

/// Whether the workspace is small enough for exact geometry; a larger one is reported.
fn fits(facts: &DimibotFacts, device: &CheckedDevice, sink: &mut Sink) -> bool {
    let extent_um = 2.0 * facts.gain * facts.stroke_um * std::f64::consts::SQRT_2;
    let fits = extent_um <= dimibot::MAX_REACH_UM && facts.growth_um() <= dimibot::MAX_REACH_UM;
    if !fits {
        let limit = length(dimibot::MAX_REACH_UM);
        sink.push(errors::workspace_too_large(device.span, &length(extent_um.max(facts.growth_um())), &limit));
    }
    fits
}

fn warn_of_coarseness(facts: &DimibotFacts, device: &CheckedDevice, sink: &mut Sink) {
    let pitch_um = facts.pitch_um(Side::Left).min(facts.pitch_um(Side::Right));
    if facts.repeatability_um > pitch_um / 2.0 {
        let at = device.fields.get("repeatability").map_or(device.span, |field| field.span);
        let at = if at.file == device.span.file { at } else { device.span };
        sink.push(errors::cells_indistinguishable(at, &length(facts.repeatability_um), &length(pitch_um)));
    }
}

/// A length for a message.
fn length(um: f64) -> String {
    Quantity::length_um(um).to_string()
}

impl Checker<'_> {
    /// A task's body in the kind's own terms; `None` after an error.
    pub fn dimibot_order(&mut self, site: &TaskSite, facts: &DimibotFacts, parts: Parts) -> Option<DimibotOrder> {
        let judged = self.scene_met(site, |checker, scene| checker.obstacles(site, scene, facts));
        let order = order(facts, &judged.cover, parts, &site.device.name, self.sink);
        order.filter(|_| judged.is_whole)
    }

    fn obstacles(&mut self, site: &TaskSite, scene: Option<&CheckedScene>, facts: &DimibotFacts) -> DimibotScene {
        let Some(scene) = scene else {
            return DimibotScene { cover: SceneCover::of(Vec::new(), facts, None), is_whole: true };
        };
        let before = self.sink.errors();
        let frame = scene.frames.get(&site.place).cloned();
        let others = match frame {
            Some(_) => self.placed_beside(scene, site.place),
            None => Vec::new(),
        };
        let robot = SceneRobot { facts, name: &site.device.name, frame: frame.as_ref(), others: &others };
        let obstacles = scene.objects.iter().filter_map(|object| obstacle(object, &robot, self.sink));
        let cover = SceneCover::of(obstacles.collect(), facts, frame.map(|frame| frame.pose));
        DimibotScene { cover, is_whole: self.sink.errors() == before }
    }
}

/// A scene as judged for one device.
pub struct DimibotScene {
    pub cover: SceneCover,
    /// Whether all of its objects are possible.
    pub is_whole: bool,
}

/// The robot that a scene is judged with.
struct SceneRobot<'a> {
    facts: &'a DimibotFacts,
    name: &'a str,
    frame: Option<&'a DeviceFrame>,
    /// The other robots that the scene places.
    others: &'a [(Rc<DimibotFacts>, Pose)],
}

impl SceneRobot<'_> {
    fn pose(&self) -> Option<&Pose> {
        self.frame.map(|frame| &frame.pose)
    }

    /// Whether a body is out of reach of the tip of every other robot in the scene.
    fn is_out_of_all_reach(&self, body: &DimibotObstacleBody) -> bool {
        let is_outside_of = |(facts, pose): &(Rc<DimibotFacts>, Pose)| is_outside(&body.seen_from(Some(pose)), facts);
        self.others.iter().all(is_outside_of)
    }
}

fn obstacle(object: &SceneObject, robot: &SceneRobot, sink: &mut Sink) -> Option<DimibotObstacle> {
    let facts = robot.facts;
    if dimibot::VOCABULARY.noun(&object.noun).is_none() {
        sink.push(of_other_kind(object, &dimibot::VOCABULARY));
        return None;
    }
    if let Some(shape) = object.shape.as_ref().filter(|shape| !ShapeForm::SOLID.contains(&shape.value.form)) {
        let known: Vec<&str> = ShapeForm::SOLID.iter().map(|form| form.name()).collect();
        sink.push(errors::shape_of_other_kind(shape.span, shape.value.form.name(), &object.noun, "dimibot", &known));
        return None;
    }
    if let Some(frame) = robot.frame.filter(|_| stands_on_cells(object)) {
        let at = object.at.as_ref().map_or(object.span, |at| at.span);
        sink.push(errors::cell_beside_frame(at, &object.name, robot.name, frame.span));
        return None;
    }
    let body = match &object.shape {
        Some(shape) if shape.value.form == ShapeForm::Cells => block(object, &shape.value.fields, facts, sink)?,
        Some(shape) => solid(object, shapes::in_plane(&shape.value)?, robot, sink)?,
        None => point(object, robot, sink)?,
    };
    let obstacle = DimibotObstacle { name: object.name.clone(), body, span: object.span };
    if is_outside(&obstacle.body.seen_from(robot.pose()), facts) {
        match robot.frame {
            Some(_) if robot.is_out_of_all_reach(&obstacle.body) => {
                sink.push(errors::obstacle_out_of_all_reach(object.span, &object.name));
            }
            Some(_) => {}
            None => sink.push(errors::obstacle_outside(object.span, &object.name, robot.name)),
        }
        return None;
    }
    Some(obstacle)
}

/// Whether an object's place is given in cells.
fn stands_on_cells(object: &SceneObject) -> bool {
    let is_block = object.shape.as_ref().is_some_and(|shape| shape.value.form == ShapeForm::Cells);
    is_block || object.at.as_ref().is_some_and(|at| whole_cell(&at.value).is_some())
}

/// The whole numbers of a cell, which may lie outside the lattice.
fn whole_cell(value: &Value) -> Option<[i64; 2]> {
    match value {
        Value::Point(point) if point.len() == 2 => Some([whole(point[0])?, whole(point[1])?]),
        _ => None,
    }
}

fn point(object: &SceneObject, robot: &SceneRobot, sink: &mut Sink) -> Option<DimibotObstacleBody> {
    match &object.at {
        Some(at) => match whole_cell(&at.value) {
            Some([x, y]) => Some(clipped([x, y], [x, y], robot.facts)),
            None => solid(object, Shape::Point, robot, sink),
        },
        None => Some(DimibotObstacleBody::Solid { shape: Shape::Point, pose: Pose::at(0.0, 0.0) }),
    }
}

fn block(
    object: &SceneObject,
    fields: &Accepted,
    facts: &DimibotFacts,
    sink: &mut Sink,
) -> Option<DimibotObstacleBody> {
    let corner = |name: &str| fields.get(name).and_then(|field| whole_cell(&field.value));
    let (Some(from), Some(to)) = (corner("from"), corner("to")) else {
        let at = fields.values().next()?;
        sink.push(errors::wrong_place(at.span, &at.value, "whole cells"));
        return None;
    };
    let shift = match &object.at {
        None => [0, 0],
        Some(at) => match whole_cell(&at.value) {
            Some(shift) => shift,
            None => {
                sink.push(errors::wrong_place(at.span, &at.value, "a cell for a block of cells"));
                return None;
            }
        },
    };
    let low = [0, 1].map(|axis| from[axis].min(to[axis]).saturating_add(shift[axis]));
    let high = [0, 1].map(|axis| from[axis].max(to[axis]).saturating_add(shift[axis]));
    Some(clipped(low, high, facts))
}

/// The part of a block on the lattice; a block that misses it entirely gets a `from` above its `to`.
fn clipped(low: [i64; 2], high: [i64; 2], facts: &DimibotFacts) -> DimibotObstacleBody {
    let last = [facts.cells(Side::Left), facts.cells(Side::Right)].map(|cells| i64::from(cells) - 1);
    let missed = (0..2).any(|axis| high[axis] < 0 || low[axis] > last[axis]);
    if missed {
        return DimibotObstacleBody::Cells { from: LatticeCell { x: 1, y: 1 }, to: LatticeCell { x: 0, y: 0 } };
    }
    let clip = |at: [i64; 2]| LatticeCell { x: at[0].clamp(0, last[0]) as u32, y: at[1].clamp(0, last[1]) as u32 };
    DimibotObstacleBody::Cells { from: clip(low), to: clip(high) }
}

fn solid(object: &SceneObject, shape: Shape, robot: &SceneRobot, sink: &mut Sink) -> Option<DimibotObstacleBody> {
    let facts = robot.facts;
    let pose = match &object.at {
        None => Pose::at(0.0, 0.0),
        Some(at) => match (shapes::pose_of(&at.value), whole_cell(&at.value)) {
            (Some(pose), _) => pose,
            (None, Some([x, y])) => {
                Pose::at(x as f64 * facts.pitch_um(Side::Left), y as f64 * facts.pitch_um(Side::Right))
            }
            (None, None) => {
                sink.push(errors::wrong_place(at.span, &at.value, "a cell, a place or a pose"));
                return None;
            }
        },
    };
    let own = robot.pose().map_or(pose, |frame| pose.seen_from(frame));
    if !shapes::within_extent(&shape, &pose) || !shapes::within_extent(&shape, &own) {
        sink.push(errors::shape_too_large(object.span, &length(MAX_EXTENT_UM)));
        return None;
    }
    Some(DimibotObstacleBody::Solid { shape, pose })
}

/// Whether a body can never touch the tip, by its bounding box.
fn is_outside(body: &DimibotObstacleBody, facts: &DimibotFacts) -> bool {
    match body {
        DimibotObstacleBody::Cells { from, to } => from.x > to.x,
        DimibotObstacleBody::Solid { shape, pose } => {
            let Some([low_um, high_um]) = bounds_um(shape, pose, facts.growth_um()) else { return false };
            let last_um = facts.place_um(last_cell(facts));
            (0..2).any(|axis| low_um[axis] > last_um[axis] || high_um[axis] < 0.0)
        }
    }
}

/// The cell of the word with all modules at 1.
fn last_cell(facts: &DimibotFacts) -> LatticeCell {
    LatticeCell { x: facts.cells(Side::Left) - 1, y: facts.cells(Side::Right) - 1 }
}

/// Lower and upper corner of the bounding box of a grown body; `None` for an impossible shape.
fn bounds_um(shape: &Shape, pose: &Pose, growth_um: f64) -> Option<[[f64; 2]; 2]> {
    let grown = shape.grown(pose, growth_um).ok()?;
    let corners = grown.core.corners();
    let axis = |axis: usize| corners.iter().map(move |corner| corner[axis]);
    let low_um = [0, 1].map(|at| axis(at).fold(f64::INFINITY, f64::min) - grown.radius_um);
    let high_um = [0, 1].map(|at| axis(at).fold(f64::NEG_INFINITY, f64::max) + grown.radius_um);
    Some([low_um, high_um])
}

/// Distance of a cell's place from a body's rim; negative inside.
fn clearance_um(shape: &Shape, pose: &Pose, cell: LatticeCell, facts: &DimibotFacts) -> f64 {
    let [x_um, y_um] = facts.place_um(cell);
    let at = Point2::new(x_um, y_um);
    let body = shape.grown(pose, 0.0);
    body.map_or(f64::INFINITY, |body| distance::segment_core([at, at], &body.core) - body.radius_um)
}

fn order(
    facts: &DimibotFacts,
    cover: &SceneCover,
    parts: Parts,
    device: &str,
    sink: &mut Sink,
) -> Option<DimibotOrder> {
    let precision = precision(&parts.settings, facts, sink);
    let objective = objective(parts.objective.as_ref().map(|objective| objective.value))?;
    let simultaneous = simultaneous(&parts.settings).unwrap_or(facts.simultaneous);
    let planner = planner(&parts, (objective, simultaneous), sink);
    warn_of_simultaneous(&parts.settings, objective, sink);
    let mut judge = stops::StopJudge::new(facts, cover, device, precision.flatten(), sink);
    let start = parts.start.as_ref().map(|start| judge.start(start));
    let steps: Vec<Option<DimibotStep>> = parts.steps.into_iter().map(|step| judge.step(step)).collect();
    let steps: Option<Vec<DimibotStep>> = steps.into_iter().collect();
    Some(DimibotOrder {
        facts: facts.clone(),
        frame: cover.frame,
        obstacles: Arc::clone(&cover.obstacles),
        objective,
        planner: planner?,
        simultaneous,
        precision_um: precision?,
        start: match start {
            None => None,
            Some(start) => Some(start?),
        },
        steps: steps?,
    })
}

/// The precision of a task in micrometres, or `Some(None)` if it sets none; `None` after an error.
fn precision(settings: &Accepted, facts: &DimibotFacts, sink: &mut Sink) -> Option<Option<f64>> {
    let Some(field) = settings.get("precision") else { return Some(None) };
    let Value::Quantity(asked) = field.value else { return None };
    let precision_um = asked.in_unit("um");
    if precision_um < facts.repeatability_um {
        sink.push(errors::precision_beyond_robot(field.span, &length(precision_um), &length(facts.repeatability_um)));
        return None;
    }
    Some(Some(precision_um))
}

/// The objective that `minimize` names; distance by default.
fn objective(name: Option<&str>) -> Option<DimibotObjective> {
    name.map_or(Some(DimibotObjective::Distance), DimibotObjective::find)
}

/// Warns of `simultaneous: safe` with an objective other than time: switching several modules at once saves time alone.
fn warn_of_simultaneous(settings: &Accepted, objective: DimibotObjective, sink: &mut Sink) {
    let is_safe = simultaneous(settings) == Some(Simultaneous::Safe);
    if let Some(field) = settings.get("simultaneous").filter(|_| is_safe && objective != DimibotObjective::Time) {
        sink.push(errors::simultaneous_in_vain(field.span, objective.name()));
    }
}

/// The method and budget of a task; `None` if a published method is asked for a feature that it lacks.
fn planner(parts: &Parts, asked: (DimibotObjective, Simultaneous), sink: &mut Sink) -> Option<DimibotPlanner> {
    let expansions = parts.expansions()?;
    let Some(planner) = &parts.planner else {
        return Some(DimibotPlanner { method: DimibotMethod::StagedAstar, expansions });
    };
    let method = DimibotMethod::find(planner.value.name)?;
    if let Some((what, span)) = beyond(method, parts, asked, planner.span) {
        sink.push(errors::planner_cannot(planner.span, planner.value.name, what, span));
        return None;
    }
    Some(DimibotPlanner { method, expansions })
}

/// A feature that the task asks of a published method but that the method lacks, and where; Tweeze's own planner has
/// all.
fn beyond(
    method: DimibotMethod,
    parts: &Parts,
    asked: (DimibotObjective, Simultaneous),
    chosen: Span,
) -> Option<(&'static str, Span)> {
    if method == DimibotMethod::StagedAstar {
        return None;
    }
    let is_visit = |step: &&tasks::VocabularyStep| matches!(&step.action, tasks::VocabularyAction::Verb(call) if call.verb.name == DimibotVerb::Visit.name());
    if let Some(visit) = parts.steps.iter().find(is_visit) {
        return Some(("order the places of a `visit`", visit.span));
    }
    let span = parts.settings.get("simultaneous").map_or(chosen, |setting| setting.span);
    (asked == (DimibotObjective::Time, Simultaneous::Safe)).then_some(("switch several modules in one pulse", span))
}

/// Where a robot stands after a task, as far as known before planning.
#[derive(Clone, Copy)]
enum TipPosition {
    At(LatticeCell),
    /// After a `visit`, whose order the planner chooses.
    Unknown,
}

/// Checks that each `start at` is where the device's last task left it, as far as known before planning, and that a
/// task without one does not begin on an obstacle.
fn check_starts(jobs: &[Job], sink: &mut Sink) {
    let mut positions: BTreeMap<&str, TipPosition> = BTreeMap::new();
    for job in jobs {
        let Some(order) = DimibotOrder::of(&job.order) else { continue };
        let before = positions.get(job.device.as_str()).copied();
        if let (Some(start), Some(TipPosition::At(cell))) = (order.start, before)
            && start.value != cell
        {
            sink.push(order.start_disagrees(start, cell, job));
        }
        let begins = order.start.map(|start| TipPosition::At(start.value)).or(before);
        let begins = begins.unwrap_or(TipPosition::At(order.facts.home));
        if let (None, TipPosition::At(cell)) = (order.start, begins) {
            let body = |index: usize| order.obstacles[index].body.seen_from(order.frame.as_ref());
            let covers = |index: &usize| cover::covers(&body(*index), cell, &order.facts);
            let covering: Vec<usize> = (0..order.obstacles.len()).filter(covers).collect();
            if !covering.is_empty() {
                let initial =
                    if before.is_some() { InitialCell::AfterLastTask(cell) } else { InitialCell::AtHome(cell) };
                sink.push(order.start_covered(initial, &covering, job));
            }
        }
        let ends = end_of(order).unwrap_or(begins);
        positions.insert(&job.device, ends);
    }
}

/// Where a task's steps end; `None` if they move nothing.
fn end_of(order: &DimibotOrder) -> Option<TipPosition> {
    order.steps.iter().rev().find_map(|step| match &step.action {
        DimibotAction::Move(stops) => stops.last().map(|stop| TipPosition::At(stop.cell)),
        DimibotAction::Visit(_) => Some(TipPosition::Unknown),
        DimibotAction::Wait(_) => None,
    })
}

#[cfg(test)]
mod tests;
