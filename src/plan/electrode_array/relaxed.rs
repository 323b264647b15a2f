//! Lower bounds of an assay that hold wherever its operations take place.
//!
//! Each part goes from place to place as if it were alone, to whichever is best for what it does next; parts that merge wait for each
//! other, and what comes after something waits for the earliest end of it. Where several operations stay at the same places, none
//! takes place while another one is there, so that all of them take as long as their stays, divided among the places.

use super::board::{BoardCosts, CellIndex};
use super::errands::AssaySite;
use super::fast::{Distances, UNREACHABLE};
use super::stage;
use crate::claims::electrode_array::AssayOperation;
use crate::device::electrode_array::ElectrodeCell;
use crate::plan::search::Meter;
use std::collections::BTreeMap;

/// Where a part may be after its last operation, with the first instant at which it can be done there.
type Reached = Vec<(CellIndex, u64)>;

/// Bounds on the plans of all arrangements.
pub(super) fn bounds(site: &AssaySite, operations: &[AssayOperation], meter: &mut Meter) -> BoardCosts {
    let order = site.order;
    let flat = |cell: ElectrodeCell| stage::flat(order, cell);
    let mut ways = Ways { site, distances: Distances::of(site.ground.board()) };
    let mut starts: Vec<Option<CellIndex>> = site.cells.iter().map(|cell| cell.map(flat)).collect();
    let mut at: Vec<Reached> = starts.iter().map(|start| start.iter().map(|cell| (*cell, 0)).collect()).collect();
    let mut done: Vec<u64> = Vec::with_capacity(operations.len());
    let mut queues: BTreeMap<Vec<CellIndex>, ServedPlaces> = BTreeMap::new();
    let mut lasts: BTreeMap<usize, Vec<CellIndex>> = BTreeMap::new();
    for operation in operations {
        let stay = operation.stay_steps(&order.facts);
        let begins = operation.after.iter().filter_map(|earlier| done.get(*earlier)).max().copied().unwrap_or(0);
        if let Some(stop) = operation.stops.first().filter(|_| operation.comes) {
            at[operation.part] = vec![(flat(stop.cell), 0)];
            starts[operation.part] = Some(flat(stop.cell));
        }
        let stops = places(operation, flat);
        let mut ends: Option<BTreeMap<CellIndex, u64>> = None;
        for part in operation.parts() {
            let arrivals = stops.iter().fold(at[part].clone(), |from, to| ways.reach(&from, to, meter));
            let own: BTreeMap<CellIndex, u64> = arrivals.into_iter().collect();
            ends = Some(match ends {
                None => own,
                Some(other) => {
                    let both = |(cell, one): (CellIndex, u64)| Some((cell, one.max(*own.get(&cell)?)));
                    other.into_iter().filter_map(both).collect()
                }
            });
        }
        let ends = ends.unwrap_or_default();
        let heads = ends.values().map(|arrival| (*arrival).max(begins)).min();
        let reached: Reached = ends.into_iter().map(|(cell, arrival)| (cell, arrival.max(begins) + stay)).collect();
        done.push(heads.map_or(0, |head| head + stay));
        if let (Some(head), true) = (heads, stay > 0 && !operation.mixes && !operation.comes) {
            let mut there: Vec<CellIndex> = reached.iter().map(|(cell, _)| *cell).collect();
            there.sort_unstable();
            queues.entry(there).or_default().add(head, stay);
        }
        if !stops.is_empty() {
            lasts.insert(operation.part, reached.iter().map(|(cell, _)| *cell).collect());
        }
        if let Some(half) = operation.splits {
            let end = done.last().copied().unwrap_or(0);
            at[half.part] = vec![(flat(half.cell), end)];
        }
        at[operation.part] = reached;
    }
    let queued = queues.iter().map(|(places, served)| served.end(places.len() as u64));
    let makespan = done.iter().copied().chain(queued).max().unwrap_or(0);
    let away = |(part, last): (&usize, &Vec<CellIndex>)| {
        let start = starts[*part]?;
        ways.reach(&vec![(start, 0)], last, meter).iter().map(|(_, steps)| *steps).min()
    };
    let sum_of_costs = lasts.iter().filter_map(away).sum();
    BoardCosts { makespan, sum_of_costs }
}

/// The cells of each stop of an operation; of the last one, of which the plan chooses.
fn places(operation: &AssayOperation, flat: impl Fn(ElectrodeCell) -> CellIndex) -> Vec<Vec<CellIndex>> {
    if operation.among.is_empty() {
        return operation.stops.iter().map(|stop| vec![flat(stop.cell)]).collect();
    }
    vec![operation.among.iter().map(|place| flat(place.stop.cell)).collect()]
}

/// Operations that stay at the same places.
#[derive(Default)]
struct ServedPlaces {
    head: Option<u64>,
    work: u64,
}

impl ServedPlaces {
    fn add(&mut self, head: u64, stay: u64) {
        self.head = Some(self.head.map_or(head, |known| known.min(head)));
        self.work = self.work.saturating_add(stay);
    }

    /// The earliest end of all of them at some number of places.
    fn end(&self, places: u64) -> u64 {
        self.head.unwrap_or(0).saturating_add(self.work.div_ceil(places.max(1)))
    }
}

/// Distances on the board with nothing but its obstacles.
struct Ways<'a> {
    site: &'a AssaySite<'a>,
    distances: Distances,
}

impl Ways<'_> {
    /// The first instants at some cells, from others with their instants; cells that cannot be reached are left out.
    fn reach(&mut self, from: &Reached, to: &[CellIndex], meter: &mut Meter) -> Reached {
        let board = self.site.ground.board();
        let mut reached = Vec::with_capacity(to.len());
        for cell in to {
            let field = self.distances.to(board, *cell, meter);
            let steps = |(start, since): &(CellIndex, u64)| {
                let steps = field.from(*start);
                (steps != UNREACHABLE).then(|| since + u64::from(steps))
            };
            reached.extend(from.iter().filter_map(steps).min().map(|instant| (*cell, instant)));
        }
        reached
    }
}
