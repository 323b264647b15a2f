//! Report on a hand: its figures, and the contacts of the parts that its tasks turn.

use super::program::length;
use crate::claims::{Claims, Order};
use crate::device::fingers::{Adhesion, FingersFacts, Plane};
use crate::quantity::{Dimension, Quantity, digits};
use std::collections::BTreeMap;

/// A line for the hand, and one for each part.
pub fn told(name: &str, facts: &FingersFacts, claims: &[Claims]) -> String {
    let (fingers, tip) = (facts.fingers, length(facts.tip_radius_um));
    let step = digits(360.0 / f64::from(facts.steps_per_turn));
    let sticking = match facts.adhesion {
        Adhesion::Sticking => format!("that stick with {}", Quantity::new(facts.pull_off_un / 1e6, Dimension::FORCE)),
        Adhesion::Absent => "that do not stick".to_owned(),
    };
    let mut text = format!("{name}: fingers, {fingers} with tips of {tip} radius {sticking}, steps of {step} deg\n");
    for (part, contacts) in parts(name, claims) {
        text.push_str(&format!("  {part}: {contacts}\n"));
    }
    text
}

/// The parts that tasks of a hand turn, by name.
fn parts(device: &str, claims: &[Claims]) -> BTreeMap<String, String> {
    let jobs = claims.iter().flat_map(|claims| &claims.jobs).filter(|job| job.device == device);
    let mut parts = BTreeMap::new();
    for job in jobs {
        let part = match &job.order {
            Order::Fingers(order) => &order.part,
            Order::Dimibot(_) | Order::ElectrodeArray(_) | Order::Microrobots(_) => continue,
        };
        let sections = Plane::ALL.iter().filter_map(|plane| Some((plane, part.section(*plane)?)));
        let lines: Vec<String> = sections
            .map(|(plane, section)| {
                let opposite = section.opposite.map_or(String::new(), |opposite| format!(", {opposite} opposite 1"));
                let step = digits((section.step_rad.to_degrees() * 1e4).round() / 1e4);
                format!("{} contacts in the plane {}, {step} deg apart{opposite}", section.contacts, plane.name())
            })
            .collect();
        parts.insert(part.name.clone(), lines.join("; "));
    }
    parts
}
