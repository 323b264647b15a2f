use super::{Edit, RECORD, each_alone, only, passes, rules, why};
use crate::claims::Claims;
use crate::claims::electrode_array::{
    Bystanders, ElectrodeArrayAction, ElectrodeArrayMove, ElectrodeArrayObjective, ElectrodeArrayObstacleBody,
    ElectrodeArrayOrder,
};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell, ElectrodeMap, Hold, Separation};
use crate::schedule::electrode_array::ElectrodeArrayState;
use crate::schedule::{PartCells, Schedule, State, Swing};
use crate::verify::{Rule, Verdict, verify};
use build::*;
use std::sync::Arc;

mod after;
mod assay;
mod broadcast;
mod build;
mod garbage;
mod lags;
mod merging;
mod pairs;
mod placed;
mod random;
mod reservoirs;
mod teams;
mod traces;
mod zones;

/// Three microparts: `a` goes right and `b` up, then all wait, then `b` comes back by a detour; `c` stays.
fn day() -> Claims {
    let steps = vec![
        ElectrodeArrayAction::Move(vec![go(0, &[(8, 5)]), go(1, &[(5, 14)])]),
        ElectrodeArrayAction::Wait(7_000_000),
        ElectrodeArrayAction::Move(vec![go(1, &[(6, 14), (5, 12)])]),
    ];
    alone(order(platform(20, 20), &[("a", 5, 5), ("b", 5, 12), ("c", 15, 15)], steps))
}

const DAY: Words = &[&[&["RRR", "U.U", ""], &[], &["", "RDDL", ""]]];

/// Each edit of the day's schedule breaks one rule and no other.
const BROKEN: &[(&str, Rule, Edit)] = &[
    ("a little more potential", Rule::Potential, |s| s.actuations[0].from = 100.000_000_1),
    ("a little less potential", Rule::Potential, |s| s.actuations[3].to = 99.999_999_9),
    ("the other sign", Rule::Potential, |s| (s.actuations[1].from, s.actuations[1].to) = (-100.0, -100.0)),
    ("an electrode that swings", Rule::Swing, |s| {
        s.actuations[0].swing = Some(Swing { period_ns: BEAT, levels: [100.0; 2] });
    }),
    ("on a little late", Rule::Beat, |s| {
        let last = s.actuations.last_mut().unwrap();
        (last.start_ns, last.duration_ns) = (last.start_ns + 1, last.duration_ns - 1);
    }),
    ("off a little early", Rule::Beat, |s| s.actuations[0].duration_ns -= 1),
    ("a step that lasts a little longer", Rule::Beat, |s| {
        s.steps[2].duration_ns += 1;
        s.plans[0].duration_ns += 1;
        s.duration_ns += 1;
    }),
    ("half a pair", Rule::Pull, |s| {
        s.actuations.remove(0);
    }),
    ("one electrode near a resting part", Rule::Pull, |s| switch_on(s, 13, 13, 0, 0, 1)),
    ("one right under a resting part", Rule::Pull, |s| switch_on(s, 15, 15, 2, 1, 1)),
    ("one beside the pair", Rule::Pull, |s| switch_on(s, 5, 5, 0, 0, 1)),
    ("one that only the end of a move feels", Rule::Pull, |s| switch_on(s, 8, 7, 0, 0, 1)),
    ("one that pulls nothing", Rule::Unused, |s| switch_on(s, 12, 15, 0, 0, 1)),
    ("one in a wait that pulls nothing", Rule::Unused, |s| {
        switch_on(s, 18, 2, 1, 0, 1);
        s.actuations.iter_mut().filter(|a| a.step == 1).for_each(|a| a.duration_ns = 7_000_000);
    }),
    ("a move in a wait", Rule::Wait, |s| {
        switch_on(s, 17, 14, 1, 0, 1);
        switch_on(s, 17, 16, 1, 0, 1);
        s.actuations.iter_mut().filter(|a| a.step == 1).for_each(|a| a.duration_ns = 7_000_000);
    }),
    ("half a wait", Rule::Beat, |s| switch_on(s, 18, 2, 1, 0, 1)),
    ("a move of a part without a goal", Rule::Bystander, |s| {
        switch_on(s, 17, 14, 0, 0, 1);
        switch_on(s, 17, 16, 0, 0, 1);
    }),
    ("another start", Rule::Start, |s| parts(s, 0).set("a", Some([5, 6]))),
    ("a start without a part", Rule::Start, |s| parts(s, 0).set("c", None)),
    ("another state", Rule::State, |s| parts(s, 2).set("b", Some([5, 12]))),
    ("a part too many", Rule::State, |s| parts(s, 3).set("d", Some([1, 1]))),
    ("another cost", Rule::Figure, |s| (s.plans[0].cost, s.plans[0].bound) = (6.0, 6.0)),
    ("an unknown outcome", Rule::Figure, |s| s.plans[0].outcomes.extend([("energy_j".to_owned(), 1.0)])),
    ("a channel that the board does not have", Rule::Channel, |s| s.channels[0].name = "board.e21_4".into()),
    ("a channel written otherwise", Rule::Channel, |s| s.channels[0].name = "board.e07_4".into()),
];

fn parts(schedule: &mut Schedule, state: usize) -> &mut PartCells {
    let State::ElectrodeArray(ElectrodeArrayState { parts }) = &mut schedule.plans[0].states[state].state else {
        panic!("a board's state")
    };
    parts
}

#[test]
fn the_day_is_sound() {
    let schedule = schedule(&day(), DAY);
    assert_eq!(schedule.duration_ns, 7 * BEAT + 7_000_000);
    assert_eq!(schedule.plans[0].outcomes["sum_of_costs"], 10.0);
    assert_eq!(schedule.plans[0].outcomes["moves"], 9.0);
    passes(&schedule, &day());
}

#[test]
fn each_break_is_caught_by_its_rule_alone() {
    each_alone(&schedule(&day(), DAY), &day(), &[BROKEN, RECORD].concat());
}

#[test]
fn the_same_electrode_may_be_on_in_two_pieces() {
    let mut near = schedule(&day(), &[&[&["RRR", "U.U", ""], &[], &["", "RDDL", ""]]]);
    let long = near.actuations.iter().position(|actuation| actuation.duration_ns == 2 * BEAT);
    assert_eq!(long, None, "pairs of microparts change with every beat");
    near.steps[0].text = "go".into();
    passes(&near, &day());
}

#[test]
fn the_cost_is_that_of_the_objective() {
    let mut claims = day();
    order_of(&mut claims, 0).objective = ElectrodeArrayObjective::SumOfCosts;
    let mut schedule = schedule(&claims, DAY);
    passes(&schedule, &claims);
    (schedule.plans[0].cost, schedule.plans[0].bound) = (7.0, 7.0);
    only(Rule::Figure, &schedule, &claims);
}

#[test]
fn messages_name_cells_parts_times_and_limits() {
    let reported = |edit: Edit| {
        let mut broken = schedule(&day(), DAY);
        edit(&mut broken);
        let Verdict::Rejected(found) = verify(broken, &day()) else { panic!("a broken schedule") };
        found[0].title.clone()
    };
    let stray = reported(|s| switch_on(s, 13, 13, 0, 1, 1));
    assert_eq!(stray, "electrodes (13, 13) at 2.2 ms pull `c` from (15, 15) in no single direction");
    let late = reported(|s| switch_on(s, 8, 7, 0, 0, 1));
    assert_eq!(late, "electrode (8, 7) also pulls `a` at (6, 5), at 0 ms");
    let unused = reported(|s| switch_on(s, 12, 15, 0, 2, 1));
    assert_eq!(unused, "electrode (12, 15) is on at 4.4 ms but pulls no part");
    let weak = reported(|s| s.actuations[0].to = 50.0);
    assert_eq!(weak, "electrode (4, 14) goes from 100 V to 50 V at 0 ms; 100 V is needed");
}

/// A schedule of a single step, with one word for each part.
fn one_step(order: ElectrodeArrayOrder, words: &[&str]) -> (Schedule, Claims) {
    let claims = alone(order);
    (schedule(&claims, &[&[words]]), claims)
}

fn moving(
    facts: crate::device::electrode_array::ElectrodeArrayFacts,
    parts: &[(&str, u32, u32)],
    moves: Vec<ElectrodeArrayMove>,
) -> ElectrodeArrayOrder {
    order(facts, parts, vec![ElectrodeArrayAction::Move(moves)])
}

#[track_caller]
fn judged(order: ElectrodeArrayOrder, words: &[&str], expected: &[Rule]) {
    let (schedule, claims) = one_step(order, words);
    assert_eq!(rules(&schedule, &claims), expected, "{words:?}");
}

#[test]
fn stops_are_reached_in_their_order() {
    let tour = |stops: &[(u32, u32)]| moving(platform(12, 12), &[("a", 4, 4)], vec![go(0, stops)]);
    judged(tour(&[(5, 4), (6, 4), (6, 5)]), &["RRU"], &[]);
    judged(tour(&[(4, 4), (6, 5)]), &["RRU"], &[]);
    judged(tour(&[(6, 4), (5, 4), (6, 5)]), &["RRU"], &[Rule::Goal]);
    judged(tour(&[(6, 5), (6, 6)]), &["RRU"], &[Rule::Goal]);
    judged(tour(&[(6, 4)]), &["RRU"], &[Rule::Goal]);
    judged(tour(&[(6, 6)]), &["RRU"], &[Rule::Goal]);
    judged(tour(&[(4, 4)]), &[""], &[]);
    judged(tour(&[(4, 5)]), &[""], &[Rule::Goal]);
}

#[test]
fn a_step_ends_with_the_last_arrival() {
    let two = || moving(platform(20, 12), &[("a", 4, 4), ("b", 14, 4)], vec![go(0, &[(6, 4)]), go(1, &[(14, 5)])]);
    judged(two(), &["RR", "U"], &[]);
    judged(two(), &[".RR", "..U"], &[]);
    judged(two(), &["..RR", "U"], &[]);
    judged(two(), &["RR.", "U"], &[Rule::Idle]);
    judged(two(), &["RR", "U.."], &[Rule::Idle]);
}

#[test]
fn parts_without_a_goal_come_back() {
    let order = |bystanders| ElectrodeArrayOrder {
        bystanders,
        ..moving(platform(20, 12), &[("a", 4, 4), ("b", 14, 4)], vec![go(0, &[(7, 4)])])
    };
    judged(order(Bystanders::Yield), &["RRR", "UD"], &[]);
    judged(order(Bystanders::Yield), &["RRR", "URDL"], &[]);
    judged(order(Bystanders::Yield), &["RRR", "U"], &[Rule::Bystander]);
    judged(order(Bystanders::Yield), &["RRR", "URD"], &[Rule::Bystander]);
    judged(order(Bystanders::Stay), &["RRR", "UD"], &[Rule::Bystander]);
    judged(order(Bystanders::Stay), &["RRR", ""], &[]);
}

#[test]
fn parts_keep_the_separation_of_the_device() {
    let apart = |separation, second: u32, ends: [(u32, u32); 2]| {
        let facts = crate::device::electrode_array::ElectrodeArrayFacts { separation, ..platform(30, 12) };
        moving(facts, &[("a", 5, 5), ("b", second, 5)], vec![go(0, &[ends[0]]), go(1, &[ends[1]])])
    };
    for separation in [Separation::Apart(4), Separation::AsPublished] {
        judged(apart(separation, 9, [(4, 5), (10, 5)]), &["L", "R"], &[]);
        judged(apart(separation, 8, [(4, 5), (9, 5)]), &["L", "R"], &[Rule::Touch]);
        judged(apart(separation, 9, [(5, 6), (9, 5)]), &["U", ""], &[]);
        judged(apart(separation, 10, [(6, 5), (11, 5)]), &["R", "R"], &[]);
        judged(apart(separation, 9, [(6, 5), (10, 5)]), &["R", "R"], &[Rule::Pull]);
        judged(apart(separation, 11, [(6, 5), (10, 5)]), &["R", "L"], &[]);
        judged(apart(separation, 10, [(6, 5), (9, 5)]), &["R", "L"], &[Rule::Pull]);
    }
    let five = Separation::Apart(5);
    judged(apart(five, 11, [(6, 5), (12, 5)]), &["R", "R"], &[]);
    judged(apart(five, 10, [(6, 5), (11, 5)]), &["R", "R"], &[Rule::Touch]);
    judged(apart(five, 9, [(4, 5), (10, 5)]), &["L", "R"], &[Rule::Touch]);
    let wide = apart(Separation::Apart(20), 25, [(4, 5), (25, 5)]);
    judged(wide, &["L", ""], &[]);
    judged(apart(Separation::Apart(21), 25, [(4, 5), (25, 5)]), &["L", ""], &[Rule::Touch]);
}

#[test]
fn bodies_never_overlap_whatever_the_separation() {
    let wide = |half_width, second| {
        let mut facts = chip(20, 8);
        facts.layout.half_width_pitches = half_width;
        moving(facts, &[("a", 5, 5), ("b", second, 5)], vec![go(0, &[(4, 5)])])
    };
    judged(wide(1.0, 7), &["L", ""], &[]);
    judged(wide(1.01, 7), &["L", ""], &[Rule::Touch]);
    judged(wide(1.01, 8), &["L", ""], &[]);
}

#[test]
fn centres_keep_the_clearance_from_covered_electrodes() {
    let wall = |from, to| {
        let mut order = moving(platform(20, 12), &[("a", 5, 5)], vec![go(0, &[(7, 5)])]);
        order.obstacles = Arc::new(vec![obstacle("wall", ElectrodeArrayObstacleBody::Electrodes { from, to })]);
        order
    };
    judged(wall(cell(10, 1), cell(11, 12)), &["RR"], &[]);
    judged(wall(cell(9, 1), cell(9, 12)), &["RR"], &[Rule::Clearance]);
    judged(wall(cell(9, 8), cell(12, 9)), &["RR"], &[]);
    judged(wall(cell(9, 7), cell(9, 7)), &["RR"], &[Rule::Clearance]);
    judged(wall(cell(3, 7), cell(3, 7)), &["RR"], &[Rule::Clearance]);
    judged(wall(cell(2, 1), cell(2, 12)), &["RR"], &[]);
}

#[test]
fn stuck_parts_are_parts_that_never_move() {
    let stuck = |at| {
        let mut order = moving(platform(20, 12), &[("a", 5, 5)], vec![go(0, &[(7, 5)])]);
        order.obstacles = Arc::new(vec![obstacle("stuck", ElectrodeArrayObstacleBody::Fixed(at))]);
        order
    };
    judged(stuck(cell(11, 5)), &["RR"], &[]);
    judged(stuck(cell(10, 5)), &["RR"], &[Rule::Pull]);
    judged(stuck(cell(11, 9)), &["RR"], &[]);
    judged(stuck(cell(2, 8)), &["RR"], &[Rule::Touch]);
    judged(stuck(cell(1, 8)), &["RR"], &[]);
    let (mut schedule, claims) = one_step(stuck(cell(15, 9)), &["RR"]);
    switch_on(&mut schedule, 13, 7, 0, 1, 1);
    only(Rule::Pull, &schedule, &claims);
}

#[test]
fn parts_stand_where_the_last_run_left_them() {
    let step = |goal| vec![ElectrodeArrayAction::Move(vec![go(0, &[goal])])];
    let task = |goal| order(platform(12, 12), &[("a", 4, 4), ("b", 10, 10)], step(goal));
    let claims = in_turn(vec![task((6, 4)), task((6, 5)), task((4, 4))]);
    let words: Words = &[&[&["RR"]], &[&["U"]], &[&["DLL"]]];
    let sound = schedule(&claims, words);
    passes(&sound, &claims);
    let mut early = sound.clone();
    let State::ElectrodeArray(ElectrodeArrayState { parts }) = &mut early.plans[1].states[0].state else {
        panic!("a board's state")
    };
    parts.set("a", Some([4, 4]));
    only(Rule::Start, &early, &claims);
    let mut lost = sound.clone();
    lost.actuations.remove(0);
    only(Rule::Pull, &lost, &claims);
}

#[test]
fn a_wait_lasts_as_claimed() {
    let claims =
        |duration_ns| alone(order(platform(12, 12), &[("a", 4, 4)], vec![ElectrodeArrayAction::Wait(duration_ns)]));
    passes(&schedule(&claims(5), &[&[&[]]]), &claims(5));
    only(Rule::Wait, &schedule(&claims(5), &[&[&[]]]), &claims(6));
    passes(&schedule(&claims(0), &[&[&[]]]), &claims(0));
    passes(&schedule(&claims(u64::MAX), &[&[&[]]]), &claims(u64::MAX));
}

/// The droplet's path is the same on all three boards; the electrodes along it differ.
#[test]
fn no_electrode_is_on_that_does_not_work_or_is_not_there() {
    let claims = |gaps: &[ElectrodeCell], disabled: &[ElectrodeCell]| {
        let board = chip(12, 12);
        let place = |index: u32| cell(index % 12 + 1, index / 12 + 1);
        let channels = (0..144).map(|index| (!gaps.contains(&place(index))).then_some(index)).collect();
        let map = ElectrodeMap { columns: 12, channels, disabled: disabled.to_vec() };
        let facts = ElectrodeArrayFacts { map: Some(Arc::new(map)), ..board };
        alone(order(facts, &[("a", 4, 4)], vec![ElectrodeArrayAction::Move(vec![go(0, &[(6, 4)])])]))
    };
    let whole = claims(&[], &[]);
    let schedule = schedule(&whole, &[&[&["RR"]]]);
    passes(&schedule, &whole);
    passes(&schedule, &claims(&[cell(5, 5)], &[cell(4, 3), cell(6, 5)]));
    only(Rule::Disabled, &schedule, &claims(&[], &[cell(5, 4)]));
    only(Rule::Disabled, &schedule, &claims(&[], &[cell(6, 4)]));
    only(Rule::Channel, &schedule, &claims(&[cell(5, 4)], &[]));
}

#[test]
fn held_droplets_are_held_all_the_time() {
    let steps = || {
        vec![
            ElectrodeArrayAction::Move(vec![go(0, &[(6, 4)])]),
            ElectrodeArrayAction::Wait(BEAT),
            ElectrodeArrayAction::Move(vec![go(0, &[(6, 5)])]),
        ]
    };
    let claims = |hold| {
        let facts = crate::device::electrode_array::ElectrodeArrayFacts { hold, ..chip(12, 12) };
        alone(order(facts, &[("a", 4, 4), ("b", 9, 9)], steps()))
    };
    let words: Words = &[&[&["R.R", ""], &[], &["U", ""]]];
    for hold in [Hold::On, Hold::Off] {
        passes(&schedule(&claims(hold), words), &claims(hold));
    }
    let on = schedule(&claims(Hold::On), words);
    let off = schedule(&claims(Hold::Off), words);
    only(Rule::Hold, &on, &claims(Hold::Off));
    only(Rule::Hold, &off, &claims(Hold::On));
    for index in 0..on.actuations.len() {
        let mut less = on.clone();
        less.actuations.remove(index);
        only(Rule::Hold, &less, &claims(Hold::On));
    }
    let mut under = off.clone();
    switch_on(&mut under, 9, 9, 1, 0, 1);
    only(Rule::Hold, &under, &claims(Hold::Off));
    let mut torn = on.clone();
    switch_on(&mut torn, 9, 10, 1, 0, 1);
    only(Rule::Pull, &torn, &claims(Hold::On));
    let mut pieces = on;
    let long = pieces.actuations.iter().position(|a| a.duration_ns == 3 * BEAT).expect("a held droplet");
    let mut second = pieces.actuations[long];
    pieces.actuations[long].duration_ns = BEAT;
    (second.start_ns, second.duration_ns) = (second.start_ns + BEAT, 2 * BEAT);
    pieces.actuations.push(second);
    pieces.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
    passes(&pieces, &claims(Hold::On));
}

#[test]
fn a_task_without_steps_still_needs_parts_that_stand_clear() {
    let stand = |second| alone(order(platform(20, 20), &[("a", 5, 5), ("b", second, 5)], vec![]));
    passes(&schedule(&stand(9), &[&[]]), &stand(9));
    only(Rule::Touch, &schedule(&stand(8), &[&[]]), &stand(8));
    only(Rule::Touch, &schedule(&stand(5), &[&[]]), &stand(5));
}
