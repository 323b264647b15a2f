//! Tests the fixes that messages suggest.

use super::*;

/// Follows the advice to remove some obstacles or let parts yield; returns whether there was any.
pub(super) fn remedied(task: &Task, reported: &str) -> bool {
    let (plan, none) = ("there is a plan", "the task has no plan either");
    // One of several reports says whether the task has a plan then.
    let Some(told) = reported.lines().find(|line| line.contains(plan) || line.contains(none)) else { return false };
    let is_plan = told.contains(plan);
    let (_, help) = told.split_once("; ").expect("a report has a help");
    let named: Vec<&str> = help.split('`').skip(1).step_by(2).collect();
    let obstacle = |index: usize| named.contains(&format!("o{index}").as_str());
    let kept = task.obstacles.iter().enumerate().filter(|(index, _)| !obstacle(*index));
    let obstacles = kept.map(|(_, obstacle)| *obstacle).collect();
    let has_part = named.iter().any(|name| name.contains(" at (") || *name == "may_yield: true");
    let may_yield = task.may_yield || has_part;
    let changed = Task { obstacles, may_yield, ..task.clone() };
    if is_plan {
        assert!(matches!(answered(&changed.text()), Answered::Plan(_)), "{reported}\n{}", changed.text());
    } else {
        assert!(changed.all().is_empty(), "{reported}\n{}", changed.text());
    }
    true
}

/// Follows the advice to raise a limit.
pub(super) fn advice(task: &Task, reported: &str) {
    let [(outcome, "<=", _)] = task.limits.as_slice() else { return };
    let Some((_, advice)) = reported.split_once("raise the limit to ") else { return };
    let number: String = advice.chars().take_while(|c| c.is_ascii_digit()).collect();
    if *outcome == "time" {
        return;
    }
    let limit = number.parse().expect("a number");
    let raised = Task { limits: vec![(*outcome, "<=", limit)], ..task.clone() };
    assert!(matches!(answered(&raised.text()), Answered::Plan(_)), "{reported}\n{}", raised.text());
}
