//! Reports on a stretch without a plan: the turn that fails, how far it gets, and changes that would make it possible.

use super::Stance;
use super::graph::{FarthestRoute, Grasp, GraspAnswer, GraspSearchEnd};
use super::looks::LooksBudget;
use super::mechanics::{Contacts, GripModel, Load, NoTables};
use super::routes::{Holding, RouteTurn, Routes, routes};
use super::sections::Sections;
use super::stretches::{
    FirstCriterion, LeftOpen, NoTaskPlan, PathChoice, StretchStart, TaskRequest, grasp_text, most_looks, plan_task,
    rolling_reserve_percent, sound,
};
use super::tip_motion::TipMotionError;
use crate::claims::Job;
use crate::claims::fingers::{FingersAction, FingersOrder, FingersPlanner, HandPart, Section};
use crate::device::MAX_EXPANSIONS;
use crate::device::fingers::MAX_GRASP_EVALUATIONS;
use crate::device::fingers::sampling::contacts;
use crate::device::fingers::{AXES, Adhesion, FingersFacts, MAX_CONTACTS, MAX_GRASPS, Plane};
use crate::diagnostic::{Code, Diagnostic, Reach, ReachExtent};
use crate::geometry::outline::Curve;
use crate::plan::search::GaveUp;
use crate::quantity::{count, digits, significant, to_decimals};
use nalgebra::UnitQuaternion;
use std::rc::Rc;
use std::sync::Arc;

/// Largest friction coefficient that is tried for a help.
const MOST_FRICTION: f64 = 2.0;

/// Resolution of the values that a help proposes.
const GRAIN: f64 = 0.01;

/// Builder of the messages about one step.
struct HandReasons<'a> {
    order: &'a FingersOrder,
    job: &'a Job,
    /// The stance at the start of the task; `None` before the device's first one.
    stance: Option<&'a Stance>,
    /// Index into the order's steps.
    at: usize,
}

/// Whether a plan exists with changed figures of the device.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum PlanExists {
    Yes,
    /// Proven, for the stretch that has no plan without the change.
    ProvenNo,
    /// The looks are spent, or the plan fails elsewhere.
    Unknown,
}

/// Trials of changed figures, which share a budget of looks.
struct Trials<'a> {
    why: &'a HandReasons<'a>,
    begins: &'a StretchStart,
    looks: Rc<LooksBudget>,
}

/// The report of a task without a plan.
pub fn no_plan(request: &TaskRequest, none: NoTaskPlan) -> Diagnostic {
    let TaskRequest { job, order, stance, .. } = *request;
    let reasons = |at: usize| HandReasons { order, job, stance, at };
    match none {
        NoTaskPlan::Blocked { at, blocked, planned, begins } => reasons(at).impossible(&blocked, &planned, begins),
        NoTaskPlan::GaveUp { at, end } => reasons(at).search_ended(&end),
        NoTaskPlan::NoTables { at, none } => reasons(at).no_tables(&none),
        NoTaskPlan::OtherGrasp { at, from } => reasons(at).otherwise_begun(from),
        NoTaskPlan::GraspFailsUnderLoad { at, held, orientation, open } => {
            reasons(at).grasp_fails_under_load(held, &orientation, open)
        }
        NoTaskPlan::NoRelease { at } => reasons(at).stuck_fingers(),
        NoTaskPlan::NoMotion(error) => reasons(0).no_motion(&error),
    }
}

/// Report of an outline that cannot be followed.
pub fn not_followed(order: &FingersOrder) -> Diagnostic {
    let title = format!("the outline of `{}` cannot be followed", order.part.name);
    Diagnostic::new(Code::E0602, title).label(order.part.span, "this part")
}

impl HandReasons<'_> {
    fn span(&self) -> crate::source::Span {
        self.order.steps.get(self.at).map_or_else(Default::default, |step| step.span)
    }

    /// Report of a search that gave up.
    fn search_ended(&self, end: &GraspSearchEnd) -> Diagnostic {
        match end {
            GraspSearchEnd::Expansions(gave_up) => self.gave_up(gave_up),
            GraspSearchEnd::Looks { bound } => self.looks_spent(*bound),
            GraspSearchEnd::TooLarge { nodes } => {
                Diagnostic::new(Code::E0602, format!("{} has {nodes} grasps, more than can be searched", self.what()))
                    .label(self.span(), "this turn")
                    .help("use a larger `step`, fewer `fingers` or several tasks")
            }
        }
    }

    /// Report: the expansions of the task are spent.
    fn gave_up(&self, gave_up: &GaveUp) -> Diagnostic {
        let (most, budget) = (u64::from(MAX_EXPANSIONS), gave_up.budget.steps);
        let bound = digits(gave_up.bound as f64 / f64::from(self.order.facts.steps_per_turn));
        let title = format!("{}: the search gave up after {}", self.what(), count(budget, "expansion"));
        let help = match budget.saturating_mul(8).min(most) {
            _ if budget >= most => "no larger budget is allowed: use a larger `step`, or split the task".to_owned(),
            more => format!("allow more: `using {} {{ expansions: {more} }}`", self.order.planner.name()),
        };
        Diagnostic::new(Code::E0602, title)
            .label(self.span(), format!("neither planned nor proven impossible; no plan costs less than {bound} deg"))
            .help(help)
    }

    /// Report: the looks of the task are spent.
    fn looks_spent(&self, bound: u64) -> Diagnostic {
        let bound = digits(bound as f64 / f64::from(self.order.facts.steps_per_turn));
        let (most, budget) = (u64::from(MAX_GRASP_EVALUATIONS), most_looks(self.order));
        let title = format!("{}: the search gave up after {budget} looks at grasps", self.what());
        let fewer = "reduce the number of grasps with a larger `step`, larger tips or shorter tasks";
        let help = match budget.saturating_mul(4).min(most) {
            _ if budget >= most => fewer.to_owned(),
            more => format!("allow more: `using {} {{ looks: {more} }}`; or {fewer}", self.order.planner.name()),
        };
        Diagnostic::new(Code::E0602, title)
            .label(self.span(), format!("neither planned nor proven impossible; no plan costs less than {bound} deg"))
            .help(help)
    }

    /// Description of a step, as the subject of a sentence.
    fn what(&self) -> String {
        match self.order.steps.get(self.at).map(|step| &step.action) {
            Some(FingersAction::Rotate { angle_rad, plane, .. }) => {
                format!("the turn by {} deg about {}", digits(angle_rad.to_degrees()), axis(*plane))
            }
            Some(FingersAction::Orient { .. }) => "the turn to this orientation".to_owned(),
            Some(FingersAction::Grasp(_)) => "the change of fingers".to_owned(),
            Some(FingersAction::Translate(_) | FingersAction::Release | FingersAction::Wait(_)) | None => {
                "the grasp".to_owned()
            }
        }
    }

    fn impossible(&self, blocked: &FarthestRoute, planned: &Routes, begins: StretchStart) -> Diagnostic {
        // The search for a remedy takes at most a fifth of the looks of the one that found no plan.
        let trials = Trials { why: self, begins: &begins, looks: Rc::new(LooksBudget::of(most_looks(self.order) / 5)) };
        if self.order.planner == FingersPlanner::GreedyDecomposition {
            return self.greedy(&trials);
        }
        let route = &planned.routes[blocked.route];
        let leg = route[blocked.leg];
        let next = route.get(blocked.leg + 1).filter(|next| next.turn.plane != leg.turn.plane);
        let is_free = self.order.steps.iter().any(|step| matches!(step.action, FingersAction::Orient { .. }));
        if planned.left_out.is_some() && !is_free {
            return self.otherwise_begun(None);
        }
        if planned.left_out.is_some() {
            let title =
                format!("the search gave up: the {} alternatives that turn least have no plan", planned.routes.len());
            return Diagnostic::new(Code::E0602, title)
                .label(self.span(), "neither planned nor proven impossible")
                .help("write the turns with `rotate`, or use a larger `step` or `precision`");
        }
        let torque = blocked.farthest.is_none().then(|| self.torque_left(planned, &begins.orientation)).flatten();
        if let Some(torque) = torque {
            return Diagnostic::new(Code::E0601, format!("{} cannot begin: its first grasp does not hold", self.what()))
                .label(self.span(), torque)
                .help("hold it on both sides of its centre of mass, or by three fingers, or give the device a larger `torsion`");
        }
        let title = match blocked.farthest {
            None => format!("{} cannot begin: its first grasp does not hold", self.what()),
            Some(_) if blocked.is_known => format!("no sequence of stable grasps carries out {}", self.what()),
            Some(_) => {
                format!("no sequence of stable grasps carries out the turns up to {}, or those after it", self.what())
            }
        };
        let leans = blocked.farthest.is_none() && self.order.facts.adhesion == Adhesion::Absent;
        let leans = leans && self.order.load_un.iter().any(|un| *un != 0.0);
        let without = if leans { "; tips that only push must hold without the load, too" } else { "" };
        Diagnostic::new(Code::E0601, title)
            .label(
                self.span(),
                format!("{}{without}{}", self.where_blocked(blocked, leg, next), self.rolling_reserve_note()),
            )
            .help_if(self.openings(&trials))
            .reached(self.reach(blocked, leg))
    }

    /// Report: there is no plan from the grasp with which the task begins, which the planner chose for the task before.
    fn otherwise_begun(&self, from: Option<Grasp>) -> Diagnostic {
        let title = format!(
            "no sequence of stable grasps carries out {} from the grasp with which its task begins",
            self.what()
        );
        let help = match from {
            Some(grasp) => {
                let grasp = grasp_text(self.order, grasp);
                format!(
                    "another grasp may work: one plan would begin with `{grasp}`; end the previous task with it if \
                     possible, or with another one, or merge the two tasks"
                )
            }
            None => {
                "it is not known whether there is one from another grasp: merge the two tasks, or end the previous one \
                 with a `grasp`"
                    .to_owned()
            }
        };
        Diagnostic::new(Code::E0602, title)
            .label(self.span(), "this grasp is the last one of the previous task, which names none")
            .help(help)
    }

    /// Report: the grasp left by the task before does not hold under the load of a task that changes no finger.
    fn grasp_fails_under_load(&self, held: Holding, orientation: &UnitQuaternion<f64>, open: LeftOpen) -> Diagnostic {
        let code = if open.is_any() { Code::E0602 } else { Code::E0601 };
        let title = "the grasp with which this task begins does not hold under its load";
        let torque = self.torque_of(held.grasp, held.plane, orientation);
        Diagnostic::new(code, title)
            .label(self.span(), torque.unwrap_or_else(|| "no finger is placed or removed in this task".to_owned()))
            .help("end the previous task with a `grasp` that holds under this load, or reduce the load")
    }

    /// Reached part of a turn whose end is unreachable; `None` if it is not known.
    fn reach(&self, blocked: &FarthestRoute, leg: RouteTurn) -> Option<Reach> {
        let reached = blocked.farthest.filter(|_| blocked.is_known)?;
        let extent = ReachExtent::Turn {
            plane: leg.turn.plane.name(),
            reached_deg: self.degrees(reached),
            asked_deg: self.degrees(leg.turn.steps),
        };
        Some(Reach { what: self.order.part.name.clone(), extent })
    }

    /// Steps of a turn in degrees, without the rounding noise of the division.
    fn degrees(&self, steps: i32) -> f64 {
        let step_deg = 360.0 / f64::from(self.order.facts.steps_per_turn);
        (f64::from(steps) * step_deg * 1e6).round() / 1e6
    }

    /// Report: the greedy planner got stuck, which proves nothing about other paths.
    fn greedy(&self, trials: &Trials) -> Diagnostic {
        let stuck = Diagnostic::new(Code::E0602, format!("the greedy planner is stuck at {}", self.what()));
        match trials.try_with(&changed(self.order, &|_| ())) {
            PlanExists::Yes => stuck
                .label(self.span(), "the turns before it end where no path leads on")
                .help("leave `using` out: Tweeze's own planner finds a plan"),
            PlanExists::ProvenNo => stuck
                .label(self.span(), "Tweeze's own planner proves that there is no plan")
                .help("leave out `using` to search for a change that makes it possible"),
            PlanExists::Unknown => stuck.label(
                self.span(),
                "neither planned nor proven impossible: the turns before it end where no path leads on",
            ),
        }
    }

    /// Label on the load's torque about the line through the two contacts with which a stretch must begin, if the tips
    /// cannot bear it.
    fn torque_left(&self, planned: &Routes, orientation: &UnitQuaternion<f64>) -> Option<String> {
        self.torque_of(planned.start?, planned.routes.first()?.first()?.turn.plane, orientation)
    }

    /// Label on the load's torque about the line through two contacts that hold, if the tips cannot bear it.
    fn torque_of(&self, grasp: Grasp, plane: Plane, orientation: &UnitQuaternion<f64>) -> Option<String> {
        let order = self.order;
        let section = order.part.section(plane)?;
        let curve = Curve::of(&section.outline).ok()?;
        let contacts = Contacts::of(section, &curve, order.facts.tip_radius_um);
        let load = Load::seen(plane, orientation, order.load_un, order.part.centre_um);
        let held: Vec<usize> = (0..grasp.0.len()).filter_map(|finger| grasp.contact(finger)).collect();
        let [i, j] = held[..] else { return None };
        let [a, b] = [i, j].map(|contact| contacts.one(contact, 0.0));
        let grip = GripModel::of(&order.facts, contacts.reach_um());
        let [asked, borne] = grip.torque_left_un_um([&a, &b], &load)?.map(|torque| digits(significant(torque, 3)));
        Some(format!(
            "the load exerts {asked} uN um about the line through contacts {} and {}; the tips bear at most {borne} uN um",
            i + 1,
            j + 1
        ))
    }

    /// Text on an assumption of the proof besides the figures of the device: the rolling reserve; empty if it has no
    /// effect.
    fn rolling_reserve_note(&self) -> String {
        match rolling_reserve_percent(self.order) {
            Some(share) => format!("; {share} % of friction and forces are held in reserve while it rolls"),
            None => String::new(),
        }
    }

    /// Label on how far the fingers get.
    fn where_blocked(&self, blocked: &FarthestRoute, leg: RouteTurn, next: Option<&RouteTurn>) -> String {
        let degrees = |steps: i32| digits(self.degrees(steps));
        let [i, j] = [1, self.order.part.section(leg.turn.plane).and_then(|section| section.opposite).unwrap_or(1)];
        let junction = next.map(|next| {
            format!(
                "between it and the turn about {} two fingers must hold contacts {i} and {j}",
                axis(next.turn.plane)
            )
        });
        if blocked.farthest.is_none() {
            return "its first grasp slips, or keeps every other finger away".to_owned();
        }
        if blocked.ends == 0 {
            let unpinned = || "no grasp holds at its end".to_owned();
            return junction.map_or_else(unpinned, |junction| format!("{junction}, but this grasp slips"));
        }
        if !blocked.is_known {
            return junction.map_or("how far the turn can go was not searched".to_owned(), |junction| junction);
        }
        let reached = match blocked.farthest {
            Some(angle) if angle != leg.turn.steps => {
                format!("the turn reaches {} deg of {} deg", degrees(angle), degrees(leg.turn.steps))
            }
            Some(_) | None => "the turn reaches its end, but only with grasps that may not end it".to_owned(),
        };
        junction.map_or(reached.clone(), |junction| format!("{reached}; {junction}"))
    }

    /// Help with changes that would make it possible: for each figure the value nearest to the device's. Each is tried
    /// on the whole task.
    fn openings(&self, trials: &Trials) -> Option<String> {
        let order = self.order;
        let with = |change: &dyn Fn(&mut FingersFacts)| changed(order, change);
        let has_plan = |changed: &FingersOrder| trials.try_with(changed) == PlanExists::Yes;
        let (mut changes, mut tried) = (Vec::new(), Vec::new());
        // A part that sticks to the tips may not come off at a release.
        let is_released = order.steps.iter().any(|step| matches!(step.action, FingersAction::Release));
        if order.facts.adhesion == Adhesion::Absent && order.facts.pull_off_un > 0.0 && !is_released {
            let sticking = with(&|facts| facts.adhesion = Adhesion::Sticking);
            changes.extend(has_plan(&sticking).then(|| "`adhesion: true`".to_owned()));
            tried.push("adhesion".to_owned());
        }
        if rolling_reserve_percent(order).is_some() {
            let all = with(&|facts| facts.rolling_reserve = 0.0);
            changes.extend(has_plan(&all).then(|| "`rolling_reserve: 0`".to_owned()));
            tried.push("no `rolling_reserve`".to_owned());
        }
        tried.push(format!("friction up to {MOST_FRICTION}"));
        let friction = |value: f64| with(&|facts| facts.friction = value);
        let least = nearest([order.facts.friction, MOST_FRICTION], &|value| has_plan(&friction(value)));
        changes.extend(least.map(|value| format!("`friction: {}`", digits(value))));
        if order.facts.adhesion == Adhesion::Sticking {
            let safety = |value: f64| with(&|facts| facts.removal_safety = value);
            let most = nearest([order.facts.removal_safety, 0.0], &|value| has_plan(&safety(value)));
            changes.extend(most.map(|value| format!("`removal_safety: {}`", digits(value))));
            tried.push("a lower `removal_safety`".to_owned());
        }
        if trials.begins.held.is_none()
            && let Some((halved, step)) = halved(order)
        {
            changes.extend(has_plan(&halved).then(|| format!("`step: {step} deg`")));
            tried.push("half the step".to_owned());
        }
        let ended = "the search for other changes reached its limit";
        let there = match self.job.requirements.is_empty() {
            true => "there is a plan",
            false => "without its `require` the task has a plan",
        };
        // A grasp held from the beginning is the end of an earlier task, which is not planned again.
        let from = match trials.begins.held {
            Some(_) => ", from the grasp with which this task begins: earlier tasks may then end with another one",
            None => "",
        };
        match (changes.as_slice(), trials.looks.are_spent()) {
            ([], true) => Some(format!("{ended} without a result")),
            ([], false) => Some(format!(
                "none of these changes makes it possible: {}; turn it differently, or use another object or other tips",
                tried.join(", ")
            )),
            (changes, true) => Some(format!("{there} with {}{from}; {ended}", changes.join(", or with "))),
            (changes, false) => Some(format!("{there} with {}{from}", changes.join(", or with "))),
        }
    }

    /// Report of a section without tables.
    fn no_tables(&self, none: &NoTables) -> Diagnostic {
        let NoTables::TooManyGrasps { contacts, layers } = *none else { return self.looks_spent(0) };
        let title = format!("{contacts} contacts at {layers} angles make more than {MAX_GRASPS} grasps of three");
        Diagnostic::new(Code::E0602, title)
            .label(self.span(), "under a load, grasps differ from angle to angle")
            .help("use a larger `step` or larger tips, or leave out the load and the `material`")
    }

    /// Report of a grasp that the fingers cannot leave.
    fn stuck_fingers(&self) -> Diagnostic {
        let others = match self.order.load_un == [0.0; 3] {
            true => "no grasp was found at the end of a plan that they can leave one after the other",
            false => "other grasps were not tried, because of the load",
        };
        Diagnostic::new(Code::E0602, "the fingers cannot leave the grasp that was found first")
            .label(self.span(), others)
            .help("end with two fingers: put `grasp … at (…)` before it")
    }

    /// Report of fingers that cannot reach the positions of a plan.
    fn no_motion(&self, error: &TipMotionError) -> Diagnostic {
        let at = |step: usize| HandReasons { at: step, ..*self }.span();
        match *error {
            TipMotionError::Range { step, finger, axis, beyond_um } => {
                let range_um = self.order.facts.range_um[axis];
                let title = format!(
                    "finger {} would go {} um beyond its range of {} um along {}",
                    finger + 1,
                    digits(to_decimals(beyond_um, 3)),
                    digits(range_um),
                    AXES[axis]
                );
                Diagnostic::new(Code::E0602, title)
                    .label(at(step), "in this step")
                    .help("place the part nearer to the middle of the hand, or give the stages a larger `range`")
            }
            TipMotionError::Blocked { step, finger, contact } => {
                let title = format!("finger {} has no clear path to or from contact {contact}", finger + 1);
                Diagnostic::new(Code::E0602, title).label(at(step), "in this step").help("use another grasp")
            }
            TipMotionError::OffContact { step, finger, contact, off_um } => {
                let allowed_um = self.order.facts.tolerance_um;
                let title = format!(
                    "finger {} ends {} um off contact {contact}, more than the tolerance of {} um leaves room for",
                    finger + 1,
                    digits(to_decimals(off_um, 4)),
                    digits(allowed_um)
                );
                Diagnostic::new(Code::E0602, title).label(at(step), "the next turn is in another plane").help(
                    "the outlines in the two planes do not quite meet on the x axis, and each change of plane adds to \
                     the error: `release` the part before this step, or give the device a larger `tolerance`",
                )
            }
            TipMotionError::TooFine { step } => Diagnostic::new(Code::E0602, "the path has too many segments")
                .label(at(step), "in this step")
                .help("give the device a larger `tolerance`"),
            TipMotionError::Unfit { step } => {
                Diagnostic::new(Code::E0602, "the plan does not fit the grasp that it meets").label(at(step), "here")
            }
        }
    }
}

fn axis(plane: Plane) -> &'static str {
    match plane {
        Plane::Xy => "z",
        Plane::Xz => "y",
    }
}

impl Trials<'_> {
    /// Tries an order with changed figures: first the stretch that has no plan now, then the whole task without its
    /// limits.
    fn try_with(&self, order: &FingersOrder) -> PlanExists {
        let StretchStart { held, orientation, steps } = self.begins;
        let Ok(mut sections) = Sections::of(order, Rc::clone(&self.looks)) else { return PlanExists::Unknown };
        let planned = routes(order, steps.clone(), *held);
        let chosen = PathChoice { first: FirstCriterion::Effort, gaits: None };
        match sound(order, &mut sections, &planned, *orientation, chosen) {
            Ok(GraspAnswer::Found(_)) => {}
            Ok(GraspAnswer::Impossible(_)) if planned.left_out.is_none() => return PlanExists::ProvenNo,
            Ok(_) | Err(_) => return PlanExists::Unknown,
        }
        let (job, stance) = (self.why.job, self.why.stance);
        let open = LeftOpen::default();
        let asked = TaskRequest { job, order, stance, open, first: FirstCriterion::Effort, gaits: Vec::new() };
        match plan_task(&mut sections, &asked) {
            Ok(_) => PlanExists::Yes,
            Err(_) => PlanExists::Unknown,
        }
    }
}

fn changed(order: &FingersOrder, change: &dyn Fn(&mut FingersFacts)) -> FingersOrder {
    let mut facts = FingersFacts::clone(&order.facts);
    change(&mut facts);
    // The default planner decides fastest whether there is a plan at all.
    FingersOrder { facts: Arc::new(facts), planner: FingersPlanner::JointAstar, ..order.clone() }
}

/// The value nearest to `from`, in whole grains, that makes the step possible; `None` if `to` does not. Bisection is
/// valid, since if a value makes it possible, so do all farther ones.
fn nearest([from, to]: [f64; 2], opens: &dyn Fn(f64) -> bool) -> Option<f64> {
    let grains = ((to - from).abs() / GRAIN).floor() as i64;
    let value = |grain: i64| ((from + (to - from).signum() * grain as f64 * GRAIN) / GRAIN).round() * GRAIN;
    if grains <= 0 || !opens(value(grains)) {
        return None;
    }
    let (mut shut, mut open) = (0, grains);
    while open - shut > 1 {
        let middle = (shut + open) / 2;
        if opens(value(middle)) { open = middle } else { shut = middle }
    }
    Some(value(open))
}

/// The order with half its step, and that step as text: twice the contacts, and twice the steps in each turn. `None` if
/// the step cannot be written exactly or is too small, if a grasp is given by its contacts, if an orientation would
/// have other alternatives, or if half the step samples other contacts.
fn halved(order: &FingersOrder) -> Option<(FingersOrder, String)> {
    let mut halved = changed(order, &|facts| facts.steps_per_turn *= 2);
    let step = digits(360.0 / f64::from(halved.facts.steps_per_turn));
    let is_written = step.parse::<f64>().is_ok_and(|step| step * f64::from(halved.facts.steps_per_turn) == 360.0);
    if !is_written || halved.facts.steps_per_turn > crate::device::fingers::MAX_STEPS_PER_TURN {
        return None;
    }
    let xy = finer(&order.part.xy, &halved.facts)?;
    let xz = match &order.part.xz {
        Some(section) => Some(finer(section, &halved.facts)?),
        None => None,
    };
    halved.part = Arc::new(HandPart { xy, xz, ..HandPart::clone(&order.part) });
    for step in &mut halved.steps {
        match &mut step.action {
            FingersAction::Rotate { steps, .. } => *steps *= 2,
            FingersAction::Grasp(Some(_)) | FingersAction::Orient { .. } => return None,
            FingersAction::Grasp(None)
            | FingersAction::Translate(_)
            | FingersAction::Release
            | FingersAction::Wait(_) => (),
        }
    }
    Some((halved, step))
}

/// A section with twice the contacts, if the device samples it that way.
fn finer(section: &Section, facts: &FingersFacts) -> Option<Section> {
    let finer = Section {
        contacts: section.contacts * 2,
        opposite: section.opposite.map(|contact| 2 * contact - 1),
        step_rad: section.step_rad / 2.0,
        ..section.clone()
    };
    let sampled = contacts(&Curve::of(&section.outline).ok()?, facts);
    (sampled == (f64::from(finer.contacts), finer.opposite) && finer.contacts <= MAX_CONTACTS).then_some(finer)
}
