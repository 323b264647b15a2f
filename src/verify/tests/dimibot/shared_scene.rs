use super::*;
use crate::claims::dimibot::DimibotAction;
use crate::claims::{SharedScene, Timeline};
use crate::device::dimibot::Simultaneous;
use crate::geometry::shape::Pose;
use std::collections::BTreeMap;
use std::f64::consts::FRAC_PI_2;

/// Far less than a planner's margin, far more than rounding.
const HAIR_UM: f64 = 1e-10;

/// Needed distance of two tips with a radius of 10 nm and a repeatability of 90 nm each.
const NEEDED_UM: f64 = 0.2;

/// Actions of two robots at the same time, the second one placed in the scene of the first.
fn together(first: DimibotAction, second: Vec<DimibotAction>, frame: Pose) -> Claims {
    let jobs = vec![job("a", "left", order(facts(3, 3), vec![first])), job("b", "right", order(facts(3, 3), second))];
    let mut claims = claims(jobs, Timeline::Together(vec![Timeline::Run(0), Timeline::Run(1)]));
    let frames = BTreeMap::from([("left".to_owned(), Pose::at(0.0, 0.0)), ("right".to_owned(), frame)]);
    claims.shared = vec![SharedScene { scene: "bench".into(), frames }];
    claims
}

fn stands(x_um: f64, y_um: f64) -> (Schedule, Claims) {
    let claims = together(go(&[(1, 0)]), vec![DimibotAction::Wait(MS)], Pose::at(x_um, y_um));
    (schedule(&claims, &[&[&["bl0.set"]], &[&[]]]), claims)
}

#[test]
fn a_tip_keeps_off_one_that_stands() {
    let (sound, claims) = stands(0.5, NEEDED_UM + HAIR_UM);
    passes(&sound, &claims);
    let (touching, claims) = stands(0.5, NEEDED_UM - HAIR_UM);
    only(Rule::Encounter, &touching, &claims);
    // Without a shared scene, nothing is known of their relative position.
    passes(&touching, &Claims { shared: Vec::new(), ..claims });
}

#[test]
fn where_a_robot_is_turned_to_matters() {
    // A robot that faces +y at (0.85, -0.5) crosses the path of the other one from below.
    let across = |wait_ns: u64| {
        let frame = Pose { x_um: 0.85, y_um: -0.5, heading_rad: FRAC_PI_2 };
        let claims = together(go(&[(1, 0)]), vec![DimibotAction::Wait(wait_ns), go(&[(1, 0)])], frame);
        (schedule(&claims, &[&[&["bl0.set"]], &[&[], &["bl0.set"]]]), claims)
    };
    let (sound, claims) = across(15 * MS + 1);
    passes(&sound, &claims);
    // A pulse includes both its ends.
    let (meeting, claims) = across(15 * MS);
    only(Rule::Encounter, &meeting, &claims);
    let (crossing, claims) = across(7 * MS);
    only(Rule::Encounter, &crossing, &claims);
}

#[test]
fn modules_switched_at_once_may_carry_the_tip_anywhere_between() {
    let mut claims = together(go(&[(1, 1)]), vec![DimibotAction::Wait(MS)], Pose::at(0.85, 0.85));
    order_of(&mut claims, 0).simultaneous = Simultaneous::Safe;
    only(Rule::Encounter, &schedule(&claims, &[&[&["bl0.set br0.set"]], &[&[]]]), &claims);
    passes(&schedule(&claims, &[&[&["bl0.set", "br0.set"]], &[&[]]]), &claims);
}

#[test]
fn a_robot_may_wait_for_another_and_no_one_else() {
    let mut claims = together(go(&[(3, 0)]), vec![DimibotAction::Wait(MS)], Pose::at(0.0, 5.0));
    let mut waits = schedule(&claims, &[&[&["bl0.set", "bl1.set"]], &[&[]]]);
    let late = 30 * MS;
    waits.actuations[1].start_ns = late;
    waits.steps[0].duration_ns = late + 20 * MS;
    waits.plans[0].duration_ns = late + 20 * MS;
    waits.duration_ns = late + 20 * MS;
    record(&mut waits, &claims);
    passes(&waits, &claims);
    claims.shared.clear();
    only(Rule::Idle, &waits, &claims);
}

#[test]
fn places_that_cannot_be_are_no_ground_to_judge_on() {
    let (schedule, sound) = stands(0.5, 1.0);
    let places: [fn(&mut Claims); 4] = [
        |claims| claims.shared[0].frames.extend([("nobody".to_owned(), Pose::at(0.0, 0.0))]),
        |claims| claims.shared[0].frames.extend([("right".to_owned(), Pose::at(f64::NAN, 0.0))]),
        |claims| order_of(claims, 1).frame = Some(Pose::at(0.0, 1.0)),
        |claims| order_of(claims, 1).frame = Some(Pose::at(f64::INFINITY, 1.0)),
    ];
    for edit in places {
        let mut claims = sound.clone();
        edit(&mut claims);
        assert!(matches!(verify(schedule.clone(), &claims), Verdict::Inconclusive { .. }));
    }
}
