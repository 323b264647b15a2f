//! Whole jobs: blocking obstacles, parts that yield, and the reports where there is no plan.

use super::ElectrodeArrayMotion;
use super::board::BoardObjective;
use super::*;
use crate::claims::electrode_array::{
    AssayOperation, BoardPart, Bystanders, ElectrodeArrayAction, ElectrodeArrayMethod, ElectrodeArrayMove,
    ElectrodeArrayObjective, ElectrodeArrayObstacle, ElectrodeArrayObstacleBody, ElectrodeArrayOrder,
    ElectrodeArrayPlanner, ElectrodeArrayStep, ElectrodeArrayStop, OperationPlace,
};
use crate::claims::fixture::{self, board_order};
use crate::claims::{Job, Order, Relation, Requirement};
use crate::device::electrode_array::fixture::{droplets, microparts};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};
use crate::diagnostic::{Code, Sink};
use crate::plan::search::{Meter, SearchAnswer, SearchBudget};
use crate::plan::{Optimality, Plan};
use crate::random::SplitMix64;
use crate::source::{FileId, Span};
use std::sync::Arc;

/// A distinct place in the source.
fn span(at: usize) -> Span {
    Span::new(FileId(0), at, at + 1)
}

/// A task without obstacles and without moves.
fn order(facts: ElectrodeArrayFacts, cells: &[(u32, u32)]) -> ElectrodeArrayOrder {
    let part = |(index, (column, row)): (usize, &(u32, u32))| BoardPart {
        name: format!("m{}", index + 1),
        cell: Some(ElectrodeCell::new(*column, *row)),
        span: span(100 + index),
    };
    ElectrodeArrayOrder {
        planner: ElectrodeArrayPlanner { method: ElectrodeArrayMethod::Portfolio, expansions: 200_000 },
        ..board_order(facts, cells.iter().enumerate().map(part), Vec::new())
    }
}

fn go(part: usize, stops: &[(u32, u32)]) -> ElectrodeArrayMove {
    let at = 200 + part;
    let stop = |(column, row): &(u32, u32)| ElectrodeArrayStop {
        cell: ElectrodeCell::new(*column, *row),
        span: span(at),
        origin: None,
    };
    ElectrodeArrayMove::alone(part, stops.iter().map(stop).collect(), span(at))
}

fn together(moves: Vec<ElectrodeArrayMove>) -> ElectrodeArrayStep {
    ElectrodeArrayStep { action: ElectrodeArrayAction::Move(moves), span: span(300) }
}

fn wall(name: &str, from: (u32, u32), to: (u32, u32)) -> ElectrodeArrayObstacle {
    let body = ElectrodeArrayObstacleBody::Electrodes {
        from: ElectrodeCell::new(from.0, from.1),
        to: ElectrodeCell::new(to.0, to.1),
    };
    ElectrodeArrayObstacle { name: name.to_owned(), body, span: span(400) }
}

fn job(order: ElectrodeArrayOrder, requirements: Vec<Requirement>) -> Job {
    let usual = fixture::job("swap", "plate", Order::ElectrodeArray(order));
    Job { requirements, span: span(1), run_span: span(2), ..usual }
}

fn limit(outcome: &str, limit: f64) -> Requirement {
    Requirement { outcome: outcome.to_owned(), relation: Relation::AtMost, limit, span: span(3) }
}

fn planned(job: &Job, standing: &mut Standings) -> (Option<Plan<ElectrodeArrayMotion>>, Vec<(Code, String)>) {
    let Order::ElectrodeArray(order) = &job.order else { panic!("an order of an electrode array") };
    let mut sink = Sink::default();
    let plan = plan(job, order, standing, &mut sink);
    (plan, sink.sorted().into_iter().map(|reported| (reported.code, format!("{reported:?}"))).collect())
}

fn found(order: ElectrodeArrayOrder) -> Plan<ElectrodeArrayMotion> {
    let (plan, reported) = planned(&job(order, Vec::new()), &mut Standings::default());
    plan.unwrap_or_else(|| panic!("{reported:?}"))
}

fn refused(order: ElectrodeArrayOrder) -> (Code, String) {
    let (plan, mut reported) = planned(&job(order, Vec::new()), &mut Standings::default());
    assert!(plan.is_none());
    assert_eq!(reported.len(), 1, "{reported:?}");
    reported.remove(0)
}

fn paths(plan: &Plan<ElectrodeArrayMotion>, step: usize) -> &[Vec<ElectrodeCell>] {
    let ElectrodeArrayStepMotion::Paths(paths) = &plan.motion.steps[step] else { panic!("a step of moves") };
    paths
}

#[test]
fn steps_follow_each_other_and_add_up() {
    let mut order = order(microparts(20, 20), &[(3, 3), (3, 12)]);
    order.steps = vec![
        together(vec![go(0, &[(9, 3)])]),
        ElectrodeArrayStep { action: ElectrodeArrayAction::Wait(1_000_000), span: span(301) },
        together(vec![go(0, &[(9, 5)]), go(1, &[(5, 12)])]),
    ];
    let plan = found(order);
    assert_eq!((plan.cost, plan.bound, plan.proof), (8.0, 8.0, Optimality::Proven));
    assert_eq!(plan.outcomes["steps"], 8.0);
    assert_eq!(plan.outcomes["sum_of_costs"], 10.0);
    assert_eq!(plan.outcomes["moves"], 10.0);
    assert_eq!(plan.outcomes["time"], 0.041);
    assert_eq!(plan.bounds["sum_of_costs"], 10.0);
    assert_eq!(paths(&plan, 0)[1], [ElectrodeCell::new(3, 12)]);
    assert_eq!(paths(&plan, 2)[0].last(), Some(&ElectrodeCell::new(9, 5)));
}

#[test]
fn parts_stand_where_the_last_task_left_them() {
    let mut first = order(microparts(20, 20), &[(3, 3), (3, 12)]);
    first.steps = vec![together(vec![go(0, &[(9, 3)])])];
    let mut second = order(microparts(20, 20), &[(3, 3), (3, 12)]);
    second.steps = vec![together(vec![go(0, &[(9, 4)])])];
    let mut standing = Standings::default();
    assert_eq!(planned(&job(first, Vec::new()), &mut standing).0.map(|plan| plan.cost), Some(6.0));
    assert_eq!(planned(&job(second, Vec::new()), &mut standing).0.map(|plan| plan.cost), Some(1.0));
}

#[test]
fn droplets_that_merge_meet_and_are_one_from_then_on() {
    let mut order = order(droplets(12, 9), &[(2, 2), (10, 2), (5, 8)]);
    let mut merge = go(0, &[(6, 2)]);
    merge.with = Some(1);
    order.steps = vec![together(vec![merge]), together(vec![go(0, &[(6, 4)])])];
    let plan = found(order);
    assert_eq!((plan.cost, plan.proof), (6.0, Optimality::Proven));
    assert_eq!(paths(&plan, 0)[0].last(), paths(&plan, 0)[1].last());
    assert!(paths(&plan, 1)[1].is_empty());
}

#[test]
fn a_part_in_a_corridor_yields_only_where_it_may() {
    // One row of electrodes, with a bay for the part that blocks it.
    let mut order = order(droplets(9, 3), &[(1, 2), (5, 2)]);
    order.obstacles =
        Arc::new(vec![wall("low", (1, 1), (9, 1)), wall("left", (1, 3), (3, 3)), wall("right", (7, 3), (9, 3))]);
    order.steps = vec![together(vec![go(0, &[(9, 2)])])];
    let (code, reported) = refused(order.clone());
    assert_eq!(code, Code::E0601);
    assert!(
        reported
            .contains("without `m2 at (5, 2)` `m1` has a path; but with `may_yield: true` the task has no plan either"),
        "{reported}"
    );
    order.bystanders = Bystanders::Yield;
    let (code, reported) = refused(order.clone());
    assert_eq!(code, Code::E0601, "the bay is too low for two droplets: {reported}");
    order.facts.rows = 5;
    order.obstacles =
        Arc::new(vec![wall("low", (1, 1), (9, 1)), wall("left", (1, 3), (4, 5)), wall("right", (6, 3), (9, 5))]);
    let plan = found(order);
    assert_eq!(plan.proof, Optimality::Proven);
    assert_eq!(paths(&plan, 0)[1].last(), Some(&ElectrodeCell::new(5, 2)));
    assert!(paths(&plan, 0)[1].len() > 1);
}

#[test]
fn the_wall_that_closes_the_way_is_named_and_no_other() {
    let mut order = order(microparts(20, 20), &[(3, 3)]);
    order.obstacles = Arc::new(vec![wall("fence", (10, 1), (10, 20)), wall("dust", (5, 15), (5, 15))]);
    order.steps = vec![together(vec![go(0, &[(17, 3)])])];
    let (code, reported) = refused(order);
    assert_eq!(code, Code::E0601);
    assert!(reported.contains("without `fence` there is a plan") && !reported.contains("dust"), "{reported}");
}

#[test]
fn a_help_is_tried_on_the_whole_task() {
    // Behind the fence the two parts must pass one another in a corridor.
    let mut order = order(droplets(11, 1), &[(1, 1), (11, 1)]);
    order.obstacles = Arc::new(vec![wall("fence", (6, 1), (6, 1))]);
    order.steps = vec![together(vec![go(0, &[(11, 1)]), go(1, &[(1, 1)])])];
    let (code, reported) = refused(order.clone());
    assert_eq!(code, Code::E0601);
    assert!(reported.contains("without `fence` `m1` has a path; but then the task has no plan either"), "{reported}");
    order.facts.rows = 3;
    order.obstacles = Arc::new(vec![wall("fence", (6, 1), (6, 3))]);
    let (_, reported) = refused(order.clone());
    assert!(reported.contains("without `fence` there is a plan"), "{reported}");
    order.planner.expansions = 4;
    let (_, reported) = refused(order);
    assert!(reported.contains("no plan of the task was found then within 1 expansion per step"), "{reported}");
}

#[test]
fn a_part_that_stays_in_the_way_may_be_told_to_yield() {
    let mut order = order(droplets(9, 5), &[(1, 2), (5, 2)]);
    order.obstacles =
        Arc::new(vec![wall("low", (1, 1), (9, 1)), wall("left", (1, 3), (4, 5)), wall("right", (6, 3), (9, 5))]);
    order.steps = vec![together(vec![go(0, &[(9, 2)])])];
    let (code, reported) = refused(order);
    assert_eq!(code, Code::E0601);
    assert!(reported.contains("with `may_yield: true` there is a plan"), "{reported}");
}

#[test]
fn two_parts_that_cannot_pass_one_another_are_both_named() {
    let mut order = order(droplets(9, 1), &[(1, 1), (9, 1), (5, 1)]);
    order.steps = vec![together(vec![go(0, &[(9, 1)]), go(1, &[(1, 1)])])];
    order.bystanders = Bystanders::Yield;
    let (code, reported) = refused(order);
    assert_eq!(code, Code::E0601);
    assert!(reported.contains("cannot pass one another"), "{reported}");
}

#[test]
fn a_limit_on_the_steps_is_kept_or_the_least_that_would_do_is_said() {
    let task = |objective: ElectrodeArrayObjective, steps: f64| {
        let mut order = order(microparts(20, 20), &[(3, 3), (10, 3)]);
        order.objective = objective;
        order.steps = vec![together(vec![go(0, &[(10, 3)]), go(1, &[(3, 3)])])];
        job(order, vec![limit("steps", steps)])
    };
    for objective in [ElectrodeArrayObjective::Makespan, ElectrodeArrayObjective::SumOfCosts] {
        let (plan, reported) = planned(&task(objective, 100.0), &mut Standings::default());
        let least = plan.unwrap_or_else(|| panic!("{reported:?}")).outcomes["steps"];
        let (plan, reported) = planned(&task(objective, 5.0), &mut Standings::default());
        assert!(plan.is_none());
        assert_eq!(reported[0].0, Code::E0603, "{reported:?}");
        assert!(least >= 11.0, "two parts of four electrodes go round each other: {least}");
        if objective == ElectrodeArrayObjective::Makespan {
            assert!(reported[0].1.contains(&format!("raise the limit to {least}")), "{reported:?}");
        }
    }
}

#[test]
fn a_search_that_may_not_go_on_says_so_and_proves_nothing() {
    let mut order = order(droplets(9, 9), &[(1, 1), (9, 1), (1, 9), (9, 9), (5, 5)]);
    order.planner.expansions = 3;
    let swaps = [(0, (9, 9)), (3, (1, 1)), (1, (1, 9)), (2, (9, 1))];
    order.steps = vec![together(swaps.map(|(part, goal)| go(part, &[goal])).to_vec())];
    let (code, reported) = refused(order);
    assert_eq!(code, Code::E0602, "{reported}");
}

#[test]
fn the_published_planner_says_that_it_is_greedy_when_it_finds_nothing() {
    let mut order = order(microparts(20, 20), &[(3, 10), (16, 10)]);
    order.planner.method = ElectrodeArrayMethod::PlainCooperativeAstar;
    order.steps = vec![together(vec![go(0, &[(16, 10)]), go(1, &[(3, 10)])])];
    let (plan, reported) = planned(&job(order.clone(), Vec::new()), &mut Standings::default());
    match plan {
        Some(plan) => assert!(plan.cost >= plan.bound),
        None => assert!(reported.iter().all(|(code, _)| *code == Code::E0602), "{reported:?}"),
    }
    order.planner.method = ElectrodeArrayMethod::Portfolio;
    assert_eq!(found(order).proof, Optimality::Proven);
}

/// Whether a part at `i` and one at (2, 2) may make these moves simultaneously.
fn may(i: (u32, u32), one: char, other: char) -> bool {
    use super::board::{BoardGrid, Instance};
    let board = BoardGrid::new(20, 20);
    let moved = |(column, row): (u32, u32), way: char| match way {
        '>' => (column + 1, row),
        '<' => (column - 1, row),
        'v' => (column, row - 1),
        _ => (column, row + 1),
    };
    let cell = |(column, row): (u32, u32)| board.cell(column, row);
    let (from_i, to_i) = (cell(i), cell(moved(i, one)));
    let (from_j, to_j) = (cell((2, 2)), cell(moved((2, 2), other)));
    let instance = Instance { board: board.clone(), separation: 4, agents: Vec::new(), merges: Vec::new() };
    let pairs = [(from_i, from_j), (to_i, from_j), (from_i, to_j), (to_i, to_j)];
    pairs.into_iter().all(|(i, j)| !instance.too_near(0, i, 1, j))
}

#[test]
fn pairs_of_moves_are_safe_or_not_as_derived_by_hand() {
    let golden = [
        ((6, 2), '<', '>', false),
        ((8, 2), '<', '>', true),
        ((7, 2), '<', '<', true),
        ((6, 2), '<', '<', false),
        ((6, 2), '>', '<', true),
        ((6, 6), '<', '^', false),
        ((7, 3), '<', '^', true),
        ((6, 3), '<', 'v', false),
        ((5, 6), '<', 'v', true),
    ];
    for (i, one, other, expected) in golden {
        assert_eq!(may(i, one, other), expected, "{i:?} {one} and (2, 2) {other}");
    }
}

/// An operation with a choice among some cells.
fn stay(part: usize, cells: &[ElectrodeCell], steps: u64) -> AssayOperation {
    let stop = |cell: &ElectrodeCell| ElectrodeArrayStop { cell: *cell, span: span(7), origin: None };
    let places = cells.iter().map(|cell| OperationPlace { stop: stop(cell), zone: None });
    let among = if cells.len() > 1 { places.collect() } else { Vec::new() };
    let passing = AssayOperation::passing(part, cells.iter().take(1).map(stop).collect(), span(8));
    AssayOperation { among, stay_ns: steps * 5_000_000, ..passing }
}

/// A few droplets, and operations with a choice of places: droplets stay, are mixed, merge, come after others, and
/// leave.
fn chosen_at_random(random: &mut SplitMix64) -> (ElectrodeArrayOrder, Vec<AssayOperation>) {
    let cell = |random: &mut SplitMix64| ElectrodeCell::new(1 + random.below(5) as u32, 1 + random.below(4) as u32);
    let cells = |random: &mut SplitMix64| -> Vec<ElectrodeCell> {
        let mut cells: Vec<ElectrodeCell> = Vec::new();
        for _ in 0..1 + random.below(3) {
            let one = cell(random);
            if !cells.contains(&one) {
                cells.push(one);
            }
        }
        cells
    };
    let mut board = order(droplets(6, 5), &[(1, 1), (6, 5), (6, 1)][..2 + random.below(2)]);
    if random.below(2) == 0 {
        let at = (2 + random.below(3) as u32, 2 + random.below(3) as u32);
        board.obstacles = Arc::new(vec![wall("w", at, at)]);
    }
    let is_free = |at: &ElectrodeCell| {
        board.obstacles.iter().all(|obstacle| match obstacle.body {
            ElectrodeArrayObstacleBody::Electrodes { from, .. } => from != *at,
            ElectrodeArrayObstacleBody::Fixed(_) => true,
        })
    };
    let mut left: Vec<usize> = (0..board.parts.len()).collect();
    let mut operations: Vec<AssayOperation> = Vec::new();
    // Some or all of the droplets come from one reservoir.
    let outlet = board.parts[0].cell;
    for part in 0..random.below(board.parts.len() + 1) {
        Arc::make_mut(&mut board.parts)[part].cell = None;
        let dispensed = stay(part, outlet.as_slice(), 1 + random.below(4) as u64);
        operations.push(AssayOperation { comes: true, ..dispensed });
    }
    for _ in 0..2 + random.below(4) {
        let Some(part) = left.get(random.below(left.len().max(1))).copied() else { break };
        let places: Vec<ElectrodeCell> = cells(random).into_iter().filter(is_free).collect();
        if places.is_empty() {
            continue;
        }
        let one = stay(part, &places, random.below(9) as u64);
        let other = left.iter().copied().find(|other| *other != part);
        let after = (0..operations.len()).filter(|_| random.below(6) == 0).collect();
        operations.push(match (random.below(6), other) {
            (0, _) => AssayOperation { mixes: true, stay_ns: 5_000_000 * (1 + random.below(6) as u64), after, ..one },
            (1, Some(with)) => {
                left.retain(|part| *part != with);
                AssayOperation { with: Some(with), stay_ns: 0, ..one }
            }
            (2, _) => {
                left.retain(|left| *left != part);
                AssayOperation { leaves: true, stay_ns: 0, ..one }
            }
            _ => AssayOperation { after, ..one },
        });
    }
    (board, operations)
}

/// Bounds proven for all arrangements at once hold for the best of them, which is found by planning each. The proofs
/// for single arrangements are compared with brute force elsewhere.
#[test]
fn bounds_of_many_arrangements_hold_for_the_best_of_them() {
    let mut random = SplitMix64::new(3);
    let (mut compared, mut equal) = (0, 0);
    for _ in 0..24 {
        let (board, operations) = chosen_at_random(&mut random);
        if operations.iter().all(|operation| operation.among.is_empty()) {
            continue;
        }
        let ground = stage::BoardGround::new(&board);
        let cells: Vec<Option<ElectrodeCell>> = board.parts.iter().map(|part| part.cell).collect();
        let site = errands::AssaySite { order: &board, ground: &ground, cells: &cells };
        let budget = SearchBudget::of(200_000);
        for objective in [BoardObjective::Makespan, BoardObjective::SumOfCosts] {
            let solved =
                |most| places::arranged::solve_each(&site, &operations, objective, most, &mut Meter::new(budget));
            let (best, many) = match (solved(1_000), solved(1)) {
                (SearchAnswer::Found(best), SearchAnswer::Found(many)) => (best, many),
                (SearchAnswer::Found(_), SearchAnswer::Impossible(_)) => panic!("there is a plan: {operations:?}"),
                _ => continue,
            };
            let ends =
                |plan: &places::arranged::PlacedPlan| plan.courses.iter().map(|course| course.until() as u64 - 1).max();
            let sums = |plan: &places::arranged::PlacedPlan| -> u64 {
                plan.courses.iter().map(|course| course.last_arrival() as u64).sum()
            };
            let steps = ends(&best).unwrap_or(0);
            assert!(many.bounds.makespan <= steps, "{:?} of {steps}: {operations:?}", many.bounds);
            assert!(many.bounds.sum_of_costs <= sums(&best), "{:?}: {operations:?}", many.bounds);
            let is_proven = objective == BoardObjective::Makespan && best.bounds.makespan == steps;
            assert!(!is_proven || ends(&many) >= Some(steps), "{operations:?}");
            compared += 1;
            equal += usize::from(ends(&many) == Some(steps));
        }
    }
    assert!(compared > 15, "{compared}");
    assert!(equal * 4 > compared * 3, "{equal} of {compared} as good as the best");
}
