//! Traces that droplets leave on electrodes.

use super::build::{assay, discard, dispense, go, merge, operation, split, without_places};
use super::judged;
use crate::claims::electrode_array::{AssayOperation, AvoidedTrace, Contamination, ElectrodeArrayOrder};
use crate::source::Span;
use crate::verify::Rule;

fn avoiding(order: ElectrodeArrayOrder, avoided: &[(&str, &str)], washes: &[&str]) -> ElectrodeArrayOrder {
    let avoided = avoided.iter().map(|(of, within)| AvoidedTrace {
        of: (*of).into(),
        within: (*within).into(),
        span: Span::default(),
    });
    let washes = washes.iter().map(|wash| (*wash).into()).collect();
    let contamination = Contamination { avoided: avoided.collect(), washes, before: Vec::new(), course: None };
    ElectrodeArrayOrder { contamination, ..order }
}

/// `a` goes up the fourth column, `b` crosses it on the sixth row, `c` goes up to there and back.
fn crossing() -> ElectrodeArrayOrder {
    let operations =
        vec![operation(go(0, &[(4, 8)])), operation(go(1, &[(2, 6)])), operation(go(2, &[(4, 6), (4, 2)]))];
    assay(&[("a", 4, 4), ("b", 10, 6), ("c", 4, 2)], operations)
}

#[test]
fn no_droplet_comes_to_traces_that_are_avoided_in_it() {
    let last = ["UUUU", "............LLLLLLLL", "....UUUUDDDD"];
    judged(crossing(), &last, &[]);
    judged(avoiding(crossing(), &[("a", "b")], &[]), &last, &[Rule::Trace]);
    judged(avoiding(crossing(), &[("b", "a")], &[]), &last, &[]);
    judged(avoiding(crossing(), &[("a", "c")], &[]), &last, &[Rule::Trace]);
    judged(avoiding(crossing(), &[("c", "b")], &[]), &last, &[Rule::Trace]);
    judged(avoiding(crossing(), &[("c", "a"), ("b", "a"), ("b", "c")], &[]), &last, &[]);
}

#[test]
fn a_wash_takes_traces_away_where_it_has_been() {
    let (last, first) =
        (["UUUU", "............LLLLLLLL", "....UUUUDDDD"], ["UUUU", "....LLLLLLLL", "............UUUUDDDD"]);
    judged(avoiding(crossing(), &[("a", "b")], &["c"]), &last, &[]);
    judged(avoiding(crossing(), &[("a", "b")], &["c"]), &first, &[Rule::Trace]);
    // A washing droplet is neither contaminated nor contaminates others.
    judged(avoiding(crossing(), &[("a", "c"), ("c", "b")], &["c"]), &last, &[]);
    judged(avoiding(crossing(), &[("a", "b")], &["b"]), &last, &[]);
}

#[test]
fn what_merges_is_all_that_both_were() {
    let merges = operation(merge(0, 1, (5, 5)));
    let meet = || assay(&[("a", 3, 5), ("b", 7, 5)], vec![merges.clone()]);
    judged(avoiding(meet(), &[("a", "b"), ("b", "a")], &[]), &["RR", "LLx"], &[]);
    judged(avoiding(meet(), &[("a", "b"), ("b", "a")], &[]), &["RR", "..LLx"], &[]);
    // It may go where either has been, but not where a third one was.
    let back = |third: &str| {
        let then = vec![merges.clone(), operation(go(0, &[(7, 5)]))];
        avoiding(assay(&[("a", 3, 5), ("b", 7, 5), ("c", 6, 8)], then), &[("b", "a"), (third, "a")], &[])
    };
    judged(back("b"), &["RRRR", "LLx", ""], &[]);
    // The half of a mixture is a mixture too.
    let halves = |avoided: &[(&str, &str)]| {
        let operations = vec![
            merges.clone(),
            split(2, 0, (5, 5), (6, 5)),
            operation(go(2, &[(9, 5)])),
            operation(go(3, &[(9, 5), (9, 9)])),
        ];
        let order = assay(&[("a", 3, 5), ("b", 7, 5), ("half", 1, 1), ("d", 9, 9)], operations);
        avoiding(without_places(order, &[2]), avoided, &[])
    };
    let words = ["RRL", "LLx", "__oR..RR", "DDDDUUUU"];
    judged(halves(&[("a", "d"), ("b", "d"), ("half", "d")]), &words, &[]);
    judged(halves(&[("d", "half")]), &words, &[]);
    judged(halves(&[("d", "a")]), &words, &[Rule::Trace]);
    judged(halves(&[("d", "b")]), &words, &[Rule::Trace]);
}

#[test]
fn what_a_reservoir_dispenses_is_that_fluid() {
    let of = |fluid: &str| AssayOperation { fluid: Some(fluid.to_owned()), ..dispense(0, (2, 4), 1) };
    let order = |avoided: &[(&str, &str)]| {
        let operations = vec![of("dye"), operation(go(0, &[(8, 4)])), operation(go(1, &[(6, 4), (6, 7)]))];
        avoiding(without_places(assay(&[("a", 1, 1), ("b", 6, 6)], operations), &[0]), avoided, &[])
    };
    let words = ["____oRRRRRR", "DDUUU"];
    judged(order(&[("b", "a"), ("dye", "b")]), &words, &[]);
    judged(order(&[("b", "dye")]), &words, &[Rule::Trace]);
}

/// A part that leaves at an outlet and one that is dispensed there at the same instant touch.
#[test]
fn who_leaves_as_another_comes_is_there_with_it() {
    let comes = AssayOperation { fluid: Some("dye".to_owned()), ..dispense(1, (4, 4), 1) };
    let order = |avoided: &[(&str, &str)]| {
        let operations = vec![discard(0, (4, 4)), comes.clone(), operation(go(1, &[(8, 4)]))];
        avoiding(without_places(assay(&[("a", 3, 4), ("b", 1, 1)], operations), &[1]), avoided, &[])
    };
    let words = ["Rx", "_oRRRR"];
    judged(order(&[]), &words, &[]);
    judged(order(&[("dye", "a")]), &words, &[Rule::Trace]);
    judged(order(&[("a", "dye")]), &words, &[Rule::Trace]);
}
