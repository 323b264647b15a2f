//! Operations with several possible places, of which the plan chooses one.

use super::assay::recorded;
use super::build::{alone, assay, discard, incubate, schedule, split};
use super::one_step;
use crate::claims::Claims;
use crate::claims::electrode_array::{
    AssayOperation, BoardZone, ElectrodeArrayStop, OperationPlace, ZoneSort, ZoneStay,
};
use crate::schedule::{Schedule, ScheduledOperation};
use crate::source::Span;
use crate::verify::Rule;
use crate::verify::tests::{only, passes, rules, why};
use std::sync::Arc;

/// An operation at one of several cells.
fn among(operation: AssayOperation, cells: &[(u32, u32)]) -> AssayOperation {
    let stop = |(column, row): (u32, u32)| ElectrodeArrayStop {
        cell: super::build::cell(column, row),
        span: Span::default(),
        origin: None,
    };
    let places: Vec<OperationPlace> =
        cells.iter().map(|cell| OperationPlace { stop: stop(*cell), zone: None }).collect();
    AssayOperation { stops: vec![stop(cells[0])], among: places, ..operation }
}

fn at(operation: ScheduledOperation, cell: [u32; 2]) -> ScheduledOperation {
    ScheduledOperation { at: Some(cell), ..operation }
}

/// `a` goes two cells to the right and stays there, the second of two places, for three beats.
fn sound() -> (Schedule, Claims) {
    let operations = vec![among(incubate(0, &[], 3), &[(4, 8), (6, 4)]), incubate(0, &[(7, 4)], 1)];
    let (mut schedule, claims) = one_step(assay(&[("a", 4, 4)], operations), &["RR...R."]);
    schedule.steps[0].operations = vec![at(recorded(&["a"], [0, 2, 5]), [6, 4]), recorded(&["a"], [5, 6, 7])];
    (schedule, claims)
}

#[test]
fn an_operation_takes_place_where_the_program_lets_it() {
    let (schedule, claims) = sound();
    passes(&schedule, &claims);
    let forged = |edit: &dyn Fn(&mut Vec<ScheduledOperation>)| {
        let mut schedule = schedule.clone();
        edit(&mut schedule.steps[0].operations);
        only(Rule::Choice, &schedule, &claims);
    };
    forged(&|all| all[0].at = None);
    forged(&|all| all[0].at = Some([6, 5]));
    forged(&|all| all[1].at = Some([7, 4]));
    forged(&|all| all.clear());
    // The other place is one of the program's, but not the one that was used.
    let (mut elsewhere, claims) = sound();
    elsewhere.steps[0].operations[0].at = Some([4, 8]);
    assert_eq!(rules(&elsewhere, &claims), [Rule::Figure, Rule::Goal]);
}

#[test]
fn no_place_is_chosen_that_is_not_open() {
    let (mut schedule, claims) = one_step(assay(&[("a", 4, 4)], vec![incubate(0, &[(6, 4)], 3)]), &["RR..."]);
    passes(&schedule, &claims);
    schedule.steps[0].operations = vec![at(recorded(&["a"], [0, 2, 5]), [6, 4])];
    only(Rule::Choice, &schedule, &claims);
}

/// The only fault is that the recorded place is not named by the program.
#[test]
fn a_place_that_is_not_named_is_found_by_nothing_else() {
    let (schedule, claims) = sound();
    let elsewhere = vec![among(incubate(0, &[], 3), &[(4, 8), (6, 8)]), incubate(0, &[(7, 4)], 1)];
    let (_, others) = one_step(assay(&[("a", 4, 4)], elsewhere), &["RR...R."]);
    passes(&schedule, &claims);
    only(Rule::Choice, &schedule, &others);
}

#[test]
fn choices_that_no_checker_makes_are_refused() {
    let is_judged = |operation: AssayOperation| {
        let mut order = assay(&[("a", 4, 4), ("b", 10, 4)], vec![operation]);
        let zone = |sort, column| {
            let cell = super::build::cell(column, 4);
            BoardZone { name: format!("zone{column}"), sort, from: cell, to: cell, span: Span::default() }
        };
        order.zones = Arc::new(vec![zone(ZoneSort::Detector, 6), zone(ZoneSort::Magnet, 8)]);
        let claims = alone(order);
        why(&schedule(&claims, &[&[&[""]]]), &claims).is_none()
    };
    let stay = || incubate(0, &[], 2);
    let two = [(6, 4), (8, 4)];
    assert!(is_judged(among(stay(), &two)));
    assert!(is_judged(among(discard(0, (4, 4)), &two)));
    let in_zones = |zones: [Option<usize>; 2]| {
        let mut operation = among(stay(), &two);
        operation.among.iter_mut().zip(zones).for_each(|(place, zone)| place.zone = zone);
        AssayOperation { zone: zones[0].map(|zone| ZoneStay { zone, temperature_k: None }), ..operation }
    };
    assert!(is_judged(in_zones([Some(0), Some(0)])));
    let many: Vec<(u32, u32)> = (1..=9).flat_map(|row| [(1, row), (2, row)]).collect();
    let refused = [
        among(stay(), &[(6, 4)]),
        among(stay(), &[(6, 4), (6, 4)]),
        among(stay(), &[(6, 4), (40, 4)]),
        among(stay(), &many),
        among(split(1, 0, (4, 4), (5, 4)), &two),
        AssayOperation { comes: true, ..among(stay(), &two) },
        AssayOperation { stops: vec![], ..among(stay(), &two) },
        in_zones([Some(0), None]),
        in_zones([None, Some(0)]),
        in_zones([Some(0), Some(1)]),
        in_zones([Some(0), Some(2)]),
    ];
    for (nth, operation) in refused.into_iter().enumerate() {
        assert!(!is_judged(operation), "{nth}");
    }
}
