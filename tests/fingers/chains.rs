//! Consecutive tasks: claims about the second task hold for every grasp that the first could have left.
//!
//! As one task, the same turns are searched together, so that plan is optimal over both.

use super::case::{Case, Step};
use super::oracle::{Kind, planned, random_case};
use super::random::{Random, cases};
use super::support::build;

/// The program with its first step as one task and the others as the next.
fn in_two_tasks(case: &Case) -> String {
    let text = case.text();
    let (before, task) = text.split_once("task flip on hand in cell {\n").expect("it has a task");
    let body = task.trim_end().strip_suffix('}').expect("its end");
    let (steps, settings): (Vec<&str>, Vec<&str>) = body.lines().partition(|line| line.starts_with("  rotate"));
    let [first, rest @ ..] = steps.as_slice() else { panic!("no turn in {text}") };
    let of = |steps: &[&str]| settings.iter().chain(steps).map(|line| format!("{line}\n")).collect::<String>();
    format!(
        "{before}task one on hand in cell {{\n{}}}\ntask two on hand in cell {{\n{}}}\nprogram flip {{ run one, run two }}\n",
        of(&[first]),
        of(rest)
    )
}

#[test]
fn claims_of_a_later_task_hold_for_every_grasp_at_its_beginning() {
    let [mut compared, mut open, mut dearer] = [0; 3];
    for seed in 0..cases(90) {
        let mut chance = Random::new(31_337 + 7919 * seed);
        let kind = [Kind::Sticking, Kind::Pushing, Kind::Loaded][chance.below(3) as usize];
        let case = random_case(&mut chance, kind);
        let turn = |chance: &mut Random| {
            let steps = 1 + chance.below(case.steps_per_turn as u32) as i32;
            Step::Turn(chance.below(2) == 0, if chance.below(2) == 0 { steps } else { -steps })
        };
        let case = Case { steps: vec![turn(&mut chance), turn(&mut chance)], ..case };
        let whole = build(&case.text());
        let Some(joined) = planned(&whole) else { continue };
        let text = in_two_tasks(&case);
        let split = build(&text);
        assert!(!split.refused, "the judge refuses it: {:?}\n{text}", split.codes);
        assert!(!split.codes.contains(&"E0601"), "{:?}, but one task has a plan\n{text}", split.codes);
        compared += 1;
        let Some(schedule) = split.schedules.first() else {
            open += 1;
            continue;
        };
        let plans = &schedule.schedule().plans;
        let [cost, bound] =
            [plans.iter().map(|plan| plan.cost).sum::<f64>(), plans.iter().map(|plan| plan.bound).sum()];
        assert!(bound <= joined.cost_deg + 1e-6, "{bound} deg is no bound of {} deg\n{text}", joined.cost_deg);
        assert!(
            !joined.optimal || cost >= joined.cost_deg - 1e-6,
            "{cost} deg is below {} deg\n{text}",
            joined.cost_deg
        );
        if plans.iter().all(|plan| plan.optimal) {
            assert!(
                cost <= joined.cost_deg + 1e-6,
                "{cost} deg is called optimal, not {} deg\n{text}",
                joined.cost_deg
            );
        } else {
            dearer += 1;
        }
    }
    // Otherwise the test would have shown nothing.
    assert!(compared > 20 && open > 0 && dearer > 0, "{compared}, {open}, {dearer}");
}
