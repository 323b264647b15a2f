//! Automatic wash droplets, as `wash with water to (16, 2)` requests: one before each droplet that comes to a place
//! where an earlier droplet, in program order, has left a fluid that harms it.
//!
//! A place is where a droplet stays from one operation until its next one elsewhere. Each wash droplet is dispensed,
//! passes over the soiled electrodes of the place once the operations that soiled them are done, and leaves; the next
//! operation there waits for it. Washes then are operations like any others.

use super::errors;
use super::positions::BoardBefore;
use super::stay_steps::{StayExcess, StaySteps};
use crate::claims::electrode_array::{
    AssayOperation, BoardPart, Contamination, ElectrodeArrayAction, ElectrodeArrayOrder, ElectrodeArrayStop, Fluids,
    WashCourse,
};
use crate::claims::{Job, Order};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell, MAX_PARTS};
use crate::diagnostic::Sink;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Name of wash droplets, before the number.
const NAME: &str = "wash";

/// Enters the wash droplets that tasks request into their orders; returns whether there are any. `before` has the board
/// before each job.
pub fn insert_washes(jobs: &mut [Job], before: &[(usize, BoardBefore)], sink: &mut Sink) -> bool {
    // By device, the wash droplets of all its tasks.
    let mut droplets: BTreeMap<String, Vec<BoardPart>> = BTreeMap::new();
    for (nth, board) in before {
        let Job { device, order: Order::ElectrodeArray(order), .. } = &mut jobs[*nth] else { continue };
        let Some(course) = order.contamination.course.clone() else { continue };
        let own = droplets.entry(device.clone()).or_default();
        if insert_in_order(order, &course, board, own, sink).is_none() {
            return false;
        }
    }
    droplets.retain(|_, own| !own.is_empty());
    // Tasks of one scene keep sharing their list of parts.
    let mut extended: BTreeMap<*const Vec<BoardPart>, Arc<Vec<BoardPart>>> = BTreeMap::new();
    for job in jobs.iter_mut() {
        let (Some(own), Order::ElectrodeArray(order)) = (droplets.get(&job.device), &mut job.order) else { continue };
        let with_own = || Arc::new(order.parts.iter().chain(own).cloned().collect());
        order.parts = Arc::clone(extended.entry(Arc::as_ptr(&order.parts)).or_insert_with(with_own));
    }
    !droplets.is_empty()
}

/// Enters the wash droplets of one order; `droplets` are those of the device so far. `None` after an error.
fn insert_in_order(
    order: &mut ElectrodeArrayOrder,
    course: &WashCourse,
    before: &BoardBefore,
    droplets: &mut Vec<BoardPart>,
    sink: &mut Sink,
) -> Option<()> {
    let facts = &order.facts;
    for step in &mut order.steps {
        let ElectrodeArrayAction::Assay(operations) = &mut step.action else { continue };
        let visits = visits(operations, facts, before);
        let washes = washes(&visits, &order.contamination, course.outlet);
        let parts = order.parts.len() + droplets.len();
        if parts + washes.len() > MAX_PARTS {
            sink.push(errors::too_many_washes(course.span, washes.len(), parts, MAX_PARTS));
            return None;
        }
        let stem = name_apart(&order.parts);
        let first = droplets.len();
        droplets.extend((first..first + washes.len()).map(|number| BoardPart {
            name: format!("{stem}{}", number + 1),
            cell: None,
            span: course.span,
        }));
        *operations = with_washes(std::mem::take(operations), &washes, course, order.parts.len() + first);
        let mut stays = StaySteps::default();
        let excess = operations.iter().find_map(|operation| stays.add(operation, facts));
        sink.push_if_some(excess.map(|StayExcess { part, steps }| {
            let part = part.and_then(|part| order.parts.get(part)).map(|part| part.name.as_str());
            errors::stays_too_long(course.span, part, steps, facts.step_ns)
        }))?;
    }
    Some(())
}

/// Name of wash droplets before the number, chosen so that it clashes with no part.
fn name_apart(parts: &[BoardPart]) -> String {
    let is_taken = |stem: &str| {
        let numbered =
            |name: &str| name.strip_prefix(stem).is_some_and(|rest| rest.bytes().all(|c| c.is_ascii_digit()));
        parts.iter().any(|part| numbered(&part.name))
    };
    let mut stem = NAME.to_owned();
    while is_taken(&stem) {
        stem.push('_');
    }
    stem
}

/// The stay of a droplet at a place.
struct PlaceVisit {
    part: usize,
    /// Its first and last operation there; `None` for a droplet that stands there without an operation yet.
    operations: Option<[usize; 2]>,
    /// The electrodes that it covers.
    cells: BTreeSet<ElectrodeCell>,
    /// The fluids that it contains at the end of the visit.
    fluids: Fluids,
}

/// The visits of droplets to places that the program fixes, in program order; places that the plan chooses are left
/// out. A new visit begins if another droplet came to the place meanwhile, or if the droplet goes on to more
/// electrodes, as in a mixing loop. So all operations of a visit precede those of the next visit to its electrodes.
fn visits(operations: &[AssayOperation], facts: &ElectrodeArrayFacts, before: &BoardBefore) -> Vec<PlaceVisit> {
    let mut walk = VisitWalk { visits: Vec::new(), at: BTreeMap::new() };
    let mut fluids = before.fluids.clone();
    for (part, position) in before.positions.iter().enumerate() {
        if let Some((cell, _)) = *position {
            walk.come(part, cell, [cell], None, &fluids[part]);
        }
    }
    for (place, operation) in operations.iter().enumerate() {
        operation.begin_fluids(&mut fluids);
        operation.end_fluids(&mut fluids);
        let part = operation.part;
        // The place is unknown where the plan chooses it, and left where the droplet moves elsewhere and back.
        if !operation.among.is_empty() || operation.stops.iter().any(|stop| Some(stop.cell) != walk.cell(part)) {
            walk.at.remove(&part);
        }
        if operation.among.is_empty()
            && let Some(cell) = operation.stops.last().map_or_else(|| walk.cell(part), |stop| Some(stop.cell))
        {
            let mut cells: Vec<ElectrodeCell> = operation.stops.iter().map(|stop| stop.cell).collect();
            cells.extend(if operation.mixes { facts.mixing_loop(cell) } else { vec![cell] });
            walk.come(part, cell, cells, Some(place), &fluids[part]);
        }
        if let Some(half) = operation.splits {
            walk.come(half.part, half.cell, [half.cell], Some(place), &fluids[half.part]);
        }
        operation.gone().and_then(|gone| walk.at.remove(&gone));
    }
    walk.visits
}

/// The visits so far.
struct VisitWalk {
    visits: Vec<PlaceVisit>,
    /// By part, its cell, and its visit there as long as no other part has come onto an electrode of that visit.
    at: BTreeMap<usize, (ElectrodeCell, Option<usize>)>,
}

impl VisitWalk {
    /// The cell of a part, if known.
    fn cell(&self, part: usize) -> Option<ElectrodeCell> {
        self.at.get(&part).map(|(cell, _)| *cell)
    }

    /// Enters that a part comes to a cell, or goes on there, and covers these electrodes meanwhile.
    fn come(
        &mut self,
        part: usize,
        cell: ElectrodeCell,
        cells: impl IntoIterator<Item = ElectrodeCell>,
        operation: Option<usize>,
        fluids: &Fluids,
    ) {
        let cells: BTreeSet<ElectrodeCell> = cells.into_iter().collect();
        let lasting = self.at.get(&part).filter(|(at, _)| *at == cell).and_then(|(_, visit)| *visit);
        let lasting = lasting.filter(|visit| self.visits[*visit].cells.is_superset(&cells));
        let visit = lasting.unwrap_or_else(|| {
            self.visits.push(PlaceVisit { part, operations: None, cells, fluids: Fluids::new() });
            self.visits.len() - 1
        });
        self.at.insert(part, (cell, Some(visit)));
        let own = &mut self.visits[visit];
        own.operations = operation.map(|last| [own.operations.map_or(last, |[first, _]| first), last]);
        own.fluids.clone_from(fluids);
        for (_, (_, other)) in self.at.iter_mut().filter(|(other, _)| **other != part) {
            let meets = |other: usize| !self.visits[other].cells.is_disjoint(&self.visits[visit].cells);
            *other = other.filter(|other| !meets(*other));
        }
    }
}

/// A wash, inserted before operation `before`.
struct PlannedWash {
    before: usize,
    /// The electrodes to wash in order, each with the operations that must be done there first.
    over: Vec<(ElectrodeCell, BTreeSet<usize>)>,
}

/// The washes needed between successive visits.
fn washes(visits: &[PlaceVisit], contamination: &Contamination, outlet: ElectrodeCell) -> Vec<PlannedWash> {
    let mut washes = Vec::new();
    let mut left: BTreeMap<ElectrodeCell, Vec<&PlaceVisit>> = BTreeMap::new();
    for visit in visits {
        if contamination.is_wash(&visit.fluids) {
            visit.cells.iter().for_each(|cell| drop(left.remove(cell)));
            continue;
        }
        let harms =
            |other: &PlaceVisit| other.part != visit.part && contamination.contaminates(&other.fluids, &visit.fluids);
        let mut soiled: BTreeMap<ElectrodeCell, BTreeSet<usize>> = BTreeMap::new();
        for cell in &visit.cells {
            let Some(others) = left.get_mut(cell) else { continue };
            let harmful: Vec<&PlaceVisit> = others.extract_if(.., |other| harms(other)).collect();
            if !harmful.is_empty() {
                let done = harmful.iter().filter_map(|other| other.operations).map(|[_, last]| last);
                soiled.insert(*cell, done.collect());
            }
        }
        if let Some([before, _]) = visit.operations
            && !soiled.is_empty()
        {
            washes.push(PlannedWash { before, over: nearest_first(soiled, outlet) });
        }
        visit.cells.iter().for_each(|cell| left.entry(*cell).or_default().push(visit));
    }
    washes.sort_by_key(|wash| wash.before);
    washes
}

/// The cells in nearest-neighbour order, beginning with the one nearest to `from`.
fn nearest_first(
    mut cells: BTreeMap<ElectrodeCell, BTreeSet<usize>>,
    from: ElectrodeCell,
) -> Vec<(ElectrodeCell, BTreeSet<usize>)> {
    let mut ordered: Vec<(ElectrodeCell, BTreeSet<usize>)> = Vec::new();
    while let Some(next) = cells.keys().copied().min_by_key(|cell| {
        let last = ordered.last().map_or(from, |(last, _)| *last);
        (cell.steps_to(last), *cell)
    }) {
        ordered.extend(cells.remove_entry(&next));
    }
    ordered
}

/// The operations with the washes inserted, each before the operation that needs it; wash `n`, from 0, is the part
/// `first + n`.
fn with_washes(
    operations: Vec<AssayOperation>,
    washes: &[PlannedWash],
    course: &WashCourse,
    first: usize,
) -> Vec<AssayOperation> {
    let mut all: Vec<AssayOperation> = Vec::new();
    // New indices of the operations, by their old ones.
    let mut moved: Vec<usize> = Vec::new();
    let mut washes = washes.iter().zip(first..).peekable();
    for (place, mut operation) in operations.into_iter().enumerate() {
        let others = operation.after.iter_mut().chain(operation.within.iter_mut().flat_map(|lag| &mut lag.of));
        others.for_each(|other| *other = moved[*other]);
        while let Some((wash, part)) = washes.next_if(|(wash, _)| wash.before == place) {
            let at = |cell: ElectrodeCell| ElectrodeArrayStop { cell, span: course.span, origin: None };
            let passing = |stop: ElectrodeArrayStop| AssayOperation::passing(part, vec![stop], course.span);
            let (stay_ns, fluid) = (course.dispense_ns, Some(course.fluid.clone()));
            all.push(AssayOperation { comes: true, fluid, stay_ns, ..passing(at(course.outlet)) });
            all.extend(wash.over.iter().map(|(cell, done)| {
                let after = done.iter().map(|done| moved[*done]).collect();
                AssayOperation { after, ..passing(at(*cell)) }
            }));
            operation.after.push(all.len() - 1);
            all.push(AssayOperation { leaves: true, ..passing(course.exit.clone()) });
        }
        moved.push(all.len());
        all.push(operation);
    }
    all
}
