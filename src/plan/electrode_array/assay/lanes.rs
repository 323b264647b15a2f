//! Lanes: the cells that are not needed for the stays of agents.
//!
//! A droplet that passes a mixer on its way, or waits beside it, may keep it from being used for as long as a whole
//! operation lasts, while a way around takes a few steps. So list scheduling also tries courses that keep off the
//! places of all other agents. Outlets are no such places: on most boards the lanes pass them, and droplets leave them
//! soon.

use super::route::RouteQuery;
use super::{AssayProblem, Errand};
use crate::plan::electrode_array::board::CellIndex;
use fixedbitset::FixedBitSet;
use std::collections::BTreeSet;

/// The cells that agents keep off where they can.
pub(super) struct Lanes<'a> {
    problem: &'a AssayProblem<'a>,
    /// Cells near a place where an agent stays, is mixed, splits or meets another one.
    reserved: FixedBitSet,
    /// The reserved cells without those near the places of one agent.
    closed: FixedBitSet,
    /// For the search of a way: cells seen, and cells to expand.
    seen: FixedBitSet,
    open: Vec<CellIndex>,
}

impl<'a> Lanes<'a> {
    pub fn new(problem: &'a AssayProblem<'a>) -> Lanes<'a> {
        let instance = problem.instance;
        let mut places: BTreeSet<CellIndex> = BTreeSet::new();
        for (agent, errands) in problem.errands.iter().enumerate() {
            let stays = |errand: &&Errand| errand.stay > 0 || errand.meets.is_some() || errand.splits.is_some();
            places.extend(
                errands.iter().skip(usize::from(problem.enters[agent])).filter(stays).map(|errand| errand.stop),
            );
            let loops = errands.iter().filter_map(|errand| errand.mixes);
            places.extend(loops.flat_map(|around| problem.loops[around].iter().copied()));
        }
        let mut reserved = FixedBitSet::with_capacity(instance.board.cells());
        for near in places.into_iter().flat_map(|place| instance.board.around(place, instance.separation)) {
            reserved.insert(near as usize);
        }
        let (closed, seen) = (reserved.clone(), FixedBitSet::with_capacity(instance.board.cells()));
        Lanes { problem, reserved, closed, seen, open: Vec::new() }
    }

    /// The cells closed to the agent of a query; `None` if it cannot get to its stops without them.
    pub fn closed_to(&mut self, query: &RouteQuery) -> Option<&FixedBitSet> {
        let (problem, board) = (self.problem, &self.problem.instance.board);
        let own = &problem.errands[query.agent][..query.first + query.waits.len()];
        let (before, due) = own.split_at(query.first);
        self.closed.clone_from(&self.reserved);
        let around = |errand: &Errand| errand.mixes.map_or([].as_slice(), |around| &problem.loops[around]);
        // It leaves the place of its last errand by the cells near that place.
        let ends = before.last().into_iter().chain(due);
        let places = ends.flat_map(|errand| around(errand).iter().copied().chain([errand.stop])).chain([query.start]);
        for near in places.flat_map(|place| board.around(place, problem.instance.separation)) {
            self.closed.set(near as usize, false);
        }
        self.seen.clear();
        self.seen.insert(query.start as usize);
        self.open.clear();
        self.open.push(query.start);
        while let Some(cell) = self.open.pop() {
            for next in board.neighbours(cell) {
                if !self.closed.contains(next as usize) && !self.seen.put(next as usize) {
                    self.open.push(next);
                }
            }
        }
        due.iter().all(|errand| self.seen.contains(errand.stop as usize)).then_some(&self.closed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::electrode_array::board::{Agent, BoardGrid, Instance};

    /// The cells closed to agent 1, which goes along the first row of a board with five columns, while agent 0 stays in
    /// its middle column.
    fn closed(rows: u32, stays_in: u32) -> Option<Vec<CellIndex>> {
        let board = BoardGrid::new(5, rows);
        let (place, way) = (board.cell(2, stays_in), [board.cell(0, 0), board.cell(4, 0)]);
        let errand = |stop: CellIndex, stay| Errand { stop, stay, meets: None, mixes: None, splits: None };
        let errands = vec![vec![errand(place, 9)], vec![errand(way[1], 1)]];
        let agents = vec![Agent { start: place, stops: vec![place] }, Agent { start: way[0], stops: vec![way[1]] }];
        let instance = Instance { board, separation: 2, agents, merges: Vec::new() };
        let problem = AssayProblem {
            instance: &instance,
            enters: vec![false; 2],
            parents: vec![None; 2],
            loops: Vec::new(),
            errands,
            operations: Vec::new(),
            afters: vec![vec![Vec::new()]; 2],
            lags: Vec::new(),
            releases: Vec::new(),
            relaxed_schedules: Vec::new(),
            is_gone: vec![false; 2],
            traces: None,
        };
        let query = RouteQuery {
            agent: 1,
            start: way[0],
            since: 0,
            first: 0,
            waits: &[None],
            begins: &[0],
            held: &[0],
            past: &[],
            is_gone: false,
            enters: false,
            keeps_lanes: true,
            limit: u32::MAX,
        };
        let mut lanes = Lanes::new(&problem);
        Some(lanes.closed_to(&query)?.ones().map(|cell| cell as CellIndex).collect())
    }

    #[test]
    fn the_places_of_others_are_closed_but_not_the_own_ones() {
        // The cells near (2, 2), but neither those near the start nor those near the own stop.
        let near = [(2, 1), (1, 2), (2, 2), (3, 2), (1, 3), (2, 3), (3, 3)];
        assert_eq!(closed(4, 2), Some(near.map(|(column, row)| row * 5 + column).to_vec()));
    }

    #[test]
    fn there_are_no_lanes_where_the_places_of_others_bar_the_way() {
        assert_eq!(closed(3, 1), None);
    }
}
