use super::*;
use crate::claims::electrode_array::AssayOperation;
use crate::schedule::{Actuation, ScheduledOperation};
use crate::source::Span;

fn assay(parts: &[(&str, u32, u32)], operations: Vec<AssayOperation>) -> ElectrodeArrayOrder {
    order(chip(14, 14), parts, vec![ElectrodeArrayAction::Assay(operations)])
}

#[test]
fn a_part_does_its_operations_in_their_order() {
    let tour = |operations| assay(&[("a", 4, 4)], operations);
    let to = |stop: (u32, u32)| operation(go(0, &[stop]));
    judged(tour(vec![to((5, 4)), to((5, 5))]), &["RU"], &[]);
    judged(tour(vec![to((5, 5)), to((5, 4)), to((5, 5))]), &["RU"], &[Rule::Goal]);
    judged(tour(vec![to((5, 5)), to((5, 4)), to((5, 5))]), &["RUDU"], &[]);
    judged(tour(vec![to((5, 5)), to((5, 4))]), &["RUD"], &[]);
    judged(tour(vec![to((5, 5))]), &["R"], &[Rule::Goal]);
    judged(tour(vec![to((5, 4))]), &["RU"], &[Rule::Goal]);
    judged(tour(vec![operation(go(0, &[(5, 4), (4, 4)]))]), &["RL"], &[]);
    judged(tour(vec![to((4, 4))]), &[""], &[]);
}

#[test]
fn a_part_stays_for_the_whole_of_its_time() {
    let stay = |stops: &[(u32, u32)], beats| assay(&[("a", 4, 4)], vec![incubate(0, stops, beats)]);
    judged(stay(&[], 3), &["..."], &[]);
    judged(stay(&[], 3), &[".."], &[Rule::Goal]);
    judged(stay(&[], 3), &["...."], &[Rule::Idle]);
    judged(stay(&[], 3), &[".RL..."], &[]);
    judged(stay(&[], 3), &[".RL.."], &[Rule::Goal]);
    judged(stay(&[(5, 4)], 2), &["R.."], &[]);
    judged(stay(&[(5, 4)], 2), &["R."], &[Rule::Goal]);
    judged(stay(&[(5, 4)], 2), &["R.LR."], &[Rule::Goal]);
    judged(stay(&[(5, 4)], 2), &["R...LR"], &[]);
    judged(stay(&[(5, 4)], 2), &["R..."], &[Rule::Idle]);
    // Rest before its turn does not count, and each stay has its own.
    let twice = |first| assay(&[("a", 4, 4)], vec![incubate(0, &[], first), incubate(0, &[], 2)]);
    judged(twice(0), &[".."], &[]);
    judged(twice(1), &["..."], &[]);
    judged(twice(1), &[".."], &[Rule::Goal]);
}

#[test]
fn stays_are_whole_beats() {
    let part = AssayOperation { stay_ns: BEAT + 1, ..incubate(0, &[], 0) };
    let order = || assay(&[("a", 4, 4)], vec![part.clone()]);
    judged(order(), &[".."], &[]);
    judged(order(), &["."], &[Rule::Goal]);
}

#[test]
fn parts_that_share_no_operation_do_not_wait_for_each_other() {
    let two = || assay(&[("a", 4, 4), ("b", 10, 4)], vec![incubate(0, &[], 3), operation(go(1, &[(11, 5)]))]);
    judged(two(), &["...", "RU"], &[]);
    judged(two(), &["...", ".RU"], &[]);
    judged(two(), &["...", "..RU"], &[]);
    judged(two(), &["....", "RU"], &[Rule::Idle]);
}

#[test]
fn parts_merge_when_both_are_there_and_ready() {
    let meet = |first: Vec<AssayOperation>| {
        let merge = operation(merge(0, 1, (5, 5)));
        assay(&[("a", 3, 5), ("b", 7, 5)], first.into_iter().chain([merge]).collect())
    };
    judged(meet(vec![]), &["RR", "LLx"], &[]);
    judged(meet(vec![]), &["RR", "..LLx"], &[]);
    judged(meet(vec![]), &["RR", "LL"], &[Rule::State]);
    judged(meet(vec![]), &["RR", "L"], &[Rule::Goal]);
    // `b` is not ready: the two keep apart, until it has stayed.
    judged(meet(vec![incubate(1, &[], 2)]), &["..RR", "..LLx"], &[]);
    judged(meet(vec![incubate(1, &[], 2)]), &["RR", "..LLx"], &[]);
    judged(meet(vec![incubate(1, &[(7, 6)], 0)]), &["RR", "ULLDx"], &[]);
    judged(meet(vec![incubate(1, &[(7, 6)], 0)]), &["RR", "LRULLD"], &[Rule::Pull]);
}

#[test]
fn what_has_merged_goes_on_as_one() {
    let on = |last: Vec<AssayOperation>| {
        let first = [operation(merge(0, 1, (5, 5)))];
        assay(&[("a", 3, 5), ("b", 7, 5)], first.into_iter().chain(last).collect())
    };
    judged(on(vec![operation(go(0, &[(5, 6)]))]), &["RRU", "LLx"], &[]);
    judged(on(vec![incubate(0, &[], 2)]), &["RR..", "LLx"], &[]);
    judged(on(vec![incubate(0, &[], 2)]), &["RR.", "LLx"], &[Rule::Goal]);
    judged(on(vec![incubate(0, &[(4, 5)], 1)]), &["RRL.", "LLx"], &[]);
    // The one that came first waits for the other, and that is no stay.
    judged(on(vec![incubate(0, &[], 2)]), &["RR...", ".LLx"], &[]);
    judged(on(vec![incubate(0, &[], 2)]), &["RR..", ".LLx"], &[Rule::Goal]);
}

#[test]
fn what_has_merged_leaves_its_place_at_once() {
    let order = |end| {
        let operations = vec![operation(merge(0, 1, (5, 5))), operation(go(0, &[(5, 9)])), operation(go(2, &[end]))];
        assay(&[("a", 3, 5), ("b", 7, 5), ("c", 9, 5)], operations)
    };
    judged(order((5, 5)), &["RRUUUU", "LLx", ".LLLL"], &[Rule::Pull]);
    judged(order((5, 5)), &["RRUUUU", "LLx", "..LLLL"], &[]);
}

#[test]
fn what_leaves_the_board_is_gone_at_once() {
    let out = |stop| assay(&[("a", 4, 4), ("b", 10, 4)], vec![discard(0, stop), incubate(1, &[], 3)]);
    judged(out((5, 4)), &["Rx", "..."], &[]);
    judged(out((5, 4)), &[".Rx", "..."], &[]);
    judged(out((5, 4)), &["R..", "..."], &[Rule::State]);
    judged(out((5, 4)), &["..R", "..."], &[Rule::State]);
    judged(out((5, 4)), &["...", "..."], &[Rule::Goal]);
    // Another may come to where it was; a step earlier it would have been too near.
    let follow = |last| {
        let operations = vec![discard(0, (5, 4)), operation(go(1, &[last]))];
        assay(&[("a", 4, 4), ("b", 7, 4)], operations)
    };
    judged(follow((5, 4)), &["Rx", ".LL"], &[]);
    judged(follow((5, 4)), &["Rx", "LL"], &[Rule::Pull]);
    judged(follow((5, 4)), &["..Rx", "...LL"], &[]);
}

/// `a` comes out of a reservoir at (4, 4) in three beats; what it does then, and the other parts with what they do.
fn out_of_a_reservoir(others: &[(&str, u32, u32)], then: Vec<AssayOperation>) -> ElectrodeArrayOrder {
    let parts: Vec<(&str, u32, u32)> = std::iter::once(("a", 1, 1)).chain(others.iter().copied()).collect();
    let operations = std::iter::once(dispense(0, (4, 4), 3)).chain(then).collect();
    without_places(assay(&parts, operations), &[0])
}

#[test]
fn a_droplet_stays_at_the_outlet_until_it_is_dispensed() {
    let one = |then| out_of_a_reservoir(&[], then);
    judged(one(vec![]), &["o.."], &[]);
    judged(one(vec![]), &["_o.."], &[]);
    judged(one(vec![]), &["o."], &[Rule::Goal]);
    judged(one(vec![]), &["___"], &[Rule::Goal]);
    judged(one(vec![]), &["o..."], &[Rule::Idle]);
    let on = || one(vec![operation(go(0, &[(5, 4)]))]);
    judged(on(), &["o..R"], &[]);
    judged(on(), &["__o...R"], &[]);
    judged(on(), &["o.R"], &[Rule::Goal]);
    judged(on(), &["o.RL...R"], &[Rule::Goal]);
    judged(one(vec![discard(0, (4, 4))]), &["o..x"], &[]);
    judged(one(vec![incubate(0, &[], 2)]), &["o...."], &[]);
    judged(one(vec![incubate(0, &[], 2)]), &["o..."], &[Rule::Goal]);
    // What is on the board is not dispensed, wherever it stands.
    let stands =
        |at| order(chip(14, 14), &[("a", at, 4)], vec![ElectrodeArrayAction::Assay(vec![dispense(0, (4, 4), 3)])]);
    judged(stands(4), &["..."], &[Rule::Goal]);
    judged(stands(3), &["R..."], &[Rule::Goal]);
}

#[test]
fn nothing_is_near_an_outlet_that_dispenses() {
    let beside = |at, then| out_of_a_reservoir(&[("b", at, 4)], then);
    judged(beside(6, vec![]), &["o..", "..."], &[]);
    judged(beside(5, vec![]), &["o..", "..."], &[Rule::Pull]);
    judged(beside(4, vec![]), &["o..", "..."], &[Rule::State]);
    let away = || beside(5, vec![operation(go(1, &[(7, 4)]))]);
    judged(away(), &["_o..", "RR"], &[]);
    judged(away(), &["o..", "RR"], &[Rule::Pull]);
    // It is there from its first beat on.
    let past = || beside(6, vec![operation(go(1, &[(5, 6)]))]);
    judged(past(), &["o..", "UUL"], &[]);
    judged(past(), &["o..", "LUU"], &[Rule::Pull]);
}

#[test]
fn one_outlet_dispenses_one_droplet_after_the_other() {
    let operations = vec![dispense(0, (4, 4), 3), operation(go(0, &[(6, 4)])), dispense(1, (4, 4), 3)];
    let order = || without_places(assay(&[("a", 1, 1), ("b", 1, 1)], operations.clone()), &[0, 1]);
    judged(order(), &["o..RR", "_____o.."], &[]);
    judged(order(), &["o..RR", "____o.."], &[Rule::Pull]);
    judged(order(), &["_____o..RR", "o.."], &[Rule::State]);
    let (mut schedule, claims) = one_step(order(), &["o..RR...", "_____o.."]);
    // Two droplets of one reservoir are alike: the record says which is which, but not that one is another.
    schedule.plans[0].states.iter_mut().for_each(|state| {
        let State::ElectrodeArray(board) = &mut state.state else { panic!("a board") };
        let cells = ["a", "b"].map(|name| board.parts.remove(name));
        let names = ["b", "a"].into_iter().zip(cells).filter_map(|(name, cell)| Some((name.to_owned(), cell?)));
        board.parts.extend(names.collect::<Vec<_>>());
    });
    only(Rule::Goal, &schedule, &claims);
}

#[test]
fn an_outlet_dispenses_what_is_asked_and_no_more() {
    let (mut schedule, claims) = one_step(out_of_a_reservoir(&[], vec![operation(go(0, &[(9, 4)]))]), &["o..RRRRR"]);
    passes(&schedule, &claims);
    let outlet = schedule.actuations.iter().find(|actuation| actuation.start_ns == 0).cloned().expect("the outlet");
    let last_ns = schedule.duration_ns - BEAT;
    schedule.actuations.push(Actuation { start_ns: last_ns, duration_ns: BEAT, ..outlet });
    schedule.actuations.sort_by_key(|actuation| (actuation.start_ns, actuation.channel));
    only(Rule::Unused, &schedule, &claims);
}

#[test]
fn parts_without_an_operation_come_back_before_the_end() {
    let order = |bystanders| ElectrodeArrayOrder {
        bystanders,
        ..assay(&[("a", 4, 4), ("b", 10, 4)], vec![incubate(0, &[], 3)])
    };
    judged(order(Bystanders::Yield), &["...", "UD"], &[]);
    judged(order(Bystanders::Yield), &["...", ".UD"], &[]);
    judged(order(Bystanders::Yield), &["...", "..U"], &[Rule::Bystander]);
    judged(order(Bystanders::Yield), &["....", "..UD"], &[]);
    judged(order(Bystanders::Stay), &["...", "UD"], &[Rule::Bystander]);
}

#[test]
fn the_sum_of_costs_ends_with_the_last_arrivals() {
    let operations = vec![incubate(0, &[(5, 4)], 5), operation(go(1, &[(11, 5)]))];
    let mut order = assay(&[("a", 4, 4), ("b", 10, 4)], operations);
    order.objective = ElectrodeArrayObjective::SumOfCosts;
    let (sound, claims) = one_step(order, &["R.....", ".RU"]);
    assert_eq!(sound.plans[0].cost, 4.0);
    passes(&sound, &claims);
}

/// An operation on the record: its parts, and start, arrival and end in beats.
pub(super) fn recorded(parts: &[&str], [start, arrival, end]: [u64; 3]) -> ScheduledOperation {
    ScheduledOperation {
        parts: parts.iter().map(|part| (*part).to_owned()).collect(),
        text: "operation".into(),
        line: 1,
        column: 1,
        start_ns: start * BEAT,
        arrival_ns: arrival * BEAT,
        duration_ns: (end - start) * BEAT,
        span: Span::default(),
    }
}

#[test]
fn operations_on_the_record_are_those_of_the_replay() {
    let operations = vec![
        incubate(1, &[], 1),
        operation(merge(0, 1, (5, 5))),
        incubate(0, &[], 2),
        operation(go(0, &[(5, 6), (6, 6)])),
        incubate(2, &[(9, 10)], 4),
    ];
    let order = assay(&[("a", 3, 5), ("b", 7, 5), ("c", 9, 9)], operations);
    // `a` waits where they meet, rests there once they are one, is held up on its way, and `c` comes back to its stay.
    let (mut sound, claims) = one_step(order, &["RR....U.R", "..LLx", ".UDU...."]);
    sound.steps[0].operations = vec![
        recorded(&["b"], [0, 0, 1]),
        recorded(&["a", "b"], [0, 4, 4]),
        recorded(&["a"], [4, 4, 6]),
        recorded(&["a"], [6, 9, 9]),
        recorded(&["c"], [0, 4, 8]),
    ];
    passes(&sound, &claims);
    let forged = |edit: &dyn Fn(&mut Vec<ScheduledOperation>)| {
        let mut schedule = sound.clone();
        edit(&mut schedule.steps[0].operations);
        only(Rule::Figure, &schedule, &claims);
    };
    for nth in 0..5 {
        forged(&|all| all[nth].start_ns += 1);
        forged(&|all| all[nth].arrival_ns += BEAT);
        forged(&|all| all[nth].duration_ns -= 1);
        forged(&|all| all[nth].parts = vec!["d".into(), "a".into()]);
        forged(&|all| drop(all.remove(nth)));
    }
    forged(&|all| all.push(recorded(&["c"], [8, 9, 9])));
    forged(&|all| all.swap(0, 4));
}

#[test]
fn steps_without_an_assay_record_no_operations() {
    let (mut schedule, claims) = one_step(moving(chip(14, 14), &[("a", 4, 4)], vec![go(0, &[(5, 4)])]), &["R"]);
    passes(&schedule, &claims);
    schedule.steps[0].operations = vec![recorded(&["a"], [0, 1, 1])];
    only(Rule::Figure, &schedule, &claims);
}

#[test]
fn claims_that_no_checker_makes_are_refused() {
    let is_judged = |operations: Vec<AssayOperation>| {
        let claims = alone(assay(&[("a", 4, 4), ("b", 10, 4)], operations));
        !matches!(verify(schedule(&claims, &[&[&[""]]]), &claims), Verdict::Inconclusive { .. })
    };
    let both = || operation(merge(0, 1, (5, 5)));
    assert!(is_judged(vec![operation(go(0, &[(4, 4)]))]));
    let refused = [
        vec![operation(go(2, &[(4, 4)]))],
        vec![operation(go(0, &[(40, 4)]))],
        vec![both(), operation(go(1, &[(4, 4)]))],
        vec![operation(merge(0, 0, (5, 5)))],
        vec![AssayOperation { stay_ns: 1, ..both() }],
        vec![AssayOperation { leaves: true, ..both() }],
        vec![AssayOperation { stay_ns: 1, ..discard(0, (5, 5)) }],
        vec![discard(0, (5, 5)), operation(go(0, &[(4, 4)]))],
        vec![dispense(0, (5, 5), 0)],
        vec![AssayOperation { leaves: true, ..dispense(0, (5, 5), 2) }],
        vec![AssayOperation { with: Some(1), ..dispense(0, (5, 5), 2) }],
        vec![AssayOperation { comes: true, ..incubate(0, &[], 2) }],
        vec![AssayOperation { comes: true, ..incubate(0, &[(5, 4), (5, 5)], 2) }],
        vec![AssayOperation { leaves: true, ..incubate(0, &[], 0) }],
        vec![incubate(0, &[], 60_000), incubate(1, &[], 60_000)],
    ];
    refused.into_iter().for_each(|operations| assert!(!is_judged(operations.clone()), "{operations:?}"));
}
