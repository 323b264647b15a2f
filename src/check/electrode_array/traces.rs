//! Which traces a task avoids, and operations that could not but leave them.

use super::errors;
use super::goals::{BoardStepJudge, is_assay};
use crate::check::lets::Argument;
use crate::check::tasks::{VocabularyAction, VocabularyStep};
use crate::check::value::{ObjectName, Value};
use crate::check::verbs::Call;
use crate::claims::electrode_array::{AvoidedTrace, Contamination, ElectrodeArrayAction, ElectrodeArrayOrder, Fluids};
use crate::claims::{Job, Order};
use crate::device::electrode_array::Electrodes;
use crate::diagnostic::{Code, Diagnostic, Sink};
use crate::source::Span;
use std::collections::{BTreeMap, BTreeSet};

impl BoardStepJudge<'_> {
    /// The traces that a task avoids, by the conditions that stand before its steps.
    pub fn contamination(&mut self, conditions: &[Call], steps: &[VocabularyStep]) -> Option<Contamination> {
        let mut contamination = Contamination::default();
        let mut is_whole = true;
        for call in conditions {
            let no_droplet = self.facts.layout.electrodes != Electrodes::Single;
            self.sink.unless(no_droplet.then(|| errors::parts_leave_no_traces(call.span)))?;
            let fluids = call.object.iter().chain(call.phrases.iter().map(|(_, fluid)| fluid));
            let fluids: Vec<Option<String>> = fluids.map(|fluid| self.fluid(fluid)).collect();
            match fluids.as_slice() {
                [Some(of), Some(within)] if of != within => {
                    let trace = AvoidedTrace { of: of.clone(), within: within.clone(), span: call.span };
                    let is_known = |known: &AvoidedTrace| known.of == trace.of && known.within == trace.within;
                    if !contamination.avoided.iter().any(is_known) {
                        contamination.avoided.push(trace);
                    }
                }
                // A fluid does no harm to itself, which spares a list of fluids its exceptions.
                [Some(_), Some(_)] => {}
                [Some(wash)] if !contamination.washes.contains(wash) => contamination.washes.push(wash.clone()),
                _ => is_whole &= fluids.iter().all(Option::is_some),
            }
        }
        self.in_one_assay(conditions, steps)?;
        is_whole.then_some(contamination)
    }

    /// A task that avoids traces has one assay, and only what moves nothing besides.
    fn in_one_assay(&mut self, conditions: &[Call], steps: &[VocabularyStep]) -> Option<()> {
        let Some(avoids) = conditions.iter().find(|call| call.object.is_some()) else {
            let idle = conditions.first().map(|call| errors::washes_nothing(call.span));
            return self.sink.unless(idle);
        };
        let moving = || steps.iter().filter(|step| !matches!(step.action, VocabularyAction::Wait(_)));
        let besides = moving().find(|step| !is_assay(&step.action)).or(moving().nth(1));
        self.sink.unless(besides.map(|step| errors::avoids_outside_assay(step.span, avoids.span)))
    }

    /// A fluid of the scene by its name; `None` after an error.
    fn fluid(&mut self, asked: &Argument) -> Option<String> {
        let Value::Object(ObjectName { name, .. }) = &asked.value else { return None };
        let fluids = self.tray.fluids();
        let wrong = (!fluids.contains(name.as_str()))
            .then(|| errors::unknown_fluid((Code::E0565, asked.span), name, &fluids, self.scene));
        asked.unless(wrong, self.sink)?;
        Some(name.clone())
    }
}

/// Enters what the parts of each order contain before it, by the places of the jobs, and reports operations at one place that harm each
/// other.
pub fn agree(jobs: &mut [Job], before: Vec<(usize, Vec<Fluids>)>, sink: &mut Sink) {
    let mut reported: BTreeSet<Span> = BTreeSet::new();
    for (nth, before) in before {
        let Order::ElectrodeArray(order) = &mut jobs[nth].order else { continue };
        if order.contamination.is_unheeded() {
            continue;
        }
        order.contamination.before = before;
        if let Some((span, wrong)) = harmed_at_one_place(order).filter(|(span, _)| reported.insert(*span)) {
            sink.push(wrong.label_elsewhere(order.contamination.avoided[0].span, span, "avoided here"));
        }
    }
}

/// Two operations at one cell, of which each does harm to the other in whatever order they come, where nothing is washed.
fn harmed_at_one_place(order: &ElectrodeArrayOrder) -> Option<(Span, Diagnostic)> {
    let contamination = &order.contamination;
    if !contamination.washes.is_empty() {
        return None;
    }
    let assay = order.steps.iter().find_map(|step| match &step.action {
        ElectrodeArrayAction::Assay(operations) => Some(operations),
        ElectrodeArrayAction::Move(_) | ElectrodeArrayAction::Wait(_) => None,
    })?;
    let mut fluids = contamination.before.clone();
    let mut stops: BTreeMap<_, Vec<(usize, Fluids)>> = BTreeMap::new();
    for operation in assay {
        operation.begin_fluids(&mut fluids);
        operation.end_fluids(&mut fluids);
        let own = &fluids[operation.part];
        // Where the plan chooses, it may keep them apart.
        for stop in operation.stops.iter().filter(|_| operation.among.is_empty()) {
            let there = stops.entry((stop.cell.column, stop.cell.row)).or_default();
            let harms_both = |left: &Fluids| contamination.does_harm(left, own) && contamination.does_harm(own, left);
            if let Some((other, _)) = there.iter().find(|(_, left)| harms_both(left)) {
                let names = [*other, operation.part].map(|part| order.parts[part].name.as_str());
                return Some((stop.span, errors::harms_at_one_place(operation.span, names, stop.cell)));
            }
            there.push((operation.part, own.clone()));
        }
    }
    None
}
