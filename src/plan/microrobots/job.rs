//! Plans one job of microrobots: the best motion by the objective, its figures, and its guarantees.

use super::bound::{self, LeastFigures};
use super::guarantee::{StageContainments, estimated_containments, message, tolerated_multiple};
use super::steps::{BedRoute, InitialLegChoice, plan_steps};
use super::strategy::{driven, episodes};
use super::why::BedReasons;
use super::{Crew, MicrorobotsMotion};
use super::{guarantee_trials, reliability};
use crate::claims::microrobots::{Assurance, MicrorobotsAction, MicrorobotsOrder};
use crate::claims::{Job, Requirement};
use crate::device::microrobots::{MicrorobotsObjective, MicrorobotsOutcome, MicrorobotsPlanner};
use crate::diagnostic::{Remark, Sink};
use crate::plan::requirements::{Kept, KnownLimit, require};
use crate::plan::{KindPlanner, Optimality, Plan};
use std::collections::BTreeMap;

/// Subject of the remark on the errors that a whole plan tolerates.
const ALL_ROBOTS: &str = "all robots";

/// State that the plans of a schedule hand on to later jobs.
#[derive(Default)]
pub struct BedStandings {
    /// By device; `None` after a missing plan, since the poses of its robots are then unknown.
    crews: BTreeMap<String, Option<Crew>>,
}

impl BedStandings {
    /// State of the robots of an order before its job, if known.
    fn of(&self, job: &Job, order: &MicrorobotsOrder) -> Option<Crew> {
        let scene = || Crew {
            poses: order.robots.iter().map(|robot| robot.pose).collect(),
            docked: vec![false; order.robots.len()],
        };
        self.crews.get(&job.device).cloned().unwrap_or_else(|| Some(scene()))
    }
}

impl KindPlanner for MicrorobotsOrder {
    /// A driven robot ends somewhere within its precision, and the strokes carry the others along.
    fn chooses_its_end(&self) -> bool {
        self.steps.iter().any(|step| match step.action {
            MicrorobotsAction::Drive { .. } | MicrorobotsAction::Assemble(_) => true,
            MicrorobotsAction::Apply { .. } | MicrorobotsAction::Wait(_) => false,
        })
    }
}

/// Returns a plan for a job, or `None` after an error was pushed, for this job or an earlier one of the same bed.
pub fn plan(
    job: &Job,
    order: &MicrorobotsOrder,
    standing: &mut BedStandings,
    sink: &mut Sink,
) -> Option<Plan<MicrorobotsMotion>> {
    let is_first = !standing.crews.contains_key(&job.device);
    let planned = standing.of(job, order).and_then(|crew| planned(job, order, crew, is_first, sink));
    let (plan, crew) = planned.map_or((None, None), |(plan, crew)| (plan, Some(crew)));
    standing.crews.insert(job.device.clone(), crew);
    plan
}

/// Returns a plan and the state of the robots after it; the plan is `None` if it misses a limit or a demanded
/// guarantee. `is_first`: this is the device's first job, so the robots start in the scene's poses.
fn planned(
    job: &Job,
    order: &MicrorobotsOrder,
    start: Crew,
    is_first: bool,
    sink: &mut Sink,
) -> Option<(Option<Plan<MicrorobotsMotion>>, Crew)> {
    let least = bound::least(order, &start);
    let fastest = plan_steps(order, order, &start, is_first, InitialLegChoice::Best, sink)?;
    let BedRoute { motion, end } = match order.objective {
        MicrorobotsObjective::Time | MicrorobotsObjective::Switches => fastest,
        MicrorobotsObjective::Failures => reliability::most_reliable(order, &start, is_first, fastest),
    };
    let mut tally = BedTally::of(order, &motion, least);
    let are_guaranteed = assure(order, &motion, &mut tally.remarks, sink);
    tally.failing = reliability::failure_share(job, order, &motion, &mut tally.remarks, sink);
    let plan = tally.plan(order.objective, motion);
    let known =
        &mut |limit: &Requirement| KnownLimit { least: least_of(&limit.outcome, least), ..KnownLimit::default() };
    let kept = require(job, &plan, known, sink);
    Some(((kept == Kept::Yes && are_guaranteed).then_some(plan), end))
}

/// Lower bound on an outcome, in its SI unit.
fn least_of(outcome: &str, least: LeastFigures) -> Option<f64> {
    let bounds = [
        (MicrorobotsOutcome::Time, seconds(least.time_ns)),
        (MicrorobotsOutcome::Switches, least.switches as f64),
        (MicrorobotsOutcome::Strokes, least.strokes as f64),
    ];
    bounds.into_iter().find(|(word, _)| word.name() == outcome).map(|(_, bound)| bound)
}

fn seconds(ns: u64) -> f64 {
    ns as f64 / 1e9
}

/// Adds a remark for each docking stage of an assembly: whether it is guaranteed, and up to which errors. Returns
/// `false` if the task demands a guarantee that does not exist.
///
/// With errors that the plan tolerates without any correction, the controller carries it out as written, and the
/// verifier has checked the result. With larger errors nothing is guaranteed; the remark names the first containment
/// that the estimates reject.
fn assure(order: &MicrorobotsOrder, motion: &MicrorobotsMotion, remarks: &mut Vec<Remark>, sink: &mut Sink) -> bool {
    let all = episodes(order, motion);
    let mut docking = all.iter().filter(|episode| !driven(episode.stage).is_empty()).peekable();
    if docking.peek().is_none() {
        return true;
    }
    let is_exact = order.facts.is_exact();
    let tolerated = if is_exact { 1.0 } else { tolerated_multiple(order, motion) };
    let failing = if tolerated > 0.0 { guarantee_trials::failing_trial(order, motion, tolerated) } else { None };
    let multiple = if failing.is_some() { 0.0 } else { tolerated };
    let is_estimated = multiple < 1.0 && failing.is_none();
    let estimates = if is_estimated { estimated_containments(order, motion).unwrap_or_default() } else { Vec::new() };
    let mut all_hold = true;
    for (nth, episode) in docking.enumerate() {
        let names = driven(episode.stage).into_iter().map(|(robot, _)| order.robot(robot).name.as_str());
        let subject = names.collect::<Vec<_>>().join(" and ");
        let why = match (order.facts.errors, estimates.get(nth).and_then(StageContainments::violated)) {
            (Some(_), None) if is_exact && failing.is_none() => {
                let text = "guaranteed: without errors the plan is carried out as it is written".to_owned();
                remarks.push(Remark { subject, text });
                continue;
            }
            (Some(_), None) if multiple >= 1.0 => {
                let text = "guaranteed: with such errors the plan is carried out as it is written".to_owned();
                remarks.push(Remark { subject, text });
                continue;
            }
            (Some(_), Some(violated)) => violated.message(order),
            (Some(_), None) => match &failing {
                Some(failed) => failed.clone(),
                None => "no sound bound is known for errors so large".to_owned(),
            },
            (None, _) => "the device does not say how far robots and measurements may be off".to_owned(),
        };
        if order.assurance == Assurance::Demanded {
            all_hold = false;
            let step = &order.steps[episode.step];
            let says = BedReasons { order, step, docked: &motion.start.docked, is_given: false };
            sink.push(says.not_guaranteed(&subject, &why, multiple));
        }
        if order.facts.errors.is_some() {
            remarks.push(Remark { subject, text: format!("not guaranteed: {why}") });
        }
    }
    if let Some(errors) = order.facts.errors.filter(|_| !is_exact && multiple > 0.0) {
        let text = format!("the plan as written is guaranteed {}", message::limit(&errors, multiple));
        remarks.push(Remark { subject: ALL_ROBOTS.to_owned(), text });
    }
    all_hold
}

/// Totals over the steps of a job.
struct BedTally {
    time_ns: u64,
    /// Lower bounds for any plan of the job.
    least: LeastFigures,
    switches: u64,
    strokes: u64,
    /// Share of simulated trials that fail; `None` if they cannot be simulated.
    failing: Option<f64>,
    remarks: Vec<Remark>,
}

impl BedTally {
    fn of(order: &MicrorobotsOrder, motion: &MicrorobotsMotion, least: LeastFigures) -> BedTally {
        BedTally {
            time_ns: motion.duration_ns(order),
            least,
            switches: motion.steps.iter().map(|step| step.legs().len() as u64).sum(),
            strokes: motion.strokes(),
            failing: None,
            remarks: Vec::new(),
        }
    }

    fn plan(self, objective: MicrorobotsObjective, motion: MicrorobotsMotion) -> Plan<MicrorobotsMotion> {
        let outcomes = [
            (MicrorobotsOutcome::Time, seconds(self.time_ns)),
            (MicrorobotsOutcome::Switches, self.switches as f64),
            (MicrorobotsOutcome::Strokes, self.strokes as f64),
        ];
        let time_s = [self.time_ns, self.least.time_ns].map(seconds);
        let ([cost, bound], is_exact) = match objective {
            MicrorobotsObjective::Time => (time_s, true),
            MicrorobotsObjective::Switches => ([self.switches, self.least.switches].map(|count| count as f64), true),
            // An estimate, which proves nothing; the worst value, 1, if the plan is too long to be simulated.
            MicrorobotsObjective::Failures => ([self.failing.unwrap_or(1.0), 0.0], false),
        };
        Plan {
            planner: MicrorobotsPlanner::OneWayDubins.name(),
            objective: objective.name(),
            unit: objective.unit(),
            cost,
            bound,
            proof: if is_exact && bound >= cost { Optimality::Proven } else { Optimality::Open },
            bounds: BTreeMap::new(),
            outcomes: outcomes.map(|(word, value)| (word.name().to_owned(), value)).into_iter().collect(),
            remarks: self.remarks,
            motion,
        }
    }
}
