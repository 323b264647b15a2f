//! Programs in `tests/found` that once got a wrong answer.

use super::support::found;
use super::{answer, answers};

#[test]
fn the_order_of_a_visit_looks_at_what_comes_after() {
    let plans = answers(&found("dimibot_visit_then_move")).expect("all three tasks have a plan");
    assert_eq!(plans.len(), 3);
    for plan in plans {
        assert!((plan.cost - 17.0767).abs() < 1e-3 && plan.optimal && plan.bound == plan.cost, "{plan:?}");
    }
}

#[test]
fn two_limits_are_kept_where_a_plan_keeps_them() {
    let text = found("dimibot_limits_not_searched");
    for objective in ["distance", "switches", "time", "energy"] {
        let plan = answer(&text.replace("minimize time", &format!("minimize {objective}")));
        let plan = plan.unwrap_or_else(|reported| panic!("{objective}: {reported:?}"));
        assert_eq!(plan.outcomes["switches"], 7.0);
        assert!((plan.outcomes["distance_um"] - 18.784).abs() < 1e-2 && plan.optimal, "{plan:?}");
    }
}

#[test]
fn of_the_plans_with_the_fewest_switches_the_shortest_is_taken() {
    for objective in ["switches", "time", "energy"] {
        let text = found("dimibot_ties_broken_badly").replace("minimize switches", &format!("minimize {objective}"));
        let plan = answer(&text).unwrap_or_else(|reported| panic!("{objective}: {reported:?}"));
        assert_eq!(plan.outcomes["switches"], 7.0);
        assert!((plan.outcomes["distance_um"] - 23.054).abs() < 1e-2 && plan.optimal, "{plan:?}");
    }
}

#[test]
fn the_blame_for_a_way_that_is_shut_has_its_own_budget() {
    let reported = answer(&found("dimibot_slow_no_plan")).expect_err("there is no way");
    assert_eq!(reported.len(), 1);
    assert_eq!(reported[0].code.name(), "E0601");
    // The budget is used up before the smallest set is known, and the report says so.
    assert!(reported[0].help.as_ref().is_some_and(|help| help.contains("were not found")), "{reported:?}");
}
