//! Random hands against all grasps there are: effort, optimality and the proof that there is none.

use super::brute::{Brute, Case};
use super::random::Random;
use super::support::build;

/// What is let pass either way where a balance is exact: a grasp may hold or not by rounding.
const SLACK: f64 = 1e-6;

fn random_case(chance: &mut Random, kind: u32) -> Case {
    let steps_per_turn = [6, 8, 9][chance.below(3) as usize];
    let long_um = chance.thousandths(9.0, 14.0);
    let round_um = |chance: &mut Random| (long_um * chance.thousandths(0.55, 1.0) * 1000.0).round() / 1000.0;
    let size_un = chance.thousandths(0.01, 4.0);
    let part_un = |chance: &mut Random| (size_un * chance.thousandths(-1.0, 1.0) * 1e4).round() / 1e4;
    let is_loaded = kind == 2;
    let load_un = if is_loaded { [0, 1, 2].map(|_| part_un(chance)) } else { [0.0; 3] };
    let turns = 1 + if is_loaded { chance.below(2) } else { chance.below(3) };
    let turn = |chance: &mut Random| {
        let steps = 1 + chance.below(steps_per_turn) as i32;
        (chance.below(2) == 0, if chance.below(2) == 0 { steps } else { -steps })
    };
    let pin = (chance.below(4) == 0).then(|| [1 + chance.below(4), 5 + chance.below(6), 0]);
    Case {
        tip_radius_um: chance.thousandths(9.0, 12.0),
        steps_per_turn: steps_per_turn as i32,
        adhesion: kind == 1 || is_loaded && chance.below(3) != 0,
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
        pin,
        turns: (0..turns).map(|_| turn(chance)).collect(),
    }
}

/// What became of a case.
#[derive(Debug, Default)]
struct Tally {
    planned: u32,
    proven_none: u32,
    /// Only within the slack.
    marginal: u32,
    /// The grasp that was asked for is none.
    skipped: u32,
}

/// The least effort that the planner proves; `None` where it proves that there is none.
fn planned_deg(case: &Case, text: &str) -> Result<Option<f64>, Vec<&'static str>> {
    let built = build(text);
    assert!(!built.refused, "the judge refuses it: {:?}\n{text}", built.codes);
    match built.codes.as_slice() {
        [] => {
            let plan = &built.schedules[0].schedule().plans[0];
            assert!(plan.optimal && (plan.bound - plan.cost).abs() < 1e-9, "{} of {}: {case:?}", plan.cost, plan.bound);
            Ok(Some(plan.cost))
        }
        ["E0601"] => Ok(None),
        other => Err(other.to_vec()),
    }
}

fn hold(case: &Case, tally: &mut Tally) {
    let text = case.text();
    let planned = match planned_deg(case, &text) {
        Ok(planned) => planned,
        Err(codes) => {
            assert!(
                case.pin.is_some() && codes.iter().all(|code| ["E0547", "E0548"].contains(code)),
                "{codes:?}\n{text}"
            );
            tally.skipped += 1;
            return;
        }
    };
    let least = |slack: f64| Brute::of(case, slack).least_deg();
    let agrees = |least: Option<f64>| match (planned, least) {
        (Some(one), Some(other)) => (one - other).abs() < 1e-6,
        (None, None) => true,
        (Some(_), None) | (None, Some(_)) => false,
    };
    match planned {
        Some(_) => tally.planned += 1,
        None => tally.proven_none += 1,
    }
    if let Some(most) = planned.and_then(|_| reconfigurations(&text)).filter(|found| *found > 0) {
        limited(case, &text, most - 1);
    }
    if !agrees(least(0.0)) {
        tally.marginal += 1;
        let [loose, tight] = [least(SLACK), least(-SLACK)];
        let within =
            |deg: f64| loose.is_some_and(|least| least <= deg + 1e-6) && tight.is_none_or(|least| deg <= least + 1e-6);
        let is_within = planned.map_or(tight.is_none(), within);
        assert!(is_within, "planned {planned:?}, at least {loose:?}, at most {tight:?}\n{text}");
    }
}

fn reconfigurations(text: &str) -> Option<u64> {
    Some(build(text).schedules.first()?.schedule().plans[0].outcomes["reconfigurations"] as u64)
}

/// With fewer reconfigurations than the cheapest plan has there is a plan, or there is none.
fn limited(case: &Case, text: &str, most: u64) {
    let limit = text.replace("{\n  precision", &format!("{{\n  require reconfigurations <= {most}\n  precision"));
    let built = build(&limit);
    assert!(!built.refused, "{limit}");
    let fewest = |slack: f64| Brute::of(case, slack).fewest().unwrap_or(u64::MAX);
    match built.codes.as_slice() {
        [] => assert!(fewest(SLACK) <= most && reconfigurations(&limit).is_some_and(|found| found <= most), "{limit}"),
        codes => assert!(codes == ["E0603"] && fewest(-SLACK) > most, "{codes:?}\n{limit}"),
    }
}

/// So many cases of a kind: tips that only push, tips that stick, loads.
fn cases(kind: u32, few: u32) -> Tally {
    let many = std::env::var("TWEEZE_ORACLE_CASES").ok().and_then(|cases| cases.parse().ok());
    let mut chance = Random(7_000 + u64::from(kind));
    let mut tally = Tally::default();
    for _ in 0..many.unwrap_or(few) {
        hold(&random_case(&mut chance, kind), &mut tally);
    }
    println!("{kind}: {tally:?}");
    tally
}

#[test]
fn pushing_tips_do_what_all_grasps_can() {
    let tally = cases(0, 12);
    assert!(tally.planned >= 3 && tally.proven_none >= 1, "{tally:?}");
}

#[test]
fn sticking_tips_do_what_all_grasps_can() {
    let tally = cases(1, 12);
    assert!(tally.planned >= 6, "{tally:?}");
}

#[test]
fn under_a_load_hands_do_what_all_grasps_can() {
    let tally = cases(2, 4);
    assert!(tally.planned >= 1 && tally.proven_none >= 1, "{tally:?}");
}
