//! Microrobots from a program's text to verified schedules: the verifier integrates the planner's drives from the
//! voltage alone.

// The expected figures come from the platform's own mathematics.
#![allow(clippy::disallowed_methods)]

mod allocations;
mod bounds;
mod control;
mod driven;
mod found;
mod guaranteed;
#[cfg(unix)]
#[path = "../support/ignored.rs"]
mod ignored;
mod lost;
#[path = "../support/random.rs"]
mod random;
mod recorded;
#[path = "../support/mod.rs"]
mod support;
mod together;

use random::Random;
use std::f64::consts::TAU;
use std::fmt::Write;
use support::build;
use tweeze::schedule::microrobots::MicrorobotsState;
use tweeze::schedule::{PlanRecord, State};

/// The reference table of four robots; a fifth column `turns` would give the turning side.
const FLEET: &str = "\
use std.microrobots
device fleet : microrobots.bed {
  robots: table {
    robot | snap_down [V] | release [V] | turning_radius [um] | speed [um/s]
    D1    | 110           | 20          | 162                 | 200
    D2    | 110           | 35          | 170                 | 190
    D3    | 130           | 35          | 158                 | 210
    D4    | 150           | 50          | 176                 | 200
  }
  margin: 2 V
}
";

/// A pose in the language.
fn pose(x_um: f64, y_um: f64, heading_rad: f64) -> String {
    format!("pose({x_um} um, {y_um} um, {} deg)", heading_rad.to_degrees())
}

/// Pose of a robot at the end of a plan.
fn last(plan: &PlanRecord, robot: &str) -> [f64; 3] {
    match plan.states.last().map(|timed| &timed.state) {
        Some(State::Microrobots(MicrorobotsState { poses, .. })) => {
            let pose = &poses[robot];
            [pose.x_um, pose.y_um, pose.heading_rad()]
        }
        other => panic!("a state of a bed: {other:?}"),
    }
}

/// The smallest angle between two headings.
fn between_rad(one: f64, other: f64) -> f64 {
    let turned = (one - other).rem_euclid(TAU);
    turned.min(TAU - turned)
}

#[test]
fn a_thousand_random_drives_reach_their_poses() {
    let mut chance = Random::new(20_080);
    let mut text = format!("{FLEET}scene empty {{ robot D3 at pose(0 mm, 0 mm, 0 deg) }}\n");
    let mut goals = Vec::new();
    for task in 0..1000 {
        let place = |chance: &mut Random| chance.thousandths(-5000.0, 5000.0);
        let goal = [place(&mut chance), place(&mut chance), chance.unit() * TAU];
        let _ = writeln!(text, "task t{task} on fleet in empty {{ drive D3 to {} }}", pose(goal[0], goal[1], goal[2]));
        goals.push(goal);
    }
    let built = build(&text);
    assert_eq!(built.codes, Vec::<&str>::new());
    assert_eq!(built.schedules.len(), 1000);
    let mut near = 0;
    for (verified, goal) in built.schedules.iter().zip(&goals) {
        let plan = &verified.schedule().plans[0];
        let end = last(plan, "D3");
        let off_um = (end[0] - goal[0]).hypot(end[1] - goal[1]);
        assert!(off_um <= 0.5, "{off_um} um from {goal:?}");
        assert!(between_rad(end[2], goal[2]) <= 0.5_f64.to_radians(), "{end:?} is not {goal:?}");
        assert!(plan.bound <= plan.cost && (!plan.optimal || plan.bound == plan.cost), "{plan:?}");
        near += usize::from(plan.cost - plan.bound < 0.1);
    }
    assert!(near >= 950, "{near} of 1000 within a tenth of a second of the bound");
}

#[test]
fn a_state_is_applied_and_all_robots_move_with_it() {
    let text = format!(
        "{FLEET}scene field {{\n  robot D1 at pose(0 mm, 0 mm, 0 deg)\n  robot D4 at pose(3 mm, 0 mm, 90 deg)\n}}\n\
         task turn on fleet in field {{\n  apply state 2 for 3 s\n  wait 10 ms\n  apply state 0b0000 for 1 s\n}}\n"
    );
    let built = build(&text);
    assert_eq!(built.codes, Vec::<&str>::new());
    let schedule = built.schedules[0].schedule();
    let trains: Vec<u64> =
        schedule.actuations.iter().filter(|one| one.swing.is_some()).map(|one| one.duration_ns).collect();
    assert_eq!(trains, [3_000_000_000, 1_000_000_000]);
    let plan = &schedule.plans[0];
    // D4 runs straight all the time, D1 only during the last second.
    let d4 = last(plan, "D4");
    assert!((d4[0] - 3000.0).abs() < 1e-6 && (d4[1] - 800.0).abs() < 1e-6, "{d4:?}");
    let d1 = last(plan, "D1");
    let turned = -600.0 / 162.0_f64;
    assert!(between_rad(d1[2], turned) < 1e-9);
    let centre = [0.0, -162.0];
    let before = [centre[0] - 162.0 * turned.sin(), centre[1] + 162.0 * turned.cos()];
    assert!((d1[0] - before[0] - 200.0 * turned.cos()).abs() < 1e-6, "{d1:?}");
    assert!((d1[1] - before[1] - 200.0 * turned.sin()).abs() < 1e-6, "{d1:?}");
}

#[test]
fn three_robots_come_together() {
    let text = format!(
        "{FLEET}scene field {{\n  robot D2 at pose(0 mm, 0 mm, 90 deg)\n  robot D3 at pose(3 mm, 0.2 mm, 0 deg)\n  \
         robot D4 at pose(1.5 mm, 3 mm, 180 deg)\n}}\n\
         task build on fleet in field {{\n  assemble {{\n    D4 to pose(1.6 mm, 1.20 mm, 90 deg)\n    \
         D3 to pose(1.6 mm, 1.46 mm, 270 deg)\n    D2 to pose(1.76 mm, 1.34 mm, 180 deg)\n  }}\n}}\n"
    );
    let built = build(&text);
    assert!(built.codes.iter().all(|code| *code == "W0511"), "{:?}", built.codes);
    let plan = &built.schedules[0].schedule().plans[0];
    let Some(State::Microrobots(MicrorobotsState { docked, .. })) = plan.states.last().map(|timed| &timed.state) else {
        panic!("a state of a bed")
    };
    assert_eq!(docked, &["D2", "D3", "D4"]);
    assert!(plan.bound > 0.0 && plan.bound <= plan.cost);
    let mut turned = 0;
    for timed in &plan.states {
        let State::Microrobots(MicrorobotsState { arms, docked, .. }) = &timed.state else {
            panic!("a state of a bed")
        };
        let row = |name: &String| name[1..].parse::<usize>().expect("a number") - 1;
        assert!(docked.iter().all(|name| arms[row(name)] == 0), "{docked:?} with {arms:?}");
        turned += usize::from(!docked.is_empty() && arms[1] == 1);
    }
    assert!(turned > 2, "D2 turns {turned} times");
}

/// A raw state that would lower the arm of a docked robot is refused at its step.
#[test]
fn no_state_is_applied_that_lowers_the_arm_of_a_docked_robot() {
    let applied = |state: usize| {
        let text = format!(
            "{FLEET}scene field {{\n  robot D2 at pose(-9 mm, 0 mm, 90 deg)\n  robot D3 at pose(3 mm, 0.2 mm, 0 deg)\n  \
             robot D4 at pose(1.5 mm, 3 mm, 180 deg)\n}}\n\
             task build on fleet in field {{\n  assemble {{\n    D4 to pose(1.6 mm, 1.20 mm, 90 deg)\n    \
             D3 to pose(1.6 mm, 1.46 mm, 270 deg)\n  }}\n  apply state {state} for 1 s\n}}\n"
        );
        let codes = build(&text).codes;
        codes.into_iter().filter(|code| *code != "W0511").collect::<Vec<&str>>()
    };
    assert_eq!(applied(2), Vec::<&str>::new());
    assert_eq!(applied(3), ["E0606"]);
    assert_eq!(applied(4), ["E0606"]);
}
