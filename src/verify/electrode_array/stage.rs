//! Goals of the parts in one step of a task, and their progress.

use super::parts::PartsOnBoard;
use super::pull::PartPull;
use crate::claims::electrode_array::{ElectrodeArrayMove, ElectrodeArrayStop};
use crate::device::electrode_array::ElectrodeCell;
use std::collections::{BTreeMap, BTreeSet};

/// The parts with a goal, and the pairs of parts that are about to merge.
#[derive(Debug, Default)]
pub(super) struct StepGoals {
    with_goal: BTreeSet<usize>,
    /// For each part that is to merge, the other part and the goal; no entry once one of them is gone.
    pub pairs: BTreeMap<usize, (usize, ElectrodeCell)>,
}

impl StepGoals {
    /// Parts with goals, and no pairs.
    pub fn new(with_goal: impl Iterator<Item = usize>) -> StepGoals {
        StepGoals { with_goal: with_goal.collect(), pairs: BTreeMap::new() }
    }

    /// Whether a part has a goal in this step.
    pub fn has_goal(&self, part: usize) -> bool {
        self.with_goal.contains(&part)
    }

    /// The part that a part merges with, and the goal.
    pub fn partner(&self, part: usize) -> Option<(usize, ElectrodeCell)> {
        self.pairs.get(&part).copied()
    }
}

/// A step of parts in progress; by default one without goals.
#[derive(Debug, Default)]
pub(super) struct StepProgress<'o> {
    moves: &'o [ElectrodeArrayMove],
    /// Index into `moves` for each part that has a goal.
    of: BTreeMap<usize, usize>,
    pub goals: StepGoals,
    /// Number of stops reached, by move.
    turns: Vec<usize>,
    /// Original cells of the parts without a goal that have moved.
    pub homes: BTreeMap<usize, ElectrodeCell>,
    /// The beat, from 1, of each part's last move.
    arrivals: BTreeMap<usize, u64>,
}

impl<'o> StepProgress<'o> {
    /// The step before its first beat.
    pub fn new(moves: &'o [ElectrodeArrayMove], cells: &PartsOnBoard) -> StepProgress<'o> {
        let mut stage = StepProgress { moves, turns: vec![0; moves.len()], ..StepProgress::default() };
        for (index, action) in moves.iter().enumerate() {
            let both = std::iter::once(action.part).chain(action.with);
            stage.of.extend(both.clone().map(|part| (part, index)));
            stage.goals.with_goal.extend(both);
            if let Some(with) = action.with.filter(|with| cells[*with].is_some() && cells[action.part].is_some()) {
                let goal = action.goal().cell;
                stage.goals.pairs.extend([(action.part, (with, goal)), (with, (action.part, goal))]);
            }
            if let Some(cell) = cells[action.part].filter(|_| action.team.is_none()) {
                stage.pass(index, cell);
            }
        }
        stage
    }

    /// Notes that a part has moved.
    pub fn arrive(&mut self, part: usize, pull: &PartPull, beat: u64) {
        self.arrivals.insert(part, beat);
        match self.of.get(&part).copied() {
            None => drop(self.homes.entry(part).or_insert(pull.from)),
            Some(index) if self.moves[index].part == part && self.moves[index].team.is_none() => {
                self.pass(index, pull.to)
            }
            Some(_) => (),
        }
    }

    /// Counts the next stops in turn as reached if they are at this cell.
    fn pass(&mut self, index: usize, cell: ElectrodeCell) {
        let left = &self.moves[index].stops[self.turns[index]..];
        self.turns[index] += left.iter().take_while(|stop| stop.cell == cell).count();
    }

    /// Sum over the parts of the beats until their last arrival.
    pub fn cost(&self) -> u64 {
        self.arrivals.values().fold(0, |sum, beats| sum.saturating_add(*beats))
    }

    /// Parts that missed a stop: each with its first missed stop, and whether that is its goal.
    pub fn missed(&self, cells: &PartsOnBoard) -> Vec<(usize, &'o ElectrodeArrayStop, bool)> {
        let of_move = |(index, action): (usize, &'o ElectrodeArrayMove)| {
            let (left, goal) = (&action.stops[self.turns[index]..], action.goal());
            let first = match left {
                [first, _, ..] => Some((action.part, first, false)),
                [_] | [] => (cells[action.part] != Some(goal.cell)).then_some((action.part, goal, true)),
            };
            let second = action.with.filter(|with| cells[*with] != Some(goal.cell)).map(|with| (with, goal, true));
            first.into_iter().chain(second)
        };
        self.moves.iter().enumerate().filter(|(_, action)| action.team.is_none()).flat_map(of_move).collect()
    }

    /// The goals of teams at which no part of the team is, each with a part of the team.
    pub fn empty(&self, cells: &PartsOnBoard) -> Vec<(usize, &'o ElectrodeArrayStop)> {
        let of_teams = self.moves.iter().filter_map(|action| Some((action.team?, action)));
        let is_taken = |(team, action): &(usize, &ElectrodeArrayMove)| {
            let others = self.moves.iter().filter(|other| other.team == Some(*team));
            others.into_iter().any(|other| cells[other.part] == Some(action.goal().cell))
        };
        of_teams.filter(|asked| !is_taken(asked)).map(|(_, action)| (action.part, action.goal())).collect()
    }

    /// The parts that no longer exist after the step, because they have merged.
    pub fn gone(&self) -> impl Iterator<Item = usize> + use<'o> {
        self.moves.iter().filter_map(|action| action.with)
    }
}
