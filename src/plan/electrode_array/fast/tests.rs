//! Plans against a checker that knows neither spans nor boxes, on many small instances and some large ones.

use super::*;
use crate::plan::electrode_array::board::{Agent, BoardGrid, CellIndex, position};
use crate::random::SplitMix64;

const PLENTY: u64 = 3_000_000;

fn meter(steps: u64) -> Meter {
    Meter::new(SearchBudget::of(steps))
}

/// All violations of a plan, as text.
fn violations(instance: &Instance, paths: &Paths) -> Vec<String> {
    let mut wrong = Vec::new();
    if paths.len() != instance.agents.len() {
        return vec![format!("{} paths for {} agents", paths.len(), instance.agents.len())];
    }
    for (agent, path) in paths.iter().enumerate() {
        wrong.extend(alone(instance, agent, path));
    }
    let end = paths.iter().map(Vec::len).max().unwrap_or(0) + 1;
    for one in 0..paths.len() {
        for other in 0..one {
            for instant in 0..end {
                for (at, other_at) in [(instant, instant), (instant + 1, instant), (instant, instant + 1)] {
                    let (p, q) = (position(&paths[one], at), position(&paths[other], other_at));
                    let (c, r) = instance.board.place(p);
                    let (d, s) = instance.board.place(q);
                    let merges = instance.merges.contains(&[other, one])
                        && (p == instance.agents[one].goal() || q == instance.agents[one].goal());
                    if c.abs_diff(d).max(r.abs_diff(s)) < instance.separation && !merges {
                        wrong.push(format!("{one} at {at} and {other} at {other_at} are too near"));
                    }
                }
            }
        }
    }
    wrong
}

fn alone(instance: &Instance, agent: usize, path: &[CellIndex]) -> Vec<String> {
    let it = &instance.agents[agent];
    let mut wrong = Vec::new();
    if path.first() != Some(&it.start) || path.last() != Some(&it.goal()) {
        return vec![format!("{agent} has another start or goal")];
    }
    if path.len() > 1 && path[path.len() - 2] == it.goal() {
        wrong.push(format!("{agent} waits on its goal at the end of its path"));
    }
    for pair in path.windows(2) {
        if instance.board.manhattan(pair[0], pair[1]) > 1 {
            wrong.push(format!("{agent} jumps"));
        }
    }
    if path.iter().any(|cell| instance.board.is_blocked(*cell)) {
        wrong.push(format!("{agent} is on a blocked cell"));
    }
    let mut stops = it.stops.iter().peekable();
    for cell in path {
        while stops.next_if(|stop| *stop == cell).is_some() {}
    }
    if stops.next().is_some() {
        wrong.push(format!("{agent} leaves out a stop"));
    }
    let merges = instance.merges.iter().flatten().any(|one| *one == agent);
    if merges && path[..path.len() - 1].contains(&it.goal()) {
        wrong.push(format!("{agent} leaves the goal where it merges"));
    }
    wrong
}

/// Density and size of random instances.
#[derive(Debug, Clone, Copy)]
struct Shape {
    sides: (usize, usize),
    agents: usize,
    separation: u32,
    obstacles: usize,
    stops: usize,
}

/// Up to `count` free cells, at least `apart` from each other.
fn scattered(random: &mut SplitMix64, board: &BoardGrid, count: usize, apart: u32) -> Vec<CellIndex> {
    let mut cells: Vec<CellIndex> = Vec::new();
    for _ in 0..count * 200 {
        let cell = random.below(board.cells()) as CellIndex;
        if cells.len() < count && !board.is_blocked(cell) && cells.iter().all(|one| board.apart(*one, cell) >= apart) {
            cells.push(cell);
        }
    }
    cells
}

fn random_instance(random: &mut SplitMix64, shape: Shape) -> Instance {
    let side = |random: &mut SplitMix64| (shape.sides.0 + random.below(shape.sides.1 - shape.sides.0 + 1)) as u32;
    let mut board = BoardGrid::new(side(random), side(random));
    for _ in 0..shape.obstacles {
        let (column, row) = (random.below(board.width() as usize), random.below(board.height() as usize));
        board.block_around(column as i64, row as i64, 1 + random.below(3) as u32);
    }
    let starts = scattered(random, &board, shape.agents, shape.separation);
    let goals = scattered(random, &board, shape.agents, shape.separation);
    let mut agents = Vec::new();
    for (start, goal) in starts.into_iter().zip(goals) {
        let mut stops = scattered(random, &board, shape.stops, 0);
        stops.push(goal);
        agents.push(Agent { start, stops });
    }
    Instance { board, separation: shape.separation, agents, merges: Vec::new() }
}

/// Makes every other pair of neighbouring agents merge.
fn with_merges(mut instance: Instance) -> Instance {
    for one in (0..instance.agents.len() / 2).step_by(2) {
        let goal = instance.agents[2 * one].goal();
        instance.agents[2 * one].stops = vec![goal];
        instance.agents[2 * one + 1].stops = vec![goal];
        instance.merges.push([2 * one, 2 * one + 1]);
    }
    instance
}

/// Plans, checks, improves for each aim, checks again; returns whether there was a plan.
fn plan_and_check(instance: &Instance, seed: u64, steps: u64) -> bool {
    let terms = FirstPlanTerms { seed, ..FirstPlanTerms::default() };
    let Some(paths) = first(instance, terms, &mut meter(steps)) else { return false };
    assert_eq!(violations(instance, &paths), Vec::<String>::new(), "{instance:?}");
    let below = bounds(instance).expect("there is a plan");
    let costs = [BoardObjective::Makespan, BoardObjective::SumOfCosts].map(ImprovementAim::Costs);
    for aim in costs.into_iter().chain([ImprovementAim::LateArrivals]) {
        let better = improve(instance, paths.clone(), aim, seed, &mut meter(3_000));
        assert_eq!(violations(instance, &better), Vec::<String>::new(), "{aim:?} {instance:?}");
        let (old, new, objective) = (BoardCosts::of(&paths), BoardCosts::of(&better), aim.final_objective());
        assert!(new.key(objective) <= old.key(objective));
        assert!(new.makespan >= below.makespan && new.sum_of_costs >= below.sum_of_costs);
    }
    true
}

#[test]
fn small_random_instances_have_legal_plans() {
    let mut random = SplitMix64::new(1);
    let mut solved = 0;
    for round in 0..300 {
        let separation = [1, 2, 3, 4][round % 4];
        let agents = 1 + random.below(6);
        let shape = Shape { sides: (8, 20), agents, separation, obstacles: round % 7, stops: round % 3 };
        let instance = random_instance(&mut random, shape);
        let instance = if round % 5 == 0 { with_merges(instance) } else { instance };
        solved += u32::from(plan_and_check(&instance, round as u64, 30_000));
    }
    assert!(solved > 200, "{solved} of 300");
}

#[test]
fn dense_boards_are_solved() {
    let mut random = SplitMix64::new(2);
    for (separation, side, agents) in [(1, 12, 60), (2, 16, 20), (4, 26, 11), (4, 48, 40)] {
        let shape = Shape { sides: (side, side), agents, separation, obstacles: 0, stops: 0 };
        for seed in 0..3 {
            let instance = random_instance(&mut random, shape);
            assert!(plan_and_check(&instance, seed, 3 * PLENTY), "{separation} {side} {agents}");
        }
    }
}

#[test]
fn thirty_microparts_are_always_planned() {
    let mut random = SplitMix64::new(3);
    let shape = Shape { sides: (48, 48), agents: 30, separation: 4, obstacles: 0, stops: 0 };
    for seed in 0..10 {
        let instance = random_instance(&mut random, shape);
        assert_eq!(instance.agents.len(), 30);
        assert!(plan_and_check(&instance, seed, PLENTY));
    }
}

#[test]
fn the_checker_finds_each_fault() {
    let agent = |start, goal| Agent { start, stops: vec![goal] };
    let board = BoardGrid::new(8, 1);
    let instance = Instance { board, separation: 2, agents: vec![agent(0, 1), agent(3, 5)], merges: vec![] };
    let faults = |paths: Paths| violations(&instance, &paths).len();
    assert_eq!(faults(vec![vec![0, 1], vec![3, 4, 5]]), 0);
    assert_eq!(faults(vec![vec![0, 1], vec![3, 5]]), 1);
    assert_eq!(faults(vec![vec![0, 1], vec![3, 2, 3, 4, 5]]), 2);
    assert_eq!(faults(vec![vec![0, 1], vec![3, 4]]), 1);
    assert_eq!(faults(vec![vec![0, 1, 1], vec![3, 4, 5]]), 1);
}

/// A corridor of one row with a bay below its middle.
fn corridor(length: u32, bay: bool) -> BoardGrid {
    let mut board = BoardGrid::new(length, 2);
    for column in 0..length {
        if column != length / 2 || !bay {
            board.block(board.cell(column, 1));
        }
    }
    board
}

fn swap(board: BoardGrid) -> Instance {
    let last = board.width() - 1;
    let agents = vec![Agent { start: 0, stops: vec![last] }, Agent { start: last, stops: vec![0] }];
    Instance { board, separation: 1, agents, merges: Vec::new() }
}

#[test]
fn two_swap_in_a_corridor_with_a_bay() {
    assert!(plan_and_check(&swap(corridor(9, true)), 1, PLENTY));
}

#[test]
fn two_swap_in_a_room_that_is_hardly_wide_enough() {
    let board = BoardGrid::new(10, 7);
    let (left, right) = (board.cell(0, 3), board.cell(9, 3));
    let agents = vec![Agent { start: left, stops: vec![right] }, Agent { start: right, stops: vec![left] }];
    for separation in [1, 2, 3] {
        let instance = Instance { board: board.clone(), separation, agents: agents.clone(), merges: Vec::new() };
        assert!(plan_and_check(&instance, 1, PLENTY), "{separation}");
    }
}

#[test]
fn without_a_bay_the_search_ends_with_its_meter() {
    let mut spent = meter(20_000);
    assert_eq!(first(&swap(corridor(9, false)), FirstPlanTerms::default(), &mut spent), None);
    assert_eq!(spent.left().steps, 0);
}

#[test]
fn nobody_needs_no_plan() {
    let instance = Instance { board: BoardGrid::new(5, 5), separation: 4, agents: vec![], merges: vec![] };
    assert!(plan_and_check(&instance, 1, 10));
    assert_eq!(bounds(&instance), Ok(BoardCosts::default()));
}

#[test]
fn starts_stops_and_goals_may_be_one() {
    let board = BoardGrid::new(14, 14);
    let here = board.cell(5, 5);
    let ring = [board.cell(1, 1), board.cell(1, 9), board.cell(9, 9), board.cell(9, 1)];
    let mut agents: Vec<Agent> =
        (0..4).map(|turn| Agent { start: ring[turn], stops: vec![ring[turn], ring[(turn + 1) % 4]] }).collect();
    agents.push(Agent { start: here, stops: vec![here, here, here] });
    let instance = Instance { board, separation: 4, agents, merges: Vec::new() };
    assert!(plan_and_check(&instance, 1, PLENTY));
    assert_eq!(bounds(&instance), Ok(BoardCosts { makespan: 8, sum_of_costs: 32 }));
}

#[test]
fn two_droplets_merge_on_their_goal_only() {
    let board = BoardGrid::new(9, 1);
    let agents = vec![Agent { start: 0, stops: vec![4] }, Agent { start: 8, stops: vec![4] }];
    let apart = Instance { board: board.clone(), separation: 2, agents: agents.clone(), merges: vec![] };
    assert_eq!(first(&apart, FirstPlanTerms::default(), &mut meter(20_000)), None);
    let instance = Instance { board, separation: 2, agents, merges: vec![[0, 1]] };
    assert!(plan_and_check(&instance, 1, PLENTY));
}

#[test]
fn a_walled_in_stop_is_named() {
    let mut board = BoardGrid::new(9, 9);
    for cell in [board.cell(1, 0), board.cell(0, 1)] {
        board.block(cell);
    }
    let far = board.cell(8, 8);
    let agents = vec![
        Agent { start: far, stops: vec![far] },
        Agent { start: board.cell(4, 4), stops: vec![far - 1, 0, far - 3] },
    ];
    let instance = Instance { board, separation: 1, agents, merges: Vec::new() };
    assert_eq!(bounds(&instance), Err(NoBoardPlan::Closed { agent: 1, stop: 1 }));
    assert_eq!(first(&instance, FirstPlanTerms::default(), &mut meter(PLENTY)), None);
}

#[test]
fn the_step_limit_holds() {
    let instance = swap(corridor(9, true));
    let with = |limit| {
        first(
            &instance,
            FirstPlanTerms { seed: 1, step_limit: Some(limit), ..FirstPlanTerms::default() },
            &mut meter(100_000),
        )
    };
    assert_eq!(with(7), None);
    let best = improve(
        &instance,
        with(40).expect("enough"),
        ImprovementAim::Costs(BoardObjective::Makespan),
        1,
        &mut meter(PLENTY),
    );
    let least = BoardCosts::of(&best).makespan;
    assert_eq!(with(least as u32).map(|paths| BoardCosts::of(&paths).makespan), Some(least));
}

#[test]
fn the_same_seed_means_the_same_plan() {
    let mut random = SplitMix64::new(4);
    let shape = Shape { sides: (30, 30), agents: 14, separation: 4, obstacles: 3, stops: 1 };
    let instance = random_instance(&mut random, shape);
    let run = || {
        let paths = first(&instance, FirstPlanTerms::default(), &mut meter(PLENTY)).expect("solvable");
        improve(&instance, paths, ImprovementAim::Costs(BoardObjective::SumOfCosts), 5, &mut meter(50_000))
    };
    assert_eq!(run(), run());
}

#[test]
fn a_board_that_is_too_large_is_left_alone() {
    let board = BoardGrid::new(1 << 11, (1 << 10) + 1);
    let instance = Instance { board, separation: 1, agents: vec![Agent { start: 0, stops: vec![0] }], merges: vec![] };
    assert_eq!(first(&instance, FirstPlanTerms::default(), &mut meter(PLENTY)), None);
    assert_eq!(improve(&instance, vec![vec![0]], ImprovementAim::LateArrivals, 0, &mut meter(9)), vec![vec![0]]);
}
