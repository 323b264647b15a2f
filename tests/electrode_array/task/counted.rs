//! The brute force itself, in cases that can be counted by hand.

use super::*;

#[test]
fn all_plans_of_one_part_are_counted_by_hand() {
    let go = Step { moves: vec![(0, vec![(4, 1)])], ..Step::default() };
    let task = Task {
        kind: DROPLETS,
        size: (6, 1),
        obstacles: vec![],
        parts: vec![(1, 1)],
        may_yield: false,
        by_sum: false,
        steps: vec![go],
        limits: vec![],
        pins: None,
    };
    let all = task.all();
    // The goal is three cells away: each step is a move or a wait, and backward moves are paired with forward ones.
    let expected = |steps: u64| (3..=steps).filter(|moves| moves % 2 == 1).map(move |moves| [steps, steps, moves]);
    assert_eq!(all, (3..=MOST_STEPS).flat_map(expected).collect());
    let past = Step { moves: vec![(0, vec![(5, 1)])], ..Step::default() };
    let still = Task { parts: vec![(1, 1), (3, 1)], steps: vec![past], ..task };
    assert!(still.all().is_empty(), "nobody passes in one row");
    let room = Task { size: (6, 3), ..still };
    assert_eq!(room.all().first(), Some(&[8, 8, 8]), "round the other, two rows up and down");
}
