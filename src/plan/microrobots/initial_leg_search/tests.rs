use super::super::assembly::{self, AssemblyTerms, CYCLES};
use super::super::world::fixture::{bed, dock, pose, robot};
use super::*;
use crate::plan::search::{Meter, SearchBudget};

/// Two robots are docked, and two join them one after the other. Their phases are known, so on an empty bed the
/// estimate is the number of strokes of the plan, unless a path is led round something, or runs straight at first.
#[test]
fn estimates_with_known_phases_are_met() {
    let docks = [dock(1, pose(-125.0, 155.0, -90.0)), dock(0, pose(125.0, -155.0, 90.0))];
    let mut random = SplitMix64::new(3);
    let (mut planned, mut met) = (0, 0);
    for _ in 0..40 {
        let place = |side: f64, random: &mut SplitMix64| {
            pose(side * (1_200.0 + 800.0 * random.unit()), 1_500.0 * random.signed_unit(), 180.0 * random.signed_unit())
        };
        let (first, second) = (place(1.0, &mut random), place(-1.0, &mut random));
        let order = bed(
            vec![
                (robot("D1", 150.0, 0.015), first),
                (robot("D2", 156.0, 0.0148), second),
                (robot("D3", 160.0, 0.015), pose(125.0, 0.0, 180.0)),
                (robot("D4", 165.0, 0.015), pose(-125.0, 0.0, 0.0)),
            ],
            Vec::new(),
        );
        let world = CollisionWorld::new(&order);
        let poses: Vec<Pose> = order.robots.iter().map(|placed| placed.pose).collect();
        let start = BedPoses::new(poses.clone(), vec![false, false, true, true]);
        let estimate = AssemblyEstimate::new(&order, &world, &start, &docks).expect("two robots are left");
        let terms = AssemblyTerms { fine: CYCLES, most_stages: assembly::MAX_PLANS };
        let mut meter = Meter::new(SearchBudget::of(order.expansions));
        let found = assembly::assemble(&order, &poses, &start.docked, None, &docks, &mut meter, terms);
        let Ok(found) = found else { continue };
        planned += 1;
        let strokes: u64 = found.legs.iter().map(|leg| leg.strokes).sum();
        met += usize::from((estimate.strokes(&poses) / strokes as f64 - 1.0).abs() < 0.01);
    }
    assert!(planned >= 30 && met * 5 >= planned * 2, "{met} of {planned} estimates are met");
}
