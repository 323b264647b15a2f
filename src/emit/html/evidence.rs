//! Evidence behind the word "verified" on a page: the rules that were checked, the closest clearances, and the forces
//! that hold parts.

use crate::diagnostic::Code;
use crate::verify::{self, GapUnit, Verified};
use serde::Serialize;

#[derive(Serialize)]
pub(super) struct PageEvidence<'a> {
    rules: Vec<PageRule>,
    clearances: Vec<PageClearance<'a>>,
    /// For each plan in which forces hold a part.
    forces: Vec<PageForces>,
}

/// The forces by which fingers hold a part.
#[derive(Serialize)]
struct PageForces {
    /// Index of the plan in the schedule.
    plan: usize,
    /// For each recorded state, the force of each finger on the part, in micronewtons along the axes of the hand:
    /// `None` for a free finger, and `None` for the whole state where no forces balance.
    states: Vec<Option<Vec<Option<[f64; 3]>>>>,
}

#[derive(Serialize)]
struct PageRule {
    code: Code,
    says: &'static str,
    /// Number of things that it was checked on.
    times: u64,
}

#[derive(Serialize)]
struct PageClearance<'a> {
    code: Code,
    device: &'a str,
    between: &'a [String; 2],
    #[serde(rename = "gap")]
    apart: f64,
    needed: f64,
    within: f64,
    unit: &'static str,
    t_ns: u64,
    points: [[f64; 3]; 2],
}

impl<'a> PageEvidence<'a> {
    pub(super) fn of(verified: &'a Verified) -> PageEvidence<'a> {
        let (evidence, schedule) = (verified.evidence(), verified.schedule());
        let orders = verified.claims().jobs.iter().map(|job| &job.order);
        let held = schedule.plans.iter().zip(orders).enumerate().map(|(plan, (record, order))| {
            let states = record.states.iter().map(|timed| verify::forces(order, &timed.state)).collect();
            PageForces { plan, states }
        });
        let forces = held.filter(|forces| forces.states.iter().any(Option::is_some));
        let rules = evidence.checks.iter().map(|(rule, times)| PageRule {
            code: rule.code(),
            says: rule.says(),
            times: *times,
        });
        let clearances = evidence.clearances.iter().map(|found| PageClearance {
            code: found.rule.code(),
            device: &found.device,
            between: &found.between,
            apart: found.apart,
            needed: found.needed,
            within: found.error_bound,
            unit: match found.unit {
                GapUnit::Micrometres => "um",
                GapUnit::Electrodes => "electrodes",
            },
            t_ns: found.t_ns,
            points: found.points,
        });
        PageEvidence { rules: rules.collect(), clearances: clearances.collect(), forces: forces.collect() }
    }
}
