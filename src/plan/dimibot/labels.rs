//! The Pareto front of paths between two cells in distance and switches, needed for limits on both.
//!
//! Problem: the Pareto front of (distance, switches) over the paths of single flips within the limits. Method:
//! bi-criteria A* with constant-time dominance checks (BOA*, Hernández and others 2023): labels leave the queue in
//! lexicographic order of (distance, switches) so far plus their lower bounds to the goal, so a label is dominated if
//! an earlier one of its cell has no more switches. The bounds are sums over the modules that differ, which are
//! consistent. Guaranteed: complete unless the budget ran out. One step of the budget is one switch examined; a switch
//! that leads to a label costs four more, since labels are kept.

use super::field::LatticeField;
use super::lattice::{Flip, LatticeCell, Side, SwitchWeights, bits};
use super::queue::RadixQueue;
use super::tally::{MotionTally, add_to_front};
use crate::plan::search::Meter;
use rustc_hash::FxHashMap;

/// Budget steps of a kept label, on top of the one for its switch.
const LABEL_STEPS: u64 = 4;
/// Bits of a queue's key that hold the switches. A path has no more switches than labels, of which there are fewer than 2^24.
const SWITCH_BITS: u32 = 24;
const MAX_LABELS: usize = 1 << SWITCH_BITS;
const NO_PARENT: u32 = u32::MAX;

/// The paths found, and whether they are complete.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LabelFront<P> {
    /// None dominates another.
    pub ways: Vec<(MotionTally, P)>,
    /// Whether every path within the limits is dominated by one of `ways`.
    pub is_complete: bool,
}

#[derive(Clone, Copy)]
struct DimibotLabel {
    cell: LatticeCell,
    distance: u64,
    switches: u32,
    parent: u32,
    by: Flip,
}

struct DimibotLabelSearch {
    goal: LatticeCell,
    limits: MotionTally,
    weights: [SwitchWeights; 2],
    labels: Vec<DimibotLabel>,
    queue: RadixQueue<u32>,
    /// Least number of switches among the expanded labels of a cell.
    settled: FxHashMap<LatticeCell, u32>,
    front: Vec<(MotionTally, Vec<Flip>)>,
    /// Whether a label was dropped because its switches exceed a queue key.
    has_dropped: bool,
}

/// The paths from `start` to `goal` within the limits. `known` are paths found before: they belong to the answer, and prune what
/// they dominate.
pub(super) fn front(
    field: &LatticeField,
    [start, goal]: [LatticeCell; 2],
    limits: MotionTally,
    known: Vec<(MotionTally, Vec<Flip>)>,
    meter: &mut Meter,
) -> LabelFront<Vec<Flip>> {
    let lattice = field.lattice();
    let mut search = DimibotLabelSearch {
        goal,
        limits,
        weights: [SwitchWeights::distance(lattice), SwitchWeights::switches(lattice)],
        labels: Vec::new(),
        queue: RadixQueue::default(),
        settled: FxHashMap::default(),
        front: Vec::new(),
        has_dropped: false,
    };
    for (tally, flips) in known {
        add_to_front(&mut search.front, tally, flips);
    }
    let is_complete = search.run(field, start, meter);
    search.front.retain(|(tally, _)| tally.is_within(limits));
    LabelFront { ways: search.front, is_complete }
}

impl DimibotLabelSearch {
    fn run(&mut self, field: &LatticeField, start: LatticeCell, meter: &mut Meter) -> bool {
        let by = Flip::of_bit(Side::Left, 1);
        self.push(DimibotLabel { cell: start, distance: 0, switches: 0, parent: NO_PARENT, by });
        let mut work = field.work();
        let (mut reader, _) = work.open(field);
        while let Some(index) = self.queue.pop() {
            let label = self.labels[index as usize];
            if self.is_dominated(&label) {
                continue;
            }
            self.settled.insert(label.cell, label.switches);
            if label.cell == self.goal {
                let flips = self.path(index);
                add_to_front(&mut self.front, tally(&label), flips);
                continue;
            }
            let legal = reader.legal(label.cell.pair()).unwrap_or([0, 0]);
            for side in Side::BOTH {
                for bit in bits(legal[side.index()]) {
                    if meter.left().steps <= LABEL_STEPS || self.labels.len() >= MAX_LABELS {
                        return false;
                    }
                    meter.charge(1);
                    let by = Flip::of_bit(side, bit);
                    let (distance, switches) = (label.distance + self.weights[0].of(by), label.switches + 1);
                    if self.push(DimibotLabel { cell: label.cell.after(by), distance, switches, parent: index, by }) {
                        meter.charge(LABEL_STEPS);
                    }
                }
            }
        }
        !self.has_dropped
    }

    /// Queues a label that may lead to a path not yet known; `false` if it cannot.
    fn push(&mut self, label: DimibotLabel) -> bool {
        if self.is_dominated(&label) {
            return false;
        }
        let ahead = self.ahead(&label);
        let Some(key) = ahead.distance.checked_mul(1 << SWITCH_BITS).filter(|key| key >> 62 == 0) else {
            self.has_dropped = true;
            return false;
        };
        self.queue.push(key | ahead.switches, self.labels.len() as u32);
        self.labels.push(label);
        true
    }

    fn is_dominated(&self, label: &DimibotLabel) -> bool {
        let ahead = self.ahead(label);
        self.settled.get(&label.cell).is_some_and(|switches| *switches <= label.switches)
            || !ahead.is_within(self.limits)
            || self.front.iter().any(|(known, _)| known.is_within(ahead))
    }

    /// Lower bound on every path through the label.
    fn ahead(&self, label: &DimibotLabel) -> MotionTally {
        let [distance, switches] = [0, 1].map(|k| self.weights[k].between(label.cell, self.goal));
        let rest = MotionTally { distance, switches, pulses: switches };
        tally(label).plus(rest)
    }

    fn path(&self, index: u32) -> Vec<Flip> {
        let mut flips = Vec::new();
        let mut at = index;
        while let Some(label) = self.labels.get(at as usize).filter(|label| label.parent != NO_PARENT) {
            flips.push(label.by);
            at = label.parent;
        }
        flips.reverse();
        flips
    }
}

fn tally(label: &DimibotLabel) -> MotionTally {
    let switches = u64::from(label.switches);
    MotionTally { distance: label.distance, switches, pulses: switches }
}
