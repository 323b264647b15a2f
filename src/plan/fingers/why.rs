//! Why a stretch of a task has no plan, in words: which turn, how far it comes, and what would open it.

use super::graph::{Answer, Blocked};
use super::job::{First, sound};
use super::mechanics::{Contacts, Grip, Load, TooManyGrasps};
use super::routes::{Holding, Routes, Turning, routes};
use super::sections::Sections;
use super::ways::WayError;
use crate::check::claims::fingers::{Action, FingersOrder, Part, Planner, Section};
use crate::device::MAX_EXPANSIONS;
use crate::device::fingers::{AXES, Adhesion, Facts, MAX_GRASPS, Plane};
use crate::diagnostic::{Code, Diagnostic};
use crate::geometry::outline::{Curve, OutlineError};
use crate::plan::search::GaveUp;
use crate::quantity::digits;
use nalgebra::UnitQuaternion;
use std::ops::Range;
use std::sync::Arc;

/// The greatest friction that a help looks for.
const MOST_FRICTION: f64 = 2.0;

/// How finely a help tells a figure that would do.
const GRAIN: f64 = 0.01;

/// What a stretch begins with: what the fingers hold, how the part is turned, and its steps.
pub type Begins = (Option<Holding>, UnitQuaternion<f64>, Range<usize>);

/// The words for the messages about one step.
pub struct Why<'a> {
    pub order: &'a FingersOrder,
    /// Index of the order's steps.
    pub at: usize,
}

impl Why<'_> {
    fn span(&self) -> crate::source::Span {
        self.order.steps.get(self.at).map_or_else(Default::default, |step| step.span)
    }

    /// What is said of a stretch for which the search found no way.
    pub fn stuck(&self, answer: &Answer, planned: &Routes, begins: Begins) -> Diagnostic {
        match answer {
            Answer::Impossible(blocked) => self.impossible(blocked, planned, begins),
            Answer::GaveUp(gave_up) => self.gave_up(gave_up),
            Answer::TooLarge { nodes } => {
                Diagnostic::new(Code::E0602, format!("{} has {nodes} grasps, more than can be searched", self.what()))
                    .label(self.span(), "this turn")
                    .help("take a larger `step`, fewer `fingers`, or several tasks")
            }
            Answer::Found(_) => unreachable!("a way that was found is no reason"),
        }
    }

    /// The expansions that the task allows are spent.
    fn gave_up(&self, gave_up: &GaveUp) -> Diagnostic {
        let (most, budget) = (u64::from(MAX_EXPANSIONS), gave_up.budget.steps);
        let bound = digits(gave_up.bound as f64 / f64::from(self.order.facts.steps_per_turn));
        let title = format!(
            "{}: the search gave up after {budget} expansion{}",
            self.what(),
            if budget == 1 { "" } else { "s" }
        );
        let help = match budget.saturating_mul(8).min(most) {
            _ if budget >= most => "no more can be allowed: take a larger `step`, or split the task".to_owned(),
            more => format!("allow more: `using {} {{ expansions: {more} }}`", planner(self.order.planner)),
        };
        Diagnostic::new(Code::E0602, title)
            .label(self.span(), format!("neither planned nor disproved; no plan costs less than {bound} deg"))
            .help(help)
    }

    /// What a step does, as the subject of a sentence.
    fn what(&self) -> String {
        match self.order.steps.get(self.at).map(|step| &step.action) {
            Some(Action::Rotate { angle_rad, plane, .. }) => {
                format!("the turn by {} deg about {}", digits(angle_rad.to_degrees()), axis(*plane))
            }
            Some(Action::Orient { .. }) => "the turn to this orientation".to_owned(),
            Some(Action::Grasp(_)) => "the change of fingers".to_owned(),
            Some(Action::Translate(_) | Action::Release | Action::Wait(_)) | None => "the grasp".to_owned(),
        }
    }

    fn impossible(&self, blocked: &Blocked, planned: &Routes, begins: Begins) -> Diagnostic {
        if self.order.planner == Planner::GreedyDecomposition {
            return Diagnostic::new(Code::E0602, format!("the greedy planner is stuck at {}", self.what()))
                .label(self.span(), "neither planned nor disproved: the turns before it end where it has no way")
                .help("leave `using` out: Tweeze's own planner finds a plan, or proves that there is none");
        }
        let route = &planned.routes[blocked.route];
        let leg = route[blocked.leg];
        let next = route.get(blocked.leg + 1).filter(|next| next.turn.plane != leg.turn.plane);
        if planned.left_out.is_some() {
            let title = format!(
                "the search gave up: of the ways to do it the {} that turn least have no plan",
                planned.routes.len()
            );
            return Diagnostic::new(Code::E0602, title)
                .label(self.span(), "neither planned nor disproved")
                .help("say the turns with `rotate`, or take a larger `step` or `precision`");
        }
        let torque = blocked.farthest.is_none().then(|| self.torque_left(planned, &begins)).flatten();
        if let Some(torque) = torque {
            return Diagnostic::new(Code::E0601, format!("{} cannot begin: its first grasp does not hold", self.what()))
                .label(self.span(), torque)
                .help("hold it on both sides of its centre of mass, or by three fingers, or give the device a larger `torsion`");
        }
        let title = match blocked.farthest {
            None => format!("{} cannot begin: its first grasp does not hold", self.what()),
            Some(_) => format!("no sequence of stable grasps carries out {}", self.what()),
        };
        Diagnostic::new(Code::E0601, title)
            .label(self.span(), format!("{}{}", self.told(blocked, leg, next), self.kept_back()))
            .help_if(self.openings(begins))
    }

    /// The torque of the load about the line through the two contacts that a stretch must begin with, where tips do not bear it.
    fn torque_left(&self, planned: &Routes, (_, orientation, _): &Begins) -> Option<String> {
        let (order, grasp) = (self.order, planned.start?);
        let plane = planned.routes.first()?.first()?.turn.plane;
        let section = order.part.section(plane)?;
        let curve = Curve::of(&section.outline).ok()?;
        let contacts = Contacts::of(section, &curve, order.facts.tip_radius_um);
        let load = Load::seen(plane, orientation, order.load_un, order.part.centre_um);
        let held: Vec<usize> = (0..grasp.0.len()).filter_map(|finger| grasp.contact(finger)).collect();
        let [i, j] = held[..] else { return None };
        let [a, b] = [i, j].map(|contact| contacts.one(contact, 0.0));
        let grip = Grip::of(&order.facts, contacts.reach_um());
        let [asked, borne] = grip.torque_left_un_um([&a, &b], &load)?.map(|torque| digits(rounded(torque)));
        Some(format!(
            "about the line through contacts {} and {} the load has a torque of {asked} uN um, of which tips bear {borne} uN um at most",
            i + 1,
            j + 1
        ))
    }

    /// What the proof rests on besides the figures of the device: the reserve, where it counts.
    fn kept_back(&self) -> String {
        match kept_back(self.order) {
            Some(share) => format!("; {share} % of friction and forces are kept back while it rolls"),
            None => String::new(),
        }
    }

    /// How far the fingers come.
    fn told(&self, blocked: &Blocked, leg: Turning, next: Option<&Turning>) -> String {
        let step_deg = 360.0 / f64::from(self.order.facts.steps_per_turn);
        let degrees = |steps: i32| digits((f64::from(steps) * step_deg * 1e6).round() / 1e6);
        let [i, j] = [1, self.order.part.section(leg.turn.plane).and_then(|section| section.opposite).unwrap_or(1)];
        let junction = next.map(|next| {
            format!(
                "between it and the turn about {} two fingers must hold contacts {i} and {j}",
                axis(next.turn.plane)
            )
        });
        if blocked.farthest.is_none() {
            return "what it must begin with lets go, or lets no finger come near enough".to_owned();
        }
        if blocked.ends == 0 {
            let what = junction.unwrap_or_else(|| "at its end no grasp holds".to_owned());
            return format!("{what}, and that lets go");
        }
        let reached = match blocked.farthest {
            Some(angle) if angle != leg.turn.steps => {
                format!("of {} deg it comes {} deg far", degrees(leg.turn.steps), degrees(angle))
            }
            Some(_) | None => "it comes round, but with no grasp that it may end with".to_owned(),
        };
        junction.map_or(reached.clone(), |junction| format!("{reached}; {junction}"))
    }

    /// What would open the way: of each figure the value nearest to the device's. Under a load, where each trial takes long, only
    /// adhesion is tried.
    fn openings(&self, begins: Begins) -> Option<String> {
        let opens = |changed: &FingersOrder| is_open(changed, &begins);
        let order = self.order;
        let with = |change: &dyn Fn(&mut Facts)| changed(order, change);
        let mut said = Vec::new();
        if order.facts.adhesion == Adhesion::Absent && order.facts.pull_off_un > 0.0 {
            let sticking = with(&|facts| facts.adhesion = Adhesion::Sticking);
            said.extend(opens(&sticking).then(|| "`adhesion: true`".to_owned()));
        }
        if order.load_un != [0.0; 3] {
            let untried = "more friction, a weaker `removal_safety` or a finer `step` may open it: with a load that was not tried";
            return Some(said.first().map_or(untried.to_owned(), |said| format!("there is a plan with {said}")));
        }
        if kept_back(order).is_some() && opens(&with(&|facts| facts.rolling_reserve = 0.0)) {
            said.push("`rolling_reserve: 0`".to_owned());
        }
        let friction = |value: f64| with(&|facts| facts.friction = value);
        let least = nearest([order.facts.friction, MOST_FRICTION], &|value| opens(&friction(value)));
        said.extend(least.map(|value| format!("`friction: {}`", digits(value))));
        if order.facts.adhesion == Adhesion::Sticking {
            let safety = |value: f64| with(&|facts| facts.removal_safety = value);
            let most = nearest([order.facts.removal_safety, 0.0], &|value| opens(&safety(value)));
            said.extend(most.map(|value| format!("`removal_safety: {}`", digits(value))));
        }
        let step_deg = 180.0 / f64::from(order.facts.steps_per_turn);
        let is_finer = begins.0.is_none() && halved(order).is_some_and(|halved| opens(&halved));
        said.extend(is_finer.then(|| format!("`step: {} deg`", digits(step_deg))));
        match said.as_slice() {
            [] => Some(format!(
                "neither friction up to {MOST_FRICTION}, nor a weaker `removal_safety`, nor half the step opens it: \
                 turn it otherwise, or take another object or other tips"
            )),
            said => Some(format!("there is a plan with {}", said.join(", or with "))),
        }
    }

    /// What is said of sections with too many contacts.
    pub fn too_many(&self, too_many: &TooManyGrasps) -> Diagnostic {
        let TooManyGrasps { contacts, layers } = *too_many;
        let title = format!("{contacts} contacts at {layers} angles make more than {MAX_GRASPS} grasps of three");
        Diagnostic::new(Code::E0602, title)
            .label(self.span(), "a load makes grasps differ from angle to angle")
            .help("take a larger `step` or larger tips, or leave the load and the `material` out")
    }

    /// What is said of a grasp that no finger may leave.
    pub fn stuck_fingers(&self) -> Diagnostic {
        Diagnostic::new(Code::E0602, "no finger can leave the grasp that was found first")
            .label(self.span(), "of the fingers that hold here; other grasps were not tried")
            .help("end with two fingers: put `grasp … at (…)` before it")
    }

    /// What is said of an outline that cannot be followed.
    pub fn not_followed(&self, error: &OutlineError) -> Diagnostic {
        let title = format!("the outline of `{}` cannot be followed: {error:?}", self.order.part.name);
        Diagnostic::new(Code::E0602, title).label(self.order.part.span, "this part")
    }

    /// What is said of fingers that cannot go where a plan wants them.
    pub fn no_way(&self, error: &WayError) -> Diagnostic {
        let at = |step: usize| Why { order: self.order, at: step }.span();
        match *error {
            WayError::Range { step, finger, axis, beyond_um } => {
                let range_um = self.order.facts.range_um[axis];
                let title = format!(
                    "finger {} would go {} um beyond its range of {} um along {}",
                    finger + 1,
                    digits((beyond_um * 1e3).round() / 1e3),
                    digits(range_um),
                    AXES[axis]
                );
                Diagnostic::new(Code::E0602, title)
                    .label(at(step), "in this step")
                    .help("place the part nearer to the middle of the hand, or give the stages a larger `range`")
            }
            WayError::Blocked { step, finger, contact } => {
                let title = format!("finger {} has no clear way to or from contact {contact}", finger + 1);
                Diagnostic::new(Code::E0602, title).label(at(step), "in this step").help("grasp it otherwise")
            }
            WayError::Adrift { step, finger, contact, off_um } => {
                let allowed_um = self.order.facts.tolerance_um;
                let title = format!(
                    "finger {} comes to be {} um off contact {contact}, more than the tolerance of {} um leaves",
                    finger + 1,
                    digits((off_um * 1e4).round() / 1e4),
                    digits(allowed_um)
                );
                Diagnostic::new(Code::E0602, title).label(at(step), "as it goes on in another plane").help(
                    "the outlines in both planes do not quite meet on the x axis, and each change of plane adds to it: `release` the \
                     part before this step, or give the device a larger `tolerance`",
                )
            }
            WayError::TooFine { step } => Diagnostic::new(Code::E0602, "the way has too many stretches")
                .label(at(step), "in this step")
                .help("give the device a larger `tolerance`"),
            WayError::Unfit { step } => {
                Diagnostic::new(Code::E0602, "the plan does not fit the grasp that it meets").label(at(step), "here")
            }
        }
    }
}

/// The share that is kept back while tips roll, in percent; `None` where it is nothing, or makes no difference: where tips stick
/// and nothing acts, every grasp holds.
pub fn kept_back(order: &FingersOrder) -> Option<String> {
    let facts = &order.facts;
    let counts = facts.rolling_reserve > 0.0 && (facts.sticking_un() == 0.0 || order.load_un != [0.0; 3]);
    counts.then(|| digits(facts.rolling_reserve * 100.0))
}

/// Three digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

fn axis(plane: Plane) -> &'static str {
    match plane {
        Plane::Xy => "z",
        Plane::Xz => "y",
    }
}

fn planner(planner: Planner) -> &'static str {
    match planner {
        Planner::JointAstar => "joint_astar",
        Planner::PublishedAstar => "published_astar",
        Planner::GreedyDecomposition => "greedy_decomposition",
    }
}

/// Whether a stretch has a plan in an order with other figures.
fn is_open(order: &FingersOrder, (held, orientation, steps): &Begins) -> bool {
    let Ok(mut sections) = Sections::of(order) else { return false };
    let planned = routes(order, steps.clone(), *held);
    matches!(sound(order, &mut sections, &planned, *orientation, First::Effort), Ok(Answer::Found(_)))
}

fn changed(order: &FingersOrder, change: &dyn Fn(&mut Facts)) -> FingersOrder {
    let mut facts = Facts::clone(&order.facts);
    change(&mut facts);
    // Whether there is a plan at all is what the default planner tells fastest.
    FingersOrder { facts: Arc::new(facts), planner: Planner::JointAstar, ..order.clone() }
}

/// The figure nearest to the first one, in whole grains, that opens the way, if the last one does; a figure between them that opens
/// it does so with all that are farther.
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

/// The order with half its step: twice the contacts, each turn of twice the steps. `None` where a grasp is named by its contacts.
fn halved(order: &FingersOrder) -> Option<FingersOrder> {
    let mut halved = changed(order, &|facts| facts.steps_per_turn *= 2);
    halved.part =
        Arc::new(Part { xy: finer(&order.part.xy), xz: order.part.xz.as_ref().map(finer), ..Part::clone(&order.part) });
    for step in &mut halved.steps {
        match &mut step.action {
            Action::Rotate { steps, .. } => *steps *= 2,
            Action::Orient { turns, .. } => turns.iter_mut().flatten().for_each(|turn| turn.steps *= 2),
            Action::Grasp(Some(_)) => return None,
            Action::Grasp(None) | Action::Translate(_) | Action::Release | Action::Wait(_) => (),
        }
    }
    (halved.facts.steps_per_turn <= crate::device::fingers::MAX_STEPS_PER_TURN).then_some(halved)
}

fn finer(section: &Section) -> Section {
    Section {
        contacts: section.contacts * 2,
        opposite: section.opposite.map(|contact| 2 * contact - 1),
        step_rad: section.step_rad / 2.0,
        ..section.clone()
    }
}
