//! Checks of the steps of a task that do not depend on the robots' places at that time.

use super::CheckedBed;
use super::bodies::{ObstacleSolid, RobotBody};
use super::errors;
use super::ground::{BedScene, exact_pose, first_near};
use crate::check::Checker;
use crate::check::figures::Figures;
use crate::check::lets::Argument;
use crate::check::tasks::{self, Parts, TaskSite};
use crate::check::value::{Accepted, ModuleWord, Value, whole};
use crate::check::verbs::Call;
use crate::claims::microrobots::{
    Assurance, Dock, MicrorobotsAction, MicrorobotsOrder, MicrorobotsStep, MicrorobotsStop, Precision,
};
use crate::device::microrobots::{MicrorobotsObjective, MicrorobotsVerb};
use crate::diagnostic::{Code, Diagnostic, Sink};
use crate::geometry::Pose;
use crate::real::Real;
use crate::source::{Span, Spanned};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Greatest distance of one `apply`: on longer paths rounding exceeds the tolerance of the verifier.
const MAX_APPLIED_UM: f64 = 1e8;

impl Checker<'_> {
    /// A task's body in the kind's own terms; `None` after an error.
    pub fn microrobots_order(&mut self, site: &TaskSite, bed: &CheckedBed, parts: Parts) -> Option<MicrorobotsOrder> {
        let ground = self.ground(site, bed);
        let precision = precision(&parts.settings, bed, &ground, self.sink);
        let scene = site.scene.as_ref().map(|(place, _)| self.named(*place).1);
        let solids = ground.obstacles.iter().map(ObstacleSolid::of).collect();
        let device = site.device.name.as_str();
        let mut judge = BedStepJudge { bed, ground: &ground, solids, scene, device, sink: self.sink };
        let steps: Vec<Option<MicrorobotsStep>> = parts.steps.iter().map(|step| judge.step(step)).collect();
        let steps: Option<Vec<MicrorobotsStep>> = steps.into_iter().collect();
        let steps = steps?;
        self.sink.push_if_some(guaranteed_in_vain(&parts.settings, bed, &steps))?;
        let objective = self.bed_objective(&parts, bed, &steps)?;
        let order = MicrorobotsOrder {
            facts: Arc::clone(&bed.facts),
            states: Arc::clone(&bed.states),
            obstacles: Arc::clone(&ground.obstacles),
            robots: Arc::clone(&ground.robots),
            expansions: parts.expansions()?,
            objective,
            precision: precision?,
            assurance: assurance(&parts.settings),
            steps,
        };
        ground.is_whole.then_some(order)
    }

    /// The objective that `minimize` names; time by default, and where nothing can fail.
    fn bed_objective(
        &mut self,
        parts: &Parts,
        bed: &CheckedBed,
        steps: &[MicrorobotsStep],
    ) -> Option<MicrorobotsObjective> {
        let Some(Spanned { value: name, span }) = parts.objective.as_ref() else {
            return Some(MicrorobotsObjective::Time);
        };
        let assembles = steps.iter().any(|step| matches!(step.action, MicrorobotsAction::Assemble(_)));
        let why = match MicrorobotsObjective::find(name)? {
            // A step that could not be read may be an assembly.
            MicrorobotsObjective::Failures if !assembles && !parts.is_whole => return Some(MicrorobotsObjective::Time),
            MicrorobotsObjective::Failures if !assembles => "the task assembles nothing",
            MicrorobotsObjective::Failures if bed.facts.errors.is_none() => "the device does not state all its errors",
            objective => return Some(objective),
        };
        self.sink.push(errors::failures_in_vain(*span, why));
        Some(MicrorobotsObjective::Time)
    }
}

fn assurance(settings: &Accepted) -> Assurance {
    if settings.is_set("guaranteed") { Assurance::Demanded } else { Assurance::Reported }
}

/// Diagnostic for a guarantee that no plan can give: a robot with errors that is driven to a pose is corrected by
/// measurements.
fn guaranteed_in_vain(settings: &Accepted, bed: &CheckedBed, steps: &[MicrorobotsStep]) -> Option<Diagnostic> {
    let setting = settings.get("guaranteed").filter(|_| settings.is_set("guaranteed"))?;
    let drives = |step: &&MicrorobotsStep| matches!(step.action, MicrorobotsAction::Drive { .. });
    let drive = steps.iter().find(drives).filter(|_| bed.facts.errors.is_none_or(|errors| !errors.are_zero()))?;
    Some(errors::guaranteed_drive(setting.span, drive.span))
}

/// Rounding tolerance of a stroke, as a share of it.
const ROUNDING: f64 = 1e-9;

/// Tolerance of goals; a robot ends no nearer than half a stroke.
fn precision(settings: &Accepted, bed: &CheckedBed, ground: &BedScene, sink: &mut Sink) -> Option<Precision> {
    let (place, heading) = (settings.quantity("precision")?, settings.quantity("heading_precision")?);
    let found = Precision { place_um: place.in_unit("um"), heading_rad: heading.si };
    let robots = ground.robots.iter().map(|placed| &bed.facts.robots[placed.row]);
    let coarsest = robots.max_by(|one, other| one.step_um.total_cmp(&other.step_um));
    if let (Some(robot), Some(setting)) = (coarsest, settings.get("precision"))
        && found.place_um < robot.step_um / 2.0 * (1.0 - ROUNDING)
    {
        sink.push(errors::precision_below_step(setting.span, found.place_um, &robot.name, robot.step_um));
        return None;
    }
    Some(found)
}

/// Judges the steps of one task.
struct BedStepJudge<'a> {
    bed: &'a CheckedBed,
    ground: &'a BedScene,
    /// One for each obstacle.
    solids: Vec<Option<ObstacleSolid>>,
    /// Where the task's scene is declared.
    scene: Option<Span>,
    /// The device's name.
    device: &'a str,
    sink: &'a mut Sink,
}

impl BedStepJudge<'_> {
    fn step(&mut self, step: &tasks::VocabularyStep) -> Option<MicrorobotsStep> {
        let action = match &step.action {
            tasks::VocabularyAction::Wait(duration_ns) => MicrorobotsAction::Wait(*duration_ns),
            tasks::VocabularyAction::Verb(call) => self.call(call)?,
            // The kind has no simultaneous goals, already reported.
            tasks::VocabularyAction::Together(_) | tasks::VocabularyAction::Assay(_) => return None,
        };
        Some(MicrorobotsStep { action, span: step.span })
    }

    fn call(&mut self, call: &Call) -> Option<MicrorobotsAction> {
        match MicrorobotsVerb::find(call.verb.name)? {
            MicrorobotsVerb::Apply => self.apply(call),
            MicrorobotsVerb::Drive => self.drive(call),
            MicrorobotsVerb::Assemble => self.assemble(call),
        }
    }

    fn apply(&mut self, call: &Call) -> Option<MicrorobotsAction> {
        let state = self.state(call.object.as_ref()?);
        let (_, duration) = call.phrases.first()?;
        let Value::Quantity(time) = duration.value else { return None };
        let duration_ns = crate::check::clock_ns(time, duration.span, "`apply`", self.sink)?;
        let wrong = self.too_far(duration_ns, duration.span);
        duration.unless(wrong, self.sink)?;
        Some(MicrorobotsAction::Apply { state: state?, duration_ns })
    }

    /// Diagnostic for a duration that carries the fastest robot too far.
    fn too_far(&self, duration_ns: u64, span: Span) -> Option<Diagnostic> {
        let facts = &self.bed.facts;
        let robots = self.ground.robots.iter().map(|placed| &facts.robots[placed.row]);
        let fastest = robots.max_by(|one, other| one.step_um.total_cmp(&other.step_um))?;
        let way_um = duration_ns.div_ceil(facts.period_ns) as f64 * fastest.step_um;
        (way_um > MAX_APPLIED_UM).then(|| errors::applied_too_far(span, &fastest.name, way_um, MAX_APPLIED_UM))
    }

    /// A control state by its number or by its arms.
    fn state(&mut self, argument: &Argument) -> Option<usize> {
        let states = &self.bed.states;
        let wrong = match &argument.value {
            Value::Quantity(number) => {
                let index = whole(*number).and_then(|number| usize::try_from(number).ok());
                if let Some(index) = index.filter(|index| *index < states.len()) {
                    return Some(index);
                }
                errors::unknown_state(argument.span, &number.to_string(), self.device, &self.accessible())
            }
            Value::Word(word) => {
                let robots = self.bed.facts.robots.len();
                if word.width as usize != robots {
                    errors::pattern_of_wrong_width(argument.span, word.width, robots, self.device)
                } else {
                    let digits = digits(*word);
                    if let Some(index) = states.iter().position(|state| state.digits() == digits) {
                        return Some(index);
                    }
                    errors::inaccessible_state(argument.span, &format!("0b{digits}"), self.device, &self.accessible())
                }
            }
            _ => return None,
        };
        argument.unless(Some(wrong), self.sink);
        None
    }

    fn accessible(&self) -> Vec<(usize, String)> {
        self.bed.states.iter().map(|state| state.digits()).enumerate().collect()
    }

    fn drive(&mut self, call: &Call) -> Option<MicrorobotsAction> {
        let robot = self.robot(call.object.as_ref()?);
        let targets = phrases(&call.phrases, "via").chain(phrases(&call.phrases, "to"));
        let stops: Vec<Option<MicrorobotsStop>> = targets.map(|target| self.stop(target, robot)).collect();
        Some(MicrorobotsAction::Drive {
            robot: robot?,
            stops: stops.into_iter().collect::<Option<Vec<MicrorobotsStop>>>()?,
        })
    }

    fn assemble(&mut self, call: &Call) -> Option<MicrorobotsAction> {
        let mut docks: Vec<Option<Dock>> = Vec::with_capacity(call.entries.len());
        let mut seen: BTreeMap<usize, Span> = BTreeMap::new();
        for entry in &call.entries {
            let robot = self.robot(&entry.object);
            let goal = phrases(&entry.phrases, "to").next().and_then(|target| self.stop(target, robot));
            let earlier = robot.and_then(|robot| seen.insert(robot, entry.span));
            let wrong = earlier.map(|earlier| errors::assembled_twice(self.name(robot), entry.span, earlier));
            let is_first = entry.object.unless(wrong, self.sink).is_some();
            docks.push(robot.zip(goal).filter(|_| is_first).map(|(robot, goal)| Dock { robot, goal }));
        }
        let is_small = (call.entries.len() < 2).then(|| errors::assembly_too_small(call.span, call.entries.len()));
        self.sink.push_if_some(is_small)?;
        docks.into_iter().collect::<Option<Vec<Dock>>>().map(MicrorobotsAction::Assemble)
    }

    fn name(&self, robot: Option<usize>) -> &str {
        let placed = robot.and_then(|robot| self.ground.robots.get(robot));
        placed.map_or("", |placed| self.bed.facts.robots[placed.row].name.as_str())
    }

    /// The robot that an argument names; `None` after an error.
    fn robot(&mut self, argument: &Argument) -> Option<usize> {
        self.ground.names.index(argument, self.scene, self.ground.is_whole, self.sink)
    }

    /// A pose at which the robot's body is clear of obstacles.
    fn stop(&mut self, target: &Argument, robot: Option<usize>) -> Option<MicrorobotsStop> {
        let pose = exact_pose(target, self.sink)?;
        let wrong = robot.and_then(|robot| self.on_obstacle(robot, pose, target.span));
        target.unless(wrong, self.sink)?;
        Some(MicrorobotsStop { pose, span: target.span, origin: target.origin.clone() })
    }

    fn on_obstacle(&self, robot: usize, pose: Pose, span: Span) -> Option<Diagnostic> {
        let facts = &self.bed.facts;
        let placed = self.ground.robots.get(robot)?;
        let kept_um = facts.clearance_um;
        let body = |pose: Pose| RobotBody::of(&facts.robots[placed.row], pose);
        let near = |pose: Pose| first_near(&body(pose), &self.ground.obstacles, &self.solids, kept_um);
        let (obstacle, gap_um) = near(pose)?;
        let free = nearest_pose(pose, |pose| near(pose).is_none());
        let what = errors::BlockedRobot { code: Code::E0502, robot: self.name(Some(robot)), span };
        Some(errors::robot_near_obstacle(&what, &obstacle.name, obstacle.span, gap_um, kept_um, free))
    }
}

fn phrases<'c>(phrases: &'c [(&'static str, Argument)], preposition: &'c str) -> impl Iterator<Item = &'c Argument> {
    phrases.iter().filter(move |(name, _)| *name == preposition).map(|(_, argument)| argument)
}

/// The digits of a word, the first one first.
fn digits(word: ModuleWord) -> String {
    (0..word.width).rev().map(|at| if word.bits >> at & 1 == 1 { '1' } else { '0' }).collect()
}

/// Number of rings around a pose that are searched for a better one, and of places on each ring.
const RINGS: [u32; 2] = [60, 24];

/// The nearest pose with the same heading, a whole number of micrometres away in widening rings, that `is_fine` accepts.
pub fn nearest_pose(pose: Pose, is_fine: impl Fn(Pose) -> bool) -> Option<Pose> {
    let [rings, places] = RINGS;
    let mut radius_um = 0.0;
    for _ in 0..rings {
        radius_um = f64::max(radius_um + 1.0, radius_um * 1.1).ceil();
        let on_ring = (0..places).map(|at| {
            let (sin, cos) = (std::f64::consts::TAU * f64::from(at) / f64::from(places)).sine_cosine();
            Pose { x_um: (pose.x_um + radius_um * cos).round(), y_um: (pose.y_um + radius_um * sin).round(), ..pose }
        });
        if let Some(found) = on_ring.into_iter().find(|pose| is_fine(*pose)) {
            return Some(found);
        }
    }
    None
}
