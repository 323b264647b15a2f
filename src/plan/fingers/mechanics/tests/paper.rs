//! The paper's own cases, found by the search over these tables.

use super::*;
use crate::plan::fingers::graph::{
    Estimator, Grasp, GraspAnswer, GraspCosts, GraspRequest, GraspSearchLimits, Regrasp, Start, TurnLeg, solve,
};
use crate::plan::search::SearchBudget;
use std::sync::Arc;

/// The six grasps of three fingers that hold I and J, in the order of Table 3.
const SIX: [[u32; 3]; 6] = [[1, 0, 38], [0, 1, 38], [38, 0, 1], [38, 1, 0], [0, 38, 1], [1, 38, 0]];

/// An ellipse that fits c = 74 as well as the paper's, a little slimmer than the one that fits its Table 2.
const SLIM: [f64; 2] = [17.0, 10.632];

fn tables_of(facts: &FingersFacts, semi_um: [f64; 2]) -> Arc<Tables> {
    Arc::new(tabulated(facts, &ellipse(semi_um, 74), Load::NONE, 19))
}

/// Cost in degrees and reconfigurations of a turn from a grasp to one of others; `None` without a path.
fn turned(tables: &Arc<Tables>, steps: i32, from: [u32; 3], goals: &[Option<Grasp>]) -> Option<(u64, usize)> {
    let leg = |goal: &Option<Grasp>| TurnLeg {
        tables: Arc::clone(tables),
        steps,
        lowest: 0,
        highest: 18,
        entry: Regrasp::Same,
        end: *goal,
        lazy: None,
    };
    let request = GraspRequest {
        fingers: 3,
        start: Start::At(Grasp::of(&from).expect("a grasp")),
        routes: goals.iter().map(|goal| vec![leg(goal)]).collect(),
        costs: GraspCosts { roll: 20, gait: 180 },
        limits: GraspSearchLimits::default(),
    };
    match solve(&request, Estimator::Layers, SearchBudget::DEFAULT) {
        GraspAnswer::Found(way) => {
            let changes = way.legs[0].windows(2).filter(|two| two[0].grasp.holding() != two[1].grasp.holding());
            Some((way.cost, changes.count()))
        }
        GraspAnswer::Impossible(_) => None,
        GraspAnswer::GaveUp(_) => {
            panic!("a graph of this size is searched to its end")
        }
    }
}

/// Table 3: 220 deg from [1 38 0] to each of the six.
fn second_rotation(semi_um: [f64; 2], removal_safety: f64) -> [(u64, usize); 6] {
    let tables = tables_of(&FingersFacts { removal_safety, ..hand(0.3, Adhesion::Sticking) }, semi_um);
    SIX.map(|goal| turned(&tables, 11, [1, 38, 0], &[Grasp::of(&goal)]).expect("a way"))
}

/// The published costs are 2240, 2240, 2240, 1880, 2240, 2600: 10, 10, 10, 8, 10 and 12 reconfigurations. By mirror symmetry the
/// second and third, and the first and fifth, cost the same on any ellipse.
#[test]
fn the_second_rotation_costs_more_the_safer_removal_is() {
    let found = |removal_safety: f64| second_rotation(PAPER, removal_safety);
    let literal = [(1160, 4), (1160, 4), (1160, 4), (1520, 6), (1160, 4), (1520, 6)];
    assert_eq!(found(1.0), literal, "two removals are exactly in balance");
    assert_eq!(found(1.1), [(1520, 6), (1160, 4), (1160, 4), (1520, 6), (1520, 6), (1520, 6)]);
    assert_eq!(found(1.5), [(1880, 8), (1520, 6), (1520, 6), (1520, 6), (1880, 8), (1880, 8)]);
    assert_eq!(found(1.8), [(2240, 10), (1880, 8), (1880, 8), (2040, 8), (2240, 10), (2240, 10)]);
    assert_eq!(found(1.85), [(2240, 10), (1880, 8), (1880, 8), (2240, 10), (2240, 10), (2240, 10)]);
    assert_eq!(found(2.0), [(2240, 10), (2040, 8), (2040, 8), (2240, 10), (2240, 10), (2240, 10)]);
}

#[test]
fn a_slimmer_ellipse_has_the_papers_reconfigurations_but_for_the_last() {
    let found = second_rotation(SLIM, 1.88);
    assert_eq!(found, [(2240, 10), (2240, 10), (2240, 10), (1960, 8), (2240, 10), (2240, 10)]);
}

/// Table 4: 0, 8 and 0 reconfigurations with adhesion, and no path without it at friction 0.3.
#[test]
fn the_spatial_rotation_needs_adhesion() {
    for (semi_um, ways_without) in [(PAPER, [true, false, true]), (SLIM, [false; 3])] {
        let with = tables_of(&hand(0.3, Adhesion::Sticking), semi_um);
        let without = tables_of(&hand(0.3, Adhesion::Absent), semi_um);
        let six = SIX.map(|goal| Grasp::of(&goal));
        let turns = [(4, [5, 42, 0], six.as_slice()), (11, [1, 38, 0], &six), (5, [1, 38, 0], &[None])];
        let reconfigurations = turns.map(|(steps, from, goals)| turned(&with, steps, from, goals).map(|way| way.1));
        assert_eq!(reconfigurations, [Some(0), Some(8), Some(0)]);
        let found = turns.map(|(steps, from, goals)| turned(&without, steps, from, goals).is_some());
        assert_eq!(found, ways_without, "{semi_um:?}");
    }
}

/// Without adhesion, more friction makes the turn possible.
#[test]
fn more_friction_opens_the_second_rotation() {
    let six = SIX.map(|goal| Grasp::of(&goal));
    let without = |friction: f64| tables_of(&hand(friction, Adhesion::Absent), PAPER);
    let ways = [0.35, 0.4, 0.5].map(|friction| turned(&without(friction), 11, [1, 38, 0], &six));
    assert_eq!(ways, [None, Some((2280, 8)), Some((1960, 8))]);
}
