//! The cost of a plan and its proof of optimality, in words.
//!
//! Input: an order and the record of its plan. Output: one line that reports and pictures share, so that they cannot
//! make different claims about one plan.

use super::PlanRecord;
use crate::claims::Order;
use crate::device::each_kind;
use crate::quantity::{digits, to_decimals};

/// Describes costs of plans in a kind's own terms.
pub(super) trait Costed {
    /// The cost of a run and its bound.
    fn cost(&self, plan: &PlanRecord) -> String;

    /// The work in an interval of a run, in what the kind counts; `None` for a kind that only counts time.
    fn work_in(&self, _plan: &PlanRecord, _start_ns: u64, _end_ns: u64) -> Option<String> {
        None
    }
}

/// The cost of a run, and whether it is proven to be minimal: `29.88 um (70 r) in 9 switches, optimal (bound 29.88
/// um)`.
pub fn cost(order: &Order, plan: &PlanRecord) -> String {
    each_kind!(Order, order, order => order.cost(plan))
}

/// The work in an interval of a run, in what its kind counts: `9 switches`, `34 steps`; `None` for a kind that only
/// counts time.
pub fn work_in(order: &Order, plan: &PlanRecord, start_ns: u64, end_ns: u64) -> Option<String> {
    each_kind!(Order, order, order => order.work_in(plan, start_ns, end_ns))
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

/// An outcome of a plan that is a count, by its name; 0 if the plan does not have it.
pub fn count_of(plan: &PlanRecord, outcome: &str) -> f64 {
    plan.outcomes.get(outcome).copied().unwrap_or_default()
}
