//! Contamination: the traces that droplets leave on electrodes, and the droplets that come there later.
//!
//! After each beat, and after the merges done by then, a droplet leaves all its fluids on its electrode. A droplet of
//! washing fluids alone removes all traces from it.

use super::assay::JudgedAssay;
use super::{Findings, JudgedBoard, Rule, contents, ms};
use crate::claims::electrode_array::{AssayOperation, AvoidedTrace, Contamination, ElectrodeArrayOrder};
use crate::claims::{Claims, Job};
use crate::device::electrode_array::ElectrodeCell;
use std::collections::{BTreeMap, BTreeSet};

/// A droplet that comes onto a trace that is avoided for one of its fluids.
#[derive(Debug)]
struct Contaminated<'c> {
    part: usize,
    cell: ElectrodeCell,
    avoided: &'c AvoidedTrace,
}

/// The traces on the board's electrodes during a task.
#[derive(Debug)]
pub(super) struct JudgedTraces<'c> {
    rules: &'c Contamination,
    /// The fluids in each part, by index of the part.
    fluids: Vec<BTreeSet<&'c str>>,
    left: BTreeMap<ElectrodeCell, BTreeSet<&'c str>>,
    /// Indices of the merges that are done.
    done: BTreeSet<usize>,
    /// The violations reported so far, one per part and cell.
    reported: BTreeSet<(usize, ElectrodeCell)>,
}

impl<'c> JudgedTraces<'c> {
    /// A clean board before a task; `None` if the task avoids no traces.
    pub fn new(order: &'c ElectrodeArrayOrder, claims: &'c Claims, job: &Job) -> Option<JudgedTraces<'c>> {
        let rules = &order.contamination;
        if rules.is_unheeded() {
            return None;
        }
        let mut before = contents::fluids_before(claims, job);
        let fluids = order.parts.iter().map(|part| before.remove(part.name.as_str()).unwrap_or_default()).collect();
        Some(JudgedTraces { rules, fluids, left: BTreeMap::new(), done: BTreeSet::new(), reported: BTreeSet::new() })
    }

    /// Notes the fluid of a droplet that is dispensed.
    pub fn dispense(&mut self, part: usize, operations: &'c [AssayOperation]) {
        let own = operations.iter().find(|operation| operation.part == part && operation.comes);
        self.fluids[part] = own.and_then(|operation| operation.fluid.as_deref()).into_iter().collect();
    }

    /// Notes that a droplet is split off another one.
    pub fn split(&mut self, part: usize, half: usize) {
        self.fluids[half] = self.fluids[part].clone();
    }

    /// Updates the fluids by the merges that are done by now: both parts get the union of their fluids.
    fn merge(&mut self, operations: &[AssayOperation], is_done: impl Fn(usize) -> bool) {
        for (place, operation) in operations.iter().enumerate() {
            let Some(with) = operation.with.filter(|_| is_done(place) && !self.done.contains(&place)) else { continue };
            self.done.insert(place);
            let both: BTreeSet<&str> = self.fluids[operation.part].union(&self.fluids[with]).copied().collect();
            (self.fluids[operation.part], self.fluids[with]) = (both.clone(), both);
        }
    }

    /// Parts rest on cells: reports contaminations, then leaves or washes off traces.
    fn visit(&mut self, there: impl Iterator<Item = (usize, ElectrodeCell)>) -> Vec<Contaminated<'c>> {
        let mut found = Vec::new();
        for (part, cell) in there {
            let own = &self.fluids[part];
            if !own.is_empty() && own.iter().all(|fluid| self.rules.washes.iter().any(|wash| wash == fluid)) {
                self.left.remove(&cell);
                continue;
            }
            let left = self.left.entry(cell).or_default();
            let (is_left, is_own) = (|fluid: &str| left.contains(fluid), |fluid: &str| own.contains(fluid));
            let harm = |trace: &&AvoidedTrace| is_left(&trace.of) && is_own(&trace.within) && !is_own(&trace.of);
            let harmed = self.rules.avoided.iter().find(harm).filter(|_| self.reported.insert((part, cell)));
            found.extend(harmed.map(|avoided| Contaminated { part, cell, avoided }));
            left.extend(own);
        }
        found
    }
}

impl JudgedBoard<'_, '_> {
    /// The parts on the board with their cells; empty if traces do not matter.
    pub(super) fn parts_on_board(&self) -> Vec<(usize, ElectrodeCell)> {
        self.traces.iter().flat_map(|_| self.cells.iter()).collect()
    }

    /// Checks the parts on their cells at an instant for contamination, with the merges done by then.
    pub(super) fn check_traces(
        &mut self,
        nth: usize,
        at_ns: u64,
        operations: &[AssayOperation],
        assay: &JudgedAssay,
        there: &[(usize, ElectrodeCell)],
        findings: &mut Findings,
    ) {
        let Some(traces) = &mut self.traces else { return };
        traces.merge(operations, |place| assay.beats[place].is_some());
        findings.count_checks(Rule::Trace, there.len());
        for Contaminated { part, cell, avoided } in traces.visit(there.iter().copied()) {
            let (name, at) = (&self.order.parts[part].name, ms(at_ns));
            let title = format!("`{name}` enters {cell} at {at}, where traces of `{}` remain", avoided.of);
            findings.push(self.run.violation(Rule::Trace, nth, at_ns, title).label(avoided.span, "avoided here"));
        }
    }
}
