//! The planner for many parts on one board, tested from outside: every plan is checked step by step, and proofs are
//! compared with brute force on tiny boards.

mod assay;
mod brute;
mod check;
mod found;
mod pins;
mod programs;
mod scenes;
#[path = "../support/mod.rs"]
mod support;
mod task;
mod teams;
mod tiny;
mod washes;

use check::{fault, judged};
use scenes::{Random, Shape, block, droplets, rimmed, table_6};
use tweeze::plan::electrode_array::board::{
    Agent, BoardAnswer, BoardCosts, BoardGrid, BoardObjective, Instance, NoBoardPlan,
};
use tweeze::plan::electrode_array::{fast, first, solve};
use tweeze::plan::search::{Meter, SearchBudget};

const OBJECTIVES: [BoardObjective; 2] = [BoardObjective::Makespan, BoardObjective::SumOfCosts];

/// Greatest number of joint states that brute force searches.
const MOST_STATES: u64 = 1 << 18;

fn agents(board: &BoardGrid, ends: &[[(u32, u32); 2]]) -> Vec<Agent> {
    let at = |(column, row): (u32, u32)| board.cell(column, row);
    ends.iter().map(|[start, goal]| Agent { start: at(*start), stops: vec![at(*goal)] }).collect()
}

/// Confirms the proof that there is no plan by brute force with the parts that it names.
fn confirm(instance: &Instance, why: &NoBoardPlan) {
    match why {
        NoBoardPlan::Closed { agent, .. } => {
            assert_eq!(brute::least(instance, &[*agent], BoardObjective::Makespan), None, "{instance:?}")
        }
        NoBoardPlan::Blocked { agents } => {
            let states = brute::states(instance, agents);
            assert!(states <= MOST_STATES, "not confirmed: {agents:?} of {instance:?}");
            assert_eq!(brute::least(instance, agents, BoardObjective::Makespan), None, "{agents:?} of {instance:?}");
        }
        NoBoardPlan::TornByChannels { .. } => panic!("no channel is shared: {instance:?}"),
        NoBoardPlan::TooFewSteps { .. } => panic!("no limit was given: {instance:?}"),
    }
}

/// Lower bounds from each part alone; `None` if one is walled in.
fn simple_bounds(instance: &Instance) -> Option<BoardCosts> {
    let alone = |agent| brute::least(instance, &[agent], BoardObjective::Makespan);
    let alone: Option<Vec<u64>> = (0..instance.agents.len()).map(alone).collect();
    alone.map(|alone| BoardCosts {
        makespan: alone.iter().copied().max().unwrap_or(0),
        sum_of_costs: alone.iter().sum(),
    })
}

#[test]
fn random_instances_end_in_legal_plans_or_proofs() {
    let mut chance = Random::new(0x7465_7a65);
    let (mut found, mut impossible, mut gave_up) = (0, 0, 0);
    for round in 0..60 {
        let side = || 14 + round * 46 / 59;
        let separation = if round % 2 == 0 { 2 } else { 4 };
        let most = (side() * side() / (separation * separation * 6)).clamp(2, 40);
        let agents = 2 + chance.below(most - 1) as usize;
        let shape = Shape { size: (side(), side()), rim: 1, separation, agents, obstacles: chance.below(40) };
        let Some(instance) = shape.instance(&mut chance) else { continue };
        let objective = OBJECTIVES[(round / 2 % 2) as usize];
        let answer = solve(&instance, objective, None, SearchBudget::of(60_000));
        match (&answer, judged(&instance, &answer)) {
            (_, Some((_, bounds))) => {
                let simple = simple_bounds(&instance).expect("there is a plan");
                assert!(bounds.makespan >= simple.makespan && bounds.sum_of_costs >= simple.sum_of_costs, "{bounds:?}");
                found += 1;
            }
            (BoardAnswer::Impossible(why), None) => {
                confirm(&instance, why);
                impossible += 1;
            }
            (_, None) => gave_up += 1,
        }
    }
    assert!(found >= 35 && impossible >= 3, "{found} found, {impossible} impossible, {gave_up} given up");
}

#[test]
fn a_limit_on_the_steps_is_kept_and_a_smaller_one_is_refused() {
    let mut chance = Random::new(77);
    let (mut kept, mut refused) = (0, 0);
    for _ in 0..25 {
        let shape = Shape { size: (16, 16), rim: 1, separation: 2, agents: 5, obstacles: 4 };
        let instance = shape.instance(&mut chance).expect("five parts fit");
        let Some((costs, bounds)) =
            judged(&instance, &solve(&instance, BoardObjective::Makespan, None, SearchBudget::of(200_000)))
        else {
            continue;
        };
        if costs.makespan > bounds.makespan {
            continue;
        }
        let within = solve(&instance, BoardObjective::SumOfCosts, Some(costs.makespan), SearchBudget::of(200_000));
        if let Some((again, _)) = judged(&instance, &within) {
            assert_eq!(again.makespan, costs.makespan, "{instance:?}");
            kept += 1;
        }
        let Some(less) = costs.makespan.checked_sub(1) else { continue };
        match solve(&instance, BoardObjective::Makespan, Some(less), SearchBudget::of(200_000)) {
            BoardAnswer::Impossible(NoBoardPlan::TooFewSteps { least }) => {
                assert!(least > less && least <= costs.makespan, "{least} for {costs:?}: {instance:?}");
                refused += 1;
            }
            BoardAnswer::GaveUp(bounds) => assert!(bounds.makespan <= costs.makespan),
            answer => panic!("{answer:?} within {less}: {instance:?}"),
        }
    }
    assert!(kept >= 15 && refused >= 15, "{kept} kept, {refused} refused");
}

#[test]
fn a_goal_that_is_walled_in_is_closed() {
    let mut board = rimmed(20, 20, 1);
    block(&mut board, (10, 10), (14, 10));
    block(&mut board, (10, 14), (14, 14));
    block(&mut board, (10, 10), (10, 14));
    block(&mut board, (14, 10), (14, 14));
    let ends = [[(2, 2), (17, 2)], [(2, 8), (12, 12)], [(2, 16), (17, 16)]];
    let instance = Instance { agents: agents(&board, &ends), board, separation: 4, merges: vec![] };
    for objective in OBJECTIVES {
        let answer = solve(&instance, objective, None, SearchBudget::of(1_000_000));
        assert_eq!(answer, BoardAnswer::Impossible(NoBoardPlan::Closed { agent: 1, stop: 0 }));
    }
}

#[test]
fn two_parts_cannot_swap_in_a_corridor_whatever_the_others_do() {
    let mut open = BoardGrid::new(24, 12);
    for cell in 0..288 {
        let (column, row) = open.place(cell);
        if row != 2 && !(row > 5 && column > 12) {
            open.block(cell);
        }
    }
    let ends = [[(14, 8), (22, 8)], [(3, 2), (20, 2)], [(20, 10), (14, 11)], [(20, 2), (3, 2)]];
    let instance = Instance { agents: agents(&open, &ends), board: open, separation: 2, merges: vec![] };
    for objective in OBJECTIVES {
        let answer = solve(&instance, objective, None, SearchBudget::of(1_000_000));
        assert_eq!(answer, BoardAnswer::Impossible(NoBoardPlan::Blocked { agents: vec![1, 3] }));
    }
}

#[test]
fn few_parts_on_a_huge_empty_board_are_planned_within_a_small_budget() {
    let shape = Shape { size: (1000, 1000), rim: 1, separation: 4, agents: 50, obstacles: 0 };
    let instance = shape.instance(&mut Random::new(5)).expect("fifty parts fit");
    let answer = solve(&instance, BoardObjective::Makespan, None, SearchBudget::of(1_000_000));
    let (costs, bounds) = judged(&instance, &answer).expect("a plan");
    assert_eq!(costs.makespan, bounds.makespan);
}

#[test]
fn thousands_of_parts_on_a_crowded_board_end_with_the_budget() {
    let shape = Shape { size: (150, 150), rim: 1, separation: 2, agents: 2000, obstacles: 0 };
    let instance = shape.instance(&mut Random::new(9)).expect("two thousand parts fit");
    let answer = solve(&instance, BoardObjective::Makespan, None, SearchBudget::of(300_000));
    match &answer {
        BoardAnswer::Found(_) => assert!(judged(&instance, &answer).is_some()),
        BoardAnswer::GaveUp(bounds) => assert!(bounds.makespan > 0),
        BoardAnswer::Impossible(why) => panic!("{why:?}"),
    }
}

#[test]
fn the_droplet_set_is_solved() {
    let most =
        [("test_a", 15), ("test_b", 13), ("test_d", 27), ("test_e", 38), ("test_g", 35), ("cho_pan_figure5", 20)];
    let cases = droplets();
    assert_eq!(cases.len(), most.len());
    for (name, instance) in cases {
        let answer = solve(&instance, BoardObjective::Makespan, None, SearchBudget::of(500_000));
        let (costs, bounds) = judged(&instance, &answer).expect("a plan");
        let stated = most.iter().find(|(case, _)| *case == name).map(|(_, most)| *most);
        assert!(stated.is_some_and(|stated| costs.makespan <= stated), "{name}: {costs:?}");
        if !["test_d", "cho_pan_figure5"].contains(&name.as_str()) {
            assert_eq!((Some(costs.makespan), bounds.makespan), (stated, costs.makespan), "{name}");
        }
    }
}

#[test]
fn table_6_of_the_paper_takes_86_steps_and_no_fewer() {
    let instance = table_6();
    let answer = solve(&instance, BoardObjective::Makespan, None, SearchBudget::of(1_000_000));
    let (costs, bounds) = judged(&instance, &answer).expect("a plan");
    assert_eq!((costs.makespan, bounds.makespan), (86, 86));
    let shorter = solve(&instance, BoardObjective::Makespan, Some(85), SearchBudget::of(1_000_000));
    assert_eq!(shorter, BoardAnswer::Impossible(NoBoardPlan::TooFewSteps { least: 86 }));
}

/// The judge itself: a good plan passes, and every way to spoil it is detected.
#[test]
fn the_judge_sees_what_is_wrong() {
    let board = BoardGrid::new(6, 6);
    let instance = Instance {
        agents: agents(&board, &[[(0, 0), (2, 0)], [(0, 2), (2, 2)]]),
        board,
        separation: 2,
        merges: vec![],
    };
    let good = vec![vec![0, 1, 2], vec![12, 13, 14]];
    assert_eq!(fault(&instance, &good), None);
    let spoilt: [(usize, &[u32], &str); 6] = [
        (0, &[0, 2], "jumps"),
        (0, &[0, 1], "elsewhere"),
        (0, &[0, 1, 2, 2], "has arrived"),
        (1, &[12, 6, 7, 8, 14], "too near"),
        (0, &[0, 1, 99, 2], "blocked"),
        (1, &[12, 13, 7, 13, 14], "too near"),
    ];
    for (part, path, word) in spoilt {
        let mut paths = good.clone();
        paths[part] = path.to_vec();
        let fault = fault(&instance, &paths).unwrap_or_default();
        assert!(fault.contains(word), "{path:?}: {fault}");
    }
    let mut by = instance.clone();
    by.agents[0].stops.insert(0, 4);
    assert!(fault(&by, &good).is_some_and(|fault| fault.contains("leaves out")));
}

/// Eight droplets on 6 × 6 cells, like a sliding puzzle with a little free space, in even permutations.
#[test]
fn crowded_boards_have_plans() {
    let board = BoardGrid::new(6, 6);
    let cells: Vec<(u32, u32)> = (0..9).map(|index| (index % 3 * 2, index / 3 * 2)).collect();
    let mut chance = Random::new(31);
    for _ in 0..8 {
        let mut goals = cells.clone();
        for _ in 0..20 {
            let [one, other] = [chance.below(7) as usize, chance.below(6) as usize];
            goals.swap(one, one + 1);
            goals.swap(other, other + 2);
        }
        let ends: Vec<[(u32, u32); 2]> = (0..8).map(|part| [cells[part], goals[part]]).collect();
        let instance = Instance { board: board.clone(), separation: 2, agents: agents(&board, &ends), merges: vec![] };
        let answer = solve(&instance, BoardObjective::SumOfCosts, None, SearchBudget::of(2_000_000));
        assert!(judged(&instance, &answer).is_some(), "{answer:?}");
    }
}

/// A crowd of microparts on a third of the board: a plan within a tenth of the bound, which repair without conflict
/// weights does not find with this budget; and a plan that is shorter than the first one, within a step limit.
#[test]
fn crowds_arrive_near_their_bound() {
    let shape = Shape { size: (32, 32), rim: 0, separation: 4, agents: 22, obstacles: 0 };
    let instance = shape.instance(&mut Random::new(3)).expect("there is room");
    let bound = simple_bounds(&instance).expect("nothing is walled in").makespan;
    let least = u32::try_from(bound).expect("a short way");
    let mut meter = Meter::new(SearchBudget::of(1_500_000));
    let terms = fast::FirstPlanTerms { seed: 1, step_limit: Some(least * 11 / 10), most_conflicts: None };
    let near = fast::first(&instance, terms, &mut meter).expect("conflicts that persist gain weight");
    assert_eq!(fault(&instance, &near), None);
    assert!(BoardCosts::of(&near).makespan * 10 <= bound * 11);

    let long = first(&instance, BoardObjective::Makespan, SearchBudget::of(1_500_000)).expect("there is a plan");
    assert_eq!(fault(&instance, &long), None);
    let makespan = BoardCosts::of(&long).makespan;
    let terms = fast::FirstPlanTerms { step_limit: Some(makespan as u32 - 1), ..terms };
    let mut meter = Meter::new(SearchBudget::of(1_500_000));
    let shorter = fast::tighten(&instance, &long, terms, &mut meter).expect("a step less is possible");
    assert_eq!(fault(&instance, &shorter), None);
    assert!(BoardCosts::of(&shorter).makespan < makespan, "{makespan}");
    let hopeless = fast::FirstPlanTerms { most_conflicts: Some(0), ..terms };
    assert_eq!(fast::tighten(&instance, &long, hopeless, &mut Meter::new(SearchBudget::of(1_500_000))), None);
}
