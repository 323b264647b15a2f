//! Report on a plan for a hand.

use super::{Note, ReportTopic, ReportedRun, count, figure_of, proof, reached, rounded};
use crate::claims::fingers::{FingersOrder, Section};
use crate::device::fingers::{FingersOutcome, Plane};
use crate::schedule::PlanRecord;

/// `2300 deg in 8 reconfigurations, optimal (bound 2300 deg)`.
pub fn cost(plan: &PlanRecord) -> String {
    let figure = |degrees: f64| format!("{} deg", rounded(degrees));
    let reconfigurations = figure_of(plan, FingersOutcome::Reconfigurations.name()) as usize;
    format!("{} in {}, {}", figure(plan.cost), count(reconfigurations, "reconfiguration"), proof(plan, figure))
}

/// Sampling of the part, and notes of the planner.
pub fn notes(run: &ReportedRun, order: &FingersOrder) -> Vec<Note> {
    let sections = Plane::ALL.into_iter().filter_map(|plane| Some(contacts(plane, order.part.section(plane)?)));
    let contacts = format!("{}: {}", order.part.name, sections.collect::<Vec<_>>().join(", "));
    let remarks =
        run.plan.remarks.iter().map(|remark| (ReportTopic::Remarked, format!("{}: {}", remark.subject, remark.text)));
    std::iter::once((ReportTopic::Contacts, contacts)).chain(remarks).chain(reached(run)).collect()
}

/// `74 in xy (I 1, J 38)`.
fn contacts(plane: Plane, section: &Section) -> String {
    let ends = section.opposite.map_or_else(|| "I 1".to_owned(), |opposite| format!("I 1, J {opposite}"));
    format!("{} in {} ({ends})", section.contacts, plane.name())
}
