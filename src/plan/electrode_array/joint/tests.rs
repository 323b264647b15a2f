use super::super::board::{Agent, Board, Costs, Instance, Objective};
use super::super::exact::field::Field;
use super::oracle::{Chance, Shape, fault, least, random};
use super::*;
use crate::plan::search::Budget;

fn meter() -> Meter {
    Meter::new(Budget::of(20_000_000))
}

fn everyone(field: &Field) -> Vec<usize> {
    (0..field.agents()).collect()
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
            let Ok(field) = Field::new(&instance) else {
                assert_eq!(least(&instance, Objective::Makespan), None);
                continue;
            };
            let group = everyone(&field);
            for objective in [Objective::Makespan, Objective::SumOfCosts] {
                let aim = match objective {
                    Objective::Makespan => Aim::Makespan { limit: None },
                    Objective::SumOfCosts => Aim::SumOfCosts { limit: None },
                };
                let found = search(&field, &group, aim, &mut meter());
                let any = search(&field, &group, Aim::Any, &mut meter());
                match least(&instance, objective) {
                    Some(cost) => {
                        let Outcome::Found(paths) = &found else { panic!("{instance:?}: {found:?}") };
                        assert_eq!(fault(&instance, paths), None, "{instance:?}");
                        assert_eq!(Costs::of(paths).key(objective).0, cost, "{instance:?} {objective:?}");
                        let Outcome::Found(paths) = &any else { panic!("{instance:?}: {any:?}") };
                        assert_eq!(fault(&instance, paths), None, "{instance:?}");
                        solved += 1;
                    }
                    None => {
                        assert_eq!((found, any), (Outcome::Impossible, Outcome::Impossible), "{instance:?}");
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
            let Ok(field) = Field::new(&instance) else { continue };
            let Some(least) = least(&instance, Objective::Makespan) else { continue };
            let group = everyone(&field);
            for aim in [|limit| Aim::Makespan { limit }, |limit| Aim::SumOfCosts { limit }] {
                let at = search(&field, &group, aim(Some(least as u32)), &mut meter());
                let Outcome::Found(paths) = at else { panic!("{instance:?}: {at:?}") };
                assert_eq!((fault(&instance, &paths), Costs::of(&paths).makespan), (None, least));
                if least > 0 {
                    let below = search(&field, &group, aim(Some(least as u32 - 1)), &mut meter());
                    assert_eq!(below, Outcome::NotWithin, "{instance:?}");
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
    let instance = Instance { board: Board::new(10, 10), separation: 3, agents, merges: vec![] };
    let field = Field::new(&instance).ok().unwrap();
    let mut meter = Meter::new(Budget::of(50));
    let outcome = search(&field, &[0, 1], Aim::SumOfCosts { limit: None }, &mut meter);
    assert_eq!(outcome, Outcome::GaveUp { bound: 36 });
    assert_eq!(meter.spent(), 50);
}
