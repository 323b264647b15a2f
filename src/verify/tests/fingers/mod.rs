use super::{Edit, RECORD, each_alone, each_passes, only, passes, rules};
use crate::claims::fingers::{FingersAction, FingersOrder, FingersTurn};
use crate::device::fingers::{Adhesion, FingersFacts, Plane};
use crate::schedule::fingers::FingersState;
use crate::schedule::{Actuation, Reached, Schedule, State};
use crate::verify::{Rule, Verdict, verify};
use build::*;
use std::sync::Arc;

mod build;
mod garbage;
mod grasps;
mod motion;
mod speed;
mod stages;

/// Two fingers grasp the bead and roll it, the third one replaces the second, and the bead is carried and released.
fn day() -> Day {
    Day::new(order())
        .step(FingersAction::Grasp(Some(vec![1, 38, 0])))
        .come(0, 1)
        .come(1, 38)
        .record()
        .rotate(Plane::Xy, 3)
        .roll(2)
        .come(2, 28)
        .counted()
        .record()
        .roll(1)
        .go(1)
        .counted()
        .record()
        .step(FingersAction::Translate([5.0, -3.0, 2.0]))
        .carry([5.0, -3.0, 2.0])
        .step(FingersAction::Wait(7 * MS))
        .still(7 * MS)
        .step(FingersAction::Release)
        .go(0)
        .go(2)
        .record()
}

/// The order of a bead, with edited facts.
fn with_facts(edit: impl FnOnce(&mut FingersFacts)) -> FingersOrder {
    let mut order = order();
    edit(Arc::make_mut(&mut order.facts));
    order
}

/// The rules that a day breaks.
fn broken(day: &Day) -> Vec<Rule> {
    let (schedule, claims) = day.both();
    rules(&schedule, &claims)
}

/// The lines of one axis, by channel.
fn lines(schedule: &mut Schedule, finger: u32, axis: u32) -> Vec<&mut Actuation> {
    schedule.actuations.iter_mut().filter(|line| line.channel == finger * 3 + axis).collect()
}

/// Moves one tip where two lines of its axis meet.
fn shift(schedule: &mut Schedule, finger: u32, axis: u32, line: usize, by_um: f64) {
    let mut lines = lines(schedule, finger, axis);
    lines[line].to += by_um;
    lines[line + 1].from += by_um;
}

/// Removes one line of an axis.
fn cut(schedule: &mut Schedule, finger: u32, axis: u32, line: usize) {
    let channel = finger * 3 + axis;
    let of_axis = |(at, line): (usize, &Actuation)| (line.channel == channel).then_some(at);
    let at = schedule.actuations.iter().enumerate().filter_map(of_axis).nth(line).expect("a line");
    schedule.actuations.remove(at);
}

/// Index of the first line of the day's second step, among the lines of an axis.
const ROLL: usize = 10;

/// Index of the first line with which the part is carried.
const CARRY: usize = ROLL + 8 + 8 + 5 + 8 + 2;

type StateEdit<'a> = (&'a mut Vec<u32>, &'a mut i64, &'a mut Plane, &'a mut [f64; 3], &'a mut [f64; 4]);

fn with_state(schedule: &mut Schedule, at: usize, edit: impl FnOnce(StateEdit)) {
    let State::Fingers(FingersState { grasp, angle_index, plane, position_um, orientation, .. }) =
        &mut schedule.plans[0].states[at].state
    else {
        panic!("a hand's state")
    };
    edit((grasp, angle_index, plane, position_um, orientation));
}

/// Records a turn of the second step: three steps requested, and a result off by `off_deg`.
fn told_turn(schedule: &mut Schedule, off_deg: f64) {
    let asked_deg = 3.0 * order().part.xy.step_rad.to_degrees();
    let reached_deg = asked_deg + off_deg;
    schedule.steps[1].reached = vec![Reached::Turn { axis: "z".into(), asked_deg, reached_deg, off_deg }];
}

fn figure(schedule: &mut Schedule, name: &str, value: f64) {
    schedule.plans[0].outcomes.insert(name.to_owned(), value);
}

/// Each edit of the day's schedule breaks one rule and no other.
const BROKEN: &[(&str, Rule, Edit)] = &[
    ("an idle axis without a value", Rule::Axis, |s| cut(s, 2, 2, 3)),
    ("an axis without an end", Rule::Axis, |s| cut(s, 1, 0, CARRY + 6)),
    ("an axis without a beginning", Rule::Axis, |s| cut(s, 2, 0, 0)),
    ("an axis that jumps", Rule::Axis, |s| lines(s, 2, 0)[4].from += 2e-6),
    ("a line that ends early", Rule::Axis, |s| lines(s, 2, 1)[4].duration_ns -= 1),
    ("a tip that goes off while it rolls", Rule::Gap, |s| shift(s, 0, 0, ROLL + 11, 0.15)),
    ("a tip that is pressed in while it rolls", Rule::Gap, |s| shift(s, 0, 0, ROLL + 11, -0.15)),
    ("a tip that slips across", Rule::Slip, |s| shift(s, 0, 2, ROLL + 11, 0.15)),
    ("a tip of two that lags in the air", Rule::Slip, |s| shift(s, 0, 2, CARRY, 0.15)),
    ("a finger that moves in a wait", Rule::Wait, |s| shift(s, 1, 2, CARRY + 1, 1e-3)),
    ("a part that ends elsewhere", Rule::State, |s| with_state(s, 2, |state| state.3[1] += 2e-3)),
    ("a part that ends turned", Rule::State, |s| with_state(s, 2, |state| state.4[0] *= -1.0)),
    ("a part that never turned", Rule::State, |s| with_state(s, 3, |state| *state.4 = [1.0, 0.0, 0.0, 0.0])),
    ("no orientation", Rule::State, |s| with_state(s, 3, |state| *state.4 = [0.0; 4])),
    ("another contact", Rule::State, |s| with_state(s, 3, |state| state.0[0] += 1)),
    ("another angle", Rule::State, |s| with_state(s, 3, |state| *state.1 += 1)),
    ("another plane", Rule::State, |s| with_state(s, 3, |state| *state.2 = Plane::Xz)),
    ("a finger less", Rule::State, |s| with_state(s, 3, |state| state.0.truncate(2))),
    ("another start", Rule::Start, |s| with_state(s, 0, |state| state.3[0] += 2e-3)),
    ("a grasp at first", Rule::Start, |s| with_state(s, 0, |state| state.0[0] = 1)),
    ("a state too early", Rule::State, |s| s.plans[0].states[2].t_ns -= 1),
    ("a state in the middle too late", Rule::State, |s| s.plans[0].states[2].t_ns += 1),
    ("a state in the middle less", Rule::State, |s| drop(s.plans[0].states.remove(4))),
    ("a turn that is said to reach more", Rule::Figure, |s| told_turn(s, 0.011)),
    ("a turn that is said to reach less", Rule::Figure, |s| told_turn(s, -0.011)),
    ("something that a wait reaches", Rule::Figure, |s| {
        told_turn(s, 0.0);
        s.steps[3].reached = std::mem::take(&mut s.steps[1].reached);
    }),
    ("a turn to no number", Rule::Number, |s| told_turn(s, f64::NAN)),
    ("another effort", Rule::Figure, |s| figure(s, "effort_deg", 1.0)),
    ("another number of changes", Rule::Figure, |s| figure(s, "reconfigurations", 3.0)),
    ("another cost", Rule::Figure, |s| s.plans[0].cost += 1e-3),
    ("another planner", Rule::Figure, |s| s.plans[0].planner = "greedy_decomposition".into()),
    ("another channel", Rule::Channel, |s| s.channels[0].name = "hand.f4.x".into()),
    ("a voltage", Rule::Channel, |s| s.channels[0].unit = crate::schedule::ChannelUnit::Volt),
    ("a swing", Rule::Swing, |s| {
        let line = &mut s.actuations[0];
        line.swing = Some(crate::schedule::Swing { period_ns: 2, levels: [line.from, line.to] });
    }),
];

#[test]
fn the_day_is_sound() {
    let (schedule, claims) = day().both();
    assert_eq!(schedule.plans[0].outcomes["reconfigurations"], 2.0);
    assert!((schedule.plans[0].cost - (2.0 * 20.0 * 2.0 + 3.0 * 20.0 + 360.0)).abs() < 1e-9);
    passes(&schedule, &claims);
}

#[test]
fn each_break_is_caught_by_its_rule_alone() {
    let (schedule, claims) = day().both();
    each_alone(&schedule, &claims, &[BROKEN, RECORD].concat());
}

#[test]
fn what_lies_within_the_tolerances_passes() {
    let near: &[(&str, Edit)] = &[
        ("a jump of rounding", |s| lines(s, 2, 0)[4].from += 5e-7),
        ("a tip a little off", |s| shift(s, 0, 0, ROLL + 11, 0.09)),
        ("a tip a little in", |s| shift(s, 0, 0, ROLL + 11, -0.09)),
        ("a tip a little across", |s| shift(s, 0, 2, ROLL + 11, 0.09)),
        ("what is reached", |s| told_turn(s, 0.0)),
        ("what is reached, rounded", |s| told_turn(s, 0.004)),
        ("a place", |s| with_state(s, 2, |state| state.3[1] += 9e-4)),
        ("an orientation", |s| with_state(s, 2, |state| state.4[1] += 4e-5)),
        ("a removal reported when the finger is home", |s| s.plans[0].states[6].t_ns -= 100 * MS),
        ("a place reported later", |s| s.plans[0].states[7].t_ns += 5 * MS),
        ("another angle where none turns", |s| with_state(s, 8, |state| *state.1 = 1)),
        ("another plane where nothing holds", |s| with_state(s, 0, |state| *state.2 = Plane::Xz)),
    ];
    let (schedule, claims) = day().both();
    each_passes(&schedule, &claims, near);
}

/// One run continues where the one before it ended.
#[test]
fn a_hand_goes_on_where_it_was() {
    let first =
        Day::new(order()).step(FingersAction::Grasp(None)).come(0, 1).come(1, 38).record().rotate(Plane::Xy, 2).roll(2);
    let second = first.after(order()).rotate(Plane::Xy, -2).roll(-2);
    let claims = in_turn(vec![first.order.clone(), second.order.clone()]);
    let days = [first, second];
    let sound = schedule(&claims, &days);
    passes(&sound, &claims);
    let mut jumps = sound.clone();
    let start_ns = jumps.plans[1].start_ns;
    jumps.actuations.iter_mut().find(|line| line.start_ns == start_ns).expect("a line").from += 1e-5;
    only(Rule::Axis, &jumps, &claims);
    let mut other = sound.clone();
    let State::Fingers(FingersState { grasp, .. }) = &mut other.plans[1].states[0].state else {
        panic!("a hand's state")
    };
    grasp[0] += 1;
    only(Rule::Start, &other, &claims);
}
