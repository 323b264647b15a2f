use super::*;
use crate::schedule::electrode_array::ElectrodeArrayState;

fn pair(
    facts: crate::device::electrode_array::ElectrodeArrayFacts,
    second: (u32, u32),
    goal: (u32, u32),
) -> ElectrodeArrayOrder {
    moving(facts, &[("a", 3, 5), ("b", second.0, second.1), ("c", 12, 12)], vec![merge(0, 1, goal)])
}

fn chip_pair(second: (u32, u32), goal: (u32, u32)) -> ElectrodeArrayOrder {
    pair(chip(14, 14), second, goal)
}

fn unheld_pair(second: (u32, u32), goal: (u32, u32)) -> ElectrodeArrayOrder {
    pair(crate::device::electrode_array::ElectrodeArrayFacts { hold: Hold::Off, ..chip(14, 14) }, second, goal)
}

#[test]
fn two_droplets_meet_at_their_goal() {
    for order in [chip_pair, unheld_pair] {
        judged(order((7, 5), (5, 5)), &["RR", "LL"], &[]);
        judged(order((7, 5), (5, 5)), &["RR", "..LL"], &[]);
        judged(order((7, 5), (5, 5)), &["..RR", "LL"], &[]);
        judged(order((7, 5), (5, 5)), &["RR.", ".LL"], &[]);
        judged(order((7, 6), (5, 5)), &["RR", ".LLD"], &[]);
        judged(order((7, 6), (5, 5)), &["RR", "LLD"], &[Rule::Pull]);
        judged(order((7, 7), (5, 5)), &["RR", "..LLDD"], &[]);
    }
    judged(chip_pair((5, 5), (5, 5)), &["RR", ""], &[]);
    judged(chip_pair((7, 5), (5, 5)), &["RR", ".L..L"], &[]);
    judged(chip_pair((7, 5), (5, 5)), &["RR", ".LRLL"], &[]);
    judged(chip_pair((7, 7), (5, 5)), &["RR", "DLRDLL"], &[]);
}

#[test]
fn two_droplets_meet_nowhere_else() {
    judged(chip_pair((7, 5), (4, 5)), &["RRL", "LLL"], &[Rule::Pull]);
    // It leaves the goal and comes back, far from the other one and near to it.
    judged(chip_pair((8, 5), (4, 5)), &["RLR", "..LLLL"], &[]);
    judged(chip_pair((6, 5), (4, 5)), &["RLR", "L.L"], &[Rule::Pull]);
    judged(chip_pair((6, 5), (7, 5)), &["RRRR", ".R"], &[Rule::Pull]);
    judged(chip_pair((6, 5), (7, 5)), &["RRRR", "R"], &[]);
    judged(chip_pair((7, 5), (5, 5)), &["RR", "L"], &[Rule::Goal]);
    judged(chip_pair((7, 5), (5, 5)), &["R", "LL"], &[Rule::Goal]);
    judged(chip_pair((4, 6), (5, 5)), &["RR", "RD"], &[Rule::Touch]);
}

#[test]
fn a_third_droplet_keeps_away_from_both() {
    let order = || {
        let moves = vec![merge(0, 1, (5, 5)), go(2, &[(5, 7)])];
        moving(chip(14, 14), &[("a", 3, 5), ("b", 7, 5), ("c", 5, 9)], moves)
    };
    judged(order(), &["RR", "LL", "DD"], &[]);
    let near = || {
        let moves = vec![merge(0, 1, (5, 5)), go(2, &[(5, 6)])];
        moving(chip(14, 14), &[("a", 3, 5), ("b", 7, 5), ("c", 5, 9)], moves)
    };
    judged(near(), &["RR", "LL", "DDD"], &[Rule::Pull]);
}

#[test]
fn what_has_merged_is_gone() {
    let steps = |last: ElectrodeArrayMove| {
        let first = ElectrodeArrayAction::Move(vec![merge(0, 1, (5, 5))]);
        alone(order(
            chip(14, 14),
            &[("a", 3, 5), ("b", 7, 5)],
            vec![first, ElectrodeArrayAction::Wait(9), ElectrodeArrayAction::Move(vec![last])],
        ))
    };
    let words: Words = &[&[&["RR", "LL"], &[], &["UU"]]];
    let claims = steps(go(0, &[(5, 7)]));
    let sound = schedule(&claims, words);
    passes(&sound, &claims);
    let State::ElectrodeArray(ElectrodeArrayState { parts }) = &sound.plans[0].states[2].state else {
        panic!("a board's state")
    };
    assert_eq!(parts.len(), 1);
    let mut two = sound.clone();
    let State::ElectrodeArray(ElectrodeArrayState { parts }) = &mut two.plans[0].states[2].state else {
        panic!("a board's state")
    };
    parts.set("b", Some([5, 5]));
    only(Rule::State, &two, &claims);
    let mut gone = steps(go(1, &[(5, 7)]));
    order_of(&mut gone, 0).bystanders = Bystanders::Yield;
    let found = rules(&schedule(&gone, &[&[&["RR", "LL"], &[], &["UD"]]]), &gone);
    assert_eq!(found, [Rule::Goal]);
}

#[test]
fn a_merged_droplet_is_missing_in_the_next_run() {
    let parts = [("a", 3, 5), ("b", 7, 5)];
    let first = order(chip(14, 14), &parts, vec![ElectrodeArrayAction::Move(vec![merge(0, 1, (5, 5))])]);
    let second = order(chip(14, 14), &parts, vec![ElectrodeArrayAction::Move(vec![go(0, &[(8, 5)])])]);
    let claims = in_turn(vec![first, second]);
    passes(&schedule(&claims, &[&[&["RR", "LL"]], &[&["RRR"]]]), &claims);
}

#[test]
fn the_electrode_of_the_goal_serves_only_who_comes() {
    let (mut early, claims) = one_step(chip_pair((8, 5), (5, 5)), &["RR", "LLL"]);
    switch_on(&mut early, 5, 5, 0, 0, 1);
    assert_eq!(rules(&early, &claims), [Rule::Unused]);
    let (mut left, claims) = one_step(chip_pair((8, 5), (5, 5)), &["RR", "LLL"]);
    let goal = channel(&mut left, cell(5, 5));
    left.actuations.retain(|actuation| actuation.channel != goal);
    assert_eq!(rules(&left, &claims), [Rule::Hold]);
}
