//! Reduced program: the parts at fault are left out, so that the rest can be checked, planned and shown.
//!
//! In a task, a setting at fault is left out alone, and a step at fault with all steps after it; in a scene, the object
//! at fault is left out. What remains keeps its place in the source.

use super::scope::Module;
use super::tasks::is_setting;
use crate::diagnostic::{PlaceUnit, WrittenPlace};
use crate::quantity::{Dimension, Unit};
use crate::source::Span;
use crate::syntax::tree::{Entry, Expr, ExprKind, Item, Object, SceneEntry, Step, Task};

/// Greatest number of places of one program that are marked.
const MAX_PLACES: usize = 100;

/// Parts left out of a program.
#[derive(Debug, Default)]
pub struct LeftOut {
    /// Names, where declared, of the tasks that lack something now.
    pub tasks: Vec<Span>,
    /// Places in the scene that the parts at fault name, if written as numbers.
    pub places: Vec<WrittenPlace>,
}

/// Leaves out of the user's files the parts that `faults` point to.
pub fn leave_out(modules: &mut [Module], faults: &[Span]) -> LeftOut {
    let mut left_out = LeftOut::default();
    for module in modules.iter_mut().filter(|module| !module.is_library()) {
        for item in &mut module.tree.items {
            if let Item::Task(task) = item {
                of_task(task, faults, &mut left_out);
            } else if let Item::Scene(scene) = item {
                of_scene(&mut scene.entries, faults, &mut left_out);
            }
        }
    }
    left_out
}

/// Leaves out every step of every task of the user's own files.
pub fn leave_out_all_steps(modules: &mut [Module]) -> LeftOut {
    let mut left_out = LeftOut::default();
    for module in modules.iter_mut().filter(|module| !module.is_library()) {
        for item in &mut module.tree.items {
            if let Item::Task(task) = item {
                cut(task, first_step(task), &mut left_out);
            }
        }
    }
    left_out
}

fn of_task(task: &mut Task, faults: &[Span], left_out: &mut LeftOut) {
    let own: Vec<Span> = faults.iter().copied().filter(|fault| task.span.contains(*fault)).collect();
    let at_fault = |entries: &[Entry], fault: Span| entries.iter().position(|entry| span_of(entry).contains(fault));
    let known = left_out.places.len();
    for &fault in &own {
        if let Some(at) = at_fault(&task.entries, fault) {
            places_in(&task.entries[at], fault, &mut left_out.places);
        }
    }
    let named = task.device.segments.last().filter(|segment| segment.indices.is_empty());
    let device = named.map(|segment| segment.name.text.to_string());
    left_out.places[known..].iter_mut().for_each(|place| place.device.clone_from(&device));
    for fault in own {
        let Some(at) = at_fault(&task.entries, fault) else {
            // The fault is in the task's head, unless its entry is left out already.
            if task.entries.first().is_some_and(|first| fault.end <= span_of(first).start) {
                cut(task, first_step(task), left_out);
            }
            continue;
        };
        if is_step(&task.entries[at]) {
            cut(task, at, left_out);
        } else {
            task.entries.remove(at);
            left_out.tasks.push(task.name.span);
        }
    }
}

/// The index of the first entry that is not a setting.
fn first_step(task: &Task) -> usize {
    task.entries.iter().position(is_step).unwrap_or(task.entries.len())
}

fn is_step(entry: &Entry) -> bool {
    match entry {
        Entry::Field(_) => false,
        Entry::Step(step) => !is_setting(step),
        Entry::For(_) | Entry::Error(_) => true,
    }
}

fn cut(task: &mut Task, from: usize, left_out: &mut LeftOut) {
    if from < task.entries.len() {
        left_out.tasks.push(task.name.span);
        task.entries.truncate(from);
    }
}

fn span_of(entry: &Entry) -> Span {
    match entry {
        Entry::Field(field) => field.span,
        Entry::Step(step) => step.span,
        Entry::For(each) => each.span,
        Entry::Error(span) => *span,
    }
}

fn of_scene(entries: &mut Vec<SceneEntry>, faults: &[Span], left_out: &mut LeftOut) {
    entries.retain(|entry| {
        let span = match entry {
            SceneEntry::Object(object) => object.span,
            SceneEntry::For(each) => each.span,
            SceneEntry::Error(span) => *span,
        };
        let Some(&fault) = faults.iter().find(|fault| span.contains(**fault)) else { return true };
        if let SceneEntry::Object(Object { at: Some(at), .. }) = entry {
            places_of(at, None, fault, &mut left_out.places);
        }
        false
    });
}

/// Collects the places in an entry that lie within a fault or contain it.
fn places_in(entry: &Entry, fault: Span, places: &mut Vec<WrittenPlace>) {
    match entry {
        Entry::Step(step) => places_in_step(step, fault, places),
        Entry::For(each) => each.entries.iter().for_each(|entry| places_in(entry, fault, places)),
        Entry::Field(_) | Entry::Error(_) => {}
    }
}

fn places_in_step(step: &Step, fault: Span, places: &mut Vec<WrittenPlace>) {
    let values = step.object.iter().chain(step.phrases.iter().map(|phrase| &phrase.value));
    values.for_each(|value| places_of(value, Some(step.span), fault, places));
    step.block.iter().flatten().for_each(|entry| places_in(entry, fault, places));
}

/// Collects the places in a value that lie within a fault or contain it; all of them if the fault covers the whole
/// step, or if there is no step but an object.
fn places_of(value: &Expr, step: Option<Span>, fault: Span, places: &mut Vec<WrittenPlace>) {
    let is_about =
        |span: Span| fault.contains(span) || span.contains(fault) || step.is_none_or(|step| fault.contains(step));
    match &value.kind {
        ExprKind::Tuple(parts) | ExprKind::Call { arguments: parts, .. } if is_about(value.span) => {
            let [first, second, ..] = parts.as_slice() else { return };
            let (Some((x, one)), Some((y, other))) = (written(first), written(second)) else { return };
            if one == other && places.len() < MAX_PLACES {
                places.push(WrittenPlace { span: value.span, device: None, unit: one, at: [x, y] });
            }
        }
        ExprKind::List(parts) => parts.iter().for_each(|part| places_of(part, step, fault, places)),
        ExprKind::Tuple(_)
        | ExprKind::Call { .. }
        | ExprKind::Number(_)
        | ExprKind::Quantity { .. }
        | ExprKind::Word(_)
        | ExprKind::Text(_)
        | ExprKind::Bool(_)
        | ExprKind::Path(_)
        | ExprKind::Range { .. }
        | ExprKind::Negative(_)
        | ExprKind::Binary { .. }
        | ExprKind::With { .. }
        | ExprKind::Table(_)
        | ExprKind::Error => {}
    }
}

/// A number without a unit, or a length in micrometres, if it is written out rather than computed.
fn written(value: &Expr) -> Option<(f64, PlaceUnit)> {
    match &value.kind {
        ExprKind::Number(digits) => Some((digits.parse().ok()?, PlaceUnit::Cells)),
        ExprKind::Quantity { number, unit } => {
            let length = Unit::parse(&unit.text).ok()?.of(number)?;
            (length.dimension == Dimension::LENGTH).then(|| (length.in_unit("um"), PlaceUnit::Micrometres))
        }
        ExprKind::Negative(inner) => written(inner).map(|(value, unit)| (-value, unit)),
        ExprKind::Word(_)
        | ExprKind::Text(_)
        | ExprKind::Bool(_)
        | ExprKind::Path(_)
        | ExprKind::Tuple(_)
        | ExprKind::List(_)
        | ExprKind::Range { .. }
        | ExprKind::Binary { .. }
        | ExprKind::Call { .. }
        | ExprKind::With { .. }
        | ExprKind::Table(_)
        | ExprKind::Error => None,
    }
}
