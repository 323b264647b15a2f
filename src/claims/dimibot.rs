//! Claims of a task on a DiMiBot.

use super::{Job, KindOrder, Order};
use crate::device::Kind;
use crate::device::dimibot;
pub use crate::device::dimibot::{DimibotMethod, DimibotObjective};
use crate::diagnostic::{Code, Diagnostic};
use crate::geometry::shape::{Pose, Shape};
use crate::quantity::{Quantity, to_decimals};
use crate::real::Real;
use crate::source::{Span, Spanned};
use nalgebra::Point2;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;
use std::sync::Arc;

/// Most obstacles that a message names.
const SHOWN_OBSTACLES: usize = 8;

/// A task of a DiMiBot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DimibotOrder {
    pub facts: dimibot::DimibotFacts,
    /// The robot's frame R1 in its scene; `None` if the scene is in the robot's own coordinates.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<Pose>,
    /// In the scene's coordinates. Shared by all tasks of one device in one scene.
    pub obstacles: Arc<Vec<DimibotObstacle>>,
    pub objective: DimibotObjective,
    pub planner: DimibotPlanner,
    pub simultaneous: dimibot::Simultaneous,
    /// Greatest distance of a position from its cell; `None` accepts any nearest cell.
    pub precision_um: Option<f64>,
    /// `start at`, if the task has it; otherwise the robot starts where its last task left it, or at home.
    pub start: Option<Spanned<dimibot::LatticeCell>>,
    pub steps: Vec<DimibotStep>,
}

impl KindOrder for DimibotOrder {
    fn kind(&self) -> Kind {
        Kind::Dimibot
    }

    fn frame(&self) -> Option<Pose> {
        self.frame
    }

    fn taken_for_places(&self) -> Vec<(Span, String)> {
        self.stops().filter_map(|stop| Some((stop.span, self.taken_for(stop)?))).collect()
    }
}

/// Cell of the robot at the beginning of a task without `start at`, and why it is there.
#[derive(Debug, Clone, Copy)]
pub enum InitialCell {
    AtHome(dimibot::LatticeCell),
    /// Where its last task ended.
    AfterLastTask(dimibot::LatticeCell),
}

impl DimibotOrder {
    /// A job's order, if it is one of this kind.
    pub fn of(order: &Order) -> Option<&DimibotOrder> {
        if let Order::Dimibot(order) = order { Some(order) } else { None }
    }

    /// E0507: the task starts at one cell by `start at`, and its robot is at another. The checker finds this if the
    /// previous task ends at a known cell, the planner after a `visit`.
    pub fn start_disagrees(
        &self,
        start: Spanned<dimibot::LatticeCell>,
        stands: dimibot::LatticeCell,
        job: &Job,
    ) -> Diagnostic {
        let show = |cell: dimibot::LatticeCell| format!("{cell}, {}", self.facts.word_text(cell));
        let (asked, stands, device) = (show(start.value), show(stands), &job.device);
        Diagnostic::new(Code::E0507, format!("the task starts at {asked}, but `{device}` is at {stands} by then"))
            .label(start.span, "not where the robot is")
            .label_elsewhere(job.run_span, start.span, "run here")
            .help(format!("leave `start at` out, or start where the last task of `{device}` ended: {stands}"))
    }

    /// E0505: the robot is on obstacles, given by their indices, when the task begins. Reported by the stage that
    /// knows the cell, as with [`Self::start_disagrees`].
    pub fn start_covered(&self, initial: InitialCell, obstacles: &[usize], job: &Job) -> Diagnostic {
        let (cell, help) = match initial {
            InitialCell::AtHome(cell) => (cell, "write `start at` with a free cell, or give the device another `home`"),
            InitialCell::AfterLastTask(cell) => (cell, "end the task before at a cell that is free in this scene"),
        };
        let shown = || obstacles.iter().take(SHOWN_OBSTACLES).map(|index| &self.obstacles[*index]);
        let names: Vec<String> = shown().map(|obstacle| format!("`{}`", obstacle.name)).collect();
        let title = format!("task `{}` begins at {cell}, on obstacle {}", job.task, names.join(", "));
        let diagnostic = Diagnostic::new(Code::E0505, title).label(job.run_span, format!("begins at {cell}"));
        shown()
            .fold(diagnostic, |diagnostic, obstacle| {
                diagnostic.label_elsewhere(obstacle.span, job.run_span, "the obstacle")
            })
            .help(help)
    }
}

impl DimibotOrder {
    /// Converts a position from the robot's own frame to the scene's coordinates.
    pub fn in_scene_um(&self, own_um: [f64; 2]) -> [f64; 2] {
        in_scene_um(own_um, self.frame.as_ref())
    }

    /// All positions to be reached, in the order of the steps.
    pub fn stops(&self) -> impl Iterator<Item = &DimibotStop> {
        self.steps.iter().flat_map(|step| match &step.action {
            DimibotAction::Move(stops) | DimibotAction::Visit(stops) => stops.as_slice(),
            DimibotAction::Wait(_) => &[],
        })
    }

    /// The cell chosen for the position of a stop, `cell (7, 14), 225.1 nm off`; `None` if the program gives a cell.
    pub fn taken_for(&self, stop: &DimibotStop) -> Option<String> {
        let off_um = to_decimals(self.off_um(stop)?, 4);
        Some(format!("cell {}, {} off", stop.cell, Quantity::length_um(off_um)))
    }

    /// Distance between the cell of a stop and the requested position; `None` if the program gives a cell.
    pub fn off_um(&self, stop: &DimibotStop) -> Option<f64> {
        let Asked::Place([x_um, y_um]) = stop.asked else { return None };
        let [cell_x_um, cell_y_um] = self.in_scene_um(self.facts.place_um(stop.cell));
        Some((cell_x_um - x_um).hypotenuse(cell_y_um - y_um))
    }
}

/// Converts a position from the robot's own frame to the scene's coordinates.
pub fn in_scene_um(own_um: [f64; 2], frame: Option<&Pose>) -> [f64; 2] {
    match frame {
        Some(frame) => (frame.isometry() * Point2::from(own_um)).coords.into(),
        None => own_um,
    }
}

/// Converts a position from the scene's coordinates to the robot's own frame.
pub fn in_robot_um(scene_um: [f64; 2], frame: Option<&Pose>) -> [f64; 2] {
    match frame {
        Some(frame) => frame.isometry().inverse_transform_point(&Point2::from(scene_um)).coords.into(),
        None => scene_um,
    }
}

/// Search method and budget; all methods agree on the cost of the plan.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct DimibotPlanner {
    pub method: DimibotMethod,
    /// Most states that one search may expand.
    pub expansions: u64,
}

/// An obstacle for the tip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DimibotObstacle {
    /// The name in the scene.
    pub name: String,
    pub body: DimibotObstacleBody,
    #[serde(skip)]
    pub span: Span,
}

/// The extent of an obstacle.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DimibotObstacleBody {
    /// Lattice cells, corners included, as in the paper: not grown. `from` is the lower corner on both axes.
    Cells { from: dimibot::LatticeCell, to: dimibot::LatticeCell },
    /// A body in the workspace, to be grown by tip radius and repeatability.
    Solid { shape: Shape, pose: Pose },
}

impl DimibotObstacleBody {
    /// The body in the coordinates of the robot with this frame. Cells are always in the robot's own coordinates.
    pub fn seen_from(&self, frame: Option<&Pose>) -> Cow<'_, DimibotObstacleBody> {
        match (self, frame) {
            (DimibotObstacleBody::Solid { shape, pose }, Some(frame)) => {
                Cow::Owned(DimibotObstacleBody::Solid { shape: shape.clone(), pose: pose.seen_from(frame) })
            }
            (DimibotObstacleBody::Solid { .. }, None) | (DimibotObstacleBody::Cells { .. }, Some(_) | None) => {
                Cow::Borrowed(self)
            }
        }
    }
}

/// One step of a DiMiBot's task.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DimibotStep {
    pub action: DimibotAction,
    #[serde(skip)]
    pub span: Span,
}

impl DimibotStep {
    /// Its stops; empty for a wait.
    pub fn stops(&self) -> &[DimibotStop] {
        match &self.action {
            DimibotAction::Move(stops) | DimibotAction::Visit(stops) => stops,
            DimibotAction::Wait(_) => &[],
        }
    }
}

/// Action of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DimibotAction {
    /// Through the stops in this order; the last one is the goal.
    Move(Vec<DimibotStop>),
    /// Through all stops in the best order; the plan chooses where it ends.
    Visit(Vec<DimibotStop>),
    /// Nothing is switched for this time, in nanoseconds.
    Wait(u64),
}

/// A position to be reached.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DimibotStop {
    pub asked: Asked,
    /// The cell chosen for it.
    pub cell: dimibot::LatticeCell,
    #[serde(skip)]
    pub span: Span,
}

/// The goal as written in the program.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Asked {
    Cell,
    /// A position in the scene's coordinates; without a frame these are the robot's own, from word 0 along the axes
    /// of R1.
    Place([f64; 2]),
}
