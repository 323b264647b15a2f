//! Operations that come after those of other parts.

use super::build::{assay, discard, dispense, go, incubate, merge, mix, operation, split, without_places};
use super::judged;
use crate::claims::electrode_array::AssayOperation;
use crate::verify::Rule;

const THREE: [(&str, u32, u32); 3] = [("a", 4, 4), ("b", 10, 4), ("c", 4, 10)];

/// An operation that comes after the first one.
fn then(operation: AssayOperation) -> AssayOperation {
    AssayOperation { after: vec![0], ..operation }
}

#[test]
fn a_stay_counts_from_then_on() {
    let two = || assay(&THREE[..2], vec![incubate(0, &[], 3), then(incubate(1, &[], 2))]);
    judged(two(), &[".....", "....."], &[]);
    judged(two(), &["....", "...."], &[Rule::Goal]);
    judged(two(), &["......", "......"], &[Rule::Idle]);
    // Its earlier moves do not matter.
    judged(two(), &[".....", "RL..."], &[]);
    judged(two(), &[".....", ".RL.."], &[]);
    judged(two(), &[".....", "..RL."], &[Rule::Goal]);
}

#[test]
fn what_waits_for_several_waits_for_the_last() {
    let last = AssayOperation { after: vec![0, 1], ..incubate(2, &[], 1) };
    let three = || assay(&THREE, vec![incubate(0, &[], 3), incubate(1, &[], 2), last.clone()]);
    judged(three(), &["....", "..", ""], &[]);
    judged(three(), &["...", "..", ""], &[Rule::Goal]);
}

#[test]
fn stops_on_the_way_wait_for_nothing() {
    let tour = || assay(&THREE[..2], vec![incubate(0, &[], 3), then(operation(go(1, &[(11, 4), (12, 4)])))]);
    judged(tour(), &["...", "RR"], &[]);
    let tour = |next| {
        let operations = vec![incubate(0, &[], 3), then(operation(go(1, &[(11, 4)]))), operation(go(1, &[next]))];
        assay(&THREE[..2], operations)
    };
    judged(tour((12, 4)), &["...", "R..R"], &[]);
    judged(tour((12, 4)), &["...", "RR"], &[Rule::Goal]);
}

#[test]
fn what_merges_later_keeps_apart_until_then() {
    let parts = [("a", 3, 5), ("b", 7, 5), ("c", 10, 10)];
    let meet = || assay(&parts, vec![incubate(2, &[], 4), then(operation(merge(0, 1, (5, 5))))]);
    judged(meet(), &["RR", "....LLx", "...."], &[]);
    judged(meet(), &["RR", "...LLx", "...."], &[Rule::Pull]);
}

#[test]
fn a_droplet_leaves_is_mixed_is_split_and_comes_no_earlier() {
    let leaves = || assay(&THREE[..2], vec![incubate(1, &[], 3), then(discard(0, (5, 4)))]);
    judged(leaves(), &["R..x", "..."], &[]);
    judged(leaves(), &["Rx", "..."], &[Rule::State]);
    let mixed = || assay(&THREE[..2], vec![incubate(1, &[], 2), then(mix(0, &[], 4))]);
    judged(mixed(), &["..RULD", ".."], &[]);
    judged(mixed(), &["RULD", ".."], &[Rule::Goal]);
    judged(mixed(), &[".RULD", ".."], &[Rule::Goal]);
    let parts = [("a", 4, 4), ("half", 1, 1), ("b", 10, 4)];
    let apart = vec![incubate(2, &[], 2), then(split(1, 0, (4, 4), (4, 5)))];
    let apart = || without_places(assay(&parts, apart.clone()), &[1]);
    judged(apart(), &["..D", "__o", ".."], &[]);
    judged(apart(), &[".D", "_o", ".."], &[Rule::Pull]);
    let comes = || {
        let operations = vec![incubate(1, &[], 2), then(dispense(0, (4, 4), 1))];
        without_places(assay(&THREE[..2], operations), &[0])
    };
    judged(comes(), &["__o", ".."], &[]);
    judged(comes(), &["o", ".."], &[Rule::Unused]);
}
