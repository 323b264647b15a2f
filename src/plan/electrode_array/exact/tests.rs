use super::super::joint::oracle::{Chance, Shape, fault, least, random};
use super::*;

fn meter() -> Meter {
    Meter::new(Budget::of(20_000_000))
}

fn shape(size: (u32, u32), separation: u32, agents: usize, blocked_percent: u64, vias: u64, merges: bool) -> Shape {
    Shape { width: size.0, height: size.1, separation, agents, blocked_percent, vias, merges }
}

fn tiny() -> Vec<Shape> {
    vec![
        shape((4, 4), 1, 2, 25, 0, false),
        shape((3, 3), 1, 3, 15, 1, false),
        shape((4, 3), 1, 3, 25, 0, false),
        shape((5, 5), 2, 2, 25, 2, false),
        shape((5, 4), 2, 3, 5, 0, false),
        shape((5, 4), 2, 2, 20, 0, true),
        shape((4, 4), 2, 3, 10, 0, true),
        shape((6, 5), 3, 2, 10, 1, false),
        shape((7, 6), 4, 2, 5, 0, false),
    ]
}

/// The groups' search against the plain searches, on instances small enough for them.
#[test]
fn conflict_based_search_agrees_with_plain_searches() {
    let mut chance = Chance(0xc0ffee);
    let mut compared = 0;
    for shape in tiny() {
        for round in 0..60 {
            let Some(instance) = random(shape, &mut chance) else { continue };
            let Ok(field) = Field::new(&instance) else { continue };
            let Some(makespan) = least(&instance, Objective::Makespan) else { continue };
            let sum = least(&instance, Objective::SumOfCosts).unwrap();
            let wanted = Wanted { least: 0, most: ALWAYS, ceiling: u64::MAX };
            let found = groups::search(&field, wanted, &mut meter());
            let End::Found { mut paths, cost } = found else { panic!("{round} {instance:?}: {found:?} for {sum}") };
            paths.iter_mut().for_each(trim);
            assert_eq!(fault(&instance, &paths), None, "{instance:?}");
            assert_eq!((cost, Costs::of(&paths).sum_of_costs), (sum, sum), "{instance:?}");
            let at = groups::search(&field, exactly(makespan as u32), &mut meter());
            let End::Found { mut paths, .. } = at else { panic!("{instance:?}: {at:?} at {makespan}") };
            paths.iter_mut().for_each(trim);
            assert_eq!(fault(&instance, &paths), None, "{instance:?}");
            if makespan > 0 {
                assert_eq!(
                    groups::search(&field, exactly(makespan as u32 - 1), &mut meter()),
                    End::Nothing,
                    "{instance:?}"
                );
            }
            compared += 1;
        }
    }
    assert!(compared > 200, "{compared}");
}
