//! Pulses against brute force, and tours of many places.

use super::oracle::{Oracle, Random};
use super::scenes::{scene, some_cell};
use crate::claims::dimibot::{DimibotMethod, DimibotObjective};
use crate::plan::dimibot::pulses::front;
use crate::plan::dimibot::tally::MotionTally;
use crate::plan::dimibot::tour::{TourCosts, ascent, improved};
use crate::plan::dimibot::*;
use crate::plan::search::{Meter, SearchBudget};
use crate::random::SplitMix64;

fn check_train(oracle: &Oracle<'_>, start: LatticeCell, goal: LatticeCell, train: &PulseTrain) {
    let mut at = start;
    for pulse in &train.pulses {
        let next = LatticeCell::new(at.x ^ pulse.left, at.y ^ pulse.right);
        assert!(next != at && oracle.free_pulse(at, next), "{at:?} {pulse:?}");
        at = next;
    }
    assert_eq!(at, goal);
}

#[test]
fn pulses_agree_with_brute_force() {
    let mut random = Random::new(21);
    let mut by_count = [0; 6];
    for round in 0..1200 {
        let (lattice, obstacles) = scene(&mut random, 3 + u32::from(round % 40 == 0), 3);
        let field = LatticeField::new(lattice, &obstacles).unwrap();
        let oracle = Oracle { lattice, obstacles: &obstacles };
        let (start, goal) = (some_cell(&mut random, &lattice), some_cell(&mut random, &lattice));
        let truth = oracle.pulses(start, goal);
        match pulses(&field, start, goal, SearchBudget::DEFAULT) {
            DimibotAnswer::Found(train) => {
                check_train(&oracle, start, goal, &train);
                assert_eq!((Some(train.pulses.len()), train.cost()), (truth, train.bound));
                by_count[train.pulses.len().min(5)] += 1;
            }
            DimibotAnswer::Impossible(_) => assert_eq!(truth, None, "{obstacles:?}"),
            DimibotAnswer::GaveUp(report) => panic!("{report:?}"),
        }
    }
    assert!(by_count[1] > 50 && by_count[2] > 50 && by_count[3] > 10, "{by_count:?}");
}

/// In a lattice too large for a table, trains are valid and keep their bound; more than nine in ten are proven optimal.
#[test]
fn the_search_by_length_is_honest() {
    let mut random = Random::new(22);
    let (mut proven, mut all) = (0, 0);
    for _ in 0..300 {
        let (lattice, obstacles) = scene(&mut random, 3, 3);
        let fine = Lattice::new([7, 7], [0.1, 0.1]).unwrap();
        let field = LatticeField::new(fine, &obstacles).unwrap();
        let oracle = Oracle { lattice: fine, obstacles: &obstacles };
        let (start, goal) = (some_cell(&mut random, &fine), some_cell(&mut random, &fine));
        let _ = lattice;
        let DimibotAnswer::Found(train) = pulses(&field, start, goal, SearchBudget::DEFAULT) else {
            continue;
        };
        check_train(&oracle, start, goal, &train);
        assert!(train.bound <= train.cost());
        all += 1;
        proven += usize::from(train.bound == train.cost());
    }
    assert!(all > 50 && proven * 10 > all * 9, "{proven} of {all}");
}

/// If no pulse can lead to the goal within a limit, only the pulses from the start are examined.
#[test]
fn pulses_beyond_a_limit_are_not_searched_on() {
    let lattice = Lattice::new([3, 3], [1.0, 1.0]).unwrap();
    let field = LatticeField::new(lattice, &[]).unwrap();
    let ends = [LatticeCell::new(0, 0), LatticeCell::new(7, 7)];
    let searched = |switches: u64| {
        let mut meter = Meter::new(SearchBudget::DEFAULT);
        let limits = MotionTally { switches, ..MotionTally::MAX };
        let found = front(&field, ends, limits, Vec::new(), &mut meter);
        (found.ways.len(), found.is_complete, meter.spent())
    };
    // All six modules differ, and the other 63 cells are one pulse away.
    assert_eq!(searched(5), (0, true, 63));
    let (ways, is_complete, spent) = searched(6);
    assert!(ways == 1 && is_complete && spent > 63, "{ways} ways, {spent} steps");
}

#[test]
fn many_places_get_a_tour_within_its_bound() {
    let mut random = Random::new(24);
    let lattice = Lattice::new([8, 8], [1.0, 1.0]).unwrap();
    for count in [13, 20, 60] {
        let obstacles: Vec<FieldObstacle> = (0..200)
            .map(|_| some_cell(&mut random, &lattice).pair())
            .map(|c| FieldObstacle::Cells { from: c, to: c })
            .collect();
        let field = LatticeField::new(lattice, &obstacles).unwrap();
        let mut free = || loop {
            let cell = some_cell(&mut random, &lattice);
            if field.legal(cell).is_some() {
                return cell;
            }
        };
        let start = free();
        let places: Vec<LatticeCell> = (0..count).map(|_| free()).collect();
        let then = free();
        for stages in
            [vec![RouteStage::All(places.clone())], vec![RouteStage::All(places.clone()), RouteStage::To(then)]]
        {
            for (objective, with_pulses) in [(DimibotObjective::Distance, false), (DimibotObjective::Time, true)] {
                let method = DimibotMethod::StagedAstar;
                let expansions = SearchBudget::DEFAULT.steps;
                let request = RouteRequest { field: &field, start, stages: &stages, method, with_pulses, expansions };
                let route = Router::new(request).best(objective).expect("a tour exists");
                check_route(&field, start, &stages, &route);
                let cost = route.tally.of_objective(objective);
                assert!(route.bound <= cost && cost * 3 <= route.bound * 4, "{cost} {}", route.bound);
            }
        }
    }
}

/// The cost of the best order of the places, by trying all of them.
fn best_order(table: &TourCosts, order: &mut Vec<usize>, rest: &mut Vec<usize>) -> u64 {
    if rest.is_empty() {
        return table.length(order);
    }
    let mut best = u64::MAX;
    for at in 0..rest.len() {
        order.push(rest.remove(at));
        best = best.min(best_order(table, order, rest));
        rest.insert(at, order.pop().unwrap());
    }
    best
}

/// The bound on tours is valid, and equals the best tour in most small instances.
#[test]
fn no_order_of_places_is_below_the_bound_on_tours() {
    let mut random = SplitMix64::new(25);
    let mut tight = 0;
    for round in 0..300 {
        let nodes = 2 + round % 5;
        let mut costs = vec![vec![0; nodes]; nodes];
        for (a, b) in (0..nodes).flat_map(|a| (0..a).map(move |b| (a, b))) {
            let cost = 1 + random.below(40) as u64;
            (costs[a][b], costs[b][a]) = (cost, cost);
        }
        let end = (round % 2 == 0 && nodes > 2).then_some(nodes - 1);
        let table = TourCosts { costs, end };
        let mut places: Vec<usize> = (1..nodes - usize::from(end.is_some())).collect();
        let best = best_order(&table, &mut Vec::new(), &mut places);
        let found = table.length(&improved(&table));
        let bound = ascent(&table, found);
        assert!(bound <= best && best <= found, "{bound} <= {best} <= {found}: {:?}", table.costs);
        tight += usize::from(bound == best);
    }
    assert!(tight > 150, "{tight} of 300");
}

/// Each stage visits all its cells, and each pulse is safe.
fn check_route(field: &LatticeField, start: LatticeCell, stages: &[RouteStage], route: &Route) {
    let mut at = start;
    for (stage, pulses) in stages.iter().zip(&route.pulses) {
        let mut seen = vec![at];
        for pulse in pulses {
            let next = LatticeCell::new(at.x ^ pulse.left, at.y ^ pulse.right);
            assert!(pulse_is_safe(field, at, next));
            at = next;
            seen.push(at);
        }
        match stage {
            RouteStage::To(cell) => assert_eq!(at, *cell),
            RouteStage::All(cells) => assert!(cells.iter().all(|cell| seen.contains(cell))),
        }
    }
}
