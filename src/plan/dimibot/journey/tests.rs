//! The last stage is rarely reached; these tests run it on problems that the first stages have solved.

use super::*;
use crate::plan::dimibot::tests::oracle::Random;
use crate::plan::dimibot::{FieldObstacle, Lattice, LatticeCell, LatticeField, shortest};

fn last_stage_alone(field: &LatticeField, ends: [LatticeCell; 2], weights: &SwitchWeights) -> Option<u64> {
    let mut work = field.work();
    let (mut reader, space) = work.open(field);
    let coarse = Blocks::new(&mut reader, COARSE);
    let ends = ends.map(LatticeCell::pair);
    if !coarse.connected(coarse.block(ends[0]), coarse.block(ends[1])) {
        return None;
    }
    let mut journey = LatticeJourney::new(reader, weights, ends, SearchBudget::DEFAULT);
    space.flood.begin(journey.reader.modules(), ends[1]);
    space.to_goal.find(&coarse, coarse.block(ends[1]), weights);
    match journey.last_stage(&coarse, space) {
        Some(Decided::Path) => {
            let flips = space.lists.path();
            Some(flips.iter().map(|flip| weights.of(*flip)).sum())
        }
        Some(Decided::No(_)) => None,
        None => panic!("the budget is ample: {}", journey.meter.spent()),
    }
}

#[test]
fn the_last_stage_agrees_with_the_first_ones() {
    let mut random = Random::new(31);
    let lattice = Lattice::new([12, 11], [1.0, 2.0]).unwrap();
    let (mut detours, mut shut) = (0, 0);
    for crowd in [4, 8, 12, 12, 24] {
        let mut cell = || LatticeCell::new(random.below(1 << 12), random.below(1 << 11));
        let obstacles: Vec<FieldObstacle> =
            (0..crowd << 11).map(|_| cell().pair()).map(|c| FieldObstacle::Cells { from: c, to: c }).collect();
        let field = LatticeField::new(lattice, &obstacles).unwrap();
        for round in 0..6 {
            let ends = [cell(), cell()];
            if ends.iter().any(|end| field.legal(*end).is_none()) {
                continue;
            }
            let weights = match round % 2 {
                0 => SwitchWeights::distance(&lattice),
                _ => SwitchWeights::switches(&lattice),
            };
            let first = match shortest(&field, ends[0], ends[1], &weights, SearchBudget::DEFAULT) {
                DimibotAnswer::Found(path) if path.cost == path.bound => Some(path.cost),
                DimibotAnswer::Impossible(_) => None,
                other => panic!("{other:?}"),
            };
            assert_eq!(last_stage_alone(&field, ends, &weights), first, "{crowd} {ends:?}");
            match first {
                Some(cost) => detours += usize::from(cost > weights.between(ends[0], ends[1])),
                None => shut += 1,
            }
        }
    }
    assert!(detours > 3 && shut > 0, "{detours} {shut}");
}
