//! Interchangeable goals: E0572.

use super::{PartPlace, electrodes, nearest};
use crate::device::electrode_array::{ElectrodeCell, MAX_TEAM};
use crate::diagnostic::{Code, Diagnostic};
use crate::quantity::count;
use crate::source::Span;
use std::collections::BTreeSet;

/// Most names in a message; further ones are counted.
const MOST_NAMED: usize = 4;

pub fn no_team(span: Span, name: &str, families: &BTreeSet<&str>, scene: Option<Span>) -> Diagnostic {
    let title = format!("the scene has no parts `{name}[…]`");
    let mend = match families.first() {
        Some(first) => {
            let all: Vec<String> = families.iter().map(|own| format!("`any {own}`")).collect();
            let known = if all.len() > MOST_NAMED { format!("`any {first}` and others") } else { all.join(", ") };
            format!("the scene has {known}; move a single part without `any`")
        }
        None => format!(
            "`any {name}` moves the parts `{name}[0]`, `{name}[1]` and so on of the scene; move a single part without `any`"
        ),
    };
    let diagnostic = Diagnostic::new(Code::E0572, title).label(span, "stands for no part");
    let diagnostic = match scene {
        Some(scene) => diagnostic.label_elsewhere(scene, span, "in this scene"),
        None => diagnostic,
    };
    diagnostic.help(mend)
}

pub fn goals_of_team(step: Span, to: Span, name: &str, parts: &[&str], goals: usize) -> Diagnostic {
    let title = format!("`any {name}` is {}, but has {}", count(parts.len(), "part"), count(goals, "goal"));
    let named: Vec<String> = parts.iter().take(MOST_NAMED).map(|name| format!("`{name}`")).collect();
    let more = if parts.len() > MOST_NAMED { format!(" and {} more", parts.len() - MOST_NAMED) } else { String::new() };
    let mend = match parts.len() > goals {
        true => format!(
            "add {} to the list: each part needs one, even if it may stay where it is",
            count(parts.len() - goals, "goal")
        ),
        false => {
            format!("leave out {}, or put more parts `{name}[…]` into the scene", count(goals - parts.len(), "goal"))
        }
    };
    Diagnostic::new(Code::E0572, title)
        .label(to, count(goals, "goal"))
        .label_elsewhere(step, to, format!("{}{more}", named.join(", ")))
        .help(mend)
}

pub fn team_goals_too_near(goals: [PartPlace; 2], apart: u32, free: Option<ElectrodeCell>) -> Diagnostic {
    let [PartPlace { name, cell, span }, PartPlace { cell: at, span: other_span, .. }] = goals;
    let title = match cell.apart(at) {
        0 => format!("`any {name}` has the goal {cell} twice"),
        distance => {
            format!("two goals of `any {name}` are {}; the least distance is {apart}", electrodes(distance))
        }
    };
    Diagnostic::new(Code::E0524, title)
        .label(span, "too near")
        .label_elsewhere(other_span, span, "to this goal")
        .help_if(nearest(free, "that is free"))
}

pub fn team_too_large(span: Span, name: &str, parts: usize) -> Diagnostic {
    Diagnostic::new(Code::E0572, format!("`any {name}` is {parts} parts; at most {MAX_TEAM} are allowed"))
        .label(span, "too many to choose among")
        .help("give the parts several names, and each name its own goals")
}

pub fn team_in_assay(span: Span) -> Diagnostic {
    Diagnostic::new(Code::E0572, "`move any` cannot be part of an `assay`")
        .label(span, "an operation of no part in particular")
        .help("write it as a step before or after the `assay`, or move each part of it by name")
}
