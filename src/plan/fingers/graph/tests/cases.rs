//! Single cases: proofs, limits, ties, long turns, and the paper's path leg by leg.

use super::oracle::{dijkstra, judge};
use super::random::{case, circle};
use crate::plan::fingers::graph::layout::{GraspChain, MAX_ANGLES, NodeSpot, Sets};
use crate::plan::fingers::graph::strands::{AngleMask, below, has, single, spread};
use crate::plan::fingers::graph::{
    Estimator, FarthestRoute, Grasp, GraspAnswer, GraspCosts, GraspRequest, GraspSearchEnd, GraspSearchLimits, Regrasp,
    Start, TurnLeg, decompose, solve,
};
use crate::plan::fingers::tables::Tables;
use crate::plan::search::SearchBudget;
use crate::random::support::Random;
use std::sync::Arc;

const BOTH: [Estimator; 2] = [Estimator::Published, Estimator::Layers];

fn grasp(list: &[u32]) -> Grasp {
    Grasp::of(list).expect("few fingers")
}

fn leg(tables: Tables, steps: i32, end: Option<&[u32]>) -> TurnLeg {
    let (lowest, highest) = (steps.min(0), steps.max(0));
    TurnLeg { tables: Arc::new(tables), steps, lowest, highest, entry: Regrasp::Same, end: end.map(grasp), lazy: None }
}

fn request(start: Start, routes: Vec<Vec<TurnLeg>>) -> GraspRequest {
    GraspRequest {
        fingers: 3,
        start,
        routes,
        costs: GraspCosts { roll: 20, gait: 180 },
        limits: GraspSearchLimits::default(),
    }
}

#[test]
fn a_way_that_no_finger_may_leave_is_none() {
    let mut tables = circle(12, 2);
    let all = 12 * 12 * 12;
    (0..all).for_each(|at| tables.layers[0].leave.take(at));
    let start = Start::At(grasp(&[1, 7, 0]));
    let asked = request(start, vec![vec![leg(tables, 3, Some(&[1, 7, 0]))]]);
    for estimator in BOTH {
        // Two fingers roll to the end, but the only grasp there is a different one.
        let expected = FarthestRoute { route: 0, leg: 0, farthest: Some(3), ends: 1, is_known: true };
        assert_eq!(solve(&asked, estimator, SearchBudget::DEFAULT), GraspAnswer::Impossible(expected));
    }
}

#[test]
fn a_start_that_does_not_hold_has_no_way() {
    let close = Start::At(grasp(&[1, 2, 0]));
    let alone = Start::At(grasp(&[1, 0, 0]));
    let outside = Start::At(grasp(&[1, 13, 0]));
    for start in [close, alone, outside] {
        let asked = request(start, vec![vec![leg(circle(12, 2), 3, None)]]);
        let GraspAnswer::Impossible(blocked) = solve(&asked, Estimator::Layers, SearchBudget::DEFAULT) else {
            panic!("{start:?} does not hold")
        };
        assert_eq!(blocked.farthest, None);
    }
}

#[test]
fn rolling_that_ends_half_way_is_told() {
    let mut tables = circle(12, 6);
    // Only opposite contacts hold, and they do not roll from 3 and 9 (counted from 0).
    tables.layers[0].roll_pair.take(3 * 12 + 9);
    tables.layers[0].roll_pair.take(9 * 12 + 3);
    let asked = request(Start::At(grasp(&[6, 12, 0])), vec![vec![leg(tables, 5, None)]]);
    for estimator in BOTH {
        let GraspAnswer::Impossible(blocked) = solve(&asked, estimator, SearchBudget::DEFAULT) else {
            panic!("there is no way")
        };
        assert_eq!(blocked.farthest, Some(2));
        assert!(blocked.ends > 0);
    }
}

#[test]
fn the_cheaper_route_is_found_and_of_equal_ones_the_first() {
    let start = Start::At(grasp(&[1, 7, 0]));
    let of = |steps: i32| vec![leg(circle(12, 2), steps, None)];
    let found =
        |routes: Vec<Vec<TurnLeg>>| match solve(&request(start, routes), Estimator::Layers, SearchBudget::DEFAULT) {
            GraspAnswer::Found(way) => (way.route, way.cost),
            other => panic!("{other:?}"),
        };
    assert_eq!(found(vec![of(5), of(3), of(-3), of(4)]), (1, 120));
    assert_eq!(found(vec![of(5), Vec::new()]), (1, 0));
}

#[test]
fn a_budget_ends_a_search_with_a_bound() {
    let asked = request(Start::At(grasp(&[1, 38, 0])), vec![vec![leg(circle(74, 6), 11, Some(&[38, 1, 0]))]]);
    let GraspAnswer::GaveUp(GraspSearchEnd::Expansions(report)) = solve(&asked, Estimator::Layers, SearchBudget::of(3))
    else {
        panic!("three nodes are few")
    };
    assert_eq!(report.spent, 3);
    assert!((440..=1880).contains(&report.bound));
}

#[test]
fn too_many_nodes_are_refused() {
    let tables = Tables { contacts: 600, layers: circle(4, 1).layers };
    let asked = request(Start::Any, vec![vec![leg(tables, 1, None)]]);
    assert!(matches!(
        solve(&asked, Estimator::Layers, SearchBudget::DEFAULT),
        GraspAnswer::GaveUp(GraspSearchEnd::TooLarge { .. })
    ));
}

/// More angles than a word has bits; contacts wrap around several times.
#[test]
fn long_turns_agree_with_the_plain_search() {
    for (steps, beyond, goal) in
        [(100, 0, [4, 0, 1]), (-130, 40, [1, 7, 0]), (360, 0, [5, 2, 9]), (360, 100, [3, 8, 0]), (-1, 360, [2, 7, 12])]
    {
        let leg = leg(circle(12, 2), steps, Some(&goal));
        let leg = TurnLeg { lowest: leg.lowest - beyond, highest: leg.highest + beyond, ..leg };
        let asked = request(Start::At(grasp(&[1, 7, 0])), vec![vec![leg]]);
        let cost = dijkstra(&asked, &asked.routes[0]).0.map(|(cost, _)| cost);
        for estimator in BOTH {
            let GraspAnswer::Found(way) = solve(&asked, estimator, SearchBudget::DEFAULT) else {
                panic!("there is a way")
            };
            assert_eq!(Some(way.cost), cost);
            judge(&asked, &way);
        }
    }
}

/// Leg by leg is never cheaper than all legs jointly, its bound holds for both, and sometimes it is more expensive.
#[test]
fn greedy_ways_are_ways() {
    let (mut ways, mut dearer) = (0, 0);
    for seed in 1000..1200 {
        let asked = case(seed);
        let GraspAnswer::Found(greedy) = decompose(&asked, Estimator::Published, SearchBudget::DEFAULT) else {
            continue;
        };
        judge(&asked, &greedy);
        let GraspAnswer::Found(joint) = solve(&asked, Estimator::Layers, SearchBudget::DEFAULT) else {
            panic!("case {seed}: a way was found leg by leg")
        };
        assert!(greedy.bound <= joint.cost && joint.cost <= greedy.cost, "case {seed}");
        ways += 1;
        dearer += usize::from(greedy.cost > joint.cost);
    }
    assert!(ways > 50 && dearer > 0, "{ways} ways, {dearer} of them dearer");
}

fn spreads_like_steps<const N: usize>(random: &mut Random) {
    for _ in 0..300 {
        let angles = 1 + random.index(64 * N);
        let word = |random: &mut Random| {
            if random.chance(30) { random.next() & random.next() } else { random.next() | random.next() }
        };
        let rolls: AngleMask<N> = below(std::array::from_fn(|_| word(random)), angles - 1);
        let mut seeds: AngleMask<N> = single(random.index(angles));
        if random.chance(50) {
            seeds[0] |= below::<N>([random.next() & random.next(); N], angles)[0];
        }
        let mut slow = seeds;
        loop {
            let before = slow;
            for angle in (1..angles).filter(|angle| has(&rolls, angle - 1)) {
                if has(&slow, angle) || has(&slow, angle - 1) {
                    for at in [angle, angle - 1] {
                        slow[at / 64] |= 1 << (at % 64);
                    }
                }
            }
            if slow == before {
                break;
            }
        }
        assert_eq!(spread(seeds, rolls), slow, "{angles} angles, {seeds:x?}, {rolls:x?}");
    }
}

#[test]
fn masks_spread_like_single_steps() {
    let random = &mut Random::new(11);
    spreads_like_steps::<1>(random);
    spreads_like_steps::<2>(random);
    spreads_like_steps::<8>(random);
    spreads_like_steps::<17>(random);
}

#[test]
fn names_of_nodes_come_back() {
    let random = &mut Random::new(5);
    for fingers in 3..=6 {
        let sets = Sets::of(fingers);
        for _ in 0..200 {
            let contacts = 2 + random.index(510);
            let number = random.index(sets.chains(contacts) as usize);
            let chain: GraspChain = sets.chain(contacts, number);
            assert_eq!(sets.index(contacts, chain), number);
            let spot = NodeSpot { leg: random.index(1 << 16), angle: random.index(MAX_ANGLES), chain };
            assert_eq!(NodeSpot::unpack(spot.pack()), spot);
        }
    }
}
