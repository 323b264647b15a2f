//! Tiny boards on which brute force gives the truth: optima, proofs that there is no plan, intermediate stops, and
//! parts that merge.

use crate::brute::least;
use crate::check::judged;
use crate::scenes::Random;
use crate::{OBJECTIVES, confirm};
use tweeze::plan::electrode_array::board::{
    Agent, BoardAnswer, BoardCosts, BoardGrid, BoardObjective, CellIndex, Instance,
};
use tweeze::plan::electrode_array::solve;
use tweeze::plan::search::SearchBudget;

/// Large enough to decide each of these instances.
const PLENTY: SearchBudget = SearchBudget::of(600_000);

/// Columns and rows, separation, parts, percentage of blocked cells, and special feature.
type Tiny = ((u32, u32), u32, usize, u32, Special);

#[derive(Clone, Copy, PartialEq)]
enum Special {
    Nothing,
    /// The first part has an intermediate stop.
    Via,
    /// The first two parts merge.
    Merge,
}

fn instance(
    width: u32,
    height: u32,
    separation: u32,
    count: usize,
    blocked: u32,
    special: Special,
    chance: &mut Random,
) -> Option<Instance> {
    let mut board = BoardGrid::new(width, height);
    for cell in 0..width * height {
        if chance.below(100) < blocked {
            board.block(cell);
        }
    }
    let starts = scatter(&board, separation, count, chance)?;
    let mut goals = scatter(&board, separation, count, chance)?;
    let mut merges = vec![];
    if special == Special::Merge {
        goals[1] = goals[0];
        merges.push([0, 1]);
    }
    let agent = |(start, goal): (CellIndex, CellIndex)| Agent { start, stops: vec![goal] };
    let mut agents: Vec<Agent> = starts.into_iter().zip(goals).map(agent).collect();
    if special == Special::Via {
        let via = scatter(&board, separation, 1, chance)?[0];
        agents[0].stops.insert(0, via);
    }
    Some(Instance { board, separation, agents, merges })
}

fn scatter(board: &BoardGrid, separation: u32, count: usize, chance: &mut Random) -> Option<Vec<CellIndex>> {
    let mut cells: Vec<CellIndex> = Vec::new();
    for _ in 0..50 {
        let cell = chance.below(board.cells() as u32);
        if cells.len() < count
            && !board.is_blocked(cell)
            && cells.iter().all(|other| board.apart(*other, cell) >= separation)
        {
            cells.push(cell);
        }
    }
    (cells.len() == count).then_some(cells)
}

/// Compares an instance with brute force; returns whether there was a plan.
fn compare(instance: &Instance) -> bool {
    let all: Vec<usize> = (0..instance.agents.len()).collect();
    let truth = OBJECTIVES.map(|objective| least(instance, &all, objective));
    for objective in OBJECTIVES {
        let answer = solve(instance, objective, None, PLENTY);
        let found = judged(instance, &answer);
        if let BoardAnswer::Impossible(why) = &answer {
            confirm(instance, why);
        }
        let proven = |costs: BoardCosts| match objective {
            BoardObjective::Makespan => costs.makespan,
            BoardObjective::SumOfCosts => costs.sum_of_costs,
        };
        let least = truth[usize::from(objective == BoardObjective::SumOfCosts)];
        assert!(!matches!(answer, BoardAnswer::GaveUp(_)), "{objective:?} of {instance:?}");
        assert_eq!(found.map(|(costs, _)| proven(costs)), least, "cost, {objective:?} of {instance:?}");
        assert_eq!(found.map(|(_, bounds)| proven(bounds)), least, "bound, {objective:?} of {instance:?}");
        if let Some((_, bounds)) = found {
            let [makespan, sum] = truth.map(|least| least.unwrap_or(0));
            assert!(
                bounds.makespan <= makespan && bounds.sum_of_costs <= sum,
                "{bounds:?} for {truth:?}: {instance:?}"
            );
        }
    }
    truth[0].is_some()
}

/// Compares instances of a kind with brute force; at least `with` must have a plan and `without` none.
fn agree(tiny: &[Tiny], rounds: u32, seed: u64, [with, without]: [usize; 2]) {
    let mut chance = Random::new(seed);
    let mut seen = [0, 0];
    for _ in 0..rounds {
        for ((width, height), separation, count, blocked, special) in tiny.iter().copied() {
            if let Some(instance) = instance(width, height, separation, count, blocked, special, &mut chance) {
                seen[usize::from(!compare(&instance))] += 1;
            }
        }
    }
    assert!(seen[0] >= with && seen[1] >= without, "{seen:?}");
}

#[test]
fn optima_and_impossibility_of_two_parts() {
    let tiny = [
        ((4, 4), 1, 2, 25, Special::Nothing),
        ((6, 6), 2, 2, 25, Special::Nothing),
        ((6, 5), 1, 2, 45, Special::Nothing),
        ((6, 3), 2, 2, 0, Special::Nothing),
    ];
    agree(&tiny, 30, 1, [40, 10]);
}

#[test]
fn optima_and_impossibility_of_three_parts() {
    let tiny = [
        ((3, 3), 1, 3, 15, Special::Nothing),
        ((4, 4), 1, 3, 30, Special::Nothing),
        ((5, 5), 2, 3, 12, Special::Nothing),
    ];
    agree(&tiny, 10, 2, [10, 4]);
}

#[test]
fn optima_with_stops_on_the_way_and_with_parts_that_merge() {
    let tiny = [
        ((4, 4), 1, 2, 20, Special::Via),
        ((5, 5), 2, 2, 15, Special::Via),
        ((5, 5), 2, 2, 20, Special::Merge),
        ((5, 4), 2, 3, 5, Special::Merge),
    ];
    agree(&tiny, 15, 3, [25, 3]);
}
