//! The decompositions of an orientation against all sequences of up to three turns.

use super::super::orientation::{self, Orientation};
use super::{BEAD, order};
use crate::claims::fingers::{FingersTurn, HandPart};
use crate::device::fingers::Plane;

/// Every sequence of three turns, none of them empty, that ends within `near_rad` of a goal.
fn all(goal: &Orientation, part: &HandPart, near_rad: f64) -> Vec<Vec<FingersTurn>> {
    let mut found = Vec::new();
    let steps = || (-18..=18).filter(|steps| *steps != 0);
    for (outer, inner) in [(Plane::Xy, Plane::Xz), (Plane::Xz, Plane::Xy)] {
        for a in steps() {
            for b in steps() {
                for c in steps() {
                    let turn = |plane, steps| FingersTurn { plane, steps };
                    let turns = vec![turn(outer, a), turn(inner, b), turn(outer, c)];
                    if orientation::after(&turns, part).angle_to(goal) <= near_rad {
                        found.push(turns);
                    }
                }
            }
        }
    }
    found
}

#[test]
fn no_way_is_missed() {
    let order = order("", BEAD, "grasp bead");
    let part = &order.part;
    let turn = |plane, steps| FingersTurn { plane, steps };
    for [a, b, c] in [[4, 11, 5], [-3, 2, 7], [1, 8, -8], [6, -5, 2], [9, 3, 1]] {
        let goal = orientation::after(&[turn(Plane::Xy, a), turn(Plane::Xz, b), turn(Plane::Xy, c)], part);
        let sequences = orientation::decompositions(&goal, part);
        let near_rad = 0.5f64.to_radians();
        for turns in all(&goal, part, near_rad) {
            let is_full = turns.iter().any(|turn| turn.steps.abs() == 18);
            assert!(
                is_full || sequences.iter().any(|sequence| sequence.turns == turns),
                "{turns:?} leads to {a}, {b}, {c}"
            );
        }
        assert!(sequences.iter().filter(|sequence| sequence.off_rad <= near_rad).count() >= 4);
    }
}

#[test]
fn ways_say_how_far_they_miss() {
    let order = order("", BEAD, "grasp bead");
    let goal = orientation::read(crate::check::orientation::from_euler([0.3, 1.1, -2.0]));
    let sequences = orientation::decompositions(&goal, &order.part);
    assert!(!sequences.is_empty());
    for sequence in &sequences {
        let off_rad = orientation::after(&sequence.turns, &order.part).angle_to(&goal);
        assert!((off_rad - sequence.off_rad).abs() < 1e-9);
        assert!(sequence.turns.windows(2).all(|pair| pair[0].plane != pair[1].plane));
    }
    // The best of them is as good as the best of all.
    let best = sequences.iter().map(|sequence| sequence.off_rad).fold(f64::INFINITY, f64::min);
    assert!(all(&goal, &order.part, best - 1e-6).is_empty());
}

#[test]
fn upside_down_and_flat() {
    let order = order("", BEAD, "grasp bead");
    let near_rad = 0.1f64.to_radians();
    for (euler, least) in
        [([0.0, 180.0, 0.0], 1), ([40.0, 180.0, 0.0], 2), ([0.0, 0.0, 0.0], 1), ([60.0, 0.0, 80.0], 1)]
    {
        let goal = orientation::read(crate::check::orientation::from_euler(euler.map(|deg: f64| deg.to_radians())));
        let near =
            orientation::decompositions(&goal, &order.part).into_iter().filter(|sequence| sequence.off_rad <= near_rad);
        let fewest = near.map(|sequence| sequence.turns.len()).min();
        assert!(fewest.is_some_and(|turns| turns <= least), "{euler:?}: {fewest:?}");
    }
}
