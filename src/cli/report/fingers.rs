//! Report of plans for hands.

use super::{Note, ReportTopic, ReportedDevice, ReportedOrder, ReportedRun, length, reached};
use crate::claims::Claims;
use crate::claims::fingers::{FingersOrder, Section};
use crate::device::fingers::{Adhesion, FingersFacts, Plane};
use crate::quantity::{Quantity, digits, to_decimals};
use std::collections::BTreeMap;

impl ReportedOrder for FingersOrder {
    /// How the part was sampled, and the planner's remarks.
    fn notes(&self, run: &ReportedRun) -> Vec<Note> {
        let sections = Plane::ALL.into_iter().filter_map(|plane| Some(contacts(plane, self.part.section(plane)?)));
        let contacts = format!("{}: {}", self.part.name, sections.collect::<Vec<_>>().join(", "));
        let remarks =
            run.remarks().map(|remark| (ReportTopic::Remarked, format!("{}: {}", remark.subject, remark.text)));
        std::iter::once((ReportTopic::Contacts, contacts)).chain(remarks).chain(reached(run)).collect()
    }
}

impl ReportedDevice for FingersFacts {
    /// One line for the hand and one for each part.
    fn describe(&self, name: &str, claims: &[Claims]) -> String {
        let (fingers, tip) = (self.fingers, length(self.tip_radius_um));
        let step = digits(360.0 / f64::from(self.steps_per_turn));
        let sticking = match self.adhesion {
            Adhesion::Sticking => {
                format!("that stick with {}", Quantity::force_un(self.pull_off_un))
            }
            Adhesion::Absent => "that do not stick".to_owned(),
        };
        let mut text =
            format!("{name}: fingers, {fingers} with tips of {tip} radius {sticking}, steps of {step} deg\n");
        for (part, contacts) in parts(name, claims) {
            text.push_str(&format!("  {part}: {contacts}\n"));
        }
        text
    }
}

/// The parts that tasks turn with a hand, by name, each with its contacts.
fn parts(device: &str, claims: &[Claims]) -> BTreeMap<String, String> {
    let jobs = claims.iter().flat_map(|claims| &claims.jobs).filter(|job| job.device == device);
    let mut parts = BTreeMap::new();
    for job in jobs {
        let Some(FingersOrder { part, .. }) = FingersOrder::of(&job.order) else { continue };
        let sections = Plane::ALL.iter().filter_map(|plane| Some((plane, part.section(*plane)?)));
        let lines: Vec<String> = sections
            .map(|(plane, section)| {
                let opposite = section.opposite.map_or(String::new(), |opposite| format!(", {opposite} opposite 1"));
                let step = digits(to_decimals(section.step_rad.to_degrees(), 4));
                format!("{} contacts in the plane {}, {step} deg apart{opposite}", section.contacts, plane.name())
            })
            .collect();
        parts.insert(part.name.clone(), lines.join("; "));
    }
    parts
}

/// Contacts of a section, with the first one and the one opposite to it: `74 in xy (I 1, J 38)`.
fn contacts(plane: Plane, section: &Section) -> String {
    let ends = section.opposite.map_or_else(|| "I 1".to_owned(), |opposite| format!("I 1, J {opposite}"));
    format!("{} in {} ({ends})", section.contacts, plane.name())
}
