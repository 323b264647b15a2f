//! The cost of a plan and how good that is, in words.
//!
//! Input: an order and the record of its plan. Output: one line that reports and pictures share, so that no two of them claim
//! different things of one plan.

use super::PlanRecord;
use crate::claims::Order;
use crate::device::each_kind;
use crate::quantity::{digits, to_decimals};

/// What a kind says of the cost of a plan, on its orders.
pub(super) trait Costed {
    /// What a run costs and how good that is.
    fn cost(&self, plan: &PlanRecord) -> String;

    /// What a stretch of a run's time takes, in what the kind counts; `None` where time says it all.
    fn stretch(&self, _plan: &PlanRecord, _start_ns: u64, _end_ns: u64) -> Option<String> {
        None
    }
}

/// What a run costs, and whether that is proven to be the least: `29.88 um (70 r) in 9 switches, optimal (bound 29.88 um)`.
pub fn cost(order: &Order, plan: &PlanRecord) -> String {
    each_kind!(Order, order, order => order.cost(plan))
}

/// What a stretch of a run's time takes, in what its kind counts: `9 switches`, `34 steps`; `None` where time says it all.
pub fn stretch(order: &Order, plan: &PlanRecord, start_ns: u64, end_ns: u64) -> Option<String> {
    each_kind!(Order, order, order => order.stretch(plan, start_ns, end_ns))
}

/// `optimal (bound 29.88 um)`.
pub fn proof(plan: &PlanRecord, figure: impl Fn(f64) -> String) -> String {
    match plan.optimal {
        true => format!("optimal (bound {})", figure(plan.bound)),
        false => format!("not proven optimal (bound {})", figure(plan.bound)),
    }
}

/// A figure for the report: two decimals, more where the value is small.
pub fn rounded(value: f64) -> String {
    if value.abs() >= 1.0 { digits(to_decimals(value, 2)) } else { digits(value) }
}

/// An outcome of a plan that is a plain count, by its word; 0 where the plan does not have it.
pub fn count_of(plan: &PlanRecord, outcome: &str) -> f64 {
    plan.outcomes.get(outcome).copied().unwrap_or_default()
}
