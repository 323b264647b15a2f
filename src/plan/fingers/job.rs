//! One job of a hand: each stretch from a first grasp to a release as one problem, then the ways of the fingers.
//!
//! After each stretch the part stands where its turns and translations have carried it, so a stretch without a plan leaves those
//! after it without a beginning: the job ends there.

use super::course::{follow, reconfigurations};
use super::graph::{self, Answer, Costs, Estimator, Grasp, Request, Start};
use super::mechanics::TooManyGrasps;
use super::routes::{Holding, Routes, routes};
use super::sections::{Sections, Sifted};
use super::ways::{self, Act, Course};
use super::why::Why;
use super::{Hold, Motion, Stance};
use crate::check::claims::Job;
use crate::check::claims::fingers::{Action, FingersOrder, Planner, Turn};
use crate::device::fingers::Plane;
use crate::diagnostic::Sink;
use crate::plan::requirements::{Kept, Known, require};
use crate::plan::search::{Budget, GaveUp};
use crate::plan::{Motion as AnyMotion, Optimality, Plan, Remark};
use nalgebra::{Quaternion, UnitQuaternion};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::ops::Range;

/// What the plans of a schedule leave behind for those that follow.
#[derive(Default)]
pub struct Standing {
    /// By device; `None` where a plan is missing, so that nobody knows where its part is.
    stances: BTreeMap<String, Option<Stance>>,
}

/// A plan for a job; without one an error was pushed, for this job or for one of the same hand before it.
pub fn plan(job: &Job, order: &FingersOrder, standing: &mut Standing, sink: &mut Sink) -> Option<Plan> {
    let known = standing.stances.get(&job.device).cloned();
    let planned = match known {
        Some(None) => None,
        Some(Some(stance)) => planned(job, order, Some(stance), sink),
        None => planned(job, order, None, sink),
    };
    let (plan, stance) = planned.map_or((None, None), |(plan, stance)| (plan, Some(stance)));
    standing.stances.insert(job.device.clone(), stance);
    plan
}

/// A plan, and where everything is after it.
fn planned(job: &Job, order: &FingersOrder, stance: Option<Stance>, sink: &mut Sink) -> Option<(Option<Plan>, Stance)> {
    let mut sections = match Sections::of(order) {
        Ok(sections) => sections,
        Err(error) => {
            sink.push(Why { order, at: 0 }.not_followed(&error));
            return None;
        }
    };
    let start = stance.unwrap_or_else(|| sections.hand().home(order.part.position_um));
    let mut tally = Tally::of(order, start.clone());
    for stretch in stretches(order) {
        tally.carry_out(&mut sections, stretch, sink)?;
    }
    let course = Course { start, steps: tally.acts };
    let motion = match sections.hand().motion(&course) {
        Ok(motion) => motion,
        Err(error) => {
            sink.push(Why { order, at: 0 }.no_way(&error));
            return None;
        }
    };
    let end = ways::end(&motion);
    let plan = tally.sums.plan(order, motion);
    let kept = require(job, &plan, &mut |_| Known::default(), sink);
    Some(((kept == Kept::Yes).then_some(plan), end))
}

/// The steps of an order, cut after each release.
fn stretches(order: &FingersOrder) -> Vec<Range<usize>> {
    let mut stretches = Vec::new();
    let mut begin = 0;
    for (step, _) in order.steps.iter().enumerate().filter(|(_, step)| step.action == Action::Release) {
        stretches.push(begin..step + 1);
        begin = step + 1;
    }
    if begin < order.steps.len() {
        stretches.push(begin..order.steps.len());
    }
    stretches
}

/// A plan while its stretches are carried out.
struct Tally<'a> {
    order: &'a FingersOrder,
    acts: Vec<Vec<Act>>,
    held: Option<Holding>,
    orientation: UnitQuaternion<f64>,
    sums: Sums,
}

/// What the stretches cost together.
#[derive(Default)]
struct Sums {
    /// In units of [`costs`].
    cost: u64,
    bound: u64,
    reconfigurations: u64,
    remarks: Vec<Remark>,
}

impl<'a> Tally<'a> {
    fn of(order: &'a FingersOrder, start: Stance) -> Tally<'a> {
        let Hold { grasp, plane, orientation: [w, x, y, z], .. } = start.hold;
        let held = Grasp::of(&grasp).filter(|grasp| grasp.holding() > 0);
        Tally {
            order,
            acts: vec![Vec::new(); order.steps.len()],
            held: held.map(|grasp| Holding { grasp, plane }),
            orientation: UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
            sums: Sums::default(),
        }
    }

    /// Plans a stretch and does what it says; `None` after an error.
    fn carry_out(&mut self, sections: &mut Sections, stretch: Range<usize>, sink: &mut Sink) -> Option<()> {
        let takes = stretch.clone().any(|step| {
            matches!(
                self.order.steps[step].action,
                Action::Grasp(_) | Action::Rotate { .. } | Action::Orient { .. } | Action::Translate(_)
            )
        });
        if takes {
            self.turn(sections, stretch.clone(), sink)?;
        }
        for step in stretch {
            match &self.order.steps[step].action {
                Action::Translate(by_um) => self.acts[step].push(Act::Translate(*by_um)),
                Action::Wait(duration_ns) => self.acts[step].push(Act::Wait(*duration_ns)),
                Action::Release => self.release(sections, step, sink)?,
                Action::Grasp(_) | Action::Rotate { .. } | Action::Orient { .. } => (),
            }
        }
        Some(())
    }

    /// The cheapest way through the turns of a stretch.
    fn turn(&mut self, sections: &mut Sections, stretch: Range<usize>, sink: &mut Sink) -> Option<()> {
        let planned = routes(self.order, stretch.clone(), self.held);
        let way = match sound(self.order, sections, &planned, self.orientation) {
            Ok(Answer::Found(way)) => way,
            Ok(stuck) => {
                let why = Why { order: self.order, at: stuck_at(&planned, &stuck) };
                sink.push(why.stuck(&stuck, &planned, (self.held, self.orientation, stretch)));
                return None;
            }
            Err(too_many) => {
                sink.push(Why { order: self.order, at: stretch.start }.too_many(&too_many));
                return None;
            }
        };
        let route = &planned.routes[way.route];
        let is_grasp = |step: &usize| matches!(self.order.steps[*step].action, Action::Grasp(_));
        let first = route.first().map_or(stretch.start, |turning| turning.step);
        let begins = stretch.clone().find(is_grasp).map_or(first, |grasp| grasp.min(first));
        let fingers = self.order.facts.fingers as usize;
        follow(&mut self.acts, (route, &way), self.held.is_none().then_some(begins), fingers);
        self.sums.cost += way.cost;
        self.sums.bound += planned.left_out.map_or(way.bound, |steps| way.bound.min(2 * ROLL * steps));
        self.sums.reconfigurations += reconfigurations(&way);
        let is_free = |step: usize| matches!(self.order.steps[step].action, Action::Orient { .. });
        if route.iter().any(|turning| is_free(turning.step)) {
            let said: Vec<String> = route.iter().map(|turning| said(self.order, turning.turn)).collect();
            self.sums.remarks.push(Remark { subject: "turns".to_owned(), text: said.join(", ") });
        }
        for turning in route {
            self.orientation = sections.turned(self.orientation, turning.turn);
        }
        let last = way.legs.last().and_then(|nodes| nodes.last())?;
        self.held = route.last().map(|turning| Holding { grasp: last.grasp, plane: turning.turn.plane });
        Some(())
    }

    /// All fingers leave, each when those that stay hold by themselves.
    fn release(&mut self, sections: &mut Sections, step: usize, sink: &mut Sink) -> Option<()> {
        let Some(holding) = self.held.take() else { return Some(()) };
        let Some(order) = sections.leaving(holding, self.orientation) else {
            sink.push(Why { order: self.order, at: step }.stuck_fingers());
            return None;
        };
        self.acts[step].push(Act::Release { order });
        Some(())
    }
}

/// How often a search is made anew after a closer look at the way that it found.
const MAX_LOOKS: usize = 100;

/// The answer of the planner, with a way whose grasps hold all the time.
fn sound(
    order: &FingersOrder,
    sections: &mut Sections,
    planned: &Routes,
    orientation: UnitQuaternion<f64>,
) -> Result<Answer, TooManyGrasps> {
    let mut bound = 0;
    for _ in 0..MAX_LOOKS {
        let answer = answer(order, sections, planned, orientation)?;
        let Answer::Found(way) = &answer else { return Ok(answer) };
        if sections.sift(&planned.routes[way.route], way, orientation) == Sifted::Sound {
            return Ok(answer);
        }
        bound = way.bound;
    }
    let budget = Budget::of(order.expansions);
    Ok(Answer::GaveUp(GaveUp { budget, spent: budget.steps, bound }))
}

/// What rolling by a step costs a finger, in the unit of [`costs`].
const ROLL: u64 = 360;

/// Costs as whole numbers: their unit is a degree divided by the steps of a turn.
fn costs(order: &FingersOrder) -> Costs {
    let gait = order.facts.gaiting_cost_deg * f64::from(order.facts.steps_per_turn);
    Costs { roll: ROLL as u32, gait: gait.round() as u32 }
}

/// The answer of the planner that the task asks for.
pub fn answer(
    order: &FingersOrder,
    sections: &mut Sections,
    planned: &Routes,
    orientation: UnitQuaternion<f64>,
) -> Result<Answer, TooManyGrasps> {
    let legs: Result<Vec<_>, _> = planned.routes.iter().map(|route| sections.legs(route, orientation)).collect();
    let request = Request {
        fingers: order.facts.fingers as usize,
        start: planned.start.map_or(Start::Any, Start::At),
        routes: legs?,
        costs: costs(order),
    };
    let budget = Budget::of(order.expansions);
    Ok(match order.planner {
        Planner::JointAstar => graph::solve(&request, Estimator::Layers, budget),
        Planner::PublishedAstar => graph::solve(&request, Estimator::Published, budget),
        Planner::GreedyDecomposition => graph::decompose(&request, Estimator::Published, budget),
    })
}

/// The step of the leg that an answer without a way ends at.
fn stuck_at(planned: &Routes, answer: &Answer) -> usize {
    let at = |route: usize, leg: usize| planned.routes.get(route).and_then(|route| route.get(leg));
    let leg = match answer {
        Answer::Impossible(blocked) => at(blocked.route, blocked.leg),
        Answer::Found(_) | Answer::GaveUp(_) | Answer::TooLarge { .. } => at(0, 0),
    };
    leg.map_or(0, |turning| turning.step)
}

/// A turn in words: `80 deg about z`.
fn said(order: &FingersOrder, turn: Turn) -> String {
    let axis = match turn.plane {
        Plane::Xy => "z",
        Plane::Xz => "y",
    };
    let degrees = f64::from(turn.steps) * 360.0 / f64::from(order.facts.steps_per_turn);
    format!("{} deg about {axis}", crate::quantity::digits(degrees))
}

impl Sums {
    fn plan(self, order: &FingersOrder, motion: Motion) -> Plan {
        let degrees = |cost: u64| cost as f64 / f64::from(order.facts.steps_per_turn);
        let time_s = ways::duration_ns(&motion).unwrap_or(u64::MAX) as f64 / 1e9;
        let outcomes = [
            ("effort", degrees(self.cost) * PI / 180.0),
            ("reconfigurations", self.reconfigurations as f64),
            ("time", time_s),
        ];
        Plan {
            planner: match order.planner {
                Planner::JointAstar => "joint_astar",
                Planner::PublishedAstar => "published_astar",
                Planner::GreedyDecomposition => "greedy_decomposition",
            },
            objective: "effort",
            unit: "deg",
            cost: degrees(self.cost),
            bound: degrees(self.bound),
            proof: if self.bound >= self.cost { Optimality::Proven } else { Optimality::Open },
            bounds: BTreeMap::new(),
            outcomes: outcomes.map(|(name, value)| (name.to_owned(), value)).into_iter().collect(),
            remarks: self.remarks,
            motion: AnyMotion::Fingers(motion),
        }
    }
}
