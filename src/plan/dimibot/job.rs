//! Planner of one DiMiBot job. Its steps are planned as a whole: first for the objective alone, then, if that plan
//! exceeds a limit, within the limits.
//!
//! A plan within limits is the best one that keeps them all. If there is none, the report on each violated limit states
//! what a search within all the other limits has shown.

use super::reach::reached;
use super::{
    FieldObstacle, Impossible, Lattice, LatticeCell, LatticeField, MissingLeg, ModulePulse, MotionTally, NoLeg,
    Opening, Proof, Route, RouteRequest, RouteStage, RouteWithin, Router, Side, avoid_collisions, blame,
};
use crate::claims::dimibot::{
    DimibotAction, DimibotMethod, DimibotObjective, DimibotObstacleBody, DimibotOrder, DimibotStep, DimibotStop,
    InitialCell,
};
use crate::claims::{self, Claims, Job, Relation, Requirement};
use crate::device::dimibot::{DimibotFacts, DimibotOutcome, Simultaneous};
use crate::diagnostic::{CellRun, Reach, ReachExtent, Sink};
use crate::plan::errors::{self, Removal};
use crate::plan::requirements::{Kept, KnownLimit, keeps, require};
use crate::plan::search::{GaveUp, SearchBudget};
use crate::plan::{KindPlanner, Motion, Optimality, Plan};
use crate::source::Span;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Budget for finding the blocking obstacles: a fraction of a second, however long the proof took.
const WHY_BUDGET: SearchBudget = SearchBudget::of(1_000_000);

/// Motion of a robot in one job.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DimibotMotion {
    pub start: LatticeCell,
    /// The motion in each step of the order.
    pub steps: Vec<DimibotStepMotion>,
    /// Idle time before each pulse, in nanoseconds, to let others pass; empty if there is none.
    pub delays: Vec<u64>,
}

/// Motion of a robot in one step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum DimibotStepMotion {
    /// The modules of each pulse, in order; empty if the robot already stands at the goal.
    Pulses(Vec<ModulePulse>),
    /// In nanoseconds.
    Wait(u64),
}

/// The fields of a schedule's scenes, each built once.
#[derive(Default)]
struct SceneFields {
    known: Vec<(Arc<Vec<claims::dimibot::DimibotObstacle>>, DimibotFacts, Arc<SearchScene>)>,
}

/// A scene in the form that the searches use.
struct SearchScene {
    field: LatticeField,
    obstacles: Vec<FieldObstacle>,
}

impl SceneFields {
    fn scene(&mut self, order: &DimibotOrder) -> Arc<SearchScene> {
        let is_same =
            |(obstacles, facts, _): &&(Arc<Vec<claims::dimibot::DimibotObstacle>>, DimibotFacts, Arc<SearchScene>)| {
                Arc::ptr_eq(obstacles, &order.obstacles) && *facts == order.facts
            };
        if let Some((_, _, scene)) = self.known.iter().find(is_same) {
            return Arc::clone(scene);
        }
        let scene = SearchScene::new(order).expect("the checker rejects scenes from which no field can be built");
        let scene = Arc::new(scene);
        self.known.push((Arc::clone(&order.obstacles), order.facts.clone(), Arc::clone(&scene)));
        scene
    }
}

impl SearchScene {
    /// `None` only for a robot or an obstacle that the checker rejects.
    fn new(order: &DimibotOrder) -> Option<SearchScene> {
        let facts = &order.facts;
        let lattice = Lattice::new([facts.left, facts.right], Side::BOTH.map(|side| facts.pitch_um(side))).ok()?;
        let growth_um = facts.growth_um();
        let obstacles: Vec<FieldObstacle> = order
            .obstacles
            .iter()
            .map(|obstacle| body(&obstacle.body.seen_from(order.frame.as_ref()), growth_um))
            .collect();
        let field = LatticeField::new(lattice, &obstacles).ok()?;
        Some(SearchScene { field, obstacles })
    }
}

fn body(body: &DimibotObstacleBody, growth_um: f64) -> FieldObstacle {
    match body {
        DimibotObstacleBody::Cells { from, to } => FieldObstacle::Cells { from: from.pair(), to: to.pair() },
        DimibotObstacleBody::Solid { shape, pose } => {
            FieldObstacle::Physical { shape: shape.clone(), pose: *pose, growth_um }
        }
    }
}

/// State carried from job to job of a schedule.
#[derive(Default)]
pub struct DimibotStandings {
    /// Cell of each robot, by device.
    cells: BTreeMap<String, LatticeCell>,
    fields: SceneFields,
}

impl DimibotStandings {
    /// State of a single robot that stands in a cell.
    pub fn at(device: &str, cell: LatticeCell) -> DimibotStandings {
        DimibotStandings { cells: BTreeMap::from([(device.to_owned(), cell)]), fields: SceneFields::default() }
    }
}

impl KindPlanner for DimibotOrder {
    /// The planner chooses the last place of a `visit` with more than one place.
    fn chooses_its_end(&self) -> bool {
        self.steps.iter().any(|step| match &step.action {
            DimibotAction::Visit(stops) => stops.len() > 1,
            DimibotAction::Move(_) | DimibotAction::Wait(_) => false,
        })
    }

    fn resolve_conflicts<'a>(
        &self,
        claims: &'a Claims,
        plans: Vec<Plan<Motion<'a>>>,
        sink: &mut Sink,
    ) -> Option<Vec<Plan<Motion<'a>>>> {
        avoid_collisions(claims, plans, sink)
    }
}

/// A plan for a job; `None` after an error was pushed.
pub fn plan(
    job: &Job,
    order: &DimibotOrder,
    standing: &mut DimibotStandings,
    sink: &mut Sink,
) -> Option<Plan<DimibotMotion>> {
    let stands = standing.cells.get(&job.device).copied();
    let (plan, end) = planned(job, order, stands, &mut standing.fields, sink);
    standing.cells.insert(job.device.clone(), end);
    plan
}

/// A plan for a job, and the robot's cell after it.
fn planned(
    job: &Job,
    order: &DimibotOrder,
    stands: Option<LatticeCell>,
    fields: &mut SceneFields,
    sink: &mut Sink,
) -> (Option<Plan<DimibotMotion>>, LatticeCell) {
    let Some(start) = start(job, order, stands, sink) else {
        return (None, end_of(order).or(stands).unwrap_or(order.facts.home));
    };
    let scene = fields.scene(order);
    let search = DimibotTaskSearch::new(job, order, &scene, start);
    if !search.begins_clear(sink) {
        return (None, end_of(order).unwrap_or(start));
    }
    let (plan, end) = search.plan(sink);
    (plan, end.or(end_of(order)).unwrap_or(start))
}

/// Cell where a job begins; `None` if it names another cell than its device stands on, which has been reported.
fn start(job: &Job, order: &DimibotOrder, stands: Option<LatticeCell>, sink: &mut Sink) -> Option<LatticeCell> {
    match (order.start, stands) {
        (Some(start), Some(stands)) if start.value != stands => {
            sink.push(order.start_disagrees(start, stands, job));
            None
        }
        (Some(start), _) => Some(start.value),
        (None, Some(stands)) => Some(stands),
        (None, None) => Some(order.facts.home),
    }
}

/// Last stop of an order, as written.
fn end_of(order: &DimibotOrder) -> Option<LatticeCell> {
    order.steps.iter().rev().find_map(|step| match &step.action {
        DimibotAction::Move(stops) | DimibotAction::Visit(stops) => stops.last().map(|stop| stop.cell),
        DimibotAction::Wait(_) => None,
    })
}

/// Planning of one job.
#[derive(Clone)]
struct DimibotTaskSearch<'a> {
    job: &'a Job,
    order: &'a DimibotOrder,
    scene: &'a SearchScene,
    start: LatticeCell,
    stages: Vec<RouteStage>,
    /// The step of each stage.
    step_of: Vec<usize>,
}

impl<'a> DimibotTaskSearch<'a> {
    fn new(job: &'a Job, order: &'a DimibotOrder, scene: &'a SearchScene, start: LatticeCell) -> Self {
        let (mut stages, mut step_of) = (Vec::new(), Vec::new());
        for (index, step) in order.steps.iter().enumerate() {
            match &step.action {
                DimibotAction::Wait(_) => {}
                DimibotAction::Move(stops) => stages.extend(stops.iter().map(|stop| RouteStage::To(stop.cell))),
                DimibotAction::Visit(stops) => {
                    stages.push(RouteStage::All(stops.iter().map(|stop| stop.cell).collect()))
                }
            }
            step_of.resize(stages.len(), index);
        }
        DimibotTaskSearch { job, order, scene, start, stages, step_of }
    }

    fn router(&self) -> Router<'_> {
        Router::new(RouteRequest {
            field: &self.scene.field,
            start: self.start,
            stages: &self.stages,
            method: self.order.planner.method,
            with_pulses: uses_pulses(self.order),
            expansions: self.order.planner.expansions,
        })
    }

    fn begins_clear(&self, sink: &mut Sink) -> bool {
        let covering = self.scene.field.covering(self.start);
        if !covering.is_empty() {
            // A covered home was reported before planning, so the last task has left the robot there.
            sink.push(self.order.start_covered(InitialCell::AfterLastTask(self.start), &covering, self.job));
        }
        covering.is_empty()
    }

    /// A plan that keeps the limits, and the robot's cell after it; without a plan an error was pushed.
    fn plan(&self, sink: &mut Sink) -> (Option<Plan<DimibotMotion>>, Option<LatticeCell>) {
        let mut router = self.router();
        let best = match router.best(self.order.objective) {
            Ok(best) => best,
            Err(failures) => {
                failures.iter().for_each(|failure| self.fail(failure, sink));
                return (None, None);
            }
        };
        let (plan, end) = (self.finished(&best, best.bound), self.end(&best));
        let limits = self.limits(None);
        if limits.is_some_and(|limits| best.tally.is_within(limits)) || !self.searches_limits() {
            let mut known = |requirement: &Requirement| self.known_of_published(&best, requirement);
            let kept = require(self.job, &plan, &mut known, sink);
            return (Some(plan).filter(|_| kept == Kept::Yes), Some(end));
        }
        let none = RouteWithin { route: None, is_complete: true };
        let within = limits.map_or(none, |limits| router.within(self.order.objective, limits));
        if let Some(route) = within.route {
            let bound = best.bound.max(route.bound);
            let (plan, end) = (self.finished(&route, bound), self.end(&route));
            let kept = require(self.job, &plan, &mut |_| KnownLimit::default(), sink);
            return (Some(plan).filter(|_| kept == Kept::Yes), Some(end));
        }
        let mut known = |requirement: &Requirement| self.known(&mut router, requirement, within.is_complete);
        let kept = require(self.job, &plan, &mut known, sink);
        debug_assert_eq!(kept, Kept::No, "the best plan misses a limit, or it would have been taken");
        (None, Some(end))
    }

    /// Whether the planner searches within limits: Tweeze's own does, the published ones do not.
    fn searches_limits(&self) -> bool {
        self.order.planner.method == DimibotMethod::StagedAstar
    }

    /// Upper limits on the figures from all requirements except `but`; `None` if no figures satisfy them.
    fn limits(&self, but: Option<&Requirement>) -> Option<MotionTally> {
        let mut limits = MotionTally::MAX;
        for requirement in &self.job.requirements {
            if but.is_some_and(|but| std::ptr::eq(but, requirement)) {
                continue;
            }
            let most = |unit: f64, offset: f64| largest(requirement, unit, offset);
            match DimibotOutcome::find(&requirement.outcome)? {
                DimibotOutcome::Distance => {
                    limits.distance = limits.distance.min(most(figure_si(self.order, DimibotObjective::Distance), 0.0)?)
                }
                DimibotOutcome::Switches => limits.switches = limits.switches.min(most(1.0, 0.0)?),
                DimibotOutcome::Energy => {
                    limits.switches = limits.switches.min(most(figure_si(self.order, DimibotObjective::Energy), 0.0)?)
                }
                DimibotOutcome::Time => {
                    let waits_s = waits_ns(&self.order.steps) as f64 / 1e9;
                    limits.pulses = limits.pulses.min(most(figure_si(self.order, DimibotObjective::Time), waits_s)?);
                }
            }
        }
        Some(limits)
    }

    /// Facts about a limit for which no plan was found that keeps it together with the others.
    fn known(&self, router: &mut Router, requirement: &Requirement, is_proven: bool) -> KnownLimit {
        let Some(objective) = objective_of(&requirement.outcome) else { return KnownLimit::default() };
        let others = self.limits(Some(requirement));
        let within = others.map(|others| router.within(objective, others));
        let search = DimibotTaskSearch { order: &DimibotOrder { objective, ..self.order.clone() }, ..self.clone() };
        let value = |figure: u64| search.si(figure);
        let (least, other) = match within {
            Some(RouteWithin { route: Some(route), is_complete: true }) => {
                (Some(value(route.tally.of_objective(objective))), Some(search.finished(&route, route.bound)))
            }
            Some(RouteWithin { route, .. }) => {
                let bound = router.best(objective).ok().map(|best| value(best.bound));
                (bound, route.map(|route| search.finished(&route, route.bound)))
            }
            None => (None, None),
        };
        let advice = (!is_proven).then(|| {
            let planner = self.order.planner.method.name();
            errors::more_allowed(self.order.planner.expansions, planner)
        });
        KnownLimit { none_keeps_all: is_proven, least, other: other.map(|plan| plan.map(drop)), advice }
    }

    /// Facts that the best plan for the objective alone proves about a limit that it violates.
    fn known_of_published(&self, best: &Route, requirement: &Requirement) -> KnownLimit {
        let is_own = objective_of(&requirement.outcome)
            .is_some_and(|objective| MotionTally::only(objective, 1) == MotionTally::only(self.order.objective, 1));
        let least = is_own.then(|| {
            let order = DimibotOrder {
                objective: objective_of(&requirement.outcome).unwrap_or(self.order.objective),
                ..self.order.clone()
            };
            DimibotTaskSearch { order: &order, ..self.clone() }.si(best.bound)
        });
        let advice = Some("leave `using` out: Tweeze's own planner searches for plans that keep limits".to_owned());
        KnownLimit { none_keeps_all: false, least, other: None, advice }
    }

    /// A figure of the objective in SI units, including waits.
    fn si(&self, figure: u64) -> f64 {
        let waits_s = match self.order.objective {
            DimibotObjective::Time => waits_ns(&self.order.steps) as f64 / 1e9,
            DimibotObjective::Distance | DimibotObjective::Switches | DimibotObjective::Energy => 0.0,
        };
        figure as f64 * figure_si(self.order, self.order.objective) + waits_s
    }

    fn end(&self, route: &Route) -> LatticeCell {
        let pulses = route.pulses.iter().flatten();
        pulses.fold(self.start, |cell, pulse| LatticeCell::new(cell.x ^ pulse.left, cell.y ^ pulse.right))
    }

    fn finished(&self, route: &Route, bound: u64) -> Plan<DimibotMotion> {
        let mut stages = self.step_of.iter().zip(&route.pulses).peekable();
        let mut steps = Vec::with_capacity(self.order.steps.len());
        for (index, step) in self.order.steps.iter().enumerate() {
            let mut pulses = Vec::new();
            while let Some((_, more)) = stages.next_if(|(of, _)| **of == index) {
                pulses.extend(more.iter().copied());
            }
            steps.push(match &step.action {
                DimibotAction::Wait(duration_ns) => DimibotStepMotion::Wait(*duration_ns),
                DimibotAction::Move(_) | DimibotAction::Visit(_) => DimibotStepMotion::Pulses(pulses),
            });
        }
        finished(self.order, DimibotMotion { start: self.start, steps, delays: Vec::new() }, route.tally, bound)
    }

    fn fail(&self, failure: &MissingLeg, sink: &mut Sink) {
        let step = &self.order.steps[self.step_of[failure.stage]];
        let (stop, is_visit) = match &step.action {
            DimibotAction::Move(stops) => {
                let before = self.step_of[..failure.stage].iter().filter(|of| **of == self.step_of[failure.stage]);
                (&stops[before.count()], false)
            }
            DimibotAction::Visit(stops) => (&stops[failure.place], true),
            DimibotAction::Wait(_) => return,
        };
        match failure.reason {
            NoLeg::Impossible(proof) => {
                let span = if is_visit { stop.span } else { step.span };
                self.impossible(span, failure.from, stop, proof, sink);
            }
            NoLeg::GaveUp(gave_up) if is_visit => {
                self.gave_up(step.span, "the places of this `visit`", gave_up, sink);
            }
            NoLeg::GaveUp(gave_up) => self.gave_up(step.span, &stop.cell.to_string(), gave_up, sink),
        }
    }

    fn impossible(&self, step: Span, from: LatticeCell, stop: &DimibotStop, proof: Impossible, sink: &mut Sink) {
        let found = blame(&self.scene.field, &self.scene.obstacles, from, stop.cell, WHY_BUDGET);
        let blamed: Vec<(&str, Span)> = found
            .iter()
            .flat_map(|found| &found.obstacles)
            .map(|index| {
                let obstacle = &self.order.obstacles[*index];
                (obstacle.name.as_str(), obstacle.span)
            })
            .collect();
        let removal = match found.as_ref().map(|found| found.opening) {
            Some(Opening::Smallest) => Removal::OpensAndIsSmallest,
            Some(Opening::Irreducible | Opening::Opens) => Removal::Opens,
            Some(Opening::Unknown) | None => Removal::Unknown,
        };
        let reach = reached(&self.scene.field, from).map(|cells| Reach {
            what: self.job.device.clone(),
            extent: ReachExtent::Cells(CellRun::all(cells.into_iter().map(|cell| (cell.x, cell.y)))),
        });
        let (from, to) = (from.to_string(), stop.cell.to_string());
        let ends = errors::StepEnds { step, from: &from, to: &to };
        let report = errors::impossible(ends, &proof_text(proof.proof), &blamed, removal).reached(reach);
        sink.push(match found {
            Some(_) => report,
            None => report.help("the obstacles that block the path were not found within the step limit"),
        });
    }

    fn gave_up(&self, step: Span, to: &str, gave_up: GaveUp, sink: &mut Sink) {
        let bound = figure(self.order, gave_up.bound);
        let bound = format!("{} {}", crate::quantity::digits(bound), self.order.objective.unit());
        let planner = self.order.planner.method.name();
        let what = format!("planner `{planner}`");
        sink.push(errors::gave_up(step, to, &what, gave_up.budget.steps, bound.trim_end(), planner));
    }
}

fn proof_text(proof: Proof) -> String {
    match proof {
        Proof::StartOutside | Proof::GoalOutside => "not a cell of the lattice".to_owned(),
        Proof::StartCovered => "it begins on an obstacle".to_owned(),
        Proof::GoalCovered => "it ends on an obstacle".to_owned(),
        Proof::BlocksApart => {
            "it cannot be reached: whole regions of the lattice are cut off from one another".to_owned()
        }
        Proof::StartShut { cells: 1 } => "every switch is blocked where it begins".to_owned(),
        Proof::GoalShut { cells: 1 } => "no switch leads to it".to_owned(),
        Proof::StartShut { cells } => format!("only {cells} cells can be reached; all were searched"),
        Proof::GoalShut { cells } => format!("it can be reached from only {cells} cells; all were searched"),
    }
}

fn uses_pulses(order: &DimibotOrder) -> bool {
    order.simultaneous == Simultaneous::Safe
        && order.objective == DimibotObjective::Time
        && order.planner.method == DimibotMethod::StagedAstar
}

/// SI value of one unit of the objective's figure.
fn figure_si(order: &DimibotOrder, objective: DimibotObjective) -> f64 {
    let facts = &order.facts;
    match objective {
        DimibotObjective::Distance => facts.pitch_um(Side::Left).min(facts.pitch_um(Side::Right)) / 1e6,
        DimibotObjective::Switches => 1.0,
        DimibotObjective::Time => (facts.pulse_duration_ns + facts.rest_ns) as f64 / 1e9,
        DimibotObjective::Energy => facts.switch_energy_j(),
    }
}

/// A search's cost in the unit of the objective, without waits.
fn figure(order: &DimibotOrder, cost: u64) -> f64 {
    let facts = &order.facts;
    let cost = cost as f64;
    match order.objective {
        DimibotObjective::Distance => cost * facts.pitch_um(Side::Left).min(facts.pitch_um(Side::Right)),
        DimibotObjective::Switches => cost,
        DimibotObjective::Time => cost * (facts.pulse_duration_ns + facts.rest_ns) as f64 / 1e6,
        DimibotObjective::Energy => cost * facts.switch_energy_j() * 1e3,
    }
}

/// The objective that minimises an outcome.
fn objective_of(outcome: &str) -> Option<DimibotObjective> {
    DimibotOutcome::find(outcome).map(DimibotOutcome::objective)
}

/// Largest count of which `count * unit + offset` keeps the upper side of a requirement (`<`, `<=` or `==`). `u64::MAX`
/// if there is no upper side or no count exceeds it, `None` if not even 0 keeps it.
fn largest(requirement: &Requirement, unit: f64, offset: f64) -> Option<u64> {
    let upper = match requirement.relation {
        Relation::AtLeast | Relation::More => return Some(u64::MAX),
        Relation::Equal => Requirement { relation: Relation::AtMost, ..requirement.clone() },
        Relation::Less | Relation::AtMost => requirement.clone(),
    };
    let fits = |count: u64| keeps(&upper, count as f64 * unit + offset) == Kept::Yes;
    if !fits(0) {
        return None;
    }
    // Bisects between a count that fits and one that does not.
    let (mut low, mut high) = (0, 1 << 53);
    if fits(high) {
        return Some(u64::MAX);
    }
    while high - low > 1 {
        let middle = low + (high - low) / 2;
        if fits(middle) { low = middle } else { high = middle }
    }
    Some(low)
}

/// A plan with its figures; `bound` refers to the objective's figure.
fn finished(order: &DimibotOrder, motion: DimibotMotion, tally: MotionTally, bound: u64) -> Plan<DimibotMotion> {
    let waits_ms = match order.objective {
        DimibotObjective::Time => waits_ns(&order.steps) as f64 / 1e6,
        DimibotObjective::Distance | DimibotObjective::Switches | DimibotObjective::Energy => 0.0,
    };
    let cost = tally.of_objective(order.objective);
    Plan {
        planner: order.planner.method.name(),
        objective: order.objective.name(),
        unit: order.objective.unit(),
        cost: figure(order, cost) + waits_ms,
        bound: figure(order, bound) + waits_ms,
        bounds: BTreeMap::new(),
        proof: if cost == bound { Optimality::Proven } else { Optimality::Open },
        outcomes: outcomes(order, &motion),
        remarks: Vec::new(),
        motion,
    }
}

fn waits_ns(steps: &[DimibotStep]) -> u128 {
    steps
        .iter()
        .map(|step| match step.action {
            DimibotAction::Wait(duration_ns) => u128::from(duration_ns),
            DimibotAction::Move(_) | DimibotAction::Visit(_) => 0,
        })
        .sum()
}

/// Every figure of a plan, in SI units.
fn outcomes(order: &DimibotOrder, motion: &DimibotMotion) -> BTreeMap<String, f64> {
    let facts = &order.facts;
    let (mut pulse_count, mut switches, mut cells) = (0u64, 0u64, [0u64; 2]);
    for step in &motion.steps {
        let DimibotStepMotion::Pulses(pulses) = step else { continue };
        pulse_count += pulses.len() as u64;
        for pulse in pulses {
            switches += u64::from(pulse.left.count_ones() + pulse.right.count_ones());
            cells[0] += u64::from(pulse.left);
            cells[1] += u64::from(pulse.right);
        }
    }
    let distance_um = cells[0] as f64 * facts.pitch_um(Side::Left) + cells[1] as f64 * facts.pitch_um(Side::Right);
    let slot_ns = u128::from(facts.pulse_duration_ns + facts.rest_ns);
    let time_ns = u128::from(pulse_count) * slot_ns + waits_ns(&order.steps);
    let figures = [
        (DimibotOutcome::Distance, distance_um / 1e6),
        (DimibotOutcome::Switches, switches as f64),
        (DimibotOutcome::Time, time_ns as f64 / 1e9),
        (DimibotOutcome::Energy, switches as f64 * facts.switch_energy_j()),
    ];
    figures.into_iter().map(|(word, value)| (word.name().to_owned(), value)).collect()
}
