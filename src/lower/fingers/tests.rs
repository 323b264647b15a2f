//! Lowering of moves.

use super::*;
use crate::claims::fingers::{FingersAction, FingersStep};
use crate::claims::fixture::hand_order;
use crate::device::fingers::Plane;
use crate::device::fingers::fixture::hand;
use crate::plan::fingers::Stance;
use crate::schedule::fingers::FingersState;
use crate::source::Span;
use std::collections::BTreeMap;

/// An order of `steps` steps; their content does not matter here.
fn order(steps: usize) -> FingersOrder {
    let step = |_| FingersStep { action: FingersAction::Release, span: Span::default() };
    hand_order(hand(), (0..steps).map(step).collect())
}

fn hold(grasp: [u32; 3], angle_index: i64) -> HeldGrasp {
    let orientation = [1.0, 0.0, 0.0, 0.0];
    HeldGrasp { grasp: grasp.to_vec(), plane: Plane::Xz, angle_index, position_um: [1.0, 2.0, 3.0], orientation }
}

fn stretch(duration_ns: u64, tips_um: [[f64; 3]; 3], state: Option<HeldGrasp>) -> TipsMove {
    TipsMove { duration_ns, tips_um: tips_um.to_vec(), state }
}

const HOME: [[f64; 3]; 3] = [[10.0, 0.0, 0.0], [-5.0, 8.0, 0.0], [-5.0, -8.0, 0.0]];

/// One finger moves, rests, and moves; then a rest; then nothing; then all move.
fn run(order: &FingersOrder, motion: &FingersMotion) -> Option<LoweredRun> {
    Planned { order, motion: motion.clone() }.run()
}

fn motion() -> FingersMotion {
    let with = |finger: usize, place: [f64; 3]| {
        let mut tips = HOME;
        tips[finger] = place;
        tips
    };
    let far = HOME.map(|tip| tip.map(|value| value + 1.0));
    let first = vec![
        stretch(10, with(0, [9.0, 1.0, 0.0]), None),
        stretch(20, with(0, [8.0, 1.0, 0.0]), Some(hold([1, 38, 0], 1))),
        stretch(30, with(0, [8.0, 1.0, 0.0]), None),
        stretch(5, HOME, Some(hold([0, 38, 7], 2))),
    ];
    let steps = vec![first, vec![stretch(40, HOME, None)], vec![], vec![stretch(1, far, Some(hold([0, 0, 0], 2)))]];
    FingersMotion { start: Stance { tips_um: HOME.to_vec(), hold: hold([0, 0, 0], 1) }, steps }
}

fn by_channel(run: &LoweredRun) -> BTreeMap<&str, Vec<&Actuation>> {
    let mut channels: BTreeMap<&str, Vec<&Actuation>> = BTreeMap::new();
    for actuation in &run.actuations {
        channels.entry(&run.channels[actuation.channel as usize]).or_default().push(actuation);
    }
    channels
}

#[test]
fn every_axis_has_a_value_at_every_instant() {
    let run = run(&order(4), &motion()).expect("it is short");
    assert_eq!(run.duration_ns, 106);
    let channels = by_channel(&run);
    assert_eq!(channels.keys().copied().collect::<Vec<_>>(), {
        let mut names = hand().channels();
        names.sort();
        names
    });
    for (name, actuations) in channels {
        let mut at = (0, None);
        for actuation in actuations {
            assert_eq!(actuation.start_ns, at.0, "{name} has a gap");
            assert!(actuation.duration_ns > 0);
            assert!(at.1.is_none_or(|value| value == actuation.from), "{name} jumps");
            let (_, start_ns, duration_ns) = run.steps[actuation.step as usize];
            let end_ns = actuation.start_ns + actuation.duration_ns;
            assert!(start_ns <= actuation.start_ns && end_ns <= start_ns + duration_ns, "{name} leaves its step");
            at = (end_ns, Some(actuation.to));
        }
        assert_eq!(at.0, run.duration_ns, "{name} ends early");
    }
}

#[test]
fn rests_are_one_stretch_in_each_step() {
    let run = run(&order(4), &motion()).expect("it is short");
    let lasting = |name: &str| -> Vec<(u64, u64, f64, f64)> {
        let own = run.actuations.iter().filter(|a| run.channels[a.channel as usize] == name);
        own.map(|a| (a.start_ns, a.duration_ns, a.from, a.to)).collect()
    };
    assert_eq!(lasting("f3.z"), [(0, 65, 0.0, 0.0), (65, 40, 0.0, 0.0), (105, 1, 0.0, 1.0)]);
    let moving = [(0, 10, 10.0, 9.0), (10, 20, 9.0, 8.0), (30, 30, 8.0, 8.0), (60, 5, 8.0, 10.0), (65, 40, 10.0, 10.0)];
    assert_eq!(lasting("f1.x")[..5], moving);
    assert_eq!(lasting("f1.y")[..3], [(0, 10, 0.0, 1.0), (10, 50, 1.0, 1.0), (60, 5, 1.0, 0.0)]);
}

#[test]
fn actuations_are_sorted_by_start_and_channel() {
    let run = run(&order(4), &motion()).expect("it is short");
    assert_eq!(run.channels, hand().channels());
    let key = |a: &Actuation| (a.start_ns, a.channel);
    assert!(run.actuations.is_sorted_by_key(key));
    assert!(run.actuations.iter().all(|actuation| actuation.swing.is_none()));
}

#[test]
fn steps_follow_one_another() {
    let run = run(&order(4), &motion()).expect("it is short");
    let steps: Vec<(u64, u64)> = run.steps.iter().map(|(_, start_ns, duration_ns)| (*start_ns, *duration_ns)).collect();
    assert_eq!(steps, [(0, 65), (65, 40), (105, 0), (105, 1)]);
}

#[test]
fn states_are_told_with_the_tips_that_hold() {
    let run = run(&order(4), &motion()).expect("it is short");
    let state = |grasp: [u32; 3], angle_index, tips_um: [Option<[f64; 3]>; 3]| {
        State::Fingers(FingersState {
            grasp: grasp.to_vec(),
            angle_index,
            plane: Plane::Xz,
            tips_um: tips_um.to_vec(),
            position_um: [1.0, 2.0, 3.0],
            orientation: [1.0, 0.0, 0.0, 0.0],
        })
    };
    let wanted = [
        (0, state([0, 0, 0], 1, [None; 3])),
        (30, state([1, 38, 0], 1, [Some([8.0, 1.0, 0.0]), Some(HOME[1]), None])),
        (65, state([0, 38, 7], 2, [None, Some(HOME[1]), Some(HOME[2])])),
        (106, state([0, 0, 0], 2, [None; 3])),
    ];
    assert_eq!(run.states, wanted.map(|(t_ns, state)| TimedState { t_ns, state }));
}

#[test]
fn what_a_clock_cannot_count_is_refused() {
    let long = |first: u64| {
        let mut motion = motion();
        motion.steps = vec![vec![stretch(first, HOME, None), stretch(1, HOME, None)]];
        run(&order(1), &motion).map(|run| run.duration_ns)
    };
    assert_eq!(long(u64::MAX - 1), Some(u64::MAX));
    assert_eq!(long(u64::MAX), None);
}
