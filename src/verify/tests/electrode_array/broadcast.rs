//! Shared channels: all electrodes of a channel are on together, and every droplet in reach is judged against all of
//! them.

use super::build::*;
use super::{judged, moving, one_step, rules, why};
use crate::claims::Claims;
use crate::claims::electrode_array::{ElectrodeArrayAction, ElectrodeArrayObstacleBody, ElectrodeArrayOrder};
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell, ElectrodeMap, Hold};
use crate::schedule::Schedule;
use crate::verify::Rule;
use std::sync::Arc;

/// Lists of electrodes; each list shares one channel.
type Lists<'a> = &'a [&'a [(u32, u32)]];

/// A board of droplets on which the electrodes of each list share a channel.
fn shared(columns: u32, rows: u32, lists: Lists) -> ElectrodeArrayFacts {
    let mut channels: Vec<Option<u32>> = (0..columns * rows).map(|place| Some(1000 + place)).collect();
    for (number, list) in (0..).zip(lists) {
        for (column, row) in *list {
            channels[((row - 1) * columns + column - 1) as usize] = Some(number);
        }
    }
    let map = ElectrodeMap { columns, channels, disabled: Vec::new() };
    ElectrodeArrayFacts { map: Some(Arc::new(map)), ..chip(columns, rows) }
}

const BROADCAST: &[Rule] = &[Rule::Broadcast];

/// One droplet goes two cells to the right; another electrode shares the channel of the first cell that it comes to.
fn alone_with(other: (u32, u32), expected: &[Rule]) {
    judged(moving(shared(9, 9, &[&[(5, 5), other]]), &[("a", 4, 5)], vec![go(0, &[(6, 5)])]), &["RR"], expected);
}

#[test]
fn another_electrode_in_reach_of_the_droplet_that_moves_tears_it() {
    // Beside its start, its next cell and its goal; two columns from both ends it does no harm.
    for near in [(3, 5), (3, 4), (4, 6), (5, 6), (6, 5), (6, 6), (6, 4)] {
        alone_with(near, BROADCAST);
    }
    for far in [(2, 5), (7, 5), (5, 7), (4, 3), (9, 9), (1, 1)] {
        alone_with(far, &[]);
    }
}

#[test]
fn a_droplet_that_is_held_may_be_torn_as_well() {
    let resting = |other: (u32, u32), expected: &[Rule]| {
        let facts = shared(9, 9, &[&[(4, 5), other]]);
        judged(moving(facts, &[("a", 4, 5), ("b", 8, 8)], vec![go(1, &[(8, 9)])]), &["", "U"], expected);
    };
    resting((5, 6), BROADCAST);
    resting((2, 5), &[]);
    // An electrode beside the other droplet shares a channel with the one that holds the first.
    resting((7, 8), BROADCAST);
    resting((6, 8), &[]);
}

#[test]
fn what_moves_one_droplet_pulls_another() {
    let beside = |other: (u32, u32), word: &str, expected: &[Rule]| {
        let goal = if word.is_empty() {
            Vec::new()
        } else {
            vec![go(1, &[moved(cell(8, 5), word.chars().next().unwrap()).pair().into()])]
        };
        let moves = std::iter::once(go(0, &[(3, 5)])).chain(goal).collect();
        judged(moving(shared(12, 9, &[&[(3, 5), other]]), &[("a", 2, 5), ("b", 8, 5)], moves), &["R", word], expected);
    };
    // Near a resting droplet, before it moves and after; a shared electrode at its own destination is on for both.
    beside((9, 6), "", BROADCAST);
    beside((10, 5), "", &[]);
    beside((10, 5), "R", BROADCAST);
    beside((7, 5), "R", BROADCAST);
    beside((9, 5), "R", &[]);
    beside((9, 5), "L", BROADCAST);
    beside((6, 6), "L", BROADCAST);
    // The electrode that holds it is on anyway.
    beside((8, 5), "", &[]);
    beside((8, 5), "R", BROADCAST);
}

/// The schedule of a three-phase bus with one droplet, and edits that only this rule catches.
#[test]
fn an_edit_of_what_is_on_is_caught_by_this_rule_alone() {
    let lists: [&[(u32, u32)]; 3] =
        [&[(1, 1), (4, 1), (7, 1)], &[(2, 1), (5, 1), (8, 1)], &[(3, 1), (6, 1), (9, 1), (1, 3)]];
    let bus = || moving(shared(9, 3, &lists), &[("a", 1, 1), ("c", 9, 3)], vec![go(0, &[(5, 1)])]);
    judged(bus(), &["RRRR", ""], &[]);
    let names = |schedule: &Schedule| -> Vec<String> { schedule.channels.iter().map(|own| own.name.clone()).collect() };
    let (schedule, _) = one_step(bus(), &["RRRR", ""]);
    assert_eq!(names(&schedule), ["board.e2_1", "board.e3_1", "board.e1_1", "board.e9_3"]);
    // An additional phase, one that lasts too long, and one that begins too early.
    let edited = |edit: &dyn Fn(&mut Schedule)| {
        let (mut schedule, claims) = one_step(bus(), &["RRRR", ""]);
        edit(&mut schedule);
        schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
        assert_eq!(rules(&schedule, &claims), BROADCAST);
    };
    edited(&|schedule| switch_on(schedule, 3, 1, 0, 0, 1));
    edited(&|schedule| schedule.actuations[0].duration_ns += BEAT);
    edited(&|schedule| {
        let third = schedule.actuations.iter_mut().find(|own| own.start_ns == 2 * BEAT).expect("the third step");
        (third.start_ns, third.duration_ns) = (BEAT, 2 * BEAT);
    });
    // A channel has the name of its first electrode and no other.
    let (mut schedule, claims) = one_step(bus(), &["RRRR", ""]);
    schedule.channels.iter_mut().filter(|own| own.name == "board.e2_1").for_each(|own| own.name = "board.e5_1".into());
    assert_eq!(rules(&schedule, &claims), [Rule::Channel]);
}

/// The electrodes that are on for each part are the same on boards of all wirings; on some, their channels switch
/// further electrodes.
#[test]
fn the_same_moves_keep_the_rule_or_break_it_by_the_channels_of_the_board() {
    let moves = || vec![go(0, &[(5, 5)]), go(1, &[(8, 8)])];
    let cases: [(Lists, &[Rule]); 5] = [
        (&[], &[]),
        (&[&[(3, 5), (12, 1)]], &[]),
        (&[&[(3, 5), (9, 5)]], BROADCAST),
        (&[&[(4, 5), (8, 8)]], BROADCAST),
        (&[&[(5, 5), (8, 8)]], &[]),
    ];
    for (lists, expected) in cases {
        judged(moving(shared(12, 9, lists), &[("a", 2, 5), ("b", 8, 5)], moves()), &["RRR", "UUU"], expected);
    }
}

#[test]
fn a_wait_holds_all_electrodes_of_a_channel() {
    let waiting = |other: (u32, u32)| {
        let order = order(
            shared(9, 9, &[&[(4, 5), other]]),
            &[("a", 4, 5), ("b", 8, 8)],
            vec![ElectrodeArrayAction::Wait(BEAT)],
        );
        let (schedule, claims) = one_step(order, &[""]);
        rules(&schedule, &claims)
    };
    assert_eq!(waiting((2, 5)), []);
    assert_eq!(waiting((7, 7)), BROADCAST);
    assert_eq!(waiting((4, 4)), BROADCAST);
    assert_eq!(waiting((8, 8)), []);
}

#[test]
fn stuck_parts_are_pulled_by_no_electrode_of_a_channel() {
    let stuck = |other: (u32, u32), expected: &[Rule]| {
        let order = moving(shared(9, 9, &[&[(4, 5), other]]), &[("a", 3, 5)], vec![go(0, &[(4, 5)])]);
        let fixed = obstacle("s", ElectrodeArrayObstacleBody::Fixed(cell(8, 8)));
        judged(ElectrodeArrayOrder { obstacles: vec![fixed].into(), ..order }, &["R"], expected);
    };
    stuck((7, 7), BROADCAST);
    stuck((8, 8), BROADCAST);
    stuck((6, 8), &[]);
}

#[test]
fn an_electrode_that_does_not_work_pulls_nothing_though_its_channel_is_on() {
    let dead = |disabled: &[ElectrodeCell], expected: &[Rule]| {
        let facts = shared(9, 9, &[&[(5, 5), (4, 6)]]);
        let map = ElectrodeMap { disabled: disabled.to_vec(), ..(**facts.map.as_ref().expect("a map")).clone() };
        let facts = ElectrodeArrayFacts { map: Some(Arc::new(map)), ..facts };
        judged(moving(facts, &[("a", 4, 5)], vec![go(0, &[(5, 5)])]), &["R"], expected);
    };
    dead(&[], BROADCAST);
    dead(&[cell(4, 6)], &[]);
    // A channel without a working electrode is not switched.
    let facts = shared(9, 9, &[&[(7, 7), (7, 9)]]);
    let map = ElectrodeMap { disabled: vec![cell(7, 7), cell(7, 9)], ..(**facts.map.as_ref().expect("a map")).clone() };
    let facts = ElectrodeArrayFacts { map: Some(Arc::new(map)), ..facts };
    let (mut schedule, claims) = one_step(moving(facts, &[("a", 4, 5)], vec![go(0, &[(5, 5)])]), &["R"]);
    switch_on(&mut schedule, 7, 7, 0, 0, 1);
    assert_eq!(rules(&schedule, &claims), [Rule::Disabled]);
}

#[test]
fn without_holding_a_droplet_may_rest_on_an_electrode_that_is_on_for_another() {
    let unheld = |other: (u32, u32), word: &str, expected: &[Rule]| {
        let facts = ElectrodeArrayFacts { hold: Hold::Off, ..shared(12, 9, &[&[(3, 5), other]]) };
        let words = [word, ""];
        judged(moving(facts, &[("a", 2, 5), ("b", 8, 5)], vec![go(0, &[(4, 5)])]), &words, expected);
    };
    unheld((8, 5), "RR", &[]);
    unheld((8, 6), "RR", &[Rule::Bystander]);
    unheld((9, 6), "RR", BROADCAST);
    unheld((10, 5), "RR", &[]);
    // An electrode that is on for no moving droplet holds this one, which the device does not allow.
    let facts = ElectrodeArrayFacts { hold: Hold::Off, ..shared(12, 9, &[&[(8, 5), (12, 9)]]) };
    let (mut schedule, claims) =
        one_step(moving(facts, &[("a", 2, 5), ("b", 8, 5)], vec![go(0, &[(4, 5)])]), &["RR", ""]);
    switch_on(&mut schedule, 8, 5, 0, 0, 1);
    assert_eq!(rules(&schedule, &claims), [Rule::Hold]);
    // An electrode that is on for no droplet is unused.
    let (mut schedule, claims) =
        one_step(moving(shared(12, 9, &[&[(11, 5), (12, 9)]]), &[("a", 2, 5)], vec![go(0, &[(4, 5)])]), &["RR"]);
    switch_on(&mut schedule, 11, 5, 0, 0, 1);
    assert_eq!(rules(&schedule, &claims), [Rule::Unused]);
}

#[test]
fn droplets_merge_and_split_by_their_own_electrodes_alone() {
    let merging = |lists: Lists, expected: &[Rule]| {
        let order = moving(shared(12, 9, lists), &[("a", 3, 5), ("b", 7, 5)], vec![merge(0, 1, (5, 5))]);
        judged(order, &["RR", "LL"], expected);
    };
    merging(&[], &[]);
    // Both arrive at once over one channel, and over one that tears one of them.
    merging(&[&[(4, 5), (6, 5)]], &[]);
    merging(&[&[(5, 5), (1, 1)]], &[]);
    merging(&[&[(5, 5), (7, 6)]], BROADCAST);
    // The goal is on too early, for neither of them.
    merging(&[&[(4, 5), (5, 5)]], BROADCAST);
    let (schedule, claims) = split_of(&[]);
    assert_eq!(rules(&schedule, &claims), []);
    let (schedule, claims) = split_of(&[&[(4, 5), (6, 5)]]);
    assert_eq!(rules(&schedule, &claims), [], "one channel pulls at both ends");
    let (schedule, claims) = split_of(&[&[(6, 5), (5, 7)], &[(4, 5), (3, 6)]]);
    assert!(rules(&schedule, &claims).contains(&Rule::Broadcast));
}

/// `a` goes to (5, 5) and is split there, to (4, 5) and (6, 5).
fn split_of(lists: Lists) -> (Schedule, Claims) {
    let order = assay(&[("a", 4, 5), ("h", 1, 1)], vec![split(1, 0, (5, 5), (6, 5))]);
    one_step(without_places(ElectrodeArrayOrder { facts: shared(14, 14, lists), ..order }, &[1]), &["RL", "_o"])
}

#[test]
fn claims_of_shared_channels_are_sound() {
    let is_judged = |order: ElectrodeArrayOrder, words: &[&str]| {
        let claims = alone(order);
        why(&schedule(&claims, &[&[words]]), &claims).is_none()
    };
    let lists: [&[(u32, u32)]; 1] = [&[(4, 4), (9, 9)]];
    let dispensed = |lists: Lists| {
        let order = assay(&[("a", 1, 1)], vec![dispense(0, (4, 4), 2)]);
        without_places(ElectrodeArrayOrder { facts: shared(14, 14, lists), ..order }, &[0])
    };
    assert!(
        is_judged(dispensed(&[]), &["o."]) && !is_judged(dispensed(&lists), &["o."]),
        "an outlet on a shared channel"
    );
    let facts = shared(14, 14, &lists);
    let micro = ElectrodeArrayFacts { map: facts.map, ..platform(14, 14) };
    assert!(!is_judged(moving(micro, &[("a", 5, 5)], vec![go(0, &[(6, 5)])]), &["R"]), "microparts");
}
