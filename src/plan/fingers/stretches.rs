//! Planning of a task stretch by stretch, each stretch from a first grasp to a release as one problem; then the motions
//! of the fingers.
//!
//! After each stretch the part stands where its turns and translations have carried it. A stretch without a plan leaves
//! the later ones without a start, so the job ends there.

use super::course::{follow, reconfigurations};
use super::graph::{
    self, Estimator, FarthestRoute, Grasp, GraspAnswer, GraspCosts, GraspNode, GraspPath, GraspRequest, GraspSearchEnd,
    GraspSearchLimits, Start,
};
use super::mechanics::NoTables;
use super::routes::{Holding, LegEnd, RouteTurn, Routes, routes, takes_hold};
use super::sections::{LoadEvaluation, RollingCheck, Sections};
use super::tip_motion::{self, FingerAct, FingersCourse, TipMotionError};
use super::{FingersMotion, HeldGrasp, Stance};
use crate::claims::Job;
use crate::claims::fingers::{FingersAction, FingersOrder, FingersPlanner, FingersTurn};
use crate::device::fingers::{DEFAULT_GRASP_EVALUATIONS, FingersObjective, FingersOutcome, Plane};
use crate::diagnostic::Remark;
use crate::plan::search::{GaveUp, SearchBudget};
use crate::plan::{Optimality, Plan};
use crate::quantity::{digits, to_decimals};
use nalgebra::{Quaternion, UnitQuaternion};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::ops::Range;
use std::rc::Rc;

/// Primary criterion of a path.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FirstCriterion {
    /// Effort first, then the number of reconfigurations.
    Effort,
    /// Reconfigurations first, then the rolling.
    Reconfigurations,
}

/// Criteria by which the path of a stretch is chosen.
#[derive(Debug, Clone, Copy)]
pub struct PathChoice {
    pub first: FirstCriterion,
    /// Limit on reconfigurations; `None`: unlimited.
    pub gaits: Option<u32>,
}

/// Budget of looks for planning one task.
pub fn most_looks(order: &FingersOrder) -> u64 {
    order.looks.unwrap_or(u64::from(DEFAULT_GRASP_EVALUATIONS))
}

/// Request for a plan.
#[derive(Clone)]
pub struct TaskRequest<'a> {
    pub job: &'a Job,
    pub order: &'a FingersOrder,
    /// Current stance; `None` before the device's first task.
    pub stance: Option<&'a Stance>,
    pub open: LeftOpen,
    pub first: FirstCriterion,
    /// Limit on the reconfigurations of each stretch; unlimited where it is `None` or missing.
    pub gaits: Vec<Option<u32>>,
}

/// Parts of a stance that earlier tasks left open: other plans for them, as good as the chosen one, end differently.
#[derive(Debug, Clone, Copy, Default)]
pub struct LeftOpen {
    /// The grasp, which no task names.
    pub grasp: bool,
    pub orientation: bool,
}

impl LeftOpen {
    pub fn is_any(self) -> bool {
        self.grasp || self.orientation
    }
}

/// A plan whose limits have not been checked yet.
pub struct PlannedTask {
    /// Its proof refers to the primary criterion.
    pub plan: Plan<FingersMotion>,
    /// The stance after it.
    pub end: Stance,
    pub open: LeftOpen,
    pub stretches: Vec<TaskStretch>,
}

/// Figures of one stretch of a plan.
#[derive(Debug, Clone, Copy)]
pub struct TaskStretch {
    /// The effort, in units of [`costs`].
    pub cost: u64,
    pub gaits: u64,
    /// Whether the path is proven optimal by the primary criterion, within the given limit.
    pub is_best: bool,
}

impl PlannedTask {
    /// Total number of reconfigurations.
    pub fn gaits(&self) -> u64 {
        self.stretches.iter().map(|stretch| stretch.gaits).sum()
    }
}

/// Start of a stretch, and its steps.
pub struct StretchStart {
    pub held: Option<Holding>,
    /// Orientation of the part.
    pub orientation: UnitQuaternion<f64>,
    pub steps: Range<usize>,
}

/// Reason why there is no plan; `at` is the step of the order at which planning ended.
pub enum NoTaskPlan {
    /// The stretch has no path.
    Blocked { at: usize, blocked: FarthestRoute, planned: Routes, begins: StretchStart },
    /// The stretch has no path from the grasp that the task before left, though it may have one from another: `from`,
    /// if one is known.
    OtherGrasp { at: usize, from: Option<Grasp> },
    /// The search for a path gave up.
    GaveUp { at: usize, end: GraspSearchEnd },
    /// A section has no tables.
    NoTables { at: usize, none: NoTables },
    /// The grasp with which a stretch begins, and which it does not change, does not hold under the load. `open` states
    /// what earlier tasks left open.
    GraspFailsUnderLoad { at: usize, held: Holding, orientation: UnitQuaternion<f64>, open: LeftOpen },
    /// No order was found in which the fingers can leave the grasp at a release.
    NoRelease { at: usize },
    /// The fingers cannot follow the path.
    NoMotion(TipMotionError),
}

impl NoTaskPlan {
    /// Whether it is proven that the order has no plan.
    pub fn is_proven(&self, order: &FingersOrder) -> bool {
        match self {
            NoTaskPlan::Blocked { planned, .. } => {
                planned.left_out.is_none() && order.planner != FingersPlanner::GreedyDecomposition
            }
            NoTaskPlan::GraspFailsUnderLoad { open, .. } => !open.is_any(),
            NoTaskPlan::OtherGrasp { .. }
            | NoTaskPlan::GaveUp { .. }
            | NoTaskPlan::NoTables { .. }
            | NoTaskPlan::NoRelease { .. }
            | NoTaskPlan::NoMotion(_) => false,
        }
    }
}

/// Plans a task; without a plan, the error gives the reason.
pub fn plan_task(sections: &mut Sections, request: &TaskRequest) -> Result<PlannedTask, Box<NoTaskPlan>> {
    let TaskRequest { order, stance, .. } = *request;
    let start = stance.cloned().unwrap_or_else(|| sections.hand().home(order.part.position_um));
    let mut tally = PartialTaskPlan::of(request, start.clone());
    for (index, stretch) in stretches(order).into_iter().enumerate() {
        tally.plan_stretch(sections, index, stretch)?;
    }
    let course = FingersCourse { start, steps: tally.acts };
    let motion = sections.hand().motion(&course).map_err(NoTaskPlan::NoMotion)?;
    let end = tip_motion::end(&motion);
    if let Some(share) = rolling_reserve_percent(order).filter(|_| tally.sums.cost > 0) {
        let text = format!("{share} % of friction and forces while it rolls (`rolling_reserve`)");
        tally.sums.remarks.push(Remark { subject: "kept back".to_owned(), text });
    }
    let (stretches, open) = (std::mem::take(&mut tally.stretches), tally.open);
    Ok(PlannedTask { plan: tally.sums.plan(order, motion), end, open, stretches })
}

/// Reserve while tips roll, in percent; `None` if it is zero or has no effect, since every grasp holds with adhesion
/// and without a load.
pub fn rolling_reserve_percent(order: &FingersOrder) -> Option<String> {
    let facts = &order.facts;
    let counts = facts.rolling_reserve > 0.0 && (facts.sticking_un() == 0.0 || order.load_un != [0.0; 3]);
    counts.then(|| digits(facts.rolling_reserve * 100.0))
}

/// The steps of an order, split after each release.
pub fn stretches(order: &FingersOrder) -> Vec<Range<usize>> {
    let mut stretches = Vec::new();
    let mut begin = 0;
    for (step, _) in order.steps.iter().enumerate().filter(|(_, step)| step.action == FingersAction::Release) {
        stretches.push(begin..step + 1);
        begin = step + 1;
    }
    if begin < order.steps.len() {
        stretches.push(begin..order.steps.len());
    }
    stretches
}

/// Partial plan while its stretches are planned.
struct PartialTaskPlan<'a> {
    request: &'a TaskRequest<'a>,
    order: &'a FingersOrder,
    acts: Vec<Vec<FingerAct>>,
    held: Option<Holding>,
    orientation: UnitQuaternion<f64>,
    /// Parts of the stance that the path up to here left open.
    open: LeftOpen,
    sums: Sums,
    stretches: Vec<TaskStretch>,
}

/// Sums over the stretches.
struct Sums {
    /// The effort, in units of [`costs`].
    cost: u64,
    /// Lower bound on the effort, in the same units; 0 if reconfigurations come first.
    bound: u64,
    /// Whether each path is optimal by its primary criterion.
    is_best: bool,
    reconfigurations: u64,
    remarks: Vec<Remark>,
}

impl<'a> PartialTaskPlan<'a> {
    fn of(request: &'a TaskRequest, start: Stance) -> PartialTaskPlan<'a> {
        let order = request.order;
        let HeldGrasp { grasp, plane, orientation: [w, x, y, z], .. } = start.hold;
        let held = Grasp::of(&grasp).filter(|grasp| grasp.holding() > 0);
        PartialTaskPlan {
            request,
            order,
            acts: vec![Vec::new(); order.steps.len()],
            held: held.map(|grasp| Holding { grasp, plane }),
            orientation: UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
            open: request.open,
            stretches: Vec::new(),
            sums: Sums { cost: 0, bound: 0, is_best: true, reconfigurations: 0, remarks: Vec::new() },
        }
    }

    /// Plans a stretch and appends its acts.
    fn plan_stretch(
        &mut self,
        sections: &mut Sections,
        index: usize,
        stretch: Range<usize>,
    ) -> Result<(), Box<NoTaskPlan>> {
        self.stretches.push(TaskStretch { cost: 0, gaits: 0, is_best: true });
        if stretch.clone().any(|step| takes_hold(&self.order.steps[step].action)) {
            self.turn(sections, index, stretch.clone())?;
        } else if let Some(held) =
            self.held.filter(|_| self.order.steps[stretch.start].action != FingersAction::Release)
            && !sections.bears(held, self.orientation)
        {
            let (at, orientation, open) = (stretch.start, self.orientation, self.open);
            return Err(Box::new(NoTaskPlan::GraspFailsUnderLoad { at, held, orientation, open }));
        }
        for step in stretch {
            match &self.order.steps[step].action {
                FingersAction::Translate(by_um) => self.acts[step].push(FingerAct::Translate(*by_um)),
                FingersAction::Wait(duration_ns) => self.acts[step].push(FingerAct::Wait(*duration_ns)),
                FingersAction::Release => self.release(sections, step)?,
                FingersAction::Grasp(_) | FingersAction::Rotate { .. } | FingersAction::Orient { .. } => (),
            }
        }
        Ok(())
    }

    /// Finds the cheapest path through the turns of a stretch.
    fn turn(&mut self, sections: &mut Sections, index: usize, stretch: Range<usize>) -> Result<(), Box<NoTaskPlan>> {
        let mut planned = routes(self.order, stretch.clone(), self.held);
        // Under a load, other plans of earlier tasks might have left the part in an orientation in which it is easier
        // to hold.
        if self.open.orientation && self.order.load_un != [0.0; 3] {
            let least = least_steps(&planned);
            planned.left_out = Some(planned.left_out.map_or(least, |known| known.min(least)));
        }
        let chosen = PathChoice { first: self.request.first, gaits: self.request.gaits.get(index).copied().flatten() };
        let way = match sound(self.order, sections, &planned, self.orientation, chosen) {
            Ok(GraspAnswer::Found(way)) if self.is_stuck_after(sections, &planned, &way, stretch.end) => {
                let released = planned.released().map(|released| {
                    let answer = sound(self.order, sections, &released, self.orientation, chosen);
                    (released, answer)
                });
                match released {
                    Some((released, Ok(GraspAnswer::Found(other)))) => {
                        planned = released;
                        // The bound covers all grasps with which the stretch may end.
                        GraspPath { bound: way.bound, ..other }
                    }
                    // The release reports that fingers cannot leave the first path's grasp.
                    Some(_) | None => way,
                }
            }
            Ok(GraspAnswer::Found(way)) => way,
            Ok(GraspAnswer::Impossible(_)) if let Some(other) = self.other_grasp(sections, &planned, chosen) => {
                return Err(Box::new(other));
            }
            Ok(GraspAnswer::Impossible(blocked)) => {
                let at = step_of(&planned, blocked.route, blocked.leg);
                let begins = StretchStart { held: self.held, orientation: self.orientation, steps: stretch };
                return Err(Box::new(NoTaskPlan::Blocked { at, blocked, planned, begins }));
            }
            Ok(GraspAnswer::GaveUp(end)) => {
                return Err(Box::new(NoTaskPlan::GaveUp { at: step_of(&planned, 0, 0), end }));
            }
            Err(none) => return Err(Box::new(NoTaskPlan::NoTables { at: stretch.start, none })),
        };
        let way = self.held_against_any(sections, &planned, way, chosen);
        let route = &planned.routes[way.route];
        let is_grasp = |step: &usize| matches!(self.order.steps[*step].action, FingersAction::Grasp(_));
        let first = route.first().map_or(stretch.start, |turning| turning.step);
        let begins = stretch.clone().find(is_grasp).map_or(first, |grasp| grasp.min(first));
        let fingers = self.order.facts.fingers as usize;
        follow(&mut self.acts, route, &way, self.held.is_none().then_some(begins), fingers);
        let cost = effort(self.order, &way);
        self.sums.cost += cost;
        let (bound, is_best) = match self.request.first {
            FirstCriterion::Effort => {
                let bound = planned.left_out.map_or(way.bound, |steps| way.bound.min(2 * ROLL * steps));
                (bound, bound >= way.cost)
            }
            FirstCriterion::Reconfigurations => (0, planned.left_out.is_none() && way.bound >= way.cost),
        };
        self.sums.bound += bound;
        self.sums.is_best &= is_best;
        self.sums.reconfigurations += reconfigurations(&way);
        self.stretches[index] = TaskStretch { cost, gaits: reconfigurations(&way), is_best };
        let is_free = |step: usize| matches!(self.order.steps[step].action, FingersAction::Orient { .. });
        let has_free = route.iter().any(|turning| is_free(turning.step));
        self.open.orientation |= has_free && planned.routes.len() > 1;
        if has_free {
            let turning = route.iter().filter(|turning| turning.end != LegEnd::Released);
            let turns: Vec<String> = turning.map(|turning| turn_text(sections, turning.turn)).collect();
            self.sums.remarks.push(Remark { subject: "turns".to_owned(), text: turns.join(", ") });
        }
        for turning in route {
            self.orientation = sections.turned(self.orientation, turning.turn);
        }
        let last = way.legs.last().and_then(|nodes| nodes.last());
        self.open.grasp = !route.last().is_some_and(|turning| matches!(turning.end, LegEnd::Pinned(_)));
        self.held =
            route.last().zip(last).map(|(turning, last)| Holding { grasp: last.grasp, plane: turning.turn.plane });
        Ok(())
    }

    /// Answer for a stretch that may begin with any grasp; `None` if no grasp is held, if a task names the held one, or
    /// for the greedy planner.
    fn begun_with_any_grasp(
        &self,
        sections: &mut Sections,
        planned: &Routes,
        chosen: PathChoice,
    ) -> Option<Result<GraspAnswer, NoTables>> {
        let is_chosen = self.held.is_some() && self.open.grasp;
        let is_exact = self.order.planner != FingersPlanner::GreedyDecomposition;
        (is_chosen && is_exact).then(|| {
            let planned = Routes { start: None, ..planned.clone() };
            sound(self.order, sections, &planned, self.orientation, chosen)
        })
    }

    /// Result for a stretch without a path from the held grasp, if another grasp at its beginning may have one.
    fn other_grasp(&self, sections: &mut Sections, planned: &Routes, chosen: PathChoice) -> Option<NoTaskPlan> {
        let from = match self.begun_with_any_grasp(sections, planned, chosen)? {
            Ok(GraspAnswer::Impossible(_)) => return None,
            Ok(GraspAnswer::Found(way)) => first_grasp(&way),
            Ok(GraspAnswer::GaveUp(_)) | Err(_) => None,
        };
        Some(NoTaskPlan::OtherGrasp { at: step_of(planned, 0, 0), from })
    }

    /// The path, with a bound that holds for all paths from any grasp that the task before could have left.
    fn held_against_any(
        &mut self,
        sections: &mut Sections,
        planned: &Routes,
        way: GraspPath,
        chosen: PathChoice,
    ) -> GraspPath {
        let roll = match self.request.first {
            FirstCriterion::Effort => ROLL,
            FirstCriterion::Reconfigurations => 1,
        };
        let least = 2 * roll * least_steps(planned);
        if way.cost <= least {
            return way;
        }
        let Some(any) = self.begun_with_any_grasp(sections, planned, chosen) else { return way };
        let bound = match any {
            Ok(GraspAnswer::Found(other)) => {
                if let Some(grasp) = first_grasp(&other).filter(|_| other.cost < way.cost) {
                    self.sums.remarks.push(self.better_begun(grasp, &other));
                }
                other.bound
            }
            Ok(GraspAnswer::GaveUp(GraspSearchEnd::Expansions(GaveUp { bound, .. }))) => bound,
            Ok(GraspAnswer::GaveUp(GraspSearchEnd::Looks { bound })) => bound,
            Ok(GraspAnswer::GaveUp(GraspSearchEnd::TooLarge { .. }) | GraspAnswer::Impossible(_)) | Err(_) => 0,
        };
        GraspPath { bound: way.bound.min(bound.max(least)), ..way }
    }

    /// Remark that names another first grasp from which the task would cost less.
    fn better_begun(&self, grasp: Grasp, way: &GraspPath) -> Remark {
        let cost = digits(effort(self.order, way) as f64 / f64::from(self.order.facts.steps_per_turn));
        let text = format!(
            "`{}` with the grasp that the task before ends with; if that ended with `{}`, it would cost {cost} deg",
            self.request.job.task,
            grasp_text(self.order, grasp)
        );
        Remark { subject: "begins".to_owned(), text }
    }

    /// Whether the steps before `end` end with a release and the fingers cannot leave the grasp at the end of a path.
    /// Always `false` under a load, where no other grasp is searched.
    fn is_stuck_after(&self, sections: &mut Sections, planned: &Routes, way: &GraspPath, end: usize) -> bool {
        let is_released = self.order.steps[..end].last().is_some_and(|step| step.action == FingersAction::Release);
        let (mut orientation, route) = (self.orientation, &planned.routes[way.route]);
        route.iter().for_each(|turning| orientation = sections.turned(orientation, turning.turn));
        let last = route.last().zip(way.legs.last().and_then(|nodes| nodes.last()));
        let held = last.map(|(turning, last)| Holding { grasp: last.grasp, plane: turning.turn.plane });
        is_released
            && self.order.load_un == [0.0; 3]
            && held.is_some_and(|held| sections.leaving(held, orientation).is_none())
    }

    /// Removes all fingers, in an order in which the remaining ones always hold.
    fn release(&mut self, sections: &mut Sections, step: usize) -> Result<(), Box<NoTaskPlan>> {
        let Some(holding) = self.held.take() else { return Ok(()) };
        self.open.grasp = false;
        let leaving = sections.leaving(holding, self.orientation);
        let order = leaving.ok_or(NoTaskPlan::NoRelease { at: step })?;
        self.acts[step].push(FingerAct::Release { order });
        Ok(())
    }
}

/// The grasp with which a path begins.
fn first_grasp(way: &GraspPath) -> Option<Grasp> {
    Some(way.legs.first()?.first()?.grasp)
}

/// A grasp as text: `grasp bead at (1, 38)`.
pub fn grasp_text(order: &FingersOrder, grasp: Grasp) -> String {
    let contacts: Vec<String> =
        grasp.list(order.facts.fingers as usize).iter().map(|contact| contact.to_string()).collect();
    let [open, close] = if contacts.len() > 3 { ["[", "]"] } else { ["(", ")"] };
    format!("grasp {} at {open}{}{close}", order.part.name, contacts.join(", "))
}

/// The planner's answer, whose path holds at every instant, within a limit on reconfigurations.
///
/// Under a load, grasps are first evaluated lazily, with half of the looks; if these do not suffice, tables are built.
///
/// # Errors
/// If a section has too many contacts for its tables, or the looks are spent.
pub fn sound(
    order: &FingersOrder,
    sections: &mut Sections,
    planned: &Routes,
    orientation: UnitQuaternion<f64>,
    chosen: PathChoice,
) -> Result<GraspAnswer, NoTables> {
    if order.load_un == [0.0; 3] {
        return lasting(order, sections, planned, orientation, chosen);
    }
    let looks = Rc::clone(sections.looks());
    let answer = looks.with_half(|| lasting(order, sections, planned, orientation, chosen));
    let Ok(GraspAnswer::GaveUp(GraspSearchEnd::Looks { bound })) = answer else { return answer };
    sections.set_load_evaluation(LoadEvaluation::Tabulated);
    let tabulated = lasting(order, sections, planned, orientation, chosen);
    sections.set_load_evaluation(LoadEvaluation::Lazy);
    Ok(tabulated.unwrap_or(GraspAnswer::GaveUp(GraspSearchEnd::Looks { bound })))
}

/// If a grasp of the path lapses between two angles, the search is repeated without that step, as often as necessary.
/// Every search has fewer steps left, so this ends. All searches together keep to the budget.
fn lasting(
    order: &FingersOrder,
    sections: &mut Sections,
    planned: &Routes,
    orientation: UnitQuaternion<f64>,
    chosen: PathChoice,
) -> Result<GraspAnswer, NoTables> {
    let (mut left, mut least) = (order.expansions, 0);
    loop {
        match answer(order, sections, planned, orientation, chosen, SearchBudget::of(left))? {
            GraspAnswer::Found(way) => {
                if sections.check_rolling(&planned.routes[way.route], &way, orientation) == RollingCheck::Sound {
                    return Ok(GraspAnswer::Found(way));
                }
                left = left.saturating_sub(way.expanded);
                least = way.bound;
            }
            GraspAnswer::GaveUp(GraspSearchEnd::Expansions(gave_up)) => {
                let (budget, bound) = (SearchBudget::of(order.expansions), least.max(gave_up.bound));
                return Ok(GraspAnswer::GaveUp(GraspSearchEnd::Expansions(GaveUp {
                    budget,
                    spent: budget.steps,
                    bound,
                })));
            }
            GraspAnswer::GaveUp(GraspSearchEnd::Looks { bound }) => {
                return Ok(GraspAnswer::GaveUp(GraspSearchEnd::Looks { bound: bound.max(least) }));
            }
            other @ (GraspAnswer::Impossible(_) | GraspAnswer::GaveUp(GraspSearchEnd::TooLarge { .. })) => {
                return Ok(other);
            }
        }
    }
}

/// Cost of rolling one finger by a step, in the unit of [`costs`].
const ROLL: u64 = 360;

/// Cost of a reconfiguration if their number comes first: larger than the rolling of any path.
const MORE_THAN_ALL_ROLLING: u32 = 1 << 24;

/// Least number of steps that the routes roll.
fn least_steps(planned: &Routes) -> u64 {
    let steps = |route: &Vec<RouteTurn>| route.iter().map(|turning| u64::from(turning.turn.steps.unsigned_abs())).sum();
    planned.routes.iter().map(steps).min().unwrap_or_default()
}

/// Cost of a path, in units of [`costs`].
fn effort(order: &FingersOrder, way: &GraspPath) -> u64 {
    let GraspCosts { roll, gait } = costs(order);
    let pairs = way.legs.iter().flat_map(|nodes| nodes.windows(2));
    let cost = |pair: &[GraspNode]| match pair[0].angle == pair[1].angle {
        true => u64::from(gait),
        false => u64::from(roll) * pair[0].grasp.holding() as u64,
    };
    pairs.map(cost).sum()
}

/// Costs as whole numbers, in degrees divided by the steps of a turn.
fn costs(order: &FingersOrder) -> GraspCosts {
    let gait = order.facts.gaiting_cost_deg * f64::from(order.facts.steps_per_turn);
    GraspCosts { roll: ROLL as u32, gait: gait.round() as u32 }
}

/// The answer of the planner that the task selects.
fn answer(
    order: &FingersOrder,
    sections: &mut Sections,
    planned: &Routes,
    orientation: UnitQuaternion<f64>,
    chosen: PathChoice,
    budget: SearchBudget,
) -> Result<GraspAnswer, NoTables> {
    let legs: Result<Vec<_>, _> = planned.routes.iter().map(|route| sections.legs(route, orientation)).collect();
    let request = GraspRequest {
        fingers: order.facts.fingers as usize,
        start: planned.start.map_or(Start::Any, Start::At),
        routes: legs?,
        costs: match chosen.first {
            FirstCriterion::Effort => costs(order),
            FirstCriterion::Reconfigurations => GraspCosts { roll: 1, gait: MORE_THAN_ALL_ROLLING },
        },
        limits: GraspSearchLimits { gaits: chosen.gaits, looks: Rc::clone(sections.looks()) },
    };
    Ok(match order.planner {
        FingersPlanner::JointAstar => graph::solve(&request, Estimator::Layers, budget),
        FingersPlanner::PublishedAstar => graph::solve(&request, Estimator::Published, budget),
        FingersPlanner::GreedyDecomposition => graph::decompose(&request, Estimator::Published, budget),
    })
}

/// The step of a leg; the first of the order where the route has no such leg.
fn step_of(planned: &Routes, route: usize, leg: usize) -> usize {
    planned.routes.get(route).and_then(|route| route.get(leg)).map_or(0, |turning| turning.step)
}

/// A turn as text, with the angle of its whole steps: `79.99 deg about z`.
fn turn_text(sections: &Sections, turn: FingersTurn) -> String {
    let axis = match turn.plane {
        Plane::Xy => "z",
        Plane::Xz => "y",
    };
    let degrees = (f64::from(turn.steps) * sections.step_rad(turn.plane)).to_degrees();
    format!("{} deg about {axis}", digits(to_decimals(degrees, 4)))
}

impl Sums {
    fn plan(self, order: &FingersOrder, motion: FingersMotion) -> Plan<FingersMotion> {
        let degrees = |cost: u64| cost as f64 / f64::from(order.facts.steps_per_turn);
        let time_s = tip_motion::duration_ns(&motion).unwrap_or(u64::MAX) as f64 / 1e9;
        let outcomes = [
            (FingersOutcome::Effort, degrees(self.cost) * PI / 180.0),
            (FingersOutcome::Reconfigurations, self.reconfigurations as f64),
            (FingersOutcome::Time, time_s),
        ];
        Plan {
            planner: order.planner.name(),
            objective: FingersObjective::Effort.name(),
            unit: "deg",
            cost: degrees(self.cost),
            bound: degrees(self.bound),
            proof: if self.is_best { Optimality::Proven } else { Optimality::Open },
            bounds: BTreeMap::new(),
            outcomes: outcomes.map(|(word, value)| (word.name().to_owned(), value)).into_iter().collect(),
            remarks: self.remarks,
            motion,
        }
    }
}
