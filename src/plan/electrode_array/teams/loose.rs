//! Which cells the program leaves open: after a step with interchangeable goals, or an assay that chooses places, the plan has chosen who
//! stands where.
//!
//! As long as a team stays together, its parts stand on the same cells whoever is where, and what is proven of a later step holds for
//! every plan of the task. Once some of its parts are sent elsewhere alone, that depends on the plan: then only the bounds of [`LooseParts::least`]
//! hold, and a step without a plan proves nothing of the task.

use crate::claims::electrode_array::{AssayOperation, ElectrodeArrayAction, ElectrodeArrayMove, ElectrodeArrayOrder};
use crate::device::electrode_array::ElectrodeCell;
use crate::plan::electrode_array::board::{Agent, BoardCosts, Instance};
use crate::plan::electrode_array::fast;
use crate::plan::electrode_array::stage::{self, BoardGround};
use std::collections::{BTreeMap, BTreeSet};

/// The parts whose cells the program leaves open.
#[derive(Debug, Default)]
pub struct LooseParts {
    /// Parts that stand on the cells of one list, each on another; of a part that an assay has left at one of several, it alone.
    teams: Vec<(BTreeSet<usize>, Vec<ElectrodeCell>)>,
    /// Whether cells are taken or free by what the plan chose.
    is_open: bool,
}

impl LooseParts {
    /// Whether what is proven of a step, with the cells that the parts have, holds whatever the plan of the steps before.
    pub fn is_fixed_in(&self, action: &ElectrodeArrayAction) -> bool {
        let movers = Movers::of(action);
        let keeps = |(team, _): &(BTreeSet<usize>, _)| {
            let is_whole = |new: &BTreeSet<usize>| team.is_subset(new) || team.is_disjoint(new);
            movers.alone.is_disjoint(team) && movers.teams.values().all(is_whole)
        };
        !self.is_open && self.teams.iter().all(keeps)
    }

    /// Takes note of a step.
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

    /// Lower bounds on a step that hold wherever the plan has brought the parts: each of its own ways, with no other part about. `None` if
    /// all that is proven of the step holds.
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

/// The steps of a part from a cell by the stops of a move, if it can come there.
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

/// Who moves in a step.
#[derive(Debug, Default)]
struct Movers {
    /// Those with goals or operations of their own.
    alone: BTreeSet<usize>,
    teams: BTreeMap<usize, BTreeSet<usize>>,
    /// All that the program sends to cells.
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
