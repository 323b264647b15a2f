//! Random hands against all possible grasps: effort, reconfigurations, limits on both, optimality, and the proof that
//! there is no plan.

use super::brute::Brute;
use super::case::{Case, Step};
use super::mechanics::reported;
use super::random::Random;
use super::support::{Built, build};
use std::ops::Range;

/// Tolerance in both directions where a balance is exact, because rounding may decide whether a grasp holds.
const SLACK: f64 = 1e-6;

/// Kinds of cases.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Turns by tips that only push.
    Pushing,
    /// Turns by tips that stick.
    Sticking,
    /// Turns under a load.
    Loaded,
    /// Grasps, translations and releases between turns.
    Verbs,
    /// An orientation, with a turn before or after it.
    Oriented,
}

pub fn random_case(chance: &mut Random, kind: Kind) -> Case {
    let steps_per_turn = [6, 8, 9][chance.below(3) as usize];
    let long_um = chance.thousandths(9.0, 14.0);
    let round_um = |chance: &mut Random| (long_um * chance.thousandths(0.55, 1.0) * 1000.0).round() / 1000.0;
    let size_un = chance.thousandths(0.01, 4.0);
    let part_un = |chance: &mut Random| (size_un * chance.thousandths(-1.0, 1.0) * 1e4).round() / 1e4;
    let is_loaded = kind == Kind::Loaded;
    let load_un = if is_loaded { [0, 1, 2].map(|_| part_un(chance)) } else { [0.0; 3] };
    let steps = random_steps(chance, kind, steps_per_turn);
    let adhesion = match kind {
        Kind::Pushing => false,
        Kind::Sticking => true,
        Kind::Loaded | Kind::Verbs | Kind::Oriented => chance.below(3) != 0,
    };
    Case {
        tip_radius_um: chance.thousandths(9.0, 12.0),
        steps_per_turn: steps_per_turn as i32,
        adhesion,
        friction: chance.thousandths(0.15, 0.7),
        removal_safety: chance.thousandths(0.5, 6.0),
        clearance_um: chance.thousandths(0.0, 0.2),
        gaiting_cost_deg: f64::from(30 * (1 + chance.below(8))),
        pull_off_un: 1.5,
        max_force_un: [5.0, 30.0][chance.below(2) as usize],
        torsion_um: [0.0, 0.01, 0.5, 2.0][chance.below(4) as usize],
        reserve: [0.0, 0.02, 0.1][chance.below(3) as usize],
        semi_um: [long_um, round_um(chance), round_um(chance)],
        load_un,
        steps,
        precision_deg: if kind == Kind::Oriented { [12, 20, 35, 60][chance.below(4) as usize] } else { 30 },
        rolling_um_per_s: chance.thousandths(5.0, 100.0),
        approach_um_per_s: chance.thousandths(2.0, 60.0),
        retract_um: chance.thousandths(0.5, 4.0),
    }
}

fn random_steps(chance: &mut Random, kind: Kind, steps_per_turn: u32) -> Vec<Step> {
    let turn = |chance: &mut Random| {
        let steps = 1 + chance.below(steps_per_turn) as i32;
        Step::Turn(chance.below(2) == 0, if chance.below(2) == 0 { steps } else { -steps })
    };
    let grasp = |chance: &mut Random| {
        let mut contacts = [1 + chance.below(4), 5 + chance.below(6), [0, 0, 11][chance.below(3) as usize]];
        contacts.rotate_left(chance.below(3) as usize);
        Step::Grasp(contacts)
    };
    let mut steps = Vec::new();
    match kind {
        Kind::Pushing | Kind::Sticking | Kind::Loaded => {
            if chance.below(4) == 0 {
                steps.push(grasp(chance));
            }
            let turns = 1 + if kind == Kind::Loaded { chance.below(2) } else { chance.below(3) };
            steps.extend((0..turns).map(|_| turn(chance)));
        }
        Kind::Verbs => {
            steps.push(turn(chance));
            for _ in 0..1 + chance.below(4) {
                steps.push(match chance.below(5) {
                    0 if !steps.contains(&Step::Release) => Step::Release,
                    1 => grasp(chance),
                    2 if steps.last() != Some(&Step::Release) => Step::Translate,
                    _ => turn(chance),
                });
            }
        }
        Kind::Oriented => {
            let degrees = |chance: &mut Random| (360 / steps_per_turn * chance.below(steps_per_turn)) as i32;
            let angles = [0, 1, 2].map(|_| degrees(chance));
            if chance.below(3) == 0 {
                steps.push(turn(chance));
            }
            steps.push(Step::Orient(angles));
            if chance.below(3) == 0 {
                steps.push(turn(chance));
            }
        }
    }
    steps
}

/// Counts of outcomes.
#[derive(Debug, Default)]
struct Tally {
    planned: u32,
    proven_none: u32,
    limited: u32,
    limits_proven_too_low: u32,
    /// Compared with the quickest sequence of grasps.
    timed: u32,
    /// Not searched exhaustively: bounds are compared with the least cost, and nothing is reported as proven.
    open: u32,
    /// Agrees only within the slack.
    marginal: u32,
    /// Refused by the check.
    skipped: u32,
}

/// Cost and bound in degrees, reconfigurations, and whether it is reported as optimal.
#[derive(Debug, Clone, Copy)]
pub struct Planned {
    pub cost_deg: f64,
    bound_deg: f64,
    pub gaits: u32,
    pub optimal: bool,
    time_s: f64,
}

pub fn planned(built: &Built) -> Option<Planned> {
    let plan = &built.schedules.first()?.schedule().plans[0];
    let gaits = plan.outcomes["reconfigurations"] as u32;
    let time_s = plan.outcomes["time_ns"] / 1e9;
    Some(Planned { cost_deg: plan.cost, bound_deg: plan.bound, gaits, optimal: plan.optimal, time_s })
}

/// Result over all grasps: the least effort and its reconfigurations, within a limit on these.
type Least = Option<(f64, u32)>;

/// Whether a plan agrees with the result over all grasps.
fn is_that(planned: Option<Planned>, least: Least) -> bool {
    match (planned, least) {
        (Some(plan), Some((deg, gaits))) => {
            let is_bound = plan.bound_deg <= deg + 1e-6;
            let is_least = (plan.cost_deg - deg).abs() < 1e-6 && plan.gaits == gaits;
            is_bound && (is_least || !plan.optimal && plan.cost_deg >= deg - 1e-6)
        }
        (None, None) => true,
        (Some(_), None) | (None, Some(_)) => false,
    }
}

/// Compares a plan, or the proof that there is none, with the result over all grasps; returns whether they agree
/// without slack.
pub fn agrees(case: &Case, planned: Option<Planned>, most: Option<u32>, text: &str) -> bool {
    let least = |slack: f64| Brute::of(case, slack).least_deg(most);
    if is_that(planned, least(0.0)) {
        return true;
    }
    let [loose, tight] = [least(SLACK), least(-SLACK)];
    let within = |plan: Planned| {
        loose.is_some_and(|(least, _)| least <= plan.cost_deg + 1e-6)
            && tight.is_none_or(|(least, _)| plan.bound_deg <= least + 1e-6)
            && (!plan.optimal || tight.is_none_or(|(least, _)| plan.cost_deg <= least + 1e-6))
    };
    let is_within = planned.map_or(tight.is_none(), within) && loose != tight;
    assert!(is_within, "planned {planned:?}, at least {loose:?}, at most {tight:?}, of at most {most:?}\n{text}");
    false
}

fn hold(case: &Case, kind: Kind, tally: &mut Tally) {
    let text = case.text();
    let built = build(&text);
    assert!(!built.refused, "the judge refuses it: {:?}\n{text}", built.codes);
    let found = match built.codes.as_slice() {
        [] => planned(&built),
        ["E0601"] => None,
        // The search was cut off, or no finger can leave a grasp; nothing is claimed.
        ["E0602"] => {
            tally.open += 1;
            return;
        }
        codes => {
            // Tips that touch, a turn that is not a whole number of steps, nothing held, or no decomposition of an
            // orientation.
            let known = ["E0543", "E0544", "E0545", "E0546", "E0547", "E0548", "E0549", "E0550"];
            assert!(codes.iter().all(|code| known.contains(code)), "{codes:?}\n{text}");
            tally.skipped += 1;
            return;
        }
    };
    match found {
        Some(_) => tally.planned += 1,
        None => tally.proven_none += 1,
    }
    let agrees = agrees(case, found, None, &text);
    tally.marginal += u32::from(!agrees);
    let Some(plan) = found else { return };
    if !plan.optimal {
        // Under a load after an orientation, or with too many decompositions.
        assert!(kind == Kind::Oriented || kind == Kind::Loaded, "{plan:?}\n{text}");
        tally.open += 1;
        return;
    }
    if agrees {
        limited(case, plan, &text, tally);
    }
}

fn with_limits(text: &str, limits: &str) -> String {
    text.replacen("{\n  precision", &format!("{{\n{limits}  precision"), 1)
}

/// With ever fewer reconfigurations than the cheapest plan has, there is a plan of greater effort or none. With less
/// effort than a plan has, there is none with as few reconfigurations.
fn limited(case: &Case, plan: Planned, text: &str, tally: &mut Tally) {
    let mut best = plan;
    timed(case, plan, text, tally);
    let soonest_s = time_bound_s(text);
    loop {
        assert!(best.time_s >= soonest_s, "{best:?}, but none is said to take less than {soonest_s} s\n{text}");
        let effort = with_limits(
            text,
            &format!("  require effort < {} deg\n  require reconfigurations <= {}\n", best.cost_deg, best.gaits),
        );
        let reported = reported(&effort);
        let is_proven = reported.len() == 1 && reported[0].contains("E0603") && reported[0].contains("proven");
        assert!(is_proven, "{reported:?}\n{effort}");
        tally.limits_proven_too_low += 1;
        let Some(fewer) = best.gaits.checked_sub(1) else { return };
        let limit = with_limits(text, &format!("  require reconfigurations <= {fewer}\n"));
        let built = build(&limit);
        assert!(!built.refused, "{limit}");
        let found = planned(&built);
        tally.marginal += u32::from(!agrees(case, found, Some(fewer), &limit));
        match found {
            Some(plan) => {
                assert!(plan.optimal && plan.gaits <= fewer, "{plan:?}\n{limit}");
                tally.limited += 1;
                best = plan;
            }
            None => {
                least_is_said(case, &limit);
                tally.limits_proven_too_low += 1;
                return;
            }
        }
    }
}

/// No sequence of grasps is quicker than the proven bound, and no plan is quicker than the quickest sequence. With a
/// plan's own time as the limit a plan is found; below it, nothing false is reported as proven.
fn timed(case: &Case, plan: Planned, text: &str, tally: &mut Tally) {
    let least_s = |slack: f64| Brute::of(case, slack).least_s();
    let (soonest_s, Some(loose_s)) = (time_bound_s(text), least_s(SLACK)) else { panic!("there is a plan\n{text}") };
    assert!(soonest_s <= loose_s * (1.0 + 1e-6), "{soonest_s} s is said to be the least, {loose_s} s is\n{text}");
    // Rolling follows short straight segments, which are slightly shorter than the true path.
    assert!(plan.time_s >= loose_s * 0.99, "{plan:?} is quicker than {loose_s} s\n{text}");
    let within = |limit_s: f64| with_limits(text, &format!("  require time <= {} ns\n", (limit_s * 1e9).round()));
    let built = build(&within(plan.time_s));
    assert!(planned(&built).is_some_and(|kept| kept.time_s <= plan.time_s + 1e-9), "{plan:?}\n{text}");
    let reported = reported(&within(plan.time_s.midpoint(soonest_s)));
    assert!(reported.iter().all(|report| !report.contains("proven: ")), "{reported:?}\n{text}");
    tally.timed += 1;
}

/// The proven lower bound on the time, in seconds.
fn time_bound_s(text: &str) -> f64 {
    let reported = reported(&with_limits(text, "  require time <= 1 ns\n"));
    let (_, rest) = reported[0].split_once("proven: no plan has less than ").expect("a bound");
    let mut words = rest.split([' ', '"']);
    let number: f64 = words.next().and_then(|number| number.parse().ok()).expect("a number");
    let unit =
        [("s", 1.0), ("ms", 1e-3), ("us", 1e-6)].into_iter().find(|(name, _)| words.clone().next() == Some(name));
    number * unit.expect("a unit of time").1
}

/// The least number of reconfigurations that the message for a limit names is correct.
fn least_is_said(case: &Case, limit: &str) {
    let reported = reported(limit);
    let fewest = |slack: f64| Brute::of(case, slack).fewest();
    let said_least = |fewest: u32| reported[0].contains(&format!("proven: the minimum is {fewest}"));
    let is_so = [0.0, SLACK, -SLACK].into_iter().filter_map(fewest).any(said_least);
    assert!(reported.len() == 1 && reported[0].contains("E0603") && is_so, "{reported:?}\n{limit}");
}

/// A few quick cases of a kind, or those of a long run.
fn cases(kind: Kind, few: Range<u32>) -> Tally {
    let number = |name: &str| std::env::var(name).ok().and_then(|cases| cases.parse::<u32>().ok());
    let skipped = number("TWEEZE_ORACLE_FROM").unwrap_or(0);
    let seeds = number("TWEEZE_ORACLE_CASES").map_or(few, |many| skipped..skipped + many);
    let mut tally = Tally::default();
    for seed in seeds {
        let mut chance = Random::new(7_000 + 1_000_003 * kind as u64 + 7919 * u64::from(seed));
        let case = random_case(&mut chance, kind);
        hold(&case, kind, &mut tally);
        if seed % 50 == 49 {
            println!("{kind:?} up to {seed}: {tally:?}");
        }
    }
    println!("{kind:?}: {tally:?}");
    tally
}

#[test]
fn pushing_tips_do_what_all_grasps_can() {
    let tally = cases(Kind::Pushing, 0..12);
    assert!(tally.planned >= 3 && tally.proven_none >= 1, "{tally:?}");
}

#[test]
fn sticking_tips_do_what_all_grasps_can() {
    let tally = cases(Kind::Sticking, 0..12);
    assert!(tally.planned >= 6 && tally.limited + tally.limits_proven_too_low >= 6, "{tally:?}");
}

#[test]
fn under_a_load_hands_do_what_all_grasps_can() {
    let tally = cases(Kind::Loaded, 3..9);
    assert!(tally.planned >= 1 && tally.proven_none >= 1, "{tally:?}");
}

#[test]
fn all_verbs_of_a_task_together_do_what_all_grasps_can() {
    let tally = cases(Kind::Verbs, 0..12);
    assert!(tally.planned >= 4, "{tally:?}");
}

#[test]
fn orientations_are_reached_by_the_best_of_their_ways() {
    let tally = cases(Kind::Oriented, 6..11);
    assert!(tally.planned >= 2, "{tally:?}");
}
