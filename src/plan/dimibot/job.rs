//! One job of a DiMiBot: its steps searched one after the other, its figures added up, its requirements held against them.
//!
//! Each stop is a fixed cell, so the best ways between the stops in their order make the best whole; only `visit` leaves an order
//! to choose, and is searched as a tour.

use super::{
    Cell, Field, Impossible, Lattice, Leg, Measure, Obstacle, Opening, Outcome, Path, Proof, Pulse, Side, TourOutcome,
    Weights, published, pulses, shortest, tour, why,
};
use crate::check::claims::dimibot::{Action, Body, DimibotOrder, Method, Objective, Step, Stop};
use crate::check::claims::{self, Job, Requirement};
use crate::check::start_disagrees;
use crate::device::dimibot::{Facts, Flip, Simultaneous};
use crate::diagnostic::Sink;
use crate::plan::errors::{self, Removal};
use crate::plan::requirements::{Kept, Known, require};
use crate::plan::search::{Budget, GaveUp};
use crate::plan::{Motion as AnyMotion, Optimality, Plan};
use crate::source::Span;
use std::collections::BTreeMap;
use std::sync::Arc;

/// States that the search for a culprit may examine.
const WHY_BUDGET: Budget = Budget::of(20_000_000);

/// What a robot does.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Motion {
    pub start: Cell,
    /// One for each step of the order.
    pub steps: Vec<StepMotion>,
}

/// What a robot does in one step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum StepMotion {
    /// The modules of each pulse, in order; none if the robot stands at the goal already.
    Pulses(Vec<Pulse>),
    /// In nanoseconds.
    Wait(u64),
}

/// The fields of a schedule's scenes, each built once.
#[derive(Default)]
struct Fields {
    known: Vec<(Arc<Vec<claims::dimibot::Obstacle>>, Facts, Arc<Scene>)>,
}

/// A scene as the searches see it.
struct Scene {
    field: Field,
    obstacles: Vec<Obstacle>,
}

impl Fields {
    fn scene(&mut self, order: &DimibotOrder) -> Arc<Scene> {
        let is_same = |(obstacles, facts, _): &&(Arc<Vec<claims::dimibot::Obstacle>>, Facts, Arc<Scene>)| {
            Arc::ptr_eq(obstacles, &order.obstacles) && *facts == order.facts
        };
        if let Some((_, _, scene)) = self.known.iter().find(is_same) {
            return Arc::clone(scene);
        }
        let scene = Scene::new(order).expect("the checker admits only what a field can be built from");
        let scene = Arc::new(scene);
        self.known.push((Arc::clone(&order.obstacles), order.facts.clone(), Arc::clone(&scene)));
        scene
    }
}

impl Scene {
    /// `None` only for a robot or an obstacle that the checker lets nobody declare.
    fn new(order: &DimibotOrder) -> Option<Scene> {
        let facts = &order.facts;
        let lattice = Lattice::new([facts.left, facts.right], Side::BOTH.map(|side| facts.pitch_um(side))).ok()?;
        let growth_um = facts.growth_um();
        let obstacles: Vec<Obstacle> = order.obstacles.iter().map(|obstacle| body(&obstacle.body, growth_um)).collect();
        let field = Field::new(lattice, &obstacles).ok()?;
        Some(Scene { field, obstacles })
    }
}

fn body(body: &Body, growth_um: f64) -> Obstacle {
    match body {
        Body::Cells { from, to } => Obstacle::Cells { from: from.pair(), to: to.pair() },
        Body::Solid { shape, pose } => Obstacle::Physical { shape: shape.clone(), pose: *pose, growth_um },
    }
}

/// What the plans of a schedule leave behind for those that follow.
#[derive(Default)]
pub struct Standing {
    /// Where each robot stands, by its device.
    cells: BTreeMap<String, Cell>,
    fields: Fields,
}

/// A plan for a job; without one an error was pushed.
pub fn plan(job: &Job, order: &DimibotOrder, standing: &mut Standing, sink: &mut Sink) -> Option<Plan> {
    let stands = standing.cells.get(&job.device).copied();
    let (plan, end) = planned(job, order, stands, &mut standing.fields, sink);
    standing.cells.insert(job.device.clone(), end);
    plan
}

/// A plan for a job, and where the robot stands after it.
fn planned(
    job: &Job,
    order: &DimibotOrder,
    stands: Option<Cell>,
    fields: &mut Fields,
    sink: &mut Sink,
) -> (Option<Plan>, Cell) {
    let Some(start) = start(job, order, stands, sink) else {
        return (None, end_of(order).or(stands).unwrap_or(order.facts.home));
    };
    let scene = fields.scene(order);
    let mut search = Search { job, order, scene: &scene, at: start, tally: Tally::default(), sink };
    if !search.begins_clear() {
        return (None, end_of(order).unwrap_or(start));
    }
    let steps: Vec<Option<StepMotion>> = order.steps.iter().map(|step| search.step(step)).collect();
    let (at, tally) = (search.at, search.tally);
    let Some(steps) = steps.into_iter().collect::<Option<Vec<StepMotion>>>() else { return (None, at) };
    let motion = Motion { start, steps };
    let plan = finished(order, motion, tally);
    let mut known = |requirement: &Requirement| {
        let other = best(job, order, &requirement.outcome, stands, fields);
        let proven = other.as_ref().filter(|best| best.proof == Optimality::Proven);
        let least = proven.and_then(|best| best.outcomes.get(&requirement.outcome).copied());
        Known { none_keeps_all: false, least, other }
    };
    let kept = require(job, &plan, &mut known, sink);
    (Some(plan).filter(|_| kept == Kept::Yes), at)
}

/// Where a job begins; `None` if it says another place than where its device stands, which was reported.
fn start(job: &Job, order: &DimibotOrder, stands: Option<Cell>, sink: &mut Sink) -> Option<Cell> {
    match (order.start, stands) {
        (Some(start), Some(stands)) if start.value != stands => {
            sink.push(start_disagrees(order, start, stands, job));
            None
        }
        (Some(start), _) => Some(start.value),
        (None, Some(stands)) => Some(stands),
        (None, None) => Some(order.facts.home),
    }
}

/// The last fixed goal of an order.
fn end_of(order: &DimibotOrder) -> Option<Cell> {
    order.steps.iter().rev().find_map(|step| match &step.action {
        Action::Move(stops) | Action::Visit(stops) => stops.last().map(|stop| stop.cell),
        Action::Wait(_) => None,
    })
}

/// Costs and bounds of the searches so far, in the units of their weights.
#[derive(Default)]
struct Tally {
    cost: u64,
    bound: u64,
}

struct Search<'a> {
    job: &'a Job,
    order: &'a DimibotOrder,
    scene: &'a Scene,
    at: Cell,
    tally: Tally,
    sink: &'a mut Sink,
}

impl Search<'_> {
    fn begins_clear(&mut self) -> bool {
        let covering = self.scene.field.covering(self.at);
        let obstacles: Vec<(&str, Span)> = covering
            .iter()
            .map(|index| &self.order.obstacles[*index])
            .map(|obstacle| (obstacle.name.as_str(), obstacle.span))
            .collect();
        if !obstacles.is_empty() {
            let (task, at) = (&self.job.task, self.at.to_string());
            self.sink.push(errors::start_covered(self.job.run_span, task, &at, &obstacles));
        }
        covering.is_empty()
    }

    fn step(&mut self, step: &Step) -> Option<StepMotion> {
        match &step.action {
            Action::Wait(duration_ns) => Some(StepMotion::Wait(*duration_ns)),
            Action::Move(stops) => {
                let legs: Vec<Option<Vec<Pulse>>> = stops.iter().map(|stop| self.leg(step.span, stop)).collect();
                let legs: Option<Vec<Vec<Pulse>>> = legs.into_iter().collect();
                Some(StepMotion::Pulses(legs?.concat()))
            }
            Action::Visit(stops) => self.visit(step.span, stops).map(StepMotion::Pulses),
        }
    }

    /// The pulses to one stop. Without a way the search goes on from the stop, so that later steps have their say.
    fn leg(&mut self, step: Span, stop: &Stop) -> Option<Vec<Pulse>> {
        let from = std::mem::replace(&mut self.at, stop.cell);
        if self.uses_pulses() {
            let outcome = pulses(&self.scene.field, from, stop.cell, self.budget());
            let train = self.found(step, from, stop, outcome)?;
            self.add(train.cost(), train.bound);
            return Some(train.pulses);
        }
        let outcome = self.path(from, stop.cell);
        let path = self.found(step, from, stop, outcome)?;
        self.add(path.cost, path.bound);
        Some(path.flips.into_iter().map(single).collect())
    }

    fn path(&self, from: Cell, to: Cell) -> Outcome<Path> {
        let method = match self.order.planner.method {
            Method::StagedAstar => shortest,
            Method::Dijkstra => published::dijkstra,
            Method::BidirectionalDijkstra => published::bidirectional_dijkstra,
            Method::Astar => published::astar,
            Method::HypercubeAstar => published::hypercube_astar,
        };
        method(&self.scene.field, from, to, &self.weights(), self.budget())
    }

    fn visit(&mut self, step: Span, stops: &[Stop]) -> Option<Vec<Pulse>> {
        let places: Vec<Cell> = stops.iter().map(|stop| stop.cell).collect();
        let measure = if self.uses_pulses() { Measure::Pulses } else { Measure::Flips(self.weights()) };
        let from = self.at;
        match tour(&self.scene.field, from, &places, &measure, self.budget()) {
            TourOutcome::Found(tour) => {
                self.add(tour.cost, tour.bound);
                self.at = tour.order.last().map_or(from, |last| places[*last]);
                Some(tour.legs.into_iter().flat_map(leg_pulses).collect())
            }
            TourOutcome::Impossible { place, proof } => {
                self.at = places.last().copied().unwrap_or(from);
                self.impossible(stops[place].span, from, &stops[place], proof);
                None
            }
            TourOutcome::GaveUp(gave_up) => {
                self.at = places.last().copied().unwrap_or(from);
                self.gave_up(step, "the places of this `visit`", gave_up);
                None
            }
        }
    }

    /// Whether several modules may be switched in one pulse, and pulses are what counts.
    fn uses_pulses(&self) -> bool {
        uses_pulses(self.order)
    }

    fn weights(&self) -> Weights {
        let lattice = self.scene.field.lattice();
        match self.order.objective {
            Objective::Distance => Weights::distance(lattice),
            Objective::Switches | Objective::Time | Objective::Energy => Weights::switches(lattice),
        }
    }

    fn budget(&self) -> Budget {
        Budget::of(self.order.planner.expansions)
    }

    fn add(&mut self, cost: u64, bound: u64) {
        self.tally.cost += cost;
        self.tally.bound += bound;
    }

    fn found<P>(&mut self, step: Span, from: Cell, stop: &Stop, outcome: Outcome<P>) -> Option<P> {
        match outcome {
            Outcome::Found(found) => Some(found),
            Outcome::Impossible(proof) => {
                self.impossible(step, from, stop, proof);
                None
            }
            Outcome::GaveUp(gave_up) => {
                self.gave_up(step, &stop.cell.to_string(), gave_up);
                None
            }
        }
    }

    fn impossible(&mut self, step: Span, from: Cell, stop: &Stop, proof: Impossible) {
        let why = why(&self.scene.field, &self.scene.obstacles, from, stop.cell, WHY_BUDGET);
        let blamed: Vec<(&str, Span)> = why
            .iter()
            .flat_map(|why| &why.obstacles)
            .map(|index| {
                let obstacle = &self.order.obstacles[*index];
                (obstacle.name.as_str(), obstacle.span)
            })
            .collect();
        let removal = match why.as_ref().map(|why| why.opening) {
            Some(Opening::Smallest) => Removal::OpensAndIsSmallest,
            Some(Opening::Irreducible | Opening::Opens) => Removal::Opens,
            Some(Opening::Unknown) | None => Removal::Unknown,
        };
        let ends = (step, from.to_string(), stop.cell.to_string());
        let ends = (ends.0, ends.1.as_str(), ends.2.as_str());
        self.sink.push(errors::impossible(ends, &proof_text(proof.proof), &blamed, removal));
    }

    fn gave_up(&mut self, step: Span, to: &str, gave_up: GaveUp) {
        let bound = figure(self.order, gave_up.bound);
        let bound = format!("{} {}", crate::quantity::digits(bound), self.order.objective.unit());
        let planner = self.order.planner.method.name();
        let what = format!("planner `{planner}`");
        self.sink.push(errors::gave_up(step, to, &what, gave_up.budget.steps, bound.trim_end(), planner));
    }
}

fn proof_text(proof: Proof) -> String {
    match proof {
        Proof::StartOutside | Proof::GoalOutside => "not a cell of the lattice".to_owned(),
        Proof::StartCovered => "begins on an obstacle".to_owned(),
        Proof::GoalCovered => "ends on an obstacle".to_owned(),
        Proof::BlocksApart => "cannot be reached: whole regions of the lattice are cut off from one another".to_owned(),
        Proof::StartShut { cells: 1 } => "not one switch is free where it begins".to_owned(),
        Proof::GoalShut { cells: 1 } => "no switch leads to it".to_owned(),
        Proof::StartShut { cells } => format!("only {cells} cells can be reached, all were searched"),
        Proof::GoalShut { cells } => format!("it can be reached from {cells} cells only, all were searched"),
    }
}

fn uses_pulses(order: &DimibotOrder) -> bool {
    order.simultaneous == Simultaneous::Safe
        && order.objective == Objective::Time
        && order.planner.method == Method::StagedAstar
}

fn single(flip: Flip) -> Pulse {
    let mask = 1 << flip.module;
    match flip.side {
        Side::Left => Pulse { left: mask, right: 0 },
        Side::Right => Pulse { left: 0, right: mask },
    }
}

fn leg_pulses(leg: Leg) -> Vec<Pulse> {
    match leg {
        Leg::Flips(flips) => flips.into_iter().map(single).collect(),
        Leg::Pulses(train) => train.pulses,
    }
}

/// A search's cost in the unit of the objective, waits left out.
fn figure(order: &DimibotOrder, cost: u64) -> f64 {
    let facts = &order.facts;
    let cost = cost as f64;
    match order.objective {
        Objective::Distance => cost * facts.pitch_um(Side::Left).min(facts.pitch_um(Side::Right)),
        Objective::Switches => cost,
        Objective::Time => cost * (facts.pulse_duration_ns + facts.rest_ns) as f64 / 1e6,
        Objective::Energy => cost * facts.switch_energy_j() * 1e3,
    }
}

fn finished(order: &DimibotOrder, motion: Motion, tally: Tally) -> Plan {
    let waits_ms = match order.objective {
        Objective::Time => waits_ns(&motion) as f64 / 1e6,
        Objective::Distance | Objective::Switches | Objective::Energy => 0.0,
    };
    Plan {
        planner: order.planner.method.name(),
        objective: order.objective.name(),
        unit: order.objective.unit(),
        cost: figure(order, tally.cost) + waits_ms,
        bound: figure(order, tally.bound) + waits_ms,
        bounds: BTreeMap::new(),
        proof: if tally.cost == tally.bound { Optimality::Proven } else { Optimality::Open },
        outcomes: outcomes(order, &motion),
        remarks: Vec::new(),
        motion: AnyMotion::Dimibot(motion),
    }
}

fn waits_ns(motion: &Motion) -> u128 {
    motion
        .steps
        .iter()
        .map(|step| match step {
            StepMotion::Pulses(_) => 0,
            StepMotion::Wait(duration_ns) => u128::from(*duration_ns),
        })
        .sum()
}

/// Every figure of a plan, in SI units.
fn outcomes(order: &DimibotOrder, motion: &Motion) -> BTreeMap<String, f64> {
    let facts = &order.facts;
    let (mut pulse_count, mut switches, mut cells) = (0u64, 0u64, [0u64; 2]);
    for step in &motion.steps {
        let StepMotion::Pulses(pulses) = step else { continue };
        pulse_count += pulses.len() as u64;
        for pulse in pulses {
            switches += u64::from(pulse.left.count_ones() + pulse.right.count_ones());
            cells[0] += u64::from(pulse.left);
            cells[1] += u64::from(pulse.right);
        }
    }
    let distance_um = cells[0] as f64 * facts.pitch_um(Side::Left) + cells[1] as f64 * facts.pitch_um(Side::Right);
    let slot_ns = u128::from(facts.pulse_duration_ns + facts.rest_ns);
    let time_ns = u128::from(pulse_count) * slot_ns + waits_ns(motion);
    BTreeMap::from([
        ("distance".to_owned(), distance_um / 1e6),
        ("switches".to_owned(), switches as f64),
        ("time".to_owned(), time_ns as f64 / 1e9),
        ("energy".to_owned(), switches as f64 * facts.switch_energy_j()),
    ])
}

/// The plan that minimises an outcome instead.
fn best(job: &Job, order: &DimibotOrder, outcome: &str, stands: Option<Cell>, fields: &mut Fields) -> Option<Plan> {
    let objective = match outcome {
        "distance" => Objective::Distance,
        "switches" => Objective::Switches,
        "time" => Objective::Time,
        "energy" => Objective::Energy,
        _ => return None,
    };
    let unconstrained = Job { requirements: Vec::new(), ..job.clone() };
    let order = DimibotOrder { objective, ..order.clone() };
    planned(&unconstrained, &order, stands, fields, &mut Sink::default()).0
}
