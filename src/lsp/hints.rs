//! Figures behind the text: what the checker knows of devices and places, and what the planner found of tasks and their steps.
//!
//! The checker's figures are there as soon as a program is without an error: the pitch of a device, the cell that is taken for a place.
//! Those of a plan wait for it (`planning`): what a task costs, what each of its steps takes, and the angle that a turn reaches.

use super::outline;
use super::planning::ProgramPlans;
use super::text::{ColumnUnit, EditedText};
use crate::check::{Checked, KindFacts};
use crate::source::FileId;
use crate::syntax::tree::{Entry, Item, Tree};
use lsp_types::{InlayHint, InlayHintLabel, InlayHintTooltip, MarkupContent, Position, Range};
use std::collections::{BTreeMap, BTreeSet};

/// What the checker knows of a program without an error; empty for one with errors.
#[derive(Debug, Default)]
pub struct CheckedFigures {
    /// By the name of the device.
    pitches: BTreeMap<String, String>,
    /// What was taken for the places that end at these bytes of the program's own text.
    places: BTreeMap<usize, BTreeSet<String>>,
}

impl CheckedFigures {
    /// The figures of a program whose own text is a file.
    pub fn of(checked: &Checked, own: FileId) -> CheckedFigures {
        let pitch = |(name, facts): &(String, KindFacts)| Some((name.clone(), facts.pitch()?));
        let mut places: BTreeMap<usize, BTreeSet<String>> = BTreeMap::new();
        let orders = checked.claims.iter().flat_map(|claims| &claims.jobs).map(|job| &job.order);
        let of_orders = orders.flat_map(|order| order.asked().taken_for_places());
        for (span, text) in of_orders.filter(|(span, _)| span.file == own) {
            places.entry(span.range().end).or_default().insert(text);
        }
        CheckedFigures { pitches: checked.devices.iter().filter_map(pitch).collect(), places }
    }
}

/// Most that one place says in a line; all of it is in the tooltip.
const MAX_SHOWN: usize = 3;

/// All that there is to say within a range of a text, in its order.
pub fn shown(
    text: &EditedText,
    figures: &CheckedFigures,
    plans: &ProgramPlans,
    within: Range,
    unit: ColumnUnit,
) -> Vec<InlayHint> {
    let tree = outline::tree(text.as_str());
    let mut found: Vec<(usize, String, Option<MarkupContent>)> = Vec::new();
    for item in &tree.items {
        if let Item::Device(device) = item
            && let Some(pitch) = figures.pitches.get(&device.name.text)
        {
            found.push((device.base.span.range().end, pitch.clone(), None));
        }
        if let Some(head) = item.runnable()
            && let Some((line, tooltip)) = plans.head(&head.name.text)
        {
            found.push((end_of_line(text.as_str(), head.name.span.range().end), line, tooltip));
        }
    }
    let places = figures.places.iter().map(|(end, cells)| {
        let shown: Vec<&str> = cells.iter().take(MAX_SHOWN).map(String::as_str).collect();
        let more = if cells.len() > MAX_SHOWN { " …" } else { "" };
        (*end, format!("{}{more}", shown.join("; ")), None)
    });
    found.extend(places);
    let ends = step_ends(&tree);
    for step in plans.steps() {
        let start = text.offset_of_character(step.line - 1, step.column - 1);
        if let Some(end) = ends.get(&start) {
            // Places are told already.
            let line = step.line_text(figures.places.range(start..=*end).next().is_none());
            found.push(((*end).min(end_of_line(text.as_str(), start)), line, Some(step.tooltip())));
        }
    }
    // In the order of the text, and of two at one place that of the checker first.
    found.sort_by_key(|(at, ..)| *at);
    let hint = |(at, label, tooltip): (usize, String, Option<MarkupContent>)| {
        let position: Position = text.position(at, unit);
        (within.start <= position && position <= within.end).then(|| InlayHint {
            position,
            label: InlayHintLabel::String(label),
            kind: None,
            text_edits: None,
            tooltip: tooltip.map(InlayHintTooltip::MarkupContent),
            padding_left: Some(true),
            padding_right: None,
            data: None,
        })
    };
    found.into_iter().filter_map(hint).collect()
}

/// Where the line of a byte ends, without blanks.
fn end_of_line(text: &str, at: usize) -> usize {
    let line = text[at..].lines().next().unwrap_or_default();
    at + line.trim_end().len()
}

/// The steps of all tasks and programs: the bytes at which they begin and end.
fn step_ends(tree: &Tree) -> BTreeMap<usize, usize> {
    let mut ends = BTreeMap::new();
    let mut open: Vec<&[Entry]> = tree.items.iter().filter_map(Item::runnable).map(|item| item.entries).collect();
    while let Some(entries) = open.pop() {
        for entry in entries {
            match entry {
                Entry::Step(step) => {
                    let range = step.span.range();
                    ends.insert(range.start, range.end);
                    open.extend(step.block.as_deref());
                }
                Entry::For(repeated) => open.push(&repeated.entries),
                Entry::Field(_) | Entry::Error(_) => {}
            }
        }
    }
    ends
}
