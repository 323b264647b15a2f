use super::oracle::{Chance, Shape, fault, least, random};
use super::*;
use crate::plan::electrode_array::board::{Agent, BoardCosts, BoardGrid, BoardObjective, Instance};
use crate::plan::electrode_array::exact::tables::ExactTables;
use crate::plan::search::SearchBudget;

fn meter() -> Meter {
    Meter::new(SearchBudget::of(20_000_000))
}

fn everyone(tables: &ExactTables) -> Vec<usize> {
    (0..tables.agents()).collect()
}

fn shapes() -> Vec<Shape> {
    let shape = |width, height, separation, agents, blocked_percent, vias, merges| Shape {
        width,
        height,
        separation,
        agents,
        blocked_percent,
        vias,
        merges,
    };
    vec![
        shape(4, 4, 1, 2, 25, 0, false),
        shape(3, 3, 1, 3, 20, 0, false),
        shape(4, 3, 1, 3, 30, 1, false),
        shape(5, 5, 2, 2, 25, 2, false),
        shape(5, 4, 2, 2, 20, 0, true),
        shape(4, 4, 2, 3, 10, 0, true),
        shape(5, 4, 2, 3, 5, 0, false),
        shape(6, 5, 3, 2, 10, 1, false),
        shape(6, 6, 4, 2, 5, 0, false),
        shape(9, 2, 4, 2, 0, 0, false),
    ]
}

#[test]
fn optima_and_impossibility_agree_with_plain_searches() {
    let mut chance = Chance(0x5eed);
    let (mut solved, mut impossible) = (0, 0);
    for shape in shapes() {
        for _ in 0..25 {
            let Some(instance) = random(shape, &mut chance) else { continue };
            let Ok(tables) = ExactTables::new(&instance) else {
                assert_eq!(least(&instance, BoardObjective::Makespan), None);
                continue;
            };
            let group = everyone(&tables);
            for objective in [BoardObjective::Makespan, BoardObjective::SumOfCosts] {
                let aim = match objective {
                    BoardObjective::Makespan => JointAim::Makespan { limit: None },
                    BoardObjective::SumOfCosts => JointAim::SumOfCosts { limit: None },
                };
                let found = search(&tables, &group, aim, &mut meter());
                let any = search(&tables, &group, JointAim::Any, &mut meter());
                match least(&instance, objective) {
                    Some(cost) => {
                        let JointAnswer::Found(paths) = &found else { panic!("{instance:?}: {found:?}") };
                        assert_eq!(fault(&instance, paths), None, "{instance:?}");
                        assert_eq!(BoardCosts::of(paths).key(objective).0, cost, "{instance:?} {objective:?}");
                        let JointAnswer::Found(paths) = &any else { panic!("{instance:?}: {any:?}") };
                        assert_eq!(fault(&instance, paths), None, "{instance:?}");
                        solved += 1;
                    }
                    None => {
                        assert_eq!(
                            (found, any),
                            (JointAnswer::Impossible(NoJointPlan::AtAll), JointAnswer::Impossible(NoJointPlan::AtAll)),
                            "{instance:?}"
                        );
                        impossible += 1;
                    }
                }
            }
        }
    }
    assert!(solved > 200 && impossible > 30, "{solved} solved, {impossible} impossible");
}

#[test]
fn a_limit_just_at_the_optimum_passes_and_one_below_does_not() {
    let mut chance = Chance(77);
    let mut compared = 0;
    for shape in shapes() {
        for _ in 0..10 {
            let Some(instance) = random(shape, &mut chance) else { continue };
            let Ok(tables) = ExactTables::new(&instance) else { continue };
            let Some(least) = least(&instance, BoardObjective::Makespan) else { continue };
            let group = everyone(&tables);
            for aim in [|limit| JointAim::Makespan { limit }, |limit| JointAim::SumOfCosts { limit }] {
                let at = search(&tables, &group, aim(Some(least as u32)), &mut meter());
                let JointAnswer::Found(paths) = at else { panic!("{instance:?}: {at:?}") };
                assert_eq!((fault(&instance, &paths), BoardCosts::of(&paths).makespan), (None, least));
                if least > 0 {
                    let below = search(&tables, &group, aim(Some(least as u32 - 1)), &mut meter());
                    assert_eq!(below, JointAnswer::Impossible(NoJointPlan::WithinLimit), "{instance:?}");
                }
                compared += 1;
            }
        }
    }
    assert!(compared > 50);
}

#[test]
fn a_budget_ends_the_search_with_a_bound() {
    let agents = vec![Agent { start: 0, stops: vec![99] }, Agent { start: 99, stops: vec![0] }];
    let instance = Instance { board: BoardGrid::new(10, 10), separation: 3, agents, merges: vec![] };
    let tables = ExactTables::new(&instance).ok().unwrap();
    let mut meter = Meter::new(SearchBudget::of(50));
    let outcome = search(&tables, &[0, 1], JointAim::SumOfCosts { limit: None }, &mut meter);
    assert_eq!(outcome, JointAnswer::GaveUp(36));
    assert_eq!(meter.spent(), 50);
}
