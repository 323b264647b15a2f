//! Critical path of an assay, for any choice of places: the earliest instant of each operation, and the least time of
//! everything after it.
//!
//! Each part moves as if it were alone, to the place that is best for its next operation. Parts that merge wait for
//! each other, and an operation that comes after others waits for their earliest end.

use crate::claims::electrode_array::AssayOperation;
use crate::device::electrode_array::ElectrodeCell;
use crate::plan::electrode_array::board::CellIndex;
use crate::plan::electrode_array::errands::AssaySite;
use crate::plan::electrode_array::fast::{Distances, UNREACHABLE};
use crate::plan::electrode_array::stage;
use crate::plan::search::Meter;

/// Cells that a part may reach, each with the earliest instant.
pub(super) type ReachedCells = Vec<(CellIndex, u64)>;

/// A place where an operation may take place.
#[derive(Debug, Clone, Copy)]
pub(super) struct TimedPlace {
    pub cell: CellIndex,
    /// The earliest instant at which it can begin there.
    pub head: u64,
    /// Least steps from its end there to the end of everything that must follow.
    pub tail: u64,
}

/// An operation with all of its places.
#[derive(Debug, Clone)]
pub(super) struct TimedOperation {
    /// Steps for which its part stays.
    pub stay: u64,
    /// The places that its parts can reach.
    pub places: Vec<TimedPlace>,
    /// The cells of each of its stops. Empty if it takes place where the previous operation has left its part.
    pub stops: Vec<Vec<CellIndex>>,
    /// For each of its parts, the previous operation and where that leaves the part.
    pub before: Vec<PartBefore>,
}

/// State of a part before an operation.
#[derive(Debug, Clone, Copy)]
pub(super) struct PartBefore {
    /// Its previous operation; `None` if it has had none.
    pub operation: Option<usize>,
    /// Its cell, if that does not depend on the place of that operation.
    pub at: Option<CellIndex>,
}

impl TimedOperation {
    /// The earliest instant at which it can begin; 0 if it cannot.
    pub fn head(&self) -> u64 {
        self.places.iter().map(|place| place.head).min().unwrap_or(0)
    }

    /// Least steps from its end to the end of everything that follows.
    pub fn tail(&self) -> u64 {
        self.places.iter().map(|place| place.tail).min().unwrap_or(0)
    }

    /// The cells of its places.
    pub fn cells(&self) -> impl Iterator<Item = CellIndex> {
        self.places.iter().map(|place| place.cell)
    }
}

/// The operations with their places, in the order of the program.
pub(super) fn timed(operations: &[AssayOperation], ways: &mut BoardWays) -> Vec<TimedOperation> {
    let mut timed = heads(operations, ways);
    tails(operations, &mut timed, ways);
    timed
}

/// The operations with their earliest instants; the tails are 0 yet.
fn heads(operations: &[AssayOperation], ways: &mut BoardWays) -> Vec<TimedOperation> {
    let site = ways.site;
    let flat = |cell: ElectrodeCell| stage::flat(site.order, cell);
    let start = |part: usize| site.cells[part].map(flat);
    let mut at: Vec<ReachedCells> =
        (0..site.cells.len()).map(|part| start(part).map(|cell| (cell, 0)).into_iter().collect()).collect();
    let mut before: Vec<PartBefore> =
        (0..at.len()).map(|part| PartBefore { operation: None, at: start(part) }).collect();
    let mut timed: Vec<TimedOperation> = Vec::with_capacity(operations.len());
    for (nth, operation) in operations.iter().enumerate() {
        let stay = operation.stay_steps(&site.order.facts);
        let ended = |earlier: &usize| timed.get(*earlier).map(|one| one.head() + one.stay);
        let begins = operation.after.iter().filter_map(ended).max().unwrap_or(0);
        if let Some(stop) = operation.stops.first().filter(|_| operation.comes) {
            at[operation.part] = vec![(flat(stop.cell), 0)];
            before[operation.part].at = Some(flat(stop.cell));
        }
        let stops = stops(operation, flat);
        let arrivals = operation.parts().map(|part| ways.through(&at[part], &stops));
        let together = |one: ReachedCells, other: ReachedCells| {
            let both = |(cell, since): (CellIndex, u64)| {
                let its = other.iter().find(|(at, _)| *at == cell)?.1;
                Some((cell, since.max(its)))
            };
            one.into_iter().filter_map(both).collect()
        };
        let arrived = arrivals.reduce(together).unwrap_or_default();
        let place =
            |(cell, arrival): &(CellIndex, u64)| TimedPlace { cell: *cell, head: begins.max(*arrival), tail: 0 };
        let places: Vec<TimedPlace> = arrived.iter().map(place).collect();
        at[operation.part] = places.iter().map(|place| (place.cell, place.head + stay)).collect();
        let before_each = operation.parts().map(|part| before[part]).collect();
        before[operation.part] = PartBefore { operation: Some(nth), at: None };
        timed.push(TimedOperation { stay, places, stops, before: before_each });
        if let Some(half) = operation.splits {
            let end = timed.last().map_or(0, |one| one.head() + stay);
            at[half.part] = vec![(flat(half.cell), end)];
            before[half.part] = PartBefore { operation: Some(nth), at: Some(flat(half.cell)) };
        }
    }
    timed
}

/// Adds the tails.
fn tails(operations: &[AssayOperation], timed: &mut [TimedOperation], ways: &mut BoardWays) {
    for nth in (0..timed.len()).rev() {
        let own = timed[nth].clone();
        let least = own.places.iter().map(|place| place.tail).min().unwrap_or(0) + own.stay;
        for earlier in &operations[nth].after {
            timed[*earlier].places.iter_mut().for_each(|place| place.tail = place.tail.max(least));
        }
        for before in &own.before {
            let Some(earlier) = before.operation else { continue };
            for place in &mut timed[earlier].places {
                let from = before.at.unwrap_or(place.cell);
                let to = ways.through(&[(from, 0)], &own.stops);
                let tail = |(cell, steps): &(CellIndex, u64)| {
                    let there = own.places.iter().find(|place| place.cell == *cell)?;
                    Some(steps + own.stay + there.tail)
                };
                place.tail = place.tail.max(to.iter().filter_map(tail).min().unwrap_or(0));
            }
        }
    }
}

/// The cells of each stop of an operation; if the plan chooses the place, all of its places as a single stop.
fn stops(operation: &AssayOperation, flat: impl Fn(ElectrodeCell) -> CellIndex) -> Vec<Vec<CellIndex>> {
    if operation.among.is_empty() {
        return operation.stops.iter().map(|stop| vec![flat(stop.cell)]).collect();
    }
    vec![operation.among.iter().map(|place| flat(place.stop.cell)).collect()]
}

/// Distances on the board with its obstacles only.
pub(super) struct BoardWays<'a, 'm> {
    pub site: &'a AssaySite<'a>,
    distances: Distances,
    meter: &'m mut Meter,
}

impl<'a, 'm> BoardWays<'a, 'm> {
    pub fn new(site: &'a AssaySite<'a>, meter: &'m mut Meter) -> BoardWays<'a, 'm> {
        BoardWays { site, distances: Distances::of(site.ground.board()), meter }
    }

    /// The earliest instants at the cells of the last stop, from cells with their instants, through all stops in order;
    /// `from` itself if there is no stop.
    pub fn through(&mut self, from: &[(CellIndex, u64)], stops: &[Vec<CellIndex>]) -> ReachedCells {
        stops.iter().fold(from.to_vec(), |from, to| self.reach(&from, to))
    }

    /// The earliest instants at some cells; cells that cannot be reached are left out.
    pub fn reach(&mut self, from: &[(CellIndex, u64)], to: &[CellIndex]) -> ReachedCells {
        let board = self.site.ground.board();
        let mut reached = Vec::with_capacity(to.len());
        for cell in to {
            let field = self.distances.to(board, *cell, self.meter);
            let steps = |(start, since): &(CellIndex, u64)| {
                let steps = field.from(*start);
                (steps != UNREACHABLE).then(|| since + u64::from(steps))
            };
            reached.extend(from.iter().filter_map(steps).min().map(|instant| (*cell, instant)));
        }
        reached
    }
}
