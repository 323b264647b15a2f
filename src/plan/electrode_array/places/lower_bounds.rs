//! Lower bounds on an assay that hold for any choice of places.
//!
//! Each part alone takes at least its travel and its stays at the best places ([`super::critical_path`]). Where several
//! operations stay at the same places, only one at a time can use a place ([`super::place_queue`]). The same holds for
//! droplets from one reservoir, and for mixing loops.

use super::critical_path::{BoardWays, ReachedCells, TimedOperation};
use super::place_queue::{DropletSource, PlaceQueue, ServedOperation};
use crate::claims::electrode_array::AssayOperation;
use crate::device::electrode_array::ElectrodeCell;
use crate::plan::electrode_array::assay::{LoopRoom, families, steps_between};
use crate::plan::electrode_array::board::{BoardCosts, BoardGrid, CellIndex};
use crate::plan::electrode_array::errands::AssaySite;
use crate::plan::electrode_array::stage;
use std::collections::{BTreeMap, BTreeSet};

/// Lower bounds on the plans of all arrangements.
pub(super) fn bounds(operations: &[AssayOperation], timed: &[TimedOperation], ways: &mut BoardWays) -> BoardCosts {
    let alone = timed.iter().map(|one| one.head() + one.stay).max().unwrap_or(0);
    let queued = queues(operations, timed, ways).values().map(PlaceQueue::end).max().unwrap_or(0);
    BoardCosts { makespan: alone.max(queued), sum_of_costs: sum_of_costs(operations, timed, ways) }
}

/// Least steps of all parts from their starts to the places of their last stops.
fn sum_of_costs(operations: &[AssayOperation], timed: &[TimedOperation], ways: &mut BoardWays) -> u64 {
    let flat = |cell| stage::flat(ways.site.order, cell);
    let mut starts: Vec<Option<CellIndex>> = ways.site.cells.iter().map(|cell| cell.map(flat)).collect();
    let mut lasts: BTreeMap<usize, Vec<CellIndex>> = BTreeMap::new();
    for (operation, timed) in operations.iter().zip(timed) {
        if let Some(stop) = operation.stops.first().filter(|_| operation.comes) {
            starts[operation.part] = Some(flat(stop.cell));
        }
        if !operation.stops.is_empty() {
            lasts.insert(operation.part, timed.cells().collect());
        }
    }
    let away = |(part, last): (&usize, &Vec<CellIndex>)| {
        ways.reach(&[(starts[*part]?, 0)], last).iter().map(|(_, steps)| *steps).min()
    };
    lasts.iter().filter_map(away).sum()
}

/// Resource that an operation needs alone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum TurnKind {
    /// The cell where it stays.
    Stay,
    /// The mixing loop from that cell on.
    Loop,
    /// The outlet where it enters.
    Outlet,
}

/// The operations by the resources that they need alone.
fn queues(
    operations: &[AssayOperation],
    timed: &[TimedOperation],
    ways: &mut BoardWays,
) -> BTreeMap<(TurnKind, Vec<CellIndex>), PlaceQueue> {
    let (room, changes) = (MixerRoom::of(ways.site), Changes::of(ways.site, operations, timed));
    // Droplets that merge or split may follow each other without a changeover.
    let joined = operations.iter().flat_map(|one| one.all_parts().map(|other| (one.part, other)));
    let (families, sources) = (families(ways.site.cells.len(), joined), sources(operations, timed, ways));
    let mut blocks: Vec<usize> = Vec::with_capacity(timed.len());
    let mut queues: BTreeMap<(TurnKind, Vec<CellIndex>), PlaceQueue> = BTreeMap::new();
    for (nth, (operation, one)) in operations.iter().zip(timed).enumerate() {
        let before = one.before.first().filter(|before| one.stops.is_empty() && before.at.is_none());
        blocks.push(before.and_then(|before| before.operation).map_or(nth, |before| blocks[before]));
        if one.stay == 0 || one.places.is_empty() {
            continue;
        }
        let mut cells: Vec<CellIndex> = one.cells().collect();
        cells.sort_unstable();
        for kind in turns(operation, one.stay, room.as_ref()) {
            // Each droplet needs the outlet alone, whatever it merges with later.
            let family = if kind == TurnKind::Outlet { operation.part } else { families[operation.part] };
            let empty = || PlaceQueue::new(cells.len() as u64, changes.between(&cells), changes.turns.clone());
            queues.entry((kind, cells.clone())).or_insert_with(empty).served.push(ServedOperation {
                head: one.head(),
                stay: one.stay,
                tail: one.tail(),
                family,
                block: blocks[nth],
                source: sources[nth],
            });
        }
    }
    queues
}

/// The resources that an operation needs alone for its stay.
fn turns(operation: &AssayOperation, stay: u64, room: Option<&MixerRoom>) -> impl Iterator<Item = TurnKind> {
    // A stay at a corner for less than a round is possible while another droplet is at the far end.
    let fills = || room.is_some_and(|mixer| mixer.room == LoopRoom::One && stay >= mixer.cells);
    let mixes = room.filter(|_| operation.mixes).map(|mixer| mixer.room);
    let (stays, turns) = LoopRoom::taken(mixes, || !operation.mixes && fills());
    let kinds = [(stays, TurnKind::Stay), (turns, TurnKind::Loop), (operation.comes, TurnKind::Outlet)];
    kinds.into_iter().filter_map(|(is_taken, kind)| is_taken.then_some(kind))
}

/// The mixing loop of the device.
struct MixerRoom {
    room: LoopRoom,
    cells: u64,
}

impl MixerRoom {
    /// `None` where it is larger than the board.
    fn of(site: &AssaySite) -> Option<MixerRoom> {
        let facts = &site.order.facts;
        let around = facts.mixing_loop(ElectrodeCell::new(1, 1));
        let is_on_board = |cell: &ElectrodeCell| cell.column <= facts.columns && cell.row <= facts.rows;
        if around.is_empty() || !around.iter().all(is_on_board) {
            return None;
        }
        let around: Vec<CellIndex> = around.into_iter().map(|cell| stage::flat(site.order, cell)).collect();
        let room = LoopRoom::of(site.ground.board(), facts.separation.apart(), &around);
        Some(MixerRoom { room, cells: around.len() as u64 })
    }
}

/// Changeovers: how long droplets take to make room for the next one.
struct Changes<'a> {
    board: &'a BoardGrid,
    separation: u32,
    /// Cells where droplets may leave the board.
    exits: BTreeSet<CellIndex>,
    /// Cells where droplets enter the board.
    outlets: BTreeSet<CellIndex>,
    /// By outlet: least steps between the appearance of one droplet and that of the next.
    turns: BTreeMap<CellIndex, u64>,
}

impl Changes<'_> {
    fn of<'a>(site: &AssaySite<'a>, operations: &[AssayOperation], timed: &[TimedOperation]) -> Changes<'a> {
        let all = || operations.iter().zip(timed);
        let exits = all().filter(|(operation, _)| operation.leaves).flat_map(|(_, one)| one.cells()).collect();
        let coming = || all().filter(|(operation, _)| operation.comes).flat_map(|(_, one)| one.cells());
        let separation = site.order.facts.separation.apart();
        let board = site.ground.board();
        let mut changes = Changes { board, separation, exits, outlets: coming().collect(), turns: BTreeMap::new() };
        for (_, one) in all().filter(|(operation, _)| operation.comes) {
            for cell in one.cells() {
                let turn = one.stay + changes.between(&[cell]);
                changes.turns.entry(cell).and_modify(|least| *least = turn.min(*least)).or_insert(turn);
            }
        }
        changes
    }

    /// Least steps between the stays of two droplets at one of some places.
    fn between(&self, cells: &[CellIndex]) -> u64 {
        let least = |cell: &CellIndex| {
            let exit = self.exits.iter().map(|exit| self.board.manhattan(*cell, *exit)).min();
            steps_between(self.separation, exit, self.outlets.contains(cell))
        };
        cells.iter().map(least).min().unwrap_or(0)
    }
}

/// For each operation, the dispensing of its first part that comes from a reservoir, if one does.
fn sources(
    operations: &[AssayOperation],
    timed: &[TimedOperation],
    ways: &mut BoardWays,
) -> Vec<Option<DropletSource>> {
    // By part: the cells that it may reach, with the steps since it was dispensed.
    let mut since: Vec<Option<(DropletSource, ReachedCells)>> = vec![None; ways.site.cells.len()];
    let mut sources = Vec::with_capacity(operations.len());
    for (operation, one) in operations.iter().zip(timed) {
        if let (true, Some(place)) = (operation.comes, one.places.first()) {
            let source = DropletSource { outlet: place.cell, droplet: operation.part, steps: 0 };
            since[operation.part] = Some((source, vec![(place.cell, 0)]));
        }
        let source = operation.parts().find_map(|part| since[part].take());
        let arrived = source.map(|(source, from)| (source, ways.through(&from, &one.stops)));
        let first = |(_, reached): &(DropletSource, ReachedCells)| reached.iter().map(|(_, steps)| *steps).min();
        let steps = arrived.as_ref().and_then(first);
        sources.push(arrived.as_ref().zip(steps).map(|((source, _), steps)| DropletSource { steps, ..*source }));
        if let (Some(half), Some((source, _)), Some(steps)) = (operation.splits, &arrived, steps) {
            let comes = stage::flat(ways.site.order, half.cell);
            since[half.part] = Some((*source, vec![(comes, steps + one.stay)]));
        }
        since[operation.part] = arrived.map(|(source, reached)| {
            (source, reached.into_iter().map(|(cell, steps)| (cell, steps + one.stay)).collect())
        });
    }
    sources
}
