//! Stays in zones: a part that is heated, read or held is in its zone for the whole time, and alone while it is read.

use super::assay::JudgedAssay;
use super::parts::PartsOnBoard;
use super::{Findings, JudgedBoard, Rule, ms};
use crate::claims::electrode_array::{AssayOperation, BoardZone, ElectrodeArrayOrder, ZoneSort};
use crate::device::electrode_array::ElectrodeCell;
use std::collections::{BTreeMap, BTreeSet, VecDeque};

/// The zones of a board during an assay; only those in which an operation stays.
pub(super) struct JudgedZones<'c> {
    zones: &'c [BoardZone],
    /// By zone: the parts in it, each with the beat since which it has been there without a break.
    within: BTreeMap<usize, BTreeMap<usize, u64>>,
    /// By zone: the last beat after which several parts were in it.
    crowded: BTreeMap<usize, u64>,
    /// By part: the indices of its pending operations in zones, the next one first.
    due: BTreeMap<usize, VecDeque<usize>>,
    /// The parts that will merge into another one.
    merging: BTreeSet<usize>,
}

impl<'c> JudgedZones<'c> {
    /// The zones before the first beat.
    pub fn new(order: &'c ElectrodeArrayOrder, operations: &[AssayOperation]) -> JudgedZones<'c> {
        let (mut within, mut due) = (BTreeMap::new(), BTreeMap::new());
        for (place, operation) in operations.iter().enumerate() {
            let Some(stay) = operation.zone else { continue };
            within.entry(stay.zone).or_insert_with(BTreeMap::new);
            due.entry(operation.part).or_insert_with(VecDeque::new).push_back(place);
        }
        let merging = operations.iter().filter_map(|operation| operation.with).collect();
        JudgedZones { zones: &order.zones, within, crowded: BTreeMap::new(), due, merging }
    }

    /// Notes the positions of the parts after `beat` beats, before the assay is updated: a part that leaves the board
    /// at that instant still counts.
    pub fn look(&mut self, beat: u64, cells: &PartsOnBoard) {
        for (zone, within) in &mut self.within {
            let Some(zone_body) = self.zones.get(*zone) else { continue };
            within.retain(|part, _| cells[*part].is_some_and(|cell| covers(zone_body, cell)));
            for (part, _) in cells.iter().filter(|(_, cell)| covers(zone_body, *cell)) {
                within.entry(part).or_insert(beat);
            }
        }
    }

    /// Notes the zones with several parts after `beat` beats; two parts that have just merged count as one.
    pub fn count(&mut self, beat: u64, settled: &PartsOnBoard) {
        for (zone, within) in &self.within {
            let is_there = |part: &&usize| settled[**part].is_some() || !self.merging.contains(*part);
            if within.keys().filter(is_there).count() > 1 {
                self.crowded.insert(*zone, beat);
            }
        }
    }
}

/// Whether a cell is in a zone.
fn covers(zone: &BoardZone, cell: ElectrodeCell) -> bool {
    let [low, at, high] = [zone.from, cell, zone.to].map(ElectrodeCell::pair);
    (0..2).all(|axis| low[axis] <= at[axis] && at[axis] <= high[axis])
}

impl JudgedBoard<'_, '_> {
    /// Checks the operations in zones that are done by now: the part was in the zone for the whole time.
    pub(super) fn stays(
        &self,
        nth: usize,
        now_ns: u64,
        operations: &[AssayOperation],
        assay: &JudgedAssay,
        zones: &mut JudgedZones,
        findings: &mut Findings,
    ) {
        let JudgedZones { zones, within, crowded, due, .. } = zones;
        let step_ns = self.order.facts.step_ns;
        for (part, due) in due {
            let Some((operation, zone)) = due.front().and_then(|place| in_zone(operations, *place)) else { continue };
            let Some(beats) = due.front().and_then(|place| assay.beats[*place]) else { continue };
            due.pop_front();
            findings.count_checks(Rule::Zone, 1);
            let needed = operation.stay_ns.div_ceil(step_ns);
            let since = within.get(&zone).and_then(|within| within.get(part));
            let stayed = since.map_or(0, |since| beats.done.saturating_sub(*since));
            let alone = crowded.get(&zone).map_or(u64::MAX, |last| beats.done.saturating_sub(*last).saturating_sub(1));
            let Some(zone) = zones.get(zone) else { continue };
            let (name, noun) = (&self.order.parts[*part].name, zone.sort.name());
            let wanted = ms(operation.stay_ns);
            let title = if stayed < needed {
                let stayed = ms(stayed.saturating_mul(step_ns));
                format!("`{name}` must be at {noun} `{}` for {wanted}, but is there for only {stayed}", zone.name)
            } else if zone.sort == ZoneSort::Detector && alone < needed {
                format!(
                    "`{name}` must be read by `{}` for {wanted}, but another part is there during that time",
                    zone.name
                )
            } else {
                continue;
            };
            let wrong = self.run.violation(Rule::Zone, nth, now_ns, title);
            findings.push(wrong.label(operation.span, "this operation").label(zone.span, "this zone"));
        }
    }
}

/// An operation with the index of its zone; `None` if it has none.
fn in_zone(operations: &[AssayOperation], place: usize) -> Option<(&AssayOperation, usize)> {
    let operation = operations.get(place)?;
    Some((operation, operation.zone?.zone))
}
