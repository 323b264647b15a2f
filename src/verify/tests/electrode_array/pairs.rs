//! The separation rule by bodies and electrodes, compared with the plain formula: every pair of actions at every
//! offset.

use super::*;
use crate::device::electrode_array::{ElectrodeArrayFacts, ElectrodeCell};

const LETTERS: [char; 5] = ['R', 'L', 'U', 'D', '.'];

const SPAN: i64 = 9;

/// All four combinations of starts and ends keep the separation.
fn plain(one: ElectrodeCell, letter: char, other: ElectrodeCell, other_letter: char, separation: u32) -> bool {
    let ends = [other, moved(other, other_letter)];
    [one, moved(one, letter)].iter().all(|one| ends.iter().all(|other| one.apart(*other) >= separation))
}

/// Bodies keep the separation at the start, halfway and at the end of a simultaneous move, and no electrode of one
/// part lies within one row and column of an electrode of the other (section 3.2 of the model).
fn in_step(
    facts: &ElectrodeArrayFacts,
    one: (ElectrodeCell, char),
    other: (ElectrodeCell, char),
    separation: u32,
) -> bool {
    let place = |(at, letter): (ElectrodeCell, char), half: u32| {
        let to = moved(at, letter);
        [at.column * (2 - half) + to.column * half, at.row * (2 - half) + to.row * half]
    };
    let bodies = (0..=2).all(|half| {
        let ([column, row], [other_column, other_row]) = (place(one, half), place(other, half));
        column.abs_diff(other_column).max(row.abs_diff(other_row)) >= 2 * separation
    });
    let pulls = |(at, letter): (ElectrodeCell, char), (other, other_letter): (ElectrodeCell, char)| {
        let on = electrodes(facts, at, letter);
        let own = facts.layout.electrodes.offsets();
        let feels = |centre: ElectrodeCell, electrode: &ElectrodeCell| {
            own.iter().any(|[column, row]| {
                let columns = i64::from(centre.column) + column - i64::from(electrode.column);
                columns.abs().max((i64::from(centre.row) + row - i64::from(electrode.row)).abs()) < 2
            })
        };
        on.iter().any(|electrode| feels(other, electrode) || feels(moved(other, other_letter), electrode))
    };
    bodies && !pulls(one, other) && !pulls(other, one)
}

/// The verdict on two parts in one step; a third one far away moves, so that the step is not idle.
fn verified(facts: &ElectrodeArrayFacts, one: (ElectrodeCell, char), other: (ElectrodeCell, char)) -> bool {
    let goal = |part, (at, letter): (ElectrodeCell, char)| go(part, &[moved(at, letter).pair().into()]);
    let parts = [("a", one.0.column, one.0.row), ("b", other.0.column, other.0.row), ("far", 50, 50)];
    let order = moving(facts.clone(), &parts, vec![goal(0, one), goal(1, other), go(2, &[(51, 50)])]);
    let words = [one.1.to_string(), other.1.to_string(), "R".to_owned()];
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let (schedule, claims) = one_step(order, &words);
    let found = rules(&schedule, &claims);
    assert!(found.iter().all(|rule| matches!(rule, Rule::Touch | Rule::Pull)), "{found:?}");
    found.is_empty()
}

/// Compares the two on all cases and returns their number; `needed` is the least distance by the formula.
fn compare(facts: &ElectrodeArrayFacts, needed: u32) -> usize {
    let here = cell(25, 25);
    let mut cases = 0;
    for (letter, other_letter) in LETTERS.iter().flat_map(|one| LETTERS.map(|other| (*one, other))) {
        for (columns, rows) in (-SPAN..=SPAN).flat_map(|columns| (-SPAN..=SPAN).map(move |rows| (columns, rows))) {
            let there = cell((25 + columns) as u32, (25 + rows) as u32);
            let case = ((here, letter), (there, other_letter));
            let safe = plain(here, letter, there, other_letter, needed);
            assert_eq!(verified(facts, case.0, case.1), safe, "{case:?} at {needed}");
            cases += 1;
        }
    }
    cases
}

#[test]
fn microparts_are_judged_by_the_plain_formula() {
    assert_eq!(compare(&platform(60, 60), 4), 9025);
    let published = ElectrodeArrayFacts { separation: Separation::AsPublished, ..platform(60, 60) };
    compare(&published, 4);
}

#[test]
fn a_larger_separation_is_kept_too() {
    for separation in [5, 6] {
        let facts = ElectrodeArrayFacts { separation: Separation::Apart(separation), ..platform(60, 60) };
        compare(&facts, separation);
    }
}

#[test]
fn droplets_are_judged_by_the_plain_formula() {
    for hold in [Hold::On, Hold::Off] {
        for separation in [2, 3] {
            let facts = ElectrodeArrayFacts { hold, separation: Separation::Apart(separation), ..chip(60, 60) };
            assert_eq!(compare(&facts, separation), 9025);
        }
    }
}

/// Simultaneous bodies, together with electrodes that pull no other part, are equivalent to the formula if the
/// separation is that of the model.
#[test]
fn bodies_in_step_and_electrodes_give_the_plain_formula() {
    let held = chip(60, 60);
    let unheld = ElectrodeArrayFacts { hold: Hold::Off, ..chip(60, 60) };
    for (facts, separation) in [(platform(60, 60), 4), (held, 2), (unheld, 2)] {
        let here = cell(25, 25);
        for (columns, rows) in (-SPAN..=SPAN).flat_map(|columns| (-SPAN..=SPAN).map(move |rows| (columns, rows))) {
            let there = cell((25 + columns) as u32, (25 + rows) as u32);
            for (letter, other) in LETTERS.iter().flat_map(|one| LETTERS.map(|other| (*one, other))) {
                let safe = plain(here, letter, there, other, separation);
                let seen = in_step(&facts, (here, letter), (there, other), separation);
                assert_eq!(seen, safe, "{letter} {other} at {columns}, {rows}");
            }
        }
    }
}
