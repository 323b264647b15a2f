//! Boards whose channels switch several electrodes, by definition: the union of the channels of all droplets that move
//! or are held is on, and within reach of a droplet only its own target electrode or that of its partner may be on.

use crate::scenes::Random;
use std::collections::BTreeSet;

pub type Cell = (i32, i32);

/// The channels of a board.
#[derive(Clone, Debug)]
pub struct Pins {
    pub size: Cell,
    /// Channel numbers, row by row from row 1.
    pub numbers: Vec<u32>,
    pub is_held: bool,
    /// Defective electrodes.
    pub dead: Vec<Cell>,
    /// Cells of stuck parts, which nothing may pull.
    pub stuck: Vec<Cell>,
}

/// A droplet during a step.
#[derive(Clone, Copy, Debug)]
pub struct Droplet {
    pub from: Cell,
    pub to: Cell,
    /// Destination of the droplet that it is about to merge with, or of the other half of a split.
    pub partner: Option<Cell>,
    /// It is being split: the electrode that pulls the other half acts on it, whatever else that channel is on for.
    pub is_split: bool,
}

impl Pins {
    /// Random channels; some electrodes have their own.
    pub fn random(size: Cell, own: &[Cell], chance: &mut Random) -> Pins {
        let (pool, percent) = (2 + chance.below(5), 20 + chance.below(60));
        let cells = (1..=size.1).flat_map(|row| (1..=size.0).map(move |column| (column, row)));
        let numbers =
            cells.enumerate().map(|(place, cell)| match chance.below(100) < percent && !own.contains(&cell) {
                true => 1000 + chance.below(pool),
                false => 2000 + place as u32,
            });
        let numbers = numbers.collect();
        Pins { size, numbers, is_held: true, dead: Vec::new(), stuck: Vec::new() }
    }

    pub fn number(&self, column: i32, row: i32) -> u32 {
        self.numbers[((row - 1) * self.size.0 + column - 1) as usize]
    }

    /// The rows of the device's field, from the top; `none` where there is no electrode.
    pub fn rows(&self, has_electrode: impl Fn(Cell) -> bool) -> String {
        let number = |column: i32, row: i32| match has_electrode((column, row)) {
            true => self.number(column, row).to_string(),
            false => "none".to_owned(),
        };
        let row = |row: i32| (1..=self.size.0).map(|column| number(column, row)).collect::<Vec<_>>().join(", ");
        (1..=self.size.1).rev().map(|at| format!("[{}]", row(at))).collect::<Vec<_>>().join(", ")
    }

    /// Whether droplets can make some moves in the same step. `has_electrode` is the outline of the board.
    pub fn allow(&self, droplets: &[Droplet], has_electrode: impl Fn(Cell) -> bool) -> bool {
        let cells = || (1..=self.size.1).flat_map(|row| (1..=self.size.0).map(move |column| (column, row)));
        let near = |one: Cell, other: Cell| (one.0 - other.0).abs().max((one.1 - other.1).abs()) <= 1;
        let (mut meant, mut besides) = (BTreeSet::new(), BTreeSet::new());
        for droplet in droplets.iter().filter(|droplet| self.is_held || droplet.from != droplet.to) {
            meant.insert(droplet.to);
            let number = self.number(droplet.to.0, droplet.to.1);
            let on =
                cells().filter(|(column, row)| self.number(*column, *row) == number && (*column, *row) != droplet.to);
            besides.extend(on.filter(|cell| has_electrode(*cell) && !self.dead.contains(cell)));
        }
        let on: Vec<Cell> = meant.union(&besides).copied().collect();
        let holds_together = |droplet: &Droplet| {
            let acting = on.iter().filter(|on| near(**on, droplet.from) || near(**on, droplet.to));
            let of_partner = |on: &Cell| droplet.partner == Some(*on) && (droplet.is_split || !besides.contains(on));
            { acting }.all(|on| *on == droplet.to || of_partner(on))
        };
        droplets.iter().all(holds_together) && !self.stuck.iter().any(|stuck| on.iter().any(|on| near(*on, *stuck)))
    }
}
