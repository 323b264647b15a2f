//! Pulses against brute force, and tours of many places.

use super::oracle::{Oracle, Random};
use super::scenes::{scene, some_cell};
use crate::claims::dimibot::{Method, Objective};
use crate::plan::dimibot::*;
use crate::plan::search::Budget;

fn check_train(oracle: &Oracle<'_>, start: Cell, goal: Cell, train: &Train) {
    let mut at = start;
    for pulse in &train.pulses {
        let next = Cell::new(at.x ^ pulse.left, at.y ^ pulse.right);
        assert!(next != at && oracle.free_pulse(at, next), "{at:?} {pulse:?}");
        at = next;
    }
    assert_eq!(at, goal);
}

#[test]
fn pulses_agree_with_brute_force() {
    let mut random = Random(21);
    let mut by_count = [0; 6];
    for round in 0..1200 {
        let (lattice, obstacles) = scene(&mut random, 3 + u32::from(round % 40 == 0), 3);
        let field = Field::new(lattice, &obstacles).unwrap();
        let oracle = Oracle { lattice, obstacles: &obstacles };
        let (start, goal) = (some_cell(&mut random, &lattice), some_cell(&mut random, &lattice));
        let truth = oracle.pulses(start, goal);
        match pulses(&field, start, goal, Budget::DEFAULT) {
            Outcome::Found(train) => {
                check_train(&oracle, start, goal, &train);
                assert_eq!((Some(train.pulses.len()), train.cost()), (truth, train.bound));
                by_count[train.pulses.len().min(5)] += 1;
            }
            Outcome::Impossible(_) => assert_eq!(truth, None, "{obstacles:?}"),
            Outcome::GaveUp(report) => panic!("{report:?}"),
        }
    }
    assert!(by_count[1] > 50 && by_count[2] > 50 && by_count[3] > 10, "{by_count:?}");
}

/// The search by length is exact too; a lattice twice as fine with the same shapes and even cells cannot need more pulses than the coarse one.
#[test]
fn the_search_by_length_is_honest() {
    let mut random = Random(22);
    let (mut proven, mut all) = (0, 0);
    for _ in 0..300 {
        let (lattice, obstacles) = scene(&mut random, 3, 3);
        let fine = Lattice::new([7, 7], [0.1, 0.1]).unwrap();
        let field = Field::new(fine, &obstacles).unwrap();
        let oracle = Oracle { lattice: fine, obstacles: &obstacles };
        let (start, goal) = (some_cell(&mut random, &fine), some_cell(&mut random, &fine));
        let _ = lattice;
        let Outcome::Found(train) = pulses(&field, start, goal, Budget::DEFAULT) else {
            continue;
        };
        check_train(&oracle, start, goal, &train);
        assert!(train.bound <= train.cost());
        all += 1;
        proven += usize::from(train.bound == train.cost());
    }
    assert!(all > 50 && proven * 10 > all * 9, "{proven} of {all}");
}

#[test]
fn many_places_get_a_tour_within_its_bound() {
    let mut random = Random(24);
    let lattice = Lattice::new([8, 8], [1.0, 1.0]).unwrap();
    for count in [13, 20, 60] {
        let obstacles: Vec<Obstacle> = (0..200)
            .map(|_| some_cell(&mut random, &lattice).pair())
            .map(|c| Obstacle::Cells { from: c, to: c })
            .collect();
        let field = Field::new(lattice, &obstacles).unwrap();
        let mut free = || loop {
            let cell = some_cell(&mut random, &lattice);
            if field.legal(cell).is_some() {
                return cell;
            }
        };
        let start = free();
        let places: Vec<Cell> = (0..count).map(|_| free()).collect();
        let then = free();
        for stages in [vec![Stage::All(places.clone())], vec![Stage::All(places.clone()), Stage::To(then)]] {
            for (objective, with_pulses) in [(Objective::Distance, false), (Objective::Time, true)] {
                let method = Method::StagedAstar;
                let expansions = Budget::DEFAULT.steps;
                let request = Request { field: &field, start, stages: &stages, method, with_pulses, expansions };
                let route = Router::new(request).best(objective).expect("a tour exists");
                check_route(&field, start, &stages, &route);
                let cost = route.tally.of_objective(objective);
                assert!(route.bound <= cost && cost * 3 <= route.bound * 4, "{cost} {}", route.bound);
            }
        }
    }
}

/// Each stage comes to all its cells, and each pulse is safe.
fn check_route(field: &Field, start: Cell, stages: &[Stage], route: &Route) {
    let mut at = start;
    for (stage, pulses) in stages.iter().zip(&route.pulses) {
        let mut seen = vec![at];
        for pulse in pulses {
            let next = Cell::new(at.x ^ pulse.left, at.y ^ pulse.right);
            assert!(pulse_is_safe(field, at, next));
            at = next;
            seen.push(at);
        }
        match stage {
            Stage::To(cell) => assert_eq!(at, *cell),
            Stage::All(cells) => assert!(cells.iter().all(|cell| seen.contains(cell))),
        }
    }
}
