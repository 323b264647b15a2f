//! Random assays on tiny boards, and their programs.

use crate::pins::Pins;
use crate::scenes::Random;
use std::collections::VecDeque;

pub type Cell = (i32, i32);

/// Greatest number of parts in an assay.
pub const MOST_PARTS: usize = 4;

/// Cell of a part that has not been dispensed or split off yet: off the board, whose cells count from 1.
pub const NOWHERE: Cell = (0, 0);

/// Duration of a step of the board of `droplet_chip`, in milliseconds.
pub const STEP_MS: u64 = 60;

#[derive(Clone, Debug)]
pub enum Operation {
    Move(usize, Vec<Cell>),
    Merge(usize, usize, Cell),
    /// A part, the cell unless it stays where it is, and the number of steps.
    Incubate(usize, Option<Cell>, u64),
    Discard(usize, Cell),
    /// A part, and the index of the reservoir.
    Dispense(usize, usize),
    /// A part, the corner of the loop unless it is mixed where it is, and the least number of steps.
    Mix(usize, Option<Cell>, u64),
    /// The new part, the part that is split, the cell of the split, and the destination of the new part.
    Split(usize, usize, Cell, Cell),
}

/// Fluid of a part when it first enters the board.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fluid {
    Part(usize),
    Reservoir(usize),
}

impl Fluid {
    fn name(self) -> String {
        match self {
            Fluid::Part(part) => format!("d{part}"),
            Fluid::Reservoir(reservoir) => format!("r{reservoir}"),
        }
    }
}

impl Operation {
    /// The parts that the operation belongs to.
    pub fn parts(&self) -> Vec<usize> {
        match self {
            Operation::Merge(part, with, _) => vec![*part, *with],
            Operation::Move(part, _)
            | Operation::Incubate(part, ..)
            | Operation::Discard(part, _)
            | Operation::Dispense(part, _)
            | Operation::Mix(part, ..)
            | Operation::Split(_, part, ..) => vec![*part],
        }
    }
}

impl Operation {
    /// Its place, if that can be left open.
    fn place(&self) -> Option<Cell> {
        match self {
            Operation::Merge(_, _, at) | Operation::Discard(_, at) => Some(*at),
            Operation::Incubate(_, at, _) | Operation::Mix(_, at, _) => *at,
            Operation::Move(..) | Operation::Dispense(..) | Operation::Split(..) => None,
        }
    }

    /// The operation at another place.
    fn at(&self, at: Cell) -> Operation {
        match *self {
            Operation::Merge(part, with, _) => Operation::Merge(part, with, at),
            Operation::Discard(part, _) => Operation::Discard(part, at),
            Operation::Incubate(part, _, steps) => Operation::Incubate(part, Some(at), steps),
            Operation::Mix(part, _, steps) => Operation::Mix(part, Some(at), steps),
            Operation::Move(..) | Operation::Dispense(..) | Operation::Split(..) => self.clone(),
        }
    }

    /// The parts that the operation belongs to, and the one that it makes.
    fn all_parts(&self) -> Vec<usize> {
        match self {
            Operation::Split(half, part, ..) => vec![*part, *half],
            Operation::Merge(..)
            | Operation::Move(..)
            | Operation::Incubate(..)
            | Operation::Discard(..)
            | Operation::Dispense(..)
            | Operation::Mix(..) => self.parts(),
        }
    }
}

#[derive(Clone, Debug)]
pub struct Assay {
    pub size: Cell,
    pub separation: i32,
    pub blocks: Vec<Cell>,
    pub parts: Vec<Cell>,
    /// Outlets of the reservoirs.
    pub reservoirs: Vec<Cell>,
    /// Steps that dispensing takes.
    pub dispensing: u64,
    /// Columns and rows of the mixing loop.
    pub mixer: Cell,
    pub may_yield: bool,
    pub by_sum: bool,
    pub operations: Vec<Operation>,
    /// Pairs of fluids (of, within): the first must leave no traces in the second.
    pub avoided: Vec<(Fluid, Fluid)>,
    pub washes: Vec<Fluid>,
    /// For each operation, a part whose operations above must be done first.
    pub afters: Vec<Option<usize>>,
    /// For each operation, a part and the most steps from the end of that part's operations above to the beginning of
    /// this one.
    pub withins: Vec<Option<(usize, u64)>>,
    /// For each operation, further cells that its place may be chosen from.
    pub among: Vec<Vec<Cell>>,
    /// Channels that switch several electrodes; the outlets of reservoirs have their own.
    pub pins: Option<Pins>,
}

pub fn apart(one: Cell, other: Cell) -> i32 {
    (one.0 - other.0).abs().max((one.1 - other.1).abs())
}

impl Assay {
    pub fn random(chance: &mut Random) -> Option<Assay> {
        let separation = if chance.below(4) == 0 { 3 } else { 2 };
        let sizes = match separation {
            2 => [(4, 4), (5, 3), (6, 2), (5, 4), (7, 2)],
            _ => [(5, 5), (6, 4), (7, 3), (4, 4), (8, 2)],
        };
        let size = sizes[chance.below(5) as usize];
        let by_sum = chance.below(3) == 0;
        let mut assay = Assay {
            size,
            separation,
            blocks: vec![],
            parts: vec![],
            reservoirs: vec![],
            dispensing: u64::from(1 + chance.below(3)),
            mixer: [(2, 2), (3, 2), (2, 3), (3, 3), (4, 2)][chance.below(5) as usize],
            may_yield: false,
            by_sum,
            operations: vec![],
            avoided: vec![],
            washes: vec![],
            afters: vec![],
            withins: vec![],
            among: vec![],
            pins: None,
        };
        assay.furnish(chance)?;
        (assay.parts.len() >= 2).then_some(())?;
        assay.may_yield = chance.below(2) == 0;
        if !assay.reservoirs.is_empty() && chance.below(3) == 0 {
            return assay.served(chance).map(|assay| assay.ordered(chance));
        }
        let mut left: Vec<usize> = (0..assay.parts.len()).collect();
        let mut ends = assay.parts.clone();
        for _ in 0..1 + chance.below(5) {
            let Some(part) = left.get(chance.below(left.len().max(1) as u32) as usize).copied() else { break };
            assay.dispense(chance, &mut ends, part);
            let operation = assay.operation(chance, part, &mut left, &mut ends)?;
            ends[part] = match &operation {
                Operation::Move(_, stops) => stops[stops.len() - 1],
                Operation::Merge(_, _, at) | Operation::Discard(_, at) => *at,
                Operation::Incubate(part, at, _) => at.unwrap_or(ends[*part]),
                Operation::Dispense(_, reservoir) => assay.reservoirs[*reservoir],
                Operation::Mix(part, at, _) => at.unwrap_or(ends[*part]),
                Operation::Split(_, _, at, to) => (2 * at.0 - to.0, 2 * at.1 - to.1),
            };
            assay.operations.push(operation);
        }
        let keep = |one: &usize, other: &usize| one == other || apart(ends[*one], ends[*other]) >= separation;
        left.iter().all(|one| left.iter().all(|other| keep(one, other))).then(|| assay.ordered(chance))
    }

    /// A random next operation of a part; `left` are the parts that are not gone, `ends` their cells.
    fn operation(
        &mut self,
        chance: &mut Random,
        part: usize,
        left: &mut Vec<usize>,
        ends: &mut Vec<Cell>,
    ) -> Option<Operation> {
        Some(match chance.below(17) {
            10..=11 => {
                let at =
                    Some(ends[part]).filter(|(column, row)| self.is_loop_free(*column, *row) && chance.below(2) == 0);
                let corner = (0..40).map(|_| self.cell(chance)).find(|(column, row)| self.is_loop_free(*column, *row));
                Operation::Mix(part, if at.is_some() { None } else { Some(corner?) }, u64::from(1 + chance.below(9)))
            }
            12.. if self.separation == 2 && self.parts.len() < MOST_PARTS => {
                let sides = [(1, 0), (-1, 0), (0, 1), (0, -1)];
                let places = (0..40).map(|_| {
                    let at = if chance.below(3) == 0 { ends[part] } else { self.cell(chance) };
                    (at, sides[chance.below(4) as usize])
                });
                let (at, (c, r)) = { places }.find(|(at, (c, r))| {
                    let sides = [(0, 0), (*c, *r), (-c, -r)];
                    sides.iter().all(|(c, r)| self.is_free(at.0 + c, at.1 + r))
                })?;
                self.parts.push(NOWHERE);
                ends.push((at.0 + c, at.1 + r));
                left.push(self.parts.len() - 1);
                Operation::Split(self.parts.len() - 1, part, at, (at.0 + c, at.1 + r))
            }
            0..=2 => Operation::Move(part, vec![self.far(chance, &[])?]),
            3 => Operation::Move(part, vec![self.far(chance, &[])?, self.far(chance, &[])?]),
            4 => Operation::Incubate(part, None, u64::from(chance.below(5))),
            5 => Operation::Incubate(part, Some(self.far(chance, &[])?), u64::from(chance.below(5))),
            6..=7 => {
                // Often its own cell or that of another part.
                let known: Vec<Cell> =
                    ends.iter().copied().filter(|(column, row)| self.is_free(*column, *row)).collect();
                let at = if chance.below(2) == 0 {
                    known.get(chance.below(known.len().max(1) as u32) as usize).copied()
                } else {
                    self.far(chance, &[])
                };
                left.retain(|left| *left != part);
                Operation::Discard(part, at?)
            }
            _ => {
                let other = left[chance.below(left.len() as u32) as usize];
                (other != part).then_some(())?;
                self.dispense(chance, ends, other);
                left.retain(|left| *left != other);
                Operation::Merge(part, other, self.far(chance, &[])?)
            }
        })
    }

    /// Dispenses all parts from reservoirs; each rests or is mixed at one of two places and leaves. Places wait for
    /// reservoirs, and parts for places.
    fn served(mut self, chance: &mut Random) -> Option<Assay> {
        let first = self.far(chance, &self.reservoirs)?;
        let second = self.far(chance, &[self.reservoirs.as_slice(), &[first]].concat())?;
        for part in 0..self.parts.len() {
            self.parts[part] = NOWHERE;
            let reservoir = chance.below(self.reservoirs.len() as u32) as usize;
            let place = if part < 2 { [first, second][part] } else { [first, second][chance.below(2) as usize] };
            let out = self.far(chance, &[])?;
            self.operations.push(Operation::Dispense(part, reservoir));
            let steps = u64::from(1 + chance.below(7));
            self.operations.push(match self.is_loop_free(place.0, place.1) && chance.below(2) == 0 {
                true => Operation::Mix(part, Some(place), steps),
                false => Operation::Incubate(part, Some(place), steps),
            });
            self.operations.push(Operation::Discard(part, if chance.below(2) == 0 { place } else { out }));
        }
        Some(self)
    }

    /// The same board, with parts that leave at the outlets where others are dispensed; one may contaminate the other.
    pub fn at_outlets(self, chance: &mut Random) -> Assay {
        let mut assay = Assay { blocks: vec![], parts: vec![], reservoirs: vec![], ..self };
        (assay.operations, assay.afters, assay.avoided, assay.washes) = (vec![], vec![], vec![], vec![]);
        let outlet = assay.cell(chance);
        assay.reservoirs.push(outlet);
        assay.parts.extend(assay.far(chance, &[outlet]));
        assay.parts.extend([NOWHERE, NOWHERE].into_iter().take(1 + chance.below(2) as usize));
        let lists = assay.parts.iter().enumerate().map(|(part, start)| {
            let first =
                if *start == NOWHERE { Operation::Dispense(part, 0) } else { Operation::Incubate(part, None, 1) };
            let stays = *start == NOWHERE && chance.below(2) == 0;
            let leaves = Operation::Discard(part, if chance.below(4) > 0 { outlet } else { assay.cell(chance) });
            [first, leaves].into_iter().take(if stays { 1 } else { 2 }).collect::<VecDeque<Operation>>()
        });
        let mut lists: Vec<VecDeque<Operation>> = lists.collect();
        while lists.iter().any(|list| !list.is_empty()) {
            let next = chance.below(lists.len() as u32) as usize;
            assay.operations.extend(lists[next].pop_front());
        }
        for place in 0..assay.operations.len() {
            let own = assay.operations[place].parts();
            let earlier = assay.operations[..place].iter().flat_map(Operation::parts).find(|part| !own.contains(part));
            assay.afters.push(earlier.filter(|_| chance.below(4) == 0));
        }
        let (placed, reservoir) = (Fluid::Part(0), Fluid::Reservoir(0));
        let pairs = [(placed, reservoir), (reservoir, placed)];
        if assay.parts[0] != NOWHERE {
            assay.avoided.extend(pairs.into_iter().filter(|_| chance.below(3) > 0));
        }
        assay
    }

    /// Makes some operations come after those of other parts.
    fn ordered(mut self, chance: &mut Random) -> Assay {
        let is_ordered = chance.below(2) == 0;
        for place in 0..self.operations.len() {
            let earlier = self.operations[..place].iter().flat_map(Operation::parts);
            let own = self.operations[place].parts();
            let others: Vec<usize> = earlier.filter(|part| !own.contains(part)).collect();
            let part = others.get(chance.below(others.len().max(1) as u32) as usize).copied();
            self.afters.push(part.filter(|_| is_ordered && chance.below(3) == 0));
        }
        self.avoiding(chance)
    }

    /// Makes some operations begin soon after earlier operations of other parts or of their own.
    pub fn hurried(mut self, chance: &mut Random) -> Assay {
        for place in 0..self.operations.len() {
            let earlier: Vec<usize> = self.operations[..place].iter().flat_map(Operation::all_parts).collect();
            let any = earlier.get(chance.below(earlier.len().max(1) as u32) as usize).copied();
            let part = self.afters[place].or(any).filter(|_| chance.below(2) == 0);
            if part.is_some_and(|part| !self.operations[place].parts().contains(&part)) {
                self.afters[place] = part;
            }
            self.withins.push(part.map(|part| (part, u64::from(chance.below(7)))));
        }
        self
    }

    /// Leaves the places of some operations open, few enough to try all arrangements.
    pub fn opened(mut self, chance: &mut Random) -> Assay {
        for place in 0..self.operations.len() {
            let (operation, mut others) = (self.operations[place].clone(), Vec::new());
            let open = self.among.iter().filter(|others| !others.is_empty()).count();
            if let Some(own) = operation.place().filter(|_| open < 2 && chance.below(2) == 0) {
                for _ in 0..1 + chance.below(2) {
                    let may_be = |(column, row): &Cell| match operation {
                        Operation::Mix(..) => self.is_loop_free(*column, *row),
                        _ => self.is_free(*column, *row),
                    };
                    let other = (0..40).map(|_| self.cell(chance)).find(may_be);
                    others.extend(other.filter(|other| *other != own && !others.contains(other)));
                }
            }
            self.among.push(others);
        }
        self
    }

    /// All assays that result from choosing a place for each operation.
    pub fn arrangements(&self) -> Vec<Assay> {
        let mut all = vec![Assay { among: vec![], ..self.clone() }];
        for (place, others) in self.among.iter().enumerate() {
            let at = |one: &Assay, cell: Cell| {
                let mut one = one.clone();
                one.operations[place] = one.operations[place].at(cell);
                one
            };
            let more: Vec<Assay> = others.iter().flat_map(|cell| all.iter().map(move |one| at(one, *cell))).collect();
            all.extend(more);
        }
        all
    }

    /// Gives the board shared channels, sometimes only a few.
    pub fn pinned(mut self, chance: &mut Random) -> Assay {
        let few = Pins::random(self.size, &self.reservoirs, chance);
        self.pins = Some(few);
        self
    }

    /// Forbids some fluids to leave traces in others.
    fn avoiding(mut self, chance: &mut Random) -> Assay {
        let placed = (0..self.parts.len()).filter(|part| self.parts[*part] != NOWHERE).map(Fluid::Part);
        let fluids: Vec<Fluid> = placed.chain((0..self.reservoirs.len()).map(Fluid::Reservoir)).collect();
        if fluids.len() < 2 || chance.below(3) > 0 {
            return self;
        }
        let one = |chance: &mut Random| fluids[chance.below(fluids.len() as u32) as usize];
        for _ in 0..1 + chance.below(3) {
            let (of, within) = (one(chance), one(chance));
            if of != within {
                self.avoided.extend([(of, within), (within, of)].into_iter().take(1 + chance.below(2) as usize));
            }
        }
        if !self.avoided.is_empty() && chance.below(2) == 0 {
            let wash = one(chance);
            // A washing fluid is in no `avoid`.
            self.avoided.retain(|(of, within)| *of != wash && *within != wash);
            self.washes.extend(Some(wash).filter(|_| !self.avoided.is_empty()));
        }
        self
    }

    /// Adds obstacles, reservoirs and parts.
    fn furnish(&mut self, chance: &mut Random) -> Option<()> {
        for _ in 0..chance.below(3) {
            let block = self.cell(chance);
            self.blocks.push(block);
        }
        for _ in 0..chance.below(3) {
            let outlet = self.far(chance, &[])?;
            if !self.reservoirs.contains(&outlet) {
                self.reservoirs.push(outlet);
            }
        }
        for _ in 0..2 + chance.below(2) {
            let is_dispensed = !self.reservoirs.is_empty() && chance.below(2) == 0;
            let cell = if is_dispensed { Some(NOWHERE) } else { self.far(chance, &self.parts) };
            self.parts.extend(cell);
        }
        Some(())
    }

    /// Dispenses a part that is not on the board yet.
    fn dispense(&mut self, chance: &mut Random, ends: &mut [Cell], part: usize) {
        if ends[part] == NOWHERE {
            let reservoir = chance.below(self.reservoirs.len() as u32) as usize;
            ends[part] = self.reservoirs[reservoir];
            self.operations.push(Operation::Dispense(part, reservoir));
        }
    }

    fn cell(&self, chance: &mut Random) -> Cell {
        (1 + chance.below(self.size.0 as u32) as i32, 1 + chance.below(self.size.1 as u32) as i32)
    }

    pub fn is_free(&self, column: i32, row: i32) -> bool {
        (1..=self.size.0).contains(&column) && (1..=self.size.1).contains(&row) && !self.blocks.contains(&(column, row))
    }

    fn is_loop_free(&self, column: i32, row: i32) -> bool {
        let columns = column..column + self.mixer.0;
        let mut cells = columns.flat_map(|column| (row..row + self.mixer.1).map(move |row| (column, row)));
        cells.all(|(column, row)| self.is_free(column, row))
    }

    fn far(&self, chance: &mut Random, taken: &[Cell]) -> Option<Cell> {
        let keeps = |cell: Cell| taken.iter().all(|other| apart(cell, *other) >= self.separation);
        (0..40).map(|_| self.cell(chance)).find(|cell| self.is_free(cell.0, cell.1) && keeps(*cell))
    }

    /// The field for how reservoirs dispense: by a duration, or by frames of their pads in one or three steps, which
    /// take no other time.
    fn dispenses(&self) -> String {
        let (columns, rows) = self.size;
        if self.dispensing == 2 || self.reservoirs.is_empty() {
            let channels = self.pins.as_ref().map(|pins| format!(", channels: [{}]", pins.rows(|_| true)));
            return format!("dispense_duration: {} ms{}", self.dispensing * STEP_MS, channels.unwrap_or_default());
        }
        let own = |(column, row): Cell| 100 + (row - 1) * columns + column;
        let number = |cell: Cell| self.pins.as_ref().map_or(own(cell), |pins| pins.number(cell.0, cell.1) as i32);
        let row = |row: i32| (1..=columns).map(move |column| number((column, row))).collect::<Vec<i32>>();
        let channels: Vec<Vec<i32>> = (1..=rows).rev().map(row).collect();
        let frames = |(reservoir, outlet): (usize, &Cell)| -> Vec<Vec<i32>> {
            let pad = 10 * reservoir as i32;
            match self.dispensing {
                1 => vec![vec![pad, number(*outlet)]],
                _ => vec![vec![pad], vec![pad, pad + 1], vec![number(*outlet), pad]],
            }
        };
        let frames: Vec<Vec<Vec<i32>>> = self.reservoirs.iter().enumerate().map(frames).collect();
        format!(
            "channels: {channels:?}, outlets: {:?}, dispense_frames: {frames:?}, dispense_frame_duration: {} ms",
            self.reservoirs,
            STEP_MS - 5
        )
    }

    pub fn text(&self) -> String {
        let ((columns, rows), separation) = (self.size, self.separation);
        let mut lines = vec![
            "use std.electrode_array as ea".to_owned(),
            format!(
                "device chip : ea.droplet_chip {{ columns: {columns}, rows: {rows}, separation: {separation}, clearance: 1, mixer: {:?}, {} }}",
                self.mixer,
                self.dispenses()
            ),
            "scene tray {".to_owned(),
        ];
        lines.extend(self.blocks.iter().enumerate().map(|(index, at)| format!("obstacle o{index} at {at:?}")));
        lines.extend(self.reservoirs.iter().enumerate().map(|(index, at)| format!("reservoir r{index} at {at:?}")));
        lines.extend(self.parts.iter().enumerate().map(|(index, at)| match *at {
            NOWHERE => format!("part d{index} : ea.droplet"),
            at => format!("part d{index} : ea.droplet at {at:?}"),
        }));
        lines.push("}\ntask go on chip in tray {".to_owned());
        lines.push(format!("minimize {}", if self.by_sum { "sum_of_costs" } else { "makespan" }));
        if self.may_yield {
            lines.push("may_yield: true".to_owned());
        }
        lines.extend(self.avoided.iter().map(|(of, within)| format!("avoid {} in {}", of.name(), within.name())));
        lines.extend(self.washes.iter().map(|fluid| format!("wash with {}", fluid.name())));
        lines.push("assay {".to_owned());
        let withins = self.withins.iter().copied().chain(std::iter::repeat(None));
        let none = Vec::new();
        let among = self.among.iter().chain(std::iter::repeat(&none));
        for (((operation, after), within), among) in self.operations.iter().zip(&self.afters).zip(withins).zip(among) {
            let place = |at: Cell| match among.is_empty() {
                true => format!(" at {at:?}"),
                false => format!(" among {:?}", std::iter::once(&at).chain(among).collect::<Vec<_>>()),
            };
            let after = match within {
                // A remainder of less than a step has no effect.
                Some((part, steps)) => format!(" after d{part} within {} ms", steps * STEP_MS + STEP_MS / 2),
                None => after.map(|part| format!(" after d{part}")).unwrap_or_default(),
            };
            let line = match operation {
                Operation::Move(part, stops) => {
                    let vias: String = stops[..stops.len() - 1].iter().map(|stop| format!(" via {stop:?}")).collect();
                    format!("move d{part} to {:?}{vias}", stops[stops.len() - 1])
                }
                Operation::Merge(part, with, at) => format!("merge d{part} with d{with}{}", place(*at)),
                Operation::Discard(part, at) => format!("discard d{part}{}", place(*at)),
                Operation::Dispense(part, reservoir) => format!("dispense d{part} from r{reservoir}"),
                Operation::Mix(part, at, steps) => {
                    let place = at.map(place).unwrap_or_default();
                    format!("mix d{part}{place} for {} ms", steps * STEP_MS)
                }
                Operation::Split(half, part, at, to) => format!("split d{half} from d{part} at {at:?} to {to:?}"),
                Operation::Incubate(part, at, stay) => {
                    let place = at.map(place).unwrap_or_default();
                    format!("incubate d{part}{place} for {} ms", stay * STEP_MS)
                }
            };
            lines.push(line + &after);
        }
        lines.push("}\n}".to_owned());
        lines.join("\n")
    }
}
