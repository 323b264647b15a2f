use super::*;
use crate::claims::Relation;
use crate::claims::electrode_array::{AssayOperation, DropletContent, DropletShare};
use crate::schedule::{Actuation, ScheduledOperation};
use crate::source::Span;

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
    // Rest before its turn does not count, and each stay counts separately.
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
    // `b` is not ready: the two keep apart until it has stayed.
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
    // The droplet that arrives first waits for the other one; that does not count as a stay.
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
    // Another part may come to its former cell; one step earlier it would have been too near.
    let follow = |last| {
        let operations = vec![discard(0, (5, 4)), operation(go(1, &[last]))];
        assay(&[("a", 4, 4), ("b", 7, 4)], operations)
    };
    judged(follow((5, 4)), &["Rx", ".LL"], &[]);
    judged(follow((5, 4)), &["Rx", "LL"], &[Rule::Pull]);
    judged(follow((5, 4)), &["..Rx", "...LL"], &[]);
}

/// `a` comes out of a reservoir at (4, 4) in three beats. `then` has its later operations and those of the other
/// parts.
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
    // A part that is on the board is not dispensed, wherever it is.
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
    // The droplet is there from its first beat on.
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
    // Two droplets of one reservoir are alike: the record says which is which, but cannot exchange their operations.
    schedule.plans[0].states.iter_mut().for_each(|state| {
        let State::ElectrodeArray(board) = &mut state.state else { panic!("a board") };
        let cells = ["a", "b"].map(|name| board.parts.get(name));
        ["b", "a"].into_iter().zip(cells).for_each(|(name, cell)| board.parts.set(name, cell));
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

/// `b` is split off `a` at (5, 4) and goes up. `then` has the later operations, and `third` is another part.
fn split_upward(third: Option<(&str, u32, u32)>, then: Vec<AssayOperation>) -> ElectrodeArrayOrder {
    let parts: Vec<(&str, u32, u32)> = [("a", 4, 4), ("b", 1, 1)].into_iter().chain(third).collect();
    let operations = std::iter::once(split(1, 0, (5, 4), (5, 5))).chain(then).collect();
    without_places(assay(&parts, operations), &[1])
}

#[test]
fn a_droplet_is_split_where_the_electrodes_on_both_sides_pull() {
    let alone = || split_upward(None, vec![]);
    judged(alone(), &["RD", "_o"], &[]);
    judged(alone(), &["R..D", "___o"], &[]);
    judged(alone(), &[".RLRD", "____o"], &[]);
    judged(alone(), &["RD", "__"], &[Rule::Goal]);
    judged(alone(), &["RU", "__"], &[Rule::Goal]);
    judged(alone(), &["R", "_"], &[Rule::Goal]);
    judged(alone(), &["RD.", "_o."], &[Rule::Idle]);
    // Its own electrode is off meanwhile, and it is split at no other cell.
    judged(alone(), &["R.", "_o"], &[Rule::Pull]);
    judged(alone(), &["URD", "__o"], &[Rule::Pull]);
    judged(alone(), &["DD", "_o"], &[Rule::Unused]);
    // The named half goes where the program says.
    let sideways = || without_places(assay(&[("a", 4, 4), ("b", 1, 1)], vec![split(1, 0, (5, 4), (6, 4))]), &[1]);
    judged(sideways(), &["RL", "_o"], &[]);
    judged(sideways(), &["RD", "_o"], &[Rule::Pull]);
}

#[test]
fn both_halves_go_on_by_themselves() {
    let then = vec![incubate(1, &[], 2), operation(go(0, &[(6, 3)])), discard(1, (5, 6))];
    judged(split_upward(None, then.clone()), &["RDR", "_o..Ux"], &[]);
    judged(split_upward(None, then.clone()), &["RD...R", "_o..Ux"], &[]);
    judged(split_upward(None, then.clone()), &["RDR", "_o.U"], &[Rule::Goal]);
    judged(split_upward(None, then), &["RDR", "_o...."], &[Rule::Goal]);
    let merges = vec![operation(merge(0, 1, (5, 4)))];
    judged(split_upward(None, merges), &["RDU", "_oDx"], &[]);
    // A half can be split again.
    let parts = [("a", 4, 4), ("b", 1, 1), ("c", 1, 1)];
    let again = vec![split(1, 0, (5, 4), (5, 5)), split(2, 1, (5, 6), (6, 6))];
    let order = || without_places(assay(&parts, again.clone()), &[1, 2]);
    judged(order(), &["RD", "_oUL", "___o"], &[]);
    judged(order(), &["RD", "_oUL", "____"], &[Rule::Goal]);
}

#[test]
fn halves_keep_away_from_others() {
    let beside = |at: (u32, u32), then| split_upward(Some(("c", at.0, at.1)), then);
    judged(beside((7, 5), vec![]), &["RD", "_o", ""], &[]);
    judged(beside((6, 6), vec![]), &["RD", "_o", ""], &[Rule::Pull]);
    judged(beside((7, 3), vec![]), &["RD", "_o", ""], &[]);
    let leaves = || vec![operation(go(2, &[(8, 4)]))];
    judged(beside((7, 4), leaves()), &["RD", "_o", ".R"], &[]);
    judged(beside((7, 4), vec![operation(go(2, &[(6, 4)]))]), &["RD", "_o", ".L"], &[Rule::Pull]);
}

#[test]
fn a_droplet_is_mixed_round_its_loop() {
    let stirred = |stops: &[(u32, u32)], beats| assay(&[("a", 4, 4)], vec![mix(0, stops, beats)]);
    judged(stirred(&[], 4), &["RULD"], &[]);
    judged(stirred(&[], 1), &["RULD"], &[]);
    judged(stirred(&[], 5), &["RULDRULD"], &[]);
    judged(stirred(&[], 5), &["RULDR"], &[Rule::Goal]);
    judged(stirred(&[], 4), &["RULD.."], &[Rule::Idle]);
    judged(stirred(&[], 4), &[".RLRULD"], &[]);
    judged(stirred(&[(5, 4)], 4), &["RRULD"], &[]);
    // Anticlockwise, one cell per beat, from the corner to the corner.
    judged(stirred(&[], 4), &["URDL"], &[Rule::Goal]);
    judged(stirred(&[], 4), &["R.ULD"], &[Rule::Goal]);
    judged(stirred(&[], 5), &["RULD.RULD"], &[Rule::Goal]);
    judged(stirred(&[], 4), &["LURD"], &[Rule::Goal]);
    judged(stirred(&[], 4), &["RRULLD"], &[Rule::Goal]);
    // Each mixing time counts once.
    let twice = || assay(&[("a", 4, 4)], vec![mix(0, &[], 4), mix(0, &[], 3)]);
    judged(twice(), &["RULDRULD"], &[]);
    judged(twice(), &["RULD"], &[Rule::Goal]);
    let mut wide = stirred(&[], 6);
    wide.facts.mixer = [3, 2];
    judged(wide.clone(), &["RRULLD"], &[]);
    judged(wide, &["RULDRULD"], &[Rule::Goal]);
    let mut ring = stirred(&[], 8);
    ring.facts.mixer = [3, 3];
    judged(ring.clone(), &["RRUULLDD"], &[]);
    judged(ring, &["RUULLDDR"], &[Rule::Goal]);
}

#[test]
fn droplets_contain_what_is_asked() {
    let share = |part, fluid: Option<&str>, relation, limit| DropletContent {
        part,
        share: fluid.map_or(DropletShare::Volume, |fluid| DropletShare::Fluid(fluid.to_owned())),
        relation,
        limit,
        span: Span::default(),
    };
    // `a` merges with `c` and is split into `a` and `b`; the remaining `a` merges with `d`.
    let operations = vec![operation(merge(0, 2, (5, 4))), split(1, 0, (5, 4), (5, 5)), operation(merge(0, 3, (5, 2)))];
    let parts = [("a", 4, 4), ("b", 1, 1), ("c", 7, 4), ("d", 5, 1)];
    let judged_with = |contents: Vec<DropletContent>, limits: [Option<f64>; 2], due: &[Rule]| {
        let mut order = without_places(assay(&parts, operations.clone()), &[1]);
        order.contents = contents;
        [order.facts.least_volume, order.facts.most_volume] = limits;
        judged(order, &["R.DD", "__o", "LLx", "...Ux"], due);
    };
    judged_with(vec![], [None, None], &[]);
    let held = |part, fluid, reached: f64| {
        for (relation, limit) in
            [(Relation::Equal, reached), (Relation::AtMost, reached), (Relation::More, reached - 0.1)]
        {
            judged_with(vec![share(part, fluid, relation, limit)], [None, None], &[]);
        }
        for (relation, limit) in [
            (Relation::Equal, reached + 0.1),
            (Relation::Less, reached),
            (Relation::More, reached),
            (Relation::AtLeast, reached + 0.1),
        ] {
            judged_with(vec![share(part, fluid, relation, limit)], [None, None], &[Rule::Requirement]);
        }
    };
    held(0, Some("a"), 0.25);
    held(0, Some("c"), 0.25);
    held(0, Some("d"), 0.5);
    held(1, Some("a"), 0.5);
    held(1, Some("d"), 0.0);
    held(0, None, 2.0);
    held(1, None, 1.0);
    held(3, Some("d"), 1.0);
    judged_with(vec![], [Some(1.0), Some(2.0)], &[]);
    judged_with(vec![], [Some(1.0), Some(1.5)], &[Rule::Requirement]);
    judged_with(vec![], [Some(1.1), Some(2.0)], &[Rule::Requirement]);
}

#[test]
fn splits_and_mixes_on_the_record_are_those_of_the_replay() {
    let operations = vec![
        mix(0, &[], 4),
        split(1, 0, (5, 4), (5, 5)),
        incubate(1, &[(5, 6)], 1),
        mix(0, &[(6, 3)], 2),
        operation(go(1, &[(5, 7)])),
    ];
    let order = without_places(assay(&[("a", 4, 4), ("b", 1, 1)], operations), &[1]);
    let (mut sound, claims) = one_step(order, &[".RULD.R.DR.RULD", "________oU.U"]);
    sound.steps[0].operations = vec![
        recorded(&["a"], [0, 1, 5]),
        recorded(&["a", "b"], [5, 7, 9]),
        recorded(&["b"], [9, 10, 11]),
        recorded(&["a"], [9, 11, 15]),
        recorded(&["b"], [11, 12, 12]),
    ];
    passes(&sound, &claims);
    for nth in 0..5 {
        for edit in [0, 1, 2] {
            let mut schedule = sound.clone();
            let own = &mut schedule.steps[0].operations[nth];
            match edit {
                0 => own.start_ns += 1,
                1 => own.arrival_ns += BEAT,
                _ => own.parts.reverse(),
            }
            if schedule != sound {
                only(Rule::Figure, &schedule, &claims);
            }
        }
    }
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

/// A recorded operation: its parts, and its start, arrival and end in beats.
pub(super) fn recorded(parts: &[&str], [start, arrival, end]: [u64; 3]) -> ScheduledOperation {
    ScheduledOperation {
        parts: parts.iter().map(|part| (*part).to_owned()).collect(),
        text: "operation".into(),
        line: 1,
        column: 1,
        at: None,
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
    // `a` waits where they meet, rests there after the merge, and is held up on its way; `c` comes back to its stay.
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
fn the_stays_of_all_parts_together_are_limited() {
    let names: Vec<String> = (0..33).map(|part| format!("p{part}")).collect();
    let parts: Vec<(&str, u32, u32)> =
        names.iter().zip(0..).map(|(name, nth)| (name.as_str(), 2 + 2 * (nth % 6), 2 + 2 * (nth / 6))).collect();
    let is_judged = |count: usize| {
        let claims = alone(assay(&parts, (0..count).map(|part| incubate(part, &[], 1_000_000)).collect()));
        why(&schedule(&claims, &[&[&[""]]]), &claims).is_none()
    };
    assert!(is_judged(32) && !is_judged(33));
}

#[test]
fn claims_that_no_checker_makes_are_refused() {
    let is_judged = |operations: Vec<AssayOperation>| {
        let claims = alone(assay(&[("a", 4, 4), ("b", 10, 4)], operations));
        why(&schedule(&claims, &[&[&[""]]]), &claims).is_none()
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
        vec![incubate(0, &[], 600_000), incubate(0, &[], 600_000)],
        vec![mix(0, &[], 0)],
        vec![mix(0, &[], 600_000), mix(0, &[], 600_000)],
        vec![AssayOperation { mixes: true, ..both() }],
        vec![AssayOperation { mixes: true, ..discard(0, (5, 5)) }],
        vec![AssayOperation { mixes: true, ..split(1, 0, (5, 4), (5, 5)) }],
        vec![split(0, 0, (5, 4), (5, 5))],
        vec![split(2, 0, (5, 4), (5, 5))],
        vec![split(1, 0, (5, 4), (6, 5))],
        vec![split(1, 0, (5, 4), (7, 4))],
        vec![split(1, 0, (5, 4), (5, 4))],
        vec![split(1, 0, (5, 14), (5, 15))],
        vec![AssayOperation { stay_ns: 1, ..split(1, 0, (5, 4), (5, 5)) }],
        vec![AssayOperation { leaves: true, ..split(1, 0, (5, 4), (5, 5)) }],
        vec![AssayOperation { splits: split(1, 0, (5, 4), (5, 5)).splits, ..incubate(0, &[], 0) }],
        vec![discard(1, (12, 4)), split(1, 0, (5, 4), (5, 5))],
    ];
    refused.into_iter().for_each(|operations| assert!(!is_judged(operations.clone()), "{operations:?}"));
    let of_facts = |edit: &dyn Fn(&mut ElectrodeArrayFacts)| {
        let mut order = assay(&[("a", 4, 4), ("b", 10, 4)], vec![split(1, 0, (5, 4), (5, 5))]);
        edit(&mut order.facts);
        let claims = alone(order);
        why(&schedule(&claims, &[&[&[""]]]), &claims).is_none()
    };
    assert!(of_facts(&|_| ()));
    assert!(!of_facts(&|facts| facts.hold = Hold::Off));
    assert!(!of_facts(&|facts| facts.separation = Separation::Apart(3)));
    assert!(!of_facts(&|facts| facts.mixer = [1, 4]));
    assert!(!of_facts(&|facts| facts.mixer = [2, 100_000]));
}
