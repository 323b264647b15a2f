//! Tracks which cells the program leaves open: after a step with interchangeable goals, or an assay that chooses
//! places, it is the plan that has chosen where each part stands.
//!
//! As long as a team stays together, its parts stand on the same set of cells in every plan, and proofs about a later
//! step hold for every plan of the task. Once some of its parts are sent elsewhere alone, later steps depend on the
//! plan: then only the bounds of [`LooseParts::least`] hold, and a step without a plan proves nothing about the task.

use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayAction, ElectrodeArrayMove, ElectrodeArrayOrder};
use crate::device::electrode_array::ElectrodeCell;
use crate::plan::electrode_array::board::{Agent, BoardCosts, Instance};
use crate::plan::electrode_array::fast;
use crate::plan::electrode_array::stage::{self, BoardGround};
use std::collections::{BTreeMap, BTreeSet};

/// The parts whose cells the program leaves open.
#[derive(Debug, Default)]
pub struct LooseParts {
    /// Groups of parts that stand on the cells of a list in an unknown order. A part that an assay has left at one of
    /// several places is a group of its own.
    teams: Vec<(BTreeSet<usize>, Vec<ElectrodeCell>)>,
    /// Whether it depends on the plan which cells are occupied.
    is_open: bool,
}

impl LooseParts {
    /// Whether proofs about a step, based on the current cells of the parts, hold whatever the plan of the steps
    /// before.
    pub fn is_fixed_in(&self, action: &ElectrodeArrayAction) -> bool {
        let movers = Movers::of(action);
        let keeps = |(team, _): &(BTreeSet<usize>, _)| {
            let is_whole = |new: &BTreeSet<usize>| team.is_subset(new) || team.is_disjoint(new);
            movers.alone.is_disjoint(team) && movers.teams.values().all(is_whole)
        };
        !self.is_open && self.teams.iter().all(keeps)
    }

    /// Updates the groups after a step.
    pub fn follow(&mut self, action: &ElectrodeArrayAction) {
        let is_fixed = self.is_fixed_in(action);
        let movers = Movers::of(action);
        let moved = &movers.moved;
        let all = self.teams.iter().all(|(team, _)| team.is_subset(moved) || team.is_disjoint(moved));
        self.is_open |= !is_fixed && !all;
        self.teams.iter_mut().for_each(|(team, _)| team.retain(|part| !moved.contains(part)));
        self.teams.retain(|(team, _)| !team.is_empty());
        if let ElectrodeArrayAction::Assay(operations) = action {
            for (part, operation) in AssayOperation::left_open(operations) {
                let cells = operation.among.iter().map(|place| place.stop.cell).collect();
                self.teams.push((BTreeSet::from([part]), cells));
                self.is_open = true;
            }
        }
        if let ElectrodeArrayAction::Move(moves) = action {
            for (number, team) in movers.teams {
                let own = moves.iter().filter(|one| one.team == Some(number));
                self.teams.push((team, own.map(|one| one.goal().cell).collect()));
            }
        }
    }

    /// Lower bounds on a step that hold wherever the plan has brought the parts: those of each part alone on the board.
    /// `None` if all proofs about the step hold.
    pub fn least(
        &self,
        order: &ElectrodeArrayOrder,
        ground: &BoardGround,
        cells: &[Option<ElectrodeCell>],
        action: &ElectrodeArrayAction,
    ) -> Option<BoardCosts> {
        if self.is_fixed_in(action) {
            return None;
        }
        let ElectrodeArrayAction::Move(moves) = action else { return Some(BoardCosts::default()) };
        let mut bounds = BoardCosts::default();
        for one in moves.iter().filter(|one| one.team.is_none()) {
            for part in std::iter::once(one.part).chain(one.with) {
                let own = self.teams.iter().find(|(team, _)| team.contains(&part));
                let from: Vec<ElectrodeCell> = match own {
                    Some((_, cells)) => cells.clone(),
                    None => cells[part].into_iter().collect(),
                };
                let steps = from.iter().filter_map(|start| alone(order, ground, *start, one));
                let least = steps.min().unwrap_or(0);
                bounds.makespan = bounds.makespan.max(least);
                bounds.sum_of_costs += least;
            }
        }
        Some(bounds)
    }
}

/// Steps of a part alone, from a cell through the stops of a move; `None` if it cannot reach them.
fn alone(
    order: &ElectrodeArrayOrder,
    ground: &BoardGround,
    start: ElectrodeCell,
    one: &ElectrodeArrayMove,
) -> Option<u64> {
    let stops = one.stops.iter().map(|stop| stage::flat(order, stop.cell)).collect();
    let agents = vec![Agent { start: stage::flat(order, start), stops }];
    let separation = order.facts.separation.apart();
    let instance = Instance { board: ground.board().clone(), separation, agents, merges: Vec::new() };
    fast::bounds(&instance).ok().map(|bounds| bounds.makespan)
}

/// The parts that move in a step.
#[derive(Debug, Default)]
struct Movers {
    /// Parts with goals or operations of their own.
    alone: BTreeSet<usize>,
    teams: BTreeMap<usize, BTreeSet<usize>>,
    /// All parts that the program sends to cells.
    moved: BTreeSet<usize>,
}

impl Movers {
    fn of(action: &ElectrodeArrayAction) -> Movers {
        let mut movers = Movers::default();
        match action {
            ElectrodeArrayAction::Wait(_) => {}
            ElectrodeArrayAction::Assay(operations) => {
                movers.alone.extend(operations.iter().flat_map(|operation| operation.all_parts()));
                let sent = operations.iter().filter(|operation| !operation.stops.is_empty());
                movers.moved.extend(sent.flat_map(|operation| operation.all_parts()));
            }
            ElectrodeArrayAction::Move(moves) => {
                for one in moves {
                    match one.team {
                        Some(team) => drop(movers.teams.entry(team).or_default().insert(one.part)),
                        None => movers.alone.extend(one.parts()),
                    }
                    movers.moved.extend(one.parts());
                }
            }
        }
        movers
    }
}
