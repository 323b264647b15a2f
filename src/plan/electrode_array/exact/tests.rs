use super::*;
use crate::plan::electrode_array::board::{Agent, BoardGrid, CellIndex};
use crate::plan::electrode_array::joint::oracle::{Chance, Shape, fault, least, random};

fn meter() -> Meter {
    Meter::new(SearchBudget::of(20_000_000))
}

fn shape(size: (u32, u32), separation: u32, agents: usize, blocked_percent: u64, vias: u64, merges: bool) -> Shape {
    Shape { width: size.0, height: size.1, separation, agents, blocked_percent, vias, merges }
}

fn tiny() -> Vec<Shape> {
    vec![
        shape((4, 4), 1, 2, 25, 0, false),
        shape((3, 3), 1, 3, 15, 1, false),
        shape((4, 3), 1, 3, 25, 0, false),
        shape((5, 5), 2, 2, 25, 2, false),
        shape((5, 4), 2, 3, 5, 0, false),
        shape((5, 4), 2, 2, 20, 0, true),
        shape((4, 4), 2, 3, 10, 0, true),
        shape((6, 5), 3, 2, 10, 1, false),
        shape((7, 6), 4, 2, 5, 0, false),
    ]
}

/// Compares the search by groups with plain searches, on instances small enough for them.
#[test]
fn conflict_based_search_agrees_with_plain_searches() {
    let mut chance = Chance(0xc0ffee);
    let mut compared = 0;
    for shape in tiny() {
        for round in 0..25 {
            let Some(instance) = random(shape, &mut chance) else { continue };
            let Ok(tables) = ExactTables::new(&instance) else { continue };
            let Some(makespan) = least(&instance, BoardObjective::Makespan) else { continue };
            let sum = least(&instance, BoardObjective::SumOfCosts).unwrap();
            let wanted = WantedBounds { least: 0, most: ALWAYS, ceiling: u64::MAX };
            let found = groups::search(&tables, wanted, &mut meter());
            let TreeAnswer::Found { mut paths, cost } = found else {
                panic!("{round} {instance:?}: {found:?} for {sum}")
            };
            paths.iter_mut().for_each(trim);
            assert_eq!(fault(&instance, &paths), None, "{instance:?}");
            assert_eq!((cost, BoardCosts::of(&paths).sum_of_costs), (sum, sum), "{instance:?}");
            let wanted = WantedBounds { least: 0, most: makespan as u32, ceiling: u64::MAX };
            let limited = groups::search(&tables, wanted, &mut meter());
            let everyone: Vec<usize> = (0..tables.agents()).collect();
            let aim = JointAim::SumOfCosts { limit: Some(makespan as u32) };
            let joint::JointAnswer::Found(best) = joint::search(&tables, &everyone, aim, &mut meter()) else {
                panic!("{instance:?}")
            };
            let TreeAnswer::Found { cost, .. } = limited else { panic!("{instance:?}: {limited:?}") };
            assert_eq!(cost, BoardCosts::of(&best).sum_of_costs, "{instance:?} within {makespan}");
            let at = groups::search(&tables, exactly(makespan as u32), &mut meter());
            let TreeAnswer::Found { mut paths, .. } = at else { panic!("{instance:?}: {at:?} at {makespan}") };
            paths.iter_mut().for_each(trim);
            assert_eq!(fault(&instance, &paths), None, "{instance:?}");
            if makespan > 0 {
                assert_eq!(
                    groups::search(&tables, exactly(makespan as u32 - 1), &mut meter()),
                    TreeAnswer::Nothing,
                    "{instance:?}"
                );
            }
            compared += 1;
        }
    }
    assert!(compared > 120, "{compared}");
}

/// Pairs never exclude a number of steps within which a plain search finds a plan, and exclude many of the others.
#[test]
fn steps_excluded_by_pairs_agree_with_plain_searches() {
    let mut chance = Chance(0xbead);
    let (mut kept, mut excluded, mut missed) = (0, 0, 0);
    for shape in tiny() {
        for _ in 0..60 {
            let Some(instance) = random(shape, &mut chance) else { continue };
            let Ok(tables) = ExactTables::new(&instance) else { continue };
            let Some(makespan) = least(&instance, BoardObjective::Makespan) else { continue };
            let alone = (0..tables.agents()).map(|agent| u64::from(tables.least(agent))).max().unwrap();
            assert!(raised(&instance, alone, u64::MAX, &mut meter()) <= makespan, "{instance:?} takes {makespan}");
            for steps in makespan..makespan + 3 {
                assert!(!joint_mdd::excludes(&tables, steps as u32, &mut meter()), "{instance:?} in {steps}");
                kept += 1;
            }
            if makespan > alone {
                let is_excluded = joint_mdd::excludes(&tables, makespan as u32 - 1, &mut meter());
                *(if is_excluded { &mut excluded } else { &mut missed }) += 1;
            }
        }
    }
    assert!(kept > 900 && excluded > 4 * missed, "{kept} kept, {excluded} excluded, {missed} missed");
}

#[test]
fn proofs_agree_with_plain_searches() {
    let mut chance = Chance(0xfeed);
    let (mut solved, mut impossible) = (0, 0);
    for shape in tiny() {
        for _ in 0..25 {
            let Some(instance) = random(shape, &mut chance) else { continue };
            for objective in [BoardObjective::Makespan, BoardObjective::SumOfCosts] {
                let answer = prove(&instance, objective, None, None, &mut meter());
                let Some(cost) = least(&instance, objective) else {
                    assert!(
                        matches!(
                            answer,
                            BoardAnswer::Impossible(NoBoardPlan::Blocked { .. } | NoBoardPlan::Closed { .. })
                        ),
                        "{instance:?}: {answer:?}"
                    );
                    impossible += 1;
                    continue;
                };
                let BoardAnswer::Found(BoardPlan { paths, bounds }) = answer else {
                    panic!("{instance:?}: {answer:?}")
                };
                assert_eq!(fault(&instance, &paths), None, "{instance:?}");
                assert_eq!(
                    (BoardCosts::of(&paths).key(objective).0, bounds.key(objective).0),
                    (cost, cost),
                    "{instance:?}"
                );
                solved += 1;
            }
        }
    }
    assert!(solved > 200 && impossible > 20, "{solved} solved, {impossible} impossible");
}

/// Column and row.
type Place = (u32, u32);

/// An instance of a board drawn with `#` for blocked cells, the top line the highest row; cells as column and row.
fn drawn(lines: &[&str], separation: u32, asked: &[(Place, Place)]) -> Instance {
    let mut board = BoardGrid::new(lines[0].len() as u32, lines.len() as u32);
    for (row, line) in lines.iter().rev().enumerate() {
        for (column, _) in line.chars().enumerate().filter(|(_, mark)| *mark == '#') {
            board.block(board.cell(column as u32, row as u32));
        }
    }
    let at = |(column, row): Place| board.cell(column, row);
    let agents = asked.iter().map(|(start, goal)| Agent { start: at(*start), stops: vec![at(*goal)] }).collect();
    Instance { board, separation, agents, merges: vec![] }
}

fn table_6() -> Instance {
    let mut board = BoardGrid::new(50, 50);
    for k in 0..50 {
        for cell in [board.cell(k, 0), board.cell(k, 49), board.cell(0, k), board.cell(49, k)] {
            board.block(cell);
        }
    }
    let parts = [((5, 3), (26, 31)), ((26, 31), (5, 3)), ((46, 4), (4, 48)), ((14, 45), (46, 4)), ((3, 20), (48, 30))];
    let at = |(column, row): Place| board.cell(column - 1, row - 1);
    let agents = parts.iter().map(|(start, goal)| Agent { start: at(*start), stops: vec![at(*goal)] }).collect();
    Instance { board, separation: 4, agents, merges: vec![] }
}

#[test]
fn table_6_takes_its_lower_bounds_by_both_objectives() {
    let instance = table_6();
    for objective in [BoardObjective::Makespan, BoardObjective::SumOfCosts] {
        let answer = prove(&instance, objective, None, None, &mut Meter::new(SearchBudget::of(1_000_000)));
        let BoardAnswer::Found(BoardPlan { paths, bounds }) = answer else { panic!("{answer:?}") };
        assert_eq!(fault(&instance, &paths), None);
        assert_eq!(BoardCosts::of(&paths), BoardCosts { makespan: 86, sum_of_costs: 312 });
        assert_eq!(bounds, BoardCosts { makespan: 86, sum_of_costs: 49 + 49 + 86 + 73 + 55 });
    }
}

#[test]
fn an_incumbent_at_the_bound_is_proven_without_a_step_and_one_above_is_bettered() {
    let instance = drawn(&[".....", ".....", "....."], 1, &[((0, 0), (4, 0)), ((0, 2), (4, 2))]);
    let straight = |row: CellIndex| (0..5).map(|column| row * 5 + column).collect::<Vec<CellIndex>>();
    let direct = vec![straight(0), straight(2)];
    let mut meter = meter();
    let answer = prove(&instance, BoardObjective::SumOfCosts, Some(&direct), None, &mut meter);
    let bounds = BoardCosts { makespan: 4, sum_of_costs: 8 };
    assert_eq!((answer, meter.spent()), (BoardAnswer::Found(BoardPlan { paths: direct.clone(), bounds }), 0));

    let mut late = direct.clone();
    late[0].insert(0, 0);
    let answer = prove(&instance, BoardObjective::SumOfCosts, Some(&late), None, &mut meter);
    let BoardAnswer::Found(BoardPlan { paths, bounds: proven }) = answer else { panic!("{answer:?}") };
    assert_eq!((BoardCosts::of(&paths), proven), (bounds, bounds));
}

#[test]
fn the_pair_that_cannot_pass_is_named_and_no_one_else() {
    // Agents 1 and 2 in a corridor of their own; agent 0 is free.
    let instance =
        drawn(&["..........", "##########", ".........."], 1, &[((0, 2), (9, 2)), ((0, 0), (9, 0)), ((9, 0), (0, 0))]);
    let answer = prove(&instance, BoardObjective::Makespan, None, None, &mut meter());
    assert_eq!(answer, BoardAnswer::Impossible(NoBoardPlan::Blocked { agents: vec![1, 2] }));
    // With a bay they can pass.
    let instance =
        drawn(&["..........", "####.#####", ".........."], 1, &[((0, 2), (9, 2)), ((0, 0), (9, 0)), ((9, 0), (0, 0))]);
    let answer = prove(&instance, BoardObjective::Makespan, None, None, &mut meter());
    assert!(matches!(answer, BoardAnswer::Found(_)), "{answer:?}");
}

#[test]
fn what_agents_reach_that_cannot_pass_ends_before_one_another() {
    let corridor = [((0, 0), (9, 0)), ((9, 0), (0, 0))];
    let instance = drawn(&[".........."], 1, &corridor);
    assert_eq!(reached(&instance, &[0, 1]), Some(vec![(0..=8).collect(), (1..=9).collect()]));
    // At a separation of three, each agent's own end of the corridor can only be reached by the agent that starts
    // there.
    let instance = drawn(&[".........."], 3, &corridor);
    assert_eq!(reached(&instance, &[1, 0]), Some(vec![(3..=9).collect(), (0..=6).collect()]));
    // Agents that can pass have a plan, and so no such proof.
    let instance = drawn(&["..........", "####.#####"], 1, &[((0, 1), (9, 1)), ((9, 1), (0, 1))]);
    assert_eq!(reached(&instance, &[0, 1]), None);
}

#[test]
fn a_blocked_pair_is_found_in_a_joint_space_too_large_to_search() {
    let (free, wall) = (".".repeat(60), "#".repeat(60));
    let lines = [free.as_str(), &free, &free, &wall, &free];
    let asked = [((0, 4), (59, 2)), ((59, 4), (0, 2)), ((0, 0), (50, 0)), ((55, 0), (4, 0)), ((30, 3), (31, 3))];
    let instance = drawn(&lines, 2, &asked);
    for (objective, limit) in
        [(BoardObjective::Makespan, None), (BoardObjective::SumOfCosts, None), (BoardObjective::SumOfCosts, Some(500))]
    {
        let answer = prove(&instance, objective, None, limit, &mut meter());
        assert_eq!(answer, BoardAnswer::Impossible(NoBoardPlan::Blocked { agents: vec![2, 3] }));
    }
}

#[test]
fn three_that_block_although_each_pair_passes_are_proven_so() {
    // With one free cell, each pair of three agents in a ring of four could pass; an odd permutation of all three cannot.
    let instance = drawn(&["..", ".."], 1, &[((0, 0), (1, 0)), ((1, 0), (0, 0)), ((1, 1), (1, 1))]);
    let answer = prove(&instance, BoardObjective::SumOfCosts, None, None, &mut meter());
    assert_eq!(answer, BoardAnswer::Impossible(NoBoardPlan::Blocked { agents: vec![0, 1, 2] }));
}

#[test]
fn a_limit_at_the_optimum_passes_and_one_below_names_it() {
    let instance = table_6();
    let at = prove(&instance, BoardObjective::SumOfCosts, None, Some(86), &mut meter());
    assert!(matches!(at, BoardAnswer::Found(_)), "{at:?}");
    let below = prove(&instance, BoardObjective::SumOfCosts, None, Some(85), &mut meter());
    assert_eq!(below, BoardAnswer::Impossible(NoBoardPlan::TooFewSteps { least: 86 }));
    // Passing in a bay takes longer than the distance, which is 9.
    let narrow = drawn(&["####.#####", ".........."], 1, &[((0, 0), (9, 0)), ((9, 0), (0, 0))]);
    let Some(optimum) = least(&narrow, BoardObjective::Makespan) else { panic!("they can pass") };
    assert!(optimum > 9);
    for objective in [BoardObjective::Makespan, BoardObjective::SumOfCosts] {
        let below = prove(&narrow, objective, None, Some(optimum - 1), &mut meter());
        assert_eq!(below, BoardAnswer::Impossible(NoBoardPlan::TooFewSteps { least: optimum }));
        assert!(matches!(prove(&narrow, objective, None, Some(optimum), &mut meter()), BoardAnswer::Found(_)));
    }
}

#[test]
fn walls_are_named_and_a_budget_of_nothing_gives_the_distances() {
    let walled = drawn(&["..#.", "..#."], 1, &[((0, 0), (1, 0)), ((0, 1), (3, 1))]);
    let answer = prove(&walled, BoardObjective::Makespan, None, None, &mut meter());
    assert_eq!(answer, BoardAnswer::Impossible(NoBoardPlan::Closed { agent: 1, stop: 0 }));
    let answer = prove(&table_6(), BoardObjective::Makespan, None, None, &mut Meter::new(SearchBudget::of(0)));
    assert_eq!(answer, BoardAnswer::GaveUp(BoardCosts { makespan: 86, sum_of_costs: 312 }));
    let nobody = Instance { board: BoardGrid::new(3, 3), separation: 2, agents: vec![], merges: vec![] };
    let answer = prove(&nobody, BoardObjective::Makespan, None, None, &mut meter());
    assert_eq!(answer, BoardAnswer::Found(BoardPlan { paths: vec![], bounds: BoardCosts::default() }));
}

#[test]
fn a_board_beyond_the_tables_is_bounded_all_the_same() {
    let board = BoardGrid::new(6_000, 6_000);
    let agents = vec![Agent { start: 0, stops: vec![board.cell(10, 7), board.cell(0, 7)] }];
    let instance = Instance { board, separation: 4, agents, merges: vec![] };
    let answer = prove(&instance, BoardObjective::Makespan, None, None, &mut meter());
    assert_eq!(answer, BoardAnswer::GaveUp(BoardCosts { makespan: 27, sum_of_costs: 27 }));
}

#[test]
fn every_budget_ends_with_sound_bounds() {
    let instance = drawn(
        &["............", ".##.##.##.#.", "............", ".##.##.##.#.", "............"],
        2,
        &[((0, 0), (11, 4)), ((11, 4), (0, 0)), ((0, 4), (11, 0)), ((11, 0), (0, 4)), ((6, 2), (3, 2))],
    );
    let BoardAnswer::Found(BoardPlan { bounds: full, .. }) =
        prove(&instance, BoardObjective::SumOfCosts, None, None, &mut meter())
    else {
        panic!("solved within the full budget")
    };
    for steps in [1, 10, 100, 1_000, 10_000, 100_000] {
        let mut meter = Meter::new(SearchBudget::of(steps));
        let bounds = match prove(&instance, BoardObjective::SumOfCosts, None, None, &mut meter) {
            BoardAnswer::Found(BoardPlan { paths, bounds }) => {
                assert_eq!(fault(&instance, &paths), None);
                bounds
            }
            BoardAnswer::GaveUp(bounds) => bounds,
            BoardAnswer::Impossible(why) => panic!("{why:?}"),
        };
        assert!(bounds.sum_of_costs <= full.sum_of_costs, "{steps}: {bounds:?}");
    }
}
