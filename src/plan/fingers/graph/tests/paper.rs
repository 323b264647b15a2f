//! The paper's tables, as corrected: classes of fingers by the effort to bring them to the goal.

use super::oracle::judge;
use super::random::circle;
use crate::plan::fingers::graph::layout::Sets;
use crate::plan::fingers::graph::published::reconfigurations;
use crate::plan::fingers::graph::{
    Estimator, Grasp, GraspAnswer, GraspCosts, GraspPath, GraspRequest, GraspSearchLimits, Regrasp, Start, TurnLeg,
    solve,
};
use crate::plan::search::SearchBudget;
use std::collections::{HashMap, VecDeque};
use std::sync::Arc;

const CONTACTS: usize = 74;

/// The chain of a grasp and its angle index, as the paper writes them; three fingers.
fn chain(sets: &Sets, grasp: [u32; 3], angle: u32) -> (u8, [u16; 3]) {
    let fingers: Vec<usize> = (0..3).filter(|finger| grasp[*finger] != 0).collect();
    let mut phases = [0; 3];
    for (phase, finger) in phases.iter_mut().zip(&fingers) {
        *phase = ((grasp[*finger] - 1 + angle) as usize % CONTACTS) as u16;
    }
    (sets.find(&fingers).expect("two or three hold"), phases)
}

fn estimate(now: [u32; 3], now_angle: u32, goal: [u32; 3], goal_angle: u32) -> u32 {
    let sets = Sets::of(3);
    reconfigurations(&sets, chain(&sets, now, now_angle), chain(&sets, goal, goal_angle))
}

/// The rows of `fingers_table1_reconfigurations.csv`, with the paper's examples.
#[test]
fn the_published_table() {
    let goal = [1, 38, 0];
    let rows = [
        ([11, 63, 0], 6),
        ([11, 63, 25], 5),
        ([0, 63, 25], 4),
        ([11, 0, 25], 4),
        ([5, 63, 0], 4),
        ([5, 63, 25], 3),
        ([5, 0, 25], 2),
        ([5, 42, 25], 1),
        ([5, 42, 0], 0),
        ([6, 43, 0], 6),
    ];
    for (grasp, count) in rows {
        assert_eq!(estimate(grasp, 1, goal, 5), count, "{grasp:?}");
    }
}

/// The rows that the paper lacks.
#[test]
fn three_finger_goals() {
    let goal = [1, 38, 20];
    let rows = [
        ([5, 42, 24], 0),
        ([5, 42, 0], 1),
        ([5, 42, 11], 2),
        ([5, 11, 0], 3),
        ([5, 11, 60], 4),
        ([11, 12, 0], 5),
        ([11, 12, 13], 6),
    ];
    for (grasp, count) in rows {
        assert_eq!(estimate(grasp, 1, goal, 5), count, "{grasp:?}");
    }
}

/// 66 + 10 and 1 + 1 are the same contact modulo 74: the printed formula would say otherwise.
#[test]
fn contacts_are_compared_modulo_their_number() {
    assert_eq!(estimate([66, 29, 0], 10, [38, 1, 0], 12), 6);
    assert_eq!(estimate([66, 29, 0], 10, [1, 38, 0], 1), 0);
    assert_eq!(estimate([66, 0, 7], 10, [1, 0, 16], 1), 0);
}

/// The closed form is the exact optimum of the relaxed problem in which any placement and removal is allowed.
#[test]
fn the_closed_form_is_the_relaxed_optimum() {
    for fingers in [3, 4, 5, 6] {
        let sets = Sets::of(fingers);
        for goal in 0..sets.len() as u8 {
            for (state, least) in relaxed(fingers, &sets, goal) {
                let members: Vec<usize> = (0..fingers).filter(|finger| state[*finger] != 0).collect();
                let mut phases = [0; 3];
                phases.iter_mut().zip(&members).for_each(|(phase, finger)| *phase = u16::from(state[*finger]));
                let now = (sets.find(&members).expect("two or three hold"), phases);
                assert_eq!(
                    reconfigurations(&sets, now, (goal, [1; 3])),
                    least,
                    "{fingers} fingers, {state:?} to {goal}"
                );
            }
        }
    }
}

/// For each state (of each finger: free, as at the goal, elsewhere), the least number of operations to the goal.
fn relaxed(fingers: usize, sets: &Sets, goal: u8) -> HashMap<Vec<u8>, u32> {
    let end: Vec<u8> = (0..fingers).map(|finger| u8::from(sets.members(goal).contains(&finger))).collect();
    let mut known = HashMap::from([(end.clone(), 0)]);
    let mut open = VecDeque::from([end]);
    while let Some(state) = open.pop_front() {
        for finger in 0..fingers {
            for value in 0..3 {
                let mut other = state.clone();
                other[finger] = value;
                let holding = other.iter().filter(|value| **value != 0).count();
                // An operation changes a finger from free to holding, or back.
                if (state[finger] == 0) == (value == 0) || !(2..=3).contains(&holding) || known.contains_key(&other) {
                    continue;
                }
                known.insert(other.clone(), known[&state] + 1);
                open.push_back(other);
            }
        }
    }
    known
}

fn found(start: [u32; 3], steps: i32, end: [u32; 3], estimator: Estimator) -> GraspPath {
    let grasp = |list: [u32; 3]| Grasp::of(&list).expect("three fingers");
    let tables = Arc::new(circle(CONTACTS, 1));
    let leg =
        TurnLeg { tables, steps, lowest: 0, highest: 18, entry: Regrasp::Same, end: Some(grasp(end)), lazy: None };
    let costs = GraspCosts { roll: 20, gait: 180 };
    let request = GraspRequest {
        fingers: 3,
        start: Start::At(grasp(start)),
        routes: vec![vec![leg]],
        costs,
        limits: GraspSearchLimits::default(),
    };
    match solve(&request, estimator, SearchBudget::DEFAULT) {
        GraspAnswer::Found(way) => {
            judge(&request, &way);
            way
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn rolling_is_enough_for_the_first_rotation() {
    for estimator in [Estimator::Published, Estimator::Layers] {
        let way = found([5, 42, 0], 4, [1, 38, 0], estimator);
        assert_eq!((way.cost, way.legs[0].len()), (160, 5));
    }
}

/// Where every grasp and removal is allowed, six reconfigurations suffice for the paper's fourth permutation.
#[test]
fn the_relaxed_second_rotation() {
    for estimator in [Estimator::Published, Estimator::Layers] {
        let way = found([1, 38, 0], 11, [38, 1, 0], estimator);
        assert_eq!(way.cost, 1520);
    }
}
