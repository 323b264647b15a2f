use super::oracle::{Oracle, Random};
use crate::geometry::{Pose, Shape};
use crate::plan::dimibot::published::*;
use crate::plan::dimibot::*;
use crate::plan::search::SearchBudget;

/// A random lattice with up to `most` modules a side, and obstacles of all shapes; from empty to fully blocked.
pub fn scene(random: &mut Random, most: u32, crowd: u32) -> (Lattice, Vec<FieldObstacle>) {
    let modules = [1 + random.below(most), 1 + random.below(most)];
    let lattice = Lattice::of_strokes(modules, 0.138, 35.0).unwrap();
    let cells = 1 << (modules[0] + modules[1]);
    let count = random.below(2 + cells * crowd / 12).min(60);
    let obstacles = (0..count).map(|_| obstacle(random, &lattice)).collect();
    (lattice, obstacles)
}

fn obstacle(random: &mut Random, lattice: &Lattice) -> FieldObstacle {
    let last = [lattice.last(Side::Left), lattice.last(Side::Right)];
    if random.below(2) == 0 {
        let from = last.map(|n| random.below(n + 2));
        let to = from.map(|v| v + random.below(6) / 5);
        return FieldObstacle::Cells { from, to };
    }
    let pitch = lattice.pitch_um[0].min(lattice.pitch_um[1]);
    let size = |random: &mut Random| random.unit() * pitch * 2.0;
    let shape = match random.below(5) {
        0 => Shape::Point,
        1 => Shape::Disc { radius_um: size(random) },
        2 => Shape::Box { size_um: [size(random), size(random)] },
        3 => Shape::Capsule { length_um: size(random), radius_um: 0.3 * size(random) },
        _ => horseshoe(random, 2.0 * pitch),
    };
    let pose =
        Pose { x_um: random.unit() * 14.0 - 1.0, y_um: random.unit() * 14.0 - 1.0, heading_rad: random.unit() * 7.0 };
    FieldObstacle::Physical { shape, pose, growth_um: random.unit() * 0.5 * pitch }
}

fn horseshoe(random: &mut Random, size: f64) -> Shape {
    let t = 0.05 + 0.3 * random.unit();
    let outline = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [1.0 - t, 1.0], [1.0 - t, t], [t, t], [t, 1.0], [0.0, 1.0]];
    Shape::Polygon { points_um: outline.map(|p| p.map(|v| v * size)).to_vec() }
}

pub fn some_cell(random: &mut Random, lattice: &Lattice) -> LatticeCell {
    LatticeCell::new(random.below(1 << lattice.modules[0]), random.below(1 << lattice.modules[1]))
}

fn cost_of(outcome: &DimibotAnswer<FlipPath>) -> Option<u64> {
    match outcome {
        DimibotAnswer::Found(path) => Some(path.cost),
        DimibotAnswer::Impossible(_) => None,
        DimibotAnswer::GaveUp(gave_up) => panic!("{gave_up:?}"),
    }
}

fn check_path(
    oracle: &Oracle<'_>,
    start: LatticeCell,
    goal: LatticeCell,
    weights: &SwitchWeights,
    outcome: &DimibotAnswer<FlipPath>,
) {
    let DimibotAnswer::Found(path) = outcome else {
        return;
    };
    let mut at = start;
    for flip in &path.flips {
        assert!(oracle.free(at, at.after(*flip)), "{at:?} {flip:?}");
        at = at.after(*flip);
    }
    assert_eq!(at, goal);
    assert_eq!(path.flips.iter().map(|f| weights.of(*f)).sum::<u64>(), path.cost);
    assert_eq!(path.cost, path.bound);
}

#[test]
fn costs_agree_with_brute_force_in_random_scenes() {
    let mut random = Random::new(1);
    let (mut found, mut detours, mut closed) = (0, 0, 0);
    for round in 0..1500 {
        let (lattice, obstacles) = scene(&mut random, if round % 25 == 0 { 5 } else { 4 }, 2);
        let field = LatticeField::new(lattice, &obstacles).unwrap();
        let oracle = Oracle { lattice, obstacles: &obstacles };
        let (start, goal) = (some_cell(&mut random, &lattice), some_cell(&mut random, &lattice));
        for weights in [SwitchWeights::distance(&lattice), SwitchWeights::switches(&lattice)] {
            let truth = oracle.cost(start, goal, |flip| weights.of(flip));
            for search in [shortest, dijkstra, bidirectional_dijkstra, astar, hypercube_astar] {
                let outcome = search(&field, start, goal, &weights, SearchBudget::DEFAULT);
                assert_eq!(cost_of(&outcome), truth, "round {round}: {lattice:?} {obstacles:?} {start:?} {goal:?}");
                check_path(&oracle, start, goal, &weights, &outcome);
            }
            match truth {
                Some(cost) if cost > weights.between(start, goal) => detours += 1,
                Some(_) => found += 1,
                None => closed += 1,
            }
        }
    }
    assert!(found > 500 && detours > 100 && closed > 300, "{found} {detours} {closed}");
}

#[test]
fn a_larger_lattice_agrees_with_dijkstra_and_hashing_changes_nothing() {
    let mut random = Random::new(5);
    for modules in [[7, 7], [6, 8], [11, 10], [14, 8]] {
        let lattice = Lattice::new(modules, [1.0, 1.0]).unwrap();
        for round in 0..3 {
            let density = [6, 14, 24][round % 3];
            let mut cells = || some_cell(&mut random, &lattice).pair();
            let obstacles: Vec<FieldObstacle> = (0..density << modules[0].min(modules[1]))
                .map(|_| cells())
                .map(|c| FieldObstacle::Cells { from: c, to: c })
                .collect();
            let field = LatticeField::new(lattice, &obstacles).unwrap();
            let (start, goal) = (some_cell(&mut random, &lattice), some_cell(&mut random, &lattice));
            for weights in [SwitchWeights::distance(&lattice), SwitchWeights::switches(&lattice)] {
                let mine = shortest(&field, start, goal, &weights, SearchBudget::DEFAULT);
                let theirs = bidirectional_dijkstra(&field, start, goal, &weights, SearchBudget::of(30_000));
                if let DimibotAnswer::GaveUp(gave_up) = theirs {
                    assert!(cost_of(&mine).is_none_or(|cost| cost >= gave_up.bound));
                    continue;
                }
                assert_eq!(cost_of(&mine), cost_of(&theirs), "{modules:?} {round}");
            }
        }
    }
}

#[test]
fn a_small_budget_gives_an_honest_bound() {
    let lattice = Lattice::new([8, 8], [1.0, 1.0]).unwrap();
    let mut random = Random::new(9);
    let mut gave_up = 0;
    for _ in 0..200 {
        let obstacles: Vec<FieldObstacle> = (0..12 << 8)
            .map(|_| some_cell(&mut random, &lattice).pair())
            .map(|c| FieldObstacle::Cells { from: c, to: c })
            .collect();
        let field = LatticeField::new(lattice, &obstacles).unwrap();
        let (start, goal) = (some_cell(&mut random, &lattice), some_cell(&mut random, &lattice));
        let weights = SwitchWeights::distance(&lattice);
        let DimibotAnswer::Found(best) = shortest(&field, start, goal, &weights, SearchBudget::DEFAULT) else {
            continue;
        };
        match shortest(&field, start, goal, &weights, SearchBudget::of(best.expanded / 2)) {
            DimibotAnswer::Found(path) => assert!(path.bound <= best.cost && best.cost <= path.cost),
            DimibotAnswer::GaveUp(report) => {
                assert!(report.bound <= best.cost && report.spent <= best.expanded / 2 + 200, "{report:?} {best:?}");
                gave_up += 1;
            }
            DimibotAnswer::Impossible(proof) => panic!("{proof:?}"),
        }
    }
    assert!(gave_up > 20, "{gave_up}");
}

#[test]
fn the_blame_opens_a_path_and_nothing_smaller_does() {
    let mut random = Random::new(3);
    let (mut by_size, mut smallest) = ([0; 4], 0);
    for _ in 0..1500 {
        let (lattice, obstacles) = scene(&mut random, 3, 8);
        let field = LatticeField::new(lattice, &obstacles).unwrap();
        let (start, goal) = (some_cell(&mut random, &lattice), some_cell(&mut random, &lattice));
        let without = |removed: &[usize]| {
            let kept = obstacles.iter().enumerate().filter(|(k, _)| !removed.contains(k));
            let obstacles: Vec<FieldObstacle> = kept.map(|(_, o)| o.clone()).collect();
            let oracle = Oracle { lattice, obstacles: &obstacles };
            oracle.cost(start, goal, |_| 1).is_some()
        };
        let Some(found) = blame(&field, &obstacles, start, goal, SearchBudget::DEFAULT) else {
            assert!(without(&[]));
            continue;
        };
        assert!(!without(&[]) && without(&found.obstacles), "{found:?}");
        for skip in &found.obstacles {
            let fewer: Vec<usize> = found.obstacles.iter().copied().filter(|k| k != skip).collect();
            assert!(!without(&fewer), "{found:?} does not need {skip}");
        }
        let single = (0..obstacles.len()).any(|k| without(&[k]));
        assert_eq!(single, found.obstacles.len() == 1);
        by_size[found.obstacles.len().min(4) - 1] += 1;
        smallest += usize::from(found.opening == Opening::Smallest);
    }
    assert!(by_size[0] > 100 && by_size[1] > 50 && by_size[2] > 5, "{by_size:?} {smallest}");
}
