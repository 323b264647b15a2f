//! Inlay hints: figures from the checker about devices and places, and figures from the planner about tasks and their
//! steps.
//!
//! The checker's figures are available as soon as a program has no error: the pitch of a device, the cell that is taken
//! for a place. The figures of a plan wait for it (`planning`): the cost of a task, the cost of each of its steps, and
//! the angle that a turn reaches.

use super::outline;
use super::planning::ProgramPlans;
use super::text::{ColumnUnit, EditedText};
use crate::check::{Checked, KindFacts};
use crate::source::FileId;
use crate::syntax::tree::{Entry, Item, Tree};
use lsp_types::{InlayHint, InlayHintLabel, InlayHintTooltip, MarkupContent, Position, Range};
use std::collections::{BTreeMap, BTreeSet};

/// The checker's figures for a program without errors; empty for a program with errors.
#[derive(Debug, Default)]
pub struct CheckedFigures {
    /// Pitch by device name.
    pitches: BTreeMap<String, String>,
    /// Texts of what was taken for a place, by the byte at which the place ends in the program's own text.
    places: BTreeMap<usize, BTreeSet<String>>,
}

impl CheckedFigures {
    /// Collects the figures of a program; `own` is the file of its own text.
    pub fn of(checked: &Checked, own: FileId) -> CheckedFigures {
        let pitch = |(name, facts): &(String, KindFacts)| Some((name.clone(), facts.pitch()?));
        let mut places: BTreeMap<usize, BTreeSet<String>> = BTreeMap::new();
        let orders = checked.claims.iter().flat_map(|claims| &claims.jobs).map(|job| &job.order);
        let of_orders = orders.flat_map(|order| order.as_kind().taken_for_places());
        for (span, text) in of_orders.filter(|(span, _)| span.file == own) {
            places.entry(span.range().end).or_default().insert(text);
        }
        CheckedFigures { pitches: checked.devices.iter().filter_map(pitch).collect(), places }
    }
}

/// Greatest number of texts that the hint of one place shows; the tooltip shows all.
const MAX_SHOWN: usize = 3;

/// All hints within a range of a text, in text order.
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
            // The step's line omits what it reaches if a place inside it already has a hint.
            let line = step.line_text(figures.places.range(start..=*end).next().is_none());
            found.push(((*end).min(end_of_line(text.as_str(), start)), line, Some(step.tooltip())));
        }
    }
    // In text order; at one position the checker's hint comes first.
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

/// End of the line of a byte, without trailing spaces.
fn end_of_line(text: &str, at: usize) -> usize {
    let line = text[at..].lines().next().unwrap_or_default();
    at + line.trim_end().len()
}

/// The steps of all tasks and programs, as the bytes at which they begin and end.
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
