//! Angles that a turn may visit: a task costs as much as its mirror image, and a turn in two parts never costs less
//! than the whole turn.

use super::brute::Brute;
use super::case::{Case, FINGERS, Step};
use super::oracle::{Kind, Planned, agrees, planned, random_case};
use super::random::Random;
use super::support::{Built, build};
use tweeze::schedule::State;
use tweeze::schedule::fingers::FingersState;

/// A small case with a turn about z between two random grasps.
fn turn_between_grasps(chance: &mut Random) -> (Case, i32) {
    let kind = if chance.below(3) == 0 { Kind::Pushing } else { Kind::Sticking };
    let case = random_case(chance, kind);
    let contacts = Brute::of(&case, 0.0).contacts();
    let grasp = |chance: &mut Random, fingers: u32| {
        let mut grasp = [0; FINGERS];
        for held in grasp.iter_mut().take(fingers as usize) {
            *held = 1 + chance.below(contacts);
        }
        grasp.rotate_left(chance.below(3) as usize);
        Step::Grasp(grasp)
    };
    let turn = 1 + chance.below(case.steps_per_turn as u32 - 3) as i32;
    let turn = if chance.below(2) == 0 { turn } else { -turn };
    let fingers = 2 + chance.below(2);
    let steps = vec![grasp(chance, 3), Step::Turn(true, turn), grasp(chance, fingers)];
    (Case { steps, ..case }, turn)
}

/// The case seen from behind, that is, turned about x by half a circle.
fn mirrored(case: &Case, contacts: u32) -> Case {
    let step = |step: &Step| match *step {
        Step::Turn(is_about_z, turn) => Step::Turn(is_about_z, -turn),
        Step::Grasp(grasp) => {
            Step::Grasp(grasp.map(|contact| if contact < 2 { contact } else { contacts + 2 - contact }))
        }
        other => other,
    };
    Case { steps: case.steps.iter().map(step).collect(), ..case.clone() }
}

/// The case with its turn in two parts, the first in the opposite direction.
fn turned_back(case: &Case, turn: i32, back: i32) -> Case {
    let step = |step: &Step| match *step {
        Step::Turn(is_about_z, _) => vec![Step::Turn(is_about_z, -back), Step::Turn(is_about_z, turn + back)],
        other => vec![other],
    };
    Case { steps: case.steps.iter().flat_map(step).collect(), ..case.clone() }
}

/// Whether the part turns beyond its start or its goal.
fn goes_beyond(built: &Built, turn: i32) -> bool {
    let states = built.schedules.iter().flat_map(|schedule| &schedule.schedule().plans[0].states);
    let mut angles = states.filter_map(|timed| match &timed.state {
        State::Fingers(FingersState { angle_index, .. }) => Some(angle_index - 1),
        _ => None,
    });
    angles.any(|angle| angle * i64::from(turn.signum()) < 0)
}

/// The build and plan of a case; the plan is `None` if it is proven that there is none, and the result is `None` if the
/// check refuses the case.
fn answered(case: &Case) -> Option<(Built, Option<Planned>)> {
    let text = case.text();
    let built = build(&text);
    assert!(!built.refused, "the judge refuses it: {:?}\n{text}", built.codes);
    let found = planned(&built);
    let is_answered = built.codes.is_empty() || built.codes == ["E0601"];
    // Otherwise a grasp whose tips touch, or a turn that is not a whole number of steps.
    assert!(is_answered || built.codes.iter().all(|code| code.starts_with("E054")), "{:?}\n{text}", built.codes);
    is_answered.then_some((built, found))
}

#[test]
fn mirror_images_cost_the_same_and_no_turn_in_two_parts_costs_less() {
    let (mut compared, mut without, mut beyond) = (0, 0, 0);
    for seed in 0..300 {
        let mut chance = Random::new(4_242 + 7919 * seed);
        let (case, turn) = turn_between_grasps(&mut chance);
        let Some((built, whole)) = answered(&case) else { continue };
        let text = case.text();
        if !agrees(&case, whole, None, &text) {
            continue;
        }
        let brute = Brute::of(&case, 0.0);
        let mirror = mirrored(&case, brute.contacts());
        let (_, seen) = answered(&mirror).expect("the mirror image is allowed where the case is");
        let cost = |plan: Option<Planned>| plan.map(|plan| (plan.cost_deg, plan.gaits, plan.optimal));
        assert_eq!(cost(whole), cost(seen), "{text}{}", mirror.text());
        let split = turned_back(&case, turn, turn.signum() * (1 + chance.below(2) as i32));
        if Brute::of(&split, 0.0).steps_turned() == brute.steps_turned()
            && let Some((_, Some(plan))) = answered(&split)
        {
            let is_dearer = whole.is_some_and(|whole| whole.cost_deg <= plan.cost_deg + 1e-6);
            assert!(is_dearer, "{whole:?}, in two parts {plan:?}\n{text}{}", split.text());
        }
        compared += 1;
        without += u32::from(whole.is_none());
        beyond += u32::from(goes_beyond(&built, turn));
    }
    println!("{compared} compared, {without} without a plan, {beyond} beyond");
    assert!(compared >= 30 && without >= 1 && beyond >= 1, "{compared} compared, {without} without, {beyond} beyond");
}
