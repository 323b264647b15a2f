//! More decompositions of an orientation than are searched: the planner makes no claim that one of the others might
//! undercut.
//!
//! At most 48 decompositions of an orientation and 256 of a task are searched, in each case those that turn least. The
//! brute force considers all of them.

use super::brute::Brute;
use super::case::{Case, Step};
use super::mechanics::reported;
use super::support::build;

/// Greatest number of decompositions of a step that are searched.
const SEARCHED: usize = 48;

/// A hand with adhesion, steps of 60 deg and a precision of 60 deg: an orientation has more decompositions than are
/// searched.
fn case(steps: Vec<Step>) -> Case {
    Case {
        tip_radius_um: 12.0,
        steps_per_turn: 6,
        adhesion: true,
        friction: 0.5,
        removal_safety: 1.0,
        clearance_um: 0.0,
        gaiting_cost_deg: 240.0,
        pull_off_un: 1.5,
        max_force_un: 30.0,
        torsion_um: 0.0,
        reserve: 0.02,
        semi_um: [11.0, 9.0, 8.5],
        load_un: [0.0; 3],
        steps,
        precision_deg: 60,
        rolling_um_per_s: 50.0,
        approach_um_per_s: 20.0,
        retract_um: 2.0,
    }
}

/// An orientation between two grasps: a decomposition that needs less regrasping from one to the other is cheaper,
/// although it is not among those that turn least.
#[test]
fn a_plan_is_not_called_optimal_where_a_way_that_was_left_out_is_cheaper() {
    let ends = [[10, 4, 0], [2, 8, 0]].map(Step::Grasp);
    let case = case(vec![ends[0], Step::Orient([240, 60, 240]), ends[1]]);
    let mut brute = Brute::of(&case, 0.0);
    assert!(brute.count() > SEARCHED, "{} ways", brute.count());
    let text = case.text();
    let built = build(&text);
    assert_eq!(built.codes, Vec::<&str>::new(), "{text}");
    let plan = &built.schedules[0].schedule().plans[0];
    let (least_deg, _) = brute.least_deg(None).expect("there is a plan");
    assert!(least_deg < plan.cost - 1e-6, "a case in which the cap matters: {least_deg}, {}", plan.cost);
    assert!(!plan.optimal && plan.bound <= least_deg + 1e-6, "bound {} of at least {least_deg}", plan.bound);
}

/// If no grasp lasts, that is a proof only if all decompositions were searched.
#[test]
fn no_plan_is_proven_only_where_all_ways_were_searched() {
    let slippery = |precision_deg: u32| {
        let steps = vec![Step::Grasp([1, 7, 0]), Step::Orient([60, 120, 180])];
        let case = Case { adhesion: false, friction: 0.02, precision_deg, ..case(steps) };
        let count = Brute::of(&case, 0.0).count();
        (count, reported(&case.text()))
    };
    let (few, proven) = slippery(15);
    assert!(few <= SEARCHED && proven[0].contains("E0601"), "{few} ways: {proven:?}");
    let (many, open) = slippery(60);
    assert!(many > SEARCHED && open.len() == 1 && open[0].contains("E0602"), "{many} ways: {open:?}");
}
