//! Cells that the tip can reach from a cell, drawn in reports that there is no plan.

use super::field::LatticeField;
use super::lattice::{Flip, LatticeCell, Side, bits};
use rustc_hash::FxHashSet;

/// Most cells listed.
const MAX_CELLS: usize = 1 << 14;

/// The cells reached by switching single modules. Pulses of several modules reach no others, since the whole rectangle
/// that they may sweep must be free. `None` if there are too many cells to list, or if the cell itself is covered.
pub(super) fn reached(field: &LatticeField, from: LatticeCell) -> Option<FxHashSet<LatticeCell>> {
    let mut met = FxHashSet::from_iter([from]);
    let mut open = vec![from];
    while let Some(cell) = open.pop() {
        let masks = field.legal(cell)?;
        for side in Side::BOTH {
            for bit in bits(masks[side.index()]) {
                let next = cell.after(Flip::of_bit(side, bit));
                if met.insert(next) {
                    open.push(next);
                }
            }
        }
        if met.len() > MAX_CELLS {
            return None;
        }
    }
    Some(met)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plan::dimibot::{DimibotAnswer, FieldObstacle, Lattice, SwitchWeights, shortest};
    use crate::plan::search::SearchBudget;

    #[test]
    fn what_is_reached_is_what_has_a_path() {
        let lattice = Lattice::new([4, 4], [1.0, 1.0]).unwrap();
        let walls = [([7, 0], [8, 11]), ([2, 12], [15, 12])].map(|(from, to)| FieldObstacle::Cells { from, to });
        let field = LatticeField::new(lattice, &walls).unwrap();
        let from = LatticeCell::new(1, 1);
        let met = reached(&field, from).unwrap();
        assert!(met.len() > 20 && met.len() < 256 - 48, "{}", met.len());
        for (x, y) in (0..16).flat_map(|x| (0..16).map(move |y| (x, y))) {
            let to = LatticeCell::new(x, y);
            let answer = shortest(&field, from, to, &SwitchWeights::switches(&lattice), SearchBudget::of(1_000_000));
            assert_eq!(matches!(answer, DimibotAnswer::Found(_)), met.contains(&to), "{to:?}");
        }
        assert_eq!(reached(&field, LatticeCell::new(7, 3)), None);
    }
}
