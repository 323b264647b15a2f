//! All arm patterns that can be set.
//!
//! An arm that is down keeps down every arm that it is not separated from, and so on transitively: the patterns that
//! can be set are those closed under this relation (proof in `cycles`). They are enumerated by deciding one arm after
//! the other together with its consequences, so that no decision is ever taken back, and n arms cost O(n) for each
//! pattern.

use super::table::VoltageTable;

/// One bit for each row.
type RowMask = u128;

/// The patterns by the number of arms that are down, then by digits; `None` if there are more than `most`.
pub fn accessible(table: &VoltageTable, most: usize) -> Option<Vec<Vec<bool>>> {
    if table.len() > RowMask::BITS as usize {
        return None;
    }
    let downs = kept_down(table);
    let ups: Vec<RowMask> = (0..table.len()).map(|row| column(&downs, row)).collect();
    let mut patterns = Vec::new();
    let mut open: Vec<(RowMask, RowMask)> = vec![(0, 0)];
    while let Some((down, up)) = open.pop() {
        let undecided = (down | up).trailing_ones() as usize;
        if undecided >= table.len() {
            patterns.push(down);
            if patterns.len() > most {
                return None;
            }
            continue;
        }
        open.push((down | downs[undecided], up));
        open.push((down, up | ups[undecided]));
    }
    let bools = |mask: RowMask| (0..table.len()).map(|row| mask >> row & 1 == 1).collect::<Vec<bool>>();
    let mut patterns: Vec<Vec<bool>> = patterns.into_iter().map(bools).collect();
    patterns.sort_by_cached_key(|pattern| (pattern.iter().filter(|is_down| **is_down).count(), pattern.clone()));
    Some(patterns)
}

/// For each row, the rows that are down when it is, itself included.
fn kept_down(table: &VoltageTable) -> Vec<RowMask> {
    let rows = 0..table.len();
    let direct = |row: usize| rows.clone().filter(move |other| !table.separates(row, *other));
    let mut kept: Vec<RowMask> =
        rows.clone().map(|row| direct(row).fold(1 << row, |mask, other| mask | 1 << other)).collect();
    for middle in rows.clone() {
        let further = kept[middle];
        for mask in &mut kept {
            if *mask >> middle & 1 == 1 {
                *mask |= further;
            }
        }
    }
    kept
}

/// The rows whose mask has a given bit.
fn column(masks: &[RowMask], bit: usize) -> RowMask {
    masks.iter().enumerate().fold(0, |rows, (row, mask)| rows | (mask >> bit & 1) << row)
}
