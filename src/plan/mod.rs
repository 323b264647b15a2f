//! Planners: from what a job asks to how it is done, with its cost, a lower bound, and whether it is proven optimal.
//!
//! Input: the [`Claims`] of a schedule. Output: a [`Plan`] for each job. Promise: a job ends in a plan, in a proof that there is
//! none (with the smallest set of obstacles that could be found), or in a search that gave up and names its budget; no empty
//! plan ever means "no". Same request, same plan: budgets count steps, never seconds.

pub mod dimibot;
mod errors;
pub mod search;

use crate::check::claims::{Claims, Order, Relation, Requirement};
use crate::device::dimibot::Cell;
use crate::diagnostic::Sink;
use std::collections::BTreeMap;

/// How a job is done.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    pub planner: &'static str,
    pub objective: &'static str,
    /// Of `cost` and `bound`; empty for a count.
    pub unit: &'static str,
    pub cost: f64,
    /// No plan costs less.
    pub bound: f64,
    pub proof: Optimality,
    /// In SI units, by the names of the vocabulary's outcomes.
    pub outcomes: BTreeMap<String, f64>,
    pub motion: Motion,
}

/// Whether a plan is known to be the best.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Optimality {
    Proven,
    Open,
}

/// What the device does, in its kind's own terms.
#[derive(Debug, Clone, PartialEq)]
pub enum Motion {
    Dimibot(dimibot::Motion),
}

/// Told before each job is planned: which one of how many, and its task.
pub type Progress<'a> = &'a mut dyn FnMut(usize, usize, &str);

/// A plan for every job, in their order; `None` after an error, which has then been pushed for each job that has none.
pub fn plan(claims: &Claims, sink: &mut Sink, progress: Progress) -> Option<Vec<Plan>> {
    let mut stands: BTreeMap<&str, Cell> = BTreeMap::new();
    let mut fields = dimibot::Fields::default();
    let mut plans = Vec::with_capacity(claims.jobs.len());
    for (index, job) in claims.jobs.iter().enumerate() {
        progress(index, claims.jobs.len(), &job.task);
        let Order::Dimibot(order) = &job.order;
        let stand = stands.get(job.device.as_str()).copied();
        let (plan, end) = dimibot::plan(job, order, stand, &mut fields, sink);
        stands.insert(&job.device, end);
        plans.push(plan);
    }
    plans.into_iter().collect()
}

/// Whether a requirement holds for an outcome.
pub fn keeps(requirement: &Requirement, reached: f64) -> Kept {
    let slack = requirement.limit.abs() * REQUIREMENT_TOLERANCE;
    let holds = match requirement.relation {
        Relation::Less => reached < requirement.limit - slack,
        Relation::AtMost => reached <= requirement.limit + slack,
        Relation::Equal => (reached - requirement.limit).abs() <= slack,
        Relation::AtLeast => reached >= requirement.limit - slack,
        Relation::More => reached > requirement.limit + slack,
    };
    if holds { Kept::Yes } else { Kept::No }
}

/// How far a sum of floats may stray from a limit that it meets exactly, relative to the limit.
const REQUIREMENT_TOLERANCE: f64 = 1e-9;

/// The answer of [`keeps`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kept {
    Yes,
    No,
}
