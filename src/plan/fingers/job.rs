//! One job of a hand: each stretch from a first grasp to a release as one problem, then the ways of the fingers.
//!
//! After each stretch the part stands where its turns and translations have carried it, so a stretch without a plan leaves those
//! after it without a beginning: the job ends there.

use super::course::{follow, reconfigurations};
use super::graph::{self, Answer, Costs, Estimator, Grasp, Node, Request, Start, Way};
use super::mechanics::TooManyGrasps;
use super::routes::{Holding, Routes, Turning, routes};
use super::sections::{Sections, Sifted};
use super::ways::{self, Act, Course};
use super::why::{Why, kept_back};
use super::{Hold, Motion, Stance};
use crate::check::claims::fingers::{Action, FingersOrder, Planner, Turn};
use crate::check::claims::{Job, Requirement};
use crate::device::fingers::Plane;
use crate::diagnostic::Sink;
use crate::plan::requirements::{Kept, Known, is_upper, keeps, require};
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

/// What a way is chosen by first.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum First {
    Effort,
    /// Then by what is rolled.
    Reconfigurations,
}

/// A plan, and where everything is after it.
///
/// Ways are chosen by effort. Where that misses a limit of reconfigurations, they are chosen by these first: such a plan keeps the
/// limit if any does.
fn planned(job: &Job, order: &FingersOrder, stance: Option<Stance>, sink: &mut Sink) -> Option<(Option<Plan>, Stance)> {
    let (mut plan, mut end) = carried_out(order, stance.as_ref(), First::Effort, sink)?;
    let mut fewest = None;
    if misses(job, &plan, "reconfigurations")
        && let Some((other, other_end)) =
            carried_out(order, stance.as_ref(), First::Reconfigurations, &mut Sink::default())
    {
        fewest = (other.proof == Optimality::Proven).then(|| other.outcomes["reconfigurations"]);
        let bound = plan.bound;
        if job.requirements.iter().all(|limit| is_kept(limit, &other)) {
            let proof = if bound >= other.cost { Optimality::Proven } else { Optimality::Open };
            (plan, end) = (Plan { bound, proof, ..other }, other_end);
        }
    }
    let least_effort_rad = plan.bound.to_radians();
    let known = &mut |limit: &Requirement| Known {
        least: match limit.outcome.as_str() {
            "effort" => Some(least_effort_rad),
            "reconfigurations" => fewest,
            _ => None,
        },
        ..Known::default()
    };
    let kept = require(job, &plan, known, sink);
    Some(((kept == Kept::Yes).then_some(plan), end))
}

fn is_kept(limit: &Requirement, plan: &Plan) -> bool {
    plan.outcomes.get(&limit.outcome).is_none_or(|reached| keeps(limit, *reached) == Kept::Yes)
}

/// Whether a plan is above a limit of an outcome.
fn misses(job: &Job, plan: &Plan, outcome: &str) -> bool {
    job.requirements.iter().any(|limit| limit.outcome == outcome && is_upper(limit) && !is_kept(limit, plan))
}

/// A plan whatever its limits, and where everything is after it. Its proof is of what it was chosen by first.
fn carried_out(order: &FingersOrder, stance: Option<&Stance>, first: First, sink: &mut Sink) -> Option<(Plan, Stance)> {
    let mut sections = match Sections::of(order) {
        Ok(sections) => sections,
        Err(error) => {
            sink.push(Why { order, at: 0 }.not_followed(&error));
            return None;
        }
    };
    let start = stance.cloned().unwrap_or_else(|| sections.hand().home(order.part.position_um));
    let mut tally = Tally::of(order, start.clone(), first);
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
    if let Some(share) = kept_back(order).filter(|_| tally.sums.cost > 0) {
        let text = format!("{share} % of friction and forces while it rolls (`rolling_reserve`)");
        tally.sums.remarks.push(Remark { subject: "kept back".to_owned(), text });
    }
    Some((tally.sums.plan(order, motion), end))
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
    /// Whether the part may be turned otherwise by now, had another way been taken.
    may_differ: bool,
    first: First,
    sums: Sums,
}

/// What the stretches cost together.
struct Sums {
    /// The effort, in units of [`costs`].
    cost: u64,
    /// In the same units, of what ways are chosen by first: of effort, or of nothing but reconfigurations.
    bound: u64,
    /// Whether each way is the best by what it was chosen by.
    is_best: bool,
    reconfigurations: u64,
    remarks: Vec<Remark>,
}

impl<'a> Tally<'a> {
    fn of(order: &'a FingersOrder, start: Stance, first: First) -> Tally<'a> {
        let Hold { grasp, plane, orientation: [w, x, y, z], .. } = start.hold;
        let held = Grasp::of(&grasp).filter(|grasp| grasp.holding() > 0);
        Tally {
            order,
            acts: vec![Vec::new(); order.steps.len()],
            held: held.map(|grasp| Holding { grasp, plane }),
            orientation: UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)),
            may_differ: false,
            first,
            sums: Sums { cost: 0, bound: 0, is_best: true, reconfigurations: 0, remarks: Vec::new() },
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
        let mut planned = routes(self.order, stretch.clone(), self.held);
        // Under a load another way before might have left the part so that it is held more easily.
        if self.may_differ && self.order.load_un != [0.0; 3] {
            let least = planned.routes.iter().map(|route| steps_of(route)).min().unwrap_or_default();
            planned.left_out = Some(planned.left_out.map_or(least, |known| known.min(least)));
        }
        let way = match sound(self.order, sections, &planned, self.orientation, self.first) {
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
        self.sums.cost += effort(self.order, &way);
        let bound = match self.first {
            First::Effort => way.bound,
            First::Reconfigurations => 0,
        };
        self.sums.bound += planned.left_out.map_or(bound, |steps| bound.min(2 * ROLL * steps));
        self.sums.is_best &= planned.left_out.is_none() && way.bound >= way.cost;
        self.sums.reconfigurations += reconfigurations(&way);
        let is_free = |step: usize| matches!(self.order.steps[step].action, Action::Orient { .. });
        self.may_differ |= planned.routes.len() > 1;
        if route.iter().any(|turning| is_free(turning.step)) {
            let said: Vec<String> = route.iter().map(|turning| said(sections, turning.turn)).collect();
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

/// The answer of the planner, with a way whose grasps hold all the time.
///
/// A way with a grasp that lapses between two angles is searched again without that step, as often as it takes: every search has
/// fewer steps left. All of them together keep to the budget.
///
/// # Errors
/// Where a section has too many contacts for its tables.
pub fn sound(
    order: &FingersOrder,
    sections: &mut Sections,
    planned: &Routes,
    orientation: UnitQuaternion<f64>,
    first: First,
) -> Result<Answer, TooManyGrasps> {
    let (mut left, mut bound) = (order.expansions, 0);
    loop {
        match answer(order, sections, planned, orientation, (first, Budget::of(left)))? {
            Answer::Found(way) => {
                if sections.sift(&planned.routes[way.route], &way, orientation) == Sifted::Sound {
                    return Ok(Answer::Found(way));
                }
                left = left.saturating_sub(way.expanded);
                bound = way.bound;
            }
            Answer::GaveUp(gave_up) => {
                let (budget, bound) = (Budget::of(order.expansions), bound.max(gave_up.bound));
                return Ok(Answer::GaveUp(GaveUp { budget, spent: budget.steps, bound }));
            }
            other @ (Answer::Impossible(_) | Answer::TooLarge { .. }) => return Ok(other),
        }
    }
}

/// What rolling by a step costs a finger, in the unit of [`costs`].
const ROLL: u64 = 360;

/// What a reconfiguration costs where their number comes first: more steps than fingers roll in any way.
const MORE_THAN_ALL_ROLLING: u32 = 1 << 24;

/// The steps that a route rolls at least.
fn steps_of(route: &[Turning]) -> u64 {
    route.iter().map(|turning| u64::from(turning.turn.steps.unsigned_abs())).sum()
}

/// What a way costs, in units of [`costs`].
fn effort(order: &FingersOrder, way: &Way) -> u64 {
    let Costs { roll, gait } = costs(order);
    let pairs = way.legs.iter().flat_map(|nodes| nodes.windows(2));
    let cost = |pair: &[Node]| match pair[0].angle == pair[1].angle {
        true => u64::from(gait),
        false => u64::from(roll) * pair[0].grasp.holding() as u64,
    };
    pairs.map(cost).sum()
}

/// Costs as whole numbers: their unit is a degree divided by the steps of a turn.
fn costs(order: &FingersOrder) -> Costs {
    let gait = order.facts.gaiting_cost_deg * f64::from(order.facts.steps_per_turn);
    Costs { roll: ROLL as u32, gait: gait.round() as u32 }
}

/// The answer of the planner that the task asks for.
fn answer(
    order: &FingersOrder,
    sections: &mut Sections,
    planned: &Routes,
    orientation: UnitQuaternion<f64>,
    (first, budget): (First, Budget),
) -> Result<Answer, TooManyGrasps> {
    let legs: Result<Vec<_>, _> = planned.routes.iter().map(|route| sections.legs(route, orientation)).collect();
    let request = Request {
        fingers: order.facts.fingers as usize,
        start: planned.start.map_or(Start::Any, Start::At),
        routes: legs?,
        costs: match first {
            First::Effort => costs(order),
            First::Reconfigurations => Costs { roll: 1, gait: MORE_THAN_ALL_ROLLING },
        },
    };
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

/// A turn in words, by the angle that its whole steps come to: `79.99 deg about z`.
fn said(sections: &Sections, turn: Turn) -> String {
    let axis = match turn.plane {
        Plane::Xy => "z",
        Plane::Xz => "y",
    };
    let degrees = (f64::from(turn.steps) * sections.step_rad(turn.plane)).to_degrees();
    format!("{} deg about {axis}", crate::quantity::digits((degrees * 1e4).round() / 1e4))
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
            proof: if self.is_best { Optimality::Proven } else { Optimality::Open },
            bounds: BTreeMap::new(),
            outcomes: outcomes.map(|(name, value)| (name.to_owned(), value)).into_iter().collect(),
            remarks: self.remarks,
            motion: AnyMotion::Fingers(motion),
        }
    }
}
