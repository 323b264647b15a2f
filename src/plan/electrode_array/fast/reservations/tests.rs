//! Segments against the separation rule, position by position.

use super::*;
use crate::plan::electrode_array::board::{Agent, BoardGrid, position};
use crate::random::SplitMix64;

const INSTANTS: u32 = 40;

fn walk(random: &mut SplitMix64, board: &BoardGrid, moves: usize) -> Vec<CellIndex> {
    let mut path = vec![random.below(board.cells()) as CellIndex];
    for _ in 0..moves {
        let at = path[path.len() - 1];
        let beside: Vec<CellIndex> = board.neighbours(at).chain([at, at]).collect();
        path.push(beside[random.below(beside.len())]);
    }
    path
}

/// Walks of three agents; the last two merge on the end of theirs.
fn three(random: &mut SplitMix64, separation: u32) -> (Instance, Vec<Vec<CellIndex>>) {
    let board = BoardGrid::new(6 + random.below(9) as u32, 1 + random.below(12) as u32);
    let moves = random.below(20);
    let mut paths: Vec<_> = (0..3).map(|_| walk(random, &board, moves)).collect();
    let goal = paths[1][moves];
    let first = paths[1].iter().position(|cell| *cell == goal).expect("it ends there");
    paths[1].truncate(first + 1);
    let mut agents: Vec<Agent> = paths.iter().map(|path| Agent { start: path[0], stops: vec![goal] }).collect();
    agents[0].stops = vec![paths[0][moves]];
    (Instance { board, separation, agents, merges: vec![[1, 2]] }, paths)
}

/// Number of these agents that are too near to a third on a cell at an instant.
fn near(
    instance: &Instance,
    paths: &[Vec<CellIndex>],
    others: &[usize],
    agent: usize,
    cell: CellIndex,
    instant: u32,
) -> u32 {
    let touches = |other: &&usize| {
        (instant.saturating_sub(1)..=instant + 1)
            .any(|at| instance.too_near(agent, cell, **other, position(&paths[**other], at as usize)))
    };
    others.iter().filter(touches).count() as u32
}

#[test]
fn segments_are_what_the_rule_says() {
    let mut random = SplitMix64::new(9);
    for round in 0..150 {
        let (instance, paths) = three(&mut random, 1 + round % 5);
        let mut table = Reservations::new(&instance);
        table.add(2, &[0]);
        table.add(0, &paths[0]);
        table.remove(2, &[0]);
        table.add(1, &paths[1]);
        for others in [Others::Hard, Others::Soft] {
            let query = IntervalQuery { goal: instance.agents[2].goal(), partners: &[1], others, weights: &[] };
            for cell in 0..instance.board.cells() as CellIndex {
                let mut segments = Vec::new();
                table.segments(cell, &query, &mut segments);
                for instant in 0..INSTANTS {
                    let here = segments.iter().find(|one| (one.from..one.to).contains(&instant));
                    let touched = near(&instance, &paths, &[0, 1], 2, cell, instant);
                    match others {
                        Others::Hard => assert_eq!(here.is_none(), touched > 0, "{instance:?} {cell} {instant}"),
                        Others::Soft => assert_eq!(here.map_or(0, |one| one.cost.min(1)), touched.min(1)),
                    }
                }
            }
        }
    }
}

#[test]
fn conflicts_are_those_of_the_rule() {
    let mut random = SplitMix64::new(10);
    for round in 0..200 {
        let (instance, paths) = three(&mut random, 1 + round % 4);
        let mut table = Reservations::new(&instance);
        table.add(0, &paths[0]);
        table.add(1, &paths[1]);
        let query =
            IntervalQuery { goal: instance.agents[2].goal(), partners: &[1], others: Others::Hard, weights: &[] };
        let mut found = Vec::new();
        table.conflicts(&paths[2], &query, |other| found.push(other));
        for other in [0, 1] {
            let touches = |at: u32| near(&instance, &paths, &[other], 2, position(&paths[2], at as usize), at) > 0;
            assert_eq!(found.contains(&other), (0..INSTANTS).any(touches));
        }
    }
}

#[test]
fn a_removed_path_leaves_nothing() {
    let mut random = SplitMix64::new(11);
    let (instance, paths) = three(&mut random, 3);
    let mut table = Reservations::new(&instance);
    for (agent, path) in paths.iter().enumerate() {
        table.add(agent, path);
        table.add_hazard(agent, path[0], 5);
    }
    for (agent, path) in paths.iter().enumerate() {
        table.remove(agent, path);
        table.remove_hazard(agent, path[0]);
    }
    assert!(table.spans.iter().all(Vec::is_empty));
    assert_eq!(table.hazards, 0);
}

#[test]
fn a_hazard_is_soft_among_hard_paths() {
    let board = BoardGrid::new(9, 1);
    let agents = vec![Agent { start: 0, stops: vec![0] }; 3];
    let instance = Instance { board, separation: 2, agents, merges: vec![] };
    let mut table = Reservations::new(&instance);
    table.add(0, &[0]);
    table.add_hazard(1, 4, 7);
    let query = IntervalQuery { goal: 8, partners: &[], others: Others::Hard, weights: &[] };
    let mut segments = Vec::new();
    table.segments(3, &query, &mut segments);
    assert_eq!(segments, [SafeInterval { from: 0, to: 7, cost: 1 }, SafeInterval { from: 7, to: NEVER, cost: 0 }]);
    segments.clear();
    table.segments(1, &query, &mut segments);
    assert_eq!(segments, []);
}

#[test]
fn a_hidden_path_does_not_count_until_it_is_decided() {
    let mut random = SplitMix64::new(12);
    let (instance, paths) = three(&mut random, 2);
    let fresh = |path: &[CellIndex]| {
        let mut table = Reservations::new(&instance);
        if !path.is_empty() {
            table.add(0, path);
        }
        listing(&mut table, &instance)
    };
    let mut table = Reservations::new(&instance);
    table.add(0, &paths[0]);
    table.hide(0);
    assert_eq!(listing(&mut table, &instance), fresh(&[]));
    table.add_instead(0, &paths[2]);
    assert_eq!(listing(&mut table, &instance), fresh(&paths[2]));
    table.reject(0, Some(&paths[2]));
    assert_eq!(listing(&mut table, &instance), fresh(&paths[0]));
    table.hide(0);
    table.add_instead(0, &paths[2]);
    table.accept(0, &paths[0]);
    assert_eq!(listing(&mut table, &instance), fresh(&paths[2]));
    table.remove(0, &paths[2]);
    assert!(table.spans.iter().all(Vec::is_empty));
}

fn listing(table: &mut Reservations, instance: &Instance) -> Vec<Vec<SafeInterval>> {
    let query = IntervalQuery { goal: 0, partners: &[], others: Others::Hard, weights: &[] };
    let list = |cell| {
        let mut segments = Vec::new();
        table.segments(cell, &query, &mut segments);
        segments
    };
    (0..instance.board.cells() as CellIndex).map(list).collect()
}
