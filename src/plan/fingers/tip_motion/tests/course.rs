//! Whole courses: states, positions, speeds, and courses that cannot be executed.

use super::*;
use nalgebra::Unit;

fn states(motion: &FingersMotion) -> Vec<&HeldGrasp> {
    motion.steps.iter().flatten().filter_map(|stretch| stretch.state.as_ref()).collect()
}

fn acts_of_the_paper() -> Vec<Vec<FingerAct>> {
    let place = |finger, contact| FingerAct::Place { finger, contact };
    let leave = |finger| FingerAct::Leave { finger };
    vec![
        vec![begin(Plane::Xy, &[5, 42, 0]), FingerAct::Roll(4)],
        vec![FingerAct::Turn(Plane::Xz), place(2, 12), leave(0), place(0, 49), leave(1), FingerAct::Roll(11)],
        vec![FingerAct::Turn(Plane::Xy), FingerAct::Roll(5)],
        vec![FingerAct::Translate([3.0, 4.0, 0.0]), FingerAct::Wait(1_000)],
        vec![FingerAct::Release { order: vec![0, 2] }],
    ]
}

/// The paper's task, which turns the ellipsoid by (80, 220, 100) deg, with its motion.
fn paper() -> (Bench, FingersMotion) {
    let bench = Bench::new(ellipse(), facts(3));
    let course = FingersCourse { start: bench.hand().home([0.0; 3]), steps: acts_of_the_paper() };
    let motion = bench.hand().motion(&course).expect("it can be carried out");
    (bench, motion)
}

#[test]
fn three_turns_make_one_orientation() {
    let (bench, motion) = paper();
    let states = states(&motion);
    assert_eq!(states.len(), 1 + 4 + 4 + 11 + 5 + 1 + 1);
    let last = states[states.len() - 1];
    let about = |axis: Vector3<f64>, steps: f64| {
        UnitQuaternion::from_axis_angle(&Unit::new_normalize(axis), steps * bench.section.step_rad)
    };
    let wanted = about(Vector3::z(), 4.0) * about(Vector3::y(), 11.0) * about(Vector3::z(), 5.0);
    assert!(rotation(last.orientation).angle_to(&wanted) < 1e-12);
    assert!(states.iter().all(|hold| hold.orientation[0] >= 0.0));
    let norm = |hold: &HeldGrasp| hold.orientation.iter().map(|part| part * part).sum::<f64>();
    assert!(states.iter().all(|hold| (norm(hold) - 1.0).abs() < 1e-14));
    assert_eq!(last.position_um, [3.0, 4.0, 0.0]);
    assert_eq!(last.grasp, [0, 0, 0]);
}

#[test]
fn states_tell_grasp_and_angle() {
    let (_, motion) = paper();
    let seen: Vec<(Vec<u32>, i64, Plane)> =
        states(&motion).iter().map(|hold| (hold.grasp.clone(), hold.angle_index, hold.plane)).collect();
    assert_eq!(seen[0], (vec![5, 42, 0], 1, Plane::Xy));
    assert_eq!(seen[4], (vec![1, 38, 0], 5, Plane::Xy));
    assert_eq!(seen[5], (vec![1, 38, 12], 1, Plane::Xz));
    assert_eq!(seen[8], (vec![49, 0, 12], 1, Plane::Xz));
    assert_eq!(seen[19], (vec![38, 0, 1], 12, Plane::Xz));
    assert_eq!(seen[20], (vec![37, 0, 74], 2, Plane::Xy));
    assert_eq!(seen[24], (vec![33, 0, 70], 6, Plane::Xy));
    assert_eq!(seen[26], (vec![0, 0, 0], 6, Plane::Xy));
}

#[test]
fn turns_go_backwards_below_one() {
    let bench = Bench::new(ellipse(), facts(3));
    let motion = bench.hand().motion(&bench.course(vec![begin(Plane::Xz, &[73, 36, 0]), FingerAct::Roll(-3)]));
    let motion = motion.expect("it can be carried out");
    let seen: Vec<(i64, u32)> = states(&motion).iter().map(|hold| (hold.angle_index, hold.grasp[0])).collect();
    assert_eq!(seen, [(1, 73), (0, 74), (-1, 1), (-2, 2)]);
    let turned = rotation(states(&motion)[3].orientation);
    let about_y = Unit::new_normalize(Vector3::y());
    assert!(turned.angle_to(&UnitQuaternion::from_axis_angle(&about_y, -3.0 * bench.section.step_rad)) < 1e-12);
}

/// At each state the holding tips touch the outline at their contacts.
#[test]
fn tips_are_at_their_contacts() {
    let (bench, motion) = paper();
    for stretch in motion.steps.iter().flatten() {
        let Some(hold) = &stretch.state else { continue };
        for (finger, contact) in hold.grasp.iter().enumerate().filter(|(_, contact)| **contact != 0) {
            let (place, off_um) = in_section(hold, stretch.tips_um[finger]);
            let touch_um = bench.reach.way(*contact as usize - 1, &[]).expect("it is open").touch_um;
            assert!((place - touch_um).norm() < 1e-5 && off_um.abs() < 1e-9, "finger {finger} at {contact}");
        }
    }
}

/// The fastest tip of each move has the speed of its act, to the nanosecond.
#[test]
fn speeds_are_those_of_the_facts() {
    let (bench, motion) = paper();
    let facts = &bench.facts;
    let mut tips = &motion.start.tips_um;
    let mut seen = [0; 3];
    for stretch in motion.steps.iter().flatten() {
        let way = |finger: usize| (Vector3::from(stretch.tips_um[finger]) - Vector3::from(tips[finger])).norm();
        let longest_um = (0..3).map(way).fold(0.0, f64::max);
        let speeds = [facts.rolling_um_per_s, facts.approach_um_per_s, facts.speed_um_per_s];
        let takes_ns = speeds.map(|speed_um_per_s| longest_um / speed_um_per_s * 1e9);
        let index = takes_ns.iter().position(|ns| (0.0..1.01).contains(&(stretch.duration_ns as f64 - ns)));
        assert!(index.is_some() || longest_um == 0.0 && stretch.duration_ns == 1_000, "{longest_um}");
        seen[index.unwrap_or(0)] += 1;
        tips = &stretch.tips_um;
    }
    assert!(seen.iter().all(|count| *count > 3), "{seen:?}");
    let sum: u64 = motion.steps.iter().flatten().map(|stretch| stretch.duration_ns).sum();
    assert_eq!(duration_ns(&motion), Some(sum));
}

#[test]
fn courses_go_on_where_others_ended() {
    let (bench, whole) = paper();
    let hand = bench.hand();
    let (mut start, mut steps) = (hand.home([0.0; 3]), Vec::new());
    for acts in acts_of_the_paper() {
        let part = hand.motion(&FingersCourse { start, steps: vec![acts] }).expect("it can be carried out");
        start = end(&part);
        steps.extend(part.steps);
    }
    let flat = |steps: &[Vec<TipsMove>]| -> Vec<f64> {
        steps.iter().flatten().flat_map(|stretch| stretch.tips_um.concat()).collect()
    };
    let (parts, whole_values) = (flat(&steps), flat(&whole.steps));
    assert_eq!(parts.len(), whole_values.len());
    // Each part measures the positions of its holding tips anew.
    assert!(parts.iter().zip(&whole_values).all(|(a, b)| (a - b).abs() < 1e-6));
    assert_eq!(end(&whole).hold.grasp, [0, 0, 0]);
}

#[test]
fn stages_stay_within_their_range() {
    let (bench, motion) = paper();
    let farthest = |axis: usize| {
        let all = motion.steps.iter().flatten().flat_map(|stretch| &stretch.tips_um).chain(&motion.start.tips_um);
        all.map(|tip| tip[axis].abs()).fold(0.0, f64::max)
    };
    let carried_out = |range_um: [f64; 3]| {
        let bench = Bench::new(ellipse(), FingersFacts { range_um, ..bench.facts.clone() });
        let course = FingersCourse { start: bench.hand().home([0.0; 3]), steps: acts_of_the_paper() };
        bench.hand().motion(&course)
    };
    let just: [f64; 3] = std::array::from_fn(farthest);
    assert!(carried_out(just).is_ok());
    for axis in 0..3 {
        let mut less = just;
        less[axis] -= 0.5;
        let Err(TipMotionError::Range { axis: named, beyond_um, .. }) = carried_out(less) else {
            panic!("axis {axis}")
        };
        assert_eq!(named, axis);
        assert!((beyond_um - 0.5).abs() < 1e-9, "{beyond_um}");
    }
}

#[test]
fn what_is_not_a_number_lies_nowhere() {
    let bench = Bench::new(ellipse(), facts(3));
    for by_um in [f64::NAN, f64::INFINITY, f64::MAX] {
        let course = bench.course(vec![FingerAct::Translate([0.0, by_um, 0.0])]);
        let Err(TipMotionError::Range { axis, .. }) = bench.hand().motion(&course) else { panic!("{by_um}") };
        assert_eq!(axis, 1);
    }
}

#[test]
fn acts_that_do_not_fit_are_refused() {
    let bench = Bench::new(ellipse(), facts(3));
    let hold = || begin(Plane::Xy, &[1, 38, 0]);
    let place = |finger, contact| FingerAct::Place { finger, contact };
    let refused: Vec<Vec<FingerAct>> = vec![
        vec![hold(), hold()],
        vec![begin(Plane::Xy, &[1, 75, 0])],
        vec![begin(Plane::Xy, &[1, 38])],
        vec![hold(), place(0, 20)],
        vec![hold(), place(3, 20)],
        vec![hold(), place(2, 0)],
        vec![hold(), place(2, 75)],
        vec![hold(), FingerAct::Leave { finger: 2 }],
        vec![hold(), FingerAct::Leave { finger: 9 }],
        vec![hold(), FingerAct::Release { order: vec![0] }],
        vec![begin(Plane::Xy, &[2, 38, 0]), FingerAct::Turn(Plane::Xz)],
        vec![FingerAct::Roll(i32::MIN)],
        vec![begin(Plane::Xy, &[0, 38, 0]), FingerAct::Roll(1)],
    ];
    for acts in refused {
        let course = bench.course(acts.clone());
        assert_eq!(bench.hand().motion(&course), Err(TipMotionError::Unfit { step: 0 }), "{acts:?}");
    }
    let course = bench.course(vec![hold(), place(2, 3)]);
    assert_eq!(bench.hand().motion(&course), Err(TipMotionError::Blocked { step: 0, finger: 2, contact: 3 }));
    let flat = HandSections { xz: None, ..bench.hand() };
    let course = bench.course(vec![hold(), FingerAct::Turn(Plane::Xz)]);
    assert_eq!(flat.motion(&course), Err(TipMotionError::Unfit { step: 0 }));
}

#[test]
fn stances_of_another_hand_are_refused() {
    let bench = Bench::new(ellipse(), facts(3));
    let edits: [fn(&mut Stance); 3] =
        [|start| start.tips_um.truncate(2), |start| start.hold.grasp.push(0), |start| start.hold.grasp[1] = 75];
    for edit in edits {
        let mut course = bench.course(vec![FingerAct::Wait(1)]);
        edit(&mut course.start);
        assert_eq!(bench.hand().motion(&course), Err(TipMotionError::Unfit { step: 0 }));
    }
}

#[test]
fn waits_and_empty_steps() {
    let bench = Bench::new(ellipse(), facts(3));
    let steps = vec![vec![], vec![FingerAct::Wait(7)], vec![FingerAct::Wait(0)], vec![FingerAct::Translate([0.0; 3])]];
    let start = bench.hand().home([0.0; 3]);
    let motion = bench.hand().motion(&FingersCourse { start: start.clone(), steps }).expect("nothing moves");
    let lasting: Vec<Vec<u64>> =
        motion.steps.iter().map(|moves| moves.iter().map(|stretch| stretch.duration_ns).collect()).collect();
    assert_eq!(lasting, [vec![], vec![7], vec![], vec![1]]);
    assert_eq!(end(&motion).tips_um, start.tips_um);
    assert!(motion.steps[3][0].state.is_some());
}
