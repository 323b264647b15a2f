//! Pulses and tours against brute force.

use super::oracle::{Oracle, Random};
use super::scenes::{scene, some_cell};
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

fn orders(n: usize) -> Vec<Vec<usize>> {
    if n == 0 {
        return vec![vec![]];
    }
    let shorter = orders(n - 1);
    let insert = |order: &Vec<usize>| {
        let order = order.clone();
        (0..n).map(move |k| {
            let mut longer = order.clone();
            longer.insert(k, n - 1);
            longer
        })
    };
    shorter.iter().flat_map(insert).collect()
}

#[test]
fn tours_agree_with_all_orders() {
    let mut random = Random(23);
    let (mut found, mut shut) = (0, 0);
    for _ in 0..150 {
        let (lattice, obstacles) = scene(&mut random, 4, 1);
        let field = Field::new(lattice, &obstacles).unwrap();
        let oracle = Oracle { lattice, obstacles: &obstacles };
        let weights = Weights::distance(&lattice);
        let start = some_cell(&mut random, &lattice);
        let places: Vec<Cell> = (0..random.below(5)).map(|_| some_cell(&mut random, &lattice)).collect();
        let leg = |a: Cell, b: Cell| oracle.cost(a, b, |flip| weights.of(flip));
        let all = |order: &Vec<usize>| {
            let mut at = start;
            order.iter().try_fold(0, |sum, &k| {
                let cost = leg(at, places[k])?;
                at = places[k];
                Some(sum + cost)
            })
        };
        let truth =
            orders(places.len()).iter().map(all).collect::<Option<Vec<u64>>>().and_then(|c| c.into_iter().min());
        match tour(&field, start, &places, &Measure::Flips(weights.clone()), Budget::DEFAULT) {
            TourOutcome::Found(tour) => {
                assert_eq!((Some(tour.cost), tour.bound), (truth, tour.cost));
                check_tour(start, &places, &tour, &weights);
                found += 1;
            }
            TourOutcome::Impossible { place, .. } => {
                assert_eq!(leg(start, places[place]), None);
                shut += 1;
            }
            TourOutcome::GaveUp(report) => panic!("{report:?}"),
        }
    }
    assert!(found > 60 && shut > 10, "{found} {shut}");
}

fn check_tour(start: Cell, places: &[Cell], tour: &Tour, weights: &Weights) {
    let mut sorted = tour.order.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, (0..places.len()).collect::<Vec<_>>());
    let (mut at, mut cost) = (start, 0);
    for (place, leg) in tour.order.iter().zip(&tour.legs) {
        let Leg::Flips(flips) = leg else { panic!("flips were asked for") };
        for flip in flips {
            at = at.after(*flip);
            cost += weights.of(*flip);
        }
        assert_eq!(at, places[*place]);
    }
    assert_eq!(cost, tour.cost);
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
        for measure in [Measure::Flips(Weights::distance(&lattice)), Measure::Pulses] {
            let TourOutcome::Found(tour) = tour(&field, start, &places, &measure, Budget::DEFAULT) else {
                panic!("a tour exists")
            };
            assert!(tour.bound <= tour.cost && tour.cost * 3 <= tour.bound * 4, "{} {}", tour.cost, tour.bound);
            if let Measure::Flips(weights) = &measure {
                check_tour(start, &places, &tour, weights);
            }
        }
    }
}
