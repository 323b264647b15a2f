//! Earliest arrivals against a search instant by instant.

use std::collections::BTreeSet;

use super::super::planned_instance::{PathTerms, PlannedInstance};
use super::super::reservations::Others;
use super::*;
use crate::plan::electrode_array::board::{Agent, Instance, Paths, position};
use crate::plan::search::SearchBudget;

const HORIZON: u32 = 90;

fn walk(random: &mut SplitMix64, board: &BoardGrid, moves: usize) -> Vec<CellIndex> {
    let mut at = loop {
        let cell = random.below(board.cells()) as CellIndex;
        if !board.is_blocked(cell) {
            break cell;
        }
    };
    let mut path = vec![at];
    for _ in 0..moves {
        let beside: Vec<CellIndex> = board.neighbours(at).chain([at]).collect();
        at = beside[random.below(beside.len())];
        path.push(at);
    }
    path
}

/// Three walks, which may touch, and an agent with two stops.
fn scene(random: &mut SplitMix64) -> (Instance, Paths) {
    let mut board = BoardGrid::new(7, 6);
    for _ in 0..random.below(8) {
        board.block(random.below(42) as CellIndex);
    }
    let paths: Paths = (0..2 + random.below(2)).map(|_| walk(random, &board, 24)).collect();
    let mut agents: Vec<Agent> =
        paths.iter().map(|path| Agent { start: path[0], stops: vec![path[path.len() - 1]] }).collect();
    let one = walk(random, &board, 40);
    agents.push(Agent { start: one[0], stops: vec![one[20], one[40]] });
    (Instance { board, separation: 1 + random.below(2) as u32, agents, merges: vec![] }, paths)
}

/// The earliest instant from which the last agent is on its goal for ever.
fn by_instants(instance: &Instance, paths: &Paths) -> Option<u32> {
    let us = paths.len();
    let free = |cell: CellIndex, at: u32| {
        (0..us).all(|other| {
            (at.saturating_sub(1)..=at + 1)
                .all(|when| !instance.too_near(us, cell, other, position(&paths[other], when as usize)))
        })
    };
    let agent = &instance.agents[us];
    let pass = |cell: CellIndex, behind: bool| behind || cell == agent.stops[0];
    let mut now = BTreeSet::new();
    if free(agent.start, 0) {
        now.insert((agent.start, pass(agent.start, false)));
    }
    for at in 0..HORIZON {
        if now.contains(&(agent.goal(), true)) && (at..HORIZON).all(|later| free(agent.goal(), later)) {
            return Some(at);
        }
        let mut next = BTreeSet::new();
        for (cell, behind) in now {
            for to in instance.board.neighbours(cell).chain([cell]).filter(|to| free(*to, at + 1)) {
                next.insert((to, pass(to, behind)));
            }
        }
        now = next;
    }
    None
}

#[test]
fn the_earliest_arrival_is_found() {
    let mut random = SplitMix64::new(21);
    let mut found = 0;
    for round in 0..400 {
        let (instance, paths) = scene(&mut random);
        let mut meter = Meter::new(SearchBudget::of(u64::MAX));
        let mut planned = PlannedInstance::new(&instance, round, &mut meter).expect("walks reach");
        for (agent, path) in paths.iter().enumerate() {
            planned.table.add(agent, path);
        }
        let truth = by_instants(&instance, &paths);
        let terms = |limit| PathTerms { others: Others::Hard, weight: 0, haste: 0, limit, delay: 0, detour: None };
        let path = planned.plan(paths.len(), terms(HORIZON), &mut meter);
        assert_eq!(path.as_ref().map(|path| path.len() as u32 - 1), truth, "{instance:?} {paths:?}");
        if let Some(arrival) = truth.filter(|arrival| *arrival > 0) {
            found += 1;
            assert_eq!(planned.plan(paths.len(), terms(arrival - 1), &mut meter), None);
            assert_eq!(planned.plan(paths.len(), terms(arrival), &mut meter).map(|path| path.len() as u32 - 1), truth);
        }
        assert!(path.is_none_or(|path| planned.conflicts(paths.len(), &path).is_empty()));
    }
    assert!(found > 100, "{found}");
}

#[test]
fn soft_paths_touch_no_one_where_hard_ones_exist() {
    let mut random = SplitMix64::new(22);
    for round in 0..200 {
        let (instance, paths) = scene(&mut random);
        let mut meter = Meter::new(SearchBudget::of(u64::MAX));
        let mut planned = PlannedInstance::new(&instance, round, &mut meter).expect("walks reach");
        for (agent, path) in paths.iter().enumerate() {
            planned.table.add(agent, path);
        }
        let terms =
            PathTerms { others: Others::Soft, weight: 1_000, haste: 0, limit: u32::MAX, delay: 0, detour: None };
        let path = planned.plan(paths.len(), terms, &mut meter).expect("soft paths always exist");
        let touched = !planned.conflicts(paths.len(), &path).is_empty();
        assert_eq!(touched, by_instants(&instance, &paths).is_none());
    }
}

#[test]
fn a_search_ends_with_its_meter() {
    let board = BoardGrid::new(20, 20);
    let instance =
        Instance { board, separation: 4, agents: vec![Agent { start: 0, stops: vec![399] }], merges: vec![] };
    let mut meter = Meter::new(SearchBudget::of(5));
    let mut planned = PlannedInstance::new(&instance, 0, &mut meter).expect("open");
    let terms = PathTerms { others: Others::Hard, weight: 0, haste: 0, limit: u32::MAX, delay: 0, detour: None };
    assert_eq!(planned.plan(0, terms, &mut meter), None);
    assert_eq!(meter.spent(), 5);
}
