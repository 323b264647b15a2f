//! Assemblies of two robots with a known plan that drives both to their goals at once: the legs of a random short plan,
//! run backwards from the goals, give the start poses. The motion model shares nothing with the planner or the
//! verifier.

use super::random::Random;
use super::support::build;
use std::f64::consts::{FRAC_PI_2, TAU};
use tweeze::schedule::PlanRecord;

/// Both robots have the same speed and radius.
const RADIUS_UM: f64 = 160.0;
const SPEED_UM_S: f64 = 200.0;

/// Greatest duration of a leg's control cycle.
const CYCLE_S: f64 = 0.002;

/// Greatest cost of rounding to whole strokes.
const ROUNDING_S: f64 = 0.01;

/// A pose: x and y in micrometres, heading in radians.
type Place = [f64; 3];

/// Moves a pose: clockwise on a circle with the arm down, straight ahead with the arm up; backwards if the distance is
/// negative.
fn moved([x, y, heading]: Place, way_um: f64, is_down: bool) -> Place {
    if !is_down {
        return [x + way_um * heading.cos(), y + way_um * heading.sin(), heading];
    }
    let (middle_x, middle_y) = (x + RADIUS_UM * heading.sin(), y - RADIUS_UM * heading.cos());
    let later = heading - way_um / RADIUS_UM;
    [middle_x - RADIUS_UM * later.sin(), middle_y + RADIUS_UM * later.cos(), later]
}

/// Two robots, `D1` facing right and `D2` facing left, that meet head on at the origin.
const GOALS: [Place; 2] = [[-130.0, 0.0, 0.0], [130.0, 0.0, 2.0 * FRAC_PI_2]];

/// Start poses from which the legs (number of lowered arms, distance) lead to the goals.
fn starts(legs: &[(usize, f64)]) -> [Place; 2] {
    // State 1 lowers the arm of `D1` alone.
    [0, 1].map(|robot| legs.iter().rev().fold(GOALS[robot], |at, (downs, way_um)| moved(at, -way_um, robot < *downs)))
}

fn text(starts: [Place; 2], objective: &str, fields: &str) -> String {
    let pose = |[x, y, heading]: Place| {
        let heading = heading.rem_euclid(TAU).to_degrees();
        format!("pose({x} um, {y} um, {heading} deg)")
    };
    let [first, second] = starts.map(pose);
    let [left, right] = GOALS.map(pose);
    format!(
        "use std.microrobots\ndevice fleet : microrobots.bed {{\n  robots: table {{\n    \
         robot | snap_down [V] | release [V] | turning_radius [um] | speed [um/s]\n    \
         D1 | 110 | 20 | {RADIUS_UM} | {SPEED_UM_S}\n    D2 | 122 | 33 | {RADIUS_UM} | {SPEED_UM_S}\n  }}\n  \
         margin: 4 V{fields}\n}}\nscene field {{\n  robot D1 at {first}\n  robot D2 at {second}\n}}\n\
         task meet on fleet in field {{\n  {objective}\n  assemble {{\n    D1 to {left}\n    D2 to {right}\n  }}\n}}\n"
    )
}

/// The plan of a program that has one.
fn planned(text: &str) -> PlanRecord {
    let built = build(text);
    assert!(!built.refused, "refused by the judge:\n{text}");
    let verified = built.schedules.first().unwrap_or_else(|| panic!("{:?}\n{text}", built.codes));
    verified.schedule().plans[0].clone()
}

const EXACT: &str = ", speed_error: 0 %, turning_error: 0 deg/mm, place_error: 0 um, heading_error: 0 deg";

/// Holding one control state brings both to their goals: no other plan is as fast or has as few control cycles.
#[test]
fn robots_that_face_each_other_run_until_they_meet() {
    let starts = starts(&[(0, 1_380.0)]);
    for fields in ["", EXACT] {
        for objective in ["", "minimize time"] {
            let plan = planned(&text(starts, objective, fields));
            assert_eq!(plan.outcomes["switches"], 1.0, "{plan:?}");
            assert!(plan.cost <= 1_380.0 / SPEED_UM_S + CYCLE_S + 1e-9 && plan.bound <= plan.cost, "{plan:?}");
            assert!(plan.bound >= plan.cost - ROUNDING_S, "{plan:?}");
        }
        let plan = planned(&text(starts, "minimize switches", fields));
        assert!(plan.cost == 1.0 && plan.optimal, "{plan:?}");
    }
}

/// Plans of one or two legs without a full circle are found, or better ones, and no bound exceeds them.
#[test]
fn no_plan_of_a_few_legs_is_missed() {
    let mut chance = Random::new(21);
    for _ in 0..16 {
        let count = 1 + chance.below(2) as usize;
        let mut legs: Vec<(usize, f64)> = Vec::new();
        while legs.len() < count {
            let downs = chance.below(3) as usize;
            let way_um = if downs == 0 { chance.thousandths(500.0, 2_500.0) } else { chance.thousandths(60.0, 480.0) };
            if legs.last().is_none_or(|last| last.0 != downs) {
                legs.push((downs, way_um));
            }
        }
        let starts = starts(&legs);
        let [dx, dy] = [0, 1].map(|axis| starts[0][axis] - starts[1][axis]);
        let known_s = legs.iter().map(|leg| leg.1 / SPEED_UM_S + CYCLE_S).sum::<f64>();
        let is_apart = dx.hypot(dy) > 700.0;
        if is_apart {
            for objective in ["minimize time", "minimize switches"] {
                let text = text(starts, objective, "");
                let plan = planned(&text);
                let known = if plan.unit == "s" { known_s + ROUNDING_S } else { count as f64 };
                assert!(plan.bound <= known, "bound {} above {known}\n{text}", plan.bound);
                assert!(plan.cost <= known, "{} where {known} do: {legs:?}\n{text}", plan.cost);
            }
        }
    }
}
