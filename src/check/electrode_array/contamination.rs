//! The traces that a task avoids, and operations that would leave them in any plan.

use super::errors;
use super::goals::{BoardStepJudge, is_assay, phrases};
use super::positions::BoardBefore;
use crate::check::lets::Argument;
use crate::check::tasks::{VocabularyAction, VocabularyStep};
use crate::check::value::{ObjectName, Value};
use crate::check::verbs::Call;
use crate::claims::electrode_array::{
    AssayOperation, AvoidedTrace, Contamination, ElectrodeArrayAction, ElectrodeArrayOrder, ElectrodeArrayStop, Fluids,
    WashCourse,
};
use crate::claims::{Job, Order};
use crate::device::electrode_array::{ElectrodeCell, Electrodes};
use crate::device::instrument::Awaited;
use crate::diagnostic::{Code, Diagnostic, Sink};
use crate::source::Span;
use std::collections::{BTreeMap, BTreeSet};

impl BoardStepJudge<'_> {
    /// The traces that a task avoids, from the conditions before its steps.
    pub fn contamination(&mut self, conditions: &[Call], steps: &[VocabularyStep]) -> Option<Contamination> {
        let mut contamination = Contamination::default();
        let mut is_whole = true;
        for call in conditions {
            let no_droplet = self.facts.layout.electrodes != Electrodes::Single;
            self.sink.push_if_some(no_droplet.then(|| errors::parts_leave_no_traces(call.span)))?;
            let named = call.phrases.iter().filter(|(preposition, _)| *preposition != "to").map(|(_, fluid)| fluid);
            let fluids = call.object.iter().chain(named);
            let fluids: Vec<Option<String>> = fluids.map(|fluid| self.fluid(fluid)).collect();
            match fluids.as_slice() {
                [Some(of), Some(within)] if of != within => {
                    let trace = AvoidedTrace { of: of.clone(), within: within.clone(), span: call.span };
                    let is_known = |known: &AvoidedTrace| known.of == trace.of && known.within == trace.within;
                    if !contamination.avoided.iter().any(is_known) {
                        contamination.avoided.push(trace);
                    }
                }
                // A fluid does no harm to itself, so a list of fluids needs no exceptions.
                [Some(_), Some(_)] => {}
                [Some(wash)] if !contamination.washes.contains(wash) => contamination.washes.push(wash.clone()),
                _ => is_whole &= fluids.iter().all(Option::is_some),
            }
            if let Some(exit) = phrases(call, "to").next().filter(|_| fluids.iter().all(Option::is_some)) {
                let course = self.wash_course(call, exit);
                let earlier =
                    contamination.course.as_ref().map(|earlier| errors::washes_by_two(call.span, earlier.span));
                is_whole &= self.sink.push_if_some(earlier).is_some() && course.is_some();
                contamination.course = course.map(Box::new);
            }
        }
        self.in_one_assay(conditions, steps)?;
        let is_wash = |fluid: &String| contamination.washes.contains(fluid);
        let idle = |trace: &&AvoidedTrace| is_wash(&trace.of) || is_wash(&trace.within);
        if is_whole && let Some(trace) = contamination.avoided.iter().find(idle) {
            let fluid = if is_wash(&trace.of) { &trace.of } else { &trace.within };
            let is_named =
                |fluid: &String, asked: &Argument| matches!(&asked.value, Value::Object(name) if name.name == *fluid);
            let washes = |call: &&Call| phrases(call, "with").any(|asked| is_named(fluid, asked));
            let wash = conditions.iter().find(washes).map_or(trace.span, |call| call.span);
            self.sink.push(errors::avoids_a_wash(trace.span, fluid, wash));
            return None;
        }
        is_whole.then_some(contamination)
    }

    /// The course of automatic wash droplets: their reservoir and their exit.
    fn wash_course(&mut self, call: &Call, exit: &Argument) -> Option<WashCourse> {
        let from = phrases(call, "with").next()?;
        let exit = self.stop(exit);
        let Value::Object(ObjectName { name, .. }) = &from.value else { return None };
        let is_dispensed = self.board_scene.outlets.iter().any(|outlet| outlet.name == *name);
        self.sink.push_if_some((!is_dispensed).then(|| errors::washes_from_no_reservoir(from.span, name)))?;
        let (fluid, outlet, dispense_ns) = self.dispensing(call, from)?;
        Some(WashCourse { fluid, outlet, dispense_ns, exit: exit?, span: call.span })
    }

    /// Reports a task that avoids traces but does not consist of one assay and of steps that move nothing.
    fn in_one_assay(&mut self, conditions: &[Call], steps: &[VocabularyStep]) -> Option<()> {
        let Some(avoids) = conditions.iter().find(|call| call.object.is_some()) else {
            let idle = conditions.first().map(|call| errors::washes_nothing(call.span));
            return self.sink.push_if_some(idle);
        };
        let moving = || steps.iter().filter(|step| !matches!(step.action, VocabularyAction::Wait(_)));
        let besides = moving().find(|step| !is_assay(&step.action)).or(moving().nth(1));
        self.sink.push_if_some(besides.map(|step| errors::avoids_outside_assay(step.span, avoids.span)))
    }

    /// A fluid of the scene by its name; `None` after an error.
    fn fluid(&mut self, asked: &Argument) -> Option<String> {
        let Value::Object(ObjectName { name, word, .. }) = &asked.value else { return None };
        if self.board_scene.is_faulty_fluid(name) {
            return None;
        }
        let fluids = self.board_scene.fluids();
        let wrong = (!fluids.contains(name.as_str()))
            .then(|| errors::unknown_fluid(Code::E0565, asked.span, name, *word, &fluids, self.scene));
        asked.unless(wrong, self.sink)?;
        Some(name.clone())
    }
}

/// Enters the fluids of the parts before each order, by job index, and reports operations at one place that contaminate
/// each other in any plan.
pub fn check_contamination(jobs: &mut [Job], before: Vec<(usize, BoardBefore)>, sink: &mut Sink) {
    let (mut reported, mut warned) = (BTreeSet::new(), BTreeSet::new());
    for (nth, board) in before {
        let (earlier, rest) = jobs.split_at_mut(nth);
        let Job { device, run_span, holds, order: Order::ElectrodeArray(order), .. } = &mut rest[0] else { continue };
        if order.contamination.is_unheeded() {
            continue;
        }
        let is_cleaned =
            holds.iter().any(|hold| hold.step == 0 && matches!(hold.terms.awaited, Awaited::Person { .. }));
        let contaminating = contaminated_before(earlier, device, order, &board.fluids).filter(|_| !is_cleaned);
        if let Some((earlier, trace)) = contaminating
            && warned.insert((*run_span, trace.span))
        {
            sink.push(errors::contaminated_before(trace.span, &trace.of, earlier));
        }
        order.contamination.before = board.fluids;
        let harmed = harmed_at_one_place(order, &board.positions);
        if let Some((span, wrong)) = harmed.filter(|(span, _)| reported.insert(*span)) {
            sink.push(wrong.label_elsewhere(order.contamination.avoided[0].span, span, "avoided here"));
        }
    }
}

/// The last earlier task of a device that moved a fluid whose traces an order avoids, and the trace.
fn contaminated_before<'a>(
    earlier: &'a [Job],
    device: &str,
    order: &'a ElectrodeArrayOrder,
    before: &[Fluids],
) -> Option<(&'a Job, &'a AvoidedTrace)> {
    let own = || order.parts.iter().map(|part| part.name.as_str()).zip(before);
    earlier.iter().rev().filter(|job| job.device == device).find_map(|job| {
        let acting = ElectrodeArrayOrder::of(&job.order)?.acting_parts();
        let led = own().filter(|(name, _)| acting.contains(name));
        let fluids: BTreeSet<&String> = led.flat_map(|(_, fluids)| fluids).collect();
        Some((job, order.contamination.avoided.iter().find(|trace| fluids.contains(&trace.of))?))
    })
}

/// A droplet at a cell, with its fluids at that time.
struct PlacedDroplet {
    part: usize,
    fluids: Fluids,
    cell: ElectrodeCell,
    span: Span,
}

/// Droplet positions that the program fixes, whatever the plan.
struct PlacedDroplets {
    /// Before the first operation.
    starts: Vec<PlacedDroplet>,
    /// At the stops of operations, in order.
    stops: Vec<PlacedDroplet>,
    /// At the end, of the parts that are still on the board.
    ends: Vec<PlacedDroplet>,
}

impl PlacedDroplets {
    /// The positions in an assay; `positions` has the cell of each part before it.
    fn of(
        order: &ElectrodeArrayOrder,
        operations: &[AssayOperation],
        positions: &[Option<(ElectrodeCell, Span)>],
    ) -> PlacedDroplets {
        let mut fluids = order.contamination.before.clone();
        let (mut starts, mut stopped) = (Vec::new(), Vec::new());
        // By part.
        let mut ends: BTreeMap<usize, (ElectrodeCell, Span)> = BTreeMap::new();
        for (part, position) in positions.iter().enumerate() {
            let Some((cell, span)) = *position else { continue };
            starts.push(PlacedDroplet { part, fluids: fluids[part].clone(), cell, span });
            ends.insert(part, (cell, span));
        }
        for operation in operations {
            operation.begin_fluids(&mut fluids);
            operation.end_fluids(&mut fluids);
            let (part, span) = (operation.part, operation.span);
            // Where the plan chooses the place, it may keep the droplets apart.
            let stops: &[ElectrodeArrayStop] = if operation.among.is_empty() { &operation.stops } else { &[] };
            let here =
                |stop: &ElectrodeArrayStop| PlacedDroplet { part, fluids: fluids[part].clone(), cell: stop.cell, span };
            stopped.extend(stops.iter().map(here));
            match stops.last() {
                Some(last) => ends.insert(part, (last.cell, span)),
                None if operation.among.is_empty() => None,
                None => ends.remove(&part),
            };
            if let Some(half) = operation.splits {
                ends.insert(half.part, (half.cell, span));
            }
            operation.gone().and_then(|gone| ends.remove(&gone));
        }
        let end = |(part, (cell, span))| PlacedDroplet { part, fluids: fluids[part].clone(), cell, span };
        let ends = ends.into_iter().map(end).collect();
        PlacedDroplets { starts, stops: stopped, ends }
    }
}

/// The first stop at which contamination is certain in any plan: the droplet there is harmed by, or harms, another one
/// that starts, stops or ends there. `None` for orders with washes.
fn harmed_at_one_place(
    order: &ElectrodeArrayOrder,
    positions: &[Option<(ElectrodeCell, Span)>],
) -> Option<(Span, Diagnostic)> {
    let contamination = &order.contamination;
    if !contamination.washes.is_empty() {
        return None;
    }
    let assay = order.steps.iter().find_map(|step| match &step.action {
        ElectrodeArrayAction::Assay(operations) => Some(operations),
        ElectrodeArrayAction::Move(_) | ElectrodeArrayAction::Wait(_) => None,
    })?;
    let placed = PlacedDroplets::of(order, assay, positions);
    let (starts, ends) = (by_cell(&placed.starts), by_cell(&placed.ends));
    let mut earlier: DropletsByCell = BTreeMap::new();
    let harms = |left: &PlacedDroplet, comes: &PlacedDroplet| {
        left.part != comes.part && contamination.contaminates(&left.fluids, &comes.fluids)
    };
    let name = |of: &PlacedDroplet| order.parts[of.part].name.as_str();
    placed.stops.iter().find_map(|stop| {
        let place = place(stop);
        let both = at(&earlier, place).iter().find(|other| harms(other, stop) && harms(stop, other));
        let start = at(&starts, place).iter().find(|start| harms(start, stop));
        let end = at(&ends, place).iter().find(|end| harms(stop, end));
        let wrong = match (both, start, end) {
            (Some(other), _, _) => errors::harms_at_one_place(stop.span, [name(other), name(stop)], stop.cell),
            (None, Some(start), _) => {
                errors::stops_where_another_starts(stop.span, start.span, [name(start), name(stop)], stop.cell)
            }
            (None, None, Some(end)) => {
                // Washes follow the order of the program.
                let is_written_before = at(&earlier, place).iter().any(|other| other.part == end.part);
                let names = [name(stop), name(end)];
                errors::ends_where_another_stops(stop.span, end.span, names, stop.cell, is_written_before)
            }
            (None, None, None) => {
                earlier.entry(place).or_default().push(stop);
                return None;
            }
        };
        Some((stop.span, wrong))
    })
}

/// Droplets by column and row of their cells.
type DropletsByCell<'a> = BTreeMap<(u32, u32), Vec<&'a PlacedDroplet>>;

fn place(droplet: &PlacedDroplet) -> (u32, u32) {
    (droplet.cell.column, droplet.cell.row)
}

fn at<'d, 'a>(droplets: &'d DropletsByCell<'a>, place: (u32, u32)) -> &'d [&'a PlacedDroplet] {
    droplets.get(&place).map_or(&[], Vec::as_slice)
}

fn by_cell<'a>(droplets: impl IntoIterator<Item = &'a PlacedDroplet>) -> DropletsByCell<'a> {
    let mut found: DropletsByCell = BTreeMap::new();
    droplets.into_iter().for_each(|droplet| found.entry(place(droplet)).or_default().push(droplet));
    found
}
