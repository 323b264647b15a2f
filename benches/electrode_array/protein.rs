//! Protein assays with many levels, which have more leaves than places.
//!
//! Operations, times, ports and places are those of the assays with few levels. The schedule, that is, the place of
//! each leaf, where halves rest and the order of splits, is made here as a lab would make it: one place splits, depth
//! first, so that at most one half of each level rests; the other places process the leaves, each taken by the place
//! that is free first.

use super::assays::{FieldAssay, place};

/// The place that splits; then the cell where a leaf rests until one of the other places is free.
const SPLITTER: u32 = 5;
const BUFFER: (u32, u32) = (12, 11);

/// Resting places of the halves, by level; an assay with fewer levels uses the last ones. Halves of deeper levels come
/// and go before those of the levels above, so that each row opens to one side.
const STORES: [(u32, u32); 11] =
    [(7, 1), (5, 1), (3, 1), (1, 1), (2, 18), (9, 1), (11, 1), (6, 16), (8, 16), (10, 16), (12, 16)];

/// Durations in tenths of a second: a merge with its mixing, a merge with its mixing and a split, and what remains
/// for a leaf after its first merge.
const MEETING: u32 = 33;
const SPLITTING: u32 = 55;
const READING: u32 = 440;

struct Schedule {
    assay: FieldAssay,
    levels: u32,
    /// Operations with their times.
    timed: Vec<(u32, String)>,
    /// For each place, when it is free, and the last leaf that it had.
    free: Vec<(u32, Option<u32>)>,
    /// The last leaf in the buffer, and when it has merged with its first droplet at its place.
    buffered: Option<(u32, u32)>,
    drops: u32,
}

impl Schedule {
    fn add(&mut self, at: u32, text: String) {
        self.timed.push((at, text));
    }

    /// A droplet merges with one of a fluid at a place and is mixed with it.
    fn meet(&mut self, at: u32, part: u32, fluid: &str, place: u32, after: &[u32]) {
        self.drops += 1;
        let (other, cell) = (format!("{fluid}_{}", self.drops), self::place(place));
        self.assay.droplets += 1;
        self.assay.scene.push(format!("part {other} : ea.droplet"));
        self.add(at, format!("dispense {other} from {fluid}{}", place % 2));
        self.add(at, format!("merge d{part} with {other} at {cell:?}{}", afters(after)));
        self.add(at, format!("mix d{part} for 3 s"));
    }

    /// The place, other than the splitter, that is free first.
    fn first_free(&self) -> u32 {
        let others = (0..8).filter(|place| *place != SPLITTER);
        others.min_by_key(|place| self.free[*place as usize].0).unwrap_or(0)
    }

    /// Processes a leaf at a place, from an instant on.
    fn leaf(&mut self, at: u32, part: u32, place: u32) {
        let before: Vec<u32> = self.free[place as usize].1.into_iter().collect();
        let at = at.max(self.free[place as usize].0);
        self.meet(at, part, "b", place, &before);
        for (nth, fluid) in (1..).zip(["b", "b", "b", "r"]) {
            self.meet(at + MEETING * nth, part, fluid, place, &[]);
        }
        self.add(at + MEETING * 5, format!("incubate d{part} for 30 s"));
        self.add(at + MEETING * 5, format!("discard d{part} at (15, 1)"));
        self.free[place as usize] = (at + MEETING + READING, Some(part));
    }

    /// Splits a droplet at the splitter once others have left it, and then everything that results from it; returns
    /// the time, and the droplet that leaves the splitter last.
    fn split(&mut self, at: u32, part: u32, level: u32, after: &[u32]) -> (u32, u32) {
        self.meet(at, part, "b", SPLITTER, after);
        self.add(at, format!("incubate d{part} for 2 s"));
        let (half, is_last) = (part + (1 << (self.levels - level - 1)), level + 1 == self.levels);
        let (column, row) = self::place(SPLITTER);
        let place = self.first_free();
        let ready = at + SPLITTING;
        let at = if is_last { ready.max(self.free[place as usize].0) } else { ready };
        let before: Vec<u32> = self.free[place as usize].1.into_iter().filter(|_| is_last).collect();
        self.assay.droplets += 1;
        self.assay.scene.push(format!("part d{half} : ea.droplet"));
        self.add(at, format!("split d{half} from d{part} at ({}, {row}){}", column + 1, afters(&before)));
        if is_last {
            self.leaf(at, half, place);
            let is_end = half + 1 == 1 << self.levels;
            if is_end {
                self.leaf(at, part, SPLITTER);
            } else {
                let (at, before) =
                    self.buffered.filter(|(_, met)| *met > at).map_or((at, None), |(part, met)| (met, Some(part)));
                self.add(at, format!("move d{part} to {BUFFER:?}{}", afters(before.as_slice())));
                let place = self.first_free();
                self.buffered = Some((part, (at + 3).max(self.free[place as usize].0) + MEETING - 1));
                self.leaf(at + 3, part, place);
                return (at + 2, part);
            }
            return (at + 2, part);
        }
        self.add(at, format!("move d{half} to {:?}", STORES[self.store(level)]));
        let (at, last) = self.split(at + 1, part, level + 1, &[]);
        self.split(at, half, level + 1, &[last])
    }

    /// Index of the store for the halves of a level, counted from 0.
    fn store(&self, level: u32) -> usize {
        STORES.len() + 1 - self.levels as usize + level as usize
    }
}

fn afters(parts: &[u32]) -> String {
    parts.iter().map(|part| format!(" after d{part}")).collect()
}

/// The assay with this many levels, with more leaves than places.
pub fn protein(levels: u32) -> FieldAssay {
    let assay = FieldAssay::default();
    let mut schedule =
        Schedule { assay, levels, timed: Vec::new(), free: vec![(0, None); 8], buffered: None, drops: 0 };
    let ports = [("s", (8, 1)), ("b0", (1, 6)), ("b1", (15, 6)), ("r0", (1, 11)), ("r1", (15, 11))];
    ports.iter().for_each(|(name, at)| schedule.assay.reservoir(name, *at));
    schedule.assay.droplets += 1;
    schedule.assay.scene.push("part d0 : ea.droplet".to_owned());
    schedule.add(0, "dispense d0 from s".to_owned());
    schedule.split(20, 0, 0, &[]);
    schedule.timed.sort_by_key(|(at, _)| *at);
    schedule.assay.operations.extend(schedule.timed.into_iter().map(|(_, text)| text));
    schedule.assay
}
