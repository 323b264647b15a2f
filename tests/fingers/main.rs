//! Hands from a program's text to verified schedules: the verifier integrates the planner's rolls from positions alone.

// The oracles use the platform's own mathematics.
#![allow(clippy::disallowed_methods)]

mod brute;
mod caps;
mod case;
mod chains;
mod ellipse;
mod forces;
mod mechanics;
mod oracle;
mod orient;
#[path = "../support/random.rs"]
mod random;
mod rolled;
mod round;
#[path = "../support/mod.rs"]
mod support;

use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use random::Random;
use support::build;
use tweeze::device::fingers::Plane;
use tweeze::schedule::fingers::FingersState;
use tweeze::schedule::{PlanRecord, State};

/// The paper's hand and ellipsoid: 74 contacts around each section, without weight.
fn program(device: &str, steps: &str) -> String {
    format!(
        "use std.fingers as f\n\
         device hand : f.three_fingers {{ tip_radius: 4.5 um, step: 20 deg{device} }}\n\
         scene cell {{ part bead : ellipsoid {{ axes: (16 um, 11.845 um, 11.845 um) }} }}\n\
         task flip on hand in cell {{\n{steps}\n}}\n"
    )
}

/// The paper's three turns.
const THREE_TURNS: &str =
    "  rotate bead by 80 deg about z\n  rotate bead by 220 deg about y\n  rotate bead by 100 deg about z";

/// The only plan of a program that must build.
fn plan(text: &str) -> PlanRecord {
    let built = build(text);
    assert_eq!(built.codes, Vec::<&str>::new(), "{text}");
    built.schedules[0].schedule().plans[0].clone()
}

/// Grasp, angle index and plane of each state.
fn grasps(plan: &PlanRecord) -> Vec<(Vec<u32>, i64, Plane)> {
    let of = |state: &State| match state {
        State::Fingers(FingersState { grasp, angle_index, plane, .. }) => (grasp.clone(), *angle_index, *plane),
        other => panic!("a state of a hand: {other:?}"),
    };
    plan.states.iter().map(|timed| of(&timed.state)).collect()
}

/// Position and orientation of the part at the end.
fn last(plan: &PlanRecord) -> (Vector3<f64>, UnitQuaternion<f64>) {
    match plan.states.last().map(|timed| &timed.state) {
        Some(State::Fingers(FingersState { position_um, orientation: [w, x, y, z], .. })) => {
            (Vector3::from(*position_um), UnitQuaternion::from_quaternion(Quaternion::new(*w, *x, *y, *z)))
        }
        other => panic!("a state of a hand: {other:?}"),
    }
}

fn about(axis: Vector3<f64>, degrees: f64) -> UnitQuaternion<f64> {
    UnitQuaternion::from_scaled_axis(axis * degrees.to_radians())
}

/// The orientation after turns about z, y and z of the part itself.
fn euler(z: f64, y: f64, again: f64) -> UnitQuaternion<f64> {
    about(Vector3::z(), z) * about(Vector3::y(), y) * about(Vector3::z(), again)
}

#[test]
fn the_papers_case_is_turned_as_asked_and_proven_cheapest() {
    let plan = plan(&program("", THREE_TURNS));
    assert!(plan.optimal, "{} deg, bound {} deg", plan.cost, plan.bound);
    let (place, orientation) = last(&plan);
    assert!(place.norm() < 0.05, "{place}");
    assert!(orientation.angle_to(&euler(80.0, 220.0, 100.0)).to_degrees() < 0.5);
    // Between the turns two fingers hold contacts 1 and 38.
    let states = grasps(&plan);
    let junctions = states.windows(2).filter(|pair| pair[0].2 != pair[1].2);
    for pair in junctions {
        let mut held: Vec<u32> = pair[0].0.iter().copied().filter(|contact| *contact != 0).collect();
        held.sort_unstable();
        assert_eq!(held, [1, 38], "{pair:?}");
    }
    // The first and third turns need only rolling: 4 + 5 steps of two fingers; the second rolls 11.
    let reconfigurations = plan.outcomes["reconfigurations"];
    assert!((plan.cost - (2.0 * 400.0 + 180.0 * reconfigurations)).abs() < 1e-6, "{} deg", plan.cost);
}

#[test]
fn both_estimates_cost_the_same_and_the_greedy_way_never_less() {
    let joint = plan(&program("", THREE_TURNS));
    let published = plan(&program("", &format!("  using published_astar\n{THREE_TURNS}")));
    let greedy = plan(&program("", &format!("  using greedy_decomposition\n{THREE_TURNS}")));
    assert!((joint.cost - published.cost).abs() < 1e-9 && published.optimal);
    assert!(greedy.cost >= joint.cost - 1e-9);
}

#[test]
fn without_adhesion_the_ellipsoid_has_no_way_and_is_told_what_would_open_one() {
    let built = build(&program(", adhesion: false", THREE_TURNS));
    assert_eq!(built.codes, ["E0601"]);
}

#[test]
fn an_orientation_is_reached_by_the_cheapest_of_all_its_ways() {
    let asked = plan(&program("", "  orient bead to euler(80 deg, 220 deg, 100 deg)"));
    let (_, orientation) = last(&asked);
    assert!(orientation.angle_to(&euler(80.0, 220.0, 100.0)).to_degrees() < 0.5);
    assert!(asked.optimal);
    let turned = plan(&program("", THREE_TURNS));
    assert!(asked.cost <= turned.cost + 1e-9, "{} deg against {} deg", asked.cost, turned.cost);
}

#[test]
fn a_grasp_that_is_asked_for_is_taken() {
    let steps = "  grasp bead at (5, 42, 0)\n  rotate bead by 80 deg about z\n  grasp bead at (1, 38, 0)";
    let plan = plan(&program("", steps));
    let states = grasps(&plan);
    assert_eq!(plan.outcomes["reconfigurations"], 0.0);
    assert!((plan.cost - 160.0).abs() < 1e-9, "{} deg", plan.cost);
    assert!(states.iter().any(|(grasp, ..)| grasp == &[5, 42, 0]));
    assert_eq!(states.last().map(|(grasp, ..)| grasp.as_slice()), Some(&[1, 38, 0][..]));
}

#[test]
fn a_part_is_carried_along_and_set_down() {
    let steps = "  grasp bead\n  translate bead by (5 um, -3 um, 2 um)\n  rotate bead by 40 deg about z\n  wait 10 ms\n  release";
    let plan = plan(&program(", support: 10 uN", steps));
    let (place, orientation) = last(&plan);
    assert!((place - Vector3::new(5.0, -3.0, 2.0)).norm() < 0.05, "{place}");
    assert!(orientation.angle_to(&about(Vector3::z(), 40.0)).to_degrees() < 0.5);
    assert!(grasps(&plan).last().is_some_and(|(grasp, ..)| grasp.iter().all(|contact| *contact == 0)));
}

#[test]
fn tasks_follow_one_another_on_one_hand() {
    let text = format!(
        "{}task back on hand in cell {{\n  rotate bead by -80 deg about z\n}}\nprogram both {{\n  run flip\n  run back\n}}\n",
        program("", "  rotate bead by 80 deg about z")
    );
    let built = build(&text);
    assert_eq!(built.codes, Vec::<&str>::new());
    let both = &built.schedules.iter().find(|one| one.schedule().plans.len() == 2).expect("the program").schedule();
    let (_, orientation) = last(&both.plans[1]);
    assert!(orientation.angle().to_degrees() < 0.5, "{} deg", orientation.angle().to_degrees());
}

#[test]
fn four_fingers_and_a_load_are_planned_too() {
    let steps = "  load: (0 nN, 0 nN, -20 nN)\n  rotate bead by 60 deg about z\n  rotate bead by 40 deg about y";
    let plan = plan(&program(", fingers: 4", steps));
    let (_, orientation) = last(&plan);
    let goal = about(Vector3::z(), 60.0) * about(Vector3::y(), 40.0);
    assert!(orientation.angle_to(&goal).to_degrees() < 0.5);
}

/// A random part, hand and task.
fn random_program(chance: &mut Random) -> String {
    let size = |chance: &mut Random| chance.thousandths(8.0, 17.0);
    let [a, b, c] = [size(chance), size(chance), size(chance)];
    let shape = match chance.below(4) {
        0 => format!("ellipsoid {{ axes: ({a} um, {b} um, {c} um) }}"),
        1 => format!("superellipsoid {{ axes: ({a} um, {b} um, {c} um), exponent: 2.5 }}"),
        2 => format!("rounded_box {{ size: ({} um, {} um, {} um), radius: 4 um }}", 2.0 * a, 2.0 * b, 2.0 * c),
        _ => format!("profile {{ x: 14 um * cos(t) - {} um * cos(2 * t), y: 13 um * sin(t) }}", a / 3.0),
    };
    let axes = if shape.starts_with("profile") { ["z", "z"] } else { ["z", "y"] };
    let mut steps = String::new();
    for _ in 0..1 + chance.below(4) {
        let degrees = 20 * (1 + chance.below(12));
        let sign = if chance.below(2) == 0 { "" } else { "-" };
        steps.push_str(&match chance.below(6) {
            0 => "  grasp part1\n  translate part1 by (1 um, -2 um, 0.5 um)\n".to_owned(),
            1 => format!("  rotate part1 by {degrees} deg about z\n  release\n"),
            _ => format!("  rotate part1 by {sign}{degrees} deg about {}\n", axes[chance.below(2) as usize]),
        });
    }
    let adhesion = chance.below(3) != 0;
    let friction = chance.thousandths(0.2, 0.7);
    format!(
        "use std.fingers as f\ndevice hand : f.three_fingers {{ adhesion: {adhesion}, friction: {friction}, support: 20 uN }}\n\
         scene cell {{ part part1 : {shape} }}\ntask turn on hand in cell {{\n  precision: 12 deg\n{steps}}}\n"
    )
}

#[test]
fn what_is_planned_for_random_parts_is_accepted_by_the_judge() {
    let mut chance = Random::new(986);
    let mut planned = 0;
    for _ in 0..30 {
        let text = random_program(&mut chance);
        let built = build(&text);
        assert!(!built.refused && built.codes.iter().all(|code| *code == "E0601"), "{:?}\n{text}", built.codes);
        planned += built.schedules.len();
    }
    assert!(planned >= 20, "{planned} of 30");
}
