//! Planners: from a job to a plan with its cost, a lower bound, and whether it is proven optimal.
//!
//! Input: the [`Claims`] of a schedule. Output: a [`Plan`] for each job. Promise: a job ends in a plan, in a proof that there is
//! none (with the smallest set of blocking obstacles that could be found), or in a search that gave up and names its budget; an
//! empty plan never means "no". Same request, same plan: budgets count steps, never seconds.

pub mod dimibot;
pub mod electrode_array;
mod errors;
pub mod fingers;
pub mod microrobots;
mod requirements;
pub mod search;

use crate::claims::{Claims, Order};
use crate::diagnostic::{Remark, Sink};
use std::collections::BTreeMap;

/// How a job is done.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
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
    pub motion: Motion,
}

/// Whether a plan is known to be the best.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Optimality {
    Proven,
    Open,
}

/// Motion of the device, in its kind's own terms.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    Dimibot(dimibot::DimibotMotion),
    ElectrodeArray(electrode_array::ElectrodeArrayMotion),
    Microrobots(microrobots::MicrorobotsMotion),
    Fingers(fingers::FingersMotion),
}

impl Motion {
    /// The motion, if it is a DiMiBot's.
    pub fn dimibot(&self) -> Option<&dimibot::DimibotMotion> {
        match self {
            Motion::Dimibot(motion) => Some(motion),
            Motion::ElectrodeArray(_) | Motion::Microrobots(_) | Motion::Fingers(_) => None,
        }
    }

    /// The motion, if it is an electrode array's.
    pub fn electrode_array(&self) -> Option<&electrode_array::ElectrodeArrayMotion> {
        match self {
            Motion::ElectrodeArray(motion) => Some(motion),
            Motion::Dimibot(_) | Motion::Microrobots(_) | Motion::Fingers(_) => None,
        }
    }

    /// The motion, if it is of microrobots.
    pub fn microrobots(&self) -> Option<&microrobots::MicrorobotsMotion> {
        match self {
            Motion::Microrobots(motion) => Some(motion),
            Motion::Dimibot(_) | Motion::ElectrodeArray(_) | Motion::Fingers(_) => None,
        }
    }

    /// The motion, if it is of a hand.
    pub fn fingers(&self) -> Option<&fingers::FingersMotion> {
        match self {
            Motion::Fingers(motion) => Some(motion),
            Motion::Dimibot(_) | Motion::ElectrodeArray(_) | Motion::Microrobots(_) => None,
        }
    }
}

/// Called before each job is planned, with its index, the number of jobs, and its task.
pub type Progress<'a> = &'a mut dyn FnMut(usize, usize, &str);

/// A plan for every job, in their order; `None` after an error, which has been pushed for each job without a plan.
pub fn plan(claims: &Claims, sink: &mut Sink, progress: Progress) -> Option<Vec<Plan>> {
    let mut robots = dimibot::DimibotStandings::default();
    let mut trays = electrode_array::BoardStandings::default();
    let mut beds = microrobots::BedStandings::default();
    let mut hands = fingers::HandStandings::default();
    let mut plans = Vec::with_capacity(claims.jobs.len());
    for (index, job) in claims.jobs.iter().enumerate() {
        progress(index, claims.jobs.len(), &job.task);
        plans.push(match &job.order {
            Order::Dimibot(order) => dimibot::plan(job, order, &mut robots, sink),
            Order::ElectrodeArray(order) => electrode_array::plan(job, order, &mut trays, sink),
            Order::Microrobots(order) => microrobots::plan(job, order, &mut beds, sink),
            Order::Fingers(order) => fingers::plan(job, order, &mut hands, sink),
        });
    }
    dimibot::apart(claims, plans.into_iter().collect::<Option<Vec<Plan>>>()?, sink)
}
