//! Planners: from a job to a plan with its cost, a lower bound, and whether it is proven optimal.
//!
//! Input: the [`Claims`] of a schedule. Output: a [`Plan`] for each job. Promise: a job ends in a plan, in a proof that
//! there is none (with the smallest set of blocking obstacles that could be found), or in a search that gave up and
//! names its budget; an empty plan never means "no". Same request, same plan: budgets count steps, never seconds.

pub mod dimibot;
pub mod electrode_array;
mod errors;
pub mod fingers;
pub mod microrobots;
pub mod parallel;
mod requirements;
pub mod search;
pub mod watch;

use crate::claims::{self, Claims, Job, Order};
use crate::device::{each_kind, for_each_kind};
use crate::diagnostic::{Remark, Sink};
use std::collections::{BTreeMap, BTreeSet};

/// A plan for one job; `M` is the form of its motion.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan<M> {
    pub planner: &'static str,
    pub objective: &'static str,
    /// Unit of `cost` and `bound`; empty for a count.
    pub unit: &'static str,
    pub cost: f64,
    /// Lower bound on the cost of every plan.
    pub bound: f64,
    pub proof: Optimality,
    /// Lower bounds on outcomes that were not minimised.
    pub bounds: BTreeMap<String, f64>,
    /// Outcomes in SI units, by their names in the vocabulary.
    pub outcomes: BTreeMap<String, f64>,
    /// The planner's further remarks, for reports.
    pub remarks: Vec<Remark>,
    pub motion: M,
}

impl<M> Plan<M> {
    /// The same plan with its motion in another form.
    pub fn map<N>(self, form: impl FnOnce(M) -> N) -> Plan<N> {
        let Plan { planner, objective, unit, cost, bound, proof, bounds, outcomes, remarks, motion } = self;
        Plan { planner, objective, unit, cost, bound, proof, bounds, outcomes, remarks, motion: form(motion) }
    }
}

/// Whether a plan is known to be the best.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Optimality {
    Proven,
    Open,
}

/// An order with the motion that carries it out, both of one kind.
#[derive(Debug, Clone, PartialEq)]
pub struct Planned<'a, O, M> {
    pub order: &'a O,
    pub motion: M,
}

/// Motion of the device, in its kind's own terms.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion<'a> {
    Dimibot(Planned<'a, claims::dimibot::DimibotOrder, dimibot::DimibotMotion>),
    ElectrodeArray(Planned<'a, claims::electrode_array::ElectrodeArrayOrder, electrode_array::ElectrodeArrayMotion>),
    Microrobots(Planned<'a, claims::microrobots::MicrorobotsOrder, microrobots::MicrorobotsMotion>),
    Fingers(Planned<'a, claims::fingers::FingersOrder, fingers::FingersMotion>),
}

macro_rules! standings {
    ({} $($module:ident $kind:ident),+) => {
        /// State that the plans of a program hand on to later ones, by kind of device.
        #[derive(Default)]
        struct Standings {
            $($module: $module::Standings,)+
        }
    };
}

for_each_kind!(standings, {});

macro_rules! planned {
    ({ $job:ident, $standings:ident, $sink:ident } $($module:ident $kind:ident),+) => {
        match &$job.order {
            $(Order::$kind(order) => {
                let plan = $module::plan($job, order, &mut $standings.$module, $sink)?;
                Some(plan.map(|motion| Motion::$kind(Planned { order, motion })))
            })+
        }
    };
}

/// Returns a plan for a job, or `None` after an error was pushed, for this job or an earlier one of the same device.
fn planned<'a>(job: &'a Job, standings: &mut Standings, sink: &mut Sink) -> Option<Plan<Motion<'a>>> {
    for_each_kind!(planned, { job, standings, sink })
}

/// Hooks of a device kind for this stage, implemented by its orders.
trait KindPlanner {
    /// Whether a plan chooses where something ends, so that findings about a later task hold only for this choice.
    /// `false` for a kind that searches later tasks from every choice.
    fn chooses_its_end(&self) -> bool;

    /// Returns the plans of a program, changed where devices of this kind would be in one another's way. Called once
    /// per kind; `None` after an error.
    fn resolve_conflicts<'a>(
        &self,
        _claims: &'a Claims,
        plans: Vec<Plan<Motion<'a>>>,
        _sink: &mut Sink,
    ) -> Option<Vec<Plan<Motion<'a>>>> {
        Some(plans)
    }
}

/// The planner of an order.
fn planner(order: &Order) -> &dyn KindPlanner {
    each_kind!(Order, order, order => order)
}

/// Subject of the remark on a search that was ended early.
pub const ENDED_EARLY: &str = "search";

/// Called before each job is planned, with its index, the number of jobs, and its task.
pub type Progress<'a> = &'a mut dyn FnMut(usize, usize, &str);

/// Returns a plan for every job, in their order. `None` if a job has no plan; the errors have then been pushed.
pub fn plan<'a>(claims: &'a Claims, sink: &mut Sink, progress: Progress) -> Option<Vec<Plan<Motion<'a>>>> {
    let mut standings = Standings::default();
    let mut plans = Vec::with_capacity(claims.jobs.len());
    let mut chosen = BTreeSet::new();
    for (index, job) in claims.jobs.iter().enumerate() {
        progress(index, claims.jobs.len(), &job.task);
        watch::begin_run();
        let mut own = Sink::default();
        let mut plan = planned(job, &mut standings, &mut own);
        own.about_device(&job.device);
        // Devices of one kind may share a scene and stand in one another's way: a proof then holds only for the ends
        // that earlier plans chose.
        if chosen.contains(&job.kind()) {
            own.weaken();
        }
        if planner(&job.order).chooses_its_end() {
            chosen.insert(job.kind());
        }
        sink.append(own);
        if let Some(plan) = plan.as_mut().filter(|plan| plan.proof == Optimality::Open && watch::has_ended_early()) {
            plan.remarks.push(Remark {
                subject: ENDED_EARLY.to_owned(),
                text: "ended on request; the best plan so far was kept".to_owned(),
            });
        }
        plans.push(plan);
    }
    let plans = plans.into_iter().collect::<Option<Vec<_>>>()?;
    claims.first_of_kinds().try_fold(plans, |plans, job| planner(&job.order).resolve_conflicts(claims, plans, sink))
}
