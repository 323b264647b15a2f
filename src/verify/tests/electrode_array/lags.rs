//! Operations that must begin soon after others.

use super::build::{BEAT, assay, incubate, merge, operation};
use super::judged;
use crate::claims::electrode_array::{AssayOperation, OperationLag};
use crate::source::Span;
use crate::verify::Rule;

/// An operation that begins at most `beats` beats after the first one.
fn soon(operation: AssayOperation, after: Vec<usize>, beats: u64) -> AssayOperation {
    let within = OperationLag { of: vec![0], most_ns: beats * BEAT + BEAT / 2, span: Span::default() };
    AssayOperation { after, within: Some(within), ..operation }
}

#[test]
fn a_stay_begins_in_time() {
    let parts = [("a", 4, 4), ("b", 10, 4)];
    let two = |beats| assay(&parts, vec![incubate(0, &[], 3), soon(incubate(1, &[], 2), vec![0], beats)]);
    judged(two(0), &["...", "....."], &[]);
    // It moves away and comes back, and begins two beats later.
    judged(two(2), &["...", "...RL.."], &[]);
    judged(two(1), &["...", "...RL.."], &[Rule::Lag]);
}

#[test]
fn a_part_goes_on_in_time() {
    let one = |beats| assay(&[("a", 4, 4)], vec![incubate(0, &[], 2), soon(incubate(0, &[(6, 4)], 1), vec![], beats)]);
    judged(one(2), &["..RR."], &[]);
    judged(one(2), &["...RR."], &[Rule::Lag]);
    judged(one(3), &["...RR."], &[]);
}

#[test]
fn droplets_merge_in_time() {
    let parts = [("a", 3, 5), ("b", 7, 5), ("c", 10, 10)];
    let meet = |beats| {
        let merged = operation(merge(0, 1, (5, 5)));
        assay(&parts, vec![incubate(2, &[], 4), soon(merged, vec![0], beats)])
    };
    judged(meet(2), &["RR", "....LLx", "...."], &[]);
    judged(meet(1), &["RR", "....LLx", "...."], &[Rule::Lag]);
}
